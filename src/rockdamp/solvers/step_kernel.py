"""The steps of one lane that `newmark_kernel` repeats: both schemes, for restitution, viscous and local damping.

A step takes the lane's state, its load at both ends, its curve (k1, b1, ks, a1, a2, a3) and its damper's parameters.
It returns displacement, velocity and acceleration at its end. Symbols and units are those of `newmark_kernel`.
"""

import numpy as np
from numba.extending import register_jitable

from rockdamp.mechanics import trilinear
from rockdamp.mechanics.trilinear import TINY

force = register_jitable(trilinear.force)
tangent = register_jitable(trilinear.tangent)
double_energy = register_jitable(trilinear.double_energy)


@register_jitable
def newmark_end(v, a, h, p, restoring, c):
    """Explicit Newmark (beta 0, gamma 1/2): velocity and acceleration at the end of a step, its displacement known."""
    half = v + 0.5 * h * a
    a = (p - restoring - c * half) / (1.0 + 0.5 * h * c)
    return half + 0.5 * h * a, a


@register_jitable
def linear_acceleration(v, a, h, dp, k, c):
    """Return increments of displacement and velocity by linear acceleration, stiffness and damping frozen in a step."""
    dx = (dp + 6.0 * v / h + 3.0 * a + c * (3.0 * v + 0.5 * h * a)) / (k + 3.0 * c / h + 6.0 / (h * h))
    return dx, 3.0 * dx / h - 3.0 * v - 0.5 * h * a


@register_jitable(fastmath=False)
def product(one, other):
    """Round a product before it enters a sum, alike in a vector of lanes and in a lane alone."""
    return one * other


@register_jitable
def moved(x, v, a, h):
    """Return the displacement after a step, or a part of one, at a constant acceleration."""
    return x + product(h, v + 0.5 * h * a)


@register_jitable
def impact_within(x, v, a, h):
    """Return the time from the start of the step to the root of x + v s + a s^2/2, known to lie in (0, h]."""
    away = v if x > 0.0 else -v
    root = np.sqrt(np.maximum(v * v - 2.0 * a * x, 0.0))
    return np.minimum(2.0 * np.abs(x) / np.maximum(root - away, TINY), h)


@register_jitable
def crossed(before, after):
    """Tell if a step has reached or passed x = 0. By signs, as the product underflows late in a decay."""
    return ((before > 0.0) & (after <= 0.0)) | ((before < 0.0) & (after >= 0.0))


@register_jitable
def odd(x, f):
    """Return f with the sign of x: the force of f(|x|), and of a velocity how fast the wall moves away from x = 0."""
    return -f if x < 0.0 else f


@register_jitable
def force_at(z, curve):
    """Return the force at z = |x|."""
    k1, b1, ks, _, _, a3 = curve
    return force(z, k1, b1, ks, a3)


@register_jitable
def tangent_at(z, curve):
    """Return the slope of the force."""
    k1, _, ks, a1, a2, a3 = curve
    return tangent(z, k1, ks, a1, a2, a3)


def formula(z, f, double_v, v, parameters):
    """Hold the place of a damper's formula."""
    raise NotImplementedError


def damped_at(z, v, curve, parameters):
    """Return force and coefficient at z = |x| and v away from x = 0. What the formula does not use costs nothing."""
    z = np.maximum(z, TINY)  # the formula may divide by it, or by the energy there
    f = force_at(z, curve)
    return f, formula(z, f, double_energy(z, *curve), v, parameters)


def constantly_damped_at(z, v, curve, parameters):
    """Return the same of a damper whose coefficient is constant; the maximum would cost it a tenth of its time."""
    return force_at(z, curve), formula(0.0, 0.0, 0.0, 0.0, parameters)


def restitution_located(x, v, a, h, start, end, curve, damper):
    """CR, Eq. (8), the impact located inside the step: Newmark up to it, the velocity times e, Newmark after it."""
    hit = crossed(x, moved(x, v, a, h))
    s = impact_within(x, v, a, h) if hit else 0.0
    # At the impact x = 0, so the restoring force vanishes and the acceleration is the load's alone.
    load = start + (end - start) * (s / h)
    v = v + 0.5 * s * (a + load) if hit else v
    v = damped_at(0.0, v, curve, damper)[1] * v if hit else v
    a = load if hit else a
    return between_impacts(0.0 if hit else x, v, a, h - s, start, end, curve, damper)


@register_jitable
def between_impacts(x, v, a, h, start, end, curve, damper):
    """CR without an impact: Newmark without damping."""
    x = moved(x, v, a, h)
    v, a = newmark_end(v, a, h, end, odd(x, force_at(np.abs(x), curve)), 0.0)
    return x, v, a


def restitution_printed(x, v, a, h, start, end, curve, damper):
    """CR as printed: linear acceleration without iteration, the velocity times e at the end of the step."""
    # ASSUME: the acceleration at the end of the step comes from the balance of forces there, not from the increment.
    dx, dv = linear_acceleration(v, a, h, end - start, tangent_at(np.abs(x), curve), 0.0)
    before, x, v = x, x + dx, v + dv
    v = damped_at(0.0, v, curve, damper)[1] * v if crossed(before, x) else v
    return x, v, end - odd(x, force_at(np.abs(x), curve))


def viscous_newmark(x, v, a, h, start, end, curve, damper):
    """Viscous damping by explicit Newmark.

    C is taken at the displacement at the end of the step and at the velocity v + h a that is expected there.
    """
    x = x + h * (v + 0.5 * h * a)
    f, c = damped_at(np.abs(x), odd(x, v + h * a), curve, damper)
    v, a = newmark_end(v, a, h, end, odd(x, f), c)
    return x, v, a


def viscous_printed(x, v, a, h, start, end, curve, damper):
    """Viscous damping as printed: C and the tangent frozen at the step's start, balance restored at its end."""
    _, c = damped_at(np.abs(x), odd(x, v), curve, damper)
    dx, dv = linear_acceleration(v, a, h, end - start, tangent_at(np.abs(x), curve), c)
    x, v = x + dx, v + dv
    f, c = damped_at(np.abs(x), odd(x, v), curve, damper)
    return x, v, end - odd(x, f) - c * v


@register_jitable
def reduced(g, alpha, v):
    """Return g - alpha |g| sgn(v), the acceleration under local damping; at rest the wall goes where g pulls it."""
    return g * (1.0 + alpha) if g * v < 0.0 else g * (1.0 - alpha)


def local_located(x, v, a, h, start, end, curve, damper):
    """Local damping by explicit Newmark, the turn located inside the step, where the acceleration jumps."""
    alpha = damper[0]
    turns = crossed(v, v + h * a)
    s = np.minimum(np.abs(v) / np.maximum(np.abs(a), TINY), h) if turns else 0.0
    x = moved(x, v, a, s)
    v = 0.0 if turns else v
    g = start + (end - start) * (s / h) - odd(x, force_at(np.abs(x), curve))
    a = reduced(g, alpha, 0.0) if turns else a
    h -= s
    x = moved(x, v, a, h)
    g = end - odd(x, force_at(np.abs(x), curve))
    ahead = v if v != 0.0 else a
    after = v + 0.5 * h * (a + reduced(g, alpha, ahead))
    return x, after, reduced(g, alpha, after if after != 0.0 else ahead)


def local_printed(x, v, a, h, start, end, curve, damper):
    """Local damping by linear acceleration, the tangent and the fraction of the force frozen in a step."""
    alpha, z = damper[0], np.abs(x)
    share = reduced(1.0, alpha, (start - odd(x, force_at(z, curve))) * v)
    dx, dv = linear_acceleration(v, a, h, share * (end - start), share * tangent_at(z, curve), 0.0)
    x, v = x + dx, v + dv
    return x, v, reduced(end - odd(x, force_at(np.abs(x), curve)), alpha, v)
