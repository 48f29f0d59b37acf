"""Error against force: dampers that act about the crossing, beside restitution under earthquakes.

Three families tend to restitution (docs/theory.md): ECD of a growing order, and bands of fixed time (BAND) and of fixed
length (CQD) that narrow. The nearer a damper comes, the larger its force at the crossing. Beside them stands CR itself
with e or the loss a little off, at half the step, and with e applied at the end of the step. Nothing is fitted.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from rockdamp.arrays import Quantity
from rockdamp.config import Config, Order
from rockdamp.constants import REFERENCE
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.catalogue import load_record, record_names
from rockdamp.progress import track
from rockdamp.solvers.newmark import simulate
from rockdamp.statistics.fragility import resample
from rockdamp.statistics.paired import BOUND, compare_pairs
from rockdamp.studies.runner import Case, pair, run, unstack, use

CONVERGED = 0.005  # the 90 % quantile of |ln r| to the finest step, at most, for `largest_step`
CROSSING_RELEASE = 0.5  # u/u_ins: the crossing whose force is compared follows a release from here


class Damper(NamedTuple):
    """A damper of the study: what makes it from e, the steps that it is run at [w1 h], and the scheme of the march."""

    make: Callable[[Quantity], Damping]
    step: float
    longest_step: float = 0.0  # of the ladder; CR is not tried on it
    scheme: str = "newmark"


def dampers(section: Order) -> dict[str, Damper]:
    """Return the dampers that need no fit. A band of fixed time has at least eight steps in it."""

    def exact(model: str, **parameter: float) -> Callable[[Quantity], Damping]:
        return lambda e: Damping.from_restitution(e, model, **parameter)

    step, longest = section.step, section.ladder[-1]
    return {
        **{f"ECD{m:g}" if m else "ECD": Damper(exact("ECD", order=m), step, longest) for m in section.order},
        **{f"BAND{w:g}": Damper(exact("BAND", width=w), min(step, w / 4), w) for w in section.band_width[::-1]},
        **{f"CQD{w:g}": Damper(exact("CQD", width=w), step, longest) for w in section.length_width[::-1]},
    }


def variations(section: Order) -> dict[str, Damper]:
    """Return CR with small changes of e and of the loss, and CR by other steps."""
    step, change, loss = section.step, section.restitution_change, section.loss_change
    return {
        f"e - {change:g}": Damper(lambda e: Damping("CR", e - change), step),
        f"e + {change:g}": Damper(lambda e: Damping("CR", e + change), step),
        f"loss - {100 * loss:g} %": Damper(lambda e: Damping("CR", e ** (1 - loss)), step),
        f"loss + {100 * loss:g} %": Damper(lambda e: Damping("CR", e ** (1 + loss)), step),
        "half step": Damper(lambda e: Damping("CR", e), step / 2),
        "end of step": Damper(lambda e: Damping("CR", e), step, scheme="paper"),
    }


def cases(section: Order) -> list[Case]:
    """Return CR at each e, and beside it every damper and variation."""
    cr = Damper(lambda e: Damping("CR", e), section.step)
    return [
        Case(
            f"{name}, e = {e:g}",
            use(damper.make(e)),
            damper.step,
            "" if damper is cr else f"{REFERENCE}, e = {e:g}",
            scheme=damper.scheme,
        )
        for e in section.restitution
        for name, damper in {REFERENCE: cr, **dampers(section), **variations(section)}.items()
    ]


def ladder_cases(section: Order, step: float) -> list[Case]:
    """Return every damper at each e at a step of the ladder; one that has a shorter longest step is not run."""
    return [
        Case(f"{name}, e = {e:g}", use(damper.make(e)) if step <= damper.longest_step else lambda *_: None, step)
        for e in section.restitution
        for name, damper in dampers(section).items()
    ]


def chunk(number: str, config: Config) -> xr.Dataset:
    """Run every wall under one job's part of the records.

    Returns what `runner.run` does of `cases`, and for some records ``departure``, the size of ln(peak) of each damper
    at each ``step`` of the ladder less that at the finest step, by ``ladder_case``; NaN where a wall collapses or the
    step is not run.
    """
    quakes, section = config.earthquakes, config.order
    names = record_names(config.records)[int(number) * quakes.chunk : (int(number) + 1) * quakes.chunk]
    motions, label = [load_record(name) for name in names], f"Dampers, records {int(number) * quakes.chunk + 1} on"
    walls, ratio = {named.name: (named.wall, named.curve) for named in quakes.walls}, quakes.velocity_ratio.values()
    histories = run(cases(section), track(motions, label), walls, ratio, tail=quakes.tail)
    finest, *ladder = (
        run(ladder_cases(section, step), motions[:: section.ladder_every], walls, ratio, tail=quakes.tail)
        for step in track([section.finest_step, *section.ladder], f"{label}, steps")
    )
    departures = []
    for one in ladder:
        stand = (one["collapsed"] == 0) & (finest["collapsed"] == 0)
        departures.append(abs(xr.apply_ufunc(np.log, one["peak"] / finest["peak"])).where(stand))
    departure = xr.concat(departures, xr.Variable("step", section.ladder), join="exact")
    departure = departure.drop_vars(["station", "reference"]).rename(record="ladder_record", case="ladder_case")
    return histories.assign(departure=departure)


# --- comparison -------------------------------------------------------------------------------------------------------


def compare(config: Config, chunks: Sequence[xr.Dataset]) -> xr.Dataset:
    """Compare every damper and variation with CR over all records, walls and intensities.

    A ratio r is of the peak over that under CR, where neither wall collapses and the peak under CR lies within the
    bands of the comparison. Intervals come from the paired bootstrap over stations.
    """
    bootstrap, bands, section = config.comparison.bootstrap, config.comparison.bands, config.order
    pairs = pair(xr.concat([part.drop_dims("ladder_record") for part in chunks], "record", join="exact"))
    departure = xr.concat([part[["departure"]] for part in chunks], "ladder_record", join="exact")
    weights = resample(pairs["station"].values, bootstrap.replicates, bootstrap.seed)
    statistics = compare_pairs(pairs, weights, [(bands[0], bands[-1])], "Dampers beside restitution").isel(band=0)
    statistics = statistics.drop_vars(["median_ratio", "median_ratio_interval", "pairs"])
    e, studied = section.restitution, list(dampers(section))
    ladder = unstack(departure.rename(ladder_case="case"), restitution=e, damper=studied)
    forces = {"largest_step": _largest_step(ladder["departure"]), "crossing_force": _crossing_force(config)}
    return (
        unstack(statistics, restitution=e, damper=[*studied, *variations(section)])
        .transpose("damper", "restitution", ...)
        .merge(forces, join="left")
        .merge(_crossing(config), join="exact")
        .assign(records=pairs.sizes["record"], stations=np.unique(pairs["station"]).size)
        .assign_coords(bound=list(BOUND))
    )


def _largest_step(departure: xr.DataArray) -> xr.DataArray:
    """Return the largest step of the ladder that is converged, by damper and e; NaN of none."""
    dims = ["ladder_record", "velocity_ratio", "wall"]
    ran = departure.notnull().any(dims)
    quantile = departure.where(ran, 2 * CONVERGED).quantile(0.9, dims).drop_vars("quantile")
    steps = quantile["step"].where(quantile <= CONVERGED)
    return steps.max("step")


# --- at the crossing --------------------------------------------------------------------------------------------------


def _crossing_force(config: Config) -> xr.DataArray:
    """Return C v/F0 at u = 0 after a release from `CROSSING_RELEASE`, of the paper's curve and of each wall.

    The speed is that between those before and after an impact, sqrt(2 e V). CR itself has no force.
    """
    e = np.array(config.order.restitution)
    curves = {"paper": config.curve.make(), **{named.name: named.curve for named in config.earthquakes.walls}}
    studied = dampers(config.order)
    force = np.full((len(studied), e.size, len(curves)), np.nan)
    for column, curve in enumerate(curves.values()):
        speed = np.sqrt(2 * e * curve.energy(CROSSING_RELEASE))
        for row, damper in enumerate(studied.values()):
            force[row, :, column] = damper.make(e).coefficient(curve, 0.0, speed) * speed
    return xr.DataArray(
        force,
        dims=("damper", "restitution", "wall"),
        coords={"damper": list(studied), "restitution": e, "wall": list(curves)},
    )


def _crossing(config: Config) -> xr.Dataset:
    """Return histories of a decay on the paper's curve, under CR and the dampers that `fig_order` shows."""
    e, step, curve = float(config.damping_force.restitution), config.solver.step, config.curve.make()
    steps = round(config.matching.response_length / step)
    drawn_dampers = {REFERENCE: Damping("CR", e)}
    drawn_dampers |= {name: dampers(config.order)[name].make(e) for name in ("ECD16", "BAND0.4", "BAND0.2")}
    decays = []
    for name, damping in drawn_dampers.items():
        run = simulate(curve, damping, release_amplitude=CROSSING_RELEASE, step=step, steps=steps)
        force = damping.coefficient(curve, run.displacement, run.velocity) * run.velocity
        force = np.full(steps + 1, np.nan) if name == REFERENCE else force
        decays.append((run.displacement, run.velocity, force))
    names = ("shown_displacement", "shown_velocity", "shown_damping_force")
    return xr.Dataset(
        {name: (("shown_damper", "tau"), values) for name, values in zip(names, np.stack(decays, axis=1), strict=True)},
        coords={"shown_damper": list(drawn_dampers), "tau": step * np.arange(steps + 1), "shown_restitution": e},
    )
