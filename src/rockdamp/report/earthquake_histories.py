"""What the report says of the histories under earthquakes: how many, how certain, and which are not."""

from __future__ import annotations

from collections.abc import Mapping
from operator import itemgetter
from typing import Any

import numpy as np
import xarray as xr

from rockdamp.report.earthquake_captions import DASH, fraction, known
from rockdamp.report.numbers import listed, percent, plain
from rockdamp.vocabulary import REFERENCE

ENOUGH_STATIONS = 10  # intervals over fewer mean nothing


def run(compared: xr.Dataset, walls: xr.Dataset) -> dict[str, Any]:
    """How many walls, records and histories there are, and how certain their outcomes and peaks."""
    each = int(np.isfinite(walls["damping_ratio"].values).sum()) + walls.sizes["wall"] * walls.sizes["restitution"]
    uncertainty = compared["relative_uncertainty"]
    return {
        "records": int(compared["records"]),
        "stations": int(compared["stations"]),
        "few": int(compared["stations"]) < ENOUGH_STATIONS,
        "wall_count": walls.sizes["wall"],
        "scale_count": compared.sizes["scale"],
        "scale_low": plain(compared["scale"].min()),
        "scale_high": plain(compared["scale"].max()),
        "restitutions": listed(plain(value) for value in compared["restitution"].values),
        "histories": f"{int(compared['records']) * compared.sizes['scale'] * each:,}".replace(",", "\u202f"),
        "settled": f"{100 * float(compared['settled_share']):.2f}",
        "uncertainty": [
            (percent(part, 3), fraction(value))
            for part, value in zip(uncertainty["share"], uncertainty, strict=True)
            if part < 1
        ],
    }


def check(sample: xr.Dataset | None) -> dict[str, Any] | None:
    """How a sample of the histories compares with the event-driven solution; none without one."""
    if sample is None:
        return None
    same = sample["collapsed"] == sample["exact_collapsed"]
    bound = sample["peak_displacement_uncertainty"]
    judged = same & (sample["collapsed"] == 0) & np.isfinite(bound)
    off = abs(sample["peak_displacement"] - sample["exact_peak"])
    return {
        "histories": sample.sizes["history"],
        "same": int(same.sum()),
        "judged": int(judged.sum()),
        "within": int((off <= bound).where(judged, False).sum()),
        "largest": fraction((off / sample["exact_peak"]).where(judged).max()),
    }


def exceptions(natural: xr.Dataset | None, names: Mapping[str, str]) -> list[dict[str, Any]]:
    """Histories whose peak has a bound larger than itself, the largest first; none without the histories.

    `names` are those of the sources of the damping ratio.
    """
    if natural is None:
        return []
    peak = natural["peak_displacement"]
    over = natural["peak_displacement_uncertainty"] / peak
    again = (over["damping_model"] == REFERENCE) & (over["damping_ratio_source"] != over["damping_ratio_source"][0])
    named = []
    for index in np.argwhere((over.where(~again) > 1).values):
        history = over[tuple(index)]
        source = str(history["damping_ratio_source"].values)
        named.append(
            {
                "record": str(history["record"].values),
                "wall": str(history["wall"].values),
                "scale": known(history["scale"]),
                "restitution": plain(history["restitution"]),
                "model": str(history["damping_model"].values),
                "source": DASH if history["damping_model"] == REFERENCE else names.get(source, source),
                "peak": known(peak[tuple(index)], 2),
                "bound": known(history, 2),
                "order": -float(history),
            }
        )
    return sorted(named, key=itemgetter("order"))
