"""How much the answer for one wall moves, as each input is changed in turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from rockdamp.assessment.assess import assess_rows
from rockdamp.assessment.table import Row
from rockdamp.constants import REFERENCE
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.catalogue import GroundMotion

E_CHANGE, HINGE_CHANGE = 0.05, 0.1  # what is left open without a test of the wall
FACTORS = (0.5, 2.0)  # on a1 and on the overburden
FIRST_OVERBURDEN = 0.5  # O/W in place of none


def sensitivity(
    wall: Wall | Parapet, curve: TrilinearCurve, answer: xr.Dataset, motions: Sequence[GroundMotion]
) -> list[dict[str, Any]]:
    """Assess the wall of an answer again with one input changed at a time; what makes no wall is left out.

    `motions` are those of the answer. Returned are the ``input``, its ``value``, the ``collapse_probability`` at the
    highest intensity and the ``median``, under restitution.
    """
    measure, e = answer.attrs["intensity_measure"], float(answer["restitution"])
    load, a1 = float(wall.overburden_ratio), float(curve.yield_displacement_ratio)
    changes: list[tuple[str, str, float]] = [
        ("restitution e", "restitution", e + by) for by in (-E_CHANGE, E_CHANGE)
    ]
    if isinstance(wall, Wall):
        hinge = float(wall.hinge_ratio)
        changes += [
            ("hinge h₁/h", "hinge_ratio", hinge + by) for by in (-HINGE_CHANGE, HINGE_CHANGE)
        ]
    changes += [("a₁", "yield_displacement_ratio", factor * a1) for factor in FACTORS]
    loads = [factor * load for factor in FACTORS] if load else [FIRST_OVERBURDEN]
    changes += [("overburden O/W", "overburden_ratio", value) for value in loads]
    rows: dict[tuple[str, float], Row] = {}
    for label, name, value in changes:
        try:
            change: dict[str, Any] = {name: value}
            changed = (
                replace(wall, **change) if name in ("hinge_ratio", "overburden_ratio") else wall
            )
            bent = replace(curve, **change) if name == "yield_displacement_ratio" else curve
        except InputError:
            continue
        kept = float(np.clip(value, 0.0, 1.0)) if name == "restitution" else e
        rows[label, value] = Row(f"{label} {value}", changed, bent, kept)
    intensity = float(answer[measure.lower()][-1])
    found = assess_rows(
        list(rows.values()), motions, measure, intensity, tail=float(answer["tail"])
    )
    cr = found.sel(damping_model=REFERENCE)
    names = ("collapse_probability", f"median_{measure.lower()}")
    values = zip(rows, *(cr[name].values for name in names), strict=True)
    return [
        {
            "input": label,
            "value": value,
            "collapse_probability": float(share),
            "median": float(median),
        }
        for (label, value), share, median in values
    ]
