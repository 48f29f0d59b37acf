"""A measured record: its rest before the motion, and the zero and the noise of its sensors."""

from __future__ import annotations

import numpy as np

from rockdamp.arrays import Array
from rockdamp.errors import InputError, check
from rockdamp.motions.record import Record

# ASSUME: the paper gives no definitions of its own for any of these.
QUIET = 0.02  # of the peak acceleration: before the motion first exceeds it the wall is at rest
SHORTEST_REST = 10  # samples


def quiet_level(record: Record) -> float:
    """Return the acceleration below which the ground is at rest: `QUIET` of the peak, or what noise reaches. [m s-2]

    The noise is that of the differences of the first samples, as a smooth motion has small ones.
    """
    peak = float(np.abs(record.ground_acceleration).max())
    noise = (
        float(np.std(np.diff(record.ground_acceleration[:SHORTEST_REST])) / np.sqrt(2))
        if peak
        else 0.0
    )
    return max(
        QUIET * peak, min(5.0 * noise, 0.3 * peak)
    )  # beyond 0.3 of the peak it moves, however noisy


def motion_noise(record: Record) -> float:
    """Return the standard deviation of the accelerometer's noise, from before and after the motion. [m s-2]"""
    acceleration = record.ground_acceleration
    moving = np.flatnonzero(np.abs(acceleration) >= quiet_level(record))
    steps = np.concatenate(
        [np.diff(acceleration[: moving[0]]), np.diff(acceleration[moving[-1] + 1 :])]
    )
    return float(np.sqrt(np.mean(steps**2) / 2))


def rest_samples(record: Record) -> int:
    """Count the samples before the motion, in which the wall is at rest; refuse fewer than `SHORTEST_REST`."""
    count = int(np.argmax(np.abs(record.ground_acceleration) >= quiet_level(record)))
    check(
        "samples at rest before the motion",
        count,
        lambda n: n >= SHORTEST_REST,
        f"at least {SHORTEST_REST}",
    )
    return count


def measured_displacement(record: Record) -> tuple[Array, float]:
    """Return the measured displacement from the level at rest, and that level as the sensor has it. [m]"""
    if record.displacement is None:
        raise InputError(
            "the record has no column displacement_m; it must have the measured response"
        )
    zero = float(np.mean(record.displacement[: rest_samples(record)]))
    return record.displacement - zero, zero
