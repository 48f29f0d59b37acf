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
from scipy.special import gammaln, log_ndtr, logsumexp, softmax

from rockdamp.arrays import Array

MOST = 3.0  # loss of an impact after which the block all but rests; no prediction goes beyond it
NORMAL = 200.0  # degrees of freedom of Student's t that are as good as a normal distribution
# First losses among which a trial's is looked for: fine near 0, where slender blocks are, and beyond any trial.
LOSSES = 0.35 * np.linspace(0.0, 1.0, 61) ** 1.5 + 1e-4
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
OF_ERRORS = ("freedom", "correlation", "growth")  # the parameters that change more than weights


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
        joint = self._joint(self.values(point), prediction, nodes)
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

    def misfit(self, values: Mapping[str, float], prediction: Prediction, nodes: Nodes) -> Array:
        """Return the log-density of each trial's ratios, shape (trials, losses, alternations, levels)."""
        freedom, correlation = values["freedom"], values["correlation"]
        levels = nodes.level if self.errors.by_trial else np.full_like(nodes.level, np.log(values["noise"]))
        trials, losses = nodes.loss.shape
        precision = np.exp(-2.0 * levels) / freedom
        product = np.ones((precision.shape[1], trials, losses, nodes.alternation.shape[1]))
        error, square, factor = (np.zeros(product.shape[1:]) for _ in range(3))
        log_rise = np.zeros((trials, losses))
        for k in range(self.ratio.shape[1]):
            count = int(np.count_nonzero(self.reached > k))
            speed = 0.5 * values["growth"] * prediction.log_energy[k, :count]
            rise, z, z2, part = np.exp(speed), error[:count], square[:count], factor[:count]
            z *= -correlation
            z += ((self.ratio[:count, k, None] - prediction.ratio[k, :count]) * rise)[:, :, None]
            z -= (-1.0) ** k * rise[:, :, None] * nodes.alternation[:count, None, :]
            np.multiply(z, z, out=z2)
            for level in range(len(product)):
                # The product of the terms of all impacts, whose logarithm is taken once: it stays below 1e200.
                np.multiply(z2, precision[:count, level, None, None], out=part)
                part += 1.0
                product[level, :count] *= part
            log_rise[:count] += speed
        density = np.log(np.moveaxis(product, 0, -1)) * (-(freedom + 1) / 2)
        density += log_rise[:, :, None, None]
        each = gammaln((freedom + 1) / 2) - gammaln(freedom / 2) - 0.5 * np.log(freedom * np.pi)
        density += (self.reached[:, None] * (each - levels))[:, None, None, :]
        return np.asarray(density)

    def _weighted(self, misfit: Array, values: Mapping[str, float], nodes: Nodes) -> Array:
        """Return the log-density with the weights of all nodes but the losses' hierarchy."""
        level, alternation = nodes.level_weight, nodes.alternation_weight
        if self.errors.by_trial:
            level = level + _log_normal(nodes.level - np.log(values["noise"]), values["noise_deviation"])
        if self.errors.alternation:
            alternation = alternation + _log_normal(nodes.alternation - values["lean"], values["alternation"])
        weights = nodes.loss_weight[:, :, None] + alternation[:, None, :]
        return np.asarray(misfit + weights[..., None] + level[:, None, None, :])

    def _joint(self, values: Mapping[str, float], prediction: Prediction, nodes: Nodes) -> Array:
        return self._weighted(self.misfit(values, prediction, nodes), values, nodes)

    def losses_at_centres(self, values: Mapping[str, float], nodes: Nodes) -> Array:
        """Return the log-density of each trial's losses at each centre, shape (trials, losses, centres)."""
        centre = self.housner[:, None] + values["centre"] + values["between"] * CENTRES[0]
        within, of_trial = values["within"], centre[self.geometry][:, None, :]
        return _log_normal(nodes.loss[:, :, None] - of_trial, within) - log_ndtr(of_trial / within)

    def of_losses(self, values: Mapping[str, float], misfit: Array, nodes: Nodes) -> Array:
        """Return the log-likelihood of each trial at each loss, with the loss's weight, shape (trials, losses)."""
        joint = self._weighted(misfit, values, nodes).reshape(*nodes.loss.shape, -1)
        most = joint.max(axis=(1, 2), keepdims=True)
        return np.asarray(np.log(np.exp(joint - most).sum(axis=2) + 1e-300) + most[:, :, 0])

    def at_centres(self, values: Mapping[str, float], of_losses: Array, nodes: Nodes) -> Array:
        """Return the log-likelihood of each trial at each centre of its geometry, shape (trials, centres)."""
        most = of_losses.max(axis=1, keepdims=True)
        prior = np.exp(self.losses_at_centres(values, nodes))
        return np.asarray(np.log((np.exp(of_losses - most)[:, None, :] @ prior)[:, 0] + 1e-300) + most)

    def of_geometries(self, at_centres: Array) -> Array:
        """Return the log-likelihood of each geometry's trials at each centre, with its weight, shape as `CENTRES`."""
        return self._membership @ at_centres + CENTRES[1]

    def centres_seen(self, values: Mapping[str, float], of_losses: Array, nodes: Nodes) -> Array:
        """Return the probability of each centre of each geometry after its trials, shape (geometries, centres)."""
        return np.asarray(softmax(self.of_geometries(self.at_centres(values, of_losses, nodes)), axis=1))

    def mean_losses(self, values: Mapping[str, float], of_losses: Array, nodes: Nodes) -> Array:
        """Return the mean of each trial's first loss after its ratios, shape (trials,)."""
        seen = self.centres_seen(values, of_losses, nodes)[self.geometry]
        at_centres = self.losses_at_centres(values, nodes)
        weight = np.exp(of_losses - of_losses.max(axis=1, keepdims=True))[:, :, None] * np.exp(at_centres)
        mean = (weight * nodes.loss[:, :, None]).sum(axis=1) / weight.sum(axis=1)
        return np.asarray((mean * seen).sum(axis=1))

    def total(self, at_centres: Array) -> float:
        """Return the log-likelihood of all trials."""
        return float(np.logaddexp.reduce(self.of_geometries(at_centres), axis=1).sum())
