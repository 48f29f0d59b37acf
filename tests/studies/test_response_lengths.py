"""The response length that the paper implies."""

import numpy as np
import pytest
import xarray as xr
from configs import changed, configured
from made_datasets import make_dataset

from rockdamp.constants import DEFAULT_RESPONSE_LENGTH, VISCOUS_MODELS
from rockdamp.studies import response_lengths
from rockdamp.studies.decays import decay


@pytest.fixture(scope="module")
def lengths(config, decays):
    return response_lengths.response_lengths(config, decays["amplitude"])


# --- damping ratios -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def finer(matches):
    """The reference wall at a finer step, with an uncertainty of its own."""
    reference = matches["amplitude"].sel(release_amplitude=0.5)
    return reference.transpose("damping_model", "restitution")


@pytest.fixture(scope="module")
def same_length(lengths, matches):
    length = float(matches["amplitude"]["response_length"])
    return lengths.sel(response_length=length).transpose("damping_model", "restitution", ...)


def test_ratio_of_one_step_is_within_its_uncertainty(same_length, finer):
    error = np.abs(same_length["damping_ratio"] - finer["damping_ratio"])
    bound = same_length["damping_ratio_uncertainty"] + finer["damping_ratio_uncertainty"]
    assert (error <= bound).mean() >= 0.9


def test_uncertainty_is_at_least_the_resolution(same_length):
    relative = same_length["damping_ratio_uncertainty"] / same_length["damping_ratio"]
    assert (relative >= 3e-5).all()


def test_uncertainty_is_a_useful_bound(same_length):
    relative = same_length["damping_ratio_uncertainty"] / same_length["damping_ratio"]
    assert float(relative.median()) < 0.1


# --- inferred length ------------------------------------------------------------------------------


def test_default_length_is_the_one_the_paper_implies(paper):
    """On the paper's grid of e, over the lengths around the minimum, at twice the step."""
    step = {"solver": {"step": 2 * paper.solver.step}}
    reference = {"studies": {"amplitude": [paper.release_amplitude]}}
    config = changed(configured(step, reference), {"response_lengths.stop": 30})
    lengths = response_lengths.response_lengths(config, decay("amplitude", config))
    assert float(lengths["inferred_response_length"]) == DEFAULT_RESPONSE_LENGTH


def test_near_counts_include_those_of_the_lengths(lengths):
    near_counts = lengths["near_misclassified"]
    near_lengths = near_counts["near_response_length"]
    response_length = lengths["response_length"]
    is_near = (response_length >= near_lengths.min()) & (response_length <= near_lengths.max())
    common = response_length[is_near].values
    expected = lengths["misclassified"].sel(response_length=common).values
    assert common.size >= 2
    np.testing.assert_array_equal(near_counts.sel(near_response_length=common), expected)


def test_inferred_length_has_the_fewest_misfits(lengths):
    inferred = float(lengths["inferred_response_length"])
    count = lengths["near_misclassified"].sel(near_response_length=inferred)
    assert int(count) == int(lengths["misclassified"].min())


def test_inferred_length_is_that_of_the_papers_release(config, lengths):
    by_release = lengths["inferred_response_length_of_release"]
    inferred = float(lengths["inferred_response_length"])
    assert float(by_release.sel(release_amplitude=config.release_amplitude)) == inferred


def test_larger_release_implies_a_longer_response(lengths):
    by_release = lengths["inferred_response_length_of_release"].values
    assert (by_release[1:] >= by_release[:-1]).all()


@pytest.mark.parametrize(
    ("misfits", "length"),
    [
        ([3, 1, 1, 1, 2, 3, 4], 3.0),
        ([0, 5, 0, 5, 5, 5, 0], 3.0),
        ([2, 2, 1, 1, 2, 2, 2], 3.0),
    ],
)
def test_middle_of_equal_lengths_is_inferred(misfits, length, monkeypatch):
    monkeypatch.setattr(response_lengths, "misclassified", lambda _: xr.DataArray(misfits))
    errors = make_dataset("response_lengths", {"response_length": np.arange(1.0, 8.0)})
    assert response_lengths.infer(errors) == length


# --- counts of misfits ----------------------------------------------------------------------------


@pytest.fixture
def errors():
    """CDR is lowest in the paper's range, then never, then always."""
    coordinates = {
        "response_length": [1.0, 2.0, 3.0],
        "restitution": [0.75, 0.80, 0.91, 0.95],
        "damping_model": list(VISCOUS_MODELS),
    }
    lowest = [["SDR", "CDR", "CDR", "SDR"], ["SDR"] * 4, ["CDR"] * 4]
    error = np.ones((3, 4, len(VISCOUS_MODELS)))
    for row, models in enumerate(lowest):
        for column, model in enumerate(models):
            error[row, column, VISCOUS_MODELS.index(model)] = 0.5
    return make_dataset("response_lengths", coordinates, error=error)


def test_misfits_are_counted_against_the_papers_range(errors):
    assert response_lengths.misclassified(errors).values.tolist() == [0, 2, 2]


def test_length_without_misfits_is_inferred(errors):
    assert response_lengths.infer(errors) == 1.0


def test_equal_errors_are_not_below(errors):
    flags = response_lengths.flags(errors)
    assert flags["secant_below_constant"].values.tolist() == [0, 0, 0]


@pytest.mark.parametrize(
    ("inferred", "expected"),
    [
        (8.0, [*np.arange(4, 8, 0.4), *np.arange(8, 9.05, 0.1)]),
        (10.0, np.arange(9, 10.05, 0.1)),
    ],
    ids=["inside", "last"],
)
def test_lengths_between_neighbours_are_tenths(inferred, expected):
    lengths = np.array([4.0, 8.0, 9.0, 10.0])
    np.testing.assert_allclose(response_lengths.between_neighbours(lengths, inferred), expected)
