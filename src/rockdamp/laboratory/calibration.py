"""Curve and coefficient of restitution from measured records: least squares of a1, b1 and e, for one damper or all.

The paper's own calibration is "not reported". A record that the best fit does not explain is refused.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from scipy.optimize import OptimizeResult

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.constants import MODELS, REFERENCE, SOFTENING
from rockdamp.errors import (
    InputError,
    check,
    check_choice,
    check_list,
    check_number,
    check_type,
)
from rockdamp.histories.measured_test import measured_displacement
from rockdamp.histories.respond import record_attributes
from rockdamp.laboratory.record_fit import PARAMETERS, RecordFit
from rockdamp.laboratory.uncertainty import (
    NORMAL,
    check_deviations,
    covariance_by_motion,
    covariance_by_sensor,
    size_change,
)
from rockdamp.mechanics.curve import RULES
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.record import Record


def calibrate(
    records: Record | Sequence[Record],
    wall: Wall | Parapet,
    *,
    damping_model: str = REFERENCE,
    ultimate_displacement_ratio: float = 1.0,
    softening: str = "steeper",
    step: float = 0.005,
    uncertain: Mapping[str, float] | None = None,
) -> xr.Dataset:
    """Fit a1, b1 and e to one record or several of one wall by least squares, with their covariance.

    The response to the measured motion, plus an offset and a linear drift of the displacement sensor, is fitted to the
    measured displacement. A scan of the whole range gives the starts, so that the smallest of the local minima is the
    solution. The covariance has three parts: the residuals, which are correlated in time; the accelerometer's noise,
    which the wall amplifies near its strength; and uncertain sizes of the wall. Gains of the sensors are taken as
    exact: an error of them goes into b1. Several records are fitted one by one, and the estimates are weighted by their
    covariances: in stacked residuals the noise of one motion would disturb e of the others.

    Parameters
    ----------
    records : Record or sequence of them
        With a measured displacement, at rest before the motion.
    wall : Wall or Parapet
        Its geometry and weights are taken as known, except for the `uncertain` ones.
    damping_model : str
        Of a viscous damper, e is the coefficient that its damping ratio stands for at 0.3 u_ins.
    ultimate_displacement_ratio, softening : float and str
        a3 and the variant of softening, taken as known.
    step : float
        Largest step of the solver, in tau. [-]
    uncertain : dict of float, optional
        Standard deviation of sizes of the wall: thickness, height [m], hinge_ratio, overburden_ratio. [-]

    Returns
    -------
    xarray.Dataset
        ``estimate``, ``standard_error``, ``interval`` of 90 % and ``true_value`` (parameter; the last NaN unless the
        header of a synthetic record states it), ``covariance``, ``damping_ratio`` (NaN of CR), ``residual_rms`` with
        its ratios to the peak and to the noise at rest, ``run_estimate`` (run, parameter) and both histories (sample).

    Raises
    ------
    InputError
        If a record has no displacement or no rest, if the best fit lies at a bound of the search or leaves more than a
        tenth of the peak, or if the record does not determine the parameters.

    Examples
    --------
    >>> import numpy as np
    >>> import rockdamp as rd
    >>> wall = rd.Wall(thickness=0.102, height=27 * 0.102, hinge_ratio=0.57, overburden_ratio=6.2)
    >>> elapsed, random = np.arange(1281) / 256, np.random.RandomState(1)
    >>> pulse = 14.0 * (1 - (9 * (elapsed - 1.5)) ** 2) * np.exp(-((9 * (elapsed - 1.5)) ** 2) / 2)
    >>> motion = rd.Record(elapsed, pulse + 0.01 * random.standard_normal(elapsed.size))
    >>> shaken = rd.respond(wall, rd.TrilinearCurve(0.033, 0.795), rd.Damping("CR", 0.845), motion)
    >>> shown = shaken.control_displacement + 1e-4 * random.standard_normal(elapsed.size)
    >>> fit = rd.calibrate(rd.Record(elapsed, motion.ground_acceleration, shown), wall)
    >>> float(fit.estimate.sel(parameter="restitution").round(3))
    0.845
    """
    deviations = check_deviations(wall, uncertain)
    fits = make_fits(records, wall, damping_model, ultimate_displacement_ratio, softening, step)
    found = [fit.solution() for fit in fits]
    for fit, one in zip(fits, found, strict=True):
        _check_solution(fit, one)
    estimates = np.array([fit.parameters(one.x) for fit, one in zip(fits, found, strict=True)])
    precisions = np.linalg.inv(
        [estimate_covariance(fit, one) for fit, one in zip(fits, found, strict=True)]
    )
    covariance = np.linalg.inv(precisions.sum(axis=0))
    weights = covariance @ precisions  # of one run 1
    estimate = np.einsum("rij,rj->i", weights, estimates)
    for name, deviation in deviations.items():
        changes = [
            size_change(fit, one.x, name, deviation) for fit, one in zip(fits, found, strict=True)
        ]
        change = np.einsum("rij,rj->i", weights, np.array(changes))
        covariance += np.outer(change, change)
    for name, ratio in zip(PARAMETERS, estimate / np.sqrt(np.diag(covariance)), strict=True):
        determined = "at least 1: the record does not determine it"
        check(f"{name} over its standard error", ratio, lambda ratio: ratio >= 1, determined)
    return _dataset(fits, estimates, estimate, covariance).assign(misfit(fits, found))


def compare_dampers(
    records: Record | Sequence[Record],
    wall: Wall | Parapet,
    *,
    ultimate_displacement_ratio: float = 1.0,
    softening: str = "steeper",
    step: float = 0.005,
) -> xr.Dataset:
    """Fit every damper to each record, with a curve of its own, and weigh the dampers by their residuals.

    The weight of a damper goes with exp(-S/(2 s^2)), S the sum of its squared residuals and s the sensor's noise at
    rest. This assumes white noise, and that one of the dampers made the record: where the smallest
    `residual_over_noise` is well above 1, none of them explains it.

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
        # A record without any noise gets a billionth of its peak.
        noise = [
            max(fit.resting_deviation, 1e-9 * float(np.abs(fit.measured).max())) for fit in fits
        ]
        squares.append(
            sum(float(np.sum((one.fun / s) ** 2)) for one, s in zip(found, noise, strict=True))
        )
        rows.append(misfit(fits, found))
        estimates.append(
            np.mean([fit.parameters(one.x) for fit, one in zip(fits, found, strict=True)], axis=0)
        )
    log_likelihood = -(np.array(squares) - min(squares)) / 2
    weight = np.exp(log_likelihood)
    residuals = ("residual_rms", "residual_over_noise")
    return xr.Dataset(
        {
            **{name: ("damping_model", [row[name] for row in rows]) for name in residuals},
            "relative_log_likelihood": ("damping_model", log_likelihood),
            "weight": ("damping_model", weight / weight.sum()),
            "estimate": (("damping_model", "parameter"), np.array(estimates)),
        },
        coords={"damping_model": list(MODELS), "parameter": list(PARAMETERS)},
    )


def study(config: Config, record: Record) -> xr.Dataset:
    """Calibrate the wall of the config's ``validation`` section: its a3 and softening are kept, a1, b1 and e fitted."""
    validation = config.validation
    return calibrate(
        record,
        validation.wall.make(),
        ultimate_displacement_ratio=validation.curve.ultimate_displacement_ratio,
        softening=validation.curve.softening,
        step=validation.step,
    )


# --- steps of a calibration -------------------------------------------------------------------------------------------


def make_fits(
    records: Record | Sequence[Record],
    wall: Wall | Parapet,
    damping_model: str,
    ultimate_displacement_ratio: float,
    softening: str,
    step: float,
) -> list[RecordFit]:
    """Return the fit of each record; refuse a displacement that no standing wall can have."""
    check_type("wall", wall, Wall, Parapet)
    step = check_number("step", step, lambda step: step > 0, "greater than 0")
    a3 = check_number(
        "ultimate_displacement_ratio",
        ultimate_displacement_ratio,
        *RULES["ultimate_displacement_ratio"],
    )
    check_choice("softening", softening, SOFTENING)
    check_choice("damping_model", damping_model, MODELS)
    several = check_list("records", records, Record)
    # ASSUME: a wall that survives stays below u_ins; a sensor's drift and an inexact size may add half of that.
    largest = 1.5 * float(wall.instability_displacement)
    for record in several:
        peak = np.abs(measured_displacement(record)[0]).max()
        allowed = f"greater than 0 and at most 1.5 u_ins = {largest:.4g} m"
        check("largest measured displacement", peak, lambda u: (u > 0) & (u <= largest), allowed)
    return [RecordFit(record, wall, damping_model, a3, softening, step) for record in several]


def _check_solution(fit: RecordFit, found: OptimizeResult) -> None:
    """Raise `InputError` for a fit that explains the record badly, at a bound, or of a wall on its first branch."""
    residual, point = misfit([fit], [found]), found.x
    # ASSUME: tests that restitution explains well leave some per cent of the peak, or of small motions the noise.
    share = residual["residual_over_peak"]
    if share > 0.10 and not residual["residual_over_noise"] <= 3:
        raise InputError(
            f"the residual of the best fit is {100 * share:.2g} % of the peak; it must be at most 10 %"
        )
    names = (
        "yield_displacement_ratio over the plateau's end (a1/a2)",
        "strength_ratio (b1)",
        "restitution (e)",
    )
    for name, value, low, high in zip(names, point, *fit.bounds, strict=True):
        if min(value - low, high - value) < 1e-3 * (high - low):
            raise InputError(
                f"the best fit has {name} {value:.4g}; it must lie inside {low:g} to {high:g}"
            )
    parameters = fit.parameters(point)
    peak = float(np.abs(fit.response(parameters)).max())
    branch = float(parameters[0] * fit.wall.instability_displacement)
    if peak <= branch:  # where only b1/a1 matters
        raise InputError(
            f"the largest displacement is {peak:.3g} m, on the first branch, which ends at {branch:.3g} m;"
            " it must be larger to determine a1 and b1"
        )


def estimate_covariance(fit: RecordFit, found: OptimizeResult) -> Array:
    """Return the covariance of a1, b1 and e by the displacement sensor and by the motion."""
    ratio, b1, _ = found.x
    # From a point to its parameters: a1 = a1/a2 times a2, which falls as b1 rises. The derivative is taken by a1/a2:
    # steps of a1 of that size, several times as long, would bend the response.
    change = [[float(fit.plateau_end(b1)), -ratio, 0], [0, 1, 0], [0, 0, 1]]
    # A quarter of the fit's step: at its own the rough history makes single errors a third too large or too small.
    derivative = replace(fit, step=fit.step / 4).derivative(found.x) @ np.linalg.inv(change)
    by_sensor = covariance_by_sensor(derivative, found.fun)
    return by_sensor + covariance_by_motion(fit, fit.parameters(found.x), derivative)


def misfit(fits: Sequence[RecordFit], found: Sequence[OptimizeResult]) -> dict[str, float]:
    """Return the root mean square of the residuals [m], also over the largest peak and over the noise at rest [-]."""
    rms = float(np.sqrt(np.mean(np.concatenate([one.fun for one in found]) ** 2)))
    noise = float(np.sqrt(np.mean([fit.resting_deviation**2 for fit in fits])))
    return {
        "residual_rms": rms,
        "residual_over_peak": rms / max(float(np.abs(fit.measured).max()) for fit in fits),
        "residual_over_noise": rms / noise if noise > 0 else np.nan,
        "rest_deviation": noise,
    }


def true_values(header: Mapping[str, str]) -> Array:
    """Return the parameters that made a synthetic record; NaN where its header does not state them, or of a test."""
    synthetic = header.get("synthetic") == "yes"
    return np.array(
        [
            float(header.get(f"generator_{name}", "nan")) if synthetic else np.nan
            for name in PARAMETERS
        ]
    )


def _dataset(
    fits: Sequence[RecordFit], estimates: Array, estimate: Array, covariance: Array
) -> xr.Dataset:
    """Return the estimates, of all runs and of each, with the fitted and the measured histories."""
    first, error = fits[0], np.sqrt(np.diag(covariance))
    responses = [fit.response(one) for fit, one in zip(fits, estimates, strict=True)]
    measured = [
        u + fit.subtract_trend(fit.measured - u) for fit, u in zip(fits, responses, strict=True)
    ]
    xi = np.nan
    if first.damping_model != REFERENCE:
        xi = float(first.damping(estimate).value)
    return xr.Dataset(
        {
            "estimate": ("parameter", estimate),
            "standard_error": ("parameter", error),
            "interval": (("bound", "parameter"), estimate + NORMAL * np.outer([-1, 1], error)),
            "true_value": ("parameter", true_values(first.record.header)),
            "covariance": (("parameter", "parameter_other"), covariance),
            "damping_ratio": xi,
            "run_estimate": (("run", "parameter"), estimates),
            "measured": ("sample", np.concatenate(measured)),
            "control_displacement": ("sample", np.concatenate(responses)),
            "sample_run": (
                "sample",
                np.repeat(np.arange(1, len(fits) + 1), [u.size for u in responses]),
            ),
        },
        coords={
            "parameter": list(PARAMETERS),
            "parameter_other": list(PARAMETERS),
            "bound": ["low", "high"],
            "run": np.arange(1, len(fits) + 1),
            "elapsed": ("sample", np.concatenate([fit.record.elapsed for fit in fits])),
        },
        attrs=record_attributes(first.record.header) | {"damping_model": first.damping_model},
    )
