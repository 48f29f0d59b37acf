r"""Losses of a specimen's impacts: their mean, their scatter, and how they depend on the amplitude.

The loss delta = -ln e of impact k, measured with a known covariance C, is taken as

.. math:: \delta_k = m_k(\beta) + s \, \epsilon_k + \text{error}_k, \qquad \epsilon_k \sim N(0, 1),
          \qquad \text{error} \sim N(0, C)

with m_k one coefficient of restitution, a multiple of what a viscous damper loses on this curve, or the law of loss by
the energy before the impact. The scatter s from impact to impact is estimated too: with a good sensor, it dominates the
uncertainty of a large specimen's e.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import least_squares, minimize_scalar

from rockdamp.arrays import Array

LARGEST_LOSS = 10.0  # of an impact that stops the wall
SMALLEST_LOSS = SMALLEST_SCATTER = 1e-6


class Regression(NamedTuple):
    """Coefficients of a regression and their covariance, the scatter s, and ln of the likelihood."""

    coefficients: Array
    covariance: Array
    scatter: float
    log_likelihood: float


def regress(losses: Array, covariance: Array, design: Array, restricted: bool = True) -> Regression:
    """Fit multiples of shapes to losses by generalised least squares, with the most likely scatter.

    The likelihood of the scatter is restricted (REML), which leaves no bias from the estimation of the coefficients,
    or plain, by which shapes are compared. The covariance is Hartung and Knapp's (doi:10.1002/sim.791): it takes the
    residuals as they are, where they are larger than expected.

    Parameters
    ----------
    losses : ndarray, shape (impacts,)
    covariance : ndarray, shape (impacts, impacts)
        By the sensor.
    design : ndarray, shape (impacts, shapes)
    restricted : bool
    """
    values, vectors = np.linalg.eigh(covariance)
    y, x = vectors.T @ losses, vectors.T @ design

    def parts(scatter: float) -> tuple[Array, Array, float, float]:
        variance = np.maximum(values, 0.0) + scatter**2
        information = x.T @ (x / variance[:, None])
        beta = np.linalg.solve(information, x.T @ (y / variance))
        square = float(np.sum((y - x @ beta) ** 2 / variance))
        return (
            beta,
            information,
            square,
            -0.5 * (square + float(np.sum(np.log(2 * np.pi * variance)))),
        )

    def cost(scatter: float) -> float:
        _, information, _, log_likelihood = parts(scatter)
        return -log_likelihood + (
            0.5 * float(np.linalg.slogdet(information)[1]) if restricted else 0.0
        )

    found = minimize_scalar(
        cost, bounds=(SMALLEST_SCATTER, 1.0), method="bounded", options={"xatol": 1e-7}
    )
    scatter = min(float(found.x), SMALLEST_SCATTER, key=cost)
    beta, information, square, log_likelihood = parts(scatter)
    inflation = max(square / max(y.size - beta.size, 1), 1.0)
    return Regression(
        beta, np.asarray(inflation * np.linalg.inv(information)), scatter, log_likelihood
    )


def law_of_loss(log_energy: Array, decrement: float, g: float) -> Array:
    """Return the losses by the energies before the impacts, ln E less ln of that at which the loss is `decrement`.

    The energy left to the power g falls by the same at each impact, docs/theory.md, section 8:
    delta(E) = -ln(1 - (1 - exp(-2 g delta_r)) (E_r/E)^g) / (2 g). An impact that stops the wall has `LARGEST_LOSS`.
    """
    if abs(g) < 1e-9:
        return np.full(log_energy.shape, decrement)
    change = np.exp(-g * log_energy) * np.expm1(-2 * g * decrement)  # of E^g, over it
    return np.minimum(-np.log1p(np.maximum(change, -1 + 1e-12)) / (2 * g), LARGEST_LOSS)


def fit_law(losses: Array, covariance: Array, log_energy: Array) -> tuple[Array, Array]:
    """Return the loss at the energy of logarithm 0 and g of the law of loss, and their covariance."""
    point = np.array([max(float(losses.mean()), 2 * SMALLEST_LOSS), 0.0])
    scatter = regress(losses, covariance, np.ones((losses.size, 1))).scatter
    for _ in range(4):  # of the law and the scatter about it
        root = np.asarray(
            np.linalg.cholesky(covariance + scatter**2 * np.eye(losses.size)), dtype=float
        )

        def residual(point: Array, root: Array = root) -> Array:
            return solve_triangular(root, law_of_loss(log_energy, *point) - losses, lower=True)

        bounds = [SMALLEST_LOSS, -3.0], [LARGEST_LOSS, 3.0]
        found = least_squares(residual, point, bounds=bounds, x_scale=(0.1, 0.3), jac="3-point")
        point = found.x
        local = regress(losses - law_of_loss(log_energy, *point), covariance, root @ found.jac)
        scatter = local.scatter
    return point, local.covariance


def loss_at(point: Array, covariance: Array, log_energy: float) -> tuple[float, float]:
    """Return the loss at an energy by a fitted law, and its standard error."""
    h, at = 1e-5, np.array([log_energy])
    sides = [
        (law_of_loss(at, *(point + d)) - law_of_loss(at, *(point - d)))[0] / (2 * h)
        for d in h * np.eye(2)
    ]
    gradient = np.array(sides)
    return float(law_of_loss(at, *point)[0]), float(np.sqrt(gradient @ covariance @ gradient))
