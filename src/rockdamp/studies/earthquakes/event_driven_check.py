"""Peaks of the study of earthquakes against the event-driven solver, on a random sample of its histories."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import xarray as xr

from rockdamp.config.parsing import Config
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.motions.records import followed_by_rest
from rockdamp.progress import track
from rockdamp.solvers.event_driven import history
from rockdamp.solvers.newmark import available_threads
from rockdamp.solvers.response import OUTCOMES
from rockdamp.studies.earthquakes.incremental import BY_DAMPER, make_wall


def check(config: Config, natural: xr.Dataset) -> xr.Dataset:
    """Solve a random sample of the histories again, event by event.

    Parameters
    ----------
    config : dict
        Validated; uses ``records`` and ``natural``.
    natural : xarray.Dataset
        Of `natural.gather`.

    Returns
    -------
    xarray.Dataset
        ``exact_peak`` and ``exact_collapsed`` (history) beside the study's own, its bound of the error, and what each
        history is of.
    """
    section = config["natural"]["check"]
    rng = np.random.default_rng(int(section["seed"]))
    run = np.argwhere(natural["collapsed"].transpose(*BY_DAMPER).values >= 0)
    chosen = run[np.sort(rng.choice(len(run), min(int(section["histories"]), len(run)), replace=False))]
    picked = natural.isel({dim: xr.DataArray(chosen[:, i], dims="history") for i, dim in enumerate(BY_DAMPER)})
    walls = {entry["name"]: entry for entry in config["natural"]["walls"]}
    entries = {entry.name: entry for entry in catalogue.listing(config["records"])}
    motions = {name: catalogue.read(entries[name]) for name in np.unique(picked["record"].values).tolist()}

    def solve(index: int) -> tuple[float, bool]:
        one = picked.isel(history=index)
        return exact_peak(one, motions[str(one["record"].values)], walls[str(one["wall"].values)], config)

    with ThreadPoolExecutor(available_threads()) as pool:
        found = list(track(pool.map(solve, range(len(chosen))), "Histories, event by event", len(chosen)))
    kept = ["peak_displacement", "peak_displacement_uncertainty", "collapsed", "settled"]
    return (
        picked[kept]
        .reset_coords(list(BY_DAMPER))
        .drop_vars(["record_set", "station"])
        .assign(
            exact_peak=("history", [peak for peak, _ in found]),
            exact_collapsed=("history", np.array([collapsed for _, collapsed in found], dtype=np.int8)),
        )
        .assign_coords(history=np.arange(len(chosen)))
    )


def exact_peak(one: xr.Dataset, motion: catalogue.GroundMotion, section: Config, config: Config) -> tuple[float, bool]:
    """Peak of one history, and whether it collapses, by `exact.history`."""
    wall, curve = make_wall(section)
    p, record = float(wall.frequency_parameter), motion.record
    model, ratio = str(one["damping_model"].values), float(one["damping_ratio"])
    damping = Damping.of(model, restitution=float(one["restitution"]), damping_ratio=ratio)
    ground = followed_by_rest(record.ground_acceleration, record.step, float(config["natural"]["tail"]))
    load: Any = float(wall.load_factor) * float(one["scale_factor"]) * ground
    step = p * record.step
    solved = history(curve, damping, [step * (ground.size - 1)], load=load, load_step=step)
    extremes = np.abs([*solved.turning_displacement, *solved.displacement])
    return float(np.nanmax(extremes, initial=0.0)), solved.outcome == OUTCOMES[1]
