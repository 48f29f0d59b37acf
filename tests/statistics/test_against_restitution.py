"""Statistics against restitution: the sums written out, and the order of the stations and walls, which says nothing."""

import numpy as np
import pytest
import xarray as xr

from rockdamp.statistics.against_restitution import HISTORIES, bootstrapped, fragilities, tail
from rockdamp.statistics.fragility import fit_fragility, resample

STATION = [f"s{i // 2}" for i in range(24)]
DIMS = (*HISTORIES, "restitution")


def of_all_pairs(ratio, dims):
    """The statistics of ratios of peaks, all counted alike; a ratio that is NaN is no pair."""
    logarithm = xr.apply_ufunc(np.log, ratio)
    return xr.Dataset(
        {
            "median_ratio": np.exp(logarithm.median(dims)),
            "log_dispersion": logarithm.std(dims),
            "log_error": np.sqrt((logarithm**2).mean(dims)),
            "pairs": logarithm.count(dims),
        }
    )


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


def test_the_statistics_are_the_sums_over_pairs_that_stand_and_over_outcomes():
    made = histories()
    whole = bootstrapped(made, resample(STATION, 20, 1)).isel(band=0)
    fell, other = made["reference_collapsed"] == 1, made["collapsed"] == 1
    pairs = of_all_pairs((made["peak"] / made["reference_peak"]).where(~fell & ~other), HISTORIES)
    missed, added = (fell & ~other).sum(HISTORIES), (~fell & other).sum(HISTORIES)
    for name, values in {**pairs, "false_safe": missed, "false_collapse": added}.items():
        np.testing.assert_allclose(whole[name], values.transpose(*whole[name].dims), rtol=1e-12)
    np.testing.assert_allclose(
        pairs["log_error"] ** 2, np.log(pairs["median_ratio"]) ** 2 + pairs["log_dispersion"] ** 2, atol=0.01
    )
    np.testing.assert_allclose(whole["false_safe_rate"], whole["false_safe"] / fell.sum(HISTORIES), rtol=1e-12)


def test_typical_size_and_tail_are_those_of_the_sorted_logarithms():
    """Of 200 pairs two are the hundredth, and eighteen off by more than 0.02; a ratio's inverse is equally far off."""
    logarithm = np.r_[0.01 * np.ones(150), -0.02 * np.ones(32), 0.05 * np.ones(16), 0.3, -0.4]
    found = tail(np.random.default_rng(2).permutation(logarithm))
    assert (found["log_error_median"], found["log_error_90"]) == (0.01, 0.02)
    expected = (0.3**2 + 0.4**2) / (150 * 0.01**2 + 32 * 0.02**2 + 16 * 0.05**2 + 0.3**2 + 0.4**2)
    assert found["tail_share"] == pytest.approx(expected)
    assert tail(np.array([0.5]))["tail_share"] == 1.0
    assert all(np.isnan(value) for value in tail(np.zeros(0)).values())


def test_typical_size_and_tail_are_of_the_pairs_that_stand_in_each_band():
    made = histories()
    edges = [(0.0, 0.5), (0.5, np.inf)]
    found = bootstrapped(made, resample(STATION, 10, 1), edges).isel(restitution=1, damper=0)
    peak, reference = made["peak"].isel(restitution=1, damper=0), made["reference_peak"].isel(restitution=1)
    for band, (low, high) in enumerate(edges):
        part = ((peak <= 1) & (reference <= 1) & (reference >= low) & (reference < high)).values
        for name, value in tail(np.log(peak.values[part] / reference.values[part])).items():
            assert float(found[name][band]) == pytest.approx(value)


def test_what_is_twice_restitution_has_the_ratio_two_without_doubt_and_inverts_with_the_sides():
    made = histories().isel(damper=[0])
    both = {"peak": 2 * made["reference_peak"], "collapsed": made["reference_collapsed"]}
    twice = made.assign({name: values.expand_dims("damper", -1) for name, values in both.items()})
    ratio = bootstrapped(twice, resample(STATION, 50, 1))
    for name, value in (("median_ratio", 2.0), ("log_error", np.log(2))):
        np.testing.assert_allclose(ratio[f"{name}_interval"], value, rtol=1e-12)
    pairs = made["peak"] / made["reference_peak"]
    forth, back = (of_all_pairs(each, HISTORIES) for each in (pairs, 1 / pairs))
    np.testing.assert_allclose(forth["median_ratio"] * back["median_ratio"], 1.0, rtol=1e-12)
    np.testing.assert_allclose(forth["log_error"], back["log_error"], rtol=1e-12)


def test_a_ratio_of_medians_is_that_of_two_fits_and_its_interval_is_narrower_than_unpaired():
    capacity = np.random.default_rng(7).lognormal(0.0, 0.4, 24)
    intensity, weights = np.geomspace(0.2, 4.0, 40), resample(STATION, 200, 2)
    counts = np.stack([capacity[:, None] < intensity, 0.9 * capacity[:, None] < intensity], axis=1)
    fitted = fragilities(intensity, counts, 1, weights, (..., slice(0, 1)))
    one, other = (fit_fragility(intensity, counts[:, i].sum(axis=0), 24).median for i in (0, 1))
    np.testing.assert_allclose(fitted["median_intensity_ratio"], [1.0, other / one])
    assert np.ptp(fitted["median_intensity_ratio_interval"][1]) < 0.3 * np.ptp(fitted["median_interval"][1])
