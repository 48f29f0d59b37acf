"""Lines of text files of numbers: a commented header, titles, and rows of cells."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import NamedTuple

from rockdamp.errors import InputError

NAMED_COLUMNS = "the columns elapsed_s, ground_acceleration_m_s2"

_LIKE_A_NUMBER = re.compile(r"[-+]?\.?\d")
_WORD = re.compile(r"[^\W\d_]{2}")
_DECIMAL_COMMAS = re.compile(r"[-+\d,;\seEdD\"]*\d,\d[-+\d,;\seEdD\"]*")


class NumberRow(NamedTuple):
    """A line of numbers: its index among the lines of the file, and its numbers."""

    line_index: int
    numbers: list[float]


def read_header(lines: Sequence[str]) -> tuple[dict[str, str], int]:
    """Return the entries of the leading lines ``# key: value``, and the index of the next line."""
    header: dict[str, str] = {}
    for index, line in enumerate(lines):
        if line.strip() and not line.startswith("#"):
            return header, index
        key, colon, value = line.lstrip("# ").partition(":")
        if colon:
            header[key.strip().lower()] = value.strip()
    return header, len(lines)


def split_cells(line: str) -> list[str]:
    """Return the cells of a line.

    The first separator that the line contains divides it: a semicolon, a tab, a comma, or blanks. A
    remark after ``#`` and separators at the end do not count.
    """
    text = line.partition("#")[0].strip().rstrip(",; ")
    for separator in ";\t,":
        if separator in text:
            return [cell.strip(' "') for cell in text.split(separator)]
    return text.replace('"', "").split()


def parse_number(cell: str) -> float:
    """Return the number of a cell, NaN if it is none.

    Fortran's exponents (``1.5D-3``) are read too.
    """
    try:
        return float(cell.replace("D", "E").replace("d", "e"))
    except ValueError:
        return math.nan


def read_rows(lines: Sequence[str], first: int, width: int | None = None) -> list[NumberRow]:
    """Return the rows of finite numbers from line `first` on, without blank lines and remarks.

    Raises
    ------
    InputError
        For the first line that holds anything else, or does not hold `width` numbers.
    """
    rows = []
    for index in range(first, len(lines)):
        cells = split_cells(lines[index])
        if not cells:
            continue
        numbers = [parse_number(cell) for cell in cells]
        if not all(map(math.isfinite, numbers)):
            raise unreadable_line(lines, index, named=width is not None)
        if width is not None and len(numbers) != width:
            raise refused_line(lines, index, f"it must have {width} numbers")
        rows.append(NumberRow(index, numbers))
    if not rows:
        raise InputError(f"has no numbers; it must have {NAMED_COLUMNS}")
    return rows


def read_rows_below_titles(lines: Sequence[str]) -> list[NumberRow]:
    """Return the rows of numbers below any titles; a broken row is not taken for a title."""
    first = next((index for index, line in enumerate(lines) if _is_row(line)), None)
    if first is None:
        raise unreadable_line(lines, _first_like_numbers(lines))
    width = len(split_cells(lines[first]))
    for index in range(first):
        if _is_broken_row(lines[index], width):
            raise unreadable_line(lines, index)
    return read_rows(lines, first)


def refused_line(lines: Sequence[str], index: int, reason: str) -> InputError:
    """Return the error that names a line and says why it is refused."""
    text = lines[index].strip()
    if _DECIMAL_COMMAS.fullmatch(text):
        reason = "the decimal sign must be a point"
    return InputError(f"line {index + 1} is {text[:30]!r}; {reason}")


def unreadable_line(lines: Sequence[str], index: int, *, named: bool = False) -> InputError:
    """Return the error that names a line and its first cell that is not a finite number.

    Unless the file has `named` columns, the error also says which columns a file may have.
    """
    cells = split_cells(lines[index]) or [""]
    wrong_cell = next((cell for cell in cells if not math.isfinite(parse_number(cell))), cells[0])
    reason = f"{wrong_cell[:20]!r} is not a finite number"
    if not named:
        reason += f"; the file must have {NAMED_COLUMNS}"
    return refused_line(lines, index, reason)


def _is_row(line: str) -> bool:
    cells = split_cells(line)
    return bool(cells) and all(math.isfinite(parse_number(cell)) for cell in cells)


def _is_broken_row(line: str, width: int) -> bool:
    """Say whether a line above the first row is a row that cannot be read as numbers.

    Dates and missing values make such rows.
    """
    text = line.strip()
    cells = split_cells(line)
    if _LIKE_A_NUMBER.match(text) and not _WORD.search(text):
        return True
    return len(cells) == width and _reads_as_a_float(cells[0])


def _reads_as_a_float(cell: str) -> bool:
    """Say whether a cell is a number, NaN and infinity among them."""
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _first_like_numbers(lines: Sequence[str]) -> int:
    """Return the index of the first line that begins with a number, else of the first text."""
    filled = [index for index, line in enumerate(lines) if line.strip()]
    if not filled:
        raise InputError(f"has no numbers; it must have {NAMED_COLUMNS}")
    like_numbers = (index for index in filled if _LIKE_A_NUMBER.match(lines[index].strip()))
    return next(like_numbers, filled[0])
