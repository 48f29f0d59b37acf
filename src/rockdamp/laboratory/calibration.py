"""Curve and coefficient of restitution from a measured record: least squares of a1, b1 and e on the CR model.

The paper's own calibration is "not reported".
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from rockdamp.arguments import instance
from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.histories.measured_test import record_attributes
from rockdamp.laboratory.candidates import SEARCHED, Candidate, size_deviations, true_values
from rockdamp.laboratory.least_squares import Fit, Solution
from rockdamp.laboratory.misfit import require_explained, require_possible
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.records import Record
from rockdamp.plausibility import warn
from rockdamp.vocabulary import REFERENCE

PARAMETERS = Candidate(REFERENCE).searched
AT_BOUND = 1e-3  # of a parameter's range: nearer to a bound is at it


def calibrate(
    record: Record,
    wall: Wall | Parapet,
    *,
    ultimate_displacement_ratio: float = 1.0,
    softening: str = "steeper",
    step: float = 0.005,
    uncertain: Mapping[str, float] | None = None,
) -> xr.Dataset:
    """Fit a1, b1 and e to a record by least squares, with their covariance.

    The response to the measured motion under CR, plus an offset and a linear drift of the displacement sensor, is
    fitted to the measured displacement. A scan of the whole range gives the starts, so that the smallest of the local
    minima is solution. The covariance has two parts. That of the residuals, which follow each other and are no white
    noise, is Newey and West's (doi:10.2307/1913610), its bandwidth Andrews' (doi:10.2307/2938229). That of the
    accelerometer's noise, which the wall responds to, is propagated; near its strength the wall amplifies it, and it
    is then the larger. A third part is that of sizes of the wall that are uncertain, by fits with other sizes. Gains of
    the sensors are taken as exact: b1 takes up their errors.

    Before all that a displacement is refused that no wall comes back from, and after the fit a misfit that is far above
    the noise; slips that explain it are tried (`misfit.py`).

    Parameters
    ----------
    record : Record
        With a measured displacement, at rest before the motion.
    wall : Wall or Parapet
        Its geometry and weights are taken as known, but for those that are `uncertain`.
    ultimate_displacement_ratio, softening : float and str
        a3 and the variant of softening, taken as known.
    step : float
        Of the solver, in tau, at most. [-]
    uncertain : dict of float, optional
        Standard deviation of sizes of the wall: thickness, height [m], hinge_ratio, overburden_ratio. [-]

    Returns
    -------
    xarray.Dataset
        ``estimate``, ``standard_error`` and ``true_value`` (parameter; the last NaN unless the record is synthetic and
        says what made it), ``covariance``, ``residual_rms`` with its ratios to the peak and to the noise at rest, and
        the fitted and measured displacement (elapsed).

    Raises
    ------
    InputError
        If the record has no displacement or no rest, the best fit lies at a bound of the search or leaves a misfit far
        above the noise, or the record does not determine the parameters.

    Examples
    --------
    >>> import numpy as np
    >>> import rockdamp as rd
    >>> wall = rd.Wall(thickness=0.102, height=27 * 0.102, hinge_ratio=0.57, overburden_ratio=6.2)
    >>> elapsed, random = np.arange(1281) / 256, np.random.RandomState(1)
    >>> pulse = 14.0 * (1 - (9 * (elapsed - 1.5)) ** 2) * np.exp(-((9 * (elapsed - 1.5)) ** 2) / 2)
    >>> motion = rd.Record(elapsed, pulse + 0.01 * random.standard_normal(elapsed.size))
    >>> shaken = rd.respond(wall, rd.TrilinearCurve(0.033, 0.795), rd.Damping.cr(0.845), motion)
    >>> shown = shaken.displacement + 1e-4 * random.standard_normal(elapsed.size)
    >>> fit = rd.calibrate(rd.Record(elapsed, motion.ground_acceleration, shown), wall)
    >>> float(fit.estimate.sel(parameter="restitution").round(3))
    0.845
    """
    a3 = ultimate_displacement_ratio
    candidate = Candidate(REFERENCE)
    instance("record", record, Record)
    instance("wall", wall, Wall, Parapet)
    deviations = size_deviations(wall, uncertain)
    require_possible(record, wall)
    fit = Fit.of(record, wall, candidate, ultimate_displacement_ratio=a3, softening=softening, step=step)
    solution = fit.solution()
    misfit = require_explained(solution)
    warn(misfit.doubts)
    estimate, computed, residual = solution.estimate, solution.computed, solution.residual
    for name, value, low, high in zip(PARAMETERS, solution.point, *fit.range, strict=True):
        if min(value - low, high - value) < AT_BOUND * (high - low):
            raise InputError(f"the best fit has {SEARCHED[name]} {value:.4g}; it must lie inside {low:g} to {high:g}")
    _check_rocking(computed, estimate, fit.u_ins)
    by_sensor, bandwidth = solution.covariance_by_sensor
    by_motion = solution.covariance_by_motion
    covariance = by_sensor + by_motion
    if deviations:
        covariance = covariance + _by_sizes(solution, deviations)
    _check_determined(estimate, np.sqrt(np.diag(covariance)))
    offset, drift = np.linalg.lstsq(fit.trend, fit.measured - computed, rcond=None)[0]
    degrees_of_freedom = residual.size - len(PARAMETERS) - fit.trend.shape[1]
    return xr.Dataset(
        {
            "estimate": ("parameter", estimate),
            "standard_error": ("parameter", np.sqrt(np.diag(covariance))),
            "true_value": ("parameter", true_values(record, PARAMETERS)),
            "covariance": (("parameter", "parameter_other"), covariance),
            "standard_error_by_motion": ("parameter", np.sqrt(np.diag(by_motion))),
            "measured": ("elapsed", fit.measured - fit.trend @ [offset, drift]),
            "displacement": ("elapsed", computed),
            "residual_deviation": np.sqrt(residual @ residual / degrees_of_freedom),
            "rest_deviation": fit.rest_deviation,
            **misfit.variables,
            "sensor_offset": fit.sensor_zero + offset,
            "sensor_drift": drift,
            "bandwidth": bandwidth,
            "local_minima": len(solution.local_minima),
        },
        coords={"parameter": list(PARAMETERS), "parameter_other": list(PARAMETERS), "elapsed": record.elapsed},
        attrs=record_attributes(record),
    )


def _by_sizes(solution: Solution, deviations: Mapping[str, float]) -> Array:
    """Return the covariance of the estimates by independent errors of sizes of the wall, to first order."""
    covariance = np.zeros((len(PARAMETERS), len(PARAMETERS)))
    for name, deviation in deviations.items():
        sides = [solution.with_size(name, sign * deviation) for sign in (1.0, -1.0)]
        change = (sides[0] - sides[1]) / 2
        covariance += np.outer(change, change)
    return covariance


def _check_determined(estimate: Array, error: Array) -> None:
    """Raise where an error is larger than its value: such an estimate says nothing."""
    for name, value, deviation in zip(PARAMETERS, estimate, error, strict=True):
        if not deviation <= value:
            raise InputError(
                f"{SEARCHED[name].partition(' over')[0]} is {value:.4g} ± {deviation:.2g}; its standard error must be"
                " less than its value: the record does not determine it"
            )


def _check_rocking(computed: Array, estimate: Array, u_ins: float) -> None:
    """Raise where the fitted wall stays on its first branch: there only b1/a1 matters."""
    largest, branch = float(np.abs(computed).max()), float(estimate[0]) * u_ins
    if largest <= branch:
        raise InputError(
            f"the largest displacement is {largest:.3g} m, on the first branch, which ends at {branch:.3g} m; "
            "it must go beyond to determine a1 and b1"
        )
