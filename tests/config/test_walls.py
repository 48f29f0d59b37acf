"""The config's walls can rock, or are refused where they stand; large ones are warned of, in one line each."""

import copy

import pytest
from hypothesis import given
from hypothesis import strategies as st
from repository import ROOT

from rockdamp import plausibility
from rockdamp.config import between_keys, walls
from rockdamp.errors import InputError, InputWarning
from rockdamp.mechanics.wall import Parapet, angular_momentum_restitution
from rockdamp.storage import yaml_file

DEFAULT = ROOT / "config/default.yaml"
SCHEMA = ROOT / "workflow/schemas/config.schema.yaml"


@pytest.fixture
def config(monkeypatch):
    monkeypatch.chdir(ROOT)  # the record's path is seen from the folder of the run
    return copy.deepcopy(yaml_file.load(DEFAULT.read_text(encoding="utf-8")))


def put(config, value, *path):
    *sections, last = path
    for section in sections:
        config = config[section]
    config[last] = value


@given(slenderness=st.floats(0.8, 40), hinge_ratio=st.floats(0.05, 0.95))
def test_restitution_in_plain_arithmetic_is_the_walls(slenderness, hinge_ratio):
    plain = walls.Sizes((), 0.3, slenderness, hinge_ratio).restitution
    assert plain == pytest.approx(float(angular_momentum_restitution(0.3, 0.3 * slenderness, hinge_ratio)), abs=1e-14)
    parapet = walls.Sizes((), 0.3, slenderness, None).restitution
    assert parapet == pytest.approx(float(Parapet(0.3, 0.3 * slenderness).restitution), abs=1e-14)


@pytest.mark.parametrize(
    ("path", "value", "expected"),
    [
        (
            ("wall", "slenderness"),
            0.1,
            "wall.slenderness makes a wall that cannot rock: thickness is 0.3 m and height 0.03 m",
        ),
        (
            ("studies", "slenderness", "slenderness", 0),
            1.2,
            "studies.slenderness.slenderness[0] makes a wall",
        ),
        (("loops", "rigid", "height"), 0.1, "loops.rigid.height makes a wall that cannot rock"),
        (("validation", "wall", "hinge_ratio"), 0.004, "e is -0.0122 by Eq. (7); it must be above 0"),
        (("natural", "walls", 0, "slenderness"), 0.2, "natural.walls[0].slenderness makes a wall that cannot rock"),
        (("population", "parameters", "slenderness", "low"), 1.3, "population.parameters.slenderness.low makes"),
        (("accuracy", "rigid", "slenderness"), [1.1, 20], "accuracy.rigid.slenderness makes a wall that"),
    ],
)
def test_a_wall_that_cannot_rock_is_refused_where_it_stands(config, path, value, expected):
    put(config, value, *path)
    with pytest.raises(InputError) as caught:
        between_keys.validate(config, SCHEMA, [DEFAULT])
    assert any(expected in line for line in str(caught.value).splitlines())


@pytest.mark.parametrize(
    ("path", "value", "expected"),
    [
        (
            ("wall", "thickness"),
            3.0,
            "wall.thickness makes an unlikely wall: thickness is 3 m and height 45 m",
        ),
        (("validation", "wall", "thickness"), 102.0, "; were they in millimetres"),
        (
            ("population", "parameters", "thickness", "high"),
            2.4,
            "population.parameters.thickness.high makes an",
        ),
    ],
)
def test_a_wall_larger_than_any_is_warned_of_where_it_stands(config, path, value, expected):
    put(config, value, *path)
    between_keys.validate(config, SCHEMA, [DEFAULT])
    with pytest.warns(InputWarning) as caught:
        between_keys.warn(config, [DEFAULT])
    assert any(expected in str(one.message) for one in caught)
    assert all(str(one.message).startswith(("the command line: ", f"{DEFAULT}, line ")) for one in caught)


def test_each_wall_is_told_once_and_a_file_by_its_line(config, tmp_path):
    own = tmp_path / "own.yaml"
    own.write_text("wall:\n  density: 1700\n  slenderness: 0.5\n", encoding="utf-8")
    config["wall"] |= {"slenderness": 0.5, "density": 1700}
    with pytest.raises(InputError) as caught:
        between_keys.validate(config, SCHEMA, [DEFAULT, own])
    of_wall = [line for line in str(caught.value).splitlines() if "cannot rock" in line]
    assert [line.split(" makes ")[0] for line in of_wall] == [f"{own}, line 3: wall.slenderness"]


def test_the_shipped_config_holds_nothing_unlikely(config):
    between_keys.warn(config, [DEFAULT])  # a warning is an error here
    assert walls.wall_doubts(config) == []
    assert plausibility.of_wall(config["wall"]["thickness"], 1.0) == []
