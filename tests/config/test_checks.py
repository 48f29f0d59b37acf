"""A config is checked once: by its model, and by the rules between its keys."""

import math

import numpy as np
import pytest
from configs import configured, stated
from repository import ROOT

from rockdamp.config import Config
from rockdamp.config.checks import validate
from rockdamp.config.files import merged
from rockdamp.errors import InputError, InputWarning
from rockdamp.laboratory.sections import LaboratoryConfig, broken
from rockdamp.mechanics.wall import Parapet
from rockdamp.pipeline.tables import STAGES
from rockdamp.storage.yaml_file import get as value_at
from rockdamp.storage.yaml_file import path_of
from rockdamp.vocabulary import DEFAULT_RESPONSE_LENGTH, STUDIES

DEFAULT = ROOT / "config/default.yaml"
MINIMAL = ROOT / "config/minimal.yaml"


@pytest.fixture
def config(monkeypatch):
    monkeypatch.chdir(ROOT)  # the record's path is seen from the folder of the run
    return stated()


def checked(raw, files=(DEFAULT,)):
    return validate(LaboratoryConfig, raw, files, [broken])


def put(config, key, value):
    *sections, last = path_of(key)
    inner = value_at(config, tuple(sections))
    inner[last] = value


def complaints(config):
    with pytest.raises(InputError) as caught:
        checked(config)
    return str(caught.value).splitlines()


# --- what is shipped ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("files", [[DEFAULT], [DEFAULT, MINIMAL]], ids=["default", "minimal"])
def test_the_shipped_configs_are_valid(files, monkeypatch):
    monkeypatch.chdir(ROOT)
    checked(merged(files, {}), files)


def objects(schema):
    """Every section that a schema describes."""
    for part in [schema, *schema["$defs"].values()]:
        if "properties" in part:
            yield part


# Keys that may be absent, where another one stands in their place.
OPTIONAL = {
    "parapet",
    "hinge_ratio",
    "preset",
    "yield_displacement_ratio",
    "strength_ratio",
    "mean",
    "standard_deviation",
}


def test_every_key_is_described_and_required_and_none_is_left_open():
    sections = list(objects(LaboratoryConfig.model_json_schema()))
    assert sum(len(section["properties"]) for section in sections) > 100
    for section in sections:
        assert section["additionalProperties"] is False
        assert set(section["properties"]) - set(section["required"]) <= OPTIONAL
        for name, entry in section["properties"].items():
            assert entry.get("description"), name


def numbers_of(entry):
    """Every part of the schema that accepts a number."""
    if isinstance(entry, dict):
        if entry.get("type") in ("number", "integer"):
            yield entry
        entry = list(entry.values())
    for inner in entry if isinstance(entry, list) else ():
        yield from numbers_of(inner)


def test_every_number_has_bounds():
    """So that no config overflows a formula, or asks for a job that no computer can run."""
    found = list(numbers_of(LaboratoryConfig.model_json_schema()))
    assert len(found) > 50
    for entry in found:
        assert {"minimum", "exclusiveMinimum"} & entry.keys() and {"maximum", "exclusiveMaximum"} & entry.keys(), entry


# --- what a stage is given ------------------------------------------------------------------------------------------


def test_a_part_has_what_its_keys_name_and_nothing_else():
    part = configured().part(["curve", "earthquakes.walls", "earthquakes.check.seed", "studies.amplitude"])
    assert float(part.curve.strength_ratio) == 0.85 and part.earthquakes.check.seed == 1
    assert part.studies.amplitude.release_amplitude.tolist() == [0.1, 0.2, 0.3, 0.5, 0.7, 0.9]
    for ask in (lambda: part.wall, lambda: part.earthquakes.step, lambda: part.earthquakes.check.histories):
        with pytest.raises(AttributeError):
            ask()


@pytest.mark.parametrize("minimal", [False, True])
def test_each_stage_names_keys_that_the_config_has(minimal):
    config = configured(minimal=minimal)
    for stage in STAGES.values():
        for study in STUDIES:
            assert config.part(key.format(study=study) for key in stage.config).plain() or not stage.config


def test_plain_values_are_those_that_stages_compute_with():
    plain = configured().part(["wall", "restitution", "matching"]).plain()
    assert plain["wall"]["height"] == pytest.approx(4.5) and "slenderness" not in plain["wall"]
    assert plain["restitution"] == [round(0.70 + 0.01 * i, 2) for i in range(29)]
    assert plain["matching"]["response_length"] == DEFAULT_RESPONSE_LENGTH


def test_a_default_that_is_written_out_changes_no_plain_value():
    written = {"matching": {"response_length": DEFAULT_RESPONSE_LENGTH}, "solver": {"step": 2.5e-3}}
    assert configured(written).plain() == configured().plain()


def test_sections_of_a_study_that_are_null_are_left_out():
    config = configured({"earthquakes": None, "amplitude": None})
    assert not config.has(["solver", "earthquakes.walls"]) and config.has(["solver", "bilinear"])
    assert config.plain()["amplitude"] is None
    with pytest.raises(ValueError, match="wall"):
        configured({"wall": None})


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_varies_its_parameter_and_nothing_else(name):
    config, raw = configured(), stated()
    study, values = config.study(name), raw["studies"][name][STUDIES[name]]
    assert study.values.tolist() == values and study.curve.shape == (len(values),)
    for index, value in enumerate(values):
        a1 = value if name == "cracked_stiffness" else 0.04
        own = study.curve.map(lambda p, index=index: p[index])
        assert (own.yield_displacement_ratio, own.strength_ratio) == (a1, 0.75 if a1 >= 0.15 else 0.85)
        assert study.release_amplitude[index] == (value if name == "amplitude" else 0.5)
        own_wall = configured({"wall": {STUDIES[name]: value}} if STUDIES[name] in raw["wall"] else {}).wall
        assert study.frequency_parameter[index] == own_wall.frequency_parameter


def test_walls_that_earthquakes_shake_have_a_hinge_or_are_parapets_with_a_preset_or_their_own_curve():
    made = {named.name: named for named in configured().earthquakes.walls}
    assert list(made) == [entry["name"] for entry in stated()["earthquakes"]["walls"]]
    assert [name for name, named in made.items() if isinstance(named.wall, Parapet)] == ["parapet"]
    assert float(made["degraded"].curve.strength_ratio) == 0.50 and float(made["church"].curve.strength_ratio) == 0.85
    assert float(made["degraded"].wall.height) == 4.0 and float(made["degraded"].wall.hinge_ratio) == 0.6


def test_the_core_has_no_section_of_measured_tests():
    assert "measured_rocking" not in Config.model_fields
    np.testing.assert_array_equal(configured().measured_rocking.impacts_used, [6, 8, 10, 14])


# --- bad input ------------------------------------------------------------------------------------------------------

NAMED = {"name": "mine", "thickness": 0.2, "slenderness": 10, "overburden_ratio": 0.0, "hinge_ratio": 0.5}
NAMED |= {"yield_displacement_ratio": 0.04, "strength_ratio": 0.85}
PRESET = {key: value for key, value in NAMED.items() if key != "hinge_ratio"}

BAD = [
    # a value outside its range
    ("wall.thickness", 0, "wall.thickness is 0; it must be a number greater than 0 and at most 1000000"),
    ("wall.hinge_ratio", 0, "wall.hinge_ratio is 0; it must be a number greater than 0 and less than 1"),
    ("wall.thickness", -0.1, "wall.thickness is -0.1; it must be a number greater than 0 and at most 1000000 [m]"),
    ("wall.overburden_ratio", -0.1, "wall.overburden_ratio is -0.1; it must be a number at least 0"),
    ("studies.overburden.overburden_ratio", [0, -1], "overburden_ratio[1] is -1; it must be a number at least 0"),
    ("restitution.stop", 1.01, "restitution.stop is 1.01; it must be a number greater than 0 and at most 1"),
    ("curve.strength_ratio", 1, "curve.strength_ratio is 1; it must be a number greater than 0 and less than 1"),
    ("solver.step", 0, "solver.step is 0; it must be a number at least 0.0001 and at most 1"),
    ("figures.resolution", 99.5, "figures.resolution is 99.5; it must be a whole number at least 30 and at most 1200"),
    ("matching.response_length", -3, "matching.response_length is -3; it must be 'default' or a number greater than 0"),
    # something else than a number
    ("wall.thickness", math.nan, "wall.thickness is nan; it must be a finite number"),
    ("studies.slenderness.slenderness", [10, math.inf], "slenderness[1] is inf; it must be a finite number"),
    ("wall.thickness", True, "wall.thickness is True; it must be a number greater than 0"),
    ("earthquakes.walls", [{"parapet": 3}], "earthquakes.walls[0].parapet is 3; it must be true or false"),
    ("wall.thickness", None, "wall.thickness is None; it must be a number greater than 0"),
    ("wall.thickness", "300mm", "and at most 1000000, in m and without the unit: 0.3"),
    ("wall.overburden_ratio", "50%", "per cent is a fraction here, 0.5 for 50%"),
    ("solver.step", "1e-3", "solver.step is the text '1e-3'; it must be a number at least 0.0001 and at most 1 (YAML"),
    ("wall", 3, "wall is 3; it must be a mapping of keys to values"),
    ("restitution", [0.7, 0.8], "restitution is [0.7, 0.8]; it must be a mapping of keys to values"),
    ("studies.slenderness.slenderness", {"a": 1}, "is a mapping of keys to values; it must be a list of at least 1"),
    ("studies.slenderness.slenderness", [], "slenderness has 0 of them; it must be a list of at least 1"),
    ("studies.slenderness.slenderness", [10, 10], "slenderness has 10 twice; its values must differ"),
    ("records", ["a.csv", 1], "records[1] is 1; it must be text"),
    # a name that is not known
    ("solver.scheme", "euler", "solver.scheme is 'euler'; it must be one of newmark, paper"),
    ("figures.formats", ["jpg"], "figures.formats[0] is 'jpg'; it must be one of pdf, png, svg"),
    ("studies.amplitud", {}, "studies.amplitud is not a key; did you mean 'amplitude'?"),
    ("solver.tolerance", 1, "solver.tolerance is not a key; it must be one of scheme, step"),
    ("hinge", 0.7, "hinge is not a key; it must be one of results, solver,"),
    ("wall.hinge", 0.7, "wall.hinge is not a key; did you mean 'hinge_ratio'?"),
    ("wall.height", 4.5, "wall.height is not a key; state slenderness, the height over the thickness"),
    ("curve.strength_ratio", 85, "greater than 0 and less than 1; was it in per cent (0.85)?"),
    ("figures.formats", ["pdf"], "figures.formats is ['pdf']; png must be among them"),
    (
        "amplitude.restitution",
        [i / 2000 for i in range(1, 1002)],
        "has 1001 of them; it must be a list of at least 1",
    ),
    # a wall or a curve that cannot be
    ("curve.yield_displacement_ratio", 0.16, "curve.yield_displacement_ratio is 0.16; it must be less than a2"),
    (
        "curve.ultimate_displacement_ratio",
        0.15,
        "curve.ultimate_displacement_ratio is 0.15; it must be greater than 1 - b1 with steeper",
    ),
    ("studies.cracked_stiffness.yield_displacement_ratio", [0.02, 0.04, 0.3], "ratio is 0.3; it must be less than a2"),
    (
        "validation.curve.yield_displacement_ratio",
        0.2,
        "validation.curve.yield_displacement_ratio is 0.2; it must",
    ),
    (
        "damping_force.rigid.yield_displacement_ratio",
        0.2,
        "damping_force.rigid.yield_displacement_ratio is 0.2; it must be less than a2",
    ),
    ("wall.eccentricity", -0.2, "wall.eccentricity is -0.2; it must be"),
    (
        "wall.slenderness",
        0.1,
        "wall cannot be used: thickness is 0.3 m and height 0.03 m, which is h/t = 0.1",
    ),
    ("studies.slenderness.slenderness", [1.2, 15], "studies.slenderness cannot be used: thickness is 0.3 m and height"),
    (
        "damping_force.rigid.height",
        0.1,
        "damping_force.rigid cannot be used: thickness is 0.4 m and height 0.1 m, which is h/t = 0.25; it must be",
    ),
    ("validation.wall.hinge_ratio", 0.004, "e is -0.0122 by Eq. (7); it must be above 0"),
    ("earthquakes.walls", [{**PRESET, "hinge_ratio": 0.5, "parapet": True}], "walls[0].hinge_ratio is not a key"),
    ("earthquakes.walls", [PRESET], "earthquakes.walls[0].hinge_ratio is missing"),
    ("earthquakes.walls", [{**NAMED, "preset": "new"}], "earthquakes.walls[0].strength_ratio is not a key"),
    (
        "earthquakes.walls",
        [{**NAMED, "yield_displacement_ratio": 0.3}],
        "walls[0].yield_displacement_ratio is 0.3; it must",
    ),
    ("earthquakes.walls", [NAMED, NAMED], "earthquakes.walls[1].name is named 'mine', as one before it"),
    # time
    ("solver.step", 0.15, "solver.step is 0.15; it must be less than the stability limit 2 sqrt(a1/b1), 0.142134"),
    ("earthquakes.walls", [{**NAMED, "yield_displacement_ratio": 1e-6}], "stability limit 2 sqrt(a1/b1), 0.00216"),
    ("validation.step", 0.5, "validation.step is 0.5; it must be less than the stability limit"),
    ("earthquakes.walls", [{**NAMED, "strength_ratio": 0.005}], "earthquakes.walls[0] has its first impact at 1"),
    ("release_amplitude", 1.0, "release_amplitude is 1.0; it must be less than a3, 1, where the wall collapses"),
    ("studies.amplitude.release_amplitude", [0.5, 1.2], "release_amplitude[1] is 1.2; it must be less than a3"),
    ("response_lengths.start", 1, "response_lengths.start is 1.0; it must be greater than 2.99"),
    ("matching.response_length", 2, "matching.response_length is 2.0; it must be greater than 2.99"),
    ("matching.response_length", 81, "matching.response_length is 81.0; it must be at most response_lengths.stop, 80"),
    ("damping_force.response_length", 1.5, "damping_force.response_length is 1.5; it must be greater than 2.99"),
    ("amplitude.release_share", [0.5, 0.9999], "must come before the end of matching.response_length"),
    ("studies.overburden.overburden_ratio", [0, 200], "overburden_ratio[1] is 200; at "),
    ("studies.slenderness.slenderness", [15, 3000], "slenderness[1] is 3000; at "),
    # grids, and what other stages look up in them
    (
        "studies.slenderness.slenderness",
        [20, 10],
        "slenderness[1] is 10; it must be greater than the value before it",
    ),
    ("bilinear.velocity_ratio.stop", 0.1, "velocity_ratio.stop is 0.1; it must be greater than start, 0.2"),
    ("restitution.stop", 0.5, "restitution.stop is 0.5; it must be greater than start, 0.7"),
    ("restitution.step", 0.03, "restitution.step is 0.03; it must be such that a whole number of steps leads from"),
    ("restitution.step", 0.28, "restitution.step makes 2 values; there must be at least 3 values"),
    ("release_amplitude", 0.4, "release_amplitude is 0.4; it must be among studies.amplitude.release_amplitude"),
    ("validation.fit_yield_displacement_ratios", [0.01], "ratios[0] is 0.01; it must lie within the a1 of the poly"),
    ("studies.cracked_stiffness.yield_displacement_ratio", [0.17], "has no value with the plateau of curve"),
    ("matching.scan.smallest", 3.0, "matching.scan.largest is 3.0; it must be greater than smallest, 3"),
    (
        "earthquakes.restitution",
        [0.995],
        "earthquakes.restitution_change is 0.01; every e of earthquakes, 0.995 to 0.995, must",
    ),
    ("order.restitution_change", 0.16, "order.restitution_change is 0.16; every e of order"),
    ("order.order", [0, 8], "order.order is [0.0, 8.0]; it must have 16"),
    ("order.band_width", [0.1, 0.2], "order.band_width is [0.1, 0.2]; it must have 0.2 and 0.4"),
    ("validation.record", "data/none.csv", "validation.record is 'data/none.csv'; it must be a file"),
    ("validation.record", "pyproject.toml", "a record without displacement_m; it must hold the wall's displacement"),
    # what no computer can run, key by key
    (
        "convergence.lanes",
        10**12,
        "lanes is 1000000000000; it must be a whole number at least 1 and at most",
    ),
    ("solver.step", 1e-9, "solver.step is 1e-09; it must be a number at least 0.0001 and at most 1"),
    ("validation.wall.density", 10**400, "and at most 1000000"),
]


@pytest.mark.parametrize(("key", "value", "expected"), BAD, ids=[f"{key}={value}"[:60] for key, value, _ in BAD])
def test_bad_input_is_named_with_its_value_and_what_is_allowed(config, key, value, expected):
    put(config, key, value)
    assert any(expected in line for line in complaints(config))


def test_translated_softening_needs_room_behind_the_plateau(config):
    config["curve"] |= {"ultimate_displacement_ratio": 0.88, "softening": "translated"}
    said = "curve.ultimate_displacement_ratio is 0.88; it must be greater than a1 + b1 with translated softening"
    assert any(said in line for line in complaints(config))


def test_a_missing_key_is_named(config):
    del config["wall"]["density"]
    (line,) = complaints(config)
    assert line.endswith("wall.density is missing")


def test_a_misspelt_key_is_not_reported_as_missing_too(config):
    config["wall"]["thicknes"] = config["wall"].pop("thickness")
    (line,) = complaints(config)
    assert line.endswith("wall.thicknes is not a key; did you mean 'thickness'?")


def test_every_problem_has_its_own_line(config):
    config["wall"]["thickness"], config["solver"]["step"] = -1, 0
    assert len(complaints(config)) == 2


# --- where it stands ------------------------------------------------------------------------------------------------


def report(files, **changes):
    """The one line about files that are merged in this order, then changed as on the command line."""
    with pytest.raises(InputError) as caught:
        checked(merged(files, changes), files)
    return str(caught.value)


def test_an_error_names_file_and_line_of_the_value(tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    own = tmp_path / "own.yaml"
    own.write_text("wall:\n  width: 2.0\n  thickness: -0.3\n", encoding="utf-8")
    assert report([DEFAULT, own]).startswith(f"{own}, line 3: wall.thickness is -0.3;")
    # A later file that leaves the value alone is not blamed.
    assert report([DEFAULT, own, MINIMAL]).startswith(f"{own}, line 3: wall.thickness is -0.3;")


def test_an_error_of_a_section_names_the_file_that_states_a_part_of_it(tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    high, wide = tmp_path / "high.yaml", tmp_path / "wide.yaml"
    high.write_text("# mine\nwall: {thickness: 99}\n", encoding="utf-8")
    wide.write_text("wall: {width: 2}\n", encoding="utf-8")
    assert report([DEFAULT, high]).startswith(f"{high}, line 2: wall cannot be used: thickness is 99 m and height")
    assert report([DEFAULT, high, MINIMAL]).startswith(f"{high}, line 2: wall cannot be used")
    assert report([DEFAULT, wide], wall={"thickness": 99}).startswith("the command line: wall cannot be used")


def test_an_error_names_the_line_of_an_item_in_a_list(tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    own = tmp_path / "own.yaml"
    own.write_text("studies:\n  slenderness:\n    slenderness:\n      - 10\n      - 0\n", encoding="utf-8")
    assert report([DEFAULT, own]).startswith(f"{own}, line 5: studies.slenderness.slenderness[1] is 0;")


def test_a_missing_key_is_looked_for_in_its_section(tmp_path):
    own = tmp_path / "own.yaml"
    own.write_text(DEFAULT.read_text(encoding="utf-8").replace("  density: 1800 ", "  # none "), encoding="utf-8")
    line = 1 + own.read_text(encoding="utf-8").splitlines().index("wall:                    # Figs 5 to 7")
    assert report([own]) == f"{own}, line {line}: wall.density is missing"


def test_an_error_tells_a_value_of_the_command_line_from_a_files(monkeypatch):
    monkeypatch.chdir(ROOT)
    assert report([DEFAULT], wall={"thickness": -1}).startswith("the command line: wall.thickness is -1;")
    assert report([DEFAULT], wall={"widht": 1}).startswith("the command line: wall.widht is not a key;")
    assert report([DEFAULT], wal={"thickness": 1}).startswith("the command line: wal is not a key;")
    assert report([DEFAULT], wall={"thickness": "0,3"}).endswith("(a number's decimal sign is a point)")


# --- walls that are possible and unlikely ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("wall.thickness", 3.0, "wall makes an unlikely wall: thickness is 3 m and height 45 m"),
        ("validation.wall.thickness", 10.2, "; were they in centimetres"),
        (
            "wall.thickness",
            0.1,
            "wall makes an unlikely wall: the height is 1.5 m, less than a storey has; was it half",
        ),
        ("wall.density", 18, "wall makes an unlikely wall: density is 18 kg m-3, less than 300; was it in kN m-3"),
        ("earthquakes.walls[4].overburden_ratio", 20, "walls[4] makes an unlikely wall: overburden_ratio is 20"),
        ("wall.width", 0.1, "wall makes an unlikely wall: width is 0.1 m, less than the thickness of 0.3 m"),
        ("wall.hinge_ratio", 0.07, "wall makes an unlikely wall: hinge_ratio is 0.07 of the height"),
        ("amplitude.restitution", [0.05], "amplitude.restitution is unlikely: restitution (e) is 0.05, less than 0.5"),
    ],
)
def test_a_wall_larger_than_any_is_warned_of_where_it_stands(config, key, value, expected):
    put(config, key, value)
    with pytest.warns(InputWarning) as caught:
        checked(config)
    assert any(expected in str(one.message) for one in caught)
    assert all(str(one.message).startswith(("the command line: ", f"{DEFAULT}, line ")) for one in caught)


def test_what_is_unlikely_stands_before_the_errors_that_it_leads_to():
    swapped = {"yield_displacement_ratio": 0.85, "strength_ratio": 0.04}
    first, *others = report([DEFAULT], curve=swapped).splitlines()
    assert first.startswith("the command line: curve makes an unlikely curve: yield_displacement_ratio (a1) is 0.85")
    assert "were a1 and b1 swapped?" in first and others
