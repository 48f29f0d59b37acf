"""The answer in short: which damper, how much of it, how certain that is, and where it ends."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from rockdamp.equivalence.programs import OFFERS, refers_to
from rockdamp.mechanics.damping import damper_classes
from rockdamp.mechanics.damping.ecd import normalisation
from rockdamp.report import earthquake_criterion as criterion
from rockdamp.report.earthquake_criterion import off
from rockdamp.storage.dataset import Datasets
from rockdamp.text import DASH, counted, number, percent, plain
from rockdamp.vocabulary import RECOMMENDED, RECOMMENDED_ORDER, RECOMMENDED_SOURCE

ORDERS = "earthquakes/orders"
# How far the recommended damper is from restitution: the words, the name in the recommendation, and of a changed e.
CERTAINTY = (
    ("root mean square", "log_error", "sensitivity_to_restitution", off),
    ("median", "log_error_median", "sensitivity_to_restitution_median", off),
    ("1 in 10 exceeds", "log_error_90", "sensitivity_to_restitution_90", off),
    ("collapses missed", "false_safe_rate", "sensitivity_false_safe_rate", percent),
    ("collapses added", "false_collapse_rate", "sensitivity_false_collapse_rate", percent),
)


def answer(data: Datasets, a1: float) -> dict[str, Any] | None:
    """Return the values of the first screen for a wall of this a1, or None without the dataset ``recommendation``.

    What the study of earthquakes has is a list over its e; ``at`` is the place of the e that is shown first.
    """
    if "recommendation" not in data:
        return None
    whole = data["recommendation"]
    at = whole.sizes["restitution"] // 2
    leading = whole.sel(damping_ratio_source=RECOMMENDED_SOURCE)
    cell = leading.sel(damping_model=RECOMMENDED)
    enough = float(whole["recommended_order"])
    return {
        "model": RECOMMENDED,
        "title": damper_classes()[RECOMMENDED].title,
        "order": RECOMMENDED_ORDER,
        "normalisation": number(normalisation(RECOMMENDED_ORDER)),
        "at": at,
        "e": [plain(e) for e in whole["restitution"].values],
        "ratios": ratios(data, a1),
        "release": plain(whole["release_amplitude"]),
        "selection": selection(data),
        "change": plain(whole["restitution_change"]),
        "certainty": [
            (words, over_e(cell[name], show), over_e(whole[changed], show)) for words, name, changed, show in CERTAINTY
        ],
        "within": [
            all(float(cell[name][e]) <= float(whole[changed][e]) for _, name, changed, _ in CERTAINTY)
            for e in range(whole.sizes["restitution"])
        ],
        "large": plain(whole["near_collapse_start"]),
        "large_error": over_e(cell["near_collapse_log_error"], off),
        "force": number(whole["crossing_force"]),
        "decay_e": plain(data["damper_order"]["shown_restitution"]) if "damper_order" in data else None,
        "by_wall": criterion.counted_in_short(data[ORDERS]) if ORDERS in data else None,
        "amplitude": of_amplitude(data["loss_law"]) if "loss_law" in data else None,
        "reservations": list(criterion.reservations(data[ORDERS]).values()) if ORDERS in data else [],
        "found": plain(enough) if np.isfinite(enough) else None,
        "agrees": enough == RECOMMENDED_ORDER,
        "programs": by_program(data),
    }


def of_amplitude(study: xr.Dataset) -> dict[str, str]:
    """Return by how much a constant e overstates the median intensity of collapse, by the amplitude of its releases.

    That of the smallest amplitude over the exponents, and the largest error of the other amplitudes, either way.
    """
    whole = study.isel(wall=0)
    over = 1 / whole["median_intensity_ratio"] - 1
    at, g = whole["reference_amplitude"].values, whole["loss_exponent"].values
    small, others = over.isel(reference_amplitude=0), over.isel(reference_amplitude=slice(1, None))
    return {
        "e": plain(study["restitution"]),
        "small": plain(at[0]),
        "good": f"{plain(at[1])} to {plain(at[-1])}",
        "within": percent(abs(others).max()),
        "least": percent(small.min()),
        "most": percent(small.max()),
        "exponent": plain(g[g.size // 2]),
        "exponents": f"{plain(g[0])} to {plain(g[-1])}",
    }


def selection(data: Datasets) -> str:
    """Say over which histories the errors are: the same for every damper of the tables."""
    records = f"{int(data['recommendation']['records'])} earthquake records"
    if "comparison" not in data:
        return records
    compared = data["comparison"]
    walls = int(compared["pooled"].sel(damping_ratio_source=RECOMMENDED_SOURCE).sum())
    peaks = f"{plain(compared['band_start'][0])} to {plain(compared['band_end'][0])}"
    return f"{counted(walls, 'wall')} under {records}, peaks of {peaks} u_ins under restitution"


def over_e(values: xr.DataArray, show: Any) -> list[str]:
    """Write a value at each e of the study."""
    return [show(value) for value in values.values]


def ratios(data: Datasets, a1: float) -> dict[str, Any] | None:
    """Return the damping ratios of least Err of each damper over e, None where ``equivalence`` has not this a1. [-]"""
    if "equivalence" not in data:
        return None
    studied = data["equivalence"]["damping_ratio"]
    if studied.sizes["yield_displacement_ratio"] > 1:
        ratio = studied.interp(yield_displacement_ratio=a1)
    else:
        ratio = studied.isel(yield_displacement_ratio=0).where(np.isclose(studied["yield_displacement_ratio"][0], a1))
    ratio = ratio.dropna("restitution", how="all")
    if ratio.sizes["restitution"] < 2:
        return None
    return {
        "e": [round(float(e), 6) for e in ratio["restitution"].values],
        "ratio": {
            model: [round(float(value), 6) for value in ratio.sel(damping_model=model)]
            for model in OFFERS
            if bool(np.isfinite(ratio.sel(damping_model=model)).all())
        },
    }


def shown_ratio(ratios: dict[str, Any] | None, model: str, e: str) -> str:
    """Write a damping ratio between those of the neighbouring e, as the page's script does; a dash if none. [%]"""
    if ratios is None or model not in ratios["ratio"]:
        return DASH
    ratio = np.interp(float(e), ratios["e"], ratios["ratio"][model], left=np.nan, right=np.nan)
    return f"{100 * ratio:.2f}" if np.isfinite(ratio) else DASH


def by_program(data: Datasets) -> list[dict[str, Any]]:
    """Return the rows of the table of dampers by what a program takes, by their error at the middle e.

    Of errors that read the same the damper that misses fewer collapses comes first.
    """
    leading = data["recommendation"].sel(damping_ratio_source=RECOMMENDED_SOURCE)
    rows = [
        _row(offer, model, refers_to(model), leading["log_error"], leading["false_safe_rate"])
        for model, offer in OFFERS.items()
    ]
    middle = leading.sizes["restitution"] // 2
    return sorted(rows, key=lambda row: (_as_shown(row["log_error"][middle]), _as_shown(row["false_safe"][middle])))


def _as_shown(value: float) -> float:
    """Round to the digits that `off` and `percent` show; infinite if not known."""
    return float(f"{np.expm1(value):.1e}") if np.isfinite(value) else np.inf


def _row(offer: str, model: str, refers: str, log_error: xr.DataArray, false_safe: xr.DataArray) -> dict[str, Any]:
    error, missed = (cost.sel(damping_model=model) for cost in (log_error, false_safe))
    return {
        "offer": offer,
        "model": model,
        "title": damper_classes()[model].title,
        "refers_to": refers,
        "log_error": error.values,
        "false_safe": missed.values,
        "error": over_e(error, off),
        "missed": over_e(missed, percent),
    }
