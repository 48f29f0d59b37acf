r"""The loss of a half cycle under the energy-consistent damper of order m, and the damping ratio that loses as e does.

The damper is C = w_E D(phi), w_E = abs(f)/sqrt(2V), D = A cos^(2m) phi, with sin^2 phi = V/(T+V) the stored fraction of
the energy and cos^2 phi = T/(T+V) the kinetic one; A = 2 xi N_m. Whatever the curve and the amplitude, a half cycle
multiplies sqrt(2V) by exp(-delta), with

.. math:: \delta(\xi; m) = \int_{-\pi/2}^{\pi/2} \frac{A \cos^{2m+2}\varphi}
          {1 - (A \sin\varphi \cos^{2m+1}\varphi)^2}\,d\varphi .

Derived in docs/theory.md, section 8. With sinh t = tan phi, the integrand is analytic and decays exponentially on the
whole line, for every real m >= 0, so the trapezoidal rule converges geometrically. At order 0 the integral is
pi xi/sqrt(1 - xi^2).
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arguments import kept, numbers
from rockdamp.arrays import Array
from rockdamp.errors import require

LARGEST_DECREMENT = -np.log(1e-6)  # poles near the real axis, at a distance like 1/delta, limit the rule's step
STEP, REACH = 0.025, 12.5  # in t sqrt(m + 1): the integrand is below 1e-16 of its middle from REACH on
NODES = np.arange(0.0, REACH, STEP)
WEIGHTS = np.where(NODES == 0, 1.0, 2.0) * STEP  # both sides: the integrand is even
SMALL_DECREMENT = 1e-8  # below, xi = delta/pi to rounding, since the next term is of the order of delta^3
# Gamma(w + 3/4)/Gamma(w + 1/4) = sqrt(w) exp(S), S = 1/64 w^-2 - 5/2048 w^-4 ... (DLMF 5.11.8, both at the middle w).
RATIO = (1 / 64, -5 / 2048, 61 / 49152, -1385 / 1048576, 50521 / 20971520)
SHIFT = 16  # of the order, by the recurrence of Gamma, before the series: what it leaves out is then below 1e-17
STEPS, CLOSE = 12, 1e-11  # of Newton, whose last step squares what the one before left


def normalisation(order: ArrayLike) -> Array:
    r"""Return N_m, which makes xi the damping ratio of small losses at every order: xi = delta/pi to first order. [-]

    .. math:: N_m = \frac{\pi/2}{\int_{-\pi/2}^{\pi/2} \cos^{2m+2}\varphi\,d\varphi}
              = \frac{\sqrt{\pi}}{2}\,\frac{\Gamma(m+2)}{\Gamma(m+3/2)}

    It is 1, 4/3 and 8/5 at orders 0, 1 and 2, and tends to sqrt(pi m)/2; exactly 1 at order 0, to 2e-15 elsewhere.
    """
    return of_order(check_order(order))


def of_order(m: Array) -> Array:
    """Return `normalisation` of orders that were checked."""
    return _normalisation(m) if m.ndim else _normalisation_of_one(float(m))


@lru_cache
def _normalisation_of_one(m: float) -> Array:
    return kept(np.asarray(_normalisation(np.array(m))))


def _normalisation(m: Array) -> Array:
    w = m + SHIFT + 1.25
    series = sum(term * w ** (-2.0 * power) for power, term in enumerate(RATIO, start=1))
    shifted = math.prod((m + k + 1.5) / (m + k + 2) for k in range(SHIFT))
    return np.where(m == 0, 1.0, math.sqrt(math.pi) / 2 * np.sqrt(w) * np.exp(series) * shifted)


def critical_damping_ratio(order: ArrayLike) -> Array:
    r"""Return xi from which a half cycle does not end: the motion creeps to the origin and never crosses it. [-]

    The denominator of the integral vanishes where A sin phi cos^(2m+1) phi = 1 at its largest, tan^2 phi = 1/(2m+1):

    .. math:: \xi_c = \frac{\sqrt{2m+2}}{2 N_m}\left(\frac{2m+2}{2m+1}\right)^{m+1/2}

    As xi tends to it the decrement tends to infinity: every e in (0, 1] has its damping ratio at every order. It rises
    from 1 at order 0, the linear oscillator's, to sqrt(2 exp(1)/pi) = 1.3155.
    """
    m = check_order(order)
    steepest = np.exp(-(m + 0.5) * np.log1p(1 / (2 * m + 1))) / np.sqrt(2 * m + 2)
    return 1 / (2 * normalisation(m) * steepest)


def log_decrement(damping_ratio: ArrayLike, order: ArrayLike = 0.0) -> Array:
    r"""Return delta = -ln e of a half cycle under ECD of order m, of any odd curve and from any amplitude, exact. [-]

    .. math:: \delta = \int_{-\pi/2}^{\pi/2} \frac{A \cos^{2m+2}\varphi}
              {1 - (A \sin\varphi \cos^{2m+1}\varphi)^2}\,d\varphi , \qquad A = 2 \xi N_m

    To 1e-14 of its value up to order 1000, for damping ratios below the critical one that keep at least e = 1e-6.
    """
    return _decrement_and_slope(np.asarray(damping_ratio, dtype=float), check_order(order))[0]


def damping_ratio(log_decrement: ArrayLike, order: ArrayLike = 0.0) -> Array:
    r"""Return xi with which ECD of order m loses delta = -ln e in every half cycle, the inverse of `log_decrement`. [-]

    On the branch that begins at xi = 0 and ends at `critical_damping_ratio`, on which delta grows from 0 without bound.
    At order 0 it is delta/sqrt(pi^2 + delta^2). In W = 1/xi^2 the curve of 1/delta^2 is a straight line at order 0 and
    nearly one at every order: Newton's steps in W, kept inside the bracket

    .. math:: \frac{\delta}{\sqrt{\pi^2+\delta^2}} \le \xi \le \min\left(\frac{\delta}{\pi}, \xi_c\right) .

    To 1e-14 of its value up to order 1000, for delta from 0 to 13.8 (e from 1 down to 1e-6).

    Examples
    --------
    >>> import numpy as np
    >>> from rockdamp.mechanics.half_cycle_loss import damping_ratio
    >>> damping_ratio(-np.log(0.5), [0, 1, 4, 8]).round(4)
    array([0.2155, 0.2166, 0.2171, 0.2173])
    """
    delta, m = np.broadcast_arrays(numbers("log_decrement (delta)", log_decrement), check_order(order))
    within = (delta >= 0) & (delta <= LARGEST_DECREMENT * (1 + 1e-12))
    require(within, "log_decrement (delta)", delta, "between 0 and 13.8 (e between 1e-6 and 1)")
    by_closed_form = delta / np.hypot(np.pi, delta)
    xi = np.where(m == 0, by_closed_form, delta / np.pi)
    solved = (m > 0) & (delta > SMALL_DECREMENT)
    # What depends on the order alone is computed once where there is one order.
    xi[solved] = _newton(delta[solved], m[solved] if np.ndim(order) else m.reshape(-1)[:1])
    return xi


def check_order(order: ArrayLike) -> Array:
    """Return m as an array of floats, or raise `InputError` unless it is at least 0."""
    m = numbers("order (m)", order)
    require(m >= 0, "order (m)", m, "at least 0")
    return m


def _decrement_and_slope(xi: Array, m: Array) -> tuple[Array, Array]:
    """Return delta(xi; m) and its derivative by xi, by the trapezoidal rule in t, tan phi = sinh t."""
    square = np.sinh(NODES / np.sqrt(m[..., None] + 1)) ** 2
    log_cos2 = -np.log1p(square)  # well conditioned at large m, where cos^2 is near 1
    scale = 2 * normalisation(m)
    numerator = scale[..., None] * np.exp((m[..., None] + 1.5) * log_cos2) * WEIGHTS / np.sqrt(m[..., None] + 1)
    share = (scale[..., None] ** 2) * (square * np.exp((2 * m[..., None] + 2) * log_cos2))  # (D sin cos)^2/xi^2
    by_xi = xi[..., None] ** 2 * share
    kernel = numerator / (1 - by_xi)
    return xi * kernel.sum(-1), (kernel * (1 + by_xi) / (1 - by_xi)).sum(-1)


def _newton(delta: Array, m: Array) -> Array:
    """Solve (pi/delta(xi))^2 = (pi/delta)^2 for W = 1/xi^2, from order 0's solution."""
    goal = (np.pi / delta) ** 2
    lowest, highest = np.maximum(goal, critical_damping_ratio(m) ** -2.0), goal + 1
    w = highest
    for _ in range(STEPS):
        xi = w**-0.5
        decrement, slope = _decrement_and_slope(xi, m)
        step = (goal - (np.pi / decrement) ** 2) / (np.pi**2 * (xi / decrement) ** 3 * slope)
        w = np.clip(w + step, 0.5 * (lowest + w), highest)
        if np.all(np.abs(step) <= CLOSE * w):
            break
    return np.asarray(w**-0.5)
