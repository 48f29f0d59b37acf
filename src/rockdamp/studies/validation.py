"""The damping models against a measured test: Fig. 8, with numbers for what the figure shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.equivalence.polynomials import Polynomials
from rockdamp.errors import InputError
from rockdamp.histories.half_cycles import CLEAR, LEAST, HalfCycles, half_cycles
from rockdamp.histories.measured_test import (
    computed_response,
    decay_start,
    free_phase_start,
    made_by,
    measured_displacement,
    record_attributes,
    rest_samples,
)
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.records import Record
from rockdamp.solvers.response import COLLAPSED, Histories
from rockdamp.vocabulary import MODELS, VISCOUS_MODELS


def validate(config: Config, record: Record, test_series: Mapping[str, Record], equivalence: xr.Dataset) -> xr.Dataset:
    """Compare the responses to measured motions, under each damping model, with the measured responses.

    The records of the test series, by name, are of the same wall. They are compared in place of `record`, unless it is
    measured and one of them is not. Misfits and decrements of the decay are over the half cycles that are free of the
    motion, and NaN where there is none. Histories that are shorter than another's end in NaN.
    It raises `InputError` if a record has no measured displacement, no rest before the motion or no decay after it, the
    records are not sampled alike, or the polynomials do not reach the config's e or a1.
    """
    ratios = damping_ratios(equivalence, config.validation.restitution, config.validation.fit_yield_displacement_ratios)
    records = compared(record, test_series)
    parts = []
    for name, one in records.items():
        try:
            parts.append(_of_record(config, ratios, one, len(records) == 1).expand_dims(record=[name]))
        except InputError as error:
            raise InputError(f"{name}: {error}" if len(records) > 1 else str(error)) from None
    joined = xr.concat(parts, "record", join="outer", fill_value={"half_cycle_free": np.int8(0)}, combine_attrs="drop")
    alone: dict[str, Any] = {
        "damping_ratio": ("damping_model", np.array([ratios.get(model, np.nan) for model in MODELS])),
        "restitution": config.validation.restitution,
        "instability_displacement": float(config.validation.wall.instability_displacement),
    }
    return joined.assign(alone).assign_attrs(_attributes(list(records.values())))


def compared(record: Record, test_series: Mapping[str, Record]) -> dict[str, Record]:
    """Return the records that are compared: the test series, or the record alone if only it is measured."""
    if not test_series or (not record.synthetic and any(one.synthetic for one in test_series.values())):
        return {"record": record}
    first = next(iter(test_series.values()))
    for name, one in test_series.items():
        if (one.elapsed[0], one.step) != (first.elapsed[0], first.step):
            raise InputError(
                f"{name} begins at {one.elapsed[0]:g} s with a step of {one.step:g} s; it must begin and be sampled as "
                f"the first of the test series, at {first.elapsed[0]:g} s with {first.step:g} s"
            )
    return dict(test_series)


def _attributes(records: Sequence[Record]) -> dict[str, str]:
    """Return the headers' statements on all records, each once; synthetic if any of them is."""
    stated = [record_attributes(one) for one in records]
    said = {key: "; ".join(dict.fromkeys(each[key] for each in stated)) for key in stated[0]}
    return {**said, "record_synthetic": "yes" if any(one.synthetic for one in records) else "no"}


def _of_record(config: Config, ratios: Mapping[str, float], record: Record, alone: bool) -> xr.Dataset:
    """Every model against one record; that of a wall which hardly rocks may lack a decay if it is not `alone`."""
    wall, curve, e = config.validation.wall, config.validation.curve, config.validation.restitution
    rest = rest_samples(record)
    measured, zero = measured_displacement(record)
    u_ins = float(wall.instability_displacement)
    after = decay_start(record, wall, curve)
    threshold = max(CLEAR * float(np.std(measured[:rest])), LEAST * u_ins)
    decay = half_cycles(record.elapsed, measured, threshold)
    first = np.flatnonzero(decay.start >= after)
    if alone and not first.size:
        raise InputError(
            f"the record has no half cycle beyond {threshold:.3g} m after {after:.3g} s; it must hold a decay"
        )
    decay = decay[slice(int(first[0]) if first.size else decay.peak.size, None)]
    free_start = free_phase_start(record, wall, curve)
    free = decay.start >= free_start

    runs = []
    for model in MODELS:
        damping = Damping.from_values(model, restitution=e, damping_ratio=ratios.get(model))
        response = computed_response(record, wall, curve, damping, config.validation.step)
        runs.append(_misfits(record.elapsed, response, u_ins, measured, decay, free, rest))
    per_model = {name: (dims, np.stack([run[name][1] for run in runs])) for name, (dims, _) in runs[0].items()}
    peak = float(np.abs(measured).max())
    return xr.Dataset(
        {
            **{name: (("damping_model", *dims), values) for name, (dims, values) in per_model.items()},
            "peak_ratio_to_measured": ("damping_model", per_model["peak_displacement"][1] / peak),
            "measured": ("elapsed", measured),
            "ground_acceleration": ("elapsed", record.ground_acceleration),
            "measured_decay_peak": ("half_cycle", np.abs(decay.peak)),
            "measured_decay_peak_elapsed": ("half_cycle", decay.peak_elapsed),
            "measured_half_cycle_duration": ("half_cycle", decay.duration),
            "half_cycle_free": ("half_cycle", free.astype(np.int8)),
            "measured_log_decrement": _log_decrement(np.abs(decay.peak[free])),
            "measured_peak_displacement": peak,
            "free_phase_start": free_start,
            "sensor_zero": zero,
            "record_made_by": made_by(record),
        },
        coords={
            "damping_model": list(MODELS),
            "elapsed": record.elapsed,
            "half_cycle": np.arange(1, decay.peak.size + 1),
        },
    )


def damping_ratios(equivalence: xr.Dataset, restitution: float, ratios: Array) -> dict[str, float]:
    """Evaluate the polynomials xi(e) of each viscous model: the mean over the a1, linear in a1 between the fits.

    The paper averages its fits at two values of a1 around the wall's.
    """
    polynomials = Polynomials.from_dataset(equivalence)
    polynomials.require_cover(restitution, ratios, "fit_yield_displacement_ratios")
    return {model: float(np.mean([polynomials(model, restitution, a1) for a1 in ratios])) for model in VISCOUS_MODELS}


# --- one model against the measurement ------------------------------------------------------------------------------


def _misfits(
    elapsed: Array,
    response: Histories,
    u_ins: float,
    measured: Array,
    decay: HalfCycles,
    free: NDArray[np.bool_],
    rest: int,
) -> Mapping[str, tuple[tuple[str, ...], Any]]:
    """Measure the misfits of one response; NaN where the wall collapsed or a half cycle has no match."""
    displacement = u_ins * response.displacement
    collapsed = int(response.outcome) == COLLAPSED
    peaks, times, durations = (np.full(decay.peak.size, np.nan) for _ in range(3))
    count = 0
    if not collapsed:
        matched = _match(half_cycles(elapsed, displacement, LEAST * u_ins), decay)
        count = matched.peak.size
        peaks[:count], times[:count] = np.abs(matched.peak), matched.peak_elapsed
        durations[:count] = matched.duration
    amplitude, judged = np.abs(decay.peak), free & np.isfinite(peaks)
    both = free & np.isfinite(durations) & np.isfinite(decay.duration)
    return {
        "control_displacement": (("elapsed",), displacement),
        "collapsed": ((), np.int8(collapsed)),
        "peak_displacement": ((), u_ins * float(response.peak)),
        "rms_misfit": ((), np.sqrt(np.mean((displacement - measured)[rest:] ** 2))),
        "matched_half_cycles": ((), count),
        "decay_peak": (("half_cycle",), peaks),
        "decay_peak_elapsed": (("half_cycle",), times),
        "half_cycle_duration": (("half_cycle",), durations),
        "decay_peak_misfit": ((), np.sqrt(np.mean((peaks - amplitude)[judged] ** 2)) if judged.any() else np.nan),
        "decay_peak_ratio": ((), np.mean((peaks / amplitude)[judged]) if judged.any() else np.nan),
        "log_decrement": ((), _log_decrement(peaks[judged])),
        "period_drift": ((), durations[both].sum() / decay.duration[both].sum() - 1 if both.any() else np.nan),
    }


def _log_decrement(peaks: Array) -> float:
    """Mean logarithm of the ratio of one peak to the next; NaN of fewer than two. [-]"""
    return float(np.log(peaks[0] / peaks[-1]) / (peaks.size - 1)) if peaks.size > 1 else np.nan


def _match(computed: HalfCycles, measured: HalfCycles) -> HalfCycles:
    """Match successive half cycles, from the computed one on the first's side whose peak is nearest to it in time."""
    if not measured.peak.size:
        return computed[slice(0, 0)]
    same_side = np.flatnonzero(np.sign(computed.peak) == np.sign(measured.peak[0]))
    if not same_side.size:
        return computed[slice(0, 0)]
    nearest = np.argmin(np.abs(computed.peak_elapsed[same_side] - measured.peak_elapsed[0]))
    start = int(same_side[nearest])
    return computed[slice(start, start + measured.peak.size)]
