"""A measured record identified: the posterior of its wall and damper, and the evidence of each damping model.

The pipeline's stages stand at the end: the tested wall calibrated, and the damping models that a test series supports.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any
from zlib import crc32

import numpy as np
import xarray as xr

from rockdamp.arguments import instance, one_of
from rockdamp.arrays import Array
from rockdamp.errors import InputError, require
from rockdamp.histories.measured_test import made_by, record_attributes
from rockdamp.laboratory.calibration import Misfit, require_explained, require_possible
from rockdamp.laboratory.candidates import Candidate, Prior, require_unlike, true_values
from rockdamp.laboratory.least_squares import RecordFit
from rockdamp.laboratory.noise import correlated
from rockdamp.laboratory.problem import Problem
from rockdamp.laboratory.sampler import Draws
from rockdamp.laboratory.sections import LaboratoryConfig
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.records import Record
from rockdamp.plausibility import warn
from rockdamp.progress import track, without_bars
from rockdamp.vocabulary import CANDIDATES, REFERENCE

# --- evidence ---------------------------------------------------------------------------------------------------------

OF_EVIDENCE = 300.0  # effective draws, at least: the logarithm of the evidence is then known to 0.06


@dataclass(frozen=True)
class Evidence:
    """The logarithm of the evidence and its standard error; NaN, with the reason, where it could not be determined."""

    logarithm: float = np.nan
    standard_error: float = np.nan
    reason: str = ""


def evidence_of(
    fit: RecordFit | Sequence[RecordFit], prior: Prior, seed: int, *, loss_by_run: bool = False
) -> Evidence:
    """Return the evidence of a model by one run or several; undetermined where its posterior is refused."""
    try:
        solutions = [one.solution() for one in ([fit] if isinstance(fit, RecordFit) else fit)]
        _, drawn = Problem.about(solutions, prior, loss_by_run=loss_by_run).drawn(OF_EVIDENCE, seed)
    except InputError as error:
        return Evidence(reason=str(error))
    return Evidence(drawn.log_evidence, drawn.error)


def probabilities(log_evidence: Array) -> Array:
    """Return the probability of each model, along the last axis, of those that were determined; all equal before."""
    known = np.isfinite(log_evidence)
    highest = np.max(np.where(known, log_evidence, -np.inf), axis=-1, keepdims=True)
    relative = np.exp(np.where(known, log_evidence - np.where(np.isfinite(highest), highest, 0.0), -np.inf))
    total = relative.sum(axis=-1, keepdims=True)
    return np.where(known, relative / np.where(total > 0, total, 1.0), np.nan)


# --- posterior --------------------------------------------------------------------------------------------------------

SENSOR = "sensor_deviation"  # the one sampled parameter that has a unit
EFFECTIVE = 2000.0  # draws of a posterior, at least
STORED = 1000  # of them, with equal weights
DRAWN = 200  # of them histories, for the predictive band
LEVELS = (0.5, 0.9)
STEP = 0.01  # in tau, at most: at it the errors of the solver stay below those of the instruments


def posterior(
    record: Record | Sequence[Record],
    wall: Wall | Parapet,
    damping_model: str = REFERENCE,
    *,
    compared: Sequence[str] = (),
    loss_by_run: bool = False,
    ultimate_displacement_ratio: float = 1.0,
    softening: str = "steeper",
    step: float = STEP,
    prior: Prior | None = None,
    seed: int = 2017,
) -> xr.Dataset:
    """Return the posterior of a1, b1 and the damper from measured records, with the instruments' errors as unknowns.

    The likelihood takes the displacement sensor's zero and drift, noise of the sensor whose neighbours are correlated,
    and the accelerometer's white noise, to which the wall responds. Zero, drift and the motion's noise are integrated
    out in closed form, the response to it as linear about the noise that leads to the record's trajectory. Nested
    sampling about the mode gives draws and evidence, for the models `compared` too. The same seed gives the same draws.

    A record has a measured displacement and is at rest before the motion. Several records are runs of one test: they
    share wall, damper and sensor, but for e or xi with `loss_by_run`. The wall is taken as known but for sizes that
    have a distribution in the prior; a3 and the variant of softening are known. The solver's steps are at most `step`
    in tau. It raises `InputError` if the least squares leave a misfit far above the noise, if the records do not
    determine the parameters, or are so near to collapse that their noise decides or the response is not linear in it.
    """
    prior = instance("prior", prior or Prior(), Prior)
    names = [one_of("damping_model", name, CANDIDATES) for name in (damping_model, *compared)]
    records = [record] if isinstance(record, Record) else list(record)
    require(len(records) > 0, "the number of records", len(records), "at least 1")
    require_unlike("records", [instance("record", one, Record).displacement for one in records])
    require(all(hasattr(wall, name) for name in prior.sizes), "hinge_ratio", "uncertain", "that of a wall: no parapet")

    for run, one in enumerate(records, start=1):
        with _concerning_run(run, len(records)):
            require_possible(instance("record", one, Record), instance("wall", wall, Wall, Parapet))

    a3 = ultimate_displacement_ratio
    known: Any = {"ultimate_displacement_ratio": a3, "softening": softening, "step": step}

    def fits(name: str) -> list[RecordFit]:
        return [RecordFit.from_record(one, wall, Candidate.from_name(name), **known) for one in records]

    solutions, misfits = [], []
    for run, fit in enumerate(fits(names[0]), start=1):
        with _concerning_run(run, len(records)):
            solutions.append(fit.solution())
            misfits.append(require_explained(solutions[-1]))
    about = Problem.about(solutions, prior, loss_by_run=loss_by_run and len(records) > 1)
    chosen, draws = about.drawn(EFFECTIVE, seed)
    values = chosen.values(draws.points)
    warn(chosen.doubts(float(draws.weights @ values[:, chosen.names.index(SENSOR)])))
    evidence = {names[0]: Evidence(draws.log_evidence, draws.error)}
    for name in track([name for name in names[1:] if name not in evidence], "evidence of other models"):
        evidence[name] = evidence_of(fits(name), prior, seed, loss_by_run=chosen.loss_by_run)
    summary = _summary(chosen, draws, misfits, seed)
    summary = summary.assign_attrs(**record_attributes(records[0]), identified_model=names[0])
    return summary.merge(_evidences({name: evidence[name] for name in names[1:]})) if compared else summary


@contextmanager
def _concerning_run(run: int, runs: int) -> Iterator[None]:
    """Name the run in an error about its record, where there are several."""
    try:
        yield
    except InputError as error:
        raise error if runs == 1 else InputError(f"record {run} of {runs}: {error}") from None


def _summary(problem: Problem, draws: Draws, misfits: Sequence[Misfit], seed: int) -> xr.Dataset:
    values = problem.values(draws.points)
    random = np.random.RandomState(seed)
    stored = problem.values(draws.resampled(STORED, random))
    plain = [index for index, name in enumerate(problem.names) if name != SENSOR]
    names, sensor = [problem.names[index] for index in plain], problem.names.index(SENSOR)
    runs = range(len(problem.runs))
    trends, bands, inside = zip(*(_predicted(problem, stored[:DRAWN], random, run) for run in runs), strict=True)
    mean = draws.weights @ values
    bounds = np.array([[0.5 - level / 2, 0.5 + level / 2] for level in LEVELS])
    intervals = [_quantiles(values[:, index], draws.weights, bounds) for index in plain]
    of_runs = {name: [misfit.variables[name] for misfit in misfits] for name in misfits[0].variables} | {
        "sensor_zero": [run.fit.sensor_zero + trend[0] for run, trend in zip(problem.runs, trends, strict=True)],
        "sensor_drift": [trend[1] for trend in trends],
        "share_inside": list(inside),
    }
    summary = xr.Dataset(
        {
            "mean": ("parameter", mean[plain]),
            "standard_deviation": ("parameter", np.sqrt(draws.weights @ (values - mean) ** 2)[plain]),
            "interval": (("level", "bound", "parameter"), np.stack(intervals, axis=-1)),
            "effective_draws": draws.effective,
            "true_value": ("parameter", true_values(problem.fit.record, [name.split()[0] for name in names])),
            "draws": (("draw", "parameter"), stored[:, plain]),
            "sensor_deviation": ("draw", stored[:, sensor]),
        },
        coords={
            "parameter": names,
            "level": list(LEVELS),
            "bound": ["low", "high"],
            "draw": np.arange(1, len(stored) + 1),
        },
    )
    if len(runs) > 1:
        by_run = summary.assign({name: ("run", found) for name, found in of_runs.items()})
        return by_run.assign_coords(run=np.arange(1, len(runs) + 1))
    fit = problem.fit
    summary = summary.assign({name: found[0] for name, found in of_runs.items()})
    return summary.assign(
        measured=("elapsed", fit.measured - fit.trend @ trends[0]), predicted=(("bound", "elapsed"), bands[0])
    ).assign_coords(elapsed=fit.record.elapsed)


def _quantiles(values: Array, weights: Array, probabilities: Array) -> Array:
    """Return quantiles of weighted values, with the shape of the probabilities."""
    order = np.argsort(values)
    below = np.cumsum(weights[order]) - 0.5 * weights[order]
    return np.interp(probabilities, below, values[order])


def _predicted(problem: Problem, values: Array, random: np.random.RandomState, run: int) -> tuple[Array, Array, float]:
    """Predict the sensor's mean zero and drift of a run, the band of what it shows less these, and the share in it."""
    noise, measured = problem.runs[run].noise, problem.runs[run].fit.measured
    _, residuals = problem.response(values, run)
    linear = noise.draw(residuals, values[:, -2], values[:, -1], random)
    shown = measured - residuals + linear @ noise.rows
    shown += np.stack([correlated(s, phi, random.standard_normal(measured.size)) for s, phi in values[:, -2:].tolist()])
    trend = linear[:, :2].mean(axis=0) * [problem.prior.sensor_zero, problem.prior.sensor_drift]
    low, high = np.quantile(shown, [0.5 - LEVELS[-1] / 2, 0.5 + LEVELS[-1] / 2], axis=0)
    inside = float(np.mean((low <= measured) & (measured <= high)))
    return trend, np.stack([low, high]) - problem.runs[run].fit.trend @ trend, inside


def _evidences(found: dict[str, Evidence]) -> xr.Dataset:
    """Put evidences into a dataset, with the probability of each model of those that were determined."""
    logarithm = np.array([one.logarithm for one in found.values()])
    return xr.Dataset(
        {
            "log_evidence": ("damping_model", logarithm),
            "log_evidence_error": ("damping_model", np.array([one.standard_error for one in found.values()])),
            "probability": ("damping_model", probabilities(logarithm)),
            "undetermined": ("damping_model", [one.reason for one in found.values()]),
        },
        coords={"damping_model": list(found)},
    )


# --- stages -----------------------------------------------------------------------------------------------------------

NOISE = ("generator_accelerometer_noise_m_s2", "generator_sensor_noise_m")  # of a synthetic record's header


def noisier(record: Record, factor: float, random: np.random.RandomState) -> Record:
    """Add white noise to both channels of a synthetic record until its noise is a multiple of what it was."""
    more = np.sqrt(factor**2 - 1)
    acceleration, displacement = (
        more * float(record.header[name]) * random.standard_normal(record.elapsed.size) for name in NOISE
    )
    assert record.displacement is not None
    return replace(
        record,
        ground_acceleration=record.ground_acceleration + acceleration,
        displacement=record.displacement + displacement,
    )


def identification(config: LaboratoryConfig, test_series: Mapping[str, Record]) -> xr.Dataset:
    """Compute the evidence of each damping model for each record, at each noise.

    The probability is among the models whose evidence was determined. It raises `InputError` if a record is not
    synthetic, or does not say with what noise it was made.
    """
    section, records = config.identification, test_series
    for name, record in records.items():
        if not (record.synthetic and record.displacement is not None and all(key in record.header for key in NOISE)):
            raise InputError(f"identification.test_series: {name} is not synthetic; it must be, and say what made it")
    cases, found = [(name, factor) for name in records for factor in section.noise], []
    for name, factor in track(cases, "models of the test series"):
        random = np.random.RandomState([section.seed, crc32(name.encode())])
        record = noisier(records[name], float(factor), random)
        with without_bars():
            found.append([_evidence(config, record, model) for model in section.damping_models])
    shape = (len(records), len(section.noise), len(section.damping_models))
    dims = ("record", "noise_factor", "damping_model")
    logarithm = np.array([[one.logarithm for one in row] for row in found]).reshape(shape)
    error = np.array([[one.standard_error for one in row] for row in found]).reshape(shape)
    return xr.Dataset(
        {
            "log_evidence": (dims, logarithm),
            "log_evidence_error": (dims, error),
            "probability": (dims, probabilities(logarithm)),
            "record_made_by": ("record", np.array([made_by(record) for record in records.values()])),
        },
        coords={
            "record": list(records),
            "noise_factor": section.noise,
            "damping_model": list(section.damping_models),
        },
    )


def _evidence(config: LaboratoryConfig, record: Record, model: str) -> Evidence:
    """Return the evidence of a model; NaN too where noise leaves nothing of the rest before the motion."""
    section, test = config.identification, config.validation
    a3, softening = float(test.curve.ultimate_displacement_ratio), test.curve.softening
    known: Any = {"ultimate_displacement_ratio": a3, "softening": softening, "step": section.step}
    try:
        fit = RecordFit.from_record(record, test.wall, Candidate.from_name(model), **known)
    except InputError:
        return Evidence()
    return evidence_of(fit, Prior(**dict(section.prior)), section.seed)
