"""What is written of walls: values for JSON, rows of tables, and why an interval or a fragility is missing."""

from __future__ import annotations

from math import isfinite
from typing import Any

import numpy as np
import xarray as xr

from rockdamp.assessment.assess import FEWEST_STATIONS
from rockdamp.assessment.collapses import STRIPES
from rockdamp.statistics.fragility import fit_fragility
from rockdamp.text import count_noun

# Of the table that is written; a median_intensity is median_pgv or median_pga of the dataset.
COLUMNS = (
    *("id", "damping_model", "restitution", "damping_ratio", "rocking_onset", "collapses", "records"),
    *("collapse_probability", "median_intensity", "dispersion", "peak_median", "unconverged", "median_uncertainty"),
    *("dispersion_uncertainty", "reason", "error"),
)
BY_INTENSITY = (
    *("collapses", "collapse_probability", "collapse_probability_interval", "effective_records"),
    *("peak_median", "peak_upper"),
)
BY_MODEL = (
    *("median_intensity", "median_intensity_interval", "dispersion", "dispersion_interval"),
    *("unconverged", "median_uncertainty", "dispersion_uncertainty"),
)


def measure_name(answer: xr.Dataset) -> str:
    """Return ``pgv`` or ``pga``, the intensity measure of an assessment."""
    return "pgv" if "median_pgv" in answer else "pga"


def models(answer: xr.Dataset) -> list[dict[str, Any]]:
    """Return one wall's answer for each damping model; what depends on the intensity as a list over it."""
    median, rows = f"median_{measure_name(answer)}", []
    renamed = answer.rename({median: "median_intensity", f"{median}_interval": "median_intensity_interval"})
    for model in map(str, answer["damping_model"].values):
        one = renamed.sel(damping_model=model)
        row = {name: plain(one[name].values.tolist()) for name in ("damping_ratio", "restitution", "records")}
        row |= {name: plain(one[name].values.tolist()) for name in (*BY_INTENSITY, *BY_MODEL)}
        if np.isnan(one["dispersion_interval"]).any():
            row |= dict.fromkeys(("median_intensity_interval", "dispersion_interval"))
        if np.isnan(one["collapse_probability_interval"]).any():
            row["collapse_probability_interval"] = [None] * one.sizes["intensity"]
        rows.append({"damping_model": model, **row, "reason": "; ".join(reasons(answer, model)) or None})
    return rows


def plain(value: Any) -> Any:
    """Return numbers for JSON: null for what is not known."""
    if isinstance(value, list):
        return [plain(one) for one in value]
    return value if isfinite(value) else None


def reasons(answer: xr.Dataset, damping_model: str) -> list[str]:
    """Return why intervals, or the fragility, of a damping model are missing; empty where none is."""
    one, median = answer.sel(damping_model=damping_model), f"median_{measure_name(answer)}"
    stations = int(np.unique(answer["station"].values).size)
    few = stations < FEWEST_STATIONS
    found = [f"{count_noun(stations, 'station')}; intervals need at least {FEWEST_STATIONS}"] if few else []
    if not isfinite(one[median]):
        found.append(str(fit_fragility(STRIPES, one["stripe_collapses"].values, answer["records"].item()).reason))
    elif not few and not np.isfinite(one[[f"{median}_interval", "dispersion_interval"]].to_array()).all():
        found.append("no interval of the fragility: under nine in ten replicates of the bootstrap define one")
    return found


def lines(answer: xr.Dataset) -> list[dict[str, Any]]:
    """Return the rows of the table that is written: one for each wall and damping model, a wall with an error once.

    What is not defined is None, and ``reason`` says why there is no fragility.
    """
    counts = answer["stripe_collapses"].transpose("wall", "damping_model", "stripe").values
    runs = np.maximum(answer["records"].values, 1)[:, None, None]
    reason = fit_fragility(STRIPES, np.maximum(counts, 0), runs).reason
    answer = answer.assign(reason=(("wall", "damping_model"), reason))
    answer = answer.rename({f"median_{measure_name(answer)}": "median_intensity", "wall": "id", "row_error": "error"})
    loss = [name for name in ("loss_exponent", "reference_amplitude") if name in answer]
    names = [*COLUMNS[2:], *loss]
    table = answer[names].to_dataframe(dim_order=["id", "damping_model"]).reset_index()[[*COLUMNS, *loss]]
    rows = []
    for row in table.to_dict("records"):
        if row["error"] and row["damping_model"] == table["damping_model"][0]:
            rows.append({**dict.fromkeys(map(str, row)), "id": row["id"], "error": row["error"]})
        elif row["collapses"] >= 0:  # against a stop there is no damper beside restitution
            rows.append({str(name): None if value == "" or value != value else value for name, value in row.items()})
    return rows
