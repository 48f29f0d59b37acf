"""Maximum of the likelihood of trials of free rocking, by searches at nodes that are laid anew after each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from rockdamp.arrays import Array
from rockdamp.laboratory.velocity_ratios import STARTS, Nodes, Predict, Prediction, Trials


class Fit(NamedTuple):
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
SETTLED = 0.02  # of the log-likelihood between two searches
SEARCHES = 6


def fit(
    trials: Trials,
    predict: Predict,
    shape: Sequence[tuple[float, float, float, float]] = (),
    start: Fit | None = None,
    other_ratios: bool = False,
) -> Fit:
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
        first, settled = end.x * scale, abs(-end.fun - largest) < SETTLED
        largest = -float(end.fun)
        if settled:
            break
        spread = False
    return Fit(largest, first, trials.values(first), first[len(names) :], nodes)


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
