"""Walls as their user states them: the rows of a table, a wrong one of which stops no other, and e by its rule."""

from __future__ import annotations

import csv
import io
import os
import re
import warnings
import zipfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rockdamp.arrays import Array
from rockdamp.errors import InputError, check
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.floors import DAMPING_RATIO, Diaphragm
from rockdamp.mechanics.one_sided import OneSidedWall
from rockdamp.mechanics.wall import SORRENTINO_RATIO, WEAKEST, Parapet, Wall
from rockdamp.storage.files import read_text
from rockdamp.units import name_and_unit, quantity

NEEDED = ("id", "thickness", "height")
SIZES = (
    "thickness",
    "height",
    "width",
    "density",
    "hinge_ratio",
    "overburden_ratio",
    "eccentricity",
    "overburden_mass",
)
DIAPHRAGM = ("diaphragm_period", "diaphragm_damping")
CURVE = ("a1", "b1", "a3", "softening", "preset")
COLUMNS = ("id", *SIZES, "overburden", "parapet", *CURVE, "restitution", *DIAPHRAGM, "one_sided")
UNITS = {**dict.fromkeys(("thickness", "height", "width", "eccentricity"), "m"), "density": "kg m-3"}
ANSWERS: Mapping[str, bool] = {"": False, "no": False, "false": False, "0": False, "yes": True, "true": True, "1": True}
REMARK = "#"
WORKBOOKS = {".xlsx": "openpyxl", ".xls": "xlrd", ".parquet": "pyarrow"}  # and the package by which pandas reads each
EXAMPLE = "id,thickness,height,overburden_ratio,preset"


@dataclass(frozen=True)
class Row:
    """A row of the table, by its line in the file and its id: a wall, its curve and e.

    `diaphragm` is the flexible floor that holds its top, if one does.
    """

    line: int
    id: str
    wall: Wall | Parapet | OneSidedWall
    curve: TrilinearCurve
    restitution: float
    diaphragm: Diaphragm | None = None


@dataclass(frozen=True)
class BadRow:
    """A row that makes no wall, and why."""

    line: int
    id: str
    error: str


def read_walls(path: str | os.PathLike[str]) -> list[Row | BadRow]:
    """Read a table of walls: a CSV with the columns ``id``, ``thickness`` and ``height`` and any others of `COLUMNS`.

    Commas, semicolons or tabs divide it; beside the latter two a comma is a decimal sign. Sizes are in SI, or have
    their unit in the cell (``300mm``) or in the head (``thickness [mm]``). Lines that begin with ``#`` are remarks.
    Excel's and Parquet's files are read where pandas can. A cell may be empty: then the default of `Wall` holds, e is
    by the rule ``measured``, and the curve must be stated by ``a1`` and ``b1``, or by ``preset``.
    """
    path = Path(path)
    text = _text(path)
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith(REMARK)]
    mark = next((mark for mark in ";\t," if lines and mark in lines[0]), ",")
    reader = csv.reader(io.StringIO(text), strict=True, delimiter=mark)
    try:
        first: list[str] = next((cells for cells in reader if not _is_remark(cells)), [])
        heads = [name_and_unit(head) for head in first]
        names = [name.lower() if name.lower() in COLUMNS else "" for name, _ in heads]
        _check_columns(names, path)
        if others := [name for (name, _), known in zip(heads, names, strict=True) if name and not known]:
            warnings.warn(f"{path}: columns that are not read: {', '.join(others)}", stacklevel=2)
        return list(_rows(reader, names, [unit for _, unit in heads], mark))
    except csv.Error as error:
        raise InputError(f"{path}, line {reader.line_num}: {error}; it must be a CSV") from None


def _is_remark(cells: list[str]) -> bool:
    return not any(cell.strip() for cell in cells) or cells[0].startswith(REMARK)


def _text(path: Path) -> str:
    """Return a table as the text of a CSV; of a workbook, its first sheet."""
    if path.suffix.lower() not in WORKBOOKS:
        return read_text(path)
    book = io.BytesIO(path.read_bytes())
    import pandas as pd  # slow to import

    try:
        read = pd.read_parquet if path.suffix.lower() == ".parquet" else pd.read_excel
        return str(read(book).to_csv(index=False))
    except ImportError:
        package = WORKBOOKS[path.suffix.lower()]
        raise InputError(f"{path}: needs {package}; it must be saved as CSV, or: pip install {package}") from None
    except (ValueError, KeyError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: {error}; it must be a table of walls, as a workbook or as CSV") from None


def _with_point(cell: str, mark: str) -> str:
    return cell.replace(",", ".") if mark != "," and re.fullmatch(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?", cell) else cell


def _check_columns(names: list[str], path: Path) -> None:
    allowed = f"they must be {', '.join(NEEDED)} and any of {', '.join(COLUMNS[len(NEEDED) :])}, as {EXAMPLE}"
    for name in filter(None, names):
        if names.count(name) > 1:
            raise InputError(f"{path}, line 1: the column {name!r} is there twice; {allowed}")
    for name in NEEDED:
        if name not in names:
            raise InputError(f"{path}, line 1: the column {name!r} is missing; {allowed}")


def _rows(reader: Iterator[list[str]], names: list[str], units: list[str], mark: str) -> Iterator[Row | BadRow]:
    lines: dict[str, int] = {}  # of the ids
    for cells in reader:
        line: int = reader.line_num  # type: ignore[attr-defined]
        if _is_remark(cells):
            continue
        identifier = dict(zip(names, map(str.strip, cells), strict=False)).get("id", "")
        try:
            if len(cells) != len(names):
                raise InputError(f"there are {len(cells)} cells; there must be {len(names)}, one for each column")
            texts = [_with_point(cell.strip(), mark) for cell in cells]
            texts = [f"{text}{unit}" if text[-1:].isdigit() else text for text, unit in zip(texts, units, strict=True)]
            row = _row(line, dict(zip(names, texts, strict=True)))
            if identifier in lines:
                raise InputError(f"id is {identifier!r}, as on line {lines[identifier]}; each wall must have its own")
        except InputError as error:
            yield BadRow(line, identifier, f"line {line}: {error}")
        else:
            yield row
        lines.setdefault(identifier, line)


def _row(line: int, cells: Mapping[str, str]) -> Row:
    filled = {name: text for name, text in cells.items() if name and text}
    if "id" not in filled:
        raise InputError("id is empty; each wall must have one")
    wall = _one_sided(filled, _wall(filled))
    e, _ = restitution_and_reason(wall, _restitution(filled.get("restitution", DEFAULT_RULE)))
    return Row(line, filled["id"], wall, _curve(filled), e, _diaphragm(filled))


def _answer(name: str, filled: Mapping[str, str]) -> bool:
    answer = filled.get(name, "").lower()
    if answer not in ANSWERS:
        raise InputError(f"{name} is {filled[name]!r}; it must be yes, no or empty")
    return ANSWERS[answer]


def _wall(filled: Mapping[str, str]) -> Wall | Parapet:
    parapet = _answer("parapet", filled)
    for name in NEEDED:
        if name not in filled:
            raise InputError(f"{name} is empty; it must be a number")
    sizes: dict[str, Any] = {
        name: WEAKEST if filled[name] == WEAKEST else _number(name, filled[name], UNITS.get(name, ""))
        for name in SIZES
        if name in filled
    }
    if parapet and "hinge_ratio" in sizes:
        raise InputError(f"hinge_ratio is {filled['hinge_ratio']}; a parapet has no hinge, and the cell must be empty")
    if parapet and "overburden_mass" in sizes:
        raise InputError(
            f"overburden_mass is {filled['overburden_mass']}; nothing holds it on a parapet: the cell must be empty"
        )
    kind: Callable[..., Wall | Parapet] = Parapet if parapet else Wall
    if "overburden" in filled:
        sizes["overburden_ratio"] = _overburden_ratio(filled, kind(**sizes))
    return kind(**sizes)


def _one_sided(filled: Mapping[str, str], wall: Wall | Parapet) -> Wall | Parapet | OneSidedWall:
    """Return the wall against a stop where the row says that it is."""
    if not _answer("one_sided", filled):
        return wall
    if DIAPHRAGM[0] in filled:
        raise InputError("a row that is one_sided has no diaphragm: the stop moves as the base does")
    return OneSidedWall(wall)


def _diaphragm(filled: Mapping[str, str]) -> Diaphragm | None:
    period, damping = DIAPHRAGM
    if period not in filled:
        if damping in filled:
            raise InputError(f"{damping} is there without {period}; both or neither must be")
        return None
    seconds = _number(period, filled[period], "s")
    return Diaphragm(seconds, _number(damping, filled[damping]) if damping in filled else DAMPING_RATIO)


def _overburden_ratio(filled: Mapping[str, str], wall: Wall | Parapet) -> float:
    """Return O/W of a load on a metre of a wall."""
    if "overburden_ratio" in filled:
        raise InputError("overburden and overburden_ratio state the same; one of the two cells must be empty")
    return float(_number("overburden", filled["overburden"], "N m-1") * wall.width / wall.weight)


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
    return text if text in RULES else _number("restitution", text)


def _number(name: str, text: str, unit: str = "") -> float:
    """Return a cell in SI: a plain number, or one with its unit."""
    try:
        return quantity(text, unit)
    except ValueError as error:
        raise InputError(f"{name}: {error}") from None


# --- e by a rule ------------------------------------------------------------------------------------------------------

Rocking = Wall | Parapet
SORRENTINO = "Sorrentino, AlShawa and Decanini (2011), second-hand: a block that hits a return wall"

# By the name of the rule: what it gives, and what it is called for a wall.
RULES: Mapping[str, tuple[Callable[[Rocking], Array], str]] = {
    "measured": (
        lambda wall: wall.restitution_measured,
        f"{SORRENTINO_RATIO:.2f} of Eq. (7), near the upper end of the tests of walls that the paper quotes",
    ),
    "rigid": (lambda wall: wall.restitution_rigid, "Eq. (7): angular momentum about the new base pivot"),
    "impulsive": (lambda wall: wall.restitution_impulsive, "with the impulse of every support"),
}
# ASSUME: the paper's factor, section 4.1. The tests that it quotes give 0.86 of Eq. (7), 0.85 to 0.91: 0.90 is on the
# safe side of their mean, and not of rigid mechanics, `impulsive`, for slender walls.
DEFAULT_RULE = "measured"
HOUSNER = "Housner: one block that rocks on its base"


def by_rule(wall: Rocking | OneSidedWall, rule: str = DEFAULT_RULE) -> tuple[Array, str]:
    """Return e of a wall by the name of a rule, and its reason; for a parapet every rule is Housner's. [-]"""
    if rule not in RULES:
        raise InputError(f"restitution (e) is {rule!r}; it must be a number, or one of {', '.join(RULES)}")
    if isinstance(wall, OneSidedWall):
        if isinstance(wall.mechanism, Wall) or rule != DEFAULT_RULE:
            allowed = f"a number against a stop, or {DEFAULT_RULE} of a block"
            raise InputError(f"restitution (e) is {rule!r}; it must be {allowed}")
        return wall.restitution_measured, SORRENTINO
    if isinstance(wall, Parapet):
        return wall.restitution_rigid, HOUSNER
    formula, reason = RULES[rule]
    e = formula(wall)
    if np.isnan(e).any():  # of a mass on the wall
        raise InputError(f"restitution (e) is {rule!r}; with overburden_mass it must be a number or another rule")
    return e, reason


def restitution_and_reason(wall: Rocking | OneSidedWall, restitution: float | str) -> tuple[float, str]:
    """Return e, by its rule or as it is given, and the reason for it. [-]"""
    if isinstance(restitution, str):
        by_name, reason = by_rule(wall, restitution)
        e = float(by_name)
    else:
        check("restitution", restitution, lambda e: (e >= 0) & (e <= 1), "at least 0 and at most 1")
        e, reason = float(restitution), "as given"
    return e, reason
