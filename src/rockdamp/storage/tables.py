"""Take lines of tables apart as spreadsheets write them: commas, semicolons or tabs, and decimal commas beside them."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass

from rockdamp import units
from rockdamp.errors import InputError

DIVIDERS = (";", "\t", ",")
_DECIMAL_COMMA = re.compile(r"\s*[-+]?\d*,\d+(?:[eE][-+]?\d+)?\s*")


@dataclass(frozen=True)
class Column:
    """A column of a file, and the unit of its numbers; none is SI, or none is needed."""

    name: str
    unit: str = ""

    @classmethod
    def of(cls, text: str, contents: Collection[str]) -> tuple[str, Column]:
        """Parse ``thickness=Thickness [mm]:mm``; the unit may be left out. Return what the column holds, and it.

        What it holds is one of `contents`.
        """
        holds, equals, column = (part.strip() for part in text.partition("="))
        if not equals or holds not in contents or not column:
            raise InputError(f"column {text!r} must be NAME=COLUMN or NAME=COLUMN:UNIT; NAME is {', '.join(contents)}")
        name, colon, unit = column.rpartition(":")
        return (holds, cls(name.strip(), unit.strip())) if colon and units.parse(unit) else (holds, cls(column))


def divider(line: str) -> str | None:
    """Return what divides the cells of a line; None for blanks."""
    return next((mark for mark in DIVIDERS if mark in line), None)


def with_point(cell: str, divided_by: str | None) -> str:
    """Return a cell with a decimal point, where commas do not divide the cells and it has a decimal comma."""
    return cell.replace(",", ".") if divided_by != "," and _DECIMAL_COMMA.fullmatch(cell) else cell


def with_commas(line: str, divided_by: str | None) -> str:
    """Return a line without quotes as one that commas divide; its numbers get decimal points."""
    if divided_by in (",", None):
        return line
    return ",".join(with_point(cell, divided_by) for cell in line.rstrip(f"{divided_by} ").split(divided_by))
