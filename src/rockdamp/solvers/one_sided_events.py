"""Event-driven reference for walls that rock to one side: exact, from one event to the next.

The force is linear in pieces: the branches of the curve, the tie slack, elastic, yielding or broken, the stop. Under a
load that is linear between its samples each piece of the motion has a closed form, and the moment at which it ends is
located to the last bits. At a rigid stop the velocity is turned round, times e; a wall that bounces ever
lower while the load presses on it comes to rest, and rests until the load lifts it. Nothing here is the stepper's.

Dimensionless: x = u/u_ins, tau = p t, unit mass, forces over F0.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numba.extending import register_jitable
from numpy.typing import ArrayLike

from rockdamp.arguments import finite
from rockdamp.arrays import Array
from rockdamp.errors import require
from rockdamp.mechanics.one_sided import OneSidedForce, Stop
from rockdamp.solvers.compiled import compiled
from rockdamp.solvers.oscillator import closed_state, closed_turn, free_zeros, responses
from rockdamp.vocabulary import OUTCOMES

# A row for each lane: what `OneSidedForce.parameters` says, then the stop, the load and the start.
SLOPE, INITIAL, B1, KS, A1, A2, A3, KT, FT, GAP, RUPTURE, KC, C, PULLS, E, FACTOR, STEP, X0, V0 = range(19)
# What a lane's state holds beside its parameters. SLACK is the x from which on the tie pulls: its gap and its set.
X, V, TAU, BRANCH, TIE, SLACK, RESTING, PARTED, PEAK, PEAK_AT, IMPACTS, EVENTS, STALLED = range(13)
STATES = 13
LOOSE, ELASTIC, YIELDING, BROKEN = range(4)  # the tie
STOP, FIRST, PLATEAU, LAST, BEYOND = range(-1, 4)  # the branches
STILL = 1e-6  # speed after an impact, over p u_ins, below which a wall that is pressed on the stop rests
LIFTING = 1e-12  # of the load beyond what holds it, by which a wall at rest lifts
PATIENCE = 200  # pieces without progress before giving up
HALVINGS = 100  # of a stretch with an event: to the last bit
CLOSE = 4e-16  # of its length: two moments that are one
COMPLETED, COLLAPSED, NO_PROGRESS = range(3)
ROOM = 256  # for events; where they are more, it is doubled


@dataclass(frozen=True)
class Ends:
    """How lanes end: outcome (0 completed, 1 collapsed) and its tau, peak of x >= 0 and its tau, impacts; by lane."""

    outcome: Array
    outcome_tau: Array
    peak: Array
    peak_tau: Array
    impacts: Array


@dataclass(frozen=True)
class History:
    """One history: x and its derivative at the times asked for, NaN after a collapse, and the events.

    `events` has a row (tau, x, v before it, kind) for each, in their order; `KINDS` names them.
    """

    times: Array
    displacement: Array
    velocity: Array
    events: Array
    outcome: str
    outcome_tau: float

    def of_kind(self, kind: str) -> Array:
        """Return the events of a kind: tau, x and v."""
        return self.events[self.events[:, 3] == KINDS.index(kind), :3]


KINDS = ("turn", "impact", "rest", "lift")


def ends(
    force: OneSidedForce,
    stop: Stop,
    *,
    load_factor: ArrayLike,
    ground_acceleration: ArrayLike,
    sampling: ArrayLike,
    duration: ArrayLike,
    threads: int = 1,
) -> Ends:
    """Solve each lane from rest at the stop; what has values by lane broadcasts together.

    Parameters
    ----------
    force, stop : OneSidedForce, Stop
    load_factor : float or ndarray
        Makes the ground's acceleration the dimensionless load. [s2 m-1]
    ground_acceleration : ndarray, shape (samples,)
        Linear between its samples, zero after the last. [m s-2]
    sampling, duration : float or ndarray
        Between two samples, and of the whole, in tau. [-]
    threads : int

    Returns
    -------
    Ends
        Peaks are of x >= 0.
    """
    lanes, shape = _lanes(force, stop, load_factor, sampling, duration=duration)
    ended, ground = np.empty((len(lanes), 6)), np.array(ground_acceleration, dtype=float)
    times = np.array(np.broadcast_to(duration, shape), dtype=float).reshape(-1, 1)
    loop, none = _compiled(), np.empty((0, 1))

    def through(part: slice) -> None:
        loop(lanes[part], ground, times[part], none, none, np.empty((0, 1, 4)), ended[part])

    with ThreadPoolExecutor(threads) as pool:
        edges = np.linspace(0, len(lanes), 4 * threads + 1).astype(int)
        list(pool.map(through, map(slice, edges[:-1], edges[1:])))
    _require_progress(ended)
    return Ends(*(column.reshape(shape) for column in ended.T[:5]))


def history(
    force: OneSidedForce,
    stop: Stop,
    times: ArrayLike,
    *,
    release_amplitude: float = 0.0,
    release_velocity: float = 0.0,
    load: ArrayLike = (),
    load_step: float = 0.0,
) -> History:
    """Solve one lane from tau = 0, and return it at ascending `times`, of which the last is its end.

    The dimensionless load is linear between samples that are `load_step` apart, and zero after the last. It raises
    `ArithmeticError` if the motion makes no progress, and `InputError` for a release beyond a3 or a rigid stop.
    """
    at = np.atleast_1d(np.array(times, dtype=float))
    a3, least = float(force.curve.ultimate_displacement_ratio), 0.0 if np.isinf(stop.stiffness) else -np.inf
    allowed = f"less than a3, {a3:g}, and at least 0 at a rigid stop"
    require(least <= release_amplitude < a3, "release_amplitude", release_amplitude, allowed)
    lanes, _ = _lanes(force, stop, 1.0, load_step, release_amplitude, release_velocity)
    room, ended = ROOM, np.empty((1, 6))
    while True:
        displacement, velocity = np.full((2, 1, at.size), np.nan)
        events = np.empty((1, room, 4))
        _compiled()(lanes, np.array(load, dtype=float), at[None], displacement, velocity, events, ended)
        _require_progress(ended)
        count = int(ended[0, 5])
        if count <= room:
            break
        room = 2 * count
    outcome = OUTCOMES[int(ended[0, 0])]
    return History(at, displacement[0], velocity[0], events[0, :count], outcome, float(ended[0, 1]))


def _lanes(
    force: OneSidedForce,
    stop: Stop,
    factor: ArrayLike,
    sampling: ArrayLike,
    x: ArrayLike = 0.0,
    v: ArrayLike = 0.0,
    duration: ArrayLike = 0.0,
) -> tuple[Array, tuple[int, ...]]:
    """Return a row of parameters for each lane, and the shape that they broadcast to."""
    damper = (stop.stiffness, stop.coefficient, float(stop.pulls), stop.restitution)
    start = (finite("release_amplitude", x), finite("release_velocity", v))
    values = [*force.parameters(), *damper, factor, sampling, *start]
    *columns, last = np.broadcast_arrays(*values, duration)
    return np.stack([np.ravel(column) for column in columns], axis=-1), last.shape


def _require_progress(ended: Array) -> None:
    stalled = np.flatnonzero(ended[:, 0] == NO_PROGRESS)
    if stalled.size:
        raise ArithmeticError(f"lane {stalled[0]}: no progress at tau = {ended[stalled[0], 1]:.9g}")


@cache
def _compiled() -> Any:
    return compiled(run_lanes, run_lanes)


# --- one lane, compiled -----------------------------------------------------------------------------------------------


@register_jitable
def branch_of(w, s):
    """Return C, stiffness and constant of the force where the lane is."""
    k, offset, c = 0.0, w[INITIAL], 0.0
    at = s[BRANCH]
    if at == STOP:
        if s[PARTED] == 0.0:
            k, c = w[KC], w[C]
    elif at == FIRST:
        k = w[SLOPE]
    elif at == PLATEAU:
        offset = w[B1]
    else:
        k, offset = -w[KS], w[KS] * w[A3]
    if s[TIE] == ELASTIC:
        k, offset = k + w[KT], offset - w[KT] * s[SLACK]
    elif s[TIE] == YIELDING:
        offset += w[FT]
    return c, k, offset


@register_jitable
def bounds_of(w, s):
    """Return the displacements between which the force stays as it is."""
    at = s[BRANCH]
    low = -np.inf if at == STOP else 0.0 if at == FIRST else w[A1] if at == PLATEAU else w[A2]
    high = 0.0 if at == STOP else w[A1] if at == FIRST else w[A2] if at == PLATEAU else w[A3]
    tie = s[TIE]
    if tie == LOOSE:
        high = min(high, s[SLACK])
    elif tie == ELASTIC:
        low, high = max(low, s[SLACK]), min(high, s[SLACK] + w[FT] / w[KT], w[GAP] + w[RUPTURE])
    elif tie == YIELDING:
        high = min(high, w[GAP] + w[RUPTURE])
    return low, high


@register_jitable
def root(x, v, c, k, q, slope, of_x, of_v, bound, sign_after, after):
    """Return the moment at which of_x x + of_v v - bound changes sign, once between 0 and `after`.

    By Newton's method, and by halves where that leaves the bracket.
    """
    low, high, at = 0.0, after, 0.5 * after
    for _ in range(HALVINGS):
        x_at, v_at = closed_state(x, v, c, k, q, slope, at)
        value = of_x * x_at + of_v * v_at - bound
        if value * sign_after > 0.0:
            high = at
        else:
            low = at
        rate = of_x * v_at + of_v * (q + slope * at - c * v_at - k * x_at)
        following = at - value / rate if rate != 0.0 else low
        if not low < following < high:
            following = 0.5 * (low + high)
        if abs(following - at) <= CLOSE * high or value == 0.0:
            return following if value != 0.0 else at
        at = following
    return at


@register_jitable
def pressing(w, x, v, c, k, q, slope, t):
    """Return the force of spring and dashpot at the stop at t, and its rate."""
    x_at, v_at = closed_state(x, v, c, k, q, slope, t)
    return w[KC] * x_at + w[C] * v_at, w[KC] * v_at + w[C] * (q + slope * t - c * v_at - k * x_at)


@register_jitable
def just_after(w, x, v, c, k, q, slope, of, sign, before, after):
    """Return the moment just after the stop's force (`of` 0) or its rate (1) has got a sign, once in this stretch."""
    for _ in range(HALVINGS):
        middle = 0.5 * (before + after)
        if middle <= before or middle >= after:
            break
        if pressing(w, x, v, c, k, q, slope, middle)[of] * sign > 0.0:
            after = middle
        else:
            before = middle
    return after


@register_jitable
def parting(w, x, v, c, k, q, slope, sign, duration):
    """Return the moment just after the stop's force first has a sign; infinite where it has not by `duration`.

    Its second derivative is a free motion: between two zeros of that the rate is monotone, and between two zeros of the
    rate the force is.
    """
    a = q - c * v - k * x
    jerk = slope - c * a - k * v
    zero, spacing = free_zeros(w[KC] * a + w[C] * jerk, w[KC] * jerk - w[C] * (c * jerk + k * a), c, k)
    start, rate = 0.0, pressing(w, x, v, c, k, q, slope, 0.0)[1]
    while start < duration:
        stop = min(zero, duration)
        rate_stop = pressing(w, x, v, c, k, q, slope, stop)[1]
        extreme = just_after(w, x, v, c, k, q, slope, 1, rate_stop, start, stop) if rate * rate_stop < 0.0 else stop
        for end in (extreme, stop):
            if pressing(w, x, v, c, k, q, slope, end)[0] * sign > 0.0:
                return just_after(w, x, v, c, k, q, slope, 0, sign, start, end)
            start = end
        rate, zero = rate_stop, zero + spacing
    return np.inf


@register_jitable
def note(s, events, kind):
    """Note an event: tau, x, v, and whether it is an impact (1), a turn (0), the coming to rest (2) or lifting (3)."""
    count = int(s[EVENTS])
    if count < events.shape[0]:
        events[count, 0], events[count, 1], events[count, 2], events[count, 3] = s[TAU], s[X], s[V], kind
    s[EVENTS] += 1.0


@register_jitable
def cross(w, s, bound, way, events):
    """Move on at a bound, to the next branch or tie state or through an impact; return whether it is an impact."""
    s[X] = bound
    if s[TIE] == LOOSE and way > 0 and bound == s[SLACK]:
        s[TIE] = ELASTIC
    elif s[TIE] == ELASTIC and way < 0 and bound == s[SLACK]:
        s[TIE] = LOOSE  # at the stop too, where a tie without slack ends: the impact is the next event
    elif (s[TIE] == ELASTIC or s[TIE] == YIELDING) and way > 0 and bound == w[GAP] + w[RUPTURE]:
        s[TIE] = BROKEN
    elif s[TIE] == ELASTIC and way > 0 and bound == s[SLACK] + w[FT] / w[KT]:
        s[TIE] = YIELDING
    elif bound == 0.0 and way < 0:
        s[IMPACTS] += 1.0
        note(s, events, 1.0)
        if w[KC] == np.inf:
            s[V] *= -w[E]
        else:
            s[BRANCH] = STOP
        return True
    else:
        s[BRANCH] += way
        s[PARTED] = 0.0
    return False


@register_jitable
def write(times, displacement, velocity, reached, tau, origin, x, v, c, k, q, slope):
    """Store the motion at the times up to tau, and return how many are stored."""
    while reached < times.size and times[reached] <= tau:
        displacement[reached], velocity[reached] = closed_state(x, v, c, k, q, slope, times[reached] - origin)
        reached += 1
    return reached


@register_jitable
def begin(w):
    """Return the state at tau = 0: a wall away from the stop has stretched its tie once."""
    s = np.zeros(STATES)
    x = w[X0]
    s[X], s[V], s[PEAK] = x, w[V0], max(x, 0.0)
    s[BRANCH] = STOP if x < 0.0 else FIRST if x < w[A1] else PLATEAU if x < w[A2] else LAST
    s[RESTING] = 1.0 if x == 0.0 and w[V0] == 0.0 and w[KC] == np.inf else 0.0
    s[SLACK], s[TIE] = w[GAP], LOOSE
    if w[KT] <= 0.0 or x > w[GAP] + w[RUPTURE]:
        s[TIE] = BROKEN
    elif x > w[GAP]:
        s[TIE], s[SLACK] = ELASTIC, max(w[GAP], x - w[FT] / w[KT])
    return s


@register_jitable
def rest(w, s, p, slope, stop, events):
    """Stay at rest to the end of the segment, or until the load lifts the wall."""
    holding = w[INITIAL] + LIFTING * (1.0 + w[INITIAL])
    wait = 0.0 if p > holding else (holding - p) / slope if slope > 0.0 else np.inf
    if s[TAU] + wait >= stop:
        s[TAU] = stop
    else:
        s[TAU] += wait
        s[RESTING] = 0.0
        note(s, events, 3.0)


@register_jitable
def move(w, s, p, slope, stop, times, displacement, velocity, reached, events):
    """Move over one piece: to the end of the segment, to a bound, to a turn, or to where the wall parts or settles."""
    c, k, offset = branch_of(w, s)
    low, high = bounds_of(w, s)
    x, v, origin, q = s[X], s[V], s[TAU], p - offset
    remaining = stop - origin
    end, after, turns = closed_turn(x, v, c, k, q, slope, remaining)
    if turns:
        way = closed_state(x, v, c, k, q, slope, after)[1]
        end = root(x, v, c, k, q, slope, 0.0, 1.0, 0.0, way, after)
    x_end, v_end = closed_state(x, v, c, k, q, slope, end)
    way, bound = 0, 0.0
    if x_end > high:
        way, bound = 1, high
    elif x_end < low:
        way, bound = -1, low
    if way != 0:
        end = root(x, v, c, k, q, slope, 1.0, 0.0, bound, way, end) if x != bound else 0.0
        x_end, v_end = closed_state(x, v, c, k, q, slope, end)
        turns = False
    if s[BRANCH] == STOP and w[PULLS] == 0.0:
        changed = parting(w, x, v, c, k, q, slope, 1.0 - 2.0 * s[PARTED], end)
        if changed <= end:  # it parts, or meets the stop again; just after, so that the next piece begins without
            end = changed
            x_end, v_end = closed_state(x, v, c, k, q, slope, end)
            s[PARTED] = 1.0 - s[PARTED]
            way, turns = 0, False
    tau = stop if end == remaining else origin + end
    reached = write(times, displacement, velocity, reached, tau, origin, x, v, c, k, q, slope)
    s[STALLED] = s[STALLED] + 1.0 if tau == origin else 0.0
    s[X], s[V], s[TAU] = x_end, v_end, tau
    if s[X] > s[PEAK]:
        s[PEAK], s[PEAK_AT] = s[X], tau
    if way != 0:
        if cross(w, s, bound, way, events) and w[KC] == np.inf and s[V] <= STILL:
            settle(w, s, p + slope * end, events)
    elif turns:
        s[V] = 0.0  # to the last bit
        note(s, events, 0.0)
        if s[TIE] == YIELDING:
            s[TIE], s[SLACK] = ELASTIC, s[X] - w[FT] / w[KT]
    return reached


@register_jitable
def full_steps(w):
    """Return `responses` over a whole interval between samples, of each branch, with the tie elastic and not."""
    table = np.zeros((8, 3))
    for row in range(8):
        at = row // 2 - 1
        k = 0.0 if at == STOP or at == PLATEAU else w[SLOPE] if at == FIRST else -w[KS]
        # One by one: Numba compiles an assignment to a row with all that describes wrong shapes, for seconds.
        table[row, 0], table[row, 1], table[row, 2] = responses(0.0, k + (row % 2) * w[KT], w[STEP])
    return table


@register_jitable
def leap(w, s, table, p, slope, stop):
    """Move over a whole interval between samples if nothing happens in it, and say whether it does not.

    It is most of them. Away from the stop there is no damping; an acceleration that has one sign at both ends of so
    short a time has it between them, and then the velocity is monotone.
    """
    if s[BRANCH] == STOP:
        return False
    _, k, offset = branch_of(w, s)
    low, high = bounds_of(w, s)
    x, v, h = s[X], s[V], w[STEP]
    if abs(k) * h * h > 1.0 or not low < x < high:
        return False
    a = p - offset - k * x
    jerk = slope - k * v
    row = 2 * (int(s[BRANCH]) + 1) + (1 if s[TIE] == ELASTIC else 0)
    g, g1, g2 = table[row, 0], table[row, 1], table[row, 2]
    x_end, v_end = x + v * h + a * g1 + jerk * g2, v + a * g + jerk * g1
    if v * v_end <= 0.0 or a * (p + slope * h - offset - k * x_end) <= 0.0 or not low < x_end < high:
        return False
    s[X], s[V], s[TAU], s[STALLED] = x_end, v_end, stop, 0.0
    if x_end > s[PEAK]:
        s[PEAK], s[PEAK_AT] = x_end, stop
    return True


@register_jitable
def settle(w, s, p, events):
    """Bring a wall to rest that bounces off with next to no speed while the load presses on it."""
    if s[TIE] != ELASTIC and p <= w[INITIAL] + LIFTING * (1.0 + w[INITIAL]):
        s[X], s[V], s[RESTING] = 0.0, 0.0, 1.0
        note(s, events, 2.0)


@register_jitable
def run(w, ground, times, displacement, velocity, events):
    """Move a lane from tau = 0 to the last of `times`, or to its collapse; return its state and how it ended."""
    s, table = begin(w), full_steps(w)
    reached, last, samples = 0, times[-1], ground.size
    for segment in range(max(samples, 1)):
        start, stop, p, slope = max(samples - 1, 0) * w[STEP], last, 0.0, 0.0
        if segment < samples - 1:
            start, stop = segment * w[STEP], min((segment + 1) * w[STEP], last)
            p = w[FACTOR] * ground[segment]
            slope = (w[FACTOR] * ground[segment + 1] - p) / w[STEP]
        while s[TAU] < stop:
            now = p + slope * (s[TAU] - start)
            whole = s[TAU] == start and segment < samples - 1 and times[reached] > stop
            if whole and s[RESTING] == 0.0 and leap(w, s, table, now, slope, stop):
                continue
            if s[RESTING] == 1.0:
                rest(w, s, now, slope, stop, events)
                while reached < times.size and times[reached] <= s[TAU]:
                    displacement[reached], velocity[reached] = 0.0, 0.0
                    reached += 1
            else:
                reached = move(w, s, now, slope, stop, times, displacement, velocity, reached, events)
                if s[BRANCH] >= BEYOND:
                    return s, COLLAPSED
                if s[STALLED] > PATIENCE:
                    return s, NO_PROGRESS
    return s, COMPLETED


def run_lanes(lanes, ground, times, displacement, velocity, events, ended):
    """Run lanes one after the other; `ended` has a row of how, tau, peak, its tau, impacts and events for each."""
    for i in range(lanes.shape[0]):
        stored = displacement.shape[0] > 0
        s, how = run(
            lanes[i],
            ground,
            times[i],
            displacement[i] if stored else np.empty(times.shape[1]),
            velocity[i] if stored else np.empty(times.shape[1]),
            events[i] if stored else np.empty((0, 4)),
        )
        ended[i, 0], ended[i, 1], ended[i, 2] = how, s[TAU], s[PEAK]
        ended[i, 3], ended[i, 4], ended[i, 5] = s[PEAK_AT], s[IMPACTS], s[EVENTS]
