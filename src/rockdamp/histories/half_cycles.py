"""Crossings of zero, turning points and half cycles of stored histories."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array

# ASSUME: the paper gives no definition of a half cycle's least size.
CLEAR = 10  # standard deviations of the sensor at rest: a measured half cycle is one that goes beyond them
LEAST = 1e-3  # of u_ins: a computed half cycle is one that goes beyond it


@dataclass(frozen=True)
class HalfCycles:
    """Successive excursions to either side: signed `peak` [m] and its time [s], crossings of zero before and after. [s]

    The first `start` and the last `end` are NaN.
    """

    peak: Array
    peak_elapsed: Array
    start: Array
    end: Array

    def __getitem__(self, part: slice) -> HalfCycles:
        return HalfCycles(
            self.peak[part], self.peak_elapsed[part], self.start[part], self.end[part]
        )

    @property
    def duration(self) -> Array:
        """Time from crossing to crossing. [s]"""
        return self.end - self.start


def passes_zero(values: ArrayLike) -> NDArray[np.bool_]:
    """Return the steps between samples in which a history reaches or passes zero, shape (..., n - 1).

    A step that starts at zero leaves it and does not count, as in the solver's count of impacts. Zeros of displacements
    are impacts, zeros of velocities are peaks; NaN passes nothing.
    """
    sign = np.sign(np.asarray(values, dtype=float))
    before, after = sign[..., :-1], sign[..., 1:]
    return (before != 0) & (before * after <= 0)


def turning_points(
    displacement: Array, velocity: Array, step: float | Array
) -> tuple[Array, Array]:
    """Return displacements and times at which histories turn after a release at rest, which counts as no turn.

    Both have the shape (lanes, most), NaN after each lane's last turn. The histories have the shape (lanes, n); `step`
    is the time between samples, between which a turn is found to second order.
    """
    lane, at = np.nonzero(passes_zero(velocity[:, 1:]))
    count = np.bincount(lane, minlength=velocity.shape[0])
    rank = np.arange(lane.size) - np.repeat(np.cumsum(count) - count, count)
    turned, elapsed = np.full((2, count.size, int(count.max(initial=0))), np.nan)
    v, h = velocity[lane, at + 1], np.broadcast_to(step, count.shape)[lane]
    # At the turn x is quadratic in time: it is v s/2 beyond x, s the time to the turn at a constant acceleration.
    s = h * v / (v - velocity[lane, at + 2])
    turned[lane, rank] = displacement[lane, at + 1] + 0.5 * s * v
    elapsed[lane, rank] = (at + 1) * h + s
    return turned, elapsed


def half_cycles(elapsed: Array, displacement: Array, threshold: float) -> HalfCycles:
    """Split a history at its crossings of zero into excursions beyond `threshold` to alternate sides.

    Noise near zero makes no half cycles: one begins where the other side's threshold is passed, and the crossing
    between two is the middle of the first and last change of sign between them.
    """
    beyond = np.flatnonzero(np.abs(displacement) > threshold)
    if not beyond.size:
        return HalfCycles(*np.empty((4, 0)))
    last = np.flatnonzero(np.diff(np.sign(displacement[beyond])))
    starts, ends = beyond[np.concatenate([[0], last + 1])], beyond[np.append(last, beyond.size - 1)]
    peaks = [
        i + int(np.argmax(np.abs(displacement[i : j + 1])))
        for i, j in zip(starts, ends, strict=True)
    ]
    crossings = [
        _crossing(elapsed, displacement, i, j) for i, j in zip(ends[:-1], starts[1:], strict=True)
    ]
    return HalfCycles(
        displacement[peaks],
        elapsed[peaks],
        np.array([np.nan, *crossings]),
        np.array([*crossings, np.nan]),
    )


def _crossing(elapsed: Array, displacement: Array, start: int, stop: int) -> float:
    """Return the middle of the first and last change of sign from `start` to `stop`, linearly interpolated."""
    changes = start + np.flatnonzero(passes_zero(displacement[start : stop + 1]))[[0, -1]]
    before, after = displacement[changes], displacement[changes + 1]
    share = before / (before - after)
    return float(np.mean(elapsed[changes] + share * (elapsed[changes + 1] - elapsed[changes])))
