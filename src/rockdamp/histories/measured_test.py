"""The response to a measured record: its rest before the motion, and what a sensor shows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from rockdamp.arguments import number
from rockdamp.arrays import Array
from rockdamp.errors import InputError, require
from rockdamp.histories.loads import Forcing
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.record import Record
from rockdamp.solvers.newmark import Histories, simulate

# ASSUME: the paper gives no definitions of its own for any of these.
QUIET = 0.02  # of the peak acceleration: before the motion first exceeds it the wall is at rest
SHORTEST_REST = 10  # samples
NOISY, MOST_NOISY = 5.0, 0.3  # of the accelerometer's noise, that is no motion; of the peak, that is one however noisy


class Described(Protocol):
    """A record, or a free-rocking test: what has a header."""

    @property
    def header(self) -> Mapping[str, str]: ...
    @property
    def synthetic(self) -> bool: ...


def record_attributes(record: Described) -> dict[str, str]:
    """Return the attributes that a dataset, and with it each figure, must state of its record."""
    stated = {f"record_{key}": record.header.get(key, "not stated") for key in ("specimen", "source", "licence")}
    return {**stated, "record_synthetic": "yes" if record.synthetic else "no"}


def computed_response(
    record: Record, wall: Wall | Parapet, curve: TrilinearCurve, damping: Damping, step: float
) -> Histories:
    """Compute the response to a record's motion at its samples; arrays of the curve or the damper make a batch.

    `step` is the solver's longest, in tau: a whole number of steps lies between two samples of the record. [-]
    """
    step = number("step", step)
    require(step > 0, "step", step, "greater than 0")
    forcing = Forcing.from_record(wall, record)
    substeps = forcing.substeps(step)
    return simulate(curve, damping, load=forcing.newmark(substeps), store_every=substeps)


def quiet_level(record: Record) -> float:
    """Return the acceleration below which the ground is at rest: `QUIET` of the peak, or what noise reaches. [m s-2]

    The noise is that of the differences of the first samples, as a smooth motion has small ones.
    """
    peak = float(np.abs(record.ground_acceleration).max())
    noise = float(np.std(np.diff(record.ground_acceleration[:SHORTEST_REST])) / np.sqrt(2)) if peak else 0.0
    return max(QUIET * peak, min(NOISY * noise, MOST_NOISY * peak))


def motion_noise(record: Record) -> float:
    """Standard deviation of the accelerometer's noise, by the differences of samples before and after the motion."""
    acceleration = record.ground_acceleration
    moving = np.flatnonzero(np.abs(acceleration) >= quiet_level(record))
    steps = np.concatenate([np.diff(acceleration[: moving[0]]), np.diff(acceleration[moving[-1] + 1 :])])
    return float(np.sqrt(np.mean(steps**2) / 2))


def rest_samples(record: Record) -> int:
    """Count the samples before the motion, in which the wall is at rest; refuse fewer than `SHORTEST_REST`."""
    level = quiet_level(record)
    count = int(np.argmax(np.abs(record.ground_acceleration) >= level))
    allowed = f"at least {SHORTEST_REST}, in which the motion stays below {level:.3g} m s-2"
    require(np.asarray(count >= SHORTEST_REST), "the number of samples at rest before the motion", count, allowed)
    return count


def measured_displacement(record: Record) -> tuple[Array, float]:
    """Return the measured displacement from the level at rest, and that level as the sensor showed it. [m]"""
    if record.displacement is None:
        raise InputError(
            "the record has no column displacement_m; it must have the measured response beside the motion"
        )
    zero = float(np.mean(record.displacement[: rest_samples(record)]))
    return record.displacement - zero, zero
