"""Fits to trials that are resampled or left out, from an expansion of one likelihood.

The log-likelihood of each trial at each loss is expanded once, to second order in the parameters of error and shape
about the maximum; the hierarchy stays exact. With weights for the trials (how often each is drawn; 0 where it is left
out) the likelihood of these expansions is maximised: hundreds of fits for the price of a few.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import ndtr, ndtri, stdtr

from rockdamp.arrays import Array
from rockdamp.laboratory.trials_fit import Fit, Search
from rockdamp.laboratory.velocity_ratios import CENTRES, HIERARCHY, LOSSES, STARTS, Predict, Trials, rule

DIFFERENCE = 0.3  # of derivatives, of the parameters' scales
OF_SHAPE = 0.1  # scale of a parameter of the shape
NEGLIGIBLE = 1e-14  # probability of a loss
FARTHEST = 5.0  # from the maximum, in standard deviations, that an expansion is believed


@dataclass(frozen=True)
class Expansion:
    """The log-likelihood of each trial at each loss to second order in the parameters of error and shape.

    `value`, `slope` and `curvature` have the shapes (trials, losses), (parameters, trials, losses) and (parameters,
    parameters, trials, losses); `expanded` are the indices of those parameters in the fit's point.
    """

    trials: Trials
    fitted: Fit
    expanded: Array
    value: Array
    slope: Array
    curvature: Array

    @classmethod
    def of(cls, trials: Trials, predict: Predict, fitted: Fit) -> Expansion:
        """Expand about a fit, by central differences at its nodes."""
        search, point = Search(trials, predict, fitted.nodes), fitted.point
        names = (*trials.errors.names, *[""] * fitted.shape.size)
        expanded = np.array([index for index, name in enumerate(names) if name not in HIERARCHY])
        h = DIFFERENCE * np.array([STARTS[names[index]][-1] if names[index] else OF_SHAPE for index in expanded])
        steps = h[:, None] * np.eye(point.size)[expanded]
        value = search.of_losses(point)
        ahead, behind = (np.array([search.of_losses(point + sign * step) for step in steps]) for sign in (1, -1))
        curvature = np.empty((expanded.size, expanded.size, *value.shape))
        for i in range(expanded.size):
            curvature[i, i] = (ahead[i] - 2 * value + behind[i]) / h[i] ** 2
            for j in range(i):
                both, neither = (search.of_losses(point + sign * (steps[i] + steps[j])) for sign in (1, -1))
                mixed = both + neither - ahead[i] - ahead[j] - behind[i] - behind[j] + 2 * value
                curvature[i, j] = curvature[j, i] = mixed / (2 * h[i] * h[j])
        return cls(trials, fitted, expanded, value, (ahead - behind) / (2 * h[:, None, None]), curvature)

    def negative(self, point: Array, weights: Array) -> tuple[float, Array]:
        """Return the negative log-likelihood of the weighted trials, and its gradient."""
        change = (point - self.fitted.point)[self.expanded]
        bent = np.tensordot(change, self.curvature, axes=1)
        of_losses = self.value + np.tensordot(change, self.slope + 0.5 * bent, axes=1)
        trials, nodes = self.trials, self.fitted.nodes
        value, of_loss, by_hierarchy = trials.total(trials.values(point), of_losses, nodes, weights)
        gradient = np.empty(point.size)
        gradient[self.expanded] = ((self.slope + bent) * of_loss).sum(axis=(1, 2))
        for name, slope in by_hierarchy.items():
            gradient[trials.errors.names.index(name)] = slope
        return -value, -gradient

    def fit(self, weights: NDArray[Any]) -> Array:
        """Return the point of the largest log-likelihood of the weighted trials."""
        at, weights = self.fitted.point, np.asarray(weights, dtype=float)
        root = np.linalg.cholesky(self.covariance)  # by which the parameters become independent and of one size

        def negative(change: Array) -> tuple[float, Array]:
            value, gradient = self.negative(at + root @ change, weights)
            return value, gradient @ root

        bounds = [(-FARTHEST, FARTHEST)] * at.size
        found = minimize(negative, np.zeros(at.size), jac=True, method="L-BFGS-B", bounds=bounds)
        return np.asarray(at + root @ found.x)

    @property
    def deviation(self) -> Array:
        """Standard deviations of the parameters."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the parameters, the inverse of the observed information."""
        ones, at, step = np.ones(len(self.value)), self.fitted.point, 1e-5
        changes = step * np.eye(at.size)
        rows = [(self.negative(at + d, ones)[1] - self.negative(at - d, ones)[1]) / (2 * step) for d in changes]
        return np.asarray(np.linalg.inv(np.array(rows)))


def drawn(geometry: NDArray[np.intp], random: np.random.RandomState) -> Array:
    """Return how often each trial is drawn: as many of each geometry as there are, with replacement."""
    weights = np.zeros(len(geometry))
    for g in np.unique(geometry):
        members = np.flatnonzero(geometry == g)
        np.add.at(weights, random.choice(members, members.size), 1.0)
    return weights


def new_losses(trials: Trials, values: Mapping[str, float]) -> Array:
    """Return the probabilities of `LOSSES` for a trial of each geometry, if no trial of it was seen.

    The shape is (geometries, losses).
    """
    return np.asarray(at_each_centre(trials, values) @ np.exp(CENTRES[1]))


def at_each_centre(trials: Trials, values: Mapping[str, float]) -> Array:
    """Return the probabilities of `LOSSES` at each centre of each geometry, shape (geometries, losses, centres)."""
    centre = (trials.housner[:, None] + values["centre"] + values["between"] * CENTRES[0])[:, None, :]
    log_density = -0.5 * ((LOSSES[:, None] - centre) / values["within"]) ** 2
    density = np.exp(log_density - log_density.max(axis=1, keepdims=True)) * np.gradient(LOSSES)[:, None]
    return np.asarray(density / density.sum(axis=1, keepdims=True))


def simulated(trials: Trials, predict: Predict, fitted: Fit, random: np.random.RandomState) -> Trials:
    """Return trials of the same number, length and geometry that the fitted model makes."""
    values, count = fitted.values, len(trials.ratio)
    centre = trials.housner + values["centre"] + values["between"] * random.standard_normal(trials.housner.size)
    centre = centre[trials.geometry]
    lowest = ndtr(-centre / values["within"])  # a loss below 0 is cut off
    loss = centre + values["within"] * ndtri(lowest + (1 - lowest) * random.uniform(size=count))
    level = values["noise"] * np.exp(values["noise_deviation"] * random.standard_normal(count))
    lean = values["lean"] + values["alternation"] * random.standard_normal(count)
    prediction = predict(np.maximum(loss, 0.0), fitted.shape)
    signs = (-1.0) ** np.arange(trials.ratio.shape[1])[:, None]
    error = random.standard_t(values["freedom"], prediction.ratio.shape) * np.exp(
        -0.5 * values["growth"] * prediction.log_energy
    )
    ratio = (prediction.ratio + signs * lean + level * error).T
    return replace(trials, ratio=np.where(np.isfinite(trials.ratio), ratio, np.nan))


def share_below(trials: Trials, values: Mapping[str, float], members: NDArray[np.intp]) -> Array:
    """Return the probability that a first ratio is below that of each of some trials, shape (members,).

    Theirs are geometries of which no trial was seen.
    """
    (level, level_weight), (lean, lean_weight) = rule(5), rule(5)
    deviation = values["noise"] * np.exp(values["noise_deviation"] * level)
    predicted = np.exp(-LOSSES)[:, None, None] + (values["lean"] + values["alternation"] * lean)[:, None]
    weight = np.exp(level_weight + lean_weight[:, None])
    losses = new_losses(trials, values)[trials.geometry[members]]
    seen = losses.max(axis=0) > NEGLIGIBLE
    below = stdtr(values["freedom"], (trials.ratio[members, 0, None, None, None] - predicted[seen]) / deviation)
    return np.asarray(np.einsum("tcal,al,tc->t", below, weight, losses[:, seen], optimize=True))
