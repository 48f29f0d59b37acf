"""The response length that the paper implies."""

import numpy as np
import pytest
import xarray as xr
from configs import changed, configured

from rockdamp.constants import DEFAULT_RESPONSE_LENGTH, VISCOUS_MODELS
from rockdamp.storage import dataset
from rockdamp.studies import response_lengths
from rockdamp.studies.decays import decay as decay_study


@pytest.fixture(scope="module")
def found(config, decays):
    return response_lengths.response_lengths(config, decays["amplitude"])


def test_a_damping_ratio_of_one_step_lies_within_its_uncertainty(found, matches):
    """Of the exact one, which the match follows to a finer step with an uncertainty of its own."""
    length = float(matches["amplitude"]["response_length"])
    here = found.sel(response_length=length).transpose("damping_model", "restitution", ...)
    exact = (
        matches["amplitude"].sel(release_amplitude=0.5).transpose("damping_model", "restitution")
    )
    off = np.abs(here["damping_ratio"] - exact["damping_ratio"])
    assert (
        off <= here["damping_ratio_uncertainty"] + exact["damping_ratio_uncertainty"]
    ).mean() >= 0.9
    assert (here["damping_ratio_uncertainty"] >= 3e-5 * here["damping_ratio"]).all()
    # It says something: at a step of 0.1 in tau, thousands of a percent would be no bound.
    assert float((here["damping_ratio_uncertainty"] / here["damping_ratio"]).median()) < 0.1


def test_the_default_response_length_is_the_one_that_the_paper_implies(paper):
    """The inference on the paper's grid of e, over the response lengths that hold its minimum, at twice the step."""
    reference = {"amplitude": [paper.release_amplitude]}
    step = {"solver": {"step": 2 * paper.solver.step}}
    config = changed(configured(step, {"studies": reference}), {"response_lengths.stop": 30})
    found = response_lengths.response_lengths(config, decay_study("amplitude", config))
    assert float(found["inferred_response_length"]) == DEFAULT_RESPONSE_LENGTH


def test_the_length_is_a_narrow_best_and_that_of_the_papers_wall(config, found):
    """Counts between its neighbours run through those at the lengths studied; each release has a length of its own."""
    dataset.check(found, "response_lengths")
    inferred, near = float(found["inferred_response_length"]), found["near_misclassified"]
    for response_length in found["response_length"].values:
        if (
            near["near_response_length"].min()
            <= response_length
            <= near["near_response_length"].max()
        ):
            assert int(near.sel(near_response_length=response_length)) == int(
                found["misclassified"].sel(response_length=response_length)
            )
    assert int(near.sel(near_response_length=inferred)) == int(found["misclassified"].min())
    of_release = found["inferred_response_length_of_release"]
    assert float(of_release.sel(release_amplitude=config.release_amplitude)) == inferred
    assert bool(
        (of_release.values[1:] >= of_release.values[:-1]).all()
    )  # a larger one needs longer for as many cycles


def test_of_lengths_that_serve_equally_the_middle_one_is_inferred(monkeypatch):
    data = xr.Dataset(coords={"response_length": np.arange(1.0, 8.0)})
    for misfits, length in (
        ([3, 1, 1, 1, 2, 3, 4], 3.0),
        ([0, 5, 0, 5, 5, 5, 0], 3.0),
        ([2, 2, 1, 1, 2, 2, 2], 3.0),
    ):
        monkeypatch.setattr(
            response_lengths, "misclassified", lambda _, misfits=misfits: xr.DataArray(misfits)
        )
        assert response_lengths.infer(data) == length


def test_misfits_are_counted_against_the_papers_range():
    e = np.array([0.75, 0.80, 0.91, 0.95])
    lowest = {"perfect": ["SDR", "CDR", "CDR", "SDR"], "never": ["SDR"] * 4, "always": ["CDR"] * 4}
    error = np.ones((3, 4, len(VISCOUS_MODELS)))
    for w, models in enumerate(lowest.values()):
        for i, model in enumerate(models):
            error[w, i, VISCOUS_MODELS.index(model)] = 0.5
    data = xr.Dataset(
        {"error": (("response_length", "restitution", "damping_model"), error)},
        coords={
            "response_length": [1.0, 2.0, 3.0],
            "restitution": e,
            "damping_model": list(VISCOUS_MODELS),
        },
    )
    assert response_lengths.misclassified(data).values.tolist() == [0, 2, 2]
    assert response_lengths.infer(data) == 1.0
    flags = response_lengths.flags(data)
    assert flags["secant_below_constant"].values.tolist() == [0, 0, 0]


def test_lengths_between_neighbours_are_tenths_on_both_sides():
    lengths = np.array([4.0, 8.0, 9.0, 10.0])
    np.testing.assert_allclose(
        response_lengths.between_neighbours(lengths, 8.0),
        [*np.arange(4, 8, 0.4), *np.arange(8, 9.05, 0.1)],
    )
    np.testing.assert_allclose(
        response_lengths.between_neighbours(lengths, 10.0), np.arange(9, 10.05, 0.1)
    )
