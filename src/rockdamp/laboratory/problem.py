"""Density of the posterior of wall, damper and instruments, by the records of one or more runs, a model and a prior."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.laboratory.candidates import Prior
from rockdamp.laboratory.least_squares import EXPLAINED, LOST, RecordFit, Solution
from rockdamp.laboratory.noise import MotionNoise, Noise, noise_directions
from rockdamp.laboratory.sampler import Draws, Neighbourhood, sample
from rockdamp.progress import track

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
FINER = 0.25  # of the solver's step, where the noise is corrected: the solver's roughness would decide there
AGAIN = 2  # times at most that draws start about another mode
HIGHER = 2.0  # in the logarithm of the density: a mode that was missed, and not a draw near the mode
CHECKED, CHECKED_SEED = 32, 0  # draws at which it must be that linear
RARELY = 1000  # so that the noise of a short rest is not taken for that of the sensor


@dataclass(frozen=True)
class Problem:
    """The records of one or more runs, a candidate and a prior, with what is known of the posterior before it is drawn.

    The response is linearised in the noise of each motion about the mode, the point of the unit cube of the greatest
    density, nearly. The cube's coordinates are the prior's probabilities of each parameter. All runs share wall, damper
    and sensor, but for e or xi where `loss_by_run` says so.
    """

    prior: Prior
    runs: tuple[MotionNoise, ...]
    mode: Array  # of the unit cube, shape (parameters,)
    loss_by_run: bool = False

    @classmethod
    def about(cls, solutions: Solution | Sequence[Solution], prior: Prior, *, loss_by_run: bool = False) -> Problem:
        """Search the mode and linearise the response there, from the least squares of each run.

        The response is linearised about the least squares first. The search then alternates: the mode of this
        linear problem, and a new linearisation about it and the noise that it asks for, as far as that explains the
        record better in truth. It raises `InputError` where that is too near to collapse, or the wall does not rock.
        """
        solutions = [solutions] if isinstance(solutions, Solution) else list(solutions)
        fits = [replace(solution.fit, sizes=prior.sizes) for solution in solutions]
        empty = cls(prior, tuple(MotionNoise.before(fit) for fit in fits), np.empty(0), loss_by_run)
        starts = empty._starts(solutions)
        left = [
            fit.without_trend(fit.measured - fit.computed(starts[:1, empty.columns(index)])[0])
            for index, fit in enumerate(fits)
        ]
        sensor = np.stack(_deviation_and_correlation(np.concatenate(left)[None]), axis=1)[0]
        nothing = [np.zeros(len(noise_directions(fit.record))) for fit in fits]
        return empty.at(starts[0], nothing, sensor).at_mode(starts).nearest()

    @classmethod
    def from_fit(cls, fit: RecordFit, prior: Prior) -> Problem:
        """Search the least squares, then the mode, and linearise there."""
        return cls.about(fit.solution(), prior)

    def _starts(self, solutions: Sequence[Solution]) -> Array:
        """Return values of wall and damper from which the mode is looked for; the first explain the records best."""
        estimates = [solution.estimate for solution in solutions]
        others = [solution.local_minima[:STARTS] for solution in solutions]
        starts = np.concatenate([[estimate, *other] for estimate, other in zip(estimates, others, strict=True)])
        candidate = self.fit.candidate
        if len(solutions) > 1:
            starts = starts[np.argsort([sum(self._misfits(start)) for start in starts], kind="stable")]
        if self.loss_by_run:
            # Each run's loss is that of its least squares; the wall is that of any.
            losses = [estimate[2] for estimate in estimates]
            starts = np.array([[*start[:2], *losses] for start in starts])
        if "order" in candidate.parameters:
            starts = np.array([[*start, order] for start in starts for order in ORDERS])
        middle = [float(self.prior.distribution(name).quantile(0.5)) for name in self.prior.sizes]
        return np.array([[*start, *middle] for start in starts])

    def _misfits(self, estimate: Array) -> Iterator[float]:
        """Yield the sum of squares that an estimate, shape (3,), leaves of each run, over the sensor's variance."""
        for run in self.runs:
            known = replace(run.fit, sizes=())
            left = known.without_trend(known.measured - known.computed(estimate[None])[0])
            yield float(left @ left) / known.rest_deviation**2

    def at(self, estimate: Array, noises: Sequence[Array], sensor: Array) -> Problem:
        """Linearise the response about values of wall and damper, a noise of each run, and the sensor's; no mode."""
        runs = []
        for index, (run, noise) in enumerate(zip(self.runs, noises, strict=True)):
            fit = run.fit.with_motion(run.fit.record.ground_acceleration)
            trend = fit.trend.T * np.array([[self.prior.sensor_zero], [self.prior.sensor_drift]])
            runs.append(MotionNoise.at(fit, estimate[self.columns(index)], noise, trend, sensor))
        return replace(self, runs=tuple(runs), mode=np.empty(0))

    @property
    def fit(self) -> RecordFit:
        """Return the first run's fit."""
        return self.runs[0].fit

    @property
    def names(self) -> tuple[str, ...]:
        """The sampled parameters."""
        candidate = self.fit.candidate
        a1, b1, loss, *order = candidate.parameters
        losses = [f"{loss} {run + 1}" for run in range(len(self.runs))] if self.loss_by_run else [loss]
        return (a1, b1, *losses, *order, *self.prior.sizes, *INSTRUMENTS)

    def columns(self, run: int) -> list[int]:
        """Return which of the values are those of wall and damper of a run."""
        count = len(self.names) - len(INSTRUMENTS)
        if not self.loss_by_run:
            return list(range(count))
        return [0, 1, 2 + run, *range(2 + len(self.runs), count)]

    def values(self, points: Array) -> Array:
        """Return the values of points of the unit cube, shape (batch, parameters)."""
        return self.prior.values(self.names, points)

    def response(self, values: Array, run: int = 0) -> tuple[Array, Array]:
        """Return a run's displacement for rows of values, under the noise of the motion that its record asks for. [m]

        Beside it stands the part of the measured displacement that is left for the instruments' errors. [m]
        """
        return self.runs[run].response(values[:, self.columns(run)], values[:, -2], values[:, -1])

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
        total = np.zeros(len(values))
        for index, run in enumerate(self.runs):
            computed, left = self.response(values, index)
            likelihood = run.noise.log_likelihood(left, values[:, -2], values[:, -1])
            largest = np.abs(computed).max(axis=1)
            u_ins = run.fit.mechanism(values[:, self.columns(index)]).instability_displacement
            rocks = (largest > values[:, 0] * u_ins) & (largest < LOST * u_ins)
            total += np.where(rocks, likelihood, -np.inf)
        density[inside] = total
        return density

    def drawn(self, effective: float, seed: int) -> tuple[Problem, Draws]:
        """Draw from the posterior until enough draws are effective; return the problem about the mode with them.

        Where the response to the noise of the motion is not linear at the draws, or they take too long, they start
        again with a noise that is corrected at each of them. It raises `InputError` if that does not help either.
        """
        try:
            problem, draws = self._drawn(effective, seed)
            if problem.beyond_linear(draws) <= LINEAR:
                return problem, draws
        except InputError:
            problem = self
        try:
            problem, draws = problem._corrected()._drawn(effective, seed)
        except InputError as error:
            raise InputError(f"{error}; {self._sensitivity()}") from None
        share = problem.beyond_linear(draws)
        if not share <= LINEAR:
            raise InputError(
                f"the response to the noise of the measured motion differs from a linear one by {share:.2g} of the"
                f" sensor's deviation; it must be at most {LINEAR}; {self._sensitivity()}"
            )
        return problem, draws

    def _corrected(self) -> Problem:
        """Search the mode again by finer steps of the solver, and correct the noise at each point from there on."""
        fine = tuple(replace(run, fit=run.fit.with_step(FINER * run.fit.step)) for run in self.runs)
        values = self.values(self.mode[None])
        about = replace(self, runs=fine).at(values[0, :-2], [run.about for run in self.runs], values[0, -2:])
        about = about.at_mode(values[:, :-2]).nearest()
        runs = tuple(replace(run, corrected=True) for run in about.runs)
        return replace(about, runs=runs).at_mode(about.values(about.mode[None])[:, :-2])

    def _drawn(self, effective: float, seed: int) -> tuple[Problem, Draws]:
        """Draw as they are; where draws show a mode that is higher than the one of the search, start about that."""
        problem = self
        for _ in range(AGAIN):
            draws = sample(problem.log_density, problem._neighbourhood(), effective, seed)
            best = np.argmax(draws.log_density)
            if draws.log_density[best] < problem.log_density(problem.mode[None])[0] + HIGHER:
                break
            problem = problem.at_mode(problem.values(draws.points[best][None])[:, :-2])
            problem = problem if problem.runs[0].corrected else problem.nearest()
        return problem, draws

    def beyond_linear(self, draws: Draws) -> float:
        """Return by how much the response to the noise of the motion differs from a linear one, over the sensor's.

        Of several runs it is the largest.
        """
        values = self.values(draws.resampled(CHECKED, np.random.RandomState(CHECKED_SEED)))
        shares = []
        for index, run in enumerate(self.runs):
            beyond = run.beyond(values[:, self.columns(index)], values[:, -2], values[:, -1])
            shares.append(float(np.sqrt(np.mean((beyond / values[:, -2, None]) ** 2))))
        return max(shares)

    def _sensitivity(self) -> str:
        """Say by how much the noise of the motion moves the response, where that is why a record is refused."""
        moved = max(float(np.sqrt(np.einsum("kt,kt->t", run.effect, run.effect).max())) for run in self.runs)
        times = moved / min(run.fit.rest_deviation for run in self.runs)
        return (
            f"the accelerometer's noise moves the response by {1000 * moved:.2g} mm, {times:.2g} times the displacement"
            " sensor's: the wall rocks too long or too near to collapse for such noise"
        )

    def doubts(self, deviation: float) -> list[str]:
        """Return a warning if the model leaves more [m] of the records than the sensor's noise at rest."""
        times = deviation / max(run.fit.rest_deviation for run in self.runs)
        most = max(EXPLAINED, *(_by_chance(run.fit.resting) for run in self.runs))
        if times <= most:
            return []
        left = f"what {self.fit.candidate.name} leaves of the record is {times:.1f} times the sensor's noise at rest"
        return [f"{left}, {most:.1f} at most if a model is right: intervals tell what holds under this one alone"]

    # --- the mode: Gauss and Newton's method, from several starts at once

    def at_mode(self, starts: Array) -> Problem:
        """Return the same with the highest mode that is reached from parameters of wall and damper."""
        left = [
            run.fit.without_trend(run.fit.measured - run.fit.computed(starts[:, self.columns(index)]))
            for index, run in enumerate(self.runs)
        ]
        sensor = np.stack(_deviation_and_correlation(np.concatenate(left, axis=1)), axis=1)
        points = self._inside(self.prior.points(self.names, np.concatenate([starts, sensor], axis=1)))
        highest = self.log_density(points)
        rocks = np.isfinite(highest)
        if not rocks.any():
            raise InputError("the wall does not rock, or collapses, where the record is explained best")
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
        runs = [self._linear(points, index) for index in range(len(self.runs))]
        values = self.values(points)
        deviation, phi = values[:, -2], values[:, -1]
        steps = np.zeros_like(points)
        wall = points.shape[1] - len(INSTRUMENTS)
        gradient = np.zeros((len(points), wall))
        for run, (residuals, derivative) in zip(self.runs, runs, strict=True):
            gradient += np.einsum("bpt,bt->bp", derivative, run.noise.by_inverse(residuals, deviation, phi))
        precision = self._precision([derivative for _, derivative in runs], deviation, phi)
        steps[:, :wall] = np.linalg.solve(precision, -gradient[..., None])[..., 0]
        left = []
        for run, (residuals, derivative) in zip(self.runs, runs, strict=True):
            stepped = residuals + np.einsum("bp,bpt->bt", steps[:, :wall], derivative)
            left.append(run.noise.without_linear(stepped, deviation, phi))
        values[:, -2:] = np.stack(_deviation_and_correlation(np.concatenate(left, axis=1)), axis=1)
        steps[:, wall:] = self.prior.points(self.names, values)[:, wall:] - points[:, wall:]
        return steps

    def _linear(self, points: Array, run: int) -> tuple[Array, Array]:
        """Return a run's residuals at points, and derivatives by wall and damper, shape (batch, wall, samples)."""
        wall = points.shape[1] - len(INSTRUMENTS)
        shift = SHIFT * np.eye(wall, points.shape[1])
        around = np.concatenate([points[:, None], points[:, None] + shift, points[:, None] - shift], axis=1)
        values = self.values(around.reshape(-1, points.shape[1]))
        residuals = self.response(values, run)[1].reshape(len(points), 2 * wall + 1, -1)
        return residuals[:, 0], (residuals[:, 1 : wall + 1] - residuals[:, wall + 1 :]) / (2 * SHIFT)

    def _precision(self, derivatives: Sequence[Array], deviation: Array, phi: Array) -> Array:
        """Return the inverse covariance of wall and damper in the unit cube, shape (batch, wall, wall)."""
        count, wall, _ = derivatives[0].shape
        # The variance of the prior, 1/12, bounds that of what the records do not tell.
        precision = np.tile(12 * np.eye(wall), (count, 1, 1))
        for run, derivative in zip(self.runs, derivatives, strict=True):
            rows = derivative.reshape(count * wall, -1)
            weighted = run.noise.by_inverse(rows, np.repeat(deviation, wall), np.repeat(phi, wall))
            precision += np.einsum("bpt,bqt->bpq", derivative, weighted.reshape(count, wall, -1))
        return precision

    def nearest(self) -> Problem:
        """Linearise anew about the mode and search it there, until that explains the records no better."""
        problem = self
        for _ in track(range(ROUNDS), "mode of the posterior"):
            nearer = problem._nearer()
            if nearer is None:
                break
            problem = problem.at(*nearer).at_mode(problem.values(problem.mode[None])[:, :-2])
        return problem

    def _nearer(self) -> tuple[Array, list[Array], Array] | None:
        """Return values, a noise of each motion and the sensor's, that explain the records better than those here.

        Those of the mode do so in as far as the response is linear; None if nothing better is found.
        """
        values = self.values(self.mode[None])
        deviation, phi = values[:, -2], values[:, -1]
        asked = [run.mean(self.response(values, index)[1], deviation, phi)[0] for index, run in enumerate(self.runs)]

        def explained(part: float) -> tuple[float, list[Array]]:
            total, noises = 0.0, []
            for index, (run, noise) in enumerate(zip(self.runs, asked, strict=True)):
                estimate = run.parameters + part * (values[0, self.columns(index)] - run.parameters)
                z = run.about + part * (noise - run.about)
                left = run.fit.measured - run.under(z).computed(estimate[None])
                total += float(Noise(run.noise.rows[:2]).log_likelihood(left, deviation, phi)[0] - 0.5 * z @ z)
                noises.append(z)
            return total, noises

        here = explained(0.0)[0]
        tried = [(*explained(float(part)), float(part)) for part in PARTS]
        best, noises, part = max(tried, key=lambda one: one[0])
        before = self._before(values)
        return (before + part * (values[0, :-2] - before), noises, values[0, -2:]) if best > here + GAINED else None

    def _before(self, values: Array) -> Array:
        """Return the values of wall and damper about which the response is linearised."""
        before = values[0, :-2].copy()
        for index, run in enumerate(self.runs):
            before[self.columns(index)] = run.parameters
        return before

    def _neighbourhood(self) -> Neighbourhood:
        """Guess the posterior: normal about the mode, by what the linear problem tells of each parameter."""
        points = self.mode[None]
        values = self.values(points)
        deviation, phi = values[:, -2], values[:, -1]
        wall = points.shape[1] - len(INSTRUMENTS)
        covariance = np.zeros((points.shape[1], points.shape[1]))
        derivatives = [self._linear(points, index)[1] for index in range(len(self.runs))]
        covariance[:wall, :wall] = np.linalg.inv(self._precision(derivatives, deviation, phi)[0])
        # Fisher's information of a correlated series: of the logarithm of its deviation, and of its correlation.
        variance, samples = 1 - phi[0] ** 2, sum(run.fit.measured.size for run in self.runs)
        fisher = np.array([[0.5 + phi[0] ** 2 / variance, phi[0]], [phi[0], variance]]) / samples
        apart = values + [*np.zeros(wall), SHIFT * deviation[0], SHIFT]
        slope = ((self.prior.points(self.names, apart) - points)[0, wall:]) / SHIFT
        covariance[wall:, wall:] = fisher * slope * slope[:, None]
        return Neighbourhood(self.mode, np.asarray(np.linalg.cholesky(covariance), dtype=float))


def _deviation_and_correlation(residuals: Array) -> tuple[Array, Array]:
    """Return the standard deviation of residuals, shape (batch, samples), and the correlation of neighbours."""
    square = np.einsum("bt,bt->b", residuals, residuals)
    phi = np.clip(np.einsum("bt,bt->b", residuals[:, 1:], residuals[:, :-1]) / square, *CORRELATION)
    return np.sqrt(square / residuals.shape[1]), phi


def _by_chance(samples: Array) -> float:
    """Return how many times their standard deviation that of what samples are drawn from may be, once in `RARELY`."""
    away = samples - samples.mean()
    phi = float(_deviation_and_correlation(away[None])[1][0])
    independent = max(samples.size * (1 - phi**2) / (1 + phi**2), 2.0)
    return float(np.sqrt((independent - 1) / chi2.ppf(1 / RARELY, independent - 1)))
