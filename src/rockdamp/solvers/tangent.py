r"""The derivative of one response by its ground motion, for many directions of that at once.

Along the response, :math:`\delta\ddot x + \partial_v h \, \delta\dot x + \partial_x h \, \delta x = \gamma \,
\delta\ddot u_g` with :math:`h = f(x) + C(x, \dot x) \, \dot x` is linear, of two states. At an impact the state jumps:
it happens earlier or later, :math:`\delta t = -\delta x / \dot x^-`, so that :math:`\delta x^+ = e \, \delta x^-` and
:math:`\delta\dot x^+ = e \, \delta\dot x^- + (1 - e) \, \ddot x \, \delta x^- / \dot x^-`.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from rockdamp.arrays import Array
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import solve

REACH = 6  # samples on either side; beyond, a spline through one sample differs from zero by less than 1e-3 of it
APART = 1e-6  # of u_ins and of the velocity: central differences of the damper's force


def derivative_by_motion(
    curve: TrilinearCurve,
    damping: Damping,
    directions: Array,
    *,
    step: float,
    substeps: int,
    load_factor: float,
    ground_acceleration: Array,
) -> Array:
    """Return the derivative of a wall's displacement at the samples of a record by the record, in some directions.

    Parameters
    ----------
    curve, damping : TrilinearCurve, Damping
        Of one wall.
    directions : ndarray, shape (directions, samples)
        Changes of the ground acceleration at the samples, a cubic spline between them. [m s-2]
    step, load_factor : float
        As of `solve`, in tau [-] and [s2 m-1].
    substeps : int
        Steps of the solver between two samples.
    ground_acceleration : ndarray, shape (steps + 1,)
        At the solver's steps. [m s-2]

    Returns
    -------
    ndarray, shape (directions, samples)
        Over u_ins. [-]
    """
    ran = solve(
        curve,
        damping,
        step=step,
        steps=ground_acceleration.size - 1,
        load_factor=load_factor,
        ground_acceleration=ground_acceleration,
        store_every=1,
    )
    x, v = ran.displacement.reshape(-1), ran.velocity.reshape(-1)
    propagators = _propagators(curve, damping, x, v, step, load_factor * ground_acceleration)
    samples = directions.shape[1]
    over, by_sample = _between_samples(propagators.reshape(samples - 1, substeps, 2, 2), step * load_factor)
    padded = np.pad(directions, ((0, 0), (REACH - 1, REACH)))
    state, moved = np.zeros((2, len(directions))), np.zeros(directions.shape)
    for sample in range(samples - 1):
        around = padded[:, sample : sample + 2 * REACH]
        state = np.einsum("ij,jk->ik", over[sample], state) + np.einsum("io,ko->ik", by_sample[sample], around)
        moved[:, sample + 1] = state[0]
    return moved


def _propagators(curve: TrilinearCurve, damping: Damping, x: Array, v: Array, step: float, load: Array) -> Array:
    """Matrices that take a small change of displacement and velocity over each step, shape (steps, 2, 2)."""
    rise, mean_x, mean_v = np.diff(x), (x[1:] + x[:-1]) / 2, (v[1:] + v[:-1]) / 2
    flat = np.abs(rise) < APART
    # The slope between the two ends holds a corner of the curve at its part of the step.
    slope = np.diff(curve.force(x)) / np.where(flat, 1.0, rise)
    stiffness = np.where(flat, curve.tangent(mean_x), slope)

    def damped(x: Array, v: Array) -> Array:
        return damping.coefficient(curve, x, v) * v

    if damping.is_impact:
        by_x = by_v = np.zeros_like(mean_x)
    else:
        by_x = (damped(mean_x + APART, mean_v) - damped(mean_x - APART, mean_v)) / (2 * APART)
        by_v = (damped(mean_x, mean_v + APART) - damped(mean_x, mean_v - APART)) / (2 * APART)
    over = _exponentials(stiffness + by_x, by_v, step)
    if damping.is_impact:
        at = np.flatnonzero(x[1:] * x[:-1] < 0)
        e = float(np.asarray(damping.restitution))
        # Of a wall that is all but at rest the impacts follow the noise; its response is below any sensor's.
        fastest = float(np.asarray(curve.initial_frequency))
        later = np.clip((1 - e) * load[at] / np.where(v[at] == 0, np.inf, v[at]), -fastest, fastest)
        jump = np.array([[np.full(at.size, e), np.zeros(at.size)], [later, np.full(at.size, e)]])
        over[at] = np.einsum("ijn,njk->nik", jump, over[at])
    return over


def _exponentials(stiffness: Array, damping: Array, step: float) -> Array:
    """Exponentials of step times [[0, 1], [-stiffness, -damping]], shape (steps, 2, 2)."""
    half = damping / 2
    root = np.sqrt((half**2 - stiffness).astype(complex)) * step
    small = np.abs(root) < 1e-8
    sine = np.where(small, 1.0, np.sinh(root) / np.where(small, 1.0, root)).real * step
    cosine, decay = np.cosh(root).real, np.exp(-half * step)
    rows = [[cosine + half * sine, sine], [-stiffness * sine, cosine - half * sine]]
    return np.asarray(np.moveaxis(decay * np.array(rows), -1, 0))


def _between_samples(propagators: Array, impulse: float) -> tuple[Array, Array]:
    """Propagators over each sample, shape (samples - 1, 2, 2), and by the samples around, (samples - 1, 2, 2 REACH)."""
    intervals, substeps = propagators.shape[:2]
    around = np.arange(-3 * REACH, 3 * REACH + 1)
    cardinal = CubicSpline(around, (around == 0).astype(float))
    part = np.arange(substeps + 1)[:, None] / substeps
    away = part - np.arange(1 - REACH, REACH + 1)
    weight = np.where(np.abs(away) < REACH, cardinal(np.clip(away, -REACH, REACH)), 0.0)
    over = np.broadcast_to(np.eye(2), (intervals, 2, 2))
    by_sample = np.zeros((intervals, 2, 2 * REACH))
    for at in range(substeps):
        by_sample[:, 1] += impulse / 2 * weight[at]
        over = np.einsum("nij,njk->nik", propagators[:, at], over)
        by_sample = np.einsum("nij,njo->nio", propagators[:, at], by_sample)
        by_sample[:, 1] += impulse / 2 * weight[at + 1]
    return over, by_sample
