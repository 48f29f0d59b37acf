r"""Likelihood of residuals under errors of the instruments: the sensor's zero, drift and noise, the motion's noise.

The residual of a model, measured less computed, is taken as

.. math:: r = B^T z + n, \qquad z \sim N(0, I), \qquad n_t = \varphi \, n_{t-1} + \sigma \sqrt{1 - \varphi^2} \,
          \epsilon_t

The rows of B are the sensor's zero and drift times their standard deviations, and the directions in which noise of the
measured motion shifts the response. What is linear with a normal prior is integrated out in closed form, so that the
sampler meets sigma and phi alone: with K = R + B^T B, R the covariance of n, the inverse and the determinant of K come
from matrices as large as B has rows (Woodbury), and the inverse of R is tridiagonal.

Effect of the noise of the measured motion on the response.

The motion that moved the wall is the measured one and a noise, whose directions have standard normal coefficients z. A
wall that rocks long responds to that noise with far more than the displacement sensor's, and not in proportion to it.
But the record tells its trajectory to within the sensor's noise. So the response is linearised about the noise z that
leads to the record's trajectory, which is another one for other parameters:

.. math:: z_0(\theta) = z_0 + Z \, (\theta - \theta_0)

What is left of z is integrated out, as linear. Where the response is too far from linear for that, z_0 is corrected at
each theta by a few steps of Gauss and Newton from there, along the main directions of the effect, with the derivatives
as they are: what is left of z is then small.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.histories.measured_test import motion_noise
from rockdamp.laboratory.least_squares import DRAWS_SEED, LOST, RecordFit
from rockdamp.motions.records import Record

# --- the sensor's errors ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Noise:
    """The linear part of the instruments' errors, B of shape (directions, samples) [m], with what likelihoods need."""

    rows: Array

    @cached_property
    def _grams(self) -> tuple[Array, Array, Array]:
        b = self.rows
        return product(b, b), product(b[:, 1:-1], b[:, 1:-1]), product(b[:, :-1], b[:, 1:])

    def log_likelihood(self, residuals: Array, deviation: Array, correlation: Array) -> Array:
        """Return the logarithm of the density of residuals; zero, drift and the motion's noise are integrated out.

        Residuals, measured less computed [m], have the shape (batch, samples). The deviation sigma [m] and the
        correlation phi between a sample and the next, in (-1, 1), have the shape (batch,).
        """
        samples, variance, phi = residuals.shape[1], deviation**2, correlation
        weighted, precision, projected = self._conditional(residuals, deviation, phi)
        lower = np.linalg.cholesky(precision)
        half = np.linalg.solve(lower, projected[..., None])[..., 0]
        square = np.einsum("ij,ij->i", residuals, weighted) - np.einsum("ij,ij->i", half, half)
        log_determinant = samples * np.log(variance) + (samples - 1) * np.log1p(-(phi**2))
        log_determinant += 2 * np.log(np.diagonal(lower, axis1=1, axis2=2)).sum(axis=1)
        return -0.5 * (square + log_determinant + samples * np.log(2 * np.pi))

    def draw(self, residuals: Array, deviation: Array, correlation: Array, random: np.random.RandomState) -> Array:
        """Draw z of each residual, given sigma and phi; shape (batch, directions)."""
        _, precision, projected = self._conditional(residuals, deviation, correlation)
        mean = np.linalg.solve(precision, projected[..., None])[..., 0]
        lower = np.linalg.cholesky(precision)
        normal = random.standard_normal(mean.shape)
        return np.asarray(mean + np.linalg.solve(lower.swapaxes(1, 2), normal[..., None])[..., 0], dtype=float)

    def mean(self, residuals: Array, deviation: Array, correlation: Array) -> Array:
        """Return the mean of z by residuals, shape (batch, samples); shape (batch, directions)."""
        _, precision, projected = self._conditional(residuals, deviation, correlation)
        return np.asarray(np.linalg.solve(precision, projected[..., None])[..., 0])

    def without_linear(self, residuals: Array, deviation: Array, correlation: Array) -> Array:
        """Subtract the mean of the linear part from residuals, shape (batch, samples): noise n is left. [m]"""
        mean = self.mean(residuals, deviation, correlation)
        return residuals - np.einsum("ik,kt->it", mean, self.rows)

    def by_inverse(self, residuals: Array, deviation: Array, correlation: Array) -> Array:
        """Multiply residuals, shape (batch, samples), by the inverse of K, by sigma and phi of each. [m-1]"""
        left = self.without_linear(residuals, deviation, correlation)
        return _by_inverse(left, correlation) / deviation[:, None] ** 2

    def _conditional(self, residuals: Array, deviation: Array, phi: Array) -> tuple[Array, Array, Array]:
        """Multiply residuals by the inverse of R; precision of z, and precision times mean, given these."""
        variance = deviation**2
        weighted = _by_inverse(residuals, phi) / variance[:, None]
        whole, inner, neighbours = self._grams
        p = phi[:, None, None]
        gram = whole + p**2 * inner - p * (neighbours + neighbours.T)
        precision = np.eye(len(whole)) + gram / ((1 - p**2) * variance[:, None, None])
        return weighted, precision, product(weighted, self.rows)


def correlated(deviation: float, correlation: float, normal: Array) -> Array:
    """Make noise of a standard deviation and correlation of neighbours from independent standard normal numbers."""
    noise, before = np.empty_like(normal), normal[0]
    scale = np.sqrt(1 - correlation**2)
    noise[0] = before
    for index in range(1, normal.size):
        before = correlation * before + scale * normal[index]
        noise[index] = before
    return deviation * noise


def _by_inverse(residuals: Array, phi: Array) -> Array:
    """Multiply rows by the inverse of the correlation matrix, phi to the power of the distance in samples."""
    p = phi[:, None]
    product = (1 + p**2) * residuals
    product[:, [0, -1]] = residuals[:, [0, -1]]
    product[:, 1:] -= p * residuals[:, :-1]
    product[:, :-1] -= p * residuals[:, 1:]
    return product / (1 - p**2)


def product(one: Array, other: Array) -> Array:
    """Return one @ other.T, summed in the same order on any number of cores."""
    return np.einsum("it,jt->ij", one, other)


# --- noise of the measured motion -------------------------------------------------------------------------------------

MOST_DIRECTIONS = 2048  # of the noise: each sample is one, or as many are drawn where there are more samples
NEGLIGIBLE = 0.1  # of the sensor's deviation at rest: what is left of the noise's effect beside its main directions
MOST_ROWS = 64
CORRECTIONS = 4  # steps of Gauss and Newton
SMALLEST_CHANGE = 1e-6  # of a parameter, that no record tells; where it decides, matrices of derivatives are singular
# Of the parameters' standard deviations: so far from theta_0 the noise follows them. There it may be another mode.
NEAR = 8.0


@dataclass(frozen=True)
class MotionNoise:
    """The response's change by the noise of the motion, about parameters and a noise."""

    fit: RecordFit  # under the measured motion and the noise z_0
    directions: Array  # of the noise, shape (directions, samples) [m s-2]
    parameters: Array  # theta_0, of which the noise follows all but the order of a damper
    about: Array  # z_0, shape (directions,)
    effect: Array  # derivative of the response by z, shape (directions, samples) [m]
    derivative: Array  # of the response by the parameters that the noise follows, shape (3 or more, samples) [m]
    noise: Noise  # the sensor's zero and drift, and the main directions of the effect
    follows: Array  # Z, shape (directions, 3 or more)
    precision: Array  # of the parameters that it follows, by the linear problem
    corrected: bool = False  # z_0 at each theta

    @classmethod
    def before(cls, measured: RecordFit) -> MotionNoise:
        """Return an empty linearisation, of a fit that has the measured motion."""
        nothing = np.empty((0, 0))
        return cls(measured, nothing, nothing, nothing, nothing, nothing, Noise(nothing), nothing, nothing)

    @classmethod
    def at(
        cls, measured: RecordFit, parameters: Array, about: Array, trend: Array, sensor: Array | tuple[float, float]
    ) -> MotionNoise:
        """Linearise the response of a fit that has the measured motion.

        It raises `InputError` where the noise, or next to nothing, decides on whether the wall collapses.
        """
        directions = noise_directions(measured.record)
        acceleration = measured.record.ground_acceleration + about @ directions
        fit = measured.with_motion(acceleration)
        effect, derivative = fit.tangent(parameters, directions)
        moved = SMALLEST_CHANGE * float(np.abs(derivative).max()) / fit.u_ins
        if not moved < 1:
            raise InputError(
                f"the response cannot be linearised where the record is explained best: a change of a parameter by"
                f" {SMALLEST_CHANGE:g} moves the wall by {moved:.2g} u_ins, as near to collapse"
            )
        # The noise of one standard deviation that shifts the response most, where it shifts it most.
        at = int(np.argmax(np.einsum("kt,kt->t", effect, effect)))
        worst = effect[:, at] @ directions / max(float(np.linalg.norm(effect[:, at])), np.finfo(float).tiny)
        sides = [measured.with_motion(acceleration + side * worst).computed(parameters[None]) for side in (-1.0, 1.0)]
        if np.abs(sides).max() >= LOST * fit.u_ins:
            raise InputError("the wall is so near to collapse that the noise of the measured motion decides on it")
        noise = Noise(np.concatenate([trend, main_directions(effect, (NEGLIGIBLE * fit.rest_deviation) ** 2)]))
        deviation, correlation = (np.full(len(derivative), value) for value in sensor)
        weighted = noise.by_inverse(derivative, deviation, correlation)
        follows = -np.einsum("kt,pt->kp", effect, weighted)
        precision = np.einsum("pt,qt->pq", derivative, weighted)
        return cls(fit, directions, parameters, about, effect, derivative, noise, follows, precision)

    def response(self, parameters: Array, deviation: Array, correlation: Array) -> tuple[Array, Array]:
        """Return the displacement for parameters and the sensor's noise, and the residual that is linear in z. [m]

        Shapes (batch, samples). The displacement is that under z_0.
        """
        if not self.corrected:
            computed = self.computed(parameters)
            return computed, self.residuals(parameters, computed)
        computed, residuals, _ = self._corrected(parameters, deviation, correlation)
        return computed, residuals

    def beyond(self, parameters: Array, deviation: Array, correlation: Array) -> Array:
        """Subtract a linear response from that to the noise that explains the record, shape (batch, samples). [m]"""
        if not self.corrected:
            computed = self.computed(parameters)
            noise = self.mean(self.residuals(parameters, computed), deviation, correlation)
            return self.beyond_linear(parameters, computed, noise)
        computed, residuals, about = self._corrected(parameters, deviation, correlation)
        along = self.noise.mean(residuals, deviation, correlation)[:, 2:]
        linear = computed + np.einsum("bk,kt->bt", along - about, self.noise.rows[2:])
        return self._along(parameters, along) - linear

    def _corrected(self, parameters: Array, deviation: Array, correlation: Array) -> tuple[Array, Array, Array]:
        """Return the displacement under the corrected z_0, the residual, and z_0 along the main directions."""
        rows = self.noise.rows[2:]
        about = self.about @ self._main + self._followed(parameters) @ (self.follows.T @ self._main)
        for _ in range(CORRECTIONS):
            residuals = self.fit.measured - self._along(parameters, about) + np.einsum("bk,kt->bt", about, rows)
            about = self.noise.mean(residuals, deviation, correlation)[:, 2:]
        computed = self._along(parameters, about)
        return computed, self.fit.measured - computed + np.einsum("bk,kt->bt", about, rows), about

    @cached_property
    def _main(self) -> Array:
        """The main directions among those of the noise, shape (directions, main directions)."""
        rows = self.noise.rows[2:]
        return np.asarray(np.linalg.solve(product(rows, rows), product(rows, self.effect)).T, dtype=float)

    @cached_property
    def _beside(self) -> RecordFit:
        """The fit under that part of z_0 which has no part in the main directions."""
        beside = self.about - self._main @ (self.about @ self._main)
        return self.under(beside)

    def _along(self, parameters: Array, along: Array) -> Array:
        """Displacement under a noise along the main directions, shape (batch, main directions). [m]"""
        if not along.shape[1]:
            return self._beside.computed(parameters)
        return self._beside.computed(parameters, self._main_motions, along.T)

    @cached_property
    def _main_motions(self) -> Array:
        """The main directions at the solver's steps, shape (main directions, steps + 1). [m s-2]"""
        return self._beside.at_steps(np.einsum("km,ks->ms", self._main, self.directions))

    @cached_property
    def _shift(self) -> tuple[Array, Array]:
        """Return what z_0 and Z add to the response, shape (samples,) and (3 or more, samples). [m]"""
        by_parameters = np.einsum("kp,kt->pt", self.follows, self.effect)
        return np.einsum("k,kt->t", self.about, self.effect), by_parameters

    @cached_property
    def _motions(self) -> Array:
        """The noise that follows the parameters, at the solver's steps, shape (3 or more, steps + 1). [m s-2]"""
        return self.fit.at_steps(np.einsum("kp,ks->ps", self.follows, self.directions))

    def _followed(self, parameters: Array) -> Array:
        """Return how far the noise follows parameters, shape (batch, 3 or more)."""
        away = self.fit.followed(parameters) - self.fit.followed(self.parameters)
        square = np.einsum("bp,pq,bq->b", away, self.precision, away)
        return np.asarray(away * np.exp(-0.5 * square / NEAR**2)[:, None])

    def computed(self, parameters: Array) -> Array:
        """Displacement under z_0 of parameters, shape (batch, samples). [m]"""
        return self.fit.computed(parameters, self._motions, self._followed(parameters).T)

    def residuals(self, parameters: Array, computed: Array) -> Array:
        """Subtract the response from the measured displacement, as far as it is linear for noise of mean zero. [m]"""
        shift, by_parameters = self._shift
        return self.fit.measured - computed + shift + np.einsum("bp,pt->bt", self._followed(parameters), by_parameters)

    def mean(self, residuals: Array, deviation: Array, correlation: Array) -> Array:
        """Return the mean of z by residuals, shape (batch, samples); shape (batch, directions)."""
        weighted = self.noise.by_inverse(residuals, deviation, correlation)
        return np.asarray(np.einsum("kt,bt->bk", self.effect, weighted))

    def under(self, noise: Array) -> RecordFit:
        """Return the fit under a noise, shape (directions,), in place of `about`."""
        return self.fit.with_motion(self.fit.record.ground_acceleration + noise @ self.directions)

    def beyond_linear(self, parameters: Array, computed: Array, noise: Array) -> Array:
        """Subtract a linear response from that to noise, shape (batch, directions); shape (batch, samples). [m]

        `computed` is the response to the noise that follows the parameters.
        """
        shift, by_parameters = self._shift
        linear = computed + np.einsum("bk,kt->bt", noise, self.effect) - shift
        linear = linear - np.einsum("bp,pt->bt", self._followed(parameters), by_parameters)
        accelerations = self.fit.record.ground_acceleration + np.stack([z @ self.directions for z in noise])
        under = [replace(self.fit, motion=motion) for motion in self.fit.at_steps(accelerations)]
        exact = [fit.computed(row[None])[0] for fit, row in zip(under, parameters, strict=True)]
        return np.stack(exact) - linear


def noise_directions(record: Record) -> Array:
    """Return motions that sum up to the accelerometer's noise, white, with standard normal coefficients. [m s-2]"""
    deviation, samples = motion_noise(record), record.elapsed.size
    if samples <= MOST_DIRECTIONS:
        return deviation * np.eye(samples)
    random = np.random.RandomState(DRAWS_SEED)
    return deviation / np.sqrt(MOST_DIRECTIONS) * random.standard_normal((MOST_DIRECTIONS, samples))


def main_directions(effect: Array, negligible: float) -> Array:
    """Return the principal directions of the effect: rows with the same covariance, but for a negligible variance.

    By Cholesky's decomposition with pivots, cut short: few rows hold nearly all, and the order of its sums is the same
    on any number of cores.
    """
    variance = np.einsum("kt,kt->t", effect, effect)
    rows, left = np.empty((0, variance.size)), variance.copy()
    while len(rows) < MOST_ROWS and left.max() > negligible:
        pivot = int(np.argmax(left))
        row = np.einsum("k,kt->t", effect[:, pivot], effect)
        row = (row - np.einsum("k,kt->t", rows[:, pivot], rows)) / np.sqrt(left[pivot])
        rows, left = np.concatenate([rows, row[None]]), np.maximum(left - row**2, 0.0)
    return rows
