"""Curve and coefficient of restitution from a measured record: least squares of a1, b1 and e on the CR model.

The paper's own calibration is "not reported". A record that the best fit does not explain is refused.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.errors import InputError, check, check_choice
from rockdamp.histories.respond import record_attributes
from rockdamp.laboratory.least_squares import HIGH, LOW, PARAMETERS, SEARCHED, RecordFit, Solution
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.record import Record

# ASSUME: a wall that survives stays below u_ins, where it collapses; a sensor's drift and a slack measure may add
# half of that. Tests that restitution explains well leave some per cent of the peak.
FARTHEST = 1.5  # of u_ins
POOREST = 0.10  # of the peak: from there on it is refused
NOISY = 3.0  # times the sensor's noise at rest, which a misfit must exceed besides
ROUNDING = 1e-9  # of the peak: a smaller noise is none
AT_BOUND = 1e-3  # of a parameter's range: nearer to a bound is at it


@dataclass(frozen=True)
class Misfit:
    """What the best fit leaves of a record: its root mean square [m], over the peak, and over the noise at rest."""

    residual_rms: float
    residual_over_peak: float
    residual_over_noise: float | None  # None of a record without noise

    @classmethod
    def from_solution(cls, solution: Solution) -> Misfit:
        """Return the misfit of a solution."""
        fit = solution.fit
        rms = float(np.sqrt(np.mean(solution.residual**2)))
        peak, noise = float(np.abs(fit.measured).max()), fit.rest_deviation
        return cls(rms, rms / peak, rms / noise if noise > ROUNDING * peak else None)

    @property
    def variables(self) -> dict[str, float]:
        """The three numbers as a dataset has them; NaN for none."""
        noise = self.residual_over_noise
        return {
            "residual_rms": self.residual_rms,
            "residual_over_peak": self.residual_over_peak,
            "residual_over_noise": np.nan if noise is None else noise,
        }

    def __str__(self) -> str:
        noise = self.residual_over_noise
        over_noise = "" if noise is None else f", {noise:.3g} times the sensor's noise at rest"
        return f"{1000 * self.residual_rms:.3g} mm, {100 * self.residual_over_peak:.2g} % of the peak{over_noise}"

    def exceeds(self, share: float) -> bool:
        """Return True if the misfit is more than a share of the peak, and more than noise."""
        noise = self.residual_over_noise
        return self.residual_over_peak > share and (noise is None or noise > NOISY)


def require_possible(record: Record, wall: Wall | Parapet) -> None:
    """Raise `InputError` for a displacement that no wall comes back from."""
    if record.displacement is None:
        return  # the fit refuses it
    u_ins = float(np.max(wall.instability_displacement))
    peak = float(np.abs(record.displacement - record.displacement[0]).max())
    if peak == 0:
        raise InputError("the measured displacement is constant; it must be that of a wall that rocks")
    if peak > FARTHEST * u_ins:
        raise InputError(
            f"the largest measured displacement is {peak:.4g} m; it must be at most {FARTHEST:g} u_ins,"
            f" {FARTHEST * u_ins:.4g} m"
        )


def size_deviations(wall: Wall | Parapet, uncertain: Mapping[str, float] | None) -> dict[str, float]:
    """Return the standard deviations of the wall's uncertain sizes, by name, or raise `InputError`."""
    deviations = {}
    for name, deviation in (uncertain or {}).items():
        check_choice("a size that is uncertain", name, [field.name for field in fields(wall)])
        deviations[name] = float(check(f"uncertain {name}", deviation, lambda size: size > 0, "greater than 0"))
    return deviations


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
    fitted to the measured displacement. A scan of the whole range gives the starts, so that the smallest of the
    local minima is the solution. The covariance has three parts. That of the residuals, which follow each other and
    are no white noise, is Newey and West's (doi:10.2307/1913610), its bandwidth Andrews' (doi:10.2307/2938229).
    That of the accelerometer's noise, which the wall responds to, is propagated; near its strength the wall
    amplifies it, and it is then the larger. A third part is that of sizes of the wall that are uncertain, by fits
    with other sizes. Gains of the sensors are taken as exact: b1 takes up their errors.

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
        If the record has no displacement or no rest, or one that no wall comes back from; the best fit lies at a bound
        of the search or leaves more than a tenth of the peak; or the record does not determine the parameters.

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
    a3 = ultimate_displacement_ratio
    deviations = size_deviations(wall, uncertain)
    require_possible(record, wall)
    fit = RecordFit.from_record(record, wall, ultimate_displacement_ratio=a3, softening=softening, step=step)
    solution = fit.solution()
    misfit = Misfit.from_solution(solution)
    if misfit.exceeds(POOREST):
        raise InputError(f"the best fit leaves {misfit}; it must leave at most {100 * POOREST:.2g} % of the peak")
    estimate, computed, residual = solution.estimate, solution.computed, solution.residual
    for name, value, low, high in zip(PARAMETERS, solution.point, LOW, HIGH, strict=True):
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
            "true_value": ("parameter", true_values(record.header, PARAMETERS)),
            "covariance": (("parameter", "parameter_other"), covariance),
            "standard_error_by_motion": ("parameter", np.sqrt(np.diag(by_motion))),
            "measured": ("elapsed", fit.measured - fit.trend @ [offset, drift]),
            "control_displacement": ("elapsed", computed),
            "residual_deviation": np.sqrt(residual @ residual / degrees_of_freedom),
            "rest_deviation": fit.rest_deviation,
            **misfit.variables,
            "sensor_offset": fit.sensor_zero + offset,
            "sensor_drift": drift,
            "bandwidth": bandwidth,
            "local_minima": len(solution.local_minima),
        },
        coords={"parameter": list(PARAMETERS), "parameter_other": list(PARAMETERS), "elapsed": record.elapsed},
        attrs=record_attributes(record.header),
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


def study(config: Config, record: Record) -> xr.Dataset:
    """Calibrate the wall of the config's ``validation`` section: its a3 and softening are kept, a1, b1 and e fitted."""
    given = config.validation
    return calibrate(
        record,
        given.wall.make(),
        ultimate_displacement_ratio=given.curve.ultimate_displacement_ratio,
        softening=given.curve.softening,
        step=given.step,
    )


def true_values(header: Mapping[str, str], names: Sequence[str]) -> Array:
    """Return the values with which a synthetic record was made; NaN where it does not state them, or was measured."""
    synthetic = header.get("synthetic") == "yes"
    values = [header.get(f"generator_{name}", "nan") if synthetic else "nan" for name in names]
    try:
        return np.array([float(value) for value in values])
    except ValueError:
        raise InputError(f"the record's generator_* values are {values}; they must be numbers") from None
