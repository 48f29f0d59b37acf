"""Many walls under one record at several intensities: how each history ends, without the history itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from operator import itemgetter

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.histories.forcing import Forcing, require_affordable
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.records import Record
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.response import COLLAPSED

SUBSTEPS_BASE = 2  # substeps are powers of it, so that what a wall does depends on no other wall


def peaks_and_collapses(
    record: Record,
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    dampings: Sequence[Damping],
    factor: ArrayLike,
    *,
    step: float,
    tail: float,
    halvings: int = 0,
) -> tuple[Array, NDArray[np.bool_]]:
    """Run walls with each damper under a record that is scaled by each factor.

    Parameters of walls, curves and dampers are numbers, or arrays of shape (walls,); `factor` has the shape (factors,)
    or (walls, factors). `step` is the longest, times the angular frequency of the first branch, before it is halved
    `halvings` times; `tail` is the rest after the record. [s] Returned are the largest |u|/u_ins [-], meaningless for a
    wall that collapsed, and whether it did, shape (walls, factors, dampings).
    """
    factor = np.atleast_2d(np.asarray(factor, dtype=float))
    shapes = [damping.shape for damping in dampings]
    count = np.broadcast_shapes(np.shape(wall.load_factor), curve.shape, *shapes, factor.shape[:1], (1,))
    spread = partial(np.broadcast_to, shape=count)
    curve = curve.map(spread)
    forcing = Forcing.of(wall, record, factor.T, rest=tail)
    sampling, load_factor = spread(forcing.sampling), np.broadcast_to(forcing.load_factor, (factor.shape[1], *count))
    shares = None if forcing.shares is None else np.broadcast_to(forcing.shares.T, (*count, 3)).T
    substeps = substeps_of(sampling * curve.initial_frequency, step) * 2**halvings
    peak, collapsed = (np.empty((*count, factor.shape[1], len(dampings)), dtype=kind) for kind in (float, bool))
    cause = f"p is {np.max(wall.frequency_parameter):.3g} rad/s (the wall may be far smaller than is meant)"
    require_affordable(int(substeps.max()) * forcing.intervals, cause)
    # Walls that need equally many steps between two samples are one batch. Its first dimension is the intensities: then
    # neighbouring lanes, a block of the kernel, collapse together, and the kernel leaves a block that has collapsed.
    for many in np.unique(substeps).tolist():
        walls = np.flatnonzero(substeps == many)
        picked = None if shares is None else shares[:, walls]
        lanes = replace(forcing, sampling=sampling[walls], load_factor=load_factor[:, walls], shares=picked)
        alike = lanes.newmark(many)
        for column, damping in enumerate(dampings):
            response = solve(
                curve.map(itemgetter(walls)), damping.map(spread).map(itemgetter(walls)), peaks_only=True, **alike
            )
            peak[walls, :, column], collapsed[walls, :, column] = response.peak.T, (response.outcome == COLLAPSED).T
    return peak, collapsed


def substeps_of(sampling: ArrayLike, step: float) -> NDArray[np.int64]:
    """Count the solver's steps between two samples, both times the frequency of the first branch."""
    needed = np.asarray(sampling, dtype=float) / step
    return SUBSTEPS_BASE ** np.maximum(np.ceil(np.log2(needed)), 0).astype(int)
