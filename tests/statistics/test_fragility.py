"""Lognormal fragilities against a general minimiser and known curves, and the bootstrap that bounds them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.stats import norm

from rockdamp.errors import InputError
from rockdamp.statistics.fragility import fit_fragility, interval, resample, weighted_quantile

INTENSITY = np.geomspace(0.2, 5.0, 12)


def probability(median, dispersion):
    return norm.cdf(np.log(INTENSITY / median) / dispersion)


def most_likely(collapses, runs):
    """The same maximum by a general minimiser over (ln median, ln dispersion)."""

    def minus(parameters):
        median, dispersion = np.exp(parameters)
        z = np.log(INTENSITY / median) / dispersion
        return -(collapses * norm.logcdf(z) + (runs - collapses) * norm.logsf(z)).sum()

    found = minimize(minus, [0.0, np.log(0.5)], method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 1e-13})
    return np.exp(found.x)


@given(st.floats(0.4, 2.5), st.floats(0.15, 1.0), st.integers(0, 10**6))
def test_the_curve_is_the_one_a_general_minimiser_finds(median, dispersion, seed):
    collapses = np.random.default_rng(seed).binomial(40, probability(median, dispersion))
    found = fit_fragility(INTENSITY, collapses, 40)
    if np.isnan(found.median):  # separated
        assert np.flatnonzero(collapses > 0).min() >= np.flatnonzero(collapses < 40).max()
    else:
        np.testing.assert_allclose([found.median, found.dispersion], most_likely(collapses, 40), rtol=1e-5)


def test_an_intensity_in_another_unit_moves_the_median_alone():
    counts = np.array([0, 0, 1, 2, 4, 5, 9, 14, 18, 20, 20, 20])
    one, other = fit_fragility(INTENSITY, counts, 20), fit_fragility(9.81 * INTENSITY, counts, 20)
    assert other.median == pytest.approx(9.81 * one.median, rel=1e-9)
    assert other.dispersion == pytest.approx(one.dispersion, rel=1e-9)


@pytest.mark.parametrize(
    "counts",
    [
        [0] * 12,
        [20] * 12,
        [0] * 6 + [20] * 6,
        [0] * 5 + [7] + [20] * 6,
        list(range(12, 0, -1)),
    ],
    ids=["no collapse", "all collapse", "separated", "one mixed stripe", "fewer with intensity"],
)
@pytest.mark.filterwarnings("ignore:collapses become fewer")
def test_outcomes_that_define_no_curve_give_none(counts):
    found = fit_fragility(INTENSITY, counts, 20)
    assert np.isnan(found.median) and np.isnan(found.dispersion)


def test_impossible_counts_and_intensities_are_refused():
    with pytest.raises(InputError, match=r"collapses is 3.0; it must be .* at most the number of runs"):
        fit_fragility([1.0, 2.0], [1, 3], 2)
    with pytest.raises(InputError, match="ascending"):
        fit_fragility([2.0, 1.0], [1, 1], 2)
    with pytest.raises(InputError, match="intensity"):
        fit_fragility([0.0, 1.0], [1, 1], 2)


def test_stations_are_drawn_whole_and_as_often_as_there_are_stations():
    groups = ["a", "a", "b", "c", "c", "c"]
    weights = resample(groups, 500, seed=3)
    np.testing.assert_array_equal(weights[:, 0], weights[:, 1])
    np.testing.assert_array_equal(weights[:, 3], weights[:, 5])
    np.testing.assert_array_equal(weights[:, [0, 2, 3]].sum(axis=1), 3)
    np.testing.assert_array_equal(weights, resample(groups, 500, seed=3))
    assert (weights != resample(groups, 500, seed=4)).any()
    # Each is drawn once on average; its variance is that of a multinomial draw.
    assert weights[:, 0].mean() == pytest.approx(1.0, abs=4 * np.sqrt((1 - 1 / 3) / 500))


@given(st.lists(st.floats(-10, 10), max_size=9), st.integers(0, 1000))
def test_the_weighted_median_is_that_of_the_repeated_values(values, seed):
    values, random = np.array(values), np.random.default_rng(seed)
    record, weights = random.integers(0, 6, values.size), random.integers(0, 4, (5, 6)).astype(float)
    found = weighted_quantile(values, record, weights, 0.5)
    for row, median in zip(weights, found, strict=True):
        repeated = np.repeat(values, row[record].astype(int))
        if repeated.size:
            assert median == pytest.approx(np.median(repeated), abs=1e-12)
        else:
            assert np.isnan(median)


def test_an_interval_leaves_a_fortieth_of_the_replicates_out_on_either_side():
    drawn = np.random.default_rng(2).permutation(1001.0 * np.arange(1, 1002)).reshape(-1, 1)
    low, high = interval(drawn)[0]
    assert (drawn < low).mean() == pytest.approx(1 / 40, abs=1e-3)
    assert (drawn > high).mean() == pytest.approx(1 / 40, abs=1e-3)


def test_an_interval_of_too_few_replicates_that_define_a_value_is_none():
    drawn = np.arange(100.0)[:, None] * np.ones(2)
    drawn[:10, 0] = drawn[:11, 1] = np.nan
    assert np.isfinite(interval(drawn)[0]).all() and np.isnan(interval(drawn)[1]).all()


def test_the_bootstrap_interval_of_a_median_covers_it_as_often_as_it_says():
    """Two hundred samples of a known lognormal: 95 % intervals must hold its median in 95 % of them, within chance."""
    rng, inside = np.random.default_rng(8), 0
    for trial in range(200):
        capacity = rng.lognormal(0.0, 0.4, 50)
        collapsed = capacity[:, None] <= INTENSITY
        weights = resample(np.arange(50), 200, seed=trial)
        drawn = fit_fragility(INTENSITY, weights @ collapsed, 50.0).median
        low, high = np.quantile(drawn, [0.025, 0.975])
        inside += low <= 1.0 <= high
    assert 0.88 * 200 <= inside <= 200  # 95 % less three standard deviations and the bootstrap's own bias
