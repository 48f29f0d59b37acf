"""A record of ground motion: samples at uniform times, and the checks that make it one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from rockdamp.arrays import Array, short_repr
from rockdamp.errors import InputError, check, check_choice, check_type

UNIFORM_SHARE = 0.01  # of a step; a time may be so far from its place, however printed


@dataclass(frozen=True, eq=False)
class Record:
    """A ground motion sampled uniformly in time, with the wall's displacement where measured.

    The record keeps copies of the arrays and of the header.

    Parameters
    ----------
    elapsed : ndarray, shape (samples,)
        Time [s], in equal steps of 0.0001 to 0.1 s. Compared with equal steps from the first time
        to the last, each time may be off by 1 % of a step or by one unit of the last decimal that
        any time has, and each interval by half a step.
    ground_acceleration : ndarray, shape (samples,)
        Absolute horizontal acceleration of the ground, positive towards +u. [m s-2]
    displacement : ndarray, shape (samples,), optional
        Measured displacement of the hinge relative to the supports. The sensor's zero may differ
        from the wall's. [m]
    header : mapping of str, optional
        Description of the record: specimen, source, licence, synthetic (yes or no), and any other
        keys.
    digest : str, optional
        SHA-256 of the text that the record was read from.

    Raises
    ------
    InputError
        If the arrays differ in length or contain values that are not finite, or if the times are
        not uniform.

    Examples
    --------
    >>> import rockdamp as rd
    >>> record = rd.Record([0.0, 0.01, 0.02], [0.0, 1.5, 0.0], header={"synthetic": "yes"})
    >>> record.step, record.synthetic
    (0.01, True)
    """

    elapsed: Array
    ground_acceleration: Array
    displacement: Array | None = None
    header: Mapping[str, str] = field(default_factory=dict)
    digest: str = ""

    def __post_init__(self) -> None:
        check_series(self, ("elapsed", "ground_acceleration"), ("displacement",))
        check_times(self.elapsed)
        check_step(self.step)

    __repr__ = short_repr

    def __eq__(self, other: object) -> bool:
        """Say whether another record has the same samples, header and digest."""
        if type(other) is not type(self):
            return False
        names = [entry.name for entry in fields(self)]
        return all(np.array_equal(getattr(self, name), getattr(other, name)) for name in names)

    @property
    def step(self) -> float:
        """Time between samples. [s]"""
        return mean_step(self.elapsed)

    @property
    def synthetic(self) -> bool:
        """True if the header states that the record was computed; False otherwise."""
        return self.header.get("synthetic") == "yes"


def check_series(instance: Any, required: Sequence[str], optional: Sequence[str]) -> None:
    """Check the series and the header of a frozen dataclass, and store copies of them.

    Each series must be finite and as long as ``elapsed``.
    """
    present = [name for name in optional if getattr(instance, name) is not None]
    for name in (*required, *present):
        values = check(name, getattr(instance, name), np.isfinite, "finite")
        object.__setattr__(instance, name, values)
        if values.ndim != 1 or values.shape != instance.elapsed.shape:
            raise InputError(
                f"{name} has shape {values.shape}; it must be (samples,), as elapsed has"
            )
    header = check_type("header", instance.header, Mapping)
    object.__setattr__(instance, "header", dict(header))
    check_choice("synthetic", instance.header.get("synthetic", "no"), ("yes", "no"))


def check_step(step: float) -> None:
    """Raise `InputError` unless a step [s] is one of a ground motion.

    Times that are indices, or in another unit, have steps outside the range.
    """
    # Loggers of ground motion sample at 50 to 1000 Hz. Times are rounded, so that a step of 0.1 s
    # may be a bit longer.
    if not 0.999e-4 <= step <= 0.1001:
        raise InputError(f"step is {step:g} s; it must be from 0.0001 to 0.1 s")


def mean_step(elapsed: Array) -> float:
    """Return the mean time between samples."""
    return float(elapsed[-1] - elapsed[0]) / (elapsed.size - 1)


def check_times(elapsed: Array, printed: Iterable[str] | None = None) -> None:
    """Raise `InputError` unless times are uniform in the sense of `Record`.

    Parameters
    ----------
    elapsed : ndarray, shape (samples,)
        Times, in any unit.
    printed : iterable of str, optional
        The same times as a file prints them. Without it, their decimals are counted.
    """
    if elapsed.size < 2:
        raise InputError(f"elapsed has {elapsed.size} samples; it must have at least 2")
    step = mean_step(elapsed)
    departure = np.abs(elapsed - elapsed[0] - step * np.arange(elapsed.size))
    if step > 0 and departure.max() <= UNIFORM_SHARE * step:
        return
    if printed is None:
        decimals = _exact_decimals(elapsed)
    else:
        decimals = count_decimals(printed)
    rounding = 2 * np.spacing(np.abs(elapsed).max())
    tolerance = max(10.0**-decimals, UNIFORM_SHARE * step) + rounding
    intervals = np.diff(elapsed)
    if (departure <= tolerance).all() and (np.abs(intervals - step) < step / 2).all():
        return
    raise InputError(_describe_first_gap(elapsed, departure, tolerance))


def _describe_first_gap(elapsed: Array, departure: Array, tolerance: float) -> str:
    """Describe the first interval that is not the usual one, and the samples missing in it."""
    intervals = np.diff(elapsed)
    # Gaps are no usual intervals; the median is one where most are.
    usual = intervals[(intervals > 0) & (intervals < 1.5 * np.median(intervals))]
    step = float(usual.mean()) if usual.size else abs(mean_step(elapsed))
    wrong = np.abs(intervals - step) >= step / 2
    if wrong.any():
        place = int(np.argmax(wrong))
    else:
        place = max(int(np.argmax(departure > tolerance)) - 1, 0)
    before = elapsed[place]
    text = (
        f"elapsed goes from {before} to {elapsed[place + 1]}; "
        f"it must rise by equal steps, here {step:.6g}"
    )
    missing = round(intervals[place] / step) - 1 if step > 0 else 0
    whole_steps = abs(intervals[place] - (missing + 1) * step) <= tolerance
    if missing < 1 or not whole_steps:
        return text
    samples = "sample is" if missing == 1 else "samples are"
    return f"{text}: {missing} {samples} missing after {before}"


def count_decimals(numbers: Iterable[str]) -> int:
    """Return the most decimals of numbers as they are printed; an exponent counts."""
    most = 0
    for number in numbers:
        mantissa, _, exponent = number.replace("E", "e").partition("e")
        decimals = len(mantissa.partition(".")[2]) - int(exponent or 0)
        most = max(most, decimals)
    return most


def _exact_decimals(values: Array) -> int:
    """Return the fewest decimals at which rounding leaves all values as they are; 15 at most."""
    for decimals in range(15):
        if (np.round(values, decimals) == values).all():
            return decimals
    return 15


def append_rest(ground_acceleration: Array, step: float, tail: float) -> Array:
    """Append zeros to ground motions, so that the wall can come to rest.

    Parameters
    ----------
    ground_acceleration : ndarray, shape (..., samples)
        Ground motions.
    step : float
        Time between samples. [s], or in tau
    tail : float
        Least duration of the zeros, in the unit of `step`.

    Returns
    -------
    ndarray, shape (..., samples + zeros)
        The motions, and the zeros behind them.
    """
    tail = float(check("tail", tail, lambda x: x >= 0, "at least 0"))
    zeros = int(np.ceil(tail / step))
    rest = np.zeros((*ground_acceleration.shape[:-1], zeros))
    return np.concatenate([ground_acceleration, rest], axis=-1)
