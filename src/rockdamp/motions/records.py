"""Records of ground motion, with or without the measured response: the CSV of this project, and PEER's AT2."""

from __future__ import annotations

import csv
import io
import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from rockdamp.arrays import Array
from rockdamp.errors import InputError, require, require_finite
from rockdamp.mechanics.wall import STANDARD_GRAVITY
from rockdamp.storage.atomic import replacing

COLUMNS = ("elapsed_s", "ground_acceleration_m_s2", "displacement_m")
REQUIRED = COLUMNS[:2]
UNIFORM = 1e-4  # of a step: how far a time may lie from where uniform sampling puts it
ANSWERS = {"yes": True, "no": False}

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_AT2_COUNT = (  # the forms of an AT2 file's fourth line
    re.compile(rf"NPTS\s*=?\s*(?P<count>\d+)\s*,?\s*DT\s*=?\s*(?P<step>{_NUMBER})", re.IGNORECASE),
    re.compile(rf"^\s*(?P<count>\d+)\s+(?P<step>{_NUMBER})\s+NPTS\s*,\s*DT", re.IGNORECASE),
)
_AT2_UNITS = re.compile(r"UNITS?\s+(?:OF|IN)\s+(?P<units>\S+)", re.IGNORECASE)


@dataclass(frozen=True)
class Record:
    """A ground motion sampled uniformly in time, and the wall's displacement where it was measured.

    Parameters
    ----------
    elapsed : ndarray, shape (samples,)
        Time, uniform to `UNIFORM` of a step. [s]
    ground_acceleration : ndarray, shape (samples,)
        Positive towards +u. [m s-2]
    displacement : ndarray, shape (samples,), optional
        Measured, relative to the supports, at the hinge; the sensor's zero need not be the wall's. [m]
    header : dict of str
        What the file says of itself: specimen, source, licence, units, synthetic (yes or no), and more.

    Raises
    ------
    InputError
        If a sample is not finite, lengths differ, time is not increasing or not uniform, or `synthetic` is neither
        yes nor no.

    Examples
    --------
    >>> import rockdamp as rd
    >>> record = rd.Record([0.0, 0.01, 0.02], [0.0, 1.5, 0.0], header={"synthetic": "yes"})
    >>> record.step, record.synthetic
    (0.01, True)
    """

    elapsed: Array
    ground_acceleration: Array
    displacement: Array | None = None
    header: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, column in zip(("elapsed", "ground_acceleration", "displacement"), COLUMNS, strict=True):
            values = getattr(self, name)
            if values is None and name == "displacement":
                continue
            values = np.asarray(values, dtype=float)
            object.__setattr__(self, name, values)
            if values.shape != (len(self.elapsed),):
                raise InputError(f"{column} has shape {values.shape}; it must be {(len(self.elapsed),)}, that of time")
            _check_finite(values, column, lambda index: f"at sample {index}")
        _check_time(self.elapsed, lambda index: f"at sample {index}")
        answer = self.header.get("synthetic", "no")
        if answer not in ANSWERS:
            raise InputError(f"synthetic is {answer!r}; it must be yes or no")

    @property
    def step(self) -> float:
        """Time between samples. [s]"""
        return _step(self.elapsed)

    @property
    def synthetic(self) -> bool:
        """Whether the record says that it was computed rather than measured; one that says nothing was measured."""
        return ANSWERS[self.header.get("synthetic", "no")]


def followed_by_rest(ground_acceleration: Array, step: float, tail: float) -> Array:
    """Return a ground acceleration and, after it, zeros for at least `tail`: the time in which a wall comes to rest.

    Parameters
    ----------
    ground_acceleration : ndarray, shape (samples,)
        Of which the unit does not matter.
    step, tail : float
        Between two samples; and how long the rest lasts. Both in s, or both in tau.

    Raises
    ------
    InputError
        If `tail` is negative or not finite.
    """
    require_finite("tail", tail)
    require(tail >= 0, "tail", tail, "at least 0")
    return np.concatenate([ground_acceleration, np.zeros(int(np.ceil(tail / step)))])


def read_record(path: str | os.PathLike[str]) -> Record:
    """Read a record: PEER AT2 where the name ends in .AT2 (in either case), this project's CSV otherwise.

    Parameters
    ----------
    path : path-like
        The CSV starts with lines ``# key: value``, then names its columns, `COLUMNS`, of which the last may be
        missing and the order is free. Of an AT2 file the acceleration is in units of g.

    Returns
    -------
    Record

    Raises
    ------
    InputError
        For whatever cannot be read or used, with the line and the file.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import rockdamp as rd
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "motion.csv")
    ...     _ = path.write_text("# synthetic: yes\\nelapsed_s,ground_acceleration_m_s2\\n0,0\\n0.01,1.5\\n0.02,0\\n")
    ...     rd.read_record(path).ground_acceleration
    array([0. , 1.5, 0. ])
    """
    path = Path(path)
    lines = _lines(path)
    read = _read_at2 if path.suffix.lower() == ".at2" else _read_csv
    try:
        return read(lines)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def write_record(path: str | os.PathLike[str], record: Record) -> None:
    """Write a record as CSV; reading it back gives the same numbers. The file appears whole or not at all.

    Parameters
    ----------
    path : path-like
        An existing file is replaced.
    record : Record

    Raises
    ------
    InputError
        If the header cannot be written as lines ``# key: value``, or the file cannot be written.

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
    for key, value in record.header.items():
        if key != key.strip() or not key or ":" in key or len(f"{key}{value}".splitlines()) > 1:
            raise InputError(f"header key {key!r} is {value!r}; it must be one line, without a colon in the key")
    columns = zip(COLUMNS, (record.elapsed, record.ground_acceleration, record.displacement), strict=True)
    frame = pd.DataFrame({name: values for name, values in columns if values is not None})
    header = "".join(f"# {key}: {value}\n" for key, value in record.header.items())
    text = header + frame.to_csv(index=False, lineterminator="\n")
    try:
        with replacing(path) as temporary:
            temporary.write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise InputError(f"{os.fspath(path)}: cannot be written ({error.strerror})") from None


# --- files to lines -------------------------------------------------------------------------------------------------


def _lines(path: Path) -> list[str]:
    """Return the lines of a text file, without blank ones at its end."""
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file; it must be a record as CSV or PEER AT2") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a directory; it must be a record as CSV or PEER AT2") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    try:
        text = content.decode("utf-8-sig")  # spreadsheets put a byte order mark first
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        byte = content[error.start]
        raise InputError(f"{path}: byte 0x{byte:02x} on line {line} is not text; it must be UTF-8") from None
    text = text.replace("\r\n", "\n").replace("\r", "\n").rstrip()
    if not text:
        raise InputError(f"{path}: is empty; it must be a record as CSV or PEER AT2")
    return text.split("\n")


# --- lines to records -----------------------------------------------------------------------------------------------


def _read_csv(lines: Sequence[str]) -> Record:
    start = next((number for number, line in enumerate(lines) if not line.startswith("#")), len(lines))
    header: dict[str, str] = {}
    for line in lines[:start]:
        key, colon, value = line.lstrip("# ").partition(":")
        if colon:
            header[key.strip()] = value.strip()
    if start == len(lines):
        raise InputError(f"has a header only; columns {', '.join(REQUIRED)} must follow it")
    names = [name.strip(' "') for name in lines[start].split(",")]
    _check_columns(names, start + 1)
    first = start + 1  # index of the first row's line
    if first == len(lines):
        raise InputError(f"has no rows; at least 2 must follow the columns on line {first}")
    for number, line in enumerate(lines[first:], first + 1):
        count = line.count(",") + 1 if line.strip() else 0
        if count != len(names):
            raise InputError(f"line {number} has {count} values; it must have {len(names)}, one for each column")
    # Read as text and converted below: so a bad cell can be named, and the conversion is exact.
    frame = pd.read_csv(
        io.StringIO("\n".join(lines[first:])),
        names=names,
        dtype=str,
        keep_default_na=False,
        quoting=csv.QUOTE_NONE,
    )
    values = {
        name: _numbers(frame[name].tolist(), name, lambda index: f"on line {first + 1 + index}") for name in names
    }
    _check_time(values["elapsed_s"], lambda index: f"on line {first + 1 + index}")
    return Record(values["elapsed_s"], values["ground_acceleration_m_s2"], values.get("displacement_m"), header)


def _read_at2(lines: Sequence[str]) -> Record:
    if len(lines) < 5:
        raise InputError(f"has {len(lines)} lines; a PEER AT2 file must have 4 of header and then the accelerations")
    units = _AT2_UNITS.search(lines[2])
    if units and units["units"].strip(".,;").lower() != "g":
        raise InputError(f"units are {units['units']!r} on line 3; they must be G")
    count = next((match for pattern in _AT2_COUNT if (match := pattern.search(lines[3]))), None)
    if count is None:
        raise InputError(f"line 4 is {lines[3].strip()!r}; it must give NPTS and DT")
    samples, step = int(count["count"]), float(count["step"])
    if not step > 0:
        raise InputError(f"DT is {count['step']} on line 4; it must be greater than 0 [s]")
    cells = [(cell, number) for number, line in enumerate(lines[4:], 5) for cell in line.split()]
    if len(cells) != samples:
        raise InputError(f"has {len(cells)} accelerations; it must have {samples}, as NPTS on line 4 says")
    values = _numbers([cell for cell, _ in cells], "acceleration", lambda index: f"on line {cells[index][1]}")
    header = {
        "specimen": "none",
        "source": "; ".join(line.strip() for line in lines[:2] if line.strip()),
        "units": "s, m s-2",
        "synthetic": "no",
    }
    return Record(step * np.arange(samples, dtype=float), values * STANDARD_GRAVITY, None, header)


def _numbers(cells: Sequence[str], name: str, place: Callable[[int], str]) -> Array:
    """Convert cells to finite numbers, or name the first that is none."""
    values = np.empty(len(cells))
    for index, cell in enumerate(cells):
        try:
            values[index] = float(cell)
        except ValueError:
            shown = cell.strip() if len(cell) < 40 else cell[:40] + "..."
            raise InputError(f"{name} is {shown!r} {place(index)}; it must be a number") from None
    _check_finite(values, name, place)
    return values


# --- checks ---------------------------------------------------------------------------------------------------------


def _check_columns(names: Sequence[str], line: int) -> None:
    allowed = f"the columns must be {', '.join(REQUIRED)} and, where measured, {COLUMNS[2]}, divided by commas"
    for name in names:
        if name not in COLUMNS:
            hint = "; the name of a PEER AT2 file must end in .AT2" if "PEER" in name.upper() else ""
            raise InputError(f"column {name!r} on line {line} is unknown; {allowed}{hint}")
        if names.count(name) > 1:
            raise InputError(f"column {name!r} on line {line} stands there more than once; {allowed}")
    for name in REQUIRED:
        if name not in names:
            raise InputError(f"column {name!r} is missing on line {line}; {allowed}")


def _check_finite(values: Array, name: str, place: Callable[[int], str]) -> None:
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise InputError(f"{name} is {float(values[bad[0]])} {place(int(bad[0]))}; it must be a finite number")


def _step(elapsed: Array) -> float:
    return float(elapsed[-1] - elapsed[0]) / (len(elapsed) - 1)


def _check_time(elapsed: Array, place: Callable[[int], str]) -> None:
    """Raise unless time has at least two samples, increases, and is uniform to `UNIFORM` of a step."""
    if len(elapsed) < 2:
        raise InputError(f"elapsed_s has {len(elapsed)} samples; it must have at least 2")
    intervals = np.diff(elapsed)
    back = np.flatnonzero(intervals <= 0)
    if back.size:
        late = int(back[0]) + 1
        raise InputError(f"elapsed_s is {elapsed[late]} {place(late)}; it must be greater than {elapsed[late - 1]}")
    # The straight line of least squares, moved to the middle, lies within UNIFORM of a step of all times.
    index = np.arange(len(elapsed)) - (len(elapsed) - 1) / 2
    departure = elapsed - index * (index @ elapsed) / (index @ index)
    if np.ptp(departure) / 2 > UNIFORM * _step(elapsed):
        usual = float(np.median(intervals))
        late = int(np.argmax(np.abs(intervals - usual))) + 1
        raise InputError(
            f"elapsed_s is {elapsed[late]} {place(late)}; it must be {elapsed[late - 1] + usual:.9g}: times must be "
            f"uniform to {UNIFORM:g} of a step"
        )
