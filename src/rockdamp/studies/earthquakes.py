"""Walls under earthquakes: incremental dynamic analyses with restitution and with every damper.

Each record is scaled to the same velocity ratios of each wall, lambda PGV/(p u_ins): the velocity that the motion gives
the wall over the one that carries a rigid wall to its instability. One set of them takes every wall from rest to
collapse.

Each history is run at three steps, h, 2h and 4h, with a whole number of them between two samples of the record. Those
that come near to collapse or end in two ways are run at h/2 and h/4 too. The finest run is published; the largest
change by any halving of the step bounds its error.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config, Earthquakes
from rockdamp.constants import MODELS, REFERENCE, VISCOUS_MODELS
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.equivalence.polynomials import Polynomials
from rockdamp.histories.loads import count_steps, run_record
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.specimen import Specimen, stack_parts
from rockdamp.mechanics.wall import Parapet
from rockdamp.motions.catalogue import GroundMotion, load_record
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.record import Record
from rockdamp.progress import track
from rockdamp.statistics.paired import NOT_RUN
from rockdamp.studies.matches import match_decays
from rockdamp.studies.runner import (
    Case,
    chunk_names,
    run,
    stack_specimens,
    study_walls,
    unstack,
    use,
)

SOURCES = (
    "polynomial",
    "least error",
    "closed form",
)  # of the ratio: polynomials, Eq. (17) at that wall, energy
BY_DAMPER = (
    "record",
    "velocity_ratio",
    "wall",
    "restitution",
    "damping_model",
    "damping_ratio_source",
)
VARIATIONS = ("step", "impact", "lower e", "higher e")  # of CR

# Near collapse the outcome can flip with a tiny change of the step: the wall comes almost to rest where it hardly
# holds, and may fall back or go on. Two steps may take the same side by chance; then one halving of the step changes
# little and says nothing of the error. Hence there are more halvings near collapse, and the largest change counts.
HALVINGS = 2  # of the coarsest step, for every history
FURTHER = 2  # more of them near to collapse
NEAR = 0.5  # u/u_ins, from which on a wall that survives is near to collapse


# --- the walls --------------------------------------------------------------------------------------------------------


def walls(config: Config, equivalence: xr.Dataset) -> xr.Dataset:
    """Return the walls of the study and the damping ratio of each damper, from each source.

    The ratio is NaN for CR and beyond the range of the polynomials.
    """
    owners, curves = zip(*study_walls(config).values(), strict=True)
    e = np.array(config.earthquakes.restitution)
    ratio = np.full((len(owners), e.size, len(MODELS), len(SOURCES)), np.nan)
    ratio[:, :, 1:] = _damping_ratios(
        config, stack_parts(curves), e, Polynomials.from_dataset(equivalence)
    )
    w1 = [
        float(wall.frequency_parameter * curve.initial_frequency)
        for wall, curve in zip(owners, curves, strict=True)
    ]
    sizes = "thickness height slenderness overburden_ratio instability_displacement frequency_parameter".split()
    columns = {name: [float(getattr(wall, name)) for wall in owners] for name in sizes} | {
        name: [float(getattr(curve, name)) for curve in curves]
        for name in ("yield_displacement_ratio", "strength_ratio")
    }
    return xr.Dataset(
        {
            "damping_ratio": (("wall", *BY_DAMPER[3:]), ratio),
            **{name: ("wall", values) for name, values in columns.items()},
            "initial_period": ("wall", 2 * np.pi / np.array(w1)),
            "parapet": (
                "wall",
                np.array([isinstance(wall, Parapet) for wall in owners], dtype=np.int8),
            ),
        },
        coords={
            "wall": list(study_walls(config)),
            "restitution": e,
            "damping_model": list(MODELS),
            "damping_ratio_source": list(SOURCES),
        },
    )


def _damping_ratios(
    config: Config, curves: TrilinearCurve, e: Array, polynomials: Polynomials
) -> Array:
    """Return damping ratios, shape (walls, e, viscous models, sources)."""
    a1, lanes = (
        curves.yield_displacement_ratio,
        curves.map(lambda parameter: np.repeat(parameter, e.size)),
    )
    each_e, amplitude = np.tile(e, a1.size), np.full(e.size * a1.size, config.release_amplitude)
    description = "Damping ratios of the walls"
    matched = match_decays(
        lanes, amplitude, each_e, VISCOUS_MODELS, config.matching, config.solver, description
    )
    ratios = [
        [
            np.stack([polynomials(model, e, ratio) for ratio in a1]),
            matched[model].damping_ratio.reshape(a1.size, e.size),
            damping_ratio_energy(lanes, model, each_e, amplitude).reshape(a1.size, e.size),
        ]
        for model in VISCOUS_MODELS
    ]
    return np.moveaxis(np.array(ratios), (0, 1), (-2, -1))


# --- the ground motions -----------------------------------------------------------------------------------------------


def chunk(number: str, config: Config, walls: xr.Dataset) -> xr.Dataset:
    """Run every wall under one job's part of the records."""
    return shake(config, walls, [load_record(name) for name in chunk_names(number, config)])


def gather(config: Config, walls: xr.Dataset, chunks: Sequence[xr.Dataset]) -> xr.Dataset:
    """Join the walls and the jobs' parts of the records, in the order of the records."""
    joined = xr.concat(
        chunks, "record", data_vars="minimal", coords="minimal", compat="override", join="exact"
    )
    return joined.merge(walls, join="exact", combine_attrs="drop")


def shake(config: Config, walls: xr.Dataset, motions: Sequence[GroundMotion]) -> xr.Dataset:
    """Run every wall, e and damper under each motion at every intensity, and CR with small changes.

    `walls` is what `earthquakes.walls` returned.
    """
    quakes, owners, e = config.earthquakes, study_walls(config), walls["restitution"].values
    intensities = [intensity_measures(motion.record) for motion in motions]
    pga, pgv = (
        np.array([getattr(intensity, name) for intensity in intensities]) for name in ("pga", "pgv")
    )
    scale, velocity_ratio = (
        [float(wall.velocity_scale) for wall, _ in owners.values()],
        quakes.velocity_ratio.values(),
    )
    factor = velocity_ratio[:, None] * scale / pgv[:, None, None]
    varied = run(vary_restitution(quakes, e), motions, owners, velocity_ratio, tail=quakes.tail)
    varied = unstack(varied.drop_vars("reference"), restitution=e, variation=VARIATIONS)
    return (
        varied.rename(peak="varied_peak", collapsed="varied_collapsed")
        .assign(
            {
                name: (BY_DAMPER, values)
                for name, values in run_dampers(config, walls, motions, factor).items()
            }
        )
        .assign(scale_factor=(BY_DAMPER[:3], factor), pga=("record", pga), pgv=("record", pgv))
        .assign_coords(damping_model=list(MODELS), damping_ratio_source=list(SOURCES))
    )


def vary_restitution(quakes: Earthquakes, e: Array) -> list[Case]:
    """Return CR at each e with a coarser step, the printed treatment of impacts, a lower and a higher e."""
    coarsest, change = 2**HALVINGS * quakes.step, quakes.restitution_change
    cases = []
    for value in e:
        names = [f"{variation}, e = {value:g}" for variation in VARIATIONS]
        cr, lower, higher = (
            use(Damping(REFERENCE, value + shift)) for shift in (0.0, -change, change)
        )
        cases += [
            Case(names[0], cr, coarsest),
            Case(names[1], cr, coarsest, scheme="paper", halvings=HALVINGS),
            Case(names[2], lower, coarsest, halvings=HALVINGS),
            Case(names[3], higher, coarsest, halvings=HALVINGS),
        ]
    return cases


def run_dampers(
    config: Config, walls: xr.Dataset, motions: Sequence[GroundMotion], factor: Array
) -> dict[str, NDArray[Any]]:
    """Run CR and every damper that has a ratio by `run_refined`; `factor` has the shape (records, intensities, walls).

    The results are over `BY_DAMPER`. CR has the same histories whatever the source of the dampers' ratios.
    """
    quakes, owners = config.earthquakes, [*study_walls(config).values()]
    value = walls["damping_ratio"].transpose("wall", *BY_DAMPER[3:]).values.copy()
    cr = MODELS.index(REFERENCE)
    value[:, :, cr, 0] = walls["restitution"]
    specimens = {
        (w, i, m, s): Specimen(*owners[w], Damping(MODELS[m], value[w, i, m, s]))
        for w, i, m, s in np.argwhere(np.isfinite(value)).tolist()
    }
    stacks, shape = stack_specimens(specimens), (*factor.shape[:2], *value.shape)
    found: dict[str, NDArray[Any]] = {
        name: np.full(shape, np.nan) for name in ("peak", "peak_uncertainty")
    }
    found |= {name: np.full(shape, NOT_RUN, dtype=np.int8) for name in ("collapsed", "converged")}
    for row, motion in enumerate(track(motions, "Dampers under records")):
        for (w, i, m, s), specimen in stacks:
            outcome = run_refined(
                motion.record, specimen, factor[row][:, w], step=quakes.step, tail=quakes.tail
            )
            for name, values in outcome.items():
                found[name][row][:, w, i, m, s] = values
    for values in found.values():
        values[..., cr, :] = values[..., cr, :1]
    return found


# --- histories and the error of their peaks ---------------------------------------------------------------------------


def run_refined(
    record: Record,
    specimen: Specimen,
    factor: Array,
    *,
    step: float,
    tail: float,
) -> dict[str, Array]:
    """Return the peaks and outcomes of histories at their finest steps, and the bound of the peaks' error.

    The arguments are those of `run_record`, of walls in arrays; `step` is the finest one of histories that do not come
    near to collapse.

    Returns
    -------
    dict
        ``peak``, ``peak_uncertainty``, ``collapsed`` and ``converged``, shape (levels, walls), as `judge` has them.
    """

    def run_halvings(
        specimen: Specimen, factor: Array, first: int, last: int
    ) -> tuple[Array, NDArray[np.bool_]]:
        runs = [
            run_record(record, specimen, factor, step=coarsest, tail=tail, halvings=halvings)
            for halvings in range(first, last + 1)
        ]
        return np.stack([run.peak for run in runs]), np.stack([run.collapsed for run in runs])

    coarsest, finest = 2**HALVINGS * step, HALVINGS + FURTHER
    peak, collapsed = run_halvings(specimen, factor, 0, HALVINGS)
    sampling = specimen.wall.frequency_parameter * record.step
    w1 = specimen.curve.initial_frequency
    w1h = sampling / count_steps(sampling * w1, coarsest) * w1
    outcome = judge(peak, collapsed, w1h / 2**HALVINGS)
    near = (collapsed != collapsed[-1]).any(axis=0) | (~collapsed[-1] & (peak[-1] >= NEAR))
    if near.any():
        # The few of all walls share batches: a block of the kernel takes as long with one lane as with all.
        lane = np.nonzero(near)[1]
        finer_peak, finer_collapsed = run_halvings(
            specimen.take(lane), factor[near][None], HALVINGS + 1, finest
        )
        peak = np.concatenate([peak[:, near], finer_peak[:, 0]])
        collapsed = np.concatenate([collapsed[:, near], finer_collapsed[:, 0]])
        for name, values in judge(peak, collapsed, w1h[lane] / 2**finest).items():
            outcome[name][near] = values
    return outcome


def judge(peak: Array, collapsed: NDArray[np.bool_], w1h: Array) -> dict[str, Array]:
    """Judge histories by their last run and by how it differs from the others, at steps 2, 4, ... times as long.

    Parameters
    ----------
    peak, collapsed : ndarray, shape (runs, ...)
        The coarsest first.
    w1h : ndarray, shape (...)
        The last run's step, times the angular frequency of the first branch. [-]

    Returns
    -------
    dict
        ``peak``, ``collapsed`` and ``converged``, which is 1 where no run ends otherwise; and ``peak_uncertainty``,
        the largest change of the peak by a halving plus w1h^2/3 of it, an error that no halving may show. That is three
        times the median error of 8000 histories, whose changes, plus this, bounded 99.97 % of their errors. NaN where
        a run collapses.
    """
    converged = (collapsed == collapsed[-1]).all(axis=0)
    changes = np.abs(np.diff(peak, axis=0)).max(axis=0)
    return {
        "peak": peak[-1],
        "peak_uncertainty": np.where(
            converged & ~collapsed[-1], changes + w1h**2 / 3 * peak[-1], np.nan
        ),
        "collapsed": collapsed[-1].astype(np.int8),
        "converged": converged.astype(np.int8),
    }
