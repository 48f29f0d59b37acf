"""Walls on a storey of a building: their supports' motion from that of the ground, and what it leaves out."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rockdamp.arguments import instance, several
from rockdamp.mechanics.building import Building
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion, load_records
from rockdamp.motions.records import Record
from rockdamp.solvers.floor_motion import floor_response
from rockdamp.vocabulary import STANDARD_GRAVITY

Records = str | os.PathLike[str] | GroundMotion | Iterable[str | os.PathLike[str] | GroundMotion]
SMALL = 0.05  # ASSUME: what is left out is small up to this part of the supports' motion


@dataclass(frozen=True)
class FloorMotion(GroundMotion):
    """The motion of a wall's supports in a building; `record` is the mean of the floors below and above.

    Attributes
    ----------
    ground : Record
        The motion of the ground, whose intensity counts.
    floor_difference : float
        Largest difference of the accelerations of both floors. [m s-2]
    drift : float
        Largest difference of their displacements. [m]

    Examples
    --------
    >>> import rockdamp as rd
    >>> building = rd.Building(period=0.25, storeys=3, storey=3)
    >>> (motion,) = rd.floor_motions("fema-p695:far-field/1/a", building)
    >>> isinstance(motion, rd.FloorMotion), motion.record.step < motion.ground.step
    (True, True)
    """

    ground: Record | None = None
    floor_difference: float = 0.0
    drift: float = 0.0

    @property
    def intensity_record(self) -> Record:
        """The record whose intensity counts: that of the ground."""
        return self.ground or self.record


def floor_motions(
    records: Records,
    building: Building,
    parapet: bool = False,
) -> list[FloorMotion]:
    """Return the motion of a wall's supports in a building under ground motions.

    Parameters
    ----------
    records : str, path, GroundMotion, or several of them
        As for `load_records`, or what it returned. Of floor motions the ground is taken.
    building : Building
        With the storey of the wall.
    parapet : bool
        The wall stands on top of its storey, and has that floor's motion alone.

    Returns
    -------
    list of FloorMotion
        In the order of the records. `assess` takes them, and scales them to the intensity of the ground.

    Raises
    ------
    InputError
        If a record cannot be read, or `building` is none.

    Examples
    --------
    >>> import rockdamp as rd
    >>> building = rd.Building(period=0.25, storeys=3, storey=3)
    >>> (motion,) = rd.floor_motions("fema-p695:far-field/1/a", building)
    >>> floor, ground = (rd.intensity_measures(record).pga for record in (motion.record, motion.ground))
    >>> round(floor / ground, 1)  # at the top the supports shake more than the ground
    2.2
    """
    instance("building", building, Building)
    return [_on_storey(motion, building, parapet) for motion in motions_of(records)]


def motions_of(records: Records) -> list[GroundMotion]:
    """Return ground motions as they are, and read those that are named."""
    if isinstance(records, (str, os.PathLike, GroundMotion)):
        records = [records]
    named = several("records", records, "a name, a path, a pattern or a GroundMotion, or some of them")
    return [
        motion
        for record in named
        for motion in ([record] if isinstance(record, GroundMotion) else load_records(record))
    ]


def _on_storey(motion: GroundMotion, building: Building, parapet: bool) -> FloorMotion:
    ground = motion.intensity_record
    modes = building.modes
    answer = floor_response(ground, modes.period, modes.contribution, building.damping_ratio)
    below, above = answer.acceleration
    acceleration = above if parapet else (below + above) / 2
    elapsed = ground.elapsed[0] + answer.step * np.arange(acceleration.size)
    record = replace(ground, elapsed=elapsed, ground_acceleration=acceleration, displacement=None)
    apart = (0.0, 0.0) if parapet else (_peak(above - below), _peak(np.diff(answer.displacement, axis=0)))
    stated = {name: getattr(motion, name) for name in ("name", "group", "record_set", "pulse_period", "event")}
    return FloorMotion(**stated, record=record, ground=ground, floor_difference=apart[0], drift=apart[1])


def left_out_share(motions: Sequence[FloorMotion], wall: Wall | Parapet) -> float:
    r"""Return the part of the load that the mean of both floors leaves out: the median over the motions. [-]

    The load on a wall is the work of its inertia and weight over a virtual displacement of the hinge. Where the floors
    differ by :math:`\Delta a`, and are apart by :math:`\Delta`, that is, per mass of the wall,

    .. math:: a_\mathrm{below} + \tfrac{1 + r}{3} \Delta a + g \frac{\Delta}{h}

    The mean has one half in place of (1 + r)/3, and no last term, which is the tilt of the line of supports.
    """
    if isinstance(wall, Parapet):
        return 0.0
    inertia = abs((1 + float(wall.hinge_ratio)) / 3 - 0.5)
    tilt = STANDARD_GRAVITY / float(wall.height)
    shares = [
        (inertia * motion.floor_difference + tilt * motion.drift) / _peak(motion.record.ground_acceleration)
        for motion in motions
    ]
    return float(np.median(shares))


def _peak(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> float:
    return float(np.abs(values).max())
