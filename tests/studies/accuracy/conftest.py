"""A small config, made-up matches and the stage run on them."""

import pytest
from accuracy_cases import made_up
from configs import configured

from rockdamp.studies import mechanism
from rockdamp.studies.accuracy import convergence
from rockdamp.studies.accuracy.stage import accuracy
from rockdamp.studies.decays import study as decay_study
from rockdamp.vocabulary import STUDIES


@pytest.fixture(scope="session")
def config():
    """The paper's config with fewer values, a larger step and shorter responses."""
    studies = {
        "amplitude": {"release_amplitude": [0.3, 0.5]},
        "slenderness": {"slenderness": [10, 15]},
        "overburden": {"overburden_ratio": [0.0, 8.0]},
        "cracked_stiffness": {"yield_displacement_ratio": [0.04, 0.10, 0.20]},
    }
    rigid = {"slenderness": [8, 20], "hinge_ratio": [0.5], "release_amplitude": [0.5]}
    sizes = {"restitutions": 2, "doublings": 1, "halvings": 2, "minima": 2, "bracket": 0.3}
    return configured(
        {"solver": {"step": 0.01}, "restitution": {"start": 0.8, "stop": 0.9, "step": 0.05}, "studies": studies},
        {"matching": {"response_length": 5.0, "scan": {"smallest": 0.3, "largest": 3.0, "points": 60}}},
        {"response_lengths": {"start": 3, "stop": 6, "step": 1}, "damping_force": {"response_length": 12}},
        {"accuracy": {**sizes, "rigid": rigid}},
    )


@pytest.fixture(scope="session")
def matches(config):
    return {name: made_up(config, name) for name in STUDIES}


@pytest.fixture(scope="session")
def studies(config):
    return {name: config.study(name) for name in STUDIES}


@pytest.fixture(scope="session")
def drawn(studies, matches):
    steps = convergence.halved(0.01, doublings=1, halvings=2)
    return convergence.collect(
        studies, matches, restitutions=2, seed=20170616, length=5.0, step=0.01, steps=steps, scheme="newmark"
    )


@pytest.fixture(scope="session")
def looped(config):
    return mechanism.damping_force(config)


@pytest.fixture(scope="session")
def stage(config, matches, looped):
    decays = [decay_study(name, config) for name in STUDIES]
    return accuracy(config, looped, list(matches.values()), decays)
