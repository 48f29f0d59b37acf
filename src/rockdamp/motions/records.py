"""Records of ground motion, with or without the measured response: the CSV of this project, and PEER's AT2."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
import pandas as pd

from rockdamp.arguments import MOST_ELEMENTS, instance, number, read_only, real
from rockdamp.arguments import path as file_path
from rockdamp.arrays import Array, ByValue
from rockdamp.errors import InputError, require
from rockdamp.motions import record_files
from rockdamp.motions.record_files import COLUMNS, check_finite, check_time, step_of
from rockdamp.storage import input_file
from rockdamp.storage.atomic import replacing

S = TypeVar("S", bound="Sampled")
ANSWERS = {"yes": True, "no": False}
OTHER_SERIES = {".vt2": "velocities", ".dt2": "displacements"}  # that PEER puts beside the accelerations


class Sampled(ByValue):
    """Base of what is sampled uniformly in time and has a header: a record, or a free-rocking test."""

    elapsed: Array
    header: Mapping[str, str]

    def _keep(self, columns: Mapping[str, str], optional: Sequence[str]) -> None:
        """Check header and columns, by the names of their fields, and make all of it read-only."""
        for name, column in columns.items():
            if getattr(self, name) is None and name in optional:
                continue
            values = read_only(real(column, getattr(self, name)).copy())
            object.__setattr__(self, name, values)
            samples = self.elapsed.shape
            if len(samples) != 1:
                raise InputError(f"{column} has shape {values.shape}; it must be (samples,)")
            if values.shape != samples:
                raise InputError(f"{column} has shape {values.shape}; it must be {samples}, that of time")
            check_finite(values, column, lambda index: f"at sample {index}")
        check_time(self.elapsed, lambda index: f"at sample {index}")
        object.__setattr__(self, "header", MappingProxyType(checked_header(self.header)))

    def __reduce__(self) -> tuple[Any, ...]:  # a copy and a pickle are checked anew, and can be changed as little
        parts = {each.name: getattr(self, each.name) for each in fields(self)} | {"header": dict(self.header)}  # type: ignore[arg-type]
        return type(self), tuple(parts.values())

    @property
    def step(self) -> float:
        """Time between samples. [s]"""
        return step_of(self.elapsed)

    @property
    def synthetic(self) -> bool:
        """True if the header says that it was computed; without such a statement it was measured."""
        return ANSWERS[self.header.get("synthetic", "no")]


@dataclass(frozen=True, eq=False)
class Record(Sampled):
    """A ground motion sampled uniformly in time, and the wall's displacement where it was measured.

    Parameters
    ----------
    elapsed : ndarray, shape (samples,)
        Time, uniform to 1e-4 of a step. [s]
    ground_acceleration : ndarray, shape (samples,)
        Positive towards +u. [m s-2]
    displacement : ndarray, shape (samples,), optional
        Measured, relative to the supports, at the hinge; the sensor's zero need not be the wall's. [m]
    header : mapping of str
        What the file says of itself: specimen, source, licence, units, synthetic (yes or no), and more. Keys are
        kept in small letters. It cannot be changed, as what was checked; `dataclasses.replace` makes another record.
    digest : str, optional
        SHA-256 of the file that it was read from.
    unit_of_file : str, optional
        Unit of the accelerations there, before they were converted.

    Raises
    ------
    InputError
        If a sample is not finite, lengths differ, time is not increasing or not uniform, two keys of the header are the
        same, `synthetic` is neither yes nor no, or `units` are others than s, m s-2 and m.

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
    header: Mapping[str, str] = field(default_factory=dict)
    digest: str = field(default="", compare=False)
    unit_of_file: str = field(default="m s-2", compare=False)

    def __post_init__(self) -> None:
        names = ("elapsed", "ground_acceleration", "displacement")
        self._keep(dict(zip(names, COLUMNS, strict=True)), optional=names[2:])
        if "units" in self.header:
            record_files.require_stated(self.header["units"], "m s-2", "they must be converted")


def checked_header(stated: Mapping[str, str]) -> dict[str, str]:
    """Return a header with its keys in small letters; refuse a key that stands there twice, and an odd `synthetic`."""
    instance("header", stated, Mapping)
    for key, value in stated.items():
        instance("a key of the header", key, str)
        instance(f"header {key!r}", value, str)
    header = {key.strip().lower(): value for key, value in stated.items()}
    if len(header) < len(stated):
        raise InputError(f"the header has the keys {', '.join(map(str, stated))}; each must stand there once")
    answer = header.get("synthetic", "no")
    if answer not in ANSWERS:
        raise InputError(f"synthetic is {answer!r}; it must be yes or no")
    return header


def header_lines(header: Mapping[str, str]) -> str:
    """Return the lines ``# key: value`` of a header, or raise `InputError` where it cannot be written so."""
    for key, value in header.items():
        line = f"{key}{value}"
        if not key or key.startswith("#") or ":" in key or not line.isprintable():
            allowed = "one line without control characters, the key without a colon and not beginning with #"
            raise InputError(f"header key {key!r} is {value!r}; it must be {allowed}")
    return "".join(f"# {key}: {value}\n" for key, value in header.items())


def followed_by_rest(ground_acceleration: Array, step: float, tail: float) -> Array:
    """Append zeros for at least `tail`, in which a wall comes to rest; `step` and `tail` in s, or in tau."""
    tail = number("tail", tail)
    require(tail >= 0, "tail", tail, "at least 0")
    rest = np.ceil(tail / step)
    allowed = f"at most {MOST_ELEMENTS:,} samples long, {MOST_ELEMENTS * step:.3g} of its unit"
    require(rest <= MOST_ELEMENTS, "tail", tail, allowed)
    return np.concatenate([ground_acceleration, np.zeros(int(rest))])


def has_displacement(path: str | os.PathLike[str]) -> bool:
    """Return whether a record's file names the column of the measured displacement; the numbers are not read."""
    text = input_file.text(input_file.content(path, "a record as CSV or PEER AT2"), path)
    names = next((line for line in text.split("\n") if line.strip() and not line.startswith("#")), "")
    return COLUMNS[2] in names


def read_record(path: str | os.PathLike[str]) -> Record:
    """Read a record: PEER AT2 where the name ends in .AT2 (in either case), this project's CSV otherwise.

    Parameters
    ----------
    path : path-like
        A regular file, or a stream such as ``/dev/stdin``; it is read once. The CSV starts with lines
        ``# key: value``, then names its columns: ``elapsed_s``, one of ``ground_acceleration_m_s2``,
        ``ground_acceleration_g`` and ``ground_acceleration_cm_s2``, and where measured ``displacement_m``, in any
        order. An AT2 file is in g unless its header states another unit.

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
    path = file_path("path", path)
    if (other := OTHER_SERIES.get(path.suffix.lower())) is not None:
        raise InputError(f"{os.fspath(path)}: has PEER's suffix for {other}; the accelerations are in the file .AT2")

    def record(lines: Sequence[str], digest: str) -> Record:
        parts = record_files.at2(lines) if path.suffix.lower() == ".at2" else record_files.csv(lines)
        return Record(*parts[:4], unit_of_file=parts.unit, digest=digest)

    return read_lines(path, "a record as CSV or PEER AT2", record)


def read_lines(path: Path, kind: str, make: Callable[[Sequence[str], str], S]) -> S:
    """Make what a file holds from its lines and its digest; an error names the file."""
    read = input_file.content(path, kind)
    text = input_file.text(read, path).rstrip()
    try:
        if not text:
            raise InputError(f"is empty; it must be {kind}")
        return make(text.split("\n"), hashlib.sha256(read).hexdigest())
    except InputError as error:
        raise InputError(f"{os.fspath(path)}: {error}") from None


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
    path, record = file_path("path", path), instance("record", record, Record)
    columns = (record.elapsed, record.ground_acceleration, record.displacement)
    write_columns(path, record.header, dict(zip(COLUMNS, columns, strict=True)))


def write_columns(path: Path, header: Mapping[str, str], columns: Mapping[str, Array | None]) -> None:
    """Write a header and those columns that are there as CSV, whole or not at all."""
    frame = pd.DataFrame({name: values for name, values in columns.items() if values is not None})
    text = header_lines(header) + frame.to_csv(index=False, lineterminator="\n")
    try:
        with replacing(path) as temporary:
            temporary.write_text(text, encoding="utf-8", newline="\n")
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be written ({getattr(error, 'strerror', None) or error})") from None
