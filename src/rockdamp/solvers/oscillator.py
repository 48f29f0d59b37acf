r"""Linear oscillators under a load that is linear in time, exact: closed forms, and responses to records.

A ground acceleration that is linear between its samples is a sum of ramps: one begins at each sample, with the change
of slope there. An oscillator at rest answers a ramp of slope 1 with the absolute acceleration and the relative
displacement

.. math:: t - h(t), \qquad h(t) = \frac{e^{-\xi \omega t} \sin \omega_d t}{\omega_d}, \qquad
          \omega_d = \omega \sqrt{1 - \xi^2}

.. math:: -\frac{t}{\omega^2} + \frac{2 \xi}{\omega^3}
          - e^{-\xi \omega t} \left( \frac{2 \xi}{\omega^3} \cos \omega_d t
          + \frac{2 \xi^2 - 1}{\omega^2 \omega_d} \sin \omega_d t \right)

Sums of damped sines and cosines over the ramps are linear recursions.

A building's floors move by its modes. A mode lags behind the ground's acceleration. The modes that are not integrated
are rigid and do not; over all modes Gamma phi, participation factor times shape, sums to 1. So the absolute
acceleration of a floor is

.. math:: a_\mathrm{floor} = a_\mathrm{ground} - \sum_i \Gamma_i \varphi_i \, \mathrm{lag}_i
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from rockdamp.arrays import Array
from rockdamp.motions.records import Record
from rockdamp.solvers.compiled import compiled

POINTS = 10  # in the shortest period, at least: then lines between them lose 3 % of that mode's acceleration
# ASSUME: the free vibration of the building after the record is followed down to this part of itself.
LEFT = 0.05


# --- closed form: x'' + c x' + k x = q + slope t, k of either sign or zero --------------------------------------------


@register_jitable
def without_stiffness(c, t):
    """Return `responses` for k = 0: t^n phi_n(-c t), n = 1, 2, 3, of the exponential integrator's functions."""
    z = -c * t
    if abs(z) < 1.0:  # downwards from the series of the last, well conditioned to c = 0
        phi3 = term = 1.0 / 6.0
        for n in range(4, 22):
            term *= z / n
            phi3 += term
        phi2 = 0.5 + z * phi3
        phi1 = 1.0 + z * phi2
    else:
        phi1 = math.expm1(z) / z
        phi2 = (phi1 - 1.0) / z
        phi3 = (phi2 - 0.5) / z
    return t * phi1, t * t * phi2, t * t * t * phi3


@register_jitable
def responses(c, k, t):
    """Return the impulse response g of x'' + c x' + k x, and its first and second integrals from 0 to t."""
    if k == 0.0:
        return without_stiffness(c, t)
    half, disc = c / 2.0, c * c / 4.0 - k
    if disc < 0.0:
        w, decay = math.sqrt(-disc), math.exp(-half * t)
        g, even = decay * math.sin(w * t) / w, decay * math.cos(w * t)
    else:
        d = math.sqrt(disc)
        slow = math.exp(-k / (d + half) * t)  # the rate -half + d, without its cancellation
        g = -slow * math.expm1(-2.0 * d * t) / (2.0 * d) if d > 0.0 else slow * t
        even = slow * (1.0 + math.exp(-2.0 * d * t)) / 2.0
    first = (1.0 - even - half * g) / k  # g' = even - half g, and g' - 1 + c g + k first = 0
    return g, first, (t - c * first - g) / k


@register_jitable
def closed_state(x, v, c, k, q, slope, t):
    """Return the state at t of the motion from (x, v)."""
    # The acceleration solves the homogeneous equation: a (g' + c g) + jerk g, integrated once and twice.
    a = q - c * v - k * x
    jerk = slope - c * a - k * v
    g, g1, g2 = responses(c, k, t)
    return x + v * t + a * (g1 + c * g2) + jerk * g2, v + a * (g + c * g1) + jerk * g1


@register_jitable
def acceleration_zeros(x, v, c, k, q, slope):
    """Return the first zero of the acceleration after the start, and the time between two; infinite where none is."""
    a = q - c * v - k * x
    half, disc = c / 2.0, c * c / 4.0 - k
    b = slope - c * a - k * v + half * a  # exp(-half t) (a cos w t + b/w sin w t), or the same with cosh and sinh
    if a == 0.0 and b == 0.0:
        return np.inf, np.inf
    if disc < 0.0:
        w = math.sqrt(-disc)
        first = math.atan2(-a * w, b) % math.pi / w
        return first if first > 0.0 else math.pi / w, math.pi / w
    d = math.sqrt(disc)
    if a * b >= 0.0 or d * abs(a) >= abs(b):
        return np.inf, np.inf
    return math.atanh(-d * a / b) / d if d > 0.0 else -a / b, np.inf


@register_jitable
def closed_turn(x, v, c, k, q, slope, duration):
    """Return a stretch (from, to) in which the velocity first changes sign, and whether there is one by `duration`."""
    start, v_start = 0.0, v
    zero, spacing = acceleration_zeros(x, v, c, k, q, slope)
    while True:  # between zeros of the acceleration the velocity is monotone
        stop = min(zero, duration)
        v_stop = closed_state(x, v, c, k, q, slope, stop)[1]
        if v_start * v_stop < 0.0:
            return start, stop, True
        if stop >= duration:
            return duration, duration, False
        start, v_start, zero = stop, v_stop, zero + spacing


# --- responses to records ---------------------------------------------------------------------------------------------


def recursion(values, first, second, last, last_but_one):
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
    def from_samples(cls, acceleration: Array, step: float, finer: int) -> Ramps:
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


class FloorResponse(NamedTuple):
    """Motion of floors, sampled a whole number of times as often as the record.

    Attributes
    ----------
    step : float
        Time between samples. [s]
    acceleration : ndarray, shape (floors, samples)
        Absolute. [m s-2]
    displacement : ndarray, shape (floors, samples)
        Relative to the ground. [m]
    """

    step: float
    acceleration: Array
    displacement: Array


def floor_response(record: Record, period: Array, contribution: Array, damping_ratio: float) -> FloorResponse:
    """Return the motion of floors under a record, which begins with the record and ends after the free vibration.

    Parameters
    ----------
    record : Record
        ASSUME: the ground is at rest one step before the record and one step after it.
    period : ndarray, shape (modes,)
        Natural periods. [s]
    contribution : ndarray, shape (floors, modes)
        Participation factor times mode shape at each floor. [-]
    damping_ratio : float
        Of every mode. [-]
    """
    if not period.size:
        still = np.zeros((len(contribution), record.elapsed.size))
        return FloorResponse(record.step, still + record.ground_acceleration, still)
    step = record.step
    # A power of two, so that a small change of the building seldom changes the samples.
    finer = 2 ** max(int(np.ceil(np.log2(step * POINTS / period.min()))), 0)
    rest = np.log(1 / LEFT) / (2 * np.pi * damping_ratio) * period.max()
    ground = np.concatenate([[0.0], record.ground_acceleration, np.zeros(1 + int(np.ceil(rest / step)))])
    ramps = Ramps.from_samples(ground, step, finer)
    lag = np.stack([ramps.lag(seconds, damping_ratio) for seconds in period.tolist()])
    moved = np.stack([ramps.displacement(seconds, damping_ratio) for seconds in period.tolist()])
    acceleration = ramps.acceleration - contribution @ lag
    return FloorResponse(ramps.step, acceleration[:, finer:], (contribution @ moved)[:, finer:])
