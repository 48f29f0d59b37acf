"""Losses of impacts: their mean, scatter and law, against what made them and against the plain formulas."""

import numpy as np
import pytest

from rockdamp.laboratory.losses import LARGEST_LOSS, fit_law, law_of_loss, loss_at, regress

COUNT = 14
ONES = np.ones((COUNT, 1))
LOG_ENERGY = np.linspace(2.0, -2.0, COUNT)


def test_equal_errors_give_the_plain_mean():
    """REML's scatter is then the sample's deviation, and Hartung and Knapp's error the mean's."""
    losses = np.random.RandomState(0).normal(0.13, 0.02, COUNT)
    mean = regress(losses, 1e-12 * np.eye(COUNT), ONES)
    assert mean.coefficients[0] == pytest.approx(losses.mean())
    assert mean.scatter == pytest.approx(losses.std(ddof=1), rel=1e-3)
    assert np.sqrt(mean.covariance[0, 0]) == pytest.approx(
        losses.std(ddof=1) / np.sqrt(COUNT), rel=1e-3
    )


def test_without_scatter_generalised_least_squares():
    """Of neighbours whose errors share a peak, sum to sum: the first and the last peak decide."""
    steps = np.diff(np.eye(COUNT + 1), axis=0)
    covariance = 0.01**2 * steps @ steps.T
    losses = 0.13 + 0.01 * steps @ np.random.RandomState(1).standard_normal(COUNT + 1)
    mean = regress(losses, covariance, ONES)
    weights = np.linalg.solve(covariance, np.ones(COUNT))
    assert mean.scatter < 1e-4
    assert mean.coefficients[0] == pytest.approx(weights @ losses / weights.sum(), rel=1e-4)


@pytest.mark.parametrize("g", [-0.5, 0.0, 0.26, 0.5])
def test_law_of_the_losses_is_found(g):
    exact = law_of_loss(LOG_ENERGY, 0.1, g)
    point, _ = fit_law(exact, 1e-8 * np.eye(COUNT), LOG_ENERGY)
    np.testing.assert_allclose(point, [0.1, g], atol=1e-3)
    z = []
    for seed in range(30):
        noise = 0.01 * np.random.RandomState(seed).standard_normal(COUNT)
        point, covariance = fit_law(exact + noise, 1e-10 * np.eye(COUNT), LOG_ENERGY)
        z.append((point - [0.1, g]) / np.sqrt(np.diag(covariance)))
    assert np.all(np.abs(np.mean(z, axis=0)) < 0.6)
    np.testing.assert_allclose(np.std(z, axis=0), 1, atol=0.4)  # of 30, three standard errors


def test_loss_at_an_energy_and_its_error():
    noise, true = np.random.RandomState(4), law_of_loss(np.array([1.0]), 0.15, 0.26)[0]
    exact, found = law_of_loss(LOG_ENERGY, 0.15, 0.26), []
    for _ in range(40):
        losses = exact + 0.02 * noise.standard_normal(COUNT)
        found.append(loss_at(*fit_law(losses, 1e-10 * np.eye(COUNT), LOG_ENERGY), 1.0))
    loss, error = np.array(found).T
    assert np.mean(loss) == pytest.approx(true, abs=3 * np.std(loss) / np.sqrt(40))
    assert np.mean(error) == pytest.approx(np.std(loss), rel=0.3)


@pytest.mark.parametrize("g", [0.13, 0.26, 0.5])
def test_power_g_of_the_energy_falls_by_the_same_each_time(g):
    """E+^g = E-^g - K, with K = 1 - e_r^(2 g) where E_r = 1; without a power the loss is the same at each."""
    decrement, energy = -np.log(0.85), np.geomspace(0.2, 3.0, 9)
    left = energy * np.exp(-2 * law_of_loss(np.log(energy), decrement, g))
    np.testing.assert_allclose(energy**g - left**g, 1 - 0.85 ** (2 * g), rtol=1e-10)
    np.testing.assert_allclose(law_of_loss(np.log(energy), decrement, 0.0), decrement)
    assert (
        law_of_loss(np.array([-60.0]), decrement, g)[0] == LARGEST_LOSS
    )  # the impact stops the wall
