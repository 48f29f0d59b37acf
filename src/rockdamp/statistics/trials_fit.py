"""Maximum of the likelihood of trials of free rocking, by searches at nodes that are laid anew after each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from rockdamp.arrays import Array
from rockdamp.statistics.velocity_ratios import HIERARCHY, OF_ERRORS, STARTS, Nodes, Predict, Trials


class Fit(NamedTuple):
    """The largest log-likelihood, the point where it is, and the parameters there by name.

    `shape` has the parameters of the damping model's shape; `nodes` are those of the last search.
    """

    log_likelihood: float
    point: Array
    values: Mapping[str, float]
    shape: Array
    nodes: Nodes


STEP = 1e-3  # of the differences that stand for derivatives, of the parameters' scales
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
        end = minimize(
            lambda scaled, search=search: search.negative(scaled * scale, scale),
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
    """The likelihood and its gradient at fixed nodes; what a parameter does not change is not computed anew."""

    trials: Trials
    predict: Predict
    nodes: Nodes

    @property
    def named(self) -> int:
        """Number of the parameters of error and hierarchy, after which those of the shape stand."""
        return len(self.trials.errors.names)

    def misfit(self, point: Array) -> Array:
        """Return the log-density of each trial's ratios at each node."""
        prediction = self.predict(self.nodes.loss, point[self.named :])
        return self.trials.misfit(self.trials.values(point), prediction, self.nodes)

    def of_losses(self, point: Array, misfit: Array | None = None) -> Array:
        """Return the log-likelihood of each trial at each loss."""
        misfit = self.misfit(point) if misfit is None else misfit
        return self.trials.of_losses(self.trials.values(point), misfit, self.nodes)

    def total(self, point: Array, of_losses: Array) -> float:
        """Return the log-likelihood of all trials."""
        return self.trials.total(self.trials.at_centres(self.trials.values(point), of_losses, self.nodes))

    def negative(self, point: Array, scale: Array) -> tuple[float, Array]:
        """Return the negative log-likelihood and its gradient by the parameters over a scale."""
        errors = self.trials.errors
        changing = OF_ERRORS if errors.by_trial else (*OF_ERRORS, "noise")
        misfit = self.misfit(point)
        of_losses = self.of_losses(point, misfit)
        value, gradient = self.total(point, of_losses), np.empty(point.size)
        for index in range(point.size):
            moved, name = point.copy(), (*errors.names, *[""] * point.size)[index]
            moved[index] += STEP * scale[index]
            of_moved = of_losses
            if name not in HIERARCHY:
                of_moved = self.of_losses(moved, None if name in (*changing, "") else misfit)
            gradient[index] = (self.total(moved, of_moved) - value) / STEP
        return -value, -gradient
