"""The checks and the building on the page of one wall: what stands where, in words and numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from rockdamp.assessment.checks import Check
from rockdamp.mechanics.building import Building
from rockdamp.text import number, percent
from rockdamp.vocabulary import STANDARD_GRAVITY


@dataclass(frozen=True)
class Placement:
    """Where a wall stands, in words; what `assess --json` says of its building, and the check at each intensity."""

    checks: tuple[Check, ...] = ()
    place: str = ""
    values: Mapping[str, Any] | None = None
    building: Building | None = None


def section(placement: Placement, instability_displacement: float) -> dict[str, Any] | None:
    """Return what the page says of the highest intensity, for a wall of u_ins [m]; None where there is no check."""
    if not placement.checks:
        return None
    check = placement.checks[-1]
    rows = [
        {
            "name": "force: supports' peak acceleration (median) against the onset of rocking",
            "demand": f"{number(check.support_acceleration / STANDARD_GRAVITY)} g",
            "capacity": f"{number(check.rocking_onset / STANDARD_GRAVITY)} g",
            "verdict": "it rocks" if check.rocks else "it does not rock",
        }
    ]
    for name, peak, met in (
        ("median peak", check.median_peak, check.median_met),
        ("peak that 84 % of the records do not pass", check.upper_peak, check.upper_met),
    ):
        rows.append(
            {
                "name": f"displacement: {name}",
                "demand": f"{number(1000 * peak)} mm" if np.isfinite(peak) else "collapse",
                "capacity": f"{number(1000 * check.capacity)} mm",
                "verdict": "met" if met else "not met",
            }
        )
    return {
        "rows": rows,
        "capacity": number(check.capacity / instability_displacement, 2),
        "place": placement.place,
        "margin": number(check.margin) if np.isfinite(check.margin) else None,
        "left_out": percent(placement.values["left_out"]) if placement.values else "",
        "shape": _shape(placement.building) if placement.building else "",
        "periods": _periods(placement.values),
    }


def _shape(building: Building) -> str:
    """Return how a building deforms."""
    by_name = {np.inf: "in shear", 0.0: "in flexure"}
    alpha = building.shear_ratio
    return by_name.get(alpha, f"in shear and flexure, with a shear ratio of {number(alpha)}")


def _periods(values: Mapping[str, Any] | None) -> list[dict[str, str]]:
    """Return the answer for each period of the building, where there are several."""
    rows = values["periods"] if values else []
    return [
        {
            "period": f"{row['building_period']:g} s",
            "share": percent(row["collapse_probability"]),
            "median": number(np.nan if row["median_intensity"] is None else row["median_intensity"]),
        }
        for row in rows
        if len(rows) > 1
    ]
