"""Checks in the engineer's words, from the histories of one wall: does it rock, and does it stay below its capacity?

They are this package's own, in physical terms, and are no clause of a code.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from rockdamp.arguments import number
from rockdamp.errors import require
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures
from rockdamp.vocabulary import REFERENCE

# ASSUME: the limit state is a displacement of this part of u_ins, where guidelines differ; a user may state another.
CAPACITY = 0.4
UPPER = 0.84  # share of the records that stay at or below the upper peak: one standard deviation of a normal


class Check(NamedTuple):
    """What the histories of one wall say at one intensity; displacements are under restitution.

    Attributes
    ----------
    intensity : float
        As asked for. [m s-2 or m s-1]
    margin : float
        Median intensity of collapse over this one; NaN where the fragility has no median. [-]
    support_acceleration : float
        Median over the records of the peak acceleration of the supports. [m s-2]
    rocking_onset : float
        Acceleration whose static load reaches the strength. [m s-2]
    capacity, median_peak, upper_peak : float
        Displacement capacity; peaks that half, and 84 %, of the records do not pass: infinite where the wall
        collapses. [m]
    """

    intensity: float
    margin: float
    support_acceleration: float
    rocking_onset: float
    capacity: float
    median_peak: float
    upper_peak: float

    @property
    def rocks(self) -> bool:
        """True if the supports reach the onset of rocking."""
        return self.support_acceleration >= self.rocking_onset

    @property
    def median_met(self) -> bool:
        """True if the median peak is at most the capacity."""
        return self.median_peak <= self.capacity

    @property
    def upper_met(self) -> bool:
        """True if the peak that 84 % of the records do not pass is at most the capacity."""
        return self.upper_peak <= self.capacity


def checks(
    answer: xr.Dataset, wall: Wall | Parapet, motions: Sequence[GroundMotion], capacity: float = CAPACITY
) -> list[Check]:
    """Return the checks at each intensity of what `assess` returned for a wall under motions.

    Parameters
    ----------
    answer : xarray.Dataset
    wall : Wall or Parapet
    motions : sequence of GroundMotion
        Those of the answer.
    capacity : float
        Displacement capacity over u_ins. [-]

    Raises
    ------
    InputError
        If the capacity is not between 0 and 1.
    """
    capacity = require_capacity(capacity)
    measure = answer.attrs["intensity_measure"].lower()
    cr, u_ins = answer.sel(damping_model=REFERENCE), float(wall.instability_displacement)
    median = float(cr[f"median_{measure}"])
    support = np.array([intensity_measures(motion.record).pga for motion in motions])
    found = []
    for index, intensity in enumerate(answer[measure].values.tolist()):
        at = cr.isel(intensity=index)
        peaks = u_ins * at["peak_ratio"].fillna(np.inf).values
        shaken = support * at["scale_factor"].values
        found.append(
            Check(
                intensity,
                median / intensity,
                float(np.median(shaken)),
                float(answer["rocking_onset"]),
                capacity * u_ins,
                *(_not_passed(peaks, share) for share in (0.5, UPPER)),
            )
        )
    return found


def require_capacity(capacity: float) -> float:
    """Return a displacement capacity over u_ins, and refuse one that is no part of it."""
    value = number("displacement capacity", capacity)
    slip = f"; was it in per cent ({value / 100:g})?" if 1 < value <= 100 else ""
    require(0 < value <= 1, "displacement capacity", value, f"greater than 0 and at most 1, over u_ins{slip}")
    return value


def _not_passed(peaks: np.ndarray[tuple[int, ...], np.dtype[np.float64]], share: float) -> float:
    """Return the least peak that at least a share of the records does not pass."""
    return float(np.quantile(peaks, share, method="inverted_cdf"))
