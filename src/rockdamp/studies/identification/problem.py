"""What a record, a damping model and a prior make of wall, damper and instruments: the density of the posterior."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.studies.candidates import SEARCHED_ORDER
from rockdamp.studies.identification.modes import Mode, climb, triangular
from rockdamp.studies.identification.noise import Noise
from rockdamp.studies.identification.prior import Prior
from rockdamp.studies.least_squares import DRAWS, LOST, Fit, Solution

# The standard deviation and correlation of the displacement sensor's noise, and a factor on the measured motion.
INSTRUMENTS = ("sensor_deviation", "sensor_correlation", "motion_gain")
NEAREST = 1e-3  # to an end of the prior, of its width, at the start
# Of the central difference by the gain: as large as the noise itself, lest the solver's roughness show.
GAIN_STEP = 1e-3
FARTHEST = 8.0  # the gain's deviations at most
KEPT_SHARE = 0.999  # of the variance of what the motion's noise shifts, by the directions that are kept
MOST_DIRECTIONS = 16
ROUGH_DRAWS = 32  # of the motion's noise, where its effect is needed about the least squares alone
STARTS = 4  # local minima of the scan from which modes are looked for, beside the least squares
# A poor model leaves what correlated noise explains better than white: its mode may be another minimum's.
WIDER = 5.0  # the scale about those, as they are no more than points of a grid
NOISE_SCALE = (0.1, 0.05)  # of the noise's deviation, in its logarithm, and of its correlation
BELOW = 20.0  # the highest mode, in the logarithm of the density: what is lower is no part of the posterior
ORDERS = 8  # of the damper of any order, at each of which the mode of the other parameters is looked for


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
    found: tuple[Mode, ...]  # modes of the posterior, before its noise was known about the highest of them

    @classmethod
    def about(cls, solution: Solution, prior: Prior) -> Problem:
        """Climb from the least squares and from other minima to the highest mode, and say what surrounds it.

        Raises
        ------
        InputError
            If the wall is so near to collapse that the noise of the measured motion decides on it, or if it does not
            rock where the record is explained best.
        """
        rough = cls._about(solution, prior, ROUGH_DRAWS)
        modes = rough._distinct(rough._climb(centre, lower, rough._told) for centre, lower in rough._starts())
        estimate = rough.values(modes[0].centre[None])[0, :3]
        return cls._about(solution.about(estimate), prior, DRAWS, tuple(modes))

    @classmethod
    def of(cls, fit: Fit, prior: Prior) -> Problem:
        """Search the least squares, and do as `about`."""
        return cls.about(fit.solution(), prior)

    @classmethod
    def _about(cls, solution: Solution, prior: Prior, draws: int, found: tuple[Mode, ...] = ()) -> Problem:
        """Find what the noise of the measured motion does to the response about some parameters.

        Mostly it does what a slightly larger or smaller motion would do. This is far from linear against the sensor's
        noise, and so a factor on the motion is sampled; what is left of it is small, and taken as linear.
        """
        fit = solution.fit
        shifts = fit.shifts_by_motion(solution.estimate, solution.computed, draws)
        if np.abs(shifts).max() > LOST / 2 * fit.u_ins:
            raise InputError("the wall is so near to collapse that the noise of the measured motion decides on it")
        sides = fit.computed(np.stack([solution.estimate] * 2), 1 + GAIN_STEP * np.array([1.0, -1.0]))
        by_gain = (sides[0] - sides[1]) / (2 * GAIN_STEP)
        gains = np.einsum("it,t->i", shifts, by_gain) / np.einsum("t,t->", by_gain, by_gain)
        variance = np.mean(gains**2)
        together = np.einsum("i,it->t", gains, shifts) / len(gains) / variance
        trend = fit.trend.T * np.array([[prior.sensor_zero], [prior.sensor_drift]])
        rows = np.concatenate([trend, _directions(shifts - gains[:, None] * together)])
        return cls(fit, prior, solution, Noise(rows), float(np.sqrt(variance)), by_gain, together - by_gain, found)

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

    @cached_property
    def modes(self) -> list[Mode]:
        """Modes that are part of the posterior, the highest first; where the order is free, one at each of several."""
        if "order" in self.names:
            return self._distinct(self._along_orders(self.found[0]))
        return self._distinct(self._climb(mode.centre, mode.lower, self._told) for mode in self.found)

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
        coordinates = np.append(self.prior.coordinates(self.names[:-1], values)[0], 0.0)
        return np.clip(coordinates, low + margin, high - margin)

    @property
    def _scale(self) -> Array:
        """Root of the covariance of all parameters but the order, by the linear problem about the least squares.

        It has the instruments' errors as unknowns beside them.
        """
        low, high = self.bounds
        deviation, phi = _deviation_and_correlation(self.solution.residual)
        by_gain = self.fit.without_trend(self.by_gain + self.beside_gain)[None] * self.gain_deviation
        slope = self.solution.estimate[:1] if self.prior.cracked_stiffness_ratio.distribution == "loguniform" else [1.0]
        design = np.concatenate([self.solution.derivative.T * [slope, [1.0], [1.0]], by_gain, self.noise.rows])
        variance = deviation**2 * (1 + phi) / (1 - phi)
        known = np.concatenate([1 / (high - low)[:3] ** 2, np.ones(1 + len(self.noise.rows))])
        covariance = np.linalg.inv(np.einsum("it,jt->ij", design, design) / variance + np.diag(known))
        lower = np.diag([1.0, 1.0, 1.0, *NOISE_SCALE, 1.0])
        parameters = [0, 1, 2, 5]
        lower[np.ix_(parameters, parameters)] = np.linalg.cholesky(covariance[:4, :4])
        return lower


def _deviation_and_correlation(residual: Array) -> tuple[float, float]:
    """Of what a model leaves: its standard deviation, and the correlation of neighbours."""
    phi = float(np.clip(residual[1:] @ residual[:-1] / (residual @ residual), 0.01, 0.98))
    return float(np.sqrt(np.mean(residual**2))), phi


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
