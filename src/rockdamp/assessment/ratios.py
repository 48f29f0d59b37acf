"""Damping ratios of many walls, from the table of least Err; no record and no history."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypedDict

import numpy as np

from rockdamp.assessment.assess import alike, stacked
from rockdamp.assessment.table import BadRow, Row
from rockdamp.equivalence.tabulated import damping_ratio_table, table_refusal
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


def ratios(rows: Sequence[Row | BadRow], release_amplitude: float) -> Iterator[Ratio]:
    """Yield the damping ratios of each wall by each viscous model, in the order of the rows.

    A row that makes no wall, or one that is not released below a3, has its error once, without a model.
    """
    released = [_released(row, release_amplitude) for row in rows]
    of_walls: dict[int, list[Ratio]] = {}
    for batch in alike(row for row in released if isinstance(row, Row)):
        of_walls |= _of_alike(batch, release_amplitude)
    for row in released:
        if isinstance(row, BadRow):
            yield Ratio(id=row.id, restitution=None, damping_model="", damping_ratio=None, error=row.error)
        else:
            yield from of_walls[row.line]


def _released(row: Row | BadRow, x0: float) -> Row | BadRow:
    if isinstance(row, BadRow) or 0 < x0 < row.curve.ultimate_displacement_ratio:
        return row
    wrong = InputError(f"release_amplitude is {x0:g}; it must be greater than 0 and less than a3")
    return BadRow(row.line, row.id, f"line {row.line}: {wrong}")


def _of_alike(rows: list[Row], x0: float) -> dict[int, list[Ratio]]:
    """Return, by line, the damping ratios of walls whose curves have one kind of last branch."""
    curve = stacked([row.curve for row in rows])
    e = np.array([row.restitution for row in rows])
    by_line: dict[int, list[Ratio]] = {row.line: [] for row in rows}
    for model in VISCOUS_MODELS:
        cells = zip(
            rows,
            damping_ratio_table(curve, model, e, x0).tolist(),
            table_refusal(curve, model, e, x0).tolist(),
            strict=True,
        )
        for row, xi, why in cells:
            ratio, error = (None, f"line {row.line}: {why}") if why else (xi, "")
            by_line[row.line].append(
                Ratio(id=row.id, restitution=row.restitution, damping_model=model, damping_ratio=ratio, error=error)
            )
    return by_line
