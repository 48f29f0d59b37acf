"""The report's numbers on the histories under earthquakes: how many there are, and how certain they are."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from rockdamp.text import listed, percent, plain
from rockdamp.vocabulary import REFERENCE

ENOUGH_STATIONS = 10  # intervals over fewer mean nothing


def run(compared: xr.Dataset, walls: xr.Dataset) -> dict[str, Any]:
    """Return how many walls, records and histories there are, and how certain their outcomes and peaks."""
    each = int(np.isfinite(walls["damping_ratio"].values).sum()) + walls.sizes["wall"] * walls.sizes["restitution"]
    uncertainty = compared["relative_uncertainty"]
    return {
        "few": int(compared["stations"]) < ENOUGH_STATIONS,
        "wall_count": walls.sizes["wall"],
        "restitutions": listed(plain(value) for value in compared["restitution"].values),
        "histories": f"{int(compared['records']) * compared.sizes['velocity_ratio'] * each:,}".replace(",", "\u202f"),
        "settled": f"{100 * float(compared['settled_share']):.2f}",
        "uncertainty": [
            (percent(part, 3), percent(value))
            for part, value in zip(uncertainty["share"], uncertainty, strict=True)
            if part < 1
        ],
    }


CHECKS = {
    "earthquakes/check": "Histories of the study, solved again event by event",
    "population/check": "Histories of the population, which has one step, a longer one, solved again event by event",
}
STRATA = {
    "far": "survives, peak below 0.5 u_ins",
    "near": "survives, 0.5 to 0.8 u_ins",
    "edge": "survives, 0.8 u_ins and more",
    "just collapsed": "collapses, and not at the next lower intensity",
    "unsettled": "outcome depends on the step",
}


def exceptions(earthquakes: xr.Dataset | None) -> list[xr.Dataset]:
    """Return the histories whose bound is larger than their peak, that of the largest ratio first."""
    if earthquakes is None:
        return []
    peak = earthquakes["peak"]
    over = earthquakes["peak_uncertainty"] / peak
    again = (over["damping_model"] == REFERENCE) & (over["damping_ratio_source"] != over["damping_ratio_source"][0])
    histories = xr.Dataset({"peak": peak, "over": over.where(~again)}).stack(history=over.dims)
    named = histories.isel(history=np.flatnonzero(histories["over"] > 1))
    return [named.isel(history=index) for index in np.argsort(-named["over"].values, kind="stable")]
