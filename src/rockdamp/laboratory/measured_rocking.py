"""The stage: which damping model measured free rocking supports, and how restitution scatters."""

from __future__ import annotations

from functools import partial

import numpy as np
import xarray as xr
from scipy.special import softmax

from rockdamp.config import Config
from rockdamp.constants import PAPER_MODELS, REFERENCE
from rockdamp.laboratory.trials import (
    KEY,
    LOSSES,
    make_trials,
    power_law,
    predict_damper,
    read_rocking_trials,
)
from rockdamp.laboratory.trials_likelihood import (
    CENTRES,
    Likelihood,
    TrialsFit,
    log_normal,
    parameter_values,
)
from rockdamp.laboratory.uncertainty import NORMAL
from rockdamp.progress import track


def measured_rocking(config: Config, trials_file: str) -> xr.Dataset:
    """Fit each damper, and a power law of the loss, to measured ratios; describe restitution and its spread."""
    settings = config.measured_rocking
    rows = read_rocking_trials(trials_file)
    log_likelihood, exponents, by_restitution = [], [], {}
    for impacts in track(settings.impacts_used, "impacts used"):
        trials = make_trials(rows, impacts)
        constant, *dampers = (
            Likelihood(trials, predict_damper(name, impacts)) for name in (REFERENCE, *PAPER_MODELS)
        )
        law = Likelihood(trials, partial(power_law, impacts=impacts))
        fits = [constant.fit()]
        for damper in dampers:
            fits.append(damper.fit(fits[-1]))
        fits.append(law.fit(fits[0], power_law=True))
        log_likelihood.append([fit.log_likelihood for fit in fits])
        exponents.append(
            fits[-1].point[-1] + NORMAL * law.standard_errors(fits[-1])[-1] * np.array([-1, 0, 1])
        )
        by_restitution[impacts] = constant, fits[0]
    low, exponent, high = np.transpose(exponents)
    blocks, repeats = rows.groupby("group").first(), rows.groupby(KEY)["duplicate_of_trial"].first()
    return xr.Dataset(
        {
            "log_likelihood": (("damping_model", "impacts_used"), np.transpose(log_likelihood)),
            "amplitude_exponent": ("impacts_used", exponent),
            "amplitude_exponent_interval": (
                ("impacts_used", "bound"),
                np.stack([low, high], axis=1),
            ),
            **restitution(*by_restitution[settings.shown_impacts]),
            "geometry_trials": ("geometry", repeats.isna().groupby("group").sum().to_numpy()),
            "impacts": len(rows),
            "trials": repeats.size,
            "duplicates": int(repeats.notna().sum()),
            "shown_impacts": settings.shown_impacts,
        },
        coords={
            # ECD and BAND lose as the reference does.
            "damping_model": [REFERENCE, *PAPER_MODELS, "power law"],
            "impacts_used": settings.impacts_used,
            "geometry": (blocks["height_m"] / blocks["thickness_m"]).to_numpy(),
            "bound": ["lower", "upper"],
        },
    )


def restitution(likelihood: Likelihood, fitted: TrialsFit) -> dict[str, object]:
    """Return e over Housner's of each geometry, and its spread within and between them, by one e for all impacts."""
    trials, values = likelihood.trials, parameter_values(fitted.point)
    housner, prior = trials.housner, np.exp(CENTRES[1])
    centre = (housner[:, None] + values["centre"] + values["between"] * CENTRES[0])[:, None, :]
    density = (
        np.exp(log_normal(LOSSES[:, None] - centre, values["within"]))
        * np.gradient(LOSSES)[:, None]
    )
    density /= density.sum(
        axis=1, keepdims=True
    )  # of a trial's loss, shape (geometries, losses, centres)
    mean = np.einsum("c,gcj->gj", LOSSES, density)
    variance = np.einsum("gcj,gcj->gj", (LOSSES[:, None] - mean[:, None, :]) ** 2, density)
    overall = mean @ prior
    within, between = variance @ prior, (mean - overall[:, None]) ** 2 @ prior
    # Of each centre, after the trials.
    posterior = softmax(likelihood.centre_likelihood(values, fitted.nodes), axis=1)
    estimate = (posterior * mean).sum(axis=1)
    scatter = np.sqrt((posterior * (mean - estimate[:, None]) ** 2).sum(axis=1))
    loss_density = np.einsum("gj,gcj->gc", posterior, density)
    below = (
        np.cumsum(loss_density, axis=1) - loss_density / 2
    )  # half of a loss's own part lies below it
    ends = np.array([np.interp([0.95, 0.05], share, LOSSES) for share in below])
    bounds = housner[:, None] - estimate[:, None] - np.outer(scatter, [NORMAL, -NORMAL])
    first = np.log(trials.ratio[:, 0])
    means = likelihood.membership @ first / likelihood.membership.sum(axis=1)
    return {
        "housner_restitution": ("geometry", np.exp(-housner)),
        "restitution_over_housner": ("geometry", np.exp(housner - estimate)),
        "restitution_over_housner_interval": (("geometry", "bound"), np.exp(bounds)),
        "trial_over_housner_interval": (("geometry", "bound"), np.exp(housner[:, None] - ends)),
        "restitution_over_housner_mean": float(np.exp((housner - overall).mean())),
        "trial_deviation": ("geometry", np.sqrt(within + between)),
        "deviation_within": float(np.sqrt(within.mean())),
        "deviation_between": float(np.sqrt(between.mean())),
        "first_ratio_deviation_within": float(
            np.sqrt(np.mean((first - means[trials.geometry]) ** 2))
        ),
        "noise": values["noise"],
        "alternation": values["alternation"],
    }
