"""The posterior of wall, damper and instruments given a measured record, by ensembles of walkers."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from threading import Barrier
from typing import Any

import numpy as np

from rockdamp.arrays import Array
from rockdamp.identification.importance import Weighted, array_statistics, needed
from rockdamp.identification.mixture import Mixture
from rockdamp.identification.problem import Problem

TAILS = (0.05, 0.95)  # quantiles whose effective sample sizes count beside that of the bulk
# What is asked of the draws, by Vehtari et al. (2021, doi:10.1214/20-BA1221); r-hat is that of many short chains,
# nested in ensembles (Margossian et al., 2024, doi:10.1214/24-BA1453).
HIGHEST_R_HAT = 1.01


@dataclass(frozen=True)
class Sampler:
    """How the posterior is drawn from.

    Parameters
    ----------
    ensembles, walkers : int
        Independent ensembles, and walkers in each.
    burn_in, steps, rounds : int
        Steps that are left out; steps of a round; rounds at most, until r-hat and effective sample size suffice.
    effective : float
        Effective sample size that suffices.
    seed : int
        Of the first ensemble; each has its own.
    """

    ensembles: int = 4
    walkers: int = 64
    burn_in: int = 120
    steps: int = 120
    rounds: int = 16
    effective: float = 400.0
    seed: int = 2017


@dataclass(frozen=True)
class Draws:
    """What the walkers found.

    Parameters
    ----------
    coordinates : ndarray, shape (ensembles, steps, walkers, parameters)
        In the prior's coordinates.
    r_hat, effective : ndarray, shape (parameters,)
        Nested r-hat, and effective sample size: the smaller of that of the bulk and those of the tails. [-]
    least_effective : float
        What is asked of the latter. [-]
    """

    coordinates: Array
    r_hat: Array
    effective: Array
    least_effective: float

    @property
    def flat(self) -> Array:
        """All draws, shape (draws, parameters)."""
        return self.coordinates.reshape(-1, self.coordinates.shape[-1])

    @property
    def good(self) -> bool:
        """Whether r-hat and effective sample size suffice."""
        return bool((self.r_hat <= HIGHEST_R_HAT).all() and (self.effective >= self.least_effective).all())


class _InStep:
    """Ensembles that ask for densities at the same time, in threads of their own, and get them from one batch."""

    def __init__(self, density: Callable[[Array], Array], ensembles: int) -> None:
        self._density = density
        self._asked: list[Array] = [np.empty(0)] * ensembles
        self._answers: list[Array] = []
        self._barrier = Barrier(ensembles, self._answer)

    def _answer(self) -> None:
        ends = np.cumsum([len(asked) for asked in self._asked])[:-1]
        self._answers = np.split(self._density(np.concatenate(self._asked)), ends)

    def of(self, ensemble: int) -> Callable[[Array], Array]:
        """Return the density that an ensemble asks for."""

        def density(coordinates: Array) -> Array:
            self._asked[ensemble] = coordinates
            self._barrier.wait()
            return self._answers[ensemble]

        return density

    def give_up(self) -> None:
        """End the others' waiting for an ensemble that failed."""
        self._barrier.abort()


def draw(problem: Problem, found: Weighted, sampler: Sampler) -> Draws:
    """Draw from a posterior until r-hat and effective sample size suffice, or the rounds are used up.

    Walkers start as draws from the mixture that was fitted to the posterior. Their moves are to other draws from it,
    and those of differential evolution, which need no tuning. Ensembles run in step, so that the kernel meets all of
    them at once; the result does not depend on the number of threads.
    """
    emcee = needed("emcee")
    in_step = _InStep(problem.log_density, sampler.ensembles)
    moves = [(_independent(found.mixture), 0.5), (emcee.moves.DEMove(), 0.5)]
    running = []
    for number in range(sampler.ensembles):
        random = np.random.RandomState(sampler.seed + number)
        shape, density = (sampler.walkers, len(problem.names)), in_step.of(number)
        made = emcee.EnsembleSampler(*shape, density, moves=moves, vectorize=True)
        made.random_state = random.get_state()
        running.append((made, _start(problem, found.mixture, sampler.walkers, random)))
    with ThreadPoolExecutor(sampler.ensembles) as pool:

        def advance(steps: int, store: bool) -> None:
            def walk(pair: tuple[Any, Any]) -> Any:
                try:
                    return pair[0].run_mcmc(pair[1], steps, store=store)
                except BaseException:
                    in_step.give_up()
                    raise

            states = pool.map(walk, running)
            running[:] = [(made, state) for (made, _), state in zip(running, list(states), strict=True)]

        advance(sampler.burn_in, store=False)
        for done in range(sampler.rounds):
            advance(sampler.steps, store=True)
            # Of further rounds the earlier half is left out: what was too little may have been too far off.
            skipped = sampler.steps * (done + 1) // 2 if done else 0
            draws = diagnosed(np.stack([made.get_chain(discard=skipped) for made, _ in running]), sampler.effective)
            if draws.good:
                break
    return draws


def _start(problem: Problem, mixture: Mixture, walkers: int, random: np.random.RandomState) -> Array:
    """Draw points of the mixture at which the posterior is not zero."""
    points = np.empty((0, len(problem.names)))
    while len(points) < walkers:
        some = mixture.draw(2 * walkers, random)
        points = np.concatenate([points, some[np.isfinite(problem.log_density(some))]])
    return points[:walkers]


def _independent(mixture: Mixture) -> Any:
    """Return a move to anywhere in a mixture, which asks for densities as often as the other move: ensembles wait."""

    class Independent(needed("emcee").moves.RedBlueMove):  # type: ignore[misc]
        def get_proposal(self, walkers: Array, others: Any, random: np.random.RandomState) -> tuple[Array, Array]:
            points = mixture.draw(len(walkers), random)
            return points, mixture.log_density(walkers) - mixture.log_density(points)

    return Independent()


def diagnosed(coordinates: Array, least_effective: float) -> Draws:
    """Return draws with their r-hat and effective sample size; shape (ensembles, steps, walkers, parameters)."""
    statistics = array_statistics()
    ensembles, steps, walkers, dimensions = coordinates.shape
    chains = coordinates.transpose(3, 0, 2, 1).reshape(dimensions, ensembles * walkers, steps)
    owner = np.repeat(np.arange(ensembles), walkers)
    with np.errstate(all="ignore"):
        r_hat = np.array([statistics.rhat_nested(chain, superchain_ids=owner) for chain in chains])
        sizes = [
            [statistics.ess(chain, method="bulk"), *(statistics.ess(chain, method="quantile", prob=q) for q in TAILS)]
            for chain in chains
        ]
    return Draws(coordinates, r_hat.astype(float), np.min(np.array(sizes, dtype=float), axis=1), least_effective)
