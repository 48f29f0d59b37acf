"""The report's section on measured free rocking: what it says of each damper, and what it does not."""

from __future__ import annotations

import math
from typing import Any

from rockdamp.storage.dataset import Datasets
from rockdamp.text import listed, number, percent
from rockdamp.vocabulary import PAPER_MODELS, REFERENCE

FIGURE = "fig_measured_rocking"
TIMES = 100  # less likely is excluded, as in data/claims.yaml


def section(datasets: Datasets) -> dict[str, Any] | None:
    """Return what the template shows, none without the dataset."""
    measured = datasets.get("measured_rocking")
    if measured is None:
        return None
    models = [REFERENCE, *PAPER_MODELS]
    likelihood = measured["log_likelihood"].sel(damping_model=models)
    behind = likelihood.max("damping_model") - likelihood
    beyond = {model: (behind.sel(damping_model=model) > math.log(TIMES)).values for model in models}
    return {
        "impacts": [int(count) for count in measured["impacts_used"].values],
        "rows": [(model, [number(value, 2) for value in behind.sel(damping_model=model).values]) for model in models],
        "excluded": listed(model for model in models if beyond[model].all()) or "none",
        "partly": listed(model for model in models if beyond[model].any() and not beyond[model].all()) or "none",
        "times": TIMES,
        "limit": number(math.log(TIMES), 2),
        "coverage": percent(measured["held_out_coverage"].mean()),
        "choices": measured.sizes["choice"],
        "trials": int(measured["trials"] - measured["duplicates"]),
    }
