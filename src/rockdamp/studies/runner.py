"""Cases of walls under records, and the comparison of each case with another one.

A study is a list of cases. A case says how a wall, its curve, its damping and the motion change;
both sides of a comparison have the same histories.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple, TypeAlias

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

WallAndCurve: TypeAlias = tuple[Wall | Parapet, TrilinearCurve]
MakeSpecimen: TypeAlias = Callable[[Wall | Parapet, TrilinearCurve], Specimen | None]
MoveSupports: TypeAlias = Callable[[GroundMotion, bool], Record]
ALL_WALLS = "all"  # all walls together, along the dimension ``wall`` of comparisons


def move_ground(motion: GroundMotion, parapet: bool) -> Record:
    """Return the motion of the ground as that of the supports, of a wall or a parapet."""
    return motion.record


def use(damping: Damping) -> MakeSpecimen:
    """Return a function that keeps wall and curve, with a damping.

    Parameters
    ----------
    damping : Damping
        Restitution or damper, of one value.
    """
    return lambda wall, curve: Specimen(wall, curve, damping)


@dataclass(frozen=True)
class Case:
    """A change of every wall of a study.

    Parameters
    ----------
    name : str
        Name that no other case of the study has.
    make_specimen : callable
        Takes a wall and a curve of the study. Returns the specimen, whose values are numbers, or
        None where the case has none.
    step : float
        Longest step, times the initial frequency w1. [-]
    reference : str, optional
        Name of the case that this one is compared with. Default: none.
    coordinates : mapping, optional
        Place of the case along the dimensions of the study's dataset, by their names. Default:
        none.
    move_supports : callable
        Takes a ground motion, and whether a parapet stands on the supports. Returns the record of
        the supports. Default: `move_ground`.
    scheme : {"newmark", "paper"}
        Scheme of the solver, as in `peaks`. Default: "newmark".
    halvings : int
        Halvings of the step, after it is made a whole part of the record's. Default: 0.
    """

    name: str
    make_specimen: MakeSpecimen
    step: float
    reference: str = ""
    coordinates: Mapping[str, Any] = field(default_factory=dict)
    move_supports: MoveSupports = move_ground
    scheme: str = "newmark"
    halvings: int = 0


class Solver(NamedTuple):
    """Settings that cases must share to run as one batch."""

    move_supports: MoveSupports
    step: float
    scheme: str
    halvings: int


class Batch(NamedTuple):
    """Specimens that run together, with their places among walls and cases."""

    solver: Solver
    walls: list[int]
    cases: list[int]
    specimen: Specimen


def study_walls(config: Config) -> dict[str, WallAndCurve]:
    """Return the walls of the study of earthquakes and their curves, by name."""
    return {wall.name: (wall.wall, wall.curve) for wall in config.earthquakes.walls}


def chunk_names(number: str, config: Config) -> list[str]:
    """Return the names of the records that one job runs; jobs are numbered from 0."""
    size = config.earthquakes.chunk
    start = int(number) * size
    return record_names(config.records)[start : start + size]


def run(
    cases: Sequence[Case],
    motions: Iterable[GroundMotion],
    walls: Mapping[str, WallAndCurve],
    velocity_ratio: Array,
    *,
    tail: float,
) -> xr.Dataset:
    """Run every case on every wall under every record, scaled to velocity ratios.

    Parameters
    ----------
    cases : sequence of Case
        Cases of the study.
    motions : iterable of GroundMotion
        Ground motions.
    walls : mapping
        Wall and curve by name. Their sizes, not those of a case, scale the records, so that all
        cases have the same motion of the ground.
    velocity_ratio : ndarray, shape (levels,)
        lambda PGV/(p u_ins). [-]
    tail : float
        Rest after a record. [s]

    Returns
    -------
    xarray.Dataset
        ``peak`` and ``collapsed`` (1, 0, or -1 where a case has no such wall) over ``record``,
        ``velocity_ratio``, ``wall`` and ``case``, with the ``reference`` of each case and the
        ``station`` of each record.
    """
    batches = _make_batches(cases, walls)
    scale = np.array([float(wall.velocity_scale) for wall, _ in walls.values()])
    velocity = velocity_ratio[:, None] * scale
    names = []
    stations = []
    peaks = []
    outcomes = []
    for motion in motions:
        names.append(motion.name)
        stations.append(motion.group)
        factor = velocity / intensity_measures(motion.intensity_record).pgv
        peak = np.full((*factor.shape, len(cases)), np.nan)
        collapsed = np.full(peak.shape, NOT_RUN, dtype=np.int8)
        for solver, columns, numbers, specimen in batches:
            ended = run_record(
                solver.move_supports(motion, isinstance(specimen.wall, Parapet)),
                specimen,
                factor[:, columns],
                step=solver.step,
                tail=tail,
                halvings=solver.halvings,
                scheme=solver.scheme,
            )
            peak[:, columns, numbers] = ended.peak
            collapsed[:, columns, numbers] = ended.collapsed
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


def _make_batches(cases: Sequence[Case], walls: Mapping[str, WallAndCurve]) -> list[Batch]:
    """Return the specimens of all cases and walls in batches that run together."""
    specimens: dict[Solver, dict[tuple[int, ...], Specimen]] = defaultdict(dict)
    for number, case in enumerate(cases):
        solver = Solver(case.move_supports, case.step, case.scheme, case.halvings)
        for column, (wall, curve) in enumerate(walls.values()):
            specimen = case.make_specimen(wall, curve)
            if specimen is not None:
                specimens[solver][column, number] = specimen
    batches = []
    for solver, places in specimens.items():
        for (columns, numbers), specimen in stack_specimens(places):
            batches.append(Batch(solver, columns, numbers, specimen))
    return batches


def stack_specimens(
    specimens: Mapping[tuple[int, ...], Specimen],
) -> list[tuple[tuple[list[int], ...], Specimen]]:
    """Stack the specimens that can run together.

    Parameters
    ----------
    specimens : mapping
        Specimens of numbers by their place in the results.

    Returns
    -------
    list of (places, Specimen)
        Each stack with its places: a list for each dimension of the results.
    """
    groups: dict[Hashable, dict[tuple[int, ...], Specimen]] = defaultdict(dict)
    for place, specimen in specimens.items():
        groups[specimen.kind][place] = specimen
    stacks = []
    for group in groups.values():
        places = tuple(list(indices) for indices in zip(*group, strict=True))
        stacks.append((places, Specimen.stack(list(group.values()))))
    return stacks


# --- the comparison -------------------------------------------------------------------------------


def run_and_compare(cases: Sequence[Case], config: Config) -> xr.Dataset:
    """Run cases on the walls of the study of earthquakes, and compare them with their references.

    Parameters
    ----------
    cases : sequence of Case
        Cases, and the references that they name.
    config : Config
        Records, walls, intensities and the bootstrap.

    Returns
    -------
    xarray.Dataset
        Statistics of `compare`, with the counts of ``records`` and ``stations``.
    """
    earthquakes = config.earthquakes
    motions = load_records(config.records)
    histories = run(
        cases,
        track(motions, cases[0].name),
        study_walls(config),
        earthquakes.velocity_ratio.values(),
        tail=earthquakes.tail,
    )
    stations = {motion.group for motion in motions}
    compared = compare(histories, config.comparison)
    return compared.assign(records=len(motions), stations=len(stations))


def compare(histories: xr.Dataset, comparison: Comparison) -> xr.Dataset:
    """Compare each case that has a reference with it, by the paired bootstrap.

    Parameters
    ----------
    histories : xarray.Dataset
        Histories from `run`.
    comparison : Comparison
        Bands of the reference's peaks, and the bootstrap over stations.

    Returns
    -------
    xarray.Dataset
        ``median_intensity_ratio`` and the statistics of `statistics.paired.compare_pairs` over
        ``case`` and ``wall`` (``all`` first), with intervals.
    """
    edges = comparison.bands
    bands = list(pairwise(edges))
    pairs = pair(histories)
    bootstrap = comparison.bootstrap
    weights = resample(histories["station"].values, bootstrap.replicates, bootstrap.seed)
    single_walls = [pairs.isel(wall=[column]) for column in range(pairs.sizes["wall"])]
    parts = [
        compare_pairs(walls, weights, bands) for walls in track([pairs, *single_walls], "Walls")
    ]
    compared = xr.concat(parts, "wall", join="exact").transpose("case", "wall", ...)
    return compared.assign(compare_intensities(pairs, weights)).assign_coords(
        band=np.arange(1, len(edges)), band_start=("band", edges[:-1]), band_end=("band", edges[1:])
    )


def pair(histories: xr.Dataset) -> xr.Dataset:
    """Put the histories of each case's reference beside its own.

    Parameters
    ----------
    histories : xarray.Dataset
        Histories from `run`.

    Returns
    -------
    xarray.Dataset
        The cases that have a reference, with ``reference_peak`` and ``reference_collapsed``.
    """
    compared = histories.isel(case=np.flatnonzero(histories["reference"].values != ""))
    references = histories.sel(case=compared["reference"].values)
    return compared.drop_vars("reference").assign(
        {
            f"reference_{name}": (values.dims, values.values)
            for name, values in references.data_vars.items()
        }
    )


def compare_intensities(pairs: xr.Dataset, weights: Array) -> xr.Dataset:
    """Return the median intensity of collapse of each case, divided by its reference's.

    Both sides of a ratio have the records and walls that both ran.

    Parameters
    ----------
    pairs : xarray.Dataset
        Histories from `pair`.
    weights : ndarray, shape (replicates, records)
        Bootstrap of the stations, from `fragility.resample`.

    Returns
    -------
    xarray.Dataset
        ``median_intensity_ratio`` with its interval over ``case`` and ``wall`` (``all`` first).
    """
    walls = pairs["wall"].values.tolist()
    # Sets of walls, shape (sets, walls): all of them, then each alone.
    members = np.concatenate([np.ones((1, len(walls))), np.eye(len(walls))])
    ratios = []
    intervals = []
    for case in range(pairs.sizes["case"]):
        collapses, runs = _count_collapses(pairs.isel(case=case), members)
        # The second side is the reference.
        curves = compare_fragilities(
            pairs["velocity_ratio"].values, collapses, runs, weights, (..., slice(1, 2))
        )
        ratios.append(curves["median_intensity_ratio"][:, 0])
        intervals.append(curves["median_intensity_ratio_interval"][:, 0])
    dims = ("case", "wall")
    return xr.Dataset(
        {
            "median_intensity_ratio": (dims, np.array(ratios)),
            "median_intensity_ratio_interval": ((*dims, "bound"), np.array(intervals)),
        },
        coords={"case": pairs["case"].values, "wall": [ALL_WALLS, *walls], "bound": list(BOUND)},
    )


def _count_collapses(pairs: xr.Dataset, members: Array) -> tuple[Array, Array]:
    """Count the collapses and the runs of a case and its reference in sets of walls.

    The shape is (records, sets, sides, levels), where a side is the case or its reference; the runs
    have one side.
    """
    histories = pairs.transpose(*HISTORIES)
    sides = [histories["collapsed"].values, histories["reference_collapsed"].values]
    is_run = (sides[0] != NOT_RUN) & (sides[1] != NOT_RUN)
    collapses = [np.where(is_run, side, 0) @ members.T for side in sides]
    runs = (is_run @ members.T).transpose(0, 2, 1)
    return np.stack(collapses, axis=-1).transpose(0, 2, 3, 1), runs[:, :, None]


def unstack(dataset: xr.Dataset, cases: Sequence[Case], *dims: str) -> xr.Dataset:
    """Lay cases out as a grid over their coordinates, which take the place of ``case``.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results over ``case``.
    cases : sequence of Case
        Cases of the dataset, and maybe others.
    *dims : str
        Coordinates of the cases. The values along each stand in the order of the cases.
    """
    places = {case.name: tuple(map(case.coordinates.get, dims)) for case in cases}
    rows = [places[name] for name in dataset["case"].values.tolist()]
    index = pd.MultiIndex.from_tuples(rows, names=dims)
    coordinates = xr.Coordinates.from_pandas_multiindex(index, "case")
    grid = dataset.drop_vars("case").assign_coords(coordinates).unstack("case")  # noqa: PD010
    # pandas sorts the values of an index.
    values = {dim: list(index.unique(dim)) for dim in dims}
    return grid.sel(values)
