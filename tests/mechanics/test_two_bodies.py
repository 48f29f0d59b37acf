"""Rigid rocking: the slender limit, and two bodies at large rotations, derived by SymPy."""

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

GRAVITY = 9.80665
WALLS = (
    Wall(0.4, 4.0, hinge_ratio=0.5),
    Wall(0.3, 2.1, hinge_ratio=0.62, overburden_ratio=2.5, eccentricity=0.06),
    Wall(0.25, 5.0, hinge_ratio=0.7, overburden_ratio=0.8, eccentricity=-0.1),
    Wall(0.3, 3.0, hinge_ratio=0.6, overburden_ratio=1.2, eccentricity=0.04, overburden_mass=0.7),
)
every_wall = pytest.mark.parametrize(
    "wall", WALLS, ids=("plain", "loaded", "eccentric", "a mass on it")
)


# --- derivation ----------------------------------------------------------------------------------

SYMBOLS = sp.symbols("t h1 h2 m1 m2 g O ecc m_O", positive=True)
T, H1, H2, M1, M2, G, LOAD, ECC, MOVING = SYMBOLS
# Rotations of the lower and the upper body, and dphi/dtheta.
THETA, PHI, SLOPE = sp.symbols("theta phi slope")


def turned(angle, x, y):
    """Turn a vector anticlockwise."""
    sine, cosine = sp.sin(angle), sp.cos(angle)
    return sp.Matrix([[cosine, -sine], [sine, cosine]]) * sp.Matrix([x, y])


def rate(expression):
    """Return the derivative by theta, with that of phi as a symbol."""
    return expression.diff(THETA) + SLOPE * expression.diff(PHI)


@cache
def lagrangian():
    """Return u, the constraint, dphi/dtheta, and M by theta' and U, in theta and phi.

    The right face is x = 0 at rest. The lower body turns clockwise about its bottom right corner.
    The upper body turns anticlockwise about its bottom left corner, which stays on the top left
    corner of the lower one.
    """
    hinge = turned(-THETA, -T, H1)
    centre1 = turned(-THETA, -T / 2, H1 / 2)
    centre2 = hinge + turned(PHI, T / 2, H2 / 2)
    contact = hinge + turned(PHI, T, H2)
    loaded = hinge + turned(PHI, T / 2 + ECC, H2)
    constraint = contact[0]  # the top contact stays at x = 0
    slope = -constraint.diff(THETA) / constraint.diff(PHI)
    speed1, speed2 = rate(centre1), rate(centre2)
    mass = M1 * speed1.dot(speed1) + M2 * speed2.dot(speed2)
    mass += M1 * (T**2 + H1**2) / 12 + M2 * (T**2 + H2**2) / 12 * SLOPE**2
    mass += MOVING * rate(loaded[1]) ** 2  # the floor holds it sideways
    potential = G * (M1 * centre1[1] + M2 * centre2[1]) + LOAD * loaded[1]
    return hinge[0] + T, constraint, slope, mass.subs(SLOPE, slope), potential


def along_path(expression):
    """Return d/dtheta along the constraint."""
    return rate(expression).subs(SLOPE, lagrangian()[2])


def symbol_values(wall):
    r, mass = float(wall.hinge_ratio), float(wall.mass)
    heights = float(wall.lower_height), float(wall.upper_height)
    load = float(wall.overburden)
    moving = wall.overburden_mass * load / GRAVITY
    masses = r * mass, (1 - r) * mass
    return [wall.thickness, *heights, *masses, GRAVITY, load, wall.eccentricity, moving]


@cache
def compiled(name):
    """Compile a derived expression as a function of theta, phi and the values of the symbols."""
    u, constraint, _, mass, potential = lagrangian()
    speed = along_path(u)  # du/dtheta
    expressions = {"u": u, "constraint": constraint, "M": mass / speed**2, "U": potential}
    expressions["M slope"] = along_path(expressions["M"]) / speed
    expressions["U slope"] = along_path(expressions["U"]) / speed
    return sp.lambdify((THETA, PHI, *SYMBOLS), expressions[name], modules="numpy", cse=True)


def find_phi(theta, wall):
    """Solve the constraint by Newton's method, from the slender limit."""
    values = symbol_values(wall)
    constraint = compiled("constraint")
    phi = theta * float(wall.lower_height / wall.upper_height)
    step = 1e-6
    for _ in range(30):
        rise = constraint(theta, phi + step, *values) - constraint(theta, phi - step, *values)
        phi -= constraint(theta, phi, *values) * 2 * step / rise
    return phi


@every_wall
@pytest.mark.parametrize("theta", [1e-3, 0.03, 0.11])
def test_inertia_and_potential_follow_from_the_geometry(wall, theta):
    arguments = (theta, find_phi(theta, wall), *symbol_values(wall))
    u = compiled("u")(*arguments)
    bodies = TwoBodies(wall)
    assert bodies.inertia(u) == pytest.approx(compiled("M")(*arguments), rel=1e-11)
    assert bodies.inertia_slope(u) == pytest.approx(compiled("M slope")(*arguments), rel=1e-9)
    assert bodies.potential(u) == pytest.approx(compiled("U")(*arguments), rel=1e-12)
    # The force is a small difference of large terms near instability: over its value at rest.
    tolerance = 1e-11 * bodies.potential_slope(0.0)
    slope = compiled("U slope")(*arguments)
    assert bodies.potential_slope(u) == pytest.approx(slope, abs=tolerance)


@every_wall
def test_strength_of_bodies_at_rest(wall):
    strength = 2 * TwoBodies(wall).potential_slope(0.0)
    assert strength == pytest.approx(float(wall.rigid_strength), rel=1e-14)


@every_wall
def test_inertia_of_bodies_at_rest_is_own_inertia(wall):
    thick = Wall(**(vars(wall) | {"own_inertia": True}))
    inertia = 2 * TwoBodies(wall).inertia(0.0)
    assert inertia == pytest.approx(float(thick.effective_mass), rel=1e-13)


# --- motion --------------------------------------------------------------------------------------


def fall_time(wall, peak):
    """Return the time in tau from rest at a peak to u = 0, by the energy integral.

    The integral is regular in z, where u = peak (1 - z^2).
    """
    bodies = TwoBodies(wall)

    def rate(z):
        u = float(peak * (1 - z * z))
        energy = bodies.potential(peak) - bodies.potential(u)
        return 2 * peak * z * mpmath.sqrt(bodies.inertia(u) / (2 * energy))

    # Near z = 0 the difference of energies cancels. Gauss-Legendre nodes stay far enough from it.
    seconds = mpmath.quad(rate, [0, 0.5, 1], method="gauss-legendre", maxdegree=4)
    return float(seconds) * float(wall.frequency_parameter)


@every_wall
def test_times_of_impacts_by_the_energy_integral(wall):
    bodies, e = TwoBodies(wall), 0.9
    scale = float(wall.instability_displacement)
    release = 0.7 * scale
    lowest = bodies.potential(0.0)
    remaining = lowest + e**2 * (bodies.potential(release) - lowest)
    peak = brentq(lambda u: bodies.potential(u) - remaining, 0.1 * scale, release, xtol=1e-15)
    first, second = fall_time(wall, release), fall_time(wall, peak)
    x = large_rotation_decay([first, first + second, first + 2 * second], wall, e, 0.7)
    assert x == pytest.approx([0.0, -peak / scale, 0.0], abs=1e-9)


def test_large_rotations_tend_to_the_slender_limit():
    """With the square of the slenderness."""
    times = np.linspace(0, 6, 601)
    slender = slender_decay(times, 0.9, 0.8)
    differences = []
    for slenderness in (20, 40, 80):
        height = 0.3 * slenderness
        wall = Wall(0.3, height, hinge_ratio=0.6, overburden_ratio=1.0, eccentricity=0.05)
        large = large_rotation_decay(times, wall, 0.9, 0.8)
        differences.append(np.abs(slender - large).max())
    orders = np.log2(np.divide(differences[:-1], differences[1:]))
    assert orders == pytest.approx([2.0, 2.0], abs=0.1)


def test_large_rotations_follow_the_last_half_cycles():
    """Until the slender wall is at rest."""
    times = np.linspace(0, 9, 901)
    wall = Wall(0.3, 60.0, hinge_ratio=0.6)
    large = large_rotation_decay(times, wall, 0.6, 0.5)
    slender = slender_decay(times, 0.6, 0.5)
    np.testing.assert_allclose(large, slender, atol=1e-3)
    assert not large[times > 5].any()


def impact_and_peak(times, decay):
    """Return the time of the first impact and the next peak."""
    return times[np.argmax(decay < 0)], -decay.min()


@pytest.mark.parametrize(
    ("slenderness", "later", "lower"), [(8, 0.064, 0.0014), (20, 0.0106, 0.00023)]
)
def test_large_rotations_delay_impacts(slenderness, later, lower):
    """The numbers of docs/accuracy.md: h1/h = 0.5, from 0.5 u_ins at e = 0.955."""
    wall = Wall(0.4, 0.4 * slenderness, hinge_ratio=0.5)
    times = np.linspace(0, 5, 20001)
    slender_impact, slender_peak = impact_and_peak(times, slender_decay(times, 0.955, 0.5))
    decay = large_rotation_decay(times, wall, 0.955, 0.5)
    impact, peak = impact_and_peak(times, decay)
    assert impact / slender_impact - 1 == pytest.approx(later, rel=0.01)
    assert 1 - peak / slender_peak == pytest.approx(lower, rel=0.02)


def slender_peaks(e, x0, count):
    """Return 2V at each peak, and the times of the peaks."""
    double_energy = e ** (2 * np.arange(count)) * (1 - (1 - x0) ** 2)
    durations = np.arccosh(1 / np.sqrt(1 - double_energy))
    return double_energy, np.concatenate([[0.0], np.cumsum(durations[:-1] + durations[1:])])


def test_slender_peaks_follow_the_energy():
    e, x0 = 0.8, 0.9
    double_energy, times = slender_peaks(e, x0, 30)
    peaks = slender_decay(times, e, x0)
    assert 1 - (1 - np.abs(peaks)) ** 2 == pytest.approx(double_energy, rel=1e-9)
    assert np.array_equal(np.sign(peaks), (-1.0) ** np.arange(30))


def test_slender_decay_comes_to_rest():
    _, times = slender_peaks(0.8, 0.9, 60)
    assert not slender_decay([times[-1] + 0.01, 1e3], 0.8, 0.9).any()


def test_tri_linear_wall_tends_to_the_slender_limit():
    """The first branch costs energy and time of order a1: first order."""
    times = np.linspace(0, 6, 301)
    rigid = slender_decay(times, 0.955, 0.9)
    differences = []
    for a1 in (4e-3, 2e-3, 1e-3, 5e-4):
        curve = TrilinearCurve(a1, 1 - 1.001 * a1)
        history = exact_history(curve, Damping("CR", 0.955), times, release_amplitude=0.9)
        differences.append(np.abs(history.displacement - rigid).max())
    orders = np.log2(np.divide(differences[:-1], differences[1:]))
    assert orders == pytest.approx([1.0] * 3, abs=0.1)


def test_release_beyond_stability_is_refused():
    """The overburden on the turned top face tips this squat wall before u_ins."""
    wall = Wall(0.4, 1.2, hinge_ratio=0.3, overburden_ratio=8.0, eccentricity=-0.2)
    with pytest.raises(InputError, match=r"release_amplitude is 0\.999"):
        large_rotation_decay([0.0, 1.0], wall, 0.9, 0.999)
