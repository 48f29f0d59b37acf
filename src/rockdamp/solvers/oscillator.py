r"""Linear oscillators under a ground acceleration that is linear between its samples, exactly.

Such a motion is a sum of ramps: one begins at each sample, with the change of slope there. An
oscillator at rest answers a ramp of slope 1 with the absolute acceleration and the relative
displacement

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
    """Motion of oscillators, sampled `parts` times as often as the motion of the ground."""

    ground: Array  # ground acceleration, shape (samples,) [m s-2]
    # Ground acceleration less the absolute one of each oscillator, shape (oscillators, samples)
    lag: Array
    displacement: Array  # relative to the ground, shape (oscillators, samples) [m]


def oscillate(
    ground_acceleration: Array, step: float, period: Array, damping_ratio: float, parts: int = 1
) -> Oscillation:
    """Return the motion of oscillators that are at rest before the ground acceleration begins.

    Parameters
    ----------
    ground_acceleration : ndarray, shape (samples,)
        Ground acceleration, which starts at 0 and keeps its last value. [m s-2]
    step : float
        Time between two samples. [s]
    period : ndarray, shape (oscillators,)
        Natural periods. [s]
    damping_ratio : float
        Damping ratio of all oscillators. [-]
    parts : int
        Number of parts into which each step is split. The default is 1.
    """
    from scipy.signal import lfilter  # slow to import

    slopes = np.diff(ground_acceleration, append=ground_acceleration[-1]) / step
    index = np.arange((ground_acceleration.size - 1) * parts + 1)
    slope_changes = np.zeros(index.size)
    slope_changes[::parts] = np.diff(slopes, prepend=0.0)
    ground = np.interp(index, index[::parts], ground_acceleration)
    slope = slopes[index // parts]
    lag, displacement = np.empty((2, period.size, index.size))
    for row, w in enumerate((2 * np.pi / period).tolist()):
        damped_w = w * np.sqrt(1 - damping_ratio**2)
        decay = np.exp(-damping_ratio * w * step / parts)
        angle = damped_w * step / parts
        sine = decay * np.sin(angle)
        cosine = decay * np.cos(angle)
        recursion = [1.0, -2 * cosine, decay**2]
        lag[row] = lfilter([0.0, sine / damped_w], recursion, slope_changes)
        # Coefficients of the damped cosine and sine in the displacement.
        a = 2 * damping_ratio / w**3
        b = (2 * damping_ratio**2 - 1) / (w**2 * damped_w)
        free = lfilter([a, b * sine - a * cosine], recursion, slope_changes)
        displacement[row] = -ground / w**2 + a * slope - free
    return Oscillation(ground, lag, displacement)
