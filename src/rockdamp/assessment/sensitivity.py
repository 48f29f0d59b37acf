"""How much the answer for one wall moves with what is known least: e, hinge, a1, overburden, the building's period."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from rockdamp.assessment.many_walls import MODELS, Answer, answers
from rockdamp.assessment.table import Row
from rockdamp.errors import InputError
from rockdamp.histories.upper_floors import floor_motions
from rockdamp.mechanics.building import Building
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.plausibility import as_meant
from rockdamp.vocabulary import REFERENCE

CHANGE_OF_E, CHANGE_OF_HINGE = 0.05, 0.1  # what is left open without a test of the wall
FACTORS = (0.5, 2.0)  # on a1 and on the overburden
PERIOD_FACTORS = (0.7, 1.4)  # on the period of the building
FIRST_OVERBURDEN = 0.5  # O/W in place of none
HIGHEST_E = 0.99


class Moved(NamedTuple):
    """The answer after one change: its name, the value, the share of collapses and the median, with restitution."""

    name: str
    value: float
    share: float
    median: float


def sensitivity(
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    restitution: float,
    motions: Sequence[GroundMotion],
    measure: str,
    intensity: float,
    tail: float,
    building: Building | None = None,
) -> list[Moved]:
    """Assess the wall again with one input changed at a time, under restitution; what makes no wall is left out.

    In a `building` the motions are those of its floors, and its period is changed too.
    """
    changes = list(_changes(wall, curve, restitution))
    rows = [Row(i, str(i), *change, "") for i, (_, _, change) in enumerate(changes)]
    at = MODELS.index(REFERENCE)

    def moved(name: str, value: float, one: Answer) -> Moved:
        return Moved(name, value, float(one.collapses[at]) / one.records, float(one.median[at]))

    with as_meant():
        results = answers(rows, motions, measure, intensity, tail=tail)
        table = [
            moved(name, value, one)
            for (name, value, _), one in zip(changes, results, strict=True)
            if isinstance(one, Answer)
        ]
        if building is None:
            return table
        for factor in PERIOD_FACTORS:
            other = replace(building, period=factor * building.period)
            supports = floor_motions(motions, other, isinstance(wall, Parapet))
            (one,) = answers([Row(0, "", wall, curve, restitution, "")], supports, measure, intensity, tail=tail)
            table += [moved("period of the building [s]", other.period, one)] if isinstance(one, Answer) else []
    return table


Change = tuple[str, float, tuple[Wall | Parapet, TrilinearCurve, float]]


def _changes(wall: Wall | Parapet, curve: TrilinearCurve, e: float) -> Iterator[Change]:
    for value in (e - CHANGE_OF_E, min(e + CHANGE_OF_E, HIGHEST_E)):
        yield from _made("coefficient of restitution, e", value, lambda v: (wall, curve, v))
    if isinstance(wall, Wall):
        hinge = float(wall.hinge_ratio)
        for value in (hinge - CHANGE_OF_HINGE, hinge + CHANGE_OF_HINGE):
            yield from _made("height of the hinge, h₁/h", value, lambda v: (replace(wall, hinge_ratio=v), curve, e))
    for factor in FACTORS:
        value = factor * float(curve.yield_displacement_ratio)
        name = "yield displacement ratio, a₁"
        yield from _made(name, value, lambda v: (wall, replace(curve, yield_displacement_ratio=v), e))
    loaded = float(wall.overburden_ratio)
    for value in [factor * loaded for factor in FACTORS] if loaded else [FIRST_OVERBURDEN]:
        yield from _made("overburden, O/W", value, lambda v: (replace(wall, overburden_ratio=v), curve, e))


def _made(
    name: str, value: float, make: Callable[[float], tuple[Wall | Parapet, TrilinearCurve, float]]
) -> Iterator[Change]:
    """Yield the change, unless there is no such wall."""
    try:
        with as_meant():
            made = make(value)
    except InputError:
        return
    if made[2] > 0:
        yield name, value, made
