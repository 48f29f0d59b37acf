"""Thousands of walls under records: a share of them at a time, so that only the results take memory."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from typing import Any, TypeVar

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.assessment.collapses import STEP, TAIL, collapses
from rockdamp.assessment.one_wall import beside_each_other, last_halving, lognormal, no_fragility
from rockdamp.assessment.table import BadRow, Row
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.plausibility import as_meant, of_level
from rockdamp.progress import counting
from rockdamp.storage.nrml import Collapse
from rockdamp.vocabulary import RECOMMENDED, REFERENCE

WALLS = 256  # that are run at once
MODELS = (REFERENCE, RECOMMENDED)
COLUMNS = (
    "id",
    "damping_model",
    "restitution",
    "damping_ratio",
    "rocking_onset",
    "building_period",
    "collapses",
    "records",
    "collapse_probability",
    "median_intensity",
    "dispersion",
    "peak_ratio_median",
    "unsettled",
    "median_uncertainty",
    "dispersion_uncertainty",
    "reason",
    "error",
)
T = TypeVar("T")


@dataclass(frozen=True)
class Answer:
    """Results for one wall; arrays have the damping models of `MODELS` as their first dimension.

    `rocking_onset` is the ground acceleration whose static load reaches the plateau [m s-2]. `collapses` are of
    `records`, at the intensity asked for; `peak_ratio_median` is NaN where half of the records or more collapse the
    wall. `stripe_share`, shape (damping models, stripes), is the share of records that collapse it at the intensities
    `stripe`. `changes` are what the last halving of the step changed, by name. `strongest` is the largest PGA of the
    scaled records. [m s-2] `building_period` is that of the building, NaN on the ground. [s]
    """

    row: Row
    rocking_onset: float
    damping_ratio: Array
    collapses: Array
    records: int
    median: Array
    dispersion: Array
    peak_ratio_median: Array
    stripe: Array
    stripe_share: Array
    changes: Mapping[str, Array]
    strongest: float
    building_period: float = np.nan


def answers(
    rows: Sequence[Row | BadRow],
    motions: Sequence[GroundMotion],
    measure: str,
    intensity: float,
    *,
    step: float = STEP,
    tail: float = TAIL,
    walls: int = WALLS,
) -> Iterator[Answer | BadRow]:
    """Yield the results for each wall, in the order of the rows; for a row that cannot be computed, why.

    `step` and `tail` are as for `assess`. `walls` run at once; the results do not depend on how many.
    """
    good = sum(isinstance(row, Row) for row in rows)
    with counting(good * len(motions), "Walls under records") as advance:

        def through(motions: Iterable[T], count: int) -> Iterator[T]:
            for motion in motions:
                yield motion
                advance(count)

        def run(wall: Wall | Parapet, curve: TrilinearCurve, e: Array) -> Any:
            dampings = beside_each_other(e)
            options: dict[str, Any] = {"step": step, "tail": tail, "track": partial(through, count=e.size)}
            return dampings, collapses(wall, curve, dampings, motions, measure, np.array([intensity]), **options)

        for start in range(0, len(rows), walls):
            share = rows[start : start + walls]
            results: dict[int, Answer | BadRow] = {row.line: row for row in share if isinstance(row, BadRow)}
            for batch in alike(share):
                results |= {row.line: one for row, one in zip(batch, _of(batch, run), strict=True)}
            yield from (results[row.line] for row in share)


def below_onset(results: Iterable[Answer | BadRow], measure: str, intensity: float) -> list[str]:
    """Return a doubt where the intensity does not reach the onset of rocking of walls: how many, and of the easiest."""
    good = [one for one in results if isinstance(one, Answer)]
    still = [one for one in good if one.strongest < one.rocking_onset]
    if not still:
        return []
    easiest = min(one.rocking_onset for one in still)
    do = "does" if len(still) == 1 else "do"
    several = f"{len(still)} of {len(good)} walls {do} not rock: the easiest of them"
    walls = several if len(good) > 1 else "the wall"
    return of_level(max(one.strongest for one in still), easiest, measure, intensity, walls)


def alike(rows: Iterable[Row | BadRow]) -> Iterable[list[Row]]:
    """Return the good rows that fit into one batch: walls or parapets, with one kind of softening."""
    kinds: dict[Any, list[Row]] = {}
    for row in rows:
        if isinstance(row, Row):
            kinds.setdefault((type(row.wall), row.curve.softening), []).append(row)
    return kinds.values()


def _of(rows: Sequence[Row], run: Callable[..., Any]) -> list[Answer | BadRow]:
    """Run walls together; where one of them is out of all scale, halves of them, down to that one."""
    wall, curve = (stacked([getattr(row, name) for row in rows]) for name in ("wall", "curve"))
    try:
        dampings, counted = run(wall, curve, np.array([row.restitution for row in rows]))
    except (InputError, ArithmeticError) as error:
        if len(rows) == 1:
            return [BadRow(rows[0].line, rows[0].id, f"line {rows[0].line}: {error}")]
        half = len(rows) // 2
        return [*_of(rows[:half], run), *_of(rows[half:], run)]
    fit, onset = lognormal(counted), wall.rocking_onset(curve.strength_ratio)
    ratio = np.stack([np.full(len(rows), np.nan) if one.is_impact else one.damping_ratio for one in dampings], axis=1)
    peaks = _median(np.where(counted.collapsed, np.inf, counted.peak)[..., 0])
    share = counted.stripe_collapsed.mean(axis=2)
    fell = counted.collapsed[..., 0].sum(axis=2)
    records, changes = counted.collapsed.shape[2], last_halving(counted)
    return [
        Answer(
            row,
            float(onset[i]),
            ratio[i],
            fell[i],
            records,
            fit.median[i],
            fit.dispersion[i],
            peaks[i],
            counted.stripe[i],
            share[i],
            {name: change[i] for name, change in changes.items()},
            float(counted.strongest[0]),
        )
        for i, row in enumerate(rows)
    ]


def stacked(owners: Sequence[T]) -> T:
    """Return walls or curves of numbers as one of arrays."""
    names = [field.name for field in fields(owners[0])]  # type: ignore[arg-type]
    first = {name: getattr(owners[0], name) for name in names}
    arrays = {
        name: np.array([float(getattr(owner, name)) for owner in owners])
        for name, value in first.items()
        if not isinstance(value, str)
    }
    with as_meant():  # what is unlikely was said of each row
        return type(owners[0])(**(first | arrays))


def _median(peaks: Array) -> Array:
    """Return the median over the last axis; NaN where it is that of a wall that collapsed."""
    ordered = np.sort(peaks, axis=-1)
    count = ordered.shape[-1]
    low, high = ordered[..., (count - 1) // 2], ordered[..., count // 2]
    return np.where(np.isfinite(high), 0.5 * (low + high), np.nan)


# --- what is written --------------------------------------------------------------------------------------------------


def lines(one: Answer | BadRow) -> Iterator[dict[str, Any]]:
    """Yield the rows of the written table by the keys of `COLUMNS`, one for each damping model.

    What is not defined is empty, and `reason` says why there is no fragility.
    """
    if isinstance(one, BadRow):
        yield dict.fromkeys(COLUMNS, "") | {"id": one.id, "error": one.error}
        return
    for i, model in enumerate(MODELS):
        values = {
            "damping_ratio": one.damping_ratio[i],
            "rocking_onset": one.rocking_onset,
            "building_period": one.building_period,
            "restitution": one.row.restitution,
            "collapse_probability": one.collapses[i] / one.records,
            "median_intensity": one.median[i],
            "dispersion": one.dispersion[i],
            "peak_ratio_median": one.peak_ratio_median[i],
            "median_uncertainty": one.changes["median_uncertainty"][i],
            "dispersion_uncertainty": one.changes["dispersion_uncertainty"][i],
        }
        known = {name: repr(float(value)) if np.isfinite(value) else "" for name, value in values.items()}
        yield {
            "id": one.row.id,
            "damping_model": model,
            **known,
            "collapses": str(one.collapses[i]),
            "records": str(one.records),
            "unsettled": str(one.changes["unsettled"][i]),
            "reason": "" if np.isfinite(one.median[i]) else no_fragility(one.stripe_share[i]),
            "error": "",
        }


def dataset(results: Sequence[Answer | BadRow], measure: str, intensity: float, tail: float = TAIL) -> xr.Dataset:
    """Return the results as a dataset of the kind ``batch``; NaN, and -1 collapses, of rows that have an error."""
    name, shape = measure.lower(), (len(results), len(MODELS))
    good = [(i, one) for i, one in enumerate(results) if isinstance(one, Answer)]

    def of(value: Callable[[Answer], Any], kind: Any = float, missing: Any = np.nan, wide: bool = True) -> Any:
        values = np.full(shape if wide else shape[:1], missing, dtype=kind)
        for i, one in good:
            values[i] = value(one)
        return (("wall", "damping_model") if wide else ("wall",), values)

    records = next((one.records for _, one in good), 0)
    in_buildings = any(np.isfinite(one.building_period) for _, one in good)
    period = {"building_period": of(lambda one: one.building_period, wide=False)} if in_buildings else {}
    return xr.Dataset(
        {
            name: intensity,
            "restitution": of(lambda one: one.row.restitution, wide=False),
            "rocking_onset": of(lambda one: one.rocking_onset, wide=False),
            **period,
            "damping_ratio": of(lambda one: one.damping_ratio),
            "collapses": of(lambda one: one.collapses, int, -1),
            "collapse_probability": of(lambda one: one.collapses / one.records),
            f"median_{name}": of(lambda one: one.median),
            "dispersion": of(lambda one: one.dispersion),
            "peak_ratio_median": of(lambda one: one.peak_ratio_median),
            "unsettled": of(lambda one: one.changes["unsettled"], int, -1),
            "median_uncertainty": of(lambda one: one.changes["median_uncertainty"]),
            "dispersion_uncertainty": of(lambda one: one.changes["dispersion_uncertainty"]),
            "tail": tail,
            "records": records,
            "error": ("wall", [one.error if isinstance(one, BadRow) else "" for one in results]),
        },
        coords={
            "wall": [one.id if isinstance(one, BadRow) else one.row.id for one in results],
            "damping_model": list(MODELS),
        },
    )


def fragilities(results: Iterable[Answer | BadRow]) -> Iterator[Collapse]:
    """Yield the fragility of each wall and damping model, for NRML."""
    for one in results:
        if isinstance(one, Answer):
            for i, model in enumerate(MODELS):
                name, fit = f"{one.row.taxonomy}-{model}", (float(one.median[i]), float(one.dispersion[i]))
                yield Collapse(name, *fit, one.stripe.tolist(), one.stripe_share[i].tolist())
