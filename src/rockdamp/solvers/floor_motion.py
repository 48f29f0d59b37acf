r"""Motion of a building's floors under a record, by modes that are integrated exactly.

A mode lags behind the ground's acceleration. The modes that are not integrated are rigid and do not; over all modes
Gamma phi, participation factor times shape, sums to 1. So the absolute acceleration of a floor is

.. math:: a_\mathrm{floor} = a_\mathrm{ground} - \sum_i \Gamma_i \varphi_i \, \mathrm{lag}_i
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rockdamp.arrays import Array
from rockdamp.motions.records import Record
from rockdamp.solvers.oscillator import Ramps

POINTS = 10  # in the shortest period, at least: then lines between them lose 3 % of that mode's acceleration
# ASSUME: the free vibration of the building after the record is followed down to this part of itself.
LEFT = 0.05


class FloorResponse(NamedTuple):
    """Motion of floors, sampled a whole number of times as often as the record.

    Attributes
    ----------
    step : float
        Time between samples. [s]
    acceleration : ndarray, shape (floors, samples)
        Absolute. [m s-2]
    displacement : ndarray, shape (floors, samples)
        Relative to the ground. [m]
    """

    step: float
    acceleration: Array
    displacement: Array


def floor_response(record: Record, period: Array, contribution: Array, damping_ratio: float) -> FloorResponse:
    """Return the motion of floors under a record, which begins with the record and ends after the free vibration.

    Parameters
    ----------
    record : Record
        ASSUME: the ground is at rest one step before the record and one step after it.
    period : ndarray, shape (modes,)
        Natural periods. [s]
    contribution : ndarray, shape (floors, modes)
        Participation factor times mode shape at each floor. [-]
    damping_ratio : float
        Of every mode. [-]
    """
    if not period.size:
        still = np.zeros((len(contribution), record.elapsed.size))
        return FloorResponse(record.step, still + record.ground_acceleration, still)
    step = record.step
    # A power of two, so that a small change of the building seldom changes the samples.
    finer = 2 ** max(int(np.ceil(np.log2(step * POINTS / period.min()))), 0)
    rest = np.log(1 / LEFT) / (2 * np.pi * damping_ratio) * period.max()
    ground = np.concatenate([[0.0], record.ground_acceleration, np.zeros(1 + int(np.ceil(rest / step)))])
    ramps = Ramps.of(ground, step, finer)
    lag = np.stack([ramps.lag(seconds, damping_ratio) for seconds in period.tolist()])
    moved = np.stack([ramps.displacement(seconds, damping_ratio) for seconds in period.tolist()])
    acceleration = ramps.acceleration - contribution @ lag
    return FloorResponse(ramps.step, acceleration[:, finer:], (contribution @ moved)[:, finer:])
