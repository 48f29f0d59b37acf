"""Walls under many loads, pulses or records: how each history ends and how far it comes, without the history itself."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from operator import itemgetter

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.histories.forcing import Forcing, require_affordable, substeps_of
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.pulse_shapes import PULSES, pulse
from rockdamp.motions.records import Record, followed_by_rest
from rockdamp.progress import track
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.response import COLLAPSED, Peaks

CELLS = ("pulse", "pulse_frequency", "load_ratio")
HISTORIES = ("record", "velocity_ratio", "wall")


def under_pulses(
    curve: TrilinearCurve,
    dampings: Mapping[str, Damping],
    frequency: Array,
    load: Array,
    *,
    step: float,
    tail: float,
    plateau: float | None = None,
    dims: Sequence[str] = (),
    description: str = "",
) -> xr.Dataset:
    """Run curves with each damper under pulses of every shape, frequency and load.

    Parameters
    ----------
    curve, dampings : TrilinearCurve and Damping by name
        Of numbers, or of arrays that broadcast to the dimensions that `dims` names.
    frequency, load : ndarray
        Angular frequency over p, and the peak of the load over the plateau. [-]
    step, tail : float
        Step of the solver and rest after the pulse, in tau. [-]
    plateau : float, optional
        By default that of the curve. [-]
    dims : sequence of str
        Names of the dimensions of curves and dampers.

    Returns
    -------
    xarray.Dataset
        ``peak`` and ``collapsed``, as `solve` with `peaks_only` has them, over ``damping_model``, `CELLS` and `dims`.
    """
    b1 = float(curve.strength_ratio) if plateau is None else plateau
    shape = np.broadcast_shapes(curve.shape, *(damping.shape for damping in dampings.values()))
    ends = _Ends(len(dampings), len(PULSES), frequency.size, load.size, *shape)
    for i, name in enumerate(PULSES):
        for j, w in enumerate(track(frequency, f"{name} pulses{description}")):
            forcing = pulse_load(name, float(w), b1 * load.reshape(-1, *(1 for _ in shape)), step, tail)
            for row, damping in enumerate(dampings.values()):
                ends[row, i, j] = solve(curve, damping, peaks_only=True, **forcing.newmark())
    coords = {"pulse": list(PULSES), "pulse_frequency": frequency, "load_ratio": load}
    return ends.dataset(("damping_model", *CELLS, *dims), {"damping_model": list(dampings), **coords})


def pulse_load(name: str, frequency: float, peak: Array, step: float, tail: float) -> Forcing:
    """Return a pulse of some peaks as the load, sampled at the solver's step, with the rest after it. [-]"""
    return Forcing(followed_by_rest(pulse(name, frequency, step), step, tail), step, peak)


def under_records(
    motions: Iterable[GroundMotion],
    walls: Mapping[str, tuple[Wall | Parapet, TrilinearCurve]],
    dampings: Mapping[str, Damping],
    velocity_ratio: Array,
    *,
    step: float,
    tail: float,
    halvings: int = 0,
    dims: Sequence[str] = (),
) -> xr.Dataset:
    """Run walls with each damper under records that are scaled to velocity ratios, lambda PGV/(p u_ins).

    Parameters
    ----------
    motions : iterable of GroundMotion
    walls : wall and curve by name
    dampings : Damping by name
        Of numbers, or of arrays of one shape, whose dimensions `dims` names.
    velocity_ratio : ndarray
        [-]
    step : float
        Longest step, times the angular frequency of the curve's first branch, before it is halved `halvings` times. [-]
    tail : float
        Rest after the record. [s]
    dims : sequence of str
        Names of the dimensions of the dampers.

    Returns
    -------
    xarray.Dataset
        ``peak`` and ``collapsed`` over ``damping_model``, `HISTORIES` and `dims`, with ``record_set`` and ``station``.
    """
    together, names = [], []
    for motion in motions:
        pgv = intensity_measures(motion.intensity_record).pgv
        names.append((motion.name, motion.record_set, motion.group))
        shape = np.broadcast_shapes(*(damping.shape for damping in dampings.values()))
        ends = _Ends(len(dampings), len(walls), velocity_ratio.size, *shape)
        for column, (wall, curve) in enumerate(walls.values()):
            factor = (velocity_ratio * wall.velocity_scale / pgv).reshape(-1, *(1 for _ in shape))
            forcing = Forcing.of(wall, motion.record, factor, rest=tail)
            substeps = forcing.substeps(step / curve.initial_frequency) * 2**halvings
            for row, damping in enumerate(dampings.values()):
                ends[row, column] = solve(curve, damping, peaks_only=True, **forcing.newmark(substeps))
        together.append(ends.dataset(("damping_model", "wall", "velocity_ratio", *dims), {}))
    name, record_set, station = zip(*names, strict=True)
    by_record = {"record": list(name), "record_set": ("record", list(record_set)), "station": ("record", list(station))}
    coords = {"damping_model": list(dampings), "wall": list(walls), "velocity_ratio": velocity_ratio, **by_record}
    return xr.concat(together, "record").transpose("damping_model", *HISTORIES, ...).assign_coords(coords)


class _Ends:
    """Peaks and outcomes of histories, filled in one batch after the other."""

    def __init__(self, *shape: int) -> None:
        self.peak, self.collapsed = np.empty(shape), np.empty(shape, dtype=np.int8)

    def __setitem__(self, at: tuple[int, ...], ended: Peaks) -> None:
        self.peak[at], self.collapsed[at] = ended.peak, ended.outcome == COLLAPSED

    def dataset(self, dims: Sequence[str], coords: Mapping[str, object]) -> xr.Dataset:
        """Name them."""
        return xr.Dataset({"peak": (dims, self.peak), "collapsed": (dims, self.collapsed)}, coords=coords)


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
    forcing = Forcing.of(wall, record, factor.T, rest=tail)
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
            response = solve(
                curve.map(itemgetter(walls)), damping.map(spread).map(itemgetter(walls)), peaks_only=True, **alike
            )
            peak[walls, :, column], collapsed[walls, :, column] = response.peak.T, (response.outcome == COLLAPSED).T
    return peak, collapsed
