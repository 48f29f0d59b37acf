"""Which damper to use, by what the user's program offers, and what each costs."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from rockdamp.report.earthquake_criterion import off
from rockdamp.report.earthquakes import SOURCES
from rockdamp.storage.dataset import Datasets
from rockdamp.studies.recommendation import EXACT_SOURCE
from rockdamp.text import percent, plain
from rockdamp.vocabulary import LOCAL, RECOMMENDED

OFFERS = {  # what a program must offer for a damper, the best first
    RECOMMENDED: "a formula of your own, or a damping parameter that you set at each step",
    "ECD": "a coefficient that depends on the displacement alone",
    "CDR": "a damping ratio at the secant period",
    "SDR": "damping in proportion to the secant stiffness",
    "CDC": "a constant coefficient alone",
}
OFFER_OF_LOCAL = "local damping alone (discrete elements)"


def by_offer(data: Datasets) -> dict[str, Any] | None:
    """Return the rows of the table at the middle e, or None without the dataset ``recommendation``.

    Each damper has its ratio from the closed form where that is exact, and else from the source that errs least.
    """
    if "recommendation" not in data:
        return None
    whole = data["recommendation"]
    at_e = whole.isel(restitution=whole.sizes["restitution"] // 2)
    rows = [_row(at_e.sel(damping_model=model), model, offer) for model, offer in OFFERS.items()]
    local = data.get("local_damping")
    if local is not None and LOCAL in local["damping_model"].values:
        rows.append(_row_of_local(local.sel(damping_model=LOCAL)))
    return {"e": plain(at_e["restitution"]), "rows": rows}


def _row(one: xr.Dataset, model: str, offer: str) -> dict[str, str]:
    sources = list(map(str, one["damping_ratio_source"].values))
    errors = np.where(np.isfinite(one["log_error"].values), one["log_error"].values, np.inf)
    source = EXACT_SOURCE if model in (RECOMMENDED, "ECD") else sources[int(errors.argmin())]
    cell = one.sel(damping_ratio_source=source)
    return {
        "offer": offer,
        "model": model,
        "parameter": f"ξ of the {SOURCES[source]}",
        "error": off(cell["log_error"]),
        "false_safe": percent(cell["false_safe_rate"]),
    }


def _row_of_local(one: xr.Dataset) -> dict[str, str]:
    return {
        "offer": OFFER_OF_LOCAL,
        "model": LOCAL,
        "parameter": f"α = tanh(−ln e) = {float(one['local_damping']):.3f}",
        "error": off(one["record_log_error"]),
        "false_safe": percent(one["record_false_safe_rate"]),
    }
