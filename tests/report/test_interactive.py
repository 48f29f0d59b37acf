"""What the report's explorer is given."""

import pytest

import rockdamp
from rockdamp.plausibility import as_meant
from rockdamp.report import interactive

WALL = rockdamp.Wall(thickness=0.3, height=4.5, hinge_ratio=0.7)


def given(step=0.0025, response_length=8.0):
    return interactive.data(rockdamp.TrilinearCurve(0.04, 0.85), WALL, step, response_length, 0.85, 0.5)


def test_the_solver_is_given_whole_numbers_of_steps():
    assert given()["solver"] == {"step": 0.0025, "steps": 8000, "compared": 3200, "drawn": 8}
    assert given(0.05)["solver"] == {"step": 0.05, "steps": 400, "compared": 160, "drawn": 1}


@as_meant()
@pytest.mark.parametrize(("thickness", "height"), [(0.1, 2.7), (0.5, 2.0), (1.0, 12.0)])
def test_walls_of_other_sizes_follow_from_the_studys(thickness, height):
    other = rockdamp.Wall(thickness=thickness, height=height, hinge_ratio=0.7)
    scales = given()["wall"]
    assert scales["u_ins_over_thickness"] * thickness == pytest.approx(float(other.instability_displacement))
    assert scales["frequency_root_height"] / height**0.5 == pytest.approx(float(other.frequency_parameter))


def test_the_explorer_starts_at_the_studys_wall():
    start = given()["start"]
    expected = {"e": 0.85, "x0": 0.5, "a1": 0.04, "b1": 0.85, "a3": 1.0, "softening": "steeper", "m": 0}
    assert start == expected | {"t": 0.3, "h": 4.5}
    assert set(start) == {control.name for control in interactive.CONTROLS} | {"softening"}
    assert given()["presets"]["study"] == start and set(given()["presets"]) == {"study", "new", "moderate", "severe"}
