"""One input changed at a time: which changes are tried, and that each answer is that of the wall so changed."""

from dataclasses import replace

import pytest

import rockdamp as rd
from rockdamp.assessment.sensitivity import sensitivity


def test_inputs_are_changed_by_what_is_left_open_without_a_test_and_a_bare_wall_gets_half_its_weight(
    wall, curve, motions
):
    bare, few = replace(wall, overburden_ratio=0.0), motions[:4]
    tried = sensitivity(bare, curve, 0.85, few, "PGV", 0.8, 3.0)
    values = {
        name: [one.value for one in tried if one.name == name] for name in dict.fromkeys(one.name for one in tried)
    }
    e, hinge, a1, overburden = values.values()
    assert e == pytest.approx([0.80, 0.90]) and overburden == [0.5]
    assert hinge == pytest.approx([wall.hinge_ratio - 0.1, wall.hinge_ratio + 0.1])
    assert a1 == pytest.approx([factor * curve.yield_displacement_ratio for factor in (0.5, 2.0)])
    loaded = rd.assess(replace(bare, overburden_ratio=0.5), curve, few, pgv=0.8, restitution=0.85)
    assert tried[-1].share == float(loaded["collapse_probability"].sel(damping_model="CR")[0])
    assert tried[-1].median == pytest.approx(float(loaded["median_pgv"].sel(damping_model="CR")))
