"""Peaks of the study of earthquakes against the event-driven solver, on a random sample of its histories."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import xarray as xr

from rockdamp.config import Config
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.motions.records import followed_by_rest
from rockdamp.progress import track
from rockdamp.solvers.event_driven import history
from rockdamp.solvers.newmark import available_threads
from rockdamp.solvers.response import OUTCOMES
from rockdamp.studies.earthquakes.incremental import BY_DAMPER
from rockdamp.studies.earthquakes.settings import EventDrivenCheckSettings
from rockdamp.studies.settings import NamedWall


def check(config: Config, earthquakes: xr.Dataset) -> xr.Dataset:
    """Solve a random sample of the histories again, event by event.

    Parameters
    ----------
    config : dict
        Has the keys of `EventDrivenCheckSettings`.
    earthquakes : xarray.Dataset
        Of `incremental.gather`.

    Returns
    -------
    xarray.Dataset
        ``exact_peak`` and ``exact_collapsed`` (history) beside the study's own, its bound of the error, and what each
        history is of.
    """
    given = EventDrivenCheckSettings.of(config)
    rng = np.random.default_rng(given.seed)
    run = np.argwhere(earthquakes["collapsed"].transpose(*BY_DAMPER).values >= 0)
    chosen = run[np.sort(rng.choice(len(run), min(given.histories, len(run)), replace=False))]
    picked = earthquakes.isel({dim: xr.DataArray(chosen[:, i], dims="history") for i, dim in enumerate(BY_DAMPER)})
    walls = {named.name: named for named in given.walls}
    entries = {entry.name: entry for entry in catalogue.listing(given.records)}
    motions = {name: catalogue.read(entries[name]) for name in np.unique(picked["record"].values).tolist()}

    def solve(index: int) -> tuple[float, bool]:
        case = picked.isel(history=index)
        return exact_peak(case, motions[str(case["record"].values)], walls[str(case["wall"].values)], given.tail)

    with ThreadPoolExecutor(available_threads()) as pool:
        solved = list(track(pool.map(solve, range(len(chosen))), "Histories, event by event", len(chosen)))
    kept = ["peak_displacement", "peak_displacement_uncertainty", "collapsed", "settled"]
    return (
        picked[kept]
        .reset_coords(list(BY_DAMPER))
        .drop_vars(["record_set", "station"])
        .assign(
            exact_peak=("history", [peak for peak, _ in solved]),
            exact_collapsed=("history", np.array([collapsed for _, collapsed in solved], dtype=np.int8)),
        )
        .assign_coords(history=np.arange(len(chosen)))
    )


def exact_peak(case: xr.Dataset, motion: catalogue.GroundMotion, named: NamedWall, tail: float) -> tuple[float, bool]:
    """Peak of one history, and whether it collapses, by `event_driven.history`; `tail` is the rest after the record."""
    wall, record = named.wall, motion.record
    model, e, ratio = str(case["damping_model"].values), float(case["restitution"]), float(case["damping_ratio"])
    ground = followed_by_rest(record.ground_acceleration, record.step, tail)
    load = float(wall.load_factor) * float(case["scale_factor"]) * ground
    step = float(wall.frequency_parameter) * record.step
    damping, end = Damping.of(model, restitution=e, damping_ratio=ratio), step * (ground.size - 1)
    solved = history(named.curve, damping, [end], load=load, load_step=step)
    extremes = np.abs([*solved.turning_displacement, *solved.displacement])
    return float(np.nanmax(extremes, initial=0.0)), solved.outcome == OUTCOMES[1]
