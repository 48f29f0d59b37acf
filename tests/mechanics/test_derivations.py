"""The constants of a wall, derived from the motion of rigid bodies by SymPy and compared with the code.

A section through the wall: x horizontal from mid-thickness, y up from the base. The wall sways to the side s = +1 or
-1. The lower body then turns on its base corner at x = +s t/2, the bodies touch at x = -s t/2, and the upper body
touches the top support at x = +s t/2 (Fig. 1). The top support keeps that corner from moving horizontally; the
overburden lies on it.
"""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.mechanics.wall import EXCITATION_FACTOR, Parapet, Wall

t, h1, h2, m, W, O, small = sp.symbols("t h1 h2 m W O small", positive=True)  # noqa: E741
ecc, u, q = sp.symbols("ecc u q", real=True)
h = h1 + h2
SHARE = (h1 / h, h2 / h)  # of the mass and weight, in the lower and the upper body
HEIGHTS = (h1, h2)

# Eqs (5) and (6): the value at rest and the negative slope of the bi-linear law.
F0 = 2 * (W + O) * t / h1 + O * (t + 2 * ecc) / h2
K0 = 2 * (W + O) / h1 + 2 * O / h2

WALL = Wall(
    thickness=np.array([0.10, 0.30, 0.40, 0.25]),
    height=np.array([2.7, 4.5, 4.0, 2.2]),
    width=np.array([1.0, 1.4, 0.7, 1.0]),
    density=np.array([1800.0, 1835.0, 2100.0, 1600.0]),
    hinge_ratio=np.array([0.5, 0.57, 0.7, 0.45]),
    overburden_ratio=np.array([0.0, 6.2, 1.0, 0.3]),
    eccentricity=np.array([0.0, -0.05, 0.2, 0.1]),
)
LIKE = {
    name: getattr(WALL, name) for name in ("width", "density", "overburden_ratio", "eccentricity")
}
PARAPET = Parapet(WALL.thickness, WALL.height, **LIKE)


def on_walls(expression, wall=WALL):
    """Evaluate `expression` for each of the walls."""
    lower = getattr(wall, "lower_height", 0.5 * np.asarray(wall.height))
    values = (
        wall.thickness,
        lower,
        wall.height - lower,
        wall.mass,
        wall.weight,
        wall.overburden,
        wall.eccentricity,
    )
    return sp.lambdify((t, h1, h2, m, W, O, ecc), expression)(*values)


# --- statics: the finite mechanism, then its limit for slender bodies and small rotations ----------------------------


def turned(x, y, angle):
    """Turn a vector clockwise."""
    return sp.Matrix([x * sp.cos(angle) + y * sp.sin(angle), y * sp.cos(angle) - x * sp.sin(angle)])


def leading(expression):
    """Coefficient of small^2, after a check that nothing of lower order is there besides a constant."""
    scaled = expression.subs({t: small * t, ecc: small * ecc, u: small * u}, simultaneous=True)
    slope = sp.diff(scaled, small)
    assert sp.simplify(slope.subs(small, 0)) == 0
    return sp.expand(sp.diff(slope, small).subs(small, 0) / 2)


def wall_potential():
    """Potential energy of the wall swaying to s = +1 with its hinge at u, exact in the rotations u/h1 and u/h2."""
    base = sp.Matrix([t / 2, 0])
    hinge = base + turned(-t, h1, u / h1)
    lower = base + turned(-t / 2, h1 / 2, u / h1)
    upper = hinge + turned(t / 2, h2 / 2, -u / h2)
    load = hinge + turned(t / 2 + ecc, h2, -u / h2)
    return W * SHARE[0] * lower[1] + W * SHARE[1] * upper[1] + O * load[1]


def test_virtual_work_gives_the_bilinear_law_with_the_strength_and_the_stiffness_of_eqs_5_and_6():
    # The face load is uniform, so a force f works over u/2, the mean displacement: f/2 = dU/du.
    law = 2 * sp.diff(leading(wall_potential()), u)
    corrected = (
        2 * W * (t - u) / h1 + O * h * (t + 2 * ecc - 2 * u) / (h1 * h2) + O * (t - 2 * ecc) / h1
    )
    assert sp.simplify(law - corrected) == 0
    assert sp.simplify(law - (F0 - K0 * u)) == 0
    np.testing.assert_allclose(WALL.rigid_strength, on_walls(F0), rtol=1e-14)
    np.testing.assert_allclose(WALL.rigid_stiffness, on_walls(K0), rtol=1e-14)
    np.testing.assert_allclose(WALL.instability_displacement, on_walls(F0 / K0), rtol=1e-14)


def test_the_rotations_keep_the_top_corner_under_its_support_to_the_order_that_the_law_needs():
    hinge = sp.Matrix([t / 2, 0]) + turned(-t, h1, u / h1)
    corner = hinge + turned(t, h2, -u / h2)
    drift = (corner[0] - t / 2).subs({t: small * t, u: small * u}, simultaneous=True)
    # Of order small^3, it would change the potential by small^4, two orders below the law's.
    assert [sp.simplify(sp.diff(drift, small, order).subs(small, 0)) for order in range(3)] == [
        0,
        0,
        0,
    ]


def test_eq_3_as_printed_is_inconsistent_with_eqs_5_and_6():
    printed = (
        2 * W * (t - u) / h1 + O * h * (t + 2 * ecc - u) / (h1 * h2) + 2 * O * (t - 2 * ecc) / h1
    )
    assert (
        sp.simplify(printed.subs(u, 0) - F0 - O * (t - 2 * ecc) / h1) == 0
    )  # too strong, unless ecc = t/2
    assert (
        sp.simplify(-sp.diff(printed, u) - K0 + O * (1 / h1 + 1 / h2)) == 0
    )  # and not stiff enough


def test_virtual_work_gives_the_law_of_the_parapet():
    base = sp.Matrix([t / 2, 0])
    # The overburden touches the corner that rises, and its eccentricity counts towards it.
    centre, load = base + turned(-t / 2, h / 2, u / h), base + turned(-t / 2 - ecc, h, u / h)
    law = 2 * sp.diff(leading(W * centre[1] + O * load[1]), u)
    strength, stiffness = (W * t + O * (t + 2 * ecc)) / h, (W + 2 * O) / h
    assert sp.simplify(law - (strength - stiffness * u)) == 0
    np.testing.assert_allclose(PARAPET.rigid_strength, on_walls(strength, PARAPET), rtol=1e-14)
    np.testing.assert_allclose(PARAPET.rigid_stiffness, on_walls(stiffness, PARAPET), rtol=1e-14)
    u_ins = PARAPET.rigid_strength / PARAPET.rigid_stiffness
    np.testing.assert_allclose(PARAPET.instability_displacement, u_ins, rtol=1e-15)


# --- dynamics at u = 0 ------------------------------------------------------------------------------------------------


def inertia(share, height):
    """Mass and polar moment of inertia of a rectangular body about its centre."""
    return m * share, m * share * (height**2 + t**2) / 12


def wall_motion(side):
    """Velocity of both centres and clockwise spin of both bodies at u = 0, for a hinge velocity of 1."""
    spins = (1 / h1, -1 / h2)

    def velocity(arm, spin):
        return spin * sp.Matrix([arm[1], -arm[0]])

    base, hinge = sp.Matrix([side * t / 2, 0]), sp.Matrix([-side * t / 2, h1])
    centres = sp.Matrix([0, h1 / 2]), sp.Matrix([0, h1 + h2 / 2])
    lower = velocity(centres[0] - base, spins[0])
    upper = velocity(hinge - base, spins[0]) + velocity(centres[1] - hinge, spins[1])
    return centres, (lower, upper), spins


def generalised_mass(first, second):
    """Sum of momentum times velocity of two motions of the wall: twice the kinetic energy where they are the same."""
    total = 0
    for share, height, v, w, a, b in zip(
        SHARE, HEIGHTS, first[1], second[1], first[2], second[2], strict=True
    ):
        mass, polar = inertia(share, height)
        total += mass * v.dot(w) + polar * a * b
    return sp.simplify(total)


def test_the_effective_mass_and_the_excitation_factor_are_the_slender_limits():
    motion = wall_motion(1)
    # The same factor of 2 as in the force: the coordinate of Eq. (1) carries half of the work.
    exact = 2 * generalised_mass(motion, motion)
    ratio = h1 / h
    printed = 2 * m / 3 * (1 + (t / h) ** 2 * (3 - 2 * ratio) / (ratio**2 * (1 - ratio)))
    assert sp.simplify(exact - printed) == 0
    limit = exact.subs(t, 0)
    assert sp.simplify(limit - 2 * m / 3) == 0  # Eq. (2)
    load = 2 * sum(m * share * v[0] for share, v in zip(SHARE, motion[1], strict=True))
    assert sp.simplify(load / limit - sp.Rational(3, 2)) == 0  # Eq. (4)
    np.testing.assert_allclose(WALL.effective_mass, on_walls(limit), rtol=1e-15)
    own = replace(WALL, own_inertia=True)
    np.testing.assert_allclose(own.effective_mass, on_walls(exact), rtol=1e-13)
    assert EXCITATION_FACTOR == 1.5 and np.all(WALL.excitation_factor == 1.5)
    squat = exact.subs({t: 1, h1: 5, h2: 5, m: sp.Rational(3, 2)})
    assert squat == sp.Rational(116, 100)  # +16 % at h/t = 10, r = 0.5


def test_the_parapet_has_the_same_effective_mass_and_excitation_factor():
    about_corner = m * (h**2 + t**2) / 3
    limit = sp.simplify((2 * about_corner / h**2).subs(t, 0))
    assert sp.simplify(limit - 2 * m / 3) == 0
    assert sp.simplify(2 * m / 2 / limit) == sp.Rational(3, 2)
    np.testing.assert_allclose(PARAPET.effective_mass, on_walls(limit, PARAPET), rtol=1e-15)
    own = replace(PARAPET, own_inertia=True)
    exact = on_walls(2 * about_corner / h**2, PARAPET)
    np.testing.assert_allclose(own.effective_mass, exact, rtol=1e-13)
    assert np.all(PARAPET.excitation_factor == EXCITATION_FACTOR)


def test_the_load_factor_is_that_of_the_equation_of_motion_divided_by_the_mass_and_the_length():
    # m_eff u'' = -lambda m_eff a_g with u = u_ins x and t = tau/p.
    expected = (
        -EXCITATION_FACTOR
        * WALL.effective_mass
        / (WALL.rigid_stiffness * WALL.instability_displacement)
    )
    np.testing.assert_allclose(WALL.load_factor, expected, rtol=1e-14)
    np.testing.assert_allclose(WALL.weight, WALL.mass * STANDARD_GRAVITY, rtol=1e-15)


# --- impacts ----------------------------------------------------------------------------------------------------------

EQ_7 = (h1 * (h1 + h) - 3 * t**2) / (h1 * (h1 + h) + 3 * t**2)


def printed_eq_7():
    """Eq. (7) as printed, with R1 the half diagonal of the lower body and tan(alpha) = t/height."""
    (m1, i1), (m2, i2) = (
        inertia(share, height) for share, height in zip(SHARE, HEIGHTS, strict=True)
    )
    r1 = sp.sqrt(h1**2 + t**2) / 2
    tan1, tan2 = t / h1, t / h2
    sin, cos = sp.sin(sp.atan(tan1)), sp.cos(sp.atan(tan1))
    common = m1 * r1**2 + i1 - i2 * tan2 / tan1
    after = m2 * r1**2 * (2 + sin * cos / tan2 - sin**2 * (4 + tan2 / tan1))
    before = m2 * r1**2 * (2 + sin * cos * (1 / tan2 + tan2))
    return (common - 2 * m1 * r1**2 * sin**2 + after) / (common + before)


def test_the_printed_eq_7_reduces_to_four_terms_and_is_the_code_s():
    assert sp.simplify(printed_eq_7() - EQ_7) == 0
    np.testing.assert_allclose(WALL.restitution_rigid, on_walls(printed_eq_7()), rtol=1e-13)
    halves = EQ_7.subs({h1: h2}) - (1 - 2 * t**2 / (t**2 + h2**2))
    assert sp.simplify(halves) == 0  # 1 - 2 sin^2(alpha) at r = 0.5


def test_eq_7_is_the_conservation_of_the_total_angular_momentum_about_the_new_base_pivot():
    pivot = sp.Matrix([-t / 2, 0])

    def angular_momentum(motion):
        total = 0
        for share, height, centre, v, spin in zip(SHARE, HEIGHTS, *motion, strict=True):
            mass, polar = inertia(share, height)
            arm = centre - pivot
            total += mass * (arm[1] * v[0] - arm[0] * v[1]) + polar * spin
        return total

    ratio = angular_momentum(wall_motion(1)) / angular_momentum(wall_motion(-1))
    assert sp.simplify(ratio - EQ_7) == 0


def impulsive_restitution():
    """Solve the momentum balance of both bodies for the hinge velocity after an impact from +1 to -1 at velocity 1.

    The impulses act where the bodies touch after the impact: both components at the base and the hinge; at the top the
    horizontal one only, as the overburden has no mass of its own.
    """
    jx, jy, kx, ky, lx, after = sp.symbols("jx jy kx ky lx after")
    centres, before_v, before_spin = wall_motion(1)
    _, after_v, after_spin = wall_motion(-1)
    base, hinge, top = sp.Matrix([-t / 2, 0]), sp.Matrix([t / 2, h1]), sp.Matrix([-t / 2, h])
    from_base, from_lower, from_top = sp.Matrix([jx, jy]), sp.Matrix([kx, ky]), sp.Matrix([lx, 0])
    on = (((base, from_base), (hinge, -from_lower)), ((hinge, from_lower), (top, from_top)))
    equations = []
    for body in range(2):
        mass, polar = inertia(SHARE[body], HEIGHTS[body])
        total = sum((impulse for _, impulse in on[body]), sp.zeros(2, 1))
        moment = 0
        for point, impulse in on[body]:
            arm = point - centres[body]
            moment += arm[1] * impulse[0] - arm[0] * impulse[1]  # clockwise
        equations += list(mass * (after * after_v[body] - before_v[body]) - total)
        equations.append(polar * (after * after_spin[body] - before_spin[body]) - moment)
    (solution,) = sp.linsolve(equations, (jx, jy, kx, ky, lx, after))
    return sp.simplify(solution[-1]), sp.simplify(solution[4])


def test_impulses_at_all_supports_give_the_impulsive_restitution_which_is_the_projection_of_the_momentum():
    restitution, top_impulse = impulsive_restitution()
    after = wall_motion(-1)
    projection = generalised_mass(after, wall_motion(1)) / generalised_mass(after, after)
    assert sp.simplify(restitution - projection) == 0
    r, square = h1 / h, (t / h) ** 2
    stated = (2 * r**2 * (1 - r) - (6 - 5 * r) * square) / (
        2 * (r**2 * (1 - r) + (3 - 2 * r) * square)
    )
    assert sp.simplify(restitution - stated) == 0
    halves = restitution.subs(h1, h2) - (4 * h2**2 - 14 * t**2) / (4 * h2**2 + 16 * t**2)
    assert sp.simplify(halves) == 0
    np.testing.assert_allclose(WALL.restitution_impulsive, on_walls(restitution), rtol=1e-13)
    # What Eq. (7) leaves out: its angular momentum misses the moment of this impulse about the base.
    assert sp.simplify(top_impulse) != 0
    assert np.all(WALL.restitution_impulsive < WALL.restitution_rigid)


def test_housner_s_restitution_is_the_angular_momentum_of_one_block_about_its_new_corner():
    # Before, the centre moves on a circle about the old corner: only part of it turns about the new one.
    about_corner, spread = m * (h**2 + t**2) / 3, m * t**2 / 2
    housner = (about_corner - spread) / about_corner
    alpha = sp.atan(t / h)
    assert sp.simplify(housner - (1 - sp.Rational(3, 2) * sp.sin(alpha) ** 2)) == 0
    np.testing.assert_allclose(PARAPET.restitution_rigid, on_walls(housner, PARAPET), rtol=1e-14)
    np.testing.assert_array_equal(PARAPET.restitution_impulsive, PARAPET.restitution_rigid)


@pytest.mark.parametrize(("hinge_ratio", "expected"), [(0.5, 0.923), (0.7, 0.951), (0.746, 0.955)])
def test_eq_7_gives_the_0_955_of_fig_4_only_above_the_hinge_heights_of_the_paper(
    hinge_ratio, expected
):
    assert Wall(0.4, 4.0, hinge_ratio=hinge_ratio).restitution_rigid == pytest.approx(
        expected, abs=5e-4
    )
