"""Restitution of measured blocks over Housner's, and its spread within and between geometries."""

from __future__ import annotations

import numpy as np
from scipy.special import softmax

from rockdamp.arrays import Array
from rockdamp.laboratory.trials import FIRST_LOSSES
from rockdamp.laboratory.trials_likelihood import (
    CENTRES,
    Likelihood,
    TrialsFit,
    log_normal,
    parameter_values,
)
from rockdamp.laboratory.uncertainty import NORMAL_QUANTILE


def restitution_spread(likelihood: Likelihood, fitted: TrialsFit) -> dict[str, object]:
    """Return variables of a dataset: e over Housner's of each geometry, and its spreads.

    Parameters
    ----------
    likelihood : Likelihood
        Trials under one restitution coefficient for all impacts of a trial.
    fitted : TrialsFit
        Maximum of this likelihood.
    """
    trials = likelihood.trials
    values = parameter_values(fitted.point)
    housner = trials.housner
    prior = np.exp(CENTRES.log_weights)
    density = _trial_density(housner, values)
    mean = np.einsum("c,gcj->gj", FIRST_LOSSES, density)
    squares = (FIRST_LOSSES[:, None] - mean[:, None, :]) ** 2
    variance = np.einsum("gcj,gcj->gj", squares, density)
    # Variance of a trial's loss: the mean within geometries plus the variance between them.
    overall = mean @ prior
    within = variance @ prior
    between = (mean - overall[:, None]) ** 2 @ prior
    # Weights of the centres after the trials.
    posterior = softmax(likelihood.centre_likelihood(values, fitted.nodes), axis=1)
    estimate = (posterior * mean).sum(axis=1)
    scatter = np.sqrt((posterior * (mean - estimate[:, None]) ** 2).sum(axis=1))
    reach = np.outer(scatter, [NORMAL_QUANTILE, -NORMAL_QUANTILE])
    bounds = housner[:, None] - estimate[:, None] - reach
    trial_bounds = _loss_quantiles(np.einsum("gj,gcj->gc", posterior, density))
    # For comparison, without a model: the first measured ratios about the mean of their geometry.
    first = np.log(trials.ratio[:, 0])
    first_means = likelihood.membership @ first / likelihood.membership.sum(axis=1)
    first_deviation = np.sqrt(np.mean((first - first_means[trials.geometry]) ** 2))
    return {
        "housner_restitution": ("geometry", np.exp(-housner)),
        "restitution_over_housner": ("geometry", np.exp(housner - estimate)),
        "restitution_over_housner_interval": (("geometry", "bound"), np.exp(bounds)),
        "trial_over_housner_interval": (
            ("geometry", "bound"),
            np.exp(housner[:, None] - trial_bounds),
        ),
        "restitution_over_housner_mean": float(np.exp((housner - overall).mean())),
        "trial_deviation": ("geometry", np.sqrt(within + between)),
        "deviation_within": float(np.sqrt(within.mean())),
        "deviation_between": float(np.sqrt(between.mean())),
        "first_ratio_deviation_within": float(first_deviation),
        "noise": values["noise"],
        "alternation": values["alternation"],
    }


def _trial_density(housner: Array, values: dict[str, float]) -> Array:
    """Return the density of a trial's loss, shape (geometries, losses, centres); it sums to 1."""
    centre = housner[:, None] + values["centre"] + values["between"] * CENTRES.nodes
    deviation = FIRST_LOSSES[:, None] - centre[:, None, :]
    widths = np.gradient(FIRST_LOSSES)[:, None]
    density = np.exp(log_normal(deviation, values["within"])) * widths
    density /= density.sum(axis=1, keepdims=True)
    return density


def _loss_quantiles(loss_density: Array) -> Array:
    """Return the 95 % and 5 % quantiles of each geometry's losses, shape (geometries, 2)."""
    half = loss_density / 2  # half of a loss's density lies below it
    shares = np.cumsum(loss_density, axis=1) - half
    return np.array([np.interp([0.95, 0.05], share, FIRST_LOSSES) for share in shares])
