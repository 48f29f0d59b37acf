"""Damping ratios of least error of many walls; no record."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TypedDict

import numpy as np

from rockdamp.assessment.assess import alike, stacked
from rockdamp.assessment.table import BadRow, Row
from rockdamp.equivalence.equivalent import least_error, longest_step
from rockdamp.equivalence.matching import of_each
from rockdamp.errors import InputError
from rockdamp.vocabulary import VISCOUS_MODELS


class Ratio(TypedDict):
    """The damping ratio of one wall and viscous model, or why there is none."""

    id: str
    restitution: float | None
    damping_model: str
    damping_ratio: float | None
    error: str


COLUMNS = tuple(Ratio.__annotations__)
AT_ONCE = 64  # walls that are searched together


def ratios(rows: Sequence[Row | BadRow], release_amplitude: float) -> Iterator[Ratio]:
    """Yield the damping ratios of least Err of each wall by each viscous model, in the order of the rows.

    They are those of `equivalent`, searched on all cores. A row that makes no wall, or one that is not released below
    a3, has its error once, without a model.
    """
    released = [_released(row, release_amplitude) for row in rows]
    batches = [
        part[start : start + AT_ONCE]
        for batch in alike(row for row in released if isinstance(row, Row))
        for part in _of_one_step(batch)
        for start in range(0, len(part), AT_ONCE)
    ]
    tasks = [(number, model) for number in range(len(batches)) for model in VISCOUS_MODELS]
    found = of_each(lambda task: _search(batches[task[0]], task[1], release_amplitude), tasks, "Damping ratios")
    of_line: dict[int, list[Ratio]] = {}
    for (number, _), answers in found.items():
        for row, answer in zip(batches[number], answers, strict=True):
            of_line.setdefault(row.line, []).append(answer)
    for each in released:
        if isinstance(each, BadRow):
            yield Ratio(id=each.id, restitution=None, damping_model="", damping_ratio=None, error=each.error)
        else:
            yield from of_line[each.line]


def _released(row: Row | BadRow, x0: float) -> Row | BadRow:
    if isinstance(row, BadRow) or 0 < x0 < row.curve.ultimate_displacement_ratio:
        return row
    wrong = InputError(f"release_amplitude is {x0:g}; it must be greater than 0 and less than a3")
    return BadRow(row.line, row.id, f"line {row.line}: {wrong}")


def _of_one_step(rows: list[Row]) -> Iterable[list[Row]]:
    """Return the walls whose decays take the same step: all but those of the stiffest curves."""
    by_step: dict[float, list[Row]] = {}
    for row in rows:
        by_step.setdefault(float(longest_step(row.curve)), []).append(row)
    return by_step.values()


def _search(rows: list[Row], model: str, x0: float) -> list[Ratio]:
    """Search the walls together; where one of them has no ratio, halves of them, down to that one."""
    e, curve = np.array([row.restitution for row in rows]), stacked([row.curve for row in rows])
    try:
        found = least_error(curve, model, e, np.full(e.shape, x0))[0].tolist()
    except InputError as error:
        if len(rows) > 1:
            half = len(rows) // 2
            return [*_search(rows[:half], model, x0), *_search(rows[half:], model, x0)]
        return [_ratio(rows[0], model, None, f"line {rows[0].line}: {error}")]
    return [_ratio(row, model, xi, "") for row, xi in zip(rows, found, strict=True)]


def _ratio(row: Row, model: str, xi: float | None, error: str) -> Ratio:
    return Ratio(id=row.id, restitution=row.restitution, damping_model=model, damping_ratio=xi, error=error)
