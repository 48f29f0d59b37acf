"""Event-driven reference solutions: no step of the kernel's is used here, so that each can be checked by the other.

The tri-linear law is linear on each branch. A piece of the motion stays on one branch, under a load that is linear in
time, and its velocity has one sign: pieces end at the branches' corners, at x = 0 and at the samples of the load, so
the right-hand side is smooth in each. Where the damping coefficient is constant (CR and CDC everywhere, most other
dampers inside a1) a piece has a closed form; elsewhere it is one step of DOP853 (Hairer, Norsett and Wanner, Solving
Ordinary Differential Equations I, 1993, section II.10) near rounding, with the damper's law, which is not the kernel's
formula. A moment inside a piece is reached from its start, by the closed form or by a step of that length: an event is
located by bisection, to the last bits of its time.

The compiler is free to reorder and to contract nothing. The functions from `coefficient` to `run` are compiled once for
each damper; `law` holds the place of the damper's.

Dimensionless as in the kernels: x = u/u_ins, tau = p t, unit mass.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numba.extending import register_jitable
from numpy.typing import ArrayLike
from scipy.integrate import DOP853

from rockdamp.arrays import Array
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.damping.base import IMPACT
from rockdamp.solvers.compiled import compiled, specialised
from rockdamp.solvers.oscillator import closed_state, closed_turn
from rockdamp.vocabulary import OUTCOMES

# DOP853's coefficients; the last two are of the estimates of a step's error, which look at the rates at its end too.
STAGES = DOP853.n_stages
A, B, C, E3, E5 = (np.ascontiguousarray(of) for of in (DOP853.A, DOP853.B, DOP853.C, DOP853.E3, DOP853.E5))
TOLERANCE = 1e-13  # relative, of a step; absolute it is a thousandth
GROWTH, SHRINKAGE, SAFETY = 10.0, 0.2, 0.9  # of the step, at most, and what it stays below the best
SMALLEST = 10 * np.finfo(float).eps  # of a step, over tau
LEAST = 1e-100  # |x| for a damper's law, which may divide by it or by the energy there
HALVINGS = 100  # of a stretch with an event, at most: to the last bit, or next to the start

# What describes a branch, for low <= x <= high: f = stiffness x + offset; C, or less than 0 where the law has it; how
# far inwards the law goes on smoothly, and the largest |f| so far; and |x|, |f| and 2V at the inner end.
DESCRIPTION = 10
LOW, HIGH, STIFFNESS, OFFSET, CONSTANT, INNERMOST, LARGEST_FORCE, INNER_END, INNER_FORCE, INNER_DOUBLE_V = range(10)

PATIENCE = 50  # pieces without progress before giving up: a state that balances on a corner to the last bit
AT_REST = 1e-12  # speed at x = 0 from which on the wall rests there, where the loss grows as the motion fades [u_ins p]
ROOM = 64  # for events; where they are more, it is doubled

COMPLETED, COLLAPSED, STALLED, FAILED = range(4)  # how a run ends

VELOCITY, ACCELERATION, DISPLACEMENT = range(3)  # what an event is a zero of


# --- a damper's law: steps of DOP853 ----------------------------------------------------------------------------------


def law(z, f, double_v, v, parameters):
    """Hold the place of a damper's law: C by |x|, |f|, 2V and the velocity away from x = 0."""
    raise NotImplementedError


def coefficient(branch, parameters, x, v):
    """Return C on a branch: a constant, or by the law."""
    if branch[CONSTANT] >= 0.0:
        return branch[CONSTANT]
    z = max(abs(x), LEAST)
    f = max(branch[STIFFNESS] * z + abs(branch[OFFSET]), 0.0)
    # 2V by the area of a trapezoid further than at the inner end.
    double_v = branch[INNER_DOUBLE_V] + (f + branch[INNER_FORCE]) * (z - branch[INNER_END])
    return law(z, f, double_v, v if x >= 0.0 else -v, parameters)


def acceleration(branch, parameters, p, x, v):
    """Return x'' on a branch under the load p."""
    return p - branch[STIFFNESS] * x - branch[OFFSET] - coefficient(branch, parameters, x, v) * v


def advance(branch, parameters, start, h, rates):
    """Take a step of DOP853 of the length h; the rates of its stages are left in `rates`, shape (2, STAGES + 1)."""
    x, v, p, slope = start
    for stage in range(STAGES):
        dx, dv = 0.0, 0.0
        for before in range(stage):
            dx += A[stage, before] * rates[0, before]
            dv += A[stage, before] * rates[1, before]
        rates[0, stage] = v + h * dv
        rates[1, stage] = acceleration(branch, parameters, p + slope * (C[stage] * h), x + h * dx, v + h * dv)
    dx, dv = 0.0, 0.0
    for stage in range(STAGES):
        dx += B[stage] * rates[0, stage]
        dv += B[stage] * rates[1, stage]
    return x + h * dx, v + h * dv


@register_jitable
def error_of(start, end, h, rates):
    """Return the estimated error of a step over what is allowed."""
    third, fifth = 0.0, 0.0
    # Squares are products: Numba compiles `**` of a whole exponent once for a process, with the liberties of what first
    # uses it. Code here has none, and the batched solver's steps of ECD of order m would be rounded otherwise.
    for row in range(2):
        scale = TOLERANCE * (1e-3 + max(abs(start[row]), abs(end[row])))
        of_third, of_fifth = 0.0, 0.0
        for stage in range(STAGES + 1):
            of_third += E3[stage] * rates[row, stage]
            of_fifth += E5[stage] * rates[row, stage]
        of_third, of_fifth = of_third / scale, of_fifth / scale
        third += of_third * of_third
        fifth += of_fifth * of_fifth
    if third == 0.0 and fifth == 0.0:
        return 0.0
    return h * fifth / math.sqrt(2.0 * (fifth + 0.01 * third))


@register_jitable
def longest_step(branch, start, remaining):
    """Return a step in which no stage leaves where the law is smooth: |x| falls by at most |v| h + pull h^2/2 in it."""
    x, v, p, slope = start
    reach, speed = abs(x) - branch[INNERMOST], abs(v)
    pull = branch[LARGEST_FORCE] + max(abs(p), abs(p + slope * remaining))
    return 2.0 * reach / (speed + math.sqrt(speed * speed + 2.0 * pull * reach))


def adaptive(branch, parameters, start, remaining, tau, wanted, rates):
    """Take a step that keeps the tolerance: its length (0 where none does), its end, and a good length for the next.

    The rates at its end stand last in `rates`.
    """
    h = min(wanted, longest_step(branch, start, remaining), remaining)
    rejected = False
    while True:
        end = advance(branch, parameters, start, h, rates)
        rates[0, STAGES] = end[1]
        rates[1, STAGES] = acceleration(branch, parameters, start[2] + start[3] * h, end[0], end[1])
        error = error_of(start, end, h, rates)
        if error < 1.0:
            growth = GROWTH if error == 0.0 else min(GROWTH, SAFETY * error**-0.125)
            growth = min(growth, 1.0) if rejected else growth
            return h, end, max(growth * h, wanted) if h == remaining else growth * h
        h *= max(SHRINKAGE, SAFETY * error**-0.125) if error < np.inf else SHRINKAGE
        rejected = True
        if not h > SMALLEST * tau:
            return 0.0, end, wanted


# --- events inside a piece --------------------------------------------------------------------------------------------


def state(branch, parameters, start, t, rates):
    """Return the state at a moment t of the piece from `start`."""
    if branch[CONSTANT] >= 0.0:
        x, v, p, slope = start
        return closed_state(x, v, branch[CONSTANT], branch[STIFFNESS], p - branch[OFFSET], slope, t)
    return advance(branch, parameters, start, t, rates)


def event(branch, parameters, start, zero_of, bound, sign_after, before, after, rates):
    """Return the last moment before `zero_of` less `bound` changes sign, known to do so once between two moments."""
    for _ in range(HALVINGS):
        middle = 0.5 * (before + after)
        if middle <= before or middle >= after:
            break
        x, v = state(branch, parameters, start, middle, rates)
        value = v if zero_of == VELOCITY else x
        if zero_of == ACCELERATION:
            value = acceleration(branch, parameters, start[2] + start[3] * middle, x, v)
        if (value - bound) * sign_after > 0.0:
            after = middle
        else:
            before = middle
    return before


def turn(branch, parameters, start, h, end, rates):
    """Return where a step of DOP853 first turns, and whether it does.

    A step near rounding is a small part of a cycle: its acceleration changes sign once at most.
    """
    a, a_end = rates[1, 0], rates[1, STAGES]
    v, v_end = start[1], end[1]
    way = v if v != 0.0 else a
    if way * v_end < 0.0:
        fastest = event(branch, parameters, start, ACCELERATION, 0.0, -way, 0.0, h, rates) if v == 0.0 else 0.0
        return event(branch, parameters, start, VELOCITY, 0.0, -way, fastest, h, rates), True
    if way * a < 0.0 and way * a_end > 0.0:  # slower and faster again: or was it back and forth?
        slowest = event(branch, parameters, start, ACCELERATION, 0.0, way, 0.0, h, rates)
        if way * state(branch, parameters, start, slowest, rates)[1] < 0.0:
            return event(branch, parameters, start, VELOCITY, 0.0, -way, 0.0, slowest, rates), True
    return h, False


def piece(branch, parameters, start, remaining, tau, wanted, rates):
    """Return the next piece: its length (0 where no step keeps the tolerance), whether it ends at a turn, a good length
    for the next step, and the state at its end."""
    c, k = branch[CONSTANT], branch[STIFFNESS]
    if c < 0.0:
        h, end, wanted = adaptive(branch, parameters, start, remaining, tau, wanted, rates)
        until, turns = turn(branch, parameters, start, h, end, rates)
        return until, turns, wanted, end if until == h else advance(branch, parameters, start, until, rates)
    x, v, p, slope = start
    before, after, turns = closed_turn(x, v, c, k, p - branch[OFFSET], slope, remaining)
    if turns:
        way = closed_state(x, v, c, k, p - branch[OFFSET], slope, after)[1]
        before = event(branch, parameters, start, VELOCITY, 0.0, way, before, after, rates)
    return before, turns, wanted, closed_state(x, v, c, k, p - branch[OFFSET], slope, before)


# --- the run ----------------------------------------------------------------------------------------------------------


@register_jitable
def appended(rows, count, first, second):
    """Return rows with one more of two numbers; they are moved to where there is room."""
    if count == rows.shape[0]:
        longer = np.empty((2 * count, 2))
        for row in range(count):  # Numba compiles an assignment of arrays with all that describes wrong shapes: seconds
            longer[row, 0], longer[row, 1] = rows[row, 0], rows[row, 1]
        rows = longer
    rows[count, 0] = first
    rows[count, 1] = second
    return rows


def run(
    branches,
    parameters,
    impact,
    rest,
    at,
    x,
    v,
    load,
    load_step,
    times,
    patience,
    displacement,
    velocity,
    impacts,
    turns,
):
    """Move from tau = 0 to the last of `times`, or to the collapse.

    Returns how it ended, tau, x, and the impacts and turns, each of shape (count, 2).

    Parameters
    ----------
    branches : ndarray, shape (branches, DESCRIPTION)
        From the left to the right; `at` is the one of the start.
    parameters : tuple of float
        The values that the law reads besides the state.
    impact : bool
        Whether the law is of an impact: the factor on the velocity at x = 0.
    rest : float
        Speed below which the wall stops where it crosses x = 0; a load sets it in motion again.
    load, load_step : ndarray and float
        Samples, linear between them and zero after the last, and their spacing.
    times, displacement, velocity : ndarray, shape (n,)
        Ascending moments, and room for the state at each that is reached.
    patience : int
        Pieces without progress before the run gives up.
    impacts, turns : ndarray, shape (room, 2)
        Room for tau and v of each crossing of x = 0, and for tau and x of each change of direction.
    """
    rates = np.zeros((2, STAGES + 1))
    crossings, changes, reached = 0, 0, 0
    tau, wanted, stalled = 0.0, np.inf, 0
    last, samples = times[-1], load.size
    for segment in range(max(samples, 1)):
        begin, stop, p, slope = max(samples - 1, 0) * load_step, last, 0.0, 0.0
        if segment < samples - 1:
            begin, stop = segment * load_step, min((segment + 1) * load_step, last)
            p, slope = load[segment], (load[segment + 1] - load[segment]) / load_step
        while tau < stop and 0 <= at < branches.shape[0]:
            branch, origin = branches[at], tau
            start = (x, v, p + slope * (origin - begin), slope)
            until = stop - origin
            end, turning, wanted, (x_end, v_end) = piece(branch, parameters, start, until, origin, wanted, rates)
            if end == 0.0 and not turning and branch[CONSTANT] < 0.0:
                return FAILED, tau, x, impacts[:crossings], turns[:changes]
            # The displacement is monotone in a piece, so no exit is missed. A start on a bound is an exit at once
            # if the motion goes out, and none if it goes in.
            way = 1 if x_end > branch[HIGH] else -1 if x_end < branch[LOW] else 0
            if way:
                bound = branch[HIGH] if way > 0 else branch[LOW]
                end = event(branch, parameters, start, DISPLACEMENT, bound, way, 0.0, end, rates) if x != bound else 0.0
                x_end, v_end = bound, state(branch, parameters, start, end, rates)[1]
            tau = stop if end == until else origin + end
            while reached > 0 and times[reached - 1] >= origin:  # after an impact, once more
                reached -= 1
            while reached < times.size and times[reached] <= tau:
                displacement[reached], velocity[reached] = state(
                    branch, parameters, start, times[reached] - origin, rates
                )
                reached += 1
            x, v, at = x_end, v_end, at + way
            if turning and not way:
                v = 0.0  # to the last bit: from there on, the hyperbolic branch does not amplify rounding
                turns = appended(turns, changes, tau, x)
                changes += 1
            if way and x == 0.0 and v != 0.0:
                impacts = appended(impacts, crossings, tau, v)
                crossings += 1
                v *= law(0.0, 0.0, 0.0, v, parameters) if impact else 1.0  # Eq. (8)
                v = v if abs(v) > rest else 0.0
            stalled = stalled + 1 if tau == origin else 0
            if stalled > patience:
                return STALLED, tau, x, impacts[:crossings], turns[:changes]
    ended = COMPLETED if 0 <= at < branches.shape[0] else COLLAPSED
    return ended, tau, x, impacts[:crossings], turns[:changes]


OF_A_LAW = (coefficient, acceleration, advance, adaptive, state, event, turn, piece, run)


@cache
def plain(law):
    """Return the functions of one damper's law by name, as Python runs them."""
    return specialised(OF_A_LAW, law.__qualname__, law=law)


@cache
def compiled_run(law):
    """Return the run with one damper's law, which is compiled when it is first called."""
    return compiled(plain(law)["run"], law)


# --- called from outside ----------------------------------------------------------------------------------------------


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
    corners = described[1:, LOW]
    at = int(np.searchsorted(corners, x, side="left" if v < 0 else "right"))
    displacement, velocity = np.full(times.shape, np.nan), np.full(times.shape, np.nan)
    displacement[times == 0.0], velocity[times == 0.0] = x, v
    ended, tau, x, impacts, turns = compiled_run(damping.law)(
        described,
        damping.law_parameters(curve),
        damping.step_kind == IMPACT,
        AT_REST if damping.loss_depends_on_amplitude else 0.0,
        at,
        x,
        v,
        # The loop is compiled for arrays that can be written.
        np.array(load),
        float(load_step or 0.0),
        np.array(times),
        PATIENCE,
        displacement,
        velocity,
        np.empty((ROOM, 2)),
        np.empty((ROOM, 2)),
    )
    if ended == STALLED:
        raise ArithmeticError(f"no progress at tau = {tau:.9g}, x = {x:.9g}")
    if ended == FAILED:
        raise ArithmeticError(f"no step of DOP853 keeps its tolerance at tau = {tau:.9g}, x = {x:.9g}")
    outcome = OUTCOMES[int(ended == COLLAPSED)]
    turning_tau, turning_displacement = turns.T
    return ExactHistory(times, displacement, velocity, impacts[:, 0], turning_tau, turning_displacement, outcome, tau)


# --- the damper and the branches --------------------------------------------------------------------------------------


def branches(curve: TrilinearCurve, damping: Damping) -> Array:
    """Return the branches from -a3 to a3, split at x = 0 and at the ends of CQD's band, shape (n, DESCRIPTION)."""
    k1, b1, ks, a1, a2, a3 = (float(value) for value in curve.parameters())
    margin = a1 / 4  # a plateau that goes on inwards has energy down to a1/2
    rows: list[tuple[float, ...]] = []
    shapes = [(0.0, a1, k1, 0.0), (a1, a2, 0.0, b1), (a2, a3, -ks, ks * a3)]
    constants = [_constant_coefficient(curve, damping, index) for index in range(3)]
    if damping.model == "CQD":  # nothing damps beyond +-w
        w = damping.law_parameters(curve)[1]
        shapes = [(0.0, w, k1, 0.0), (w, a1, k1, 0.0), *shapes[1:]]
        constants = [-1.0, 0.0, 0.0, 0.0]
    for constant, (low, high, k, offset) in zip(constants, shapes, strict=True):
        at_low = (low, k * low + offset, 2 * float(curve.energy(low)))
        shared = (constant, low - margin, b1 + ks * margin, *at_low)
        rows = [(-high, -low, k, -offset, *shared), *rows, (low, high, k, offset, *shared)]
    return np.array(rows)


def _constant_coefficient(curve: TrilinearCurve, damping: Damping, index: int) -> float:
    """Return C on the branch of number `index` from x = 0 where it is constant, else -1."""
    if damping.step_kind == IMPACT:
        return 0.0
    k1 = float(curve.initial_stiffness)
    return 2 * math.sqrt(k1) * float(damping.damping_ratio) if index < damping.linear_branches else -1.0
