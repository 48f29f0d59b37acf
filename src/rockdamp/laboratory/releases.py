"""Releases in a free-rocking test, with their zero, peaks and crossings of zero."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import detrend, find_peaks
from scipy.stats import theilslopes

from rockdamp.arrays import Array
from rockdamp.errors import check
from rockdamp.histories.half_cycles import CLEAR, half_cycles

# ASSUME: what a test must be for these to be found in it.
FEWEST_PEAKS = 4  # of a release, itself included: three impacts, of which two leave something to compare
GROWN = 1.5  # of the peak before: a peak beyond it did not follow from free motion, the specimen was pulled again
RELEASE = 0.2  # of the largest peak: a release is at least as large
FALLING = 0.8  # of the release: below it the specimen moves freely, whatever held it
RISEN = 0.5  # of the next peak: where the record begins below it, the first impact has no energy before it
ONE_SIDED = 0.5  # of the amplitude: how far the middle between peaks may move with it
LOST_FRAMES, LOST_SHARE = 5, 0.25  # in a gap, and of the half period around it: more may hide two crossings
LAST = 0.4  # of the half period before: how far beyond the last peak the record is used
# Of the white noise, or of the range: where the first or the last part of a test varies less, the specimen is at rest.
QUIET_SPREAD, QUIET = 1.5, 0.005
QUIET_SHARE, QUIET_SAMPLES = 0.05, 50  # of the test: how long that part is, and its least number of samples
NORMAL_MEDIAN = 0.6745  # median of the absolute value of a standard normal variable


@dataclass(frozen=True)
class Release:
    """A part of a test that is one free decay, in SI and as the sensor shows it.

    Times [s] and displacements [m] of the samples; crossings of zero, one for each impact [s]; signed peaks around
    them, one more than crossings [m].
    """

    elapsed: Array
    displacement: Array
    zero: float
    crossings: Array
    peaks: Array

    @property
    def half_periods(self) -> Array:
        """Times between crossings, as they were measured. [s]"""
        return np.diff(self.crossings)


def noise_of(displacement: Array) -> float:
    """Return the standard deviation of the sensor's noise, or half of that at rest where the noise is no white one. [m]

    White noise shows in second differences, which motion hardly changes; filtered noise shows at rest alone.
    """
    resting = rest_deviation(displacement)
    return max(_white_noise(displacement), 0.0 if np.isnan(resting) else resting / 2)


def rest_deviation(displacement: Array) -> float:
    """Return the standard deviation of the sensor at rest, at the start or the end of a test; NaN without rest. [m]"""
    count = max(int(QUIET_SHARE * displacement.size), QUIET_SAMPLES)
    spreads = [float(np.std(detrend(part))) for part in (displacement[:count], displacement[-count:])]
    quiet = max(QUIET_SPREAD * _white_noise(displacement), QUIET * float(np.ptp(displacement)))
    return min(spreads) if min(spreads) < quiet else np.nan


def _white_noise(displacement: Array) -> float:
    differences = np.diff(displacement, 2)
    spread = float(np.median(np.abs(differences - np.median(differences)))) / NORMAL_MEDIAN / np.sqrt(6)
    steps = np.unique(np.abs(np.diff(displacement)))
    return max(spread, float(steps[steps > 0].min()) / np.sqrt(12) if steps.any() else 0.0)  # the logger's steps


def zero_of(displacement: Array, noise: float) -> float:
    """Return the level about which the specimen rocks: where the middle between peaks tends to as they fade. [m]

    A specimen that rocks to one side of a support has its middle move with the amplitude, and is refused.
    """
    top, bottom = (find_peaks(side, prominence=2 * CLEAR * noise)[0] for side in (displacement, -displacement))
    at = np.sort(np.concatenate([top, bottom]))
    values = displacement[at]
    _check_peaks(values.size, CLEAR * noise)
    middle = (values[:-2] + 2 * values[1:-1] + values[2:]) / 4
    amplitude = np.abs(values[:-2] - 2 * values[1:-1] + values[2:]) / 4
    slope = float(theilslopes(middle, amplitude)[0])  # robust: of several releases some peaks follow from a pull
    allowed = f"at most {ONE_SIDED:g}: a specimen that rocks to one side of a support is not fitted"
    check("shift of the middle between peaks over their amplitude", slope, lambda s: np.abs(s) <= ONE_SIDED, allowed)
    return float(np.median(middle - slope * amplitude))


def find_releases(elapsed: Array, displacement: Array, least: float | None = None) -> list[Release]:
    """Split a test into its releases, each from where the specimen falls freely to its last clear half cycle.

    Times [s], displacements at the hinge or the top [m], and the smallest peak that is used [m], by default ten
    standard deviations of the noise. Raises `InputError` for too few peaks, or a specimen that rocks to one side only.
    """
    check("samples of the test", displacement.size, lambda n: n >= QUIET_SAMPLES, f"at least {QUIET_SAMPLES}")
    noise = noise_of(displacement)
    clear = CLEAR * noise if least is None else least
    zero = zero_of(displacement, noise)
    cycles = half_cycles(elapsed, displacement - zero, clear)
    sizes = np.abs(cycles.peak)
    _check_peaks(sizes.size, clear)
    grown = (sizes[1:] > GROWN * sizes[:-1]) & (sizes[1:] > RELEASE * sizes.max())
    starts = np.concatenate([[0], 1 + np.flatnonzero(grown)])
    ends = np.append(starts[1:], sizes.size)
    parts = [cycles[int(start) : int(end)] for start, end in zip(starts, ends, strict=True)]
    parts = [part for part in parts if abs(part.peak[0]) > RELEASE * sizes.max()]
    _check_peaks(max(part.peak.size for part in parts), clear)
    found = []
    for part in [part for part in parts if part.peak.size >= FEWEST_PEAKS]:
        inside, peaks = part.start[1:], part.peak
        # The last half cycle ends in the noise: it is used to a little before where its like would end.
        last = part.peak_elapsed[-1] + LAST * (inside[-1] - inside[-2])
        fall = (elapsed < inside[0]) & (np.abs(displacement - zero) >= FALLING * abs(peaks[0]))
        first = int(np.flatnonzero(fall)[-1]) if fall.any() else 0
        if np.abs(displacement[first] - zero) < RISEN * np.abs(peaks[1]):
            first, inside, peaks = int(np.argmax(elapsed >= inside[0])), inside[1:], peaks[1:]
        used = slice(first, int(np.searchsorted(elapsed, last)) + 1)
        _check_gaps(elapsed[used], inside)
        found.append(Release(elapsed[used], displacement[used], zero, inside, peaks))
    return found


def _check_gaps(elapsed: Array, crossings: Array) -> None:
    """Refuse a release of which more frames are lost than leave its half periods to be seen."""
    intervals, half_periods = np.diff(elapsed), np.diff(crossings)
    around = np.interp(elapsed[:-1], crossings[:-1] + half_periods / 2, half_periods)
    allowed = np.maximum((LOST_FRAMES + 1.5) * np.median(intervals), LOST_SHARE * around)
    at = int(np.argmax(intervals - allowed))
    what = f"at most {allowed[at]:.3g}: {LOST_FRAMES} frames, or {LOST_SHARE:g} of the half period there"
    check(f"gap after {elapsed[at]:.6g} s", intervals[at], lambda gap: gap <= allowed[at], what)


def _check_peaks(count: int, clear: float) -> None:
    allowed = f"at least {FEWEST_PEAKS} beyond {1000 * clear:.3g} mm, the release included"
    check("number of clear peaks", count, lambda n: n >= FEWEST_PEAKS, allowed)
