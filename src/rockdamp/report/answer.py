"""The answer in short, for who reads nothing else: how much damping, which damper, what it costs."""

from __future__ import annotations

from typing import Any

import numpy as np

from rockdamp.figures.damper_order import at_shown
from rockdamp.mechanics.damping import Damping
from rockdamp.report.earthquake_captions import fraction, known
from rockdamp.report.numbers import number, percent, plain
from rockdamp.storage.dataset import Datasets
from rockdamp.vocabulary import PAPER_MODELS, RECOMMENDED, RECOMMENDED_ORDER, TITLES

SOURCE = "closed form"  # of the recommended damper's ratio: exact
NEEDED = ("comparison", "natural/orders", "damper_order", "loops")


def answer(data: Datasets) -> dict[str, Any] | None:
    """Return what the first screen says, or nothing where a dataset of `NEEDED` was not built.

    Parameters
    ----------
    data : dict of str to xarray.Dataset
        Of the report.
    """
    if any(name not in data for name in NEEDED):
        return None
    compared, orders, by_order = (data[name] for name in NEEDED[:3])
    middle = compared.isel(restitution=compared.sizes["restitution"] // 2)
    e = float(middle["restitution"])
    error = middle["log_error"].isel(band=0)
    papers = error.sel(damping_model=list(PAPER_MODELS)).min("damping_ratio_source")
    nearest_of_paper = PAPER_MODELS[int(np.argmin(papers.values))]
    own = middle["varied_log_error"].isel(band=0).sel(variation=["lower e", "higher e"])
    shown = at_shown(by_order).sel(order=RECOMMENDED_ORDER, method="nearest")
    cell = middle.sel(damping_model=RECOMMENDED, damping_ratio_source=SOURCE)
    found = float(orders["recommended_order"])
    return {
        "model": RECOMMENDED,
        "title": TITLES[RECOMMENDED],
        "e": plain(e),
        "ratio": percent(float(Damping.of_restitution(e, RECOMMENDED).damping_ratio), 3),
        "records": int(orders["records"]),
        "error": known(cell["log_error"].isel(band=0), 2),
        "own": f"{known(own.min(), 2)} to {known(own.max(), 2)}",
        "change": plain(orders["restitution_change"]),
        "paper_model": nearest_of_paper,
        "paper_error": known(papers.sel(damping_model=nearest_of_paper), 2),
        "safe": fraction(cell["false_safe_rate"]),
        "decay_error": number(shown["curve_rms_error"], 2),
        "fitted_error": number(shown["fitted_rms_error"].sel(damping_model=list(PAPER_MODELS)).min(), 2),
        "fitted_e": plain(shown["restitution"]),
        "before": known(shown["pulse_before_impact_log_error"], 2),
        "found": plain(found) if np.isfinite(found) else None,
        "agrees": found == RECOMMENDED_ORDER,
        "order": RECOMMENDED_ORDER,
    }
