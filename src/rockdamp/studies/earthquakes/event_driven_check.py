"""Check peaks of the study of earthquakes by the event-driven solver, on a sample that is stratified towards collapse.

Few histories come near to collapse, and there they fork: a random sample would hardly hold any. Hence equal numbers are
drawn of histories far from collapse, near to it and at its edge, of those that just collapse, and of those whose
outcome depends on the step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config, NamedWall
from rockdamp.constants import MODELS, REFERENCE
from rockdamp.histories.loads import make_load, sample_load
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.progress import track
from rockdamp.solvers.exact import exact_history
from rockdamp.solvers.newmark import Load
from rockdamp.studies.earthquakes.incremental import BY_DAMPER, NEAR

EDGE = 0.8  # u/u_ins: of the peaks of walls that survive
STRATA = ("far", "near", "edge", "just collapsed", "unconverged")


Members = list[NDArray[np.bool_]]  # which histories each stratum has


@dataclass(frozen=True)
class Sample:
    """Histories drawn from each stratum: each in a `part` of the study, with its indices there (`place`) and `stratum`.

    `study` counts the histories of the whole study in each of `STRATA`.
    """

    part: NDArray[np.int64]
    place: NDArray[np.int64]
    stratum: NDArray[np.int64]
    study: NDArray[np.int64]


def strata(peak: Array, collapsed: Array, converged: Array, intensity: int) -> Members:
    """Return which histories each of `STRATA` has; `intensity` is the axis of the arrays along which it grows."""
    stands, fell = (converged == 1) & (collapsed == 0), (converged == 1) & (collapsed == 1)
    fell, lower = np.moveaxis(fell, intensity, 0), np.moveaxis(collapsed, intensity, 0)
    just = np.moveaxis(np.concatenate([fell[:1], fell[1:] & (lower[:-1] != 1)]), 0, intensity)
    return [
        stands & (peak < NEAR),
        stands & (peak >= NEAR) & (peak < EDGE),
        stands & (peak >= EDGE),
        just,
        (converged == 0) & (collapsed >= 0),
    ]


def draw(parts: Sequence[Callable[[], Members]], count: int, seed: int) -> Sample:
    """Draw `count` histories, as many of each stratum as there are up to its share; only one part is held at once."""
    rng = np.random.default_rng(seed)
    counts = np.array([[member.sum() for member in members()] for members in parts])
    study, before = counts.sum(axis=0), np.cumsum(counts, axis=0) - counts
    shares = np.diff(np.linspace(0, count, study.size + 1).astype(int))
    ranks = [rng.choice(of, min(share, of), replace=False) for of, share in zip(study, shares, strict=True)]
    part, place, stratum = [], [], []
    for p, members in enumerate(parts):
        for s, member in enumerate(members()):
            own = np.sort(ranks[s] - before[p, s])
            own = own[(own >= 0) & (own < counts[p, s])]
            place.append(np.argwhere(member)[own])
            part.append(np.full(own.size, p))
            stratum.append(np.full(own.size, s))
    order = np.argsort(np.concatenate(stratum), kind="stable")
    return Sample(np.concatenate(part)[order], np.concatenate(place)[order], np.concatenate(stratum)[order], study)


def solved(solve: Callable[[int], tuple[float, bool]], count: int, label: str) -> dict[str, tuple[str, Array]]:
    """Solve histories 0 to `count`."""
    ends = [solve(index) for index in track(range(count), label)]
    return {
        "exact_peak": ("history", np.array([peak for peak, _ in ends])),
        "exact_collapsed": ("history", np.array([collapsed for _, collapsed in ends], dtype=np.int8)),
    }


def rates(sample: Sample, checked: xr.Dataset) -> dict[str, tuple[str, Array]]:
    """Count, in each stratum, the histories that end otherwise, and measure the error of peaks where both survive."""
    of = {str(name): checked[name].values for name in checked.data_vars}
    same = of["collapsed"] == of["exact_collapsed"]
    stand = same & (of["collapsed"] == 0)
    error = np.abs(of["peak"] - of["exact_peak"])

    def each(statistic: Callable[[Array], Any], values: Array, among: NDArray[np.bool_]) -> tuple[str, Array]:
        own = [values[among & (sample.stratum == stratum)] for stratum in range(sample.study.size)]
        return "stratum", np.array([statistic(part) if part.size else np.nan for part in own], dtype=float)

    columns = {
        "study_count": ("stratum", sample.study),
        "checked_count": ("stratum", np.bincount(sample.stratum, minlength=sample.study.size)),
        "otherwise_share": each(np.mean, ~same, np.ones_like(same)),
        "median_difference": each(np.median, error / of["exact_peak"], stand),
        "largest_difference": each(np.max, error / of["exact_peak"], stand),
        "history_stratum": ("history", np.array(STRATA)[sample.stratum]),
    }
    if "peak_uncertainty" in of:
        bound = of["peak_uncertainty"]
        columns["beyond_bound_share"] = each(np.mean, error > bound, stand & np.isfinite(bound))
    return columns


def check_earthquakes(config: Config, earthquakes: xr.Dataset) -> xr.Dataset:
    """Solve a stratified sample of the histories again, event by event.

    The dataset has ``exact_peak`` and ``exact_collapsed`` beside the peaks of the study and their bounds, and for each
    stratum the share of histories that end otherwise or lie beyond their bound.
    """
    quakes = config.earthquakes
    names = ("peak", "collapsed", "converged")
    peak, collapsed, converged = (earthquakes[name].transpose(*BY_DAMPER).values for name in names)
    collapsed = np.where(_once(collapsed.shape), collapsed, -1)
    members = strata(peak, collapsed, np.where(collapsed < 0, -1, converged), BY_DAMPER.index("velocity_ratio"))
    sample = draw([lambda: members], quakes.check.histories, quakes.check.seed)
    picked = earthquakes.isel(
        {dim: xr.DataArray(sample.place[:, i], dims="history") for i, dim in enumerate(BY_DAMPER)}
    )
    walls = {named.name: named for named in quakes.walls}
    sources = {catalogue.motion_name(name): name for name in catalogue.record_names(config.records)}
    motions = {name: catalogue.load_record(sources[name]) for name in np.unique(picked["record"].values).tolist()}

    cases = picked[["damping_ratio", "scale_factor"]].load()  # and the coordinates

    def solve(index: int) -> tuple[float, bool]:
        case = cases.isel(history=index)
        return exact_peak(case, motions[str(case["record"].values)], walls[str(case["wall"].values)], quakes.tail)

    checked = (
        picked[[*names, "peak_uncertainty"]]
        .reset_coords(list(BY_DAMPER))
        .drop_vars(["record_set", "station"])
        .assign(solved(solve, len(sample.place), "Histories, event by event"))
    )
    coords: Mapping[str, Any] = {"history": np.arange(len(sample.place)), "stratum": list(STRATA)}
    return checked.assign(rates(sample, checked)).assign_coords(coords)


def _once(shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Mark the histories, shape (*BY_DAMPER), that count: restitution's is the same for every source of a ratio."""
    once = np.ones(shape, dtype=bool)
    once[..., MODELS.index(REFERENCE), 1:] = False
    return once


def exact_peak(case: xr.Dataset, motion: catalogue.GroundMotion, named: NamedWall, tail: float) -> tuple[float, bool]:
    """Return the peak of one history and whether it collapses; `tail` is the rest after the record. [s]"""
    model, e, ratio = str(case["damping_model"].values), float(case["restitution"]), float(case["damping_ratio"])
    load = make_load(named.wall, motion.record, float(case["scale_factor"]), tail=tail)
    return exact_end(named.curve, Damping(model, e if model == REFERENCE else ratio), load)


def exact_end(curve: TrilinearCurve, damping: Damping, load: Load) -> tuple[float, bool]:
    """Return the peak of a history by the event-driven solver, and whether it collapses."""
    end = float(load.sampling) * (load.ground.shape[1] - 1)
    ended = exact_history(curve, damping, [end], **sample_load(load))
    extremes = np.abs([*ended.turning_displacement, *ended.displacement])
    return float(np.nanmax(extremes, initial=0.0)), ended.collapsed
