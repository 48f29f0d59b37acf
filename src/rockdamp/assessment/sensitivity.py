"""The change of the answer for one wall as each input is changed in turn."""

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


def sensitivity(
    wall: Wall | Parapet, curve: TrilinearCurve, answer: xr.Dataset, motions: Sequence[GroundMotion]
) -> list[dict[str, Any]]:
    """Assess the wall of an answer again, with one input changed at a time.

    Parameters
    ----------
    wall : Wall or Parapet
        One wall.
    curve : TrilinearCurve
        Force-displacement curve of the wall.
    answer : xarray.Dataset
        Answer of `assess` for the wall.
    motions : sequence of GroundMotion
        Motions of the answer.

    Returns
    -------
    list of dict
        ``input``, its ``value``, and under restitution the ``collapse_probability`` at the highest
        intensity and the ``median``. A change that makes no wall is left out.
    """
    measure = answer.attrs["intensity_measure"]
    changes = _list_changes(wall, curve, float(answer["restitution"]))
    rows = []
    for label, name, value in changes:
        try:
            row = Row(f"{label} {value}", wall, curve, float(answer["restitution"]))
            rows.append(_change_input(row, name, value))
        except InputError:
            continue
    intensity = float(answer[measure.lower()][-1])
    answers = assess_rows(rows, motions, measure, intensity, tail=float(answer["tail"]))
    cr = answers.sel(damping_model=REFERENCE)
    inputs = {f"{label} {value}": (label, value) for label, _, value in changes}
    table = []
    for row in rows:
        label, value = inputs[row.id]
        values = cr.sel(wall=row.id)
        table.append(
            {
                "input": label,
                "value": value,
                "collapse_probability": values["collapse_probability"].item(),
                "median": values[f"median_{measure.lower()}"].item(),
            }
        )
    return table


def _list_changes(
    wall: Wall | Parapet, curve: TrilinearCurve, restitution: float
) -> list[tuple[str, str, float]]:
    """Return the label, the name and the value of each input that is changed."""
    # ASSUME: without a test of the wall, e is open by 0.05 and the hinge by 0.1 of the height;
    # a1 and the overburden by a factor of two.
    factors = (0.5, 2.0)
    changes = [("restitution e", "restitution", restitution + shift) for shift in (-0.05, 0.05)]
    if isinstance(wall, Wall):
        hinge = float(wall.hinge_ratio)
        changes += [("hinge h₁/h", "hinge_ratio", hinge + shift) for shift in (-0.1, 0.1)]
    a1 = float(curve.yield_displacement_ratio)
    changes += [("a₁", "yield_displacement_ratio", factor * a1) for factor in factors]
    overburden = float(wall.overburden_ratio)
    loads = [factor * overburden for factor in factors] if overburden else [0.5]
    changes += [("overburden O/W", "overburden_ratio", load) for load in loads]
    return changes


def _change_input(row: Row, name: str, value: float) -> Row:
    """Return a row with another value of one input; e ends at 0 and 1."""
    change: dict[str, Any] = {name: value}
    if name == "restitution":
        return replace(row, restitution=float(np.clip(value, 0.0, 1.0)))
    if name == "yield_displacement_ratio":
        return replace(row, curve=replace(row.curve, **change))
    return replace(row, wall=replace(row.wall, **change))
