"""Pulses of the ground or of a shaking table, as functions of time."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arguments import number, numbers
from rockdamp.arrays import Array
from rockdamp.errors import require

PULSES = ("Ricker", "sine")
RICKER_HALF_LENGTH = 1.5  # periods before and after the peak, where the wavelet is 1e-8 of it
RICKER_SIDE_LOBE = 2 * np.exp(-1.5)  # 0.446 of the peak

# ASSUME: shape of a table's pulse. Pulses recorded on the sister specimen of Fig. 8 are said (secondary source, not
# verified) to have had main lobes about 0.29 s wide and side lobes of -0.18 to -0.28 of the peak: the middle of that.
PULSE_WIDTH, PULSE_SIDE_LOBE = 0.29, 0.23


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


def table_pulse(
    time: ArrayLike, amplitude: float, *, width: float = PULSE_WIDTH, side_lobe: float = PULSE_SIDE_LOBE
) -> Array:
    """Return a shaking table's pulse for a Ricker wavelet: side lobes lower and longer, no velocity left over.

    The difference of two Gaussian bells of equal area,

        a(t) = A [exp(-q) - r exp(-r^2 q)]/(1 - r),  q = t^2/(2 s^2),  0 < r < 1,

    whose integral is zero; being even, it leaves no displacement over either. It is zero at q0 = ln(1/r)/(1 - r^2) and
    lowest at 3 q0, with -A (1 + r)/r^2 exp(-3 q0). Towards r = 1 it is the Ricker wavelet.

    s follows from the `width` of the main lobe between its zeros [s], r from `side_lobe`: the depth of the side lobes
    over the peak, between 0.02 and a Ricker wavelet's 0.446.
    """
    from scipy.optimize import brentq  # slow to import, and the pulses of a table alone need it

    at, amplitude = numbers("time", time), number("amplitude", amplitude)
    width, side_lobe = number("width", width), number("side_lobe", side_lobe)
    require(width > 0, "width", width, "greater than 0 [s]")
    allowed = f"between 0.02 and {RICKER_SIDE_LOBE:.3f}, a Ricker wavelet's, excluded"
    require(0.02 <= side_lobe < 0.446, "side_lobe", side_lobe, allowed)
    r = brentq(lambda r: _side_lobe(r) - side_lobe, 0.001, 0.9999, xtol=1e-15)
    q = _zero(r) * (2 * at / width) ** 2
    return amplitude * (np.exp(-q) - r * np.exp(-(r**2) * q)) / (1 - r)


def _zero(r: float) -> float:
    """Return q where the pulse of `table_pulse` is zero."""
    return float(np.log(1 / r) / (1 - r**2))


def _side_lobe(r: float) -> float:
    """Return the depth of the side lobes of `table_pulse` over its peak."""
    return float((1 + r) / r**2 * np.exp(-3 * _zero(r)))


def wavelet(time: ArrayLike, frequency: float, cycles: float, amplitude: float) -> Array:
    r"""Return the wavelet of Mavroeidis and Papageorgiou (2003, doi:10.1785/0120020100), a few cycles, even in time.

    .. math:: a(t) = \frac{A}{2} \left[\left(1 + \cos\frac{\omega t}{\gamma}\right) \cos\omega t
              - \frac{1}{\gamma} \sin\frac{\omega t}{\gamma} \sin\omega t\right], \quad |\omega t| \le \pi \gamma

    with :math:`\omega = 2 \pi f`. Its integral is odd and zero at both ends: the table stops where it started. The
    `cycles` gamma are more than 1; the pulse lasts gamma/f.
    """
    at, amplitude = numbers("time", time), number("amplitude", amplitude)
    frequency, cycles = number("frequency", frequency), number("cycles", cycles)
    require(frequency > 0, "frequency", frequency, "greater than 0 [Hz]")
    require(cycles > 1, "cycles", cycles, "greater than 1")
    phase = 2 * np.pi * frequency * at
    slow = phase / cycles
    inside = (1 + np.cos(slow)) * np.cos(phase) - np.sin(slow) * np.sin(phase) / cycles
    return np.where(np.abs(slow) <= np.pi, amplitude / 2 * inside, 0.0)
