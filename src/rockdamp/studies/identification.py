"""The study of identification: simulated records identified, and the models that a test_series's records support."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated
from zlib import crc32

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.parsing import Settings
from rockdamp.config.walls import Strip
from rockdamp.errors import InputError
from rockdamp.histories.measured_test import made_by
from rockdamp.identification.candidates import Candidate
from rockdamp.identification.evidence import Evidence, evidence_of, probabilities
from rockdamp.identification.least_squares import Fit
from rockdamp.identification.prior import Prior
from rockdamp.identification.simulated import Maker, Simulated, gathered
from rockdamp.motions.records import Record
from rockdamp.progress import track, without_bars

NOISE = ("generator_accelerometer_noise_m_s2", "generator_sensor_noise_m")  # of a synthetic record's header


@dataclass(frozen=True)
class IdentificationSettings(Settings):
    """The wall of the tests, the prior, and what is simulated: new records, and the test_series's with more noise."""

    wall: Annotated[Strip, "validation.wall"]
    ultimate_displacement_ratio: Annotated[float, "validation.curve.ultimate_displacement_ratio"]
    softening: Annotated[str, "validation.curve.softening"]
    prior: Annotated[Prior, "identification.prior", Prior.of]
    step: Annotated[float, "identification.step"]
    simulated: Annotated[Simulated, "identification.simulated"]
    damping_models: Annotated[tuple[str, ...], "identification.damping_models"]
    noise: Annotated[Array, "identification.noise"]


def identification(config: Config, test_series: Mapping[str, Record]) -> xr.Dataset:
    """Identify records made with parameters drawn from the prior, and compare models for the records of a test series.

    Parameters
    ----------
    config : dict
        Has the keys of `IdentificationSettings`.
    test_series : dict of str to Record
        Synthetic records, by their names.

    Returns
    -------
    xarray.Dataset
        Of what `simulated.gathered` and `test_series.supported` return.
    """
    given = IdentificationSettings.of(config)
    maker = maker_of(given)
    records = []
    for number in track(range(given.simulated.draws), "simulated records"):
        with without_bars():
            records.append(maker.judged(number))
    return gathered(maker.names, records).merge(supported(given, test_series))


def maker_of(given: IdentificationSettings) -> Maker:
    """Return what makes the records, with the prior that has the sensor's noise as it is simulated."""
    simulated = given.simulated
    prior = replace(
        given.prior, sensor_deviation=simulated.sensor_deviation, sensor_correlation=simulated.sensor_correlation
    )
    return Maker(given.wall, given.ultimate_displacement_ratio, given.softening, given.step, prior, simulated)


def noisier(record: Record, factor: float, random: np.random.RandomState) -> Record:
    """Add white noise to both channels of a synthetic record until its noise is a multiple of what it was."""
    more = np.sqrt(factor**2 - 1)
    acceleration, displacement = (more * float(record.header[name]) * _normal(record, random) for name in NOISE)
    assert record.displacement is not None
    return replace(
        record,
        ground_acceleration=record.ground_acceleration + acceleration,
        displacement=record.displacement + displacement,
    )


def _normal(record: Record, random: np.random.RandomState) -> Array:
    return random.standard_normal(record.elapsed.size)


def supported(given: IdentificationSettings, records: Mapping[str, Record]) -> xr.Dataset:
    """Compute the evidence of each model for each record, at each noise.

    Returns
    -------
    xarray.Dataset
        ``log_evidence``, ``log_evidence_error`` and ``probability`` (record, noise, damping_model), the last among the
        models that were determined, and ``record_made_by`` (record).

    Raises
    ------
    InputError
        If a record is not synthetic, or does not say with what noise it was made.
    """
    for name, record in records.items():
        if not (record.synthetic and record.displacement is not None and all(key in record.header for key in NOISE)):
            raise InputError(f"identification.test_series: {name} is not synthetic; it must be, and say what made it")
    cases = [(name, factor) for name in records for factor in given.noise]
    found = []
    for name, factor in track(cases, "models of the test_series's records"):
        random = np.random.RandomState([given.simulated.seed, crc32(name.encode())])
        record = noisier(records[name], float(factor), random)
        with without_bars():
            found.append([_evidence(given, record, model) for model in given.damping_models])
    shape = (len(records), len(given.noise), len(given.damping_models))
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
        coords={"record": list(records), "noise_factor": given.noise, "damping_model": list(given.damping_models)},
    )


def _evidence(given: IdentificationSettings, record: Record, model: str) -> Evidence:
    """Return the evidence of a model; NaN too where noise leaves nothing of the rest before the motion."""
    try:
        fit = _fit(given, record, model)
    except InputError:
        return Evidence()
    return evidence_of(fit, given.prior, given.simulated.seed)


def _fit(given: IdentificationSettings, record: Record, model: str) -> Fit:
    return Fit.of(
        record,
        given.wall,
        Candidate.of(model),
        ultimate_displacement_ratio=given.ultimate_displacement_ratio,
        softening=given.softening,
        step=given.step,
    )
