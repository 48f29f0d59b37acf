"""Assessed walls as commands write them: values by damping model, rows of a table, and reasons."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from scipy.special import ndtr

from rockdamp.assessment.collapses import FEWEST_STATIONS, STRIPES
from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.statistics.fragility import fit_fragility
from rockdamp.text import count_noun
from rockdamp.units import INTENSITY_UNITS

# Values of each damping model in the answer for one wall.
MODEL_VALUES = (
    "restitution",
    "damping_ratio",
    "records",
    "collapses",
    "collapse_probability",
    "effective_records",
    "peak_median",
    "peak_upper",
    "median_intensity",
    "dispersion",
    "unconverged",
    "median_uncertainty",
    "dispersion_uncertainty",
)
MODEL_INTERVALS = (
    "collapse_probability_interval",
    "median_intensity_interval",
    "dispersion_interval",
)
# Columns of the table of many walls, with pgv or pga after the first two; median_intensity is
# median_pgv or median_pga of the dataset.
ANSWER_COLUMNS = (
    "id",
    "damping_model",
    "restitution",
    "rocking_onset",
    "collapses",
    "records",
    "collapse_probability",
    "median_intensity",
    "intensity_unit",
    "dispersion",
    "peak_median",
    "unconverged",
    "median_uncertainty",
    "dispersion_uncertainty",
    "reason",
    "error",
)
LAW_NAMES = ("loss_exponent", "reference_amplitude")  # of answers with a loss law alone


def measure_name(answer: xr.Dataset) -> str:
    """Return ``pgv`` or ``pga``, the intensity measure of an assessment."""
    return "pgv" if "median_pgv" in answer else "pga"


def assessed_values(answer: xr.Dataset) -> dict[str, Any]:
    """Return the answer for one wall in SI; NaN stands for a value that is not defined.

    Parameters
    ----------
    answer : xarray.Dataset
        Answer of `assess`. With one intensity each value is a number, with several a list.
    """
    measure = measure_name(answer)
    renamed = answer.rename(
        {
            f"median_{measure}": "median_intensity",
            f"median_{measure}_interval": "median_intensity_interval",
        }
    )
    if renamed.sizes["intensity"] == 1:
        renamed = renamed.squeeze("intensity")
    models = renamed["damping_model"].values.tolist()
    law = {name: renamed[name].item() for name in LAW_NAMES if name in renamed}
    return {
        "rocking_onset": renamed["rocking_onset"].item(),
        "restitution": renamed["restitution"].item(),
        "restitution_reason": answer.attrs["restitution_reason"],
        "intensity_measure": measure.upper(),
        "intensity": renamed[measure].values.tolist(),
        "scaled_motion": answer.attrs["scaled_motion"],
        "models": [
            {
                "damping_model": model,
                **_model_values(renamed.sel(damping_model=model)),
                "reason": "; ".join(reasons(answer, model)) or None,
            }
            for model in models
        ],
        "restitution_range": [_case_values(renamed, case) for case in answer["restitution_case"]],
        **law,
    }


def _model_values(answer: xr.Dataset) -> dict[str, Any]:
    """Return the values of one damping model; an interval that is not defined is None."""
    values = {name: answer[name].values.tolist() for name in (*MODEL_VALUES, *MODEL_INTERVALS)}
    undefined = [name for name in MODEL_INTERVALS if np.isnan(answer[name]).any()]
    return {**values, **dict.fromkeys(undefined)}


def _case_values(answer: xr.Dataset, case: xr.DataArray) -> dict[str, Any]:
    """Return e and the collapse probability of one case of restitution."""
    values = answer.sel(restitution_case=case)
    return {
        "restitution_case": case.item(),
        "restitution": values["case_restitution"].item(),
        "collapse_probability": values["case_collapse_probability"].values.tolist(),
    }


def ductility_demand(answer: xr.Dataset, curve: TrilinearCurve) -> float:
    """Return the largest peak under CR at the last intensity, divided by u1.

    It is NaN if a record collapses the wall.
    """
    peaks = answer["peak"].sel(damping_model="CR").isel(intensity=-1)
    return float(peaks.max(skipna=False) / curve.yield_displacement_ratio)


def explain_rest(answer: xr.Dataset, curve: TrilinearCurve) -> str:
    """Return the answer for a wall that no record makes rock; empty if it rocks.

    Parameters
    ----------
    answer : xarray.Dataset
        Answer of `assess`.
    curve : TrilinearCurve
        Force-displacement curve of the wall.
    """
    ratio = ductility_demand(answer, curve)
    if not ratio < 1:
        return ""
    onset = float(answer["rocking_onset"]) / STANDARD_GRAVITY
    text = (
        f"No record makes this wall rock: the largest peak is {ratio:.3g} times u1,"
        f" where the plateau starts, and rocking starts at a static acceleration of {onset:.3g} g."
        " The model gives no collapse."
    )
    bounds = answer["collapse_probability_interval"].sel(damping_model="CR").isel(intensity=-1)
    most = float(bounds.sel(bound="upper"))
    if np.isfinite(most):
        text += (
            f" The upper bound of {100 * most:.3g} % reflects only that there are"
            f" {count_stations(answer)} and ignores that the model predicts no rocking."
        )
    return f"{text} Check the curve, the eccentricity and the floors."


def fragility_at(answer: xr.Dataset) -> float:
    """Return the value of the fragility curve with restitution at an intensity; NaN without one.

    Parameters
    ----------
    answer : xarray.Dataset
        Answer of `assess` at one intensity.
    """
    cr = answer.sel(damping_model="CR")
    measure = measure_name(answer)
    log_ratio = np.log(cr[measure] / cr[f"median_{measure}"])
    return float(ndtr(log_ratio / cr["dispersion"]))


def warn_of_zero(answer: xr.Dataset) -> str:
    """Return what to report if no record collapses the wall; empty if one does.

    Parameters
    ----------
    answer : xarray.Dataset
        Answer of `assess` at one intensity, of which the given e counts.
    """
    cr = answer.sel(damping_model="CR")
    if cr["collapses"].item() > 0:
        return ""
    bound = float(cr["collapse_probability_interval"].sel(bound="upper"))
    limit = f"up to {100 * bound:.3g} %" if np.isfinite(bound) else "above zero"
    warning = f"do not report zero: with {count_stations(answer)} a share {limit} is possible"
    estimate = fragility_at(answer)
    if np.isfinite(estimate):
        warning += f"; the estimate of the fragility curve is {100 * estimate:.2g} %"
    return warning


def count_stations(answer: xr.Dataset) -> str:
    """Return the number of stations of the records in words: ``22 stations``."""
    return count_noun(int(np.unique(answer["station"].values).size), "station")


def reasons(answer: xr.Dataset, damping_model: str) -> list[str]:
    """Return why intervals, or the fragility, of a damping model are missing; empty if none is.

    Parameters
    ----------
    answer : xarray.Dataset
        Answer of `assess`.
    damping_model : str
        Label of the damping model.
    """
    model = answer.sel(damping_model=damping_model)
    median = f"median_{measure_name(answer)}"
    stations = int(np.unique(answer["station"].values).size)
    has_few_stations = stations < FEWEST_STATIONS
    texts = []
    if has_few_stations:
        count = count_noun(stations, "station")
        texts.append(f"no intervals: {count}; at least {FEWEST_STATIONS} are needed")
    if not np.isfinite(model[median]):
        counts = model["stripe_collapses"].values
        texts.append(str(fit_fragility(STRIPES, counts, answer["records"].item()).reason))
        return texts
    intervals = model[[f"{median}_interval", "dispersion_interval"]].to_array()
    if not has_few_stations and not np.isfinite(intervals).all():
        texts.append(
            "no interval of the fragility curve: fewer than 90 % of the bootstrap samples give one"
        )
    return texts


def tabulate_walls(answer: xr.Dataset) -> list[dict[str, Any]]:
    """Return the rows of the table of many walls.

    There is a row for each wall and damping model, and one for a wall with an error. A value that
    is not defined is None, and ``reason`` says why there is no fragility.

    Parameters
    ----------
    answer : xarray.Dataset
        Answer of `assess_rows`.
    """
    measure = measure_name(answer)
    counts = answer["stripe_collapses"].transpose("wall", "damping_model", "stripe").values
    runs = np.maximum(answer["records"].values, 1)[:, None, None]
    reason = fit_fragility(STRIPES, np.maximum(counts, 0), runs).reason
    answer = answer.assign(
        reason=(("wall", "damping_model"), reason),
        intensity_unit=INTENSITY_UNITS[measure.upper()],
    )
    answer = answer.rename(
        {f"median_{measure}": "median_intensity", "wall": "id", "row_error": "error"}
    )
    law = [name for name in LAW_NAMES if name in answer]
    columns = [*ANSWER_COLUMNS[:2], measure, *ANSWER_COLUMNS[2:], *law]
    values = answer[columns[2:]].to_dataframe(dim_order=["id", "damping_model"])
    table = values.reset_index()[columns]
    has_error = table["error"] != ""
    is_first_model = table["damping_model"] == table["damping_model"].iloc[0]
    is_run = table["collapses"] >= 0  # a one-sided wall has no damper beside restitution
    table = table[(has_error & is_first_model) | is_run]
    is_defined = table.notna() & (table != "")
    rows = table.astype(object).where(is_defined, None).to_dict("records")
    return [_empty_row(row) if row["error"] else row for row in rows]


def _empty_row(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row with its id and its error alone."""
    return {**dict.fromkeys(row), "id": row["id"], "error": row["error"]}
