"""What is counted of the histories: a handful of them, whose rates and bands can be counted by hand."""

import numpy as np
import pytest
import xarray as xr
from configs import configured
from made_up_earthquakes import histories

from rockdamp.studies import comparison

CONFIG = configured({"comparison": {"bands": [0.1, 0.2, 0.4], "bootstrap": {"replicates": 60, "seed": 4}}})


def study(peak, fell=None, scale=(1.0,)):
    """Histories of CR and CDR on one wall; `peak` and `fell` of shape (records, scales, 2)."""
    peaks = np.asarray(peak, dtype=float)[:, :, None, None, :, None]
    collapsed = np.zeros(peaks.shape, dtype=np.int8)
    if fell is not None:
        collapsed[...] = np.asarray(fell)[:, :, None, None, :, None]
    return histories(
        peaks,
        peaks[..., 0, :],
        [f"s{i}" for i in range(len(peaks))],
        list(scale),
        collapsed,
        wall=["one"],
        restitution=[0.85],
        damping_model=["CR", "CDR"],
        damping_ratio_source=["least error"],
        variation=["step"],
    )


def compared(made):
    return comparison.compare_dampers(CONFIG, made).squeeze(["wall", "restitution", "damping_ratio_source"])


def test_missed_collapses_are_of_the_collapses_and_added_ones_of_the_survivals():
    """CR collapses in four of ten histories. The damper stands in one of the four, and collapses in two of the six."""
    cr, damper = [1, 1, 1, 1, 0, 0, 0, 0, 0, 0], [1, 1, 1, 0, 1, 1, 0, 0, 0, 0]
    found = compared(study(np.full((10, 1, 2), 0.15), np.stack([cr, damper], axis=-1)[:, None])).sel(
        damping_model="CDR"
    )
    assert float(found["missed_collapse_rate"]) == 1 / 4 and float(found["added_collapse_rate"]) == 2 / 6
    assert int(found["pairs"].isel(band=0)) == 4


def test_a_peak_at_the_edge_of_two_bands_is_in_the_upper_one_and_one_at_the_last_edge_in_none():
    cr = np.array([0.0999, 0.1, 0.2, 0.3, 0.4])
    found = compared(study(np.stack([cr, cr * [7, 2, 3, 3, 7]], axis=-1)[:, None])).sel(damping_model="CDR")
    assert found["pairs"].values.tolist() == [3, 1, 2]
    np.testing.assert_allclose(found["median_ratio"], [3, 2, 3])
    np.testing.assert_allclose(found["log_error"], np.sqrt([np.mean(np.log([2, 3, 3]) ** 2), *np.log([2, 3]) ** 2]))


SCALE = np.geomspace(0.2, 5.0, 8)
ONE = np.ones(2)


def capacities():
    """Of twenty records: the scale at which a wall collapses."""
    return np.random.default_rng(9).lognormal(0.0, 0.4, 20)


def test_a_damper_that_collapses_with_restitution_has_a_median_of_ratio_one_without_doubt():
    """However uncertain each of both medians is, they are resampled together."""
    fell = np.repeat((capacities()[:, None] <= SCALE)[..., None], 2, axis=-1)
    found = compared(study(np.full(fell.shape, 0.15), fell, SCALE)).sel(damping_model="CDR")
    assert np.ptp(found["median_velocity_ratio_interval"].values) > 0.1
    np.testing.assert_allclose(found["median_intensity_ratio_interval"], ONE)


def test_a_history_of_cr_counts_once_however_many_sources_of_a_ratio_there_are():
    """CR, which no step settles, and CDR with two ratios: two of three histories are converged."""
    one = study(np.full((4, 1, 2), 0.15))
    other = one.assign_coords(damping_ratio_source=["closed form"])
    made = xr.concat([one, other], "damping_ratio_source", data_vars="minimal", coords="minimal", compat="override")
    made["converged"] = xr.ones_like(made["collapsed"]).where(made["damping_model"] != "CR", 0)
    assert float(comparison.compare_dampers(CONFIG, made)["converged_share"]) == pytest.approx(2 / 3)
