"""The motion under ECD of order m, integrated in (x, v) by means of its own: of the package's only the curve and xi.

The damper is written as an engineer would, C = 2 xi N (abs(f)/sqrt(2V)) (T/(T+V))^m, in a form that goes on smoothly
beyond the ends of a branch, so that each branch is integrated on its own, to a corner, a crossing or a turn.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import mpmath
import numpy as np
from scipy.integrate import solve_ivp

from rockdamp.mechanics.half_cycle_loss import damping_ratio, normalisation


class Branch(NamedTuple):
    """f = stiffness z + offset at z = abs(x) from low to high, and V = stored at low."""

    low: float
    high: float
    stiffness: float
    offset: float
    stored: float

    def force(self, z):
        return self.stiffness * z + self.offset

    def double_energy(self, z):
        return 2 * self.stored + (self.force(z) + self.force(self.low)) * (z - self.low)


def branches(curve):
    """Return the three branches of one tri-linear curve."""
    k1, b1, ks, a1, a2, a3 = (float(value) for value in curve.parameters())
    at_a1 = k1 * a1 * a1 / 2
    return [
        Branch(0.0, a1, k1, 0.0, 0.0),
        Branch(a1, a2, 0.0, b1, at_a1),
        Branch(a2, a3, -ks, ks * a3, at_a1 + b1 * (a2 - a1)),
    ]


@dataclass
class Damper:
    """C over m_eff p of one branch; `amplitude` is 2 xi N_m."""

    amplitude: float
    order: float

    def coefficient(self, branch, z, v):
        double_v = branch.double_energy(z) if branch.low else branch.stiffness * z * z
        total = v * v + double_v
        if total <= 0:
            return 0.0
        frequency = branch.force(z) / math.sqrt(max(double_v, 1e-300)) if branch.low else math.sqrt(branch.stiffness)
        return self.amplitude * frequency * (v * v / total) ** self.order


def of_restitution(e, order):
    """Return the damper that loses in a half cycle what an impact of e loses."""
    return Damper(2 * float(damping_ratio(-np.log(e), order) * normalisation(order)), order)


class Turn(NamedTuple):
    """Where and when a half cycle ends, and how fast it crossed x = 0."""

    displacement: float
    duration: float
    crossing_speed: float


def half_cycle(curve, damper, x0, beyond=None, tolerance=1e-12):
    """Follow the motion from rest at x0 > 0 to the next turn, over x = 0; `beyond` is the curve and damper at x < 0."""
    other_curve, other_damper = beyond or (curve, damper)
    sides = {1: (branches(curve), damper), -1: (branches(other_curve), other_damper)}
    at = max(i for i, branch in enumerate(sides[1][0]) if branch.low < x0)
    state, elapsed, side, crossing = np.array([x0, 0.0]), 0.0, 1, 0.0
    while True:
        branch = sides[side][0][at]
        goal = branch.low if side == 1 else branch.high
        state, duration, turned = _piece(branch, side, sides[side][1], state, goal, tolerance)
        elapsed += duration
        if turned:
            return Turn(abs(float(state[0])), elapsed, crossing)
        if side == 1 and at == 0:
            side, crossing = -1, abs(float(state[1]))
        else:
            at -= side


def _piece(branch, side, damper, state, goal, tolerance):
    def rates(_, y):
        x, v = y.tolist()
        z = side * x
        return v, -side * branch.force(z) - damper.coefficient(branch, z, v) * v

    def reaches(_, y):
        return side * y[0] - goal

    def turns(t, y):
        return y[1] if t > 0 else -1.0

    reaches.terminal = turns.terminal = True
    turns.direction = 1
    # Events are found on the step's interpolant, whose error no tolerance controls: hence short steps.
    accuracy = {"rtol": tolerance, "atol": 1e-3 * tolerance * max(abs(state)), "max_step": 0.02}
    run = solve_ivp(rates, (0, 1e3), state, "DOP853", events=(reaches, turns), **accuracy)
    assert run.status == 1, run.message
    turned = bool(run.t_events[1].size)
    end = run.y_events[1 if turned else 0][0]
    return np.array([end[0] if turned else side * goal, end[1]]), float(run.t[-1]), turned


def precise_half_cycle(force, double_energy, frequency, amplitude, order, x0, digits=30, step=0.05):
    """The same in mpmath, for a law without corners: extrapolated midpoint steps, the last one by Newton's to v = 0."""
    with mpmath.workdps(digits):
        amplitude, order = mpmath.mpf(amplitude), mpmath.mpf(order)

        def rates(x, v):
            total = v * v + double_energy(x)
            return v, -force(x) - amplitude * frequency(x) * (v * v / total) ** order * v

        state, h = (mpmath.mpf(x0), mpmath.mpf(0)), mpmath.mpf(step)
        while True:
            after = _extrapolated(rates, state, h)
            if after[1] > 0:  # past the turn: shorten the step until it ends there
                for _ in range(60):
                    if abs(after[1]) < mpmath.mpf(10) ** (8 - digits):
                        return -after[0]
                    h -= after[1] / rates(*after)[1]
                    after = _extrapolated(rates, state, h)
                raise ArithmeticError(f"no turn found near x = {mpmath.nstr(after[0], 10)}")
            state = after


def _extrapolated(rates, state, h, columns=14):
    """One step of Gragg's modified midpoint rule, extrapolated in the square of the substep."""
    rows = []
    for k in range(1, columns + 1):
        n = 2 * k
        s, (x0, v0) = h / n, state
        r = rates(x0, v0)
        x1, v1 = x0 + s * r[0], v0 + s * r[1]
        for _ in range(n - 1):
            r = rates(x1, v1)
            x0, v0, x1, v1 = x1, v1, x0 + 2 * s * r[0], v0 + 2 * s * r[1]
        r = rates(x1, v1)
        row = [((x0 + x1 + s * r[0]) / 2, (v0 + v1 + s * r[1]) / 2)]
        for j, previous in enumerate(rows[-1] if rows else (), start=1):
            ratio = mpmath.mpf(k) ** 2 / mpmath.mpf(k - j) ** 2 - 1
            row.append(tuple(new + (new - old) / ratio for new, old in zip(row[-1], previous, strict=True)))
        rows.append(row)
    return rows[-1][-1]


def forced_peak(curve, damper, load, step=1e-3):
    """First turn of the motion from rest at x = 0 under the load p(tau) >= 0, by steps of Runge and Kutta's."""
    parts = branches(curve)

    def rates(tau, x, v):
        branch = next(part for part in parts if x <= part.high)
        return v, load(tau) - branch.force(x) - damper.coefficient(branch, x, v) * v

    tau, x, v = 0.0, 0.0, 0.0
    while True:
        a = rates(tau, x, v)
        b = rates(tau + step / 2, x + step / 2 * a[0], v + step / 2 * a[1])
        c = rates(tau + step / 2, x + step / 2 * b[0], v + step / 2 * b[1])
        d = rates(tau + step, x + step * c[0], v + step * c[1])
        x_end, v_end = (old + step / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]) for i, old in enumerate((x, v)))
        if v_end <= 0:
            return x + step * v * v / (v - v_end) / 2
        tau, x, v = tau + step, x_end, v_end
