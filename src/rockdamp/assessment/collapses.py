"""Collapses of walls under records: at the intensities asked for, and at stripes that span each wall's fragility."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from rockdamp import progress
from rockdamp.arrays import Array
from rockdamp.assessment.refinement import refined
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures

UNITS = {"PGV": "m s-1", "PGA": "m s-2"}
STEP = 0.05  # of the solver, times the first branch's angular frequency, at most; a quarter of it near to collapse
TAIL = 3.0  # rest after a record [s]
# Of the stripes: lambda PGV/(p u_ins). The medians of the eight walls of config/default.yaml lie between 0.57 and 2.0,
# and twice their dispersions span a factor of 2.6 to either side: a test holds the stripes to be beyond it.
STRIPES = np.geomspace(0.15, 8.0, 16)


SHOWN = partial(progress.track, description="Records")


@dataclass(frozen=True)
class Collapses:
    """Walls under records: peaks and collapses at the intensities asked for, and collapses at the stripes of each wall.

    `peak` is the largest |u|/u_ins, NaN of a wall that collapsed; it and `collapsed` have the shape (walls, dampings,
    records, intensities), `stripe_collapsed` (walls, dampings, records, stripes). `stripe_coarser` are the collapses
    at the stripes at twice the finest step of each history. `stripe` has the shape (walls, stripes), in the unit of
    `intensity`; `factor`, on each record's acceleration, (records, intensities); `strongest` is the largest PGA of the
    scaled records, shape (intensities,). [m s-2]
    """

    measure: str
    intensity: Array
    stripe: Array
    factor: Array
    strongest: Array
    peak: Array
    collapsed: NDArray[np.bool_]
    stripe_collapsed: NDArray[np.bool_]
    stripe_coarser: NDArray[np.bool_]


def collapses(
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    dampings: Sequence[Damping],
    motions: Sequence[GroundMotion],
    measure: str,
    intensity: Array,
    *,
    step: float = STEP,
    tail: float = TAIL,
    track: Callable[[Sequence[GroundMotion]], Iterable[GroundMotion]] = SHOWN,
) -> Collapses:
    """Run walls with each damper under records, scaled to the intensities asked for and to each wall's stripes.

    Walls, curves and dampers are of numbers, or of arrays of shape (walls,). `step` is the solver's longest, times the
    angular frequency of the first branch, and is refined near to collapse; `tail` is the rest after each record [s].
    `track` yields the records on, and may show progress.
    """
    supports = [intensity_measures(motion.record) for motion in motions]
    own = np.array([getattr(intensity_measures(motion.intensity_record), measure.lower()) for motion in motions])
    stripe = np.atleast_1d(wall.velocity_scale)[:, None] * STRIPES
    stripe = stripe * np.median(own / [level.pgv for level in supports])
    walls = np.broadcast_shapes(stripe.shape[:1], curve.shape, *(damping.shape for damping in dampings))[0]
    asked = np.broadcast_to(intensity, (walls, intensity.size))
    wanted = np.concatenate([asked, np.broadcast_to(stripe, (walls, STRIPES.size))], axis=1)
    peak, collapsed, coarser = [], [], []
    for motion, level in zip(track(motions), own, strict=True):
        largest, fell, before = refined(motion.record, wall, curve, dampings, wanted / level, step=step, tail=tail)
        # Of the stripes the peaks are not kept: memory grows with walls and records alone.
        peak.append(np.where(fell, np.nan, largest)[:, : intensity.size])
        collapsed.append(fell)
        coarser.append(before)
    order = (1, 3, 0, 2)  # from (records, walls, intensities, dampings)
    fell, before = (np.stack(outcomes).transpose(order) for outcomes in (collapsed, coarser))
    factor = intensity / own[:, None]
    return Collapses(
        measure,
        intensity,
        np.broadcast_to(stripe, (walls, STRIPES.size)),
        factor,
        np.max(factor * [[level.pga] for level in supports], axis=0),
        np.stack(peak).transpose(order),
        fell[..., : intensity.size],
        fell[..., intensity.size :],
        before[..., intensity.size :],
    )
