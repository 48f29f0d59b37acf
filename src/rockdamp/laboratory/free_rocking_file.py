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
from rockdamp.arrays import Array
from rockdamp.errors import InputError, check, check_number
from rockdamp.motions.record import check_series
from rockdamp.motions.text_lines import read_header, split_cells
from rockdamp.storage.files import read_text


@dataclass(frozen=True, eq=False)
class FreeRocking:
    """A free-rocking test: one or more releases, without a motion of the ground.

    Parameters
    ----------
    elapsed : ndarray, shape (samples,)
        Time, ascending by any steps. [s]
    displacement : ndarray, shape (samples,), optional
        Horizontal displacement at the hinge, or at the top of a parapet; the sensor's zero need not be the wall's. [m]
    rotation : ndarray, shape (samples,), optional
        Rotation of the lower body, or of a parapet, in place of the displacement. [rad]
    header : mapping of str
        What the file says of itself: specimen, source, licence, units, synthetic (yes or no), and more.
    digest : str, optional
        SHA-256 of the text that it was read from.

    Raises
    ------
    InputError
        Unless there is either a displacement or a rotation, of finite numbers at times that rise.

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

    def __post_init__(self) -> None:
        if (self.displacement is None) == (self.rotation is None):
            raise InputError("a free-rocking test must have either a displacement or a rotation")
        check_series(self, ("elapsed",), optional=("displacement", "rotation"))
        falls = np.flatnonzero(np.diff(self.elapsed) <= 0)
        if falls.size:
            before, after = self.elapsed[falls[0] : falls[0] + 2]
            raise InputError(f"elapsed goes from {before:.9g} to {after:.9g}; it must rise")

    @property
    def synthetic(self) -> bool:
        """True if the header says that it was computed; without such a statement it was measured."""
        return self.header.get("synthetic") == "yes"

    @property
    def measured(self) -> Array:
        """What was measured: the displacement [m] or the rotation [rad]."""
        return self.displacement if self.displacement is not None else self.rotation  # type: ignore[return-value]


def read_free_rocking(
    path: str | os.PathLike[str], *, frame_rate: float | None = None, pixel: float | None = None
) -> FreeRocking:
    """Read a free-rocking test: times, and displacements or rotations, in the first two columns of a text file.

    The columns may have any name. A head ends with their unit, as ``t [ms]``, ``angle (deg)`` or ``rotation_rad``; one
    without a unit is in s, or in m. Rows without a value are left out.

    Parameters
    ----------
    path : path-like
        Lines ``# key: value``, then the columns, which semicolons, tabs, commas or blanks divide.
    frame_rate : float, optional
        Of a video, whose first column has frame numbers. [s-1]
    pixel : float, optional
        Size of a pixel, where the second column has pixels. [m]

    Raises
    ------
    InputError
        For whatever cannot be read or used, with the file, and the line or the time.

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
        heads, (times, values) = _first_two_columns(lines, first)
        if frame_rate is None:
            elapsed = times * _unit(heads[0], "s")[1]
        else:
            frame_rate = check_number(
                "frame_rate", frame_rate, lambda rate: rate > 0, "greater than 0 [s-1]"
            )
            elapsed = (
                check("frame", times, lambda frame: frame == np.round(frame), "a whole number")
                / frame_rate
            )
        if pixel is None:
            kind, factor = _unit(heads[1], "m", "rad")
        else:
            kind, factor = (
                "m",
                check_number("pixel", pixel, lambda size: size > 0, "greater than 0 [m]"),
            )
        measured = {"displacement" if kind == "m" else "rotation": factor * values}
        return FreeRocking(
            elapsed, **measured, header=header, digest=sha256(text.encode()).hexdigest()
        )
    except InputError as error:
        raise InputError(f"{os.fspath(path)}: {error}") from None


def _first_two_columns(lines: Sequence[str], first: int) -> tuple[list[str], Array]:
    """Return the heads of the first two columns, and their numbers, shape (2, rows), where both have one.

    The heads are the last line above the numbers that has as many cells as they.
    """
    heads, rows, width = ["", ""], [], 0
    for number, line in enumerate(lines[first:], first + 1):
        row = split_cells(line)
        values = _values(row[:2])
        if not width and (values is None or len(row) < 2):
            heads = (
                split_cells(re.sub(r"\s+(?=[\[(])", "", line)) or heads
            )  # a unit stays with its name
            continue
        width = width or len(row)
        if values is None or len(row) > width:
            raise InputError(
                f"line {number} is {line.strip()[:30]!r}; it must be {width} cells, the first two numbers"
            )
        if len(values) == 2 and not any(map(math.isnan, values)):
            rows.append(values)
    if not rows:
        raise InputError(
            "has no rows of numbers; it must have times and displacements, or rotations, in two columns"
        )
    return heads if len(heads) == width else ["", ""], np.array(rows).T


def _values(texts: Sequence[str]) -> list[float] | None:
    """Return the numbers of cells, NaN of an empty one; None where anything else stands there."""
    try:
        return [float(text or "nan") for text in texts]
    except ValueError:
        return None


def _unit(head: str, *kinds: str) -> tuple[str, float]:
    """Return the SI unit, one of some, and the size of the unit that a head ends with; the first without one."""
    name, stated = units.name_and_unit(head)
    ending = stated or name.rpartition("_")[2]
    sizes = ((kind, units.size(ending, kind)) for kind in kinds)
    known = [(kind, size) for kind, size in sizes if size is not None]
    if stated and not known:
        allowed = ", ".join(spelling for kind in kinds for spelling in units.UNITS[kind])
        raise InputError(f"the unit of {head!r} is {stated!r}; it must be one of {allowed}")
    return known[0] if known else (kinds[0], 1.0)
