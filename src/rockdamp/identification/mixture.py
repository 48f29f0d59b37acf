"""Mixtures of multivariate t distributions: what is drawn from in place of a posterior, and fitted to its draws."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import gammaln, logsumexp

from rockdamp.arrays import Array

HEAVY = 5.0  # degrees of freedom of the tails
LEAST_SHARE = 1e-3  # of a component: a smaller one is left out
FIRMNESS = 1e-6  # added to a covariance's diagonal, of itself, so that few points leave it positive


@dataclass(frozen=True)
class Mixture:
    """Components with shares, centres and scales, all with the same heavy tails.

    Parameters
    ----------
    share : ndarray, shape (components,)
        Their sum is 1. [-]
    centre : ndarray, shape (components, dimensions)
    lower : ndarray, shape (components, dimensions, dimensions)
        Lower triangular roots of the scale matrices.
    """

    share: Array
    centre: Array
    lower: Array

    @classmethod
    def alike(cls, centre: Array, lower: Array) -> Mixture:
        """Return components of one scale, with equal shares, about several centres."""
        count = len(centre)
        return cls(np.full(count, 1 / count), centre, np.broadcast_to(lower, (count, *lower.shape)))

    def draw(self, count: int, random: np.random.RandomState) -> Array:
        """Draw points, shape (count, dimensions)."""
        of = random.choice(self.share.size, count, p=self.share)
        normal = random.standard_normal((count, self.centre.shape[1]))
        stretch = np.sqrt(random.chisquare(HEAVY, count) / HEAVY)
        return self.centre[of] + np.einsum("nij,nj->ni", self.lower[of], normal) / stretch[:, None]

    def log_density(self, points: Array) -> Array:
        """Return the logarithm of the density at points, shape (points,)."""
        return np.asarray(logsumexp(self._parts(points)[0], axis=0), dtype=float)

    def _parts(self, points: Array) -> tuple[Array, Array]:
        """Logarithms of each component's part of the density, and squared distances; shape (components, points)."""
        dimensions = self.centre.shape[1]
        away = points[None] - self.centre[:, None]
        inverse = np.linalg.inv(self.lower)
        standard = np.einsum("kij,knj->kni", inverse, away)
        square = np.einsum("kni,kni->kn", standard, standard)
        constant = gammaln((HEAVY + dimensions) / 2) - gammaln(HEAVY / 2) - dimensions / 2 * np.log(HEAVY * np.pi)
        roots = np.log(np.diagonal(self.lower, axis1=1, axis2=2)).sum(axis=1)
        constants = constant - roots + np.log(self.share)
        return constants[:, None] - (HEAVY + dimensions) / 2 * np.log1p(square / HEAVY), square

    def fitted(self, points: Array, weights: Array) -> Mixture:
        """Return the mixture after one step of expectation and maximisation to weighted points.

        The step of Cappé et al. (2008, doi:10.1007/s11222-008-9059-x): it brings the mixture nearer, in the divergence
        of Kullback and Leibler, to what the weighted points are a sample of.
        """
        dimensions = self.centre.shape[1]
        parts, square = self._parts(points)
        own = weights * np.exp(parts - logsumexp(parts, axis=0))
        share = own.sum(axis=1)
        kept = share > LEAST_SHARE * share.sum()
        own, share = own[kept], share[kept]
        pull = own * (HEAVY + dimensions) / (HEAVY + square[kept])
        centre = np.einsum("kn,ni->ki", pull, points) / pull.sum(axis=1)[:, None]
        away = points[None] - centre[:, None]
        scale = np.einsum("kn,kni,knj->kij", pull, away, away) / share[:, None, None]
        whole = np.einsum("n,ni->i", weights, points**2) / weights.sum()
        whole = whole - (np.einsum("n,ni->i", weights, points) / weights.sum()) ** 2
        scale = scale + FIRMNESS * np.diag(whole + np.finfo(float).tiny)
        return Mixture(share / share.sum(), centre, np.linalg.cholesky(scale))
