"""Walls as their user states them: the rows of a table, a wrong one of which stops no other, and e by its rule."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from io import StringIO
from typing import Any

import numpy as np

from rockdamp.errors import InputError, check, check_choice
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.floors import Diaphragm
from rockdamp.mechanics.one_sided import OneSidedWall
from rockdamp.mechanics.wall import SORRENTINO_RATIO, Parapet, Wall
from rockdamp.storage.files import read_text
from rockdamp.units import name_and_unit, quantity

NEEDED = ("id", "thickness", "height")
HINGED_SIZES = ("hinge_ratio", "overburden_mass")  # which a parapet has not
SIZES = ("thickness", "height", "width", "density", "overburden_ratio", "eccentricity", *HINGED_SIZES)
TEXTS = ("id", "preset", "softening", "parapet", "one_sided")
COLUMNS = (*SIZES, "overburden", "a1", "b1", "a3", "restitution", "diaphragm_period", *TEXTS)
UNITS = {**dict.fromkeys(("thickness", "height", "width", "eccentricity"), "m"), "density": "kg m-3"}
UNITS |= {"overburden": "N m-1", "diaphragm_period": "s"}


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
    names, units = [name.lower() for name, _ in heads], [unit for _, unit in heads]
    for name in names:
        check_choice(f"{path}: a column", name, COLUMNS)
    if missing := [name for name in NEEDED if name not in names]:
        raise InputError(f"{path}: the column {missing[0]} is missing; there must be {', '.join(NEEDED)}")
    rows: dict[str, Row | BadRow] = {}
    for number, cells in enumerate(table.itertuples(index=False), 1):
        texts = {name: str(cell).strip() for name, cell in zip(names, cells, strict=True) if cell == cell}
        filled = {name: text for name, text in texts.items() if text}
        identifier = filled.get("id", f"row {number}")
        if identifier in rows:
            raise InputError(f"{path}: the id {identifier!r} is there twice; each wall must have its own")
        try:
            rows[identifier] = _row(identifier, filled, dict(zip(names, units, strict=True)))
        except InputError as error:
            rows[identifier] = BadRow(identifier, str(error))
    if not rows:
        raise InputError(f"{path}: has no rows; a wall must stand in each")
    return list(rows.values())


def _row(identifier: str, filled: Mapping[str, str], units: Mapping[str, str]) -> Row:
    numbers = {name: _number(name, text, units[name]) for name, text in filled.items() if name not in TEXTS}
    parapet, one_sided = (filled.get(name, "no").lower() for name in ("parapet", "one_sided"))
    for name, text in (("parapet", parapet), ("one_sided", one_sided)):
        check_choice(name, text, ("yes", "no"))
    hinged = {name: numbers.pop(name) for name in HINGED_SIZES if name in numbers}
    if parapet == "yes" and hinged:
        raise InputError(f"{next(iter(hinged))} belongs to a wall; of a parapet the cell must be empty")
    sizes = {name: numbers[name] for name in SIZES if name in numbers}
    if missing := [name for name in NEEDED[1:] if name not in sizes]:
        raise InputError(f"{missing[0]} is empty; it must be a number")
    kind: Callable[..., Wall | Parapet] = Parapet if parapet == "yes" else partial(Wall, **hinged)
    if "overburden" in numbers:
        if "overburden_ratio" in numbers:
            raise InputError("overburden and overburden_ratio state the same; one of the two cells must be empty")
        bare = kind(**sizes)
        sizes["overburden_ratio"] = numbers["overburden"] * float(bare.width / bare.weight)
    wall: Any = OneSidedWall(kind(**sizes)) if one_sided == "yes" else kind(**sizes)
    e, _ = restitution_and_reason(wall, numbers.get("restitution", DEFAULT_RULE))
    period = numbers.get("diaphragm_period")
    if one_sided == "yes" and period is not None:
        raise InputError("a row that is one_sided has no diaphragm: the stop moves as the base does")
    return Row(identifier, wall, _curve(filled, numbers), e, None if period is None else Diaphragm(period))


def _curve(filled: Mapping[str, str], numbers: Mapping[str, Any]) -> TrilinearCurve:
    last = {"ultimate_displacement_ratio": numbers.get("a3", 1.0), "softening": filled.get("softening", "steeper")}
    if ("preset" in filled) is ("a1" in numbers) or ("a1" in numbers) is not ("b1" in numbers):
        raise InputError("there must be either preset, or a1 and b1")
    if "preset" in filled:
        return TrilinearCurve.preset(filled["preset"], **last)
    return TrilinearCurve(numbers["a1"], numbers["b1"], **last)


def _number(name: str, text: str, unit: str) -> Any:
    """Return a cell in SI: a plain number in the unit of its head, or one with its own; or a word."""
    if text in ("weakest", *RULES) and name in ("hinge_ratio", "restitution"):
        return text
    try:
        return quantity(text + unit if text[-1].isdigit() else text, UNITS.get(name, ""))
    except ValueError as error:
        raise InputError(f"{name}: {error}") from None


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


def restitution_and_reason(wall: Wall | Parapet | OneSidedWall, restitution: float | str) -> tuple[float, str]:
    """Return e, by its rule or as it is given, and the reason for it; for a parapet every rule is Housner's. [-]"""
    if not isinstance(restitution, str):
        check("restitution", restitution, lambda e: (e >= 0) & (e <= 1), "at least 0 and at most 1")
        return float(restitution), "given"
    if isinstance(wall, OneSidedWall):
        if isinstance(wall.mechanism, Wall) or restitution != DEFAULT_RULE:
            raise InputError(f"restitution is {restitution!r}; it must be a number, or of a one-sided block measured")
        return float(wall.restitution_measured), SORRENTINO
    check_choice("restitution", restitution, tuple(RULES))
    e = float(getattr(wall, f"restitution_{restitution}"))
    if np.isnan(e):  # of a mass on the wall
        raise InputError(f"restitution is {restitution!r}; with overburden_mass it must be a number or another rule")
    return e, HOUSNER if isinstance(wall, Parapet) else RULES[restitution]
