r"""Derivatives of one response: by its ground motion, in many directions at once, and by parameters of the wall.

Along the response, a small change of it is the solution of a linear equation of two states,

.. math:: \delta\ddot x + \partial_v h \, \delta\dot x + \partial_x h \, \delta x
    = \gamma \, \delta\ddot u_g - \partial_\theta h \, \delta\theta, \qquad h = f(x) + C(x, \dot x) \, \dot x

At an impact the state jumps. It happens earlier or later, by :math:`\delta t = -\delta x / \dot x^-`, so that

.. math:: \delta x^+ = e \, \delta x^-, \qquad
    \delta\dot x^+ = e \, \delta\dot x^- + (1 - e) \, \ddot x \, \delta x^- / \dot x^- + \dot x^- \, \delta e
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.damping.base import IMPACT
from rockdamp.solvers.newmark import solve

REACH = 6  # samples on either side; beyond, a spline through one sample differs from zero by less than 1e-3 of it
APART = 1e-6  # of u_ins and of the velocity: central differences of the damper's force
# Of the velocity that takes the wall through its first branch: slower impacts are of a wall at rest. The spline through
# a record without noise rings before the motion, at 1e-100 of it too, and the wall passes zero at each ring. Its time
# there would be the more sensitive the smaller the velocity, and the derivative would grow without end.
SLOWEST = 1e-6

Walled = tuple[TrilinearCurve, Damping]


def derivatives(
    wall: Walled,
    directions: Array,
    sides: Sequence[tuple[Walled, Walled, float]] = (),
    *,
    step: float,
    substeps: int,
    load_factor: float,
    ground_acceleration: Array,
) -> tuple[Array, Array]:
    """Return derivatives of a displacement over u_ins at the samples of a record: by the record, and by parameters.

    Shapes (directions, samples) and (parameters, samples). `directions`, shape (directions, samples), are changes of
    the ground acceleration [m s-2] at the samples, with a cubic spline between them. `sides` has of each parameter the
    wall with a little more of it, with a little less, and the difference. `substeps` are the solver's steps between two
    samples, and `ground_acceleration` [m s-2] is given at each of them. A wall that collapses raises `InputError`.
    """
    if wall[1].loss_depends_on_amplitude:
        raise InputError("derivatives of a response take a damper whose loss does not depend on the amplitude")
    ran = solve(
        *wall,
        step=step,
        steps=ground_acceleration.size - 1,
        load_factor=load_factor,
        ground_acceleration=ground_acceleration,
        store_every=1,
    )
    if ran.outcome.any():
        raise InputError("the wall collapses; derivatives are those of a response that does not end")
    x, v = ran.displacement.reshape(-1), ran.velocity.reshape(-1)
    over, impacts = _over_steps(*wall, x, v, step, load_factor * ground_acceleration)
    pushes = np.array([(_force(*less, x, v) - _force(*more, x, v)) / apart for more, less, apart in sides])
    jumps = np.zeros((len(sides), over.shape[0]))
    if wall[1].step_kind == IMPACT:
        changes = [(_restitution(more) - _restitution(less)) / apart for more, less, apart in sides]
        before = (v[impacts] + v[impacts + 1] / _restitution(wall)) / 2
        jumps[:, impacts] = np.outer(changes, before)
    samples = directions.shape[1]
    whole = _between_samples(over, step * load_factor, step * pushes.reshape(len(sides), x.size), jumps, substeps)
    padded = np.pad(directions, ((0, 0), (REACH - 1, REACH)))
    by_motion, by_parameters = np.zeros((2, len(directions))), np.zeros((2, len(sides)))
    moved, changed = np.zeros(directions.shape), np.zeros((len(sides), samples))
    for sample, (matrix, by_sample, pushed) in enumerate(zip(*whole, strict=True)):
        around = padded[:, sample : sample + 2 * REACH]
        by_motion = np.einsum("ij,jk->ik", matrix, by_motion) + np.einsum("io,ko->ik", by_sample, around)
        by_parameters = np.einsum("ij,jp->ip", matrix, by_parameters) + pushed
        moved[:, sample + 1], changed[:, sample + 1] = by_motion[0], by_parameters[0]
    return moved, changed


def _force(curve: TrilinearCurve, damping: Damping, x: Array, v: Array) -> Array:
    """Return the force of curve and damper. [-]"""
    return np.asarray(curve.force(x) + damping.coefficient(curve, x, v) * v)


def _restitution(wall: Walled) -> float:
    return float(np.asarray(wall[1].restitution))


def _over_steps(
    curve: TrilinearCurve, damping: Damping, x: Array, v: Array, step: float, load: Array
) -> tuple[Array, NDArray[np.intp]]:
    """Return matrices that take a small change of the state over each step, shape (steps, 2, 2), and the impacts."""
    rise, mean_x, mean_v = np.diff(x), (x[1:] + x[:-1]) / 2, (v[1:] + v[:-1]) / 2
    flat = np.abs(rise) < APART
    # The slope between the two ends holds a corner of the curve at its part of the step.
    slope = np.diff(curve.force(x)) / np.where(flat, 1.0, rise)
    stiffness = np.where(flat, curve.tangent(mean_x), slope)
    impacts = np.flatnonzero(x[1:] * x[:-1] < 0)
    if damping.step_kind != IMPACT:

        def damped(x: Array, v: Array) -> Array:
            return np.asarray(damping.coefficient(curve, x, v) * v)

        by_x = (damped(mean_x + APART, mean_v) - damped(mean_x - APART, mean_v)) / (2 * APART)
        by_v = (damped(mean_x, mean_v + APART) - damped(mean_x, mean_v - APART)) / (2 * APART)
        return _exponentials(stiffness + by_x, by_v, step), impacts
    over = _exponentials(stiffness, np.zeros_like(stiffness), step)
    e = _restitution((curve, damping))
    # Of a wall that is all but at rest the impacts follow the noise; its response is below any sensor's.
    fastest = float(np.asarray(curve.initial_frequency))
    slow = np.abs(v[impacts]) < SLOWEST * fastest * float(np.asarray(curve.yield_displacement_ratio))
    later = np.where(slow, 0.0, (1 - e) * load[impacts] / np.where(slow, 1.0, v[impacts]))
    later = np.clip(later, -fastest, fastest)
    jump = np.array([[np.full(impacts.size, e), np.zeros(impacts.size)], [later, np.full(impacts.size, e)]])
    over[impacts] = np.einsum("ijn,njk->nik", jump, over[impacts])
    return over, impacts


def _exponentials(stiffness: Array, damping: Array, step: float) -> Array:
    """Return exponentials of step times [[0, 1], [-stiffness, -damping]], shape (steps, 2, 2)."""
    half = damping / 2
    root = np.sqrt((half**2 - stiffness).astype(complex)) * step
    small = np.abs(root) < 1e-8
    sine = np.where(small, 1.0, np.sinh(root) / np.where(small, 1.0, root)).real * step
    cosine, decay = np.cosh(root).real, np.exp(-half * step)
    rows = [[cosine + half * sine, sine], [-stiffness * sine, cosine - half * sine]]
    return np.asarray(np.moveaxis(decay * np.array(rows), -1, 0))


def _between_samples(
    over: Array, impulse: float, pushes: Array, jumps: Array, substeps: int
) -> tuple[Array, Array, Array]:
    """Return the change from sample to sample by the state before, by the samples around, and by the parameters.

    Shapes (samples - 1, 2, 2), (samples - 1, 2, 2 REACH) and (samples - 1, 2, parameters). `pushes`, shape (parameters,
    steps + 1), act at steps, and `jumps`, shape (parameters, steps), at impacts.
    """
    around = np.arange(-3 * REACH, 3 * REACH + 1)
    cardinal = CubicSpline(around, (around == 0).astype(float))
    part = np.arange(substeps + 1)[:, None] / substeps
    away = part - np.arange(1 - REACH, REACH + 1)
    weight = np.where(np.abs(away) < REACH, cardinal(np.clip(away, -REACH, REACH)), 0.0)
    by_step = over.reshape(-1, substeps, 2, 2)
    count = len(by_step)
    matrix = np.broadcast_to(np.eye(2), (count, 2, 2))
    by_sample, pushed = np.zeros((count, 2, 2 * REACH)), np.zeros((count, 2, len(pushes)))
    for at in range(substeps):
        by_sample[:, 1] += impulse / 2 * weight[at]
        pushed[:, 1] += pushes[:, at:-1:substeps].T / 2
        matrix = np.einsum("nij,njk->nik", by_step[:, at], matrix)
        by_sample = np.einsum("nij,njo->nio", by_step[:, at], by_sample)
        pushed = np.einsum("nij,njp->nip", by_step[:, at], pushed)
        by_sample[:, 1] += impulse / 2 * weight[at + 1]
        pushed[:, 1] += pushes[:, at + 1 :: substeps].T / 2 + jumps[:, at::substeps].T
    return matrix, by_sample, pushed
