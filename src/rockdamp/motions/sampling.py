"""Check a sampled series: finite numbers at uniform times. Errors name the sample or the line."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rockdamp.arrays import Array
from rockdamp.errors import InputError

UNIFORM = 1e-4  # of a step: how far a time may lie from where uniform sampling puts it

Place = Callable[[int], str]  # of a sample, by its index: "on line 12"


def check_finite(values: Array, name: str, place: Place) -> None:
    """Raise unless every value is a finite number."""
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise InputError(f"{name} is {float(values[bad[0]])} {place(int(bad[0]))}; it must be a finite number")


def step_of(elapsed: Array) -> float:
    """Return the mean interval between two samples."""
    return float(elapsed[-1] - elapsed[0]) / (len(elapsed) - 1)


def check_time(elapsed: Array, place: Place) -> None:
    """Raise unless time has at least two samples, increases, and is uniform to `UNIFORM` of a step."""
    if len(elapsed) < 2:
        raise InputError(f"elapsed_s has {len(elapsed)} samples; it must have at least 2")
    intervals = np.diff(elapsed)
    back = np.flatnonzero(intervals <= 0)
    if back.size:
        late = int(back[0]) + 1
        raise InputError(f"elapsed_s is {elapsed[late]} {place(late)}; it must be greater than {elapsed[late - 1]}")
    # The straight line of least squares, moved to the middle, lies within UNIFORM of a step of all times.
    # Sums, as the product of long vectors by BLAS starts threads, which take longer than it does.
    index = np.arange(len(elapsed)) - (len(elapsed) - 1) / 2
    departure = elapsed - index * (index * elapsed).sum() / (index * index).sum()
    if np.ptp(departure) / 2 > UNIFORM * step_of(elapsed):
        usual = float(np.median(intervals))
        late = int(np.argmax(np.abs(intervals - usual))) + 1
        raise InputError(
            f"elapsed_s is {elapsed[late]} {place(late)}; it must be {elapsed[late - 1] + usual:.9g}: times must be "
            f"uniform to {UNIFORM:g} of a step, and be written with as many digits"
        )
