"""Statistics of pairs against restitution: the sums written out, and the order of the stations, which says nothing."""

import numpy as np
import pytest
import xarray as xr

from rockdamp.statistics.fragility import fit_fragility, resample
from rockdamp.statistics.paired import HISTORIES, LARGE, compare_fragilities, compare_pairs

STATION = [f"s{i // 2}" for i in range(24)]
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


def test_the_statistics_are_the_sums_over_pairs_that_stand_in_each_band_and_over_outcomes(
    histories,
):
    found = compare_pairs(histories, resample(STATION, 20, 1), BANDS)
    reference, peak = histories["reference_peak"], histories["peak"]
    fell, falls = reference > 1, peak > 1
    for band, (low, high) in enumerate(BANDS):
        inside = ~fell & ~falls & (reference >= low) & (reference < high)
        logarithm = xr.apply_ufunc(np.log, (peak / reference).where(inside))
        size = abs(logarithm)
        expected = {
            "median_ratio": np.exp(logarithm.median(HISTORIES)),
            "log_error": np.sqrt((logarithm**2).mean(HISTORIES)),
            "log_error_median": size.median(HISTORIES),
            "share_above": (size > LARGE).sum(HISTORIES) / inside.sum(HISTORIES),
            "pairs": logarithm.count(HISTORIES),
        }
        for name, values in expected.items():
            np.testing.assert_allclose(
                found[name].isel(band=band), values.transpose("restitution", "damper"), 1e-12
            )
        high = found["log_error_90"].isel(band=band).transpose("damper", "restitution")
        np.testing.assert_allclose(
            (size <= high).sum(HISTORIES), 0.9 * inside.sum(HISTORIES), atol=1
        )
    for name, wrong, ran in (("missed", fell & ~falls, fell), ("added", ~fell & falls, ~fell)):
        expected = (wrong.sum(HISTORIES) / ran.sum(HISTORIES)).transpose("restitution", "damper")
        np.testing.assert_allclose(found[f"{name}_collapse_rate"], expected, rtol=1e-12)


def test_what_the_alternative_did_not_run_counts_nowhere(histories):
    weights = resample(STATION, 20, 1)
    fewer = histories.assign(collapsed=histories["collapsed"].where(histories["wall"] > 0, -1))
    alone = compare_pairs(histories.isel(wall=[1, 2]), weights, BANDS)
    xr.testing.assert_allclose(compare_pairs(fewer, weights, BANDS), alone, rtol=1e-12)


def test_what_is_twice_restitution_has_the_ratio_two_without_doubt(histories):
    both = {"peak": 2 * histories["reference_peak"], "collapsed": histories["reference_collapsed"]}
    twice = histories.isel(damper=[0]).assign(
        {name: value.expand_dims("damper", -1) for name, value in both.items()}
    )
    found = compare_pairs(twice, resample(STATION, 50, 1), BANDS[:1])
    for name, value in (("median_ratio", 2.0), ("log_error", np.log(2))):
        np.testing.assert_allclose(found[f"{name}_interval"], value, rtol=1e-12)


def test_a_ratio_of_medians_is_that_of_two_fits_and_its_interval_is_narrower_than_unpaired():
    capacity = np.random.default_rng(7).lognormal(0.0, 0.4, 24)
    intensity, weights = np.geomspace(0.2, 4.0, 40), resample(STATION, 200, 2)
    counts = np.stack([capacity[:, None] < intensity, 0.9 * capacity[:, None] < intensity], axis=1)
    fitted = compare_fragilities(intensity, counts, 1, weights, (..., slice(0, 1)))
    one, other = (fit_fragility(intensity, counts[:, i].sum(axis=0), 24).median for i in (0, 1))
    np.testing.assert_allclose(fitted["median_intensity_ratio"], [1.0, other / one])
    assert np.ptp(fitted["median_intensity_ratio_interval"][1]) < 0.3 * np.ptp(
        fitted["median_interval"][1]
    )
