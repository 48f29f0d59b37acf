"""Walls that rock to one side, from one event to the next: exact, as the tri-linear curve is linear in pieces.

Under a load that is linear between its samples each piece of the motion has a closed form, and the moment at which it
ends is located to the last bits. At the stop, x = 0, the velocity is turned round, times e. A wall that bounces ever
lower while the load presses on it comes to rest, and rests until the load lifts it.

Dimensionless: x = u/u_ins, tau = p t, unit mass, forces over F0.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import ArrayLike

from rockdamp.arguments import number
from rockdamp.arrays import Array
from rockdamp.errors import require
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.solvers.compiled import compiled
from rockdamp.solvers.oscillator import closed_state, closed_turn
from rockdamp.solvers.response import COLLAPSED, COMPLETED, Response

# What a lane is: its curve, e, the factor on the ground's acceleration, the time between its samples, and the start.
K1, B1, KS, A1, A2, A3, E, FACTOR, STEP, X0, V0 = range(11)
# What its state is.
X, V, TAU, BRANCH, RESTING, PEAK, PEAK_AT, IMPACTS, EVENTS, STALLED = range(10)
STATES = 10
FIRST, PLATEAU, LAST, BEYOND = range(4)  # the branches
KINDS = ("turn", "impact", "rest", "lift")  # of events
TURN, IMPACT, REST, LIFT = range(4)
STILL = 1e-6  # speed after an impact, over p u_ins, below which a wall that is pressed on the stop rests
LIFTING = 1e-12  # load by which a wall at rest lifts
PATIENCE = 200  # pieces without progress before giving up
HALVINGS = 100  # of a stretch with an event: to the last bit
CLOSE = 4e-16  # of its length: two moments that are one
NO_PROGRESS = 2  # how a run ends, beside completed and collapsed
ROOM = 10_000  # for events


class History(NamedTuple):
    """One history: x at the times asked for, NaN after a collapse, its events, and how it ended.

    `events` has a row (tau, x, v before it, kind) for each of the first `ROOM`, in their order; `KINDS` names them.
    """

    displacement: Array
    events: Array
    ends: Response

    def of_kind(self, kind: str) -> Array:
        """Return the events of a kind: tau, x and v."""
        return self.events[self.events[:, 3] == KINDS.index(kind), :3]


def ends(
    curve: TrilinearCurve,
    restitution: float,
    *,
    load_factor: Array,
    ground_acceleration: Array,
    sampling: float,
    threads: int = 1,
) -> Response:
    """Solve each lane from rest at the stop, up to the last sample of the ground's acceleration.

    Parameters
    ----------
    curve : TrilinearCurve
    restitution : float
        e, greater than 0 and at most 1. [-]
    load_factor : ndarray, shape (lanes,)
        Makes the ground's acceleration the dimensionless load. [s2 m-1]
    ground_acceleration : ndarray, shape (samples,)
        Linear between its samples. [m s-2]
    sampling : float
        Time between two samples, in tau. [-]
    threads : int
    """
    lanes = _lanes(curve, restitution, load_factor, sampling)
    ended, ground = np.empty((len(lanes), 6)), np.array(ground_acceleration)
    end = np.array([sampling * (ground.size - 1)])

    def solve(part: slice) -> None:
        _compiled()(lanes[part], ground, end, np.empty((0, 1)), np.empty((0, 1, 4)), ended[part])

    with ThreadPoolExecutor(threads) as pool:
        edges = np.linspace(0, len(lanes), 4 * threads + 1).astype(int)
        list(pool.map(solve, map(slice, edges[:-1], edges[1:])))
    return _response(ended)


def history(
    curve: TrilinearCurve,
    restitution: float,
    times: ArrayLike,
    *,
    release_amplitude: float = 0.0,
    release_velocity: float = 0.0,
    load: ArrayLike = (),
    load_step: float = 0.0,
) -> History:
    """Solve one lane from tau = 0, and return it at ascending `times`, of which the last is its end.

    The dimensionless load is linear between samples that are `load_step` apart, and zero after the last. It raises
    `ArithmeticError` if the motion makes no progress, and `InputError` for a release that is not from 0 up to a3.
    """
    a3 = float(curve.ultimate_displacement_ratio)
    require(0 <= release_amplitude < a3, "release_amplitude", release_amplitude, f"at least 0 and less than a3, {a3:g}")
    lanes = _lanes(curve, restitution, np.ones(1), load_step, release_amplitude, release_velocity)
    at = np.array(times, dtype=float)
    displacement, events, ended = np.full((1, at.size), np.nan), np.empty((1, ROOM, 4)), np.empty((1, 6))
    _compiled()(lanes, np.array(load, dtype=float), at, displacement, events, ended)
    return History(displacement[0], events[0, : int(ended[0, 5])], _response(ended))


def _lanes(
    curve: TrilinearCurve, restitution: float, factor: Array, sampling: float, x: float = 0.0, v: float = 0.0
) -> Array:
    """Return a row of parameters for each lane."""
    e = number("restitution (e)", restitution)
    require(0 < e <= 1, "restitution (e)", e, "greater than 0 and at most 1")
    return np.stack(np.broadcast_arrays(*curve.parameters(), e, factor, sampling, x, v), axis=-1)


def _response(ended: Array) -> Response:
    stalled = np.flatnonzero(ended[:, 0] == NO_PROGRESS)
    if stalled.size:
        raise ArithmeticError(f"lane {stalled[0]}: no progress at tau = {ended[stalled[0], 1]:.9g}")
    outcome, end, peak, peak_at, impacts, _ = ended.T
    return Response(outcome.astype(np.int8), end, peak, peak_at, impacts.astype(np.int64))


@cache
def _compiled() -> Any:
    return compiled(run_lanes, run_lanes)


# --- one lane, compiled -----------------------------------------------------------------------------------------------


@register_jitable
def branch_of(w, s):
    """Return the ends of the lane's branch, and the stiffness and constant of its force."""
    if s[BRANCH] == FIRST:
        return 0.0, w[A1], w[K1], 0.0
    if s[BRANCH] == PLATEAU:
        return w[A1], w[A2], 0.0, w[B1]
    return w[A2], w[A3], -w[KS], w[KS] * w[A3]


@register_jitable
def root(x, v, k, q, slope, of_x, of_v, bound, sign_after, after):
    """Return the moment at which of_x x + of_v v - bound changes sign, once between 0 and `after`.

    By Newton's method, and by halves where that leaves the bracket.
    """
    low, high, at = 0.0, after, 0.5 * after
    for _ in range(HALVINGS):
        x_at, v_at = closed_state(x, v, 0.0, k, q, slope, at)
        value = of_x * x_at + of_v * v_at - bound
        if value * sign_after > 0.0:
            high = at
        else:
            low = at
        rate = of_x * v_at + of_v * (q + slope * at - k * x_at)
        following = at - value / rate if rate != 0.0 else low
        if not low < following < high:
            following = 0.5 * (low + high)
        if abs(following - at) <= CLOSE * high or value == 0.0:
            return following if value != 0.0 else at
        at = following
    return at


@register_jitable
def note(s, events, kind):
    """Note an event: tau, x, v and its kind."""
    count = int(s[EVENTS])
    if count < events.shape[0]:
        events[count, 0], events[count, 1], events[count, 2], events[count, 3] = s[TAU], s[X], s[V], kind
    s[EVENTS] += 1.0


@register_jitable
def begin(w):
    """Return the state at tau = 0."""
    s = np.zeros(STATES)
    x = w[X0]
    s[X], s[V], s[PEAK] = x, w[V0], x
    s[BRANCH] = FIRST if x < w[A1] else PLATEAU if x < w[A2] else LAST
    s[RESTING] = 1.0 if x == 0.0 and w[V0] == 0.0 else 0.0
    return s


@register_jitable
def rest(s, p, slope, stop, events):
    """Stay at rest to the end of the segment, or until the load lifts the wall."""
    wait = 0.0 if p > LIFTING else (LIFTING - p) / slope if slope > 0.0 else np.inf
    if s[TAU] + wait >= stop:
        s[TAU] = stop
    else:
        s[TAU] += wait
        s[RESTING] = 0.0
        note(s, events, LIFT)


@register_jitable
def move(w, s, p, slope, stop, times, displacement, reached, events):
    """Move over one piece: to the end of the segment, to the end of a branch or to a turn."""
    low, high, k, offset = branch_of(w, s)
    x, v, origin, q = s[X], s[V], s[TAU], p - offset
    remaining = stop - origin
    end, after, turns = closed_turn(x, v, 0.0, k, q, slope, remaining)
    if turns:
        way = closed_state(x, v, 0.0, k, q, slope, after)[1]
        end = root(x, v, k, q, slope, 0.0, 1.0, 0.0, way, after)
    x_end, v_end = closed_state(x, v, 0.0, k, q, slope, end)
    way, bound = 0, 0.0
    if x_end > high:
        way, bound = 1, high
    elif x_end < low:
        way, bound = -1, low
    if way != 0:
        end = root(x, v, k, q, slope, 1.0, 0.0, bound, way, end) if x != bound else 0.0
        x_end, v_end = closed_state(x, v, 0.0, k, q, slope, end)
    tau = stop if end == remaining else origin + end
    while reached < times.size and times[reached] <= tau:
        displacement[reached] = closed_state(x, v, 0.0, k, q, slope, times[reached] - origin)[0]
        reached += 1
    s[STALLED] = s[STALLED] + 1.0 if tau == origin else 0.0
    s[X], s[V], s[TAU] = x_end, v_end, tau
    if s[X] > s[PEAK]:
        s[PEAK], s[PEAK_AT] = s[X], tau
    if way != 0:
        s[X] = bound
        if bound == 0.0:
            hit(w, s, p + slope * end, events)
        else:
            s[BRANCH] += way
    elif turns:
        s[V] = 0.0  # to the last bit
        note(s, events, TURN)
    return reached


@register_jitable
def hit(w, s, p, events):
    """Turn the velocity round; a wall that bounces off with next to none while the load presses on it rests."""
    s[IMPACTS] += 1.0
    note(s, events, IMPACT)
    s[V] *= -w[E]
    if s[V] <= STILL and p <= LIFTING:
        s[V], s[RESTING] = 0.0, 1.0
        note(s, events, REST)


@register_jitable
def run(w, ground, times, displacement, events):
    """Move a lane from tau = 0 to the last of `times`, or to its collapse; return its state and how it ended."""
    s, reached, last, samples = begin(w), 0, times[-1], ground.size
    for segment in range(max(samples, 1)):
        start, stop, p, slope = max(samples - 1, 0) * w[STEP], last, 0.0, 0.0
        if segment < samples - 1:
            start, stop = segment * w[STEP], min((segment + 1) * w[STEP], last)
            p = w[FACTOR] * ground[segment]
            slope = (w[FACTOR] * ground[segment + 1] - p) / w[STEP]
        while s[TAU] < stop:
            now = p + slope * (s[TAU] - start)
            if s[RESTING] == 1.0:
                rest(s, now, slope, stop, events)
                while reached < times.size and times[reached] <= s[TAU]:
                    displacement[reached] = 0.0
                    reached += 1
            else:
                reached = move(w, s, now, slope, stop, times, displacement, reached, events)
                if s[BRANCH] >= BEYOND:
                    return s, COLLAPSED
                if s[STALLED] > PATIENCE:
                    return s, NO_PROGRESS
    return s, COMPLETED


def run_lanes(lanes, ground, times, displacement, events, ended):
    """Run lanes one after the other; `ended` has a row of how, tau, peak, its tau, impacts and events for each."""
    for i in range(lanes.shape[0]):
        stored = displacement.shape[0] > 0
        at, noted = (displacement[i], events[i]) if stored else (np.empty(times.size), np.empty((0, 4)))
        s, how = run(lanes[i], ground, times, at, noted)
        ended[i, 0], ended[i, 1], ended[i, 2] = how, s[TAU], s[PEAK]
        ended[i, 3], ended[i, 4], ended[i, 5] = s[PEAK_AT], s[IMPACTS], s[EVENTS]
