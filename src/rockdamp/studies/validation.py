"""The damping models against a measured test: Fig. 8, with numbers for the figure."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.constants import MODELS, REFERENCE, VISCOUS_MODELS
from rockdamp.equivalence.polynomials import Polynomials
from rockdamp.errors import InputError
from rockdamp.histories.half_cycles import CLEAR_OF_NOISE, LEAST_PEAK, HalfCycles, half_cycles
from rockdamp.histories.record_rest import measured_displacement, rest_samples
from rockdamp.histories.respond import record_attributes, respond
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.record import Record


def validate(
    config: Config, record: Record, equivalence: xr.Dataset, calibration: xr.Dataset
) -> xr.Dataset:
    """Compare the response to a measured motion, under each damping model, with the measured one.

    a1, b1 and e are those of the calibration on the same record; a3 and the softening are the
    config's. The metrics of the decay are over all half cycles after the largest measured peak.

    Raises
    ------
    InputError
        If the record has no measured displacement, no rest before the motion or fewer than two half
        cycles after its largest peak, or the polynomials do not reach the calibrated e and a1 or
        the config's a1.
    """
    section = config.validation
    wall = section.wall.make()
    estimate = calibration["estimate"].to_series()
    a1 = estimate["yield_displacement_ratio"]
    b1 = estimate["strength_ratio"]
    e = estimate["restitution"]
    # The fits must reach the calibrated a1 too, although the ratios are those of the config's a1.
    damping_ratios(equivalence, e, np.array([a1]))
    ratios = damping_ratios(equivalence, e, np.array(section.fit_yield_displacement_ratios))
    rest = rest_samples(record)
    test_displacement, zero = measured_displacement(record)
    u_ins = float(wall.instability_displacement)
    threshold = max(CLEAR_OF_NOISE * float(np.std(test_displacement[:rest])), LEAST_PEAK * u_ins)
    decay = _measured_decay(record.elapsed, test_displacement, threshold)
    curve = section.curve.make(yield_displacement_ratio=a1, strength_ratio=b1)
    dampings = [Damping(model, e if model == REFERENCE else ratios[model]) for model in MODELS]
    responses = respond(wall, curve, dampings, record, step=section.step)
    responses = responses.assign_coords(elapsed=record.elapsed)
    histories = responses[["control_displacement", "collapsed", "peak_displacement"]]
    histories = histories.reset_coords(drop=True)
    comparisons = [
        compare(responses.sel(damping_model=model), test_displacement, decay, rest)
        for model in MODELS
    ]
    peak = float(np.abs(test_displacement).max())
    damping_ratio = np.array([ratios.get(model, np.nan) for model in MODELS])
    return (
        xr.concat(comparisons, "damping_model")
        .assign(histories)
        .assign(
            peak_ratio_to_measured=histories["peak_displacement"] / peak,
            measured=("elapsed", test_displacement),
            ground_acceleration=("elapsed", record.ground_acceleration),
            measured_log_decrement=_log_decrement(np.abs(decay.peak)),
            measured_peak_displacement=peak,
            sensor_zero=zero,
            damping_ratio=("damping_model", damping_ratio),
            yield_displacement_ratio=a1,
            strength_ratio=b1,
            restitution=e,
            instability_displacement=u_ins,
        )
        .assign_coords(damping_model=list(MODELS), elapsed=record.elapsed)
        .assign_attrs(record_attributes(record.header))
    )


def damping_ratios(equivalence: xr.Dataset, restitution: float, ratios: Array) -> dict[str, float]:
    """Evaluate the polynomials xi(e) of each viscous model: the mean over several a1.

    Between the fits they are linear in a1. The paper averages its fits at two values of a1 around
    the wall's.

    Parameters
    ----------
    equivalence : xarray.Dataset
        Polynomials of the stage ``equivalence``.
    restitution : float
        Restitution coefficient e. [-]
    ratios : ndarray
        Values of a1. [-]

    Raises
    ------
    InputError
        If e or an a1 lies outside the range of the fits.
    """
    polynomials = Polynomials.from_dataset(equivalence)
    means = {}
    for model in VISCOUS_MODELS:
        means[model] = float(np.mean([polynomials(model, restitution, a1) for a1 in ratios]))
    if not np.isfinite(list(means.values())).all():
        low, high = polynomials.restitution
        a1 = polynomials.yield_displacement_ratio
        raise InputError(
            f"restitution is {restitution:g} and yield_displacement_ratio"
            f" {', '.join(map('{:g}'.format, ratios))}; they must be within the range of the fits,"
            f" {low:g} to {high:g} and {a1[0]:g} to {a1[-1]:g}"
        )
    return means


def _measured_decay(elapsed: Array, displacement: Array, threshold: float) -> HalfCycles:
    """Return the half cycles after the largest peak; refuse fewer than two."""
    decay = half_cycles(elapsed, displacement, threshold)
    if decay.peak.size:
        largest = int(np.argmax(np.abs(decay.peak)))
        decay = decay[slice(largest + 1, None)]
    if decay.peak.size < 2:
        raise InputError(
            f"the record has {decay.peak.size} half cycles beyond {threshold:.3g} m after its"
            " largest peak; it must have at least 2"
        )
    return decay


# --- one model against the measurement ------------------------------------------------------------


def compare(
    response: xr.Dataset, test_displacement: Array, decay: HalfCycles, rest: int
) -> xr.Dataset:
    """Compare one response with the measured one.

    Metrics are NaN if the wall collapsed or no half cycle has a match.

    Parameters
    ----------
    response : xarray.Dataset
        Response under one damping model.
    test_displacement : ndarray, shape (samples,)
        Measured displacement from its level at rest. [m]
    decay : HalfCycles
        Measured half cycles of the decay.
    rest : int
        Number of samples at rest before the motion.
    """
    displacement = response["control_displacement"].values
    threshold = LEAST_PEAK * float(response["instability_displacement"])
    cycles = half_cycles(response["elapsed"].values, displacement, threshold)
    computed_decay = decay[slice(0, 0)] if response["collapsed"] else _match(cycles, decay)
    count = computed_decay.peak.size
    peaks = np.abs(computed_decay.peak)
    measured_peaks = np.abs(decay.peak[:count])
    metrics = {
        "rms_misfit": np.sqrt(np.mean((displacement - test_displacement)[rest:] ** 2)),
        "matched_half_cycles": count,
        "decay_peak_misfit": np.nan,
        "decay_peak_ratio": np.nan,
        "log_decrement": _log_decrement(peaks),
        "period_drift": np.nan,
    }
    if count:
        metrics["decay_peak_misfit"] = np.sqrt(np.mean((peaks - measured_peaks) ** 2))
        metrics["decay_peak_ratio"] = np.mean(peaks / measured_peaks)
    durations = computed_decay.duration
    measured_durations = decay.duration[:count]
    is_whole = np.isfinite(durations) & np.isfinite(measured_durations)
    if is_whole.any():
        ratio = durations[is_whole].sum() / measured_durations[is_whole].sum()
        metrics["period_drift"] = ratio - 1
    return xr.Dataset(metrics)


def _log_decrement(peaks: Array) -> float:
    """Return the mean logarithm of the ratio of one peak to the next; NaN for one peak. [-]"""
    if peaks.size < 2:
        return np.nan
    return float(np.log(peaks[0] / peaks[-1]) / (peaks.size - 1))


def _match(computed_cycles: HalfCycles, measured_cycles: HalfCycles) -> HalfCycles:
    """Return the computed half cycles that match the measured ones, in order.

    The first one is on the same side as the first measured one, and of those that are, its peak is
    nearest in time.
    """
    same_side = np.flatnonzero(np.sign(computed_cycles.peak) == np.sign(measured_cycles.peak[0]))
    if not same_side.size:
        return computed_cycles[slice(0, 0)]
    nearest = np.argmin(
        np.abs(computed_cycles.peak_elapsed[same_side] - measured_cycles.peak_elapsed[0])
    )
    start = int(same_side[nearest])
    return computed_cycles[slice(start, start + measured_cycles.peak.size)]
