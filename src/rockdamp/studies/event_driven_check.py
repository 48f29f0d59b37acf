"""Check peaks of the study of earthquakes by the event-driven solver, on a stratified sample.

Few histories come near to collapse, where a small difference decides the outcome: a random sample
would hardly hold any. Hence equal numbers are drawn of histories far from collapse, near to it and
at its edge, of those that just collapse, and of those whose outcome depends on the step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config, NamedWall
from rockdamp.constants import REFERENCE
from rockdamp.histories.loads import make_load, sample_load
from rockdamp.histories.refinement import NEAR_COLLAPSE
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.progress import track
from rockdamp.solvers.exact import exact_history
from rockdamp.studies.earthquakes import HISTORY_DIMS

EDGE_OF_COLLAPSE = 0.8  # peak of a survivor, u/u_ins
STRATA = ("far", "near", "edge", "just collapsed", "unconverged")


def check_earthquakes(config: Config, earthquakes: xr.Dataset) -> xr.Dataset:
    """Solve a stratified sample of the histories again, event by event.

    The dataset has ``exact_peak`` and ``exact_collapsed`` beside the peaks of the study and their
    bounds, and for each stratum the share of histories that end otherwise or exceed their bound.
    """
    settings = config.earthquakes.check
    strata = find_strata(earthquakes)
    places, stratum = draw(strata, settings.histories, settings.seed)
    indexers = {
        dim: xr.DataArray(places[:, index], dims="history")
        for index, dim in enumerate(HISTORY_DIMS)
    }
    sample = earthquakes.isel(indexers)
    exact_peaks, exact_collapses = _solve_sample(config, sample)
    names = ["peak", "collapsed", "converged", "peak_uncertainty"]
    checked = sample[names].reset_coords(list(HISTORY_DIMS)).drop_vars("station")
    checked = checked.assign(
        exact_peak=("history", exact_peaks),
        exact_collapsed=("history", exact_collapses),
        history_stratum=("history", np.array(STRATA)[stratum]),
        checked_count=("stratum", np.bincount(stratum, minlength=len(STRATA))),
    )
    coords: dict[str, Any] = {"history": np.arange(len(places)), "stratum": list(STRATA)}
    return checked.assign(rate(stratum, checked)).assign_coords(coords)


def _solve_sample(config: Config, sample: xr.Dataset) -> tuple[Array, NDArray[np.int8]]:
    """Return the peak of each history of a sample, and 1 where it collapses."""
    walls = {wall.name: wall for wall in config.earthquakes.walls}
    sources = {catalogue.motion_name(name): name for name in catalogue.record_names(config.records)}
    motions = {
        name: catalogue.load_record(sources[name])
        for name in np.unique(sample["record"].values).tolist()
    }
    histories = sample[["damping_ratio", "scale_factor"]]
    peaks = []
    collapses = []
    for index in track(range(sample.sizes["history"]), "Histories, event by event"):
        case = histories.isel(history=index)
        motion = motions[str(case["record"].values)]
        named_wall = walls[str(case["wall"].values)]
        peak, is_collapsed = solve_exactly(case, motion, named_wall, config.earthquakes.tail)
        peaks.append(peak)
        collapses.append(is_collapsed)
    return np.array(peaks), np.array(collapses, dtype=np.int8)


def find_strata(earthquakes: xr.Dataset) -> list[NDArray[np.bool_]]:
    """Return the histories of each of `STRATA`, over `HISTORY_DIMS`.

    Parameters
    ----------
    earthquakes : xarray.Dataset
        Peaks and collapses of the study.
    """
    peak = earthquakes["peak"]
    collapsed = earthquakes["collapsed"]
    converged = earthquakes["converged"]
    # CR's histories are the same for every source of a ratio: one of them counts.
    source = earthquakes["damping_ratio_source"]
    is_new = (earthquakes["damping_model"] != REFERENCE) | (source == source[0])
    is_run = (collapsed >= 0) & is_new
    survives = is_run & (converged == 1) & (collapsed == 0)
    collapses = is_run & (converged == 1) & (collapsed == 1)
    collapsed_at_lower = collapsed.shift(velocity_ratio=1, fill_value=0)
    strata = [
        survives & (peak < NEAR_COLLAPSE),
        survives & (peak >= NEAR_COLLAPSE) & (peak < EDGE_OF_COLLAPSE),
        survives & (peak >= EDGE_OF_COLLAPSE),
        collapses & (collapsed_at_lower != 1),
        is_run & (converged == 0),
    ]
    return [stratum.transpose(*HISTORY_DIMS).values for stratum in strata]


def draw(
    strata: Sequence[NDArray[np.bool_]], count: int, seed: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Draw histories, as many of each stratum as it has up to an equal share.

    Parameters
    ----------
    strata : sequence of ndarray of bool
        Histories of each stratum.
    count : int
        Number of histories to be drawn.
    seed : int
        Seed of the random numbers.

    Returns
    -------
    tuple of ndarray of int
        Indices of the histories, shape (histories, dimensions), and their strata, shape
        (histories,).
    """
    rng = np.random.default_rng(seed)
    shares = np.diff(np.linspace(0, count, len(strata) + 1).astype(int))
    places = []
    for members, share in zip(strata, shares, strict=True):
        candidates = np.argwhere(members)
        size = min(share, len(candidates))
        rows = np.sort(rng.choice(len(candidates), size, replace=False))
        places.append(candidates[rows])
    counts = [len(place) for place in places]
    return np.concatenate(places), np.repeat(np.arange(len(strata)), counts)


def rate(stratum: NDArray[np.int64], checked: xr.Dataset) -> dict[str, tuple[str, Array]]:
    """Return for each stratum the share that ends otherwise, and errors of peaks of survivors.

    Parameters
    ----------
    stratum : ndarray of int, shape (histories,)
        Stratum of each history.
    checked : xarray.Dataset
        Peaks and collapses by both solvers, with the bounds of the peaks.
    """
    exact_peak = checked["exact_peak"].values
    error = np.abs(checked["peak"].values - exact_peak)
    bound = checked["peak_uncertainty"].values
    collapsed = checked["collapsed"].values
    ends_otherwise = collapsed != checked["exact_collapsed"].values
    survives = ~ends_otherwise & (collapsed == 0)

    def summarise(
        statistic: Callable[[Any], Any], values: NDArray[Any], chosen: NDArray[np.bool_]
    ) -> tuple[str, Array]:
        summaries = np.full(len(STRATA), np.nan)
        for number in range(len(STRATA)):
            members = values[chosen & (stratum == number)]
            if members.size:
                summaries[number] = statistic(members)
        return "stratum", summaries

    has_bound = survives & np.isfinite(bound)
    relative = error / exact_peak
    return {
        "otherwise_share": summarise(np.mean, ends_otherwise, np.ones_like(ends_otherwise)),
        "beyond_bound_share": summarise(np.mean, error > bound, has_bound),
        "median_difference": summarise(np.median, relative, survives),
        "largest_difference": summarise(np.max, relative, survives),
    }


def solve_exactly(
    case: xr.Dataset, motion: catalogue.GroundMotion, named_wall: NamedWall, tail: float
) -> tuple[float, bool]:
    """Return the peak of one history and whether it collapses.

    Parameters
    ----------
    case : xarray.Dataset
        Damping model, restitution, damping ratio and scale factor of the history.
    motion : GroundMotion
        Motion of its record.
    named_wall : NamedWall
        Wall and curve of the config.
    tail : float
        Rest after the record. [s]
    """
    model = str(case["damping_model"].values)
    value = float(case["restitution" if model == REFERENCE else "damping_ratio"])
    load = make_load(named_wall.wall, motion.record, float(case["scale_factor"]), tail=tail)
    end = float(load.sampling) * (load.ground.shape[1] - 1)
    history = exact_history(named_wall.curve, Damping(model, value), [end], **sample_load(load))
    extremes = np.abs([*history.turning_displacement, *history.displacement])
    return float(np.nanmax(extremes, initial=0.0)), history.collapsed
