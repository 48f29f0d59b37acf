"""Draws and evidence by nested sampling, against densities of which all is known."""

import builtins

import numpy as np
import pytest

from rockdamp.errors import InputError
from rockdamp.laboratory import sampler
from rockdamp.laboratory.sampler import Neighbourhood, sample

CENTRE = np.array([0.4, 0.6])
COVARIANCE = np.array([[2.0, 0.9], [0.9, 1.0]]) * 1e-4
LOG_EVIDENCE = 123.4
ABOUT = Neighbourhood(CENTRE + 0.01, 1.5 * np.linalg.cholesky(COVARIANCE))  # a poor guess


def log_normal(points, centre=CENTRE):
    away = points - centre
    square = np.einsum("ni,ij,nj->n", away, np.linalg.inv(COVARIANCE), away)
    return LOG_EVIDENCE - 0.5 * (square + np.linalg.slogdet(2 * np.pi * COVARIANCE)[1])


@pytest.mark.parametrize("good", [sampler.GOOD, 2.0])  # the latter no guess is: draws close in
@pytest.mark.parametrize("bend", [0.0, 20.0])
def test_the_evidence_is_the_integral_of_the_density_and_the_moments_are_its_own(bend, good, monkeypatch):
    """A normal density along a parabola has the evidence of the straight one."""
    monkeypatch.setattr(sampler, "GOOD", good)

    def straightened(points):
        straight = points.copy()
        straight[:, 1] -= bend * (points[:, 0] - CENTRE[0]) ** 2
        return straight

    draws = sample(lambda points: log_normal(straightened(points)), ABOUT, 1000, 3)
    assert draws.effective >= 1000 and draws.error < 0.04
    assert draws.log_evidence == pytest.approx(LOG_EVIDENCE, abs=4 * draws.error)
    straight = straightened(draws.points)
    mean = draws.weights @ straight
    np.testing.assert_allclose(mean, CENTRE, atol=4 * np.sqrt(2e-4 / draws.effective))
    covariance = np.einsum("n,ni,nj->ij", draws.weights, straight - mean, straight - mean)
    np.testing.assert_allclose(covariance, COVARIANCE, atol=0.25e-4)
    np.testing.assert_allclose(draws.log_density, log_normal(straight))


def test_a_density_at_a_bound_is_cut_off_there():
    def at_bound(points):
        return np.where(points[:, 0] > 0, log_normal(points, np.array([0.0, 0.5])), -np.inf)

    draws = sample(at_bound, Neighbourhood(np.array([0.001, 0.5]), np.linalg.cholesky(COVARIANCE)), 2000, 3)
    assert draws.log_evidence == pytest.approx(LOG_EVIDENCE + np.log(0.5), abs=4 * draws.error)
    assert draws.points.min() > 0


def test_the_neighbourhood_is_a_distribution_inside_the_cube():
    """Its density, from the map's own, is the inverse of the map's Jacobian: areas of small squares tell that."""
    about = Neighbourhood(np.array([0.98, 0.5]), np.array([[0.05, 0.0], [0.1, 0.1]]))
    cube, side = np.random.RandomState(0).uniform(0.05, 0.95, (50, 2)), 1e-6
    points, log_density = about.points(cube)
    assert np.all((points > 0) & (points < 1))
    right, up = (about.points(cube + side * np.eye(2)[axis])[0] - points for axis in (0, 1))
    area = np.abs(right[:, 0] * up[:, 1] - right[:, 1] * up[:, 0]) / side**2
    np.testing.assert_allclose(np.exp(-log_density), area, rtol=1e-3)


def test_the_same_seed_gives_the_same_draws_and_another_one_others():
    once, again, other = (sample(log_normal, ABOUT, 300, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(once.points, again.points)
    assert once.log_evidence == again.log_evidence != other.log_evidence


def test_a_posterior_that_takes_too_long_is_refused(monkeypatch):
    monkeypatch.setattr(sampler, "MOST", 100)
    monkeypatch.setattr(sampler, "MOST_A_DRAW", 0.1)
    with pytest.raises(InputError, match="600 likelihoods do not suffice"):
        sample(log_normal, ABOUT, 5000, 1)


def test_the_package_that_a_posterior_needs_is_named_where_it_is_missing(monkeypatch):
    imported = builtins.__import__

    def without(name, *rest):
        if name == "nautilus":
            raise ImportError
        return imported(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(InputError, match="pip install nautilus-sampler"):
        sampler.nautilus()
