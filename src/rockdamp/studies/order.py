"""Error against force: dampers that act about the crossing, beside restitution under earthquakes.

Three families tend to restitution (docs/theory.md): ECD of a growing order, and bands of fixed time (BAND) and of fixed
length (CQD) that narrow. The nearer a damper comes, the larger its force at the crossing. Beside them stands CR itself
with e or the loss a little off, at half the step, and with e applied at the end of the step. Nothing is fitted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.constants import REFERENCE
from rockdamp.histories.loads import run_records
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.progress import track
from rockdamp.solvers.newmark import simulate
from rockdamp.statistics.fragility import interval, resample, weighted_quantile
from rockdamp.statistics.paired import BOUND, quotient, root_mean_square

LARGE = 0.05  # of |ln r|: the share of the histories beyond it
CONVERGED = 0.005  # the 90 % quantile of |ln r| to the finest step, at most, for `largest_step`
HISTORIES = ("record", "velocity_ratio", "wall", "restitution")
CROSSING_RELEASE = 0.5  # u/u_ins: the crossing whose force is compared follows a release from here


@dataclass(frozen=True)
class Case:
    """One damper at each e of the study, with the steps that it is run at [w1 h] and the scheme of the march."""

    name: str
    damping: Damping
    step: float
    longest_step: float = math.inf
    scheme: str = "newmark"


def damper_cases(config: Config) -> list[Case]:
    """Return the dampers that need no fit. A band of fixed time has at least eight steps in it."""
    section = config.order
    e, step = np.array(section.restitution), section.step

    def damping(model: str, **parameter: float) -> Damping:
        return Damping.from_restitution(e, model, **parameter)

    return [
        *(Case(f"ECD{m:g}" if m else "ECD", damping("ECD", order=m), step) for m in section.order),
        *(Case(f"BAND{w:g}", damping("BAND", width=w), min(step, w / 4), w) for w in section.band_width[::-1]),
        *(Case(f"CQD{w:g}", damping("CQD", width=w), step) for w in section.length_width[::-1]),
    ]


def variation_cases(config: Config) -> list[Case]:
    """Return CR with small changes of e and of the loss, and CR by other steps."""
    section = config.order
    e, step = np.array(section.restitution), section.step
    change, loss = section.restitution_change, section.loss_change
    changed = {
        f"e - {change:g}": e - change,
        f"e + {change:g}": e + change,
        f"loss - {100 * loss:g} %": e ** (1 - loss),
        f"loss + {100 * loss:g} %": e ** (1 + loss),
    }
    return [
        *(Case(name, Damping("CR", other), step) for name, other in changed.items()),
        Case("half step", Damping("CR", e), step / 2),
        Case("end of step", Damping("CR", e), step, scheme="paper"),
    ]


# --- histories --------------------------------------------------------------------------------------------------------


def chunk(number: str, config: Config) -> xr.Dataset:
    """Run every wall under one job's part of the records, with CR, its variations and every damper.

    Returns ``peak`` and ``collapsed`` over ``damper`` and `HISTORIES`, ``reference_peak`` and ``reference_collapsed``
    over `HISTORIES`, and for some records ``departure``, the size of ln(peak) at each step less that at the finest
    step, over ``damper``, ``step`` and `HISTORIES`; NaN where a wall collapses or the step is not run.
    """
    size, section = config.earthquakes.chunk, config.order
    entries = catalogue.record_names(config.records)[int(number) * size : (int(number) + 1) * size]
    motions = [catalogue.load_record(entry) for entry in entries]
    reference = _run(Case(REFERENCE, Damping("CR", section.restitution), section.step), config, motions)
    dampers = damper_cases(config)
    cases = [*dampers, *variation_cases(config)]
    label = f"Dampers, records {int(number) * size + 1} on"
    runs = xr.concat([_run(case, config, motions) for case in track(cases, label)], "damper", join="exact")
    fewer = [_departures(case, config, motions[:: section.ladder_every]) for case in track(dampers, f"{label}, steps")]
    departure = xr.concat(fewer, "damper", join="exact").rename(record="ladder_record")
    names = [case.name for case in cases]
    return (
        runs.assign({f"reference_{name}": reference[name] for name in reference})
        .assign_coords(damper=names)
        .assign(departure=departure.assign_coords(damper=names[: len(dampers)]).reindex(damper=names))
    )


def _run(case: Case, config: Config, motions: Sequence[GroundMotion], step: float | None = None) -> xr.Dataset:
    """Return peaks and outcomes of one case over `HISTORIES`."""
    quakes = config.earthquakes
    runs = run_records(
        motions,
        {named.name: (named.wall, named.curve) for named in quakes.walls},
        case.damping,
        quakes.velocity_ratio.values(),
        step=case.step if step is None else step,
        tail=quakes.tail,
        dim="restitution",
        scheme=case.scheme,
    )
    return runs.assign_coords(restitution=config.order.restitution)


def _departures(case: Case, config: Config, motions: Sequence[GroundMotion]) -> xr.DataArray:
    """Return how far the peaks of one case depart from those at the finest step."""
    section = config.order
    finest = _run(case, config, motions, section.finest_step)
    rows = []
    for step in section.ladder:
        if step > case.longest_step:
            rows.append(xr.full_like(finest["peak"], np.nan))
            continue
        runs = _run(case, config, motions, step)
        stand = (runs["collapsed"] == 0) & (finest["collapsed"] == 0)
        logarithm = xr.apply_ufunc(np.log, runs["peak"] / finest["peak"])
        rows.append(abs(logarithm).where(stand))
    return xr.concat(rows, "step", join="exact").assign_coords(step=section.ladder)


# --- comparison -------------------------------------------------------------------------------------------------------


def compare(config: Config, chunks: Sequence[xr.Dataset]) -> xr.Dataset:
    """Compare every damper and variation with CR over all records, walls and intensities.

    A ratio r is of the peak over that under CR, where neither wall collapses and the peak under CR lies within the
    bands of the comparison. Intervals come from the paired bootstrap over stations.
    """
    bootstrap, bands = config.comparison.bootstrap, config.comparison.bands
    histories = xr.concat(
        [part.drop_dims("ladder_record") for part in chunks], "record", join="exact", data_vars="minimal"
    )
    departure = xr.concat([part["departure"] for part in chunks], "ladder_record", join="exact")
    weights = resample(histories["station"].values, bootstrap.replicates, bootstrap.seed)
    reference, fell = (histories[f"reference_{name}"] for name in ("peak", "collapsed"))
    dims = ("damper", "restitution")
    histories = histories.assign(inside=(fell == 0) & (reference >= bands[0]) & (reference < bands[-1]))
    cells = [
        [_statistics(histories.isel(damper=row, restitution=at), weights) for at in range(histories.sizes[dims[1]])]
        for row in track(range(histories.sizes[dims[0]]), "Dampers beside restitution")
    ]
    measures = {
        name: ((*dims, "bound")[: values.ndim], values)
        for name in cells[0][0]
        for values in [np.array([[cell[name] for cell in row] for row in cells])]
    }
    compared = xr.Dataset(
        {**measures, "largest_step": (dims, _largest_step(departure)), "crossing_force": _crossing_force(config)},
        coords={name: histories[name].values for name in dims} | {"bound": list(BOUND)},
    )
    counts = {"records": histories.sizes["record"], "stations": np.unique(histories["station"]).size}
    return compared.merge(_crossing(config), join="exact").assign(counts)


def _statistics(histories: xr.Dataset, weights: Array) -> dict[str, Any]:
    """Return each measure of one damper at one e, and its interval; histories (record, velocity_ratio, wall)."""
    reference, fell, peak, falls = (
        histories[name].values for name in ("reference_peak", "reference_collapsed", "peak", "collapsed")
    )
    drawn = np.concatenate([np.ones((1, len(peak))), weights])  # the first replicate is the sample itself
    stand = histories["inside"].values & (falls == 0)
    record = np.broadcast_to(np.arange(len(peak))[:, None, None], peak.shape)[stand]
    size = np.abs(np.log(peak[stand] / reference[stand]))

    def total(values: Array) -> Array:
        return drawn @ np.bincount(record, values, len(peak))

    def rate(wrong: NDArray[np.bool_], cases: NDArray[np.bool_]) -> Array:
        return np.asarray(quotient(*(drawn @ count.sum(axis=(1, 2)) for count in (wrong & cases, cases))))

    count = total(np.ones(size.size))
    values = {
        "log_error_median": weighted_quantile(size, record, drawn, 0.5),
        "log_error_90": weighted_quantile(size, record, drawn, 0.9),
        "share_above": quotient(total((size > LARGE).astype(float)), count),
        "missed_collapse_rate": rate(falls == 0, fell == 1),
        "added_collapse_rate": rate(falls == 1, fell == 0),
        "log_error": root_mean_square(total(size**2), count),
    }
    intervals = {f"{name}_interval": interval(replicates[1:]) for name, replicates in values.items()}
    return {name: replicates[0] for name, replicates in values.items()} | intervals


def _largest_step(departure: xr.DataArray) -> Array:
    """Return the largest step of the ladder that is converged, shape (damper, restitution); NaN of none."""
    dims = ["ladder_record", "velocity_ratio", "wall"]
    ran = departure.notnull().any(dims)
    quantile = departure.where(ran, 2 * CONVERGED).quantile(0.9, dims)
    steps = quantile["step"].where(quantile <= CONVERGED)
    return steps.max("step").transpose("damper", "restitution").values


# --- at the crossing --------------------------------------------------------------------------------------------------


def _crossing_force(config: Config) -> xr.DataArray:
    """Return C v/F0 at u = 0 after a release from `CROSSING_RELEASE`, of the paper's curve and of each wall.

    The speed is that between those before and after an impact, sqrt(2 e V). CR itself has no force.
    """
    e = np.array(config.order.restitution)
    curves = {"paper": config.curve.make(), **{named.name: named.curve for named in config.earthquakes.walls}}
    cases = damper_cases(config)
    force = np.full((len(cases), e.size, len(curves)), np.nan)
    for column, curve in enumerate(curves.values()):
        speed = np.sqrt(2 * e * curve.energy(CROSSING_RELEASE))
        for row, case in enumerate(cases):
            force[row, :, column] = case.damping.coefficient(curve, 0.0, speed) * speed
    return xr.DataArray(
        force,
        dims=("damper", "restitution", "wall"),
        coords={"damper": [case.name for case in cases], "restitution": e, "wall": list(curves)},
    )


def _crossing(config: Config) -> xr.Dataset:
    """Return histories of a decay on the paper's curve, under CR and the dampers that `fig_order` shows."""
    e, step, curve = config.damping_force.restitution, config.solver.step, config.curve.make()
    steps = round(config.matching.response_length / step)
    shown = {
        REFERENCE: Damping("CR", e),
        "ECD16": Damping.from_restitution(e, "ECD", order=16.0),
        "BAND0.4": Damping.from_restitution(e, "BAND", width=0.4),
        "BAND0.2": Damping.from_restitution(e, "BAND", width=0.2),
    }
    runs = [
        simulate(curve, damping, release_amplitude=CROSSING_RELEASE, step=step, steps=steps)
        for damping in shown.values()
    ]
    force = [
        np.full(steps + 1, np.nan)
        if name == REFERENCE
        else damping.coefficient(curve, run.displacement, run.velocity) * run.velocity
        for (name, damping), run in zip(shown.items(), runs, strict=True)
    ]
    dims = ("shown_damper", "tau")
    return xr.Dataset(
        {
            "shown_displacement": (dims, np.stack([run.displacement for run in runs])),
            "shown_velocity": (dims, np.stack([run.velocity for run in runs])),
            "shown_damping_force": (dims, np.stack(force)),
        },
        coords={"shown_damper": list(shown), "tau": step * np.arange(steps + 1), "shown_restitution": float(e)},
    )
