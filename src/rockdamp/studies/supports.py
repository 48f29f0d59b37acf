"""Supports of a wall, and terms that the equation of motion leaves out.

Each case changes one assumption about the walls of the study of earthquakes, under the same records
at the same intensities of the ground, with e by the rule ``measured``. The result is the change of
the intensity that collapses the wall.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config, Supports
from rockdamp.constants import REFERENCE, STANDARD_GRAVITY
from rockdamp.errors import check
from rockdamp.histories.loads import count_steps
from rockdamp.histories.supports import floor_motions
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.floors import Diaphragm
from rockdamp.mechanics.specimen import Specimen, stack_parts
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion, load_records
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.record import Record, append_rest
from rockdamp.progress import track
from rockdamp.solvers.newmark import uneven_collapses
from rockdamp.statistics.fragility import resample
from rockdamp.statistics.paired import HISTORIES, NOT_RUN
from rockdamp.studies.runner import (
    Case,
    MoveSupports,
    WallAndCurve,
    compare_intensities,
    pair,
    run,
    study_walls,
)

# Cases with which the others are compared.
ASSUMED = "as assumed"
WEAKER_SIDE = "eccentric overburden, weaker side"
# Cases of an asymmetric load or wall, which have a solver of their own.
VERTICAL = "vertical shaking"
FIXED_SIDE = "eccentric overburden, fixed side"


def list_cases(section: Supports) -> list[Case]:
    """Return the cases with a symmetric curve; a parapet has the floors and its own inertia alone.

    Parameters
    ----------
    section : Supports
        The study's part of the config.
    """
    step = section.step

    def add_mass(wall: Wall | Parapet, curve: TrilinearCurve) -> Specimen | None:
        return change_wall(wall, curve, overburden_mass=1.0) if is_loaded(wall) else None

    def move_as_bodies(wall: Wall | Parapet, curve: TrilinearCurve) -> Specimen:
        return change_wall(wall, curve, own_inertia=True)

    def keep_momentum(wall: Wall | Parapet, curve: TrilinearCurve) -> Specimen | None:
        return None if isinstance(wall, Parapet) else change_wall(wall, curve, "rigid")

    def add_impulses(wall: Wall | Parapet, curve: TrilinearCurve) -> Specimen | None:
        return None if isinstance(wall, Parapet) else change_wall(wall, curve, "impulsive")

    def weaken(wall: Wall | Parapet, curve: TrilinearCurve) -> Specimen | None:
        eccentricity = -section.eccentricity * wall.thickness
        return change_wall(wall, curve, eccentricity=eccentricity) if is_loaded(wall) else None

    cases = [Case(ASSUMED, change_wall, step)]
    for period in section.diaphragm_period:
        floor = Diaphragm(period, section.diaphragm_damping)
        cases.append(
            Case(
                f"floor of {period:g} s",
                change_wall,
                step,
                reference=ASSUMED,
                coordinates={"diaphragm_period": period},
                move_supports=hold_by_floor(floor),
            )
        )
    return [
        *cases,
        Case("overburden has mass, e unchanged", add_mass, step, ASSUMED),
        Case("own inertia", move_as_bodies, step, ASSUMED),
        Case("e of Eq. (7)", keep_momentum, step, ASSUMED),
        Case("e impulsive", add_impulses, step, ASSUMED),
        Case(WEAKER_SIDE, weaken, step),
    ]


def change_wall(
    wall: Wall | Parapet, curve: TrilinearCurve, rule: str = "measured", **sizes: Any
) -> Specimen:
    """Return a wall with other sizes, its curve, and e by a rule.

    Parameters
    ----------
    wall : Wall or Parapet
        One wall.
    curve : TrilinearCurve
        Force-displacement curve of the wall.
    rule : {"measured", "rigid", "impulsive"}
        Rule for e.
    **sizes : float
        Parameters of the wall that take other values.
    """
    body = replace(wall, **sizes)
    restitution = float(getattr(body, f"restitution_{rule}"))
    return Specimen(body, curve, Damping(REFERENCE, restitution))


def is_loaded(wall: Wall | Parapet) -> bool:
    """Return whether a wall that spans between supports has an overburden."""
    return not isinstance(wall, Parapet) and float(wall.overburden_ratio) > 0


def hold_by_floor(floor: Diaphragm) -> MoveSupports:
    """Return a function that moves the supports as under a flexible floor.

    Parameters
    ----------
    floor : Diaphragm
        Flexible floor at the top of a wall; a parapet stands on it.
    """
    return lambda motion, parapet: floor_motions(motion, None, parapet, floor)[0].record


# --- asymmetric cases -----------------------------------------------------------------------------


def run_asymmetric(
    section: Supports,
    motions: Sequence[GroundMotion],
    walls: Mapping[str, WallAndCurve],
    *,
    tail: float,
) -> xr.Dataset:
    """Run vertical shaking, and an overburden that keeps its side instead of changing it with u.

    Vertical shaking is the other horizontal component of the station times a factor; a record
    without one is not run.

    Parameters
    ----------
    section : Supports
        The study's part of the config.
    motions : sequence of GroundMotion
        Ground motions.
    walls : mapping
        Wall and curve by name.
    tail : float
        Rest after a record. [s]

    Returns
    -------
    xarray.Dataset
        ``collapsed``, as `runner.run` returns it.
    """
    bodies = [wall for wall, _ in walls.values()]
    curves = stack_parts([curve for _, curve in walls.values()])
    # Walls are the first axis, intensities the second.
    column = curves.map(lambda ratio: ratio[:, None])
    velocity_ratio = section.velocity_ratio.values()
    p = _column(bodies, "frequency_parameter")
    e = _column(bodies, "restitution_measured")
    velocity_scale = _column(bodies, "velocity_scale")
    load_factor = _column(bodies, "load_factor")
    stronger = np.array([[change_strength(wall, section.eccentricity)] for wall in bodies])
    weaker = np.array([[change_strength(wall, -section.eccentricity)] for wall in bodies])
    loaded = np.array([[is_loaded(wall)] for wall in bodies])
    lift = section.vertical / STANDARD_GRAVITY
    shape = (len(motions), velocity_ratio.size, len(bodies))
    vertical = np.full(shape, NOT_RUN, dtype=np.int8)
    fixed_side = np.full(shape, NOT_RUN, dtype=np.int8)
    for row, motion in enumerate(track(motions, "Asymmetric walls")):
        record = motion.record
        factor = velocity_ratio * velocity_scale / intensity_measures(record).pgv
        substeps = count_steps(record.step * p * column.initial_frequency, section.step)
        ground = append_rest(record.ground_acceleration, record.step, tail)
        march: dict[str, Any] = {
            "ground": ground,
            "step": p * record.step / substeps,
            "substeps": substeps,
            "load": load_factor * factor,
        }
        component = find_other_component(motion, motions)
        if component is not None:
            lifting = _fit_length(component.ground_acceleration, ground)
            vertical[row] = uneven_collapses(
                column, e, lift=lift * factor, vertical=lifting, **march
            ).T
        collapsed = uneven_collapses(column, e, side=(stronger, weaker), **march)
        fixed_side[row] = np.where(loaded, collapsed, NOT_RUN).T
    return xr.Dataset(
        {"collapsed": ((*HISTORIES, "case"), np.stack([vertical, fixed_side], axis=-1))},
        coords={
            "case": [VERTICAL, FIXED_SIDE],
            "reference": ("case", [ASSUMED, WEAKER_SIDE]),
        },
    )


def _column(walls: Sequence[Wall | Parapet], name: str) -> Array:
    """Return a property of walls, shape (walls, 1)."""
    return np.array([[float(getattr(wall, name))] for wall in walls])


def _fit_length(motion: Array, ground: Array) -> NDArray[Any]:
    """Return a motion as long as another one, cut off or with zeros after it."""
    fitted = np.zeros_like(ground)
    fitted[: motion.size] = motion[: ground.size]
    return fitted


def find_other_component(motion: GroundMotion, motions: Sequence[GroundMotion]) -> Record | None:
    """Return the other component of a motion's station, or None.

    Parameters
    ----------
    motion : GroundMotion
        Ground motion.
    motions : sequence of GroundMotion
        All motions of the study.

    Raises
    ------
    InputError
        If the other component has another step.
    """
    components = [
        component
        for component in motions
        if component.group == motion.group and component is not motion
    ]
    if not components:
        return None
    component = components[0]
    step = motion.record.step
    check(
        f"step of {component.name!r}",
        component.record.step,
        lambda component_step: np.isclose(component_step, step, rtol=1e-6, atol=0),
        f"{step:g} s, as of {motion.name!r}",
    )
    return component.record


def change_strength(wall: Wall | Parapet, eccentricity: float) -> float:
    """Return the strength with an eccentric overburden, divided by that without. [-]

    Parameters
    ----------
    wall : Wall or Parapet
        One wall.
    eccentricity : float
        Distance of the overburden from mid-thickness, divided by the thickness. [-]
    """
    eccentric = replace(wall, eccentricity=eccentricity * float(wall.thickness))
    return float(eccentric.rigid_strength / wall.rigid_strength)


# --- comparison -----------------------------------------------------------------------------------


def supports(config: Config) -> xr.Dataset:
    """Run every case on every wall under every record, and compare it with its reference."""
    return compare(config, run_histories(config))


def run_histories(config: Config) -> xr.Dataset:
    """Return ``collapsed`` of all cases, as `runner.run` does."""
    section = config.supports
    tail = config.earthquakes.tail
    walls = study_walls(config)
    motions = load_records(config.records)
    symmetric = run(
        list_cases(section),
        track(motions, "Supports"),
        walls,
        section.velocity_ratio.values(),
        tail=tail,
    )
    asymmetric = run_asymmetric(section, motions, walls, tail=tail)
    return xr.concat([symmetric.drop_vars("peak"), asymmetric], "case", join="override")


def compare(config: Config, histories: xr.Dataset) -> xr.Dataset:
    """Compare the median intensity of collapse in each case with that of its reference.

    A case is compared over all walls together that have it, and wall by wall.

    Parameters
    ----------
    config : Config
        Cases and the bootstrap.
    histories : xarray.Dataset
        Outcomes from `run_histories`.
    """
    section = config.supports
    bootstrap = config.comparison.bootstrap
    pairs = pair(histories)
    weights = resample(pairs["station"].values, bootstrap.replicates, bootstrap.seed)
    compared = compare_intensities(pairs, weights)
    is_run = (pairs["collapsed"] != NOT_RUN) & (pairs["reference_collapsed"] != NOT_RUN)
    by_record = is_run.any(("velocity_ratio", "wall")).transpose("case", "record").values
    station = pairs["station"].values
    stations = [np.unique(station[records]).size for records in by_record]
    coordinates = {case.name: case.coordinates for case in list_cases(section)}
    periods = [
        coordinates.get(name, {}).get("diaphragm_period", np.nan)
        for name in compared["case"].values.tolist()
    ]
    return (
        compared.assign(
            stations=("case", stations),
            diaphragm_damping=section.diaphragm_damping,
            vertical_factor=section.vertical,
        )
        .assign_coords(diaphragm_period=("case", periods))
        .rename(case="assumption")
    )
