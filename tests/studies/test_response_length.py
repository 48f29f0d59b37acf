"""The response length that the paper implies."""

import copy

import numpy as np
import pytest
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


def test_misfits_are_counted_against_the_papers_range():
    import xarray as xr

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
