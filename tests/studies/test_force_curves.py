"""The curves of Figs 1 and 2."""

import pytest

from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.two_bodies import TwoBodies
from rockdamp.mechanics.wall import Wall
from rockdamp.studies import mechanism
from rockdamp.studies.mechanism import effective_mass_ratio


def test_curves_are_tabulated_on_the_bi_linear_law_or_below(config):
    found = mechanism.mechanism(config)
    rigid = found["force"].sel(curve_name="bi-linear")
    assert (found["force"] <= rigid + 1e-12).all()
    drawn = found.sel(curve_name="severe")
    assert (float(drawn["strength_ratio"]), float(drawn["yield_displacement_ratio"])) == (0.5, 0.2)


@pytest.mark.parametrize("a1, b1, lower", [(0.04, 0.85, 0.85), (0.2, 0.75, 0.63)])
def test_both_variants_of_fig_2_end_where_it_draws_them_on_a_plateau_that_leaves_them_room(a1, b1, lower):
    drawn = mechanism.make_variants(TrilinearCurve(a1, b1))
    assert [float(drawn[name].strength_ratio) for name in ("steeper", "translated")] == pytest.approx([b1, lower])
    for curve in drawn.values():
        assert float(curve.ultimate_displacement_ratio) == 0.93
        assert float(curve.yield_displacement_ratio) == a1 < float(curve.plateau_end)


def test_the_stage_of_fig_1_tabulates_what_the_wall_gives(paper):
    stored = mechanism.mechanism(paper).sel(slenderness=10, hinge_height_ratio=0.5)
    wall = Wall(0.4, 4.0, hinge_ratio=0.5)
    assert float(stored["restitution_rigid"]) == pytest.approx(float(wall.restitution_rigid), rel=1e-14)
    assert float(stored["restitution_impulsive"]) == pytest.approx(float(wall.restitution_impulsive), rel=1e-14)


def test_the_effective_mass_at_rest_is_that_of_two_bodies_and_tends_to_the_papers():
    for r, h_t in ((0.5, 10.0), (0.7, 10.0), (0.6, 25.0)):
        wall = Wall(0.24, 0.24 * h_t, hinge_ratio=r)
        mass = float(wall.weight) / STANDARD_GRAVITY
        assert effective_mass_ratio(r, h_t) == pytest.approx(2 * TwoBodies(wall).inertia(0.0) / mass, rel=1e-12)
    assert effective_mass_ratio(0.5, 10.0) == pytest.approx(2 / 3 * 1.16, rel=1e-12)  # 16 % more, at h/t = 10
    assert effective_mass_ratio(0.7, 1e6) == pytest.approx(2 / 3, rel=1e-9)
