"""Tables of walls: the wall, the curve and e of each row, or why the row makes none."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from io import StringIO
from typing import TYPE_CHECKING, Any

from rockdamp.assessment.description import DESCRIPTION_UNITS, make_curve, make_wall
from rockdamp.assessment.restitution import DEFAULT_RULE, RESTITUTION_RULES, find_restitution
from rockdamp.errors import InputError, check_choice
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.floors import Diaphragm
from rockdamp.mechanics.specimen import AnyWall
from rockdamp.mechanics.wall import OneSidedWall
from rockdamp.storage.files import read_text
from rockdamp.units import name_and_unit, quantity

if TYPE_CHECKING:
    import pandas as pd

REQUIRED_COLUMNS = ("id", "thickness", "height")


@dataclass(frozen=True)
class Row:
    """A row of the table that makes a wall.

    Attributes
    ----------
    id : str
        Name of the wall.
    wall : Wall, Parapet or OneSidedWall
        One wall.
    curve : TrilinearCurve
        Force-displacement curve of the wall.
    restitution : float
        Coefficient of restitution e. [-]
    diaphragm : Diaphragm, optional
        Flexible floor at the top of the wall.
    """

    id: str
    wall: AnyWall
    curve: TrilinearCurve
    restitution: float
    diaphragm: Diaphragm | None = None


@dataclass(frozen=True)
class BadRow:
    """A row that makes no wall, and why."""

    id: str
    error: str


def read_walls(path: str | os.PathLike[str]) -> list[Row | BadRow]:
    """Read a table of walls.

    Commas, semicolons or tabs divide its cells. Sizes are in SI, or have their unit in the cell
    (``300mm``) or in the head (``thickness [mm]``). Lines that begin with ``#`` are remarks. A cell
    may be empty: then the default of `Wall` holds, e is by the rule ``measured``, and the curve
    must be stated by ``a1`` and ``b1``, or by ``preset``.

    Parameters
    ----------
    path : str or path
        CSV with the columns ``id``, ``thickness`` and ``height``, and any others of
        `DESCRIPTION_UNITS`.

    Returns
    -------
    list of Row or BadRow
        In the order of the table. A row that makes no wall is a `BadRow` and stops no other.

    Raises
    ------
    InputError
        If the file is no table of walls: it cannot be read, a column is unknown, missing or there
        twice, an id is there twice, or it has no rows.
    """
    table = _read_cells(path)
    units = _read_heads(path, table)
    rows: dict[str, Row | BadRow] = {}
    for number, cells in enumerate(table.fillna("").itertuples(index=False), 1):
        texts = {name: cell.strip() for name, cell in zip(units, cells, strict=True)}
        texts = {name: text for name, text in texts.items() if text}
        identifier = texts.pop("id", f"row {number}")
        if identifier in rows:
            raise InputError(
                f"{path}: the id {identifier!r} occurs twice; each wall must have its own"
            )
        try:
            values = {name: _read_value(name, text, units[name]) for name, text in texts.items()}
            rows[identifier] = _make_row(identifier, values)
        except InputError as error:
            rows[identifier] = BadRow(identifier, str(error))
    if not rows:
        raise InputError(f"{path} has no rows; it must have a row for each wall")
    return list(rows.values())


def _read_cells(path: str | os.PathLike[str]) -> pd.DataFrame:
    """Read the cells of a table as texts."""
    import pandas as pd  # slow to import

    lines = [line for line in read_text(path).splitlines() if not line.startswith("#")]
    text = StringIO("\n".join(lines))
    try:
        table = pd.read_csv(text, sep=None, engine="python", dtype=str, keep_default_na=False)
    except (ValueError, csv.Error) as error:
        raise InputError(f"{path}: {error}; it must be a table, as CSV") from None
    if not isinstance(table.index, pd.RangeIndex):
        raise InputError(
            f"{path}: a row has more cells than the head; the decimal sign must be a point"
        )
    return table


def _read_heads(path: str | os.PathLike[str], table: pd.DataFrame) -> dict[str, str]:
    """Return the unit in the head of each column, by the column's name; "" where it has none."""
    heads = [name_and_unit(str(head)) for head in table.columns]
    units = {name.lower(): unit for name, unit in heads}
    for name in units:
        if name not in DESCRIPTION_UNITS:
            allowed = ", ".join(DESCRIPTION_UNITS)
            raise InputError(f"{path}: unknown column {name!r}; it must be one of {allowed}")
    for name in REQUIRED_COLUMNS:
        if name not in units:
            raise InputError(
                f"{path}: the column {name} is missing; there must be id, thickness and height"
            )
    if len(units) < len(heads):
        raise InputError(f"{path}: a column occurs twice")
    return units


def _read_value(name: str, text: str, head_unit: str) -> Any:
    """Return a cell in SI: a number in the unit of its head or with its own, or a word."""
    unit = DESCRIPTION_UNITS[name]
    if name in ("parapet", "one_sided"):
        return check_choice(name, text.lower(), ("yes", "no")) == "yes"
    is_rule = name == "restitution" and text in RESTITUTION_RULES
    is_weakest_hinge = name == "hinge_ratio" and text == "weakest"
    if unit is None or is_rule or is_weakest_hinge:
        return text
    if re.match(r"[-+]?\d*,\d", text):
        raise InputError(f"{name} is {text!r}; the decimal sign must be a point")
    number = text + head_unit if text[-1].isdigit() else text
    try:
        return quantity(number, unit)
    except ValueError as error:
        raise InputError(f"{name}: {error}") from None


def _make_row(identifier: str, values: Mapping[str, Any]) -> Row:
    """Return the row of values in SI; raise `InputError` if they make no wall."""
    for name in ("thickness", "height"):
        if name not in values:
            raise InputError(f"{name} is empty; it must be a number")
    wall = make_wall(values)
    e, _ = find_restitution(wall, values.get("restitution", DEFAULT_RULE))
    period = values.get("diaphragm_period")
    if period is not None and isinstance(wall, OneSidedWall):
        raise InputError(
            "a row that is one_sided must have no diaphragm_period: the stop moves as the base does"
        )
    diaphragm = None if period is None else Diaphragm(period)
    return Row(identifier, wall, make_curve(values), e, diaphragm)
