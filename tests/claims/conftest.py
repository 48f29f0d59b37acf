"""The made-up datasets, once for all and a copy for each test, and the paper's claims."""

import pytest
from made_up_claims import (
    FILE,
    MEASURED,
    amplitude_study,
    bilinear,
    equivalence,
    indifferent,
    loops,
    measured_rocking,
    mechanism,
    response_lengths,
    stiffness_study,
    validation,
)

from rockdamp import claims


@pytest.fixture(scope="session")
def made_up():
    return {
        "mechanism": mechanism(),
        "bilinear": bilinear(),
        "measured_rocking": measured_rocking(),
        "damping_force": loops(),
        "response_lengths": response_lengths(),
        "equivalence": equivalence(),
        "validation": validation(),
        "match/amplitude": amplitude_study(),
        "match/cracked_stiffness": stiffness_study(),
        "match/slenderness": indifferent("slenderness"),
        "match/overburden": indifferent("overburden_ratio"),
    }


@pytest.fixture
def data(made_up):
    return {name: dataset.copy(deep=True) for name, dataset in made_up.items()}


@pytest.fixture(scope="session")
def listed():
    return [*claims.read(FILE), *claims.read(MEASURED)]
