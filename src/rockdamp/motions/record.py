"""Records of ground motion: this project's CSV, AT2 files of PEER, and plain numbers with a step and a unit."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from hashlib import sha256
from itertools import chain
from typing import Any, TypeAlias

import numpy as np

from rockdamp import units
from rockdamp.arrays import Array
from rockdamp.errors import InputError, check, check_choice, check_number, check_type
from rockdamp.storage.files import read_text, replace_file

COLUMNS = ("elapsed_s", "ground_acceleration_m_s2", "displacement_m")
ACCELERATION = "ground_acceleration_"  # begins a column's name; its unit ends it: m_s2, cm_s2 or g
UNIFORM = 0.01  # of a step: how far a time may lie from its place, however it is printed
HEAD = 10  # lines of an AT2 file, of which one has NPTS and DT

_Series: TypeAlias = tuple[
    Array, Array, Array | None, dict[str, str]
]  # times, accelerations, displacements, header
_AT2 = re.compile(r"\bNPTS\b|\bDT\b|(?:\d+\.?\d*|\.\d+)(?:[ED][-+]?\d+)?")  # in capital letters
_UNIT = re.compile(
    r"(?:\bUNITS?(?:\s+(?:OF|IN|ARE|IS))?\s*[:=]?|\bIN(?!\s+UNIT)|\()\s*([A-Z][\w/*^ -]*)",
    re.IGNORECASE,
)


@dataclass(frozen=True, eq=False)
class Record:
    """A ground motion sampled uniformly in time, and the wall's displacement where it was measured.

    Parameters
    ----------
    elapsed : ndarray, shape (samples,)
        Time. Each lies within 1 % of a step, or one unit of the last decimal that any of them has, of equal steps from
        the first to the last, and each interval within half a step. [s]
    ground_acceleration : ndarray, shape (samples,)
        Positive towards +u. [m s-2]
    displacement : ndarray, shape (samples,), optional
        Measured, relative to the supports, at the hinge; the sensor's zero need not be the wall's. [m]
    header : mapping of str
        What the file says of itself: specimen, source, licence, synthetic (yes or no), and more.
    digest : str, optional
        SHA-256 of the text that it was read from.

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
    digest: str = ""

    def __post_init__(self) -> None:
        check_series(self, ("elapsed", "ground_acceleration"), optional=("displacement",))
        check_times(self.elapsed)

    def __eq__(self, other: object) -> bool:
        """Say whether another record has the same samples, header and file."""
        same = (
            np.array_equal(getattr(self, each.name), getattr(other, each.name))
            for each in fields(self)
        )
        return type(other) is type(self) and all(same)

    @property
    def step(self) -> float:
        """Time between samples. [s]"""
        return mean_step(self.elapsed)

    @property
    def synthetic(self) -> bool:
        """True if the header says that it was computed; without such a statement it was measured."""
        return self.header.get("synthetic") == "yes"


def check_series(instance: Any, names: Sequence[str], optional: Sequence[str]) -> None:
    """Check fields as series of one length, and the header; store copies. An optional field may be None."""
    present = [name for name in optional if getattr(instance, name) is not None]
    for name in (*names, *present):
        values = check(name, getattr(instance, name), np.isfinite, "finite")
        object.__setattr__(instance, name, values)
        if values.ndim != 1 or values.shape != instance.elapsed.shape:
            raise InputError(
                f"{name} has shape {values.shape}; it must be (samples,), as elapsed has"
            )
    header = check_type("header", instance.header, Mapping)
    object.__setattr__(instance, "header", dict(header))
    check_choice("synthetic", instance.header.get("synthetic", "no"), ("yes", "no"))


def mean_step(elapsed: Array) -> float:
    """Return the time between samples, from the first to the last."""
    return float(elapsed[-1] - elapsed[0]) / (elapsed.size - 1)


def check_times(elapsed: Array, printed: Iterable[str] = ()) -> None:
    """Raise `InputError` unless times are uniform, as `Record` says; `printed` are the times as a file has them."""
    if elapsed.size < 2:
        raise InputError(f"elapsed has {elapsed.size} samples; it must have at least 2")
    step, intervals = mean_step(elapsed), np.diff(elapsed)
    departure = np.abs(elapsed - elapsed[0] - step * np.arange(elapsed.size))
    if step > 0 and departure.max() <= UNIFORM * step:
        return
    exact = (d for d in range(15) if (np.round(elapsed, d) == elapsed).all())
    decimals = _decimals(printed) if printed else next(exact, 15)
    tolerance = max(10.0**-decimals, UNIFORM * step) + 2 * np.spacing(np.abs(elapsed).max())
    if (departure <= tolerance).all() and (np.abs(intervals - step) < step / 2).all():
        return
    usual = intervals[(intervals > 0) & (intervals < 1.5 * np.median(intervals))]
    step = float(usual.mean()) if usual.size else abs(step)
    wrong = np.abs(intervals - step) >= step / 2
    at = int(np.argmax(wrong)) if wrong.any() else max(int(np.argmax(departure > tolerance)) - 1, 0)
    missing = round(intervals[at] / step) - 1 if step > 0 else 0
    text = f"elapsed goes from {elapsed[at]} to {elapsed[at + 1]}; it must rise by equal steps, here {step:.6g}"
    if missing > 0 and abs(intervals[at] - (missing + 1) * step) <= tolerance:
        text += f": {missing} sample{'s are' if missing > 1 else ' is'} missing after {elapsed[at]}"
    raise InputError(text)


def append_rest(ground_acceleration: Array, step: float, tail: float) -> Array:
    """Append zeros to motions, shape (..., samples), for at least `tail`; `step` and `tail` in s, or in tau."""
    tail = float(check("tail", tail, lambda x: x >= 0, "at least 0"))
    rest = np.zeros((*ground_acceleration.shape[:-1], int(np.ceil(tail / step))))
    return np.concatenate([ground_acceleration, rest], axis=-1)


# --- files -----------------------------------------------------------------------------------------------------------


def read_record(
    path: str | os.PathLike[str], *, step: float | None = None, unit: str | None = None
) -> Record:
    """Read a record of ground motion.

    Parameters
    ----------
    path : path-like
        A CSV with lines ``# key: value``, then the columns ``elapsed_s``, ``ground_acceleration_m_s2`` (or ``_g``,
        ``_cm_s2``) and, where measured, ``displacement_m``. Or an AT2 file of PEER, known by NPTS and DT in one of its
        first ten lines. Or plain numbers below any title: times and accelerations in two columns, or accelerations in
        reading order, which may begin with their number and the step.
    step : float, optional
        Of plain numbers without times. [s]
    unit : str, optional
        Of accelerations whose file states none, as ``g``, ``m/s2`` or ``cm/s2``.

    Raises
    ------
    InputError
        For what is no record, with the line or the time; where step or unit are missing, or others than the file's.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import rockdamp as rd
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "motion.txt")
    ...     _ = path.write_text("El Centro\\n0.0 0.1 -0.2\\n0.3\\n")
    ...     rd.read_record(path, step=0.02, unit="m/s2").ground_acceleration
    array([ 0. ,  0.1, -0.2,  0.3])
    """
    text = read_text(path)
    lines = text.splitlines()
    try:
        if step is not None:
            step = check_number("step", step, np.isfinite, "a finite number")
        factor = None if unit is None else _acceleration(check_type("unit", unit, str))
        if unit is not None and factor is None:
            raise InputError(f"unit is {unit!r}; it must be one of acceleration, as g, m/s2, cm/s2")
        header, first = read_header(lines)
        names = cells(lines[first]) if first < len(lines) else []
        at2 = next(
            (
                (k, *found)
                for k, line in enumerate(lines[:HEAD])
                if (found := _samples_and_step(line))
            ),
            None,
        )
        if COLUMNS[0] in names:
            series = _csv(lines, first, names, header, factor)
        elif at2:
            series = _at2(lines, *at2, factor)
        else:
            series = _plain(lines, step, factor)
        record = Record(*series, digest=sha256(text.encode()).hexdigest())
        _agree("step", step, record.step)
        return record
    except InputError as error:
        raise InputError(f"{os.fspath(path)}: {error}") from None


def _csv(
    lines: Sequence[str],
    first: int,
    names: Sequence[str],
    header: dict[str, str],
    given: float | None,
) -> _Series:
    found = {
        name: _acceleration(name.removeprefix(ACCELERATION).replace("_", "/")) for name in names
    }
    factors = [
        (name, factor) for name, factor in found.items() if name.startswith(ACCELERATION) and factor
    ]
    if len(factors) != 1:
        shown, allowed = ", ".join(names)[:50], ", ".join(COLUMNS)
        raise InputError(f"columns are {shown}; they must be {allowed}, the last where measured")
    ((name, factor),) = factors
    _agree("unit [m s-2]", given, factor)
    columns = dict(zip(names, np.array(read_rows(lines, first + 1, len(names))).T, strict=True))
    times = names.index(COLUMNS[0])
    check_times(
        columns[COLUMNS[0]], (row[times] for line in lines[first + 1 :] if (row := cells(line)))
    )
    if factor != 1:
        header["units"] = "s, m s-2, m"
    return columns[COLUMNS[0]], columns[name] * factor, columns.get(COLUMNS[2]), header


def _at2(lines: Sequence[str], k: int, samples: float, step: float, given: float | None) -> _Series:
    head = "\n".join(lines[: k + 1])
    texts = _UNIT.findall(head)
    texts += [text.split()[0] for text in texts]  # of "G FILTERED"
    stated = {factor for text in texts if (factor := _acceleration(text))}
    other = re.search("velocity|displacement", head, re.IGNORECASE)
    if other and not stated:
        raise InputError(f"has {other[0]!r} above its numbers; they must be accelerations")
    if len(stated) > 1 or not (stated or given):
        raise InputError(
            f"states {len(stated)} units of acceleration; it must state one, or unit must be given, as g"
        )
    factor = stated.pop() if stated else given
    _agree("unit [m s-2]", given, factor)
    values = np.fromiter(chain.from_iterable(read_rows(lines, k + 1)), float)
    if values.size != samples:
        raise InputError(f"has {values.size} accelerations; it must have {samples:g}, as NPTS says")
    return (
        step * np.arange(samples),
        values * factor,
        None,
        {"source": "; ".join(map(str.strip, lines[:k]))},
    )


def _plain(lines: Sequence[str], step: float | None, factor: float | None) -> _Series:
    first = next((k for k, line in enumerate(lines) if _numbers(line)), len(lines))
    rows = read_rows(lines, first)
    if "," in (text := "".join(lines[first:])) and "." not in text:
        raise InputError(
            "has commas and no points in its numbers; the decimal sign must be a point"
        )
    numbers, head, elapsed = np.fromiter(chain.from_iterable(rows), float), rows[0], None
    values, widths = numbers, {len(row) for row in rows}
    if len(head) <= 2 and head[0] == numbers.size - len(head):
        values, step = numbers[len(head) :], head[1] if len(head) == 2 else step
    # A column that rises at nine of ten rows is time, uniform or refused.
    elif len(widths) == 1 < len(head) and (np.diff(numbers[:: len(head)]) > 0).sum() > 0.9 * (
        len(rows) - 1
    ):
        if len(head) > 2:
            raise InputError(
                f"has {len(head)} columns, the first of times; it must have {', '.join(COLUMNS[:2])}"
            )
        elapsed, values = numbers[::2], numbers[1::2]
        check_times(elapsed, (row[0] for line in lines[first:] if (row := cells(line))))
    if elapsed is None and step is not None:
        elapsed = step * np.arange(values.size, dtype=float)
    if factor is None or elapsed is None:
        shown = ", ".join(f"{value:g}" for value in numbers[:3])
        raise InputError(
            f"has plain numbers ({shown}, ...); step and unit must be given, or columns {', '.join(COLUMNS[:2])}"
        )
    return elapsed, values * factor, None, {}


def _samples_and_step(line: str) -> tuple[float, float] | None:
    """Return NPTS and DT of a line that states both, in any order, the numbers behind their names or before them."""
    found = _AT2.findall(line.upper())
    names = [word for word in found if word in ("NPTS", "DT")]
    numbers = [float(word.replace("D", "E")) for word in found if word not in ("NPTS", "DT")]
    stated = dict(zip(names, numbers, strict=False))
    return (stated["NPTS"], stated["DT"]) if len(stated) == 2 else None


def _acceleration(unit: str) -> float | None:
    """Return a unit of acceleration in m s-2, or None for another text."""
    return units.size(unit.strip(), "m s-2")


def _agree(name: str, given: float | None, own: float | None) -> None:
    if given is not None and own is not None and not math.isclose(given, own, rel_tol=1e-3):
        raise InputError(f"{name} is {given:g}; it must be {own:g}, as the file states")


# --- lines of files --------------------------------------------------------------------------------------------------


def read_header(lines: Sequence[str]) -> tuple[dict[str, str], int]:
    """Return the entries of the leading lines ``# key: value``, and the index of the line below them."""
    first = next(
        (k for k, line in enumerate(lines) if line.strip() and not line.startswith("#")), len(lines)
    )
    entries = [line.lstrip("# ").partition(":") for line in lines[:first]]
    return {key.strip().lower(): value.strip() for key, colon, value in entries if colon}, first


def cells(line: str) -> list[str]:
    """Return the cells of a line, divided by what it has first of semicolons, tabs, commas and blanks.

    A remark behind # is no cell, nor is what follows the last separator if it is empty.
    """
    text = line.partition("#")[0].strip().rstrip(",; ")
    for mark in ";\t,":
        if mark in text:
            return [cell.strip(' "') for cell in text.split(mark)]
    return text.replace('"', "").split()


def _decimals(numbers: Iterable[str]) -> int:
    """Return the most decimals of numbers as they are printed; an exponent counts."""
    parts = [number.replace("E", "e").partition("e") for number in numbers]
    return max(
        0,
        max(
            len(mantissa.partition(".")[2]) - int(exponent or 0) for mantissa, _, exponent in parts
        ),
    )


def read_rows(lines: Sequence[str], first: int, columns: int = 0) -> list[list[float]]:
    """Return the numbers of the lines from `first` on, in so many `columns` if any; blank lines are passed over."""
    rows = []
    for number, line in enumerate(lines[first:], first + 1):
        row = _numbers(line)
        if row is None or (columns and row and len(row) != columns):
            shown, allowed = (
                line.strip()[:30],
                f"{columns} finite numbers" if columns else "numbers alone",
            )
            raise InputError(
                f"line {number} is {shown!r}; it must be {allowed}, or the file have columns {', '.join(COLUMNS[:2])}"
            )
        if row:
            rows.append(row)
    if not rows:
        raise InputError(f"has no numbers; it must have the columns {', '.join(COLUMNS[:2])}")
    return rows


def _numbers(line: str) -> list[float] | None:
    """Return the finite numbers of a line, Fortran's exponents among them; None where anything else stands there."""
    try:
        row = [float(cell.replace("D", "E").replace("d", "e")) for cell in cells(line)]
    except ValueError:
        return None
    return row if all(map(math.isfinite, row)) else None


def write_record(path: str | os.PathLike[str], record: Record) -> None:
    """Write a record as CSV, which appears whole or not at all; reading it back gives the same numbers.

    Parameters
    ----------
    path : path-like
        An existing file is replaced.
    record : Record

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
    columns = zip(
        COLUMNS, (record.elapsed, record.ground_acceleration, record.displacement), strict=True
    )
    present = {name: values.tolist() for name, values in columns if values is not None}
    lines = [f"# {key}: {value}" for key, value in record.header.items()]
    lines += [
        ",".join(present),
        *(",".join(map(repr, row)) for row in zip(*present.values(), strict=True)),
    ]
    with replace_file(path) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
