"""Losses of impacts: their mean, scatter and exponent, against what made them and against the plain formulas."""

import numpy as np
import pytest
from scipy.stats import t as student

from rockdamp.laboratory.excursions import Losses, exponent_of, law_of_loss, restitution_at

COUNT = 14
LOG_ENERGY = np.linspace(-1.0, -5.0, COUNT)


def test_with_equal_errors_the_mean_is_the_plain_mean_with_students_interval():
    """REML's scatter is then the sample's deviation, and Hartung and Knapp's error that of the mean."""
    decrement = np.random.RandomState(0).normal(0.13, 0.02, COUNT)
    losses = Losses(decrement, 1e-12 * np.eye(COUNT))
    line = losses.line(np.ones(COUNT))
    assert line.decrement == pytest.approx(decrement.mean())
    assert line.scatter == pytest.approx(decrement.std(ddof=1), rel=1e-3)
    assert line.standard_error == pytest.approx(decrement.std(ddof=1) / np.sqrt(COUNT), rel=1e-3)
    assert losses.quantile == pytest.approx(student.ppf(0.95, COUNT - 1))


def test_without_scatter_the_mean_is_that_of_generalised_least_squares():
    """Of neighbours whose errors share a peak, sum to sum: the first and the last peak decide."""
    steps = np.diff(np.eye(COUNT + 1), axis=0)
    covariance = 0.01**2 * steps @ steps.T
    decrement = 0.13 + 0.01 * steps @ np.random.RandomState(1).standard_normal(COUNT + 1)
    line = Losses(decrement, covariance).line(np.ones(COUNT))
    weights = np.linalg.solve(covariance, np.ones(COUNT))
    assert line.scatter < 1e-4
    assert line.decrement == pytest.approx(weights @ decrement / weights.sum(), rel=1e-4)


@pytest.mark.parametrize("g", [-0.5, 0.0, 0.26, 0.5])
def test_the_exponent_is_that_of_the_law_which_made_the_losses(g):
    exact = law_of_loss(LOG_ENERGY - LOG_ENERGY.mean(), 0.1, g)
    noise = 0.004 * np.random.RandomState(2).standard_normal(COUNT)
    _, (low, high) = exponent_of(Losses(exact + noise, 1e-10 * np.eye(COUNT)), LOG_ENERGY)
    assert low < g < high and high - low < 0.2
    exactly, _ = exponent_of(Losses(exact, 1e-8 * np.eye(COUNT)), LOG_ENERGY)
    assert exactly == pytest.approx(g, abs=1e-3)
    slope = -np.polyfit(LOG_ENERGY, np.log(exact), 1)[0]
    assert -1e-9 < slope - g < 0.2 * abs(g) + 1e-9  # of a loss in proportion to a power of the energy: another


def test_an_exponent_that_losses_do_not_tell_has_no_end():
    noise = 0.5 * np.random.RandomState(3).standard_normal(4)
    _, ends = exponent_of(Losses(0.05 + noise, 1e-6 * np.eye(4)), LOG_ENERGY[:4] / 10)
    assert np.isnan(ends).all()


@pytest.mark.parametrize("g", [0.13, 0.26, 0.5])
def test_the_energy_left_to_the_power_g_falls_by_the_same_at_each_impact(g):
    """E+^g = E-^g - K, with K = 1 - e_r^(2 g) where E_r = 1; without a power the loss is the same at each."""
    decrement = -np.log(0.85)
    energy = np.geomspace(0.2, 3.0, 9)
    left = energy * np.exp(-2 * law_of_loss(np.log(energy), decrement, g))
    np.testing.assert_allclose(energy**g - left**g, 1 - 0.85 ** (2 * g), rtol=1e-10)
    np.testing.assert_allclose(law_of_loss(np.log(energy), decrement, 0.0), decrement)
    assert law_of_loss(np.array([-60.0]), decrement, g)[0] == np.inf  # the impact stops the wall


def test_e_at_an_energy_is_that_of_the_law_which_made_the_losses():
    exact = law_of_loss(LOG_ENERGY + 2.0, 0.15, 0.26)
    for at in (-1.0, -2.0, -3.0):
        true = float(np.exp(-law_of_loss(np.array([at + 2.0]), 0.15, 0.26)[0]))
        assert restitution_at(Losses(exact, 1e-8 * np.eye(COUNT)), LOG_ENERGY, at)[0] == pytest.approx(true, abs=2e-4)
        noisy = exact + 0.02 * np.random.RandomState(4).standard_normal(COUNT)
        _, (low, high) = restitution_at(Losses(noisy, 1e-8 * np.eye(COUNT)), LOG_ENERGY, at)
        assert low < true < high and 0.005 < high - low < 0.1
