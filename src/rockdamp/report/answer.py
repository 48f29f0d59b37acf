"""The answer in short: how much damping, which damper, and what to beware of."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from rockdamp.mechanics.damping import kinds
from rockdamp.report import earthquake_criterion as criterion
from rockdamp.report import interactive
from rockdamp.report.earthquake_criterion import off
from rockdamp.storage.dataset import Datasets
from rockdamp.studies.recommendation import EXACT_SOURCE
from rockdamp.text import number, percent, plain
from rockdamp.vocabulary import PAPER_MODELS, RECOMMENDED, RECOMMENDED_ORDER, VISCOUS_MODELS

SIZES = {"median": "log_error_median", "tail": "log_error_90", "rms": "log_error"}  # of the difference of the peaks
ORDERS = "earthquakes/orders"


def answer(data: Datasets) -> dict[str, Any] | None:
    """Return the values of the first screen, or None without the dataset ``recommendation``."""
    if "recommendation" not in data:
        return None
    whole = data["recommendation"]
    middle = whole.isel(restitution=whole.sizes["restitution"] // 2)
    papers = middle["log_error"].sel(damping_model=list(PAPER_MODELS)).min("damping_ratio_source")
    nearest_of_paper = PAPER_MODELS[int(np.argmin(papers.values))]
    cell = middle.sel(damping_model=RECOMMENDED, damping_ratio_source=EXACT_SOURCE)
    enough = float(whole["recommended_order"])
    return {
        "model": RECOMMENDED,
        "title": kinds()[RECOMMENDED].title,
        "e": plain(middle["restitution"]),
        "ratios": ratios(middle["damping_ratio_energy"]),
        "release": plain(whole["release_amplitude"]),
        "records": int(whole["records"]),
        "sizes": {kind: (off(cell[name]), off(cell[of_change(name)])) for kind, name in SIZES.items()},
        "within": all(float(cell[name]) <= float(cell[of_change(name)]) for name in SIZES.values()),
        "large": plain(whole["near_collapse_start"]),
        "large_sizes": {
            kind: (off(cell[f"near_collapse_{name}"]), off(cell[f"near_collapse_{of_change(name)}"]))
            for kind, name in SIZES.items()
        },
        "change": plain(whole["restitution_change"]),
        "paper_model": nearest_of_paper,
        "paper_error": off(papers.sel(damping_model=nearest_of_paper)),
        "safe": percent(cell["false_safe_rate"]),
        "safe_of_change": percent(cell["sensitivity_false_safe_rate"]),
        "collapse": percent(cell["false_collapse_rate"]),
        "collapse_of_change": percent(cell["sensitivity_false_collapse_rate"]),
        "force": number(whole["crossing_force"]),
        "by_wall": criterion.counted_in_short(data[ORDERS]) if ORDERS in data else None,
        "before": off(whole["before_impact_log_error"]),
        "slow": off(cell["slow_pulse_log_error"]),
        "quick": off(cell["quick_pulse_log_error"]),
        "found": plain(enough) if np.isfinite(enough) else None,
        "agrees": enough == RECOMMENDED_ORDER,
        "order": RECOMMENDED_ORDER,
    }


def of_change(name: str) -> str:
    """Return the name of the same size of the difference that a change of e makes."""
    return f"sensitivity_to_restitution{name.removeprefix('log_error')}"


def ratios(damping_ratio: xr.DataArray) -> list[dict[str, Any]]:
    """Return each damper with its ratio at one e, the recommended one first."""
    exact = interactive.exact_dampers()
    models = [RECOMMENDED, *(model for model in reversed(VISCOUS_MODELS) if model != RECOMMENDED)]
    return [
        {
            "model": model,
            "title": kinds()[model].title,
            "exact": model in exact,
            "ratio": f"{100 * float(damping_ratio.sel(damping_model=model)):.2f}",
        }
        for model in models
    ]
