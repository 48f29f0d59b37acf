"""Rigid rocking: the slender limit, the two bodies at large rotations, and the derivation of both by SymPy."""

from functools import cache

import mpmath
import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq

from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.two_bodies import TwoBodies, large_rotation_decay, slender_decay
from rockdamp.mechanics.wall import Wall
from rockdamp.solvers.exact import exact_history

WALLS = (
    Wall(0.4, 4.0, hinge_ratio=0.5),
    Wall(0.3, 2.1, hinge_ratio=0.62, overburden_ratio=2.5, eccentricity=0.06),
    Wall(0.25, 5.0, hinge_ratio=0.7, overburden_ratio=0.8, eccentricity=-0.1),
    Wall(0.3, 3.0, hinge_ratio=0.6, overburden_ratio=1.2, eccentricity=0.04, overburden_mass=0.7),
)
IDS = ("plain", "loaded", "eccentric", "a mass on it")


# --- derivation -----------------------------------------------------------------------------------------------------

T, H1, H2, M1, M2, G, LOAD, ECC, MOVING = symbols = sp.symbols(
    "t h1 h2 m1 m2 g O ecc m_O", positive=True
)
THETA, PHI, SLOPE = sp.symbols(
    "theta phi slope"
)  # rotations of the lower and the upper body, dphi/dtheta


@cache
def lagrangian() -> tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr, sp.Expr]:
    """Turn both bodies about their corners; return u, the constraint, dphi/dtheta, M and U in theta and phi.

    The right face is x = 0 at rest. The lower body turns clockwise about its bottom right corner; the upper one
    turns anticlockwise about its bottom left corner, which stays on the top left corner of the lower one.
    """

    def turned(angle: sp.Expr, x: sp.Expr, y: sp.Expr) -> sp.Matrix:
        return sp.Matrix(
            [[sp.cos(angle), -sp.sin(angle)], [sp.sin(angle), sp.cos(angle)]]
        ) * sp.Matrix([x, y])

    hinge = turned(-THETA, -T, H1)
    centre1 = turned(-THETA, -T / 2, H1 / 2)
    centre2 = hinge + turned(PHI, T / 2, H2 / 2)
    contact = hinge + turned(PHI, T, H2)
    loaded = hinge + turned(PHI, T / 2 + ECC, H2)
    constraint = contact[0]  # the top contact stays at x = 0
    slope = -constraint.diff(THETA) / constraint.diff(PHI)

    def squared_speed(point: sp.Matrix) -> sp.Expr:  # over theta'^2
        rate = point.diff(THETA) + SLOPE * point.diff(PHI)
        return rate.dot(rate)

    inertia1, inertia2 = M1 * (T**2 + H1**2) / 12, M2 * (T**2 + H2**2) / 12
    mass = (
        M1 * squared_speed(centre1) + M2 * squared_speed(centre2) + inertia1 + inertia2 * SLOPE**2
    )
    mass += (
        MOVING * (loaded[1].diff(THETA) + SLOPE * loaded[1].diff(PHI)) ** 2
    )  # the floor holds it sideways
    potential = G * (M1 * centre1[1] + M2 * centre2[1]) + LOAD * loaded[1]
    return hinge[0] + T, constraint, slope, mass.subs(SLOPE, slope), potential


def along_path(expression: sp.Expr) -> sp.Expr:
    """Return d/dtheta along the constraint."""
    return expression.diff(THETA) + lagrangian()[2] * expression.diff(PHI)


def numbers(wall: Wall) -> list[float]:
    """Values of the symbols."""
    r, mass, load, g = float(wall.hinge_ratio), float(wall.mass), float(wall.overburden), 9.80665
    heights = float(wall.lower_height), float(wall.upper_height)
    moving = wall.overburden_mass * load / g
    return [wall.thickness, *heights, r * mass, (1 - r) * mass, g, load, wall.eccentricity, moving]


@cache
def compiled(name: str):
    """Compile one of the derived expressions as a function of theta, phi and the wall's numbers."""
    u, constraint, _, mass, potential = lagrangian()
    speed = along_path(u)  # du/dtheta
    in_u = mass / speed**2
    expressions = {"u": u, "constraint": constraint, "M": in_u, "U": potential}
    expressions |= {f"{each} slope": along_path(expressions[each]) / speed for each in ("M", "U")}
    return sp.lambdify((THETA, PHI, *symbols), expressions[name], modules="numpy", cse=True)


def phi_of(theta: float, wall: Wall) -> float:
    """Solve the constraint by Newton's method, from the slender limit."""
    phi = theta * float(wall.lower_height / wall.upper_height)
    for _ in range(30):
        step = 1e-6
        value = compiled("constraint")(theta, phi, *numbers(wall))
        above, below = (
            compiled("constraint")(theta, phi + s, *numbers(wall)) for s in (step, -step)
        )
        phi -= value * 2 * step / (above - below)
    return phi


@pytest.mark.parametrize("wall", WALLS, ids=IDS)
@pytest.mark.parametrize("theta", [1e-3, 0.03, 0.11])
def test_inertia_potential_and_slopes_follow_from_the_geometry(wall, theta):
    phi = phi_of(theta, wall)
    u = compiled("u")(theta, phi, *numbers(wall))
    bodies = TwoBodies(wall)
    derived = {
        name: compiled(name)(theta, phi, *numbers(wall))
        for name in ("M", "M slope", "U", "U slope")
    }
    assert bodies.inertia(u) == pytest.approx(derived["M"], rel=1e-11)
    assert bodies.inertia_slope(u) == pytest.approx(derived["M slope"], rel=1e-9)
    assert bodies.potential(u) == pytest.approx(derived["U"], rel=1e-12)
    # The force is a small difference of large terms near instability: measured against its value at rest.
    assert bodies.potential_slope(u) == pytest.approx(
        derived["U slope"], abs=1e-11 * bodies.potential_slope(0.0)
    )


@pytest.mark.parametrize("wall", WALLS, ids=IDS)
def test_bodies_at_rest_agree_with_the_wall(wall):
    bodies, r = TwoBodies(wall), wall.hinge_ratio
    correction = (3 - 2 * r) / (r**2 * (1 - r)) / float(wall.slenderness) ** 2
    assert 2 * bodies.inertia(0.0) == pytest.approx(
        float(wall.effective_mass) * (1 + correction), rel=1e-14
    )
    assert 2 * bodies.potential_slope(0.0) == pytest.approx(float(wall.rigid_strength), rel=1e-14)


# --- motion ---------------------------------------------------------------------------------------------------------


def fall_time(wall: Wall, peak: float) -> float:
    """Time in tau from rest at u = peak to u = 0: the energy integral, regular in z where u = peak (1 - z^2)."""
    bodies = TwoBodies(wall)

    def rate(z):
        u = float(peak * (1 - z * z))
        lost = bodies.potential(peak) - bodies.potential(u)
        return 2 * peak * z * mpmath.sqrt(bodies.inertia(u) / (2 * lost))

    # Near z = 0 the difference of energies cancels: Gauss-Legendre nodes stay far enough from it.
    return float(mpmath.quad(rate, [0, 0.5, 1], method="gauss-legendre", maxdegree=4)) * float(
        wall.frequency_parameter
    )


@pytest.mark.parametrize("wall", WALLS, ids=IDS)
def test_large_rotation_impacts_come_when_the_energy_integral_says(wall):
    bodies, scale = TwoBodies(wall), float(wall.instability_displacement)
    first = fall_time(wall, 0.7 * scale)
    energy = bodies.potential(0.7 * scale) - bodies.potential(0.0)
    e = 0.9
    target = bodies.potential(0.0) + e**2 * energy
    peak = brentq(lambda u: bodies.potential(u) - target, 0.1 * scale, 0.7 * scale, xtol=1e-15)
    second = fall_time(wall, peak)
    x = large_rotation_decay([first, first + second, first + 2 * second], wall, e, 0.7)
    assert x == pytest.approx([0.0, -peak / scale, 0.0], abs=1e-9)


def test_large_rotations_tend_to_the_slender_limit_with_the_square_of_the_slenderness():
    times = np.linspace(0, 6, 601)
    differences = []
    for slenderness in (20, 40, 80):
        wall = Wall(
            0.3, 0.3 * slenderness, hinge_ratio=0.6, overburden_ratio=1.0, eccentricity=0.05
        )
        both = slender_decay(times, 0.9, 0.8), large_rotation_decay(times, wall, 0.9, 0.8)
        differences.append(np.abs(both[0] - both[1]).max())
    orders = np.log2(np.divide(differences[:-1], differences[1:]))
    assert orders == pytest.approx([2.0, 2.0], abs=0.1)


@pytest.mark.parametrize(
    ("slenderness", "later", "lower"), [(8, 0.064, 0.0014), (20, 0.0106, 0.00023)]
)
def test_large_rotations_delay_the_first_impact_more_than_they_lower_the_next_peak(
    slenderness, later, lower
):
    """The numbers of docs/accuracy.md: h1/h = 0.5, from 0.5 u_ins at e = 0.955."""
    wall, times = Wall(0.4, 0.4 * slenderness, hinge_ratio=0.5), np.linspace(0, 5, 20001)
    slender, large = slender_decay(times, 0.955, 0.5), large_rotation_decay(times, wall, 0.955, 0.5)
    impacts, peaks = zip(
        *((times[np.argmax(x < 0)], -x.min()) for x in (slender, large)), strict=True
    )
    assert impacts[1] / impacts[0] - 1 == pytest.approx(later, rel=0.01)
    assert 1 - peaks[1] / peaks[0] == pytest.approx(lower, rel=0.02)


def test_slender_peaks_follow_the_energy_of_each_impact_and_then_it_rests():
    e, x0 = 0.8, 0.9
    kept = e ** (2 * np.arange(60)) * (1 - (1 - x0) ** 2)
    falls = np.arccosh(1 / np.sqrt(1 - kept))
    peak_times = np.concatenate([[0.0], np.cumsum(falls[:-1] + falls[1:])])
    peaks = slender_decay(peak_times, e, x0)
    assert 1 - (1 - np.abs(peaks[:30])) ** 2 == pytest.approx(kept[:30], rel=1e-9)
    assert np.array_equal(np.sign(peaks[:30]), (-1.0) ** np.arange(30))
    assert not slender_decay([peak_times[-1] + 0.01, 1e3], e, x0).any()


def test_tri_linear_wall_tends_to_the_slender_limit_as_its_first_branch_shrinks():
    times = np.linspace(0, 6, 301)
    rigid = slender_decay(times, 0.955, 0.9)
    misfits = []
    for a1 in (4e-3, 2e-3, 1e-3, 5e-4):
        curve = TrilinearCurve(a1, 1 - 1.001 * a1)
        wall = exact_history(curve, Damping("CR", 0.955), times, release_amplitude=0.9)
        misfits.append(np.abs(wall.displacement - rigid).max())
    # The first branch costs energy of order a1 and time of order a1: first order.
    assert np.log2(np.divide(misfits[:-1], misfits[1:])) == pytest.approx([1.0] * 3, abs=0.1)


# --- bad input ------------------------------------------------------------------------------------------------------


def test_release_from_where_the_bodies_fall_is_refused():
    # At large rotations the overburden on the turned top face tips this squat wall before u_ins.
    wall = Wall(0.4, 1.2, hinge_ratio=0.3, overburden_ratio=8.0, eccentricity=-0.2)
    with pytest.raises(InputError, match=r"release_amplitude is 0\.999"):
        large_rotation_decay([0.0, 1.0], wall, 0.9, 0.999)
