"""Run histories again at finer steps where the step may decide whether a wall collapses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from functools import partial
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.histories.at_intensities import peaks_and_collapses
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.records import Record
from rockdamp.plausibility import as_meant

NEAR = 0.5  # u/u_ins, from which on a wall that stands is near to collapse; the study of earthquakes has it too
HALVINGS = 2  # of the step near to collapse; the last one shows what is left of the error


def refined(
    record: Record,
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    dampings: Sequence[Damping],
    factor: Array,
    *,
    step: float,
    tail: float,
) -> tuple[Array, NDArray[np.bool_], NDArray[np.bool_]]:
    """Run walls with each damper under a record at each factor, at a finer step near to collapse.

    Arguments are as for `peaks_and_collapses`, with `factor` of the shape (walls, factors). Returned are the peaks [-]
    and collapses at the finest step, and the collapses at twice that step, shape (walls, factors, dampings).
    """
    peak, collapsed = peaks_and_collapses(record, wall, curve, dampings, factor, step=step, tail=tail)
    coarser = collapsed.copy()
    near = near_to_collapse(peak, collapsed, factor)
    spread = partial(np.broadcast_to, shape=factor.shape[:1])
    for column, damping in enumerate(dampings):
        walls, levels = np.nonzero(near[..., column])
        if not walls.size:
            continue
        # Those that fell stand together: the kernel leaves a block that has collapsed.
        fell_last = np.argsort(collapsed[walls, levels, column], kind="stable")
        walls, levels = walls[fell_last], levels[fell_last]
        lane, pick = (walls, levels, column), itemgetter(walls)
        lanes = (_lanes(wall, factor.shape[0], walls), curve.map(spread).map(pick), [damping.map(spread).map(pick)])
        for halvings in range(1, HALVINGS + 1):
            coarser[lane] = collapsed[lane]
            finer = peaks_and_collapses(
                record, *lanes, factor[walls, levels][:, None], step=step, tail=tail, halvings=halvings
            )
            peak[lane], collapsed[lane] = (values[:, 0, 0] for values in finer)
    return peak, collapsed, coarser


def near_to_collapse(peak: Array, collapsed: NDArray[np.bool_], factor: Array) -> NDArray[np.bool_]:
    """Return which histories stand with a large peak, or collapse where the next weaker motion does not.

    `peak` and `collapsed` have the shape (walls, factors, dampings), `factor` (walls, factors).
    """
    order = np.argsort(np.abs(factor), axis=1, kind="stable")[..., None]
    fell = np.take_along_axis(collapsed, order, axis=1)
    first = fell.copy()
    first[:, 1:] &= ~fell[:, :-1]
    near = np.empty_like(collapsed)
    np.put_along_axis(near, order, first, axis=1)
    return near | (~collapsed & (peak >= NEAR))


def _lanes(wall: Wall | Parapet, count: int, walls: NDArray[np.intp]) -> Wall | Parapet:
    """Return the wall of each lane."""
    each = {field.name: np.broadcast_to(getattr(wall, field.name), count) for field in fields(wall)}
    sizes: dict[str, Any] = {name: values[walls] for name, values in each.items()}
    with as_meant():  # it was warned of when it was made
        return replace(wall, **sizes)
