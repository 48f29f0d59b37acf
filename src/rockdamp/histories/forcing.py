"""A wall under a ground motion, without dimensions: the arguments that either solver takes from the two."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypedDict

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array, Quantity
from rockdamp.errors import InputError
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.records import Record, followed_by_rest
from rockdamp.solvers.response import Options
from rockdamp.vocabulary import STANDARD_GRAVITY

MOST_STEPS = 10_000_000  # of one history: some seconds of computation
SPLINE_PARTS = 64  # straight parts between two samples in place of the spline, where a solver knows lines alone
ROUNDING = 1e-12  # a number of steps that exceeds a whole one by less than this part is that whole one


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
        """The three motions whose sum, each times its factor, is the load; shape (3, samples)."""
        return np.stack([self.base_acceleration, self.top_acceleration, -STANDARD_GRAVITY * self.drift])


def support_factors(wall: Wall) -> Array:
    """Return the wall's factors on `SupportRecord.motions`, shape (3, ...) by the shape of its sizes."""
    r, h = np.broadcast_arrays(wall.hinge_ratio, wall.height)
    return np.stack([(2 - r) / 3, (1 + r) / 3, 1 / h])


class Load(TypedDict):
    """The arguments of `event_driven.history` that describe the load."""

    load: Array
    load_step: float


@dataclass(frozen=True)
class Forcing:
    """A ground motion as a load on a wall. The wall starts at rest.

    `ground_acceleration` includes the rest after the motion [m s-2]. `sampling` is p dt, the time between two samples
    in tau; `load_factor` makes the ground acceleration the dimensionless load. [s2 m-1] A `smooth` motion runs along a
    cubic spline between its samples, any other along straight lines. Where both supports move apart, `motions` are what
    loads the wall, shape (motions, samples), and `shares` its factors on each, shape (motions, ...).
    """

    ground_acceleration: Array
    sampling: Quantity
    load_factor: Quantity
    smooth: bool = False
    motions: Array | None = None
    shares: Array | None = None

    @classmethod
    def of(cls, wall: Wall | Parapet, record: Record, factor: ArrayLike = 1.0, *, rest: float = 0.0) -> Forcing:
        """Scale a record by a factor, which broadcasts with the wall, and let `rest` seconds without motion follow."""
        motions = shares = None
        if isinstance(record, SupportRecord):
            if isinstance(wall, Parapet):
                raise InputError(
                    "a parapet stands on one floor; its motions must be those of floor_motions(parapet=True)"
                )
            motions = np.stack([followed_by_rest(each, record.step, rest) for each in record.motions])
            shares = support_factors(wall)
        return cls(
            followed_by_rest(record.ground_acceleration, record.step, rest),
            wall.frequency_parameter * record.step,
            wall.load_factor * np.asarray(factor),
            # ASSUME: the motion of a test, measured with the wall's response, is smooth between its samples: straight
            # lines would cut the peaks of a pulse off. An accelerogram alone is linear, as its publishers process it.
            smooth=record.displacement is not None,
            motions=motions,
            shares=shares,
        )

    @property
    def intervals(self) -> int:
        """Intervals between the samples."""
        return self.ground_acceleration.size - 1

    def substeps(self, longest: ArrayLike) -> int:
        """Return the fewest substeps between two samples no longer than `longest`, in tau, for all walls together."""
        return int(substeps_of(self.sampling, longest).max())

    def newmark(self, substeps: int = 1) -> Options:
        """Return the arguments of `newmark.solve` for so many steps between two samples."""
        return {
            "step": self.sampling / substeps,
            "steps": substeps * self.intervals,
            "load_factor": self._factors(),
            "ground_acceleration": self._every(substeps),
            "substeps": 1 if self.smooth else substeps,
        }

    def _factors(self) -> Quantity:
        """Return the factors on the motion; of several motions they are the first axis."""
        if self.shares is None:
            return self.load_factor
        between = (1,) * (np.ndim(self.load_factor) - self.shares.ndim + 1)
        return self.shares.reshape(len(self.shares), *between, *self.shares.shape[1:]) * self.load_factor

    def event_driven(self) -> Load:
        """Return the arguments of `event_driven.history`, for one wall and one factor."""
        parts = SPLINE_PARTS if self.smooth else 1
        motion, factors = self._every(parts), self._factors()
        load = factors * motion if self.motions is None else np.tensordot(factors, motion, 1)
        return {"load": load, "load_step": float(self.sampling) / parts}

    def _every(self, parts: int) -> Array:
        """Return the motion at so many times for each sample where it is smooth, along the spline; else as it is."""
        if parts == 1 or not self.smooth:
            return self.ground_acceleration if self.motions is None else self.motions
        index = np.arange(self.intervals + 1)
        from scipy.interpolate import CubicSpline  # slow to import, and accelerograms alone need none

        return np.asarray(CubicSpline(index, self.ground_acceleration)(np.arange(self.intervals * parts + 1) / parts))


def substeps_of(sampling: ArrayLike, longest: ArrayLike) -> Array:
    """Return the fewest equal substeps between two samples no longer than `longest`, for each wall of its own.

    They are whole numbers; infinity stands for more than floating point holds. See `require_affordable`.
    """
    with np.errstate(over="ignore"):
        between = np.asarray(sampling, dtype=float) / longest
        return np.maximum(np.ceil(between * (1 - ROUNDING)), 1.0)


def require_affordable(steps: float, cause: str) -> None:
    """Raise `InputError` where a history takes more than `MOST_STEPS`; the cause reads as "length is 1e12"."""
    if not steps <= MOST_STEPS:
        allowed = f"they must be at most {MOST_STEPS:.3g}"
        raise InputError(f"{cause}, and the history would take {steps:.3g} steps of the solver; {allowed}")
