"""Dampers compared by the least squares that each leaves of measured records."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from rockdamp.constants import MODELS
from rockdamp.laboratory.calibration import make_fits, misfit
from rockdamp.laboratory.record_fit import PARAMETERS
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
    """Fit every damper to each record, with a curve of its own, and weigh the dampers by what they leave.

    The weight of a damper goes with exp(-S/(2 s^2)), S the sum of its squared residuals and s the sensor's noise at
    rest. It supposes white noise, and that one of them made the record: where the smallest `residual_over_noise` is
    well above 1, none of them explains it.

    Returns
    -------
    xarray.Dataset
        ``residual_rms``, ``residual_over_noise``, ``relative_log_likelihood`` and ``weight`` (damping_model), and the
        ``estimate`` (damping_model, parameter), a mean over the records. The arguments are those of `calibrate`.
    """
    rows, squares, estimates = [], [], []
    for model in MODELS:
        fits = make_fits(records, wall, model, ultimate_displacement_ratio, softening, step)
        found = [fit.solution() for fit in fits]
        noise = [max(fit.resting_deviation, SMALLEST_NOISE * float(np.abs(fit.measured).max())) for fit in fits]
        squares.append(sum(float(np.sum((one.fun / s) ** 2)) for one, s in zip(found, noise, strict=True)))
        rows.append(misfit(fits, found))
        estimates.append(np.mean([fit.parameters(one.x) for fit, one in zip(fits, found, strict=True)], axis=0))
    log_likelihood = -(np.array(squares) - min(squares)) / 2
    weight = np.exp(log_likelihood)
    names = ("residual_rms", "residual_over_noise")
    return xr.Dataset(
        {
            **{name: ("damping_model", [row[name] for row in rows]) for name in names},
            "relative_log_likelihood": ("damping_model", log_likelihood),
            "weight": ("damping_model", weight / weight.sum()),
            "estimate": (("damping_model", "parameter"), np.array(estimates)),
        },
        coords={"damping_model": list(MODELS), "parameter": list(PARAMETERS)},
    )
