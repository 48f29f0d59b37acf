"""Check peaks of the study of earthquakes by the event-driven solver, on a sample that is stratified towards collapse.

Few histories come near to collapse, and there they fork: a random sample would hardly hold any. Hence equal numbers are
drawn of histories far from collapse, near to it and at its edge, of those that just collapse, and of those whose
outcome depends on the step.
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
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.progress import track
from rockdamp.solvers.exact import exact_history
from rockdamp.studies.earthquakes import BY_DAMPER, NEAR

STRATA = ("far", "near", "edge", "just collapsed", "unconverged")


def check_earthquakes(config: Config, earthquakes: xr.Dataset) -> xr.Dataset:
    """Solve a stratified sample of the histories again, event by event.

    The dataset has ``exact_peak`` and ``exact_collapsed`` beside the peaks of the study and their bounds, and for each
    stratum the share of histories that end otherwise or lie beyond their bound.
    """
    quakes, walls = config.earthquakes, {named.name: named for named in config.earthquakes.walls}
    place, stratum = draw(find_strata(earthquakes), quakes.check.histories, quakes.check.seed)
    drawn = earthquakes.isel(
        {dim: xr.DataArray(place[:, i], dims="history") for i, dim in enumerate(BY_DAMPER)}
    )
    sources = {catalogue.motion_name(name): name for name in catalogue.record_names(config.records)}
    motions = {
        name: catalogue.load_record(sources[name])
        for name in np.unique(drawn["record"].values).tolist()
    }
    cases = [
        drawn[["damping_ratio", "scale_factor"]].isel(history=index) for index in range(len(place))
    ]
    ends = [
        solve_exactly(
            case, motions[str(case["record"].values)], walls[str(case["wall"].values)], quakes.tail
        )
        for case in track(cases, "Histories, event by event")
    ]
    checked = drawn[["peak", "collapsed", "converged", "peak_uncertainty"]].reset_coords(
        list(BY_DAMPER)
    )
    checked = checked.drop_vars("station").assign(
        exact_peak=("history", np.array([peak for peak, _ in ends])),
        exact_collapsed=("history", np.array([collapsed for _, collapsed in ends], dtype=np.int8)),
        history_stratum=("history", np.array(STRATA)[stratum]),
        checked_count=("stratum", np.bincount(stratum, minlength=len(STRATA))),
    )
    coords: dict[str, Any] = {"history": np.arange(len(place)), "stratum": list(STRATA)}
    return checked.assign(rate(stratum, checked)).assign_coords(coords)


def find_strata(earthquakes: xr.Dataset, edge: float = 0.8) -> list[NDArray[np.bool_]]:
    """Return which histories each of `STRATA` has, over `BY_DAMPER`; `edge` is where survivors are at the edge."""
    peak, collapsed, converged = (earthquakes[name] for name in ("peak", "collapsed", "converged"))
    # CR's histories are the same for every source of a ratio: one of them counts.
    source = earthquakes["damping_ratio_source"]
    run = (collapsed >= 0) & ((earthquakes["damping_model"] != REFERENCE) | (source == source[0]))
    survived, collapsing = (run & (converged == 1) & (collapsed == end) for end in (0, 1))
    lower = collapsed.shift(velocity_ratio=1, fill_value=0)
    strata = [
        survived & (peak < NEAR),
        survived & (peak >= NEAR) & (peak < edge),
        survived & (peak >= edge),
        collapsing & (lower != 1),
        run & (converged == 0),
    ]
    return [stratum.transpose(*BY_DAMPER).values for stratum in strata]


def draw(
    members: Sequence[NDArray[np.bool_]], count: int, seed: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Draw `count` histories, as many of each stratum as it has up to its share; their indices and strata."""
    rng, shares = (
        np.random.default_rng(seed),
        np.diff(np.linspace(0, count, len(members) + 1).astype(int)),
    )
    places = []
    for member, share in zip(members, shares, strict=True):
        place = np.argwhere(member)
        places.append(place[np.sort(rng.choice(len(place), min(share, len(place)), replace=False))])
    return np.concatenate(places), np.repeat(
        np.arange(len(members)), [len(place) for place in places]
    )


def rate(stratum: NDArray[np.int64], checked: xr.Dataset) -> dict[str, tuple[str, Array]]:
    """Return for each stratum which share ends otherwise, and the error of peaks where both survive."""
    same = (checked["collapsed"] == checked["exact_collapsed"]).values
    survived = same & (checked["collapsed"] == 0).values
    error, bound = (
        abs(checked["peak"] - checked["exact_peak"]).values,
        checked["peak_uncertainty"].values,
    )
    relative = error / checked["exact_peak"].values

    def summarise(
        statistic: Callable[[Any], Any], values: NDArray[Any], among: NDArray[np.bool_]
    ) -> tuple[str, Array]:
        parts = [values[among & (stratum == number)] for number in range(len(STRATA))]
        return "stratum", np.array(
            [statistic(part) if part.size else np.nan for part in parts], dtype=float
        )

    return {
        "otherwise_share": summarise(np.mean, ~same, np.ones_like(same)),
        "beyond_bound_share": summarise(np.mean, error > bound, survived & np.isfinite(bound)),
        "median_difference": summarise(np.median, relative, survived),
        "largest_difference": summarise(np.max, relative, survived),
    }


def solve_exactly(
    case: xr.Dataset, motion: catalogue.GroundMotion, named: NamedWall, tail: float
) -> tuple[float, bool]:
    """Return the peak of one history and whether it collapses; `tail` is the rest after the record. [s]"""
    model, e, ratio = (
        str(case["damping_model"].values),
        float(case["restitution"]),
        float(case["damping_ratio"]),
    )
    load = make_load(named.wall, motion.record, float(case["scale_factor"]), tail=tail)
    end = float(load.sampling) * (load.ground.shape[1] - 1)
    damping = Damping(model, e if model == REFERENCE else ratio)
    ended = exact_history(named.curve, damping, [end], **sample_load(load))
    extremes = np.abs([*ended.turning_displacement, *ended.displacement])
    return float(np.nanmax(extremes, initial=0.0)), ended.collapsed
