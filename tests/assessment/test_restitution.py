"""The coefficient of restitution by a number or a rule."""

import pytest

import rockdamp as rd
from rockdamp.assessment.restitution import find_restitution
from rockdamp.mechanics.wall import SORRENTINO_RATIO

WALL = rd.Wall(0.25, 3.0, overburden_ratio=0.5)
PARAPET = rd.Parapet(0.25, 1.5)


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        ("measured", SORRENTINO_RATIO * WALL.restitution_rigid),
        ("rigid", WALL.restitution_rigid),
        ("impulsive", WALL.restitution_impulsive),
    ],
)
def test_a_rule_of_a_wall(rule, expected):
    e, _ = find_restitution(WALL, rule)
    assert e == pytest.approx(float(expected), rel=1e-12)


@pytest.mark.parametrize("rule", ["measured", "rigid", "impulsive"])
def test_every_rule_of_a_parapet_is_housners(rule):
    e, reason = find_restitution(PARAPET, rule)
    assert e == float(PARAPET.restitution_rigid)
    assert "Housner" in reason


def test_a_one_sided_block_has_the_e_of_return_walls():
    front = rd.OneSidedWall(PARAPET)
    e, reason = find_restitution(front, "measured")
    assert e == float(front.restitution_measured)
    assert "Sorrentino" in reason


def test_a_number_is_given():
    assert find_restitution(WALL, 0.8) == (0.8, "given")
