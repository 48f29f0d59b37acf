"""Pulses of the ground or of a shaking table, as functions of time."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arguments import number, numbers
from rockdamp.arrays import Array
from rockdamp.errors import require

PULSES = ("Ricker", "sine")
RICKER_HALF_LENGTH = 1.5  # periods before and after the peak, where the wavelet is 1e-8 of it


def pulse(name: str, frequency: float, step: float) -> Array:
    """Return a pulse of peak 1 and angular frequency w/p, sampled every `step` in tau; it ends at zero."""
    period = 2 * np.pi / frequency
    if name == "Ricker":
        half = round(RICKER_HALF_LENGTH * period / step)
        return ricker(step * np.arange(-half, half + 1), 1 / period, 1.0)
    tau = step * np.arange(int(np.ceil(period / step)) + 1)
    return np.where(tau < period, np.sin(frequency * tau), 0.0)


def ricker(time: ArrayLike, frequency: float, amplitude: float) -> Array:
    """Return a Ricker wavelet A (1 - 2 s) exp(-s), s = (pi f t)^2, with its peak at t = 0. [s], [Hz], [m s-2]"""
    at, amplitude, frequency = numbers("time", time), number("amplitude", amplitude), number("frequency", frequency)
    require(frequency > 0, "frequency", frequency, "greater than 0 [Hz]")
    s = (np.pi * frequency * at) ** 2
    return amplitude * (1 - 2 * s) * np.exp(-s)
