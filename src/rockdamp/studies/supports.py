"""What holds a wall, and what the equation of motion leaves out: how far the intensity moves that collapses the wall.

Each case changes one assumption about the walls of the study of earthquakes, under the same records at the same
intensities of the ground, with e by the rule ``measured``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from rockdamp.config import Config, Supports
from rockdamp.constants import STANDARD_GRAVITY
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
    WallAndCurve,
    compare_intensities,
    pair,
    run,
    study_walls,
)

ASSUMED, WEAKER = (
    "as assumed",
    "eccentric overburden, weaker side",
)  # what the others are compared with


def cases(section: Supports) -> list[Case]:
    """Return the cases that are loads on an odd curve; a parapet has a flexible floor alone."""
    step, shift = section.step, -section.eccentricity
    floors = [Diaphragm(period, section.diaphragm_damping) for period in section.diaphragm_period]
    changes: dict[str, Callable[[Any, TrilinearCurve], Specimen | None]] = {
        "overburden has mass, e unchanged": lambda w, c: (
            change(w, c, overburden_mass=1.0) if is_loaded(w) else None
        ),
        "own inertia": lambda w, c: change(w, c, own_inertia=True),
        "e of Eq. (7)": lambda w, c: None if isinstance(w, Parapet) else change(w, c, "rigid"),
        "e impulsive": lambda w, c: None if isinstance(w, Parapet) else change(w, c, "impulsive"),
    }
    return [
        Case(ASSUMED, change, step),
        *(
            Case(f"floor of {floor.period:g} s", change, step, ASSUMED, move_floor(floor))
            for floor in floors
        ),
        *(Case(name, setup, step, ASSUMED) for name, setup in changes.items()),
        Case(
            WEAKER,
            lambda w, c: change(w, c, eccentricity=shift * w.thickness) if is_loaded(w) else None,
            step,
        ),
    ]


def change(
    wall: Wall | Parapet, curve: TrilinearCurve, rule: str = "measured", **sizes: Any
) -> Specimen:
    """Return a wall with other sizes, its curve, and e by a rule."""
    wall = replace(wall, **sizes)
    return Specimen(wall, curve, Damping("CR", float(getattr(wall, f"restitution_{rule}"))))


def is_loaded(wall: Wall | Parapet) -> bool:
    return not isinstance(wall, Parapet) and float(wall.overburden_ratio) > 0


def move_floor(floor: Diaphragm) -> Callable[[GroundMotion, bool], Record]:
    """Return what makes the motion of the supports under a flexible floor; a parapet stands on it."""
    return lambda motion, parapet: floor_motions(motion, None, parapet, floor)[0].record


def run_asymmetric(
    section: Supports,
    motions: Sequence[GroundMotion],
    walls: Mapping[str, WallAndCurve],
    *,
    tail: float,
) -> xr.Dataset:
    """Run vertical shaking, and an overburden that keeps its side in place of one that changes sides with u.

    Vertical shaking is the other horizontal component of the station times a factor; without one it is not run.
    Returns ``collapsed``, as `runner.run` does.
    """
    owners, curves = zip(*walls.values(), strict=True)
    p, e, scale, load = (
        np.array([[float(getattr(wall, name))] for wall in owners])
        for name in ("frequency_parameter", "restitution_measured", "velocity_scale", "load_factor")
    )
    curve, ratio = (
        stack_parts(curves).map(lambda value: value[:, None]),
        section.velocity_ratio.values(),
    )
    stronger, weaker = (
        np.array([[change_strength(wall, sign * section.eccentricity)] for wall in owners])
        for sign in (1, -1)
    )
    loaded = np.array([[is_loaded(wall)] for wall in owners])
    collapsed = np.full((len(motions), ratio.size, len(owners), 2), NOT_RUN, dtype=np.int8)
    for row, motion in enumerate(track(motions, "Asymmetric walls")):
        record, lift = motion.record, section.vertical / STANDARD_GRAVITY
        factor = ratio * scale / intensity_measures(record).pgv  # (walls, levels)
        substeps = count_steps(record.step * p * curve.initial_frequency, section.step)
        ground = append_rest(record.ground_acceleration, record.step, tail)
        march = {
            "ground": ground,
            "step": p * record.step / substeps,
            "substeps": substeps,
            "load": load * factor,
        }
        if (other := other_component(motion, motions)) is not None:
            vertical = np.zeros_like(ground)
            vertical[: other.ground_acceleration.size] = other.ground_acceleration[: ground.size]
            collapsed[row, :, :, 0] = uneven_collapses(
                curve, e, lift=lift * factor, vertical=vertical, **march
            ).T
        fixed = uneven_collapses(curve, e, side=(stronger, weaker), **march)
        collapsed[row, :, :, 1] = np.where(loaded, fixed, NOT_RUN).T
    names = ["vertical shaking", "eccentric overburden, fixed side"]
    return xr.Dataset(
        {"collapsed": ((*HISTORIES, "case"), collapsed)},
        coords={"case": names, "reference": ("case", [ASSUMED, WEAKER])},
    )


def other_component(motion: GroundMotion, motions: Sequence[GroundMotion]) -> Record | None:
    """Return the other component of a motion's station; refuse one of another step."""
    other = next(
        (other for other in motions if other.group == motion.group and other is not motion), None
    )
    if other is None:
        return None
    step = motion.record.step
    wanted = f"{step:g} s, as of {motion.name!r}"
    check(
        f"step of {other.name!r}",
        other.record.step,
        lambda own: np.isclose(own, step, rtol=1e-6, atol=0),
        wanted,
    )
    return other.record


def change_strength(wall: Wall | Parapet, eccentricity: float) -> float:
    """Return the strength with an overburden so far from mid-thickness, over the thickness, over that without. [-]"""
    moved = replace(wall, eccentricity=eccentricity * float(wall.thickness))
    return float(moved.rigid_strength / wall.rigid_strength)


def supports(config: Config) -> xr.Dataset:
    """Run every case on every wall under every record, and compare it with its reference."""
    return compare(config, histories(config))


def histories(config: Config) -> xr.Dataset:
    """Return ``collapsed`` of all cases, as `runner.run` does."""
    section, tail, walls = config.supports, config.earthquakes.tail, study_walls(config)
    motions, ratio = load_records(config.records), section.velocity_ratio.values()
    odd = run(cases(section), track(motions, "Supports"), walls, ratio, tail=tail).drop_vars("peak")
    return xr.concat(
        [odd, run_asymmetric(section, motions, walls, tail=tail)], "case", join="override"
    )


def compare(config: Config, histories: xr.Dataset) -> xr.Dataset:
    """Compare the median intensity of collapse in each case with that of its reference, with intervals over stations.

    A case is compared over all walls together that have it, and wall by wall.
    """
    section, bootstrap = config.supports, config.comparison.bootstrap
    pairs = pair(histories)
    compared = compare_intensities(
        pairs, resample(pairs["station"].values, bootstrap.replicates, bootstrap.seed)
    )
    ran = (pairs["collapsed"] != NOT_RUN) & (pairs["reference_collapsed"] != NOT_RUN)
    by_record = ran.any(("velocity_ratio", "wall")).transpose("case", "record").values
    periods = {f"floor of {period:g} s": period for period in section.diaphragm_period}
    return compared.assign(
        stations=("case", [np.unique(pairs["station"].values[some]).size for some in by_record]),
        diaphragm_period=(
            "case",
            [periods.get(case, np.nan) for case in compared["case"].values.tolist()],
        ),
        diaphragm_damping=section.diaphragm_damping,
        vertical_factor=section.vertical,
    ).rename(case="assumption")
