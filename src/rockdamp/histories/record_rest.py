"""A measured record at rest: samples before the motion, and zero and noise of the sensors."""

from __future__ import annotations

import numpy as np

from rockdamp.arrays import Array
from rockdamp.errors import InputError, check
from rockdamp.motions.record import Record

SHORTEST_REST = 10  # samples


def quiet_level(record: Record) -> float:
    """Return the acceleration up to which the ground is at rest. [m s-2]

    It is 2 % of the peak acceleration, or the level that noise reaches if this is higher. The noise
    is found from differences between the first samples, to which a smooth motion adds little.

    Parameters
    ----------
    record : Record
        Ground motion with its rest before the motion.
    """
    peak = float(np.abs(record.ground_acceleration).max())
    if peak == 0:
        return 0.0
    first_differences = np.diff(record.ground_acceleration[:SHORTEST_REST])
    # A difference of two samples has twice the variance of one.
    noise = float(np.std(first_differences) / np.sqrt(2))
    # ASSUME: the paper defines neither the rest before a motion nor the noise of its sensors. Five
    # standard deviations hold practically all noise. Beyond 0.3 of the peak the ground moves,
    # however noisy the sensor is.
    return max(0.02 * peak, min(5.0 * noise, 0.3 * peak))


def motion_noise(record: Record) -> float:
    """Return the standard deviation of the accelerometer's noise outside the motion. [m s-2]

    The samples before and after the motion count.

    Parameters
    ----------
    record : Record
        Ground motion with rest before or after the motion.
    """
    acceleration = record.ground_acceleration
    moving = np.flatnonzero(np.abs(acceleration) >= quiet_level(record))
    first_rest = np.diff(acceleration[: moving[0]])
    last_rest = np.diff(acceleration[moving[-1] + 1 :])
    differences = np.concatenate([first_rest, last_rest])
    return float(np.sqrt(np.mean(differences**2) / 2))


def rest_samples(record: Record) -> int:
    """Count the samples before the motion, in which the wall is at rest.

    Parameters
    ----------
    record : Record
        Ground motion with its rest before the motion.

    Raises
    ------
    InputError
        If there are fewer than ten.
    """
    count = int(np.argmax(np.abs(record.ground_acceleration) >= quiet_level(record)))
    allowed = f"at least {SHORTEST_REST}"
    check("samples at rest before the motion", count, lambda n: n >= SHORTEST_REST, allowed)
    return count


def measured_displacement(record: Record) -> tuple[Array, float]:
    """Return the measured displacement from its level at rest, and that level of the sensor. [m]

    Parameters
    ----------
    record : Record
        Test with the measured response.

    Raises
    ------
    InputError
        If the record has no displacement, or fewer than ten samples at rest.
    """
    if record.displacement is None:
        raise InputError(
            "the record has no column displacement_m; it must have the measured response"
        )
    zero = float(np.mean(record.displacement[: rest_samples(record)]))
    return record.displacement - zero, zero
