"""A wall under a load, a pulse or a record: as either solver takes the two, and how many such histories end."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from operator import itemgetter
from typing import TypedDict

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array, Quantity
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.record import Record, append_rest
from rockdamp.solvers import newmark
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
    """The arguments of `exact_history` that describe the load."""

    load: Array
    sampling: float


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
    def from_record(
        cls, wall: Wall | Parapet, record: Record, factor: ArrayLike = 1.0, *, tail: float = 0.0
    ) -> Forcing:
        """Scale a record by a factor, which broadcasts with the wall, and let `tail` seconds without motion follow."""
        motions = shares = None
        if isinstance(record, SupportRecord):
            if isinstance(wall, Parapet):
                raise InputError(
                    "a parapet stands on one floor, and this is a motion of two supports; it must be one of"
                    " floor_motions(parapet=True)"
                )
            motions = np.stack([append_rest(each, record.step, tail) for each in record.motions])
            shares = support_factors(wall)
        return cls(
            append_rest(record.ground_acceleration, record.step, tail),
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

    def newmark(self, substeps: int = 1) -> newmark.Load:
        """Return the load for so many steps of the solver between two samples."""
        ground, factors = self._every(substeps), self._factors()
        if self.smooth:
            return newmark.Load(ground, factors, self.sampling / substeps)
        return newmark.Load(ground, factors, self.sampling, substeps)

    def _factors(self) -> Quantity:
        """Return the factors on the motion; of several motions they are the first axis."""
        if self.shares is None:
            return self.load_factor
        between = (1,) * (np.ndim(self.load_factor) - self.shares.ndim + 1)
        return self.shares.reshape(len(self.shares), *between, *self.shares.shape[1:]) * self.load_factor

    def event_driven(self) -> Load:
        """Return the arguments of `exact_history`, for one wall and one factor."""
        parts = SPLINE_PARTS if self.smooth else 1
        motion, factors = self._every(parts), self._factors()
        load = factors * motion if self.motions is None else np.tensordot(factors, motion, 1)
        return {"load": load, "sampling": float(self.sampling) / parts}

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


# --- many loads -------------------------------------------------------------------------------------------------------

HISTORIES = ("record", "velocity_ratio", "wall")


def under_records(
    motions: Iterable[GroundMotion],
    walls: Mapping[str, tuple[Wall | Parapet, TrilinearCurve]],
    damping: Damping,
    velocity_ratio: Array,
    *,
    step: float,
    tail: float,
    dim: str,
    scheme: str = "newmark",
) -> xr.Dataset:
    """Run walls with one damper under records that are scaled to velocity ratios, lambda PGV/(p u_ins).

    Parameters
    ----------
    motions : iterable of GroundMotion
    walls : wall and curve by name
    damping : Damping, shape (dampers,)
    velocity_ratio : ndarray
        [-]
    step : float
        Longest step, times the angular frequency of the curve's first branch. [-]
    tail : float
        Rest after the record. [s]
    dim : str
        Name of the dimension of the damper.
    scheme : str
        That of `newmark.peaks`.

    Returns
    -------
    xarray.Dataset
        ``peak`` and ``collapsed`` over `HISTORIES` and `dim`, with ``record_set`` and ``station`` of each record.
    """
    ends, names = [], []
    for motion in motions:
        pgv = intensity_measures(motion.intensity_record).pgv
        names.append((motion.name, motion.record_set, motion.group))
        of_record = []
        for wall, curve in walls.values():
            factor = (velocity_ratio * wall.velocity_scale / pgv)[:, None]
            forcing = Forcing.from_record(wall, motion.record, factor, tail=tail)
            substeps = forcing.substeps(step / curve.initial_frequency)
            of_record.append(newmark.peaks(curve, damping, load=forcing.newmark(substeps), scheme=scheme))
        ends.append(of_record)
    record, record_set, station = (list(each) for each in zip(*names, strict=True))
    shape = (*HISTORIES, dim)
    peak, collapsed = (
        np.stack([np.stack([getattr(end, name) for end in row], axis=1) for row in ends])
        for name in ("peak", "collapsed")
    )
    return xr.Dataset(
        {"peak": (shape, peak), "collapsed": (shape, collapsed.astype(np.int8))},
        coords={
            "record": record,
            "record_set": ("record", record_set),
            "station": ("record", station),
            "velocity_ratio": velocity_ratio,
            "wall": list(walls),
        },
    )


def peaks_and_collapses(
    record: Record,
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    dampings: Sequence[Damping],
    factor: ArrayLike,
    *,
    step: float,
    tail: float,
    halvings: int = 0,
) -> tuple[Array, NDArray[np.bool_]]:
    """Run walls with each damper under a record that is scaled by each factor.

    Parameters of walls, curves and dampers are numbers, or arrays of shape (walls,); `factor` has the shape (factors,)
    or (walls, factors). `step` is the longest, times the angular frequency of the first branch, before it is halved
    `halvings` times; `tail` is the rest after the record. [s] Returned are the largest |u|/u_ins [-], meaningless for a
    wall that collapsed, and whether it did, shape (walls, factors, dampings).
    """
    factor = np.atleast_2d(np.asarray(factor, dtype=float))
    shapes = [damping.shape for damping in dampings]
    count = np.broadcast_shapes(np.shape(wall.load_factor), curve.shape, *shapes, factor.shape[:1], (1,))
    spread = partial(np.broadcast_to, shape=count)
    curve = curve.map(spread)
    forcing = Forcing.from_record(wall, record, factor.T, tail=tail)
    sampling, load_factor = spread(forcing.sampling), np.broadcast_to(forcing.load_factor, (factor.shape[1], *count))
    shares = None if forcing.shares is None else np.broadcast_to(forcing.shares.T, (*count, 3)).T
    needed = substeps_of(sampling * curve.initial_frequency, step) * 2**halvings
    peak, collapsed = (np.empty((*count, factor.shape[1], len(dampings)), dtype=kind) for kind in (float, bool))
    cause = f"p is {np.max(wall.frequency_parameter):.3g} rad/s (the wall may be far smaller than is meant)"
    require_affordable(float(needed.max()) * forcing.intervals, cause)
    substeps = needed.astype(int)
    # Walls that need equally many steps between two samples are one batch. Its first dimension is the intensities: then
    # neighbouring lanes, a block of the kernel, leave it together.
    for many in np.unique(substeps).tolist():
        walls = np.flatnonzero(substeps == many)
        picked = None if shares is None else shares[:, walls]
        lanes = replace(forcing, sampling=sampling[walls], load_factor=load_factor[:, walls], shares=picked)
        alike = lanes.newmark(many)
        for column, damping in enumerate(dampings):
            found = newmark.peaks(curve.map(itemgetter(walls)), damping.map(spread).map(itemgetter(walls)), load=alike)
            peak[walls, :, column], collapsed[walls, :, column] = found.peak.T, found.collapsed.T
    return peak, collapsed
