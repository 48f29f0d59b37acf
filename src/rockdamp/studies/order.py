"""Error against force: dampers that act about the crossing, beside restitution under earthquakes.

Three families tend to restitution (docs/theory.md): ECD of a growing order, and bands of fixed time
(BAND) and of fixed length (CQD) that narrow. The nearer a damper comes, the larger its force at the
crossing. Beside them stands CR itself with e or the loss a little off, at half the step, and with e
applied at the end of the step. Nothing is fitted.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from rockdamp.arrays import Quantity
from rockdamp.config import Config, Order
from rockdamp.constants import REFERENCE
from rockdamp.histories.respond import damper_coordinates
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.catalogue import load_record
from rockdamp.progress import track
from rockdamp.solvers.coefficient import damping_coefficient
from rockdamp.statistics.fragility import resample
from rockdamp.statistics.paired import BOUND, HISTORIES, compare_pairs
from rockdamp.studies.decays import damped_decays, step_count
from rockdamp.studies.runner import Case, chunk_names, pair, run, study_walls, unstack, use

RELEASE = 0.5  # u/u_ins, from which the wall comes to the crossing whose force is compared


class Variation(NamedTuple):
    """CR after a small change: the family and the parameter take the place of a damper's."""

    family: str
    parameter: float
    restitution: float
    step: float
    scheme: str = "newmark"


def make_dampers(section: Order, e: Quantity) -> dict[str, Damping]:
    """Return the dampers that stand for e without a fit, by name.

    Parameters
    ----------
    section : Order
        The study's part of the config.
    e : float or ndarray
        Coefficient of restitution. [-]
    """
    make = Damping.from_restitution
    dampers = {}
    for order in section.order:
        dampers[f"ECD{order:g}" if order else "ECD"] = make(e, "ECD", order=order)
    for width in section.band_width[::-1]:
        dampers[f"BAND{width:g}"] = make(e, "BAND", width=width)
    for width in section.length_width[::-1]:
        dampers[f"CQD{width:g}"] = make(e, "CQD", width=width)
    return dampers


def vary_restitution(section: Order, e: float) -> dict[str, Variation]:
    """Return CR with small changes of e and of the loss, and CR by other steps, by name.

    Parameters
    ----------
    section : Order
        The study's part of the config.
    e : float
        Coefficient of restitution. [-]
    """
    step = section.step
    variations = {}
    for sign, change in (("-", -section.restitution_change), ("+", section.restitution_change)):
        name = f"e {sign} {section.restitution_change:g}"
        variations[name] = Variation("restitution", change, e + change, step)
    for sign, change in (("-", -section.loss_change), ("+", section.loss_change)):
        # The loss -ln e times 1 + change.
        name = f"loss {sign} {100 * section.loss_change:g} %"
        variations[name] = Variation("loss", change, e ** (1 + change), step)
    variations["half step"] = Variation("step", 0.5, e, step / 2)
    variations["end of step"] = Variation("impact", np.nan, e, step, "paper")
    return variations


def list_cases(section: Order) -> list[Case]:
    """Return CR at each e, and beside it every damper and variation.

    Parameters
    ----------
    section : Order
        The study's part of the config.
    """
    cases = []
    for e in section.restitution:
        cr = Case(f"{REFERENCE}, e = {e:g}", use(Damping(REFERENCE, e)), section.step)
        cases.append(cr)
        for name, damping in make_dampers(section, e).items():
            step = section.step
            if damping.model == "BAND":  # at least eight steps in the band
                step = min(step, float(damping.width) / 4)
            place = {"restitution": e, "damper": name}
            cases.append(Case(f"{name}, e = {e:g}", use(damping), step, cr.name, place))
        for name, variation in vary_restitution(section, e).items():
            cases.append(
                Case(
                    f"{name}, e = {e:g}",
                    use(Damping(REFERENCE, variation.restitution)),
                    variation.step,
                    reference=cr.name,
                    coordinates={"restitution": e, "damper": name},
                    scheme=variation.scheme,
                )
            )
    return cases


def list_ladder_cases(section: Order) -> list[Case]:
    """Return every damper at each e and step of the ladder, the finest first.

    A band has at least two steps in it; otherwise the case has no wall.

    Parameters
    ----------
    section : Order
        The study's part of the config.
    """
    cases = []
    for step in (section.finest_step, *section.ladder):
        for e in section.restitution:
            for name, damping in make_dampers(section, e).items():
                is_too_narrow = damping.model == "BAND" and step > damping.width
                cases.append(
                    Case(
                        f"{name}, e = {e:g}, step = {step:g}",
                        _leave_out if is_too_narrow else use(damping),
                        step,
                        coordinates={"step": step, "restitution": e, "damper": name},
                    )
                )
    return cases


def _leave_out(*wall_and_curve: object) -> None:
    """Return no specimen, whatever the wall."""


def chunk(number: str, config: Config) -> xr.Dataset:
    """Run every wall under one job's part of the records.

    Parameters
    ----------
    number : str
        Number of the job, from 0.
    config : Config
        Records, walls, intensities and the dampers.

    Returns
    -------
    xarray.Dataset
        Histories of `list_cases` from `runner.run`, and for some records ``departure``, the size of
        ln(peak) of each damper at each ``step`` of the ladder less that at the finest step; NaN
        where a wall collapses or the step is not run.
    """
    section = config.order
    walls = study_walls(config)
    motions = [load_record(name) for name in chunk_names(number, config)]
    velocity_ratio = config.earthquakes.velocity_ratio.values()
    tail = config.earthquakes.tail
    tracked = track(motions, f"Dampers, part {number}")
    histories = run(list_cases(section), tracked, walls, velocity_ratio, tail=tail)
    ladder_cases = list_ladder_cases(section)
    ladder_motions = track(motions[:: section.ladder_every], f"Steps, part {number}")
    ladder = run(ladder_cases, ladder_motions, walls, velocity_ratio, tail=tail)
    ladder = ladder.drop_vars(["station", "reference"]).rename(record="ladder_record")
    return histories.assign(departure=find_departure(ladder, ladder_cases))


def find_departure(ladder: xr.Dataset, cases: Sequence[Case]) -> xr.DataArray:
    """Return the size of ln(peak) at each step less that at the finest step. [-]

    Parameters
    ----------
    ladder : xarray.Dataset
        Histories of the ladder's cases.
    cases : sequence of Case
        Cases of the ladder, the finest step first.
    """
    grid = unstack(ladder, cases, "step", "restitution", "damper")
    finest = grid.isel(step=0, drop=True)
    coarser = grid.isel(step=slice(1, None))
    survived = (coarser["collapsed"] == 0) & (finest["collapsed"] == 0)
    ratio = coarser["peak"] / finest["peak"]
    return abs(xr.apply_ufunc(np.log, ratio)).where(survived)


# --- comparison -----------------------------------------------------------------------------------


def compare(config: Config, chunks: Sequence[xr.Dataset]) -> xr.Dataset:
    """Compare every damper and variation with CR over all records, walls and intensities.

    The ratio of a peak to the peak under CR is taken where neither wall collapses and the peak
    under CR lies within the bands of the comparison. Intervals come from the paired bootstrap over
    stations.

    Parameters
    ----------
    config : Config
        Dampers, bands and the bootstrap.
    chunks : sequence of xarray.Dataset
        Histories from `chunk`, in the order of the records.
    """
    section = config.order
    bands = config.comparison.bands
    bootstrap = config.comparison.bootstrap
    histories = xr.concat([part[["peak", "collapsed"]] for part in chunks], "record", join="exact")
    departure = xr.concat([part["departure"] for part in chunks], "ladder_record", join="exact")
    pairs = pair(histories)
    weights = resample(pairs["station"].values, bootstrap.replicates, bootstrap.seed)
    whole_band = [(bands[0], bands[-1])]
    statistics = compare_pairs(pairs, weights, whole_band, "Dampers beside restitution")
    statistics = statistics.isel(band=0).assign_coords(case=pairs["case"].values)
    statistics = statistics.drop_vars(["median_ratio", "median_ratio_interval", "pairs"])
    grid = unstack(statistics, list_cases(section), "restitution", "damper")
    grid = grid.transpose("damper", "restitution", ...)
    grid = grid.merge(
        {"largest_step": find_largest_step(departure), "crossing_force": crossing_force(config)},
        join="left",
    )
    grid = grid.merge(crossing_decays(config), join="exact")
    return grid.assign(
        records=pairs.sizes["record"], stations=np.unique(pairs["station"]).size
    ).assign_coords({**_family_coordinates(section), "bound": list(BOUND)})


def _family_coordinates(section: Order) -> dict[str, tuple[str, list[str] | list[float]]]:
    """Return family and parameter along ``damper``: those of dampers, then those of variations."""
    dampers = damper_coordinates(list(make_dampers(section, 1.0).values()), "damper")
    variations = vary_restitution(section, 1.0).values()
    families = [*dampers["damper_family"][1], *(variation.family for variation in variations)]
    parameters = dampers["damper_parameter"][1]
    parameters = [*parameters, *(variation.parameter for variation in variations)]
    return {"damper_family": ("damper", families), "damper_parameter": ("damper", parameters)}


def find_largest_step(departure: xr.DataArray, converged: float = 0.005) -> xr.DataArray:
    """Return the largest step at which nine in ten peaks hardly depart; NaN if there is none. [-]

    Parameters
    ----------
    departure : xarray.DataArray
        Departures of ln(peak) from `chunk`.
    converged : float
        Departure up to which a peak counts as converged. [-]
    """
    histories = ["ladder_record", *HISTORIES[1:]]
    is_run = departure.notnull().any(histories)
    # A step without any history counts as not converged.
    quantile = departure.where(is_run, 1.0).quantile(0.9, histories).drop_vars("quantile")
    return quantile["step"].where(quantile <= converged).max("step")


def crossing_force(config: Config) -> xr.DataArray:
    """Return C v/F0 at u = 0 after a release, of the paper's curve and of each wall. [-]

    The speed sqrt(2 e V) is the geometric mean of those before and after an impact. CR has no
    force.

    Parameters
    ----------
    config : Config
        Curve of the paper, walls and dampers.
    """
    e = np.array(config.order.restitution)
    curves = {"paper": config.curve.make()}
    curves |= {name: curve for name, (_, curve) in study_walls(config).items()}
    dampers = make_dampers(config.order, e)
    force = np.empty((len(dampers), e.size, len(curves)))
    for column, curve in enumerate(curves.values()):
        speed = np.sqrt(2 * e * curve.energy(RELEASE))
        for row, damping in enumerate(dampers.values()):
            force[row, :, column] = damping_coefficient(curve, damping, 0.0, speed) * speed
    coords = {"damper": list(dampers), "restitution": e, "wall": list(curves)}
    return xr.DataArray(force, coords)


def crossing_decays(config: Config) -> xr.Dataset:
    """Return decays on the paper's curve, under CR and the dampers that `fig_order` shows.

    Parameters
    ----------
    config : Config
        Curve of the paper, its e, and the solver's step.
    """
    e = float(config.damping_force.restitution)
    step = config.solver.step
    dampers = make_dampers(config.order, e)
    shown_dampers = {name: dampers[name] for name in ("ECD16", "BAND0.4", "BAND0.2")}
    steps = step_count(config.matching.response_length, step)
    decays = damped_decays(
        config.curve.make(),
        {REFERENCE: Damping(REFERENCE, e), **shown_dampers},
        RELEASE,
        step=step,
        steps=steps,
    )
    return decays.rename(damping_model="crossing_damper").assign_coords(crossing_restitution=e)
