"""Time histories from event to event: exact, and without a step of the batched solver, so that each checks the other.

The tri-linear law is linear on each branch. A piece of the motion stays on one branch, under a load that is linear in
time, and its velocity has one sign: pieces end at the branches' corners, at x = 0, at turns and at the samples of the
load. Where the damping coefficient is constant (CR and CDC everywhere, CDR, SDR and ECD inside a1) a piece has a closed
form. Elsewhere it is one step of DOP853 (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 1993,
section II.10) near rounding. An event inside a piece is located by bisection, to the last bits of its time.

Dimensionless as everywhere: x = u/u_ins, tau = p t, unit mass, forces over F0.

Numba keeps compiled code by the content of this one file. So each function that `run` compiles stands here, and so does
each number that it reads; the coefficients of DOP853 are SciPy's, which are published. The compiler may reorder and
contract nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numba.extending import register_jitable
from numpy.typing import ArrayLike
from scipy.integrate import DOP853

from rockdamp.arrays import Array
from rockdamp.errors import InputError, check, check_number, check_type
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.dampers import band_strength
from rockdamp.mechanics.damping import Damping

# DOP853's coefficients. The last two estimate the error of a step, and also weigh the rates at its end.
STAGES = DOP853.n_stages
A, B, C, E3, E5 = (
    np.ascontiguousarray(table) for table in (DOP853.A, DOP853.B, DOP853.C, DOP853.E3, DOP853.E5)
)
LIFTING = 1e-12  # load that lifts a wall from its stop [F0]

CR, SECANT, ECD, BAND, CQD = range(5)  # the laws of damping
VELOCITY, ACCELERATION, DISPLACEMENT = range(3)  # what is zero, or at a bound, at an event
COMPLETED, COLLAPSED, STALLED, FAILED = range(4)  # how a run ends


class Branch(NamedTuple):
    """One branch of the curve, low <= x <= high, on which f = stiffness x + offset."""

    low: float
    high: float
    stiffness: float
    offset: float
    constant: float  # C, or less than 0 where the law has it
    innermost: float  # |x| down to which the law is smooth
    largest_force: float
    inner_end: float  # |x|, |f| and 2V at the end next to x = 0
    inner_force: float
    inner_double_v: float


class Law(NamedTuple):
    """The damper: the number of its law, what this reads besides the state, and the speed below which a wall stops."""

    number: int
    parameters: tuple[float, float, float, float]
    rest: float = 0.0


# --- closed form: x'' + c x' + k x = q + slope t, k of either sign or zero --------------------------------------------


@register_jitable
def responses_without_stiffness(c, t):
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
        return responses_without_stiffness(c, t)
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
    """Return x and v at t of the motion from (x, v)."""
    # The acceleration solves the homogeneous equation: a (g' + c g) + jerk g, integrated once and twice.
    a = q - c * v - k * x
    jerk = slope - c * a - k * v
    g, g1, g2 = responses(c, k, t)
    return x + v * t + a * (g1 + c * g2) + jerk * g2, v + a * (g + c * g1) + jerk * g1


@register_jitable
def acceleration_zeros(x, v, c, k, q, slope):
    """Return the first zero of the acceleration after the start, and the time between two; infinite where none is."""
    a = q - c * v - k * x
    half, disc = c / 2.0, c * c / 4.0 - k
    b = (
        slope - c * a - k * v + half * a
    )  # exp(-half t) (a cos w t + b/w sin w t), or the same with cosh and sinh
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


# --- the laws of the dampers, written anew from their sources, not from the batched solver's --------------------------
#
# z = |x|, f = |f(x)|, v is the velocity away from x = 0, and double_v is 2V(x). Numba compiles a power of a whole,
# constant exponent once for a process, with the liberties of whoever uses it first: squares here are products.


@register_jitable
def kept_velocity(v, e, g, double_r):
    """Return the factor on the velocity at an impact, Eq. (8); of E+^g = E-^g - E_r^g (1 - e^2g) where g > 0."""
    if g == 0.0:
        return e
    level, lost = math.log(v * v / double_r), math.expm1(2.0 * g * math.log(e))
    left = math.exp(g * level) + lost  # E+^g/E_r^g
    if left <= 0.0:
        return 0.0
    # Near 1 to the last bit.
    rise = math.log1p(math.expm1(g * level) + lost) if abs(left - 1.0) < 0.5 else math.log(left)
    return math.exp((rise / g - level) / 2.0)


@register_jitable
def ecd_coefficient(f, double_v, v, kappa, m, g, double_r):
    """Return C of ECD by the tangent u of the phase, cos^2 = 1/(1 + u^2).

    It is as smooth as its rounding: that of a power grows with m, and steps would shrink.
    """
    root = math.sqrt(double_v)
    if m == 0.0 and g == 0.0:
        return kappa * f / root
    size = kappa * math.exp(-g * math.log((v * v + double_v) / double_r)) if g > 0.0 else kappa
    if v == 0.0:
        return size * f / root if m == 0.0 else 0.0
    u = root / v
    size *= math.exp(-m * math.log1p(u * u))
    # ASSUME: the product in the denominator is at most 0.95, as in the batched solver; half cycles then still end.
    return size * f / root / (1.0 - min(size / (u + 1.0 / u), 0.95))


@register_jitable
def coefficient(branch, law, x, v):
    """Return C on a branch: a constant, or by the law."""
    if branch.constant >= 0.0:
        return branch.constant
    z = max(abs(x), 1e-100)  # a law may divide by x or by the energy
    a, b, c, d = law.parameters
    f = max(branch.stiffness * z + abs(branch.offset), 0.0)
    if law.number == SECANT:  # 2 xi w1 (w/w1)^n, Eqs (11) and (12)
        return a * (f / z / b) ** c
    if law.number == BAND:  # size (1 - (z/(c v))^2), by the distance to the edge of the band
        reach = max(b * abs(v), 1e-90)
        return a * (reach - z) * (reach + z) / (reach * reach) if z < reach else 0.0
    if law.number == CQD:  # mu(x) |v|, asked for inside the band alone
        return a * (b - z) * (b + z) / (b * b * b) * abs(v)
    # 2V by the area of a trapezoid further than at the inner end.
    double_v = branch.inner_double_v + (f + branch.inner_force) * (z - branch.inner_end)
    return ecd_coefficient(f, double_v, v if x >= 0.0 else -v, a, b, c, d)


@register_jitable
def acceleration(branch, law, p, x, v):
    """Return x'' on a branch under the load p."""
    return p - branch.stiffness * x - branch.offset - coefficient(branch, law, x, v) * v


# --- steps of DOP853 from a start (x, v, p, slope of p) ---------------------------------------------------------------


@register_jitable
def advance(branch, law, start, h, rates):
    """Take a step of the length h; the rates of its stages are left in `rates`, shape (2, STAGES + 1)."""
    x, v, p, slope = start
    for stage in range(STAGES):
        dx, dv = 0.0, 0.0
        for before in range(stage):
            dx += A[stage, before] * rates[0, before]
            dv += A[stage, before] * rates[1, before]
        rates[0, stage] = v + h * dv
        rates[1, stage] = acceleration(
            branch, law, p + slope * (C[stage] * h), x + h * dx, v + h * dv
        )
    dx, dv = 0.0, 0.0
    for stage in range(STAGES):
        dx += B[stage] * rates[0, stage]
        dv += B[stage] * rates[1, stage]
    return x + h * dx, v + h * dv


@register_jitable
def step_error(start, end, h, rates):
    """Return the estimated error of a step over what is allowed."""
    third, fifth = 0.0, 0.0
    for row in range(2):  # allowed are 1e-13, relative, and a thousandth of it
        scale = 1e-13 * (1e-3 + max(abs(start[row]), abs(end[row])))
        row_third, row_fifth = 0.0, 0.0
        for stage in range(STAGES + 1):
            row_third += E3[stage] * rates[row, stage]
            row_fifth += E5[stage] * rates[row, stage]
        row_third, row_fifth = row_third / scale, row_fifth / scale
        third += row_third * row_third
        fifth += row_fifth * row_fifth
    if third == 0.0 and fifth == 0.0:
        return 0.0
    return h * fifth / math.sqrt(2.0 * (fifth + 0.01 * third))


@register_jitable
def longest_step(branch, start, remaining):
    """Return a step in which no stage leaves where the law is smooth: |x| falls by at most |v| h + pull h^2/2 in it."""
    x, v, p, slope = start
    reach, speed = abs(x) - branch.innermost, abs(v)
    pull = branch.largest_force + max(abs(p), abs(p + slope * remaining))
    return 2.0 * reach / (speed + math.sqrt(speed * speed + 2.0 * pull * reach))


@register_jitable
def adaptive_step(branch, law, start, remaining, tau, h, rates):
    """Take a step that keeps the tolerance: its length (0 where none does), its end, and a good length for the next.

    The rates at its end stand last in `rates`.
    """
    wanted, rejected = h, False
    h = min(h, longest_step(branch, start, remaining), remaining)
    while True:
        end = advance(branch, law, start, h, rates)
        rates[0, STAGES] = end[1]
        rates[1, STAGES] = acceleration(branch, law, start[2] + start[3] * h, end[0], end[1])
        error = step_error(start, end, h, rates)
        if error < 1.0:
            growth = 10.0 if error == 0.0 else min(10.0, 0.9 * error**-0.125)
            growth = min(growth, 1.0) if rejected else growth
            return h, end, max(growth * h, wanted) if h == remaining else growth * h
        h *= max(0.2, 0.9 * error**-0.125) if error < np.inf else 0.2
        rejected = True
        if not h > 10 * np.finfo(np.float64).eps * tau:
            return 0.0, end, wanted


# --- pieces and the events in them ------------------------------------------------------------------------------------


@register_jitable
def state(branch, law, start, t, rates):
    """Return x and v at a moment t of the piece from `start`, by the closed form or by a step of that length."""
    if branch.constant >= 0.0:
        x, v, p, slope = start
        return closed_state(x, v, branch.constant, branch.stiffness, p - branch.offset, slope, t)
    return advance(branch, law, start, t, rates)


@register_jitable
def event(branch, law, start, quantity, bound, sign_after, before, after, rates):
    """Return the last moment before `quantity` less `bound` changes sign, known to do so once between two moments."""
    for _ in range(100):  # to the last bit, or next to the start
        middle = 0.5 * (before + after)
        if middle <= before or middle >= after:
            break
        x, v = state(branch, law, start, middle, rates)
        value = v if quantity == VELOCITY else x
        if quantity == ACCELERATION:
            value = acceleration(branch, law, start[2] + start[3] * middle, x, v)
        if (value - bound) * sign_after > 0.0:
            after = middle
        else:
            before = middle
    return before


@register_jitable
def turn(branch, law, start, h, end, rates):
    """Return where a step of DOP853 first turns, and whether it does.

    A step near rounding is a small part of a cycle: its acceleration changes sign once at most.
    """
    a, a_end = rates[1, 0], rates[1, STAGES]
    v, v_end = start[1], end[1]
    way = v if v != 0.0 else a
    if way * v_end < 0.0:
        fastest = (
            event(branch, law, start, ACCELERATION, 0.0, -way, 0.0, h, rates) if v == 0.0 else 0.0
        )
        return event(branch, law, start, VELOCITY, 0.0, -way, fastest, h, rates), True
    if way * a < 0.0 and way * a_end > 0.0:  # slower and faster again, or back and forth?
        slowest = event(branch, law, start, ACCELERATION, 0.0, way, 0.0, h, rates)
        if way * state(branch, law, start, slowest, rates)[1] < 0.0:
            return event(branch, law, start, VELOCITY, 0.0, -way, 0.0, slowest, rates), True
    return h, False


@register_jitable
def piece(branch, law, start, remaining, tau, step, rates):
    """Return the next piece: its length (0 where no step keeps the tolerance), whether it ends at a turn, a good length
    for the next step, and the state at its end."""
    c, k = branch.constant, branch.stiffness
    if c < 0.0:
        h, end, step = adaptive_step(branch, law, start, remaining, tau, step, rates)
        until, turns = turn(branch, law, start, h, end, rates)
        return until, turns, step, end if until == h else advance(branch, law, start, until, rates)
    x, v, p, slope = start
    before, after, turns = closed_turn(x, v, c, k, p - branch.offset, slope, remaining)
    if turns:
        way = closed_state(x, v, c, k, p - branch.offset, slope, after)[1]
        before = event(branch, law, start, VELOCITY, 0.0, way, before, after, rates)
    return before, turns, step, closed_state(x, v, c, k, p - branch.offset, slope, before)


@register_jitable
def piece_on_branch(branch, law, start, remaining, tau, step, rates):
    """Return the next piece, which may leave its branch: length, whether it turns, where it leaves to, step, state.

    The displacement is monotone in a piece, so no exit is missed. A start on a bound is an exit at once if the motion
    goes out, and none if it goes in.
    """
    end, turns, step, (x_end, v_end) = piece(branch, law, start, remaining, tau, step, rates)
    way = 0 if end == 0.0 else 1 if x_end > branch.high else -1 if x_end < branch.low else 0
    if way:
        bound = branch.high if way > 0 else branch.low
        end = (
            event(branch, law, start, DISPLACEMENT, bound, way, 0.0, end, rates)
            if start[0] != bound
            else 0.0
        )
        x_end, v_end = bound, state(branch, law, start, end, rates)[1]
    return end, turns and way == 0, way, step, x_end, v_end


# --- the run ----------------------------------------------------------------------------------------------------------


@register_jitable
def branch_at(branches, at):
    """Return one branch of an array, shape (branches, 10)."""
    row = branches[at]
    return Branch(row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9])


@register_jitable
def load_segment(load, sampling, index, last):
    """Return begin and end of a segment of the load, the load at its begin, and its slope."""
    if index < load.size - 1:
        begin, end = index * sampling, min((index + 1) * sampling, last)
        return begin, end, load[index], (load[index + 1] - load[index]) / sampling
    return max(load.size - 1, 0) * sampling, last, 0.0, 0.0


@register_jitable
def store(branch, law, start, origin, tau, times, reached, displacement, velocity, rates):
    """Store the states of a piece at the times in it, and return how many times are reached."""
    while reached > 0 and times[reached - 1] >= origin:  # after an impact, once more
        reached -= 1
    while reached < times.size and times[reached] <= tau:
        displacement[reached], velocity[reached] = state(
            branch, law, start, times[reached] - origin, rates
        )
        reached += 1
    return reached


@register_jitable
def append(rows, count, first, second):
    """Return rows with one more of two numbers; they are moved to where there is room."""
    if count == rows.shape[0]:
        longer = np.empty((2 * count, 2))
        for row in range(
            count
        ):  # Numba compiles an assignment of arrays with all that describes wrong shapes: seconds
            longer[row, 0], longer[row, 1] = rows[row, 0], rows[row, 1]
        rows = longer
    rows[count, 0] = first
    rows[count, 1] = second
    return rows


@register_jitable
def impact(law, one_sided, v, p):
    """Return the velocity after a crossing of x = 0 under the load p, or after a blow on the stop."""
    if law.number == CR:
        v *= kept_velocity(v, law.parameters[0], law.parameters[1], law.parameters[2])
    if one_sided:
        return (
            0.0 if -v <= 1e-6 and p <= LIFTING else -v
        )  # too slow a wall, pressed against its stop, rests there
    return v if abs(v) > law.rest else 0.0


@register_jitable
def lift_time(p, slope):
    """Return the time until a load lifts a wall that rests at its stop; infinite where it does not."""
    if p > LIFTING:
        return 0.0
    return (LIFTING - p) / slope if slope > 0.0 else np.inf


@njit(cache=True, error_model="numpy", nogil=True)
def run(branches, law, one_sided, at, x, v, load, sampling, times, displacement, velocity):
    """Move from tau = 0 to the last of `times`, or to the collapse.

    Returns how it ended, tau, x, and tau and v of the impacts and tau and x of the turns, each of shape (count, 2).

    Parameters
    ----------
    branches : ndarray, shape (branches, 10)
        Rows of `Branch`, from the left to the right; `at` is the one of the start.
    law : Law
    one_sided : bool
        Whether the wall bounces off a stop at x = 0.
    load, sampling : ndarray and float
        Samples, linear between them and zero after the last, and their spacing.
    times, displacement, velocity : ndarray, shape (n,)
        Ascending moments, and room for the state at each that is reached.
    """
    impacts, turns, rates = np.empty((64, 2)), np.empty((64, 2)), np.zeros((2, STAGES + 1))
    impact_count, turn_count, reached, stalled = 0, 0, 0, 0
    tau, step = 0.0, np.inf
    resting = one_sided and x == 0.0 and v == 0.0
    for segment in range(max(load.size, 1)):
        begin, stop, p, slope = load_segment(load, sampling, segment, times[-1])
        while tau < stop and 0 <= at < branches.shape[0]:
            branch, origin, remaining = branch_at(branches, at), tau, stop - tau
            start = (x, v, p + slope * (tau - begin), slope)
            if resting:
                end = lift_time(start[2], slope)
                resting = end >= remaining
                start, turning, way = (0.0, 0.0, 0.0, 0.0), False, 0
                end = remaining if resting else end
            else:
                end, turning, way, step, x, v = piece_on_branch(
                    branch, law, start, remaining, tau, step, rates
                )
                if end == 0.0 and not turning and way == 0 and branch.constant < 0.0:
                    return FAILED, tau, x, impacts[:impact_count], turns[:turn_count]
            tau = stop if end == remaining else origin + end
            reached = store(
                branch, law, start, origin, tau, times, reached, displacement, velocity, rates
            )
            if turning:
                v = 0.0  # to the last bit: from there on, the hyperbolic branch does not amplify rounding
                turns = append(turns, turn_count, tau, x)
                turn_count += 1
            if way and x == 0.0 and (v != 0.0 or one_sided):
                impacts = append(impacts, impact_count, tau, v)
                impact_count += 1
                v = impact(law, one_sided, v, start[2] + slope * end)
                resting = one_sided and v == 0.0
            if not (one_sided and x == 0.0):
                at += way
            stalled = stalled + 1 if tau == origin else 0
            if stalled > 200:  # a state that balances on a corner to the last bit
                return STALLED, tau, x, impacts[:impact_count], turns[:turn_count]
    ended = COMPLETED if 0 <= at < branches.shape[0] else COLLAPSED
    return ended, tau, x, impacts[:impact_count], turns[:turn_count]


# --- what is called ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ExactHistory:
    """One time history at the times asked for; tau [-] and u/u_ins [-]."""

    times: Array
    displacement: Array  # NaN after a collapse
    velocity: Array  # by tau; after the impact where a time is an impact's
    impacts: Array  # tau of the crossings of u = 0, whatever the damper; of a one-sided wall, of the blows on its stop
    turning_tau: Array  # where the velocity changes sign after the release
    turning_displacement: Array  # the signed peaks of a free decay
    peak: float  # largest abs(u)/u_ins; a3 after a collapse
    peak_tau: float
    collapsed: bool
    end_tau: float


def exact_history(
    curve: TrilinearCurve,
    damping: Damping,
    times: ArrayLike,
    *,
    release_amplitude: float = 0.0,
    release_velocity: float = 0.0,
    load: ArrayLike | None = None,
    sampling: float = 0.0,
    one_sided: bool = False,
) -> ExactHistory:
    """Solve x'' + C(x, x') x' + f(x) = load from tau = 0 for one wall and one damper, with Eq. (8) at impacts for CR.

    Parameters
    ----------
    curve, damping : TrilinearCurve, Damping
        Of plain numbers.
    times : ndarray, shape (n,)
        Ascending moments tau >= 0 at which the history is given; the last is the end of the run. [-]
    release_amplitude, release_velocity : float
        u/u_ins and its derivative by tau at tau = 0. [-]
    load : ndarray, shape (samples,), optional
        `Wall.load_factor` times the ground acceleration; linear between its samples, and zero after the last. [-]
    sampling : float
        Time between two samples of the load, in tau. [-]
    one_sided : bool
        The wall rocks to u >= 0 alone, away from a rigid stop: an impact turns the velocity v into -e v. A wall that
        bounces ever lower while the load presses on it comes to rest, and rests until the load lifts it. With CR alone.

    Raises
    ------
    InputError
        If the release lies beyond the curve, or a one-sided wall has a viscous damper.
    ArithmeticError
        If the motion makes no progress, or no step keeps its tolerance.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> history = rd.exact_history(curve, rd.Damping("CR", 0.85), [10.0], release_amplitude=0.5)
    >>> history.turning_displacement.round(3)[:3]
    array([-0.335,  0.237, -0.174])
    """
    check_type("curve", curve, TrilinearCurve)
    check_type("damping", damping, Damping)
    if one_sided and damping.model != "CR":
        raise InputError(
            f"damping_model is {damping.model}; it must be CR with a wall that rocks to one side"
        )
    a3 = float(curve.ultimate_displacement_ratio)
    allowed = f"less than a3, {a3:g}, " + ("and at least 0" if one_sided else "to either side")
    x = check_number(
        "release_amplitude",
        release_amplitude,
        lambda x: (abs(x) < a3) & ((x >= 0) | (not one_sided)),
        allowed,
    )
    finite = "a finite number"
    v = check_number("release_velocity", release_velocity, np.isfinite, finite)
    times = np.atleast_1d(check("times", times, np.isfinite, finite))
    load = np.empty(0) if load is None else check("load", load, np.isfinite, finite)
    sampling = check_number("sampling", sampling, lambda h: h >= 0, "at least 0")
    law, constants = law_parameters(curve, damping)
    rows = curve_branches(curve, law, constants)
    rows = rows[len(rows) // 2 :] if one_sided else rows
    # From a corner the motion goes to the branch ahead, lest a start at x = 0 be an impact.
    at = int(np.searchsorted(rows[1:, 0], x, side="left" if v < 0 and not one_sided else "right"))
    displacement, velocity = np.full(times.shape, np.nan), np.full(times.shape, np.nan)
    displacement[times == 0.0], velocity[times == 0.0] = x, v
    ended, tau, x_end, impacts, turns = run(
        rows, law, one_sided, at, x, v, load, sampling, times, displacement, velocity
    )
    if ended == STALLED:
        raise ArithmeticError(f"no progress at tau = {tau:.9g}, x = {x_end:.9g}")
    if ended == FAILED:
        raise ArithmeticError(
            f"no step of DOP853 keeps its tolerance at tau = {tau:.9g}, x = {x_end:.9g}"
        )
    turning_tau, turning_displacement = turns.T
    extremes = np.abs([x, *turning_displacement, x_end])
    peak_tau = [0.0, *turning_tau, tau][int(extremes.argmax())]
    return ExactHistory(
        times=times,
        displacement=displacement,
        velocity=velocity,
        impacts=impacts[:, 0],
        turning_tau=turning_tau,
        turning_displacement=turning_displacement,
        peak=float(extremes.max()),
        peak_tau=float(peak_tau),
        collapsed=ended == COLLAPSED,
        end_tau=tau,
    )


def law_parameters(curve: TrilinearCurve, damping: Damping) -> tuple[Law, list[float]]:
    """Return the law of a damper, and C on each branch from x = 0 outwards: -1 where it is not constant."""
    k1, a1, model = (
        float(curve.initial_stiffness),
        float(curve.yield_displacement_ratio),
        damping.model,
    )
    g, double_r = float(damping.loss_exponent), 1.0
    if g > 0.0:
        a3, at = float(curve.ultimate_displacement_ratio), damping.reference_amplitude
        check("reference_amplitude", at, lambda x: x < a3, f"less than a3, {a3:g}")
        double_r = 2 * float(curve.energy(at))
    rest = 1e-12 if g > 0.0 else 0.0  # where the loss grows as the motion fades
    if model == "CR":
        return Law(CR, (float(damping.value), g, double_r, 0.0), rest), [0.0] * 3
    xi = float(damping.value)
    linear = 2 * math.sqrt(k1) * xi
    if model == "ECD":
        m = float(damping.order)
        # The integral of cos^(2m+2) over a half cycle is the beta function of m + 3/2 and 1/2.
        integral = (
            math.exp(math.lgamma(m + 1.5) + math.lgamma(0.5) - math.lgamma(m + 2))
            if m
            else math.pi / 2
        )
        inner = linear if m == 0.0 and g == 0.0 else -1.0
        return Law(ECD, (math.pi * xi / integral, m, g, double_r), rest), [inner, -1.0, -1.0]
    if model == "BAND":
        c = float(damping.width) / math.sqrt(k1)
        return Law(
            BAND, (0.75 * float(band_strength(math.pi * xi, damping.width)) / c, c, 0.0, 0.0)
        ), [-1.0] * 3
    if model == "CQD":  # nothing damps beyond the band
        return Law(CQD, (3 * math.pi * xi / 4, float(damping.width) * a1, 0.0, 0.0)), [
            -1.0,
            0.0,
            0.0,
            0.0,
        ]
    outer = linear if model == "CDC" else -1.0
    half_exponent = {"CDC": 0.0, "CDR": 0.5, "SDR": 1.0}[model]
    return Law(SECANT, (2 * xi * math.sqrt(k1), k1, half_exponent, 0.0)), [linear, outer, outer]


def curve_branches(curve: TrilinearCurve, law: Law, constants: list[float]) -> Array:
    """Return the branches from -a3 to a3, split at x = 0 and at the ends of CQD's band, shape (n, 10)."""
    k1, b1, ks, a1, a2, a3 = (float(value) for value in curve.parameters())
    shapes = [(0.0, a1, k1, 0.0), (a1, a2, 0.0, b1), (a2, a3, -ks, ks * a3)]
    if law.number == CQD:
        w = law.parameters[1]
        shapes = [(0.0, w, k1, 0.0), (w, a1, k1, 0.0), *shapes[1:]]
    margin = a1 / 4  # a plateau that goes on inwards has energy down to a1/2
    rows: list[Branch] = []
    for constant, (low, high, k, offset) in zip(constants, shapes, strict=True):
        inner = (
            low - margin,
            b1 + ks * margin,
            low,
            k * low + offset,
            2 * float(curve.energy(low)),
        )
        mirrored = Branch(-high, -low, k, -offset, constant, *inner)
        rows = [mirrored, *rows, Branch(low, high, k, offset, constant, *inner)]
    return np.array(rows)
