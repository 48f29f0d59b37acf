"""Free rocking of rigid bodies with impacts: the slender limit in closed form, and two bodies at large rotations.

Both are what Fig. 4 compares the tri-linear wall with. A decay is a chain of half cycles. Between impacts nothing is
lost, so each half cycle is a fall from rest, run backwards and then forwards; at an impact the velocity is multiplied
by e (Eq. 8), so the energy of successive half cycles falls by e^2. Impacts follow each other ever faster and the wall
is at rest after a finite time.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from rockdamp.arrays import Array
from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.errors import check
from rockdamp.mechanics.wall import Wall

Fall = Callable[[Array], Array]


def slender_decay(times: ArrayLike, restitution: float, release_amplitude: float) -> Array:
    """Return u/u_ins of the rigid bi-linear law x'' = -sgn(x) (1 - |x|) after a release from rest. [-]

    At `times` tau = p t, ascending from 0 or later. All walls have the same decay in tau and u/u_ins.
    """
    energy = release_amplitude * (2 - release_amplitude)  # 2 V, from 1 - (1 - x)^2

    def half_cycle(n: int) -> tuple[float, float, Fall]:
        kept = restitution ** (2 * n) * energy
        root = np.sqrt(1 - kept)  # 1 - x_n
        peak = kept / (1 + root)
        return peak, float(np.arccosh(1 / root)), lambda t: peak - 2 * root * np.sinh(t / 2) ** 2

    return _decay(np.asarray(times, dtype=float), half_cycle)


def large_rotation_decay(
    times: ArrayLike, wall: Wall, restitution: float, release_amplitude: float
) -> Array:
    """Return u/u_ins of the two rigid bodies rocking at rotations of any size, after a release from rest. [-]

    Solves M(u) u'' + 1/2 M'(u) u'^2 + U'(u) = 0 for |u| (see `TwoBodies`) by DOP853. The scales of u and t are those of
    the slender limit, u_ins and p of the wall, so the result compares directly with `slender_decay`.
    """
    bodies = TwoBodies(wall)
    scale, p = float(wall.instability_displacement), float(wall.frequency_parameter)
    u0 = release_amplitude * scale
    allowed = "smaller: from there these bodies fall instead of rocking"
    check("release_amplitude", release_amplitude, lambda _: bodies.potential_slope(u0) > 0, allowed)
    at_rest = bodies.potential(0.0)
    energy = bodies.potential(u0) - at_rest

    def rates(_: float, state: Array) -> tuple[float, float]:
        u, v = state.tolist()
        pull = 0.5 * bodies.inertia_slope(u) * v**2 + bodies.potential_slope(u) / p**2
        return v, -pull / bodies.inertia(u)

    def ground(_: float, state: Array) -> float:
        return float(state[0])

    ground.terminal = True  # type: ignore[attr-defined]

    def half_cycle(n: int) -> tuple[float, float, Fall]:
        kept = restitution ** (2 * n) * energy
        peak = (
            brentq(
                lambda u: bodies.potential(u) - at_rest - kept, 0.0, u0, xtol=1e-16 * u0, rtol=1e-15
            )
            if n
            else u0
        )
        # From rest under at least the force at the peak: the fall cannot last longer than this.
        longest = 2 * np.sqrt(2 * peak * bodies.inertia(0.0) / bodies.potential_slope(peak)) * p
        options = {
            "method": "DOP853",
            "dense_output": True,
            "rtol": 1e-12,
            "atol": 1e-3 * 1e-12 * peak,
        }
        fall = solve_ivp(rates, (0.0, longest), (peak, 0.0), events=ground, **options)
        return peak / scale, float(fall.t_events[0][0]), lambda t: fall.sol(t)[0] / scale

    return _decay(np.asarray(times, dtype=float), half_cycle)


def _decay(times: Array, half_cycle: Callable[[int], tuple[float, float, Fall]]) -> Array:
    """Chain half cycles: `half_cycle(n)` is the n-th peak, the time to fall from it to u = 0, and that fall |u|(t)."""
    displacement = np.zeros(times.shape)
    release, duration, fall = half_cycle(0)
    peak, n, peak_time = release, 0, 0.0
    while peak > 1e-10 * release and times.size and peak_time - duration <= times[-1]:
        first, last = np.searchsorted(times, (peak_time - duration, peak_time + duration))
        if last > first:
            displacement[first:last] = (-1) ** n * fall(np.abs(times[first:last] - peak_time))
        n, peak_time = n + 1, peak_time + duration
        peak, duration, fall = half_cycle(n)
        peak_time += duration
    return displacement


class TwoBodies:
    """Inertia and potential of the two bodies of one wall (Fig. 1) in u > 0, without a limit on the rotations.

    The lower body turns about its corner A' and touches the upper one at the hinge B; the upper body's corner C' is
    held sideways and free to rise. B is at the horizontal distance s = u - t from the line A'C', and with R_i the
    bodies' diagonals D_i = sqrt(R_i^2 - s^2): B is at the height D1, C' at D1 + D2. The rotations are
    theta_i = atan(t/h_i) + asin(s/R_i). Kinetic energy is 1/2 M(u) u'^2, with the moments of inertia
    m_i (t^2 + h_i^2)/12. For u < 0 all is mirrored, the overburden's eccentricity included.

    In the slender limit M tends to m/3 and U' to f_bi/2: the coordinate u carries half of the mass and of the force of
    Eq. (1), where m_eff is 2m/3.
    """

    def __init__(self, wall: Wall) -> None:
        r, t = float(wall.hinge_ratio), float(wall.thickness)
        self._thickness, self._lower, self._upper = (
            t,
            float(wall.lower_height),
            float(wall.upper_height),
        )
        self._masses = r * float(wall.mass), (1 - r) * float(wall.mass)
        self._weights = r * float(wall.weight), (1 - r) * float(wall.weight)
        # ASSUME: the overburden stays at its place on the top face, and vertical, as the upper body turns.
        self._overburden, self._arm = float(wall.overburden), t / 2 - float(wall.eccentricity)
        # The mass of the overburden moves up and down alone.
        self._moving = float(wall.overburden_mass * wall.overburden / STANDARD_GRAVITY)

    def _parts(self, u: float) -> tuple[float, float, float]:
        """Return s, D1 and D2. [m]"""
        s = u - self._thickness
        square = self._thickness**2 - s**2
        return s, math.sqrt(self._lower**2 + square), math.sqrt(self._upper**2 + square)

    def inertia(self, u: float) -> float:
        """Return M(u) for u >= 0. [kg]"""
        s, d1, d2 = self._parts(u)
        m1, m2 = self._masses
        bodies = (m1 + m2) / 3 + s**2 * ((m1 / 3 + m2) / d1**2 + m2 / (d1 * d2) + m2 / (3 * d2**2))
        return bodies + self._moving * self._rise(s, d1, d2) ** 2

    def inertia_slope(self, u: float) -> float:
        """Return dM/du. [kg m-1]"""
        s, d1, d2 = self._parts(u)
        m1, m2 = self._masses
        # M is quadratic in y_i = s/D_i, and dy_i/ds = R_i^2/D_i^3.
        y1, y2 = s / d1, s / d2
        slope1, slope2 = (1 + y1**2) / d1, (1 + y2**2) / d2
        bodies = (
            2 * (m1 / 3 + m2) * y1 * slope1
            + m2 * (y1 * slope2 + y2 * slope1)
            + 2 * m2 * y2 * slope2 / 3
        )
        turned = self._arm * self._thickness * slope2 / (self._upper**2 + self._thickness**2)
        return bodies - 2 * self._moving * self._rise(s, d1, d2) * (slope1 + slope2 - turned)

    def potential(self, u: float) -> float:
        """Return U(u) for u >= 0, of the weights and the overburden. [J]"""
        s, d1, d2 = self._parts(u)
        w1, w2 = self._weights
        sine = (self._upper * s + self._thickness * d2) / (
            self._upper**2 + self._thickness**2
        )  # of theta_2
        return w1 * d1 / 2 + w2 * (d1 + d2 / 2) + self._overburden * (d1 + d2 - self._arm * sine)

    def potential_slope(self, u: float) -> float:
        """Return dU/du: half of the force at the hinge, as Eq. (1) counts it. [N]"""
        s, d1, d2 = self._parts(u)
        w1, w2 = self._weights
        y1, y2 = s / d1, s / d2
        return -w1 * y1 / 2 - w2 * (y1 + y2 / 2) + self._overburden * self._rise(s, d1, d2)

    def _rise(self, s: float, d1: float, d2: float) -> float:
        """Return how much the overburden rises for a unit of u. [-]"""
        sine_slope = (self._upper - self._thickness * s / d2) / (
            self._upper**2 + self._thickness**2
        )
        return -(s / d1 + s / d2 + self._arm * sine_slope)
