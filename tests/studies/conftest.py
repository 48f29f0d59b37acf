"""The paper's config made small, with the decays and matches of the studies."""

import copy

import pytest
import yaml
from repository import ROOT

from rockdamp.studies.decays import study as decay_study
from rockdamp.studies.matches import match
from rockdamp.vocabulary import STUDIES


@pytest.fixture(scope="session")
def paper():
    return yaml.safe_load((ROOT / "config/default.yaml").read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def config(paper):
    """The paper's config with fewer values, a larger step and shorter responses."""
    small = copy.deepcopy(paper)
    small["solver"]["step"] = 0.01
    small["restitution"] = {"start": 0.74, "stop": 0.98, "step": 0.04}
    small["studies"]["amplitude"]["release_amplitude"] = [0.3, 0.5, 0.9]
    small["studies"]["slenderness"]["slenderness"] = [10, 15, 30]
    small["studies"]["overburden"]["overburden_ratio"] = [0.0, 0.5]
    small["studies"]["cracked_stiffness"]["yield_displacement_ratio"] = [0.02, 0.04, 0.10, 0.20]
    small["response_lengths"] = {"start": 3, "stop": 16, "step": 1}
    return small


@pytest.fixture(scope="session")
def decays(config):
    return {name: decay_study(name, config) for name in STUDIES}


@pytest.fixture(scope="session")
def matches(config, decays):
    return {name: match(name, config, decays[name]) for name in STUDIES}
