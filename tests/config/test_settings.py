"""The config parsed into settings: every stage of both configs, and what is missing or not known."""

import copy

import pytest
from repository import ROOT
from rockdamp.config.parsing import Settings, ascending
from rockdamp.config.settings import DecaySettings, MatchSettings, PulseSettings
from rockdamp.config.walls import StudySettings, make_named_wall, make_wall
from snakemake.utils import update_config

from rockdamp.config import earthquakes
from rockdamp.errors import InputError
from rockdamp.mechanics.wall import Parapet
from rockdamp.storage import yaml_file
from rockdamp.storage.provenance import subset
from rockdamp.vocabulary import DEFAULT_RESPONSE_LENGTH, STUDIES


def kinds(base=Settings):
    for kind in base.__subclasses__():
        yield kind
        yield from kinds(kind)


KINDS = list(kinds())


@pytest.fixture
def config():
    return yaml_file.load((ROOT / "config/default.yaml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("overlay", [None, "minimal"])
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_each_stage_takes_the_part_of_the_config_that_has_its_keys(kind, overlay, config):
    if overlay:
        update_config(config, yaml_file.load((ROOT / f"config/{overlay}.yaml").read_text(encoding="utf-8")))
    part = subset(config, *kind.keys())
    for given in (part, config):
        assert repr(kind.of(given)) == repr(kind.of(part))


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_a_key_that_a_stage_needs_and_that_is_missing_is_named(kind, config):
    for key in kind.keys():
        *sections, last = key.split(".")
        part = copy.deepcopy(config)
        inner = part
        for section in sections:
            inner = inner[section]
        del inner[last]
        with pytest.raises(InputError, match=f"^{key} is missing$"):
            kind.of(part)


@pytest.mark.parametrize(
    ("key", "kind"),
    [
        ("wall.density", DecaySettings),
        ("restitution.step", DecaySettings),
        ("matching.scan.points", PulseSettings),
        ("studies.cracked_stiffness.strength_ratio_beyond", MatchSettings),
        ("population.parameters.restitution.low", earthquakes.PopulationWallSettings),
    ],
)
def test_a_misspelt_key_is_an_error_and_never_a_default(key, kind, config):
    *sections, last = key.split(".")
    inner = config
    for section in sections:
        inner = inner[section]
    inner[last + "s"] = inner[last]
    with pytest.raises(InputError, match=f"^{key}s is not a key; it must be one of .*{last}"):
        kind.of(config)
    del inner[last + "s"], inner[last]
    with pytest.raises(InputError, match=f"^{key} is missing$"):
        kind.of(config)


@pytest.mark.parametrize(
    ("section", "name", "value", "told"),
    [
        ("solver", "step", "0.01", "solver.step is '0.01'; it must be a number"),
        ("solver", "scheme", 2, "solver.scheme is 2; it must be text"),
        ("matching", "refinement", 2.5, "matching.refinement is 2.5; it must be a whole number"),
        ("matching", "scan", None, "matching.scan is None; it must be a mapping of keys to values"),
        ("pulses", "bands", [0.5, "a"], r"pulses.bands\[1\] is 'a'; it must be a number"),
    ],
)
def test_a_value_of_another_kind_is_named_with_its_key(section, name, value, told, config):
    config[section][name] = value
    with pytest.raises(InputError, match=f"^{told}$"):
        PulseSettings.of(config)


def test_the_default_response_length_is_the_packages(config):
    assert config["matching"]["response_length"] == "default"
    assert MatchSettings.of(config).matching.response_length == DEFAULT_RESPONSE_LENGTH
    config["matching"]["response_length"] = 12
    assert MatchSettings.of(config).matching.response_length == 12.0
    assert earthquakes.EarthquakeWallSettings.of(config).matching.response_length == 12.0


def test_of_values_that_must_ascend_the_first_that_does_not_is_named():
    with pytest.raises(InputError, match=r"^a\.b\[2\] is 2; it must be greater than the value before it, 2$"):
        ascending([1, 2, 2, 1, 3], "a.b")


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_varies_its_parameter_and_nothing_else(name, config):
    given = StudySettings.of(config)
    study = given.study(name)
    values = config["studies"][name][STUDIES[name]]
    assert study.values.tolist() == values and study.curve.shape == (len(values),)
    wall = dict(config["wall"])
    for index, value in enumerate(values):
        a1 = value if name == "cracked_stiffness" else 0.04
        own = study.curve.map(lambda p, index=index: p[index])
        assert (own.yield_displacement_ratio, own.strength_ratio) == (a1, 0.75 if a1 >= 0.15 else 0.85)
        assert study.release_amplitude[index] == (value if name == "amplitude" else 0.5)
        wall |= {STUDIES[name]: value} if STUDIES[name] in wall else {}
        assert study.frequency_parameter[index] == make_wall(wall).frequency_parameter


@pytest.mark.parametrize(("parameter", "values"), [("hinge_ratio", [0.5, 0.6]), ("strength_ratio", [0.6, 0.8, 0.9])])
def test_a_fifth_study_varies_any_parameter_of_the_wall_or_the_curve(parameter, values, config, monkeypatch):
    monkeypatch.setitem(STUDIES, "fifth", parameter)
    config["studies"]["fifth"] = {parameter: values}
    study = StudySettings.of(config).study("fifth")
    assert study.values.tolist() == values and study.release_amplitude.tolist() == [0.5] * len(values)
    b1 = values if parameter == "strength_ratio" else [0.85] * len(values)
    assert study.curve.strength_ratio.tolist() == b1 and study.curve.yield_displacement_ratio.tolist() == [0.04] * len(
        b1
    )
    walls = [make_wall({**config["wall"], "hinge_ratio": value}) for value in values]
    if parameter == "hinge_ratio":
        assert study.frequency_parameter.tolist() == [float(wall.frequency_parameter) for wall in walls]
        assert len(set(study.frequency_parameter)) == len(values)


def test_walls_that_earthquakes_shake_are_strips_or_parapets_with_a_preset_or_their_own_curve(config):
    made = {named.name: named for named in map(make_named_wall, config["earthquakes"]["walls"])}
    assert list(made) == [entry["name"] for entry in config["earthquakes"]["walls"]]
    assert [name for name, named in made.items() if isinstance(named.wall, Parapet)] == ["parapet"]
    assert float(made["degraded"].curve.strength_ratio) == 0.50 and float(made["church"].curve.strength_ratio) == 0.85
    assert float(made["degraded"].wall.height) == 4.0 and float(made["degraded"].wall.hinge_ratio) == 0.6
    hinged = {**config["earthquakes"]["walls"][-1], "hinge_ratio": 0.5}
    with pytest.raises(InputError, match=r"earthquakes\.walls\[7\]\.hinge_ratio is not a key"):
        make_named_wall(hinged, "earthquakes.walls[7]")


def test_the_grid_of_restitution_is_exact_in_decimals(config):
    grid = DecaySettings.of(config).restitution
    assert list(grid) == [round(0.70 + 0.01 * i, 2) for i in range(29)]


def test_a_normal_distribution_alone_has_moments(config):
    drawn = earthquakes.PopulationWallSettings.of(config).parameters
    assert drawn["restitution"].mean == 0.86 and drawn["thickness"].mean is None
    assert earthquakes.PopulationWallSettings.of(config).correlations == {("restitution", "slenderness"): 0.5}
