"""How well each model explains a record: the evidence, the likelihood averaged over the prior."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import gammaln, logsumexp

from rockdamp.arrays import Array
from rockdamp.studies.identification.posterior import Draws, Problem, array_statistics

POINTS, BATCH = 2048, 256  # of the importance sample; computed at once
HEAVY = 5.0  # degrees of freedom of the sample's tails
WIDER = 1.3  # of its covariance over that of the draws
HIGHEST_K_HAT = 0.7  # of Pareto's shape: beyond, the average is not to be relied on (Vehtari et al., arXiv:1507.02646)


@dataclass(frozen=True)
class Evidence:
    """The logarithm of the evidence by importance sampling, its standard error, and Pareto's k-hat of the weights."""

    logarithm: float
    standard_error: float
    k_hat: float

    @property
    def good(self) -> bool:
        """Whether the weights are light enough for the average to be relied on."""
        return self.k_hat <= HIGHEST_K_HAT


def evidence(problem: Problem, draws: Draws, seed: int) -> Evidence:
    """Estimate the evidence, by importance sampling from a multivariate t about the draws of the posterior."""
    random = np.random.RandomState(seed)
    flat = draws.flat
    dimensions = flat.shape[1]
    centre = flat.mean(axis=0)
    away = flat - centre
    lower = np.linalg.cholesky(WIDER * np.einsum("ni,nj->ij", away, away) / len(away))
    normal = random.standard_normal((POINTS, dimensions))
    points = centre + np.einsum("nj,ij->ni", normal, lower) / np.sqrt(random.chisquare(HEAVY, POINTS) / HEAVY)[:, None]
    density = np.concatenate([problem.log_density(some) for some in np.array_split(points, -(-POINTS // BATCH))])
    weights = density - _log_t(points - centre, lower)
    logarithm = float(logsumexp(weights) - np.log(POINTS))
    relative = np.exp(weights - logarithm)
    k_hat = float(array_statistics().pareto_khat(relative, chain_axis=None, r_eff=1.0, tail="right"))
    return Evidence(logarithm, float(relative.std() / np.sqrt(POINTS)), k_hat)


def _log_t(away: Array, lower: Array) -> Array:
    """Logarithm of the density of a multivariate t at points away from its centre."""
    dimensions = len(lower)
    standard = np.linalg.solve(lower, away.T)
    square = np.einsum("in,in->n", standard, standard)
    constant = gammaln((HEAVY + dimensions) / 2) - gammaln(HEAVY / 2) - dimensions / 2 * np.log(HEAVY * np.pi)
    return constant - np.log(np.diag(lower)).sum() - (HEAVY + dimensions) / 2 * np.log1p(square / HEAVY)
