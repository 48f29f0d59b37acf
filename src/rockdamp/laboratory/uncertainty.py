"""Covariance of least squares, by the sensor, the measured motion and the wall's sizes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np
from scipy.special import ndtri

from rockdamp.arrays import Array
from rockdamp.errors import InputError, check_choice, check_number, check_type
from rockdamp.histories.loads import make_load
from rockdamp.histories.record_rest import motion_noise
from rockdamp.laboratory.record_fit import RecordFit, Solution
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.progress import track
from rockdamp.solvers.newmark import Load

NORMAL_QUANTILE = float(ndtri(0.95))  # for an interval of 90 %
MOTION_DRAWS = 1024  # draws of the motion's noise
DIFFERENCE_STEP = 1e-5  # of a coordinate, for central differences


def differentiate(
    function: Callable[[Array], Array], point: Array, coordinates: Sequence[int] | None = None
) -> Array:
    """Return central differences of a function at a point, shape (values, coordinates).

    Parameters
    ----------
    function : callable
        Takes points, shape (batch, coordinates). Returns values, shape (batch, values).
    point : ndarray, shape (coordinates,)
        Point.
    coordinates : sequence of int, optional
        Coordinates to differentiate by. Default: all.
    """
    steps = DIFFERENCE_STEP * np.eye(point.size)
    if coordinates is not None:
        steps = steps[list(coordinates)]
    forward, backward = np.split(function(np.concatenate([point + steps, point - steps])), 2)
    return ((forward - backward) / (2 * DIFFERENCE_STEP)).T


def covariance_by_sensor(derivative: Array, residual: Array) -> Array:
    """Return the covariance of the estimates under residuals that are correlated in time.

    Newey and West's estimate (doi:10.2307/1913610) with Andrews' bandwidth (doi:10.2307/2938229).
    Derivative and residual have no offset and drift of the sensor, so that these two are accounted
    for (Frisch and Waugh).

    Parameters
    ----------
    derivative : ndarray, shape (samples, parameters)
        Derivative of the residual by the parameters.
    residual : ndarray, shape (samples,)
        Residual of the fit.

    Raises
    ------
    InputError
        If the derivatives do not tell the parameters apart.
    """
    scale = np.linalg.norm(derivative, axis=0)
    # ASSUME: above this condition number the record does not determine the parameters.
    if not scale.all() or np.linalg.cond(derivative / scale) > 1e4:
        raise InputError(
            "the test does not determine a1, b1 and e: with these sizes no peak clearly leaves the"
            " first branch, or the half cycles do not shorten as the peaks fall, as those of a"
            " rocking wall do; check thickness, height and the units"
        )
    scores = (derivative / scale) * residual[:, None]
    samples, parameters = scores.shape
    lag_one = np.sum(scores[1:] * scores[:-1], axis=0) / np.sum(scores**2, axis=0)
    rho = min(float(lag_one.max()), 0.99)
    # Andrews' Eqs. (6.2) and (6.4), for Bartlett's weights and a process of first order.
    alpha = 4 * rho**2 / (1 - rho**2) ** 2
    andrews = int(np.ceil(1.1447 * (alpha * samples) ** (1 / 3)))
    bandwidth = min(andrews, samples - 1)
    meat = scores.T @ scores
    for lag in range(1, bandwidth + 1):
        product = scores[lag:].T @ scores[:-lag]
        bartlett_weight = 1 - lag / (bandwidth + 1)
        meat += bartlett_weight * (product + product.T)
    meat *= samples / (samples - parameters - 2)  # two more for offset and drift
    bread = np.linalg.inv((derivative / scale).T @ (derivative / scale))
    return bread @ meat @ bread / np.outer(scale, scale)


def covariance_by_motion(fit: RecordFit, parameters: Array, derivative: Array) -> Array:
    """Return the covariance of the estimates by the accelerometer's noise.

    The noise shifts the whole decay, and the residuals of a fit hardly show it. It is taken as
    white; its size comes from the differences between samples before and after the motion. Drawn
    noise is run through the solver, because near collapse a tangent would underestimate its effect.
    All fits share the draws.

    Parameters
    ----------
    fit : RecordFit
        Fit of one record.
    parameters : ndarray, shape (3,)
        Best a1, b1 and e.
    derivative : ndarray, shape (samples, 3)
        Derivative of the residual by the parameters.
    """
    random = np.random.RandomState(0)
    response = fit.response(parameters)
    record = fit.record
    # Small enough for the response to be linear, and large against the solver's roughness.
    noise_share = 0.3
    lanes = 16  # motions of one run; each lane adds up all of them, so that more would be slower
    shifts = []
    for _ in track(range(MOTION_DRAWS // lanes), "noise of the motion"):
        draws = random.standard_normal((lanes, record.elapsed.size))
        grounds = []
        for noise in noise_share * motion_noise(record) * draws:
            motion = replace(record, ground_acceleration=record.ground_acceleration + noise)
            grounds.append(make_load(fit.wall, motion, substeps=fit.substeps).ground)
        factor = fit.wall.load_factor * np.eye(lanes)  # each lane has a motion of its own
        load = Load(np.concatenate(grounds), factor, fit.load.sampling)
        shift = fit.subtract_trend(fit.response(parameters, load) - response)
        shifts.append(shift / noise_share)
    estimates = np.linalg.lstsq(derivative, np.concatenate(shifts).T, rcond=None)[0]
    return np.asarray(estimates @ estimates.T / MOTION_DRAWS)


def size_change(solution: Solution, name: str, deviation: float) -> Array:
    """Return the change of the estimates with one size of the wall, to first order.

    Parameters
    ----------
    solution : Solution
        Best fit of one record.
    name : str
        Name of the size, such as "thickness".
    deviation : float
        Standard deviation of the size.
    """
    fit = solution.fit
    estimates = []
    for side in (1, -1):
        size: dict[str, Any] = {name: getattr(fit.wall, name) + side * deviation}
        other_fit = replace(fit, wall=replace(fit.wall, **size))
        estimates.append(other_fit.descend(solution.point).parameters)
    return np.asarray(estimates[0] - estimates[1]) / 2


def check_deviations(
    wall: Wall | Parapet, uncertain: Mapping[str, float] | None
) -> Mapping[str, float]:
    """Return the standard deviations of sizes of the wall, by name, all greater than 0."""
    if uncertain is None:
        return {}
    size_names = [field.name for field in fields(wall)]
    for name, deviation in check_type("uncertain", uncertain, Mapping).items():
        check_choice("a size that is uncertain", name, size_names)
        check_number(f"uncertain {name}", deviation, lambda size: size > 0, "greater than 0")
    return uncertain
