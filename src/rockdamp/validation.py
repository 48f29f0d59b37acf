"""The damping models against a measured test: Fig. 8, with numbers for what the figure shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.curve import TrilinearCurve
from rockdamp.damping import MODELS, VISCOUS_MODELS, Damping
from rockdamp.decay import Config, make_wall
from rockdamp.errors import InputError, require, require_finite
from rockdamp.newmark import COLLAPSED, Response, solve
from rockdamp.records import Record
from rockdamp.wall import Parapet, Wall

Array = NDArray[np.float64]

# ASSUME: the paper gives no definitions of its own for any of these.
QUIET = 0.02  # of the peak acceleration: before the motion first exceeds it the wall is at rest
FREE = 1 / 3  # of the plateau's strength: once the load stays below it, it can no longer make the wall rock
SHORTEST_REST = 10  # samples
CLEAR = 10  # standard deviations of the sensor at rest: a measured half cycle is one that goes beyond them
LEAST = 1e-3  # of u_ins: a computed half cycle is one that goes beyond it


@dataclass(frozen=True)
class HalfCycles:
    """Successive excursions to either side; all arrays of shape (count,).

    Attributes
    ----------
    peak : ndarray
        Largest displacement, signed. [m]
    peak_elapsed : ndarray
        Its time. [s]
    start, end : ndarray
        Crossings of zero before and after; NaN for the first's start and the last's end. [s]
    """

    peak: Array
    peak_elapsed: Array
    start: Array
    end: Array

    def __getitem__(self, part: slice) -> HalfCycles:
        return HalfCycles(self.peak[part], self.peak_elapsed[part], self.start[part], self.end[part])

    @property
    def duration(self) -> Array:
        """From crossing to crossing. [s]"""
        return self.end - self.start


def validate(config: Config, record: Record, equivalence: xr.Dataset) -> xr.Dataset:
    """Compare the response to the record's measured motion, under each damping model, with the measured response.

    Parameters
    ----------
    config : dict
        Validated; uses ``validation``.
    record : Record
        With a measured displacement, at rest before the motion.
    equivalence : xarray.Dataset
        With ``coefficient`` (damping_model, cracked_stiffness_ratio, degree) of the polynomials xi(e).

    Returns
    -------
    xarray.Dataset
        Histories, the matched half cycles of the decay, and the misfits of each model.

    Raises
    ------
    InputError
        If the record has no measured displacement, no rest before the motion or no free decay after it, or the
        polynomials do not reach the config's e or a1.
    """
    section = config["validation"]
    wall, curve, e = (
        make_wall(section["wall"]),
        TrilinearCurve(**section["curve"]),
        float(section["restitution"]),
    )
    ratios = damping_ratios(equivalence, e, section["fit_cracked_stiffness_ratios"])
    rest = rest_samples(record)
    measured, zero = measured_displacement(record)
    u_ins = float(wall.instability_displacement)
    free = free_phase_start(record, wall, curve)
    threshold = max(CLEAR * float(np.std(measured[:rest])), LEAST * u_ins)
    decay = half_cycles(record.elapsed, measured, threshold)
    first = np.flatnonzero(decay.start >= free)
    if not first.size:
        raise InputError(
            f"the record has no half cycle beyond {threshold:.3g} m after {free:.3g} s; it must hold a decay"
        )
    decay = decay[slice(int(first[0]), None)]

    runs = []
    for model in MODELS:
        damping = Damping.cr(e) if model == "CR" else Damping(model, ratios[model])
        response = respond(record, wall, curve, damping, float(section["step"]))
        runs.append(_compare(record.elapsed, response, u_ins, measured, decay, rest))
    per_model = {name: (dims, np.stack([run[name][1] for run in runs])) for name, (dims, _) in runs[0].items()}
    peak = float(np.abs(measured).max())
    return xr.Dataset(
        {
            **{name: (("damping_model", *dims), values) for name, (dims, values) in per_model.items()},
            "peak_ratio_to_measured": ("damping_model", per_model["peak_displacement"][1] / peak),
            "damping_ratio": ("damping_model", np.array([ratios.get(model, np.nan) for model in MODELS])),
            "measured": ("elapsed", measured),
            "ground_acceleration": ("elapsed", record.ground_acceleration),
            "measured_decay_peak": ("half_cycle", np.abs(decay.peak)),
            "measured_decay_peak_elapsed": ("half_cycle", decay.peak_elapsed),
            "measured_half_cycle_duration": ("half_cycle", decay.duration),
            "measured_log_decrement": _log_decrement(np.abs(decay.peak)),
            "measured_peak_displacement": peak,
            "restitution": e,
            "instability_displacement": u_ins,
            "free_phase_start": free,
            "sensor_zero": zero,
        },
        coords={
            "damping_model": list(MODELS), "elapsed": record.elapsed, "half_cycle": np.arange(1, decay.peak.size + 1)
        },
        attrs=record_attributes(record),
    )  # fmt: skip


def record_attributes(record: Record) -> dict[str, str]:
    """Return what a dataset, and with it each figure, must say of the record that it stands on."""
    told = {f"record_{key}": record.header.get(key, "not stated") for key in ("specimen", "source", "licence")}
    return {**told, "record_synthetic": "yes" if record.synthetic else "no"}


def damping_ratios(equivalence: xr.Dataset, restitution: float, ratios: Sequence[float]) -> dict[str, float]:
    """Evaluate the polynomials xi(e) of each viscous model: the mean over the given a1, linear in a1 between the fits.

    The paper averages its fits at two values of a1 around the wall's.

    Raises
    ------
    InputError
        If e or an a1 lies outside the range of the fits.
    """
    e, a1 = (np.sort(equivalence[name].values) for name in ("restitution", "cracked_stiffness_ratio"))
    allowed = f"within the range of the fits, {e[0]:g} to {e[-1]:g}"
    require(
        (e[0] <= np.asarray(restitution)) & (np.asarray(restitution) <= e[-1]),
        "restitution",
        restitution,
        allowed,
    )
    wanted = np.asarray(ratios, dtype=float)
    allowed = f"within the range of the fits, {a1[0]:g} to {a1[-1]:g}"
    require((a1[0] <= wanted) & (wanted <= a1[-1]), "fit_cracked_stiffness_ratios", wanted, allowed)
    fits = equivalence["coefficient"].sortby("cracked_stiffness_ratio")
    powers = restitution ** fits["degree"]
    at_fits = (fits * powers).sum("degree")
    return {
        model: float(np.interp(wanted, a1, at_fits.sel(damping_model=model).values).mean()) for model in VISCOUS_MODELS
    }


def respond(record: Record, wall: Wall | Parapet, curve: TrilinearCurve, damping: Damping, step: float) -> Response:
    """Response of a wall, or of a batch by the curve's or damper's arrays, to a record's motion, starting at rest.

    Parameters
    ----------
    step : float
        Of the solver, in tau: at most this, and a whole number of them between two samples of the record. [-]

    Returns
    -------
    Response
        With the histories at the record's samples.
    """
    require_finite("step", step)
    require(np.asarray(step) > 0, "step", step, "greater than 0")
    sampling = float(wall.frequency_parameter) * record.step
    substeps = int(np.ceil(sampling / step * (1 - 1e-12)))
    return solve(
        curve,
        damping,
        step=sampling / substeps,
        steps=substeps * (record.elapsed.size - 1),
        load_factor=float(wall.load_factor),
        ground_acceleration=record.ground_acceleration,
        substeps=substeps,
        store_every=substeps,
    )


# --- phases of the record -------------------------------------------------------------------------------------------


def rest_samples(record: Record) -> int:
    """Count the samples before the motion, in which the wall is at rest.

    Raises
    ------
    InputError
        If there are fewer than `SHORTEST_REST`.
    """
    acceleration = np.abs(record.ground_acceleration)
    count = int(np.argmax(acceleration >= QUIET * acceleration.max()))
    allowed = f"at least {SHORTEST_REST}, in which the motion stays below {QUIET:.0%} of its peak"
    require(np.asarray(count >= SHORTEST_REST), "the number of samples at rest before the motion", count, allowed)
    return count


def measured_displacement(record: Record) -> tuple[Array, float]:
    """Return the measured displacement from the level at rest, and that level as the sensor showed it. [m]

    Raises
    ------
    InputError
        If the record has no displacement, or no rest.
    """
    if record.displacement is None:
        raise InputError("the record has no column displacement_m; it must hold the measured response")
    zero = float(np.mean(record.displacement[: rest_samples(record)]))
    return record.displacement - zero, zero


def free_phase_start(record: Record, wall: Wall, curve: TrilinearCurve) -> float:
    """Time from which the load stays below `FREE` of the plateau's strength. [s]

    Raises
    ------
    InputError
        If it does not before the end of the record.
    """
    load = np.abs(float(wall.load_factor) * record.ground_acceleration)
    strong = np.flatnonzero(load >= FREE * float(curve.plateau_ratio))
    last = int(strong[-1]) if strong.size else 0
    if last >= record.elapsed.size - 1:
        raise InputError(
            "the motion is still strong at the end of the record; it must hold a free decay after the motion"
        )
    return float(record.elapsed[last + 1])


def half_cycles(elapsed: Array, displacement: Array, threshold: float) -> HalfCycles:
    """Split a history at its crossings of zero into excursions beyond `threshold` to alternate sides.

    Noise near zero makes no half cycles: one begins where the other side's threshold is passed, and the crossing
    between two is the middle of the first and last change of sign between them.
    """
    beyond = np.flatnonzero(np.abs(displacement) > threshold)
    side = np.sign(displacement[beyond])
    turns = np.flatnonzero(np.diff(side) != 0)
    firsts = beyond[np.concatenate([[0], turns + 1])] if beyond.size else beyond
    lasts = beyond[np.concatenate([turns, [beyond.size - 1]])] if beyond.size else beyond
    at = [first + int(np.argmax(np.abs(displacement[first : last + 1]))) for first, last in zip(firsts, lasts)]
    between = [_crossing(elapsed, displacement, last, first) for last, first in zip(lasts[:-1], firsts[1:])]
    outer = [np.nan] if beyond.size else []
    return HalfCycles(
        displacement[at] if at else np.empty(0), elapsed[at] if at else np.empty(0),
        np.array(outer + between), np.array(between + outer),
    )  # fmt: skip


def _crossing(elapsed: Array, displacement: Array, start: int, stop: int) -> float:
    """Middle of the first and the last change of sign from sample `start` to sample `stop`, linearly interpolated."""
    u = displacement[start : stop + 1]
    changes = start + np.flatnonzero(np.sign(u[:-1]) * np.sign(u[1:]) <= 0)[[0, -1]]
    before, after = displacement[changes], displacement[changes + 1]
    part = np.divide(before, before - after, out=np.zeros(2), where=before != after)
    return float(np.mean(elapsed[changes] + part * (elapsed[changes + 1] - elapsed[changes])))


# --- one model against the measurement ------------------------------------------------------------------------------


def _compare(
    elapsed: Array, response: Response, u_ins: float, measured: Array, decay: HalfCycles, rest: int
) -> Mapping[str, tuple[tuple[str, ...], Any]]:
    """Misfits of one response; NaN where the wall collapsed or a half cycle has no match. Values by name with dims."""
    assert response.displacement is not None
    displacement = u_ins * response.displacement
    collapsed = int(response.outcome) == COLLAPSED
    peaks, times, durations = (np.full(decay.peak.size, np.nan) for _ in range(3))
    count = 0
    if not collapsed:
        matched = _match(half_cycles(elapsed, displacement, LEAST * u_ins), decay)
        count = matched.peak.size
        peaks[:count], times[:count] = np.abs(matched.peak), matched.peak_elapsed
        durations[:count] = matched.duration
    amplitude, both = np.abs(decay.peak), np.isfinite(durations) & np.isfinite(decay.duration)
    nothing = np.nan
    decrement = _log_decrement(peaks[:count])
    return {
        "displacement": (("elapsed",), displacement),
        "collapsed": ((), np.int8(collapsed)),
        "peak_displacement": ((), u_ins * float(response.peak)),
        "rms_misfit": ((), np.sqrt(np.mean((displacement - measured)[rest:] ** 2))),
        "matched_half_cycles": ((), count),
        "decay_peak": (("half_cycle",), peaks),
        "decay_peak_elapsed": (("half_cycle",), times),
        "half_cycle_duration": (("half_cycle",), durations),
        "decay_peak_misfit": ((), np.sqrt(np.mean((peaks - amplitude)[:count] ** 2)) if count else nothing),
        "decay_peak_ratio": ((), np.mean((peaks / amplitude)[:count]) if count else nothing),
        "log_decrement": ((), decrement),
        "period_drift": (
            (),
            durations[both].sum() / decay.duration[both].sum() - 1 if both.any() else nothing,
        ),
    }


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
