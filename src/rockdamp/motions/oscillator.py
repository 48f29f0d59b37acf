r"""Linear oscillators under a ground acceleration that is linear between its samples, exact at any step.

Such an acceleration is a sum of ramps: one begins at each sample, with the change of slope there. An oscillator at rest
answers a ramp of slope 1 with the absolute acceleration and the relative displacement

.. math:: t - h(t), \qquad h(t) = \frac{e^{-\xi \omega t} \sin \omega_d t}{\omega_d}, \qquad
          \omega_d = \omega \sqrt{1 - \xi^2}

.. math:: -\frac{t}{\omega^2} + \frac{2 \xi}{\omega^3}
          - e^{-\xi \omega t} \left( \frac{2 \xi}{\omega^3} \cos \omega_d t
          + \frac{2 \xi^2 - 1}{\omega^2 \omega_d} \sin \omega_d t \right)

Sums of damped sines and cosines over the ramps are linear recursions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rockdamp.arrays import Array


@dataclass(frozen=True)
class Ramps:
    """A ground acceleration as a sum of ramps, at samples that lie a whole number of times closer.

    `acceleration` [m s-2], `slope` [m s-3], just after each sample, and its `change` at the sample have one shape.
    """

    step: float
    acceleration: Array
    slope: Array
    change: Array

    @classmethod
    def of(cls, acceleration: Array, step: float, finer: int) -> Ramps:
        """Split each step of an acceleration into `finer` ones; it must begin at 0, and stays as it ends."""
        slope = np.diff(acceleration, append=acceleration[-1]) / step
        index = np.arange((acceleration.size - 1) * finer + 1)
        change = np.zeros(index.size)
        change[::finer] = np.diff(slope, prepend=0.0)
        followed = np.interp(index, index[::finer], acceleration)
        return cls(step / finer, followed, slope[index // finer], change)

    def lag(self, period: float, damping_ratio: float) -> Array:
        """Return the ground's acceleration less the absolute one of an oscillator at rest. [m s-2]"""
        w, damped, sine, cosine, decay = self._cycle(period, damping_ratio)
        return self._recursion([0.0, sine / damped], cosine, decay)

    def displacement(self, period: float, damping_ratio: float) -> Array:
        """Return the displacement of an oscillator relative to the ground. [m]"""
        w, damped, sine, cosine, decay = self._cycle(period, damping_ratio)
        of_cosine, of_sine = 2 * damping_ratio / w**3, (2 * damping_ratio**2 - 1) / (w**2 * damped)
        free = self._recursion([of_cosine, of_sine * sine - of_cosine * cosine], cosine, decay)
        return np.asarray(-self.acceleration / w**2 + of_cosine * self.slope - free)

    def _cycle(self, period: float, damping_ratio: float) -> tuple[float, float, float, float, float]:
        """Return w, w_d, and what a step makes of a free vibration: its sine, its cosine and its decay."""
        w = 2 * np.pi / period
        damped = w * float(np.sqrt(1 - damping_ratio**2))
        decay = float(np.exp(-damping_ratio * w * self.step))
        return w, damped, decay * float(np.sin(damped * self.step)), decay * float(np.cos(damped * self.step)), decay

    def _recursion(self, numerator: list[float], cosine: float, decay: float) -> Array:
        from scipy.signal import lfilter  # slow to import, and the workflow reads records when it starts

        return np.asarray(lfilter(numerator, [1.0, -2 * cosine, decay**2], self.change))
