r"""The losses of a specimen's impacts: their mean, their scatter, and how they depend on the amplitude.

The loss delta = -ln e of impact k, measured with a known covariance C, is taken as

.. math:: \delta_k = \delta \, m_k + s \, \epsilon_k + \text{error}_k, \qquad \epsilon_k \sim N(0, 1),
          \qquad \text{error} \sim N(0, C)

with m_k = 1 for one coefficient of restitution, m_k proportional to V_k^gamma for a loss that goes with a power of the
energy V before the impact, or what a viscous damper loses on this curve. The scatter s of a real impact from the next
is estimated too: it is what a large specimen's e is uncertain by, once the sensor is good.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import t as student

from rockdamp.arrays import Array

LEVEL = 0.90
SPACING = 0.1
EXPONENTS = SPACING * np.arange(-30, 31)  # gammas that are looked at
LARGEST_SCATTER = 1.0  # of ln e


@dataclass(frozen=True)
class Line:
    """A fitted multiple of a shape: delta and its standard error, the scatter s, and ln of the likelihood."""

    decrement: float
    standard_error: float
    scatter: float
    log_likelihood: float


@dataclass(frozen=True)
class Losses:
    """Losses of impacts, shape (impacts,), and their covariance by the sensor."""

    decrement: Array
    covariance: Array

    @cached_property
    def _directions(self) -> tuple[Array, Array]:
        """Variances by the sensor, and the independent sums of losses that have them."""
        values, vectors = np.linalg.eigh(self.covariance)
        return values, vectors

    def of(self, chosen: Array) -> Losses:
        """Return the losses of some impacts, by their indices or by True and False."""
        return Losses(self.decrement[chosen], self.covariance[chosen][:, chosen])

    @property
    def quantile(self) -> float:
        """Return Student's quantile of an interval, by the impacts that are left once the mean is known."""
        return float(student.ppf(0.5 + LEVEL / 2, self.decrement.size - 1))

    def line(self, shape: Array, restricted: bool = True) -> Line:
        """Fit a multiple of a shape, by generalised least squares with the most likely scatter.

        The likelihood of the scatter is restricted (REML), which leaves no bias from the mean's estimation, or plain,
        by which shapes are compared. The standard error is Hartung and Knapp's (doi:10.1002/sim.791): it takes the
        residuals as they are, where they are larger than expected.
        """
        values, vectors = self._directions
        y, m = vectors.T @ self.decrement, vectors.T @ shape

        def parts(scatter: float) -> tuple[float, float, float, float]:
            variance = np.maximum(values, 0.0) + scatter**2
            precision = float(np.sum(m**2 / variance))
            mean = float(np.sum(m * y / variance)) / precision
            square = float(np.sum((y - mean * m) ** 2 / variance))
            log_likelihood = -0.5 * (square + float(np.sum(np.log(2 * np.pi * variance))))
            return mean, precision, square, log_likelihood

        def cost(scatter: float) -> float:
            _, precision, _, log_likelihood = parts(scatter)
            return -log_likelihood + (0.5 * np.log(precision) if restricted else 0.0)

        floor = 1e-6  # keeps the variance of what the sensor measures exactly above zero
        found = minimize_scalar(cost, bounds=(floor, LARGEST_SCATTER), method="bounded", options={"xatol": 1e-7})
        scatter = float(found.x) if cost(float(found.x)) < cost(floor) else floor
        mean, precision, square, log_likelihood = parts(scatter)
        inflation = max(square / max(y.size - 1, 1), 1.0)
        return Line(mean, float(np.sqrt(inflation / precision)), scatter, log_likelihood)

    @property
    def threshold(self) -> float:
        """Fall of the log-likelihood at the end of an interval of a parameter, exact for equal variances."""
        left = max(self.decrement.size - 2, 1)
        quantile = float(student.ppf(0.5 + LEVEL / 2, left))
        return 0.5 * self.decrement.size * float(np.log1p(quantile**2 / left))


def exponent_of(losses: Losses, log_energy: Array) -> tuple[float, tuple[float, float]]:
    """Return gamma of a loss proportional to V^gamma by maximum likelihood, and its interval by the likelihood.

    An end of the interval is NaN where it is not determined.
    """
    centred = log_energy - log_energy.mean()

    def likelihood(gamma: float) -> float:
        return losses.line(np.exp(gamma * centred), restricted=False).log_likelihood

    rough = EXPONENTS[int(np.argmax([likelihood(gamma) for gamma in EXPONENTS]))]
    around = np.clip([rough - SPACING, rough + SPACING], EXPONENTS[0], EXPONENTS[-1])
    found = minimize_scalar(lambda gamma: -likelihood(gamma), bounds=around, method="bounded", options={"xatol": 1e-5})
    best, least = float(found.x), -float(found.fun) - losses.threshold

    def end(beyond: list[float]) -> float:
        inside = best
        for gamma in beyond:
            if likelihood(gamma) < least:
                return float(brentq(lambda between: likelihood(between) - least, inside, gamma, xtol=1e-5))
            inside = gamma
        return np.nan

    below, above = (EXPONENTS[side].tolist() for side in (EXPONENTS < best, EXPONENTS > best))
    return best, (end(below[::-1]), end(above))
