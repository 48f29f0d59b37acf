"""Stages of the pipeline on measured tests: the calibration on a record, and trials of blocks."""

from __future__ import annotations

from functools import partial

import numpy as np
import xarray as xr

from rockdamp.config import Config
from rockdamp.constants import PAPER_MODELS, REFERENCE
from rockdamp.laboratory.calibration import calibrate
from rockdamp.laboratory.restitution_spread import restitution_spread
from rockdamp.laboratory.trials import (
    TRIAL_KEY,
    make_trials,
    power_law,
    predict_damper,
    read_rocking_trials,
)
from rockdamp.laboratory.trials_likelihood import Likelihood
from rockdamp.laboratory.uncertainty import NORMAL_QUANTILE
from rockdamp.motions.record import Record
from rockdamp.progress import track


def calibration(config: Config, record: Record) -> xr.Dataset:
    """Fit a1, b1 and e of the wall in the config's ``validation`` to a record, at its a3."""
    validation = config.validation
    return calibrate(
        record,
        validation.wall.make(),
        ultimate_displacement_ratio=validation.curve.ultimate_displacement_ratio,
        softening=validation.curve.softening,
        step=validation.step,
    )


def measured_rocking(config: Config, trials_file: str) -> xr.Dataset:
    """Fit each damper and a power law to measured ratios; describe restitution's spread."""
    settings = config.measured_rocking
    rows = read_rocking_trials(trials_file)
    log_likelihoods = []
    exponent_intervals = []
    spread: dict[str, object] = {}
    for impacts in track(settings.impacts_used, "impacts used"):
        trials = make_trials(rows, impacts)
        constant = Likelihood(trials, predict_damper(REFERENCE, impacts))
        fits = [constant.fit()]
        for model in PAPER_MODELS:
            damper = Likelihood(trials, predict_damper(model, impacts))
            fits.append(damper.fit(fits[-1]))
        law = Likelihood(trials, partial(power_law, impacts=impacts))
        law_fit = law.fit(fits[0], power_law=True)
        log_likelihoods.append([fit.log_likelihood for fit in (*fits, law_fit)])
        reach = NORMAL_QUANTILE * law.standard_errors(law_fit)[-1] * np.array([-1, 0, 1])
        exponent_intervals.append(law_fit.point[-1] + reach)
        if impacts == settings.shown_impacts:
            spread = restitution_spread(constant, fits[0])
    low, exponent, high = np.transpose(exponent_intervals)
    exponent_bounds = np.stack([low, high], axis=1)
    blocks = rows.groupby("group").first()
    repeated_trial = rows.groupby(TRIAL_KEY)["duplicate_of_trial"].first()
    trial_counts = repeated_trial.isna().groupby("group").sum()
    return xr.Dataset(
        {
            "log_likelihood": (("damping_model", "impacts_used"), np.transpose(log_likelihoods)),
            "amplitude_exponent": ("impacts_used", exponent),
            "amplitude_exponent_interval": (("impacts_used", "bound"), exponent_bounds),
            **spread,
            "geometry_trials": ("geometry", trial_counts.to_numpy()),
            "impacts": len(rows),
            "trials": repeated_trial.size,
            "duplicates": int(repeated_trial.notna().sum()),
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
