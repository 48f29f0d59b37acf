"""The density of residuals under the instruments' errors, against dense matrices."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from rockdamp.laboratory.noise import Noise, correlated

SAMPLES = 40
RANDOM = np.random.RandomState(3)
ROWS = np.stack([np.ones(SAMPLES), np.linspace(0, 1, SAMPLES), np.sin(np.arange(SAMPLES) / 5)]) * [[0.5], [0.3], [0.2]]
DEVIATION, CORRELATION = np.array([0.1, 0.4]), np.array([0.0, 0.8])
RESIDUALS = RANDOM.standard_normal((2, SAMPLES))


def dense(deviation, correlation):
    lags = np.abs(np.subtract.outer(np.arange(SAMPLES), np.arange(SAMPLES)))
    return deviation**2 * correlation**lags


def test_the_density_is_that_of_the_dense_covariance():
    found = Noise(ROWS).log_likelihood(RESIDUALS, DEVIATION, CORRELATION)
    for value, residual, sigma, phi in zip(found, RESIDUALS, DEVIATION, CORRELATION, strict=True):
        whole = dense(sigma, phi) + ROWS.T @ ROWS
        assert value == pytest.approx(multivariate_normal(cov=whole).logpdf(residual), rel=1e-9)


def test_residuals_are_multiplied_by_the_inverse_of_the_dense_covariance():
    found = Noise(ROWS).by_inverse(RESIDUALS, DEVIATION, CORRELATION)
    for product, residual, sigma, phi in zip(found, RESIDUALS, DEVIATION, CORRELATION, strict=True):
        np.testing.assert_allclose((dense(sigma, phi) + ROWS.T @ ROWS) @ product, residual, atol=1e-9)


def test_what_is_linear_is_drawn_from_its_conditional_distribution():
    sigma, phi, many = 0.4, 0.8, 4000
    repeated = np.repeat(RESIDUALS[1:], many, axis=0)
    drawn = Noise(ROWS).draw(repeated, np.full(many, sigma), np.full(many, phi), np.random.RandomState(0))
    gain = ROWS @ np.linalg.inv(dense(sigma, phi) + ROWS.T @ ROWS)
    covariance = np.eye(3) - gain @ ROWS.T
    error = np.sqrt(np.diag(covariance) / many)
    assert np.all(np.abs(drawn.mean(axis=0) - gain @ RESIDUALS[1]) < 5 * error)
    np.testing.assert_allclose(np.cov(drawn.T), covariance, atol=0.1 * np.diag(covariance).max())


def test_noise_has_the_deviation_and_correlation_that_were_asked_for():
    noise = correlated(2.0, 0.7, np.random.RandomState(5).standard_normal(20_000))
    assert noise.std() == pytest.approx(2.0, rel=0.05)
    assert np.corrcoef(noise[1:], noise[:-1])[0, 1] == pytest.approx(0.7, abs=0.02)
