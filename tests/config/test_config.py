"""The config: what is shipped, what a stage is given, and which key an error names."""

import json

import numpy as np
import pytest
from configs import configured, stated
from repository import ROOT

from rockdamp.config import Config, parse_config
from rockdamp.constants import DEFAULT_RESPONSE_LENGTH, STUDIES
from rockdamp.errors import InputError
from rockdamp.mechanics.wall import Parapet


@pytest.mark.parametrize("name", ["minimal", "default"])
def test_the_shipped_files_are_valid_and_name_the_schema(name):
    assert parse_config(stated(minimal=name == "minimal")).solver.scheme == "newmark"
    assert (
        (ROOT / f"config/{name}.yaml")
        .read_text()
        .startswith("# yaml-language-server: $schema=schema.json\n")
    )


def test_the_schema_is_that_of_the_model():
    """`python -m rockdamp.config > config/schema.json` writes it."""
    assert json.loads((ROOT / "config/schema.json").read_text()) == Config.model_json_schema()


def test_the_matched_length_is_that_of_the_package():
    assert configured().matching.response_length == DEFAULT_RESPONSE_LENGTH


# --- what a stage is given --------------------------------------------------------------------------------------------


def test_a_part_has_what_its_keys_name_and_nothing_else():
    part = configured().part(
        "curve", "earthquakes.walls.church.slenderness", "earthquakes.check.seed"
    )
    assert (
        part.curve.strength_ratio == 0.85
        and part.earthquakes.check.seed == 1
        and len(part.earthquakes.walls) == 8
    )
    for read in ("wall", "earthquakes.step", "earthquakes.check.histories"):
        section, _, key = f"part.{read}".rpartition(".")
        with pytest.raises(AttributeError):
            getattr(eval(section, {"part": part}), key)


def test_leaves_are_plain_values_by_their_keys_and_walls_by_their_names():
    leaves = configured({"solver": {"step": "1e-3"}}).leaves(
        "solver", "restitution.stop", "earthquakes.walls"
    )
    assert {key: leaves[key] for key in list(leaves)[:4]} == {
        "solver.scheme": "newmark",
        "solver.step": 0.001,
        "restitution.stop": 0.98,
        "earthquakes.walls.tested.name": "tested",
    }
    assert leaves["earthquakes.walls.church.slenderness"] == 16
    with pytest.raises(AttributeError):
        configured().leaves("solver.tolerance")


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_varies_its_parameter_and_nothing_else(name):
    study, values = configured().study(name), stated()["studies"][name]
    assert study.values.tolist() == values and study.curve.shape == (len(values),)
    assert study.varies_wall == (name in ("slenderness", "overburden"))
    for index, value in enumerate(values):
        a1 = value if name == "cracked_stiffness" else 0.04
        own = study.curve.map(lambda p, index=index: p[index])
        assert (own.yield_displacement_ratio, own.strength_ratio) == (
            a1,
            0.75 if a1 >= 0.15 else 0.85,
        )
        assert study.release_amplitude[index] == (value if name == "amplitude" else 0.5)
        own_wall = configured(
            {"wall": {STUDIES[name]: value} if study.varies_wall else {}}
        ).wall.make()
        assert study.frequency_parameter[index] == own_wall.frequency_parameter


def test_grids_include_their_ends_round():
    config = configured()
    assert config.restitution.values().tolist() == [round(0.70 + 0.01 * i, 2) for i in range(29)]
    np.testing.assert_allclose(
        config.earthquakes.velocity_ratio.values(), np.geomspace(0.2, 5, 14), rtol=1e-15
    )


def test_walls_under_earthquakes_have_a_hinge_or_are_parapets_with_a_preset_or_their_own_curve():
    walls = {named.name: named for named in configured().earthquakes.walls}
    assert [name for name, named in walls.items() if isinstance(named.wall, Parapet)] == ["parapet"]
    assert (
        float(walls["degraded"].curve.strength_ratio) == 0.50
        and float(walls["church"].curve.strength_ratio) == 0.85
    )
    assert (
        float(walls["degraded"].wall.height) == 4.0
        and float(walls["degraded"].wall.hinge_ratio) == 0.6
    )


# --- bad input --------------------------------------------------------------------------------------------------------

WALL = {
    "name": "mine",
    "thickness": 0.2,
    "slenderness": 15,
    "overburden_ratio": 0.0,
    "hinge_ratio": 0.5,
}
WALL |= {"yield_displacement_ratio": 0.04, "strength_ratio": 0.85}
NO_HINGE = {key: value for key, value in WALL.items() if key != "hinge_ratio"}

BAD = [  # a key, a wrong value, and the key that the error begins with, if it is another one
    # of the wrong size, or unknown
    ("wall.thickness", float("nan")),
    ("wall.height", 4.5),
    ("matching.refinement", 3),
    ("restitution.step", 0.03, "restitution"),
    ("earthquakes.velocity_ratio.stop", 0.1, "earthquakes.velocity_ratio"),
    ("studies.overburden", [0, -1], "studies.overburden.1"),
    ("studies.slenderness", []),
    ("studies.slenderness", [10, 10]),
    ("results", "results/{study}"),
    # a wall or a curve that cannot be
    ("wall.slenderness", 0.1, "wall"),
    ("wall.eccentricity", -0.2, "wall"),
    ("curve.yield_displacement_ratio", 0.16, "curve"),
    ("curve.ultimate_displacement_ratio", 0.15, "curve"),
    ("validation.wall.hinge_ratio", 0.004, "validation.wall"),
    ("damping_force.rigid.height", 0.1, "damping_force.rigid"),
    ("damping_force.rigid.yield_displacement_ratio", 0.2, "damping_force.rigid"),
    ("studies.cracked_stiffness", [0.02, 0.04, 0.3]),
    ("studies.slenderness", [0.1, 15]),
    ("earthquakes.walls", [{**WALL, "parapet": True}], "earthquakes.walls.0"),
    ("earthquakes.walls", [NO_HINGE], "earthquakes.walls.0"),
    ("earthquakes.walls", [{**WALL, "preset": "new"}], "earthquakes.walls.0"),
    ("earthquakes.walls", [{**WALL, "strength_ratio": None}], "earthquakes.walls.0"),
    ("earthquakes.walls", [{**WALL, "yield_displacement_ratio": 0.3}], "earthquakes.walls.0"),
    ("earthquakes.walls", [WALL, WALL]),
    # steps
    ("solver.step", 0.15),
    ("earthquakes.walls", [{**WALL, "yield_displacement_ratio": 1e-6}], "earthquakes.walls.0"),
    ("validation.step", 0.5),
    # what is looked up
    ("release_amplitude", 0.4, "studies.amplitude"),
    ("order.order", [0, 8]),
    ("order.band_width", [0.2]),
    ("measured_rocking.shown_impacts", 7, "measured_rocking.impacts_used"),
    ("restitution", {"start": 0.9, "stop": 0.95, "step": 0.05}),
    ("restitution", {"start": 0.9, "stop": 1.1, "step": 0.05}),
    ("validation.fit_yield_displacement_ratios", [0.02, 0.15]),
    ("earthquakes.restitution_change", 0.15),
    ("order.restitution_change", 0.15),
    # responses
    ("matching.response_length", 1),
    ("matching.response_length", 81),
]


@pytest.mark.parametrize("case", BAD, ids=lambda case: f"{case[0]}={case[1]!r:.30}")
def test_an_error_is_one_line_that_begins_with_the_key(case):
    key, value, *named = case
    raw = inner = stated()
    *sections, last = key.split(".")
    for section in sections:
        inner = inner[section]
    inner[last] = value
    with pytest.raises(InputError) as caught:
        parse_config(raw)
    (line,) = str(caught.value).splitlines()
    assert line.startswith((named or [key])[0])
