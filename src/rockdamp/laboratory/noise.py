r"""Likelihood of residuals under errors of the instruments: the sensor's zero, drift and noise, the motion's noise.

The residual of a model, measured less computed, is taken as

.. math:: r = B^T z + n, \qquad z \sim N(0, I), \qquad n_t = \varphi \, n_{t-1} + \sigma \sqrt{1 - \varphi^2} \,
          \epsilon_t

The rows of B are the sensor's zero and drift times their standard deviations, and the directions in which noise of the
measured motion shifts the response. What is linear with a normal prior is integrated out in closed form, so that the
sampler meets sigma and phi alone: with K = R + B^T B, R the covariance of n, the inverse and the determinant of K come
from matrices as large as B has rows (Woodbury), and the inverse of R is tridiagonal.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rockdamp.arrays import Array


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
