"""Simulate free-rocking tests by an integrator that shares no code with the package: SciPy's DOP853 with events.

`.venv/bin/python tools/free_rocking_tests.py` writes the examples: two releases of one specimen. Forces and masses are
in N and kg, by the paper's Eqs. (2), (5), (6) and Section 3; the law of loss and its damper are of docs/theory.md,
section 8.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

FOLDER = Path(__file__).resolve().parents[1] / "examples"
GRAVITY, DENSITY = 9.80665, 1800.0
ACCURACY = {"method": "DOP853", "rtol": 1e-9, "atol": 1e-12}
AT = 0.3  # u/u_ins that e belongs to, where the loss has an exponent
CAP = 0.95  # of the damper's kappa cos^(2m+1) sin


@dataclass(frozen=True)
class Specimen:
    """A wall with its curve and its loss at impacts, or with an order the damper of the law of loss in place of them.

    With an exponent g, e is that of `AT`; at order 0 without an exponent the damper is ECD.
    """

    thickness: float
    height: float
    hinge_ratio: float
    overburden_ratio: float
    a1: float
    b1: float
    e: float
    scatter: float = 0.0  # standard deviation of ln e from impact to impact
    g: float = 0.0
    order: float | None = None

    @property
    def constants(self) -> tuple[float, float, float]:
        """F0 [N] and K0 [N/m] of the rigid wall, and its effective mass [kg]; of a strip one metre wide."""
        mass = DENSITY * self.thickness * self.height
        weight, load = mass * GRAVITY, self.overburden_ratio * mass * GRAVITY
        low, high = self.hinge_ratio * self.height, (1 - self.hinge_ratio) * self.height
        strength = 2 * (weight + load) * self.thickness / low + load * self.thickness / high
        return strength, 2 * (weight + load) / low + 2 * load / high, 2 * mass / 3

    @property
    def u_ins(self) -> float:
        """Displacement at which the rigid wall collapses. [m]"""
        strength, stiffness, _ = self.constants
        return strength / stiffness

    def force(self, u: float) -> float:
        """Restoring force of the tri-linear law, a3 = 1. [N]"""
        strength, stiffness, _ = self.constants
        yielded = self.b1 * strength
        size = min(yielded * abs(u) / (self.a1 * self.u_ins), yielded, strength - stiffness * abs(u))
        return float(np.copysign(max(size, 0.0), u))

    def stored(self, u: float) -> float:
        """Energy that is stored at a displacement. [J]"""
        strength, stiffness, _ = self.constants
        size, bends = abs(u), (self.a1 * self.u_ins, (1 - self.b1) * self.u_ins)
        ends = [0.0, *(bend for bend in bends if bend < size), size]
        forces = [self.force(end) for end in ends]
        return sum((a + b) / 2 * (y - x) for a, b, x, y in zip(forces, forces[1:], ends, ends[1:], strict=False))

    def lost(self, energy: float, deviation: float) -> float:
        """ln e of the impact, or of the half cycle, at an energy [J], with a deviation from the law."""
        if not self.g:
            return min(math.log(self.e) + deviation, 0.0)
        change = (self.stored(AT * self.u_ins) / energy) ** self.g * math.expm1(2 * self.g * math.log(self.e))
        return min(math.log1p(change) / (2 * self.g) + deviation, 0.0) if change > -1 else -math.inf

    def taken(self, energy: float, lost: float) -> float:
        """What a half cycle takes of E^g/(2g) [J^g], or of ln E/2, by its ln e."""
        return -(energy**self.g) * math.expm1(2 * self.g * lost) / (2 * self.g) if self.g else -lost

    def damping(self, u: float, v: float, taken: float) -> float:
        """C/m of the damper that has an order, by what it takes in a half cycle. [1/s]"""
        _, _, mass = self.constants
        moving, stored, m = mass * v * v / 2, self.stored(u), self.order or 0.0
        energy = moving + stored
        frequency = abs(self.force(u)) / math.sqrt(2 * stored * mass) if stored > 0 else self.first
        if not self.order and not self.g:
            return 2 * frequency * taken / math.hypot(math.pi, taken)
        kappa = taken / energy**self.g / math.sqrt(math.pi) * math.gamma(m + 2) / math.gamma(m + 1.5)
        q, outwards = kappa * (moving / energy) ** m, math.copysign(math.sqrt(moving * stored) / energy, u * v)
        return frequency * q / (1 - min(q * outwards, CAP))

    @property
    def first(self) -> float:
        """Frequency on the first branch. [rad/s]"""
        strength, _, mass = self.constants
        return math.sqrt(self.b1 * strength / (self.a1 * self.u_ins) / mass)

    def acceleration(self, u: float, v: float, taken: float = 0.0) -> float:
        """Acceleration of free motion. [m s-2]"""
        _, _, mass = self.constants
        if self.order is not None:
            return -self.force(u) / mass - self.damping(u, v, taken) * v
        return -self.force(u) / mass


def decay(specimen: Specimen, release: float, step: float, longest: float, least: float, random: Any):
    """Return the displacement from the release on [m], at intervals of `step` [s], and e of each impact.

    It ends after the time `longest` [s], or where the amplitude falls below `least`. [m]
    """
    _, _, mass = specimen.constants
    damped, taken = specimen.order is not None, 0.0

    def motion(_: float, state: Any) -> list[float]:
        return [state[1], specimen.acceleration(float(state[0]), float(state[1]), taken)]

    def boundary(_: float, state: Any) -> float:
        """What is 0 at an impact; of the law's damper, at a peak."""
        return float(state[1 if damped else 0])

    boundary.terminal = True  # type: ignore[attr-defined]
    times = step * np.arange(int(longest / step) + 1)
    moved, now, state, impacts = np.zeros(times.size), 0.0, np.array([release, 0.0]), []
    while now < times[-1] and max(abs(state[0]), abs(state[1]) / specimen.first) > least:
        deviation = specimen.scatter * random.standard_normal() if damped else 0.0
        if damped:
            energy = specimen.stored(state[0])
            left = specimen.lost(energy, deviation)
            if left == -math.inf:
                break
            taken = specimen.taken(energy, left)
        side = np.sign(state[0] + state[1] * 1e-9)
        boundary.direction = side if damped else -side  # type: ignore[attr-defined]
        part = solve_ivp(motion, (now, times[-1]), state, events=boundary, dense_output=True, **ACCURACY)
        within = (times >= now) & (times <= part.t[-1])
        moved[within] = part.sol(times[within])[0]
        if part.status != 1:
            break
        now = float(part.t[-1])
        if damped:
            impacts.append(math.exp(left))
            state = np.array([part.y[0, -1], 0.0])
            continue
        before = mass * part.y[1, -1] ** 2 / 2
        kept = math.exp(specimen.lost(before, specimen.scatter * random.standard_normal()))
        impacts.append(kept)
        state = np.array([0.0, kept * part.y[1, -1]])
    return moved[times <= now], impacts


def channel(moved: Any, step: float, *, held: float, late: float, rest: float, noise: float, drift: float, random: Any):
    """Return times [s] and what a sensor shows of a decay: held before the release, or cut off; then at rest. [m]

    Its zero, a linear drift, a random walk, white noise and the logger's steps of 0.01 mm are added.
    """
    before = np.full(int(held / step), moved[0])
    shown = np.concatenate([before, moved, np.zeros(int(rest / step))])[int(late / step) :]
    elapsed = step * np.arange(shown.size)
    walk = 0.1 * noise * np.cumsum(random.standard_normal(shown.size)) * np.sqrt(step)
    zero = 10 * noise * random.standard_normal()
    shown = shown + zero + drift * elapsed + walk + noise * random.standard_normal(shown.size)
    return elapsed, np.round(shown, 5)


# The examples: a wall of 250 mm without overburden, released from half and from a quarter of u_ins.
EXAMPLE = Specimen(0.25, 3.0, 0.6, 0.0, a1=0.05, b1=0.82, e=0.875, scatter=0.015)
STEP, NOISE, DRIFT = 0.002, 2e-4, 1.5e-4  # 500 Hz; [m] and [m/s]
SOURCE = "computed by tools/free_rocking_tests.py: SciPy's DOP853 from impact to impact, then noise and drift"


def examples() -> dict[str, str]:
    """Return the text of each example by the name of its file."""
    texts = {}
    for number, (share, held) in enumerate([(0.5, 0.8), (0.25, 0.5)], 1):
        random = np.random.RandomState(2026 + number)
        release = share * EXAMPLE.u_ins
        moved, _ = decay(EXAMPLE, release, STEP, 8.0, NOISE, random)
        elapsed, shown = channel(moved, STEP, held=held, late=0.0, rest=1.0, noise=NOISE, drift=DRIFT, random=random)
        header = {
            "specimen": f"wall 0.25 m thick and 3 m high, hinge at 0.6 of its height, release {number}; computed",
            "source": SOURCE,
            "licence": "CC0-1.0",
            "synthetic": "yes",
        }
        lines = [f"# {key}: {value}" for key, value in header.items()]
        true = {"yield_displacement_ratio": EXAMPLE.a1, "strength_ratio": EXAMPLE.b1, "restitution": EXAMPLE.e}
        lines += ["# units: s, m", *(f"# generator_{name}: {value:g}" for name, value in true.items())]
        rows = [f"{t:.3f},{u:.5f}" for t, u in zip(elapsed, shown, strict=True)]
        texts[f"my-free-rocking-{number}.csv"] = "\n".join([*lines, "elapsed_s,displacement_m", *rows]) + "\n"
    return texts


if __name__ == "__main__":
    for name, text in examples().items():
        (FOLDER / name).write_text(text, encoding="utf-8")
