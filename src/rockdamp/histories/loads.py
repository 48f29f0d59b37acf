"""A wall under a ground motion: the load that the solvers take, and walls run under a record."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.errors import InputError, check, check_number
from rockdamp.mechanics.specimen import AnyWall, Specimen
from rockdamp.mechanics.wall import OneSidedWall, Parapet, Wall
from rockdamp.motions.record import Record, append_rest
from rockdamp.solvers.newmark import Load, Peaks, peaks

MOST_STEPS = 10_000_000  # of a history: some minutes and 0.1 GB
LONGEST_TAIL = 1000.0  # rest after a record [s]: no wall rocks as long


@dataclass(frozen=True, eq=False)
class SupportRecord(Record):
    """The motion of both supports of a wall; `ground_acceleration` is their mean.

    Parameters
    ----------
    base_acceleration, top_acceleration : ndarray, shape (samples,)
        Absolute accelerations of the supports. [m s-2]
    drift : ndarray, shape (samples,)
        Displacement of the top support relative to the base. [m]
    """

    base_acceleration: Array = field(kw_only=True)
    top_acceleration: Array = field(kw_only=True)
    drift: Array = field(kw_only=True)

    @property
    def motions(self) -> Array:
        """Three motions that add up to the load, times `support_factors`. [m s-2]

        Shape (3, samples): accelerations of base and top, and the tilt of gravity by the drift.
        """
        tilt = -STANDARD_GRAVITY * self.drift
        return np.stack([self.base_acceleration, self.top_acceleration, tilt])


def support_factors(wall: Wall) -> Array:
    """Return the factors of a wall on `SupportRecord.motions`. [-, -, m-1]

    They are (2 - r)/3, (1 + r)/3 and 1/h, with the hinge ratio r and the height h; the docstring of
    `rockdamp.histories.supports` states the load.

    Parameters
    ----------
    wall : Wall
        One wall or many; the factors have the shape (3,) or (3, walls).
    """
    r, h = np.broadcast_arrays(wall.hinge_ratio, wall.height)
    return np.stack([(2 - r) / 3, (1 + r) / 3, 1 / h])


def count_steps(length: ArrayLike, longest: ArrayLike) -> NDArray[np.int64]:
    """Return the fewest equal steps in a length of time, none longer than `longest`.

    Parameters
    ----------
    length : float or ndarray
        Length of time in tau. [-]
    longest : float or ndarray
        Longest step in tau; broadcasts with the length. [-]

    Raises
    ------
    InputError
        If the longest step is not greater than 0, or there would be more than 10 million steps.
    """
    longest = check("step", longest, lambda step: step > 0, "greater than 0")
    rounding = 1e-12  # relative excess over a whole number of steps that is ignored
    exact = np.asarray(length, dtype=float) / longest
    count = np.maximum(np.ceil(exact * (1 - rounding)), 1)
    allowed = f"at most {MOST_STEPS:,}"
    return check("number of steps", count, lambda n: n <= MOST_STEPS, allowed).astype(np.int64)


def check_tail(tail: float) -> float:
    """Return the rest after a record [s]; raise `InputError` unless it is 0 to 1000 s."""
    allowed = f"at least 0 and at most {LONGEST_TAIL:g} s"
    return check_number("tail", tail, lambda x: (x >= 0) & (x <= LONGEST_TAIL), allowed)


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
        One wall, or many in arrays.
    record : Record
        Motion of the ground, or a `SupportRecord` with that of both supports.
    factor : float or ndarray
        Factor on the acceleration; broadcasts with the wall. [-]
    substeps : int
        Steps of the solver between two samples.
    tail : float
        Rest after the record, at most 1000. [s]

    Raises
    ------
    InputError
        For a one-sided wall, and for a parapet under the motion of two supports.
    """
    if isinstance(wall, OneSidedWall):
        raise InputError("the wall is one-sided; it must be a Wall or a Parapet")
    ground = record.ground_acceleration
    factors = wall.load_factor * np.asarray(factor, dtype=float)
    if isinstance(record, SupportRecord):
        if isinstance(wall, Parapet):
            raise InputError(
                "a parapet stands on one floor, and this is a motion of two supports; it must be"
                " one of floor_motions(parapet=True)"
            )
        ground = record.motions
        factors = np.stack([share * factors for share in support_factors(wall)])
    ground = append_rest(ground, record.step, check_tail(tail))
    sampling = wall.frequency_parameter * record.step
    # ASSUME: the motion of a test, measured with the wall's response, is smooth between samples:
    # straight lines would cut off the peaks of a pulse. An accelerogram is linear, as published.
    is_measured_test = record.displacement is not None
    if is_measured_test and substeps > 1:
        ground = _interpolate(ground, substeps)
        sampling = sampling / substeps
        substeps = 1
    return Load(ground, factors, sampling, substeps)


def _interpolate(motion: Array, substeps: int) -> Array:
    """Return the spline through the samples of motions, at `substeps` times as many samples."""
    from scipy.interpolate import CubicSpline  # slow to import, and accelerograms need none

    samples = np.arange(motion.shape[-1])
    spline = CubicSpline(samples, motion, axis=-1)
    return np.asarray(spline(np.arange(samples[-1] * substeps + 1) / substeps))


def sample_load(load: Load) -> dict[str, Any]:
    """Return the arguments of `exact_history` that describe the load on one wall."""
    return {"load": np.tensordot(load.factor, load.ground, 1), "sampling": float(load.sampling)}


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
        Motion of the ground, or of both supports.
    specimen : Specimen
        One wall, or many in arrays of shape (walls,).
    factor : ndarray, shape (levels, walls) or (levels, 1)
        Factors on the acceleration. Levels come first, so that neighbouring lanes of the solver
        collapse together. [-]
    step : float
        Longest step, times the initial frequency w1. [-]
    tail : float
        Rest after the record, at most 1000. [s]
    halvings : int
        Halvings of the step, after it is made a whole part of the record's.
    scheme : {"newmark", "paper"}
        Scheme of the solver, as in `peaks`.

    Returns
    -------
    Peaks
        Arrays of shape (levels, walls).
    """
    sampling = specimen.wall.frequency_parameter * record.step
    substeps = count_steps(sampling * specimen.curve.initial_frequency, step) * 2**halvings
    if substeps.min() == substeps.max():
        load = make_load(specimen.wall, record, factor, substeps=int(substeps.max()), tail=tail)
        return peaks(specimen.curve, specimen.damping, load=load, scheme=scheme)
    # Walls that need equally many steps between two samples are one batch.
    factors = np.asarray(factor, dtype=float)
    factors = np.broadcast_to(factors, (*factors.shape[:-1], substeps.size))
    peak = np.empty(factors.shape)
    collapsed = np.empty(factors.shape, dtype=bool)
    options: dict[str, Any] = {"step": step, "tail": tail, "halvings": halvings, "scheme": scheme}
    for number in np.unique(substeps):
        walls = np.flatnonzero(substeps == number)
        batch = run_record(record, specimen.take(walls), factors[..., walls], **options)
        peak[..., walls] = batch.peak
        collapsed[..., walls] = batch.collapsed
    return Peaks(peak, collapsed)
