"""Curve and coefficient of restitution from a measured record: least squares of a1, b1 and e on the CR model.

The paper's own calibration is "not reported".
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import xarray as xr
from scipy.ndimage import minimum_filter
from scipy.optimize import OptimizeResult, least_squares

from rockdamp.arguments import instance, number, one_of
from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.errors import InputError, require
from rockdamp.histories.under_a_record import QUIET, measured_displacement, record_attributes, respond, rest_samples
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.records import Record
from rockdamp.progress import track
from rockdamp.solvers.newmark import available_threads
from rockdamp.studies.settings import CalibrationSettings
from rockdamp.vocabulary import SOFTENING

PARAMETERS = ("cracked_stiffness_ratio", "plateau_ratio", "restitution")

# ASSUME: where a masonry wall is looked for. a1 is searched as a1/a2, which keeps it below the plateau's end a2;
# Doherty's stages span a1/a2 = 0.21 to 0.40 and b1 = 0.50 to 0.72, the paper's walls 0.13 to 0.4 and 0.75 to 0.85.
SEARCHED = ("cracked_stiffness_ratio over the plateau's end (a1/a2)", "plateau_ratio (b1)", "restitution (e)")
LOWEST, HIGHEST = np.array([0.02, 0.40, 0.50]), np.array([0.90, 0.95, 1.00])
SCAN = (np.geomspace(0.03, 0.65, 11), np.linspace(0.42, 0.94, 53), np.linspace(0.56, 1.00, 12))
SPACING = np.array([np.log(SCAN[0][1] / SCAN[0][0]), SCAN[1][1] - SCAN[1][0], SCAN[2][1] - SCAN[2][0]])
SCAN_STEP = 0.03  # in tau, at most: enough to tell the minima apart, and below the stability limit of all of the scan
# The misfit has long bent valleys, in which a descent gets stuck: the best points of the scan are refined together.
KEPT, REFINEMENTS, ROUNDS = 64, 6, 4
NEARBY = np.array([offset for offset in product((-1, 0, 1), repeat=3) if any(offset)])
EXPLAINED = 1.5  # the residuals' deviation over the resting sensor's up to which no better minimum is looked for
DESCENT = {"max_nfev": 100, "xtol": 1e-9, "ftol": 1e-10, "gtol": None}
BATCH = 1024  # histories held at once
DIFFERENCE = 1e-4  # of a parameter's range: step of the central differences
DRAWS, DRAWS_SEED = 256, 0  # of the motion's noise
DRAWN = 0.3  # of its size: small enough for the response to be linear, and large against the solver's roughness
AT_BOUND = 1e-3  # of a parameter's range: nearer to a bound is at it
LARGEST_CONDITION = 1e4  # of the scaled derivatives: beyond it the record does not tell the parameters apart
LOST = 3.0  # u/u_ins that stands for a collapsed wall, far beyond any that stands


def calibrate(
    record: Record,
    wall: Wall | Parapet,
    *,
    ultimate_ratio: float = 1.0,
    softening: str = "steeper",
    step: float = 0.005,
) -> xr.Dataset:
    """Fit a1, b1 and e to a record by least squares, with their covariance.

    The response to the measured motion under CR, plus an offset and a linear drift of the displacement sensor, is
    fitted to the measured displacement. A scan of the whole range gives the starts, so that the smallest of the local
    minima is found. The covariance has two parts. That of the residuals, which follow each other and are no white
    noise, is Newey and West's (doi:10.2307/1913610), its bandwidth Andrews' (doi:10.2307/2938229). That of the
    accelerometer's noise, which the wall responds to, is propagated; near its strength the wall amplifies it, and it
    is then the larger. Gains of the sensors and the wall's geometry are taken as exact: b1 takes up their errors.

    Parameters
    ----------
    record : Record
        With a measured displacement, at rest before the motion.
    wall : Wall or Parapet
        Its geometry and weights are taken as known.
    ultimate_ratio, softening : float and str
        a3 and the variant of softening, taken as known.
    step : float
        Of the solver, in tau, at most. [-]

    Returns
    -------
    xarray.Dataset
        ``estimate``, ``standard_error`` and ``true_value`` (parameter; the last NaN unless the record is synthetic and
        says what made it), ``covariance``, and the fitted and measured displacement (elapsed).

    Raises
    ------
    InputError
        If the record has no displacement or no rest, the best fit lies at a bound of the search, or the record does
        not determine the parameters.

    Examples
    --------
    >>> import rockdamp as rd
    >>> from rockdamp.motions.experimental_style import synthetic_record
    >>> wall = rd.Wall(thickness=0.102, height=27 * 0.102, hinge_ratio=0.57, overburden_ratio=6.2)
    >>> fit = rd.calibrate(synthetic_record(restitution=0.845), wall)
    >>> float(fit.estimate.sel(parameter="restitution").round(3))
    0.845
    """
    instance("record", record, Record)
    instance("wall", wall, Wall, Parapet)
    require(np.ndim(wall.load_factor) == 0, "the number of walls", np.size(wall.load_factor), "1")
    a3, longest = number("ultimate_ratio (a3)", ultimate_ratio), number("step", step)
    require(0 < a3 <= 1, "ultimate_ratio (a3)", a3, "greater than 0 and at most 1")
    require(longest > 0, "step", longest, "greater than 0")
    fit = _Fit.of(record, wall, a3, one_of("softening", softening, SOFTENING), longest)
    point, local_minima = fit.search()
    for name, value, low, high in zip(SEARCHED, point, LOWEST, HIGHEST, strict=True):
        if min(value - low, high - value) < AT_BOUND * (high - low):
            raise InputError(f"the best fit has {name} {value:.4g}; it must lie inside {low:g} to {high:g}")
    estimate = fit.physical(point)
    computed = fit.computed(estimate[None])[0]
    _check_rocking(computed, estimate, float(wall.instability_displacement))
    residual = fit.without_trend(fit.measured - computed)
    derivative = fit.derivative(estimate)
    by_sensor, bandwidth = _covariance(derivative, residual)
    by_motion = fit.covariance_by_motion(estimate, derivative, computed)
    covariance = by_sensor + by_motion
    offset, drift = np.linalg.lstsq(fit.trend, fit.measured - computed, rcond=None)[0]
    degrees_of_freedom = residual.size - len(PARAMETERS) - fit.trend.shape[1]
    return xr.Dataset(
        {
            "estimate": ("parameter", estimate),
            "standard_error": ("parameter", np.sqrt(np.diag(covariance))),
            "true_value": ("parameter", _true_values(record)),
            "covariance": (("parameter", "parameter_other"), covariance),
            "standard_error_by_motion": ("parameter", np.sqrt(np.diag(by_motion))),
            "measured": ("elapsed", fit.measured - fit.trend @ [offset, drift]),
            "displacement": ("elapsed", computed),
            "residual_deviation": np.sqrt(residual @ residual / degrees_of_freedom),
            "rest_deviation": fit.rest_deviation,
            "sensor_offset": fit.sensor_zero + offset,
            "sensor_drift": drift,
            "bandwidth": bandwidth,
            "local_minima": local_minima,
        },
        coords={
            "parameter": list(PARAMETERS),
            "parameter_other": list(PARAMETERS),
            "elapsed": record.elapsed,
        },
        attrs=record_attributes(record),
    )


def _check_rocking(computed: Array, estimate: Array, u_ins: float) -> None:
    """Raise where the fitted wall stays on its first branch: there only b1/a1 matters."""
    largest, branch = float(np.abs(computed).max()), float(estimate[0]) * u_ins
    if largest <= branch:
        raise InputError(
            f"the largest displacement is {largest:.3g} m, on the first branch, which ends at {branch:.3g} m; "
            "it must go beyond to determine a1 and b1"
        )


def _true_values(record: Record) -> Array:
    """What a synthetic record says made it; NaN where it says nothing, or was measured."""
    values = [record.header.get(f"generator_{name}", "nan") if record.synthetic else "nan" for name in PARAMETERS]
    try:
        return np.array([float(value) for value in values])
    except ValueError:
        raise InputError(f"the record's generator_* values are {values}; they must be numbers") from None


def study(config: Config, record: Record) -> xr.Dataset:
    """Calibrate the wall of the config's ``validation`` section: its a3 and softening are kept, a1, b1 and e fitted."""
    given = CalibrationSettings.of(config)
    return calibrate(
        record, given.wall, ultimate_ratio=given.ultimate_ratio, softening=given.softening, step=given.step
    )


@dataclass(frozen=True)
class _Fit:
    """What is fitted, with what. A *point* is in the coordinates of the search, *parameters* are a1, b1 and e."""

    record: Record
    wall: Wall | Parapet
    ultimate_ratio: float
    softening: str
    step: float
    measured: Array  # from the level at rest [m]
    sensor_zero: float  # that level [m]
    rest_deviation: float  # of the measured displacement at rest [m]
    trend: Array  # (samples, 2): offset and drift of the sensor
    basis: Array  # the same, orthonormal

    @classmethod
    def of(cls, record: Record, wall: Wall | Parapet, ultimate_ratio: float, softening: str, step: float) -> _Fit:
        measured, zero = measured_displacement(record)
        elapsed = record.elapsed - record.elapsed[0]
        trend = np.stack([np.ones_like(elapsed), elapsed], axis=1)
        resting = float(np.std(measured[: rest_samples(record)]))
        basis = np.linalg.qr(trend)[0]
        return cls(record, wall, ultimate_ratio, softening, step, measured, zero, resting, trend, basis)

    def physical(self, points: Array) -> Array:
        """Turn points into parameters, or a batch of them, shape (..., 3)."""
        end = (1.0 if self.softening == "steeper" else self.ultimate_ratio) - points[..., 1]
        return np.stack([points[..., 0] * end, points[..., 1], points[..., 2]], axis=-1)

    def computed(self, parameters: Array) -> Array:
        """Displacement under CR for parameters of shape (batch, 3); shape (batch, samples). [m]"""
        a1, b1, e = parameters.T
        curve = TrilinearCurve(a1, b1, self.ultimate_ratio, self.softening)
        response = respond(self.record, self.wall, curve, Damping.cr(e), self.step)
        # Collapsed walls must stay comparable numbers, and lose.
        return float(self.wall.instability_displacement) * np.nan_to_num(response.displacement, nan=LOST)

    def without_trend(self, histories: Array) -> Array:
        """What of histories, shape (..., samples), no offset and drift can explain."""
        return histories - (histories @ self.basis) @ self.basis.T

    def misfit(self, points: Array, description: str = "") -> Array:
        """Sum of squares of each point's residual, shape (batch,); a description shows the progress. [m2]"""
        batches = np.array_split(points, -(-len(points) // BATCH))
        some = track(batches, description) if description else batches
        residuals = (self.without_trend(self.measured - self.computed(self.physical(batch))) for batch in some)
        return np.concatenate([np.einsum("ij,ij->i", residual, residual) for residual in residuals])

    def derivative(self, parameters: Array, *, at_point: bool = False) -> Array:
        """Derivative of the computed history by the parameters, or at a point by the point; shape (samples, 3)."""
        h = DIFFERENCE * (HIGHEST - LOWEST)
        sides = np.concatenate([parameters + np.diag(h), parameters - np.diag(h)])
        computed = self.without_trend(self.computed(self.physical(sides) if at_point else sides))
        return ((computed[:3] - computed[3:]) / (2 * h[:, None])).T

    def covariance_by_motion(self, parameters: Array, derivative: Array, computed: Array) -> Array:
        """Covariance that the accelerometer's noise alone gives the estimates, by Monte Carlo, to first order.

        It acts through the response, as an error of the motion: it shifts the whole decay, and the residuals of the
        fit hardly show it. Taken as white; its size is that of the differences between samples before and after the
        motion.
        """
        acceleration = self.record.ground_acceleration
        moving = np.flatnonzero(np.abs(acceleration) >= QUIET * np.abs(acceleration).max())
        steps = np.concatenate([np.diff(acceleration[: moving[0]]), np.diff(acceleration[moving[-1] + 1 :])])
        size = DRAWN * np.sqrt(np.mean(steps**2) / 2)
        draws = size * np.random.RandomState(DRAWS_SEED).standard_normal((DRAWS, acceleration.size))

        def shift(noise: Array) -> Array:
            moved = replace(self, record=replace(self.record, ground_acceleration=acceleration + noise))
            return self.without_trend(moved.computed(parameters[None])[0] - computed)

        with ThreadPoolExecutor(available_threads()) as pool:
            shifts = np.array(list(track(pool.map(shift, draws), "noise of the motion", DRAWS)))
        estimates = np.linalg.lstsq(derivative, shifts.T, rcond=None)[0]
        return estimates @ estimates.T / (DRAWS * DRAWN**2)

    def search(self) -> tuple[Array, int]:
        """Return the point of least misfit, and how many local minima the scan found."""
        grid = np.array(list(product(*SCAN)))
        coarse = replace(self, step=SCAN_STEP)
        misfit = coarse.misfit(grid, "scan of a1, b1 and e").reshape([len(axis) for axis in SCAN])
        minima = np.flatnonzero(misfit == minimum_filter(misfit, size=3, mode="nearest"))
        points = grid[np.argsort(misfit, axis=None, kind="stable")[:KEPT]]
        best = coarse._descend(coarse._refine(points))
        for _ in range(ROUNDS - 1):
            if np.sqrt(2 * best.cost / self.measured.size) < EXPLAINED * self.rest_deviation:
                break
            again = coarse._descend(coarse._refine(best.x[None]))
            if again.cost > 0.99 * best.cost:
                break
            best = again
        return self._descend(best.x).x, minima.size

    def _refine(self, points: Array) -> Array:
        """Look around each point, keep the best of all, halve the distance, and so on; return the best."""
        misfit, spacing = self.misfit(points), SPACING
        for _ in range(REFINEMENTS):
            spacing = spacing / 2
            around = np.stack([points] * len(NEARBY))
            around[..., 0] *= np.exp(NEARBY[:, None, 0] * spacing[0])
            around[..., 1:] += NEARBY[:, None, 1:] * spacing[1:]
            around = np.clip(around.reshape(-1, 3), LOWEST, HIGHEST)
            points, misfit = np.concatenate([points, around]), np.concatenate([misfit, self.misfit(around)])
            best = np.argsort(misfit, kind="stable")[:KEPT]
            points, misfit = points[best], misfit[best]
        return points[0]

    def _descend(self, start: Array) -> OptimizeResult:

        def residual(point: Array) -> Array:
            return self.without_trend(self.computed(self.physical(point)[None])[0] - self.measured)

        def derivative(point: Array) -> Array:
            # Central differences must not step over a bound: 1 is the largest e there is.
            inside = DIFFERENCE * (HIGHEST - LOWEST)
            return self.derivative(np.clip(point, LOWEST + inside, HIGHEST - inside), at_point=True)

        return least_squares(
            residual,
            start,
            derivative,
            bounds=(LOWEST, HIGHEST),
            x_scale=HIGHEST - LOWEST,
            **DESCENT,
        )


def _covariance(derivative: Array, residual: Array) -> tuple[Array, int]:
    """Covariance of the estimates under serially correlated residuals, and the bandwidth in samples that it took.

    Derivative and residual are without offset and drift, so those two are accounted for (Frisch and Waugh).
    """
    scale = np.linalg.norm(derivative, axis=0)
    if not scale.all() or np.linalg.cond(derivative / scale) > LARGEST_CONDITION:
        raise InputError("the record does not determine a1, b1 and e; it must hold rocking beyond the first branch")
    scores = (derivative / scale) * residual[:, None]
    samples = residual.size
    lag_one = np.sum(scores[1:] * scores[:-1], axis=0) / np.sum(scores**2, axis=0)
    rho = min(float(lag_one.max()), 0.99)
    alpha = 4 * rho**2 / (1 - rho**2) ** 2
    bandwidth = min(int(np.ceil(1.1447 * (alpha * samples) ** (1 / 3))), samples - 1)
    meat = scores.T @ scores
    for lag in range(1, bandwidth + 1):
        product_ = scores[lag:].T @ scores[:-lag]
        meat += (1 - lag / (bandwidth + 1)) * (product_ + product_.T)
    meat *= samples / (samples - derivative.shape[1] - 2)
    bread = np.linalg.inv((derivative / scale).T @ (derivative / scale))
    return bread @ meat @ bread / np.outer(scale, scale), bandwidth
