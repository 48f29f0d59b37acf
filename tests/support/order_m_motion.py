"""The motion under ECD of order m, integrated in (x, v).

Only the curve and xi come from the package. The damper is written as an engineer would, C = w q/(1
- q s) with w = abs(f)/sqrt(2V), q = 2 xi N (T/(T+V))^m and s = sqrt(T V)/(T+V), in a form that goes
on smoothly beyond the ends of a branch. So each branch is integrated on its own, to a corner, a
crossing or a turn.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from rockdamp.mechanics.half_cycle_loss import normalisation


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
    energy = k1 * a1 * a1 / 2
    return [
        Branch(0.0, a1, k1, 0.0, 0.0),
        Branch(a1, a2, 0.0, b1, energy),
        Branch(a2, a3, -ks, ks * a3, energy + b1 * (a2 - a1)),
    ]


@dataclass
class Damper:
    """C over m_eff p of one branch; `amplitude` is 2 xi N_m, and order 0 has no denominator."""

    amplitude: float
    order: float

    def coefficient(self, branch, z, v):
        """Return C at z = abs(x) and v away from x = 0."""
        if branch.low:
            root = math.sqrt(max(branch.double_energy(z), 1e-300))
            frequency = branch.force(z) / root
        else:
            frequency = math.sqrt(branch.stiffness)
            root = frequency * z
        total = v * v + root * root
        if total <= 0:
            return 0.0
        q = self.amplitude * (v * v / total) ** self.order
        if self.order == 0:
            return q * frequency
        return q * frequency / (1 - q * v * root / total)


def of_restitution(e, order):
    """Return the damper that loses in a half cycle what an impact of e loses."""
    delta = -math.log(e)
    xi = delta / math.pi if order else delta / math.hypot(math.pi, delta)
    return Damper(2 * float(normalisation(order)) * xi, order)


class Turn(NamedTuple):
    """Where and when a half cycle ends, and how fast it crossed x = 0."""

    displacement: float
    duration: float
    crossing_speed: float


def half_cycle(curve, damper, x0, beyond=None, tolerance=1e-12):
    """Follow the motion from rest at x0 > 0 over x = 0 to the next turn.

    `beyond` is the curve and the damper at x < 0.
    """
    other_curve, other_damper = beyond or (curve, damper)
    sides = {1: (branches(curve), damper), -1: (branches(other_curve), other_damper)}
    number = max(i for i, branch in enumerate(sides[1][0]) if branch.low < x0)
    state = np.array([x0, 0.0])
    elapsed = 0.0
    side = 1
    crossing_speed = 0.0
    while True:
        side_branches, side_damper = sides[side]
        branch = side_branches[number]
        goal = branch.low if side == 1 else branch.high
        state, duration, turns = _follow(branch, side, side_damper, state, goal, tolerance)
        elapsed += duration
        if turns:
            return Turn(abs(float(state[0])), elapsed, crossing_speed)
        if side == 1 and number == 0:
            side = -1
            crossing_speed = abs(float(state[1]))
        else:
            number -= side


def _follow(branch, side, damper, state, goal, tolerance):
    """Return the state and the time at the end of a branch, and whether the motion turns there."""

    def rates(_, y):
        x, v = y.tolist()
        z = side * x
        return v, -side * branch.force(z) - damper.coefficient(branch, z, side * v) * v

    def reach(_, y):
        return side * y[0] - goal

    def turn(t, y):
        return y[1] if t > 0 else -1.0

    reach.terminal = True
    turn.terminal = True
    turn.direction = 1
    # Events are found on a step's interpolant, whose error no tolerance controls: steps are short.
    accuracy = {"rtol": tolerance, "atol": 1e-3 * tolerance * max(abs(state)), "max_step": 0.02}
    solution = solve_ivp(rates, (0, 1e3), state, "DOP853", events=(reach, turn), **accuracy)
    assert solution.status == 1, solution.message
    duration = float(solution.t[-1])
    if solution.t_events[1].size:
        return solution.y_events[1][0], duration, True
    speed = solution.y_events[0][0][1]
    return np.array([side * goal, speed]), duration, False


def forced_peak(curve, damper, load, end):
    """Return the first turn from rest at x = 0 under p(tau) >= 0, which stops at `end`."""
    parts = branches(curve)

    def rates(tau, state):
        x, v = state.tolist()
        branch = next(part for part in parts if x <= part.high)
        return v, load(tau) - branch.force(x) - damper.coefficient(branch, x, v) * v

    def turn(tau, state):
        return state[1] if tau > 0 else 1.0

    turn.terminal = True
    turn.direction = -1
    options = {"rtol": 1e-8, "atol": 1e-10, "max_step": end / 50}
    solution = solve_ivp(rates, (0, 1e3), [0.0, 0.0], "RK45", events=turn, **options)
    return float(solution.y_events[0][0][0])
