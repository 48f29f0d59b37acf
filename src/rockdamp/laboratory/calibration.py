"""Curve and coefficient of restitution from a measured record: least squares of a1, b1 and e on the CR model.

The paper's own calibration is "not reported".

A record that the best fit does not explain is refused, and a slip in it that does is named.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.polynomial import Polynomial
from scipy.integrate import cumulative_trapezoid

from rockdamp import units
from rockdamp.arguments import instance
from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.errors import InputError
from rockdamp.histories.measured_test import record_attributes, rest_samples
from rockdamp.laboratory.candidates import SEARCHED, Candidate, size_deviations, true_values
from rockdamp.laboratory.least_squares import RecordFit, Solution
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.records import Record
from rockdamp.plausibility import ACCELERATIONS, LENGTHS, PER_CENT_OF_G, of_motion, warn
from rockdamp.text import listed
from rockdamp.vocabulary import REFERENCE

# --- what a fit leaves of a record, and slips that explain it ---------------------------------------------------------

# ASSUME: a wall that survives stays below u_ins, where it collapses; a sensor's drift and a slack measure may add
# half of that. Tests that restitution explains well leave some per cent of the peak.
FARTHEST = 1.5  # of u_ins
SMALL = 0.005  # of the peak: a smaller rest gives no warning
POOR, POOREST = 0.03, 0.10  # of the peak: from the first on slips are looked for, from the second on it is refused
NOISY = 3.0  # times the sensor's noise at rest, which a misfit must exceed besides
BETTER = 3.0  # times smaller is the misfit of a record without its slip
TABLE_DEGREE = 3  # of the polynomial that an integrated acceleration is known but for
CLIPPED = 5  # neighbouring equal samples at an extreme, at least
TOP_JUMP = 2.5  # steps of the logger from a cut-off top to the samples beside it, at least
# Slips with the table's displacement, and how often it is added to what is shown to undo each.
OF_TABLE = {
    "not subtracted from": -1.0,
    "subtracted once too often from": 1.0,
    "added in place of subtracted from": -2.0,
}
ROUNDING = 1e-9  # of the largest value: a smaller difference is none


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

    @property
    def doubts(self) -> list[str]:
        """Return a warning if the best fit leaves more than the sensor's noise."""
        return (
            [f"the best fit leaves {self}: errors tell what holds under this model and these sizes alone"]
            if self.exceeds(SMALL)
            else []
        )

    def exceeds(self, share: float) -> bool:
        """Return True if the misfit is more than a share of the peak, and more than noise."""
        noise = self.residual_over_noise
        return self.residual_over_peak > share and (noise is None or noise > NOISY)


def require_possible(record: Record, wall: Wall | Parapet) -> None:
    """Raise `InputError` for a displacement that no wall comes back from; it names a slip that is found."""
    if record.displacement is None:
        return  # the fit refuses it
    u_ins = float(np.max(wall.instability_displacement))
    peak, moved = (
        float(np.abs(column - column[0]).max()) for column in (record.displacement, record.ground_acceleration)
    )
    if peak == 0:
        raise InputError("the measured displacement is constant; it must be that of a wall that rocks")
    if peak <= FARTHEST * u_ins:
        return
    stated = f"the largest measured displacement is {peak:.4g} m, {peak / u_ins:.3g} times u_ins = {u_ins:.4g} m"
    lengths = [name for name, size in LENGTHS.items() if 0.01 < peak * size / u_ins <= 1]
    asked = [f"was it in {' or '.join(lengths)}"] if lengths else []
    least, words = min(_with_the_table(record), default=(np.inf, ""))
    if least <= FARTHEST * u_ins:
        asked = [f"was the table's displacement {words} the wall's"]
        asked += ["is it that of the table itself"] if least <= POOREST * peak else []
    if moved <= FARTHEST * u_ins and not of_motion(peak):
        asked = ["were its column and that of the acceleration exchanged"]
    elif least > FARTHEST * u_ins and (doubts := of_motion(moved)):  # then no guess about the displacement is any good
        raise InputError(f"{stated}, beyond which the wall collapses; and {doubts[0]}: are the columns right?")
    raise InputError(f"{stated}, beyond which the wall collapses{_ask(asked)}")


def _with_the_table(record: Record) -> Iterator[tuple[float, str]]:
    """Yield how far a displacement goes without each slip with the table's, known but for a polynomial. [m]"""
    with suppress(InputError):  # of a record without rest
        for words, times in OF_TABLE.items():
            moved = _shown(record) + times * table_displacement(record)
            drift = Polynomial.fit(record.elapsed, moved, TABLE_DEGREE)
            yield float(np.abs(moved - drift(record.elapsed)).max()), words


def _is_the_table(record: Record) -> bool:
    """Say whether a displacement is the table's own, of either sign, known but for a polynomial."""
    shown, table = _shown(record), table_displacement(record)
    left = [
        moved - Polynomial.fit(record.elapsed, moved, TABLE_DEGREE)(record.elapsed)
        for moved in (shown - table, shown + table)
    ]
    return bool(min(np.abs(each).max() for each in left) <= POOREST * np.abs(shown - shown[0]).max())


def require_explained(solution: Solution) -> Misfit:
    """Return the misfit of the best fit, or raise `InputError`; it names a slip that is found.

    Where the misfit is far above the noise, the record without each possible slip is fitted too.
    """
    misfit = Misfit.from_solution(solution)
    stated = f"the best fit leaves {misfit}"
    clipped = list(_clipped(solution.fit.record)) if misfit.exceeds(SMALL) else []
    if clipped:
        raise InputError(f"{stated}{_ask(clipped)}")
    if not misfit.exceeds(POOR):
        return misfit
    if _is_the_table(solution.fit.record):
        raise InputError(f"{stated}; is the displacement that of the table itself, in place of the wall's?")
    tried: dict[str, Misfit] = {}
    for words, corrected in slips(solution.fit):
        with suppress(InputError):
            tried[words] = Misfit.from_solution(corrected.solution())
    # In metres: a displacement of the table that is added in vain makes the peak larger, and the share smaller.
    words, better = min(tried.items(), key=lambda item: item[1].residual_rms, default=("", misfit))
    if BETTER * better.residual_rms < misfit.residual_rms:
        raise InputError(f"{stated}. If {words}, it leaves {better}: is that so?")
    if misfit.exceeds(POOREST):
        most = f"it must leave at most {100 * POOREST:.2g} % of the peak"
        asked = f"It fits no better if {listed(list(tried))}: are the wall's sizes and load right?"
        raise InputError(f"{stated}; {most}. {asked}")
    return misfit


def slips(fit: RecordFit) -> Iterator[tuple[str, RecordFit]]:
    """Yield what may be wrong with a record, in words, and the fit of the record without it."""
    record = fit.record
    wrong = "the sign of the acceleration, or of the displacement, is wrong"
    yield wrong, _of(fit, ground_acceleration=-record.ground_acceleration)
    for words, times in OF_TABLE.items():
        relative = _shown(record) + times * table_displacement(record)
        yield (
            f"the table's displacement is {words} the wall's",
            replace(_of(fit, displacement=relative), trend_degree=TABLE_DEGREE),
        )
    taken = units.size(record.unit_of_file, "m s-2") or 1.0
    made = record.header.get("table_acceleration_channel", "")  # by `record`: "a, times 9.80665"
    with suppress(ValueError):
        taken *= float(made.rpartition(" times ")[2])
    numbers = record.ground_acceleration / taken  # as they stand in the file
    for unit, size in (ACCELERATIONS | PER_CENT_OF_G).items():
        if size != taken and not of_motion(size * float(np.abs(numbers).max())):
            scaled = size * numbers
            yield f"the acceleration is in {unit}", _of(fit, ground_acceleration=scaled)


def table_displacement(record: Record) -> Array:
    """Integrate the ground acceleration, less its mean at rest, twice; it starts at rest. [m]"""
    acceleration = record.ground_acceleration - record.ground_acceleration[: rest_samples(record)].mean()
    velocity = cumulative_trapezoid(acceleration, dx=record.step, initial=0)
    return np.asarray(cumulative_trapezoid(velocity, dx=record.step, initial=0))


def _shown(record: Record) -> Array:
    """Return the displacement as the sensor shows it, which a record that is fitted has. [m]"""
    assert record.displacement is not None
    return record.displacement


def _of(fit: RecordFit, **changed: Any) -> RecordFit:
    """Return the fit of a record with other channels."""
    record = replace(fit.record, **changed)
    return replace(fit, record=record).with_motion(record.ground_acceleration)


def _clipped(record: Record) -> Iterator[str]:
    """Yield the channels of which neighbouring samples at an extreme are equal, in words."""
    for name, values in (("displacement", _shown(record)), ("acceleration", record.ground_acceleration)):
        for extreme in (values.max(), values.min()):
            count = _cut_off(values, extreme)
            if count:
                yield f"is the {name} clipped, of which {count} neighbouring samples are all {extreme:.4g}"
                break


def _cut_off(values: Array, extreme: float) -> int:
    """Count the neighbouring samples at an extreme if they cut the channel off; 0 where its top is round.

    Steps of a logger make the top of a slow motion flat too; but the samples beside it are then one step away.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], values == extreme, [False]])))
    start, end = max(edges.reshape(-1, 2), key=lambda run: run[1] - run[0])
    beside = [values[at] for at in (start - 1, end) if 0 <= at < values.size]
    differences = np.abs(np.diff(values))
    logger = float(differences[differences > ROUNDING * np.abs(values).max()].min(initial=np.inf))
    cut = end - start >= CLIPPED and np.mean(np.abs(np.array(beside) - extreme)) > TOP_JUMP * logger
    return int(end - start) if cut else 0


def _ask(words: list[str]) -> str:
    return f"; {' or '.join(words)}?" if words else ""


# --- least squares ----------------------------------------------------------------------------------------------------

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
    fitted to the measured displacement. A scan of the whole range gives the starts, so that the smallest of the
    local minima is the solution. The covariance has three parts. That of the residuals, which follow each other and
    are no white noise, is Newey and West's (doi:10.2307/1913610), its bandwidth Andrews' (doi:10.2307/2938229).
    That of the accelerometer's noise, which the wall responds to, is propagated; near its strength the wall
    amplifies it, and it is then the larger. A third part is that of sizes of the wall that are uncertain, by fits
    with other sizes. Gains of the sensors are taken as exact: b1 takes up their errors.

    Before all that a displacement is refused that no wall comes back from, and after the fit a misfit that is far above
    the noise; slips that explain it are tried.

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
    >>> shown = shaken.control_displacement + 1e-4 * random.standard_normal(elapsed.size)
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
    fit = RecordFit.from_record(record, wall, candidate, ultimate_displacement_ratio=a3, softening=softening, step=step)
    solution = fit.solution()
    misfit = require_explained(solution)
    warn(misfit.doubts)
    estimate, computed, residual = solution.estimate, solution.computed, solution.residual
    for name, value, low, high in zip(PARAMETERS, solution.point, *fit.range, strict=True):
        if min(value - low, high - value) < AT_BOUND * (high - low):
            slip = "did the wall rock, and are its sizes and load right?"
            raise InputError(
                f"the best fit has {SEARCHED[name]} {value:.4g}; it must lie inside {low:g} to {high:g}: {slip}"
            )
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


def study(config: Config, record: Record) -> xr.Dataset:
    """Calibrate the wall of the config's ``validation`` section: its a3 and softening are kept, a1, b1 and e fitted."""
    given = config.validation
    return calibrate(
        record,
        given.wall,
        ultimate_displacement_ratio=float(given.curve.ultimate_displacement_ratio),
        softening=given.curve.softening,
        step=given.step,
    )
