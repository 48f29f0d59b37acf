"""What a record, a damping model and a prior make of wall, damper and instruments: the density of the posterior."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.histories.under_a_record import rest_samples
from rockdamp.identification.candidates import SEARCHED_ORDER
from rockdamp.identification.least_squares import EXPLAINED, LOST, Fit, Solution
from rockdamp.identification.modes import Mode, climb, triangular
from rockdamp.identification.motion import MotionNoise, noise_directions
from rockdamp.identification.noise import Noise
from rockdamp.identification.prior import Prior

INSTRUMENTS = ("sensor_deviation", "sensor_correlation")  # standard deviation of the noise, and from sample to sample
NEAREST = 1e-3  # to an end of the prior, of its width, at the start
ROUNDS = 16  # of linearising the response to the noise of the motion, each about what the one before explains best
LINEAR = 0.3  # of the sensor's deviation: what the response may differ from a linear one, a tenth of the variance
PARTS = (1.0, 0.5, 0.25, 0.1, 0.03)  # of the way there, of which the best is taken
GAINED = 0.1  # in the logarithm of the density of parameters and noise: below it the noise is found
STARTS = 4  # local minima of the scan from which modes are looked for, beside the least squares
# A poor model leaves what correlated noise explains better than white: its mode may be another minimum's.
WIDER = 5.0  # the scale about those, as they are no more than points of a grid
NOISE_SCALE = (0.1, 0.05)  # of the noise's deviation, in its logarithm, and of its correlation
BELOW = 20.0  # the highest mode, in the logarithm of the density: what is lower is no part of the posterior
RARELY = 1000  # so that the noise of a short rest is not taken for that of the sensor
ORDERS = 8  # of the damper of any order, at each of which the mode of the other parameters is looked for


@dataclass(frozen=True)
class Problem:
    """A record, a candidate and a prior."""

    prior: Prior
    solution: Solution  # of least squares, or what another point has in its place
    motion: MotionNoise  # about that point
    found: tuple[Mode, ...] = ()  # modes of the posterior; where the order is free, those at the order of the search

    @classmethod
    def about(cls, solution: Solution, prior: Prior) -> Problem:
        """Climb from the least squares and from other minima to the highest mode, and say what surrounds it.

        Raises
        ------
        InputError
            If the wall is so near to collapse that the noise of the measured motion decides on it, or if it does not
            rock where the record is explained best.
        """
        nothing = np.zeros(len(noise_directions(solution.fit.record)))
        problem = cls._about(solution, prior, solution.estimate, nothing)
        problem = problem._with_modes_from(problem._starts())
        for _ in range(ROUNDS):
            nearer = problem._nearer()
            if nearer is None:
                break
            there = cls._about(solution, prior, *nearer)
            problem = there._with_modes_from((mode.centre, mode.lower) for mode in problem.found)
        return problem

    @property
    def _sensor(self) -> tuple[float, float]:
        """Deviation and correlation of the sensor's noise at the highest mode."""
        deviation, phi = self.values(self.found[0].centre[None])[0, -2:]
        return float(deviation), float(phi)

    @classmethod
    def of(cls, fit: Fit, prior: Prior) -> Problem:
        """Search the least squares, and do as `about`."""
        return cls.about(fit.solution(), prior)

    @classmethod
    def _about(
        cls, solution: Solution, prior: Prior, estimate: Array, noise: Array, sensor: tuple[float, float] | None = None
    ) -> Problem:
        """Linearise the response to the noise of the motion about parameters and a noise."""
        fit = solution.fit
        if sensor is None:
            sensor = _deviation_and_correlation(fit.without_trend(fit.measured - fit.computed(estimate[None])[0]))
        trend = fit.trend.T * np.array([[prior.sensor_zero], [prior.sensor_drift]])
        motion = MotionNoise.at(fit, estimate, noise, trend, sensor)
        return cls(prior, replace(solution, fit=motion.fit).about(estimate), motion)

    def _with_modes_from(self, starts: Iterable[tuple[Array, Array]]) -> Problem:
        modes = self._distinct(self._climb(centre, lower, self._told) for centre, lower in starts)
        return replace(self, found=tuple(modes))

    def _nearer(self) -> tuple[Array, Array, tuple[float, float]] | None:
        """Return parameters, a noise of the motion and the sensor's, that explain the record better than those here.

        Those of the highest mode do so in as far as the response is linear; None if nothing better is found.
        """
        values = self.values(self.found[0].centre[None])
        deviation, phi = values[:, -2], values[:, -1]
        noise = self.motion.mean(self.residuals(values, self.computed(values)), deviation, phi)[0]
        trend_alone = Noise(self.motion.noise.rows[:2])

        def explained(part: float) -> tuple[float, Array, Array]:
            estimate = self.solution.estimate + part * (values[0, :3] - self.solution.estimate)
            z = self.motion.about + part * (noise - self.motion.about)
            left = self.fit.measured - self.motion.under(z).computed(estimate[None])
            return float(trend_alone.log_likelihood(left, deviation, phi)[0] - 0.5 * z @ z), estimate, z

        here = explained(0.0)[0]
        best, estimate, z = max((explained(part) for part in PARTS), key=lambda found: found[0])
        return (estimate, z, self._sensor) if best > here + GAINED else None

    @property
    def noise(self) -> Noise:
        """The sensor's zero and drift, and the noise of the motion."""
        return self.motion.noise

    @property
    def fit(self) -> Fit:
        """Under the measured motion and the noise about which this is."""
        return self.motion.fit

    @property
    def names(self) -> tuple[str, ...]:
        """The sampled parameters."""
        return (*self.fit.candidate.parameters, *INSTRUMENTS)

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """The box of the prior, in coordinates."""
        return self.prior.bounds(self.names)

    def values(self, coordinates: Array) -> Array:
        """From coordinates, shape (batch, parameters), to values."""
        return self.prior.values(self.names, coordinates)

    def computed(self, values: Array) -> Array:
        """Displacement for rows of values, under the noise of the motion that the record asks for. [m]"""
        return self.motion.computed(values[:, : -len(INSTRUMENTS)])

    def residuals(self, values: Array, computed: Array) -> Array:
        """What is left of the measured displacement for the instruments' errors. [m]"""
        return self.motion.residuals(values[:, : -len(INSTRUMENTS)], computed)

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
        values = values[inside]
        computed = self.computed(values)
        likelihood = self.noise.log_likelihood(self.residuals(values, computed), values[:, -2], values[:, -1])
        largest = np.abs(computed).max(axis=1)
        rocks = (largest > values[:, 0] * self.fit.u_ins) & (largest < LOST * self.fit.u_ins)
        density[inside] = np.where(rocks, likelihood - np.log(high - low).sum(), -np.inf)
        return density

    def require_linear(self, coordinates: Array) -> None:
        """Raise `InputError` unless the response to the noise of the motion is linear at draws of the posterior."""
        values = self.values(coordinates)
        computed = self.computed(values)
        noise = self.motion.mean(self.residuals(values, computed), values[:, -2], values[:, -1])
        beyond = self.motion.beyond_linear(values[:, : -len(INSTRUMENTS)], computed, noise)
        share = float(np.sqrt(np.mean((beyond / values[:, -2, None]) ** 2)))
        if not share <= LINEAR:
            raise InputError(
                f"the response to the noise of the measured motion differs from a linear one by {share:.2g} of the"
                f" sensor's deviation; it must be at most {LINEAR}: the wall rocks too long or too near to collapse"
            )

    def doubts(self, deviation: float) -> list[str]:
        """Say it if the model leaves more of the record than the sensor's noise at rest, by the deviation found. [m]"""
        times = deviation / self.fit.rest_deviation
        most = max(EXPLAINED, _by_chance(self.fit.measured[: rest_samples(self.fit.record)]))
        if times <= most:
            return []
        left = f"what {self.fit.candidate.name} leaves of the record is {times:.1f} times the sensor's noise at rest"
        return [f"{left}, {most:.1f} at most if a model is right: intervals tell what holds under this one alone"]

    @cached_property
    def modes(self) -> list[Mode]:
        """Modes that are part of the posterior, the highest first; where the order is free, one at each of several."""
        if "order" in self.names:
            return self._distinct(self._along_orders(self.found[0]))
        return list(self.found)

    @property
    def _told(self) -> NDArray[np.intp]:
        """Indices of the parameters that the least squares tell: all but the order."""
        return np.array([index for index, name in enumerate(self.names) if name != "order"])

    def _climb(self, centre: Array, lower: Array, free: NDArray[np.intp]) -> Mode:
        return climb(self.log_density, centre, lower, self.bounds, free)

    def _distinct(self, modes: Iterable[Mode]) -> list[Mode]:
        """Return modes that are not alike, the highest first, without those that are far below it."""
        kept: list[Mode] = []
        for mode in sorted(modes, key=lambda mode: -mode.log_density):
            if not kept and not np.isfinite(mode.log_density):
                raise InputError("the wall does not rock, or falls, where the record is explained best")
            if kept and mode.log_density < kept[0].log_density - BELOW:
                break
            if not any(mode.near(other) for other in kept):
                kept.append(mode)
        return kept

    def _starts(self) -> Iterator[tuple[Array, Array]]:
        """Yield points to climb from and scales to begin with: least squares, and minima of the scan."""
        lower = self._scale
        for estimate in [self.solution.estimate, *self.solution.local_minima[:STARTS]]:
            yield self._noise_about(estimate), lower
            lower = WIDER * self._scale

    def _along_orders(self, mode: Mode) -> Iterator[Mode]:
        """Follow a mode from one order to the next, and yield it at each with the scale of all up to its neighbours."""
        axis, (low, high) = self.names.index("order"), self.bounds
        orders = np.linspace(low[axis], high[axis], 2 * ORDERS + 1)[1::2]
        nearest = int(np.argmin(np.abs(orders - mode.centre[axis])))
        ridge: dict[int, Mode] = {}
        for path in (range(nearest, ORDERS), range(nearest - 1, -1, -1)):
            last = ridge.get(nearest, mode)
            for index in path:
                centre = last.centre.copy()
                centre[axis] = orders[index]
                ridge[index] = last = self._climb(centre, last.lower, self._told)
        slopes = np.gradient(np.array([ridge[index].centre for index in range(ORDERS)]), axis=0)
        for index, slope in enumerate(slopes):
            root = np.zeros((low.size, low.size))
            root[:, axis] = slope / 2
            root[np.ix_(self._told, self._told)] = ridge[index].lower
            yield replace(ridge[index], lower=triangular(root), free=np.arange(low.size))

    def _noise_about(self, estimate: Array) -> Array:
        """Return the coordinates of parameters of wall and damper, with the noise that they leave in the residual."""
        residual = self.fit.without_trend(self.fit.measured - self.fit.computed(estimate[None])[0])
        deviation, phi = _deviation_and_correlation(residual)
        order = [SEARCHED_ORDER] if "order" in self.names else []
        values = np.array([[*estimate, *order, deviation, phi]])
        low, high = self.bounds
        margin = NEAREST * (high - low)
        return np.clip(self.prior.coordinates(self.names, values)[0], low + margin, high - margin)

    @property
    def _scale(self) -> Array:
        """Root of the covariance of all parameters but the order, by the linear problem about the least squares."""
        low, high = self.bounds
        slope = self.solution.estimate[0] if self.prior.cracked_stiffness_ratio.distribution == "loguniform" else 1.0
        slopes = np.array([slope, 1.0, 1.0])
        precision = self.motion.precision * slopes * slopes[:, None] + np.diag(1 / (high - low)[:3] ** 2)
        lower = np.diag([1.0, 1.0, 1.0, *NOISE_SCALE])
        lower[:3, :3] = np.linalg.cholesky(np.linalg.inv(precision))
        return lower


def _deviation_and_correlation(residual: Array) -> tuple[float, float]:
    """Of what a model leaves: its standard deviation, and the correlation of neighbours."""
    phi = float(np.clip(residual[1:] @ residual[:-1] / (residual @ residual), 0.01, 0.98))
    return float(np.sqrt(np.mean(residual**2))), phi


def _by_chance(samples: Array) -> float:
    """Return how many times their standard deviation that of what samples are drawn from may be, once in `RARELY`."""
    away = samples - samples.mean()
    _, phi = _deviation_and_correlation(away)
    independent = max(samples.size * (1 - phi**2) / (1 + phi**2), 2.0)
    return float(np.sqrt((independent - 1) / chi2.ppf(1 / RARELY, independent - 1)))
