"""The interval of a share against its equation, its coverage, and groups whose members agree or do not."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.stats import norm

from rockdamp.statistics.fragility import effective_count, wilson


@pytest.mark.parametrize(("counted", "trials"), [(0, 5), (1, 44), (22, 44), (44, 44), (3, 7)])
def test_the_ends_are_where_the_score_test_just_rejects(counted, trials):
    """|p_hat - p| = z sqrt(p (1 - p)/n) at both ends, solved by bisection."""
    share, z = counted / trials, norm.ppf(0.975)
    low, high = wilson(share, trials)

    def excess(p):
        return abs(share - p) - z * np.sqrt(p * (1 - p) / trials)

    assert low == pytest.approx(brentq(excess, 1e-12, share - 1e-9) if counted else 0.0, abs=1e-9)
    assert high == pytest.approx(brentq(excess, share + 1e-9, 1 - 1e-12) if counted < trials else 1.0, abs=1e-9)


def test_the_interval_covers_the_share_as_often_as_it_says():
    rng = np.random.default_rng(5)
    for share in (0.05, 0.3, 0.5, 0.9):
        bounds = wilson(rng.binomial(44, share, 4000) / 44, 44)
        covered = ((bounds[:, 0] <= share) & (share <= bounds[:, 1])).mean()
        assert 0.92 < covered < 0.99, share


def test_components_that_agree_count_as_their_stations_and_opposite_ones_as_all():
    groups = np.repeat(np.arange(20), 2)
    alike = np.repeat(np.arange(20) < 8, 2)
    opposite = np.tile([True, False], 20)
    both = effective_count(np.stack([alike, opposite], axis=1), groups, 4000, 1)
    assert both[0] == pytest.approx(20, rel=0.05)
    assert both[1] == 40


def test_where_none_or_all_are_counted_the_stations_count():
    counted = np.stack([np.zeros(6, bool), np.ones(6, bool)], axis=1)
    assert effective_count(counted, [1, 1, 2, 2, 3, 3], 100, 1).tolist() == [3, 3]


@pytest.mark.parametrize("agreement", [0.0, 0.5, 1.0])
def test_the_interval_of_pairs_covers_however_much_they_agree(agreement):
    """22 stations of two components, of which a part has the same outcome in both."""
    rng, groups, share = np.random.default_rng(11), np.repeat(np.arange(22), 2), 0.3
    first = rng.random((1000, 22)) < share
    second = np.where(rng.random((1000, 22)) < agreement, first, rng.random((1000, 22)) < share)
    counted = np.stack([first, second], axis=2).reshape(1000, 44).T
    bounds = wilson(counted.mean(axis=0), effective_count(counted, groups, 400, 3))
    covered = ((bounds[:, 0] <= share) & (share <= bounds[:, 1])).mean()
    assert 0.92 < covered < 0.99


def test_of_few_groups_the_variance_of_the_bootstrap_is_too_small_by_what_theory_says():
    """Three stations that agree, of the outcomes 1, 0, 0: Kish's count from the exact variance, p (1 - p)/(g - 1)."""
    groups, outcome = np.repeat(np.arange(3), 4), np.repeat([True, False, False], 4)
    # The exact variance of the mean over bootstraps of g groups is p (1 - p)/g, times g/(g - 1).
    assert effective_count(outcome, groups, 20000, 1) == 3  # (g - 1) of the formula, never fewer than the groups
    mixed = np.array([1, 1, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0], dtype=bool)
    p, of_group = mixed.mean(), mixed.reshape(3, 4).mean(axis=1)
    exact = p * (1 - p) / (of_group.var() / 2)
    assert effective_count(mixed, groups, 20000, 1) == pytest.approx(exact, rel=0.05)


def test_an_interval_of_all_or_none_reaches_no_further_than_the_rule_of_the_score_test():
    """Where every trial counts the lower end is n/(n + z^2), where none does the upper one is z^2/(n + z^2)."""
    z = norm.ppf(0.975) ** 2
    for n in (1, 10, 44):
        assert wilson(1.0, n) == pytest.approx([n / (n + z), 1.0])
        assert wilson(0.0, n) == pytest.approx([0.0, z / (n + z)])


def test_the_interval_of_none_begins_at_none_and_that_of_all_ends_at_all():
    bounds = wilson([[0.0], [1.0]], np.linspace(1, 100, 1000))
    assert not bounds[0, :, 0].any() and (bounds[1, :, 1] == 1).all()
