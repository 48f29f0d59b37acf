"""Many walls on a storey of a building: parapets and walls apart, and the worst of several periods for each wall."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from rockdamp.assessment.many_walls import Answer, answers
from rockdamp.assessment.table import BadRow, Row
from rockdamp.histories.upper_floors import floor_motions
from rockdamp.mechanics.building import Building
from rockdamp.mechanics.wall import Parapet
from rockdamp.motions.catalogue import GroundMotion


def in_buildings(
    rows: Sequence[Row | BadRow],
    motions: Sequence[GroundMotion],
    buildings: Sequence[Building],
    measure: str,
    intensity: float,
    tail: float,
) -> list[Answer | BadRow]:
    """Return the results for each wall in the order of the rows, on the ground where there is no building.

    Of several buildings each wall has the results of the one in which most records collapse it under restitution; of
    several such, of the one with the lowest median. The intensity is that of the ground.
    """
    if not buildings:
        return list(answers(rows, motions, measure, intensity, tail=tail))
    everywhere = [list(_in_building(rows, motions, building, measure, intensity, tail)) for building in buildings]
    return [max(of_row, key=_severity) for of_row in zip(*everywhere, strict=True)]


def _in_building(
    rows: Sequence[Row | BadRow],
    motions: Sequence[GroundMotion],
    building: Building,
    measure: str,
    intensity: float,
    tail: float,
) -> Iterator[Answer | BadRow]:
    """Yield the results in one building: a parapet has the motion of one floor, a wall that of two."""
    by_line: dict[int, Answer | BadRow] = {}
    for parapet in (False, True):
        alike = [row for row in rows if isinstance(row, Row) and isinstance(row.wall, Parapet) == parapet]
        if alike:
            supports = floor_motions(motions, building, parapet)
            for row, result in zip(alike, answers(alike, supports, measure, intensity, tail=tail), strict=True):
                if isinstance(result, Answer):
                    result = replace(result, building_period=building.period)
                by_line[row.line] = result
    yield from (by_line.get(row.line, row) if isinstance(row, Row) else row for row in rows)  # type: ignore[misc]


def _severity(result: Answer | BadRow) -> tuple[float, float]:
    """Return what grows with how bad a result is."""
    if isinstance(result, BadRow):
        return -1.0, 0.0
    median = float(result.median[0])
    return float(result.collapses[0]), -median if np.isfinite(median) else -np.inf
