"""The model of the config: the shipped files, the schema, grids and walls."""

import json

import numpy as np
import pytest
from configs import configured, merge_files
from repository import ROOT

from rockdamp.config import Config
from rockdamp.config.rules import parse_config
from rockdamp.constants import DEFAULT_RESPONSE_LENGTH
from rockdamp.mechanics.wall import Parapet


@pytest.mark.parametrize("minimal", [False, True])
def test_shipped_files_are_valid(minimal):
    assert parse_config(merge_files(minimal=minimal), ROOT).solver.scheme == "newmark"


@pytest.mark.parametrize("name", ["minimal", "default"])
def test_shipped_files_name_the_schema(name):
    text = (ROOT / f"config/{name}.yaml").read_text(encoding="utf-8")
    assert text.startswith("# yaml-language-server: $schema=schema.json\n")


def test_schema_file_is_that_of_the_model():
    """`python -m rockdamp.config > config/schema.json` writes it."""
    text = (ROOT / "config/schema.json").read_text(encoding="utf-8")
    assert json.loads(text) == Config.model_json_schema()


def test_every_key_is_described():
    schema = Config.model_json_schema()
    sections = [schema, *schema["$defs"].values()]
    for section in sections:
        for name, entry in section["properties"].items():
            assert entry.get("description"), (section["title"], name)


def test_matched_length_is_the_default_of_the_package():
    assert configured().matching.response_length == DEFAULT_RESPONSE_LENGTH


def test_arithmetic_grid_includes_round_ends():
    values = configured().restitution.values()
    assert values.tolist() == [round(0.70 + 0.01 * i, 2) for i in range(29)]


def test_geometric_grid_includes_its_ends():
    values = configured().earthquakes.velocity_ratio.values()
    np.testing.assert_allclose(values, np.geomspace(0.2, 5, 14), rtol=1e-15)


@pytest.fixture
def walls():
    return {wall.name: wall for wall in configured().earthquakes.walls}


def test_wall_without_a_hinge_is_a_parapet(walls):
    parapets = [name for name, wall in walls.items() if isinstance(wall.wall, Parapet)]
    assert parapets == ["parapet"]


def test_wall_has_its_preset_or_its_own_curve(walls):
    assert float(walls["degraded"].curve.strength_ratio) == 0.50
    assert float(walls["church"].curve.strength_ratio) == 0.85


def test_height_follows_from_slenderness(walls):
    assert float(walls["degraded"].wall.height) == 4.0
    assert float(walls["degraded"].wall.hinge_ratio) == 0.6


def test_cracked_curves_change_to_the_softer_plateau():
    config = configured()
    curves = config.cracked_curves()
    a1 = np.array(merge_files()["studies"]["cracked_stiffness"])
    np.testing.assert_array_equal(curves.yield_displacement_ratio, a1)
    np.testing.assert_array_equal(curves.strength_ratio, np.where(a1 >= 0.15, 0.75, 0.85))
