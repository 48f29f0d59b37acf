"""Walls as their user states them: the rows of a table, a wrong one of which stops no other, and e by its rule."""

from __future__ import annotations

import csv
import difflib
import io
import os
import re
import warnings
import zipfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from rockdamp import plausibility, units
from rockdamp.arguments import number
from rockdamp.arrays import Array
from rockdamp.assessment.collapses import LEAST_OF_DAMPER
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.floors import DAMPING_RATIO, Diaphragm
from rockdamp.mechanics.one_sided import OneSidedWall
from rockdamp.mechanics.wall import SORRENTINO_RATIO, WEAKEST, Parapet, Wall
from rockdamp.stated import of_heights, of_stated
from rockdamp.storage.files import read_text
from rockdamp.units import UnitError, quantity
from rockdamp.units import number as text_number
from rockdamp.vocabulary import RECOMMENDED

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
LOADS, EMPTY_LOAD = {"overburden", "overburden_ratio"}, "the overburden is empty, and taken as 0"
COLUMNS = ("id", *SIZES, "overburden", "parapet", *CURVE, "restitution", *DIAPHRAGM, "one_sided")
LENGTHS = ("thickness", "height", "width", "eccentricity")
ANSWERS: Mapping[str, bool] = {"": False, "no": False, "false": False, "0": False, "yes": True, "true": True, "1": True}
REMARK = "#"
WORKBOOKS = {".xlsx": "openpyxl", ".xls": "xlrd", ".parquet": "pyarrow"}  # and the package by which pandas reads each
EXAMPLE = "id,thickness,height,overburden_ratio,preset"


@dataclass(frozen=True)
class Row:
    """A row of the table, by its line in the file and its id: a wall, its curve and e.

    `doubts` are the warnings about it; `diaphragm` is the flexible floor that holds its top, if one does.
    """

    line: int
    id: str
    wall: Wall | Parapet | OneSidedWall
    curve: TrilinearCurve
    restitution: float
    doubts: tuple[str, ...] = ()
    diaphragm: Diaphragm | None = None


@dataclass(frozen=True)
class BadRow:
    """A row that makes no wall, and why."""

    line: int
    id: str
    error: str


def read_walls(path: str | os.PathLike[str], storeys: int | None = None) -> list[Row | BadRow]:
    """Read a table of walls: a CSV with the columns ``id``, ``thickness`` and ``height`` and any others of `COLUMNS`.

    Commas, semicolons or tabs divide it; beside the latter two a comma is a decimal sign. Sizes are in SI units, or
    have theirs. Columns of other names are passed over with a warning; lines that begin with ``#`` without one.
    Excel's and Parquet's files are read where pandas can. A cell may be empty: then the default of `Wall` holds, e is
    by the rule ``measured``, and the curve must be stated by ``a1`` and ``b1``, or by ``preset``. `storeys` are those
    of the building that all walls stand in.
    """
    path = Path(path)
    text = _text(path)
    heads = [line for line in text.splitlines() if line.strip() and not line.startswith(REMARK)]
    mark = next((mark for mark in ";\t," if heads and mark in heads[0]), ",")
    reader = csv.reader(io.StringIO(text), strict=True, delimiter=mark)
    try:
        first: list[str] = next((cells for cells in reader if not _is_remark(cells)), [])
        stated_names = [name.strip() for name in first]
        names = [name.lower() if name.lower() in COLUMNS else "" for name in stated_names]
        _check_columns(names, path)
        others = [_near(name) for name, content in zip(stated_names, names, strict=True) if name and not content]
        if others:
            plausibility.warn([f"{path}: columns that are not read: {', '.join(others)}"])
        return _compared(list(_rows(reader, names, mark, storeys)))
    except csv.Error as error:
        raise InputError(f"{path}, line {reader.line_num}: {error}; it must be a CSV") from None


def _near(name: str) -> str:
    """Return the name of a column that is not read, with the one that may be meant."""
    near = difflib.get_close_matches(name.lower(), COLUMNS, n=1, cutoff=0.8)
    return f"{name} (did you mean {near[0]}?)" if near else name


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


def _rows(reader: Iterator[list[str]], names: list[str], mark: str, storeys: int | None) -> Iterator[Row | BadRow]:
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
            row = _row(line, dict(zip(names, texts, strict=True)), storeys)
            if identifier in lines:
                raise InputError(f"id is {identifier!r}, as on line {lines[identifier]}; each wall must have its own")
        except InputError as error:
            yield BadRow(line, identifier, f"line {line}: {error}")
        else:
            yield row
        lines.setdefault(identifier, line)


def _compared(rows: list[Row | BadRow]) -> list[Row | BadRow]:
    """Return the rows with doubts about heights unlike the others', and about no empty load where none states one."""
    good = [row for row in rows if isinstance(row, Row)]
    walls: list[Any] = [getattr(row.wall, "mechanism", row.wall) for row in good]
    loaded = any(wall.overburden_ratio for wall in walls)
    unlike = of_heights({row.line: float(row.wall.height) for row in good if isinstance(row.wall, Wall)})

    def doubts(row: Row) -> tuple[str, ...]:
        kept = tuple(doubt for doubt in row.doubts if loaded or not doubt.endswith(EMPTY_LOAD))
        return kept + ((f"line {row.line}: {unlike[row.line]}",) if row.line in unlike else ())

    return [replace(row, doubts=doubts(row)) if isinstance(row, Row) else row for row in rows]


def _row(line: int, cells: Mapping[str, str], storeys: int | None) -> Row:
    filled = {name: text for name, text in cells.items() if name and text}
    if "id" not in filled:
        raise InputError("id is empty; each wall must have one")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with plausibility.as_meant():  # what is unlikely is said of the wall in its building
            wall = _one_sided(filled, _wall(filled))
        plausibility.warn(of_stated(wall, storeys))
        curve = _curve(filled)
        if LOADS & cells.keys() and not LOADS & filled.keys():
            plausibility.warn([EMPTY_LOAD])
        e, _ = restitution_and_reason(wall, _restitution(filled.get("restitution", DEFAULT_RULE)))
        diaphragm = _diaphragm(filled)
    doubts = tuple(dict.fromkeys(f"line {line}: {each.message}" for each in caught))
    return Row(line, filled["id"], wall, curve, e, doubts, diaphragm)


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
    weakest = {"hinge_ratio": WEAKEST} if filled.get("hinge_ratio") == WEAKEST else {}
    sizes: dict[str, Any] = {name: _size(name, filled[name]) for name in SIZES if name in filled.keys() - weakest}
    sizes |= weakest
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
    try:
        seconds = quantity(filled[period], "s")
    except UnitError as error:
        raise InputError(
            f"{period} is {filled[period]!r}: {error}; it must be a number of s, or with its unit"
        ) from None
    return Diaphragm(seconds, _number(damping, filled[damping]) if damping in filled else DAMPING_RATIO)


def _overburden_ratio(filled: Mapping[str, str], wall: Wall | Parapet) -> float:
    """Return O/W of a load with its unit on a wall."""
    if "overburden_ratio" in filled:
        raise InputError("overburden and overburden_ratio state the same; one of the two cells must be empty")
    try:
        load = units.overburden(filled["overburden"])
    except UnitError as error:
        raise InputError(f"overburden: {error}; it must be a load with its unit, as 12kN/m or 12kN") from None
    return units.overburden_ratio(*load, float(wall.weight), float(wall.width), float(wall.thickness))


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


def _size(name: str, text: str) -> float:
    """Return a size in SI: a number, or one with its unit."""
    read = {"density": units.density, **dict.fromkeys(LENGTHS, units.length)}.get(name)
    if read is None:
        return _number(name, text)
    try:
        return read(text)
    except UnitError as error:
        raise InputError(f"{name} is {text!r}: {error}; it must be a number, in SI units or with its unit") from None


def _number(name: str, text: str) -> float:
    try:
        return text_number(text)
    except ValueError as error:
        raise InputError(f"{name} is {text!r}: {error}; it must be a number, in SI units") from None


# --- e by a rule ------------------------------------------------------------------------------------------------------

Rocking = Wall | Parapet
SORRENTINO = "Sorrentino, AlShawa and Decanini (2011), second-hand: a block that hits a return wall"

# By the name of the rule: what it gives, and what it is called for a wall.
RULES: Mapping[str, tuple[Callable[[Rocking], Array], str]] = {
    "measured": (
        lambda wall: wall.restitution_measured,
        f"{SORRENTINO_RATIO:.2f} of Eq. (7), near the upper end of the tests of walls that the paper quotes",
    ),
    "analytical": (lambda wall: wall.restitution_rigid, "Eq. (7): angular momentum about the new base pivot"),
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
        e, reason = float(Damping("CR", number("restitution (e)", restitution)).value), "as given"
    if isinstance(wall, OneSidedWall):  # against a stop an e of 0.3 is usual
        return e, reason
    if e < LEAST_OF_DAMPER:
        stops = "the wall stops at an impact" if e == 0 else "the wall all but stops at an impact"
        plausibility.warn(
            [f"restitution (e) is {e:.3g}: {stops}; {RECOMMENDED} is run with {LEAST_OF_DAMPER:.3g}, its least"]
        )
    elif reason == "as given":
        plausibility.warn([*plausibility.of_restitution(e), *plausibility.of_sizes(e, float(wall.restitution_rigid))])
    return e, reason
