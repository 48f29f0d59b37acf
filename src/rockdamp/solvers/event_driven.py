"""Event-driven reference solutions: no step of the kernel's is used here, so that each can be checked by the other.

The tri-linear law is linear on each branch. Where the damping coefficient is constant (CR and CDC everywhere, most
other dampers inside a1) a piece of the motion has a closed form under a load that is linear in time; elsewhere it is
integrated by DOP853 near rounding, with the damper's law, which is not the kernel's formula. Pieces end at the
branches' corners, at x = 0 and at the samples of the load, so the right-hand side is smooth in each.

Dimensionless as in the kernels: x = u/u_ins, tau = p t, unit mass.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike
from scipy.integrate import DOP853
from scipy.optimize import brentq
from scipy.special import hyp1f1

from rockdamp.arguments import number, numbers
from rockdamp.arrays import Array
from rockdamp.errors import InputError, require
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping, Viscous

Time = Any  # a float, or an array of them
State = Callable[[Time], tuple[Time, Time]]
Coefficient = float | Callable[[float, float], float]

TOLERANCE = 1e-13  # relative, of DOP853
ROOT = {"xtol": 1e-15, "rtol": 1e-15}  # of brentq; its times count from the start of a piece
LEAST = 1e-100  # |x| for a damper's law, which may divide by it or by the energy there
STALLED = 50  # pieces without progress before giving up: a state that balances on a corner to the last bit

# DOP853's continuous extension is of degree 7: eight Chebyshev points hold it.
NODES = chebyshev.chebpts1(8)
TO_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(NODES, 7))


@dataclass(frozen=True)
class ExactHistory:
    """One time history, at the times asked for.

    Attributes
    ----------
    times : ndarray, shape (n,)
        tau. [-]
    displacement, velocity : ndarray, shape (n,)
        u/u_ins and its derivative by tau, after the impact where a time is an impact's; NaN after a collapse. [-]
    impacts : ndarray
        tau of the crossings of u = 0, whatever the damper. [-]
    turning_tau, turning_displacement : ndarray
        Where the velocity changes sign after the release: the signed peaks of a free decay. [-]
    outcome : {"completed", "collapsed"}
        Collapsed: |u| went beyond u3 and the run ended.
    outcome_tau : float
        tau of the end. [-]
    """

    times: Array
    displacement: Array
    velocity: Array
    impacts: Array
    turning_tau: Array
    turning_displacement: Array
    outcome: str
    outcome_tau: float


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
    """Solve x'' + C(x) x' + f(x) = load from tau = 0, with Eq. (8) at each impact for CR.

    Parameters
    ----------
    curve, damping : TrilinearCurve, Damping
        One wall and one damper: no array parameters.
    times : ndarray, shape (n,)
        tau at which the history is wanted, ascending from 0 or later; the last is the end of the run. [-]
    release_amplitude, release_velocity : float
        x and x' at tau = 0. [-]
    load : ndarray, shape (samples,)
        Dimensionless load, `Wall.load_factor` times the ground acceleration: linear between its samples, the first of
        them at tau = 0, and zero after the last. [-]
    load_step : float
        Spacing of the samples in tau; needed where there is a load. [-]

    Raises
    ------
    InputError
        If a value lies outside its range.
    """
    times, load = np.atleast_1d(np.asarray(times, dtype=float)), np.asarray(load, dtype=float)
    _check(curve, damping, times, release_amplitude, release_velocity, load, load_step)
    branches = _branches(curve, damping)
    x, v = float(release_amplitude), float(release_velocity)
    # From a corner the motion goes to the branch ahead, lest a start at x = 0 be an impact.
    at = int(np.searchsorted([branch.low for branch in branches[1:]], x, side="left" if v < 0 else "right"))
    run = _Run(times, branches, float(damping.restitution) if damping.is_impact else 1.0, x, v, at)
    for segment in _segments(load, float(load_step or 0.0), float(times[-1])):
        if not run.collapsed:
            run.cross(segment)
    turning_tau, turning_displacement = np.reshape(run.turns, (-1, 2)).T
    return ExactHistory(
        times,
        run.displacement,
        run.velocity,
        np.array(run.impacts),
        turning_tau,
        turning_displacement,
        "collapsed" if run.collapsed else "completed",
        run.tau,
    )


def cr_peaks(curve: TrilinearCurve, restitution: float, release_amplitude: float, count: int) -> Array:
    """Return the first `count` peaks |x_n| of a free CR decay after a release from rest: V(x_n) = e^(2n) V(x0). [-]

    Raises
    ------
    InputError
        If e is outside (0, 1] or the release is at or beyond a3.
    """
    Damping.cr(restitution)
    x0 = np.abs(np.asarray(release_amplitude, dtype=float))
    require(x0 < curve.ultimate_ratio, "release_amplitude", x0, "less than a3, where the wall collapses")
    return curve.amplitude(restitution ** (2 * np.arange(1, count + 1)) * curve.energy(x0))


def _check(
    curve: TrilinearCurve, damping: Damping, times: Array, x0: float, v0: float, load: Array, load_step: float | None
) -> None:
    if curve.shape or damping.shape:
        raise InputError(f"the curve's or damper's shape is {curve.shape or damping.shape}; it must be one of each")
    for name, value in (("times", times), ("release_amplitude", x0), ("release_velocity", v0), ("load", load)):
        numbers(name, value)
    require(times.size > 0, "the number of times", times.size, "at least 1")
    require(times >= 0, "times", times, "at least 0")
    require(np.diff(times) >= 0, "times", times[1:], "ascending")
    require(np.abs(x0) < curve.ultimate_ratio, "release_amplitude", x0, "less than a3, where the wall collapses")
    require(load.ndim == 1, "the load's number of dimensions", load.ndim, "1")
    if load.size:
        spacing = number("load_step", np.nan if load_step is None else load_step)
        require(spacing > 0, "load_step", spacing, "greater than 0")


# --- the run: pieces, branches and segments of the load -------------------------------------------------------------


class _Segment(NamedTuple):
    """A stretch of time over which the load is p + slope (tau - start)."""

    start: float
    stop: float
    p: float
    slope: float


class _Piece(NamedTuple):
    """A stretch of the motion on one branch in which x is monotone; `turns` if the velocity changes sign at its end."""

    start: float
    stop: float
    state: State
    turns: bool


class _Run:
    """The state that moves on, and what has been observed of it."""

    def __init__(self, times: Array, branches: list[_Branch], restitution: float, x: float, v: float, at: int) -> None:
        self.times, self.branches, self.restitution = times, branches, restitution
        self.moments = times.tolist()  # to look one up in an array takes ten times as long
        self.tau, self.x, self.v, self.at = 0.0, x, v, at
        self.displacement, self.velocity = np.full(times.shape, np.nan), np.full(times.shape, np.nan)
        self.displacement[times == 0.0], self.velocity[times == 0.0] = x, v
        self.impacts: list[float] = []
        self.turns: list[tuple[float, float]] = []

    @property
    def collapsed(self) -> bool:
        return not 0 <= self.at < len(self.branches)

    def cross(self, segment: _Segment) -> None:
        """Advance to the end of `segment`, from branch to branch, or to the collapse."""
        stalled = 0
        while self.tau < segment.stop and not self.collapsed:
            before = self.tau
            way = self.follow(self.branches[self.at], segment)
            self.at += way
            if way and self.x == 0.0 and self.v != 0.0:
                self.impacts.append(self.tau)
                self.v *= self.restitution  # Eq. (8)
            stalled = stalled + 1 if self.tau == before else 0
            if stalled > STALLED:
                raise ArithmeticError(f"no progress at tau = {self.tau:.9g}, x = {self.x:.9g}")

    def follow(self, branch: _Branch, segment: _Segment) -> int:
        """Stay on `branch` up to a turn, its end or the segment's; return -1 or 1 if left at low or high, else 0."""
        origin, times = self.tau, self.times
        p = segment.p + segment.slope * (origin - segment.start)
        for piece in branch.pieces(self.x, self.v, p, segment.slope, segment.stop - origin):
            end, x, v, way = _exit(piece, branch.low, branch.high)
            self.tau = segment.stop if end == segment.stop - origin else origin + end
            first, last = bisect_left(self.moments, origin + piece.start), bisect_right(self.moments, self.tau)
            if last > first:
                self.displacement[first:last], self.velocity[first:last] = piece.state(times[first:last] - origin)
            turns = piece.turns and not way
            # A turn is at rest to the last bit: from there on, the hyperbolic branch does not amplify rounding.
            self.x, self.v = (branch.low, float(x), branch.high)[way + 1], 0.0 if turns else float(v)
            if turns:
                self.turns.append((self.tau, self.x))
            if turns or way:
                return way
        return 0


def _exit(piece: _Piece, low: float, high: float) -> tuple[float, float, float, int]:
    """Return when x leaves [low, high], x and v then, and where (-1 low, 1 high); or the piece's end and 0.

    As x is monotone no exit is missed. A start on a bound is none unless the motion goes out.
    """
    x, v = piece.state(piece.stop)
    if low <= x <= high:
        return piece.stop, x, v, 0
    bound, way = (high, 1) if x > high else (low, -1)
    end = float(brentq(lambda t: piece.state(t)[0] - bound, piece.start, piece.stop, **ROOT))
    return end, *piece.state(end), way


def _segments(load: Array, step: float, end: float) -> Iterator[_Segment]:
    """Split [0, end] at the samples of the load."""
    for i, (p, after) in enumerate(pairwise(load.tolist())):
        if i * step >= end:
            return
        yield _Segment(i * step, min((i + 1) * step, end), p, (after - p) / step)
    rest = max(load.size - 1, 0) * step
    if rest < end:
        yield _Segment(rest, end, 0.0, 0.0)


# --- the branches ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Branch:
    """One branch on one side of x = 0: f = stiffness x + offset for low <= x <= high.

    `coefficient` is C, a number or a function of x and v that goes on smoothly for `margin` beyond the branch's inner
    end; `largest_force` bounds |f| there.
    """

    low: float
    high: float
    stiffness: float
    offset: float
    coefficient: Coefficient
    margin: float
    largest_force: float

    def pieces(self, x: float, v: float, p: float, slope: float, duration: float) -> Iterator[_Piece]:
        """Yield the motion from (x, v) under the load p + slope t as if the branch had no end."""
        if callable(self.coefficient):
            return self._integrated(self.coefficient, x, v, p, slope, duration)
        return iter([_closed_form(x, v, self.coefficient, self.stiffness, p - self.offset, slope, duration)])

    def _integrated(
        self, c: Callable[[float, float], float], x: float, v: float, p: float, slope: float, duration: float
    ) -> Iterator[_Piece]:
        def rates(t: float, state: Array) -> tuple[float, float]:
            x, v = state.tolist()
            return v, p + slope * t - self.stiffness * x - self.offset - c(x, v) * v

        inner = min(abs(self.low), abs(self.high)) - self.margin
        pull = self.largest_force + max(abs(p), abs(p + slope * duration))
        solver = DOP853(rates, 0.0, [x, v], duration, rtol=TOLERANCE, atol=1e-3 * TOLERANCE)
        while solver.status == "running":
            # No stage of a step may look beyond the margin: |x| falls by at most |v| h + pull h^2/2 in it.
            reach, speed = abs(solver.y[0]) - inner, abs(solver.y[1])
            solver.max_step = 2 * reach / (speed + math.sqrt(speed**2 + 2 * pull * reach))
            message = solver.step()
            if solver.status == "failed":
                raise ArithmeticError(f"DOP853 failed at x = {solver.y[0]:.9g}: {message}")
            state = solver.dense_output()
            turn = _first_turn(state, solver.t_old, solver.t)
            yield _Piece(solver.t_old, solver.t if turn is None else turn, state, turn is not None)


def _branches(curve: TrilinearCurve, damping: Damping) -> list[_Branch]:
    """Return the six branches from -a3 to a3, split at x = 0."""
    k1, b1, ks, a1, a2, a3 = (float(value) for value in curve.parameters())
    margin = a1 / 4  # a plateau that goes on inwards has energy down to a1/2
    shapes = [(0.0, a1, k1, 0.0), (a1, a2, 0.0, b1), (a2, a3, -ks, ks * a3)]
    laws = [(*shape, _coefficient(curve, damping, index, *shape)) for index, shape in enumerate(shapes)]
    largest = b1 + ks * margin
    right = [_Branch(*law, margin, largest) for law in laws]
    left = [_Branch(-high, -low, k, -offset, c, margin, largest) for low, high, k, offset, c in reversed(laws)]
    return left + right


def _coefficient(
    curve: TrilinearCurve, damping: Damping, index: int, low: float, high: float, k: float, offset: float
) -> Coefficient:
    """C on the branch of number `index` from x = 0: not taken from `Damping.coefficient`, which has corners."""
    if not isinstance(damping, Viscous):
        return 0.0
    k1 = float(curve.initial_stiffness)
    if index < damping.constant_branches:
        return 2 * math.sqrt(k1) * float(damping.damping_ratio)
    law, double_v, f_low = damping.law(k1), 2 * float(curve.energy(low)), k * low + offset

    def coefficient(x: float, v: float) -> float:
        z = max(abs(x), LEAST)
        f = max(k * z + offset, 0.0)
        return law(z, f, double_v + (f + f_low) * (z - low), v)  # 2V: the area of a trapezoid further than at `low`

    return coefficient


# --- closed form ----------------------------------------------------------------------------------------------------


def _closed_form(x: float, v: float, c: float, k: float, q: float, slope: float, duration: float) -> _Piece:
    """Solve x'' + c x' + k x = q + slope t from (x, v), for k of either sign or zero, up to the first turn."""
    a = q - c * v - k * x
    jerk = slope - c * a - k * v

    def state(t: Time) -> tuple[Time, Time]:
        # The acceleration solves the homogeneous equation: a (g' + c g) + jerk g, integrated once and twice.
        g, g1, g2 = _responses(c, k, t)
        return x + v * t + a * (g1 + c * g2) + jerk * g2, v + a * (g + c * g1) + jerk * g1

    # Between zeros of the acceleration the velocity is monotone: it has one zero where its sign changes.
    for start, stop in pairwise([0.0, *_acceleration_zeros(c, k, a, jerk, duration), duration]):
        if state(start)[1] * state(stop)[1] < 0:
            return _Piece(0.0, float(brentq(lambda t: state(t)[1], start, stop, **ROOT)), state, True)
    return _Piece(0.0, duration, state, False)


def _responses(c: float, k: float, t: Time) -> tuple[Time, Time, Time]:
    """Return the impulse response g of x'' + c x' + k x, and its first and second integrals from 0 to t."""
    lib = math if isinstance(t, float) else np  # one time after the other, math is ten times faster
    if k == 0.0:  # t^n phi_n(-c t), well conditioned down to c = 0
        return tuple(t**n * hyp1f1(1, n + 1, -c * t) / math.factorial(n) for n in (1, 2, 3))
    half, disc = c / 2, c * c / 4 - k
    if disc < 0:
        w, decay = math.sqrt(-disc), lib.exp(-half * t)
        g, even = decay * lib.sin(w * t) / w, decay * lib.cos(w * t)
    else:
        d = math.sqrt(disc)
        slow = lib.exp(-k / (d + half) * t)  # the rate -half + d, without its cancellation
        g = -slow * lib.expm1(-2 * d * t) / (2 * d) if d else slow * t
        even = slow * (1 + lib.exp(-2 * d * t)) / 2
    first = (1 - even - half * g) / k  # g' = even - half g, and g' - 1 + c g + k first = 0
    return g, first, (t - c * first - g) / k


def _acceleration_zeros(c: float, k: float, a: float, jerk: float, duration: float) -> list[float]:
    """Times in (0, duration) at which an acceleration that starts from a with slope jerk vanishes."""
    half, disc = c / 2, c * c / 4 - k
    b = jerk + half * a  # exp(-half t) (a cos w t + b/w sin w t), or the same with cosh and sinh
    if a == 0.0 and b == 0.0:
        return []
    if disc < 0:
        w = math.sqrt(-disc)
        zeros = np.arange(math.atan2(-a * w, b) % math.pi / w, duration, math.pi / w)
        return [t for t in zeros.tolist() if t > 0.0]
    d = math.sqrt(disc)
    if a * b >= 0 or d * abs(a) >= abs(b):
        return []
    zero = math.atanh(-d * a / b) / d if d else -a / b
    return [zero] if zero < duration else []


def _first_turn(state: State, start: float, stop: float) -> float | None:
    """Time in (start, stop) at which the velocity of a step's continuous extension first vanishes, if it does."""
    middle, half = (start + stop) / 2, (stop - start) / 2
    coefficients = TO_COEFFICIENTS @ state(middle + half * NODES)[1]
    if abs(coefficients[0]) > np.abs(coefficients[1:]).sum():  # the polynomials are within 1: no zero
        return None
    roots = chebyshev.chebroots(coefficients)
    real = np.sort(roots[np.abs(roots.imag) < 1e-10].real)
    # A zero at the very start is a release from rest or the last turn: the velocity does not change sign there.
    inside = [t for t in (middle + half * real).tolist() if start + 1e-9 * half < t < stop]
    return inside[0] if inside else None
