r"""Likelihood of the ratios of velocity in trials of free rocking, impact by impact.

Impact k = 1, 2, ... of trial t of geometry g has the ratio
r_k = exp(-delta_k) + a (-1)^(k-1) + s_t (V_1/V_k)^(q/2) z_k. Here delta_k is the loss that a damper
predicts from the trial's first loss delta_1, and V_k the energy before the impact. The other terms
are errors. Noise grows as the block slows; its level s_t belongs to the trial, ln s_t normal over
the trials; its tails are heavy, z_k Student's t. Odd and even impacts differ by an alternation a,
normal over the trials, because a block leans to one side.

delta_1 is normal over the trials of a geometry and cut off at 0, its centre delta_Housner + m_g,
with m_g normal over the geometries: the spread of ln e does not depend on the block.

Loss, alternation and level of noise of each trial are integrated out on nodes where its ratios put
them, as in adaptive Gauss-Hermite quadrature (Pinheiro and Bates,
doi:10.1080/10618600.1995.10474663). The nodes stay in place during a search; new nodes and a new
search follow until the maximum stays.
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
from rockdamp.laboratory.trials import FIRST_LOSSES, Predict, Trials

# Numbers of nodes for each trial's loss, alternation and level of noise: tests compare the
# quadrature with sums over fine grids.
LOSS_NODES = 15
ALTERNATION_NODES = 5
LEVEL_NODES = 5


class SearchRange(NamedTuple):
    """Start and bounds of a parameter in the search, and its scale.

    The scale is about the standard error that hundreds of trials give; the search steps by it.
    """

    start: float
    low: float
    high: float
    scale: float


# Logarithms, except for `PLAIN_PARAMETERS`. "centre" and "between" are the mean and the standard
# deviation of m_g, "within" that of delta_1, "noise" and "noise_deviation" those of s_t, as the
# median of s_t and the standard deviation of ln s_t.
SEARCH_RANGES = {
    "noise": SearchRange(-3.7, -6.0, -1.0, 0.06),
    "freedom": SearchRange(1.0, -3.0, 5.0, 0.15),  # degrees of freedom less one
    "alternation": SearchRange(-4.1, -7.0, -1.0, 0.1),
    "lean": SearchRange(0.0, -0.1, 0.1, 0.003),  # mean of the alternation over the trials
    "noise_deviation": SearchRange(-0.6, -4.0, 0.7, 0.09),
    "growth": SearchRange(2.0, 0.0, 5.0, 0.2),  # q: noise grows as the energy to the power -q/2
    "centre": SearchRange(-0.01, -0.2, 0.2, 0.007),
    "within": SearchRange(-3.7, -7.0, 0.0, 0.15),
    "between": SearchRange(-4.3, -7.0, 0.0, 0.3),
    "exponent": SearchRange(-0.2, -2.0, 2.0, 0.1),  # of a power law alone
}
PLAIN_PARAMETERS = ("lean", "growth", "centre", "exponent")


class Quadrature(NamedTuple):
    """Nodes of an integral and the logarithms of their weights."""

    nodes: Array
    log_weights: Array


def hermite(count: int) -> Quadrature:
    """Return the quadrature of a standard normal distribution."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(count)
    return Quadrature(nodes, np.log(weights / weights.sum()))


CENTRES = hermite(15)  # centres of the geometries, in their standard deviations


def log_normal(x: Array, deviation: float) -> Array:
    """Return the logarithm of a normal density about 0."""
    return -0.5 * (x / deviation) ** 2 - np.log(deviation * np.sqrt(2 * np.pi))


def normal_nodes(mean: Array, deviation: Array, count: int) -> Quadrature:
    """Return nodes around a normal distribution of each trial, shape (trials, count)."""
    standard = hermite(count)
    # The rule's density is divided out: it decides where the nodes are, and is not integrated.
    log_weights = standard.log_weights - log_normal(standard.nodes, 1.0)
    nodes = mean[:, None] + deviation[:, None] * standard.nodes
    return Quadrature(nodes, log_weights + np.log(deviation)[:, None])


def parameter_values(point: Array) -> dict[str, float]:
    """Return the parameters of a point by name."""
    values = {"exponent": 0.0}
    for name, coordinate in zip(SEARCH_RANGES, point, strict=False):
        values[name] = float(coordinate if name in PLAIN_PARAMETERS else np.exp(coordinate))
    values["freedom"] += 1.0
    return values


class Nodes(NamedTuple):
    """Quadratures over each trial's loss, alternation and logarithm of noise, (trials, nodes).

    Their weights are for integrals over these values, without a density.
    """

    loss: Quadrature
    alternation: Quadrature
    level: Quadrature


class TrialsFit(NamedTuple):
    """Largest log-likelihood, its point, and the nodes of the last search."""

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
        geometries = np.arange(self.trials.housner.size)
        return (self.trials.geometry == geometries[:, None]).astype(float)

    # --- nodes ------------------------------------------------------------------------------------

    def spread_nodes(self, values: Mapping[str, float]) -> Nodes:
        """Return first nodes: for all possible losses, and around the prior of the others."""
        ones = np.ones(len(self.trials.ratio))
        shape = (ones.size, FIRST_LOSSES.size)
        loss = Quadrature(
            np.broadcast_to(FIRST_LOSSES, shape),
            np.broadcast_to(np.log(np.gradient(FIRST_LOSSES)), shape),
        )
        alternation = normal_nodes(
            ones * values["lean"], ones * values["alternation"], ALTERNATION_NODES
        )
        level = normal_nodes(
            ones * np.log(values["noise"]), ones * values["noise_deviation"], LEVEL_NODES
        )
        return Nodes(loss, alternation, level)

    def adapted_nodes(self, values: Mapping[str, float], nodes: Nodes) -> Nodes:
        """Return nodes where each trial's ratios put its loss, alternation and level of noise."""
        joint = self.joint(values, nodes)
        by_centre = self.losses_at_centres(values, nodes) + CENTRES.log_weights
        joint += logsumexp(by_centre, axis=2)[:, :, None, None]
        share = softmax(joint, axis=(1, 2, 3))
        loss_mean, loss_deviation = _moments(nodes.loss.nodes, share.sum(axis=(2, 3)))
        alternation = _moments(nodes.alternation.nodes, share.sum(axis=(1, 3)))
        level = _moments(nodes.level.nodes, share.sum(axis=(1, 2)))
        unit_nodes, weights = np.polynomial.legendre.leggauss(LOSS_NODES)
        reach = 5.0 * loss_deviation  # the density beyond it is negligible
        low = np.maximum(loss_mean - reach, 0.0)
        high = loss_mean + reach
        half = ((high - low) / 2)[:, None]
        loss_nodes = ((high + low) / 2)[:, None] + half * unit_nodes
        return Nodes(
            Quadrature(loss_nodes, np.log(half * weights)),
            normal_nodes(*alternation, ALTERNATION_NODES),
            normal_nodes(*level, LEVEL_NODES),
        )

    # --- likelihood -------------------------------------------------------------------------------

    def joint(self, values: Mapping[str, float], nodes: Nodes) -> Array:
        """Return the log-density of each trial's ratios at its nodes, with the trial's own weights.

        The shape is (trials, losses, alternations, levels).
        """
        ratio = self.trials.ratio
        losses = nodes.loss.nodes
        alternations = nodes.alternation.nodes
        levels = nodes.level.nodes
        prediction = self.predict(losses, values["exponent"])
        freedom = values["freedom"]
        growth = values["growth"]
        precision = np.exp(-2.0 * levels) / freedom
        log_rise = np.zeros(losses.shape)
        product = np.ones((*losses.shape, alternations.shape[1], levels.shape[1]))
        for k, count in enumerate(np.isfinite(ratio).sum(axis=0)):
            log_energy = prediction.log_energy[k, :count]
            # The residual over the growth of the noise: times (V_k/V_1)^(q/2).
            rise = np.exp(0.5 * growth * log_energy)
            z = ((ratio[:count, k, None] - prediction.ratio[k, :count]) * rise)[:, :, None]
            z = z - ((-1.0) ** k * rise)[:, :, None] * alternations[:count, None, :]
            log_rise[:count] += 0.5 * growth * log_energy
            # The product over all impacts, whose logarithm is taken once, stays below 1e200.
            product[:count] *= 1.0 + (z * z)[..., None] * precision[:count, None, None, :]
        constant = gammaln((freedom + 1) / 2) - gammaln(freedom / 2) - 0.5 * np.log(freedom * np.pi)
        impacts = np.isfinite(ratio).sum(axis=1)[:, None]
        level = nodes.level.log_weights + log_normal(
            levels - np.log(values["noise"]), values["noise_deviation"]
        )
        level = level + impacts * (constant - levels)
        alternation = nodes.alternation.log_weights + log_normal(
            alternations - values["lean"], values["alternation"]
        )
        loss = log_rise + nodes.loss.log_weights
        density = np.log(product) * (-(freedom + 1) / 2) + loss[:, :, None, None]
        return np.asarray(density + alternation[:, None, :, None] + level[:, None, None, :])

    def losses_at_centres(self, values: Mapping[str, float], nodes: Nodes) -> Array:
        """Return the log-density of losses at each centre, shape (trials, losses, centres)."""
        centre = self.trials.housner[:, None] + values["centre"] + values["between"] * CENTRES.nodes
        within = values["within"]
        above_zero = log_ndtr(centre / within)[self.trials.geometry][:, None, :]
        deviation = nodes.loss.nodes[:, :, None] - centre[self.trials.geometry][:, None, :]
        return log_normal(deviation, within) - above_zero

    def centre_likelihood(self, values: Mapping[str, float], nodes: Nodes) -> Array:
        """Return the weighted log-likelihood of geometries at centres, (geometries, centres)."""
        joint = self.joint(values, nodes)
        largest = joint.max(axis=(2, 3), keepdims=True)
        by_loss = np.log(np.exp(joint - largest).sum(axis=(2, 3))) + largest[:, :, 0, 0]
        largest = by_loss.max(axis=1, keepdims=True)
        prior = np.exp(self.losses_at_centres(values, nodes))
        density = (np.exp(by_loss - largest)[:, None, :] @ prior)[:, 0]
        by_trial = np.log(density + 1e-300) + largest  # at far centres the density underflows
        return np.asarray(self.membership @ by_trial + CENTRES.log_weights)

    def log_likelihood(self, point: Array, nodes: Nodes) -> float:
        """Return the log-likelihood of all trials."""
        by_centre = self.centre_likelihood(parameter_values(point), nodes)
        return float(logsumexp(by_centre, axis=1).sum())

    # --- maximum ----------------------------------------------------------------------------------

    def fit(self, start: TrialsFit | None = None, *, power_law: bool = False) -> TrialsFit:
        """Maximise over the parameters of error and hierarchy, and the exponent of a power law.

        Parameters
        ----------
        start : TrialsFit, optional
            Fit whose point and nodes begin the search. Default: none.
        power_law : bool
            Search the exponent too. Default: False.
        """
        ranges = list(SEARCH_RANGES.values())
        if not power_law:
            ranges = ranges[:-1]
        point, low, high, scale = np.array(ranges).T
        if start is None:
            values = parameter_values(point)
            largest = -np.inf
            # Once more than in the loop, as the first nodes are coarse.
            nodes = self.adapted_nodes(values, self.spread_nodes(values))
        else:
            count = min(start.point.size, point.size)
            point[:count] = start.point[:count]
            nodes = start.nodes
            largest = start.log_likelihood
        # ASSUME: six searches suffice; the maximum stays after two or three.
        for _ in range(6):
            nodes = self.adapted_nodes(parameter_values(point), nodes)

            def negative(scaled: Array, nodes: Nodes = nodes) -> float:
                return -self.log_likelihood(scaled * scale, nodes)

            minimum = minimize(
                negative,
                point / scale,
                method="L-BFGS-B",
                bounds=list(zip(low / scale, high / scale, strict=True)),
                options={"maxiter": 100, "ftol": 1e-8, "gtol": 1e-2, "eps": 1e-4, "maxfun": 5000},
            )
            previous = largest
            point = minimum.x * scale
            largest = -float(minimum.fun)
            if abs(largest - previous) < 0.02:  # decides no comparison of likelihoods
                break
        return TrialsFit(largest, point, nodes)

    def standard_errors(self, fitted: TrialsFit) -> Array:
        """Return the standard errors of the parameters by the observed information."""
        scales = np.array([search_range.scale for search_range in SEARCH_RANGES.values()])
        # A fifth of about a standard error: the log-likelihood is nearly a parabola there.
        h = 0.2 * scales[: fitted.point.size]
        steps = np.diag(h)

        def likelihood(shift: Array) -> float:
            return self.log_likelihood(fitted.point + shift, fitted.nodes)

        middle = likelihood(np.zeros(h.size))
        forward = np.array([likelihood(step) for step in steps])
        backward = np.array([likelihood(-step) for step in steps])
        curvature = np.diag((forward - 2 * middle + backward) / h**2)
        for i in range(h.size):
            for j in range(i):
                diagonal = steps[i] + steps[j]
                mixed = likelihood(diagonal) + likelihood(-diagonal)
                mixed = mixed - forward[i] - forward[j] - backward[i] - backward[j] + 2 * middle
                curvature[i, j] = curvature[j, i] = mixed / (2 * h[i] * h[j])
        return np.asarray(np.sqrt(np.diag(np.linalg.inv(-curvature))))


def _moments(nodes: Array, share: Array) -> tuple[Array, Array]:
    """Return the mean and the standard deviation of each trial's nodes, by their shares."""
    mean = (share * nodes).sum(axis=1)
    variance = (share * (nodes - mean[:, None]) ** 2).sum(axis=1)
    return mean, np.sqrt(np.maximum(variance, 1e-10))  # nodes must stay apart
