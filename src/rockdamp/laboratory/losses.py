r"""Losses of a specimen's impacts: their mean, their scatter, and their law by the amplitude.

The loss delta = -ln e of impact k, measured with a known covariance C, is taken as

.. math:: \delta_k = m_k(\beta) + s \, \epsilon_k + \text{error}_k, \qquad \epsilon_k \sim N(0, 1),
          \qquad \text{error} \sim N(0, C)

with m_k one restitution coefficient, a multiple of the losses of a viscous damper on this curve, or
the law of loss by the energy before the impact. The scatter s from impact to impact is estimated
too: with a good sensor, it dominates the uncertainty of a large specimen's e.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import least_squares, minimize_scalar

from rockdamp.arrays import Array
from rockdamp.laboratory.uncertainty import differentiate

STOPPING_LOSS = 10.0  # loss of an impact that stops the wall: e is 5e-5
SMALLEST_LOSS = 1e-6  # of a law, as a loss is positive
SMALLEST_SCATTER = 1e-6  # as no covariance may be singular


class Regression(NamedTuple):
    """Regression of losses.

    Parameters
    ----------
    coefficients : ndarray, shape (shapes,)
        Multiples of the shapes. [-]
    covariance : ndarray, shape (shapes, shapes)
        Covariance of the coefficients. [-]
    scatter : float
        Standard deviation from impact to impact. [-]
    log_likelihood : float
        Logarithm of the likelihood.
    """

    coefficients: Array
    covariance: Array
    scatter: float
    log_likelihood: float


class _WeightedFit(NamedTuple):
    """Weighted least squares at one scatter."""

    coefficients: Array
    information: Array
    square_sum: float
    log_likelihood: float


def regress(losses: Array, covariance: Array, design: Array, restricted: bool = True) -> Regression:
    """Fit multiples of shapes to losses by generalised least squares, with the most likely scatter.

    The covariance of the coefficients is Hartung and Knapp's (doi:10.1002/sim.791), which rises in
    proportion to the squares of the residuals; here it does not fall where they are smaller than
    expected.

    Parameters
    ----------
    losses : ndarray, shape (impacts,)
        Measured losses. [-]
    covariance : ndarray, shape (impacts, impacts)
        Covariance of the losses by the sensor.
    design : ndarray, shape (impacts, shapes)
        Shapes, one in each column.
    restricted : bool
        Use the restricted likelihood (REML), which leaves no bias from the estimation of the
        coefficients; otherwise the plain one, which compares shapes. Default: True.
    """
    # In the axes of the eigenvectors the losses are uncorrelated at any scatter.
    values, vectors = np.linalg.eigh(covariance)
    y = vectors.T @ losses
    x = vectors.T @ design

    def fit(scatter: float) -> _WeightedFit:
        variance = np.maximum(values, 0.0) + scatter**2
        information = x.T @ (x / variance[:, None])
        beta = np.linalg.solve(information, x.T @ (y / variance))
        square_sum = float(np.sum((y - x @ beta) ** 2 / variance))
        log_determinant = float(np.sum(np.log(2 * np.pi * variance)))
        return _WeightedFit(beta, information, square_sum, -0.5 * (square_sum + log_determinant))

    def cost(scatter: float) -> float:
        weighted = fit(scatter)
        if not restricted:
            return -weighted.log_likelihood
        _, log_determinant = np.linalg.slogdet(weighted.information)
        return -weighted.log_likelihood + 0.5 * float(log_determinant)

    minimum = minimize_scalar(
        cost, bounds=(SMALLEST_SCATTER, 1.0), method="bounded", options={"xatol": 1e-7}
    )
    # The bounded search does not try the bound itself.
    scatter = min(float(minimum.x), SMALLEST_SCATTER, key=cost)
    weighted = fit(scatter)
    degrees_of_freedom = max(y.size - weighted.coefficients.size, 1)
    inflation = max(weighted.square_sum / degrees_of_freedom, 1.0)
    coefficient_covariance = np.asarray(inflation * np.linalg.inv(weighted.information))
    return Regression(
        weighted.coefficients, coefficient_covariance, scatter, weighted.log_likelihood
    )


def law_of_loss(log_energy: Array, decrement: float, g: float) -> Array:
    """Return the losses of impacts by the energies before them.

    The energy to the power g falls by the same amount at each impact (docs/theory.md, section 8):
    delta(E) = -ln(1 - (1 - exp(-2 g delta_r)) (E_r/E)^g) / (2 g). An impact that stops the wall has
    `STOPPING_LOSS`.

    Parameters
    ----------
    log_energy : ndarray
        ln(E/E_r), with E_r the energy of the reference.
    decrement : float
        Loss delta_r at the reference. [-]
    g : float
        Exponent of the law. [-]
    """
    if abs(g) < 1e-9:
        return np.full(log_energy.shape, decrement)
    relative_change = np.exp(-g * log_energy) * np.expm1(-2 * g * decrement)  # of E^g
    loss = -np.log1p(np.maximum(relative_change, -1 + 1e-12)) / (2 * g)
    return np.minimum(loss, STOPPING_LOSS)


def fit_law(losses: Array, covariance: Array, log_energy: Array) -> tuple[Array, Array]:
    """Return the loss at the reference and g of the law of loss, and their covariance.

    Parameters
    ----------
    losses : ndarray, shape (impacts,)
        Measured losses. [-]
    covariance : ndarray, shape (impacts, impacts)
        Covariance of the losses by the sensor.
    log_energy : ndarray, shape (impacts,)
        ln(E/E_r) before each impact.
    """
    point = np.array([max(float(losses.mean()), 2 * SMALLEST_LOSS), 0.0])
    scatter = regress(losses, covariance, np.ones((losses.size, 1))).scatter
    for _ in range(4):  # the law and the scatter about it determine each other
        whole_covariance = covariance + scatter**2 * np.eye(losses.size)
        root = np.asarray(np.linalg.cholesky(whole_covariance), dtype=float)

        def residual(point: Array, root: Array = root) -> Array:
            return solve_triangular(root, law_of_loss(log_energy, *point) - losses, lower=True)

        law = least_squares(
            residual,
            point,
            bounds=([SMALLEST_LOSS, -3.0], [STOPPING_LOSS, 3.0]),
            x_scale=(0.1, 0.3),
            jac="3-point",
        )
        point = law.x
        # The law is linear near the point, with the derivative root @ law.jac of the losses.
        local = regress(losses - law_of_loss(log_energy, *point), covariance, root @ law.jac)
        scatter = local.scatter
    return point, local.covariance


def loss_at(point: Array, covariance: Array, log_energy: float) -> tuple[float, float]:
    """Return the loss at an energy by a fitted law, and its standard error.

    Parameters
    ----------
    point : ndarray, shape (2,)
        Loss at the reference and g, by `fit_law`.
    covariance : ndarray, shape (2, 2)
        Covariance of the point.
    log_energy : float
        ln(E/E_r).
    """
    energies = np.array([log_energy])

    def predict(points: Array) -> Array:
        return np.array([law_of_loss(energies, *parameters) for parameters in points])

    (gradient,) = differentiate(predict, point)
    loss = float(law_of_loss(energies, *point)[0])
    return loss, float(np.sqrt(gradient @ covariance @ gradient))
