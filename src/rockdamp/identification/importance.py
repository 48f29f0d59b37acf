"""A posterior by weighted draws from a mixture that is fitted to it: its moments, and the evidence of its model."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from typing import Any, Protocol

import numpy as np
from scipy.special import logsumexp

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.identification.mixture import Mixture
from rockdamp.identification.modes import Mode

COMPONENTS = 6  # of the mixture, at least: the posterior may be bent
SPREAD = 1.3  # of the components over the scale about the modes
BATCH = 512  # densities computed at once
DRAWN, ROUNDS = 1024, 12  # points of a round, and rounds at most, in which the mixture is fitted
FLAT = 0.05  # effective share of a round's points: where it is less, the weights are flattened until it is not
FITTED = 0.4  # effective share at which the mixture is good enough
FINAL, FINALS = 3072, 5  # points of a last round, by which everything is told; last rounds at most
HIGHEST_K_HAT = 0.7  # of Pareto's shape: beyond, averages are not to be relied on (Vehtari et al., arXiv:1507.02646)
LEAST_EFFECTIVE = 200.0  # draws


class Density(Protocol):
    """What is drawn from: the logarithm of a density, and its modes."""

    @property
    def modes(self) -> list[Mode]: ...

    def log_density(self, coordinates: Array) -> Array: ...


@dataclass(frozen=True)
class Evidence:
    """The logarithm of the evidence, its standard error, and Pareto's k-hat of the weights."""

    logarithm: float
    standard_error: float
    k_hat: float


@dataclass(frozen=True)
class Weighted:
    """Draws from a mixture, with weights that make them draws from a posterior.

    Parameters
    ----------
    coordinates : ndarray, shape (draws, parameters)
    log_weights : ndarray, shape (draws,)
        Logarithm of the density over the mixture's.
    mixture : Mixture
    """

    coordinates: Array
    log_weights: Array
    mixture: Mixture

    @cached_property
    def weights(self) -> Array:
        """With a sum of 1."""
        return np.exp(self.log_weights - logsumexp(self.log_weights))

    @property
    def effective(self) -> float:
        """Effective number of draws."""
        return float(1 / np.sum(self.weights**2))

    @cached_property
    def evidence(self) -> Evidence:
        """The average of the likelihood over the prior."""
        count = self.weights.size
        relative = count * self.weights
        k_hat = float(array_statistics().pareto_khat(relative, chain_axis=None, r_eff=1.0, tail="right"))
        logarithm = float(logsumexp(self.log_weights) - np.log(count))
        return Evidence(logarithm, float(relative.std() / np.sqrt(count)), k_hat)

    @property
    def good(self) -> bool:
        """Whether the weights are light enough, and the draws enough, for averages to be relied on."""
        return self.evidence.k_hat <= HIGHEST_K_HAT and self.effective >= LEAST_EFFECTIVE

    @property
    def fitted(self) -> Mixture:
        """The mixture, fitted to the draws; where few weigh much, with weights that are flattened until enough do."""
        return self.mixture.fitted(self.coordinates, _flattened(self.log_weights))

    def resampled(self, count: int, random: np.random.RandomState) -> Array:
        """Draw from the draws, in proportion to their weights."""
        return self.coordinates[random.choice(self.weights.size, count, p=self.weights)]


def explore(density: Density, random: np.random.RandomState) -> Weighted:
    """Fit a mixture to a posterior, from its modes on, and draw from that; more than once where it does not suffice."""
    mixture = _about(density.modes, random)
    for _ in range(ROUNDS):
        found = _drawn(density, mixture, DRAWN, random)
        if found.effective >= FITTED * DRAWN:
            break
        mixture = found.fitted
    for _ in range(FINALS):
        found = _drawn(density, mixture, FINAL, random)
        if found.good:
            break
        mixture = found.fitted
    return found


def _about(modes: list[Mode], random: np.random.RandomState) -> Mixture:
    """Return components about modes, with copies scattered about each until they are enough."""
    copies = -(-COMPONENTS // len(modes))
    volume = np.array([mode.log_density + np.log(np.diag(mode.lower)).sum() for mode in modes])
    share = np.maximum(np.exp(volume - logsumexp(volume)), 1 / COMPONENTS**2)
    away = random.standard_normal((copies, len(modes), modes[0].centre.size))
    away[0] = 0.0
    centre = np.stack([mode.centre + away[:, index] @ mode.lower.T for index, mode in enumerate(modes)], axis=1)
    lower = SPREAD * np.array([mode.lower for mode in modes])
    share = np.tile(share, copies)
    return Mixture(share / share.sum(), centre.reshape(len(share), -1), np.tile(lower, (copies, 1, 1)))


def _drawn(density: Density, mixture: Mixture, count: int, random: np.random.RandomState) -> Weighted:
    points = mixture.draw(count, random)
    found = np.concatenate([density.log_density(some) for some in np.array_split(points, -(-count // BATCH))])
    return Weighted(points, found - mixture.log_density(points), mixture)


def _flattened(log_weights: Array) -> Array:
    """Return weights to the highest power, 1 at most, of which enough draws are effective."""
    highest, power = log_weights.max(), 1.0
    while True:
        weights = np.exp(power * (log_weights - highest))
        if weights.sum() ** 2 >= FLAT * log_weights.size * np.sum(weights**2) or power < 1e-3:
            return np.asarray(weights)
        power *= 0.8


def array_statistics() -> Any:
    """Return the statistics of draws, of a package which only those need who ask for a posterior."""
    return needed("arviz_stats.base").array_stats


def needed(module: str) -> Any:
    """Import a module of a package that the extra `posterior` brings."""
    try:
        return import_module(module)
    except ImportError:
        message = "a posterior needs the packages emcee and arviz-stats; pip install emcee arviz-stats"
        raise InputError(message) from None
