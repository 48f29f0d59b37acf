"""Releases in a free-rocking test, with their zero, peaks and crossings of zero."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import detrend, find_peaks
from scipy.stats import median_abs_deviation, theilslopes

from rockdamp.arrays import Array
from rockdamp.errors import check
from rockdamp.histories.half_cycles import CLEAR, half_cycles

FEWEST_PEAKS = 4  # ASSUME: of a release, itself included: three impacts, of which two leave something to compare
FEWEST_SAMPLES = 50  # of a test, and of its part at rest


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


def sensor_noise(displacement: Array) -> float:
    """Return the standard deviation of white noise, or half of the deviation at rest where this is larger. [m]

    White noise shows in second differences, which motion hardly changes; filtered noise shows only at rest.
    """
    resting = rest_deviation(displacement)
    return max(_white_noise(displacement), 0.0 if np.isnan(resting) else resting / 2)


def rest_deviation(displacement: Array) -> float:
    """Return the standard deviation of the sensor at rest, at the start or the end of a test; NaN without rest. [m]"""
    count = max(int(0.05 * displacement.size), FEWEST_SAMPLES)
    spread = min(
        float(np.std(detrend(part))) for part in (displacement[:count], displacement[-count:])
    )
    # ASSUME: the specimen is at rest where a twentieth of the test varies this little.
    quiet = max(1.5 * _white_noise(displacement), 0.005 * float(np.ptp(displacement)))
    return spread if spread < quiet else np.nan


def _white_noise(displacement: Array) -> float:
    """Return the standard deviation of white noise, at least the one of the logger's steps. [m]"""
    spread = float(median_abs_deviation(np.diff(displacement, 2), scale="normal")) / np.sqrt(6)
    steps = np.unique(np.abs(np.diff(displacement)))
    return max(spread, float(steps[steps > 0].min()) / np.sqrt(12) if steps.any() else 0.0)


def rocking_zero(displacement: Array, noise: float) -> float:
    """Return the level about which the specimen rocks: the middle between peaks, as they fade. [m]

    A specimen that rocks to one side of a support has its middle move with the amplitude, and is refused.
    """
    top, bottom = (
        find_peaks(side, prominence=2 * CLEAR * noise)[0] for side in (displacement, -displacement)
    )
    values = displacement[np.sort(np.concatenate([top, bottom]))]
    _check_peaks(values.size, CLEAR * noise)
    middle = (values[:-2] + 2 * values[1:-1] + values[2:]) / 4
    amplitude = np.abs(values[:-2] - 2 * values[1:-1] + values[2:]) / 4
    slope = float(
        theilslopes(middle, amplitude)[0]
    )  # robust: of several releases some peaks follow from a pull
    allowed = "at most 0.5: a specimen that rocks to one side of a support is not fitted"
    check(
        "shift of the middle between peaks over their amplitude",
        slope,
        lambda s: np.abs(s) <= 0.5,
        allowed,
    )
    return float(np.median(middle - slope * amplitude))


def find_releases(elapsed: Array, displacement: Array, least: float | None = None) -> list[Release]:
    """Split a test into its releases, each from where the specimen falls freely to its last clear half cycle.

    Times [s], displacements at the hinge or the top [m], and the smallest peak that is used [m], by default ten
    standard deviations of the noise. Raises `InputError` for too few peaks, lost frames, or a specimen that rocks to
    one side only.
    """
    check(
        "samples of the test",
        displacement.size,
        lambda n: n >= FEWEST_SAMPLES,
        f"at least {FEWEST_SAMPLES}",
    )
    noise = sensor_noise(displacement)
    clear = CLEAR * noise if least is None else least
    zero = rocking_zero(displacement, noise)
    cycles = half_cycles(elapsed, displacement - zero, clear)
    sizes = np.abs(cycles.peak)
    _check_peaks(sizes.size, clear)
    # ASSUME: a release is at least a fifth of the largest peak. A peak half as large again as the one before it did not
    # follow from free motion: the specimen was pulled again.
    smallest = 0.2 * sizes.max()
    starts = 1 + np.flatnonzero((sizes[1:] > 1.5 * sizes[:-1]) & (sizes[1:] > smallest))
    edges = [0, *starts.tolist(), sizes.size]
    parts = [
        cycles[start:end]
        for start, end in zip(edges[:-1], edges[1:], strict=True)
        if sizes[start] > smallest
    ]
    _check_peaks(max(part.peak.size for part in parts), clear)
    found = []
    for part in parts:
        if part.peak.size < FEWEST_PEAKS:
            continue
        crossings, peaks = part.start[1:], part.peak
        # The last half cycle ends in the noise: it is used to a little before where its like would end.
        last = part.peak_elapsed[-1] + 0.4 * (crossings[-1] - crossings[-2])
        # ASSUME: below 0.8 of the release the specimen moves freely, whatever held it.
        fall = (elapsed < crossings[0]) & (np.abs(displacement - zero) >= 0.8 * abs(peaks[0]))
        first = int(np.flatnonzero(fall)[-1]) if fall.any() else 0
        if np.abs(displacement[first] - zero) < 0.5 * np.abs(
            peaks[1]
        ):  # no energy before the first impact
            first, crossings, peaks = (
                int(np.argmax(elapsed >= crossings[0])),
                crossings[1:],
                peaks[1:],
            )
        used = slice(first, int(np.searchsorted(elapsed, last)) + 1)
        _check_gaps(elapsed[used], crossings)
        found.append(Release(elapsed[used], displacement[used], zero, crossings, peaks))
    return found


def _check_gaps(elapsed: Array, crossings: Array) -> None:
    """Refuse a release that lost more than 5 frames in a row and a quarter of a half period: two crossings may hide."""
    intervals, half_periods = np.diff(elapsed), np.diff(crossings)
    around = np.interp(elapsed[:-1], crossings[:-1] + half_periods / 2, half_periods)
    allowed = np.maximum(6.5 * np.median(intervals), 0.25 * around)
    at = int(np.argmax(intervals - allowed))
    rule = f"at most {allowed[at]:.3g}: 5 frames, or 0.25 of the half period there"
    check(f"gap after {elapsed[at]:.6g} s", intervals[at], lambda gap: gap <= allowed[at], rule)


def _check_peaks(count: int, clear: float) -> None:
    allowed = f"at least {FEWEST_PEAKS} above {1000 * clear:.3g} mm, the release included"
    check("number of clear peaks", count, lambda n: n >= FEWEST_PEAKS, allowed)
