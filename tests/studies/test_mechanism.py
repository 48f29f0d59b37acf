"""Curves of Fig. 2, the wall of Fig. 1, and restitution by slenderness."""

import pytest

from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.two_bodies import TwoBodies
from rockdamp.mechanics.wall import Wall
from rockdamp.studies.mechanism import effective_mass_ratio, make_variants, mechanism


@pytest.fixture(scope="module")
def curves(paper):
    return mechanism(paper)


def test_curves_lie_on_the_bilinear_law_or_below(curves):
    bilinear = curves["force"].sel(curve_name="bi-linear")
    assert (curves["force"] <= bilinear + 1e-12).all()


def test_presets_are_those_of_doherty(curves):
    severe = curves.sel(curve_name="severe")
    assert float(severe["strength_ratio"]) == 0.5
    assert float(severe["yield_displacement_ratio"]) == 0.2


@pytest.mark.parametrize("name", ["restitution_rigid", "restitution_impulsive"])
def test_restitution_is_that_of_the_wall(curves, name):
    wall = Wall(0.4, 4.0, hinge_ratio=0.5)
    stored = float(curves[name].sel(slenderness=10, hinge_height_ratio=0.5))
    assert stored == pytest.approx(float(getattr(wall, name)), rel=1e-14)


# --- variants of the softening branch -------------------------------------------------------------

VARIANTS = [(0.04, 0.85, 0.85), (0.2, 0.75, 0.63)]


@pytest.mark.parametrize(("a1", "b1", "lower_b1"), VARIANTS)
def test_plateau_is_lower_if_it_leaves_no_room(a1, b1, lower_b1):
    variants = make_variants(TrilinearCurve(a1, b1))
    assert float(variants["steeper"].strength_ratio) == b1
    assert float(variants["translated"].strength_ratio) == pytest.approx(lower_b1)


@pytest.mark.parametrize(("a1", "b1", "_"), VARIANTS)
def test_variants_end_where_fig_2_draws_them(a1, b1, _):
    for curve in make_variants(TrilinearCurve(a1, b1)).values():
        assert float(curve.ultimate_displacement_ratio) == 0.93
        assert float(curve.yield_displacement_ratio) == a1
        assert a1 < float(curve.plateau_end)


# --- effective mass -------------------------------------------------------------------------------


@pytest.mark.parametrize(("r", "h_t"), [(0.5, 10.0), (0.7, 10.0), (0.6, 25.0)])
def test_effective_mass_is_that_of_two_bodies(r, h_t):
    wall = Wall(0.24, 0.24 * h_t, hinge_ratio=r)
    mass = float(wall.weight) / STANDARD_GRAVITY
    expected = 2 * TwoBodies(wall).inertia(0.0) / mass
    assert effective_mass_ratio(r, h_t) == pytest.approx(expected, rel=1e-12)


def test_effective_mass_is_larger_for_a_thick_wall():
    assert effective_mass_ratio(0.5, 10.0) == pytest.approx(2 / 3 * 1.16, rel=1e-12)


def test_effective_mass_of_a_slender_wall_is_the_papers():
    assert effective_mass_ratio(0.7, 1e6) == pytest.approx(2 / 3, rel=1e-9)
