"""Lognormal fragilities against a general minimiser and known curves, the bootstrap, and intervals of a proportion."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq, minimize
from scipy.stats import norm

from rockdamp.errors import InputError
from rockdamp.statistics import fragility
from rockdamp.statistics.fragility import (
    effective_count,
    fit_fragility,
    resample,
    weighted_quantile,
    wilson,
)

INTENSITY = np.geomspace(0.2, 5.0, 12)


def most_likely(collapses, runs):
    """The same maximum by a general minimiser over (ln median, ln dispersion)."""

    def minus(parameters):
        median, dispersion = np.exp(parameters)
        z = np.log(INTENSITY / median) / dispersion
        return -(collapses * norm.logcdf(z) + (runs - collapses) * norm.logsf(z)).sum()

    found = minimize(
        minus, [0.0, np.log(0.5)], method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 1e-13}
    )
    return np.exp(found.x)


@given(st.floats(0.4, 2.5), st.floats(0.15, 1.0), st.integers(0, 10**6))
def test_the_curve_is_the_one_a_general_minimiser_finds(median, dispersion, seed):
    probability = norm.cdf(np.log(INTENSITY / median) / dispersion)
    collapses = np.random.default_rng(seed).binomial(40, probability)
    found = fit_fragility(INTENSITY, collapses, 40)
    if np.isnan(found.median):  # separated
        assert np.flatnonzero(collapses > 0).min() >= np.flatnonzero(collapses < 40).max()
    else:
        np.testing.assert_allclose(found[:2], most_likely(collapses, 40), rtol=1e-5)
        other = fit_fragility(9.81 * INTENSITY, collapses, 40)
        np.testing.assert_allclose(other[:2], [9.81 * found.median, found.dispersion], rtol=1e-8)


@pytest.mark.parametrize(
    ("counts", "reason"),
    [
        ([0] * 12, "no run"),
        ([20] * 12, "every run"),
        ([0] * 6 + [20] * 6, "none below"),
        ([0] * 5 + [7] + [20] * 6, "none below"),
        (list(range(12, 0, -1)), "fewer"),
    ],
)
def test_outcomes_that_define_no_curve_say_why(counts, reason):
    found = fit_fragility(INTENSITY, [counts, range(1, 13)], 20)
    np.testing.assert_array_equal(np.isnan([found.median, found.dispersion]), [[True, False]] * 2)
    assert reason in found.reason[0] and found.reason[1] == ""


BAD = [("collapses", [1, 2], [1, 3]), ("collapses", [1, 2], [1, -1])]
BAD += [("intensity", [2, 1], [1, 1]), ("intensity", [0, 1], [1, 1])]


@pytest.mark.parametrize(("named", "intensity", "collapses"), BAD)
def test_impossible_counts_and_intensities_are_refused(named, intensity, collapses):
    with pytest.raises(InputError, match=named):
        fit_fragility(intensity, collapses, 2)


# --- the bootstrap ----------------------------------------------------------------------------------------------------


def test_stations_are_drawn_whole_and_as_often_as_there_are_stations():
    groups = ["a", "a", "b", "c", "c", "c"]
    weights = resample(groups, 500, seed=3)
    np.testing.assert_array_equal(weights[:, [0, 3, 3]], weights[:, [1, 4, 5]])
    np.testing.assert_array_equal(weights[:, [0, 2, 3]].sum(axis=1), 3)
    np.testing.assert_array_equal(weights, resample(groups, 500, seed=3))
    assert (weights != resample(groups, 500, seed=4)).any()
    # Each is drawn once on average; its variance is that of a multinomial draw.
    assert weights[:, 0].mean() == pytest.approx(1.0, abs=4 * np.sqrt((1 - 1 / 3) / 500))


@given(st.lists(st.floats(-10, 10), max_size=9), st.integers(0, 1000))
def test_the_weighted_median_is_that_of_the_repeated_values(values, seed):
    values, random = np.array(values), np.random.default_rng(seed)
    record, weights = (
        random.integers(0, 6, values.size),
        random.integers(0, 4, (5, 6)).astype(float),
    )
    found = weighted_quantile(values, record, weights, 0.5)
    for row, median in zip(weights, found, strict=True):
        repeated = np.repeat(values, row[record].astype(int))
        expected = np.median(repeated) if repeated.size else np.nan
        assert median == pytest.approx(expected, abs=1e-12, nan_ok=True)


def test_an_interval_leaves_a_fortieth_of_the_replicates_out_on_either_side_and_needs_nine_in_ten():
    drawn = np.random.default_rng(2).permutation(1001.0 * np.arange(1, 1002)).reshape(-1, 1)
    low, high = fragility.interval(drawn)[0]
    assert (drawn < low).mean() == pytest.approx(1 / 40, abs=1e-3)
    assert (drawn > high).mean() == pytest.approx(1 / 40, abs=1e-3)
    drawn = np.arange(100.0)[:, None] * np.ones(2)
    drawn[:10, 0] = drawn[:11, 1] = np.nan
    assert (
        np.isfinite(fragility.interval(drawn)[0]).all()
        and np.isnan(fragility.interval(drawn)[1]).all()
    )


def test_the_bootstrap_interval_of_a_median_covers_it_as_often_as_it_says():
    """Two hundred samples of a known lognormal: 95 % intervals must hold its median in 95 % of them, within chance."""
    rng, inside = np.random.default_rng(8), 0
    for trial in range(200):
        collapsed = rng.lognormal(0.0, 0.4, 50)[:, None] <= INTENSITY
        drawn = fit_fragility(
            INTENSITY, resample(np.arange(50), 200, seed=trial) @ collapsed, 50.0
        ).median
        low, high = np.quantile(drawn, [0.025, 0.975])
        inside += low <= 1.0 <= high
    assert (
        0.88 * 200 <= inside <= 200
    )  # 95 % less three standard deviations and the bootstrap's own bias


# --- proportions ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("counted", "trials"), [(0, 5), (1, 44), (22, 44), (44, 44), (3, 7)])
def test_the_ends_are_where_the_score_test_just_rejects(counted, trials):
    """|p_hat - p| = z sqrt(p (1 - p)/n) at both ends, solved by bisection."""
    share, z = counted / trials, norm.ppf(0.975)

    def excess(p):
        return abs(share - p) - z * np.sqrt(p * (1 - p) / trials)

    low = brentq(excess, 1e-12, share - 1e-9) if counted else 0.0
    high = brentq(excess, share + 1e-9, 1 - 1e-12) if counted < trials else 1.0
    assert wilson(share, trials) == pytest.approx([low, high], abs=1e-9)


@pytest.mark.parametrize("share", [0.05, 0.3, 0.9])
def test_the_interval_covers_the_share_as_often_as_it_says(share):
    bounds = wilson(np.random.default_rng(5).binomial(44, share, 4000) / 44, 44)
    assert 0.92 < ((bounds[:, 0] <= share) & (share <= bounds[:, 1])).mean() < 0.99


@pytest.mark.parametrize("agreement", [0.0, 0.5, 1.0])
def test_the_interval_of_pairs_covers_however_much_they_agree(agreement):
    """22 stations of two components, of which a part has the same outcome in both."""
    rng, groups, share = np.random.default_rng(11), np.repeat(np.arange(22), 2), 0.3
    first = rng.random((1000, 22)) < share
    second = np.where(rng.random((1000, 22)) < agreement, first, rng.random((1000, 22)) < share)
    counted = np.stack([first, second], axis=2).reshape(1000, 44).T
    bounds = wilson(counted.mean(axis=0), effective_count(counted, groups, 400, 3))
    assert 0.92 < ((bounds[:, 0] <= share) & (share <= bounds[:, 1])).mean() < 0.99


def test_the_effective_count_is_kish_s_between_the_groups_and_the_trials():
    groups = np.repeat(np.arange(3), 4)
    mixed = np.array([1, 1, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0], dtype=bool)
    p, share = mixed.mean(), mixed.reshape(3, 4).mean(axis=1)
    exact = (
        p * (1 - p) / (share.var() / 2)
    )  # the exact variance over bootstraps, times g/(g - 1) as it is too small
    assert effective_count(mixed, groups, 20000, 1) == pytest.approx(exact, rel=0.05)
    alike, opposite = np.repeat([True, False, False], 4), np.tile([True, False], 6)
    edges = np.stack([alike, opposite, np.zeros(12, bool), np.ones(12, bool)], axis=1)
    assert effective_count(edges, groups, 4000, 1).tolist() == [3, 12, 3, 3]
    assert effective_count(edges, np.arange(12), 100, 1).tolist() == [12] * 4
