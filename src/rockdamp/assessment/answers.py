"""What is written of walls: values for JSON, lines of tables, damping ratios."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import isfinite
from typing import Any, TypedDict

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from rockdamp.assessment.assess import FEWEST_STATIONS, alike, stacked
from rockdamp.assessment.table import BadRow, Row
from rockdamp.constants import VISCOUS_MODELS
from rockdamp.equivalence.equivalent import least_error, longest_step
from rockdamp.equivalence.matching import map_in_threads
from rockdamp.errors import InputError
from rockdamp.text import count_noun

# Of the written table; a median_intensity is median_pgv or median_pga of the dataset.
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
    "peak_median",
    "unconverged",
    "median_uncertainty",
    "dispersion_uncertainty",
    "reason",
    "error",
)
OF_LOSS = ("loss_exponent", "reference_amplitude")  # columns where the loss has an exponent
BY_INTENSITY = ("collapses", "collapse_probability", "collapse_probability_interval", "effective_records")
IMPULSIVE = "collapse_probability_impulsive"  # of a wall, by the rule measured
HALVING = ("unconverged", "median_uncertainty", "dispersion_uncertainty")


def measure_of(answer: xr.Dataset) -> str:
    """Return ``pgv`` or ``pga``, the intensity measure of an assessment."""
    return "pgv" if "median_pgv" in answer else "pga"


# --- one wall ---------------------------------------------------------------------------------------------------------


def models(answer: xr.Dataset) -> list[dict[str, Any]]:
    """Return one wall's answer for each damping model; what depends on the intensity as a list over it."""
    median = f"median_{measure_of(answer)}"
    rows = []
    for model in map(str, answer["damping_model"].values):
        one = answer.sel(damping_model=model)
        lists = {name: _plain(one[name].values) for name in (*BY_INTENSITY, IMPULSIVE) if name in one}
        rows.append(
            {
                "damping_model": model,
                "order": _plain(one["order"].values),
                "damping_ratio": _plain(one["damping_ratio"].values),
                "records": int(answer["records"]),
                **lists,
                "median_intensity": _plain(one[median].values),
                "median_intensity_interval": _bounds(one[f"{median}_interval"].values),
                "dispersion": _plain(one["dispersion"].values),
                "dispersion_interval": _bounds(one["dispersion_interval"].values),
                **{name: _plain(one[name].values) for name in HALVING if name in one},
                "reason": "; ".join(reasons(answer, model)) or None,
            }
        )
        rows[-1]["collapse_probability_interval"] = list(map(_bounds, one["collapse_probability_interval"].values))
    return rows


def _plain(values: np.ndarray[Any, Any]) -> Any:
    """Return numbers for JSON, and null where one is not known."""
    if values.ndim:
        return [_plain(value) for value in values]
    return values.item() if isfinite(values) else None


def _bounds(values: np.ndarray[Any, Any]) -> list[float] | None:
    return values.tolist() if np.isfinite(values).all() else None


def reasons(answer: xr.Dataset, damping_model: str) -> list[str]:
    """Return why intervals, or the fragility, of a damping model are missing; empty where none is."""
    of_model, median = answer.sel(damping_model=damping_model), f"median_{measure_of(answer)}"
    stations = int(np.unique(answer["station"].values).size)
    few = stations < FEWEST_STATIONS
    found = [f"{count_noun(stations, 'station')}; intervals need at least {FEWEST_STATIONS}"] if few else []
    if not np.isfinite(float(of_model[median])):
        found.append(no_fragility(of_model["stripe_collapses"].values, int(answer["records"])))
    elif not few and not np.isfinite(of_model[[f"{median}_interval", "dispersion_interval"]].to_array()).all():
        found.append("no interval of the fragility: under nine in ten replicates of the bootstrap define one")
    return found


def no_fragility(collapses: ArrayLike, records: int) -> str:
    """Return why counts of collapses at the stripes define no lognormal curve."""
    count = np.asarray(collapses)
    lowest = np.flatnonzero(count > 0).min(initial=count.size)
    highest = np.flatnonzero(count < records).max(initial=-1)
    separated = "all records collapse the wall from one stripe on, and none below it"
    return f"no fragility: {'collapses become fewer with intensity' if lowest < highest else separated}"


# --- many walls -------------------------------------------------------------------------------------------------------


def columns(answer: xr.Dataset) -> tuple[str, ...]:
    """Return the columns of the written table: `COLUMNS`, and where the loss has an exponent what states it."""
    return (*COLUMNS, *(name for name in OF_LOSS if name in answer))


def lines(answer: xr.Dataset) -> Iterator[dict[str, Any]]:
    """Yield the rows of the written table by the keys of `columns`: one for each wall and damping model.

    What is not defined is empty, and ``reason`` says why there is no fragility. A wall with an error has it once.
    """
    renamed = answer.rename({f"median_{measure_of(answer)}": "median_intensity", "wall": "id", "row_error": "error"})
    named = [name for name in columns(answer) if name in renamed.variables and name != "id"]
    table = renamed[named].to_dataframe(dim_order=["id", "damping_model"]).reset_index()
    stripes = renamed["stripe_collapses"].transpose("id", "damping_model", "stripe").values.reshape(len(table), -1)
    for row, counts in zip(table.to_dict("records"), stripes, strict=True):
        filled = {str(name): "" if value != value or value == -1 else value for name, value in row.items()}
        if filled["error"]:
            filled = {name: filled[name] for name in ("id", "error")}
            if row["damping_model"] != table["damping_model"][0]:
                continue
        elif row["collapses"] < 0:  # against a stop there is no damper beside restitution
            continue
        elif filled["median_intensity"] == "":
            filled["reason"] = no_fragility(counts, int(row["records"]))
        yield dict.fromkeys(columns(answer), "") | filled


# --- damping ratios, without a record ---------------------------------------------------------------------------------


class Ratio(TypedDict):
    """The damping ratio of one wall and viscous model, or why there is none."""

    id: str
    restitution: float | None
    damping_model: str
    damping_ratio: float | None
    error: str


RATIO_COLUMNS = tuple(Ratio.__annotations__)
AT_ONCE = 64  # walls that are searched together


def ratios(rows: Sequence[Row | BadRow], release_amplitude: float) -> Iterator[Ratio]:
    """Yield the damping ratios of least Err of each wall by each viscous model, in the order of the rows.

    They are those of `equivalent`, searched on all cores. A row that makes no wall, or one that is not released below
    a3, has its error once, without a model.
    """
    released = [_released(row, release_amplitude) for row in rows]
    batches = [
        part[start : start + AT_ONCE]
        for batch in alike(row for row in released if isinstance(row, Row))
        for part in _of_one_step(batch)
        for start in range(0, len(part), AT_ONCE)
    ]
    numbers = range(len(batches))
    found = map_in_threads(
        lambda number: _search(batches[number], VISCOUS_MODELS, release_amplitude), numbers, "Batches"
    )
    of_line: dict[int, list[Ratio]] = {}
    for one in (ratio for batch in found.values() for ratio in batch):
        of_line.setdefault(one[0], []).append(one[1])
    for each in released:
        if isinstance(each, BadRow):
            yield Ratio(id=each.id, restitution=None, damping_model="", damping_ratio=None, error=each.error)
        else:
            yield from of_line[each.line]


def _released(row: Row | BadRow, x0: float) -> Row | BadRow:
    if isinstance(row, BadRow) or 0 < x0 < row.curve.ultimate_displacement_ratio:
        return row
    wrong = InputError(f"release_amplitude is {x0:g}; it must be greater than 0 and less than a3")
    return BadRow(row.line, row.id, f"line {row.line}: {wrong}")


def _of_one_step(rows: list[Row]) -> Iterable[list[Row]]:
    """Return the walls whose decays take the same step: all but those of the stiffest curves."""
    by_step: dict[float, list[Row]] = {}
    for row in rows:
        by_step.setdefault(float(longest_step(row.curve)), []).append(row)
    return by_step.values()


def _search(rows: list[Row], models: Sequence[str], x0: float) -> list[tuple[int, Ratio]]:
    """Search walls and models together; where one has no ratio, in halves and then by model, down to that one.

    Each ratio stands beside the line of its wall; those of a wall are in the order of the models.
    """
    e, curve = np.array([row.restitution for row in rows]), stacked([row.curve for row in rows])
    try:
        found = least_error(curve, e, np.full(e.shape, x0), damping_models=models)
    except InputError as error:
        if len(rows) > 1:
            half = len(rows) // 2
            return [*_search(rows[:half], models, x0), *_search(rows[half:], models, x0)]
        if len(models) > 1:
            return [one for model in models for one in _search(rows, [model], x0)]
        return [_answer(rows[0], models[0], None, f"line {rows[0].line}: {error}")]
    ratios = {model: matched.damping_ratio.tolist() for model, matched in found.items()}
    return [_answer(row, model, ratios[model][index], "") for index, row in enumerate(rows) for model in models]


def _answer(row: Row, model: str, xi: float | None, error: str) -> tuple[int, Ratio]:
    ratio = Ratio(id=row.id, restitution=row.restitution, damping_model=model, damping_ratio=xi, error=error)
    return row.line, ratio
