"""Walls as their user states them, by named values: one wall, or the rows of a table, and e by its rule."""

from __future__ import annotations

import csv
import os
from collections.abc import Mapping
from dataclasses import dataclass
from io import StringIO
from typing import Any

import numpy as np

from rockdamp.errors import InputError, check, check_choice
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.floors import Diaphragm
from rockdamp.mechanics.wall import SORRENTINO_RATIO, OneSidedWall, Parapet, Wall
from rockdamp.storage.files import read_text
from rockdamp.units import name_and_unit, quantity

# Of the values that describe a wall the SI unit, by name; None for texts.
COLUMNS: dict[str, str | None] = {
    **dict.fromkeys(("id", "parapet", "one_sided", "preset", "softening")),
    **dict.fromkeys(("thickness", "height", "width", "eccentricity"), "m"),
    **dict.fromkeys(
        ("hinge_ratio", "overburden_ratio", "overburden_mass", "a1", "b1", "a3", "restitution"), ""
    ),
    "density": "kg m-3",
    "overburden": "N m-1",
    "diaphragm_period": "s",
}
HINGED = ("hinge_ratio", "overburden_mass")  # which a parapet has not
SIZES = ("thickness", "height", "width", "density", "overburden_ratio", "eccentricity", *HINGED)


def make_wall(values: Mapping[str, Any]) -> Wall | Parapet | OneSidedWall:
    """Return the wall of some values, by the names of `COLUMNS`; what is None or missing has the default of `Wall`.

    ``overburden`` is a load on a metre of wall [N m-1]; ``parapet`` and ``one_sided`` are true or false.
    """
    sizes = {name: values[name] for name in SIZES if values.get(name) is not None}
    kind: type[Wall | Parapet] = Parapet if values.get("parapet") else Wall
    for name in HINGED:
        if kind is Parapet and name in sizes:
            raise InputError(f"{name} is {sizes[name]}; a parapet must have none")
    if values.get("overburden") is not None:
        if "overburden_ratio" in sizes:
            raise InputError(
                "overburden and overburden_ratio state the same; there must be one of them"
            )
        bare = kind(**sizes)
        sizes["overburden_ratio"] = values["overburden"] * float(bare.width / bare.weight)
    wall = kind(**sizes)
    return OneSidedWall(wall) if values.get("one_sided") else wall


def make_curve(values: Mapping[str, Any]) -> TrilinearCurve:
    """Return the curve of ``preset``, or of ``a1`` and ``b1``; without ``a3`` and ``softening`` with their defaults."""
    a1, b1, preset = (values.get(name) for name in ("a1", "b1", "preset"))
    names = {"a3": "ultimate_displacement_ratio", "softening": "softening"}
    last = {names[name]: values[name] for name in names if values.get(name) is not None}
    if (a1 is None) is not (b1 is None) or (preset is None) is (a1 is None):
        raise InputError("there must be either preset, or a1 and b1")
    return (
        TrilinearCurve(a1, b1, **last) if preset is None else TrilinearCurve.preset(preset, **last)
    )


# --- the rows of a table ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Row:
    """A row of the table: a wall, its curve and e; `diaphragm` is the flexible floor at its top, if there is one."""

    id: str
    wall: Wall | Parapet | OneSidedWall
    curve: TrilinearCurve
    restitution: float
    diaphragm: Diaphragm | None = None


@dataclass(frozen=True)
class BadRow:
    """A row that makes no wall, and why."""

    id: str
    error: str


def read_walls(path: str | os.PathLike[str]) -> list[Row | BadRow]:
    """Read a table of walls: a CSV with the columns ``id``, ``thickness`` and ``height`` and any others of `COLUMNS`.

    Commas, semicolons or tabs divide it. Sizes are in SI, or have their unit in the cell (``300mm``) or in the head
    (``thickness [mm]``). Lines that begin with ``#`` are remarks. A cell may be empty: then the default of `Wall`
    holds, e is by the rule ``measured``, and the curve must be stated by ``a1`` and ``b1``, or by ``preset``.
    """
    import pandas as pd  # slow to import

    lines = [line for line in read_text(path).splitlines() if not line.startswith("#")]
    text = StringIO("\n".join(lines))
    try:
        table = pd.read_csv(text, sep=None, engine="python", dtype=str, keep_default_na=False)
    except (ValueError, csv.Error) as error:
        raise InputError(f"{path}: {error}; it must be a table, as CSV") from None
    if not isinstance(table.index, pd.RangeIndex):
        raise InputError(f"{path}: a row has more cells than the head")
    heads = [name_and_unit(str(head)) for head in table.columns]
    units = {name.lower(): unit for name, unit in heads}
    for name in units:
        check_choice(f"{path}: a column", name, list(COLUMNS))
    for name in ("id", "thickness", "height"):
        if name not in units:
            raise InputError(
                f"{path}: the column {name} is missing; there must be id, thickness and height"
            )
    if len(units) < len(heads):
        raise InputError(f"{path}: a column is there twice; each must be there once")
    rows: dict[str, Row | BadRow] = {}
    for number, cells in enumerate(table.fillna("").itertuples(index=False), 1):
        filled = {
            name: cell.strip() for name, cell in zip(units, cells, strict=True) if cell.strip()
        }
        identifier = filled.pop("id", f"row {number}")
        if identifier in rows:
            raise InputError(
                f"{path}: the id {identifier!r} is there twice; each wall must have its own"
            )
        try:
            rows[identifier] = _make_row(
                identifier, {name: _value(name, filled[name], units[name]) for name in filled}
            )
        except InputError as error:
            rows[identifier] = BadRow(identifier, str(error))
    if not rows:
        raise InputError(f"{path}: has no rows; a wall must stand in each")
    return list(rows.values())


def _value(name: str, text: str, head_unit: str) -> Any:
    """Return a cell in SI: a plain number in the unit of its head, or one with its own; or a word."""
    unit = COLUMNS[name]
    if name in ("parapet", "one_sided"):
        return check_choice(name, text.lower(), ("yes", "no")) == "yes"
    if (
        unit is None
        or (name, text) == ("hinge_ratio", "weakest")
        or (name == "restitution" and text in RULES)
    ):
        return text
    try:
        return quantity(text + head_unit if text[-1].isdigit() else text, unit)
    except ValueError as error:
        raise InputError(f"{name}: {error}") from None


def _make_row(identifier: str, values: Mapping[str, Any]) -> Row:
    for name in ("thickness", "height"):
        if name not in values:
            raise InputError(f"{name} is empty; it must be a number")
    wall, period = make_wall(values), values.get("diaphragm_period")
    e, _ = find_restitution(wall, values.get("restitution", DEFAULT_RULE))
    if period is not None and isinstance(wall, OneSidedWall):
        raise InputError(
            "a row that is one_sided must have no diaphragm_period: the stop moves as the base does"
        )
    return Row(
        identifier, wall, make_curve(values), e, None if period is None else Diaphragm(period)
    )


# --- e by a rule ------------------------------------------------------------------------------------------------------

# ASSUME: `measured` has the paper's factor, section 4.1. The tests that it quotes give 0.86 of Eq. (7), 0.85 to 0.91:
# 0.90 is on the safe side of their mean, and not of rigid mechanics, `impulsive`, for slender walls.
DEFAULT_RULE = "measured"
RULES = {
    "measured": f"{SORRENTINO_RATIO:.2f} of Eq. (7), near the upper end of the tests of walls that the paper quotes",
    "rigid": "Eq. (7): angular momentum about the new base pivot",
    "impulsive": "with the impulse of every support",
}
HOUSNER = "Housner: one block that rocks on its base"
SORRENTINO = "Sorrentino, AlShawa and Decanini (2011), second-hand: a block that hits a return wall"


def find_restitution(
    wall: Wall | Parapet | OneSidedWall, restitution: float | str
) -> tuple[float, str]:
    """Return e, by its rule or as it is given, and the reason for it; for a parapet every rule is Housner's. [-]"""
    if not isinstance(restitution, str):
        check("restitution", restitution, lambda e: (e >= 0) & (e <= 1), "at least 0 and at most 1")
        return float(restitution), "given"
    if isinstance(wall, OneSidedWall):
        if isinstance(wall.mechanism, Wall) or restitution != DEFAULT_RULE:
            raise InputError(
                f"restitution is {restitution!r}; it must be a number, or of a one-sided block measured"
            )
        return float(wall.restitution_measured), SORRENTINO
    check_choice("restitution", restitution, tuple(RULES))
    e = float(getattr(wall, f"restitution_{restitution}"))
    if np.isnan(e):  # of a mass on the wall
        raise InputError(
            f"restitution is {restitution!r}; with overburden_mass it must be a number or another rule"
        )
    return e, HOUSNER if isinstance(wall, Parapet) else RULES[restitution]
