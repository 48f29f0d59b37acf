"""Maximum of the likelihood of trials of free rocking, by searches at nodes that are laid anew after each.

Fits to trials that are resampled or left out, from an expansion of one likelihood.

The log-likelihood of each trial at each loss is expanded once, to second order in the parameters of error and shape
about the maximum; the hierarchy stays exact. With weights for the trials (how often each is drawn; 0 where it is left
out) the likelihood of these expansions is maximised: hundreds of fits for the price of a few.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import ndtr, ndtri, stdtr

from rockdamp.arrays import Array
from rockdamp.laboratory.velocity_ratios import (
    CENTRES,
    HIERARCHY,
    LOSSES,
    STARTS,
    Nodes,
    Predict,
    Prediction,
    Trials,
    rule,
)


class TrialsFit(NamedTuple):
    """The largest log-likelihood, the point where it is, and the parameters there by name.

    `shape` has the parameters of the damping model's shape; `nodes` are those of the last search.
    """

    log_likelihood: float
    point: Array
    values: Mapping[str, float]
    shape: Array
    nodes: Nodes


STEP = 1e-5  # of the differences that stand for derivatives by the parameters of a prediction's shape
LEAST = -60.0  # logarithm of a part that is as good as none; of far smaller ones a processor takes long
CONVERGED = 0.02  # of the log-likelihood between two searches
SEARCHES = 6


def fit(
    trials: Trials,
    predict: Predict,
    shape: Sequence[tuple[float, float, float, float]] = (),
    start: TrialsFit | None = None,
    other_ratios: bool = False,
) -> TrialsFit:
    """Maximise the likelihood over the parameters of error and hierarchy, and over those of the prediction's shape.

    `shape` has start, bounds and scale of each of these; `start` is a fit to begin at, of the same error model;
    its nodes serve too, unless it is a fit to `other_ratios`.
    """
    names = trials.errors.names
    first, low, high, scale = np.array([*(STARTS[name] for name in names), *shape]).T
    if start is not None:
        first[: len(names)] = start.point[: len(names)]
        if len(start.shape) == len(shape):
            first[len(names) :] = start.shape
    if start is None or other_ratios:
        spread, nodes, largest = True, trials.spread_nodes(trials.values(first)), -np.inf
    else:
        spread, nodes, largest = False, start.nodes, start.log_likelihood
    for _ in range(SEARCHES):
        for _ in range(2 if spread else 1):  # from spread nodes the first are coarse
            nodes = trials.own_nodes(first, predict(nodes.loss, first[len(names) :]), nodes)
        search = Search(trials, predict, nodes)

        def negative(scaled: Array, search: Search = search) -> tuple[float, Array]:
            value, gradient = search.negative(scaled * scale)
            return value, gradient * scale

        end = minimize(
            negative,
            first / scale,
            jac=True,
            method="L-BFGS-B",
            bounds=list(zip(low / scale, high / scale, strict=True)),
            options={"maxiter": 100, "ftol": 1e-9, "gtol": 1e-2},
        )
        first, converged = end.x * scale, abs(-end.fun - largest) < CONVERGED
        largest = -float(end.fun)
        if converged:
            break
        spread = False
    return TrialsFit(largest, first, trials.values(first), first[len(names) :], nodes)


@dataclass
class Search:
    """The likelihood and its gradient at fixed nodes."""

    trials: Trials
    predict: Predict
    nodes: Nodes

    def prediction(self, point: Array) -> Prediction:
        """Return the prediction at the nodes; the parameters of its shape stand after those of error and hierarchy."""
        return self.predict(self.nodes.loss, point[len(self.trials.errors.names) :])

    def of_losses(self, point: Array) -> Array:
        """Return the log-likelihood of each trial at each loss, with the loss's weight, shape (trials, losses)."""
        values = self.trials.values(point)
        misfit = self.trials.misfit(values, self.prediction(point), self.nodes)
        return _summed(self.trials.weighted(misfit, values, self.nodes))[0]

    def negative(self, point: Array) -> tuple[float, Array]:
        """Return the negative log-likelihood and its gradient."""
        values, prediction = self.trials.values(point), self.prediction(point)
        misfit = self.trials.misfit(values, prediction, self.nodes)
        of_losses, share = _summed(self.trials.weighted(misfit, values, self.nodes))
        value, of_loss, by_name = self.trials.total(values, of_losses, self.nodes)
        share *= of_loss[:, :, None, None]
        by_error, by_prediction = self.trials.slopes(values, prediction, self.nodes, share, misfit)
        by_name |= by_error
        gradient = [by_name[name] for name in self.trials.errors.names]
        for step in STEP * np.eye(point.size)[len(gradient) :]:
            ahead, behind = self.prediction(point + step), self.prediction(point - step)
            parts = zip(by_prediction, ahead, behind, strict=True)
            gradient.append(sum(float((by * (one - other)).sum()) for by, one, other in parts) / (2 * STEP))
        return -value, -np.array(gradient)


def _summed(joint: Array) -> tuple[Array, Array]:
    """Return the logarithm of the sum over alternations and levels, and the part that each node has in it."""
    most = joint.max(axis=(2, 3), keepdims=True)
    share = np.exp(np.maximum(joint - most, LEAST))
    total = np.einsum("tlas->tl", share)[:, :, None, None]
    share /= total
    return np.asarray((np.log(total) + most)[:, :, 0, 0]), share


# --- trials resampled or left out -------------------------------------------------------------------------------------

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
    fitted: TrialsFit
    expanded: Array
    value: Array
    slope: Array
    curvature: Array

    @classmethod
    def about(cls, trials: Trials, predict: Predict, fitted: TrialsFit) -> Expansion:
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


def simulated(trials: Trials, predict: Predict, fitted: TrialsFit, random: np.random.RandomState) -> Trials:
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
