r"""Linear oscillators at rest under a ground acceleration that is linear between its samples: exact.

Such a motion is a sum of ramps: one begins at each sample, with the change of slope there. An oscillator answers a ramp
of slope 1 with the absolute acceleration and the relative displacement

.. math:: t - h(t), \qquad h(t) = \frac{e^{-\xi \omega t} \sin \omega_d t}{\omega_d}, \qquad
          \omega_d = \omega \sqrt{1 - \xi^2}

.. math:: -\frac{t}{\omega^2} + \frac{2 \xi}{\omega^3}
          - e^{-\xi \omega t} \left( \frac{2 \xi}{\omega^3} \cos \omega_d t
          + \frac{2 \xi^2 - 1}{\omega^2 \omega_d} \sin \omega_d t \right)

Sums of damped sines and cosines over the ramps are linear recursions.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rockdamp.arrays import Array


class Oscillation(NamedTuple):
    """Motion of oscillators, sampled a whole number of times as often as that of the ground."""

    ground: Array  # acceleration, shape (samples,) [m s-2]
    lag: Array  # the ground's acceleration less the absolute one of each oscillator, shape (oscillators, samples)
    displacement: Array  # relative to the ground, shape (oscillators, samples) [m]


def oscillate(
    acceleration: Array, step: float, period: Array, damping_ratio: float, finer: int = 1
) -> Oscillation:
    """Return the motion of oscillators under a ground acceleration that begins at 0, each step in `finer` parts.

    Parameters
    ----------
    acceleration : ndarray, shape (samples,)
        Of the ground; it stays as it ends. [m s-2]
    step : float
        Time between two samples. [s]
    period : ndarray, shape (oscillators,)
        Natural periods. [s]
    damping_ratio : float
        Of each oscillator. [-]
    finer : int
    """
    from scipy.signal import lfilter  # slow to import

    slopes = np.diff(acceleration, append=acceleration[-1]) / step
    index = np.arange((acceleration.size - 1) * finer + 1)
    change = np.zeros(index.size)
    change[::finer] = np.diff(slopes, prepend=0.0)
    ground, slope = np.interp(index, index[::finer], acceleration), slopes[index // finer]
    lag, displacement = np.empty((2, period.size, index.size))
    for row, w in enumerate((2 * np.pi / period).tolist()):
        damped = w * np.sqrt(1 - damping_ratio**2)
        decay, turned = np.exp(-damping_ratio * w * step / finer), damped * step / finer
        sine, cosine = decay * np.sin(turned), decay * np.cos(turned)
        recursion = [1.0, -2 * cosine, decay**2]
        lag[row] = lfilter([0.0, sine / damped], recursion, change)
        in_cosine, in_sine = 2 * damping_ratio / w**3, (2 * damping_ratio**2 - 1) / (w**2 * damped)
        free = lfilter([in_cosine, in_sine * sine - in_cosine * cosine], recursion, change)
        displacement[row] = -ground / w**2 + in_cosine * slope - free
    return Oscillation(ground, lag, displacement)
