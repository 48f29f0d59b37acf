"""Histories near collapse, run again at smaller steps.

Near collapse the outcome can flip with a tiny change of the step: the wall almost comes to rest
where it hardly holds, and may fall back or go on. Two steps may agree by chance, so a history near
collapse is run at two more halvings, and every run counts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.histories.loads import run_record
from rockdamp.mechanics.specimen import Specimen
from rockdamp.motions.record import Record

Outcomes: TypeAlias = NDArray[np.bool_]

NEAR_COLLAPSE = 0.5  # a wall that survives with such a peak, u/u_ins, is near collapse


@dataclass(frozen=True)
class RefinedPeaks:
    """Histories at the finest step that each was run at, and the effect of the step.

    Attributes
    ----------
    peak : ndarray, shape (levels, walls)
        Largest \\|u\\|/u_ins at the finest step. [-]
    collapsed : ndarray of bool, shape (levels, walls)
        Outcome at the finest step.
    coarser_collapsed : ndarray of bool, shape (levels, walls)
        Outcome at twice the finest step; the outcome itself where there is one run.
    converged : ndarray of bool, shape (levels, walls)
        Whether all runs end alike.
    largest_change : ndarray, shape (levels, walls)
        Largest change of the peak by one halving of the step. [-]
    halvings : ndarray of int, shape (levels, walls)
        Halvings of the longest step up to the finest one.
    """

    peak: Array
    collapsed: Outcomes
    coarser_collapsed: Outcomes
    converged: Outcomes
    largest_change: Array
    halvings: NDArray[np.int64]


def run_refined(
    record: Record,
    specimen: Specimen,
    factor: Array,
    find_doubtful: Callable[[Outcomes], Outcomes],
    *,
    step: float,
    tail: float,
    halvings: int,
) -> RefinedPeaks:
    """Run walls from rest under a record, and those that come near collapse at smaller steps too.

    A history is near collapse if the wall survives with a large peak, or if its outcome is
    doubtful.

    Parameters
    ----------
    record : Record
        Ground motion, or motion of both supports.
    specimen : Specimen
        Walls in arrays of shape (walls,), or one.
    factor : ndarray, shape (levels, walls)
        Factors on the acceleration. [-]
    find_doubtful : callable
        Takes the outcomes of all histories, shape (runs, levels, walls), the coarsest run first,
        and returns which outcomes are doubtful, shape (levels, walls).
    step : float
        Longest step, times the initial frequency w1. [-]
    tail : float
        Rest after the record. [s]
    halvings : int
        Halvings of the step for every history.
    """

    def halve(specimen: Specimen, factor: Array, halvings: range) -> tuple[Array, Outcomes]:
        runs = [
            run_record(record, specimen, factor, step=step, tail=tail, halvings=number)
            for number in halvings
        ]
        peak = np.stack([peaks.peak for peaks in runs])
        return peak, np.stack([peaks.collapsed for peaks in runs])

    finest = halvings + 2  # of the histories near collapse
    peak, collapsed = halve(specimen, factor, range(halvings + 1))
    refined = summarise_runs(peak, collapsed)
    has_large_peak = ~collapsed[-1] & (peak[-1] >= NEAR_COLLAPSE)
    level, wall = np.nonzero(find_doubtful(collapsed) | has_large_peak)
    if not level.size:
        return refined
    # All walls share a batch, and those that collapse stand together: a block of the kernel takes
    # as long with one lane as with all, and ends when all its lanes have collapsed.
    order = np.argsort(collapsed[-1, level, wall], kind="stable")
    level, wall = level[order], wall[order]
    finer_peak, finer_collapsed = halve(
        specimen.take(wall), factor[level, wall][None], range(halvings + 1, finest + 1)
    )
    refined_lanes = summarise_runs(
        np.concatenate([peak[:, level, wall], finer_peak[:, 0]]),
        np.concatenate([collapsed[:, level, wall], finer_collapsed[:, 0]]),
    )
    for field in fields(refined):
        getattr(refined, field.name)[level, wall] = getattr(refined_lanes, field.name)
    return refined


def summarise_runs(peak: Array, collapsed: Outcomes) -> RefinedPeaks:
    """Return the last run of histories, and how the others differ from it.

    Parameters
    ----------
    peak, collapsed : ndarray, shape (runs, ...)
        Runs at steps h, h/2, h/4, ...
    """
    last = len(peak) - 1
    changes = np.abs(np.diff(peak, axis=0))
    return RefinedPeaks(
        peak=peak[last].copy(),
        collapsed=collapsed[last].copy(),
        coarser_collapsed=collapsed[max(last - 1, 0)].copy(),
        converged=(collapsed == collapsed[last]).all(axis=0),
        largest_change=changes.max(axis=0, initial=0.0),
        halvings=np.full(peak.shape[1:], last),
    )
