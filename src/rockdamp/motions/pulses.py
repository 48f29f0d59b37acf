"""The Ricker pulse of the ground or of a shaking table, as a function of time."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array


def ricker(time: ArrayLike, frequency: float, amplitude: float) -> Array:
    """Return a Ricker wavelet A (1 - 2 s) exp(-s), s = (pi f t)^2, with its peak at t = 0. [s], [Hz], [m s-2]"""
    s = (np.pi * frequency * np.asarray(time, float)) ** 2
    return amplitude * (1 - 2 * s) * np.exp(-s)
