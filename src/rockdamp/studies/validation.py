"""The damping models against a measured test: Fig. 8, with numbers for what the figure shows."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.constants import MODELS, REFERENCE, VISCOUS_MODELS
from rockdamp.equivalence.polynomials import Polynomials
from rockdamp.errors import InputError
from rockdamp.histories.half_cycles import CLEAR, LEAST, HalfCycles, half_cycles
from rockdamp.histories.measured_test import measured_displacement, rest_samples
from rockdamp.histories.respond import record_attributes, respond
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.record import Record


def validate(
    config: Config, record: Record, equivalence: xr.Dataset, calibration: xr.Dataset
) -> xr.Dataset:
    """Compare the response to a measured motion, under each damping model, with the measured response.

    a1, b1 and e are those of the calibration on the same record; a3 and the softening are the config's. The metrics of
    the decay are over all half cycles after the largest measured peak.
    It raises `InputError` if the record has no measured displacement, no rest before the motion or fewer than two half
    cycles after its largest peak, or if the polynomials do not reach the calibrated e and a1 or the config's a1.
    """
    section, wall = config.validation, config.validation.wall.make()
    fitted = calibration["estimate"].to_series()
    a1, b1, e = (
        fitted[name] for name in ("yield_displacement_ratio", "strength_ratio", "restitution")
    )
    damping_ratios(equivalence, e, np.array([a1]))  # which are refused where the fits do not reach
    ratios = damping_ratios(equivalence, e, np.array(section.fit_yield_displacement_ratios))

    rest, (measured, zero) = rest_samples(record), measured_displacement(record)
    u_ins = float(wall.instability_displacement)
    threshold = max(CLEAR * float(np.std(measured[:rest])), LEAST * u_ins)
    cycles = half_cycles(record.elapsed, measured, threshold)
    decay = (
        cycles[slice(int(np.argmax(np.abs(cycles.peak))) + 1, None)] if cycles.peak.size else cycles
    )
    if decay.peak.size < 2:
        raise InputError(
            f"the record has {decay.peak.size} half cycles beyond {threshold:.3g} m after its largest peak;"
            " it must have at least 2"
        )

    curve = section.curve.make(yield_displacement_ratio=a1, strength_ratio=b1)
    dampings = [Damping(model, e if model == REFERENCE else ratios[model]) for model in MODELS]
    responses = respond(wall, curve, dampings, record, step=section.step).assign_coords(
        elapsed=record.elapsed
    )
    histories = responses[["control_displacement", "collapsed", "peak_displacement"]].reset_coords(
        drop=True
    )
    compared = [
        compare(responses.sel(damping_model=model), measured, decay, rest) for model in MODELS
    ]
    peak = float(np.abs(measured).max())
    return (
        xr.concat(compared, "damping_model")
        .assign(histories)
        .assign(
            peak_ratio_to_measured=histories["peak_displacement"] / peak,
            measured=("elapsed", measured),
            ground_acceleration=("elapsed", record.ground_acceleration),
            measured_log_decrement=_log_decrement(np.abs(decay.peak)),
            measured_peak_displacement=peak,
            sensor_zero=zero,
            damping_ratio=(
                "damping_model",
                np.array([ratios.get(model, np.nan) for model in MODELS]),
            ),
            yield_displacement_ratio=a1,
            strength_ratio=b1,
            restitution=e,
            instability_displacement=u_ins,
        )
        .assign_coords(damping_model=list(MODELS), elapsed=record.elapsed)
        .assign_attrs(record_attributes(record.header))
    )


def damping_ratios(equivalence: xr.Dataset, restitution: float, ratios: Array) -> dict[str, float]:
    """Evaluate the polynomials xi(e) of each viscous model: the mean over the a1, linear in a1 between the fits.

    The paper averages its fits at two values of a1 around the wall's.
    """
    polynomials = Polynomials.from_dataset(equivalence)
    found = {
        model: float(np.mean([polynomials(model, restitution, a1) for a1 in ratios]))
        for model in VISCOUS_MODELS
    }
    if not np.isfinite(list(found.values())).all():
        low, high = polynomials.restitution
        a1 = polynomials.yield_displacement_ratio
        raise InputError(
            f"restitution is {restitution:g} and yield_displacement_ratio {', '.join(map('{:g}'.format, ratios))}; they"
            f" must be within the range of the fits, {low:g} to {high:g} and {a1[0]:g} to {a1[-1]:g}"
        )
    return found


# --- one model against the measurement ------------------------------------------------------------------------------


def compare(response: xr.Dataset, measured: Array, decay: HalfCycles, rest: int) -> xr.Dataset:
    """Compare one response with the measured one; NaN where the wall collapsed or a half cycle has no match."""
    displacement = response["control_displacement"].values
    cycles = half_cycles(
        response["elapsed"].values,
        displacement,
        LEAST * float(response["instability_displacement"]),
    )
    matched = decay[slice(0, 0)] if response["collapsed"] else _match(cycles, decay)
    count = matched.peak.size
    peaks, amplitudes = np.abs(matched.peak), np.abs(decay.peak[:count])
    durations, lasted = matched.duration, decay.duration[:count]
    both = np.isfinite(durations) & np.isfinite(lasted)
    return xr.Dataset(
        {
            "rms_misfit": np.sqrt(np.mean((displacement - measured)[rest:] ** 2)),
            "matched_half_cycles": count,
            "decay_peak_misfit": np.sqrt(np.mean((peaks - amplitudes) ** 2)) if count else np.nan,
            "decay_peak_ratio": np.mean(peaks / amplitudes) if count else np.nan,
            "log_decrement": _log_decrement(peaks),
            "period_drift": durations[both].sum() / lasted[both].sum() - 1
            if both.any()
            else np.nan,
        }
    )


def _log_decrement(peaks: Array) -> float:
    """Mean logarithm of the ratio of one peak to the next; NaN of fewer than two. [-]"""
    return float(np.log(peaks[0] / peaks[-1]) / (peaks.size - 1)) if peaks.size > 1 else np.nan


def _match(computed: HalfCycles, measured: HalfCycles) -> HalfCycles:
    """Match successive half cycles, from the computed one on the first's side whose peak is nearest to it in time."""
    same_side = np.flatnonzero(np.sign(computed.peak) == np.sign(measured.peak[0]))
    if not same_side.size:
        return computed[slice(0, 0)]
    nearest = np.argmin(np.abs(computed.peak_elapsed[same_side] - measured.peak_elapsed[0]))
    start = int(same_side[nearest])
    return computed[slice(start, start + measured.peak.size)]
