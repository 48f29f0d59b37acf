"""Files of records: the project's CSV, AT2 files of PEER, and plain numbers."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator, Sequence
from hashlib import sha256
from itertools import chain
from statistics import mode
from typing import NamedTuple

import numpy as np

from rockdamp import units
from rockdamp.arrays import Array
from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.errors import InputError, check_number, check_type
from rockdamp.motions.record import Record, check_step, check_times
from rockdamp.motions.text_lines import (
    NAMED_COLUMNS,
    NumberRow,
    read_header,
    read_rows,
    read_rows_below_titles,
    refused_line,
    split_cells,
)
from rockdamp.storage.files import read_text, replace_file
from rockdamp.text import count_noun

RECORD_COLUMNS = ("elapsed_s", "ground_acceleration_m_s2", "displacement_m")
ACCELERATION_PREFIX = "ground_acceleration_"  # the rest of the name is the unit: m_s2, cm_s2 or g

_AT2_WORD = re.compile(r"\bNPTS\b|\bDT\b|[-+]?(?:\d+\.?\d*|\.\d+)(?:[ED][-+]?\d+)?")
_UNIT_PHRASE = re.compile(
    r"(?:\bUNITS?(?:\s+(?:OF|IN|ARE|IS))?\s*[:=]?|\bIN(?!\s+UNIT)|\()\s*([A-Z][\w/*^ -]*)",
    re.IGNORECASE,
)


class _Samples(NamedTuple):
    """Fields of a `Record` as a file has them."""

    elapsed: Array
    ground_acceleration: Array
    displacement: Array | None
    header: dict[str, str]


class _Options(NamedTuple):
    """Statements of the caller about a file that does not make them itself."""

    step: float | None
    unit_size: float | None
    column: int | None


def read_record(
    path: str | os.PathLike[str],
    *,
    step: float | None = None,
    unit: str | None = None,
    column: int | None = None,
) -> Record:
    """Read a record of ground motion from a text file in one of three formats.

    - A CSV with lines ``# key: value``, then the columns ``elapsed_s``,
      ``ground_acceleration_m_s2`` (or ``_g``, ``_cm_s2``) and, where measured, ``displacement_m``.
    - An AT2 file of PEER, with NPTS and DT in one of its first ten lines.
    - Plain numbers below any titles. With `step` the file has one column of accelerations; without
      it two columns, times and accelerations. Several numbers per line are read row by row below a
      line ``n`` or ``n dt``, where n is the number of values, or from the column that `column`
      selects.

    Parameters
    ----------
    path : path-like
        Text file in UTF-8.
    step : float, optional
        Time between plain numbers without times. [s]
    unit : str, optional
        Unit of accelerations whose file states none: ``g``, ``m/s2``, ``cm/s2``, ``mm/s2``,
        ``gal``.
    column : int, optional
        Column of the accelerations, 1 for the first, in a file of several columns without times.

    Returns
    -------
    Record
        Samples in SI, with the header and the digest of the file.

    Raises
    ------
    InputError
        If the file is not a record (the message gives the line or the time), a step or a unit is
        missing or contradicts the file, or the peak is above 5 g, which means a wrong unit.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import rockdamp as rd
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "motion.txt")
    ...     _ = path.write_text("El Centro\\n0.0\\n0.1\\n-0.2\\n0.3\\n")
    ...     rd.read_record(path, step=0.02, unit="m/s2").ground_acceleration
    array([ 0. ,  0.1, -0.2,  0.3])
    """
    text = read_text(path)
    try:
        if step is not None:
            step = check_number("step", step, np.isfinite, "a finite number")
        if column is not None:
            check_type("column", column, int)
        options = _Options(step, _unit_size(unit), column)
        samples = _read_samples(text.splitlines(), options)
        record = Record(*samples, digest=sha256(text.encode()).hexdigest())
        _check_agreement("step", step, record.step)
        _check_peak(record)
    except InputError as error:
        raise InputError(f"{os.fspath(path)}: {error}") from None
    return record


def _read_samples(lines: Sequence[str], options: _Options) -> _Samples:
    """Read lines in the format that their head shows."""
    header, first = read_header(lines)
    names = split_cells(lines[first]) if first < len(lines) else []
    if RECORD_COLUMNS[0] in names:
        _refuse_column(options)
        return _read_csv(lines, first, header, options)
    if any(name.startswith(ACCELERATION_PREFIX) for name in names):
        given_names = ", ".join(names)[:50]
        raise InputError(
            f"columns are {given_names}; the column of times must be {RECORD_COLUMNS[0]}"
        )
    for index, line in enumerate(lines[:10]):
        counts = _samples_and_step(line)
        if counts is not None:
            _refuse_column(options)
            return _read_at2(lines, index, *counts, options)
    return _read_plain(lines, options)


def _refuse_column(options: _Options) -> None:
    if options.column is not None:
        raise InputError(f"column is {options.column}; it must be left out, as the file has a head")


# --- the project's CSV -------------------------------------------------------------------------


def _read_csv(
    lines: Sequence[str], first: int, header: dict[str, str], options: _Options
) -> _Samples:
    """Read the columns below the line of their names."""
    names = split_cells(lines[first])
    doubles = [name for name in names if names.count(name) > 1]
    if doubles:
        raise InputError(f"has the column {doubles[0]!r} twice; each column must have its own name")
    acceleration_name, unit_size = _acceleration_column(names)
    _check_agreement("unit [m s-2]", options.unit_size, unit_size)
    rows = read_rows(lines, first + 1, len(names))
    values = np.array([row.numbers for row in rows]).T
    columns = dict(zip(names, values, strict=True))
    elapsed = columns[RECORD_COLUMNS[0]]
    check_times(elapsed, _printed_cells(lines, rows, names.index(RECORD_COLUMNS[0])))
    if unit_size != 1:
        header["units"] = "s, m s-2, m"
    displacement = columns.get(RECORD_COLUMNS[2])
    return _Samples(elapsed, columns[acceleration_name] * unit_size, displacement, header)


def _acceleration_column(names: Sequence[str]) -> tuple[str, float]:
    """Return the name of the column of accelerations, and its unit in m s-2."""
    sizes = {}
    for name in names:
        unit = name.removeprefix(ACCELERATION_PREFIX).replace("_", "/")
        size = units.size(unit, "m s-2")
        if name.startswith(ACCELERATION_PREFIX) and size is not None:
            sizes[name] = size
    if len(sizes) != 1:
        given_names = ", ".join(names)[:50]
        allowed_names = ", ".join(RECORD_COLUMNS)
        raise InputError(
            f"columns are {given_names}; they must be {allowed_names}, the last where measured"
        )
    return sizes.popitem()


# --- AT2 files of PEER -------------------------------------------------------------------------


def _read_at2(
    lines: Sequence[str], index: int, samples: float, step: float, options: _Options
) -> _Samples:
    """Read the accelerations below the line that states NPTS and DT."""
    unit_size = _stated_unit(lines[: index + 1], options.unit_size)
    rows = read_rows(lines, index + 1)
    values = _all_numbers(rows)
    if values.size != samples:
        raise InputError(f"has {values.size} accelerations; it must have {samples:g}, as NPTS says")
    check_step(step)
    source = "; ".join(line.strip() for line in lines[:index])
    return _Samples(step * np.arange(samples), values * unit_size, None, {"source": source})


def _samples_and_step(line: str) -> tuple[float, float] | None:
    """Return NPTS and DT of a line that states both; None for any other line.

    They may be in any order, with the numbers behind their names or before them.
    """
    words = _AT2_WORD.findall(line.upper())
    names = [word for word in words if word in ("NPTS", "DT")]
    numbers = [float(word.replace("D", "E")) for word in words if word not in names]
    counts = dict(zip(names, numbers, strict=False))
    if len(counts) != 2:
        return None
    return counts["NPTS"], counts["DT"]


def _stated_unit(head: Sequence[str], given_size: float | None) -> float:
    """Return the unit of acceleration that the head of an AT2 file states, or the given one.

    Both are in m s-2.
    """
    text = "\n".join(head)
    phrases = _UNIT_PHRASE.findall(text)
    phrases += [phrase.split()[0] for phrase in phrases]  # the unit of "G FILTERED"
    possible_sizes = [units.size(phrase, "m s-2") for phrase in phrases]
    sizes = {size for size in possible_sizes if size is not None}
    quantity = re.search("velocity|displacement", text, re.IGNORECASE)
    if quantity and not sizes:
        raise InputError(f"has {quantity[0]!r} above its numbers; they must be accelerations")
    if not sizes and given_size is not None:
        return given_size
    if len(sizes) != 1:
        raise InputError(
            f"states {len(sizes)} units of acceleration; "
            "it must state one, or unit must be given, for example g"
        )
    unit_size = sizes.pop()
    _check_agreement("unit [m s-2]", given_size, unit_size)
    return unit_size


# --- plain numbers -----------------------------------------------------------------------------


def _read_plain(lines: Sequence[str], options: _Options) -> _Samples:
    """Read plain numbers: times and accelerations, or accelerations at a step."""
    rows = read_rows_below_titles(lines)
    numbers_text = "".join(lines[rows[0].line_index :])
    if "," in numbers_text and "." not in numbers_text:
        raise InputError(
            "has commas and no points in its numbers; the decimal sign must be a point"
        )
    if options.unit_size is None:
        raise InputError(
            f"does not have {NAMED_COLUMNS} (or _g, _cm_s2); without them unit must be given,"
            " such as g or cm/s2 (--unit g in a command)"
        )
    head = rows[0].numbers
    if options.column is None and _states_count(rows):
        step = head[1] if len(head) == 2 else options.step
        values = _all_numbers(rows[1:])
    elif options.column is None and options.step is None:
        return _read_two_columns(lines, rows, options.unit_size)
    else:
        step = options.step
        values = _read_one_column(lines, rows, options.column)
    if step is None:
        raise InputError(f"has no times; step must be given, or {NAMED_COLUMNS}")
    check_step(step)
    elapsed = step * np.arange(values.size, dtype=float)
    return _Samples(elapsed, values * options.unit_size, None, {})


def _states_count(rows: Sequence[NumberRow]) -> bool:
    """Say whether the first line is ``n`` or ``n dt``, where n is how many numbers are below it."""
    head = rows[0].numbers
    count = sum(len(row.numbers) for row in rows[1:])
    return len(head) <= 2 and head[0] == count > 0


def _read_two_columns(
    lines: Sequence[str], rows: Sequence[NumberRow], unit_size: float
) -> _Samples:
    """Read times and accelerations."""
    width = _common_width(lines, rows)
    if width == 1:
        raise InputError(f"has one column; step must be given, or {NAMED_COLUMNS}")
    if width > 2:
        raise InputError(
            f"has {width} columns; without a step it must have two, times and accelerations, "
            f"or {NAMED_COLUMNS}"
        )
    elapsed, values = np.array([row.numbers for row in rows]).T
    check_times(elapsed, _printed_cells(lines, rows, 0))
    return _Samples(elapsed, values * unit_size, None, {})


def _read_one_column(lines: Sequence[str], rows: Sequence[NumberRow], column: int | None) -> Array:
    """Return the numbers of the one column, or of the column that was named."""
    width = _common_width(lines, rows)
    if column is None and width > 1:
        otherwise = f"or the file must have {NAMED_COLUMNS}"
        if width == 2:
            otherwise = "or step must be left out if the first has times"
        raise InputError(
            f"has {width} columns; with a step, column must be given, from 1 to {width},"
            f" {otherwise}"
        )
    place = 0 if column is None else column - 1
    if not 0 <= place < width:
        raise InputError(f"column is {column}; it must be from 1 to {width}, as the file has them")
    _refuse_whole_head(lines, rows, place)
    return np.array([row.numbers[place] for row in rows])


def _common_width(lines: Sequence[str], rows: Sequence[NumberRow]) -> int:
    """Return how many numbers every row has; refuse a row that has not as many as most."""
    width = mode(len(row.numbers) for row in rows)
    for row in rows:
        count = len(row.numbers)
        if count != width:
            reason = f"it has {count_noun(count, 'number')}; most lines have {width}"
            raise refused_line(lines, row.line_index, reason)
    return width


def _refuse_whole_head(lines: Sequence[str], rows: Sequence[NumberRow], place: int) -> None:
    """Refuse whole numbers above the first decimal one: they are a head, and no accelerations."""
    whole = []
    for row in rows:
        cell = split_cells(lines[row.line_index])[place]
        if not cell.lstrip("-+").isdigit():
            break
        whole.append(row)
    else:
        return  # whole numbers throughout, such as counts
    for row in whole:
        if row.numbers[place] != 0:
            reason = f"above decimals it must be the number of values, or {NAMED_COLUMNS}"
            raise refused_line(lines, row.line_index, reason)


# --- values ------------------------------------------------------------------------------------


def _all_numbers(rows: Sequence[NumberRow]) -> Array:
    """Return the numbers of all rows in reading order."""
    return np.fromiter(chain.from_iterable(row.numbers for row in rows), float)


def _printed_cells(lines: Sequence[str], rows: Sequence[NumberRow], place: int) -> Iterator[str]:
    """Yield the cells of one column as the file prints them."""
    return (split_cells(lines[row.line_index])[place] for row in rows)


def _unit_size(unit: str | None) -> float | None:
    """Return the size of a given unit of acceleration in m s-2."""
    if unit is None:
        return None
    size = units.size(check_type("unit", unit, str), "m s-2")
    if size is None:
        raise InputError(
            f"unit is {unit!r}; it must be a unit of acceleration, such as g, m/s2, cm/s2"
        )
    return size


def _check_agreement(name: str, given: float | None, stated: float) -> None:
    """Refuse a given step or unit that contradicts the file."""
    if given is not None and not math.isclose(given, stated, rel_tol=1e-3):
        raise InputError(f"{name} is {given:g}; leave it out, as the file states {stated:g}")


def _check_peak(record: Record) -> None:
    """Refuse accelerations that no ground motion has: the strongest recorded are below 3 g."""
    peak = float(np.abs(record.ground_acceleration).max()) / STANDARD_GRAVITY
    if peak > 5:
        raise InputError(
            f"has a peak of {peak:.3g} g; it must be at most 5 g: "
            "check the unit, and that the numbers are accelerations"
        )


def write_record(path: str | os.PathLike[str], record: Record) -> None:
    """Write a record as CSV; reading it back gives the same numbers.

    The file is written completely or not at all.

    Parameters
    ----------
    path : path-like
        File to write; an existing one is replaced.
    record : Record
        Record to write. Its header must have no line breaks.

    Raises
    ------
    InputError
        For a line break in the header; nothing is written.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import rockdamp as rd
    >>> motion = rd.Record([0.0, 0.01, 0.02], [0.0, 1.5, 0.0], header={"synthetic": "yes"})
    >>> with TemporaryDirectory() as folder:
    ...     rd.write_record(Path(folder, "motion.csv"), motion)
    ...     print(Path(folder, "motion.csv").read_text(encoding="utf-8"), end="")
    # synthetic: yes
    elapsed_s,ground_acceleration_m_s2
    0.0,0.0
    0.01,1.5
    0.02,0.0
    """
    check_type("record", record, Record)
    lines = [_header_line(key, value) for key, value in record.header.items()]
    names = list(RECORD_COLUMNS[:2])
    columns = [record.elapsed, record.ground_acceleration]
    if record.displacement is not None:
        names.append(RECORD_COLUMNS[2])
        columns.append(record.displacement)
    lines.append(",".join(names))
    for row in np.column_stack(columns).tolist():
        lines.append(",".join(map(repr, row)))
    with replace_file(path) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def _header_line(key: str, value: str) -> str:
    line = f"# {key}: {value}"
    if "".join(line.splitlines()) != line:
        raise InputError(f"header has {key!r}: {value!r}; it must have no line breaks")
    return line
