"""The answer in short, for who reads nothing else: how much damping, which damper, and what to beware of."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.figures.damper_order import at_shown
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.report import interactive
from rockdamp.storage.dataset import Datasets
from rockdamp.text import percent, plain
from rockdamp.vocabulary import PAPER_MODELS, RECOMMENDED, RECOMMENDED_ORDER, TITLES, VISCOUS_MODELS

SOURCE = "closed form"  # of the recommended damper's ratio: exact
NEEDED = ("comparison", "natural/orders", "damper_order", "pulses", "loops")


def answer(data: Datasets, curve: TrilinearCurve) -> dict[str, Any] | None:
    """Return what the first screen says, or nothing where a dataset of `NEEDED` was not built.

    Parameters
    ----------
    data : dict of str to xarray.Dataset
        Of the report.
    curve : TrilinearCurve
        The study's.
    """
    if any(name not in data for name in NEEDED):
        return None
    compared, orders, by_order, pulses = (data[name] for name in NEEDED[:4])
    release = float(data["loops"]["release_amplitude"])
    middle = compared.isel(restitution=compared.sizes["restitution"] // 2)
    e = float(middle["restitution"])
    error = middle["log_error"].isel(band=0)
    papers = error.sel(damping_model=list(PAPER_MODELS)).min("damping_ratio_source")
    nearest_of_paper = PAPER_MODELS[int(np.argmin(papers.values))]
    own = middle["varied_log_error"].sel(variation=["lower e", "higher e"])
    shown = at_shown(by_order).sel(order=RECOMMENDED_ORDER, method="nearest")
    cell = middle.sel(damping_model=RECOMMENDED, damping_ratio_source=SOURCE)
    found = float(orders["recommended_order"])
    return {
        "model": RECOMMENDED,
        "title": TITLES[RECOMMENDED],
        "e": plain(e),
        "ratios": ratios(curve, e, release),
        "release": plain(release),
        "records": int(orders["records"]),
        "error": off(cell["log_error"].isel(band=0)),
        "own": off(own.isel(band=0).max()),
        "within": float(cell["log_error"].isel(band=0)) <= float(own.isel(band=0).max()),
        "large": plain(compared["band_start"][-1]),
        "large_error": off(cell["log_error"].isel(band=-1)),
        "large_own": off(own.isel(band=-1).max()),
        "change": plain(orders["restitution_change"]),
        "paper_model": nearest_of_paper,
        "paper_error": off(papers.sel(damping_model=nearest_of_paper)),
        "safe": percent(cell["false_safe_rate"]),
        "before": off(shown["pulse_before_impact_log_error"]),
        **under_pulses(pulses),
        "found": plain(found) if np.isfinite(found) else None,
        "agrees": found == RECOMMENDED_ORDER,
        "order": RECOMMENDED_ORDER,
    }


def off(log_error: Any) -> str:
    """Return a root mean square of logarithms as the percentage that it stands for."""
    return percent(np.expm1(float(log_error)))


def ratios(curve: TrilinearCurve, e: float, release: float) -> list[dict[str, Any]]:
    """Return each damper with its ratio at e for a curve and a release, the recommended one first."""
    exact = interactive.exact_dampers()
    models = [RECOMMENDED, *(model for model in reversed(VISCOUS_MODELS) if model != RECOMMENDED)]
    return [
        {
            "model": model,
            "title": TITLES[model],
            "exact": model in exact,
            "ratio": f"{100 * float(damping_ratio_energy(curve, model, e, release)):.2f}",
        }
        for model in models
    ]


def under_pulses(pulses: xr.Dataset) -> dict[str, str]:
    """Return how far the recommended damper's peaks are off under the slowest and under the quickest pulses."""
    at_e = pulses.isel(restitution=pulses.sizes["restitution"] // 2).sel(
        damping_model=RECOMMENDED, damping_ratio_source=SOURCE
    )
    stand = (at_e["collapsed"] == 0) & (at_e["reference_collapsed"] == 0)
    ratio = at_e["peak_ratio"] / at_e["reference_peak"]
    squares = ratio.copy(data=np.log(ratio.values) ** 2).where(stand).sortby("pulse_frequency")
    error = np.sqrt(squares.mean(["pulse", "load_ratio"]).values)
    return {"slow": off(error[0]), "quick": off(error[-1])}
