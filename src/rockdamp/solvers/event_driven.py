"""Event-driven reference solutions: no step of the kernel's is used here, so that each can be checked by the other.

The tri-linear law is linear on each branch. Where the damping coefficient is constant (CR and CDC everywhere, most
other dampers inside a1) a piece of the motion has a closed form under a load that is linear in time; elsewhere it is
integrated by DOP853 near rounding, with the damper's law, which is not the kernel's formula. Pieces end at the
branches' corners, at x = 0 and at the samples of the load, so the right-hand side is smooth in each. The motion itself
is compiled, in event_kernel.py.

Dimensionless as in the kernels: x = u/u_ins, tau = p t, unit mass.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers import event_kernel
from rockdamp.solvers.response import OUTCOMES

STALLED = 50  # pieces without progress before giving up: a state that balances on a corner to the last bit
AT_REST = 1e-12  # speed at x = 0 from which on the wall rests there, where the loss grows as the motion fades [u_ins p]
ROOM = 64  # for events; where they are more, it is doubled


@dataclass(frozen=True)
class ExactHistory:
    """One time history, at the times asked for; tau [-] and u/u_ins [-]."""

    times: Array
    displacement: Array  # NaN after a collapse
    velocity: Array  # by tau, after the impact where a time is an impact's
    impacts: Array  # tau of the crossings of u = 0, whatever the damper
    turning_tau: Array  # where the velocity changes sign after the release
    turning_displacement: Array  # the signed peaks of a free decay
    outcome: str  # of `OUTCOMES`
    outcome_tau: float  # of the end


def history(
    curve: TrilinearCurve,
    damping: Damping,
    times: ArrayLike,
    *,
    release_amplitude: float = 0.0,
    release_velocity: float = 0.0,
    load: ArrayLike = (),
    load_step: float | None = None,
) -> ExactHistory:
    """Solve x'' + C(x) x' + f(x) = load from tau = 0 for one wall and one damper, with Eq. (8) at each impact for CR.

    The history is given at `times` in tau, ascending from 0 or later; the last is the end of the run. The dimensionless
    load, `Wall.load_factor` times the ground acceleration, is linear between its samples, which are `load_step` apart
    in tau from 0 on, and zero after the last. It raises `ArithmeticError`, and says where, if the motion makes no
    progress or no step keeps its tolerance.
    """
    times, load = np.atleast_1d(np.asarray(times, dtype=float)), np.asarray(load, dtype=float)
    described = branches(curve, damping)
    x, v = float(release_amplitude), float(release_velocity)
    # From a corner the motion goes to the branch ahead, lest a start at x = 0 be an impact.
    corners = described[1:, event_kernel.LOW]
    at = int(np.searchsorted(corners, x, side="left" if v < 0 else "right"))
    displacement, velocity = np.full(times.shape, np.nan), np.full(times.shape, np.nan)
    displacement[times == 0.0], velocity[times == 0.0] = x, v
    ended, tau, x, impacts, turns = event_kernel.compiled_run(damping.law)(
        described,
        damping.law_parameters(curve),
        damping.is_impact,
        AT_REST if damping.loss_depends_on_amplitude else 0.0,
        float(damping.local_damping) if damping.on_net_force else -1.0,
        at,
        x,
        v,
        # The loop is compiled for arrays that can be written.
        np.array(load),
        float(load_step or 0.0),
        np.array(times),
        STALLED,
        displacement,
        velocity,
        np.empty((ROOM, 2)),
        np.empty((ROOM, 2)),
    )
    if ended == event_kernel.STALLED:
        raise ArithmeticError(f"no progress at tau = {tau:.9g}, x = {x:.9g}")
    if ended == event_kernel.FAILED:
        raise ArithmeticError(f"no step of DOP853 keeps its tolerance at tau = {tau:.9g}, x = {x:.9g}")
    outcome = OUTCOMES[int(ended == event_kernel.COLLAPSED)]
    turning_tau, turning_displacement = turns.T
    return ExactHistory(times, displacement, velocity, impacts[:, 0], turning_tau, turning_displacement, outcome, tau)


# --- the damper and the branches --------------------------------------------------------------------------------------


def branches(curve: TrilinearCurve, damping: Damping) -> Array:
    """Return the branches from -a3 to a3, split at x = 0, as `event_kernel` describes them, shape (6, DESCRIPTION)."""
    k1, b1, ks, a1, a2, a3 = (float(value) for value in curve.parameters())
    margin = a1 / 4  # a plateau that goes on inwards has energy down to a1/2
    rows: list[tuple[float, ...]] = []
    for index, (low, high, k, offset) in enumerate(((0.0, a1, k1, 0.0), (a1, a2, 0.0, b1), (a2, a3, -ks, ks * a3))):
        constant = _constant_coefficient(curve, damping, index)
        at_low = (low, k * low + offset, 2 * float(curve.energy(low)))
        shared = (constant, low - margin, b1 + ks * margin, *at_low)
        rows = [(-high, -low, k, -offset, *shared), *rows, (low, high, k, offset, *shared)]
    return np.array(rows)


def _constant_coefficient(curve: TrilinearCurve, damping: Damping, index: int) -> float:
    """Return C on the branch of number `index` from x = 0 where it is constant, else -1."""
    if damping.is_impact or damping.on_net_force:
        return 0.0
    k1 = float(curve.initial_stiffness)
    return 2 * math.sqrt(k1) * float(damping.damping_ratio) if index < damping.linear_branches else -1.0
