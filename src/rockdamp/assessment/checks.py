"""What an engineer asks of one wall's answer: does it rock, how far does it move, how near is collapse?

The checks are this package's own, in physical terms, and are no clause of a code.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from rockdamp.assessment.assess import assess_rows
from rockdamp.assessment.table import Row
from rockdamp.constants import REFERENCE
from rockdamp.errors import InputError
from rockdamp.histories.loads import SupportRecord
from rockdamp.histories.one_sided import add_reversed
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.floors import Building, Diaphragm
from rockdamp.mechanics.one_sided import OneSidedWall
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures

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
    rocking_share : float
        Share of the records under which the wall rocks: it goes beyond u1, or collapses. Below the onset too it may, as
        it vibrates on its first branch. [-]
    median_peak, upper_peak : float
        Peaks that half, and 84 %, of the records do not pass: infinite where the wall collapses. [m]
    """

    intensity: float
    margin: float
    support_acceleration: float
    rocking_onset: float
    rocking_share: float
    median_peak: float
    upper_peak: float

    @property
    def rocks(self) -> bool:
        """True if the wall rocks under any of the records."""
        return self.rocking_share > 0

    def rocking_in_words(self, runs: int) -> str:
        """Say whether the wall rocks: under all of its runs, some, or none."""
        if not self.rocks:
            return "it does not rock"
        below = self.support_acceleration < self.rocking_onset
        share = "" if self.rocking_share == 1 else f" under {round(self.rocking_share * runs)} of {runs}"
        return f"it rocks{share}{', as its first branch vibrates' if below else ''}"


def checks(
    answer: xr.Dataset,
    wall: Wall | Parapet | OneSidedWall,
    curve: TrilinearCurve,
    motions: Sequence[GroundMotion],
) -> list[Check]:
    """Return the checks at each intensity of what `assess` returned for a wall under motions.

    Parameters
    ----------
    answer : xarray.Dataset
    wall : Wall, Parapet or OneSidedWall
    curve : TrilinearCurve
    motions : sequence of GroundMotion
        Those that `assess` was given.
    """
    measure = answer.attrs["intensity_measure"].lower()
    cr, u_ins = answer.sel(damping_model=REFERENCE), float(wall.instability_displacement)
    median = float(cr[f"median_{measure}"])
    shaken_by = add_reversed(motions) if isinstance(wall, OneSidedWall) else motions
    support = np.array([intensity_measures(motion.record).pga for motion in shaken_by])
    found = []
    for index, intensity in enumerate(answer[measure].values.tolist()):
        at = cr.isel(intensity=index)
        peaks = u_ins * at["peak"].fillna(np.inf).values
        shaken = support * at["scale_factor"].values
        found.append(
            Check(
                intensity,
                median / intensity,
                float(np.median(shaken)),
                float(answer["rocking_onset"]),
                float(np.mean(peaks > u_ins * float(curve.yield_displacement_ratio))),
                *(_not_passed(peaks, share) for share in (0.5, UPPER)),
            )
        )
    return found


def _not_passed(peaks: np.ndarray[tuple[int, ...], np.dtype[np.float64]], share: float) -> float:
    """Return the least peak that at least a share of the records does not pass."""
    return float(np.quantile(peaks, share, method="inverted_cdf"))


# --- how much the answer moves ----------------------------------------------------------------------------------------

CHANGE_OF_E, CHANGE_OF_HINGE = 0.05, 0.1  # what is left open without a test of the wall
FACTORS = (0.5, 2.0)  # on a1 and on the overburden
PERIOD_FACTORS = (0.7, 1.4)  # on the period of the building and of the diaphragm
FIRST_DIAPHRAGM = 0.3  # period of a timber floor, in place of a rigid one [s]
FIRST_OVERBURDEN = 0.5  # O/W in place of none
HIGHEST_E = 0.99


class Moved(NamedTuple):
    """The answer after one change: its name, the value, the share of collapses and the median, with restitution."""

    name: str
    value: float
    share: float
    median: float


def sensitivity(
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    restitution: float,
    motions: Sequence[GroundMotion],
    measure: str,
    intensity: float,
    tail: float,
    building: Building | None = None,
    diaphragm: Diaphragm | None = None,
) -> list[Moved]:
    """Assess the wall again with one input changed at a time, under restitution; what makes no wall is left out.

    In a `building`, or under a `diaphragm`, the period of each is changed too; a wall under a rigid floor is also put
    under a flexible one.
    """
    made = [(name, value, changed, building, diaphragm) for name, value, changed in _changes(wall, curve, restitution)]
    same = (wall, curve, restitution)
    for other in (
        [] if building is None else [replace(building, period=factor * building.period) for factor in PERIOD_FACTORS]
    ):
        made.append(("period of the building [s]", other.period, same, other, diaphragm))
    measured = building is None and any(isinstance(motion.record, SupportRecord) for motion in motions)
    periods = [] if measured or isinstance(wall, Parapet) else [FIRST_DIAPHRAGM]
    if diaphragm is not None:
        periods = [factor * diaphragm.period for factor in PERIOD_FACTORS]
    for period in periods:
        floor = Diaphragm(period) if diaphragm is None else replace(diaphragm, period=period)
        made.append(("period of a flexible floor [s]", period, same, building, floor))
    moved = []
    for placed in dict.fromkeys(change[3] for change in made):
        here = [change for change in made if change[3] == placed]
        rows = [Row(i, str(i), *change, diaphragm=floor) for i, (_, _, change, _, floor) in enumerate(here)]
        buildings = [] if placed is None else [placed]
        answer = assess_rows(rows, motions, measure, intensity, tail=tail, buildings=buildings)
        cr = answer.sel(damping_model=REFERENCE)
        values = zip(here, cr["collapse_probability"].values, cr[f"median_{measure.lower()}"].values, strict=True)
        moved += [Moved(name, value, float(share), float(median)) for (name, value, *_), share, median in values]
    return [one for one in moved if np.isfinite(one.share)]


Changed = tuple[Wall | Parapet, TrilinearCurve, float]
Change = tuple[str, float, Changed]


def _changes(wall: Wall | Parapet, curve: TrilinearCurve, e: float) -> Iterator[Change]:
    for value in (e - CHANGE_OF_E, min(e + CHANGE_OF_E, HIGHEST_E)):
        yield from _made("coefficient of restitution, e", value, lambda v: (wall, curve, v))
    if isinstance(wall, Wall):
        hinge = float(wall.hinge_ratio)
        for value in (hinge - CHANGE_OF_HINGE, hinge + CHANGE_OF_HINGE):
            yield from _made("height of the hinge, h₁/h", value, lambda v: (replace(wall, hinge_ratio=v), curve, e))
    for factor in FACTORS:
        value = factor * float(curve.yield_displacement_ratio)
        name = "yield displacement ratio, a₁"
        yield from _made(name, value, lambda v: (wall, replace(curve, yield_displacement_ratio=v), e))
    loaded = float(wall.overburden_ratio)
    for value in [factor * loaded for factor in FACTORS] if loaded else [FIRST_OVERBURDEN]:
        yield from _made("overburden, O/W", value, lambda v: (replace(wall, overburden_ratio=v), curve, e))
    if isinstance(wall, Wall) and loaded:
        value = 0.0 if float(wall.overburden_mass) else 1.0  # with the same e, by its inertia alone
        name = "part of the overburden that moves as a mass"
        yield from _made(name, value, lambda v: (replace(wall, overburden_mass=v), curve, e))


def _made(name: str, value: float, make: Callable[[float], Changed]) -> Iterator[Change]:
    """Yield the change, unless there is no such wall."""
    try:
        made = make(value)
    except InputError:
        return
    if made[2] > 0:
        yield name, value, made
