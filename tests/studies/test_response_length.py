"""The response length that the paper implies."""

import copy

import numpy as np
import pytest
import xarray as xr
from repository import ROOT

from rockdamp.storage import dataset
from rockdamp.studies import response_length
from rockdamp.studies.decays import study as decay_study
from rockdamp.vocabulary import DEFAULT_WINDOW, VISCOUS_MODELS


def test_windows_agree_with_the_match_at_its_window(config, decays, matches):
    """Both find the same minima; the match then follows them to a finer step, which moves them a little."""
    found = response_length.windows(config, decays["amplitude"])
    window = float(matches["amplitude"]["window"])
    here = found["damping_ratio"].sel(window=window).transpose("damping_model", "restitution")
    np.testing.assert_allclose(here, matches["amplitude"]["damping_ratio"].sel(release_amplitude=0.5), rtol=0.02)


@pytest.mark.no_cover
def test_the_default_window_is_the_one_that_the_paper_implies(paper):
    """The inference on the paper's grid of e, over the windows that hold its minimum, at twice the step."""
    config = copy.deepcopy(paper)
    config["solver"]["step"] = 2 * paper["solver"]["step"]
    config["studies"]["amplitude"]["release_amplitude"] = [paper["release_amplitude"]]
    config["windows"] = {**paper["windows"], "stop": 30}
    found = response_length.windows(config, decay_study("amplitude", config))
    assert float(found["inferred_window"]) == DEFAULT_WINDOW
    flag = found["cdr_lowest_in_paper_range"].sel(window=DEFAULT_WINDOW)
    assert int(flag) == (int(found["misclassified"].min()) == 0)


def test_a_built_windows_dataset_infers_the_default_window():
    path = ROOT / "results/windows.nc"
    if not path.exists():
        pytest.skip("results/windows.nc is not built")
    assert float(dataset.open(path)["inferred_window"]) == DEFAULT_WINDOW


def test_the_length_is_a_narrow_best_and_that_of_the_papers_wall(config, decays):
    """Counts between its neighbours run through those at the lengths studied; each release has a length of its own."""
    found = response_length.windows(config, decays["amplitude"])
    dataset.check(found, "windows")
    inferred, near = float(found["inferred_window"]), found["near_misclassified"]
    for window in found["window"].values:
        if near["near_window"].min() <= window <= near["near_window"].max():
            assert int(near.sel(near_window=window)) == int(found["misclassified"].sel(window=window))
    assert int(near.sel(near_window=inferred)) == int(found["misclassified"].min())
    of_release = found["inferred_window_of_release"]
    assert float(of_release.sel(release_amplitude=config["release_amplitude"])) == inferred
    assert bool((of_release.values[1:] >= of_release.values[:-1]).all())  # a larger one needs longer for as many cycles


def test_lengths_next_to_the_inferred_are_in_tenths_and_end_with_those_studied():
    lengths = np.array([3.0, 4.0, 6.0])
    np.testing.assert_allclose(
        response_length.between_neighbours(lengths, 4.0), np.r_[np.arange(3.0, 4.0, 0.1), np.arange(4.0, 6.05, 0.2)]
    )
    np.testing.assert_allclose(response_length.between_neighbours(lengths, 6.0), np.arange(4.0, 6.05, 0.2))


def test_of_lengths_that_serve_equally_the_middle_one_is_inferred(monkeypatch):
    data = xr.Dataset(coords={"window": np.arange(1.0, 8.0)})
    for misfits, length in (([3, 1, 1, 1, 2, 3, 4], 3.0), ([0, 5, 0, 5, 5, 5, 0], 3.0), ([2, 2, 1, 1, 2, 2, 2], 3.0)):
        monkeypatch.setattr(response_length, "misclassified", lambda _, misfits=misfits: xr.DataArray(misfits))
        assert response_length.infer(data) == length


def test_misfits_are_counted_against_the_papers_range():
    e = np.array([0.75, 0.80, 0.91, 0.95])
    lowest = {"perfect": ["SDR", "CDR", "CDR", "SDR"], "never": ["SDR"] * 4, "always": ["CDR"] * 4}
    error = np.ones((3, 4, len(VISCOUS_MODELS)))
    for w, models in enumerate(lowest.values()):
        for i, model in enumerate(models):
            error[w, i, VISCOUS_MODELS.index(model)] = 0.5
    data = xr.Dataset(
        {"error": (("window", "restitution", "damping_model"), error)},
        coords={"window": [1.0, 2.0, 3.0], "restitution": e, "damping_model": list(VISCOUS_MODELS)},
    )
    assert response_length.misclassified(data).values.tolist() == [0, 2, 2]
    assert response_length.infer(data) == 1.0
    flags = response_length.flags(data)
    assert flags["cdr_lowest_in_paper_range"].values.tolist() == [1, 0, 0]
    assert flags["secant_below_constant"].values.tolist() == [0, 0, 0]
