"""Covariance of least squares, by the displacement sensor, the measured motion and the wall's sizes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np
from scipy.special import ndtri

from rockdamp.arrays import Array
from rockdamp.errors import InputError, check_choice, check_number, check_type
from rockdamp.histories.loads import make_load
from rockdamp.histories.measured_test import motion_noise
from rockdamp.laboratory.record_fit import RecordFit
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.progress import track
from rockdamp.solvers.newmark import Load

NORMAL = float(ndtri(0.95))  # of an interval of 90 %
DRAWS = 1024  # of the motion's noise


def covariance_by_sensor(derivative: Array, residual: Array) -> Array:
    """Return the covariance of the estimates under residuals that are correlated in time.

    Newey and West's estimate (doi:10.2307/1913610) with Andrews' bandwidth (doi:10.2307/2938229). Derivative and
    residual are without offset and drift of the sensor, so those two are accounted for (Frisch and Waugh). Raises
    `InputError` where the derivatives do not tell the parameters apart.

    Parameters
    ----------
    derivative : ndarray, shape (samples, parameters)
    residual : ndarray, shape (samples,)
    """
    scale = np.linalg.norm(derivative, axis=0)
    if not scale.all() or np.linalg.cond(derivative / scale) > 1e4:
        raise InputError(
            "the record does not determine a1, b1 and e; the wall must leave its first branch"
        )
    scores = (derivative / scale) * residual[:, None]
    samples, parameters = scores.shape
    lag_one = np.sum(scores[1:] * scores[:-1], axis=0) / np.sum(scores**2, axis=0)
    rho = min(float(lag_one.max()), 0.99)
    alpha = 4 * rho**2 / (1 - rho**2) ** 2
    bandwidth = min(int(np.ceil(1.1447 * (alpha * samples) ** (1 / 3))), samples - 1)
    meat = scores.T @ scores
    for lag in range(1, bandwidth + 1):
        product = scores[lag:].T @ scores[:-lag]
        meat += (1 - lag / (bandwidth + 1)) * (product + product.T)
    meat *= samples / (samples - parameters - 2)
    bread = np.linalg.inv((derivative / scale).T @ (derivative / scale))
    return bread @ meat @ bread / np.outer(scale, scale)


def covariance_by_motion(fit: RecordFit, parameters: Array, derivative: Array) -> Array:
    """Return the covariance that the accelerometer's noise gives the estimates.

    It acts through the response, as an error of the motion: it shifts the whole decay, and the residuals of a fit
    hardly show it. It is taken as white; its size comes from the differences between samples before and after the
    motion. It is drawn, as near collapse the tangent would make it too small. All fits share the draws.
    """
    random, response, record = np.random.RandomState(0), fit.response(parameters), fit.record
    share = 0.3  # of the noise: small enough for the response to be linear, and large against the solver's roughness
    lanes = 16  # of one run, each of which takes time for all motions
    shifts = []
    for _ in track(range(DRAWS // lanes), "noise of the motion"):
        noise = share * motion_noise(record) * random.standard_normal((lanes, record.elapsed.size))
        motions = [
            replace(record, ground_acceleration=record.ground_acceleration + one) for one in noise
        ]
        ground = np.concatenate(
            [make_load(fit.wall, motion, substeps=fit.substeps).ground for motion in motions]
        )
        load = Load(
            ground, fit.wall.load_factor * np.eye(lanes), fit.load.sampling
        )  # each lane has its own motion
        shifts.append(fit.subtract_trend(fit.response(parameters, load) - response) / share)
    estimates = np.linalg.lstsq(derivative, np.concatenate(shifts).T, rcond=None)[0]
    return np.asarray(estimates @ estimates.T / DRAWS)


def size_change(fit: RecordFit, point: Array, name: str, deviation: float) -> Array:
    """Return the change of the estimates with a size of the wall by its standard deviation, to first order."""
    sizes: list[Any] = [{name: getattr(fit.wall, name) + sign * deviation} for sign in (1, -1)]
    others = [replace(fit, wall=replace(fit.wall, **size)) for size in sizes]
    large, small = (other.parameters(other.descend(point).x) for other in others)
    return np.asarray(large - small) / 2


def check_deviations(
    wall: Wall | Parapet, uncertain: Mapping[str, float] | None
) -> Mapping[str, float]:
    """Return the standard deviations of sizes of the wall, by name, all greater than 0."""
    if uncertain is None:
        return {}
    for name, deviation in check_type("uncertain", uncertain, Mapping).items():
        check_choice("a size that is uncertain", name, [field.name for field in fields(wall)])
        check_number(f"uncertain {name}", deviation, lambda size: size > 0, "greater than 0")
    return uncertain
