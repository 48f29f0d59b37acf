"""What holds a wall, and what the equation of motion leaves out: how far the intensity moves that collapses the wall.

Each case changes one assumption about the walls of the study of earthquakes, under the same records at the same
intensities of the ground, with e by the rule ``measured``:

- a flexible floor at the top, by its period (`histories.supports`); a parapet stands on it;
- the overburden as a mass, by its inertia alone (`Wall`);
- restitution by another rule;
- vertical shaking, for which the other horizontal component of the station stands, times a factor;
- an overburden that keeps its side, in place of one that changes sides with u.

The last two are no load on an odd curve: `newmark.uneven_collapses` runs them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from itertools import groupby
from typing import NamedTuple, TypedDict, TypeVar

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array, Quantity
from rockdamp.config import Config, NamedWall, Supports
from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.errors import InputError
from rockdamp.histories.loads import count_steps, run_record
from rockdamp.histories.supports import floor_motions
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.floors import Diaphragm
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions import catalogue
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.record import Record, append_rest
from rockdamp.progress import track
from rockdamp.solvers.newmark import uneven_collapses
from rockdamp.statistics.fragility import resample
from rockdamp.statistics.paired import BOUND, compare_fragilities

EVERY_WALL = "all"
ASSUMED = "as assumed"
MASS, ANALYTICAL, IMPULSIVE = "mass, same e", "e of Eq. (7)", "e impulsive"
VERTICAL, WORSE, KEEPS = "vertical shaking", "worse of both sides", "keeps its side"
# What a case is compared with, where that is not `ASSUMED`; what others are compared with is no case of its own.
BESIDE: Mapping[str, str] = {KEEPS: WORSE}
REFERENCES = (ASSUMED, WORSE)
NOT_RUN = -1

T = TypeVar("T")


class Run(NamedTuple):
    """A wall in a case: its number among the walls, and e."""

    case: str
    column: int
    wall: Wall | Parapet
    curve: TrilinearCurve
    restitution: float


class Common(TypedDict):
    """The arguments of `newmark.uneven_collapses` that its cases share."""

    step: Array
    substeps: NDArray[np.int64]
    load: Array
    ground: Array


def floor_case(period: float) -> str:
    """Return the name of the case of a flexible floor."""
    return f"floor of {period:g} s"


def names_of(settings: Supports) -> list[str]:
    """Return the names of all cases, those that others are compared with among them."""
    floors = [floor_case(period) for period in settings.diaphragm_period]
    return [ASSUMED, *floors, MASS, ANALYTICAL, IMPULSIVE, VERTICAL, WORSE, KEEPS]


def histories(config: Config) -> xr.Dataset:
    """Run every wall in every case under every record; ``collapsed`` is 1, 0, or -1 where a case is not run."""
    settings, walls, tail = config.supports, config.earthquakes.walls, config.earthquakes.tail
    motions = [catalogue.load_record(name) for name in catalogue.record_names(config.records)]
    names, plain = names_of(settings), [*_plain(walls, settings.eccentricity)]
    ratio = settings.velocity_ratio.values()
    shape = (len(motions), len(names), ratio.size, len(walls))
    collapsed = np.full(shape, NOT_RUN, dtype=np.int8)
    for row, motion in enumerate(track(motions, "What holds a wall")):
        pgv = intensity_measures(motion.record).pgv
        factor = np.array([ratio * float(named.wall.velocity_scale) / pgv for named in walls])
        for record, runs in [(motion.record, plain), *_on_floors(plain, motion, settings)]:
            for run, fell in zip(runs, _collapses(record, runs, factor, settings.step, tail), strict=True):
                collapsed[row, names.index(run.case), :, run.column] = fell
        for case, of_case in uneven(walls, motion.record, _beside(motion, motions), factor, settings, tail):
            collapsed[row, names.index(case)] = of_case.T
    return xr.Dataset(
        {"collapsed": (("record", "assumption", "velocity_ratio", "wall"), collapsed)},
        coords={
            "record": [motion.name for motion in motions],
            "station": ("record", [motion.group for motion in motions]),
            "assumption": names,
            "velocity_ratio": ratio,
            "wall": [named.name for named in walls],
        },
    )


def _beside(motion: GroundMotion, motions: Sequence[GroundMotion]) -> Record | None:
    """Return the other component of a motion's station; refuse one of another step."""
    other = next((other for other in motions if other.group == motion.group and other is not motion), None)
    if other is None:
        return None
    step, wanted = other.record.step, motion.record.step
    if not np.isclose(step, wanted, rtol=1e-6, atol=0.0):
        raise InputError(f"{other.name!r} has steps of {step:g} s; they must be {wanted:g} s, as of {motion.name!r}")
    return other.record


def _plain(walls: Sequence[NamedWall], eccentricity: float) -> Iterator[Run]:
    """Yield the cases under the ground's own motion: of a parapet alone as it is, as its e has one rule and no mass."""
    for column, named in enumerate(walls):
        wall, curve = named.wall, named.curve
        yield Run(ASSUMED, column, wall, curve, float(wall.restitution_measured))
        if isinstance(wall, Parapet):
            continue
        yield Run(ANALYTICAL, column, wall, curve, float(wall.restitution_rigid))
        yield Run(IMPULSIVE, column, wall, curve, float(wall.restitution_impulsive))
        if float(wall.overburden_ratio):
            heavy = replace(wall, overburden_mass=1.0)
            yield Run(MASS, column, heavy, curve, float(wall.restitution_measured))
            weaker = replace(wall, eccentricity=-eccentricity * float(wall.thickness))
            yield Run(WORSE, column, weaker, curve, float(wall.restitution_measured))


def _on_floors(plain: Sequence[Run], motion: GroundMotion, settings: Supports) -> Iterator[tuple[Record, list[Run]]]:
    """Yield the motions of the supports under flexible floors, with the walls that they hold."""
    runs = [run for run in plain if run.case == ASSUMED]
    for period in settings.diaphragm_period:
        floor = Diaphragm(period, settings.diaphragm_damping)
        for parapet in (False, True):
            held = [run._replace(case=floor_case(period)) for run in runs if isinstance(run.wall, Parapet) == parapet]
            if held:
                (moved,) = floor_motions(motion, None, parapet, floor)
                yield moved.record, held


def _collapses(record: Record, runs: Sequence[Run], factor: Array, step: float, tail: float) -> Array:
    """Return which runs collapse, shape (runs, levels), in their order; `factor` has the shape (walls, levels)."""
    found = np.empty((len(runs), factor.shape[1]), dtype=bool)
    numbered = sorted(enumerate(runs), key=lambda one: isinstance(one[1].wall, Parapet))
    for _, group in groupby(numbered, key=lambda one: isinstance(one[1].wall, Parapet)):
        rows, alike = zip(*group, strict=True)
        wall, curve = (_stacked([getattr(run, name) for run in alike]) for name in ("wall", "curve"))
        damping = Damping("CR", np.array([run.restitution for run in alike]))
        levels = factor[[run.column for run in alike]]
        found[list(rows)] = run_record(record, wall, curve, damping, levels.T, step=step, tail=tail).collapsed.T
    return found


def _stacked(owners: Sequence[T]) -> T:
    """Return walls or curves of numbers as one of arrays; curves have one kind of softening."""
    names = [field.name for field in fields(owners[0])]  # type: ignore[arg-type]
    values = {name: [getattr(owner, name) for owner in owners] for name in names}
    arrays = {name: of[0] if isinstance(of[0], str) else np.array(of, dtype=float) for name, of in values.items()}
    return type(owners[0])(**arrays)


# --- beyond an odd curve ----------------------------------------------------------------------------------------------


def uneven(
    walls: Sequence[NamedWall], record: Record, other: Record | None, factor: Array, settings: Supports, tail: float
) -> Iterator[tuple[str, NDArray[np.int8]]]:
    """Yield each case beyond an odd curve with what collapses in it, shape (walls, levels), -1 where it is not run.

    `other` is the component whose motion, times `settings.vertical`, stands for the vertical one; without one that case
    is left out. `factor` on both has the shape (walls, levels).
    """
    ground = append_rest(record.ground_acceleration, record.step, tail)
    p, w1, e, load = (
        np.array([float(value) for value in values])[:, None] for values in zip(*map(_parameters, walls), strict=True)
    )
    curve = _stacked([named.curve for named in walls]).map(lambda value: value[:, None])
    substeps = count_steps(record.step * p * w1, settings.step)
    common: Common = {
        "step": p * record.step / substeps,
        "substeps": substeps,
        "load": load * factor,
        "ground": ground,
    }
    if other is not None:
        vertical = np.zeros_like(ground)
        given = other.ground_acceleration[: ground.size]
        vertical[: given.size] = given
        lift = settings.vertical / STANDARD_GRAVITY * factor
        yield VERTICAL, uneven_collapses(curve, e, lift=lift, vertical=vertical, **common).astype(np.int8)
    loaded = np.array([float(named.wall.overburden_ratio) > 0 for named in walls])[:, None]
    stronger, weaker = (
        np.array([_strength_with(named.wall, to * settings.eccentricity) for named in walls])[:, None] for to in (1, -1)
    )
    kept = uneven_collapses(curve, e, side=(stronger, weaker), **common)
    yield KEEPS, np.where(loaded, kept, NOT_RUN).astype(np.int8)


def _parameters(named: NamedWall) -> tuple[Quantity, ...]:
    """Return p, the frequency of the first branch over p, e, and the factor on the ground's acceleration."""
    wall = named.wall
    return wall.frequency_parameter, named.curve.initial_frequency, wall.restitution_measured, wall.load_factor


def _strength_with(wall: Wall | Parapet, eccentricity: float) -> float:
    """Return the strength with an overburden so far from mid-thickness, over the thickness, over that without. [-]"""
    moved = replace(wall, eccentricity=eccentricity * float(wall.thickness))
    return float(moved.rigid_strength / wall.rigid_strength)


# --- the comparison ---------------------------------------------------------------------------------------------------


def compare(config: Config, histories: xr.Dataset) -> xr.Dataset:
    """Compare the median intensity of collapse in each case with that under the usual assumption, with intervals.

    ``median_intensity_ratio`` is that of a case over that of what it is compared with, over all walls together that
    have the case, and wall by wall; the same records and walls stand on both sides.
    """
    settings, bootstrap = config.supports, config.comparison.bootstrap
    names, walls = [*map(str, histories["assumption"].values)], [*map(str, histories["wall"].values)]
    weights = resample(histories["station"].values, bootstrap.replicates, bootstrap.seed)
    chosen = np.concatenate([np.ones((1, len(walls))), np.eye(len(walls))])  # (sets of walls, walls)
    compared = [name for name in names if name not in REFERENCES]
    ratio, bounds, stations = [], [], []
    for case in track(compared, "What holds a wall, cases"):
        pair = [histories["collapsed"].sel(assumption=name).values for name in (case, BESIDE.get(case, ASSUMED))]
        both = (pair[0] != NOT_RUN) & (pair[1] != NOT_RUN)
        # By record, set of walls, side of the pair and intensity.
        fell = np.stack([np.where(both, one, 0) @ chosen.T for one in pair], axis=-1).transpose(0, 2, 3, 1)
        runs = (both @ chosen.T).transpose(0, 2, 1)[:, :, None]
        curves = compare_fragilities(histories["velocity_ratio"].values, fell, runs, weights, (..., slice(1, 2)))
        ratio.append(curves["median_intensity_ratio"][:, 0])
        bounds.append(curves["median_intensity_ratio_interval"][:, 0])
        stations.append(np.unique(histories["station"].values[both.any(axis=(1, 2))]).size)
    period = dict(zip(map(floor_case, settings.diaphragm_period), settings.diaphragm_period, strict=True))
    return xr.Dataset(
        {
            "median_intensity_ratio": (("assumption", "wall"), np.array(ratio)),
            "median_intensity_ratio_interval": (("assumption", "wall", "bound"), np.array(bounds)),
            "stations": ("assumption", stations),
            "diaphragm_period": ("assumption", [period.get(case, np.nan) for case in compared]),
            "diaphragm_damping": settings.diaphragm_damping,
            "vertical_factor": settings.vertical,
            "eccentricity_ratio": settings.eccentricity,
        },
        coords={"assumption": compared, "wall": [EVERY_WALL, *walls], "bound": list(BOUND)},
    )
