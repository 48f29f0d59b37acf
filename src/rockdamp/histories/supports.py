r"""Motion of a wall's two supports: floors of a building, or a flexible diaphragm.

By virtual work, with u measured from the line of the supports, the load on a wall per mass is that
of supports that move alike with the acceleration

.. math:: \frac{2 - r}{3} a_\mathrm{base} + \frac{1 + r}{3} a_\mathrm{top}
          - g \frac{u_\mathrm{top} - u_\mathrm{base}}{h}

where r is h1/h of the hinge. The last term is the tilt of the line of supports; it
does not depend on the overburden. Left out: the joints at base, hinge and top close at
displacements that differ by ``r |u_top - u_base|`` or less; in the model all close at once.

A mode of a building lags behind the ground's acceleration. The modes that are not integrated are
rigid and do not lag; over all modes, participation factor times shape sums to 1. So the absolute
acceleration of a floor is

.. math:: a_\mathrm{floor} = a_\mathrm{ground} - \sum_i \Gamma_i \varphi_i \, \mathrm{lag}_i
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

import numpy as np

from rockdamp.arrays import Array
from rockdamp.errors import InputError, check_type
from rockdamp.histories.loads import SupportRecord
from rockdamp.mechanics.floors import RIGID_PERIOD, Building, Diaphragm, Modes
from rockdamp.motions.catalogue import GroundMotion, load_records
from rockdamp.motions.record import Record
from rockdamp.solvers.oscillator import oscillate

OneRecord: TypeAlias = str | os.PathLike[str] | Record | GroundMotion
Records: TypeAlias = OneRecord | Iterable[OneRecord]


@dataclass(frozen=True)
class FloorMotion(GroundMotion):
    """The motion of a wall's supports above a ground motion; `record` holds that of the supports.

    Attributes
    ----------
    ground : Record
        Motion of the ground, whose intensity counts.

    Examples
    --------
    >>> import rockdamp as rd
    >>> building = rd.Building(period=0.25, storeys=3, storey=3)
    >>> (motion,) = rd.floor_motions("fema-p695:far-field/1/a", building)
    >>> motion.record.step < motion.ground.step
    True
    """

    ground: Record

    @property
    def intensity_record(self) -> Record:
        """The motion of the ground, whose intensity counts."""
        return self.ground


def floor_motions(
    records: Records,
    building: Building | None = None,
    parapet: bool = False,
    diaphragm: Diaphragm | None = None,
) -> list[FloorMotion]:
    """Return the motion of the supports of a wall in a building, under a flexible floor, or both.

    Parameters
    ----------
    records : str, path, Record, GroundMotion, or several of them
        Ground motions: names, paths, patterns or folders as `load_records` takes them, records,
        or motions from `load_records`. For a motion from `floor_motions`, its ground motion is
        used.
    building : Building, optional
        Linear building, with the storey of the wall. Without one the base of the wall moves with
        the ground.
    parapet : bool
        Whether the wall is a parapet on top of its storey, which moves with that floor alone.
    diaphragm : Diaphragm, optional
        Flexible floor at the top of the wall, driven by the building there, or by the ground. In a
        building the wall also stands on such a floor, except on the ground. The wall does not load
        the floors.

    Returns
    -------
    list of FloorMotion
        Motions in the order of the records. `assess` scales them to the intensity of the ground.

    Raises
    ------
    InputError
        If the records cannot be read.

    Examples
    --------
    >>> import rockdamp as rd
    >>> building = rd.Building(period=0.25, storeys=3, storey=3)
    >>> (motion,) = rd.floor_motions("fema-p695:far-field/1/a", building)
    >>> floor = rd.intensity_measures(motion.record).pga
    >>> ground = rd.intensity_measures(motion.ground).pga
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
        supports = _move_supports(ground, building, diaphragm)
        record = _make_support_record(ground, supports, parapet)
        motions.append(FloorMotion(motion.name, motion.group, motion.record_set, record, ground))
    return motions


def collect_motions(records: Records) -> list[GroundMotion]:
    """Return ground motions as they are, and read those that are named.

    Parameters
    ----------
    records : str, path, Record, GroundMotion, or several of them
        Ground motions, as in `floor_motions`.

    Raises
    ------
    InputError
        If there is no record, or one cannot be read.
    """
    if isinstance(records, str | os.PathLike | Record | GroundMotion):
        records = [records]
    check_type("records", records, Iterable)
    motions: list[GroundMotion] = []
    for number, record in enumerate(records, 1):
        if isinstance(record, GroundMotion):
            motions.append(record)
        elif isinstance(record, Record):
            motions.append(GroundMotion(f"record {number}", f"record {number}", "own", record))
        else:
            check_type("records", record, str, os.PathLike)
            motions += load_records(record)
    if not motions:
        raise InputError("there are no records; there must be at least one")
    return motions


class SupportMotion(NamedTuple):
    """Absolute accelerations of floors, and their displacements from the ground."""

    step: float  # between two samples [s]
    acceleration: Array  # shape (floors, samples) [m s-2]
    displacement: Array  # shape (floors, samples) [m]


def modal_response(
    acceleration: Array, step: float, modes: Modes, damping_ratio: float
) -> SupportMotion:
    """Return the motion of floors under a ground acceleration, with the free vibration after it.

    It begins at the first sample of the ground motion. Its step is that of the ground motion
    divided by a whole number.

    Parameters
    ----------
    acceleration : ndarray, shape (samples,)
        Acceleration of the ground. [m s-2]
    step : float
        Time between two samples. [s]
    modes : Modes
        Periods, and how much each mode moves each floor.
    damping_ratio : float
        Damping ratio of every mode. [-]
    """
    if not modes.period.size:
        still = np.zeros((len(modes.contribution), acceleration.size))
        return SupportMotion(step, still + acceleration, still)
    # Ten samples in the shortest period: straight lines between them lose 3 % of that mode's
    # acceleration. A power of two, so that a small change of the building seldom changes samples.
    samples_per_step = step * 10 / modes.period.min()
    finer = 2 ** max(int(np.ceil(np.log2(samples_per_step))), 0)
    # ASSUME: the free vibration after the record is followed down to a twentieth of itself.
    free_vibration = np.log(1 / 0.05) / (2 * np.pi * damping_ratio) * modes.period.max()
    # ASSUME: the ground is at rest one step before the record and one step after it.
    padding = np.zeros(1 + int(np.ceil(free_vibration / step)))
    padded = np.concatenate([[0.0], acceleration, padding])
    oscillation = oscillate(padded, step, modes.period, damping_ratio, finer)
    floors = oscillation.ground - modes.contribution @ oscillation.lag
    displacement = modes.contribution @ oscillation.displacement
    return SupportMotion(step / finer, floors[:, finer:], displacement[:, finer:])


def _move_supports(
    ground: Record, building: Building | None, diaphragm: Diaphragm | None
) -> SupportMotion:
    """Return the motion of the base and of the top of a wall."""
    if building is None:
        modes = Modes(np.empty(0), np.empty((2, 0)))
        damping_ratio = 1.0
        is_on_ground = True
    else:
        modes = building.modes
        damping_ratio = building.damping_ratio
        is_on_ground = building.storey == 1
    rigid = modal_response(ground.ground_acceleration, ground.step, modes, damping_ratio)
    if diaphragm is None or diaphragm.period < RIGID_PERIOD:
        return rigid
    base_share = 0.0 if is_on_ground else 1.0  # of the motion of a flexible floor
    base = _hold_by_floor(rigid, 0, base_share, diaphragm)
    top = _hold_by_floor(rigid, 1, 1.0, diaphragm)
    return SupportMotion(
        base.step,
        np.concatenate([base.acceleration, top.acceleration]),
        np.concatenate([base.displacement, top.displacement]),
    )


def _hold_by_floor(
    rigid: SupportMotion, support: int, share: float, diaphragm: Diaphragm
) -> SupportMotion:
    """Return the motion of a support on a flexible floor that the rigid support drives.

    `share` is 1, or 0 for a support on the ground, whose motion is only sampled as finely.
    """
    modes = Modes(np.array([diaphragm.period]), np.array([[share]]))
    driving = rigid.acceleration[support]
    floor = modal_response(driving, rigid.step, modes, diaphragm.damping_ratio)
    carrier = rigid.displacement[support]
    samples = np.arange(floor.acceleration.shape[-1]) * floor.step / rigid.step
    carried = np.interp(samples, np.arange(carrier.size), carrier, right=0.0)
    return SupportMotion(floor.step, floor.acceleration, carried + floor.displacement)


def _make_support_record(ground: Record, supports: SupportMotion, parapet: bool) -> Record:
    """Return the record of both supports, or of one where they move alike."""
    base, top = supports.acceleration
    drift = supports.displacement[1] - supports.displacement[0]
    has_one_support = parapet or (np.array_equal(base, top) and not drift.any())
    mean = top if has_one_support else (base + top) / 2
    elapsed = ground.elapsed
    if mean.size != elapsed.size or supports.step != ground.step:
        elapsed = ground.elapsed[0] + supports.step * np.arange(mean.size)
    if has_one_support:
        return replace(ground, elapsed=elapsed, ground_acceleration=mean, displacement=None)
    return SupportRecord(
        elapsed,
        mean,
        header=ground.header,
        digest=ground.digest,
        base_acceleration=base,
        top_acceleration=top,
        drift=drift,
    )
