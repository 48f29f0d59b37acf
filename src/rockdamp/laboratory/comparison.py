"""Dampers compared by the least squares that each leaves of measured records."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from rockdamp.constants import MODELS
from rockdamp.laboratory.calibration import make_fit, misfits
from rockdamp.laboratory.record_fit import PARAMETERS, resting_deviation
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.record import Record

SMALLEST_NOISE = 1e-9  # of the peak, that of a record without any


def compare_dampers(
    records: Record | Sequence[Record],
    wall: Wall | Parapet,
    *,
    ultimate_displacement_ratio: float = 1.0,
    softening: str = "steeper",
    step: float = 0.005,
) -> xr.Dataset:
    """Fit every damper to records, each with a curve of its own, and weigh the dampers by what they leave.

    The weight of a damper goes with exp(-S/(2 s^2)), S the sum of its squared residuals and s the sensor's noise at
    rest. It supposes white noise, and that one of them made the record: where the smallest `residual_over_noise` is
    well above 1, none of them explains it.

    Returns
    -------
    xarray.Dataset
        ``residual_rms``, ``residual_over_noise``, ``relative_log_likelihood`` and ``weight`` (damping_model), and the
        ``estimate`` (damping_model, parameter). The arguments are those of `calibrate`.
    """
    rows, estimates, squares = [], [], []
    for model in MODELS:
        fit = make_fit(records, wall, model, ultimate_displacement_ratio, softening, step)
        found = fit.solution()
        peak = float(np.abs(fit.measured).max())
        noise = [max(resting_deviation(record), SMALLEST_NOISE * peak) for record in fit.records]
        squares.append(sum(float(np.sum((found.fun[run] / s) ** 2)) for run, s in zip(fit.runs, noise, strict=True)))
        rows.append(misfits(fit, found))
        estimates.append(fit.parameters(found.x))
    log_likelihood = -(np.array(squares) - min(squares)) / 2
    weight = np.exp(log_likelihood)
    return xr.Dataset(
        {
            **{
                name: ("damping_model", [row[name] for row in rows]) for name in ("residual_rms", "residual_over_noise")
            },
            "relative_log_likelihood": ("damping_model", log_likelihood),
            "weight": ("damping_model", weight / weight.sum()),
            "estimate": (("damping_model", "parameter"), np.array(estimates)),
        },
        coords={"damping_model": list(MODELS), "parameter": list(PARAMETERS)},
    )
