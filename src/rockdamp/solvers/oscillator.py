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
from numpy.typing import ArrayLike

from rockdamp.arguments import instance, number, numbers
from rockdamp.arrays import Array
from rockdamp.errors import require
from rockdamp.motions.records import Record
from rockdamp.solvers.compiled import compiled

MOST_POINTS = 2**25  # of the fine record that an oscillator is integrated over
PER_PERIOD = 100  # points in a period: the largest of them is within 1 - cos(pi/100), 0.05 %, of the peak


def recursion(values, first, second, last, last_but_one):  # type: ignore[no-untyped-def]  # numba infers the types
    """Return y_n = first x_n + second x_(n-1) + last y_(n-1) - last_but_one y_(n-2), which starts at rest.

    `scipy.signal.lfilter` gives the same bits; to import it takes a second, and a process calls this a few times.
    """
    sums = np.empty_like(values)
    carried = kept = 0.0
    for n in range(values.size):
        sums[n] = y = carried + first * values[n]
        carried = kept + second * values[n] + last * y
        kept = -last_but_one * y
    return sums


run_recursion = compiled(recursion, recursion)


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
        return run_recursion(self.change, 0.0, sine / damped, 2 * cosine, decay**2)

    def displacement(self, period: float, damping_ratio: float) -> Array:
        """Return the displacement of an oscillator relative to the ground. [m]"""
        w, damped, sine, cosine, decay = self._cycle(period, damping_ratio)
        of_cosine, of_sine = 2 * damping_ratio / w**3, (2 * damping_ratio**2 - 1) / (w**2 * damped)
        free = run_recursion(self.change, of_cosine, of_sine * sine - of_cosine * cosine, 2 * cosine, decay**2)
        return np.asarray(-self.acceleration / w**2 + of_cosine * self.slope - free)

    def _cycle(self, period: float, damping_ratio: float) -> tuple[float, float, float, float, float]:
        """Return w, w_d, and what a step makes of a free vibration: its sine, its cosine and its decay."""
        w = 2 * np.pi / period
        damped = w * float(np.sqrt(1 - damping_ratio**2))
        decay = float(np.exp(-damping_ratio * w * self.step))
        return w, damped, decay * float(np.sin(damped * self.step)), decay * float(np.cos(damped * self.step)), decay


def spectral_acceleration(record: Record, period: ArrayLike, damping_ratio: float = 0.05) -> Array:
    r"""Return the pseudo-spectral acceleration: w^2 times the peak displacement of a linear oscillator.

    .. math::
        S_a = \omega^2 \max \lvert u \rvert, \quad \ddot{u} + 2 \xi \omega \dot{u} + \omega^2 u = -a, \quad
        \omega = 2 \pi/T

    The oscillator is integrated exactly for an acceleration that is linear between samples, with at least
    `PER_PERIOD` points in a period, and for one period after the record.

    Parameters
    ----------
    record : Record
        ASSUME: the ground is at rest one step before the record and one step after it.
    period : float or ndarray
        Of the undamped oscillator. [s]
    damping_ratio : float
        Fraction of critical damping. [-]

    Returns
    -------
    ndarray, shape of `period`
        [m s-2]

    Raises
    ------
    InputError
        If a period is not positive or the damping ratio is not between 0 and 1.

    Examples
    --------
    >>> import numpy as np
    >>> import rockdamp as rd
    >>> elapsed = 0.01 * np.arange(201)
    >>> sine = rd.Record(elapsed, np.sin(2 * np.pi * elapsed))
    >>> rd.spectral_acceleration(sine, [0.05, 1.0]).round(2)  # a stiff oscillator follows the ground; at 1 s, resonance
    array([1.01, 4.67])
    """
    instance("record", record, Record)
    periods, damping_ratio = numbers("period", period), number("damping_ratio", damping_ratio)
    require(periods > 0, "period", periods, "greater than 0 [s]")
    with np.errstate(over="ignore"):
        points = (record.elapsed.size + periods / record.step) * np.ceil(PER_PERIOD * record.step / periods)
    require(points <= MOST_POINTS, "period", periods, "nearer to the step and the duration of the record")
    require(0 <= damping_ratio < 1, "damping_ratio", damping_ratio, "at least 0 and less than 1")
    return np.vectorize(lambda seconds: _pseudo_acceleration(record, seconds, damping_ratio), otypes=[float])(periods)


def _pseudo_acceleration(record: Record, period: float, damping_ratio: float) -> float:
    step = record.step
    fine = int(np.ceil(PER_PERIOD * step / period))  # points in place of each sample
    ground = np.concatenate([[0.0], record.ground_acceleration, np.zeros(int(np.ceil(period / step)) + 1)])
    displacement = Ramps.of(ground, step, fine).displacement(period, damping_ratio)
    return (2.0 * np.pi / period) ** 2 * float(np.abs(displacement).max())
