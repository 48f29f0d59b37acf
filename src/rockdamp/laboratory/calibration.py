"""Curve and coefficient of restitution from measured records: least squares of a1, b1 and e.

The paper's own calibration is "not reported". A record that the best fit does not explain is refused.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from scipy.optimize import OptimizeResult
from scipy.special import ndtri

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.constants import MODELS, REFERENCE, SOFTENING
from rockdamp.errors import InputError, check, check_choice
from rockdamp.histories.measured_test import measured_displacement
from rockdamp.histories.respond import record_attributes
from rockdamp.laboratory.record_fit import HIGH, LOW, PARAMETERS, RecordFit
from rockdamp.laboratory.uncertainty import (
    check_deviations,
    covariance_by_motion,
    covariance_by_sensor,
    size_change,
)
from rockdamp.mechanics.curve import RULES
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.record import Record

NORMAL = float(ndtri(0.95))  # of an interval of 90 %
# ASSUME: a wall that survives stays below u_ins; a sensor's drift and a slack measure may add half of that. Tests that
# restitution explains well leave some per cent of the peak.
LARGEST_DISPLACEMENT = 1.5  # of u_ins
LARGEST_MISFIT, LARGEST_NOISE = 0.10, 3.0  # of the peak; of the sensor's noise at rest, which must be exceeded besides
AT_BOUND = 1e-3  # of a parameter's range: nearer to a bound is at it
SEARCHED = "yield_displacement_ratio over the plateau's end (a1/a2)", "strength_ratio (b1)", "restitution (e)"


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
    solution. The covariance has three parts: the residuals, which follow each other; the accelerometer's noise, to
    which the wall responds, and which it amplifies near its strength; and sizes of the wall that are uncertain. Gains
    of the sensors are taken as exact: b1 takes up their errors. Of several records each is fitted, and the estimates
    are weighed by their covariances: in stacked residuals the motion's noise in one would disturb e of the others.

    Parameters
    ----------
    records : Record or sequence of them
        With a measured displacement, at rest before the motion.
    wall : Wall or Parapet
        Its geometry and weights are taken as known, but for those that are `uncertain`.
    damping_model : str
        CR; of a viscous damper e is what its damping ratio stands for at 0.3 u_ins.
    ultimate_displacement_ratio, softening : float and str
        a3 and the variant of softening, taken as known.
    step : float
        Of the solver, in tau, at most. [-]
    uncertain : dict of float, optional
        Standard deviation of sizes of the wall: thickness, height [m], hinge_ratio, overburden_ratio. [-]

    Returns
    -------
    xarray.Dataset
        ``estimate``, ``standard_error``, ``interval`` of 90 % and ``true_value`` (parameter; the last NaN unless the
        record is synthetic and says what made it), ``covariance``, ``damping_ratio`` (NaN of CR), ``residual_rms``
        with its ratios to the peak and to the noise at rest, ``run_estimate`` (run, parameter) and both histories
        (sample).

    Raises
    ------
    InputError
        If a record has no displacement or no rest; the best fit lies at a bound of the search or leaves more than a
        tenth of the peak; or the record does not determine the parameters.

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
        _check_solution(fit, one.x, misfit([fit], [one]))
    estimates = np.array([fit.parameters(one.x) for fit, one in zip(fits, found, strict=True)])
    precisions = np.linalg.inv([_covariance(fit, one) for fit, one in zip(fits, found, strict=True)])
    covariance = np.linalg.inv(precisions.sum(axis=0))
    weights = covariance @ precisions  # of one run 1
    estimate = np.einsum("rij,rj->i", weights, estimates)
    for name, deviation in deviations.items():
        changes = [size_change(fit, one.x, name, deviation) for fit, one in zip(fits, found, strict=True)]
        change = np.einsum("rij,rj->i", weights, np.array(changes))
        covariance += np.outer(change, change)
    for name, ratio in zip(PARAMETERS, estimate / np.sqrt(np.diag(covariance)), strict=True):
        determined = "at least 1: the record does not determine it"
        check(f"{name} over its standard error", ratio, lambda ratio: ratio >= 1, determined)
    return _dataset(fits, estimates, estimate, covariance).assign(misfit(fits, found))


def _covariance(fit: RecordFit, found: OptimizeResult) -> Array:
    """Return the covariance of a1, b1 and e by the displacement sensor and by the motion."""
    ratio, b1, _ = found.x
    # From a point to its parameters: a1 = a1/a2 times a2, which falls as b1 rises. The derivative is taken by a1/a2:
    # steps of a1 of that size, several times as long, would bend the response.
    change = [[float(fit.end_of_plateau(b1)), -ratio, 0], [0, 1, 0], [0, 0, 1]]
    derivative = found.jac @ np.linalg.inv(change)
    by_sensor = covariance_by_sensor(derivative, found.fun)
    return by_sensor + covariance_by_motion(fit, fit.parameters(found.x), derivative)


def _dataset(fits: Sequence[RecordFit], estimates: Array, estimate: Array, covariance: Array) -> xr.Dataset:
    """Return the estimates of all runs and each one's, with its history and what was measured."""
    first, error = fits[0], np.sqrt(np.diag(covariance))
    responses = [fit.response(one) for fit, one in zip(fits, estimates, strict=True)]
    measured = [u + fit.subtract_trend(fit.measured - u) for fit, u in zip(fits, responses, strict=True)]
    xi = np.nan
    if first.damping_model != REFERENCE:
        xi = float(first.damping(first.curve(estimate), estimate[2]).value)
    return xr.Dataset(
        {
            "estimate": ("parameter", estimate),
            "standard_error": ("parameter", error),
            "interval": (("bound", "parameter"), estimate + NORMAL * np.outer([-1, 1], error)),
            "true_value": ("parameter", true_values(first.record.header, PARAMETERS)),
            "covariance": (("parameter", "parameter_other"), covariance),
            "damping_ratio": xi,
            "run_estimate": (("run", "parameter"), estimates),
            "measured": ("sample", np.concatenate(measured)),
            "control_displacement": ("sample", np.concatenate(responses)),
            "sample_run": ("sample", np.repeat(np.arange(1, len(fits) + 1), [u.size for u in responses])),
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


def make_fits(
    records: Record | Sequence[Record],
    wall: Wall | Parapet,
    damping_model: str,
    ultimate_displacement_ratio: float,
    softening: str,
    step: float,
) -> list[RecordFit]:
    """Return the fit of each record, with a displacement that a wall may have come back from."""
    check("step", step, lambda step: step > 0, "greater than 0")
    a3 = float(check("ultimate_displacement_ratio", ultimate_displacement_ratio, *RULES["ultimate_displacement_ratio"]))
    check_choice("softening", softening, SOFTENING)
    check_choice("damping_model", damping_model, MODELS)
    several = [records] if isinstance(records, Record) else list(records)
    largest = LARGEST_DISPLACEMENT * float(wall.instability_displacement)
    for record in several:
        peak = np.abs(measured_displacement(record)[0]).max()
        allowed = f"greater than 0 and at most {LARGEST_DISPLACEMENT:g} u_ins = {largest:.4g} m"
        check("largest measured displacement", peak, lambda u: (u > 0) & (u <= largest), allowed)
    return [RecordFit(record, wall, damping_model, a3, softening, step) for record in several]


def misfit(fits: Sequence[RecordFit], found: Sequence[OptimizeResult]) -> dict[str, float]:
    """Return what the best fits leave: its root mean square [m], over the largest peak, and over the noise at rest."""
    rms = float(np.sqrt(np.mean(np.concatenate([one.fun for one in found]) ** 2)))
    noise = float(np.sqrt(np.mean([fit.resting_deviation**2 for fit in fits])))
    return {
        "residual_rms": rms,
        "residual_over_peak": rms / max(float(np.abs(fit.measured).max()) for fit in fits),
        "residual_over_noise": rms / noise if noise > 0 else np.nan,
        "rest_deviation": noise,
    }


def _check_solution(fit: RecordFit, point: Array, left: Mapping[str, float]) -> None:
    """Raise `InputError` for a fit that explains the record badly, at a bound, or of a wall on its first branch."""
    share = left["residual_over_peak"]
    if share > LARGEST_MISFIT and not left["residual_over_noise"] <= LARGEST_NOISE:
        raise InputError(
            f"the best fit leaves {100 * share:.2g} % of the peak; it must leave at most {100 * LARGEST_MISFIT:g} %"
        )
    for name, value, low, high in zip(SEARCHED, point, LOW, HIGH, strict=True):
        if min(value - low, high - value) < AT_BOUND * (high - low):
            raise InputError(f"the best fit has {name} {value:.4g}; it must lie inside {low:g} to {high:g}")
    parameters = fit.parameters(point)
    peak = float(np.abs(fit.response(parameters)).max())
    branch = float(parameters[0] * fit.wall.instability_displacement)
    if peak <= branch:  # where only b1/a1 matters
        raise InputError(
            f"the largest displacement is {peak:.3g} m, on the first branch, which ends at {branch:.3g} m;"
            " it must go beyond to determine a1 and b1"
        )


def true_values(header: Mapping[str, str], names: Sequence[str]) -> Array:
    """Return the values with which a synthetic record was made; NaN where it does not state them, or was measured."""
    synthetic = header.get("synthetic") == "yes"
    return np.array([float(header.get(f"generator_{name}", "nan")) if synthetic else np.nan for name in names])


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
