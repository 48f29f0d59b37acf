"""Read a table of walls, one a row: a bad row is reported with its line, and stops no other."""

from __future__ import annotations

import csv
import io
import os
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rockdamp.assessment.one_wall import stated
from rockdamp.assessment.restitution import DEFAULT_RULE, RULES
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import WEAKEST, Parapet, Wall
from rockdamp.storage import input_file
from rockdamp.units import number as text_number

NEEDED = ("id", "thickness", "height")
SIZES = ("thickness", "height", "width", "density", "hinge_ratio", "overburden_ratio", "eccentricity")
CURVE = ("a1", "b1", "a3", "softening", "preset")
COLUMNS = ("id", *SIZES, "parapet", *CURVE, "restitution")
ANSWERS: Mapping[str, bool] = {"": False, "no": False, "false": False, "0": False, "yes": True, "true": True, "1": True}
EXAMPLE = "id,thickness,height,overburden_ratio,preset"


@dataclass(frozen=True)
class Row:
    """A row of the table, by its line in the file and its id: a wall, its curve, e and its reason.

    `doubts` are the warnings about it.
    """

    line: int
    id: str
    wall: Wall | Parapet
    curve: TrilinearCurve
    restitution: float
    reason: str
    doubts: tuple[str, ...] = ()


@dataclass(frozen=True)
class BadRow:
    """A row that makes no wall, and why."""

    line: int
    id: str
    error: str


def read_walls(path: str | os.PathLike[str]) -> list[Row | BadRow]:
    """Read a table of walls: a CSV with the columns ``id``, ``thickness`` and ``height`` and any others of `COLUMNS`.

    Sizes are in SI units. A cell may be empty: then the default of `Wall` holds, e is by the rule ``measured``, and the
    curve must be stated by ``a1`` and ``b1``, or by ``preset``.
    """
    path = Path(path)
    text = input_file.text(input_file.content(path, "a CSV of walls"), path)
    reader = csv.reader(io.StringIO(text), strict=True)
    try:
        names = [name.strip() for name in next(reader, [])]
        _check_columns(names, path)
        return list(_rows(reader, names))
    except csv.Error as error:
        raise InputError(f"{path}, line {reader.line_num}: {error}; it must be a CSV") from None


def row_of(path: str | os.PathLike[str], wanted: str) -> Row:
    """Return the wall of one id; refuse a table without it, and a row that makes no wall."""
    rows = [row for row in read_walls(path) if row.id == wanted]
    if not rows:
        raise InputError(f"{os.fspath(path)}: there is no wall whose id is {wanted!r}")
    row = rows[0]
    if isinstance(row, BadRow):
        raise InputError(f"{os.fspath(path)}, {row.error}")
    return row


def _check_columns(names: list[str], path: Path) -> None:
    allowed = f"they must be {', '.join(NEEDED)} and any of {', '.join(COLUMNS[len(NEEDED) :])}, as {EXAMPLE}"
    for name in names:
        if name not in COLUMNS:
            raise InputError(f"{path}, line 1: there is no column {name!r}; {allowed}")
        if names.count(name) > 1:
            raise InputError(f"{path}, line 1: the column {name!r} is there twice; {allowed}")
    for name in NEEDED:
        if name not in names:
            raise InputError(f"{path}, line 1: the column {name!r} is missing; {allowed}")


def _rows(reader: Iterator[list[str]], names: list[str]) -> Iterator[Row | BadRow]:
    lines: dict[str, int] = {}  # of the ids
    for cells in reader:
        line: int = reader.line_num  # type: ignore[attr-defined]
        if not any(cell.strip() for cell in cells):
            continue
        identifier = dict(zip(names, map(str.strip, cells), strict=False)).get("id", "")
        try:
            if len(cells) != len(names):
                raise InputError(f"there are {len(cells)} cells; there must be {len(names)}, one for each column")
            row = _row(line, dict(zip(names, map(str.strip, cells), strict=True)))
            if identifier in lines:
                raise InputError(f"id is {identifier!r}, as on line {lines[identifier]}; each wall must have its own")
        except InputError as error:
            yield BadRow(line, identifier, f"line {line}: {error}")
        else:
            yield row
        lines.setdefault(identifier, line)


def _row(line: int, cells: Mapping[str, str]) -> Row:
    filled = {name: text for name, text in cells.items() if text}
    if "id" not in filled:
        raise InputError("id is empty; each wall must have one")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        wall, curve = _wall(filled), _curve(filled)
        e, reason = stated(wall, _restitution(filled.get("restitution", DEFAULT_RULE)))
    return Row(line, filled["id"], wall, curve, e, reason, tuple(f"line {line}: {each.message}" for each in caught))


def _wall(filled: Mapping[str, str]) -> Wall | Parapet:
    answer = filled.get("parapet", "").lower()
    if answer not in ANSWERS:
        raise InputError(f"parapet is {filled['parapet']!r}; it must be yes, no or empty")
    for name in NEEDED:
        if name not in filled:
            raise InputError(f"{name} is empty; it must be a number")
    weakest = {"hinge_ratio": WEAKEST} if filled.get("hinge_ratio") == WEAKEST else {}
    sizes: dict[str, Any] = {name: _number(name, filled[name]) for name in SIZES if name in filled.keys() - weakest}
    sizes |= weakest
    if not ANSWERS[answer]:
        return Wall(**sizes)
    if "hinge_ratio" in sizes:
        raise InputError(f"hinge_ratio is {filled['hinge_ratio']}; a parapet has no hinge, and the cell must be empty")
    return Parapet(**sizes)


def _curve(filled: Mapping[str, str]) -> TrilinearCurve:
    last: dict[str, float | str] = (
        {"ultimate_displacement_ratio": _number("a3", filled["a3"])} if "a3" in filled else {}
    )
    last |= {"softening": filled["softening"]} if "softening" in filled else {}
    if "preset" in filled:
        if "a1" in filled or "b1" in filled:
            raise InputError("preset stands for a1 and b1; there must be either it or both of them")
        return TrilinearCurve.preset(filled["preset"], **last)
    for name in ("a1", "b1"):
        if name not in filled:
            raise InputError(f"{name} is empty; there must be a1 and b1, or preset")
    make: Callable[..., TrilinearCurve] = TrilinearCurve
    return make(_number("a1", filled["a1"]), _number("b1", filled["b1"]), **last)


def _restitution(text: str) -> float | str:
    if text in RULES:
        return text
    try:
        return text_number(text)
    except ValueError:
        raise InputError(f"restitution is {text!r}; it must be a number, or one of {', '.join(RULES)}") from None


def _number(name: str, text: str) -> float:
    try:
        return text_number(text)
    except ValueError:
        raise InputError(f"{name} is {text!r}; it must be a number, in SI units") from None
