"""Collapses of walls under records: at the intensities asked for, and at stripes that span each wall's fragility."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.constants import RECOMMENDED, VISCOUS_MODELS
from rockdamp.histories.loads import run_record
from rockdamp.histories.one_sided import run_one_sided
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.dampers import CAP, critical_damping_ratio
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.specimen import AnyWall, Specimen
from rockdamp.mechanics.wall import OneSidedWall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.record import Record
from rockdamp.progress import track
from rockdamp.solvers.blocks import available_threads

UNITS = {"PGV": "m s-1", "PGA": "m s-2"}
ORDER = (
    16  # of ECD, which stands beside restitution where the loss has an exponent: BAND takes none
)
STEP = 0.05  # of the solver, times the first branch's angular frequency, at most; a quarter of it near collapse
TAIL = 3.0  # rest after a record [s]
# Of the stripes: lambda PGV/(p u_ins). The medians of the eight walls of config/default.yaml lie between 0.57 and 2.0,
# and twice their dispersions span a factor of 2.6 to either side: a test holds the stripes to be beyond it.
STRIPES = np.geomspace(0.15, 8.0, 16)
NEAR = 0.5  # u/u_ins, from which on a wall that survives is near collapse; the study of earthquakes has it too
HALVINGS = 2  # of the step near collapse; the last one shows what is left of the error
LEAST_OF_DAMPER = 1.01 * float(
    np.exp(-np.pi * CAP * critical_damping_ratio(ORDER))
)  # e that the damper is run with

Outcomes = tuple[Array, NDArray[np.bool_], NDArray[np.bool_]]


def damping_pair(wall: Any, restitution: ArrayLike, **loss: float) -> list[Damping]:
    """Return restitution and the damper that is recommended in its place; against a stop restitution alone.

    `loss` holds the exponent and the reference amplitude of `Damping`.
    """
    cr = Damping("CR", restitution, **loss)
    if isinstance(wall, OneSidedWall):
        return [cr]
    e = np.maximum(restitution, LEAST_OF_DAMPER)
    if not loss.get("loss_exponent"):
        return [cr, Damping.from_restitution(e, RECOMMENDED)]
    return [cr, Damping.from_restitution(e, "ECD", order=ORDER, **loss)]


def collapses(
    wall: AnyWall,
    curve: TrilinearCurve,
    dampings: Sequence[Damping],
    motions: Sequence[GroundMotion],
    measure: str,
    intensity: Array,
    *,
    step: float = STEP,
    tail: float = TAIL,
) -> xr.Dataset:
    """Run walls with each damper under records, scaled to the intensities asked for and to stripes.

    Parameters
    ----------
    wall, curve, dampings : Wall, Parapet or OneSidedWall, TrilinearCurve, list of Damping
        Of numbers, or of arrays of shape (walls,); against a stop of one wall.
    motions : sequence of GroundMotion
    measure, intensity : str, ndarray
        PGV [m s-1] or PGA [m s-2], and the levels asked for.
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
    supports = [intensity_measures(motion.record) for motion in motions]
    levels = np.array(
        [
            getattr(intensity_measures(motion.intensity_record), measure.lower())
            for motion in motions
        ]
    )
    stripe = np.atleast_1d(wall.velocity_scale)[:, None] * STRIPES
    stripe = stripe * np.median(levels / [level.pgv for level in supports])
    walls = np.broadcast_shapes(
        stripe.shape[:1], curve.shape, *(damping.shape for damping in dampings)
    )[0]
    stripe = np.broadcast_to(stripe, (walls, STRIPES.size))
    wanted = np.concatenate([np.broadcast_to(intensity, (walls, intensity.size)), stripe], axis=1)
    specimens = [Specimen(wall, curve, damping) for damping in dampings]
    peaks, runs = [], []
    for motion, level in zip(track(motions, "Records"), levels, strict=True):
        peak, *outcomes = run_outcomes(
            motion.record, specimens, wanted / level, step=step, tail=tail
        )
        # Of the stripes the peaks are not kept: memory grows with walls and records alone.
        peaks.append(np.where(outcomes[0], np.nan, peak)[:, : intensity.size])
        runs.append(outcomes)
    collapsed, coarser = np.stack(runs, axis=1)
    at, stripes = (("record", "wall", level, "damping_model") for level in ("intensity", "stripe"))
    ratio = [each.value if each.model in VISCOUS_MODELS else np.nan for each in dampings]
    return xr.Dataset(
        {
            "peak": (at, np.stack(peaks)),
            "collapsed": (at, collapsed[:, :, : intensity.size]),
            "stripe_collapsed": (stripes, collapsed[:, :, intensity.size :]),
            "stripe_coarser": (stripes, coarser[:, :, intensity.size :]),
            "stripe_intensity": (("wall", "stripe"), stripe),
            "asked": ("intensity", intensity),
            "scale_factor": (("record", "intensity"), intensity / levels[:, None]),
            "damping_ratio": (
                ("damping_model", "wall"),
                np.array([np.broadcast_to(each, walls) for each in ratio]),
            ),
        },
        coords={"damping_model": [damping.label for damping in dampings]},
    )


def run_outcomes(
    record: Record,
    specimens: Sequence[Specimen],
    factor: Array,
    *,
    step: float,
    tail: float,
) -> Outcomes:
    """Return peaks [-] and collapses under a record at each factor, and the collapses at twice the finest step.

    `specimens` are the same walls and curves with each damping. The shape of `factor` is (walls, factors), that of the
    results (walls, factors, dampings). Against a stop there is one wall, which is solved event by event, without a
    step.
    """
    if not isinstance(specimens[0].wall, OneSidedWall):
        return refined(record, specimens, factor, step=step, tail=tail)
    threads = available_threads()
    ended = [
        run_one_sided(record, specimen.take(0), factor[0], tail=tail, threads=threads)
        for specimen in specimens
    ]
    peak, fell = (
        np.array([[getattr(end, name) for end in ends] for ends in ended]).T[None]
        for name in ("peak", "collapsed")
    )
    return peak, fell, fell


# --- a finer step near collapse ---------------------------------------------------------------------------------------


def refined(
    record: Record,
    specimens: Sequence[Specimen],
    factor: Array,
    *,
    step: float,
    tail: float,
) -> tuple[Array, NDArray[np.bool_], NDArray[np.bool_]]:
    """Run walls with each damper under a record at each factor, at a finer step near collapse.

    Arguments are as for `run_record`, with `factor` of the shape (walls, factors). Returned are the peaks [-]
    and collapses at the finest step, and the collapses at twice that step, shape (walls, factors, dampings).
    """
    ended = [run_record(record, specimen, factor.T, step=step, tail=tail) for specimen in specimens]
    peak, collapsed = (
        np.stack([getattr(end, name).T for end in ended], axis=-1) for name in ("peak", "collapsed")
    )
    coarser = collapsed.copy()
    near = near_to_collapse(peak, collapsed, factor)
    for column, specimen in enumerate(specimens):
        walls, levels = np.nonzero(near[..., column])
        if not walls.size:
            continue
        # Those that collapsed stand together: the kernel leaves a block that has collapsed.
        collapsed_last = np.argsort(collapsed[walls, levels, column], kind="stable")
        walls, levels = walls[collapsed_last], levels[collapsed_last]
        lane, lanes = (walls, levels, column), specimen.take(walls)
        for halvings in range(1, HALVINGS + 1):
            coarser[lane] = collapsed[lane]
            finer = run_record(
                record, lanes, factor[walls, levels], step=step, tail=tail, halvings=halvings
            )
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
