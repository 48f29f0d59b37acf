"""Intensity measures of a ground motion."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rockdamp.arrays import Array
from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.errors import InputError, check_type
from rockdamp.motions.record import Record


class IntensityMeasures(NamedTuple):
    """Measures of the strength of a ground motion, and its final velocity.

    A final velocity far from 0 shows an uncorrected baseline.
    """

    pga: float
    """Peak ground acceleration, at a sample. [m s-2]"""
    pgv: float
    """Peak ground velocity, at a sample. [m s-1]"""
    pgd: float
    """Peak ground displacement; meaningful only for a record with a corrected baseline. [m]"""
    arias: float
    """Arias intensity. [m s-1]"""
    strong_start: float
    """Time at which the Arias intensity reaches 5 %. [s]"""
    strong_end: float
    """Time at which the Arias intensity reaches 95 %. [s]"""
    end_velocity: float
    """Velocity at the last sample. [m s-1]"""

    @property
    def strong_duration(self) -> float:
        """Significant duration D5-95 (Trifunac and Brady 1975, doi:10.1785/BSSA0650030581). [s]"""
        return self.strong_end - self.strong_start


def intensity_measures(record: Record) -> IntensityMeasures:
    r"""Return the intensity measures of a ground motion, integrated by the trapezoidal rule.

    .. math::
        \mathrm{PGA} = \max \lvert a \rvert, \quad \mathrm{PGV} = \max \left\lvert \int a \,
        \mathrm{d}t \right\rvert, \quad I_A = \frac{\pi}{2 g} \int a^2 \, \mathrm{d}t

    Parameters
    ----------
    record : Record
        Ground motion whose acceleration is not zero throughout.

    Returns
    -------
    IntensityMeasures
        ``pga`` [m s-2], ``pgv`` [m s-1], ``pgd`` [m], ``arias`` [m s-1], ``strong_start``,
        ``strong_end`` and ``strong_duration`` [s], ``end_velocity`` [m s-1].

    Raises
    ------
    InputError
        If the ground acceleration is zero throughout.

    References
    ----------
    Arias A. (1970). A measure of earthquake intensity. In: Hansen R.J. (ed.), *Seismic Design for
    Nuclear Power Plants*, MIT Press, Cambridge, Massachusetts, 438-483.

    Examples
    --------
    The velocity is (1 - cos(2 pi t))/(2 pi), with the peak 1/pi:

    >>> import numpy as np
    >>> import rockdamp as rd
    >>> elapsed = 0.01 * np.arange(201)
    >>> measures = rd.intensity_measures(rd.Record(elapsed, np.sin(2 * np.pi * elapsed)))
    >>> round(measures.pgv, 3), round(measures.strong_duration, 2)
    (0.318, 1.66)
    """
    acceleration = check_type("record", record, Record).ground_acceleration
    if not acceleration.any():
        raise InputError(
            "the ground acceleration is 0 throughout; it must be different from 0 somewhere"
        )
    velocity = _integrate(acceleration, record.step)
    displacement = _integrate(velocity, record.step)
    energy = _integrate(acceleration**2, record.step)
    start, end = np.interp((0.05, 0.95), energy / energy[-1], record.elapsed)
    return IntensityMeasures(
        pga=_peak(acceleration),
        pgv=_peak(velocity),
        pgd=_peak(displacement),
        arias=float(np.pi / (2.0 * STANDARD_GRAVITY) * energy[-1]),
        strong_start=float(start),
        strong_end=float(end),
        end_velocity=float(velocity[-1]),
    )


def _integrate(values: Array, step: float) -> Array:
    """Integrate from zero by the trapezoidal rule.

    The function of scipy does the same; importing it would cost half a second whenever Snakemake
    starts.
    """
    sums = np.cumsum(values[1:] + values[:-1])
    return np.concatenate([[0.0], sums]) * (step / 2.0)


def _peak(values: Array) -> float:
    return float(np.abs(values).max())
