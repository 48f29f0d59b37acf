"""Compiled closed forms of a linear oscillator, under a load that is linear in time and under a sampled motion."""

import math

import numpy as np
from numba.extending import register_jitable

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
    jerk = slope - c * a - k * v
    half, disc = c / 2.0, c * c / 4.0 - k
    b = jerk + half * a  # exp(-half t) (a cos w t + b/w sin w t), or the same with cosh and sinh
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


# --- sampled motions --------------------------------------------------------------------------------------------------


def recursion(values, first, second, last, last_but_one):
    """Return y_n = first x_n + second x_(n-1) + last y_(n-1) - last_but_one y_(n-2), which starts at rest."""
    sums = np.empty_like(values)
    carried = kept = 0.0
    for n in range(values.size):
        sums[n] = y = carried + first * values[n]
        carried = kept + second * values[n] + last * y
        kept = -last_but_one * y
    return sums
