"""Posteriors by weighted draws, against densities of which all is known."""

from dataclasses import dataclass

import numpy as np
import pytest

from rockdamp.identification.importance import Weighted, explore
from rockdamp.identification.mixture import Mixture
from rockdamp.identification.modes import Mode

CENTRE = np.array([1.0, -2.0])
COVARIANCE = np.array([[2.0, 0.9], [0.9, 1.0]])
LOG_EVIDENCE = 123.4


def log_normal(points):
    away = points - CENTRE
    square = np.einsum("ni,ij,nj->n", away, np.linalg.inv(COVARIANCE), away)
    return LOG_EVIDENCE - 0.5 * (square + np.linalg.slogdet(2 * np.pi * COVARIANCE)[1])


@dataclass
class Bent:
    """A normal density along a parabola, whose evidence is that of the straight one; its modes are poorly known."""

    bend: float

    @property
    def modes(self):
        return [Mode(CENTRE + 0.5, np.linalg.cholesky(COVARIANCE) / 4, 0.0, np.arange(2))]

    def log_density(self, points):
        straight = points.copy()
        straight[:, 1] -= self.bend * (points[:, 0] - CENTRE[0]) ** 2
        return log_normal(straight)


@pytest.mark.parametrize("bend", [0.0, 0.4])
def test_the_evidence_is_the_integral_of_the_density_and_the_moments_are_its_own(bend):
    found = explore(Bent(bend), np.random.RandomState(3))
    assert found.good and found.evidence.standard_error < 0.05
    assert abs(found.evidence.logarithm - LOG_EVIDENCE) < 4 * found.evidence.standard_error
    straight = found.coordinates - [0.0, 1.0] * (bend * (found.coordinates[:, :1] - CENTRE[0]) ** 2)
    mean = found.weights @ straight
    np.testing.assert_allclose(mean, CENTRE, atol=4 * np.sqrt(2.0 / found.effective))
    covariance = np.einsum("n,ni,nj->ij", found.weights, straight - mean, straight - mean)
    np.testing.assert_allclose(covariance, COVARIANCE, atol=0.2)


def test_weights_with_a_heavy_tail_or_too_few_effective_draws_are_not_relied_on():
    random = np.random.RandomState(1)
    narrow = Mixture.alike(CENTRE[None], 0.02 * np.eye(2))
    points = narrow.draw(2000, random)
    assert not Weighted(points, log_normal(points) - narrow.log_density(points), narrow).good
    wide = Mixture.alike(CENTRE[None], 2 * np.eye(2))
    points = wide.draw(2000, random)
    assert Weighted(points, log_normal(points) - wide.log_density(points), wide).good
    assert not Weighted(points[:150], (log_normal(points) - wide.log_density(points))[:150], wide).good
