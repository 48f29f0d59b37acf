r"""Likelihood of the ratios of velocity that trials of free rocking show, impact by impact.

Trial t of geometry g shows r_k = exp(-delta_k) + a (-1)^k + s_t (V_1/V_k)^(q/2) z_k at its impact k. Here delta_k is
the loss that a damping model predicts from the trial's first loss delta_1, and V_k the energy that is left before the
impact. The rest is error:

- noise that grows as the block slows: with q = 1 that of an angular velocity whose noise does not, q larger where
  the motion itself is less regular;
- a level of noise s_t of the trial's own, ln s_t normal over the trials;
- heavy tails, z_k Student's t;
- an alternation a of odd and even impacts, as of a block that leans to one side, normal over the trials;
- if asked for, a correlation of neighbouring errors, as of one velocity that stands in two ratios,
  z_k = y_k + c y_{k-1}.

delta_1 is normal over the trials of a geometry and cut off at 0, its centre delta_Housner + m_g, with m_g normal over
the geometries: the spread of ln e does not depend on the block.

Loss, alternation and level of noise of each trial are integrated out on nodes that lie where its own ratios put them,
as in adaptive Gauss-Hermite quadrature (Pinheiro and Bates, doi:10.1080/10618600.1995.10474663). The nodes stay in
place during a search, so that most parameters change weights alone; they are laid anew, and the search repeated, until
the maximum stays.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import digamma, erfcx, gammaln, log_ndtr, logsumexp, softmax

from rockdamp.arrays import Array

MOST = 3.0  # loss of an impact after which the block all but rests; no prediction goes beyond it
NORMAL = 200.0  # degrees of freedom of Student's t that are as good as a normal distribution
# First losses among which a trial's is looked for: fine near 0, where slender blocks are, and beyond any trial.
LOSSES = 0.35 * np.linspace(0.0, 1.0, 61) ** 1.5 + 1e-4
LEAST_LOSS = 1e-6  # of a first impact
REACH = 5.0  # standard deviations to either side within which a trial's loss is integrated
NODES = 15, 5, 5  # of loss, alternation and level of noise

# Parameters of error and hierarchy: where a search starts, between what, and about how well trials by the hundred tell
# them, by which a search scales its steps. Logarithms but for `UNSCALED`.
STARTS = {
    "noise": (-3.7, -6.0, -1.0, 0.06),
    "freedom": (1.0, -3.0, 5.0, 0.15),  # degrees of freedom less one
    "alternation": (-4.1, -7.0, -1.0, 0.1),
    "lean": (0.0, -0.1, 0.1, 0.003),  # mean of the alternation over the trials
    "noise_deviation": (-0.6, -4.0, 0.7, 0.09),
    "correlation": (0.0, -0.9, 0.9, 0.03),
    "growth": (2.0, 0.0, 5.0, 0.2),  # of the noise, a power of the speed that is left
    "centre": (-0.01, -0.2, 0.2, 0.007),
    "within": (-3.7, -7.0, 0.0, 0.15),
    "between": (-4.3, -7.0, 0.0, 0.3),
}
UNSCALED = ("lean", "correlation", "growth", "centre")
NOTHING = {"freedom": NORMAL} | dict.fromkeys(("alternation", "lean", "noise_deviation", "correlation"), 0.0)
HIERARCHY = ("centre", "within", "between")


class Prediction(NamedTuple):
    """What a damping model predicts for some first losses, shapes (impacts, *losses).

    `ratio` of the velocities at each impact, and `log_energy`, ln(V_k/V_1) before it.
    """

    ratio: Array
    log_energy: Array


Predict = Callable[[Array, Array], Prediction]  # of first losses, and of the parameters of the model's shape, if any


def power_law(losses: Array, exponent: float, impacts: int) -> Prediction:
    """Return the prediction of a loss per impact in proportion to the energy left, to the power of an exponent."""
    log_energy, ratio, energies = np.zeros(losses.shape), [], []
    for _ in range(impacts):
        loss = np.minimum(losses * np.exp(exponent * log_energy), MOST)
        energies.append(log_energy)
        ratio.append(np.exp(-loss))
        log_energy = log_energy - 2.0 * loss
    return Prediction(np.array(ratio), np.array(energies))


def law_of_loss(losses: Array, exponent: float, impacts: int) -> Prediction:
    """Return the prediction of the law of docs/theory.md, section 8, with the exponent g, above 0.

    V^g falls at each impact by V_1^g (1 - exp(-2 g delta_1)), until nothing is left and the block stops: from there on
    the loss is `MOST`.
    """
    log_energy, ratio, energies = np.zeros(losses.shape), [], []
    for _ in range(impacts):
        left = np.exp(-exponent * log_energy) * np.expm1(-2.0 * exponent * losses)  # V_k+1^g over V_k^g, less 1
        loss = np.where(left > -1.0, np.log1p(np.maximum(left, -1.0 + 1e-16)) / (-2.0 * exponent), MOST)
        loss = np.minimum(loss, MOST)
        energies.append(log_energy)
        ratio.append(np.exp(-loss))
        log_energy = log_energy - 2.0 * loss
    return Prediction(np.array(ratio), np.array(energies))


def impacts_to_stop(losses: Array, exponent: float) -> Array:
    """Return the number of the impact at which that law stops a block, by its first loss and g, both above 0. [-]"""
    return np.ceil(-1.0 / np.expm1(-2.0 * exponent * np.maximum(losses, LEAST_LOSS)))


def by_impact(losses: Array, log_profile: Array) -> Prediction:
    """Return the prediction of losses in proportion to a profile over the impacts, of geometric mean 1.

    `log_profile`, shape (impacts - 1,), lacks that of the last impact; `losses` are then the mean's.
    """
    profile = np.exp([*log_profile, -np.sum(log_profile)]).reshape(-1, *(1,) * losses.ndim)
    loss = np.minimum(losses * profile, MOST)
    return Prediction(np.exp(-loss), -2.0 * (np.cumsum(loss, axis=0) - loss))


@dataclass(frozen=True)
class ErrorModel:
    """What the error of a ratio has; each part can be left out to see what it brings.

    `growth` is the power of the speed with which the noise falls, None where it is not known.
    """

    growth: float | None = None
    by_trial: bool = True
    heavy_tails: bool = True
    alternation: bool = True
    correlation: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        parts = {
            "freedom": self.heavy_tails,
            "alternation": self.alternation,
            "lean": self.alternation,
            "noise_deviation": self.by_trial,
            "correlation": self.correlation,
            "growth": self.growth is None,
        }
        return tuple(name for name in STARTS if parts.get(name, True))


def rule(nodes: int) -> tuple[Array, Array]:
    """Return abscissas and logarithms of the weights of a rule for the standard normal distribution."""
    at, weight = np.polynomial.hermite_e.hermegauss(nodes)
    return at, np.log(weight / weight.sum())


def _log_normal(x: Array | float, deviation: Array | float) -> Array:
    return np.asarray(-0.5 * (x / deviation) ** 2 - np.log(deviation) - 0.5 * np.log(2 * np.pi))


CENTRES = rule(15)  # of the geometries, in their standard deviations


class Nodes(NamedTuple):
    """Values of each trial's loss, alternation and logarithm of noise, shapes (trials, nodes), with their log-weights.

    The weights are those of integrals by these values, without a density.
    """

    loss: Array
    loss_weight: Array
    alternation: Array
    alternation_weight: Array
    level: Array
    level_weight: Array


@dataclass(frozen=True, eq=False)
class Trials:
    """Ratios of trials, those with the most impacts first, and the geometry of each.

    `ratio` has the shape (trials, impacts), NaN after the last impact; `geometry` (trials,); `housner`, -ln e of
    Housner, (geometries,).
    """

    ratio: Array
    geometry: NDArray[np.intp]
    housner: Array
    errors: ErrorModel = field(default_factory=ErrorModel)

    @cached_property
    def reached(self) -> Array:
        """Number of impacts of each trial."""
        return np.asarray(np.isfinite(self.ratio).sum(axis=1))

    @cached_property
    def _counts(self) -> Array:
        """Number of trials that reach each impact."""
        return np.asarray(np.isfinite(self.ratio).sum(axis=0))

    @cached_property
    def _membership(self) -> Array:
        """One where a trial is of a geometry, shape (geometries, trials)."""
        return (self.geometry == np.arange(self.housner.size)[:, None]).astype(float)

    def values(self, point: Array) -> dict[str, float]:
        """Return the parameters by name, those that the error model lacks such that they do nothing."""
        named = dict(zip(self.errors.names, point, strict=False))
        values = {name: float(v if name in UNSCALED else np.exp(v)) for name, v in named.items()}
        if "freedom" in values:
            values["freedom"] += 1.0
        growth = {} if self.errors.growth is None else {"growth": self.errors.growth}
        return NOTHING | growth | values

    # --- nodes --------------------------------------------------------------------------------------------------------

    def spread_nodes(self, values: Mapping[str, float]) -> Nodes:
        """Return nodes for all losses that there may be and around the prior of the others: where a search begins."""
        trials, (_, alternations, levels) = len(self.ratio), NODES
        loss = np.broadcast_to(LOSSES, (trials, LOSSES.size))
        weight = np.broadcast_to(np.log(np.gradient(LOSSES)), loss.shape)
        none = np.zeros(trials)
        return Nodes(
            loss,
            weight,
            *self._around(none + values["lean"], none + values["alternation"], alternations, self.errors.alternation),
            *self._around(
                none + np.log(values["noise"]), none + values["noise_deviation"], levels, self.errors.by_trial
            ),
        )

    @staticmethod
    def _around(middle: Array, deviation: Array, nodes: int, varies: bool) -> tuple[Array, Array]:
        """Return nodes around a normal distribution of each trial; one node where nothing varies."""
        if not varies:
            return middle[:, None], np.zeros((middle.size, 1))
        at, log_weight = rule(nodes)
        value = middle[:, None] + deviation[:, None] * at
        # The rule's density is divided out: it is where the nodes are, not what is integrated.
        return value, log_weight - _log_normal(at, 1.0) + np.log(deviation)[:, None]

    def own_nodes(self, point: Array, prediction: Prediction, nodes: Nodes) -> Nodes:
        """Return nodes where each trial's ratios put its loss, alternation and level of noise."""
        joint = self.weighted(self.misfit(self.values(point), prediction, nodes), self.values(point), nodes)
        centres = self.losses_at_centres(self.values(point), nodes)
        joint += logsumexp(centres + CENTRES[1], axis=2)[:, :, None, None]
        share = np.exp(joint - joint.max(axis=(1, 2, 3), keepdims=True))
        share /= share.sum(axis=(1, 2, 3), keepdims=True)
        moments = []
        for values, others in ((nodes.loss, (2, 3)), (nodes.alternation, (1, 3)), (nodes.level, (1, 2))):
            each = share.sum(axis=others)
            mean = (each * values).sum(axis=1)
            variance = (each * (values - mean[:, None]) ** 2).sum(axis=1)
            moments.append((mean, np.sqrt(np.maximum(variance, 1e-10))))
        (loss, spread), alternation, level = moments
        at, weight = np.polynomial.legendre.leggauss(NODES[0])
        low, high = np.maximum(loss - REACH * spread, 0.0), loss + REACH * spread
        half = ((high - low) / 2)[:, None]
        return Nodes(
            ((high + low) / 2)[:, None] + half * at,
            np.log(half * weight),
            *self._around(*alternation, NODES[1], self.errors.alternation),
            *self._around(*level, NODES[2], self.errors.by_trial),
        )

    # --- likelihood ---------------------------------------------------------------------------------------------------

    def _errors(self, values: Mapping[str, float], prediction: Prediction, nodes: Nodes) -> list[Array]:
        """Return the errors z over their level, by the speed left: of each impact those of the trials that reach it.

        The shapes are (trials, losses, alternations).
        """
        errors: list[Array] = []
        for k, count in enumerate(self._counts):
            rise = np.exp(0.5 * values["growth"] * prediction.log_energy[k, :count])
            z = ((self.ratio[:count, k, None] - prediction.ratio[k, :count]) * rise)[:, :, None]
            z = z - ((-1.0) ** k * rise)[:, :, None] * nodes.alternation[:count, None, :]
            if errors and values["correlation"]:
                z -= values["correlation"] * errors[-1][:count]
            errors.append(z)
        return errors

    def _log_levels(self, values: Mapping[str, float], nodes: Nodes) -> Array:
        return nodes.level if self.errors.by_trial else np.full_like(nodes.level, np.log(values["noise"]))

    def misfit(self, values: Mapping[str, float], prediction: Prediction, nodes: Nodes) -> Array:
        """Return the log-density of each trial's ratios, shape (trials, losses, alternations, levels)."""
        freedom, levels = values["freedom"], self._log_levels(values, nodes)
        precision = np.exp(-2.0 * levels) / freedom
        log_rise = np.zeros(nodes.loss.shape)
        product = np.ones((precision.shape[1], *log_rise.shape, nodes.alternation.shape[1]))
        for z, log_energy in zip(self._errors(values, prediction, nodes), prediction.log_energy, strict=True):
            square, count = z * z, len(z)
            log_rise[:count] += 0.5 * values["growth"] * log_energy[:count]
            for level, weight in enumerate(precision[:count].T):
                # The product of the terms of all impacts, whose logarithm is taken once: it stays below 1e200.
                part = square * weight[:, None, None]
                part += 1.0
                product[level, :count] *= part
        density = np.log(np.moveaxis(product, 0, -1)) * (-(freedom + 1) / 2)
        density += log_rise[:, :, None, None]
        each = gammaln((freedom + 1) / 2) - gammaln(freedom / 2) - 0.5 * np.log(freedom * np.pi)
        density += (self.reached[:, None] * (each - levels))[:, None, None, :]
        return np.asarray(density)

    def slopes(
        self, values: Mapping[str, float], prediction: Prediction, nodes: Nodes, share: Array, misfit: Array
    ) -> tuple[dict[str, float], Prediction]:
        """Return the slopes of the mean misfit by the parameters of error and by the prediction.

        The mean is that with the probabilities `share` of the nodes, shape of the misfit. By Fisher's identity these
        are the slopes of the log-likelihood.
        """
        freedom, correlation, growth = (values[name] for name in ("freedom", "correlation", "growth"))
        levels = self._log_levels(values, nodes)
        of_loss, of_alternation, of_level = (np.einsum(f"tlas->{kept}", share) for kept in ("tl", "ta", "ts"))
        precision = np.exp(-2.0 * levels) / freedom
        weighted = np.ascontiguousarray(np.moveaxis(share * precision[:, None, None, :], -1, 0))
        errors = self._errors(values, prediction, nodes)
        by_error = np.zeros(weighted.shape[1:])  # at first of the impact before, as errors that are correlated pass on
        by_ratio, by_energy = np.zeros(prediction.ratio.shape), np.zeros(prediction.ratio.shape)
        squares = by_correlation = log_rise = 0.0
        for k in reversed(range(len(errors))):
            z, count = errors[k], len(errors[k])
            square, weight = z * z, np.zeros(z.shape)
            for level, precision_of_level in enumerate(precision[:count].T):
                part = square * precision_of_level[:, None, None]
                part += 1.0
                weight += np.divide(weighted[level, :count], part, out=part)
            squares += float((square * weight).sum())
            by_error[:count] = -(freedom + 1) * z * weight - correlation * by_error[:count]
            before = errors[k - 1][:count] if k else np.zeros(z.shape)
            by_correlation -= float((by_error[:count] * before).sum())
            log_energy = prediction.log_energy[k, :count]
            rise = np.exp(0.5 * growth * log_energy)
            by_ratio[k, :count] = -np.einsum("tla->tl", by_error[:count]) * rise
            by_energy[k, :count] = (
                np.einsum("tla,tla->tl", by_error[:count], z + correlation * before) + of_loss[:count]
            )
            log_rise += 0.5 * growth * float((log_energy * of_loss[:count]).sum())
        ratios = float(self.reached.sum())
        each = gammaln((freedom + 1) / 2) - gammaln(freedom / 2) - 0.5 * np.log(freedom * np.pi)
        logarithms = log_rise + ratios * each - float((self.reached[:, None] * levels * of_level).sum())
        logarithms = (logarithms - float((share * misfit).sum())) / (freedom + 1)  # half their mean
        by_freedom = (freedom + 1) / (2 * freedom) * squares - logarithms
        by_freedom += ratios * 0.5 * (digamma((freedom + 1) / 2) - digamma(freedom / 2) - 1 / freedom)
        by_parameter = {
            "freedom": by_freedom * (freedom - 1),
            "correlation": by_correlation,
            "growth": 0.5 * float((prediction.log_energy * by_energy).sum()),
            "noise": (freedom + 1) * squares - ratios,
        }
        if self.errors.by_trial:
            change = (nodes.level - np.log(values["noise"])) / values["noise_deviation"]
            by_parameter["noise"] = float((of_level * change).sum()) / values["noise_deviation"]
            by_parameter["noise_deviation"] = float((of_level * (change**2 - 1)).sum())
        if self.errors.alternation:
            change = (nodes.alternation - values["lean"]) / values["alternation"]
            by_parameter["lean"] = float((of_alternation * change).sum()) / values["alternation"]
            by_parameter["alternation"] = float((of_alternation * (change**2 - 1)).sum())
        return by_parameter, Prediction(by_ratio, 0.5 * growth * by_energy)

    def weighted(self, misfit: Array, values: Mapping[str, float], nodes: Nodes) -> Array:
        """Return the log-density with the weights of all nodes but the losses' hierarchy."""
        level, alternation = nodes.level_weight, nodes.alternation_weight
        if self.errors.by_trial:
            level = level + _log_normal(nodes.level - np.log(values["noise"]), values["noise_deviation"])
        if self.errors.alternation:
            alternation = alternation + _log_normal(nodes.alternation - values["lean"], values["alternation"])
        weights = nodes.loss_weight[:, :, None] + alternation[:, None, :]
        return np.asarray(misfit + weights[..., None] + level[:, None, None, :])

    def losses_at_centres(self, values: Mapping[str, float], nodes: Nodes) -> Array:
        """Return the log-density of each trial's losses at each centre, shape (trials, losses, centres)."""
        centre, within = self._centres(values), values["within"]
        above_zero = log_ndtr(centre / within)[self.geometry][:, None, :]
        return _log_normal(nodes.loss[:, :, None] - centre[self.geometry][:, None, :], within) - above_zero

    def _centres(self, values: Mapping[str, float]) -> Array:
        return np.asarray(self.housner[:, None] + values["centre"] + values["between"] * CENTRES[0])

    def at_centres(self, values: Mapping[str, float], of_losses: Array, nodes: Nodes) -> Array:
        """Return the log-likelihood of each trial at each centre of its geometry, shape (trials, centres)."""
        most = of_losses.max(axis=1, keepdims=True)
        prior = np.exp(self.losses_at_centres(values, nodes))
        return np.asarray(np.log((np.exp(of_losses - most)[:, None, :] @ prior)[:, 0] + 1e-300) + most)

    def centres_seen(self, values: Mapping[str, float], of_losses: Array, nodes: Nodes) -> Array:
        """Return the probability of each centre of each geometry after its trials, shape (geometries, centres)."""
        at_centres = self.at_centres(values, of_losses, nodes)
        return np.asarray(softmax(self._membership @ at_centres + CENTRES[1], axis=1))

    def total(
        self, values: Mapping[str, float], of_losses: Array, nodes: Nodes, weights: Array | float = 1.0
    ) -> tuple[float, Array, dict[str, float]]:
        """Return the log-likelihood of all trials, and its slopes.

        These are by the log-likelihood of each trial at each loss, shape (trials, losses), which is the probability of
        the loss after the ratios, and by the parameters of the hierarchy. `weights` say how often each trial counts.
        """
        times = np.broadcast_to(weights, len(self.ratio))[:, None]
        most = of_losses.max(axis=1, keepdims=True)
        joint = np.exp(of_losses - most)[:, :, None] * np.exp(self.losses_at_centres(values, nodes))
        at_centres = joint.sum(axis=1) + 1e-300
        of_geometries = self._membership @ ((np.log(at_centres) + most) * times) + CENTRES[1]
        # By Fisher's identity a slope is the mean of the joint density's over what is not observed.
        of_centre = softmax(of_geometries, axis=1)[self.geometry] * times
        joint *= (of_centre / at_centres)[:, None, :]
        within, deviations = values["within"], CENTRES[0] * values["between"]
        centre = self._centres(values) / within
        hazard = (np.sqrt(2 / np.pi) / erfcx(-centre / np.sqrt(2)))[self.geometry]  # phi / Phi
        centre = centre[self.geometry]
        z = nodes.loss[:, :, None] / within - centre[:, None, :]
        slope = joint * z
        by_centre = (slope.sum(axis=(0, 1)) - (of_centre * hazard).sum(axis=0)) / within
        by_hierarchy = {
            "centre": float(by_centre.sum()),
            "between": float(by_centre @ deviations),
            "within": float(np.vdot(slope, z) + (of_centre * (hazard * centre - 1)).sum()),
        }
        return float(np.logaddexp.reduce(of_geometries, axis=1).sum()), joint.sum(axis=2), by_hierarchy
