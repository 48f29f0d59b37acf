"""Restitution of blocks over Housner's and its spreads, on ratios whose spreads are known."""

from functools import partial

import numpy as np
import pytest
from scipy import stats

from rockdamp.laboratory.restitution_spread import restitution_spread
from rockdamp.laboratory.trials import Trials, power_law
from rockdamp.laboratory.trials_likelihood import (
    PLAIN_PARAMETERS,
    SEARCH_RANGES,
    Likelihood,
    TrialsFit,
    parameter_values,
)

ERRORS = {
    "noise": 0.03,
    "freedom": 1.0,
    "alternation": 1e-3,
    "lean": 0.0,
    "noise_deviation": 0.1,
    "growth": 1e-9,
    "centre": 0.0,
}


def housner_losses(*slendernesses):
    sine = np.sin(np.arctan(slendernesses))
    return -np.log(1.5 * sine**2 - 0.5)


def spread(ratio, geometry, housner, **parameters):
    """Return the spread of ratios by given parameters in place of fitted ones."""
    values = ERRORS | parameters
    point = []
    for name in list(SEARCH_RANGES)[:-1]:
        is_plain = name in PLAIN_PARAMETERS
        point.append(values[name] if is_plain else np.log(values[name]))
    law = partial(power_law, impacts=ratio.shape[1])
    likelihood = Likelihood(Trials(ratio, geometry, housner), law)
    nodes = likelihood.spread_nodes(parameter_values(np.array(point)))
    return restitution_spread(likelihood, TrialsFit(0.0, np.array(point), nodes))


@pytest.fixture(scope="module")
def two_blocks():
    """Ratios of two blocks, four trials each.

    ln e of the blocks is 0.02 off Housner's, ln e of the trials 0.012 off their block's. Every
    first ratio is 0.03 larger than e, as after a bad start.
    """
    geometry = np.repeat([0, 1], 4)
    block_offset = np.array([0.02, -0.02])[geometry]
    trial_offset = 0.012 * np.tile([1.0, -1.0], 4)
    log_e = -housner_losses(3.0, 4.0)[geometry] + block_offset + trial_offset
    ratio = np.repeat(np.exp(log_e)[:, None], 10, axis=1)
    ratio[:, 0] += 0.03
    return ratio


@pytest.fixture(scope="module")
def two_blocks_spread(two_blocks):
    geometry = np.repeat([0, 1], 4)
    return spread(two_blocks, geometry, housner_losses(3.0, 4.0), within=0.012, between=0.03)


def test_restitution_of_each_block_is_found(two_blocks_spread):
    _, ratios = two_blocks_spread["restitution_over_housner"]
    np.testing.assert_allclose(ratios, np.exp([0.02, -0.02]), atol=0.008)


def test_mean_over_the_blocks_is_that_of_housner(two_blocks_spread):
    assert two_blocks_spread["restitution_over_housner_mean"] == pytest.approx(1.0, abs=0.002)


def test_first_ratios_have_their_own_deviation(two_blocks, two_blocks_spread):
    expected = np.log(two_blocks[:, 0]).reshape(2, 4).std(axis=1).mean()
    assert two_blocks_spread["first_ratio_deviation_within"] == pytest.approx(expected, rel=0.01)


def test_deviations_are_those_within_and_between_blocks(two_blocks_spread):
    assert two_blocks_spread["deviation_within"] == pytest.approx(0.012, rel=0.05)
    assert two_blocks_spread["deviation_between"] == pytest.approx(0.03, rel=0.05)


def test_deviation_of_a_trial_has_both_parts(two_blocks_spread):
    _, deviations = two_blocks_spread["trial_deviation"]
    np.testing.assert_allclose(deviations, np.hypot(0.012, 0.03), rtol=0.05)


def test_blocks_that_lose_little_scatter_less():
    """A normal loss is cut off at 0: three deviations away at H/B = 4, a quarter of one at 15."""
    geometry = np.repeat([0, 1], 4)
    housner = housner_losses(4.0, 15.0)
    ratio = np.repeat(np.exp(-housner[geometry])[:, None], 10, axis=1)
    _, deviations = spread(ratio, geometry, housner, within=0.03, between=1e-3)["trial_deviation"]
    expected = [stats.truncnorm(-loss / 0.03, np.inf, scale=0.03).std() for loss in housner]
    np.testing.assert_allclose(deviations, expected, rtol=0.02)


@pytest.mark.parametrize(
    ("name", "deviation"), [("restitution", 0.004), ("trial", np.hypot(0.03, 0.004))]
)
def test_intervals_hold_90_per_cent(name, deviation):
    """Trials without information, as their noise is huge: 1.645 deviations of the prior."""
    ratio = np.full((4, 2), 0.85)
    variables = spread(
        ratio, np.zeros(4, int), np.array([0.16]), noise=5.0, within=0.03, between=0.004
    )
    _, intervals = variables[f"{name}_over_housner_interval"]
    bounds = np.log(intervals[0])
    np.testing.assert_allclose(bounds, [-1.645 * deviation, 1.645 * deviation], rtol=0.03)
