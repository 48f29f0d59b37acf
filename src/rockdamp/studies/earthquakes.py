"""Walls under earthquakes: incremental dynamic analyses with restitution and with every damper.

Each record is scaled to the same velocity ratios of each wall, lambda PGV/(p u_ins): the velocity
that the motion gives the wall over the one that carries a rigid wall to its instability. One set of
ratios takes every wall from rest to collapse.

Each history is run at three steps, h, 2h and 4h, with a whole number of them between two samples of
the record. Histories that come near to collapse or end in two ways are run at h/2 and h/4 too. The
finest run is published; the largest change by any halving of the step bounds its error.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config, Earthquakes
from rockdamp.constants import MODELS, REFERENCE, VISCOUS_MODELS
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.equivalence.polynomials import Polynomials
from rockdamp.histories.loads import count_steps
from rockdamp.histories.refinement import RefinedPeaks, run_refined
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

# Sources of the damping ratios: the polynomials, Eq. (17) for the wall itself, and the energy.
SOURCES = ("polynomial", "least error", "closed form")
# Dimensions of the damping ratios of a wall, and of the histories.
RATIO_DIMS = ("restitution", "damping_model", "damping_ratio_source")
HISTORY_DIMS = ("record", "velocity_ratio", "wall", *RATIO_DIMS)
HALVINGS = 2  # of the coarsest step, for every history


# --- the walls ------------------------------------------------------------------------------------


def walls(config: Config, equivalence: xr.Dataset) -> xr.Dataset:
    """Return the walls of the study and the damping ratio of each damper, from each source.

    The ratio is NaN for CR and beyond the range of the polynomials.

    Parameters
    ----------
    config : Config
        Walls, coefficients of restitution and the matching.
    equivalence : xarray.Dataset
        Polynomials of the damping ratio.
    """
    named_walls = study_walls(config)
    bodies = [wall for wall, _ in named_walls.values()]
    curves = [curve for _, curve in named_walls.values()]
    e = np.array(config.earthquakes.restitution)
    ratio = np.full((len(bodies), e.size, len(MODELS), len(SOURCES)), np.nan)
    polynomials = Polynomials.from_dataset(equivalence)
    ratio[:, :, 1:] = _find_damping_ratios(config, stack_parts(curves), e, polynomials)
    sizes = (
        "thickness",
        "height",
        "slenderness",
        "overburden_ratio",
        "instability_displacement",
        "frequency_parameter",
    )
    columns = {name: [float(getattr(wall, name)) for wall in bodies] for name in sizes}
    for name in ("yield_displacement_ratio", "strength_ratio"):
        columns[name] = [float(getattr(curve, name)) for curve in curves]
    w1 = [
        float(wall.frequency_parameter * curve.initial_frequency)
        for wall, curve in named_walls.values()
    ]
    is_parapet = np.array([isinstance(wall, Parapet) for wall in bodies], dtype=np.int8)
    return xr.Dataset(
        {
            "damping_ratio": (("wall", *RATIO_DIMS), ratio),
            **{name: ("wall", values) for name, values in columns.items()},
            "initial_period": ("wall", 2 * np.pi / np.array(w1)),
            "parapet": ("wall", is_parapet),
        },
        coords={
            "wall": list(named_walls),
            "restitution": e,
            "damping_model": list(MODELS),
            "damping_ratio_source": list(SOURCES),
        },
    )


def _find_damping_ratios(
    config: Config, curves: TrilinearCurve, e: Array, polynomials: Polynomials
) -> Array:
    """Return damping ratios, shape (walls, e, viscous models, sources). [-]"""
    a1 = curves.yield_displacement_ratio
    shape = (a1.size, e.size)
    # Lanes are pairs of a wall and an e.
    lane_curves = curves.map(lambda ratio: np.repeat(ratio, e.size))
    lane_e = np.tile(e, a1.size)
    amplitude = np.full(lane_e.size, config.release_amplitude)
    matches = match_decays(
        lane_curves,
        amplitude,
        lane_e,
        VISCOUS_MODELS,
        config.matching,
        config.solver,
        "Damping ratios of the walls",
    )
    ratios = []
    for model in VISCOUS_MODELS:
        polynomial = np.stack([polynomials(model, e, ratio) for ratio in a1])
        least_error = matches[model].damping_ratio.reshape(shape)
        closed_form = damping_ratio_energy(lane_curves, model, lane_e, amplitude).reshape(shape)
        ratios.append([polynomial, least_error, closed_form])
    return np.moveaxis(np.array(ratios), (0, 1), (-2, -1))


# --- the ground motions ---------------------------------------------------------------------------


def chunk(number: str, config: Config, walls: xr.Dataset) -> xr.Dataset:
    """Run every wall under one job's part of the records; jobs are numbered from 0."""
    return shake(config, walls, [load_record(name) for name in chunk_names(number, config)])


def gather(config: Config, walls: xr.Dataset, chunks: Sequence[xr.Dataset]) -> xr.Dataset:
    """Join the walls and the jobs' parts of the records, in the order of the records."""
    joined = xr.concat(
        chunks, "record", data_vars="minimal", coords="minimal", compat="override", join="exact"
    )
    return joined.merge(walls, join="exact", combine_attrs="drop")


def shake(config: Config, walls: xr.Dataset, motions: Sequence[GroundMotion]) -> xr.Dataset:
    """Run every wall, e and damper under each motion at every intensity, and CR with small changes.

    Parameters
    ----------
    config : Config
        Walls, intensities and the solver's step.
    walls : xarray.Dataset
        Walls and damping ratios from `walls`.
    motions : sequence of GroundMotion
        Ground motions.
    """
    earthquakes = config.earthquakes
    named_walls = study_walls(config)
    e = walls["restitution"].values
    velocity_ratio = earthquakes.velocity_ratio.values()
    measures = [intensity_measures(motion.record) for motion in motions]
    pga = np.array([measure.pga for measure in measures])
    pgv = np.array([measure.pgv for measure in measures])
    scale = [float(wall.velocity_scale) for wall, _ in named_walls.values()]
    factor = velocity_ratio[:, None] * scale / pgv[:, None, None]
    cases = vary_restitution(earthquakes, e)
    histories = run(cases, motions, named_walls, velocity_ratio, tail=earthquakes.tail)
    histories = unstack(histories.drop_vars("reference"), cases, "restitution", "variation")
    histories = histories.rename(peak="varied_peak", collapsed="varied_collapsed")
    results = run_dampers(config, walls, motions, factor)
    histories = histories.assign({name: (HISTORY_DIMS, values) for name, values in results.items()})
    return histories.assign(
        scale_factor=(HISTORY_DIMS[:3], factor),
        pga=("record", pga),
        pgv=("record", pgv),
    ).assign_coords(damping_model=list(MODELS), damping_ratio_source=list(SOURCES))


def vary_restitution(earthquakes: Earthquakes, e: Array) -> list[Case]:
    """Return CR at each e with small changes.

    They are a coarser step, the printed treatment of impacts, a lower and a higher e.

    Parameters
    ----------
    earthquakes : Earthquakes
        The study's part of the config.
    e : ndarray, shape (values,)
        Coefficients of restitution. [-]
    """
    coarsest = 2**HALVINGS * earthquakes.step
    change = earthquakes.restitution_change
    cases = []
    for value in e:
        variations: dict[str, tuple[float, dict[str, Any]]] = {
            "step": (value, {}),
            "impact": (value, {"scheme": "paper", "halvings": HALVINGS}),
            "lower e": (value - change, {"halvings": HALVINGS}),
            "higher e": (value + change, {"halvings": HALVINGS}),
        }
        for variation, (restitution, options) in variations.items():
            cases.append(
                Case(
                    f"{variation}, e = {value:g}",
                    use(Damping(REFERENCE, restitution)),
                    coarsest,
                    coordinates={"restitution": value, "variation": variation},
                    **options,
                )
            )
    return cases


def run_dampers(
    config: Config, walls: xr.Dataset, motions: Sequence[GroundMotion], factor: Array
) -> dict[str, NDArray[Any]]:
    """Run CR and every damper that has a ratio, at finer steps near collapse.

    CR has the same histories whatever the source of the dampers' ratios.

    Parameters
    ----------
    config : Config
        Walls and the solver's step.
    walls : xarray.Dataset
        Damping ratios from `walls`.
    motions : sequence of GroundMotion
        Ground motions.
    factor : ndarray, shape (records, intensities, walls)
        Factors on the acceleration. [-]

    Returns
    -------
    dict
        ``peak``, ``peak_uncertainty``, ``collapsed`` and ``converged`` over `HISTORY_DIMS`.
    """
    stacks = stack_specimens(_make_specimens(config, walls))
    shape = (*factor.shape[:2], *walls["damping_ratio"].transpose("wall", *RATIO_DIMS).shape)
    results: dict[str, NDArray[Any]] = {
        "peak": np.full(shape, np.nan),
        "peak_uncertainty": np.full(shape, np.nan),
        "collapsed": np.full(shape, NOT_RUN, dtype=np.int8),
        "converged": np.full(shape, NOT_RUN, dtype=np.int8),
    }
    step = config.earthquakes.step
    for row, motion in enumerate(track(motions, "Dampers under records")):
        for place, specimen in stacks:
            columns = place[0]
            refined = run_refined(
                motion.record,
                specimen,
                factor[row][:, columns],
                find_disagreement,
                step=2**HALVINGS * step,
                tail=config.earthquakes.tail,
                halvings=HALVINGS,
            )
            lanes = (slice(None), *place)  # of the record's intensities
            results["peak"][row][lanes] = refined.peak
            results["peak_uncertainty"][row][lanes] = bound_error(
                refined, motion.record, specimen, step
            )
            results["collapsed"][row][lanes] = refined.collapsed
            results["converged"][row][lanes] = refined.converged
    cr = MODELS.index(REFERENCE)
    for values in results.values():
        values[..., cr, :] = values[..., cr, :1]
    return results


def _make_specimens(config: Config, walls: xr.Dataset) -> Mapping[tuple[int, ...], Specimen]:
    """Return the specimens with a ratio, by wall, e, model and source; CR at the first source."""
    values = walls["damping_ratio"].transpose("wall", *RATIO_DIMS).values.copy()
    values[:, :, MODELS.index(REFERENCE), 0] = walls["restitution"]
    named_walls = list(study_walls(config).values())
    specimens: dict[tuple[int, ...], Specimen] = {}
    for wall, e, model, source in np.argwhere(np.isfinite(values)).tolist():
        damping = Damping(MODELS[model], values[wall, e, model, source])
        specimens[wall, e, model, source] = Specimen(*named_walls[wall], damping)
    return specimens


# --- the error of peaks ---------------------------------------------------------------------------


def find_disagreement(collapsed: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which histories end in two ways.

    Parameters
    ----------
    collapsed : ndarray of bool, shape (runs, ...)
        Outcomes at several steps.
    """
    return (collapsed != collapsed[-1]).any(axis=0)


def bound_error(refined: RefinedPeaks, record: Record, specimen: Specimen, step: float) -> Array:
    """Return the bound of the error of peaks; NaN where a run collapses. [-]

    It is the largest change of the peak by a halving of the step, plus w1h^2/3 of the peak, an
    error that no halving may show: three times the median error of 8000 histories, whose changes,
    plus this, bounded 99.97 % of their errors. w1h is the finest step of a history, times the
    initial frequency w1.

    Parameters
    ----------
    refined : RefinedPeaks
        Histories of the specimen under the record.
    record : Record
        Ground motion.
    specimen : Specimen
        Walls in arrays.
    step : float
        Longest w1h of histories that do not come near to collapse. [-]
    """
    sampling = specimen.wall.frequency_parameter * record.step
    w1 = specimen.curve.initial_frequency
    coarsest = sampling / count_steps(sampling * w1, 2**HALVINGS * step) * w1
    w1h = coarsest / 2.0**refined.halvings
    has_bound = refined.converged & ~refined.collapsed
    return np.where(has_bound, refined.largest_change + w1h**2 / 3 * refined.peak, np.nan)
