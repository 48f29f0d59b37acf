"""Time histories from event to event: exact, and independent of the batched solver.

Each of the two solvers checks the other.

The tri-linear law is linear on each branch. A piece of the motion stays on one branch, under a load
that is linear in time, and its velocity has one sign: pieces end at the corners of the branches, at
x = 0, at turning points and at the samples of the load. Where the damping coefficient is constant
(CR and CDC everywhere; CDR, SDR and ECD inside a1) a piece has a closed form. Elsewhere it is one
step of DOP853 (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 1993, section
II.10) with a tolerance near rounding. An event inside a piece is located by bisection, to the last
bits of its time.

Everything is dimensionless: x = u/u_ins, tau = p t, unit mass, forces divided by F0.

Numba keeps compiled code by the content of this one file. So each function that `integrate`
compiles is here, and so is each number that it reads, but for the published coefficients of DOP853,
which come from SciPy. The compiler may reorder and contract nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import ArrayLike
from scipy.integrate import DOP853

from rockdamp.arrays import Array
from rockdamp.errors import InputError, check, check_number, check_type
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.half_cycle_loss import band_strength
from rockdamp.solvers.machine_code import compile_cached

# Coefficients of DOP853. E3 and E5 estimate the error of a step, and weigh the rates at its end.
STAGES = DOP853.n_stages
TABLES = (DOP853.A, DOP853.B, DOP853.C, DOP853.E3, DOP853.E5)
A, B, C, E3, E5 = (np.ascontiguousarray(table) for table in TABLES)
LIFTING = 1e-12  # load that lifts a wall from its stop [F0]; only rounding is smaller

CR, SECANT, ECD, BAND, CQD = range(5)  # numbers of the laws in `coefficient`
VELOCITY, ACCELERATION, DISPLACEMENT = range(3)  # quantities whose sign changes at an event
COMPLETED, COLLAPSED, STALLED, FAILED = range(4)  # outcomes of a run
FAILURES = {STALLED: "no progress", FAILED: "no step of DOP853 keeps its tolerance"}


class Branch(NamedTuple):
    """One branch of the curve, low <= x <= high, on which f = stiffness x + offset."""

    low: float
    high: float
    stiffness: float
    offset: float
    constant: float  # C, or less than 0 where the law gives it
    innermost: float  # |x| down to which the law is smooth
    largest_force: float
    inner_end: float  # |x|, |f| and 2V at the end next to x = 0
    inner_force: float
    inner_double_v: float


class Law(NamedTuple):
    """The law of a damper."""

    number: int
    parameters: tuple[float, float, float, float]  # which `coefficient` and `impact` read
    rest: float = 0.0  # speed below which an impact stops the wall


# --- closed form: x'' + c x' + k x = q + slope t, k of either sign or zero ------------------------


@register_jitable
def responses_without_stiffness(c, t):
    """Return `responses` for k = 0: t^n phi_n(-c t), n = 1, 2, 3, of the exponential integrator."""
    z = -c * t
    if abs(z) < 1.0:  # phi3 by its series, the others from it: well conditioned to c = 0
        term = 1.0 / 6.0
        phi3 = term
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
    """Return the impulse response g of x'' + c x' + k x, and its first and second integral to t."""
    if k == 0.0:
        return responses_without_stiffness(c, t)
    half = c / 2.0
    discriminant = c * c / 4.0 - k
    if discriminant < 0.0:
        w = math.sqrt(-discriminant)
        decay = math.exp(-half * t)
        g = decay * math.sin(w * t) / w
        even = decay * math.cos(w * t)
    else:
        d = math.sqrt(discriminant)
        slow = math.exp(-k / (d + half) * t)  # the rate -half + d, without its cancellation
        g = -slow * math.expm1(-2.0 * d * t) / (2.0 * d) if d > 0.0 else slow * t
        even = slow * (1.0 + math.exp(-2.0 * d * t)) / 2.0
    first = (1.0 - even - half * g) / k  # g' = even - half g, and g' - 1 + c g + k first = 0
    return g, first, (t - c * first - g) / k


@register_jitable
def closed_state(x, v, c, k, q, slope, t):
    """Return x and v at the time t of the motion from (x, v)."""
    # The acceleration solves the homogeneous equation: a (g' + c g) + jerk g, integrated twice.
    a = q - c * v - k * x
    jerk = slope - c * a - k * v
    g, g1, g2 = responses(c, k, t)
    return x + v * t + a * (g1 + c * g2) + jerk * g2, v + a * (g + c * g1) + jerk * g1


@register_jitable
def acceleration_zeros(x, v, c, k, q, slope):
    """Return the first zero of the acceleration after the start, and the time between two zeros.

    They are infinite where there is none.
    """
    a = q - c * v - k * x
    half = c / 2.0
    discriminant = c * c / 4.0 - k
    # a(t) = exp(-half t) (a cos w t + b/w sin w t), or the same with cosh and sinh
    b = slope - c * a - k * v + half * a
    if a == 0.0 and b == 0.0:
        return np.inf, np.inf
    if discriminant < 0.0:
        w = math.sqrt(-discriminant)
        first = math.atan2(-a * w, b) % math.pi / w
        spacing = math.pi / w
        return first if first > 0.0 else spacing, spacing
    d = math.sqrt(discriminant)
    if a * b >= 0.0 or d * abs(a) >= abs(b):
        return np.inf, np.inf
    if d == 0.0:
        return -a / b, np.inf
    return math.atanh(-d * a / b) / d, np.inf


@register_jitable
def closed_turn(x, v, c, k, q, slope, duration):
    """Return start and stop of a stretch in which the velocity first changes sign, and True.

    Where it does not by `duration`, return this time twice, and False.
    """
    start = 0.0
    v_start = v
    zero, spacing = acceleration_zeros(x, v, c, k, q, slope)
    while True:  # between zeros of the acceleration the velocity is monotone
        stop = min(zero, duration)
        v_stop = closed_state(x, v, c, k, q, slope, stop)[1]
        if v_start * v_stop < 0.0:
            return start, stop, True
        if stop >= duration:
            return duration, duration, False
        start = stop
        v_start = v_stop
        zero += spacing


# --- the laws of the dampers, written from their sources, not from the batched solver -------------
#
# z = |x|, f = |f(x)|, v is the outward velocity, positive away from x = 0, and double_v is 2V(x).
# Numba compiles a power with a whole, constant exponent once for a process, with the compiler
# options of the first function that uses it. So squares here are products.


@register_jitable
def restitution_factor(v, e, g, double_reference):
    """Return the factor on the velocity at an impact, Eq. (8).

    Where g > 0 it follows from E+^g = E-^g - E_r^g (1 - e^2g).
    """
    if g == 0.0:
        return e
    level = math.log(v * v / double_reference)
    lost = math.expm1(2.0 * g * math.log(e))
    remainder = math.exp(g * level) + lost  # (E+/E_r)^g
    if remainder <= 0.0:
        return 0.0
    if abs(remainder - 1.0) < 0.5:  # near 1 to the last bit
        log_remainder = math.log1p(math.expm1(g * level) + lost)
    else:
        log_remainder = math.log(remainder)
    return math.exp((log_remainder / g - level) / 2.0)


@register_jitable
def ecd_coefficient(f, double_v, v, kappa, m, g, double_reference):
    """Return C of ECD by the tangent u of the phase, cos^2 = 1/(1 + u^2).

    The tangent keeps C smooth: in a power of cos^2 the rounding would grow with m, and the steps of
    DOP853 would shrink.
    """
    root = math.sqrt(double_v)
    if m == 0.0 and g == 0.0:
        return kappa * f / root
    size = kappa
    if g > 0.0:
        size = kappa * math.exp(-g * math.log((v * v + double_v) / double_reference))
    if v == 0.0 and m > 0.0:
        return 0.0
    if v == 0.0:
        return size * f / root
    u = root / v
    size *= math.exp(-m * math.log1p(u * u))
    # ASSUME: the subtrahend is at most 0.95, as in the batched solver; half cycles then still end.
    return size * f / root / (1.0 - min(size / (u + 1.0 / u), 0.95))


@register_jitable
def coefficient(branch, law, x, v):
    """Return C on a branch: a constant, or from the law."""
    if branch.constant >= 0.0:
        return branch.constant
    z = max(abs(x), 1e-100)  # a law may divide by x or by the energy
    a, b, c, d = law.parameters
    f = max(branch.stiffness * z + abs(branch.offset), 0.0)
    if law.number == SECANT:  # 2 xi w1 (w/w1)^n, Eqs (11) and (12)
        return a * (f / z / b) ** c
    if law.number == BAND:  # size (1 - (z/(c v))^2), by the distance to the edge of the band
        reach = max(b * abs(v), 1e-90)
        if z >= reach:
            return 0.0
        return a * (reach - z) * (reach + z) / (reach * reach)
    if law.number == CQD:  # mu(x) |v|; only branches inside the band ask
        return a * (b - z) * (b + z) / (b * b * b) * abs(v)
    # 2V exceeds its value at the inner end by the area of a trapezoid.
    double_v = branch.inner_double_v + (f + branch.inner_force) * (z - branch.inner_end)
    outward_v = v if x >= 0.0 else -v
    return ecd_coefficient(f, double_v, outward_v, a, b, c, d)


@register_jitable
def acceleration(branch, law, p, x, v):
    """Return x'' on a branch under the load p."""
    return p - branch.stiffness * x - branch.offset - coefficient(branch, law, x, v) * v


# --- steps of DOP853 from a start (x, v, p, slope of p) -------------------------------------------


@register_jitable
def advance(branch, law, start, h, rates):
    """Take a step of the length h, and write the rates of its stages, shape (2, STAGES + 1)."""
    x, v, p, slope = start
    for stage in range(STAGES):
        dx = 0.0
        dv = 0.0
        for earlier in range(stage):
            dx += A[stage, earlier] * rates[0, earlier]
            dv += A[stage, earlier] * rates[1, earlier]
        stage_p = p + slope * (C[stage] * h)
        rates[0, stage] = v + h * dv
        rates[1, stage] = acceleration(branch, law, stage_p, x + h * dx, v + h * dv)
    dx = 0.0
    dv = 0.0
    for stage in range(STAGES):
        dx += B[stage] * rates[0, stage]
        dv += B[stage] * rates[1, stage]
    return x + h * dx, v + h * dv


@register_jitable
def step_error(start, end, h, rates):
    """Return the estimated error of a step divided by the tolerance, as in Hairer et al.

    It is h F/sqrt(2 (F + 0.01 T)), with the squared norms F of the fifth-order and T of the
    third-order estimate of the two rates.
    """
    third = 0.0
    fifth = 0.0
    for row in range(2):  # the tolerance is 1e-13, relative, and a thousandth of it
        scale = 1e-13 * (1e-3 + max(abs(start[row]), abs(end[row])))
        row_third = 0.0
        row_fifth = 0.0
        for stage in range(STAGES + 1):
            row_third += E3[stage] * rates[row, stage]
            row_fifth += E5[stage] * rates[row, stage]
        row_third /= scale
        row_fifth /= scale
        third += row_third * row_third
        fifth += row_fifth * row_fifth
    if third == 0.0 and fifth == 0.0:
        return 0.0
    return h * fifth / math.sqrt(2.0 * (fifth + 0.01 * third))


@register_jitable
def longest_step(branch, start, remaining):
    """Return a step in which no stage leaves the region where the law is smooth.

    In it |x| falls by at most |v| h + pull h^2/2.
    """
    x, v, p, slope = start
    distance = abs(x) - branch.innermost
    speed = abs(v)
    pull = branch.largest_force + max(abs(p), abs(p + slope * remaining))
    return 2.0 * distance / (speed + math.sqrt(speed * speed + 2.0 * pull * distance))


@register_jitable
def adaptive_step(branch, law, start, remaining, tau, proposed, rates):
    """Take a step that keeps the tolerance.

    Return its length (0 where no step keeps it), its end, and a good length for the next step. The
    rates at its end are the last ones in `rates`.
    """
    h = min(proposed, longest_step(branch, start, remaining), remaining)
    is_retry = False
    while True:
        end = advance(branch, law, start, h, rates)
        rates[0, STAGES] = end[1]
        rates[1, STAGES] = acceleration(branch, law, start[2] + start[3] * h, end[0], end[1])
        error = step_error(start, end, h, rates)
        # Step control as in Hairer et al.: factors 0.9, 0.2 and 10, exponent -1/8 for order 8.
        factor = 0.9 * error**-0.125 if error > 0.0 else 10.0
        if error < 1.0:
            next_step = min(factor, 1.0 if is_retry else 10.0) * h
            if h == remaining:  # a short piece does not shorten the next step
                next_step = max(next_step, proposed)
            return h, end, next_step
        h *= max(0.2, factor) if error < np.inf else 0.2
        is_retry = True
        if not h > 10 * np.finfo(np.float64).eps * tau:
            return 0.0, end, proposed


# --- pieces and the events in them ----------------------------------------------------------------


@register_jitable
def state(branch, law, start, t, rates):
    """Return x and v at the time t of a piece, by the closed form or by a step of that length."""
    if branch.constant >= 0.0:
        x, v, p, slope = start
        return closed_state(x, v, branch.constant, branch.stiffness, p - branch.offset, slope, t)
    return advance(branch, law, start, t, rates)


@register_jitable
def event(branch, law, start, quantity, bound, sign_after, low, high, rates):
    """Return the last time before `quantity` less `bound` changes sign.

    It is known to do so once between the times `low` and `high`.
    """
    for _ in range(100):  # to the last bit, or next to the start
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        x, v = state(branch, law, start, middle, rates)
        value = v if quantity == VELOCITY else x
        if quantity == ACCELERATION:
            value = acceleration(branch, law, start[2] + start[3] * middle, x, v)
        if (value - bound) * sign_after > 0.0:
            high = middle
        else:
            low = middle
    return low


@register_jitable
def turn(branch, law, start, h, end, rates):
    """Return the time at which a step of DOP853 first turns, and whether it does.

    A step near rounding is a small part of a cycle: its acceleration changes sign once at most.
    """
    a = rates[1, 0]
    a_end = rates[1, STAGES]
    v = start[1]
    v_end = end[1]
    way = v if v != 0.0 else a
    if way * v_end < 0.0:
        fastest = 0.0
        if v == 0.0:
            fastest = event(branch, law, start, ACCELERATION, 0.0, -way, 0.0, h, rates)
        return event(branch, law, start, VELOCITY, 0.0, -way, fastest, h, rates), True
    if way * a < 0.0 and way * a_end > 0.0:  # slower and faster again, or back and forth?
        slowest = event(branch, law, start, ACCELERATION, 0.0, way, 0.0, h, rates)
        if way * state(branch, law, start, slowest, rates)[1] < 0.0:
            return event(branch, law, start, VELOCITY, 0.0, -way, 0.0, slowest, rates), True
    return h, False


@register_jitable
def piece(branch, law, start, remaining, tau, step, rates):
    """Return the next piece of the motion.

    Return its length (0 where no step keeps the tolerance), whether it ends at a turning point, a
    good length for the next step, and the state at its end.
    """
    c = branch.constant
    k = branch.stiffness
    if c < 0.0:
        h, end, step = adaptive_step(branch, law, start, remaining, tau, step, rates)
        length, turns = turn(branch, law, start, h, end, rates)
        if length != h:
            end = advance(branch, law, start, length, rates)
        return length, turns, step, end
    x, v, p, slope = start
    q = p - branch.offset
    length, stop, turns = closed_turn(x, v, c, k, q, slope, remaining)
    if turns:
        v_stop = closed_state(x, v, c, k, q, slope, stop)[1]
        length = event(branch, law, start, VELOCITY, 0.0, v_stop, length, stop, rates)
    return length, turns, step, closed_state(x, v, c, k, q, slope, length)


@register_jitable
def piece_on_branch(branch, law, start, remaining, tau, step, rates):
    """Return the next piece, cut where it leaves its branch.

    Return length, whether it ends at a turning point, the way to the next branch (-1, 0 or 1), a
    good length for the next step, and the state. The displacement is monotone in a piece, so no
    exit is missed. A start on a bound is an exit at once if the motion goes out, and none if it
    goes in.
    """
    length, turns, step, (x_end, v_end) = piece(branch, law, start, remaining, tau, step, rates)
    way = 0
    if length != 0.0:
        way = 1 if x_end > branch.high else -1 if x_end < branch.low else 0
    if way:
        bound = branch.high if way > 0 else branch.low
        if start[0] == bound:
            length = 0.0
        else:
            length = event(branch, law, start, DISPLACEMENT, bound, way, 0.0, length, rates)
        x_end = bound
        v_end = state(branch, law, start, length, rates)[1]
    return length, turns and way == 0, way, step, x_end, v_end


# --- the run --------------------------------------------------------------------------------------


@register_jitable
def branch_at(branches, index):
    """Return one branch of an array, shape (branches, 10)."""
    row = branches[index]
    return Branch(row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9])


@register_jitable
def load_segment(load, sampling, index, last):
    """Return begin and end of a segment of the load, the load at its begin, and its slope."""
    if index < load.size - 1:
        begin = index * sampling
        end = min((index + 1) * sampling, last)
        return begin, end, load[index], (load[index + 1] - load[index]) / sampling
    return max(load.size - 1, 0) * sampling, last, 0.0, 0.0


@register_jitable
def store(branch, law, start, origin, tau, times, count, displacement, velocity, rates):
    """Store the states of a piece at the times in it, and return the number of times up to tau."""
    while count > 0 and times[count - 1] >= origin:  # after an impact, once more
        count -= 1
    while count < times.size and times[count] <= tau:
        x, v = state(branch, law, start, times[count] - origin, rates)
        displacement[count] = x
        velocity[count] = v
        count += 1
    return count


@register_jitable
def append(rows, count, first, second):
    """Return rows with one more pair of numbers, moved to a larger array where there is no room."""
    if count == rows.shape[0]:
        larger = np.empty((2 * count, 2))
        # One by one: Numba compiles an assignment of arrays with its error messages, in seconds.
        for row in range(count):
            larger[row, 0] = rows[row, 0]
            larger[row, 1] = rows[row, 1]
        rows = larger
    rows[count, 0] = first
    rows[count, 1] = second
    return rows


@register_jitable
def impact(law, one_sided, v, p):
    """Return the velocity after a crossing of x = 0 under the load p, or after a blow on a stop."""
    if law.number == CR:
        e, g, double_reference, _ = law.parameters
        v *= restitution_factor(v, e, g, double_reference)
    if one_sided:
        # At this speed a wall would leave its stop by less than 1e-6 u_ins.
        rests = -v <= 1e-6 and p <= LIFTING
        return 0.0 if rests else -v
    return v if abs(v) > law.rest else 0.0


@register_jitable
def lift_time(p, slope):
    """Return the time until a load lifts a wall that rests at its stop; infinite if it does not."""
    if p > LIFTING:
        return 0.0
    if slope <= 0.0:
        return np.inf
    return (LIFTING - p) / slope


def integrate(branches, law, one_sided, index, x, v, load, sampling, times, displacement, velocity):
    """Move from tau = 0 to the last of `times`, or to the collapse.

    Returns the outcome, tau, x, and tau and v of the impacts and tau and x of the turning points,
    each of the shape (count, 2).

    Parameters
    ----------
    branches : ndarray, shape (branches, 10)
        Rows of `Branch`, from the left to the right; `index` is the branch of the start.
    law : Law
        Law of the damper.
    one_sided : bool
        Whether the wall bounces off a stop at x = 0.
    x, v : float
        State at tau = 0.
    load, sampling : ndarray and float
        Samples, linear between them and zero after the last, and their spacing.
    times, displacement, velocity : ndarray, shape (n,)
        Ascending times, and room for the state at each time that is reached.
    """
    impacts = np.empty((64, 2))
    turns = np.empty((64, 2))
    rates = np.zeros((2, STAGES + 1))
    impact_count = 0
    turn_count = 0
    time_count = 0
    stalled = 0
    tau = 0.0
    step = np.inf
    resting = one_sided and x == 0.0 and v == 0.0
    for segment in range(max(load.size, 1)):
        begin, stop, p, slope = load_segment(load, sampling, segment, times[-1])
        while tau < stop and 0 <= index < branches.shape[0]:
            branch = branch_at(branches, index)
            origin = tau
            remaining = stop - tau
            start = (x, v, p + slope * (tau - begin), slope)
            if resting:
                length = lift_time(start[2], slope)
                resting = length >= remaining
                start = (0.0, 0.0, 0.0, 0.0)
                turning = False
                way = 0
                if resting:
                    length = remaining
            else:
                length, turning, way, step, x, v = piece_on_branch(
                    branch, law, start, remaining, tau, step, rates
                )
                if length == 0.0 and not turning and way == 0 and branch.constant < 0.0:
                    return FAILED, tau, x, impacts[:impact_count], turns[:turn_count]
            tau = stop if length == remaining else origin + length
            time_count = store(
                branch, law, start, origin, tau, times, time_count, displacement, velocity, rates
            )
            if turning:
                v = 0.0  # to the last bit, lest the hyperbolic branch amplify its rounding
                turns = append(turns, turn_count, tau, x)
                turn_count += 1
            if way and x == 0.0 and (v != 0.0 or one_sided):
                impacts = append(impacts, impact_count, tau, v)
                impact_count += 1
                v = impact(law, one_sided, v, start[2] + slope * length)
                resting = one_sided and v == 0.0
            if not (one_sided and x == 0.0):
                index += way
            stalled = stalled + 1 if tau == origin else 0
            if stalled > 200:  # a state that balances on a corner to the last bit
                return STALLED, tau, x, impacts[:impact_count], turns[:turn_count]
    outcome = COMPLETED if 0 <= index < branches.shape[0] else COLLAPSED
    return outcome, tau, x, impacts[:impact_count], turns[:turn_count]


integrate = compile_cached(integrate, error_model="numpy", nogil=True)


# --- the laws by model ----------------------------------------------------------------------------
# A law takes curve and damping. It returns itself and the constant C on each branch from x = 0
# outwards, -1 where C is not constant.

BranchConstants = list[float]


def impact_law(curve: TrilinearCurve, damping: Damping) -> tuple[Law, BranchConstants]:
    """CR: no damping but for the impacts."""
    g, double_reference, rest = loss_parameters(curve, damping)
    return Law(CR, (float(damping.value), g, double_reference, 0.0), rest), [0.0, 0.0, 0.0]


def secant_law(
    exponent: float,
) -> Callable[[TrilinearCurve, Damping], tuple[Law, BranchConstants]]:
    """CDC, CDR, SDR: C = 2 xi w1 (k/k1)^exponent, k the secant stiffness, Eqs (10) to (12)."""

    def law(curve: TrilinearCurve, damping: Damping) -> tuple[Law, BranchConstants]:
        c = linear_coefficient(curve, damping)
        outer = c if exponent == 0.0 else -1.0
        return Law(SECANT, (c, float(curve.initial_stiffness), exponent, 0.0)), [c, outer, outer]

    return law


def energy_law(curve: TrilinearCurve, damping: Damping) -> tuple[Law, BranchConstants]:
    """ECD of order m."""
    m = float(damping.order)
    g, double_reference, rest = loss_parameters(curve, damping)
    # The integral of cos^(2m+2) over a half cycle is the beta function of m + 3/2 and 1/2.
    integral = math.pi / 2
    if m:
        integral = math.exp(math.lgamma(m + 1.5) + math.lgamma(0.5) - math.lgamma(m + 2))
    kappa = math.pi * float(damping.value) / integral
    constants = [-1.0, -1.0, -1.0]
    if m == 0.0 and g == 0.0:
        constants[0] = linear_coefficient(curve, damping)
    return Law(ECD, (kappa, m, g, double_reference), rest), constants


def band_law(curve: TrilinearCurve, damping: Damping) -> tuple[Law, BranchConstants]:
    """BAND."""
    c = float(damping.width) / math.sqrt(float(curve.initial_stiffness))
    strength = float(band_strength(math.pi * float(damping.value), damping.width))
    return Law(BAND, (0.75 * strength / c, c, 0.0, 0.0)), [-1.0, -1.0, -1.0]


def quadratic_law(curve: TrilinearCurve, damping: Damping) -> tuple[Law, BranchConstants]:
    """CQD: the first branch is split at the end of the band, beyond which nothing damps."""
    half_width = float(damping.width) * float(curve.yield_displacement_ratio)
    size = 3 * math.pi * float(damping.value) / 4
    return Law(CQD, (size, half_width, 0.0, 0.0)), [-1.0, 0.0, 0.0, 0.0]


LAWS = {
    "CR": impact_law,
    "CDC": secant_law(0.0),
    "CDR": secant_law(0.5),
    "SDR": secant_law(1.0),
    "ECD": energy_law,
    "BAND": band_law,
    "CQD": quadratic_law,
}


def linear_coefficient(curve: TrilinearCurve, damping: Damping) -> float:
    """Return C = 2 xi w1 of the linear oscillator on the first branch."""
    return 2 * math.sqrt(float(curve.initial_stiffness)) * float(damping.value)


def loss_parameters(curve: TrilinearCurve, damping: Damping) -> tuple[float, float, float]:
    """Return the loss exponent g, 2V at its reference amplitude, and `Law.rest`."""
    g = float(damping.loss_exponent)
    if g == 0.0:
        return g, 1.0, 0.0
    a3 = float(curve.ultimate_displacement_ratio)
    amplitude = damping.reference_amplitude
    check("reference_amplitude", amplitude, lambda x: x < a3, f"less than a3, {a3:g}")
    # The loss grows as the motion fades; at a speed of 1e-12 nothing is left of it.
    return g, 2 * float(curve.energy(amplitude)), 1e-12


def curve_branches(curve: TrilinearCurve, law: Law, constants: BranchConstants) -> Array:
    """Return the branches from -a3 to a3, split at x = 0 and at the ends of CQD's band."""
    k1, b1, ks, a1, a2, a3 = (float(value) for value in curve.parameters())
    segments = [(0.0, a1, k1, 0.0), (a1, a2, 0.0, b1), (a2, a3, -ks, ks * a3)]
    if law.number == CQD:
        half_width = law.parameters[1]
        segments[:1] = [(0.0, half_width, k1, 0.0), (half_width, a1, k1, 0.0)]
    # Stages of a step may pass a corner: the energy of a plateau that continues inwards is positive
    # down to a1/2.
    margin = a1 / 4
    rows: list[Branch] = []
    for constant, (low, high, k, offset) in zip(constants, segments, strict=True):
        inner_double_v = 2 * float(curve.energy(low))
        inner = (low - margin, b1 + ks * margin, low, k * low + offset, inner_double_v)
        mirrored = Branch(-high, -low, k, -offset, constant, *inner)
        rows = [mirrored, *rows, Branch(low, high, k, offset, constant, *inner)]
    return np.array(rows)


# --- the public function --------------------------------------------------------------------------


@dataclass(frozen=True)
class ExactHistory:
    """One time history at given times.

    Attributes
    ----------
    times : ndarray, shape (n,)
        Times tau. [-]
    displacement, velocity : ndarray, shape (n,)
        u/u_ins and its derivative by tau; NaN after a collapse. At the time of an impact the
        velocity is that after it. [-]
    impacts : ndarray
        Times tau of the crossings of u = 0, with any damper; for a one-sided wall, of the blows on
        its stop. [-]
    turning_tau, turning_displacement : ndarray
        Times of the turning points after the release, and u/u_ins there: the signed peaks of a free
        decay. [-]
    peak, peak_tau : float
        Largest |u|/u_ins, a3 after a collapse, and its time. [-]
    collapsed : bool
        Whether |u| went beyond u3.
    end_tau : float
        Time of the end of the run, or of the collapse. [-]
    """

    times: Array
    displacement: Array
    velocity: Array
    impacts: Array
    turning_tau: Array
    turning_displacement: Array
    peak: float
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
    """Solve x'' + C(x, x') x' + f(x) = load for one wall and one damper, with Eq. (8) for CR.

    Parameters
    ----------
    curve : TrilinearCurve
        Force-displacement curve, of plain numbers.
    damping : Damping
        Damping, of plain numbers.
    times : ndarray, shape (n,)
        Ascending times tau >= 0 at which the history is given; the last is the end of the run. [-]
    release_amplitude, release_velocity : float
        u/u_ins and its derivative with respect to tau, at tau = 0. The default is 0. [-]
    load : ndarray, shape (samples,), optional
        `Wall.load_factor` times the ground acceleration; linear between its samples, and zero after
        the last. By default the wall decays freely. [-]
    sampling : float
        Time between two samples of the load, in tau. [-]
    one_sided : bool
        Whether the wall rocks to u >= 0 only, away from a rigid stop: an impact turns the velocity
        v into -e v. A wall whose bounces die out under the load comes to rest, until the load lifts
        it again. Only with CR. The default is False.

    Raises
    ------
    InputError
        If the release lies beyond the curve, or a one-sided wall has a viscous damper.
    ArithmeticError
        If the motion makes no progress, or no step meets its tolerance.

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
    side = "and at least 0" if one_sided else "to either side"
    x = check_number(
        "release_amplitude",
        release_amplitude,
        lambda x: (abs(x) < a3) & ((x >= 0) | (not one_sided)),
        f"less than a3, {a3:g}, {side}",
    )
    finite = "a finite number"
    v = check_number("release_velocity", release_velocity, np.isfinite, finite)
    times = np.atleast_1d(check("times", times, lambda t: t >= 0, "at least 0"))
    check("step from one time to the next", np.diff(times), lambda h: h >= 0, "at least 0")
    load = check("load", np.empty(0) if load is None else load, np.isfinite, finite)
    allowed = "greater than 0 with a load"
    sampling = check_number("sampling", sampling, lambda h: (h > 0) | (load.size < 2), allowed)
    law, constants = LAWS[damping.model](curve, damping)
    branches = curve_branches(curve, law, constants)
    if one_sided:
        branches = branches[len(branches) // 2 :]
    # From a corner the motion goes to the branch ahead, lest a start at x = 0 be an impact.
    goes_left = v < 0 and not one_sided
    index = int(np.searchsorted(branches[1:, 0], x, side="left" if goes_left else "right"))
    displacement = np.full(times.shape, np.nan)
    velocity = np.full(times.shape, np.nan)
    displacement[times == 0.0] = x
    velocity[times == 0.0] = v
    outcome, tau, x_end, impacts, turns = integrate(
        branches, law, one_sided, index, x, v, load, sampling, times, displacement, velocity
    )
    if outcome in FAILURES:
        raise ArithmeticError(f"{FAILURES[outcome]} at tau = {tau:.9g}, x = {x_end:.9g}")
    turning_tau, turning_displacement = turns.T
    extremes = np.abs([x, *turning_displacement, x_end])
    extreme_times = [0.0, *turning_tau, tau]
    largest = int(extremes.argmax())
    return ExactHistory(
        times,
        displacement,
        velocity,
        impacts[:, 0],
        turning_tau,
        turning_displacement,
        peak=float(extremes[largest]),
        peak_tau=float(extreme_times[largest]),
        collapsed=outcome == COLLAPSED,
        end_tau=tau,
    )
