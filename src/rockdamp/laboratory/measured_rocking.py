"""The stage: which damping model measured free rocking supports, and how restitution scatters."""

from __future__ import annotations

from functools import partial

import numpy as np
import xarray as xr
from scipy.special import softmax

from rockdamp.config import Config
from rockdamp.constants import PAPER_MODELS, REFERENCE
from rockdamp.laboratory.calibration import NORMAL
from rockdamp.laboratory.trials import LOSSES, DamperLosses, RockingTrials, power_law, read_rocking_trials
from rockdamp.laboratory.trials_likelihood import (
    CENTRES,
    Predict,
    Trials,
    TrialsFit,
    fit_trials,
    log_normal,
    parameter_values,
    standard_errors,
)
from rockdamp.mechanics.wall import Parapet
from rockdamp.progress import track

MODELS = (REFERENCE, *PAPER_MODELS)  # ECD and BAND lose as REFERENCE does
POWER_LAW = "power law"  # of the loss in the energy left, at its most likely exponent
TAILS = 0.05, 0.95  # of an interval of 90 %


def measured_rocking(config: Config) -> xr.Dataset:
    """Fit each damper, and a power law of the loss, to measured ratios; describe restitution and its spread."""
    settings = config.measured_rocking
    measured = read_rocking_trials(settings.trials)
    log_likelihood = np.empty((len(MODELS) + 1, len(settings.impacts_used)))
    exponents, references = [], {}
    for column, impacts in enumerate(track(settings.impacts_used, "impacts used")):
        trials = make_trials(measured, impacts)
        fits = [fit_trials(trials, damper(REFERENCE, impacts))]
        for model in PAPER_MODELS:
            fits.append(fit_trials(trials, damper(model, impacts), fits[-1]))
        law = partial(power_law, impacts=impacts)
        fits.append(fit_trials(trials, law, fits[0], free=True))
        log_likelihood[:, column] = [fit.log_likelihood for fit in fits]
        exponent, error = fits[-1].point[-1], standard_errors(trials, law, fits[-1])[-1]
        exponents.append((exponent, exponent - NORMAL * error, exponent + NORMAL * error))
        references[impacts] = fits[0]
    impact_count = settings.shown_impacts
    exponent, *interval = np.array(exponents).T
    return xr.Dataset(
        {
            "log_likelihood": (("damping_model", "impacts_used"), log_likelihood),
            "amplitude_exponent": ("impacts_used", exponent),
            "amplitude_exponent_interval": (("impacts_used", "bound"), np.transpose(interval)),
            **restitution(
                make_trials(measured, impact_count), damper(REFERENCE, impact_count), references[impact_count]
            ),
            "geometry_trials": ("geometry", np.bincount(measured.geometry)),
            "impacts": measured.impacts,
            "trials": measured.trials,
            "duplicates": measured.duplicates,
            "shown_impacts": impact_count,
        },
        coords={
            "damping_model": [*MODELS, POWER_LAW],
            "impacts_used": settings.impacts_used,
            "geometry": measured.height / measured.thickness,
            "bound": ["lower", "upper"],
        },
    )


def make_trials(measured: RockingTrials, impacts: int) -> Trials:
    """Return the ratios of the first impacts, and Housner's loss of each block."""
    housner = -np.log(Parapet(measured.thickness, measured.height).restitution_rigid)
    return Trials(measured.ratio[:, :impacts], measured.geometry, housner)


def damper(model: str, impacts: int) -> Predict:
    """Return what a damper predicts for a block."""
    losses = DamperLosses(model, impacts)
    return lambda first, _: losses(first)


def restitution(trials: Trials, predict: Predict, fitted: TrialsFit) -> dict[str, object]:
    """Return e over Housner's of each geometry, and its spread within and between them, by one e for all impacts."""
    values, nodes, housner = parameter_values(fitted.point), fitted.nodes, trials.housner
    prior = np.exp(CENTRES[1])
    centre = (housner[:, None] + values["centre"] + values["between"] * CENTRES[0])[:, None, :]
    density = np.exp(log_normal(LOSSES[:, None] - centre, values["within"])) * np.gradient(LOSSES)[:, None]
    density /= density.sum(axis=1, keepdims=True)  # of a trial's loss, shape (geometries, losses, centres)
    mean = np.einsum("c,gcj->gj", LOSSES, density)
    variance = np.einsum("gcj,gcj->gj", (LOSSES[:, None] - mean[:, None, :]) ** 2, density)
    overall = mean @ prior
    within, between = variance @ prior, (mean - overall[:, None]) ** 2 @ prior
    by_loss = trials.loss_likelihood(values, predict(nodes.loss, 0.0), nodes)
    seen = softmax(trials.centre_likelihood(values, by_loss, nodes), axis=1)  # of each centre, after the trials
    estimate = (seen * mean).sum(axis=1)
    scatter = np.sqrt((seen * (mean - estimate[:, None]) ** 2).sum(axis=1))
    loss_density = np.einsum("gj,gcj->gc", seen, density)
    below = np.cumsum(loss_density, axis=1) - loss_density / 2  # half of a loss's own part lies below it
    ends = np.array([np.interp(TAILS[::-1], share, LOSSES) for share in below])
    bounds = housner[:, None] - estimate[:, None] - np.outer(scatter, [NORMAL, -NORMAL])
    first = np.log(trials.ratio[:, 0])
    means = trials.membership @ first / trials.membership.sum(axis=1)
    return {
        "housner_restitution": ("geometry", np.exp(-housner)),
        "restitution_over_housner": ("geometry", np.exp(housner - estimate)),
        "restitution_over_housner_interval": (("geometry", "bound"), np.exp(bounds)),
        "trial_over_housner_interval": (("geometry", "bound"), np.exp(housner[:, None] - ends)),
        "restitution_over_housner_mean": float(np.exp((housner - overall).mean())),
        "trial_deviation": ("geometry", np.sqrt(within + between)),
        "deviation_within": float(np.sqrt(within.mean())),
        "deviation_between": float(np.sqrt(between.mean())),
        "first_ratio_deviation_within": float(np.sqrt(np.mean((first - means[trials.geometry]) ** 2))),
        "noise": values["noise"],
        "alternation": values["alternation"],
    }
