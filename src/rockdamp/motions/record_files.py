"""Read a record's file, CSV or PEER AT2, into numbers in SI. Errors name the line.

Statements of the file, its units above all, are believed or refused, never passed over.
"""

from __future__ import annotations

import csv as csv_module
import difflib
import io
import re
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from rockdamp import units
from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.storage import input_file
from rockdamp.vocabulary import STANDARD_GRAVITY

Place = Callable[[int], str]  # of a sample, by its index: "on line 12"

UNIFORM = 1e-4  # of a step: how far a time may lie from where uniform sampling puts it
COLUMNS = ("elapsed_s", "ground_acceleration_m_s2", "displacement_m")  # as they are written
ACCELERATIONS = {  # the columns that an acceleration may be read from, and their units, also in m s-2
    "ground_acceleration_m_s2": ("m s-2", 1.0),
    "ground_acceleration_g": ("g", STANDARD_GRAVITY),
    "ground_acceleration_cm_s2": ("cm s-2", 0.01),
}
ROCKING_COLUMNS = ("displacement_m", "rotation_rad")  # of a free-rocking test: one of them
KEYS = ("synthetic", "units", "pulse_period")  # of a CSV's header, that change what is done with the record
SI = "s, m s-2"

_NUMBER = r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eEdD][-+]?[0-9]+)?"  # with Fortran's exponents
_COUNT, _STEP = r"(?P<count>[0-9]{1,15})", rf"(?P<step>{_NUMBER})"
_AT2_COUNT = (  # the forms of an AT2 file's fourth line
    re.compile(rf"\s*NPTS\s*=?\s*{_COUNT}\s*,?\s*DT\s*=?\s*{_STEP}(?P<rest>.*)", re.IGNORECASE),
    re.compile(rf"\s*{_COUNT}\s+{_STEP}\s+NPTS\s*,\s*DT(?P<rest>.*)", re.IGNORECASE),
)
_AT2_STATED = (  # in any line of the header "IN UNITS OF G", "UNITS: CM/S2"; in the third also "UNITS G", "IN GAL"
    re.compile(r"\bUNITS?\b\s*(?:(?:OF|IN|ARE|IS)\b|[:=])\s*(?P<unit>[^\s,;]+)", re.IGNORECASE),
    re.compile(r"\b(?:UNITS?|IN)\s+(?!UNITS?\b|OF\b|IN\b|ARE\b|IS\b)(?P<unit>[^\s,;:=]+)", re.IGNORECASE),
)
_AT2_UNIT = re.compile(  # a unit itself: "(CM/S**2)", "CM / SEC / SEC", "CM/S", "CM SEC-2", "GALS"
    r"(?<![A-Z])(?:MM|CM|DM|M|IN|INCH(?:ES)?|FT|FEET|G)"
    r"(?:\s*(?:/|\bPER\b)\s*\(?S[A-Z]*[*^]*[-0-9²⁻]*\)?(?:\s*/\s*S[A-Z]*)*|[ *.·]S(?:EC)?[*^]*(?:-|⁻)[2²])"
    r"|\b(?:GALS?|MG)\b|%\s*G\b",
    re.IGNORECASE,
)
_AT2_OTHER = re.compile(r"\b(?:VELOCITY|DISPLACEMENT)\b", re.IGNORECASE)


class Parts(NamedTuple):
    """The contents of a file in SI, as in `Record`."""

    elapsed: Array
    ground_acceleration: Array
    displacement: Array | None
    header: dict[str, str]
    unit: str


# --- units ------------------------------------------------------------------------------------------------------------


def require_stated(stated: str, acceleration: str, remedy: str) -> None:
    """Refuse a list of units, ``s, m s-2, m``, with other units than those of the numbers: s, `acceleration` and m."""
    for name in re.split("[,;]", stated):
        same_acceleration = units.size(name, "m s-2") == units.size(acceleration, "m s-2")
        if not (same_acceleration or units.size(name, "s") == 1 or units.size(name, "m") == 1):
            wrong = f"has {name.strip()!r}; the numbers are taken in s, {acceleration} and m: {remedy}"
            raise InputError(f"units is {stated!r} and {wrong}")


# --- CSV --------------------------------------------------------------------------------------------------------------


def csv(lines: Sequence[str]) -> Parts:
    """Parse this project's CSV; semicolons or tabs may divide it, beside decimal commas."""
    header, names, lines, start = _names(lines, COLUMNS[:2])
    _check_columns(names, start + 1)
    (column,) = (name for name in names if name in ACCELERATIONS)
    unit, factor = ACCELERATIONS[column]
    if "units" in header:
        require_stated(header["units"], unit, f"{column} is in {unit}, displacement_m in m")
    first = start + 1  # index of the first row's line
    values = _columns(lines, first, names)
    check_time(values["elapsed_s"], lambda index: f"on line {first + 1 + index}")
    acceleration = values[column]
    if factor != 1:
        acceleration = acceleration * factor
        header["units"] = f"{SI}, m" if COLUMNS[2] in names else SI
    return Parts(values["elapsed_s"], acceleration, values.get(COLUMNS[2]), header, unit)


def rocking_csv(lines: Sequence[str]) -> tuple[Array, tuple[Array | None, Array | None], dict[str, str]]:
    """Parse a free-rocking test: times, the displacement and the rotation, of which one is None, and the header."""
    header, names, lines, start = _names(lines, (COLUMNS[0], " or ".join(ROCKING_COLUMNS)))
    allowed = f"the columns must be {COLUMNS[0]} and one of {', '.join(ROCKING_COLUMNS)}"
    if sorted(names) not in [sorted((COLUMNS[0], column)) for column in ROCKING_COLUMNS]:
        hint = "; a free-rocking test has no motion of the ground" if set(names) & set(ACCELERATIONS) else ""
        raise InputError(f"columns on line {start + 1} are {', '.join(names)}; {allowed}{hint}")
    for name in re.split("[,;]", header.get("units", "s")):
        allowed_units = ("s", "m") if ROCKING_COLUMNS[0] in names else ("s", "rad")
        if name.strip() not in allowed_units:
            wrong = f"the numbers are taken in {' and '.join(allowed_units)}: they must be converted"
            raise InputError(f"units is {header['units']!r} and has {name.strip()!r}; {wrong}")
    values = _columns(lines, start + 1, names)
    check_time(values[COLUMNS[0]], lambda index: f"on line {start + 2 + index}")
    return values[COLUMNS[0]], (values.get(ROCKING_COLUMNS[0]), values.get(ROCKING_COLUMNS[1])), header


def _names(lines: Sequence[str], expected: Sequence[str]) -> tuple[dict[str, str], list[str], list[str], int]:
    """Return the header, the columns' names, the lines as divided by commas, and the index of that with the names."""
    start = next((number for number, line in enumerate(lines) if not line.startswith("#")), len(lines))
    mark = input_file.divider(lines[start]) if start < len(lines) else None
    lines = [input_file.with_commas(line, mark) if number >= start else line for number, line in enumerate(lines)]
    header = _header(lines[:start])
    if start == len(lines):
        raise InputError(f"has a header only; columns {', '.join(expected)} must follow it")
    return header, [name.strip(' "') for name in lines[start].split(",")], lines, start


def _columns(
    lines: Sequence[str], first: int, names: Sequence[str], wanted: Sequence[str] | None = None
) -> Mapping[str, Array]:
    """Return the numbers of each column, or of those `wanted`, of the rows from the line of index `first` on."""
    if first == len(lines):
        raise InputError(f"has no rows; at least 2 must follow the columns on line {first}")
    for number, line in enumerate(lines[first:], first + 1):
        count = line.count(",") + 1 if line.strip() else 0
        if count != len(names) and not (wanted and 0 < count < len(names)):  # empty cells at the end are not written
            raise InputError(f"line {number} has {count} values; it must have {len(names)}, one for each column")
    # Read as text and converted below: so a bad cell can be named, and the conversion is exact.
    frame = pd.read_csv(
        io.StringIO("\n".join(lines[first:])),
        names=[name if name in (wanted or names) else f"column {at}" for at, name in enumerate(names)],
        dtype=str,
        keep_default_na=False,
        quoting=csv_module.QUOTE_NONE,
    )
    return {
        name: _numbers(frame[name].fillna("").tolist(), name, lambda index: f"on line {first + 1 + index}")
        for name in wanted or names
    }


def _header(lines: Sequence[str]) -> dict[str, str]:
    """Return the entries of lines ``# key: value``, keys in small letters; a line without a colon is a remark."""
    header: dict[str, str] = {}
    for number, line in enumerate(lines, 1):
        key, colon, value = line.lstrip("# \t").partition(":")
        key = key.strip().lower()
        if not colon:
            _check_remark(line, key, number)
            continue
        near = [] if key in KEYS else _near(key)
        if near:
            asked = f"did you mean {near[0]!r}? A line without a colon is a remark"
            raise InputError(f"key {key!r} on line {number} is unknown; {asked}")
        if key in header:
            raise InputError(f"key {key!r} on line {number} stands there more than once; each must stand there once")
        header[key] = value.strip()
    return header


def _near(key: str) -> list[str]:
    """Return the known key that another was meant for."""
    words = re.split(r"[^a-z]+", key)
    named = [known for known in KEYS if known in words or known.removesuffix("s") in words]
    return named or difflib.get_close_matches(key, KEYS, n=1, cutoff=0.75)


def _check_remark(line: str, text: str, number: int) -> None:
    first = re.split(r"[^a-z_]+", text)[0]
    if "synthetic" in text or first in (*KEYS, "unit"):
        key = next((known for known in KEYS if known.startswith(first)), KEYS[0])
        raise InputError(f"line {number} is {line.strip()!r}; it must be '# {key}: ...', with a colon")


def _check_columns(names: Sequence[str], line: int) -> None:
    one_of = f"one of {', '.join(ACCELERATIONS)}"
    allowed = f"the columns must be {COLUMNS[0]}, {one_of} and, where measured, {COLUMNS[2]}"
    allowed += ", divided by commas, semicolons or tabs"
    for name in names:
        if name not in (*COLUMNS, *ACCELERATIONS):
            hint = "; the name of a PEER AT2 file must end in .AT2" if "PEER" in name.upper() else ""
            raise InputError(
                f"column {name!r} on line {line} is unknown; {allowed}{hint}; files of ESM, K-NET or CESMD must be"
                " converted, as docs/howto/your-records.md shows"
            )
        if names.count(name) > 1:
            raise InputError(f"column {name!r} on line {line} stands there more than once; {allowed}")
    accelerations = [name for name in names if name in ACCELERATIONS]
    for name, there in ((COLUMNS[0], COLUMNS[0] in names), (COLUMNS[1], accelerations)):
        if not there:
            raise InputError(f"column {name!r} is missing on line {line}; {allowed}")
    if len(accelerations) > 1:
        raise InputError(f"columns {' and '.join(accelerations)} on line {line} state the same; {allowed}")


# --- PEER AT2 ---------------------------------------------------------------------------------------------------------


def at2(lines: Sequence[str]) -> Parts:
    """Parse an AT2 file of PEER: four lines of header, then accelerations."""
    if len(lines) < 5:
        raise InputError(f"has {len(lines)} lines; a PEER AT2 file must have 4 of header and then the accelerations")
    unit, factor = _at2_unit(lines)
    samples, step = _at2_count(lines[3])
    cells = [(cell, number) for number, line in enumerate(lines[4:], 5) for cell in line.split()]
    if len(cells) != samples:
        raise InputError(f"has {len(cells)} accelerations; it must have {samples}, as NPTS on line 4 says")
    numbers = [re.sub("[dD]", "e", cell) for cell, _ in cells]
    values = _numbers(numbers, "acceleration", lambda index: f"on line {cells[index][1]}")
    header = {
        "specimen": "none",
        "source": "; ".join(line.strip() for line in lines[:2] if line.strip()),
        "units": SI,
        "synthetic": "no",
    }
    return Parts(step * np.arange(samples, dtype=float), values * factor, None, header, unit)


def _at2_unit(lines: Sequence[str]) -> tuple[str, float]:
    """Return the unit of the accelerations, also in m s-2; PEER's is g where the header states none."""
    said = [(match["unit"], number) for number in range(3) for match in _AT2_STATED[0].finditer(lines[number])]
    said += [(match["unit"], 2) for match in _AT2_STATED[1].finditer(lines[2])]
    said += [(match[0], 2) for match in _AT2_UNIT.finditer(lines[2])]
    said = [(text.strip(".()[] "), number) for text, number in said]
    found: dict[str, float] = {}
    for text, number in said:
        if any(longer.startswith(f"{text} ") for longer, _ in said):
            continue  # "CM" of "CM / SEC / SEC"
        value = units.size(re.sub(r"\s*\bPER\b\s*", "/", text, flags=re.IGNORECASE), "m s-2")
        if value is None:
            allowed = "they must be those of an acceleration: G, GAL, CM/SEC2, M/SEC2, IN/SEC2"
            raise InputError(f"units are {text!r} on line {number + 1}; {allowed}")
        found[text.lower()] = value
    if len(set(found.values())) > 1:
        raise InputError(f"units are {' and '.join(map(repr, found))}; an AT2 file must state one unit")
    if (other := _AT2_OTHER.search(lines[2])) and "ACCEL" not in lines[2].upper():
        raise InputError(f"line 3 is {lines[2].strip()!r}, which says {other[0]!r}; the series must be an acceleration")
    return next(iter(found.items()), ("g", STANDARD_GRAVITY))


def _at2_count(line: str) -> tuple[int, float]:
    """Return the number of samples and the time between two [s]."""
    match = next((found for form in _AT2_COUNT if (found := form.match(line))), None)
    if match is None:
        raise InputError(f"line 4 is {line.strip()!r}; it must give NPTS and DT")
    rest = match["rest"].strip(" \t,;.")
    unit = units.size(rest.strip("()[]. \t"), "s") if rest else 1.0
    if unit is None:
        shown = f"{match['step']}{match['rest']}".strip()
        raise InputError(f"DT is {shown!r} on line 4; it must be a number, and its unit SEC or MSEC if it has one")
    step = float(re.sub("[dD]", "e", match["step"])) * unit
    if not 0 < step < np.inf:
        raise InputError(f"DT is {match['step']} on line 4; it must be greater than 0 [s]")
    return int(match["count"]), step


# --- numbers ----------------------------------------------------------------------------------------------------------


def _numbers(cells: Sequence[str], name: str, place: Place) -> Array:
    """Convert cells to finite numbers, or name the first that is none."""
    values = np.empty(len(cells))
    for index, cell in enumerate(cells):
        try:
            values[index] = units.number(cell)
        except ValueError:
            shown = cell.strip() if len(cell) < 40 else cell[:40] + "..."
            raise InputError(f"{name} is {shown!r} {place(index)}; it must be a number") from None
    check_finite(values, name, place)
    return values


def check_finite(values: Array, name: str, place: Place) -> None:
    """Raise unless every value is a finite number."""
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise InputError(f"{name} is {float(values[bad[0]])} {place(int(bad[0]))}; it must be a finite number")


def step_of(elapsed: Array) -> float:
    """Return the mean interval between two samples."""
    return float(elapsed[-1] - elapsed[0]) / (len(elapsed) - 1)


def check_time(elapsed: Array, place: Place) -> None:
    """Raise unless time has at least two samples, increases, and is uniform to `UNIFORM` of a step."""
    if len(elapsed) < 2:
        raise InputError(f"elapsed_s has {len(elapsed)} samples; it must have at least 2")
    intervals = np.diff(elapsed)
    back = np.flatnonzero(intervals <= 0)
    if back.size:
        late = int(back[0]) + 1
        raise InputError(
            f"elapsed_s is {elapsed[late]} {place(late)}; it must be greater than {elapsed[late - 1]}, as times are:"
            " is this the column of the times?"
        )
    # The straight line of least squares, moved to the middle, lies within UNIFORM of a step of all times.
    # Sums, as the product of long vectors by BLAS starts threads, which take longer than it does.
    index = np.arange(len(elapsed)) - (len(elapsed) - 1) / 2
    departure = elapsed - index * (index * elapsed).sum() / (index * index).sum()
    if np.ptp(departure) / 2 > UNIFORM * step_of(elapsed):
        usual = float(np.median(intervals))
        late = int(np.argmax(np.abs(intervals - usual))) + 1
        raise InputError(
            f"elapsed_s is {elapsed[late]} {place(late)}; it must be {elapsed[late - 1] + usual:.9g}: times must be "
            f"uniform to {UNIFORM:g} of a step, and be written with as many digits"
            + ("; are samples missing?" if intervals[late - 1] > 1.5 * usual else "")
        )
