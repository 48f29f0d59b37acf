"""A fifth study of free decay: its name, its parameter and its values are enough for every stage."""

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
MEANINGS = {"hinge_ratio": "height of the hinge over height of the wall", "strength_ratio": "plateau over strength"}


HINGE, PLATEAU = ("hinge", "hinge_ratio", [0.6, 0.7]), ("plateau", "strength_ratio", [0.6, 0.85])


@pytest.fixture(params=[HINGE, PLATEAU], ids=["of the wall", "of the curve"])
def fifth(request, monkeypatch):
    """Its name and parameter, and a small config that has it: of the wall, and of the curve."""
    name, parameter, values = request.param
    monkeypatch.setitem(STUDIES, name, parameter)
    monkeypatch.setitem(registry()["common"], parameter, {"units": "1", "long_name": MEANINGS[parameter]})
    config = yaml_file.load(DEFAULT.read_text(encoding="utf-8"))
    config["solver"]["step"] = 0.01
    config["restitution"] = {"start": 0.8, "stop": 0.9, "step": 0.05}
    config["studies"] |= {name: {parameter: values}}
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
    return name, parameter, config


def test_it_is_released_and_matched(fifth):
    name, parameter, config = fifth
    released = decays.study(name, config)
    matched = matches.match(name, config, released)
    dataset.check(released, "decay")
    dataset.check(matched, "match")
    assert matched["damping_ratio"].dims == ("damping_model", parameter, "restitution")
    apart = abs(matched["damping_ratio"].diff(parameter))
    if name == "hinge":  # in tau the wall does not matter, in seconds it does
        assert float(apart.max()) == 0
        assert float(abs(matched["damping_ratio_fixed_seconds"].diff(parameter)).min()) > 0
    else:
        assert float(apart.sel(damping_model="CDR").min()) > 0
        assert "damping_ratio_fixed_seconds" not in matched


@pytest.mark.no_cover
@pytest.mark.parametrize("fifth", [PLATEAU], indirect=True, ids=["of the curve"])
def test_accuracy_is_given_it_and_measures_it(fifth):
    name, _, config = fifth
    # Walls of one frequency: the length in seconds of the response is within the decays of each.
    config["studies"]["slenderness"]["slenderness"] = [config["wall"]["slenderness"]]
    config["studies"]["overburden"]["overburden_ratio"] = [0.0]
    released = {study: decays.study(study, config) for study in STUDIES}
    matched = {study: matches.match(study, config, released[study]) for study in STUDIES}
    measured = accuracy(config, damping_force.damping_force(config), *matched.values(), *released.values())
    assert measured["study"].values.tolist() == [*STUDIES]
    assert float(measured["decay_energy_residual"].sel(study=name)) < 1e-3
    assert int(measured["published_count"]) == sum(one["damping_ratio"][0].size for one in matched.values())
    assert sorted(measured["strength_ratio"].values) == [0.6, 0.85, 0.85]  # of the curves: 0.85 at two values of a1


def test_it_stands_in_the_report_and_in_the_data_dictionary(fifth):
    name, parameter, _ = fifth
    assert f"match/{name}" in report_content.content().datasets
    assert f"| `{name}` | `{parameter}` |" in list(dictionary.lines())


def test_its_values_are_checked_before_the_run(fifth, monkeypatch):
    monkeypatch.chdir(ROOT)
    name, parameter, config = fifth
    wrong = {"hinge": [0.05, 0.7], "plateau": [0.6, 0.97]}[name]
    config["studies"][name][parameter] = wrong
    lines = "\n".join(map(str, checks.problems(config)))
    said = {
        "hinge": "studies.hinge.hinge_ratio[0] is 0.05; at",
        "plateau": "studies.plateau cannot be used: yield_displacement_ratio (a1) is 0.04; it must be less than a2",
    }
    assert said[name] in lines
    config["studies"][name][parameter] = wrong[::-1]
    assert f"studies.{name}.{parameter}[1] is {wrong[0]}; it must be greater" in "\n".join(
        map(str, checks.problems(config))
    )
