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
    numbers = range(len(batches))
    found = of_each(lambda number: _search(batches[number], VISCOUS_MODELS, release_amplitude), numbers, "Batches")
    of_line: dict[int, list[Ratio]] = {}
    for one in (ratio for batch in found.values() for ratio in batch):
        of_line.setdefault(one[0], []).append(one[1])
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


def _search(rows: list[Row], models: Sequence[str], x0: float) -> list[tuple[int, Ratio]]:
    """Search walls and models together; where one has no ratio, in halves and then by model, down to that one.

    Each ratio stands beside the line of its wall; those of a wall are in the order of the models.
    """
    e, curve = np.array([row.restitution for row in rows]), stacked([row.curve for row in rows])
    try:
        found = least_error(curve, e, np.full(e.shape, x0), damping_models=models)
    except InputError as error:
        if len(rows) > 1:
            half = len(rows) // 2
            return [*_search(rows[:half], models, x0), *_search(rows[half:], models, x0)]
        if len(models) > 1:
            return [one for model in models for one in _search(rows, [model], x0)]
        return [_answer(rows[0], models[0], None, f"line {rows[0].line}: {error}")]
    ratios = {model: matched.damping_ratio.tolist() for model, matched in found.items()}
    return [_answer(row, model, ratios[model][index], "") for index, row in enumerate(rows) for model in models]


def _answer(row: Row, model: str, xi: float | None, error: str) -> tuple[int, Ratio]:
    ratio = Ratio(id=row.id, restitution=row.restitution, damping_model=model, damping_ratio=xi, error=error)
    return row.line, ratio
