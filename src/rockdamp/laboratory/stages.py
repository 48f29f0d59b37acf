"""Stages of the pipeline: the tested wall calibrated, and the damping models that a test series supports."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any
from zlib import crc32

import numpy as np
import xarray as xr

from rockdamp.config import Config
from rockdamp.errors import InputError
from rockdamp.histories.measured_test import made_by
from rockdamp.laboratory.calibration import calibrate
from rockdamp.laboratory.candidates import Candidate, Prior
from rockdamp.laboratory.least_squares import RecordFit
from rockdamp.laboratory.posterior import Evidence, evidence_of, probabilities
from rockdamp.laboratory.sections import LaboratoryConfig
from rockdamp.motions.records import Record
from rockdamp.progress import track, without_bars

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
        fit = RecordFit.of(record, test.wall, Candidate.of(model), **known)
    except InputError:
        return Evidence()
    return evidence_of(fit, Prior(**dict(section.prior)), section.seed)


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
