"""Compare ECD of order m with CR by its order, in free decay and under load: from viscous damping to restitution.

The damping ratio of ECD is exact, nothing is fitted. Beside it stand the dampers of `VISCOUS_MODELS`, which are fitted
by Eq. (17), and CR itself after a small change of e: a damper that is nearer to CR than that is as good as CR.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.histories.half_cycles import passes_zero, turns
from rockdamp.histories.loads import CELLS, pulse_load
from rockdamp.histories.measured_test import computed_response, record_attributes
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.pulse_shapes import PULSES
from rockdamp.motions.records import Record
from rockdamp.progress import track
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.response import COLLAPSED, Histories, Options, Reference
from rockdamp.statistics.against_restitution import CHANGES_OF_E, of_outcomes, of_pairs
from rockdamp.studies.amplitude_dependence import Group, groups
from rockdamp.studies.decays import step_count
from rockdamp.studies.matches import match_decays
from rockdamp.vocabulary import VISCOUS_MODELS

PULSE_DIMS = (*CELLS, "restitution")
MEASURES = ("rms_error", "peak_error", "duration_error")

R = TypeVar("R")
Variables = dict[str, tuple[tuple[str, ...], NDArray[Any]]]


def damper_order(config: Config, record: Record) -> xr.Dataset:
    """Compare ECD of each order with CR, in free decay, under pulses and under the motion of the record of Fig. 8."""
    asked = groups(
        config.amplitude_dependence,
        float(config.curve.strength_ratio),
        config.studies.cracked_stiffness.strength_ratio_beyond,
    )
    parts = [_on_group(group, config) for group in asked]
    curves = xr.concat(parts, "case", join="exact", combine_attrs="drop", data_vars="minimal", coords="minimal")
    parts = [
        _on_curve(config),
        _fitted(config),
        _shown(config),
        _under_pulses(config),
        _under_record(config, record),
    ]
    return xr.merge([curves, *parts], join="exact", compat="no_conflicts").assign_attrs(record_attributes(record))


@dataclass(frozen=True)
class Dampers:
    """Dampers that are compared with CR at each e: ECD of each order, then CR at an e a little lower and higher."""

    order: Array
    restitution: Array
    change: float

    def each(self, run: Callable[[Damping], R], description: str = "") -> list[R]:
        """Call a function for each of them, which have the shape of `restitution`."""
        e = self.restitution
        dampings = [Damping.of_restitution(e, order=m) for m in self.order]
        dampings += [Damping.cr(e - self.change), Damping.cr(e + self.change)]
        return [run(damping) for damping in (track(dampings, description) if description else dampings)]

    def split(self, measures: Mapping[str, NDArray[Any]], *dims: str) -> Variables:
        """Return values of all of them as two variables each, of the orders and of CR itself."""
        many = self.order.size
        of_order = {name: (("order", *dims), values[:many]) for name, values in measures.items()}
        varied = {f"varied_{name}": (("variation", *dims), values[many:]) for name, values in measures.items()}
        return {**of_order, **varied}

    @property
    def coords(self) -> dict[str, list[object]]:
        return {"order": list(self.order), "variation": list(CHANGES_OF_E)}


def _dampers(config: Config, restitution: Array) -> Dampers:
    return Dampers(config.damper_order.order, restitution, config.damper_order.restitution_change)


def _at(config: Config) -> dict[str, Any]:
    """Return length, step and scheme of the decays."""
    return {
        "response_length": config.matching.response_length,
        "step": config.solver.step,
        "scheme": config.solver.scheme,
    }


# --- free decay ------------------------------------------------------------------------------------------------------


def measured(
    curve: TrilinearCurve,
    release_amplitude: Array,
    dampers: Dampers,
    *,
    response_length: float,
    step: float,
    scheme: str,
) -> dict[str, Array]:
    """Compare decays, shape (lanes,), with those under CR; each measure has the shape (dampers, lanes). [-]

    ``rms_error`` is sqrt(Err/k) of Eq. (17) over the response length in tau. ``peak_error`` and ``duration_error`` are
    the largest difference of a peak, and of the time from one peak to the next, as a fraction of those under CR.
    """
    steps = step_count(response_length, step)
    start: Options = {"release_amplitude": release_amplitude, "step": step, "steps": steps, "scheme": scheme}
    restitution = solve(curve, Damping.cr(dampers.restitution), store_every=1, **start)
    reference = Reference(restitution.displacement, np.arange(release_amplitude.size), [steps])
    expected = turns(restitution.displacement, restitution.velocity, step)

    def differences(damping: Damping) -> tuple[Array, Array, Array]:
        run = solve(curve, damping, reference=reference, store_every=1, **start)
        peaks, elapsed = turns(run.displacement, run.velocity, step)
        most = min(peaks.shape[1], expected[0].shape[1])
        lasting, lasted = (np.diff(times[:, :most], prepend=0.0) for times in (elapsed, expected[1]))
        return (
            np.sqrt(run.error[0] / steps),
            _largest(peaks[:, :most] / expected[0][:, :most] - 1),
            _largest(lasting / lasted - 1),
        )

    return dict(zip(MEASURES, map(np.stack, zip(*dampers.each(differences), strict=True)), strict=True))


def _largest(difference: Array) -> Array:
    """Largest size over the last axis; NaN where nothing is known."""
    return np.fmax.reduce(np.abs(difference), axis=-1, initial=np.nan)


def _on_group(group: Group, config: Config) -> xr.Dataset:
    share, e = config.damper_order.release_share, config.damper_order.restitution
    shape = (len(group.name), share.size, e.size)
    case, share_at, e_at = (index.ravel() for index in np.indices(shape))
    ultimate = np.asarray(group.curve.ultimate_displacement_ratio)
    dampers = _dampers(config, e[e_at])
    curve, release_amplitude = group.curve.map(lambda p: p[case]), share[share_at] * ultimate[case]
    errors = measured(curve, release_amplitude, dampers, **_at(config))
    shaped = {name: values.reshape(-1, *shape) for name, values in errors.items()}
    return xr.Dataset(
        dampers.split(shaped, "case", "release_share", "restitution"),
        coords={**dampers.coords, "case": group.name, "release_share": share, "restitution": e},
    )


def _on_curve(config: Config) -> xr.Dataset:
    """On the reference curve, with the damping ratios."""
    e = config.damper_order.restitution
    dampers = _dampers(config, e)
    errors = measured(config.curve, np.full(e.size, config.release_amplitude), dampers, **_at(config))
    variables = dampers.split({f"curve_{name}": values for name, values in errors.items()}, "restitution")
    ratio = [Damping.of_restitution(e, order=m).damping_ratio for m in dampers.order]
    return xr.Dataset(
        {**variables, "damping_ratio": (("order", "restitution"), np.stack(ratio))},
        coords={
            **dampers.coords,
            "restitution": e,
            "restitution_change": dampers.change,
            "release_amplitude": config.release_amplitude,
            "response_length": config.matching.response_length,
        },
    )


def _fitted(config: Config) -> xr.Dataset:
    """The dampers of least Err on the reference curve, by the protocol of all published damping ratios."""
    e = config.damper_order.restitution
    matched = match_decays(
        config.curve.map(lambda p: np.full(e.size, p)),
        np.full(e.size, config.release_amplitude),
        e,
        VISCOUS_MODELS,
        config.matching,
        step=config.solver.step,
        scheme=config.solver.scheme,
        description="fitted dampers",
    )
    fitted = matched.values()
    values = {
        "fitted_damping_ratio": [match.damping_ratio for match in fitted],
        "fitted_damping_ratio_uncertainty": [match.uncertainty for match in fitted],
        "fitted_rms_error": [match.rms_error for match in fitted],
    }
    dims = ("damping_model", "restitution")
    return xr.Dataset(
        {name: (dims, np.stack(rows)) for name, rows in values.items()},
        coords={"damping_model": list(matched), "restitution": e},
    )


def _shown(config: Config) -> xr.Dataset:
    """Histories under CR and each order, of the decay on the reference curve at the e of Fig. 3."""
    e, step, order = config.damping_force.restitution, config.solver.step, config.damper_order.order
    steps = step_count(config.matching.response_length, step)
    dampings = [Damping.cr(e), *(Damping.of_restitution(e, order=m) for m in order)]
    impact, *runs = [
        solve(
            config.curve,
            damping,
            release_amplitude=config.release_amplitude,
            step=step,
            steps=steps,
            store_every=1,
            scheme=config.solver.scheme,
        )
        for damping in dampings
    ]
    force = [
        damping.coefficient(config.curve, run.displacement, run.velocity) * run.velocity
        for damping, run in zip(dampings[1:], runs, strict=True)
    ]
    return xr.Dataset(
        {
            "shown_reference_displacement": ("tau", impact.displacement),
            "shown_reference_velocity": ("tau", impact.velocity),
            "shown_displacement": (("order", "tau"), np.stack([run.displacement for run in runs])),
            "shown_velocity": (("order", "tau"), np.stack([run.velocity for run in runs])),
            "shown_damping_force": (("order", "tau"), np.stack(force)),
        },
        coords={"order": list(order), "tau": step * np.arange(steps + 1), "shown_restitution": e},
    )


# --- under load ------------------------------------------------------------------------------------------------------


def _under_pulses(config: Config) -> xr.Dataset:
    section, e = config.damper_order.pulses, config.damper_order.restitution
    dampers = _dampers(config, e)
    shape = (len(PULSES), section.frequency.size, section.load.size, e.size)
    rows = dampers.order.size + len(CHANGES_OF_E)
    fell, before, peak = np.empty((rows, *shape), dtype=bool), np.empty((rows, *shape)), np.empty((rows, *shape))
    reference_fell = np.empty(shape, dtype=bool)
    for i, name in enumerate(PULSES):
        for j, w in enumerate(track(section.frequency, f"{name} pulses by order")):
            peak_load = float(config.curve.strength_ratio) * section.load[:, None]
            forcing = pulse_load(name, float(w), peak_load, section.step, section.tail)
            impact, *histories = [
                solve(config.curve, damping, store_every=1, **forcing.newmark())
                for damping in (Damping.cr(e), *dampers.each(lambda damping: damping))
            ]
            reference_fell[i, j] = impact.outcome == COLLAPSED
            for row, history in enumerate(histories):
                fell[row, i, j] = history.outcome == COLLAPSED
                peak[row, i, j] = history.peak / impact.peak
                before[row, i, j] = ratio_before_impact(impact.displacement, history.displacement)
    ratio = np.where(fell | reference_fell, np.nan, peak)
    return xr.Dataset(
        {
            **dampers.split({"pulse_ratio": ratio, "pulse_ratio_before_impact": before}, *PULSE_DIMS),
            **dampers.split(pulse_statistics(ratio, before, fell, reference_fell), "restitution"),
            "pulse_collapses": ("restitution", reference_fell.sum((0, 1, 2))),
            "pulse_survivals": ("restitution", (~reference_fell).sum((0, 1, 2))),
        },
        coords={
            **dampers.coords,
            "pulse": list(PULSES),
            "pulse_frequency": section.frequency,
            "load_ratio": section.load,
            "restitution": e,
        },
    )


def pulse_statistics(
    ratio: Array, before: Array, fell: NDArray[np.bool_], reference_fell: NDArray[np.bool_]
) -> dict[str, NDArray[Any]]:
    """Return statistics over all pulses of each damper against CR, of shape (dampers, e); NaN where there is no ratio.

    The ratio is the peak over CR's, `before` the same up to CR's first impact, shape (dampers, pulses, frequencies,
    loads, e). The collapses under CR are without the first dimension.
    """
    dims = ("damper", *PULSE_DIMS)
    counts = of_outcomes(xr.DataArray(fell, dims=dims), xr.DataArray(reference_fell, dims=PULSE_DIMS), CELLS)
    measures = {f"pulse_{name}": values.transpose("damper", ...).to_numpy() for name, values in counts.items()}
    for name, values in {"pulse": ratio, "pulse_before_impact": before}.items():
        pairs = of_pairs(xr.DataArray(values, dims=dims), CELLS)
        measures |= {f"{name}_{statistic}": pairs[statistic].to_numpy() for statistic in ("median_ratio", "log_error")}
    return measures


def ratio_before_impact(reference: Array, displacement: Array) -> Array:
    """Peak over that of the reference, both up to the reference's first impact; NaN where one collapses before it.

    Both histories start from rest at x = 0 and are NaN after a collapse; time is the last axis.
    """
    impacts = passes_zero(reference[..., 1:])  # the start is at rest at 0
    before: NDArray[np.bool_] = np.cumsum(impacts, axis=-1) <= impacts
    peak, expected = (np.abs(np.where(before, x[..., 1:-1], 0.0)).max(axis=-1) for x in (displacement, reference))
    return np.asarray(peak / expected)


def _under_record(config: Config, record: Record) -> xr.Dataset:
    """The tested wall under the record's motion: the largest displacement. [m]"""
    wall, e = config.validation.wall, np.asarray(config.validation.restitution)
    dampers = _dampers(config, e)

    def run(damping: Damping) -> Histories:
        return computed_response(record, wall, config.validation.curve, damping, config.validation.step)

    impact, histories = run(Damping.cr(e)), dampers.each(run)
    u_ins = float(wall.instability_displacement)
    return xr.Dataset(
        {
            "record_reference_peak": u_ins * float(impact.peak),
            **dampers.split({"record_peak": u_ins * np.array([float(history.peak) for history in histories])}),
        },
        coords={**dampers.coords, "record_restitution": float(e)},
    )
