"""Free-rocking tests as sensors and videos record them, and their files."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256

import numpy as np

from rockdamp import units
from rockdamp.arrays import Array, short_repr
from rockdamp.errors import InputError, check, check_number
from rockdamp.motions.record import check_series, check_step
from rockdamp.motions.text_lines import read_header, refused_line, split_cells
from rockdamp.storage.files import read_text

# Units that the columns of measured values may have, by their names.
MEASURED_KINDS = {"displacement": ("m",), "rotation": ("rad",)}
# Names of angles, whole or as words of a longer name. Without a unit they could be rad or degrees.
ANGLE = re.compile(
    r"angle|theta|rotation|tilt|inclin|[θϑφϕ]|(?<![a-z])(rot|ang|phi|alpha)(?![a-z])"
)


@dataclass(frozen=True, eq=False)
class FreeRocking:
    """A free-rocking test: one or more releases, without ground motion.

    Parameters
    ----------
    elapsed : ndarray, shape (samples,)
        Time, increasing in steps that may vary, with a median of 0.0001 to 0.1 s. [s]
    displacement : ndarray, shape (samples,), optional
        Horizontal displacement at the hinge, or at the top of a parapet. The sensor's zero need not
        be the wall's. Default: none; then `rotation` is required. [m]
    rotation : ndarray, shape (samples,), optional
        Rotation of the lower body, or of a parapet; alternative to `displacement`. [rad]
    header : mapping of str, optional
        Description of the test: specimen, source, licence, synthetic (yes or no), and any other
        keys. Default: empty.
    digest : str, optional
        SHA-256 of the file that the test was read from. Default: empty.
    columns : str, optional
        Columns that were read from the file, with their units. Default: empty.

    Raises
    ------
    InputError
        If both or neither of displacement and rotation are given, a value is not finite, the shapes
        differ, or the times do not increase in steps of the stated size.

    Examples
    --------
    >>> import rockdamp as rd
    >>> test = rd.FreeRocking(
    ...     [0.0, 0.002, 0.0041], [0.05, 0.05, 0.0499], header={"synthetic": "yes"}
    ... )
    >>> test.measured, test.synthetic
    (array([0.05  , 0.05  , 0.0499]), True)
    """

    elapsed: Array
    displacement: Array | None = None
    rotation: Array | None = None
    header: Mapping[str, str] = field(default_factory=dict)
    digest: str = ""
    columns: str = ""

    __repr__ = short_repr

    def __post_init__(self) -> None:
        if (self.displacement is None) == (self.rotation is None):
            raise InputError("a free-rocking test must have either a displacement or a rotation")
        check_series(self, ("elapsed",), optional=("displacement", "rotation"))
        _check_times(self.elapsed)

    @property
    def synthetic(self) -> bool:
        """True if the header states that the test was computed; False otherwise."""
        return self.header.get("synthetic") == "yes"

    @property
    def measured(self) -> Array:
        """Measured values: the displacement [m] or the rotation [rad]."""
        series = self.rotation if self.displacement is None else self.displacement
        assert series is not None  # one of them is given
        return series


def _check_times(elapsed: Array) -> None:
    if elapsed.size < 2:
        raise InputError(f"number of samples is {elapsed.size}; it must be at least 2")
    intervals = np.diff(elapsed)
    reversals = np.flatnonzero(intervals <= 0)
    if reversals.size:
        earlier, later = elapsed[reversals[0] : reversals[0] + 2]
        raise InputError(f"elapsed goes from {earlier:.9g} to {later:.9g}; it must rise")
    interval = float(np.median(intervals))
    if interval >= 1:
        raise InputError(
            f"step is {interval:g} s; it must be from 0.0001 to 0.1 s: if the times are frame"
            " numbers, frame_rate must be given"
        )
    check_step(interval)


def read_free_rocking(
    path: str | os.PathLike[str], *, frame_rate: float | None = None, pixel: float | None = None
) -> FreeRocking:
    """Read a free-rocking test from a text file.

    The file has optional lines ``# key: value``, then columns separated by semicolons, tabs, commas
    or blanks. Times are in the column ``elapsed`` and measured values in the column
    ``displacement`` or ``rotation``, in any position. Without these names they are in the first two
    columns; a column without a name, such as the index that pandas writes, is ignored.

    A name ends with its unit, as in ``elapsed_s``, ``displacement [mm]`` or ``angle (deg)``.
    Without a unit, times are in s and displacements in m; the name of an angle must have a unit.
    Rows without a value are skipped.

    Parameters
    ----------
    path : path-like
        The file.
    frame_rate : float, optional
        Frames per second of a video. The times are then frame numbers, in the column ``frame`` or
        the first column. Default: none; the file has times. [s-1]
    pixel : float, optional
        Size of a pixel, if the displacement is in pixels. Default: none. [m]

    Returns
    -------
    FreeRocking
        The test in SI units, with the header and the digest of the file.

    Raises
    ------
    InputError
        If the file cannot be read or used. The message names the file and the line, the column or
        the time.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import rockdamp as rd
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "release.csv")
    ...     _ = path.write_text("frame,x\\n0,250\\n1,250\\n2,\\n3,249\\n")
    ...     test = rd.read_free_rocking(path, frame_rate=100, pixel=0.0004)
    >>> test.elapsed, test.displacement
    (array([0.  , 0.01, 0.03]), array([0.1   , 0.1   , 0.0996]))
    """
    text = read_text(path)
    lines = text.splitlines()
    try:
        header, first = read_header(lines)
        time_name = "elapsed" if frame_rate is None else "frame"
        heads, start = _find_heads(lines, first, time_name)
        time_column, value_column = _find_columns(heads, time_name)
        times, values = _read_rows(lines, start, (time_column, value_column), len(heads))
        elapsed = _elapsed(times, heads[time_column], frame_rate)
        measured = _measured(values, heads[value_column], pixel)
        time_text = _describe_column(heads[time_column], time_column, "s", frame_rate)
        value_text = _describe_column(heads[value_column], value_column, "m", pixel)
        return FreeRocking(
            elapsed,
            **measured,
            header=header,
            digest=sha256(text.encode()).hexdigest(),
            columns=f"{time_text}, {value_text}",
        )
    except InputError as error:
        raise InputError(f"{os.fspath(path)}: {error}") from None


# --- columns --------------------------------------------------------------------------------------


def _find_heads(lines: Sequence[str], first: int, time_name: str) -> tuple[list[str], int]:
    """Return the heads of the columns, or empty texts, and the index of the first row."""
    heads: list[str] = []
    head_line = ""
    for index, line in enumerate(lines[first:], first):
        row = split_cells(line)
        if _numbers(row[:2]) is None:
            head_line = re.sub(r"\s+(?=[\[(])", "", line)  # a unit stays with its name
            heads = split_cells(head_line)
            names = {_name_and_unit(head)[0] for head in heads}
            if time_name in names and not names.isdisjoint(MEASURED_KINDS):
                return heads, index + 1
        elif len(row) > 1:
            # Rows may lack their last cells. A line that blanks divide may be a title.
            is_divided = any(mark in head_line for mark in ";\t,")
            if len(heads) == len(row) or (len(heads) > len(row) and is_divided):
                return heads, index
            if len(row) > 2 and "," in line and "." not in line:
                raise refused_line(lines, index, "the columns must have heads")
            return [""] * len(row), index
    for index, line in enumerate(lines[first:], first):
        if re.match(r"[\s\"+-]*\d", line):
            raise refused_line(lines, index, "it must have numbers in its first two columns")
    raise InputError(
        "the file has no rows of numbers; it must have times, and displacements or rotations"
    )


def _find_columns(heads: Sequence[str], time_name: str) -> tuple[int, int]:
    """Return the indices of the columns of times and of measured values."""
    names = [_name_and_unit(head)[0] for head in heads]
    for name in (time_name, *MEASURED_KINDS):
        if names.count(name) > 1:
            raise InputError(f"the file has {names.count(name)} columns {name}; it must have one")
    time_names = [name for name in names if name == time_name]
    measured_names = [name for name in names if name in MEASURED_KINDS]
    if len(measured_names) > 1:
        raise InputError("the file has a displacement and a rotation; it must have one of them")
    if time_names and measured_names:
        return names.index(time_name), names.index(measured_names[0])
    named_columns = [column for column, name in enumerate(names) if name]
    time_column, value_column = named_columns[:2] if len(named_columns) > 1 else (0, 1)
    for column, known_names in ((time_column, time_names), (value_column, measured_names)):
        if known_names and names[column] not in known_names:
            raise InputError(
                f"columns are {', '.join(heads)[:50]}; they must be {time_name}"
                " and displacement or rotation, or the first two must be times and measured values"
            )
    return time_column, value_column


def _name_and_unit(head: str) -> tuple[str, str]:
    """Return the name of a column in small letters and the unit that its head ends with, if any."""
    name, unit = units.name_and_unit(head)
    stem, _, ending = name.rpartition("_")
    if not unit and stem and any(units.size(ending, kind) for kind in ("s", "m", "rad")):
        return stem.casefold(), ending
    return name.casefold(), unit


def _unit(head: str, *kinds: str) -> tuple[str, float]:
    """Return the SI unit of a column, by default the first of `kinds`, and the unit's size."""
    _, unit = _name_and_unit(head)
    if not unit:
        return kinds[0], 1.0
    for kind in kinds:
        size = units.size(unit, kind)
        if size is not None:
            return kind, size
    allowed = ", ".join(spelling for kind in kinds for spelling in units.UNITS[kind])
    raise InputError(f"the unit of {head!r} is {unit!r}; it must be one of {allowed}")


def _describe_column(head: str, column: int, assumed_unit: str, size: float | None) -> str:
    """Return the head of a column, with its number if it has none and the unit if it is assumed."""
    name = head or f"column {column + 1}"
    if size is not None or _name_and_unit(head)[1]:
        return name
    return f"{name} [{assumed_unit} assumed]"


def _elapsed(times: Array, head: str, frame_rate: float | None) -> Array:
    if frame_rate is None:
        return times * _unit(head, "s")[1]
    rate = check_number("frame_rate", frame_rate, lambda rate: rate > 0, "greater than 0 [s-1]")
    frames = check("frame", times, lambda frame: frame == np.round(frame), "a whole number")
    return frames / rate


def _measured(values: Array, head: str, pixel: float | None) -> dict[str, Array]:
    """Return the measured values in SI, by the field of `FreeRocking` that they belong to."""
    name, unit = _name_and_unit(head)
    if ANGLE.search(name) and not unit:
        raise InputError(f"column {head!r} has no unit; write {head} [rad] or {head} [deg]")
    if pixel is not None:
        size = check_number("pixel", pixel, lambda pixel: pixel > 0, "greater than 0 [m]")
        return {"displacement": size * values}
    kinds = MEASURED_KINDS.get(name, ("m", "rad"))
    kind, size = _unit(head, *kinds)
    return {"displacement" if kind == "m" else "rotation": size * values}


# --- rows -----------------------------------------------------------------------------------------


def _read_rows(lines: Sequence[str], start: int, columns: tuple[int, int], width: int) -> Array:
    """Return times and measured values, shape (2, rows), of the rows that have both."""
    first, second = (column + 1 for column in columns)
    rows = []
    for index in range(start, len(lines)):
        row = split_cells(lines[index])
        if len(row) > width:
            raise refused_line(lines, index, f"it must have at most {width} cells")
        texts = [row[column] if column < len(row) else "" for column in columns]
        numbers = _numbers(texts)
        if numbers is None:
            allowed = f"it must have numbers in columns {first} and {second}"
            raise refused_line(lines, index, allowed)
        if not any(map(math.isnan, numbers)):
            rows.append(numbers)
    if not rows:
        raise InputError("the file has no rows with a time and a displacement or rotation")
    return np.array(rows).T


def _numbers(texts: Sequence[str]) -> list[float] | None:
    """Return the numbers of cells, NaN for an empty one, or None if a text is no number."""
    try:
        return [float(text or "nan") for text in texts]
    except ValueError:
        return None
