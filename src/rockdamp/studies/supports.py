"""What holds a wall, and what the equation of motion leaves out: how far the intensity moves that collapses the wall.

Each case changes one assumption about the walls of the study of earthquakes, under the same records at the same
intensities of the ground, with e by the rule ``measured``:

- a flexible floor at the top, by its period (`histories.supports`); a parapet stands on it;
- the overburden as a mass, at first by its inertia alone, then with the impact that is its own (`Wall`);
- restitution by another rule;
- vertical shaking, for which the other horizontal component of the station stands, times a factor;
- an overburden that keeps its side, in place of one that changes sides with u;
- no loss at impacts so slow that the wall stays on the first branch of its curve.

The last three are no load on an odd curve. They are marched here in NumPy, by the scheme of `solvers.newmark`, under
one record of each station, and so is what they are compared with.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from itertools import groupby
from typing import NamedTuple, TypeVar

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.earthquakes import NamedWall, Supports
from rockdamp.histories.loads import peaks_and_collapses, substeps_of
from rockdamp.histories.supports import floor_motions
from rockdamp.mechanics import trilinear
from rockdamp.mechanics.building import Diaphragm
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions import catalogue
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.records import Record, followed_by_rest
from rockdamp.plausibility import as_meant
from rockdamp.progress import track
from rockdamp.statistics.against_restitution import BOUND, fragilities
from rockdamp.statistics.fragility import resample
from rockdamp.vocabulary import STANDARD_GRAVITY

EVERY_WALL = "all"
ASSUMED, STEPPED = "as assumed", "as assumed, one record of a station"
MASS, ANALYTICAL, IMPULSIVE, STRUCK = "mass, same e", "e of Eq. (7)", "e impulsive", "mass, e impulsive"
VERTICAL, WORSE, KEEPS, ELASTIC = "vertical shaking", "worse of both sides", "keeps its side", "no loss below a1"
IN_NUMPY = (STEPPED, VERTICAL, WORSE, KEEPS, ELASTIC)
# What a case is compared with, where that is not `ASSUMED`; what others are compared with is no case of its own.
BESIDE: Mapping[str, str] = {STRUCK: IMPULSIVE, VERTICAL: STEPPED, KEEPS: WORSE, ELASTIC: STEPPED}
REFERENCES = (ASSUMED, STEPPED, WORSE)
NOT_RUN = -1

T = TypeVar("T")


class Run(NamedTuple):
    """A wall in a case: its number among the walls, and e."""

    case: str
    column: int
    wall: Wall | Parapet
    curve: TrilinearCurve
    restitution: float


def floor_case(period: float) -> str:
    """Return the name of the case of a flexible floor."""
    return f"floor of {period:g} s"


def names_of(settings: Supports) -> list[str]:
    """Return the names of all cases, those that others are compared with among them."""
    floors = [floor_case(period) for period in settings.diaphragm_period.tolist()]
    return [ASSUMED, *floors, MASS, ANALYTICAL, IMPULSIVE, STRUCK, *IN_NUMPY]


def histories(config: Config) -> xr.Dataset:
    """Run every wall in every case under every record; ``collapsed`` is 1, 0, or -1 where a case is not run."""
    settings, walls, tail = config.supports, config.earthquakes.walls, config.earthquakes.tail
    motions = [catalogue.read(entry) for entry in catalogue.listing(config.records)]
    names, plain = names_of(settings), [*_plain(walls)]
    shape = (len(motions), len(names), settings.velocity_ratio.size, len(walls))
    collapsed = np.full(shape, NOT_RUN, dtype=np.int8)
    for row, motion in enumerate(track(motions, "What holds a wall")):
        pgv = intensity_measures(motion.record).pgv
        factor = np.array([settings.velocity_ratio * float(named.wall.velocity_scale) / pgv for named in walls])
        for record, runs in [(motion.record, plain), *_on_floors(walls, motion, settings)]:
            for run, fell in zip(runs, _collapses(record, runs, factor, settings.step, tail), strict=True):
                collapsed[row, names.index(run.case), :, run.column] = fell
        partners = [other for other in motions[row + 1 :] if other.group == motion.group]
        if partners and motion.group not in {other.group for other in motions[:row]}:
            fell = in_numpy(walls, motion.record, partners[0].record, factor, settings, tail)
            for case, of_case in zip(IN_NUMPY, fell, strict=True):
                collapsed[row, names.index(case)] = of_case.T
    unloaded = [not float(named.wall.overburden_ratio) for named in walls]
    for case in (WORSE, KEEPS):
        collapsed[:, names.index(case)][:, :, unloaded] = NOT_RUN
    return xr.Dataset(
        {"collapsed": (("record", "assumption", "velocity_ratio", "wall"), collapsed)},
        coords={
            "record": [motion.name for motion in motions],
            "station": ("record", [motion.group for motion in motions]),
            "assumption": names,
            "velocity_ratio": settings.velocity_ratio,
            "wall": [named.name for named in walls],
        },
    )


def _plain(walls: Sequence[NamedWall]) -> Iterator[Run]:
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
            yield Run(STRUCK, column, heavy, curve, float(heavy.restitution_impulsive))


def _on_floors(
    walls: Sequence[NamedWall], motion: GroundMotion, settings: Supports
) -> Iterator[tuple[Record, list[Run]]]:
    """Yield the motions of the supports under flexible floors, with the walls that they hold."""
    runs = [run for run in _plain(walls) if run.case == ASSUMED]
    for period in settings.diaphragm_period.tolist():
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
        with as_meant():  # the walls were warned of when they were made
            wall, curve = (_stacked([getattr(run, name) for run in alike]) for name in ("wall", "curve"))
        damping = Damping.cr(np.array([run.restitution for run in alike]))
        levels = factor[[run.column for run in alike]]
        found[list(rows)] = peaks_and_collapses(record, wall, curve, [damping], levels, step=step, tail=tail)[1][..., 0]
    return found


def _stacked(owners: Sequence[T]) -> T:
    """Return walls or curves of numbers as one of arrays; curves have one kind of softening."""
    names = [field.name for field in fields(owners[0])]  # type: ignore[arg-type]
    values = {name: [getattr(owner, name) for owner in owners] for name in names}
    arrays = {name: of[0] if isinstance(of[0], str) else np.array(of, dtype=float) for name, of in values.items()}
    return type(owners[0])(**arrays)


# --- in NumPy ---------------------------------------------------------------------------------------------------------


def in_numpy(
    walls: Sequence[NamedWall], record: Record, other: Record, factor: Array, settings: Supports, tail: float
) -> NDArray[np.bool_]:
    """Return which walls collapse in each case of `IN_NUMPY`, shape (cases, walls, levels).

    `other` is the component whose motion, times `settings.vertical`, stands for the vertical one. `factor` on both has
    the shape (walls, levels).
    """
    ground = followed_by_rest(record.ground_acceleration, record.step, tail)
    vertical = np.zeros_like(ground)
    given = other.ground_acceleration[: ground.size]
    vertical[: given.size] = given
    p = np.array([float(named.wall.frequency_parameter) for named in walls])
    fastest = p * [float(named.curve.initial_frequency) for named in walls]
    substeps = int(substeps_of(record.step * fastest, settings.step).max())
    lift, side = np.zeros((len(IN_NUMPY), 1, 1)), np.ones((2, len(IN_NUMPY), len(walls), 1))
    lift[IN_NUMPY.index(VERTICAL)] = settings.vertical / STANDARD_GRAVITY
    share = np.array([_eccentric_share(named.wall, settings.eccentricity) for named in walls])[:, None]
    side[:, IN_NUMPY.index(WORSE)] = 1 - share
    side[0, IN_NUMPY.index(KEEPS)], side[1, IN_NUMPY.index(KEEPS)] = 1 + share, 1 - share
    e = np.array([float(named.wall.restitution_measured) for named in walls])[:, None]
    slowest = np.zeros((len(IN_NUMPY), len(walls), 1))
    curves = _stacked([named.curve for named in walls])
    slowest[IN_NUMPY.index(ELASTIC), :, 0] = 2 * curves.energy(curves.yield_displacement_ratio)
    return collapses_by_step(
        curves.map(lambda value: value[:, None]),
        e,
        step=(p * record.step / substeps)[:, None],
        substeps=substeps,
        load=np.array([float(named.wall.load_factor) for named in walls])[:, None] * factor,
        ground=ground,
        lift=lift * factor,
        vertical=vertical,
        side=side,
        slowest=slowest,
    )


def _eccentric_share(wall: Wall | Parapet, eccentricity: float) -> float:
    """Return by what part an overburden that is so far from mid-thickness, over it, makes a wall stronger. [-]"""
    if isinstance(wall, Parapet):
        return 0.0
    arm = 2 * float(wall.overburden) * eccentricity * float(wall.thickness) / float(wall.upper_height)
    return arm / float(wall.rigid_strength)


def collapses_by_step(
    curve: TrilinearCurve,
    restitution: Array,
    *,
    step: Array,
    substeps: int,
    load: Array,
    ground: Array,
    lift: Array,
    vertical: Array,
    side: Array,
    slowest: Array,
) -> NDArray[np.bool_]:
    """Return which lanes collapse: x'' + (1 + lift vertical) f(x) = load ground, and e at each impact, from rest.

    By explicit Newmark with the impact located inside the step, as `solvers.newmark`. All arrays but the motions
    broadcast to the lanes' shape.

    Parameters
    ----------
    step, substeps : ndarray, int
        In tau, and how many there are between two samples of the motions.
    load, ground, lift, vertical : ndarray
        Factors of the lanes on the two motions, and these, shape (samples,).
    side : ndarray, shape (2, ...)
        What times the curve is that of u > 0, and of u < 0, in force and displacement alike.
    slowest : ndarray
        Square of the velocity up to which an impact takes nothing. [-]
    """
    k1, b1, ks, _, _, a3 = curve.parameters()
    shape = np.broadcast_shapes(np.shape(load), np.shape(lift), side.shape[1:], np.shape(step), slowest.shape)
    x, v, fell = np.zeros(shape), np.zeros(shape), np.zeros(shape, dtype=bool)
    h, e, load, slowest = (np.broadcast_to(values, shape) for values in (step, restitution, load, slowest))
    positive, negative = np.broadcast_to(side[0], shape), np.broadcast_to(side[1], shape)
    parts = np.arange(1, substeps + 1) / substeps
    a = load * ground[0]
    for before, after, up, up_after in zip(ground[:-1], ground[1:], vertical[:-1], vertical[1:], strict=True):
        for part in parts:
            start, end = (load * (before + (after - before) * at) for at in (part - parts[0], part))
            moved = x + h * (v + 0.5 * h * a)
            rest, begin = h, v
            hit = ((x > 0) & (moved <= 0)) | ((x < 0) & (moved >= 0))
            if hit.any():
                moved, rest, begin, a = _after_impact(hit, x, v, a, h, start, end, e, slowest, moved)
            x = moved
            scale = np.where(x < 0, negative, positive)
            force = scale * trilinear.force(np.abs(x) / scale, k1, b1, ks, a3)
            pull = np.maximum(1 + lift * (up + (up_after - up) * part), 0.0)
            a_end = end - np.where(x < 0, -force, force) * pull
            v, a = begin + 0.5 * rest * (a + a_end), a_end
            fell |= np.abs(x) > a3 * scale
    return fell


def _after_impact(
    hit: NDArray[np.bool_],
    x: Array,
    v: Array,
    a: Array,
    h: Array,
    start: Array,
    end: Array,
    e: Array,
    slowest: Array,
    moved: Array,
) -> tuple[Array, Array, Array, Array]:
    """Return, of all lanes, the displacement at the step's end, what is left of it, and v and a at its start or after
    the impact."""
    away = np.where(x > 0, v, -v)[hit]
    root = np.sqrt(np.maximum(v[hit] ** 2 - 2 * a[hit] * x[hit], 0.0))
    until = np.minimum(2 * np.abs(x[hit]) / np.maximum(root - away, trilinear.TINY), h[hit])
    at = start[hit] + (end - start)[hit] * (until / h[hit])
    speed = v[hit] + 0.5 * until * (a[hit] + at)
    speed = np.where(speed**2 > slowest[hit], e[hit], 1.0) * speed
    rest, begin, a, moved = h.copy(), v.copy(), a.copy(), moved.copy()
    rest[hit] -= until
    begin[hit], a[hit] = speed, at
    moved[hit] = rest[hit] * (speed + 0.5 * rest[hit] * at)
    return moved, rest, begin, a


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
        curves = fragilities(histories["velocity_ratio"].values, fell, runs, weights, (..., slice(1, 2)))
        ratio.append(curves["median_intensity_ratio"][:, 0])
        bounds.append(curves["median_intensity_ratio_interval"][:, 0])
        stations.append(np.unique(histories["station"].values[both.any(axis=(1, 2))]).size)
    period = dict(zip(map(floor_case, settings.diaphragm_period.tolist()), settings.diaphragm_period, strict=True))
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
