"""Releases in a free-rocking test, with their zero, peaks and crossings of zero."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.signal import detrend, find_peaks
from scipy.stats import median_abs_deviation, theilslopes

from rockdamp.arrays import Array
from rockdamp.errors import InputError, check
from rockdamp.histories.half_cycles import CLEAR_OF_NOISE, HalfCycles, half_cycles

Indices: TypeAlias = NDArray[np.int64]

# ASSUME: a release has at least three impacts, of which two leave a peak to compare.
FEWEST_PEAKS = 4
FEWEST_SAMPLES = 50  # of a test, and of its part at rest: a deviation is known to a tenth
# ASSUME: lost frames in a row over which a motion can be interpolated.
MOST_LOST_FRAMES = 5


@dataclass(frozen=True)
class Release:
    """Part of a test that is one free decay, in SI units, as the sensor measured it.

    Parameters
    ----------
    elapsed : ndarray, shape (samples,)
        Time. [s]
    displacement : ndarray, shape (samples,)
        Measured displacement. [m]
    zero : float
        Level of the sensor about which the specimen rocks. [m]
    crossings : ndarray, shape (impacts,)
        Times at which the displacement crosses zero, one for each impact. [s]
    peaks : ndarray, shape (impacts + 1,)
        Signed peaks around the crossings. [m]
    """

    elapsed: Array
    displacement: Array
    zero: float
    crossings: Array
    peaks: Array


# --- noise and zero of the sensor -----------------------------------------------------------------


def sensor_noise(displacement: Array) -> float:
    """Return the standard deviation of white noise, or half of the one at rest if it is larger. [m]

    White noise shows in second differences, which motion hardly changes; filtered noise shows only
    at rest.
    """
    white_noise = _white_noise(displacement)
    resting_deviation = rest_deviation(displacement)
    if np.isnan(resting_deviation):
        return white_noise
    return max(white_noise, resting_deviation / 2)


def rest_deviation(displacement: Array) -> float:
    """Return the standard deviation at rest, at the start or the end; NaN without rest. [m]"""
    count = max(int(0.05 * displacement.size), FEWEST_SAMPLES)
    ends = displacement[:count], displacement[-count:]
    deviation = min(float(np.std(detrend(end))) for end in ends)
    # ASSUME: the specimen is at rest where a twentieth of the test varies this little.
    quiet = max(1.5 * _white_noise(displacement), 0.005 * float(np.ptp(displacement)))
    return deviation if deviation < quiet else np.nan


def _white_noise(displacement: Array) -> float:
    """Return the standard deviation of white noise, or of the logger's rounding. [m]"""
    # A second difference of white noise has six times its variance; rounding to steps of s has the
    # variance s^2/12.
    curvature = np.diff(displacement, 2)
    deviation = float(median_abs_deviation(curvature, scale="normal")) / np.sqrt(6)
    steps = np.abs(np.diff(displacement))
    if not steps.any():
        return deviation
    return max(deviation, float(steps[steps > 0].min()) / np.sqrt(12))


def rocking_zero(displacement: Array, noise: float) -> float:
    """Return the level about which the specimen rocks: the middle between peaks, as they fade. [m]

    The middle moves with the amplitude if the specimen rocks to one side of a support; such a test
    is refused.
    """
    prominence = 2 * CLEAR_OF_NOISE * noise
    top, _ = find_peaks(displacement, prominence=prominence)
    bottom, _ = find_peaks(-displacement, prominence=prominence)
    peaks = displacement[np.sort(np.concatenate([top, bottom]))]
    _check_peaks(peaks.size, CLEAR_OF_NOISE * noise)
    middle = (peaks[:-2] + 2 * peaks[1:-1] + peaks[2:]) / 4
    amplitude = np.abs(peaks[:-2] - 2 * peaks[1:-1] + peaks[2:]) / 4
    # A robust slope, as some peaks of several releases follow from a pull.
    slope = float(theilslopes(middle, amplitude)[0])
    # The slope is 0 for rocking to both sides, and 1 for rocking to one side.
    check(
        "shift of the middle between peaks over their amplitude",
        slope,
        lambda slope: np.abs(slope) <= 0.5,
        "at most 0.5: a specimen that rocks to one side of a support is not fitted",
    )
    return float(np.median(middle - slope * amplitude))


# --- releases -------------------------------------------------------------------------------------


def find_releases(elapsed: Array, displacement: Array, least: float | None = None) -> list[Release]:
    """Split a test into its releases, each from free fall to its last clear half cycle.

    Parameters
    ----------
    elapsed : ndarray, shape (samples,)
        Time. [s]
    displacement : ndarray, shape (samples,)
        Displacement at the hinge or the top. [m]
    least : float, optional
        Smallest peak that is used; default: ten standard deviations of the noise. [m]

    Raises
    ------
    InputError
        If there are too few samples or peaks, a sample lies far off its neighbours, frames are
        lost, or the specimen rocks to one side only.
    """
    if displacement.size < FEWEST_SAMPLES:
        raise InputError(
            f"the test has {displacement.size} samples; it must have at least {FEWEST_SAMPLES}"
        )
    noise = sensor_noise(displacement)
    _check_spikes(elapsed, displacement, CLEAR_OF_NOISE * noise)
    clear = CLEAR_OF_NOISE * noise if least is None else least
    zero = rocking_zero(displacement, noise)
    cycles = half_cycles(elapsed, displacement - zero, clear)
    releases = [
        _make_release(elapsed, displacement, zero, decay)
        for decay in _split_decays(cycles, clear)
        if decay.peak.size >= FEWEST_PEAKS
    ]
    for release in releases:
        _check_gaps(release.elapsed, release.crossings)
    return releases


def _split_decays(cycles: HalfCycles, clear: float) -> list[HalfCycles]:
    """Split half cycles where the specimen was pulled again."""
    sizes = np.abs(cycles.peak)
    _check_peaks(sizes.size, clear)
    # ASSUME: a release is at least a fifth of the largest peak. A peak half as large again as the
    # one before it did not follow from free motion: the specimen was pulled again.
    smallest = 0.2 * sizes.max()
    pulls = 1 + np.flatnonzero((sizes[1:] > 1.5 * sizes[:-1]) & (sizes[1:] > smallest))
    starts = [0, *pulls.tolist()]
    ends = [*pulls.tolist(), sizes.size]
    decays = [
        cycles[start:end]
        for start, end in zip(starts, ends, strict=True)
        if sizes[start] > smallest
    ]
    _check_peaks(max(decay.peak.size for decay in decays), clear)
    return decays


def _make_release(elapsed: Array, displacement: Array, zero: float, decay: HalfCycles) -> Release:
    """Return the release of a decay, without the part in which the specimen was held."""
    crossings = decay.start[1:]
    peaks = decay.peak
    # The last half cycle ends in the noise: it is used to a little before its expected end, half of
    # a half period after its peak.
    end = decay.peak_elapsed[-1] + 0.4 * (crossings[-1] - crossings[-2])
    # ASSUME: below 0.8 of the release the specimen moves freely, whatever held it.
    is_held = (elapsed < crossings[0]) & (np.abs(displacement - zero) >= 0.8 * abs(peaks[0]))
    first = int(np.flatnonzero(is_held)[-1]) if is_held.any() else 0
    if np.abs(displacement[first] - zero) < 0.5 * np.abs(peaks[1]):
        # The test begins too late for the energy before the first impact.
        first = int(np.argmax(elapsed >= crossings[0]))
        crossings = crossings[1:]
        peaks = peaks[1:]
    used = slice(first, int(np.searchsorted(elapsed, end)) + 1)
    return Release(elapsed[used], displacement[used], zero, crossings, peaks)


# --- checks ---------------------------------------------------------------------------------------


def _check_peaks(count: int, clear: float) -> None:
    allowed = f"at least {FEWEST_PEAKS} above {1000 * clear:.3g} mm, the release included"
    check("number of clear peaks", count, lambda count: count >= FEWEST_PEAKS, allowed)


def _check_gaps(elapsed: Array, crossings: Array) -> None:
    """Refuse a gap of several frames and a quarter of a half period: impacts may hide there."""
    intervals = np.diff(elapsed)
    half_periods = np.diff(crossings)
    middles = crossings[:-1] + half_periods / 2
    local_half_periods = np.interp(elapsed[:-1], middles, half_periods)
    # Without n frames there are n + 1 intervals; half of one allows for uneven times.
    longest_loss = (MOST_LOST_FRAMES + 1.5) * np.median(intervals)
    allowed = np.maximum(longest_loss, 0.25 * local_half_periods)
    worst = int(np.argmax(intervals - allowed))
    if intervals[worst] > allowed[worst]:
        raise InputError(
            f"gap after {elapsed[worst]:.6g} s is {intervals[worst]:.3g} s; it must be at most"
            f" {allowed[worst]:.3g} s: {MOST_LOST_FRAMES} frames, or 0.25 of the half period there"
        )


def _check_spikes(elapsed: Array, displacement: Array, clear: float) -> None:
    """Refuse samples far off the motion on both sides of them, where a sensor or a marker was lost.

    Three lines continue the motion: on each side the line through the two nearest samples, and the
    chord between the nearest ones of both sides. After an impact or a release, and at a low frame
    rate, samples lie between these lines. A spike of up to `MOST_LOST_FRAMES` samples lies outside
    them by more than `clear`, and by more than five times the distance of any neighbour from the
    chord between the samples beside it.
    """
    t = np.pad(elapsed, 2, mode="reflect", reflect_type="odd")
    u = np.pad(displacement, 2, mode="reflect")
    inner = np.arange(1, u.size - 1)
    roughness = np.pad(np.abs(u[inner] - _line(t, u, inner - 1, inner + 1, inner)), 1)
    # Largest roughness of four samples: those that end with a sample, and those that start with it.
    largest = sliding_window_view(np.pad(roughness, 3), 4).max(axis=1)
    largest_before = largest[:-3]
    largest_after = largest[3:]
    for width in range(1, MOST_LOST_FRAMES + 1):
        first = np.arange(2, u.size - width - 1)
        last = first + width - 1
        samples = first + np.arange(width)[:, None]
        from_left = _line(t, u, first - 2, first - 1, samples)
        from_right = _line(t, u, last + 1, last + 2, samples)
        chord = _line(t, u, first - 1, last + 1, samples)
        excess = u[samples] - np.maximum(np.maximum(from_left, from_right), chord)
        deficit = np.minimum(np.minimum(from_left, from_right), chord) - u[samples]
        distance = np.maximum(excess.min(axis=0), deficit.min(axis=0))
        nearby = np.maximum(largest_before[first - 2], largest_after[last + 2])
        allowed = np.maximum(clear, 5 * nearby)
        worst = int(np.argmax(distance - allowed))
        if distance[worst] > allowed[worst]:
            raise InputError(
                f"jump of the displacement at {t[first[worst]]:.6g} s is {distance[worst]:.3g} m;"
                f" it must be at most {allowed[worst]:.3g} m: leave out samples of a lost marker"
            )


def _line(t: Array, u: Array, start: Indices, end: Indices, sample: Indices) -> Array:
    """Return the line through two samples, at the time of another one."""
    slope = (u[end] - u[start]) / (t[end] - t[start])
    return np.asarray(u[start] + slope * (t[sample] - t[start]))
