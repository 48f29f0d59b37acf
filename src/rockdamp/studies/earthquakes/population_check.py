"""Check the population's peaks by the event-driven solver: its step is longer than the study's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from operator import itemgetter

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.earthquakes import PARAMETERS
from rockdamp.histories.loads import Forcing
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.studies.earthquakes import event_driven_check
from rockdamp.studies.earthquakes.event_driven_check import STRATA, Members, Sample, draw, exact_end, rates, solved
from rockdamp.studies.earthquakes.population import mechanics

HISTORY = ("wall", "record", "intensity", "damping_model")


def check_population(config: Config, walls: xr.Dataset, shares: Sequence[xr.Dataset]) -> xr.Dataset:
    """Solve a stratified sample of the population's histories again, event by event.

    The dataset is that of `check_earthquakes`, without bounds: each history of a population is run at one step.
    """
    section = config.population
    sample = draw([partial(_members, share) for share in shares], section.check.histories, section.check.seed)
    motions = catalogue.load_records(section.records)
    wall, curve = mechanics({name: walls[name].values for name in PARAMETERS})
    first = np.cumsum([0, *(share.sizes["wall"] for share in shares)])
    number = first[sample.part] + sample.place[:, 0]
    e, ratio = walls["restitution"].values, walls["damping_ratio"].values
    intensity, models = shares[0]["intensity"].values, [str(model) for model in shares[0]["damping_model"].values]

    def solve(index: int) -> tuple[float, bool]:
        _, record, level, model = sample.place[index].tolist()
        i = int(number[index])
        motion = motions[record].record
        factor = intensity[level] / intensity_measures(motion).pgv
        damping = Damping.from_values(models[model], restitution=float(e[i]), damping_ratio=float(ratio[i, model]))
        forcing = Forcing.of(wall, motion, factor, rest=section.tail)
        of_wall = replace(forcing, sampling=forcing.sampling[i], load_factor=forcing.load_factor[i])
        return exact_end(curve.map(itemgetter(i)), damping, of_wall)

    of_history = {
        "wall": walls["wall"].values[number],
        "record": np.array([motion.name for motion in motions])[sample.place[:, 1]],
        "intensity": intensity[sample.place[:, 2]],
        "damping_model": np.array(models)[sample.place[:, 3]],
        "peak": _picked(shares, "peak", sample).astype(float),
        "collapsed": _picked(shares, "collapsed", sample),
    }
    checked = xr.Dataset(
        {name: ("history", values) for name, values in of_history.items()}
        | solved(solve, len(sample.place), "Histories of the population, event by event"),
        coords={"history": np.arange(len(sample.place)), "stratum": list(STRATA[: len(sample.study)])},
    )
    return checked.assign(rates(sample, checked))


def _members(share: xr.Dataset) -> Members:
    """Return the strata of one share; without finer steps, nothing is known to be unsettled."""
    peak, collapsed = (share[name].transpose(*HISTORY).values for name in ("peak", "collapsed"))
    of_all = event_driven_check.strata(peak, collapsed, np.ones_like(collapsed), HISTORY.index("intensity"))
    return of_all[: STRATA.index("unsettled")]


def _picked(shares: Sequence[xr.Dataset], name: str, sample: Sample) -> Array:
    """Return a variable of each history of the sample."""
    picked = np.empty(len(sample.place), dtype=shares[0][name].dtype)
    for number, share in enumerate(shares):
        own = sample.part == number
        picked[own] = share[name].transpose(*HISTORY).values[*sample.place[own].T]
    return picked
