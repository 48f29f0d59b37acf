"""Run cases of walls under records, and compare each case with another one over the same histories.

A study is a list of cases and its dataset: a case says what becomes of a wall, its curve and damper, and of the motion.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Comparison, Config
from rockdamp.histories.loads import run_record
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.specimen import Specimen
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion, load_records, record_names
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.record import Record
from rockdamp.progress import track
from rockdamp.statistics.fragility import resample
from rockdamp.statistics.paired import BOUND, HISTORIES, NOT_RUN, compare_fragilities, compare_pairs

WallAndCurve = tuple[Wall | Parapet, TrilinearCurve]
Stacks = list[tuple[tuple[list[int], ...], Specimen]]


def shake_ground(motion: GroundMotion, parapet: bool) -> Record:
    """Return the motion of the ground as that of the supports."""
    return motion.record


def use(damping: Damping) -> Callable[[Wall | Parapet, TrilinearCurve], Specimen]:
    """Return the setup that changes neither wall nor curve."""
    return lambda wall, curve: Specimen(wall, curve, damping)


@dataclass(frozen=True)
class Case:
    """What becomes of every wall in one case of a study.

    Attributes
    ----------
    name : str
    setup : callable
        Returns the specimen, of numbers, for a wall and curve of the study; None where the case has none.
    step : float
        Longest step, times the angular frequency of the first branch. [-]
    reference : str, optional
        Name of the case that this one is compared with.
    motion : callable
        Returns the record of the supports for a ground motion, and whether a parapet stands on them.
    scheme : str
        That of `peaks`.
    halvings : int
        Of the step, after it is made a whole part of that of the record.
    """

    name: str
    setup: Callable[[Wall | Parapet, TrilinearCurve], Specimen | None]
    step: float
    reference: str = ""
    motion: Callable[[GroundMotion, bool], Record] = shake_ground
    scheme: str = "newmark"
    halvings: int = 0


def study_walls(config: Config) -> dict[str, WallAndCurve]:
    """Return the walls of the study of earthquakes and their curves, by name."""
    return {named.name: (named.wall, named.curve) for named in config.earthquakes.walls}


def chunk_names(number: str, config: Config) -> list[str]:
    """Return the names of the records that one job runs; jobs are numbered from 0."""
    size = config.earthquakes.chunk
    return record_names(config.records)[int(number) * size : (int(number) + 1) * size]


def run(
    cases: Sequence[Case],
    motions: Iterable[GroundMotion],
    walls: Mapping[str, WallAndCurve],
    velocity_ratio: Array,
    *,
    tail: float,
) -> xr.Dataset:
    """Run every case on every wall under every record, scaled to velocity ratios, lambda PGV/(p u_ins).

    Parameters
    ----------
    cases : sequence of Case
    motions : iterable of GroundMotion
    walls : wall and curve by name
        Their sizes, not those of a case, scale the records, so that all cases have the same motion of the ground.
    velocity_ratio : ndarray
        [-]
    tail : float
        Rest after a record. [s]

    Returns
    -------
    xarray.Dataset
        ``peak`` and ``collapsed`` (1, 0, or -1 where a case has no such wall) over ``record``, ``velocity_ratio``,
        ``wall`` and ``case``, with the ``reference`` of each case and the ``station`` of each record.
    """
    scale = np.array([float(wall.velocity_scale) for wall, _ in walls.values()])
    alike: dict[Any, dict[Any, Specimen]] = defaultdict(dict)
    for number, case in enumerate(cases):
        for column, (wall, curve) in enumerate(walls.values()):
            if (specimen := case.setup(wall, curve)) is not None:
                alike[case.motion, case.step, case.scheme, case.halvings][column, number] = specimen
    batches = [
        (how, *stacked)
        for how, specimens in alike.items()
        for stacked in stack_specimens(specimens)
    ]
    shape = (velocity_ratio.size, len(walls), len(cases))
    names, stations, peaks, outcomes = [], [], [], []
    for motion in motions:
        names.append(motion.name)
        stations.append(motion.group)
        peak, collapsed = np.full(shape, np.nan), np.full(shape, NOT_RUN, dtype=np.int8)
        factor = velocity_ratio[:, None] * scale / intensity_measures(motion.intensity_record).pgv
        for (move, step, scheme, halvings), (columns, numbers), specimen in batches:
            record = move(motion, isinstance(specimen.wall, Parapet))
            factors = factor[:, columns]
            ended = run_record(
                record, specimen, factors, step=step, tail=tail, halvings=halvings, scheme=scheme
            )
            peak[:, columns, numbers], collapsed[:, columns, numbers] = ended.peak, ended.collapsed
        peaks.append(peak)
        outcomes.append(collapsed)
    dims = (*HISTORIES, "case")
    return xr.Dataset(
        {"peak": (dims, np.stack(peaks)), "collapsed": (dims, np.stack(outcomes))},
        coords={
            "record": names,
            "station": ("record", stations),
            "velocity_ratio": velocity_ratio,
            "wall": list(walls),
            "case": [case.name for case in cases],
            "reference": ("case", [case.reference for case in cases]),
        },
    )


def stack_specimens(specimens: Mapping[Any, Specimen]) -> Stacks:
    """Stack the specimens that can run together.

    `specimens` are by their place in the results. A stack comes with its places: a list for each dimension of a place.
    """
    alike: dict[Any, dict[Any, Specimen]] = defaultdict(dict)
    for place, specimen in specimens.items():
        alike[specimen.kind][place] = specimen
    return [
        (tuple(map(list, zip(*members, strict=True))), Specimen.stack([*members.values()]))
        for members in alike.values()
    ]


# --- the comparison ---------------------------------------------------------------------------------------------------


def run_and_compare(cases: Sequence[Case], config: Config) -> xr.Dataset:
    """Run cases on the walls of the study of earthquakes under its records and intensities, and compare them.

    Returns what `compare` does, with the counts of ``records`` and ``stations``.
    """
    quakes, motions = config.earthquakes, load_records(config.records)
    ratio, shown = quakes.velocity_ratio.values(), track(motions, cases[0].name)
    histories = run(cases, shown, study_walls(config), ratio, tail=quakes.tail)
    stations = {motion.group for motion in motions}
    return compare(histories, config.comparison).assign(
        records=len(motions), stations=len(stations)
    )


def compare(histories: xr.Dataset, comparison: Comparison) -> xr.Dataset:
    """Compare each case that has a reference with it, over all walls and wall by wall, by the paired bootstrap.

    Parameters
    ----------
    histories : xarray.Dataset
        What `run` returned.
    comparison : Comparison
        Bands of the reference's peaks, and the bootstrap over stations.

    Returns
    -------
    xarray.Dataset
        ``median_intensity_ratio`` and the statistics of `statistics.paired.compare_pairs` over ``case`` and ``wall``
        (``all`` first), with intervals.
    """
    edges, pairs = comparison.bands, pair(histories)
    weights = resample(
        histories["station"].values, comparison.bootstrap.replicates, comparison.bootstrap.seed
    )
    chosen = [pairs, *(pairs.isel(wall=[column]) for column in range(pairs.sizes["wall"]))]
    parts = [
        compare_pairs(walls, weights, list(pairwise(edges))) for walls in track(chosen, "Walls")
    ]
    compared = xr.concat(parts, "wall", join="exact").transpose("case", "wall", ...)
    return compared.assign(compare_intensities(pairs, weights)).assign_coords(
        band=np.arange(1, len(edges)), band_start=("band", edges[:-1]), band_end=("band", edges[1:])
    )


def pair(histories: xr.Dataset) -> xr.Dataset:
    """Put the histories of each case's reference beside its own, as ``reference_peak`` and ``reference_collapsed``."""
    compared = histories.isel(case=np.flatnonzero(histories["reference"].values != ""))
    references = histories.sel(case=compared["reference"].values)
    return compared.drop_vars("reference").assign(
        {
            f"reference_{name}": (values.dims, values.values)
            for name, values in references.data_vars.items()
        }
    )


def compare_intensities(pairs: xr.Dataset, weights: Array) -> xr.Dataset:
    """Return the median intensity of collapse of each case over its reference's, with its interval.

    `pairs` is what `pair` returned and `weights` are the bootstrap's. Both sides of a ratio are of the same records and
    walls: those that both ran.
    """
    walls = [*map(str, pairs["wall"].values)]
    chosen = np.concatenate(
        [np.ones((1, len(walls))), np.eye(len(walls))]
    )  # (sets of walls, walls)
    ratio, bounds = [], []
    for case in range(pairs.sizes["case"]):
        histories = pairs.isel(case=case).transpose(*HISTORIES)
        outcomes = [histories[name].values for name in ("collapsed", "reference_collapsed")]
        both = (outcomes[0] != NOT_RUN) & (outcomes[1] != NOT_RUN)
        # By record, set of walls, side of the pair and intensity.
        collapses = np.stack(
            [np.where(both, side, 0) @ chosen.T for side in outcomes], axis=-1
        ).transpose(0, 2, 3, 1)
        runs = (both @ chosen.T).transpose(0, 2, 1)[:, :, None]
        curves = compare_fragilities(
            pairs["velocity_ratio"].values, collapses, runs, weights, (..., slice(1, 2))
        )
        ratio.append(curves["median_intensity_ratio"][:, 0])
        bounds.append(curves["median_intensity_ratio_interval"][:, 0])
    dims = ("case", "wall")
    return xr.Dataset(
        {
            "median_intensity_ratio": (dims, np.array(ratio)),
            "median_intensity_ratio_interval": ((*dims, "bound"), np.array(bounds)),
        },
        coords={"case": pairs["case"].values, "wall": ["all", *walls], "bound": list(BOUND)},
    )


def unstack(cases: xr.Dataset, **values: Iterable[Any]) -> xr.Dataset:
    """Lay cases out as a grid: their names give way to a dimension for each parameter, the last varies fastest."""
    index = pd.MultiIndex.from_product([*values.values()], names=list(values))
    grid = cases.drop_vars("case", errors="ignore").assign_coords(
        xr.Coordinates.from_pandas_multiindex(index, "case")
    )
    # pandas sorts what it makes an index of.
    return grid.unstack("case").sel({name: list(each) for name, each in values.items()})  # noqa: PD010, it is xarray's
