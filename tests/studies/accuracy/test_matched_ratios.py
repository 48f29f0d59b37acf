"""How certain the published damping ratios are, on cases whose answer is known."""

import numpy as np
import pytest
from accuracy_cases import CURVE, made_up

from rockdamp.errors import InputError
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers import event_driven
from rockdamp.studies.accuracy import stage
from rockdamp.vocabulary import STUDIES, VISCOUS_MODELS

SAMPLE = {"count": 2, "bracket": 0.3, "seed": 20170616}


def test_uncertainties_of_all_studies_are_summarised_together(config, matches):
    known = {name: match.copy(deep=True) for name, match in matches.items()}
    known["overburden"]["damping_ratio_uncertainty"][0, 1, 2] = 0.002 * known["overburden"]["damping_ratio"][0, 1, 2]
    found = stage.uncertainty(known)
    count = 3 * (2 + 2 + 2 + 3)
    assert int(found["published_count"]) == count
    np.testing.assert_allclose(found["share_within_thousandth"], [1 - 1 / count] + [1] * (len(VISCOUS_MODELS) - 1))
    largest = found["uncertainty_quantile"].sel(quantile=1.0)
    assert float(largest[0]) == pytest.approx(0.002)
    assert float(found["uncertainty_quantile"].sel(quantile=0.99)[0]) == float(largest[0])  # of 27 values, in doubt
    every = np.concatenate([stage.relative_uncertainty(match)[1].values.ravel() for match in known.values()])
    middle = float(found["uncertainty_quantile"].sel(viscous_model="CDR", quantile=0.5))
    assert middle in every and np.mean(every <= middle) >= 0.5 >= np.mean(every < middle)


def test_the_sample_holds_the_largest_errors_and_drawn_ones_whatever_their_uncertainty(studies, matches):
    known = {name: match.copy(deep=True) for name, match in matches.items()}
    known["amplitude"]["rms_error"][2, 0, 0] = 0.5
    chosen = stage.sample(studies, known, count=5, seed=20170616)
    assert [len(chosen[model]) for model in VISCOUS_MODELS] == [5] * len(VISCOUS_MODELS)
    assert (chosen["SDR"][0].restitution, chosen["SDR"][0].release_amplitude) == (0.8, 0.3)
    errors = np.sort(np.unique(known["cracked_stiffness"]["rms_error"][2].values))[::-1]
    for published, error in zip(chosen["SDR"][1:3], errors[:2], strict=True):
        there = known["cracked_stiffness"].sel(damping_model="SDR", restitution=published.restitution)
        assert error == float(there["rms_error"].sel(yield_displacement_ratio=published.curve.yield_displacement_ratio))
    for name, match in known.items():
        known[name] = match.assign(damping_ratio_uncertainty=match["damping_ratio_uncertainty"][::-1, ::-1, ::-1])
    again = stage.sample(studies, known, count=5, seed=20170616)
    assert [one.ratio for one in again["SDR"]] == [one.ratio for one in chosen["SDR"]]
    other = stage.sample(studies, known, count=5, seed=1)
    assert [one.ratio for one in other["SDR"][:3]] == [one.ratio for one in chosen["SDR"][:3]]
    assert any([one.ratio for one in other[model]] != [one.ratio for one in chosen[model]] for model in VISCOUS_MODELS)


@pytest.fixture(scope="module")
def distance():
    return stage.Distance(CURVE, "CDC", 0.85, 0.5, 6.0)


def test_the_distance_is_the_integral_of_eq_17(distance):
    """Against 8 times as many samples without nodes at the crossings; each is second order in its spacing."""
    times = np.linspace(0, 6, 8 * 12000 + 1)
    expected, found = (
        np.abs(event_driven.history(CURVE, damping, times, release_amplitude=0.5).displacement)
        for damping in (Damping.cr(0.85), Damping("CDC", 0.03))
    )
    assert distance(0.03) == pytest.approx(np.trapezoid((expected - found) ** 2, times), rel=2e-5)


@pytest.fixture(scope="module")
def minimum(distance):
    """The least distance by brute force: a parabola through three points around the least of a fine scan."""
    scan = np.linspace(0.02, 0.06, 41)
    values = np.array([distance(xi) for xi in scan])
    low, middle, high = values[values.argmin() - 1 : values.argmin() + 2]
    return scan[values.argmin()] + 0.001 * (low - high) / (low - 2 * middle + high) / 2


def test_the_exact_minimum_does_not_depend_on_the_published_value(distance, minimum):
    found = [
        stage.exact_minimum(stage.Published(CURVE, 0.5, 0.85, "CDC", factor * minimum, 0.0), 6.0, 0.02)
        for factor in (0.99, 1.0, 1.01)
    ]
    np.testing.assert_allclose(found, found[1], rtol=2e-5)
    assert found[1] == pytest.approx(minimum, rel=0.01)
    assert distance(found[1]) < min(distance(found[1] * 0.999), distance(found[1] * 1.001))


def test_a_minimum_beyond_the_bracket_is_an_error(minimum):
    far = stage.Published(CURVE, 0.5, 0.85, "CDC", 1.05 * minimum, 0.0)
    with pytest.raises(InputError, match=r"accuracy.bracket is 0.02; it must be larger: Err of CDC at e = 0.85"):
        stage.exact_minimum(far, 6.0, 0.02)


def test_the_difference_of_the_sample_is_that_of_the_published_value(config, studies):
    """The same published values, once 0.3 % larger: so are the differences, and nothing else changes."""
    plain = {name: made_up(config, name, ["CDC"]) for name in STUDIES}
    more = {name: match.assign(damping_ratio=1.003 * match["damping_ratio"]) for name, match in plain.items()}
    one, other = (stage.minima(studies, known, **SAMPLE) for known in (plain, more))
    np.testing.assert_allclose(other["sample_exact_ratio"], one["sample_exact_ratio"], rtol=2e-5)
    np.testing.assert_allclose(1 + other["sample_difference"], 1.003 * (1 + one["sample_difference"]), rtol=2e-5)
    np.testing.assert_allclose(one["sample_bound"][0, 0], 2e-4)  # the largest of them all


def test_the_share_within_the_uncertainty_is_that_of_the_exact_minima_in_it(config, studies):
    known = {name: made_up(config, name, ["CDC"]) for name in STUDIES}
    exact = stage.minima(studies, known, **SAMPLE)
    ratio, worst = known["cracked_stiffness"]["damping_ratio"], exact["sample_exact_ratio"].values[0, 0]
    uncertainty = known["cracked_stiffness"]["damping_ratio_uncertainty"]  # its last is of the largest error of all
    ratio[0, -1, -1] = 1.001 * worst
    for within, bound in ((1.0, 0.00101), (0.0, 0.00099)):
        uncertainty[0, -1, -1] = bound * worst
        found = stage.minima(studies, known, **SAMPLE)
        assert found["sample_difference"][0, 0] == pytest.approx(0.001, rel=1e-2)
        assert float(found["share_within_uncertainty"].sel(sample_half="largest error")[0]) == within
    drawn = abs(found["sample_difference"][0, 1]) <= found["sample_bound"][0, 1]
    assert float(found["share_within_uncertainty"].sel(sample_half="drawn")[0]) == float(drawn)
