"""The answer in short: which damper, what it costs, which program takes which, and where it ends."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from markupsafe import Markup

from rockdamp.constants import RECOMMENDED_SOURCE
from rockdamp.equivalence.programs import REFERENCE_QUANTITY, REQUIREMENT
from rockdamp.figures.style import RESTITUTION
from rockdamp.mechanics.damping import DAMPERS
from rockdamp.storage.dataset import Datasets
from rockdamp.text import DASH, count_noun, number, percent, plain

BAND = "BAND0.2"  # the damper of the first screen, by its name in the dataset ``order``
# Rows of the first table: a part of the families, the wider band first, and restitution with another e after them.
SHOWN = ("ECD", "ECD16", "ECD64", "BAND0.4", BAND, "BAND0.1", "CQD0.25")
COLUMNS = {
    "|ln r|, median": "log_error_median",
    "|ln r|, 90 %": "log_error_90",
    "|ln r| > 5 %": "share_above",
    "collapses missed": "missed_collapse_rate",
    "collapses added": "added_collapse_rate",
}
# Columns of the dampers by program: the errors of ``comparison`` over all its peaks.
OF_PROGRAMS = ("log_error_median", "log_error_90", "missed_collapse_rate")


def answer(data: Datasets, a1: float) -> dict[str, Any] | None:
    """Return the values of the first screen for a wall of this a1, or None without ``order`` and ``comparison``.

    The dampers by program have a list over the e of ``comparison``; ``at`` is the place of the e that is shown first.
    """
    if not {"order", "comparison"} <= data.keys():
        return None
    e, order = data["comparison"]["restitution"].values, select_e(data["order"])
    return {
        "at": e.size // 2,
        "e": [plain(value) for value in e],
        "ratios": ratios(data, a1),
        "selection": selection(data["comparison"]),
        "programs": by_program(data["comparison"]),
        "order_e": plain(order["restitution"]),
        "records": int(order["records"]),
        "columns": list(COLUMNS),
        "order": order_rows(order),
        "ends": {variable: percent(order[variable].sel(damper=BAND)) for variable in COLUMNS.values()},
        "floor": percent(order["share_above"].sel(damper="half step")),
        "amplitude": of_amplitude(data["loss_law"]) if "loss_law" in data else None,
    }


def select_e(order: xr.Dataset) -> xr.Dataset:
    """Return the errors over force at the e that the page and `fig_order` show."""
    return order.sel(restitution=RESTITUTION, method="nearest")


def order_rows(at_e: xr.Dataset) -> list[dict[str, Any]]:
    """Return a row for each damper that is shown at one e, and for CR with another e.

    The errors are percentages with their intervals, the force is that of the paper's curve over F0, and the step that
    of w1 h.
    """
    studied = at_e["damper"].values.tolist()
    changed = [name for name in studied if name.startswith("e ")]
    return [
        {
            "damper": f"CR, {name}" if name in changed else name,
            "force": number(row["crossing_force"].sel(wall="paper"), 2),
            "errors": [with_interval(row, variable, rate=True) for variable in COLUMNS.values()],
            "step": plain(row["largest_step"]) if np.isfinite(row["largest_step"]) else DASH,
        }
        for name in (*SHOWN, *changed)
        if name in studied
        for row in [at_e.sel(damper=name)]
    ]


def with_interval(cell: xr.Dataset, name: str, rate: bool = False) -> str:
    """Return a statistic and its interval: "0.149 (0.138 to 0.160)"."""
    show = percent if rate else number
    bounds = cell[f"{name}_interval"].values
    if not np.isfinite(bounds).all():
        return show(cell[name])
    return Markup("{} <small>({} to {})</small>").format(show(cell[name]), *(show(bound) for bound in bounds))


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


def selection(compared: xr.Dataset) -> str:
    """Say over which histories the errors are: the same for every damper of the tables."""
    walls = int(compared["pooled"].sel(damping_ratio_source=RECOMMENDED_SOURCE).sum())
    peaks = f"{plain(compared['band_start'][0])} to {plain(compared['band_end'][0])}"
    records = f"{int(compared['records'])} earthquake records"
    return f"{count_noun(walls, 'wall')} under {records}, peaks of {peaks} u_ins under restitution"


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
            for model in REQUIREMENT
            if bool(np.isfinite(ratio.sel(damping_model=model)).all())
        },
    }


def shown_ratio(ratios: dict[str, Any] | None, model: str, e: str) -> str:
    """Write a damping ratio between those of the neighbouring e, as the page's script does; a dash if none. [%]"""
    if ratios is None or model not in ratios["ratio"]:
        return DASH
    ratio = np.interp(float(e), ratios["e"], ratios["ratio"][model], left=np.nan, right=np.nan)
    return f"{100 * ratio:.2f}" if np.isfinite(ratio) else DASH


def by_program(compared: xr.Dataset) -> list[dict[str, Any]]:
    """Return the rows of the table of dampers by what a program takes: median, 90 % and collapses missed at each e."""
    leading = compared.sel(damping_ratio_source=RECOMMENDED_SOURCE).isel(band=0)
    return [
        {
            "offer": offer,
            "model": model,
            "title": DAMPERS[model].title,
            "refers_to": REFERENCE_QUANTITY[model],
            "errors": [list(map(percent, leading[name].sel(damping_model=model).values)) for name in OF_PROGRAMS],
        }
        for model, offer in REQUIREMENT.items()
    ]
