"""Free rocking of rigid bodies with impacts: the slender limit, and two bodies at large rotations.

Fig. 4 compares the tri-linear wall with both. A decay is a chain of half cycles. Nothing is lost
between impacts, so that each half cycle is a fall from rest, run backwards and then forwards. An
impact multiplies the velocity by e by Eq. (8), and therefore the energy by e^2. Impacts follow each
other ever faster, and the wall is at rest after a finite time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from rockdamp.arrays import Array
from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.errors import check
from rockdamp.mechanics.wall import Wall

TOLERANCE = 1e-12  # relative, of DOP853


class Fall(NamedTuple):
    """A fall from rest to u = 0: half of a half cycle."""

    peak: float  # u/u_ins [-]
    duration: float  # in tau [-]
    displacement: Callable[[Array], Array]  # u/u_ins at times since the peak [-]


def slender_decay(times: ArrayLike, restitution: float, release_amplitude: float) -> Array:
    r"""Return u/u_ins of the rigid law x'' = -sgn(x) (1 - \|x\|) after a release from rest. [-]

    In tau and u/u_ins all slender walls have the same decay.

    Parameters
    ----------
    times : ndarray
        Ascending times tau = p t, from 0 on. [-]
    restitution : float
        Coefficient of restitution e. [-]
    release_amplitude : float
        Amplitude u0/u_ins, between 0 and 1. [-]
    """
    double_energy = release_amplitude * (2 - release_amplitude)  # 2V = 1 - (1 - x)^2

    def fall(number: int) -> Fall:
        remaining = restitution ** (2 * number) * double_energy
        root = np.sqrt(1 - remaining)  # 1 - x at the peak
        peak = remaining / (1 + root)  # 1 - root without its cancellation
        # x = 1 - root cosh(t), in a form without cancellation near the peak.
        duration = float(np.arccosh(1 / root))
        return Fall(peak, duration, lambda t: peak - 2 * root * np.sinh(t / 2) ** 2)

    return _chain_half_cycles(np.asarray(times, dtype=float), fall)


def large_rotation_decay(
    times: ArrayLike, wall: Wall, restitution: float, release_amplitude: float
) -> Array:
    """Return u/u_ins of two rigid bodies at rotations of any size, after a release from rest. [-]

    DOP853 solves M(u) u'' + 1/2 M'(u) u'^2 + U'(u) = 0 for u > 0 (see `TwoBodies`). The scales
    u_ins and p are those of the wall, so that the result compares with `slender_decay`.

    Parameters
    ----------
    times : ndarray
        Ascending times tau = p t, from 0 on. [-]
    wall : Wall
        One wall.
    restitution : float
        Coefficient of restitution e. [-]
    release_amplitude : float
        Amplitude u0/u_ins, at which the bodies must still fall back. [-]
    """
    bodies = TwoBodies(wall)
    u_ins = float(wall.instability_displacement)
    p = float(wall.frequency_parameter)
    u0 = release_amplitude * u_ins
    allowed = "smaller: from there these bodies fall instead of rocking"
    check("release_amplitude", release_amplitude, lambda _: bodies.potential_slope(u0) > 0, allowed)
    lowest = bodies.potential(0.0)
    energy = bodies.potential(u0) - lowest

    def rates(_: float, state: Array) -> tuple[float, float]:
        u, v = state.tolist()
        pull = 0.5 * bodies.inertia_slope(u) * v**2 + bodies.potential_slope(u) / p**2
        return v, -pull / bodies.inertia(u)

    def crossing(_: float, state: Array) -> float:
        return float(state[0])

    crossing.terminal = True  # type: ignore[attr-defined]

    def find_peak(number: int) -> float:
        if number == 0:
            return u0
        remaining = restitution ** (2 * number) * energy

        def excess(u: float) -> float:
            return bodies.potential(u) - lowest - remaining

        return float(brentq(excess, 0.0, u0, xtol=1e-16 * u0, rtol=1e-15))

    def fall(number: int) -> Fall:
        peak = find_peak(number)
        # Force and inertia are never less favourable than the force at the peak and the inertia at
        # u = 0, with which the fall would last `slowest`.
        slowest = np.sqrt(2 * peak * bodies.inertia(0.0) / bodies.potential_slope(peak)) * p
        solution = solve_ivp(
            rates,
            (0.0, 2 * slowest),  # the crossing ends it before
            (peak, 0.0),
            events=crossing,
            method="DOP853",
            dense_output=True,
            rtol=TOLERANCE,
            atol=1e-3 * TOLERANCE * peak,
        )
        duration = float(solution.t_events[0][0])
        return Fall(peak / u_ins, duration, lambda t: solution.sol(t)[0] / u_ins)

    return _chain_half_cycles(np.asarray(times, dtype=float), fall)


def _chain_half_cycles(times: Array, fall: Callable[[int], Fall]) -> Array:
    """Return the decay at ascending times; `fall(n)` is the fall from the n-th peak."""
    displacement = np.zeros(times.shape)
    current = fall(0)
    smallest = 1e-10 * current.peak  # far below the accuracy of the falls; the decay is 0 then
    number = 0
    peak_time = 0.0
    while current.peak > smallest and times.size and peak_time - current.duration <= times[-1]:
        ends = (peak_time - current.duration, peak_time + current.duration)
        first, last = np.searchsorted(times, ends)
        if last > first:
            since_peak = np.abs(times[first:last] - peak_time)
            displacement[first:last] = (-1) ** number * current.displacement(since_peak)
        number += 1
        peak_time += current.duration
        current = fall(number)
        peak_time += current.duration
    return displacement


class TwoBodies:
    """Inertia and potential of the two bodies of one wall (Fig. 1), at u > 0 of any size.

    The lower body turns about its corner A' and touches the upper body at the hinge B. The upper
    body's corner C' is held sideways and free to rise. B lies s = u - t sideways of the line A'C'.
    With the diagonals R_i of the bodies and D_i = sqrt(R_i^2 - s^2), B is at the height D1 and C'
    at D1 + D2. The rotations are theta_i = atan(t/h_i) + asin(s/R_i). The kinetic energy is
    1/2 M(u) u'^2, with the moments of inertia m_i (t^2 + h_i^2)/12. For u < 0 all is mirrored,
    the eccentricity of the overburden included.

    In the slender limit M tends to m/3 and U' to half of the bi-linear force: the coordinate u
    carries half of the mass and of the force of Eq. (1), where m_eff is 2m/3.

    Parameters
    ----------
    wall : Wall
        One wall.
    """

    def __init__(self, wall: Wall) -> None:
        r = float(wall.hinge_ratio)
        self._thickness = float(wall.thickness)
        self._lower = float(wall.lower_height)
        self._upper = float(wall.upper_height)
        self._masses = r * float(wall.mass), (1 - r) * float(wall.mass)
        self._weights = r * float(wall.weight), (1 - r) * float(wall.weight)
        self._overburden = float(wall.overburden)
        # ASSUME: the overburden stays at its place on the top face, and vertical, as the body
        # turns.
        self._arm = self._thickness / 2 - float(wall.eccentricity)
        # Part of the overburden that has a mass, which moves up and down alone.
        self._moving_mass = float(wall.overburden_mass * wall.overburden / STANDARD_GRAVITY)
        self._upper_diagonal_squared = self._upper**2 + self._thickness**2

    def _heights(self, u: float) -> tuple[float, float, float]:
        """Return s, D1 and D2. [m]"""
        s = u - self._thickness
        square = self._thickness**2 - s**2
        return s, math.sqrt(self._lower**2 + square), math.sqrt(self._upper**2 + square)

    def inertia(self, u: float) -> float:
        """Return M(u) for u >= 0. [kg]"""
        s, d1, d2 = self._heights(u)
        m1, m2 = self._masses
        turning = (m1 / 3 + m2) / d1**2 + m2 / (d1 * d2) + m2 / (3 * d2**2)
        bodies = (m1 + m2) / 3 + s**2 * turning
        return bodies + self._moving_mass * self._rise(s, d1, d2) ** 2

    def inertia_slope(self, u: float) -> float:
        """Return dM/du. [kg m-1]"""
        s, d1, d2 = self._heights(u)
        m1, m2 = self._masses
        # M is quadratic in y_i = s/D_i, and dy_i/ds = R_i^2/D_i^3.
        y1 = s / d1
        y2 = s / d2
        slope1 = (1 + y1**2) / d1
        slope2 = (1 + y2**2) / d2
        mixed = m2 * (y1 * slope2 + y2 * slope1)
        bodies = 2 * (m1 / 3 + m2) * y1 * slope1 + mixed + 2 * m2 * y2 * slope2 / 3
        arm_slope = self._arm * self._thickness * slope2 / self._upper_diagonal_squared
        return bodies - 2 * self._moving_mass * self._rise(s, d1, d2) * (
            slope1 + slope2 - arm_slope
        )

    def potential(self, u: float) -> float:
        """Return U(u) of the weights and the overburden for u >= 0. [J]"""
        s, d1, d2 = self._heights(u)
        w1, w2 = self._weights
        sine = (self._upper * s + self._thickness * d2) / self._upper_diagonal_squared  # of theta_2
        bodies = w1 * d1 / 2 + w2 * (d1 + d2 / 2)
        return bodies + self._overburden * (d1 + d2 - self._arm * sine)

    def potential_slope(self, u: float) -> float:
        """Return dU/du: half of the force at the hinge, as Eq. (1) counts it. [N]"""
        s, d1, d2 = self._heights(u)
        w1, w2 = self._weights
        y1 = s / d1
        y2 = s / d2
        return -w1 * y1 / 2 - w2 * (y1 + y2 / 2) + self._overburden * self._rise(s, d1, d2)

    def _rise(self, s: float, d1: float, d2: float) -> float:
        """Return the rise of the overburden for each unit of u. [-]"""
        sine_slope = (self._upper - self._thickness * s / d2) / self._upper_diagonal_squared
        return -(s / d1 + s / d2 + self._arm * sine_slope)
