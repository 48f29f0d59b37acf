"""A config that no computer can run is refused before its first job, with key, value and bound."""

import re

import pytest
from repository import ROOT

from rockdamp.config import between_keys
from rockdamp.config.limits import cost_problems, costs, size_problems
from rockdamp.config.merging import merged
from rockdamp.errors import InputError

DEFAULT, MINIMAL = ROOT / "config/default.yaml", ROOT / "config/minimal.yaml"


def stated(dotted, value):
    for name in reversed(dotted.split(".")):
        value = {name: value}
    return value


def at(config, dotted):
    for name in dotted.split("."):
        config = config[name]
    return config


HUGE = {  # of each the cost explodes, or the memory
    "solver.step": 1e-9,
    "convergence.lanes": 10**12,
    "convergence.length": 1e12,
    "convergence.coarsest": 1e-11,
    "convergence.halvings": 10**9,
    "accuracy.doublings": 10**9,
    "accuracy.halvings": 10**12,
    "accuracy.restitutions": 10**12,
    "accuracy.minima": 10**9,
    "accuracy.rigid.peaks": 10**9,
    "matching.refinement": 10**10,
    "matching.scan.points": 10**9,
    "natural.scale.count": 10**9,
    "natural.step": 1e-11,
    "natural.tail": 1e12,
    "natural.bootstrap.replicates": 10**9,
    "natural.check.histories": 10**9,
    "natural.orders.step": 1e-11,
    "population.walls": 10**12,
    "population.walls_per_job": 10**12,
    "population.intensity.count": 10**9,
    "population.step": 1e-11,
    "population.tail": 1e12,
    "population.bootstrap.replicates": 10**9,
    "population.check.histories": 10**9,
    "pulses.frequency.count": 10**9,
    "pulses.load.count": 10**9,
    "pulses.step": 1e-11,
    "pulses.tail": 1e12,
    "damper_order.pulses.load.count": 10**9,
    "damper_order.pulses.step": 1e-11,
    "dispersion.refinement": 10**10,
    "loops.window": 1e9,
    "validation.step": 1e-11,
    "restitution.step": 1e-11,
    "windows.step": 1e-9,
    "windows.stop": 1e9,
}


@pytest.mark.parametrize("files", [[DEFAULT], [DEFAULT, MINIMAL]], ids=["default", "minimal"])
def test_the_shipped_configs_are_far_from_every_limit(files):
    config = merged(files, {})
    assert size_problems(config) == [] and cost_problems(config) == []
    for key, factor in (("solver.step", 1 / 20), ("population.walls", 20), ("natural.scale.count", 20)):
        assert cost_problems(merged([DEFAULT], stated(key, at(config, key) * factor))) == []


@pytest.mark.parametrize("key", HUGE)
def test_a_value_that_makes_a_job_without_end_is_named_with_a_bound_that_holds(key, monkeypatch):
    monkeypatch.chdir(ROOT)
    config = merged([DEFAULT], stated(key, HUGE[key]))
    (text,) = [str(problem) for problem in cost_problems(config) if str(problem).startswith(f"{key} is")]
    assert f"{key} is {HUGE[key]}, with which" in text
    bound = float(re.search(r"it must be at (?:most|least) ([-+.e\d]+)$", text)[1])
    sign = 1 if "at most" in text else -1
    within = merged([DEFAULT], stated(key, bound * 0.99**sign))
    assert not any(str(problem).startswith(f"{key} is") for problem in cost_problems(within))
    beyond = merged([DEFAULT], stated(key, bound * 1.02**sign + (sign > 0)))
    assert any(str(problem).startswith(f"{key} is") for problem in cost_problems(beyond))


def test_a_long_list_is_named_by_the_number_of_its_values():
    config = merged([DEFAULT], stated("natural.restitution", [index / 10**7 for index in range(1, 10**6)]))
    (problem,) = cost_problems(config)
    assert str(problem).startswith("natural.restitution has 999999 values, with which steps of a job of natural would")
    assert "; it must have at most " in str(problem)


def test_the_usual_values_are_those_of_the_full_config():
    config = merged([DEFAULT], {})
    for term in {term for cost in costs() for term in cost.terms}:
        assert term.size(term.usual) == pytest.approx(term.size(at(config, term.key)), abs=1e-9), term.key


@pytest.mark.parametrize("value", [1e-320, 10**400, -(10**400), 1e16, -1e-13])
def test_a_number_beyond_all_use_is_named_with_its_key(value):
    (problem,) = size_problems(merged([DEFAULT], stated("validation.wall.density", value)))
    assert problem.path == ("validation", "wall", "density")
    assert "must be 0, or between 1e-12 and 1e+15 in size" in problem.text and len(problem.text) < 120


def test_a_config_is_checked_for_both(monkeypatch):
    monkeypatch.chdir(ROOT)
    for value, text in ((10**400, "400 digits|401 digits"), (10**12, "it must be at most")):
        config = merged([DEFAULT], stated("convergence.lanes", value))
        with pytest.raises(InputError, match=f"convergence.lanes is .*({text})"):
            between_keys.validate(config, ROOT / "workflow/schemas/config.schema.yaml", [DEFAULT])
