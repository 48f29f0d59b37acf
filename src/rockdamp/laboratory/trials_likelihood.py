r"""Likelihood of the ratios of velocity that trials of free rocking show, impact by impact.

Trial t of geometry g shows r_k = exp(-delta_k) + a (-1)^k + s_t (V_1/V_k)^(q/2) z_k at its impact k. Here delta_k is
the loss that a damper predicts from the trial's first loss delta_1, and V_k the energy that is left before the impact.
The other terms are errors. Noise grows as the block slows; its level s_t is the trial's own, ln s_t normal over the
trials; its tails are heavy, z_k Student's t. Odd and even impacts differ by an alternation a, as of a block that leans
to one side, normal over the trials.

delta_1 is normal over the trials of a geometry and cut off at 0, its centre delta_Housner + m_g, with m_g normal over
the geometries: the spread of ln e does not depend on the block.

Loss, alternation and level of noise of each trial are integrated out on nodes that lie where its own ratios put them,
as in adaptive Gauss-Hermite quadrature (Pinheiro and Bates, doi:10.1080/10618600.1995.10474663). The nodes stay in
place during a search; new nodes and a new search follow until the maximum stays.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize
from scipy.special import gammaln, log_ndtr, logsumexp, softmax

from rockdamp.arrays import Array
from rockdamp.laboratory.trials import LOSSES, Predict, Trials

NODES = 15, 5, 5  # of loss, alternation and level of noise
# Start of a search, its bounds, and about how well hundreds of trials determine a parameter, by which a search scales
# its steps. Logarithms except for `PLAIN`.
START = {
    "noise": (-3.7, -6.0, -1.0, 0.06),
    "freedom": (1.0, -3.0, 5.0, 0.15),  # degrees of freedom less one
    "alternation": (-4.1, -7.0, -1.0, 0.1),
    "lean": (0.0, -0.1, 0.1, 0.003),  # mean of the alternation over the trials
    "noise_deviation": (-0.6, -4.0, 0.7, 0.09),
    "growth": (2.0, 0.0, 5.0, 0.2),  # of the noise, a power of the speed that is left
    "centre": (-0.01, -0.2, 0.2, 0.007),
    "within": (-3.7, -7.0, 0.0, 0.15),
    "between": (-4.3, -7.0, 0.0, 0.3),
    "exponent": (-0.2, -2.0, 2.0, 0.1),  # of a power law
}
PLAIN = ("lean", "growth", "centre", "exponent")


def hermite(nodes: int) -> tuple[Array, Array]:
    """Return the nodes of a standard normal distribution, and the logarithms of their weights."""
    at, weight = np.polynomial.hermite_e.hermegauss(nodes)
    return at, np.log(weight / weight.sum())


CENTRES = hermite(15)  # of the geometries, in their standard deviations


def log_normal(x: Array, deviation: float) -> Array:
    """Return the logarithm of a normal density about 0."""
    return -0.5 * (x / deviation) ** 2 - np.log(deviation * np.sqrt(2 * np.pi))


def normal_nodes(mean: Array, deviation: Array, count: int) -> tuple[Array, Array]:
    """Return nodes around a normal distribution of each trial, and their log-weights."""
    at, log_weight = hermite(count)
    # The rule's density is divided out: it is where the nodes are, not what is integrated.
    return mean[:, None] + deviation[:, None] * at, log_weight - log_normal(at, 1.0) + np.log(
        deviation
    )[:, None]


def parameter_values(point: Array) -> dict[str, float]:
    """Return the parameters of a point by name."""
    named = dict(zip(START, point, strict=False))
    values = {
        name: float(value if name in PLAIN else np.exp(value)) for name, value in named.items()
    }
    return {"exponent": 0.0} | values | {"freedom": values["freedom"] + 1.0}


class Nodes(NamedTuple):
    """Values of each trial's loss, alternation and logarithm of noise, shapes (trials, nodes), with their log-weights.

    The weights are for integrals over these values, without a density.
    """

    loss: Array
    loss_weight: Array
    alternation: Array
    alternation_weight: Array
    level: Array
    level_weight: Array


class TrialsFit(NamedTuple):
    """The largest log-likelihood, the point where it is, and the nodes of the last search."""

    log_likelihood: float
    point: Array
    nodes: Nodes


@dataclass(frozen=True, eq=False)
class Likelihood:
    """Trials and the prediction of their ratios."""

    trials: Trials
    predict: Predict

    @cached_property
    def membership(self) -> Array:
        """One where a trial is of a geometry, shape (geometries, trials)."""
        return (self.trials.geometry == np.arange(self.trials.housner.size)[:, None]).astype(float)

    # --- nodes --------------------------------------------------------------------------------------------------------

    def spread_nodes(self, values: Mapping[str, float]) -> Nodes:
        """Return nodes for all possible losses and around the prior of the others: where a search begins."""
        ones = np.ones(len(self.trials.ratio))
        loss, weight = (
            np.broadcast_to(one, (ones.size, LOSSES.size))
            for one in (LOSSES, np.log(np.gradient(LOSSES)))
        )
        alternation = normal_nodes(ones * values["lean"], ones * values["alternation"], NODES[1])
        level = normal_nodes(
            ones * np.log(values["noise"]), ones * values["noise_deviation"], NODES[2]
        )
        return Nodes(loss, weight, *alternation, *level)

    def own_nodes(self, values: Mapping[str, float], nodes: Nodes) -> Nodes:
        """Return nodes where each trial's ratios put its loss, alternation and level of noise."""
        joint = self.joint(values, nodes)
        joint += logsumexp(self.losses_at_centres(values, nodes) + CENTRES[1], axis=2)[
            :, :, None, None
        ]
        share = softmax(joint, axis=(1, 2, 3))
        moments = []
        for at, others in (
            (nodes.loss, (2, 3)),
            (nodes.alternation, (1, 3)),
            (nodes.level, (1, 2)),
        ):
            weight = share.sum(axis=others)
            mean = (weight * at).sum(axis=1)
            variance = (weight * (at - mean[:, None]) ** 2).sum(axis=1)
            moments.append((mean, np.sqrt(np.maximum(variance, 1e-10))))
        (loss, spread), alternation, level = moments
        at, weight = np.polynomial.legendre.leggauss(NODES[0])
        low, high = np.maximum(loss - 5.0 * spread, 0.0), loss + 5.0 * spread
        half = ((high - low) / 2)[:, None]
        placed = ((high + low) / 2)[:, None] + half * at, np.log(half * weight)
        return Nodes(
            *placed, *normal_nodes(*alternation, NODES[1]), *normal_nodes(*level, NODES[2])
        )

    # --- likelihood ---------------------------------------------------------------------------------------------------

    def joint(self, values: Mapping[str, float], nodes: Nodes) -> Array:
        """Return the log-density of each trial's ratios at its nodes, with all weights except the hierarchy's.

        The shape is (trials, losses, alternations, levels).
        """
        ratio, prediction = self.trials.ratio, self.predict(nodes.loss, values["exponent"])
        freedom, growth = values["freedom"], values["growth"]
        precision = np.exp(-2.0 * nodes.level) / freedom
        log_rise = np.zeros(nodes.loss.shape)
        product = np.ones((*log_rise.shape, nodes.alternation.shape[1], precision.shape[1]))
        for k, count in enumerate(np.isfinite(ratio).sum(axis=0)):
            log_energy = prediction.log_energy[k, :count]
            rise = np.exp(0.5 * growth * log_energy)
            z = ((ratio[:count, k, None] - prediction.ratio[k, :count]) * rise)[:, :, None]
            z = z - ((-1.0) ** k * rise)[:, :, None] * nodes.alternation[:count, None, :]
            log_rise[:count] += 0.5 * growth * log_energy
            # The product of the terms of all impacts, whose logarithm is taken once: it stays below 1e200.
            product[:count] *= 1.0 + (z * z)[..., None] * precision[:count, None, None, :]
        constant = gammaln((freedom + 1) / 2) - gammaln(freedom / 2) - 0.5 * np.log(freedom * np.pi)
        impacts = np.isfinite(ratio).sum(axis=1)[:, None]
        level = nodes.level_weight + log_normal(
            nodes.level - np.log(values["noise"]), values["noise_deviation"]
        )
        level = level + impacts * (constant - nodes.level)
        alternation = nodes.alternation_weight + log_normal(
            nodes.alternation - values["lean"], values["alternation"]
        )
        density = (
            np.log(product) * (-(freedom + 1) / 2)
            + (log_rise + nodes.loss_weight)[:, :, None, None]
        )
        return np.asarray(density + alternation[:, None, :, None] + level[:, None, None, :])

    def losses_at_centres(self, values: Mapping[str, float], nodes: Nodes) -> Array:
        """Return the log-density of each trial's losses at each centre, shape (trials, losses, centres)."""
        centre = self.trials.housner[:, None] + values["centre"] + values["between"] * CENTRES[0]
        within = values["within"]
        above_zero = log_ndtr(centre / within)[self.trials.geometry][:, None, :]
        return (
            log_normal(nodes.loss[:, :, None] - centre[self.trials.geometry][:, None, :], within)
            - above_zero
        )

    def centre_likelihood(self, values: Mapping[str, float], nodes: Nodes) -> Array:
        """Return the log-likelihood of each geometry at each centre, with its weight, shape (geometries, centres)."""
        joint = self.joint(values, nodes)
        largest = joint.max(axis=(2, 3), keepdims=True)
        by_loss = np.log(np.exp(joint - largest).sum(axis=(2, 3))) + largest[:, :, 0, 0]
        largest = by_loss.max(axis=1, keepdims=True)
        prior = np.exp(self.losses_at_centres(values, nodes))
        by_trial = np.log((np.exp(by_loss - largest)[:, None, :] @ prior)[:, 0] + 1e-300) + largest
        return np.asarray(self.membership @ by_trial + CENTRES[1])

    def log_likelihood(self, point: Array, nodes: Nodes) -> float:
        """Return the log-likelihood of all trials."""
        return float(
            logsumexp(self.centre_likelihood(parameter_values(point), nodes), axis=1).sum()
        )

    # --- maximum ------------------------------------------------------------------------------------------------------

    def fit(self, start: TrialsFit | None = None, *, power_law: bool = False) -> TrialsFit:
        """Maximise over the parameters of error and hierarchy, and over the exponent of a power law."""
        first, low, high, scale = np.array(list(START.values())[: None if power_law else -1]).T
        if start is None:
            nodes, largest = self.spread_nodes(parameter_values(first)), -np.inf
            nodes = self.own_nodes(
                parameter_values(first), nodes
            )  # coarse, as they follow from spread nodes
        else:
            nodes, largest = start.nodes, start.log_likelihood
            first[: min(start.point.size, first.size)] = start.point[: first.size]
        for _ in range(6):
            nodes = self.own_nodes(parameter_values(first), nodes)

            def negative(scaled: Array, nodes: Nodes = nodes) -> float:
                return -self.log_likelihood(scaled * scale, nodes)

            end = minimize(
                negative,
                first / scale,
                method="L-BFGS-B",
                bounds=list(zip(low / scale, high / scale, strict=True)),
                options={"maxiter": 100, "ftol": 1e-8, "gtol": 1e-2, "eps": 1e-4, "maxfun": 5000},
            )
            first, before, largest = end.x * scale, largest, -float(end.fun)
            if abs(largest - before) < 0.02:
                break
        return TrialsFit(largest, first, nodes)

    def standard_errors(self, fitted: TrialsFit) -> Array:
        """Return the standard errors of the parameters by the observed information, at fixed nodes."""
        h = 0.2 * np.array([scale for *_, scale in START.values()])[: fitted.point.size]
        steps = np.diag(h)

        def at(point: Array) -> float:
            return self.log_likelihood(point, fitted.nodes)

        middle = at(fitted.point)
        ahead, behind = ([at(fitted.point + sign * step) for step in steps] for sign in (1, -1))
        curvature = np.diag((np.array(ahead) - 2 * middle + np.array(behind)) / h**2)
        for i in range(h.size):
            for j in range(i):
                both, neither = (
                    at(fitted.point + sign * (steps[i] + steps[j])) for sign in (1, -1)
                )
                mixed = both + neither - ahead[i] - ahead[j] - behind[i] - behind[j] + 2 * middle
                curvature[i, j] = curvature[j, i] = mixed / (2 * h[i] * h[j])
        return np.asarray(np.sqrt(np.diag(np.linalg.inv(-curvature))))
