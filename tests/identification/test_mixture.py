"""Mixtures of t distributions: their density, and how they are fitted."""

import numpy as np
import pytest
from scipy.stats import multivariate_t

from rockdamp.identification.mixture import HEAVY, Mixture

CENTRES = np.array([[0.0, 0.0], [6.0, 1.0]])
LOWER = np.array([[[1.0, 0.0], [0.5, 0.8]], [[0.6, 0.0], [-0.2, 0.4]]])
MIXTURE = Mixture(np.array([0.3, 0.7]), CENTRES, LOWER)


def test_the_density_is_the_sum_of_the_components():
    points = np.random.RandomState(0).standard_normal((50, 2)) * 4
    parts = [
        share * multivariate_t(centre, lower @ lower.T, HEAVY).pdf(points)
        for share, centre, lower in zip(MIXTURE.share, MIXTURE.centre, MIXTURE.lower, strict=True)
    ]
    np.testing.assert_allclose(np.exp(MIXTURE.log_density(points)), sum(parts), rtol=1e-10)


def test_a_mixture_is_fitted_to_draws_of_another_one():
    points = MIXTURE.draw(8000, np.random.RandomState(1))
    found = Mixture.alike(np.array([[1.0, -1.0], [4.0, 2.0]]), np.eye(2))
    for _ in range(25):
        found = found.fitted(points, np.full(len(points), 1 / len(points)))
    assert found.share == pytest.approx(MIXTURE.share, abs=0.02)
    np.testing.assert_allclose(found.centre, CENTRES, atol=0.1)
    scales, made = (lower @ lower.swapaxes(1, 2) for lower in (found.lower, LOWER))
    np.testing.assert_allclose(scales, made, atol=0.1)
