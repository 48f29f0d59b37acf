"""A measured record identified: the posterior of its wall and damper, and which damping models it supports."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from rockdamp.arguments import instance, one_of
from rockdamp.arrays import Array
from rockdamp.histories.measured_test import record_attributes
from rockdamp.identification.candidates import Candidate, true_values
from rockdamp.identification.evidence import Evidence, evidence_of, probabilities
from rockdamp.identification.least_squares import Fit
from rockdamp.identification.noise import correlated
from rockdamp.identification.prior import Prior
from rockdamp.identification.problem import Problem
from rockdamp.identification.sampler import Draws
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.records import Record
from rockdamp.plausibility import warn
from rockdamp.progress import track
from rockdamp.vocabulary import CANDIDATES, REFERENCE

SENSOR = "sensor_deviation"  # the one sampled parameter that has a unit
EFFECTIVE = 2000.0  # draws of a posterior, at least
STORED = 1000  # of them, with equal weights
DRAWN = 200  # of them histories, for the predictive band
LEVELS = (0.5, 0.9)
STEP = 0.01  # in tau, at most: at it the errors of the solver stay below those of the instruments


def posterior(
    record: Record,
    wall: Wall | Parapet,
    damping_model: str = REFERENCE,
    *,
    compared: Sequence[str] = (),
    ultimate_displacement_ratio: float = 1.0,
    softening: str = "steeper",
    step: float = STEP,
    prior: Prior | None = None,
    seed: int = 2017,
) -> xr.Dataset:
    """Return the posterior of a1, b1 and the damper from a measured record, with the instruments' errors as unknowns.

    The likelihood takes the displacement sensor's zero and drift, noise of the sensor whose neighbours are correlated,
    and the accelerometer's white noise, to which the wall responds. Zero, drift and the motion's noise are integrated
    out in closed form, the response to it as linear about the noise that leads to the record's trajectory. Nested
    sampling about the mode gives draws and evidence, for the models `compared` too. The same seed gives the same draws.

    The record has a measured displacement and is at rest before the motion. The wall, a3 and the variant of softening
    are taken as known; the solver's steps are at most `step` in tau. It raises `InputError` if the record does not
    determine the parameters, or is so near to collapse that its noise decides or its response is not linear in it.
    """
    prior = instance("prior", prior or Prior(), Prior)
    names = [one_of("damping_model", name, CANDIDATES) for name in (damping_model, *compared)]

    def fit(name: str) -> Fit:
        return Fit.of(
            record,
            wall,
            Candidate.of(name),
            ultimate_displacement_ratio=ultimate_displacement_ratio,
            softening=softening,
            step=step,
        )

    chosen, draws = Problem.of(fit(names[0]), prior).drawn(EFFECTIVE, seed)
    values = chosen.values(draws.points)
    warn(chosen.doubts(float(draws.weights @ values[:, chosen.names.index(SENSOR)])))
    evidence = {names[0]: Evidence(draws.log_evidence, draws.error)}
    for name in track([name for name in names[1:] if name not in evidence], "evidence of other models"):
        evidence[name] = evidence_of(fit(name), prior, seed)
    summary = _summary(chosen, draws, seed).assign_attrs(**record_attributes(record), identified_model=names[0])
    return summary.merge(_evidences({name: evidence[name] for name in names[1:]})) if compared else summary


def _summary(problem: Problem, draws: Draws, seed: int) -> xr.Dataset:
    values = problem.values(draws.points)
    random = np.random.RandomState(seed)
    stored = problem.values(draws.resampled(STORED, random))
    plain = [index for index, name in enumerate(problem.names) if name != SENSOR]
    names, sensor = [problem.names[index] for index in plain], problem.names.index(SENSOR)
    trend, band, inside = _predicted(problem, stored[:DRAWN], random)
    mean = draws.weights @ values
    bounds = np.array([[0.5 - level / 2, 0.5 + level / 2] for level in LEVELS])
    intervals = [_quantiles(values[:, index], draws.weights, bounds) for index in plain]
    return xr.Dataset(
        {
            "mean": ("parameter", mean[plain]),
            "standard_deviation": ("parameter", np.sqrt(draws.weights @ (values - mean) ** 2)[plain]),
            "interval": (("level", "bound", "parameter"), np.stack(intervals, axis=-1)),
            "effective_draws": draws.effective,
            "true_value": ("parameter", true_values(problem.fit.record, names)),
            "draws": (("draw", "parameter"), stored[:, plain]),
            "sensor_deviation": ("draw", stored[:, sensor]),
            "sensor_zero": problem.fit.sensor_zero + trend[0],
            "sensor_drift": trend[1],
            "measured": ("elapsed", problem.fit.measured - problem.fit.trend @ trend),
            "predicted": (("bound", "elapsed"), band),
            "share_inside": inside,
        },
        coords={
            "parameter": names,
            "level": list(LEVELS),
            "bound": ["low", "high"],
            "draw": np.arange(1, len(stored) + 1),
            "elapsed": problem.fit.record.elapsed,
        },
    )


def _quantiles(values: Array, weights: Array, probabilities: Array) -> Array:
    """Return quantiles of weighted values, with the shape of the probabilities."""
    order = np.argsort(values)
    below = np.cumsum(weights[order]) - 0.5 * weights[order]
    return np.interp(probabilities, below, values[order])


def _predicted(problem: Problem, values: Array, random: np.random.RandomState) -> tuple[Array, Array, float]:
    """Return the sensor's mean zero and drift, the band of what it would show less these, and the share in it."""
    computed = problem.computed(values)
    residuals = problem.residuals(values, computed)
    linear = problem.noise.draw(residuals, values[:, -2], values[:, -1], random)
    shown = problem.fit.measured - residuals + linear @ problem.noise.rows
    shown += np.stack([_sensor_noise(row, random, shown.shape[1]) for row in values[:, -2:]])
    trend = linear[:, :2].mean(axis=0) * [problem.prior.sensor_zero, problem.prior.sensor_drift]
    low, high = np.quantile(shown, [0.5 - LEVELS[-1] / 2, 0.5 + LEVELS[-1] / 2], axis=0)
    inside = float(np.mean((low <= problem.fit.measured) & (problem.fit.measured <= high)))
    return trend, np.stack([low, high]) - problem.fit.trend @ trend, inside


def _sensor_noise(row: Array, random: np.random.RandomState, samples: int) -> Array:
    """Draw the sensor's noise of a standard deviation and a correlation. [m]"""
    return correlated(float(row[0]), float(row[1]), random.standard_normal(samples))


def _evidences(found: dict[str, Evidence]) -> xr.Dataset:
    """Put evidences into a dataset, with the probability of each model of those that were determined."""
    logarithm = np.array([one.logarithm for one in found.values()])
    return xr.Dataset(
        {
            "log_evidence": ("damping_model", logarithm),
            "log_evidence_error": ("damping_model", np.array([one.standard_error for one in found.values()])),
            "probability": ("damping_model", probabilities(logarithm)),
        },
        coords={"damping_model": list(found)},
    )
