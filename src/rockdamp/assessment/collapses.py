"""Collapses of walls under records: at the intensities asked for, and at stripes that span each wall's fragility.

Of walls that rock to one side too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.constants import RECOMMENDED, REFERENCE, VISCOUS_MODELS
from rockdamp.errors import check
from rockdamp.histories.loads import run_record, select
from rockdamp.histories.one_sided import run_one_sided
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import CAP, REFERENCE_AMPLITUDE, Damping, critical_damping_ratio
from rockdamp.mechanics.one_sided import OneSidedWall
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.record import Record
from rockdamp.progress import track
from rockdamp.solvers.newmark import available_threads

UNITS = {"PGV": "m s-1", "PGA": "m s-2"}
ORDER = 16  # of ECD, which stands beside restitution where the loss has an exponent: BAND takes none
STEP = 0.05  # of the solver, times the first branch's angular frequency, at most; a quarter of it near collapse
TAIL = 3.0  # rest after a record [s]
# Of the stripes: lambda PGV/(p u_ins). The medians of the eight walls of config/default.yaml lie between 0.57 and 2.0,
# and twice their dispersions span a factor of 2.6 to either side: a test holds the stripes to be beyond it.
STRIPES = np.geomspace(0.15, 8.0, 16)
NEAR = 0.5  # u/u_ins, from which on a wall that survives is near collapse; the study of earthquakes has it too
HALVINGS = 2  # of the step near collapse; the last one shows what is left of the error
LEAST_OF_DAMPER = 1.01 * float(np.exp(-np.pi * CAP * critical_damping_ratio(ORDER)))  # e that the damper is run with


class Loss(NamedTuple):
    """How the loss depends on the amplitude: the exponent g [-], and the amplitude u/u_ins that e belongs to [-]."""

    exponent: float = 0.0
    at: float = REFERENCE_AMPLITUDE


CONSTANT = Loss()


def side_by_side(restitution: ArrayLike, loss: Loss = CONSTANT) -> list[Damping]:
    """Return restitution and the damper that is recommended in its place, of `LEAST_OF_DAMPER` at least."""
    e = np.maximum(restitution, LEAST_OF_DAMPER)
    if not loss.exponent:
        return [Damping("CR", restitution), Damping.from_restitution(e, RECOMMENDED)]
    named = {"loss_exponent": loss.exponent, "reference_amplitude": loss.at}
    return [Damping("CR", restitution, **named), Damping.from_restitution(e, "ECD", order=ORDER, **named)]


def collapses(
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    restitution: ArrayLike,
    motions: Sequence[GroundMotion],
    measure: str,
    intensity: Array,
    *,
    loss: Loss = CONSTANT,
    step: float = STEP,
    tail: float = TAIL,
) -> xr.Dataset:
    """Run walls with each damper of `side_by_side` under records, scaled to the intensities asked for and to stripes.

    Parameters
    ----------
    wall, curve, restitution : Wall or Parapet, TrilinearCurve, float or ndarray
        Of numbers, or of arrays of shape (walls,).
    measure, intensity : str, ndarray
        PGV [m s-1] or PGA [m s-2], and the levels asked for.
    loss : Loss
        Of all walls alike; that of one e, if not given.
    step, tail : float
        The solver's longest step, times the angular frequency of the first branch: it is refined near collapse. [-]
        Rest after each record. [s]

    Returns
    -------
    xarray.Dataset
        By ``wall``, ``damping_model``, ``record`` and ``intensity``: ``peak``, the largest \\|u\\|/u_ins, NaN where the
        wall collapses, and ``collapsed``. By stripe ``stripe_collapsed``, and ``stripe_coarser``, the same at twice the
        finest step of each history, at each wall's ``stripe_intensity``. ``scale_factor`` are the factors on the
        records' accelerations.
    """
    dampings = side_by_side(restitution, loss)
    supports = [intensity_measures(motion.record) for motion in motions]
    levels = np.array([getattr(intensity_measures(motion.intensity_record), measure.lower()) for motion in motions])
    stripe = np.atleast_1d(wall.velocity_scale)[:, None] * STRIPES
    stripe = stripe * np.median(levels / [level.pgv for level in supports])
    walls = np.broadcast_shapes(stripe.shape[:1], curve.shape, *(damping.shape for damping in dampings))[0]
    stripe = np.broadcast_to(stripe, (walls, STRIPES.size))
    wanted = np.concatenate([np.broadcast_to(intensity, (walls, intensity.size)), stripe], axis=1)
    peaks, runs = [], []
    for motion, level in zip(track(motions, "Records"), levels, strict=True):
        peak, *outcomes = refined(motion.record, wall, curve, dampings, wanted / level, step=step, tail=tail)
        # Of the stripes the peaks are not kept: memory grows with walls and records alone.
        peaks.append(np.where(outcomes[0], np.nan, peak)[:, : intensity.size])
        runs.append(outcomes)
    collapsed, coarser = np.stack(runs, axis=1)
    dims, asked = ("record", "wall", "level", "damping_model"), slice(None, intensity.size)
    factor = intensity / levels[:, None]
    at, stripes = (*dims[:2], "intensity", dims[3]), (*dims[:2], "stripe", dims[3])
    by_wall = {
        name: [
            np.broadcast_to(getattr(damping, field) if damping.model in models else np.nan, walls)
            for damping in dampings
        ]
        for name, field, models in (("damping_ratio", "value", VISCOUS_MODELS), ("order", "order", ("ECD",)))
    }
    return xr.Dataset(
        {
            "peak": (at, np.stack(peaks)),
            "collapsed": (at, collapsed[:, :, asked]),
            "stripe_collapsed": (stripes, collapsed[:, :, intensity.size :]),
            "stripe_coarser": (stripes, coarser[:, :, intensity.size :]),
            "stripe_intensity": (("wall", "stripe"), stripe),
            "asked": ("intensity", intensity),
            "scale_factor": (("record", "intensity"), factor),
            **{name: (("damping_model", "wall"), np.array(values)) for name, values in by_wall.items()},
        },
        coords={"damping_model": [damping.model for damping in dampings]},
    )


# --- a finer step near collapse ---------------------------------------------------------------------------------------


def refined(
    record: Record,
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    dampings: Sequence[Damping],
    factor: Array,
    *,
    step: float,
    tail: float,
) -> tuple[Array, NDArray[np.bool_], NDArray[np.bool_]]:
    """Run walls with each damper under a record at each factor, at a finer step near collapse.

    Arguments are as for `run_record`, with `factor` of the shape (walls, factors). Returned are the peaks [-]
    and collapses at the finest step, and the collapses at twice that step, shape (walls, factors, dampings).
    """
    ended = [run_record(record, wall, curve, damping, factor.T, step=step, tail=tail) for damping in dampings]
    peak, collapsed = (np.stack([getattr(end, name).T for end in ended], axis=-1) for name in ("peak", "collapsed"))
    coarser = collapsed.copy()
    near = near_to_collapse(peak, collapsed, factor)
    for column, damping in enumerate(dampings):
        walls, levels = np.nonzero(near[..., column])
        if not walls.size:
            continue
        # Those that collapsed stand together: the kernel leaves a block that has collapsed.
        collapsed_last = np.argsort(collapsed[walls, levels, column], kind="stable")
        walls, levels = walls[collapsed_last], levels[collapsed_last]
        lane, count = (walls, levels, column), factor.shape[0]
        lanes = select(wall, count, walls), select(curve, count, walls), select(damping, count, walls)
        for halvings in range(1, HALVINGS + 1):
            coarser[lane] = collapsed[lane]
            finer = run_record(record, *lanes, factor[walls, levels], step=step, tail=tail, halvings=halvings)
            peak[lane], collapsed[lane] = finer.peak, finer.collapsed
    return peak, collapsed, coarser


def near_to_collapse(peak: Array, collapsed: NDArray[np.bool_], factor: Array) -> NDArray[np.bool_]:
    """Return which histories survive with a large peak, or collapse where the next weaker motion does not.

    `peak` and `collapsed` have the shape (walls, factors, dampings), `factor` (walls, factors).
    """
    order = np.argsort(np.abs(factor), axis=1, kind="stable")[..., None]
    ordered = np.take_along_axis(collapsed, order, axis=1)
    first = ordered.copy()
    first[:, 1:] &= ~ordered[:, :-1]
    near = np.empty_like(collapsed)
    np.put_along_axis(near, order, first, axis=1)
    return near | (~collapsed & (peak >= NEAR))


# --- walls that rock to one side --------------------------------------------------------------------------------------


def one_sided_collapses(
    wall: OneSidedWall,
    curve: TrilinearCurve,
    restitution: ArrayLike,
    motions: Sequence[GroundMotion],
    measure: str,
    intensity: Array,
    *,
    loss: Loss = CONSTANT,
    step: float = STEP,
    tail: float = TAIL,
) -> xr.Dataset:
    """Run one wall with restitution, event by event, which takes no step and no loss with an exponent.

    Arguments and result are as of `collapses`, of one wall, without ``stripe_coarser``.
    """
    check("exponent", loss.exponent, lambda g: g == 0, "0 for a wall against a stop")
    curve = curve.map(lambda parameter: parameter.reshape(-1)[0])
    measures = [intensity_measures(motion.record) for motion in motions]
    levels = np.array([getattr(each, measure.lower()) for each in measures])
    stripe = float(wall.velocity_scale) * STRIPES * float(np.median(levels / [each.pgv for each in measures]))
    wanted, asked, threads = np.concatenate([intensity, stripe]), intensity.size, available_threads()
    e = float(np.ravel(restitution)[0])
    ended = [
        run_one_sided(motion.record, wall, curve, e, wanted / level, tail=tail, threads=threads)
        for motion, level in zip(track(motions, "Records"), levels, strict=True)
    ]
    # By record, wall, level and damping model, of which there is one each.
    fell, peak = (
        np.array([[getattr(history, name) for history in row] for row in ended])[:, None, :, None]
        for name in ("collapsed", "peak")
    )
    factor = intensity / levels[:, None]
    at, stripes = ("record", "wall", "intensity", "damping_model"), ("record", "wall", "stripe", "damping_model")
    return xr.Dataset(
        {
            "peak": (at, np.where(fell, np.nan, peak)[:, :, :asked]),
            "collapsed": (at, fell[:, :, :asked]),
            "stripe_collapsed": (stripes, fell[:, :, asked:]),
            "stripe_intensity": (("wall", "stripe"), stripe[None]),
            "asked": ("intensity", intensity),
            "scale_factor": (("record", "intensity"), factor),
            "damping_ratio": (("damping_model", "wall"), [[np.nan]]),
            "order": (("damping_model", "wall"), [[np.nan]]),
        },
        coords={"damping_model": [REFERENCE]},
    )
