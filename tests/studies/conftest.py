"""The paper's config made small, with the decays and matches of its studies."""

import pytest
from configs import configured

from rockdamp.constants import STUDIES
from rockdamp.studies.decays import decay
from rockdamp.studies.matches import match


@pytest.fixture(scope="session")
def paper():
    return configured()


@pytest.fixture(scope="session")
def config():
    """The paper's config with fewer values, a larger step and shorter responses."""
    studies = {
        "amplitude": [0.3, 0.5, 0.9],
        "slenderness": [10, 15, 30],
        "overburden": [0.0, 0.5],
        "cracked_stiffness": [0.02, 0.04, 0.10, 0.20],
    }
    return configured(
        {"solver": {"step": 0.01}, "restitution": {"start": 0.74, "stop": 0.98, "step": 0.04}},
        {"studies": studies, "response_lengths": {"start": 3, "stop": 16, "step": 1}},
    )


@pytest.fixture(scope="session")
def decays(config):
    return {name: decay(name, config) for name in STUDIES}


@pytest.fixture(scope="session")
def matches(config, decays):
    return {name: match(name, config, decays[name]) for name in STUDIES}
