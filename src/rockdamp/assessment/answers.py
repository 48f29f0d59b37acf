"""What commands write of assessed walls: values by damping model, rows of a table, and why a number is missing."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from rockdamp.assessment.assess import FEWEST_STATIONS
from rockdamp.assessment.collapses import STRIPES
from rockdamp.statistics.fragility import fit_fragility
from rockdamp.text import count_noun

BY_MODEL = (
    *(
        "restitution",
        "damping_ratio",
        "records",
        "collapses",
        "collapse_probability",
        "effective_records",
    ),
    *("peak_median", "peak_upper", "median_intensity", "dispersion"),
    *("unconverged", "median_uncertainty", "dispersion_uncertainty"),
)
INTERVALS = ("collapse_probability_interval", "median_intensity_interval", "dispersion_interval")
# Of the table that is written; a median_intensity is median_pgv or median_pga of the dataset.
COLUMNS = (
    *(
        "id",
        "damping_model",
        "restitution",
        "damping_ratio",
        "rocking_onset",
        "collapses",
        "records",
    ),
    *(
        "collapse_probability",
        "median_intensity",
        "dispersion",
        "peak_median",
        "unconverged",
        "median_uncertainty",
    ),
    *("dispersion_uncertainty", "reason", "error"),
)


def measure_name(answer: xr.Dataset) -> str:
    """Return ``pgv`` or ``pga``, the intensity measure of an assessment."""
    return "pgv" if "median_pgv" in answer else "pga"


def assessed_values(answer: xr.Dataset) -> dict[str, Any]:
    """Return the answer for one wall in SI: values at one intensity, lists over several; NaN is not defined."""
    measure = measure_name(answer)
    names = {
        f"median_{measure}": "median_intensity",
        f"median_{measure}_interval": "median_intensity_interval",
    }
    one = answer.rename(names)
    one = one.squeeze("intensity") if one.sizes["intensity"] == 1 else one
    models = []
    for model in map(str, one["damping_model"].values):
        damper = one.sel(damping_model=model)
        row = {name: damper[name].values.tolist() for name in (*BY_MODEL, *INTERVALS)}
        row |= {name: None for name in INTERVALS if np.isnan(damper[name]).any()}
        models.append(
            {"damping_model": model, **row, "reason": "; ".join(reasons(answer, model)) or None}
        )
    cases = [one.sel(restitution_case=case) for case in one["restitution_case"]]
    return {
        **{name: one[name].item() for name in ("rocking_onset", "restitution")},
        "restitution_reason": one.attrs["restitution_reason"],
        "intensity_measure": measure.upper(),
        "intensity": one[measure].values.tolist(),
        "models": models,
        "restitution_range": [
            {
                "restitution_case": case["restitution_case"].item(),
                "restitution": case["case_restitution"].item(),
                "collapse_probability": case["case_collapse_probability"].values.tolist(),
            }
            for case in cases
        ],
        **{
            name: one[name].item()
            for name in ("loss_exponent", "reference_amplitude")
            if name in one
        },
    }


def reasons(answer: xr.Dataset, damping_model: str) -> list[str]:
    """Return why intervals, or the fragility, of a damping model are missing; empty where none is."""
    one, median = answer.sel(damping_model=damping_model), f"median_{measure_name(answer)}"
    stations = int(np.unique(answer["station"].values).size)
    few = stations < FEWEST_STATIONS
    found = (
        [f"{count_noun(stations, 'station')}; intervals need at least {FEWEST_STATIONS}"]
        if few
        else []
    )
    if not np.isfinite(one[median]):
        found.append(
            str(
                fit_fragility(
                    STRIPES, one["stripe_collapses"].values, answer["records"].item()
                ).reason
            )
        )
    elif (
        not few
        and not np.isfinite(one[[f"{median}_interval", "dispersion_interval"]].to_array()).all()
    ):
        found.append(
            "no interval of the fragility: under nine in ten replicates of the bootstrap define one"
        )
    return found


def tabulate_walls(answer: xr.Dataset) -> list[dict[str, Any]]:
    """Return the rows of the table that is written: one for each wall and damping model, a wall with an error once.

    What is not defined is None, and ``reason`` says why there is no fragility.
    """
    counts = answer["stripe_collapses"].transpose("wall", "damping_model", "stripe").values
    runs = np.maximum(answer["records"].values, 1)[:, None, None]
    reason = fit_fragility(STRIPES, np.maximum(counts, 0), runs).reason
    answer = answer.assign(reason=(("wall", "damping_model"), reason))
    answer = answer.rename(
        {f"median_{measure_name(answer)}": "median_intensity", "wall": "id", "row_error": "error"}
    )
    columns = [
        *COLUMNS,
        *(name for name in ("loss_exponent", "reference_amplitude") if name in answer),
    ]
    table = (
        answer[columns[2:]].to_dataframe(dim_order=["id", "damping_model"]).reset_index()[columns]
    )
    first, bad = table["damping_model"] == table["damping_model"].iloc[0], table["error"] != ""
    table = table[
        (bad & first) | (table["collapses"] >= 0)
    ]  # against a stop there is no damper beside restitution
    rows = table.astype(object).where(table.notna() & (table != ""), None).to_dict("records")
    return [
        dict.fromkeys(row) | {"id": row["id"], "error": row["error"]} if row["error"] else row
        for row in rows
    ]
