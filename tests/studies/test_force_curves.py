"""The curves of Figs 1 and 2."""

import pytest

from rockdamp.mechanics.wall import Wall
from rockdamp.studies import force_curves


def test_curves_are_tabulated_on_the_bi_linear_law_or_below(config):
    found = force_curves.mechanism(config)
    rigid = found["force"].sel(curve_name="bi-linear")
    assert (found["force"] <= rigid + 1e-12).all()
    drawn = found.sel(curve_name="severe")
    assert (float(drawn["plateau_ratio"]), float(drawn["cracked_stiffness_ratio"])) == (0.5, 0.2)


def test_the_stage_of_fig_1_tabulates_what_the_wall_gives(paper):
    stored = force_curves.mechanism(paper).sel(slenderness=10, hinge_height_ratio=0.5)
    wall = Wall(0.4, 4.0, hinge_ratio=0.5)
    assert float(stored["restitution_analytical"]) == pytest.approx(float(wall.restitution), rel=1e-14)
    assert float(stored["restitution_impulsive"]) == pytest.approx(float(wall.restitution_impulsive), rel=1e-14)
