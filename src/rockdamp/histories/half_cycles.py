"""Crossings of zero, turning points and half cycles of stored histories."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array

# ASSUME: the smallest half cycle, which the paper does not define.
CLEAR_OF_NOISE = 10  # smallest measured peak, in standard deviations of the sensor at rest
LEAST_PEAK = 1e-3  # smallest computed peak, u/u_ins


@dataclass(frozen=True)
class HalfCycles:
    """Successive excursions to alternate sides.

    Attributes
    ----------
    peak : ndarray, shape (half cycles,)
        Signed peaks. [m]
    peak_elapsed : ndarray, shape (half cycles,)
        Times of the peaks. [s]
    start, end : ndarray, shape (half cycles,)
        Times of the crossings of zero before and after; the first start and the last end are
        NaN. [s]
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
    """Return the steps between samples in which a history reaches or passes zero.

    A step that starts at zero leaves it and does not count, as in the solver's count of impacts.
    Zeros of displacements are impacts, zeros of velocities are peaks; NaN passes nothing.

    Parameters
    ----------
    values : ndarray, shape (..., samples)
        Histories.

    Returns
    -------
    ndarray of bool, shape (..., samples - 1)
    """
    sign = np.sign(np.asarray(values, dtype=float))
    start = sign[..., :-1]
    end = sign[..., 1:]
    return (start != 0) & (start * end <= 0)


def turning_points(
    displacement: Array, velocity: Array, step: float | Array
) -> tuple[Array, Array]:
    """Return displacements and times at which histories turn after a release at rest.

    The release counts as no turn. A turn between two samples is found to second order.

    Parameters
    ----------
    displacement, velocity : ndarray, shape (lanes, samples)
        Histories.
    step : float or ndarray, shape (lanes,)
        Time between two samples, in the unit of the velocity.

    Returns
    -------
    displacement, elapsed : ndarray, shape (lanes, most turns)
        Turning points, NaN after each lane's last one.
    """
    lane, sample = np.nonzero(passes_zero(velocity[:, 1:]))
    count = np.bincount(lane, minlength=velocity.shape[0])
    first_of_lane = np.cumsum(count) - count
    rank = np.arange(lane.size) - np.repeat(first_of_lane, count)
    shape = (count.size, int(count.max(initial=0)))
    turns = np.full(shape, np.nan)
    elapsed = np.full(shape, np.nan)
    v = velocity[lane, sample + 1]
    h = np.broadcast_to(step, count.shape)[lane]
    # Time to the turn at a constant acceleration; x is quadratic in time, so it turns v s/2 beyond.
    s = h * v / (v - velocity[lane, sample + 2])
    turns[lane, rank] = displacement[lane, sample + 1] + 0.5 * s * v
    elapsed[lane, rank] = (sample + 1) * h + s
    return turns, elapsed


def half_cycles(elapsed: Array, displacement: Array, threshold: float) -> HalfCycles:
    """Split a history at its crossings of zero into excursions to alternate sides.

    Noise near zero makes no half cycles: one begins where the threshold of the other side is
    passed. The crossing between two is the middle of the first and the last change of sign there.

    Parameters
    ----------
    elapsed, displacement : ndarray, shape (samples,)
        History. [s], [m]
    threshold : float
        Least peak of a half cycle. [m]
    """
    large = np.flatnonzero(np.abs(displacement) > threshold)
    if not large.size:
        return HalfCycles(*np.empty((4, 0)))
    changes_side = np.diff(np.sign(displacement[large])) != 0
    excursions = np.split(large, np.flatnonzero(changes_side) + 1)
    peaks = [_find_peak(displacement, excursion[0], excursion[-1]) for excursion in excursions]
    crossings = [
        _find_crossing(elapsed, displacement, excursion[-1], successor[0])
        for excursion, successor in pairwise(excursions)
    ]
    return HalfCycles(
        peak=displacement[peaks],
        peak_elapsed=elapsed[peaks],
        start=np.array([np.nan, *crossings]),
        end=np.array([*crossings, np.nan]),
    )


def _find_peak(displacement: Array, first: int, last: int) -> int:
    """Return the sample of the largest displacement from `first` to `last`."""
    return first + int(np.argmax(np.abs(displacement[first : last + 1])))


def _find_crossing(elapsed: Array, displacement: Array, first: int, last: int) -> float:
    """Return the middle of the first and the last change of sign from `first` to `last`. [s]"""
    changes = first + np.flatnonzero(passes_zero(displacement[first : last + 1]))
    ends = changes[[0, -1]]
    x = displacement[ends]
    share = x / (x - displacement[ends + 1])
    interval = elapsed[ends + 1] - elapsed[ends]
    return float(np.mean(elapsed[ends] + share * interval))
