"""Curve and restitution from measured records: least squares of a1, b1 and e.

The paper's own calibration is "not reported". A record that the best fit does not explain is
refused.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.constants import MODELS, REFERENCE, SOFTENING
from rockdamp.errors import (
    InputError,
    check,
    check_choice,
    check_list,
    check_number,
    check_type,
)
from rockdamp.histories.record_rest import measured_displacement
from rockdamp.histories.respond import record_attributes
from rockdamp.laboratory.record_fit import PARAMETERS, RecordFit, Solution
from rockdamp.laboratory.uncertainty import (
    NORMAL_QUANTILE,
    check_deviations,
    covariance_by_motion,
    covariance_by_sensor,
    size_change,
)
from rockdamp.mechanics.curve import CURVE_RULES
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
    """Fit a1, b1 and e to one or more records of a wall by least squares, with their covariance.

    The response to the measured motion, plus an offset and a linear drift of the displacement
    sensor, is fitted to the measured displacement. A scan of the whole range provides the starting
    points, so that the fit finds the lowest local minimum.

    The covariance has three parts: residuals, which are correlated in time; noise of the
    accelerometer, which the wall amplifies near its strength; and uncertain sizes of the wall. The
    gains of the sensors are taken as exact: an error in a gain becomes an error in b1.

    Several records are fitted separately, and their estimates weighted by their covariances: with
    stacked residuals the noise of one motion would disturb the e of the others.

    Parameters
    ----------
    records : Record or sequence of Record
        Measured tests of the wall, each with a displacement and with rest before the motion.
    wall : Wall or Parapet
        Sizes and weights of the wall, exact except for those in `uncertain`.
    damping_model : {"CR", "CDC", "CDR", "SDR", "ECD", "BAND"}
        Damping model. For a viscous damper, e is the coefficient that loses as much energy as the
        damper at an amplitude of 0.3 a3 u_ins. Default: "CR".
    ultimate_displacement_ratio : float
        Known a3, in (0, 1]. Default: 1. [-]
    softening : {"steeper", "translated"}
        Known variant of the softening branch. Default: "steeper".
    step : float
        Largest step of the solver in tau = p t. Default: 0.005. [-]
    uncertain : dict of float, optional
        Standard deviations of sizes of the wall, by name: thickness, height [m], hinge_ratio,
        overburden_ratio [-]. Default: none.

    Returns
    -------
    xarray.Dataset
        ``estimate``, ``standard_error``, 90 % ``interval`` and ``true_value`` (parameter), the last
        NaN unless the header of a synthetic record states it; ``covariance``; ``damping_ratio``,
        NaN for CR; ``residual_rms`` with its ratios to the peak and to the noise at rest;
        ``run_estimate`` (run, parameter); ``measured`` and ``control_displacement`` (sample).

    Raises
    ------
    InputError
        If a record has no displacement or no rest, the best fit lies at a bound of the search or
        leaves a residual of more than a tenth of the peak, or a record does not determine the
        parameters.

    Examples
    --------
    >>> import numpy as np
    >>> import rockdamp as rd
    >>> wall = rd.Wall(thickness=0.102, height=27 * 0.102, hinge_ratio=0.57, overburden_ratio=6.2)
    >>> elapsed = np.arange(1281) / 256
    >>> random = np.random.RandomState(1)
    >>> phase = 9 * (elapsed - 1.5)
    >>> pulse = 14.0 * (1 - phase**2) * np.exp(-(phase**2) / 2)
    >>> motion = rd.Record(elapsed, pulse + 0.01 * random.standard_normal(elapsed.size))
    >>> response = rd.respond(
    ...     wall, rd.TrilinearCurve(0.033, 0.795), rd.Damping("CR", 0.845), motion
    ... )
    >>> sensor = response.control_displacement + 1e-4 * random.standard_normal(elapsed.size)
    >>> fit = rd.calibrate(rd.Record(elapsed, motion.ground_acceleration, sensor), wall)
    >>> float(fit.estimate.sel(parameter="restitution").round(3))
    0.845
    """
    deviations = check_deviations(wall, uncertain)
    fits = make_fits(records, wall, damping_model, ultimate_displacement_ratio, softening, step)
    solutions = [fit.solution() for fit in fits]
    for solution in solutions:
        _check_solution(solution)
    run_estimates = np.array([solution.parameters for solution in solutions])
    covariances = [estimate_covariance(solution) for solution in solutions]
    precisions = np.linalg.inv(covariances)
    covariance = np.linalg.inv(precisions.sum(axis=0))
    weights = covariance @ precisions  # 1 for a single run
    estimate = np.einsum("rij,rj->i", weights, run_estimates)
    for name, deviation in deviations.items():
        run_changes = [size_change(solution, name, deviation) for solution in solutions]
        change = np.einsum("rij,rj->i", weights, np.array(run_changes))
        covariance += np.outer(change, change)
    estimate_over_error = estimate / np.sqrt(np.diag(covariance))
    for name, ratio in zip(PARAMETERS, estimate_over_error, strict=True):
        check(
            f"{name} over its standard error",
            ratio,
            lambda ratio: ratio >= 1,
            "at least 1: the record does not determine it",
        )
    fitted = _dataset(fits, run_estimates, estimate, covariance)
    return fitted.assign(misfit(solutions))


def compare_dampers(
    records: Record | Sequence[Record],
    wall: Wall | Parapet,
    *,
    ultimate_displacement_ratio: float = 1.0,
    softening: str = "steeper",
    step: float = 0.005,
) -> xr.Dataset:
    """Fit every damper, with a curve of its own, to each record; weigh dampers by residuals.

    The weight of a damper is proportional to exp(-S/(2 s^2)), with S the sum of its squared
    residuals and s the sensor's noise at rest. This assumes white noise, and that one of the
    dampers made the record: where the smallest `residual_over_noise` is well above 1, none explains
    it.

    Parameters
    ----------
    records : Record or sequence of Record
        Measured tests of the wall, each with a displacement and with rest before the motion.
    wall : Wall or Parapet
        Sizes and weights of the wall.
    ultimate_displacement_ratio : float
        Known a3, in (0, 1]. Default: 1. [-]
    softening : {"steeper", "translated"}
        Known variant of the softening branch. Default: "steeper".
    step : float
        Largest step of the solver in tau = p t. Default: 0.005. [-]

    Returns
    -------
    xarray.Dataset
        ``residual_rms``, ``residual_over_noise``, ``relative_log_likelihood`` and ``weight``
        (damping_model), and the ``estimate`` (damping_model, parameter), a mean over the records.

    Raises
    ------
    InputError
        If a record has no displacement or no rest, or a displacement that no wall can have.
    """
    misfits = []
    squares = []
    estimates = []
    for model in MODELS:
        fits = make_fits(records, wall, model, ultimate_displacement_ratio, softening, step)
        solutions = [fit.solution() for fit in fits]
        misfits.append(misfit(solutions))
        squares.append(sum(_square_over_noise(solution) for solution in solutions))
        run_estimates = [solution.parameters for solution in solutions]
        estimates.append(np.mean(run_estimates, axis=0))
    log_likelihood = -(np.array(squares) - min(squares)) / 2
    weight = np.exp(log_likelihood)
    variables = {
        name: ("damping_model", [row[name] for row in misfits])
        for name in ("residual_rms", "residual_over_noise")
    }
    return xr.Dataset(
        {
            **variables,
            "relative_log_likelihood": ("damping_model", log_likelihood),
            "weight": ("damping_model", weight / weight.sum()),
            "estimate": (("damping_model", "parameter"), np.array(estimates)),
        },
        coords={"damping_model": list(MODELS), "parameter": list(PARAMETERS)},
    )


def _square_over_noise(solution: Solution) -> float:
    """Return the sum of squared residuals over the variance of the noise at rest."""
    # A record without noise gets a billionth of its peak, so that nothing is divided by zero.
    least_noise = 1e-9 * float(np.abs(solution.fit.measured).max())
    noise = max(solution.fit.resting_deviation, least_noise)
    return float(np.sum((solution.residual / noise) ** 2))


# --- steps of a calibration -----------------------------------------------------------------------


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
        *CURVE_RULES["ultimate_displacement_ratio"],
    )
    check_choice("softening", softening, SOFTENING)
    check_choice("damping_model", damping_model, MODELS)
    record_list = check_list("records", records, Record)
    # ASSUME: a wall that survives stays below u_ins; a sensor's drift and an inexact size may add
    # half of that.
    largest = 1.5 * float(wall.instability_displacement)
    for record in record_list:
        displacement, _ = measured_displacement(record)
        check(
            "largest measured displacement",
            np.abs(displacement).max(),
            lambda u: (u > 0) & (u <= largest),
            f"greater than 0 and at most 1.5 u_ins = {largest:.4g} m",
        )
    return [RecordFit(record, wall, damping_model, a3, softening, step) for record in record_list]


def _check_solution(solution: Solution) -> None:
    """Refuse a poor fit, a fit at a bound, and a wall that stays on its first branch."""
    fit = solution.fit
    residual = misfit([solution])
    # ASSUME: where restitution explains a test well, the residual is a few per cent of the peak or,
    # for small motions, about the noise.
    peak_share = residual["residual_over_peak"]
    if peak_share > 0.10 and not residual["residual_over_noise"] <= 3:
        raise InputError(
            f"the residual of the best fit is {100 * peak_share:.2g} % of the peak;"
            " it must be at most 10 %"
        )
    names = (
        "yield_displacement_ratio over the plateau's end (a1/a2)",
        "strength_ratio (b1)",
        "restitution (e)",
    )
    for name, value, low, high in zip(names, solution.point, *fit.bounds, strict=True):
        # The search stops just inside a bound.
        if min(value - low, high - value) < 1e-3 * (high - low):
            raise InputError(
                f"the best fit has {name} {value:.4g}; it must lie inside {low:g} to {high:g}"
            )
    a1, _, _ = solution.parameters
    peak = float(np.abs(fit.response(solution.parameters)).max())
    first_branch = float(a1 * fit.wall.instability_displacement)
    if peak <= first_branch:  # where only b1/a1 matters
        raise InputError(
            f"the largest displacement is {peak:.3g} m, on the first branch, which ends at"
            f" {first_branch:.3g} m; it must be larger to determine a1 and b1"
        )


def estimate_covariance(solution: Solution) -> Array:
    """Return the covariance of a1, b1 and e by the displacement sensor and by the motion."""
    fit = solution.fit
    ratio, b1, _ = solution.point
    # Jacobian of (a1, b1, e) by the point (a1/a2, b1, e): a1 is a1/a2 times a2, and da2/db1 = -1.
    # The differences are taken in a1/a2: the same step in a1 would be several times as long, too
    # long for a linear response.
    change = [[float(fit.plateau_end(b1)), -ratio, 0], [0, 1, 0], [0, 0, 1]]
    # A quarter of the fit's step: at its own step the rough history makes single errors a third too
    # large or too small.
    fine_fit = replace(fit, step=fit.step / 4)
    derivative = fine_fit.derivative(solution.point) @ np.linalg.inv(change)
    by_sensor = covariance_by_sensor(derivative, solution.residual)
    by_motion = covariance_by_motion(fit, solution.parameters, derivative)
    return by_sensor + by_motion


def misfit(solutions: Sequence[Solution]) -> dict[str, float]:
    """Return the rms of the residuals and of the noise at rest [m], and ratios of the former."""
    residuals = np.concatenate([solution.residual for solution in solutions])
    fits = [solution.fit for solution in solutions]
    rms = float(np.sqrt(np.mean(residuals**2)))
    noise = float(np.sqrt(np.mean([fit.resting_deviation**2 for fit in fits])))
    return {
        "residual_rms": rms,
        "residual_over_peak": rms / max(float(np.abs(fit.measured).max()) for fit in fits),
        "residual_over_noise": rms / noise if noise > 0 else np.nan,
        "rest_deviation": noise,
    }


def true_values(header: Mapping[str, str]) -> Array:
    """Return the parameters in the header of a synthetic record; NaN if it does not state them."""
    if header.get("synthetic") != "yes":
        return np.full(len(PARAMETERS), np.nan)
    return np.array([float(header.get(f"generator_{name}", "nan")) for name in PARAMETERS])


def _dataset(
    fits: Sequence[RecordFit], run_estimates: Array, estimate: Array, covariance: Array
) -> xr.Dataset:
    """Return the estimates, over all runs and of each, with fitted and measured histories."""
    first_fit = fits[0]
    error = np.sqrt(np.diag(covariance))
    responses = [
        fit.response(parameters) for fit, parameters in zip(fits, run_estimates, strict=True)
    ]
    # The measured displacement without the sensor's offset and drift, those of the residual.
    measured = [
        response + fit.subtract_trend(fit.measured - response)
        for fit, response in zip(fits, responses, strict=True)
    ]
    damping_ratio = np.nan
    if first_fit.damping_model != REFERENCE:
        damping_ratio = float(first_fit.damping(estimate).value)
    runs = np.arange(1, len(fits) + 1)
    interval = estimate + NORMAL_QUANTILE * np.outer([-1, 1], error)
    return xr.Dataset(
        {
            "estimate": ("parameter", estimate),
            "standard_error": ("parameter", error),
            "interval": (("bound", "parameter"), interval),
            "true_value": ("parameter", true_values(first_fit.record.header)),
            "covariance": (("parameter", "parameter_other"), covariance),
            "damping_ratio": damping_ratio,
            "run_estimate": (("run", "parameter"), run_estimates),
            "measured": ("sample", np.concatenate(measured)),
            "control_displacement": ("sample", np.concatenate(responses)),
            "sample_run": ("sample", np.repeat(runs, [response.size for response in responses])),
        },
        coords={
            "parameter": list(PARAMETERS),
            "parameter_other": list(PARAMETERS),
            "bound": ["low", "high"],
            "run": runs,
            "elapsed": ("sample", np.concatenate([fit.record.elapsed for fit in fits])),
        },
        attrs={
            **record_attributes(first_fit.record.header),
            "damping_model": first_fit.damping_model,
        },
    )
