"""Intensity measures of a ground motion, and warnings where its numbers are hardly those of an earthquake."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rockdamp import plausibility, units
from rockdamp.arguments import instance
from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.motions.records import Record
from rockdamp.vocabulary import STANDARD_GRAVITY

STRONG = (0.05, 0.95)  # shares of the Arias intensity that the significant duration lies between
# ASSUME: a record whose final velocity is more than this part of PGV has not been corrected. The largest among the
# 100 horizontals of FEMA P695 is 0.025, while an offset of 0.1 % of g over 40 s gives 0.4 m/s, about PGV itself.
RESIDUAL = 0.1


class IntensityMeasures(NamedTuple):
    """Measures of the strength of a ground motion; peaks are those at the samples.

    Attributes
    ----------
    pga : float
        Peak ground acceleration. [m s-2]
    pgv : float
        Peak ground velocity. [m s-1]
    pgd : float
        Peak ground displacement; it means something for a record with a corrected baseline only. [m]
    arias : float
        Arias intensity, pi/(2 g) times the integral of the squared acceleration (Arias 1970). [m s-1]
    strong_start, strong_end : float
        Times at which 5 % and 95 % of the Arias intensity have come. [s]

    Examples
    --------
    >>> import numpy as np
    >>> import rockdamp as rd
    >>> elapsed = 0.01 * np.arange(201)
    >>> measures = rd.intensity_measures(rd.Record(elapsed, np.sin(2 * np.pi * elapsed)))
    >>> isinstance(measures, rd.IntensityMeasures), round(measures.strong_duration, 2)
    (True, 1.66)
    """

    pga: float
    pgv: float
    pgd: float
    arias: float
    strong_start: float
    strong_end: float

    @property
    def strong_duration(self) -> float:
        """Significant duration D5-95 (Trifunac and Brady 1975, doi:10.1785/BSSA0650030581). [s]"""
        return self.strong_end - self.strong_start


def intensity_measures(record: Record) -> IntensityMeasures:
    r"""Return the intensity measures of a ground motion, integrated by the trapezoidal rule.

    .. math::
        \mathrm{PGA} = \max \lvert a \rvert, \quad \mathrm{PGV} = \max \left\lvert \int a \, \mathrm{d}t \right\rvert,
        \quad I_A = \frac{\pi}{2 g} \int a^2 \, \mathrm{d}t

    Parameters
    ----------
    record : Record
        Of which the ground acceleration is used.

    Returns
    -------
    IntensityMeasures

    Raises
    ------
    InputError
        If the acceleration is zero throughout.

    References
    ----------
    Arias A. (1970). A measure of earthquake intensity. In: Hansen R.J. (ed.), *Seismic Design for Nuclear Power
    Plants*, MIT Press, Cambridge, Massachusetts, 438-483.

    Examples
    --------
    >>> import numpy as np
    >>> import rockdamp as rd
    >>> elapsed = 0.01 * np.arange(201)
    >>> sine = rd.Record(elapsed, np.sin(2 * np.pi * elapsed))
    >>> round(rd.intensity_measures(sine).pgv, 3)  # 1/pi, as the velocity is (1 - cos(2 pi t))/(2 pi)
    0.318
    """
    _check_motion(instance("record", record, Record))
    acceleration = record.ground_acceleration
    velocity = _integral(acceleration, record.step)
    energy = _integral(acceleration**2, record.step)
    start, end = np.interp(STRONG, energy / energy[-1], record.elapsed)
    return IntensityMeasures(
        pga=_peak(acceleration),
        pgv=_peak(velocity),
        pgd=_peak(_integral(velocity, record.step)),
        arias=float(np.pi / (2.0 * STANDARD_GRAVITY) * energy[-1]),
        strong_start=float(start),
        strong_end=float(end),
    )


# --- whether the numbers can be those of an earthquake ----------------------------------------------------------------


def plausible(record: Record, name: str, unit: str = "m s-2") -> list[str]:
    """Return a sentence for each warning about a record: the unit of its accelerations, or its baseline.

    `name` begins each sentence; `unit` is that in which the numbers were read.
    """
    try:
        _check_motion(record)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None
    doubts = [*plausibility.of_step(record.step), *_unit_doubts(record, unit), *_baseline_doubts(record)]
    return [f"{name}: {doubt}" for doubt in doubts]


def _unit_doubts(record: Record, unit: str) -> list[str]:
    pga = _peak(record.ground_acceleration)
    return plausibility.of_motion(pga, unit, units.size(unit, "m s-2") or 1.0)


def _baseline_doubts(record: Record) -> list[str]:
    velocity = _integral(record.ground_acceleration, record.step)
    share = abs(velocity[-1]) / _peak(velocity)
    if share <= RESIDUAL:
        return []
    return [
        f"the ground still moves at {velocity[-1]:.3g} m s-1 at the end, {share:.0%} of PGV, more than {RESIDUAL:.0%}; "
        "the record is cut off or its baseline is not corrected"
    ]


def _check_motion(record: Record) -> None:
    if not record.ground_acceleration.any():
        raise InputError("the ground acceleration is 0 throughout; it must be different from 0 somewhere")


def _integral(values: Array, step: float) -> Array:
    """Integrate from zero by the trapezoidal rule; scipy's would cost half a second whenever snakemake starts."""
    return np.concatenate([[0.0], np.cumsum(values[1:] + values[:-1])]) * (step / 2.0)


def _peak(values: Array) -> float:
    return float(np.abs(values).max())
