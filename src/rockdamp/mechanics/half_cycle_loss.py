"""Closed forms of the energy that ECD and BAND take in a half cycle.

docs/theory.md derives those of ECD in sections 4, 7 and 8, and those of BAND in section 9.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array

# ASSUME: bound of kappa cos^(2m+1) phi sin phi of ECD, at the phase phi with tan^2 phi = V/T. From
# 1 on, half cycles would not end; near 1 the motion almost creeps, as if overdamped.
CAP = 0.95
# delta' of BAND. From 2 sqrt(3) = 3.46 on, the integrand of `half_cycle_loss` has a pole in a
# narrow band.
LARGEST_STRENGTH = 3.4


# --- ECD in closed form ---------------------------------------------------------------------------


def normalisation(order: ArrayLike) -> Array:
    r"""Return N_m, with which kappa = 2 xi N_m is the size of ECD of order m for xi = delta/pi. [-]

    .. math:: N_m = \frac{\pi/2}{\int_{-\pi/2}^{\pi/2} \cos^{2m+2}\varphi\,d\varphi}
              = \frac{\sqrt{\pi}}{2}\,\frac{\Gamma(m+2)}{\Gamma(m+3/2)}

    It is 1, 4/3 and 8/5 at orders 0, 1 and 2, and tends to sqrt(pi m)/2.

    Parameters
    ----------
    order : float or ndarray
        Order m, at least 0. [-]
    """
    orders = np.asarray(order, dtype=float)
    log_ratios = [math.lgamma(m + 2) - math.lgamma(m + 1.5) for m in orders.flat]
    ratios = [math.exp(log_ratio) for log_ratio in log_ratios]
    factors = math.sqrt(math.pi) / 2 * np.reshape(ratios, orders.shape)
    return np.where(orders == 0, 1.0, factors)


def critical_damping_ratio(order: ArrayLike) -> Array:
    r"""Return xi from which a half cycle does not end: the motion creeps to the origin. [-]

    There the largest kappa cos^(2m+1) phi sin phi, at tan^2 phi = 1/(2m+1), reaches 1:

    .. math:: \xi_c = \frac{\sqrt{2m+2}}{2 N_m}\left(\frac{2m+2}{2m+1}\right)^{m+1/2}

    It rises from 1 at order 0, as for the linear oscillator, to sqrt(2 exp(1)/pi) = 1.3155.

    Parameters
    ----------
    order : float or ndarray
        Order m, at least 0. [-]
    """
    m = np.asarray(order, dtype=float)
    power = np.exp((m + 0.5) * np.log1p(1 / (2 * m + 1)))
    return np.sqrt(2 * m + 2) / (2 * normalisation(m)) * power


# --- the strength of BAND -------------------------------------------------------------------------


def _gauss_rule(count: int) -> tuple[Array, Array]:
    """Return the positive nodes of Gauss's rule in (-1, 1), and their weights."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes[count // 2 :], weights[count // 2 :]


# Both rules give the strength of every width to rounding, within 1e-12 of 600 nodes: the coarse one
# up to delta = 1, the fine one up to the 4.6 of e = 0.01.
COARSE_RULE = _gauss_rule(24)
FINE_RULE = _gauss_rule(60)


def half_cycle_loss(strength: ArrayLike, width: ArrayLike) -> Array:
    r"""Return delta = -ln e of a half cycle that crosses x = 0 on the first branch under BAND. [-]

    .. math:: \delta = \int_{-t_c}^{t_c} \frac{G\,(1+t^2)^{-2}}{1 + G\,t/(1+t^2)}\,dt, \qquad
              G = \frac{3\delta'}{4 t_c}\left(1 - \frac{t^2}{t_c^2}\right)

    Parameters
    ----------
    strength : float or ndarray
        delta', from 0 to 3.4, broadcasts. [-]
    width : float or ndarray
        t_c, broadcasts. [rad]
    """
    terms = _loss_terms(np.asarray(width, dtype=float), FINE_RULE)
    loss, _ = _sum_loss(np.asarray(strength, dtype=float), terms)
    return loss


def band_strength(log_decrement: ArrayLike, width: ArrayLike) -> Array:
    """Return delta' with which a half cycle loses delta = -ln e, the inverse of `half_cycle_loss`.

    The short form delta (1 + 0.4 t_c^2 - 0.097 t_c^4 - 0.043 delta^2) is within 0.1 % of it for e
    from 0.5 to 1 and t_c up to 0.4.

    Parameters
    ----------
    log_decrement : float or ndarray
        delta, from 0 to that of delta' = 3.4, broadcasts. [-]
    width : float or ndarray
        t_c, broadcasts. [rad]
    """
    delta = np.asarray(log_decrement, dtype=float)
    delta, t_c = np.broadcast_arrays(delta, np.asarray(width, dtype=float))
    strength = np.empty(delta.shape)
    is_small = delta <= 1.0
    for rule, members in ((COARSE_RULE, is_small), (FINE_RULE, ~is_small)):
        if members.any():
            strength[members] = _invert_loss(delta[members], t_c[members], rule)
    return strength


def _invert_loss(delta: Array, t_c: Array, rule: tuple[Array, Array]) -> Array:
    """Return the strengths by Newton's method, each with the steps it would take alone."""
    terms = _loss_terms(t_c, rule)
    # The short form's first terms lie above the root. From there the steps fall to it, as the loss
    # is convex.
    strength = np.minimum(delta * (1 + 0.4 * t_c**2), LARGEST_STRENGTH)
    moves = np.ones(delta.shape, dtype=bool)
    while moves.any():
        loss, slope = _sum_loss(strength, terms)
        step = np.where(moves, (loss - delta) / slope, 0.0)
        strength = strength - step
        # The error after a step is as the square of the step: after 1e-8 it is that of rounding.
        moves = np.abs(step) > 1e-8 * strength
    return strength


def _loss_terms(t_c: Array, rule: tuple[Array, Array]) -> list[tuple[Array, Array]]:
    """Return pairs of b and w, with which delta is the sum of delta' w/(1 - (b delta')^2).

    The variable of integration is the phase theta, t = tan(theta), in which the integrand of a wide
    band is smooth. The two nodes at +theta and -theta have one pair.
    """
    edge = np.arctan(t_c)
    terms = []
    for node, weight in zip(*rule, strict=True):
        t = np.tan(edge * node)
        cosine_squared = 1 / (1 + t * t)
        g = 0.75 * (1 - (t / t_c) ** 2) / t_c  # G/delta'
        terms.append((g * t * cosine_squared, 2 * weight * edge * g * cosine_squared))
    return terms


def _sum_loss(strength: Array, terms: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    """Return delta and its derivative with respect to delta'."""
    total = np.zeros_like(strength)
    slope = np.zeros_like(strength)
    # Pair by pair: arrays of all pairs would not fit into the processor's cache.
    for b, w in terms:
        square = (strength * b) ** 2
        part = w / (1 - square)
        total = total + part
        slope = slope + part * (1 + square) / (1 - square)
    return strength * total, slope
