"""Access to the config by keys: the params of rules, and the part that a stage is given."""

import pytest
from configs import configured

from rockdamp.config.keys import restrict, select_values


def test_values_have_dotted_keys():
    config = configured({"solver": {"step": "1e-3"}})
    assert select_values(config, "solver", "restitution.stop") == {
        "solver.scheme": "newmark",
        "solver.step": 0.001,
        "restitution.stop": 0.98,
    }


def test_values_of_walls_have_the_walls_names():
    values = select_values(configured(), "earthquakes.walls")
    assert values["earthquakes.walls.church.slenderness"] == 16
    assert "earthquakes.walls.church.preset" not in values


def test_order_of_walls_is_a_value():
    config = configured()
    walls = config.earthquakes.walls
    names = [wall.name for wall in walls]
    assert select_values(config, "earthquakes")["earthquakes.walls"] == names
    walls.reverse()
    assert select_values(config, "earthquakes")["earthquakes.walls"] == names[::-1]


def test_unknown_key_is_refused():
    with pytest.raises(AttributeError):
        select_values(configured(), "solver.tolerance")


@pytest.fixture
def part():
    keys = ["curve", "earthquakes.walls.church.slenderness", "earthquakes.check.seed"]
    return restrict(configured(), keys)


def test_part_has_the_values_at_its_keys(part):
    assert part.curve.strength_ratio == 0.85
    assert part.earthquakes.check.seed == 1


def test_part_has_walls_whole(part):
    assert len(part.earthquakes.walls) == 8


@pytest.mark.parametrize(
    ("section", "key"),
    [
        (lambda part: part, "wall"),
        (lambda part: part.earthquakes, "step"),
        (lambda part: part.earthquakes.check, "histories"),
    ],
    ids=["section", "value", "inner value"],
)
def test_part_has_nothing_else(part, section, key):
    with pytest.raises(AttributeError):
        getattr(section(part), key)


def test_section_and_a_key_in_it_give_the_section():
    part = restrict(configured(), ["solver.step", "solver"])
    assert part.solver.scheme == "newmark"
