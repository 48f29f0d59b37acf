"""Lognormal fragilities, their bootstrap, and intervals of a proportion."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq, minimize
from scipy.stats import norm

from rockdamp.errors import InputError
from rockdamp.statistics.fragility import (
    effective_count,
    fit_fragility,
    interval,
    resample,
    weighted_quantile,
    wilson,
)

INTENSITY = np.geomspace(0.2, 5.0, 12)


def most_likely(collapses, runs):
    """The same maximum by a general minimiser over (ln median, ln dispersion)."""

    def minus_log_likelihood(parameters):
        median, dispersion = np.exp(parameters)
        z = np.log(INTENSITY / median) / dispersion
        return -(collapses * norm.logcdf(z) + (runs - collapses) * norm.logsf(z)).sum()

    options = {"xatol": 1e-10, "fatol": 1e-13}
    start = [0.0, np.log(0.5)]
    result = minimize(minus_log_likelihood, start, method="Nelder-Mead", options=options)
    return np.exp(result.x)


@settings(max_examples=40)
@given(st.floats(0.4, 2.5), st.floats(0.15, 1.0), st.integers(0, 10**6))
def test_fit_agrees_with_a_general_minimiser(median, dispersion, seed):
    probability = norm.cdf(np.log(INTENSITY / median) / dispersion)
    collapses = np.random.default_rng(seed).binomial(40, probability)
    fit = fit_fragility(INTENSITY, collapses, 40)
    if np.isnan(fit.median):  # separated
        assert np.flatnonzero(collapses > 0).min() >= np.flatnonzero(collapses < 40).max()
    else:
        np.testing.assert_allclose(fit[:2], most_likely(collapses, 40), rtol=1e-5)


@given(st.floats(0.4, 2.5), st.floats(0.4, 1.0), st.integers(0, 10**6))
def test_median_scales_with_the_unit_of_the_intensity(median, dispersion, seed):
    probability = norm.cdf(np.log(INTENSITY / median) / dispersion)
    collapses = np.random.default_rng(seed).binomial(40, probability)
    fit = fit_fragility(INTENSITY, collapses, 40)
    scaled = fit_fragility(9.81 * INTENSITY, collapses, 40)
    np.testing.assert_allclose(scaled[:2], [9.81 * fit.median, fit.dispersion], rtol=1e-8)


@pytest.mark.parametrize(
    ("collapses", "reason"),
    [
        ([0] * 12, "no record causes collapse"),
        ([20] * 12, "every record causes collapse"),
        ([0] * 6 + [20] * 6, "all records cause collapse from one intensity on, and none below it"),
        (
            [0] * 5 + [7] + [20] * 6,
            "at only one intensity do some records cause collapse and others not",
        ),
        (list(range(12, 0, -1)), "the share of collapses does not rise with intensity"),
        ([10] * 12, "the share of collapses does not rise with intensity"),
    ],
)
def test_counts_that_define_no_curve_say_why(collapses, reason):
    fit = fit_fragility(INTENSITY, [collapses, range(1, 13)], 20)
    np.testing.assert_array_equal(np.isnan([fit.median, fit.dispersion]), [[True, False]] * 2)
    assert fit.reason.tolist() == [f"no fragility curve: {reason}", ""]


def test_counts_without_runs_say_so():
    assert fit_fragility(INTENSITY, 0, 0).reason == "no fragility curve: there are no records"


def test_fit_that_does_not_converge_says_so():
    intensity = [0.1997, 0.2012, 0.2132, 0.3839, 1.332, 4.9917, 6.3175]
    fit = fit_fragility(intensity, [1, 2, 3, 3, 3, 3, 3], 3)
    assert fit.reason == "no fragility curve: the fit does not converge"
    assert np.isnan(fit.median)


def true_reasons(collapses, runs):
    """Every reason that is true of counts at three intensities, by its words."""
    share = np.array(collapses) / runs
    mixed = (share > 0) & (share < 1)
    reasons = set()
    if not any(share):
        reasons.add("no record causes collapse")
    if all(share == 1):
        reasons.add("every record causes collapse")
    if mixed.sum() == 1:
        reasons.add("at only one intensity do some records cause collapse and others not")
    if not mixed.any() and (np.diff(share) >= 0).all() and np.ptp(share) == 1:
        reasons.add("all records cause collapse from one intensity on, and none below it")
    if np.polyfit(np.arange(3), share, 1)[0] <= 1e-12:
        reasons.add("the share of collapses does not rise with intensity")
    return reasons


def test_reason_is_true_of_every_three_counts():
    for collapses in product(range(4), repeat=3):
        fit = fit_fragility([1.0, 2.0, 4.0], collapses, 3)
        reason = str(fit.reason).removeprefix("no fragility curve: ")
        assert (reason == "") == np.isfinite(fit.median), collapses
        assert reason in true_reasons(collapses, 3) | {""}, collapses


@pytest.mark.parametrize(
    ("name", "intensity", "collapses"),
    [
        ("collapses", [1, 2], [1, 3]),
        ("collapses", [1, 2], [1, -1]),
        ("intensity", [2, 1], [1, 1]),
        ("intensity", [0, 1], [1, 1]),
    ],
)
def test_impossible_count_or_intensity_is_refused(name, intensity, collapses):
    with pytest.raises(InputError, match=name):
        fit_fragility(intensity, collapses, 2)


# --- the bootstrap -----------------------------------------------------------------------------

GROUPS = ["a", "a", "b", "c", "c", "c"]


def test_stations_are_drawn_whole():
    weights = resample(GROUPS, 500, seed=3)
    np.testing.assert_array_equal(weights[:, [0, 3, 3]], weights[:, [1, 4, 5]])


def test_as_many_stations_are_drawn_as_there_are():
    weights = resample(GROUPS, 500, seed=3)
    np.testing.assert_array_equal(weights[:, [0, 2, 3]].sum(axis=1), 3)
    # Each is drawn once on average; its variance is that of a multinomial draw.
    assert weights[:, 0].mean() == pytest.approx(1.0, abs=4 * np.sqrt((1 - 1 / 3) / 500))


def test_draws_follow_the_seed():
    weights = resample(GROUPS, 500, seed=3)
    np.testing.assert_array_equal(weights, resample(GROUPS, 500, seed=3))
    assert (weights != resample(GROUPS, 500, seed=4)).any()


@given(st.lists(st.floats(-10, 10), max_size=9), st.integers(0, 1000))
def test_weighted_median_is_the_one_of_repeated_values(values, seed):
    values = np.array(values)
    random = np.random.default_rng(seed)
    record = random.integers(0, 6, values.size)
    weights = random.integers(0, 4, (5, 6)).astype(float)
    medians = weighted_quantile(values, record, weights, 0.5)
    for row, median in zip(weights, medians, strict=True):
        repeated = np.repeat(values, row[record].astype(int))
        expected = np.median(repeated) if repeated.size else np.nan
        assert median == pytest.approx(expected, abs=1e-12, nan_ok=True)


def test_interval_leaves_a_fortieth_out_on_either_side():
    replicates = np.random.default_rng(2).permutation(1001.0 * np.arange(1, 1002)).reshape(-1, 1)
    low, high = interval(replicates)[0]
    assert (replicates < low).mean() == pytest.approx(1 / 40, abs=1e-3)
    assert (replicates > high).mean() == pytest.approx(1 / 40, abs=1e-3)


@pytest.mark.parametrize(("undefined", "expected"), [(10, True), (11, False)])
def test_interval_needs_nine_in_ten_replicates(undefined, expected):
    replicates = np.arange(100.0)[:, None]
    replicates[:undefined] = np.nan
    assert np.isfinite(interval(replicates)).all() == expected


def test_bootstrap_interval_of_a_median_covers_it_as_often_as_it_says():
    """The 95 % intervals of 200 samples of a known lognormal hold its median in 95 % of them,
    within chance.
    """
    rng = np.random.default_rng(8)
    inside = 0
    for trial in range(200):
        collapsed = rng.lognormal(0.0, 0.4, 50)[:, None] <= INTENSITY
        weights = resample(np.arange(50), 200, seed=trial)
        medians = fit_fragility(INTENSITY, weights @ collapsed, 50.0).median
        low, high = np.quantile(medians, [0.025, 0.975])
        inside += low <= 1.0 <= high
    # 95 % less three standard deviations and the bias of the bootstrap.
    assert 0.88 * 200 <= inside <= 200


# --- proportions -------------------------------------------------------------------------------


@pytest.mark.parametrize(("successes", "trials"), [(0, 5), (1, 44), (22, 44), (44, 44), (3, 7)])
def test_ends_are_where_the_score_test_just_rejects(successes, trials):
    """|p_hat - p| = z sqrt(p (1 - p)/n) at both ends, solved by bisection."""
    share = successes / trials
    z = norm.ppf(0.975)

    def excess(p):
        return abs(share - p) - z * np.sqrt(p * (1 - p) / trials)

    low = brentq(excess, 1e-12, share - 1e-9) if successes else 0.0
    high = brentq(excess, share + 1e-9, 1 - 1e-12) if successes < trials else 1.0
    assert wilson(share, trials) == pytest.approx([low, high], abs=1e-9)


def coverage(bounds, share):
    return ((bounds[:, 0] <= share) & (share <= bounds[:, 1])).mean()


@pytest.mark.parametrize("share", [0.05, 0.3, 0.9])
def test_interval_covers_the_share_as_often_as_it_says(share):
    bounds = wilson(np.random.default_rng(5).binomial(44, share, 4000) / 44, 44)
    assert 0.92 < coverage(bounds, share) < 0.99


@pytest.mark.parametrize("agreement", [0.0, 0.5, 1.0])
def test_interval_of_pairs_covers_however_much_they_agree(agreement):
    """22 stations of two components, of which a part has the same outcome in both."""
    rng = np.random.default_rng(11)
    groups = np.repeat(np.arange(22), 2)
    share = 0.3
    first = rng.random((1000, 22)) < share
    second = np.where(rng.random((1000, 22)) < agreement, first, rng.random((1000, 22)) < share)
    outcomes = np.stack([first, second], axis=2).reshape(1000, 44).T
    bounds = wilson(outcomes.mean(axis=0), effective_count(outcomes, groups, 400, 3))
    assert 0.92 < coverage(bounds, share) < 0.99


def test_effective_count_is_kish_s():
    groups = np.repeat(np.arange(3), 4)
    outcomes = np.array([1, 1, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0], dtype=bool)
    p = outcomes.mean()
    group_shares = outcomes.reshape(3, 4).mean(axis=1)
    # The exact variance over bootstraps, times g/(g - 1).
    exact = p * (1 - p) / (group_shares.var() / 2)
    assert effective_count(outcomes, groups, 20000, 1) == pytest.approx(exact, rel=0.05)


def test_effective_count_lies_between_groups_and_trials():
    alike = np.repeat([True, False, False], 4)
    opposite = np.tile([True, False], 6)
    none = np.zeros(12, dtype=bool)
    outcomes = np.stack([alike, opposite, none, ~none], axis=1)
    groups = np.repeat(np.arange(3), 4)
    assert effective_count(outcomes, groups, 4000, 1).tolist() == [3, 12, 3, 3]
    assert effective_count(outcomes, np.arange(12), 100, 1).tolist() == [12] * 4
