"""Density of the posterior of wall, damper and instruments, by a record, a damping model and a prior."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.histories.measured_test import rest_samples
from rockdamp.identification.least_squares import EXPLAINED, LOST, Fit, Solution
from rockdamp.identification.motion import MotionNoise, noise_directions
from rockdamp.identification.noise import Noise
from rockdamp.identification.prior import Prior
from rockdamp.identification.sampler import Draws, Neighbourhood, sample

INSTRUMENTS = ("sensor_deviation", "sensor_correlation")  # standard deviation of the noise, and from sample to sample
# A poor model leaves what correlated noise explains better than white: its mode may be another minimum's.
STARTS = 4  # local minima of the scan from which the mode is looked for, beside the least squares
ORDERS = (1.0, 4.0, 16.0)  # from which it is looked for where the order is free
NEAREST = 1e-3  # to an end of the prior, of its width
SHIFT = 1e-4  # of the prior's width: half of the differences' width
STEPS = 25  # of the search for the mode, at most
ROUNDS = 16  # of linearising the response to the noise of the motion, each about what the one before explains best
CORRELATION = (0.01, 0.995)  # of what a model leaves, as it is taken in the search
PARTS = np.array([1.0, 0.5, 0.25, 0.1, 0.03])  # of a step, of which the best is taken
GAINED = 0.1  # in the logarithm of the density: below it the mode is found
LINEAR = 0.3  # of the sensor's deviation: what the response may differ from a linear one, a tenth of the variance
AGAIN = 2  # times at most that draws start about another mode
HIGHER = 2.0  # in the logarithm of the density: a mode that was missed, and not a draw near the mode
CHECKED, CHECKED_SEED = 32, 0  # draws at which it must be that linear
RARELY = 1000  # so that the noise of a short rest is not taken for that of the sensor


@contextmanager
def _finite() -> Iterator[None]:
    """Refuse in words where a matrix is singular: near to collapse derivatives are as good as infinite."""
    try:
        yield
    except np.linalg.LinAlgError:
        raise InputError("the wall is too near to collapse where the record is explained best") from None


@dataclass(frozen=True)
class Problem:
    """A record, a candidate and a prior, with what is known of the posterior before it is drawn from.

    The response is linearised in the noise of the motion about the mode, the point of the unit cube of the greatest
    density, nearly. The cube's coordinates are the prior's probabilities of each parameter.
    """

    prior: Prior
    motion: MotionNoise
    mode: Array  # of the unit cube, shape (parameters,)

    @classmethod
    @_finite()
    def about(cls, solution: Solution, prior: Prior) -> Problem:
        """Search the mode and linearise the response there.

        The response is linearised about the least squares first. The search then alternates: the mode of this
        linear problem, and a new linearisation about it and the noise that it asks for, as far as that explains the
        record better in truth. It raises `InputError` where that is too near to collapse, or the wall does not rock.
        """
        fit = solution.fit
        starts = np.array([solution.estimate, *solution.local_minima[:STARTS]])
        if "order" in fit.candidate.parameters:
            starts = np.array([[*start, order] for start in starts for order in ORDERS])
        residual = fit.without_trend(fit.measured - fit.computed(starts[:1])[0])
        sensor = np.stack(_deviation_and_correlation(residual[None]), axis=1)[0]
        nothing = np.zeros(len(noise_directions(fit.record)))
        return cls._at(fit, prior, starts[0], nothing, sensor)._at_mode(starts)._nearest()

    @classmethod
    def of(cls, fit: Fit, prior: Prior) -> Problem:
        """Search the least squares, and do as `about`."""
        return cls.about(fit.solution(), prior)

    @classmethod
    def _at(cls, fit: Fit, prior: Prior, estimate: Array, noise: Array, sensor: Array) -> Problem:
        """Linearise the response about parameters of wall and damper, a noise and the sensor's; without a mode."""
        trend = fit.trend.T * np.array([[prior.sensor_zero], [prior.sensor_drift]])
        motion = MotionNoise.at(fit, estimate, noise, trend, sensor)
        return cls(prior, motion, np.empty(0))

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

    def values(self, points: Array) -> Array:
        """From points of the unit cube, shape (batch, parameters), to values."""
        return self.prior.values(self.names, points)

    def computed(self, values: Array) -> Array:
        """Displacement for rows of values, under the noise of the motion that the record asks for. [m]"""
        return self.motion.computed(values[:, : -len(INSTRUMENTS)])

    def residuals(self, values: Array, computed: Array) -> Array:
        """Return the part of the measured displacement that is left for the instruments' errors. [m]"""
        return self.motion.residuals(values[:, : -len(INSTRUMENTS)], computed)

    def log_density(self, points: Array) -> Array:
        """Return the logarithm of prior times likelihood in the unit cube, shape (batch,); -inf where it is zero.

        It is zero outside the cube, and where the wall collapses or does not go beyond its first branch: a record of
        that is refused.
        """
        inside = np.all((points > 0) & (points < 1), axis=1)
        values = self.values(np.where(inside[:, None], points, 0.5))
        # 1 % of room: a plateau of no length at all is no curve.
        end = self.fit.physical(np.stack([np.ones(len(values)), values[:, 1], np.zeros(len(values))], axis=1))[:, 0]
        inside &= values[:, 0] < 0.99 * end
        density = np.full(len(points), -np.inf)
        if not inside.any():
            return density
        values = values[inside]
        computed = self.computed(values)
        likelihood = self.noise.log_likelihood(self.residuals(values, computed), values[:, -2], values[:, -1])
        largest = np.abs(computed).max(axis=1)
        rocks = (largest > values[:, 0] * self.fit.u_ins) & (largest < LOST * self.fit.u_ins)
        density[inside] = np.where(rocks, likelihood, -np.inf)
        return density

    @_finite()
    def drawn(self, effective: float, seed: int) -> tuple[Problem, Draws]:
        """Draw from the posterior until enough draws are effective; return the problem about the mode with them.

        Where the draws show a mode that is higher than the one of the search, the draws start again about that. It
        raises `InputError` if this takes too long, or the response to the noise of the motion is not linear there.
        """
        problem = self
        for _ in range(AGAIN):
            draws = sample(problem.log_density, problem._neighbourhood(), effective, seed)
            best = np.argmax(draws.log_density)
            if draws.log_density[best] < problem.log_density(problem.mode[None])[0] + HIGHER:
                break
            problem = problem._at_mode(problem.values(draws.points[best][None])[:, :-2])._nearest()
        problem.require_linear(draws.resampled(CHECKED, np.random.RandomState(CHECKED_SEED)))
        return problem, draws

    def require_linear(self, points: Array) -> None:
        """Raise `InputError` unless the response to the noise of the motion is linear at draws of the posterior."""
        values = self.values(points)
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
        """Return a warning if the model leaves more [m] of the record than the sensor's noise at rest."""
        times = deviation / self.fit.rest_deviation
        most = max(EXPLAINED, _by_chance(self.fit.measured[: rest_samples(self.fit.record)]))
        if times <= most:
            return []
        left = f"what {self.fit.candidate.name} leaves of the record is {times:.1f} times the sensor's noise at rest"
        return [f"{left}, {most:.1f} at most if a model is right: intervals tell what holds under this one alone"]

    # --- the mode: Gauss and Newton's method, from several starts at once

    def _at_mode(self, starts: Array) -> Problem:
        """Return the same with the highest mode that is reached from parameters of wall and damper."""
        left = self.fit.without_trend(self.fit.measured - self.fit.computed(starts))
        sensor = np.stack(_deviation_and_correlation(left), axis=1)
        points = self._inside(self.prior.points(self.names, np.concatenate([starts, sensor], axis=1)))
        highest = self.log_density(points)
        rocks = np.isfinite(highest)
        if not rocks.any():
            raise InputError("the wall does not rock, or falls, where the record is explained best")
        points, highest = points[rocks], highest[rocks]
        for _ in range(STEPS):
            tried = self._inside(points + PARTS[:, None, None] * self._steps(points))
            density = self.log_density(tried.reshape(-1, points.shape[1])).reshape(len(PARTS), -1)
            best = np.argmax(density, axis=0)
            higher = np.take_along_axis(density, best[None], axis=0)[0]
            gained = higher > highest + GAINED
            if not gained.any():
                break
            points = np.where(gained[:, None], tried[best, np.arange(len(points))], points)
            highest = np.where(gained, higher, highest)
        return replace(self, mode=points[np.argmax(highest)])

    @staticmethod
    def _inside(points: Array) -> Array:
        return np.clip(points, NEAREST, 1 - NEAREST)

    def _steps(self, points: Array) -> Array:
        """Return a step for each point: generalised least squares of wall and damper, and the noise that is left."""
        residuals, derivative = self._linear(points)
        values = self.values(points)
        deviation, phi = values[:, -2], values[:, -1]
        steps = np.zeros_like(points)
        gradient = np.einsum("bpt,bt->bp", derivative, self.noise.by_inverse(residuals, deviation, phi))
        wall = gradient.shape[1]
        steps[:, :wall] = np.linalg.solve(self._precision(derivative, deviation, phi), -gradient[..., None])[..., 0]
        left = residuals + np.einsum("bp,bpt->bt", steps[:, :wall], derivative)
        left = self.noise.without_linear(left, deviation, phi)
        values[:, -2:] = np.stack(_deviation_and_correlation(left), axis=1)
        steps[:, wall:] = self.prior.points(self.names, values)[:, wall:] - points[:, wall:]
        return steps

    def _linear(self, points: Array) -> tuple[Array, Array]:
        """Return the residuals at points, and their derivatives by wall and damper, shape (batch, wall, samples)."""
        wall = points.shape[1] - len(INSTRUMENTS)
        shift = SHIFT * np.eye(wall, points.shape[1])
        around = np.concatenate([points[:, None], points[:, None] + shift, points[:, None] - shift], axis=1)
        values = self.values(around.reshape(-1, points.shape[1]))
        residuals = self.residuals(values, self.computed(values)).reshape(len(points), 2 * wall + 1, -1)
        return residuals[:, 0], (residuals[:, 1 : wall + 1] - residuals[:, wall + 1 :]) / (2 * SHIFT)

    def _precision(self, derivative: Array, deviation: Array, phi: Array) -> Array:
        """Return the inverse covariance of wall and damper in the unit cube, shape (batch, wall, wall)."""
        count, wall, samples = derivative.shape
        rows = derivative.reshape(-1, samples)
        weighted = self.noise.by_inverse(rows, np.repeat(deviation, wall), np.repeat(phi, wall))
        # The variance of the prior, 1/12, bounds that of what the record does not tell.
        return np.einsum("bpt,bqt->bpq", derivative, weighted.reshape(count, wall, samples)) + 12 * np.eye(wall)

    def _nearest(self) -> Problem:
        """Linearise anew about the mode and search it there, until that explains the record no better."""
        problem, measured = self, self.fit.with_motion(self.fit.record.ground_acceleration)
        for _ in range(ROUNDS):
            nearer = problem._nearer()
            if nearer is None:
                break
            problem = self._at(measured, self.prior, *nearer)._at_mode(problem.values(problem.mode[None])[:, :-2])
        return problem

    def _nearer(self) -> tuple[Array, Array, Array] | None:
        """Return parameters, a noise of the motion and the sensor's, that explain the record better than those here.

        Those of the mode do so in as far as the response is linear; None if nothing better is found.
        """
        values = self.values(self.mode[None])
        deviation, phi = values[:, -2], values[:, -1]
        noise = self.motion.mean(self.residuals(values, self.computed(values)), deviation, phi)[0]
        trend_alone = Noise(self.noise.rows[:2])
        before = self.motion.parameters

        def explained(part: float) -> tuple[float, Array, Array]:
            estimate = before + part * (values[0, :-2] - before)
            z = self.motion.about + part * (noise - self.motion.about)
            left = self.fit.measured - self.motion.under(z).computed(estimate[None])
            return float(trend_alone.log_likelihood(left, deviation, phi)[0] - 0.5 * z @ z), estimate, z

        here = explained(0.0)[0]
        best, estimate, z = max((explained(float(part)) for part in PARTS), key=lambda tried: tried[0])
        return (estimate, z, values[0, -2:]) if best > here + GAINED else None

    def _neighbourhood(self) -> Neighbourhood:
        """Guess the posterior: normal about the mode, by what the linear problem tells of each parameter."""
        points = self.mode[None]
        values = self.values(points)
        deviation, phi = values[:, -2], values[:, -1]
        wall = points.shape[1] - len(INSTRUMENTS)
        covariance = np.zeros((points.shape[1], points.shape[1]))
        covariance[:wall, :wall] = np.linalg.inv(self._precision(self._linear(points)[1], deviation, phi)[0])
        # Fisher's information of a correlated series: of the logarithm of its deviation, and of its correlation.
        variance = 1 - phi[0] ** 2
        fisher = np.array([[0.5 + phi[0] ** 2 / variance, phi[0]], [phi[0], variance]]) / self.fit.measured.size
        apart = values + [*np.zeros(wall), SHIFT * deviation[0], SHIFT]
        slope = ((self.prior.points(self.names, apart) - points)[0, wall:]) / SHIFT
        covariance[wall:, wall:] = fisher * slope * slope[:, None]
        return Neighbourhood(self.mode, np.asarray(np.linalg.cholesky(covariance), dtype=float))


def _deviation_and_correlation(residuals: Array) -> tuple[Array, Array]:
    """Of what a model leaves, shape (batch, samples): the standard deviation, and the correlation of neighbours."""
    square = np.einsum("bt,bt->b", residuals, residuals)
    phi = np.clip(np.einsum("bt,bt->b", residuals[:, 1:], residuals[:, :-1]) / square, *CORRELATION)
    return np.sqrt(square / residuals.shape[1]), phi


def _by_chance(samples: Array) -> float:
    """Return how many times their standard deviation that of what samples are drawn from may be, once in `RARELY`."""
    away = samples - samples.mean()
    phi = float(_deviation_and_correlation(away[None])[1][0])
    independent = max(samples.size * (1 - phi**2) / (1 + phi**2), 2.0)
    return float(np.sqrt((independent - 1) / chi2.ppf(1 / RARELY, independent - 1)))
