"""Statistics of pairs against restitution, compared with their sums written out."""

import numpy as np
import pytest
import xarray as xr

from rockdamp.statistics.fragility import fit_fragility, resample
from rockdamp.statistics.paired import (
    HISTORIES,
    LARGE_LOG_RATIO,
    compare_fragilities,
    compare_pairs,
)

STATIONS = [f"s{i // 2}" for i in range(24)]
DIMS = (*HISTORIES, "restitution")
BANDS = [(0.0, np.inf), (0.0, 0.5), (0.5, np.inf)]


@pytest.fixture
def histories():
    """Peaks of two alternatives to restitution on three walls; beyond 1 they collapse."""
    rng = np.random.default_rng(6)
    reference = rng.lognormal(-0.7, 0.6, (24, 4, 3, 2))
    peak = reference[..., None] * np.exp(rng.normal([0.1, -0.2], [0.3, 0.1], (*reference.shape, 2)))
    return xr.Dataset(
        {
            "reference_peak": (DIMS, reference),
            "reference_collapsed": (DIMS, (reference > 1).astype(np.int8)),
            "peak": ((*DIMS, "damper"), peak),
            "collapsed": ((*DIMS, "damper"), (peak > 1).astype(np.int8)),
        }
    )


@pytest.mark.parametrize("band", range(len(BANDS)))
def test_peaks_are_compared_over_pairs_of_survivals_in_a_band(band, histories):
    statistics = compare_pairs(histories, resample(STATIONS, 20, 1), BANDS).isel(band=band)
    reference = histories["reference_peak"]
    peak = histories["peak"]
    low, high = BANDS[band]
    inside = (reference <= 1) & (peak <= 1) & (reference >= low) & (reference < high)
    logarithm = xr.apply_ufunc(np.log, (peak / reference).where(inside))
    size = abs(logarithm)
    expected = {
        "median_ratio": np.exp(logarithm.median(HISTORIES)),
        "log_error": np.sqrt((logarithm**2).mean(HISTORIES)),
        "log_error_median": size.median(HISTORIES),
        "share_above": (size > LARGE_LOG_RATIO).sum(HISTORIES) / inside.sum(HISTORIES),
        "pairs": logarithm.count(HISTORIES),
    }
    for name, values in expected.items():
        np.testing.assert_allclose(
            statistics[name], values.transpose("restitution", "damper"), 1e-12, err_msg=name
        )
    upper = statistics["log_error_90"].transpose("damper", "restitution")
    below = (size <= upper).sum(HISTORIES)
    np.testing.assert_allclose(below, 0.9 * inside.sum(HISTORIES), atol=1)


def test_collapse_rates_count_outcomes_of_only_one_of_the_two(histories):
    statistics = compare_pairs(histories, resample(STATIONS, 20, 1), BANDS)
    reference_collapses = histories["reference_peak"] > 1
    collapses = histories["peak"] > 1
    missed = reference_collapses & ~collapses
    added = ~reference_collapses & collapses
    missed_rate = missed.sum(HISTORIES) / reference_collapses.sum(HISTORIES)
    added_rate = added.sum(HISTORIES) / (~reference_collapses).sum(HISTORIES)
    for name, rate in (("missed", missed_rate), ("added", added_rate)):
        expected = rate.transpose("restitution", "damper")
        np.testing.assert_allclose(statistics[f"{name}_collapse_rate"], expected, rtol=1e-12)


def test_histories_that_were_not_run_count_nowhere(histories):
    weights = resample(STATIONS, 20, 1)
    fewer = histories.assign(collapsed=histories["collapsed"].where(histories["wall"] > 0, -1))
    other_walls = compare_pairs(histories.isel(wall=[1, 2]), weights, BANDS)
    xr.testing.assert_allclose(compare_pairs(fewer, weights, BANDS), other_walls, rtol=1e-12)


def test_twice_the_peak_has_the_ratio_two_without_doubt(histories):
    doubled = {
        "peak": 2 * histories["reference_peak"],
        "collapsed": histories["reference_collapsed"],
    }
    alternative = histories.isel(damper=[0]).assign(
        {name: values.expand_dims("damper", -1) for name, values in doubled.items()}
    )
    statistics = compare_pairs(alternative, resample(STATIONS, 50, 1), BANDS[:1])
    np.testing.assert_allclose(statistics["median_ratio_interval"], 2.0, rtol=1e-12)
    np.testing.assert_allclose(statistics["log_error_interval"], np.log(2), rtol=1e-12)


@pytest.fixture
def two_fragilities():
    """Counts of two walls, the second of 0.9 the capacity, under 24 records."""
    capacity = np.random.default_rng(7).lognormal(0.0, 0.4, 24)
    intensity = np.geomspace(0.2, 4.0, 40)
    first = capacity[:, None] < intensity
    second = 0.9 * capacity[:, None] < intensity
    return intensity, np.stack([first, second], axis=1)


def test_ratio_of_medians_is_the_one_of_two_fits(two_fragilities):
    intensity, counts = two_fragilities
    weights = resample(STATIONS, 200, 2)
    statistics = compare_fragilities(intensity, counts, 1, weights, (..., slice(0, 1)))
    first, second = (
        fit_fragility(intensity, counts[:, wall].sum(axis=0), 24).median for wall in (0, 1)
    )
    np.testing.assert_allclose(statistics["median_intensity_ratio"], [1.0, second / first])


def test_interval_of_a_ratio_of_medians_is_paired(two_fragilities):
    """It is much narrower than the interval of one median."""
    intensity, counts = two_fragilities
    weights = resample(STATIONS, 200, 2)
    statistics = compare_fragilities(intensity, counts, 1, weights, (..., slice(0, 1)))
    ratio_width = np.ptp(statistics["median_intensity_ratio_interval"][1])
    median_width = np.ptp(statistics["median_interval"][1])
    assert ratio_width < 0.3 * median_width
