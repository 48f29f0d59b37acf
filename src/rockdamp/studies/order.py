"""Error against force: dampers that act about the crossing, beside restitution under earthquakes.

Three families tend to restitution (docs/theory.md): ECD of a growing order, and bands of fixed time (BAND) and of fixed
length (CQD) that narrow. The nearer a damper comes, the larger its force at the crossing. Beside them stands CR itself
with e or the loss a little off, at half the step, and with e applied at the end of the step. Nothing is fitted.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from rockdamp.arrays import Quantity
from rockdamp.config import Config, Order
from rockdamp.constants import REFERENCE
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.catalogue import load_record
from rockdamp.progress import track
from rockdamp.solvers.coefficient import damping_coefficient
from rockdamp.statistics.fragility import resample
from rockdamp.statistics.paired import BOUND, HISTORIES, compare_pairs
from rockdamp.studies.decays import damped_decays, step_count
from rockdamp.studies.runner import Case, chunk_names, pair, run, study_walls, unstack, use

RELEASE = 0.5  # u/u_ins, from which the wall comes to the crossing whose force is compared


def dampers(section: Order, e: Quantity) -> dict[str, Damping]:
    """Return the dampers that stand for e without a fit, by name."""
    make = Damping.from_restitution
    return {
        **{f"ECD{m:g}" if m else "ECD": make(e, "ECD", order=m) for m in section.order},
        **{f"BAND{w:g}": make(e, "BAND", width=w) for w in section.band_width[::-1]},
        **{f"CQD{w:g}": make(e, "CQD", width=w) for w in section.length_width[::-1]},
    }


def variations(section: Order, e: float) -> dict[str, tuple[float, float, str]]:
    """Return CR with small changes of e and of the loss, and CR by other steps: its e, step and scheme, by name."""
    step, change, loss = section.step, section.restitution_change, section.loss_change
    return {
        f"e - {change:g}": (e - change, step, "newmark"),
        f"e + {change:g}": (e + change, step, "newmark"),
        f"loss - {100 * loss:g} %": (e ** (1 - loss), step, "newmark"),
        f"loss + {100 * loss:g} %": (e ** (1 + loss), step, "newmark"),
        "half step": (e, step / 2, "newmark"),
        "end of step": (e, step, "paper"),
    }


def cases(section: Order) -> list[Case]:
    """Return CR at each e, and beside it every damper and variation. A band has at least eight steps in it."""
    listed = []
    for e in section.restitution:
        at, cr, usual = f"e = {e:g}", f"{REFERENCE}, e = {e:g}", section.step
        listed.append(Case(cr, use(Damping(REFERENCE, e)), usual))
        for name, damping in dampers(section, e).items():
            step = min(usual, float(damping.width) / 4) if damping.model == "BAND" else usual
            listed.append(Case(f"{name}, {at}", use(damping), step, cr))
        for name, (changed, step, scheme) in variations(section, e).items():
            listed.append(
                Case(f"{name}, {at}", use(Damping(REFERENCE, changed)), step, cr, scheme=scheme)
            )
    return listed


def ladder_cases(section: Order) -> list[Case]:
    """Return every damper at each e and step of the ladder, the finest first. A band has at least two steps in it."""
    return [
        Case(
            f"{name}, e = {e:g}, step = {step:g}",
            (lambda *_: None) if damping.model == "BAND" and step > damping.width else use(damping),
            step,
        )
        for step in (section.finest_step, *section.ladder)
        for e in section.restitution
        for name, damping in dampers(section, e).items()
    ]


def chunk(number: str, config: Config) -> xr.Dataset:
    """Run every wall under one job's part of the records.

    Returns what `runner.run` does of `cases`, and for some records ``departure``, the size of ln(peak) of each damper
    at each ``step`` of the ladder less that at the finest step; NaN where a wall collapses or the step is not run.
    """
    quakes, section, walls = config.earthquakes, config.order, study_walls(config)
    motions, ratio = (
        [load_record(name) for name in chunk_names(number, config)],
        quakes.velocity_ratio.values(),
    )
    histories = run(
        cases(section), track(motions, f"Dampers, part {number}"), walls, ratio, tail=quakes.tail
    )
    few = track(motions[:: section.ladder_every], f"Steps, part {number}")
    ladder = unstack(
        run(ladder_cases(section), few, walls, ratio, tail=quakes.tail).drop_vars(
            ["station", "reference"]
        ),
        step=[section.finest_step, *section.ladder],
        restitution=section.restitution,
        damper=dampers(section, 1.0),
    ).rename(record="ladder_record")
    finest, ladder = ladder.isel(step=0, drop=True), ladder.isel(step=slice(1, None))
    survived = (ladder["collapsed"] == 0) & (finest["collapsed"] == 0)
    return histories.assign(
        departure=abs(xr.apply_ufunc(np.log, ladder["peak"] / finest["peak"])).where(survived)
    )


# --- comparison -------------------------------------------------------------------------------------------------------


def compare(config: Config, chunks: Sequence[xr.Dataset]) -> xr.Dataset:
    """Compare every damper and variation with CR over all records, walls and intensities.

    A ratio r is of the peak over that under CR, where neither wall collapses and the peak under CR lies within the
    bands of the comparison. Intervals come from the paired bootstrap over stations.
    """
    bootstrap, bands, section = config.comparison.bootstrap, config.comparison.bands, config.order
    pairs = pair(
        xr.concat([part[["peak", "collapsed"]] for part in chunks], "record", join="exact")
    )
    departure = xr.concat([part["departure"] for part in chunks], "ladder_record", join="exact")
    weights = resample(pairs["station"].values, bootstrap.replicates, bootstrap.seed)
    statistics = compare_pairs(
        pairs, weights, [(bands[0], bands[-1])], "Dampers beside restitution"
    ).isel(band=0)
    statistics = statistics.drop_vars(["median_ratio", "median_ratio_interval", "pairs"])
    names = [*dampers(section, 1.0), *variations(section, 1.0)]
    return (
        unstack(statistics, restitution=section.restitution, damper=names)
        .transpose("damper", "restitution", ...)
        .merge(
            {
                "largest_step": find_largest_step(departure),
                "crossing_force": crossing_force(config),
            },
            join="left",
        )
        .merge(crossing_decays(config), join="exact")
        .assign(records=pairs.sizes["record"], stations=np.unique(pairs["station"]).size)
        .assign_coords(bound=list(BOUND))
    )


def find_largest_step(departure: xr.DataArray, converged: float = 0.005) -> xr.DataArray:
    """Return the largest step at which nine in ten peaks depart by no more than `converged`; NaN of none."""
    histories = ["ladder_record", *HISTORIES[1:]]
    ran = departure.notnull().any(histories)
    quantile = departure.where(ran, 1.0).quantile(0.9, histories).drop_vars("quantile")
    return quantile["step"].where(quantile <= converged).max("step")


def crossing_force(config: Config) -> xr.DataArray:
    """Return C v/F0 at u = 0 after a release from `RELEASE`, of the paper's curve and of each wall.

    The speed is that between those before and after an impact, sqrt(2 e V). CR itself has no force.
    """
    e, curves = np.array(config.order.restitution), {"paper": config.curve.make()}
    curves |= {name: curve for name, (_, curve) in study_walls(config).items()}
    speed = {name: np.sqrt(2 * e * curve.energy(RELEASE)) for name, curve in curves.items()}
    studied = dampers(config.order, e)
    force = [
        [damping_coefficient(curves[w], damping, 0.0, v) * v for w, v in speed.items()]
        for damping in studied.values()
    ]
    coords = {"damper": list(studied), "wall": list(curves), "restitution": e}
    return xr.DataArray(force, coords, ["damper", "wall", "restitution"]).transpose(
        "damper", "restitution", "wall"
    )


def crossing_decays(config: Config) -> xr.Dataset:
    """Return decays on the paper's curve, under CR and the dampers that `fig_order` shows."""
    e, step = float(config.damping_force.restitution), config.solver.step
    named = {REFERENCE: Damping(REFERENCE, e), **dampers(config.order, e)}
    shown = {name: named[name] for name in (REFERENCE, "ECD16", "BAND0.4", "BAND0.2")}
    steps = step_count(config.matching.response_length, step)
    decays = damped_decays(config.curve.make(), shown, RELEASE, step=step, steps=steps)
    return decays.rename(damping_model="crossing_damper").assign_coords(crossing_restitution=e)
