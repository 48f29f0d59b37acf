"""Take lines of tables apart as spreadsheets write them: commas, semicolons or tabs, and decimal commas beside them."""

from __future__ import annotations

import re

DIVIDERS = (";", "\t", ",")
_DECIMAL_COMMA = re.compile(r"\s*[-+]?\d*,\d+(?:[eE][-+]?\d+)?\s*")


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
