"""Losses of impacts: their mean, scatter and law, against their truth and the plain formulas."""

import numpy as np
import pytest

from rockdamp.laboratory.losses import STOPPING_LOSS, fit_law, law_of_loss, loss_at, regress

COUNT = 14
ONES = np.ones((COUNT, 1))
LOG_ENERGY = np.linspace(2.0, -2.0, COUNT)
SENSOR = 1e-10 * np.eye(COUNT)  # covariance of an almost exact sensor


# --- mean and scatter -----------------------------------------------------------------------------


@pytest.fixture
def losses():
    return np.random.RandomState(0).normal(0.13, 0.02, COUNT)


def test_equal_errors_give_the_plain_mean(losses):
    mean = regress(losses, SENSOR, ONES)
    assert mean.coefficients[0] == pytest.approx(losses.mean())


def test_scatter_is_the_deviation_of_the_sample(losses):
    """The restricted likelihood has no bias."""
    scatter = regress(losses, SENSOR, ONES).scatter
    assert scatter == pytest.approx(losses.std(ddof=1), rel=1e-3)


def test_error_of_the_mean_is_the_plain_one(losses):
    variance = regress(losses, SENSOR, ONES).covariance[0, 0]
    expected = losses.std(ddof=1) / np.sqrt(COUNT)
    assert np.sqrt(variance) == pytest.approx(expected, rel=1e-3)


def test_mean_without_scatter_is_weighted():
    """If neighbours share the error of a peak, the sum depends on the first and the last peak."""
    steps = np.diff(np.eye(COUNT + 1), axis=0)
    covariance = 0.01**2 * steps @ steps.T
    losses = 0.13 + 0.01 * steps @ np.random.RandomState(1).standard_normal(COUNT + 1)
    mean = regress(losses, covariance, ONES)
    weights = np.linalg.solve(covariance, np.ones(COUNT))
    assert mean.scatter < 1e-4
    assert mean.coefficients[0] == pytest.approx(weights @ losses / weights.sum(), rel=1e-4)


# --- law of the losses ----------------------------------------------------------------------------


@pytest.mark.parametrize("g", [-0.5, 0.0, 0.26, 0.5])
def test_law_of_exact_losses_is_found(g):
    point, _ = fit_law(law_of_loss(LOG_ENERGY, 0.1, g), 1e-8 * np.eye(COUNT), LOG_ENERGY)
    np.testing.assert_allclose(point, [0.1, g], atol=1e-3)


@pytest.mark.parametrize("g", [-0.5, 0.0, 0.26, 0.5])
def test_errors_of_the_law_are_those_of_its_fits(g):
    exact = law_of_loss(LOG_ENERGY, 0.1, g)
    scores = []
    for seed in range(30):
        noise = 0.01 * np.random.RandomState(seed).standard_normal(COUNT)
        point, covariance = fit_law(exact + noise, SENSOR, LOG_ENERGY)
        scores.append((point - [0.1, g]) / np.sqrt(np.diag(covariance)))
    assert np.all(np.abs(np.mean(scores, axis=0)) < 0.6)
    np.testing.assert_allclose(np.std(scores, axis=0), 1, atol=0.4)  # three standard errors


@pytest.fixture(scope="module")
def predictions():
    """Loss at an energy and its error, by forty fits of noisy losses; shape (2, 40)."""
    random = np.random.RandomState(4)
    exact = law_of_loss(LOG_ENERGY, 0.15, 0.26)
    rows = []
    for _ in range(40):
        losses = exact + 0.02 * random.standard_normal(COUNT)
        point, covariance = fit_law(losses, SENSOR, LOG_ENERGY)
        rows.append(loss_at(point, covariance, 1.0))
    return np.transpose(rows)


def test_loss_at_an_energy_is_found(predictions):
    losses, _ = predictions
    expected = law_of_loss(np.array([1.0]), 0.15, 0.26)[0]
    assert np.mean(losses) == pytest.approx(expected, abs=3 * np.std(losses) / np.sqrt(40))


def test_error_of_a_loss_is_its_deviation(predictions):
    losses, errors = predictions
    assert np.mean(errors) == pytest.approx(np.std(losses), rel=0.3)


@pytest.mark.parametrize("g", [0.13, 0.26, 0.5])
def test_power_of_the_energy_falls_by_the_same(g):
    """E+^g = E-^g - K, with K = 1 - e_r^(2 g) where E_r = 1."""
    energy = np.geomspace(0.2, 3.0, 9)
    remaining = energy * np.exp(-2 * law_of_loss(np.log(energy), -np.log(0.85), g))
    np.testing.assert_allclose(energy**g - remaining**g, 1 - 0.85 ** (2 * g), rtol=1e-10)


def test_loss_without_a_power_is_constant():
    np.testing.assert_allclose(law_of_loss(LOG_ENERGY, 0.16, 0.0), 0.16)


@pytest.mark.parametrize("g", [0.13, 0.26, 0.5])
def test_impact_of_a_small_energy_stops_the_wall(g):
    assert law_of_loss(np.array([-60.0]), 0.16, g)[0] == STOPPING_LOSS
