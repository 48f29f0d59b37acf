"""The answer in short: how much damping, which damper, and what to beware of."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from rockdamp.mechanics.damping import kinds
from rockdamp.report import interactive
from rockdamp.report.programs import factor
from rockdamp.storage.dataset import Datasets
from rockdamp.studies.recommendation import EXACT_SOURCE
from rockdamp.text import percent, plain
from rockdamp.vocabulary import PAPER_MODELS, RECOMMENDED, RECOMMENDED_ORDER, VISCOUS_MODELS


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
        "error": factor(cell["log_error"]),
        "own": factor(cell["sensitivity_to_restitution"]),
        "within": float(cell["log_error"]) <= float(cell["sensitivity_to_restitution"]),
        "large": plain(whole["near_collapse_start"]),
        "large_error": factor(cell["near_collapse_log_error"]),
        "large_own": factor(cell["near_collapse_sensitivity_to_restitution"]),
        "change": plain(whole["restitution_change"]),
        "paper_model": nearest_of_paper,
        "paper_error": factor(papers.sel(damping_model=nearest_of_paper)),
        "safe": percent(cell["false_safe_rate"]),
        "before": factor(whole["before_impact_log_error"]),
        "slow": factor(cell["slow_pulse_log_error"]),
        "quick": factor(cell["quick_pulse_log_error"]),
        "found": plain(enough) if np.isfinite(enough) else None,
        "agrees": enough == RECOMMENDED_ORDER,
        "order": RECOMMENDED_ORDER,
    }


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
