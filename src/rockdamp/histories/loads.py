"""A wall under a ground motion: the load that the solvers take, and how many such histories end."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.errors import InputError, check
from rockdamp.mechanics.specimen import AnyWall, Specimen
from rockdamp.mechanics.wall import OneSidedWall, Parapet, Wall
from rockdamp.motions.record import Record, append_rest
from rockdamp.solvers.newmark import Load, Peaks, peaks


@dataclass(frozen=True, eq=False)
class SupportRecord(Record):
    """The motion of both supports of a wall; `ground_acceleration` is their mean.

    `base_acceleration` and `top_acceleration` are absolute [m s-2]; `drift` is the displacement of the top support
    relative to that at the base [m]. All have the shape (samples,).
    """

    base_acceleration: Array = field(default_factory=lambda: np.empty(0))
    top_acceleration: Array = field(default_factory=lambda: np.empty(0))
    drift: Array = field(default_factory=lambda: np.empty(0))

    @property
    def motions(self) -> Array:
        """The three motions whose sum, each times its factor, is the load; shape (3, samples). [m s-2]"""
        return np.stack(
            [self.base_acceleration, self.top_acceleration, -STANDARD_GRAVITY * self.drift]
        )


def support_factors(wall: Wall) -> Array:
    """Return the wall's factors on `SupportRecord.motions`, shape (3, ...) by the shape of its sizes. [-]"""
    r, h = np.broadcast_arrays(wall.hinge_ratio, wall.height)
    return np.stack([(2 - r) / 3, (1 + r) / 3, 1 / h])


# --- one motion as a load ---------------------------------------------------------------------------------------------


def count_steps(length: ArrayLike, longest: ArrayLike) -> NDArray[np.int64]:
    """Return the fewest equal steps within a length of time that are no longer than `longest`, both in tau."""
    longest = check("step", longest, lambda step: step > 0, "greater than 0")
    rounding = 1e-12  # part by which a number of steps may exceed a whole one
    count = np.maximum(np.ceil(np.asarray(length, dtype=float) / longest * (1 - rounding)), 1)
    return check("number of steps", count, lambda n: n <= 10_000_000, "at most 10,000,000").astype(
        np.int64
    )


def make_load(
    wall: AnyWall,
    record: Record,
    factor: ArrayLike = 1.0,
    *,
    substeps: int = 1,
    tail: float = 0.0,
) -> Load:
    """Return a record as the load on a wall.

    Parameters
    ----------
    wall : Wall or Parapet
        Of numbers or arrays.
    record : Record
        Of a `SupportRecord` both supports move.
    factor : float or ndarray
        On the acceleration; broadcasts with the wall. [-]
    substeps : int
        Steps of the solver between two samples.
    tail : float
        Rest after the record. [s]
    """
    if isinstance(wall, OneSidedWall):
        raise InputError("the wall is one-sided; it must be a Wall or a Parapet")
    sampling = wall.frequency_parameter * record.step
    ground, factors = record.ground_acceleration, wall.load_factor * np.asarray(factor, dtype=float)
    if isinstance(record, SupportRecord):
        if isinstance(wall, Parapet):
            raise InputError(
                "a parapet stands on one floor, and this is a motion of two supports; it must be one of"
                " floor_motions(parapet=True)"
            )
        ground, factors = (
            record.motions,
            np.stack([share * factors for share in support_factors(wall)]),
        )
    ground = append_rest(ground, record.step, tail)
    # ASSUME: the motion of a test, measured with the wall's response, is smooth between its samples: straight lines
    # would cut the peaks of a pulse off. An accelerogram alone is linear, as its publishers process it.
    if record.displacement is not None and substeps > 1:
        from scipy.interpolate import (
            CubicSpline,
        )  # slow to import, and accelerograms alone need none

        samples = np.arange(ground.shape[-1])
        ground = CubicSpline(samples, ground, axis=-1)(
            np.arange(samples[-1] * substeps + 1) / substeps
        )
        sampling, substeps = sampling / substeps, 1
    return Load(ground, factors, sampling, substeps)


def sample_load(load: Load) -> dict[str, Any]:
    """Return the arguments of `exact_history` that describe the load on one wall."""
    return {"load": np.tensordot(load.factor, load.ground, 1), "sampling": float(load.sampling)}


# --- many walls under one motion --------------------------------------------------------------------------------------


def run_record(
    record: Record,
    specimen: Specimen,
    factor: ArrayLike,
    *,
    step: float,
    tail: float = 0.0,
    halvings: int = 0,
    scheme: str = "newmark",
) -> Peaks:
    """Return the peaks and collapses of walls from rest under a record.

    Parameters
    ----------
    record : Record
    specimen : Specimen
        The walls: one, or as many as its arrays have.
    factor : ndarray, shape (levels, walls), or (levels, 1)
        On the acceleration. Levels come first, so that neighbouring lanes of the solver collapse together. [-]
    step : float
        Longest step, times the angular frequency of the curve's first branch, before it is halved. [-]
    tail : float
        Rest after the record. [s]
    halvings : int
        Of each wall's step.
    scheme : str
        That of `peaks`.
    """
    sampling = specimen.wall.frequency_parameter * record.step
    substeps = count_steps(sampling * specimen.curve.initial_frequency, step) * 2**halvings
    if substeps.min() == substeps.max():
        load = make_load(specimen.wall, record, factor, substeps=int(substeps.max()), tail=tail)
        return peaks(specimen.curve, specimen.damping, load=load, scheme=scheme)
    # Walls that need equally many steps between two samples are one batch.
    factor = np.asarray(factor, dtype=float)
    count = substeps.size
    peak, collapsed = (
        np.empty((*factor.shape[:-1], count)),
        np.empty((*factor.shape[:-1], count), dtype=bool),
    )
    for number in np.unique(substeps):
        picked = np.flatnonzero(substeps == number)
        batch = specimen.take(picked)
        factors = np.broadcast_to(factor, peak.shape)[..., picked]
        ended = run_record(
            record, batch, factors, step=step, tail=tail, halvings=halvings, scheme=scheme
        )
        peak[..., picked], collapsed[..., picked] = ended.peak, ended.collapsed
    return Peaks(peak, collapsed)
