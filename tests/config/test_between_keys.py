"""The config: its schema, the checks between its keys, and how an error reads."""

import copy
import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from repository import ROOT

from rockdamp import plausibility
from rockdamp.config import between_keys as checks
from rockdamp.config.schema import ascending
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Wall, angular_momentum_restitution
from rockdamp.storage import yaml_file
from rockdamp.vocabulary import SOFTENING

SCHEMA = ROOT / "workflow/schemas/config.schema.yaml"
DEFAULT = ROOT / "config/default.yaml"
MINIMAL = ROOT / "config/minimal.yaml"


def load(path):
    return yaml_file.load(path.read_text(encoding="utf-8"))


def merged(one, other):
    """As snakemake merges: mappings key by key, everything else replaced."""
    if not isinstance(one, dict) or not isinstance(other, dict):
        return other
    return {**one, **{key: merged(one[key], value) if key in one else value for key, value in other.items()}}


@pytest.fixture
def config(monkeypatch):
    monkeypatch.chdir(ROOT)  # the record's path is seen from the folder of the run
    return copy.deepcopy(load(DEFAULT))


def put(config, key, value):
    *sections, last = key.split(".")
    for section in sections:
        config = config[section]
    config[last] = value


def complaints(config):
    with pytest.raises(InputError) as caught:
        checks.validate(config, SCHEMA, [DEFAULT])
    return str(caught.value).splitlines()


# --- what is shipped ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("files", [[DEFAULT], [DEFAULT, MINIMAL]], ids=["default", "minimal"])
def test_the_shipped_configs_are_valid(files, monkeypatch):
    monkeypatch.chdir(ROOT)
    config = {}
    for file in files:
        config = merged(config, load(file))
    checks.validate(config, SCHEMA, files)


def test_the_minimal_config_is_built_elsewhere():
    assert load(MINIMAL)["results"] != load(DEFAULT)["results"]


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
    "natural_wall": {"parapet", "hinge_ratio", "preset", "cracked_stiffness_ratio", "plateau_ratio"},
    "distribution": {"mean", "standard_deviation"},
}


def test_every_key_is_described_and_required_and_none_is_left_open():
    schema = checks.read_schema(SCHEMA)
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


# --- bad input ------------------------------------------------------------------------------------------------------

NAMED = {"name": "mine", "thickness": 0.2, "slenderness": 10, "overburden_ratio": 0.0, "hinge_ratio": 0.5}
NAMED |= {"cracked_stiffness_ratio": 0.04, "plateau_ratio": 0.85}

BAD = [
    # a value outside its range
    ("wall.thickness", 0, "wall.thickness is 0; it must be a number greater than 0"),
    ("wall.thickness", -0.3, "wall.thickness is -0.3; it must be a number greater than 0"),
    ("validation.wall.thickness", -1, "validation.wall.thickness is -1; it must be a number greater than 0"),
    ("wall.hinge_ratio", 0, "wall.hinge_ratio is 0; it must be a number greater than 0 and less than 1"),
    ("wall.hinge_ratio", 1.0, "wall.hinge_ratio is 1.0; it must be a number greater than 0 and less than 1"),
    ("wall.overburden_ratio", -0.1, "wall.overburden_ratio is -0.1; it must be a number at least 0"),
    ("studies.overburden.overburden_ratio", [0, -1], "overburden_ratio[1] is -1; it must be a number at least 0"),
    ("restitution.start", 0, "restitution.start is 0; it must be a number greater than 0 and at most 1"),
    ("restitution.stop", 1.01, "restitution.stop is 1.01; it must be a number greater than 0 and at most 1"),
    ("loops.restitution", -0.5, "loops.restitution is -0.5; it must be a number greater than 0 and at most 1"),
    ("curve.plateau_ratio", 1, "curve.plateau_ratio is 1; it must be a number greater than 0 and less than 1"),
    ("curve.cracked_stiffness_ratio", 0, "cracked_stiffness_ratio is 0; it must be a number greater than 0"),
    ("curve.ultimate_ratio", 1.1, "curve.ultimate_ratio is 1.1; it must be a number greater than 0 and at most 1"),
    ("solver.step", 0, "solver.step is 0; it must be a number greater than 0"),
    ("figures.resolution", 99.5, "figures.resolution is 99.5; it must be a whole number at least 30 and at most 1200"),
    ("matching.window", -3, "matching.window is -3; it must be 'default' or a number greater than 0"),
    ("matching.window", "long", "matching.window is 'long'; it must be 'default' or a number greater than 0"),
    # something else than a number
    ("wall.thickness", math.nan, "wall.thickness is nan; it must be a finite number"),
    ("studies.slenderness.slenderness", [10, math.inf], "slenderness[1] is inf; it must be a finite number"),
    ("wall.thickness", True, "wall.thickness is True; it must be a number greater than 0"),
    ("natural.walls", [{"parapet": 3}], "natural.walls[0].parapet is 3; it must be true or false"),
    ("wall.thickness", None, "wall.thickness is None; it must be a number greater than 0"),
    ("solver.step", "1e-3", "solver.step is the text '1e-3'; it must be a number greater than 0 (YAML's numbers"),
    ("wall", 3, "wall is 3; it must be a mapping of keys to values"),
    ("restitution", [0.7, 0.8], "restitution is [0.7, 0.8]; it must be a mapping of keys to values"),
    ("studies.slenderness.slenderness", {"a": 1}, "is a mapping of keys to values; it must be a list of at least 1"),
    ("studies.slenderness.slenderness", [], "slenderness has 0 of them; it must be a list of at least 1"),
    ("studies.slenderness.slenderness", [10, 10], "slenderness has 10 twice; its values must differ"),
    ("records", [], "records has 0 of them; it must be a list of at least 1"),
    ("records", ["a.csv", 1], "records[1] is 1; it must be text"),
    # a name that is not known
    ("solver.scheme", "euler", "solver.scheme is 'euler'; it must be one of newmark, paper"),
    ("curve.softening", "sloping", "curve.softening is 'sloping'; it must be one of steeper, translated"),
    ("figures.formats", ["jpg"], "figures.formats[0] is 'jpg'; it must be one of pdf, png, svg"),
    ("studies.amplitud", {}, "studies.amplitud is not a key; did you mean 'amplitude'?"),
    ("wall.slendernes", 15, "wall.slendernes is not a key; did you mean 'slenderness'?"),
    ("solver.tolerance", 1, "solver.tolerance is not a key; it must be one of scheme, step"),
    # values that do not agree
    ("curve.cracked_stiffness_ratio", 0.16, "curve.cracked_stiffness_ratio is 0.16; a1 must be less than a2"),
    ("curve.ultimate_ratio", 0.15, "curve.ultimate_ratio is 0.15; a3 must be greater than 1 - b1 with steeper"),
    ("studies.cracked_stiffness.cracked_stiffness_ratio", [0.02, 0.04, 0.3], "ratio[2] is 0.3; a1 must be less than"),
    ("validation.curve.cracked_stiffness_ratio", 0.2, "validation.curve.cracked_stiffness_ratio is 0.2; a1 must"),
    ("loops.rigid.cracked_stiffness_ratio", 0.2, "loops.rigid.cracked_stiffness_ratio is 0.2; a1 must be less than a2"),
    ("solver.step", 0.15, "solver.step is 0.15; it must be less than the stability limit 2 sqrt(a1/b1), 0.142134"),
    ("natural.walls", [{**NAMED, "cracked_stiffness_ratio": 1e-7}], "stability limit 2 sqrt(a1/b1), 0.00068"),
    ("natural.walls", [{**NAMED, "plateau_ratio": 0.005}], "natural.walls[0] has its first impact at 1"),
    ("validation.step", 0.5, "validation.step is 0.5; it must be less than the stability limit"),
    ("release_amplitude", 1.0, "release_amplitude is 1.0; it must be less than a3, 1.0, where the wall collapses"),
    ("studies.amplitude.release_amplitude", [0.5, 1.2], "release_amplitude[1] is 1.2; it must be less than a3"),
    ("loops.rigid.release_amplitude", 1, "loops.rigid.release_amplitude is 1; it must be less than a3"),
    ("release_amplitude", 0.4, "release_amplitude is 0.4; it must be among studies.amplitude.release_amplitude"),
    ("studies.slenderness.slenderness", [20, 10], "slenderness[1] is 10; it must be greater than the value before it"),
    ("restitution.stop", 0.5, "restitution.stop is 0.5; it must be greater than restitution.start, 0.7"),
    ("restitution.step", 0.03, "restitution.step is 0.03; a whole number of steps must lead from restitution.start"),
    ("restitution.step", 0.28, "restitution.step is 0.28; there must be at least 3 values from 0.7 to 0.98"),
    ("windows.stop", 2, "windows.stop is 2; it must be greater than windows.start, 3"),
    ("windows.start", 1, "windows.start is 1; it must be greater than 2.99"),
    ("matching.window", 2, "matching.window is 2; it must be greater than 2.99"),
    ("matching.window", 81, "matching.window is 81; it must be at most windows.stop, 80"),
    ("loops.window", 1.5, "loops.window is 1.5; it must be greater than 2.99"),
    ("studies.overburden.overburden_ratio", [0, 200], "overburden_ratio[1] is 200; at "),
    ("studies.slenderness.slenderness", [15, 9000], "slenderness[1] is 9000; at "),
    ("wall.eccentricity", -0.2, "wall.eccentricity is -0.2; it must be at most half the thickness, 0.15 m"),
    ("validation.restitution", 0.6, "validation.restitution is 0.6; it must lie within the e of the polynomials"),
    ("validation.fit_cracked_stiffness_ratios", [0.01], "ratios[0] is 0.01; it must lie within the a1 of the poly"),
    ("studies.cracked_stiffness.cracked_stiffness_ratio", [0.17], "has no value below 0.15, from where on another"),
    ("matching.scan.smallest", 3.0, "matching.scan.largest is 3.0; it must be greater than matching.scan.smal"),
    ("validation.record", "data/none.csv", "validation.record is 'data/none.csv'; it must be a file"),
    ("validation.ladder", ["data/none.csv"], "validation.ladder[0] is 'data/none.csv'; it must be a file"),
    (
        "validation.ladder",
        ["data/ladder/cr-half.csv", "./data/ladder/cr-half.csv"],
        "validation.ladder[1] is named 'cr-half', as one before it; each must have a name of its own",
    ),
]


@pytest.mark.parametrize(("key", "value", "expected"), BAD, ids=[f"{key}={value}" for key, value, _ in BAD])
def test_bad_input_is_named_with_its_value_and_what_is_allowed(config, key, value, expected):
    put(config, key, value)
    assert any(expected in line for line in complaints(config))


def test_translated_softening_needs_room_behind_the_plateau(config):
    config["curve"] |= {"ultimate_ratio": 0.88, "softening": "translated"}
    lines = complaints(config)
    assert any(
        "curve.ultimate_ratio is 0.88; a3 must be greater than a1 + b1 with translated" in line for line in lines
    )


def test_a_plateau_below_which_a_study_does_not_fit_is_named_with_the_value_of_the_study(config):
    config["curve"]["ultimate_ratio"] = 0.22  # enough for b1 = 0.85, not for the 0.75 of the softer curves
    lines = complaints(config)
    assert any("curve.ultimate_ratio is 0.22" in line and "cracked_stiffness_ratio[9]" in line for line in lines)


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


def test_check_alone_raises_without_the_schema(config):
    checks.check(config)
    config["curve"]["cracked_stiffness_ratio"] = 0.5
    with pytest.raises(InputError, match="a1 must be less than a2"):
        checks.check(config)


# --- where it stands ------------------------------------------------------------------------------------------------


def report(files, **changes):
    """The one line about files that are merged in this order, then changed as on the command line."""
    config = {}
    for file in files:
        config = merged(config, load(file))
    config = merged(config, changes)
    with pytest.raises(InputError) as caught:
        checks.validate(config, SCHEMA, files)
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


def test_an_error_names_the_file_of_a_misspelt_key(tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    own = tmp_path / "own.yaml"
    own.write_text("# a comment\nsolvr:\n  step: 0.01\n", encoding="utf-8")
    assert report([DEFAULT, own]) == f"{own}, line 2: solvr is not a key; did you mean 'solver'?"


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


# --- the plain formulas against the curve ---------------------------------------------------------------------------

PARAMETERS = st.floats(0.005, 1.0)


@given(a1=PARAMETERS, b1=st.floats(0.005, 0.995), a3=PARAMETERS, softening=st.sampled_from(SOFTENING))
def test_a_curve_is_accepted_exactly_when_it_can_be_made(a1, b1, a3, softening):
    case = checks.Case(("curve",), a1, b1, a3, softening, (("solver", "step"), 1e-6), [])
    try:
        curve = TrilinearCurve(a1, b1, a3, softening)
    except InputError:
        curve = None
    assert (list(checks._curve_problems(case)) == []) == (curve is not None)
    if curve is not None:
        assert case.a2 == curve.plateau_end


@given(
    a1=PARAMETERS,
    b1=st.floats(0.005, 0.995),
    a3=PARAMETERS,
    softening=st.sampled_from(SOFTENING),
    part=st.floats(0.01, 0.99),
)
def test_the_first_impact_comes_after_a_quarter_of_the_curves_period(a1, b1, a3, softening, part):
    try:
        curve = TrilinearCurve(a1, b1, a3, softening)
    except InputError:
        return
    case = checks.Case(("curve",), a1, b1, a3, softening, (("solver", "step"), 1e-6), [])
    expected = float(curve.period(part * a3)) / 4
    # Both sum the same closed forms; near the edge of a branch they cancel to about the root of the rounding error.
    assert checks.first_impact(case, part * a3) == pytest.approx(expected, rel=1e-6)


@given(
    thickness=st.floats(0.05, 1.0),
    slenderness=st.floats(5, 40),
    hinge_ratio=st.floats(0.05, 0.95),
    overburden_ratio=st.floats(0, 10),
    eccentricity=st.floats(-0.02, 0.02),
    density=st.floats(500, 3000),
)
def test_the_frequency_parameter_is_the_walls(thickness, slenderness, **others):
    assume(angular_momentum_restitution(thickness, thickness * slenderness, others["hinge_ratio"]) > 0)  # else none
    with plausibility.as_meant():
        wall = Wall(thickness, thickness * slenderness, **others)
    plain = checks.frequency_parameter({"thickness": thickness, "slenderness": slenderness, **others})
    assert plain == pytest.approx(float(wall.frequency_parameter), rel=1e-12)


def test_of_values_that_must_ascend_each_that_does_not_exceed_the_one_before_it_is_named():
    said = [str(problem) for problem in ascending(("a", "b"), [1, 2, 2, 1, 3])]
    assert said == [
        f"a.b[{index}] is {value}; it must be greater than the value before it, 2" for index, value in ((2, 2), (3, 1))
    ]
