"""The report's numbers on the histories under earthquakes: how many there are, and how certain they are."""

from __future__ import annotations

from collections.abc import Mapping
from operator import itemgetter
from typing import Any

import numpy as np
import xarray as xr

from rockdamp.text import DASH, listed, number, percent, plain
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


def check(sample: xr.Dataset | None) -> list[dict[str, Any]]:
    """Compare each stratum of a sample of the histories with the event-driven solution; none without a sample."""
    if sample is None:
        return []
    return [
        {
            "stratum": STRATA[str(part["stratum"].values)],
            "study": f"{int(part['study_count']):,}".replace(",", "\u202f"),
            "checked": int(part["checked_count"]),
            "otherwise": percent(part["otherwise_share"]),
            "beyond": percent(part["beyond_bound_share"]) if "beyond_bound_share" in part else DASH,
            "median": percent(part["median_difference"]),
            "largest": percent(part["largest_difference"]),
        }
        for part in (sample.isel(stratum=place) for place in range(sample.sizes["stratum"]))
        if int(part["checked_count"])
    ]


def exceptions(earthquakes: xr.Dataset | None, names: Mapping[str, str]) -> list[dict[str, Any]]:
    """List the histories whose peak is smaller than its bound, by that ratio; `names` has the sources of the ratio."""
    if earthquakes is None:
        return []
    peak = earthquakes["peak_ratio"]
    over = earthquakes["peak_ratio_uncertainty"] / peak
    again = (over["damping_model"] == REFERENCE) & (over["damping_ratio_source"] != over["damping_ratio_source"][0])
    named = []
    for index in np.argwhere((over.where(~again) > 1).values):
        at = {str(dim): over[dim].values[i] for dim, i in zip(over.dims, index, strict=True)}
        model, source = str(at["damping_model"]), str(at["damping_ratio_source"])
        bound = float(over.values[tuple(index)])
        named.append(
            {
                "record": str(at["record"]),
                "wall": str(at["wall"]),
                "velocity_ratio": number(at["velocity_ratio"]),
                "restitution": plain(at["restitution"]),
                "model": model,
                "source": DASH if model == REFERENCE else names.get(source, source),
                "peak": number(peak.values[tuple(index)], 2),
                "bound": number(bound, 2),
                "order": -bound,
            }
        )
    return sorted(named, key=itemgetter("order"))
