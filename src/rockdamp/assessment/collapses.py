"""Collapses of walls under records, and their statistics.

Each record is scaled to the intensities asked for, and to stripes that span each wall's fragility.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.constants import RECOMMENDED, VISCOUS_MODELS
from rockdamp.histories.one_sided import run_one_sided
from rockdamp.histories.refinement import run_refined
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.half_cycle_loss import CAP, critical_damping_ratio
from rockdamp.mechanics.specimen import AnyWall, Specimen
from rockdamp.mechanics.wall import OneSidedWall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.record import Record
from rockdamp.progress import track
from rockdamp.solvers.blocks import available_threads
from rockdamp.statistics.fragility import (
    Fragility,
    effective_count,
    fit_fragility,
    fit_resampled,
    interval,
    resample,
    wilson,
)

# Intensities, lambda PGV/(p u_ins), with the excitation factor lambda of the wall. The medians of
# the eight walls of config/default.yaml lie between 0.57 and 2.0, and twice their dispersions span
# a factor of 2.6 to either side: a test checks that the stripes reach beyond it.
STRIPES = np.geomspace(0.15, 8.0, 16)
# Order of ECD, the second damper where the loss has an exponent: BAND takes none.
ECD_ORDER = 16
# Least e of the second damper: 1 % above that at which half cycles of ECD would not end.
LEAST_DAMPER_RESTITUTION = 1.01 * float(np.exp(-np.pi * CAP * critical_damping_ratio(ECD_ORDER)))
# A bootstrap over g stations draws one given station alone in a share g^-g of its replicates. Up to
# three stations that share is above 2.5 %: then a bound of the interval is one station's value, and
# says nothing of the others.
FEWEST_STATIONS = 4

# Peaks [-], collapses, and collapses at twice the finest step, shape (walls, factors, dampings).
Outcomes: TypeAlias = tuple[Array, NDArray[np.bool_], NDArray[np.bool_]]


def choose_dampings(wall: AnyWall, restitution: ArrayLike, **law: float) -> list[Damping]:
    """Return restitution and the damper that is recommended in its place.

    Parameters
    ----------
    wall : Wall, Parapet or OneSidedWall
        A one-sided wall has restitution alone.
    restitution : float or ndarray, shape (walls,)
        Coefficient of restitution e. [-]
    **law : float
        ``loss_exponent`` and ``reference_amplitude`` of `Damping`; none for one e at all
        amplitudes.
    """
    cr = Damping("CR", restitution, **law)
    if isinstance(wall, OneSidedWall):
        return [cr]
    e = np.maximum(restitution, LEAST_DAMPER_RESTITUTION)
    if law.get("loss_exponent"):
        return [cr, Damping.from_restitution(e, "ECD", order=ECD_ORDER, **law)]
    return [cr, Damping.from_restitution(e, RECOMMENDED)]


def run_intensities(
    specimens: Sequence[Specimen],
    motions: Sequence[GroundMotion],
    measure: str,
    intensity: Array,
    *,
    step: float,
    tail: float,
) -> xr.Dataset:
    """Run walls with each damping under records, scaled to intensities and to stripes.

    Parameters
    ----------
    specimens : sequence of Specimen
        The same walls and curves with each damping: numbers, or arrays of shape (walls,).
    motions : sequence of GroundMotion
        Motions of the walls' supports.
    measure : {"PGV", "PGA"}
        Intensity measure.
    intensity : ndarray, shape (intensities,)
        Levels asked for. [m s-1 or m s-2]
    step : float
        Longest step of the solver, times the initial frequency w1; it is refined
        near collapse. [-]
    tail : float
        Rest after each record. [s]

    Returns
    -------
    xarray.Dataset
        Over ``wall``, ``damping_model``, ``record`` and ``intensity``: ``peak``, the largest
        \\|u\\|/u_ins, NaN where the wall collapses, and ``collapsed``. By stripe
        ``stripe_collapsed``, and ``stripe_coarser``, the same at twice the finest step of each
        history, at each wall's ``stripe_intensity``. ``scale_factor`` holds the factors on the
        records' accelerations.
    """
    name = measure.lower()
    levels = np.array(
        [getattr(intensity_measures(motion.intensity_record), name) for motion in motions]
    )
    stripe = _place_stripes(specimens, motions, levels)
    walls = len(stripe)
    requested = np.broadcast_to(intensity, (walls, intensity.size))
    targets = np.concatenate([requested, stripe], axis=1)
    peaks = []
    collapses = []
    coarser_collapses = []
    for motion, level in zip(track(motions, "Records"), levels, strict=True):
        peak, collapsed, coarser = run_outcomes(
            motion.record, specimens, targets / level, stripes=STRIPES.size, step=step, tail=tail
        )
        # Peaks at the stripes are not kept: memory grows with walls and records alone.
        peaks.append(np.where(collapsed, np.nan, peak)[:, : intensity.size])
        collapses.append(collapsed)
        coarser_collapses.append(coarser)
    collapsed = np.stack(collapses)
    coarser = np.stack(coarser_collapses)
    dims = ("record", "wall", "intensity", "damping_model")
    stripe_dims = ("record", "wall", "stripe", "damping_model")
    dampings = [specimen.damping for specimen in specimens]
    return xr.Dataset(
        {
            "peak": (dims, np.stack(peaks)),
            "collapsed": (dims, collapsed[:, :, : intensity.size]),
            "stripe_collapsed": (stripe_dims, collapsed[:, :, intensity.size :]),
            "stripe_coarser": (stripe_dims, coarser[:, :, intensity.size :]),
            "stripe_intensity": (("wall", "stripe"), stripe),
            "requested_intensity": ("intensity", intensity),
            "scale_factor": (("record", "intensity"), intensity / levels[:, None]),
            "damping_ratio": (("damping_model", "wall"), _damping_ratios(dampings, walls)),
        },
        coords={"damping_model": [damping.label for damping in dampings]},
    )


def _place_stripes(
    specimens: Sequence[Specimen], motions: Sequence[GroundMotion], levels: Array
) -> Array:
    """Return the intensities of each wall's stripes, shape (walls, stripes). [m s-1 or m s-2]

    `levels` are the intensities of the motions as they are.
    """
    velocity_scale = np.atleast_1d(specimens[0].wall.velocity_scale)
    pgv = [intensity_measures(motion.record).pgv for motion in motions]
    stripe = velocity_scale[:, None] * STRIPES * np.median(levels / pgv)
    (walls,) = np.broadcast_shapes((1,), *(specimen.shape for specimen in specimens))
    return np.broadcast_to(stripe, (walls, STRIPES.size))


def _damping_ratios(dampings: Sequence[Damping], walls: int) -> Array:
    """Return the damping ratio of each damping and wall; NaN for restitution. [-]"""
    ratios = [damping.value if damping.model in VISCOUS_MODELS else np.nan for damping in dampings]
    return np.array([np.broadcast_to(ratio, walls) for ratio in ratios])


def run_outcomes(
    record: Record,
    specimens: Sequence[Specimen],
    factor: Array,
    *,
    stripes: int = 0,
    step: float,
    tail: float,
) -> Outcomes:
    """Return peaks [-] and collapses under a record, and the collapses at twice the finest step.

    Parameters
    ----------
    record : Record
        Motion of the walls' supports.
    specimens : sequence of Specimen
        The same walls and curves with each damping. There is one one-sided wall at most, which is
        solved event by event, without a step.
    factor : ndarray, shape (walls, factors)
        Factors on the acceleration. [-]
    stripes : int
        Number of the last factors that are stripes. No outcome depends on another factor that is
        not a stripe.
    step : float
        Longest step of the solver, times the initial frequency w1; it is refined
        near collapse. [-]
    tail : float
        Rest after the record. [s]
    """
    if isinstance(specimens[0].wall, OneSidedWall):
        return _run_one_sided(record, specimens, factor[0], tail)

    levels = factor.T
    first_stripe = len(levels) - stripes

    def find_doubtful(collapsed: NDArray[np.bool_]) -> NDArray[np.bool_]:
        outcomes = collapsed[-1]
        doubtful = outcomes.copy()
        doubtful[first_stripe:] = find_first_collapses(
            outcomes[first_stripe:], levels[first_stripe:]
        )
        # Any other outcome is compared with the stripes alone, and not with another such outcome.
        for index in range(first_stripe):
            with_stripes = [index, *range(first_stripe, len(levels))]
            first_collapses = find_first_collapses(outcomes[with_stripes], levels[with_stripes])
            doubtful[index] = first_collapses[0]
        return doubtful

    runs = [
        run_refined(record, specimen, levels, find_doubtful, step=step, tail=tail, halvings=0)
        for specimen in specimens
    ]
    return (
        np.stack([peaks.peak.T for peaks in runs], axis=-1),
        np.stack([peaks.collapsed.T for peaks in runs], axis=-1),
        np.stack([peaks.coarser_collapsed.T for peaks in runs], axis=-1),
    )


def _run_one_sided(
    record: Record, specimens: Sequence[Specimen], factor: Array, tail: float
) -> Outcomes:
    """Return the outcomes of a one-sided wall at each factor, shape (1, factors, dampings)."""
    threads = available_threads()
    runs = [
        run_one_sided(record, specimen.take(0), factor, tail=tail, threads=threads)
        for specimen in specimens
    ]
    peak = np.array([[history.peak for history in histories] for histories in runs])
    collapsed = np.array([[history.collapsed for history in histories] for histories in runs])
    return peak.T[None], collapsed.T[None], collapsed.T[None]


def find_first_collapses(collapsed: NDArray[np.bool_], factor: Array) -> NDArray[np.bool_]:
    """Return which histories collapse where the next weaker motion does not.

    Parameters
    ----------
    collapsed : ndarray of bool, shape (levels, walls)
        Outcomes.
    factor : ndarray, shape (levels, walls)
        Factors on the acceleration, in any order; a negative one reverses the motion. [-]
    """
    order = np.argsort(np.abs(factor), axis=0, kind="stable")
    ordered = np.take_along_axis(collapsed, order, axis=0)
    first = ordered.copy()
    first[1:] &= ~ordered[:-1]
    first_collapses = np.empty_like(collapsed)
    np.put_along_axis(first_collapses, order, first, axis=0)
    return first_collapses


# --- from runs to an answer -----------------------------------------------------------------------


def summarise_collapses(runs: xr.Dataset, specimen: Specimen, measure: str) -> xr.Dataset:
    """Return shares of collapses, peaks and fragilities, and the effect of the solver's step.

    Parameters
    ----------
    runs : xarray.Dataset
        Runs from `run_intensities`.
    specimen : Specimen
        Walls and curves of the runs.
    measure : {"PGV", "PGA"}
        Intensity measure.
    """
    name = measure.lower()
    fine = _fit_stripes(runs["stripe_collapsed"])
    coarse = _fit_stripes(runs["stripe_coarser"])
    # Intensity that the stripe 1 stands for: fragilities are fitted to stripes without a unit.
    unit = runs["stripe_intensity"].values[:, :1] / STRIPES[0]
    dims = ("wall", "damping_model")
    collapses = runs["collapsed"].sum("record")
    onset = specimen.wall.rocking_onset(specimen.curve.strength_ratio)
    is_changed = runs["stripe_coarser"] != runs["stripe_collapsed"]
    return xr.Dataset(
        {
            "damping_ratio": runs["damping_ratio"],
            name: runs["requested_intensity"],
            f"stripe_{name}": runs["stripe_intensity"],
            "rocking_onset": ("wall", np.broadcast_to(onset, runs.sizes["wall"])),
            "collapses": collapses,
            "collapse_probability": collapses / runs.sizes["record"],
            "peak_median": find_peak_quantile(runs, 0.5),
            # One standard deviation of a normal distribution above the median.
            "peak_upper": find_peak_quantile(runs, 0.84),
            f"median_{name}": (dims, unit * fine.median),
            "dispersion": (dims, fine.dispersion),
            "stripe_collapses": runs["stripe_collapsed"].sum("record"),
            # The change by the last halving of the step near collapse; NaN where either step
            # defines no fragility.
            "unconverged": is_changed.sum(("record", "stripe")),
            "median_uncertainty": (dims, np.abs(np.log(fine.median / coarse.median))),
            "dispersion_uncertainty": (dims, np.abs(fine.dispersion - coarse.dispersion)),
        }
    )


def _fit_stripes(collapsed: xr.DataArray) -> Fragility:
    """Return the fragility of each wall and damping model by collapses at the stripes."""
    counts = collapsed.sum("record").transpose("wall", "damping_model", "stripe").values
    return fit_fragility(STRIPES, counts, collapsed.sizes["record"])


def find_peak_quantile(runs: xr.Dataset, share: float) -> xr.DataArray:
    """Return the u/u_ins that a share of the records does not pass; NaN for collapse. [-]

    Parameters
    ----------
    runs : xarray.Dataset
        ``peak`` over ``record``, NaN where the wall collapses.
    share : float
        Share of the records, 0 to 1. [-]
    """
    peak = runs["peak"].transpose("record", ...)
    ordered = np.sort(peak.fillna(np.inf).values, axis=0)
    place = share * len(ordered)
    lower = ordered[int(np.ceil(place)) - 1]
    upper = ordered[int(place)]
    values = 0.5 * (lower + upper)
    one_record = runs["peak"].isel(record=0, drop=True)
    return one_record.copy(data=np.where(np.isfinite(values), values, np.nan))


def find_intervals(runs: xr.Dataset, groups: Sequence[str], measure: str) -> xr.Dataset:
    """Return the intervals of one wall's shares and fragilities, by a bootstrap over stations.

    Parameters
    ----------
    runs : xarray.Dataset
        Runs of one wall from `run_intensities`.
    groups : sequence of str
        Station of each record. Intervals are NaN for fewer than four stations.
    measure : {"PGV", "PGA"}
        Intensity measure.
    """
    replicates = 1000
    seed = 695  # any number; a fixed one gives the same interval every time
    mask = 1.0 if len(set(groups)) >= FEWEST_STATIONS else np.nan
    collapsed = runs["collapsed"].transpose("record", "damping_model", ...).values
    stripes = runs["stripe_collapsed"].transpose("record", "damping_model", ...).values
    weights = resample(groups, replicates, seed)
    _, replicate = fit_resampled(STRIPES, stripes, 1, weights)
    effective = effective_count(collapsed, groups, replicates, seed)
    probability = wilson(collapsed.mean(axis=0), effective)
    unit = float(runs["stripe_intensity"][0]) / STRIPES[0]
    dims = ("damping_model", "bound")
    dims_by_level = ("damping_model", "intensity")
    return xr.Dataset(
        {
            "collapse_probability_interval": ((*dims_by_level, "bound"), mask * probability),
            "effective_records": (dims_by_level, effective),
            f"median_{measure.lower()}_interval": (
                dims,
                mask * unit * interval(replicate.median),
            ),
            "dispersion_interval": (dims, mask * interval(replicate.dispersion)),
        }
    )
