"""The posterior of wall, damper and instruments given a measured record, by ensembles of walkers."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from threading import Barrier
from typing import Any

import numpy as np

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.studies.identification.noise import Noise
from rockdamp.studies.identification.prior import Prior
from rockdamp.studies.least_squares import LOST, Fit, Solution

# The standard deviation and correlation of the displacement sensor's noise, and a factor on the measured motion.
INSTRUMENTS = ("sensor_deviation", "sensor_correlation", "motion_gain")
NEAREST = 1e-3  # to an end of the prior, of its width, at the start
GAIN_STEP = 1e-4  # of the central difference by the gain
FARTHEST = 8.0  # the gain's deviations at most
# What is asked of the draws, by Vehtari et al. (2021, doi:10.1214/20-BA1221); r-hat is that of many short chains,
# nested in ensembles (Margossian et al., 2024, doi:10.1214/24-BA1453).
HIGHEST_R_HAT = 1.01
SPREAD = 1.5  # of the walkers' start over what is expected of the posterior
KEPT_SHARE = 0.999  # of the variance of what the motion's noise shifts, by the directions that are kept
MOST_DIRECTIONS = 16


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


@dataclass(frozen=True)
class Problem:
    """A record, a candidate and a prior."""

    fit: Fit
    prior: Prior
    solution: Solution  # of least squares
    noise: Noise
    gain_deviation: float  # of a factor on the motion that acts as the motion's noise mostly does
    by_gain: Array  # derivative of the response by that factor [m]
    beside_gain: Array  # what the noise changes beside that, in proportion to that factor [m]

    @classmethod
    def of(cls, fit: Fit, prior: Prior) -> Problem:
        """Search the least squares, step from there to where the posterior is expected, and say what surrounds that.

        Raises
        ------
        InputError
            If the wall is so near to collapse that the noise of the measured motion decides on it.
        """
        solution = fit.solution()
        return cls._about(solution.about(cls._about(solution, prior)._improved), prior)

    @classmethod
    def _about(cls, solution: Solution, prior: Prior) -> Problem:
        """Find what the noise of the measured motion does to the response about some parameters.

        Mostly it does what a slightly larger or smaller motion would do. This is far from linear against the sensor's
        noise, and so a factor on the motion is sampled; what is left of it is small, and taken as linear.
        """
        fit, shifts = solution.fit, solution.shifts
        if np.abs(shifts).max() > LOST / 2 * fit.u_ins:
            raise InputError("the wall is so near to collapse that the noise of the measured motion decides on it")
        sides = fit.computed(np.stack([solution.estimate] * 2), 1 + GAIN_STEP * np.array([1.0, -1.0]))
        by_gain = (sides[0] - sides[1]) / (2 * GAIN_STEP)
        gains = np.einsum("it,t->i", shifts, by_gain) / np.einsum("t,t->", by_gain, by_gain)
        variance = np.mean(gains**2)
        together = np.einsum("i,it->t", gains, shifts) / len(gains) / variance
        trend = fit.trend.T * np.array([[prior.sensor_zero], [prior.sensor_drift]])
        rows = np.concatenate([trend, _directions(shifts - gains[:, None] * together)])
        return cls(fit, prior, solution, Noise(rows), float(np.sqrt(variance)), by_gain, together - by_gain)

    @property
    def names(self) -> tuple[str, ...]:
        """The sampled parameters."""
        return (*self.fit.candidate.parameters, *INSTRUMENTS)

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """The box of the prior, in coordinates; the last one is the gain's, in its deviations."""
        low, high = self.prior.bounds(self.names[:-1])
        return np.append(low, -FARTHEST), np.append(high, FARTHEST)

    def values(self, coordinates: Array) -> Array:
        """From coordinates, shape (batch, parameters), to values."""
        gain = 1 + self.gain_deviation * coordinates[:, -1:]
        return np.concatenate([self.prior.values(self.names[:-1], coordinates[:, :-1]), gain], axis=1)

    def computed(self, values: Array) -> Array:
        """Displacement for rows of values. [m]"""
        return self.fit.computed(values[:, : -len(INSTRUMENTS)], values[:, -1])

    def residuals(self, values: Array, computed: Array) -> Array:
        """What is left of the measured displacement, with what the motion's noise does beside its gain. [m]"""
        return self.fit.measured - computed - (values[:, -1:] - 1) * self.beside_gain

    def log_density(self, coordinates: Array) -> Array:
        """Return the logarithm of prior times likelihood, shape (batch,); -inf where the prior is zero.

        It is zero too where the wall collapses or does not go beyond its first branch: a record of that is refused.
        """
        low, high = self.bounds
        inside = np.all((coordinates > low) & (coordinates < high), axis=1)
        values = self.values(np.where(inside[:, None], coordinates, (low + high) / 2))
        # 1 % of room: a plateau of no length at all is no curve.
        end = self.fit.physical(np.stack([np.ones(len(values)), values[:, 1], np.zeros(len(values))], axis=1))[:, 0]
        inside &= values[:, 0] < 0.99 * end
        density = np.full(len(coordinates), -np.inf)
        if not inside.any():
            return density
        values, gain = values[inside], coordinates[inside, -1]
        computed = self.computed(values)
        likelihood = self.noise.log_likelihood(self.residuals(values, computed), values[:, -3], values[:, -2])
        largest = np.abs(computed).max(axis=1)
        rocks = (largest > values[:, 0] * self.fit.u_ins) & (largest < LOST * self.fit.u_ins)
        prior = -np.log((high - low)[:-1]).sum() - 0.5 * (gain**2 + np.log(2 * np.pi))
        density[inside] = np.where(rocks, likelihood + prior, -np.inf)
        return density

    def start(self, walkers: int, random: np.random.RandomState) -> Array:
        """Scatter walkers about the least squares, somewhat wider than the posterior is expected to be."""
        low, high = self.bounds
        centre, spread = self._expected
        scattered = np.empty((0, low.size))
        while len(scattered) < walkers:
            some = centre + SPREAD * random.standard_normal((4 * walkers, low.size)) @ spread.T
            flat = np.isnan(centre)
            some[:, flat] = random.uniform(low[flat], high[flat], (4 * walkers, int(flat.sum())))
            margin = NEAREST * (high - low)
            some = np.clip(some, low + margin, high - margin)
            scattered = np.concatenate([scattered, some[np.isfinite(self.log_density(some))]])
        return scattered[:walkers]

    @cached_property
    def _residual_noise(self) -> tuple[float, float]:
        """Standard deviation and correlation of neighbours of what least squares leave."""
        residual = self.solution.residual
        phi = float(np.clip(residual[1:] @ residual[:-1] / (residual @ residual), 0.01, 0.98))
        return float(np.sqrt(np.mean(residual**2))), phi

    @cached_property
    def _linear(self) -> tuple[Array, Array]:
        """Expected change and covariance of the coordinates of a1, b1, the damper's parameter and the gain.

        Of the linear problem, with the instruments' errors as unknowns beside them.
        """
        low, high = self.bounds
        deviation, phi = self._residual_noise
        by_gain = self.fit.without_trend(self.by_gain + self.beside_gain)[None] * self.gain_deviation
        slope = self.solution.estimate[:1] if self.prior.cracked_stiffness_ratio.distribution == "loguniform" else [1.0]
        design = np.concatenate([self.solution.derivative.T * [slope, [1.0], [1.0]], by_gain, self.noise.rows])
        variance = deviation**2 * (1 + phi) / (1 - phi)
        known = np.concatenate([1 / (high - low)[:3] ** 2, np.ones(1 + len(self.noise.rows))])
        covariance = np.linalg.inv(np.einsum("it,jt->ij", design, design) / variance + np.diag(known))
        change = covariance @ np.einsum("it,t->i", design, self.solution.residual) / variance
        return change[:4], covariance[:4, :4]

    @property
    def _improved(self) -> Array:
        """The parameters after a step from the least squares to where the posterior is expected."""
        names, (low, high) = self.names[:3], self.bounds
        coordinates = self.prior.coordinates(names, self.solution.estimate[None])[0] + self._linear[0][:3]
        margin = NEAREST * (high - low)[:3]
        return self.prior.values(names, np.clip(coordinates, low[:3] + margin, high[:3] - margin)[None])[0]

    @cached_property
    def _expected(self) -> tuple[Array, Array]:
        """Where the posterior is expected, NaN where the prior alone says, and the root of its covariance."""
        values = np.full((1, len(self.names) - 1), np.nan)
        values[0, :3], values[0, -2:] = self.solution.estimate, self._residual_noise
        centre = np.append(self.prior.coordinates(self.names[:-1], values)[0], 0.0)
        spread, lower = np.zeros((centre.size, centre.size)), np.linalg.cholesky(self._linear[1])
        spread[:3, :3], spread[-1, :3], spread[-1, -1] = lower[:3, :3], lower[3, :3], lower[3, 3]
        spread[-3, -3], spread[-2, -2] = 0.1, 0.05
        return centre, spread


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


def draw(problem: Problem, sampler: Sampler) -> Draws:
    """Draw from a posterior until r-hat and effective sample size suffice, or the rounds are used up.

    Moves are those of differential evolution, which need no tuning. Ensembles run in step, so that the kernel meets all
    of them at once; the result does not depend on the number of threads.
    """
    emcee = _needed("emcee")
    in_step = _InStep(problem.log_density, sampler.ensembles)
    running = []
    for number in range(sampler.ensembles):
        random = np.random.RandomState(sampler.seed + number)
        shape, density = (sampler.walkers, len(problem.names)), in_step.of(number)
        made = emcee.EnsembleSampler(*shape, density, moves=emcee.moves.DEMove(), vectorize=True)
        made.random_state = random.get_state()
        running.append((made, problem.start(sampler.walkers, random)))
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


TAILS = (0.05, 0.95)


def array_statistics() -> Any:
    """Return the statistics of draws, of a package which only those need who ask for a posterior."""
    return _needed("arviz_stats.base").array_stats


def _needed(module: str) -> Any:
    try:
        return import_module(module)
    except ImportError:
        message = "a posterior needs the packages emcee and arviz-stats; pip install emcee arviz-stats"
        raise InputError(message) from None


def _directions(shifts: Array) -> Array:
    """Return rows whose products sum up to nearly all of the covariance of the shifts.

    By Cholesky's decomposition with pivots, cut short: few rows hold nearly all, and the order of its sums is the same
    on any number of cores.
    """
    covariance_of = np.einsum("it,it->t", shifts, shifts) / len(shifts)
    rows, left = np.empty((0, covariance_of.size)), covariance_of.copy()
    while len(rows) < MOST_DIRECTIONS and left.sum() > (1 - KEPT_SHARE) * covariance_of.sum():
        pivot = int(np.argmax(left))
        row = np.einsum("i,it->t", shifts[:, pivot], shifts) / len(shifts)
        row = (row - np.einsum("k,kt->t", rows[:, pivot], rows)) / np.sqrt(left[pivot])
        rows, left = np.concatenate([rows, row[None]]), np.maximum(left - row**2, 0.0)
    return rows
