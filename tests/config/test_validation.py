"""A config is checked once: by its schema, by what its stages' settings are made into, by the rules between keys."""

import math
import re

import pytest
from jsonschema import Draft202012Validator
from repository import ROOT
from rockdamp.config.merging import merged
from rockdamp.config.validation import validate

from rockdamp.config import schema, validation
from rockdamp.errors import InputError, InputWarning
from rockdamp.storage.dotted_keys import path_of, stated

SCHEMA = ROOT / "workflow/schemas/config.schema.yaml"
DEFAULT = ROOT / "config/default.yaml"
MINIMAL = ROOT / "config/minimal.yaml"


@pytest.fixture
def config(monkeypatch):
    monkeypatch.chdir(ROOT)  # the record's path is seen from the folder of the run
    return merged([DEFAULT], {})


def put(config, key, value):
    *sections, last = path_of(key)
    inner = stated(config, tuple(sections))
    inner[last] = value


def complaints(config):
    with pytest.raises(InputError) as caught:
        validate(config, SCHEMA, [DEFAULT])
    return str(caught.value).splitlines()


# --- what is shipped ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("files", [[DEFAULT], [DEFAULT, MINIMAL]], ids=["default", "minimal"])
def test_the_shipped_configs_are_valid(files, monkeypatch):
    monkeypatch.chdir(ROOT)
    validate(merged(files, {}), SCHEMA, files)


def sections(schema, definitions, path=()):
    """Every place of the schema that describes a key, references followed."""
    for key, entry in schema.get("properties", {}).items():
        reference = entry.get("$ref")
        yield (*path, key), entry
        target = definitions[reference.rpartition("/")[2]] if reference else entry
        yield from sections(target, definitions, (*path, key))
        assert ("type" in target) or ("enum" in target) or ("anyOf" in target), path


# Keys that may be absent, by definition: config.py asks for one or the other.
OPTIONAL = {
    "earthquake_wall": {"parapet", "hinge_ratio", "preset", "yield_displacement_ratio", "strength_ratio"},
    "distribution": {"mean", "standard_deviation"},
}


def test_every_key_is_described_and_required_and_none_is_left_open():
    schema = validation.read_schema(SCHEMA)
    Draft202012Validator.check_schema(schema)
    definitions = schema["$defs"]
    described = dict(sections(schema, definitions))
    assert len(described) > 60
    for path, entry in described.items():
        assert entry.get("description"), path
    for name, entry in [("", schema), *described.items(), *definitions.items()]:
        if entry.get("type") != "object":
            continue
        if "properties" in entry:
            assert entry["additionalProperties"] is False
            assert set(entry["required"]) | OPTIONAL.get(name, set()) == set(entry["properties"])
        else:  # a mapping from names of a closed set
            assert definitions[entry["propertyNames"]["$ref"].rpartition("/")[2]]["enum"]
            assert entry["additionalProperties"]["type"] in ("number", "object")


def numbers_of(entry):
    """Every part of the schema that accepts a number."""
    if isinstance(entry, dict):
        if entry.get("type") in ("number", "integer"):
            yield entry
        entry = list(entry.values())
    for inner in entry if isinstance(entry, list) else ():
        yield from numbers_of(inner)


def test_every_number_and_every_list_of_numbers_has_bounds():
    """So that no config overflows a formula, or asks for a job that no computer can run."""
    found = list(numbers_of(validation.read_schema(SCHEMA)))
    assert len(found) > 50
    for entry in found:
        assert {"minimum", "exclusiveMinimum"} & entry.keys() and {"maximum", "exclusiveMaximum"} & entry.keys(), entry


# --- bad input ------------------------------------------------------------------------------------------------------

NAMED = {"name": "mine", "thickness": 0.2, "slenderness": 10, "overburden_ratio": 0.0, "hinge_ratio": 0.5}
NAMED |= {"yield_displacement_ratio": 0.04, "strength_ratio": 0.85}
PRESET = {key: value for key, value in NAMED.items() if key != "hinge_ratio"}

BAD = [
    # a value outside its range
    ("wall.thickness", 0, "wall.thickness is 0; it must be a number greater than 0 and at most 1000000"),
    ("wall.hinge_ratio", 0, "wall.hinge_ratio is 0; it must be a number greater than 0 and less than 1"),
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
    ("figures.formats", ["pdf"], "figures.formats is ['pdf']; png must be among them"),
    ("pulses.restitution", [i / 2000 for i in range(1, 1002)], "has 1001 of them; it must be a list of at least 1 and"),
    # a distribution that cannot be
    ("identification.prior.strength_ratio.high", 0.3, "strength_ratio.high is 0.3; it must be greater than low, 0.4"),
    ("identification.prior.strength_ratio.high", 1.0, "strength_ratio.high is 1.0; it must be a number less than 1"),
    ("identification.prior.damping_ratio.low", -0.1, "damping_ratio.low is -0.1; it must be a number at least 0"),
    ("identification.prior.order.low", 0.0, "prior.order.low is 0.0; it must be greater than 0 for loguniform"),
    ("identification.simulated.pulse_peak.low", -1.0, "pulse_peak.low is -1.0; it must be a number greater than 0"),
    ("population.parameters.thickness.low", 0.6, "thickness.high is 0.5; it must be greater than low, 0.6"),
    ("population.parameters.overburden_ratio.low", -1, "overburden_ratio.low is -1; it must be a number at least 0"),
    ("population.parameters.thickness.mean", 0.2, "thickness.distribution is 'uniform'; mean and standard_deviation"),
    (
        "population.parameters.strength_ratio.high",
        0.9,
        "yield_displacement_ratio.high is 0.14; it must be less",
    ),
    ("population.correlations.thickness", {"thickness": 0.5}, "population.correlations.thickness states thickness"),
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
    (
        "amplitude_dependence.yield_displacement_ratio",
        [0.04, 0.3],
        "amplitude_dependence.yield_displacement_ratio has a curve that can",
    ),
    (
        "amplitude_dependence.ultimate_displacement_ratio",
        0.3,
        "amplitude_dependence.ultimate_displacement_ratio is 0.3; a3 must be greater than 1 - b1",
    ),
    ("wall.eccentricity", -0.2, "wall.eccentricity is -0.2; it must be"),
    ("wall.slenderness", 0.1, "wall.thickness is 0.3 m and height 0.03 m, which is h/t = 0.1; it must be at least 1"),
    ("studies.slenderness.slenderness", [1.2, 15], "studies.slenderness cannot be used: thickness is 0.3 m and height"),
    (
        "damping_force.rigid.height",
        0.1,
        "damping_force.rigid.thickness is 0.4 m and height 0.1 m, which is h/t = 0.25; it must be",
    ),
    ("validation.wall.hinge_ratio", 0.004, "e is -0.0122 by Eq. (7); it must be above 0"),
    (
        "population.parameters.slenderness.low",
        1.3,
        "parameters.slenderness.low makes a wall that cannot rock",
    ),
    ("accuracy.rigid.slenderness", [1.1, 20], "accuracy.rigid.slenderness makes a wall that cannot rock"),
    ("earthquakes.walls", [{**PRESET, "hinge_ratio": 0.5, "parapet": True}], "walls[0].hinge_ratio is not a key"),
    ("earthquakes.walls", [PRESET], "earthquakes.walls[0].hinge_ratio is missing"),
    ("earthquakes.walls", [{**NAMED, "preset": "new"}], "earthquakes.walls[0].yield_displacement_ratio is not a key"),
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
    ("pulses.step", 0.5, "pulses.step is 0.5; it must be less than the stability limit"),
    ("damper_order.pulses.step", 0.5, "damper_order.pulses.step is 0.5; it must be less than the stability limit"),
    ("earthquakes.walls", [{**NAMED, "strength_ratio": 0.005}], "earthquakes.walls[0] has its first impact at 1"),
    ("release_amplitude", 1.0, "release_amplitude is 1.0; it must be less than a3, 1, where the wall collapses"),
    ("studies.amplitude.release_amplitude", [0.5, 1.2], "release_amplitude[1] is 1.2; it must be less than a3"),
    ("response_lengths.start", 1, "response_lengths.start is 1.0; it must be greater than 2.99"),
    ("matching.response_length", 2, "matching.response_length is 2.0; it must be greater than 2.99"),
    ("matching.response_length", 81, "matching.response_length is 81.0; it must be at most response_lengths.stop, 80"),
    ("damping_force.response_length", 1.5, "damping_force.response_length is 1.5; it must be greater than 2.99"),
    ("amplitude_dependence.release_share", [0.5, 0.9999], "must come before the end of matching.response_length"),
    ("studies.overburden.overburden_ratio", [0, 200], "overburden_ratio[1] is 200; at "),
    ("studies.slenderness.slenderness", [15, 9000], "slenderness[1] is 9000; at "),
    # grids, and what other stages look up in them
    (
        "studies.slenderness.slenderness",
        [20, 10],
        "slenderness[1] is 10; it must be greater than the value before it",
    ),
    ("pulses.frequency.stop", 0.1, "frequency.stop is 0.1; it must be greater than pulses.frequency.start, 0.5"),
    ("restitution.stop", 0.5, "restitution.stop is 0.5; it must be greater than restitution.start, 0.7"),
    ("restitution.step", 0.03, "restitution.step is 0.03; it must be such that a whole number of steps leads from"),
    ("restitution.step", 0.28, "restitution.step is 0.28; there must be at least 3 values"),
    ("release_amplitude", 0.4, "release_amplitude is 0.4; it must be among studies.amplitude.release_amplitude"),
    ("validation.restitution", 0.6, "validation.restitution is 0.6; it must lie within the e of the polynomials"),
    ("validation.fit_yield_displacement_ratios", [0.01], "ratios[0] is 0.01; it must lie within the a1 of the poly"),
    ("studies.cracked_stiffness.yield_displacement_ratio", [0.17], "has no value with the plateau of curve"),
    ("matching.scan.smallest", 3.0, "matching.scan.largest is 3.0; it must be greater than smallest, 3"),
    (
        "earthquakes.restitution",
        [0.995],
        "earthquakes.restitution_change is 0.01; every e of earthquakes, 0.75 to 0.995, must",
    ),
    (
        "earthquakes.orders.test_spread",
        0.06,
        "earthquakes.orders.test_spread is 0.06; e of earthquakes.orders, up to 0.95, must stay up to 1",
    ),
    ("damper_order.restitution_change", 0.16, "damper_order.restitution_change is 0.16; every e of damper_order"),
    ("validation.record", "data/none.csv", "validation.record is 'data/none.csv'; it must be a file"),
    ("validation.record", "pyproject.toml", "a record without displacement_m; it must hold the wall's displacement"),
    ("validation.test_series", ["data/none.csv"], "validation.test_series[0] is 'data/none.csv'; it must be a file"),
    (
        "validation.test_series",
        ["data/test_series/cr-half.csv", "./data/test_series/cr-half.csv"],
        "validation.test_series[1] is named 'cr-half', as one before it; each must have a name of its own",
    ),
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


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("natural", "earthquakes"),
        ("earthquakes.scale", "earthquakes.velocity_ratio"),
        ("windows", "response_lengths"),
        ("matching.window", "matching.response_length"),
        ("loops", "damping_force"),
        ("damping_force.window", "damping_force.response_length"),
        ("dispersion", "amplitude_dependence"),
        ("validation.ladder", "validation.test_series"),
        ("identification.ladder", "identification.test_series"),
        ("validation.fit_cracked_stiffness_ratios", "validation.fit_yield_displacement_ratios"),
        ("curve.cracked_stiffness_ratio", "curve.yield_displacement_ratio"),
        ("curve.plateau_ratio", "curve.strength_ratio"),
        ("validation.curve.ultimate_ratio", "validation.curve.ultimate_displacement_ratio"),
        ("studies.cracked_stiffness.cracked_stiffness_ratio", "studies.cracked_stiffness.yield_displacement_ratio"),
        ("studies.cracked_stiffness.plateau_ratio_beyond", "studies.cracked_stiffness.strength_ratio_beyond"),
        ("identification.prior.plateau_ratio", "identification.prior.strength_ratio"),
        ("population.parameters.cracked_stiffness_ratio", "population.parameters.yield_displacement_ratio"),
        ("population.correlations.plateau_ratio", "population.correlations.strength_ratio"),
        ("earthquakes.walls[0].cracked_stiffness_ratio", "yield_displacement_ratio"),
    ],
)
def test_an_old_key_ends_in_one_line_with_its_new_name(old, new, config):
    *sections, last = path_of(old)
    section = stated(config, tuple(sections))
    section[last] = section.pop(path_of(new)[-1], {})
    (line,) = complaints(config)
    assert re.search(rf": {re.escape(old)} is now called (\S+\.)?{path_of(new)[-1]}$", line)


@pytest.mark.parametrize(
    ("old", "new"),
    [("natural", "earthquakes"), ("orders", "convergence"), ("fig_natural_ratio", "fig_earthquakes_ratio")],
)
def test_an_old_target_ends_in_one_line_with_its_new_name(old, new):
    schema.refuse_old_targets(["all", "fig1", new, "results/orders.nc"])
    with pytest.raises(InputError, match=f"^{old} is now called {new}$"):
        schema.refuse_old_targets(["fig1", old])


# --- where it stands ------------------------------------------------------------------------------------------------


def report(files, **changes):
    """The one line about files that are merged in this order, then changed as on the command line."""
    with pytest.raises(InputError) as caught:
        validate(merged(files, changes), SCHEMA, files)
    return str(caught.value)


def test_an_error_names_file_and_line_of_the_value(tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    own = tmp_path / "own.yaml"
    own.write_text("wall:\n  width: 2.0\n  thickness: -0.3\n", encoding="utf-8")
    assert report([DEFAULT, own]).startswith(f"{own}, line 3: wall.thickness is -0.3;")
    # A later file that leaves the value alone is not blamed.
    assert report([DEFAULT, own, MINIMAL]).startswith(f"{own}, line 3: wall.thickness is -0.3;")


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
    advice = "; write nested values in a file and pass --configfile"
    assert report([DEFAULT], wall={"thickness": -1}).endswith(advice)
    assert report([DEFAULT], restitution=0.9).endswith(f"a mapping of keys to values{advice}")
    assert advice not in report([DEFAULT], release_amplitude=-1)


# --- walls that are possible and unlikely ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("wall.thickness", 3.0, "wall makes an unlikely wall: thickness is 3 m and height 45 m"),
        ("validation.wall.thickness", 102.0, "; were they in millimetres"),
        ("wall.density", 18, "wall makes an unlikely wall: density is 18 kg m-3, less than 300; was it in kN m-3"),
        ("earthquakes.walls[4].overburden_ratio", 20, "walls[4] makes an unlikely wall: overburden_ratio is 20"),
        ("population.parameters.thickness.high", 2.4, "population.parameters.thickness.high makes an"),
    ],
)
def test_a_wall_larger_than_any_is_warned_of_where_it_stands(config, key, value, expected):
    put(config, key, value)
    with pytest.warns(InputWarning) as caught:
        validate(config, SCHEMA, [DEFAULT])
    assert any(expected in str(one.message) for one in caught)
    assert all(str(one.message).startswith(("the command line: ", f"{DEFAULT}, line ")) for one in caught)
