"""Free-rocking tests: their files, and the releases in them with zero, peaks and crossings of zero."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import sha256

import numpy as np
from scipy.signal import detrend, find_peaks
from scipy.stats import theilslopes

from rockdamp.arrays import Array
from rockdamp.errors import InputError, check
from rockdamp.histories.half_cycles import CLEAR, half_cycles
from rockdamp.motions.record import cells, check_series, mean_step, read_header, read_rows
from rockdamp.storage.files import read_text

TIME = "elapsed_s"
ROCKING_COLUMNS = ("displacement_m", "rotation_rad")  # one of them


@dataclass(frozen=True, eq=False)
class FreeRocking:
    """A free-rocking test, sampled uniformly in time: one or more releases, without a motion of the ground.

    Parameters
    ----------
    elapsed : ndarray, shape (samples,)
        Time, uniform as that of a `Record`. [s]
    displacement : ndarray, shape (samples,), optional
        Horizontal displacement at the hinge, or at the top of a parapet; the sensor's zero need not be the wall's. [m]
    rotation : ndarray, shape (samples,), optional
        Rotation of the lower body, or of a parapet, in place of the displacement. [rad]
    header : mapping of str
        What the file says of itself: specimen, source, licence, units, synthetic (yes or no), and more.
    digest : str, optional
        SHA-256 of the file that it was read from.

    Raises
    ------
    InputError
        Unless there is either a displacement or a rotation, of finite numbers at uniform times.

    Examples
    --------
    >>> import rockdamp as rd
    >>> test = rd.FreeRocking([0.0, 0.002, 0.004], [0.05, 0.05, 0.0499], header={"synthetic": "yes"})
    >>> test.step, test.synthetic
    (0.002, True)
    """

    elapsed: Array
    displacement: Array | None = None
    rotation: Array | None = None
    header: Mapping[str, str] = field(default_factory=dict)
    digest: str = ""

    def __post_init__(self) -> None:
        if (self.displacement is None) == (self.rotation is None):
            raise InputError(f"a free-rocking test must have one of {' and '.join(ROCKING_COLUMNS)}")
        check_series(self, ("elapsed", "displacement", "rotation"))

    @property
    def step(self) -> float:
        """Time between samples. [s]"""
        return mean_step(self.elapsed)

    @property
    def synthetic(self) -> bool:
        """True if the header says that it was computed; without such a statement it was measured."""
        return self.header.get("synthetic") == "yes"

    @property
    def measured(self) -> Array:
        """What was measured: the displacement [m] or the rotation [rad]."""
        return self.displacement if self.displacement is not None else self.rotation  # type: ignore[return-value]


def read_free_rocking(
    path: str | os.PathLike[str], *, frame_rate: float | None = None, pixel: float | None = None
) -> FreeRocking:
    """Read a free-rocking test: lines ``# key: value``, then ``elapsed_s`` and ``displacement_m`` or ``rotation_rad``.

    Parameters
    ----------
    path : path-like
    frame_rate : float, optional
        Of a video, whose first column has frame numbers, whatever it is called. [s-1]
    pixel : float, optional
        Size of a pixel, where the second column has pixels, whatever it is called. [m]

    Raises
    ------
    InputError
        For whatever cannot be read or used, with the line and the file.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import rockdamp as rd
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "release.csv")
    ...     _ = path.write_text("# synthetic: yes\\nelapsed_s,rotation_rad\\n0,0.05\\n0.01,0.05\\n")
    ...     rd.read_free_rocking(path).rotation
    array([0.05, 0.05])
    """

    text = read_text(path)
    lines = text.splitlines()
    try:
        header, first = read_header(lines)
        names = cells(lines[first]) if first < len(lines) else []
        times_named, values_named = names[:1] == [TIME], names[1:] in ([ROCKING_COLUMNS[0]], [ROCKING_COLUMNS[1]])
        if len(names) != 2 or not (times_named or frame_rate) or not (values_named or pixel):
            raise InputError(
                f"columns are {', '.join(names)}; they must be {TIME} and one of {', '.join(ROCKING_COLUMNS)}"
            )
        elapsed, values = np.array(read_rows(lines, first + 1, 2)).T
        elapsed = elapsed if frame_rate is None else elapsed / frame_rate
        name = "displacement" if pixel is not None else names[1].partition("_")[0]
        measured = dict.fromkeys(("displacement", "rotation")) | {name: values if pixel is None else pixel * values}
        return FreeRocking(elapsed, **measured, header=header, digest=sha256(text.encode()).hexdigest())
    except InputError as error:
        raise InputError(f"{os.fspath(path)}: {error}") from None


# --- releases ---------------------------------------------------------------------------------------------------------

# ASSUME: what a test must be for these to be found in it.
FEWEST_PEAKS = 4  # of a release, itself included: three impacts, of which two leave something to compare
GROWN = 1.5  # of the peak before: a peak beyond it did not follow from free motion, the specimen was pulled again
RELEASE = 0.2  # of the largest peak: a release is at least as large
FALLING = 0.8  # of the release: below it the specimen moves freely, whatever held it
RISEN = 0.5  # of the next peak: where the record begins below it, the first impact has no energy before it
ONE_SIDED = 0.5  # of the amplitude: how far the middle between peaks may move with it
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
        found.append(Release(elapsed[used], displacement[used], zero, inside, peaks))
    return found


def _check_peaks(count: int, clear: float) -> None:
    allowed = f"at least {FEWEST_PEAKS} beyond {1000 * clear:.3g} mm, the release included"
    check("number of clear peaks", count, lambda n: n >= FEWEST_PEAKS, allowed)
