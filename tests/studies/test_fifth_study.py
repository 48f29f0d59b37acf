"""A fifth study of free decay: its name, its parameter and its values are enough for every stage.

Here it varies the curve; tests/documents/test_howto_additions.py adds one that varies the wall.
"""

import pytest
import report_content
from repository import ROOT

from rockdamp.config import validation as checks
from rockdamp.pipeline import dictionary
from rockdamp.storage import dataset, yaml_file
from rockdamp.storage.registry import registry
from rockdamp.studies import damping_force, decays, matches
from rockdamp.studies.accuracy.stage import accuracy
from rockdamp.vocabulary import STUDIES

SCHEMA, DEFAULT = ROOT / "workflow/schemas/config.schema.yaml", ROOT / "config/default.yaml"
NAME, PARAMETER, VALUES = "plateau", "strength_ratio", [0.6, 0.85]


@pytest.fixture
def config(monkeypatch):
    """A small config that has it."""
    monkeypatch.setitem(STUDIES, NAME, PARAMETER)
    monkeypatch.setitem(registry()["common"], PARAMETER, {"units": "1", "long_name": "plateau over strength"})
    config = yaml_file.load(DEFAULT.read_text(encoding="utf-8"))
    config["solver"]["step"] = 0.01
    config["restitution"] = {"start": 0.8, "stop": 0.9, "step": 0.05}
    config["studies"] |= {NAME: {PARAMETER: VALUES}}
    config["matching"] |= {
        "response_length": 5.0,
        "refinement": 2,
        "scan": {"smallest": 0.3, "largest": 3.0, "points": 60},
    }
    config["response_lengths"] = {"start": 3, "stop": 10, "step": 1}
    config["damping_force"]["response_length"] = 12
    config["accuracy"] |= {"restitutions": 1, "doublings": 0, "halvings": 1, "minima": 2, "bracket": 0.3}
    config["accuracy"]["rigid"] |= {"slenderness": [8], "hinge_ratio": [0.5], "release_amplitude": [0.5]}
    config["studies"]["amplitude"]["release_amplitude"] = [0.5]
    config["studies"]["cracked_stiffness"]["yield_displacement_ratio"] = [0.02, 0.04]
    return config


def test_it_is_released_and_matched(config):
    released = decays.study(NAME, config)
    matched = matches.match(NAME, config, released)
    dataset.check(released, "decay")
    dataset.check(matched, "match")
    assert matched["damping_ratio"].dims == ("damping_model", PARAMETER, "restitution")
    assert float(abs(matched["damping_ratio"].diff(PARAMETER)).sel(damping_model="CDR").min()) > 0
    assert "damping_ratio_fixed_seconds" not in matched


@pytest.mark.no_cover
def test_accuracy_is_given_it_and_measures_it(config):
    # Walls of one frequency: the length in seconds of the response is within the decays of each.
    config["studies"]["slenderness"]["slenderness"] = [config["wall"]["slenderness"]]
    config["studies"]["overburden"]["overburden_ratio"] = [0.0]
    released = {study: decays.study(study, config) for study in STUDIES}
    matched = {study: matches.match(study, config, released[study]) for study in STUDIES}
    measured = accuracy(config, damping_force.damping_force(config), *matched.values(), *released.values())
    assert measured["study"].values.tolist() == [*STUDIES]
    assert float(measured["decay_energy_residual"].sel(study=NAME)) < 1e-3
    assert int(measured["published_count"]) == sum(one["damping_ratio"][0].size for one in matched.values())
    assert sorted(measured["strength_ratio"].values) == [0.6, 0.85, 0.85]  # of the curves: 0.85 at two values of a1


def test_it_stands_in_the_report_and_in_the_data_dictionary(config):
    assert f"match/{NAME}" in report_content.content().datasets
    assert f"| `{NAME}` | `{PARAMETER}` |" in list(dictionary.lines())


def test_its_values_are_checked_before_the_run(config, monkeypatch):
    monkeypatch.chdir(ROOT)
    for wrong, said in (
        ([0.6, 0.97], "studies.plateau cannot be used: yield_displacement_ratio (a1) is 0.04; it must be less than a2"),
        ([0.97, 0.6], "studies.plateau.strength_ratio[1] is 0.6; it must be greater"),
    ):
        config["studies"][NAME][PARAMETER] = wrong
        assert any(said in str(problem) for problem in checks.problems(config))
