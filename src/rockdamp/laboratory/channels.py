"""From a laboratory's raw channels to a record: units, relative displacement, filter, resampling, zero and baseline."""

from __future__ import annotations

import csv
import hashlib
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from rockdamp import units
from rockdamp.arguments import number
from rockdamp.arrays import Array
from rockdamp.errors import InputError, require
from rockdamp.laboratory.releases import FreeRocking
from rockdamp.motions.records import Record
from rockdamp.plausibility import ACCELERATIONS, of_displacement, of_motion, of_step, warn
from rockdamp.storage import input_file

FILTER_ORDER = 4  # of Butterworth's filter, which runs forwards and backwards: no delay, twice the order
FEWEST_FILTERED = 16  # samples that the filter needs to run backwards
MOST_FINER = 100  # times the channels' rate: a spline adds nothing between the samples
MOST_SAMPLES = 10**7  # of a record: some seconds of work
KEPT = 0.4  # of the sampling rate: where a coarser rate is asked for, what is above is filtered out
MOST_FILLED = 5  # neighbouring samples that a spline replaces, as of a marker that the camera lost
PIXEL = "px"
MOST_CHANNELS = 10  # times the rows: of a table that has more columns the rows are the channels
MOST_UNEVEN = 0.5  # of the median interval: how far an interval may be from it
BASELINES = ("constant", "linear", "none")
ANGLES = {"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180, "°": math.pi / 180}  # [rad]
# ASSUME: where the rest varies so many times more than the quietest part, and by so much of the peak, it is none.
RESTLESS, RESTLESS_SHARE = 3.0, 0.005
# ASSUME: a band above the drift of what is integrated twice [Hz]; the correlation, and the factor, of what is alike;
# how many times as unlike it the channel of the table may be as that of the wall.
COMPARED, ALIKE, UNLIKE, WORSE = (0.3, 10.0), 0.9, 1.5, 3.0
UNRELATED = 0.5  # ASSUME: below this correlation they have less than a quarter of their variance in common
MOST_CUT = 0.5  # ASSUME: of PGA; a filter that leaves less takes more than noise from most motions


@dataclass(frozen=True)
class Channel:
    """A column of a raw file, by its name or number, and its unit."""

    column: str
    unit: str

    @classmethod
    def from_text(cls, text: str, unit: str = "") -> Channel:
        """Parse ``COLUMN:UNIT``; the unit may be left out where there is a usual one."""
        column, colon, stated = text.rpartition(":")
        if not colon:
            column, stated = text, unit
        if not column or not stated:
            raise InputError(f"channel {text!r} must be COLUMN:UNIT, as d1:mm; COLUMN is a name, or a number from 1 on")
        return cls(column.strip(), stated.strip())


@dataclass(frozen=True)
class Raw:
    """The columns of a raw file."""

    names: Sequence[str]
    values: Array  # (rows, columns)
    digest: str

    def column(self, name: str) -> Array:
        """Return a column by its name, or by its number from 1 on."""
        if name in self.names:
            return self.values[:, list(self.names).index(name)]
        if name.isascii() and name.isdigit() and 1 <= int(name) <= self.values.shape[1]:
            return self.values[:, int(name) - 1]
        raise InputError(f"column {name!r} is not there; it must be one of {', '.join(self.names)}, or its number")


def read_raw(path: str | os.PathLike[str], gaps: bool = False) -> Raw:
    """Read a table of numbers: divided by commas, semicolons, tabs or blanks, with or without a line of names.

    With `gaps`, an empty cell and "nan" are NaN, but not in all columns of a row.

    Lines before the first of two or more numbers are remarks, of which the last one with as many cells names the
    columns; otherwise the columns are numbered. A comma is a decimal sign where semicolons or tabs divide.
    """
    if os.fspath(path).lower().endswith(".at2"):
        raise InputError(
            f"{os.fspath(path)}: is a record of PEER, which respond, assess and batch read as it is; raw channels must"
            " be a table with a column of the times"
        )
    read = input_file.content(path, "a table of raw channels")
    lines = [line.strip() for line in input_file.text(read, path).split("\n")]
    divider = _divider(lines)
    try:
        rows = [(index, _cells(line, divider)) for index, line in enumerate(lines, 1) if line]
    except csv.Error as error:  # of a cell of more than 131 072 characters
        raise InputError(f"{os.fspath(path)}: {error}; it must be a table of raw channels") from None
    first = next((at for at, (_, cells) in enumerate(rows) if len(cells) > 1 and _row(cells, gaps) is not None), None)
    if first is None or len(rows) < first + 2:
        raise InputError(f"{os.fspath(path)}: has no table of numbers; it must have two columns and two rows at least")
    width = len(rows[first][1])
    values = []
    for line, cells in rows[first:]:
        found = _row(cells, gaps)
        if found is None or len(found) != width or not gaps and not np.isfinite(found).all():
            raise InputError(
                f"{os.fspath(path)}: line {line} must have {width} finite numbers, as line {rows[first][0]} has"
            )
        values.append(found)
    if width > MOST_CHANNELS * len(values):
        shape = f"{len(values)} rows and {width} columns"
        raise InputError(f"{os.fspath(path)}: has {shape}; a row must hold one time: is the table transposed?")
    named = [cells for _, cells in rows[:first] if len(cells) == width]
    if len(named) > 1 and all(_is_unit(cell) for cell in named[-1]):  # below the names
        named.pop()
    names = [cell.strip(' "#') for cell in named[-1]] if named else [str(index + 1) for index in range(width)]
    return Raw(names, np.array(values), hashlib.sha256(read).hexdigest())


def _is_unit(cell: str) -> bool:
    unit = cell.strip(' "#()[]')
    known = units.parse(unit) or units.size(unit, "m s-2") or ANGLES.get(unit.lower())
    return known is not None or unit in ("-", "", "%")


def _divider(lines: Sequence[str]) -> str | None:
    """Return what divides the cells; None for blanks."""
    body = [line for line in lines if line and not line.startswith("#")][-1:]
    return input_file.divider(body[0]) if body else None


def _cells(line: str, divider: str | None) -> list[str]:
    cells = next(csv.reader([line], delimiter=divider)) if divider else line.split()
    return [input_file.with_point(cell, divider) for cell in cells]


def _row(cells: Sequence[str], gaps: bool) -> list[float] | None:
    """Return the numbers of a row; None for a remark. With `gaps`, empty cells are NaN, but not all."""
    found = _numbers([cell.strip() or "nan" for cell in cells] if gaps else cells)
    return None if found is not None and gaps and not np.isfinite(found).any() else found


def _numbers(cells: Sequence[str]) -> list[float] | None:
    try:
        return [units.number(cell) for cell in cells]
    except ValueError:
        return None


def laboratory_record(
    raw: Raw,
    *,
    time: Channel,
    table_acceleration: Channel | None = None,
    table_velocity: Channel | None = None,
    wall: Channel | None = None,
    table: Channel | None = None,
    rest: float = 0.5,
    lowpass: float | None = None,
    rate: float | None = None,
    baseline: str = "constant",
    specimen: str = "not stated",
    source: str = "not stated",
    synthetic: bool = False,
) -> Record:
    """Make a record of raw channels; its header says all that was done to them.

    In this order: units to SI, the wall less the table, velocity to acceleration, the low-pass filter, one rate, the
    displacement's zero and the acceleration's baseline. The motion is `table_acceleration` or `table_velocity`; of the
    wall's displacement that of the `table` is taken off. The zeros are means over `rest` at the start [s]; of a channel
    that is not at rest there, or where `rest` is 0, nothing is subtracted. `lowpass` is
    the corner of Butterworth's filter of fourth order, run forwards and backwards [Hz]; where `rate` is lower than that
    of the channels, there is one at 0.4 of it [Hz]. A ``linear`` baseline is also the straight line, zero at the end of
    the rest, that leaves no velocity at the end of the record.
    """
    if (table_acceleration is None) == (table_velocity is None):
        raise InputError("the motion must be given once: as table_acceleration or as table_velocity")
    if table is not None and wall is None:
        raise InputError("table is the displacement that is taken off the wall's; there must be a wall")
    if baseline not in BASELINES:
        raise InputError(f"baseline is {baseline!r}; it must be one of {', '.join(BASELINES)}")
    header = {"specimen": specimen, "source": source, "units": "s, m s-2, m" if wall else "s, m s-2"}
    header |= {"synthetic": "yes" if synthetic else "no", "raw_sha256": raw.digest}
    _require_apart(raw, time, table_acceleration, table_velocity, wall, table)
    elapsed = _in(raw, time, "s", "time", header)
    interval = _check_time(elapsed)
    warn(of_step(interval))
    ends = f"at least 0 and less than the record's length, {elapsed[-1] - elapsed[0]:.4g} [s]"
    require(0 <= rest < elapsed[-1] - elapsed[0], "rest", rest, ends)
    even = elapsed[0] + interval * np.arange(int((elapsed[-1] - elapsed[0]) / interval * (1 + 1e-9)) + 1)
    if table_velocity is not None:
        motion = CubicSpline(elapsed, _in(raw, table_velocity, "m s-1", "table_velocity", header))(even, 1)
        header["acceleration"] = "derivative of the velocity's cubic spline"
    if table_acceleration is not None:
        motion = CubicSpline(elapsed, _in(raw, table_acceleration, "m s-2", "table_acceleration", header))(even)
    displacement, moved = None, None
    if wall is not None:
        displacement = CubicSpline(elapsed, _in(raw, wall, "m", "wall", header))(even)
        header["displacement"] = "wall less table" if table is not None else "wall, taken as relative to the table"
        moved = CubicSpline(elapsed, _in(raw, table, "m", "table", header))(even) if table is not None else None
    beside = displacement if moved is None else moved
    warn(_of_motion(even, motion, beside, raw, table_acceleration, {"wall": wall, "table": table}))
    if displacement is not None:
        warn(_of_table(even, motion, displacement, moved))
        displacement = displacement if moved is None else displacement - moved
        warn(_spike(even, displacement))
    strongest = float(np.abs(motion).max())
    even, motion, displacement = _filtered(even, motion, displacement, lowpass, rate, header)
    if (left := float(np.abs(motion).max())) < MOST_CUT * strongest:
        corner = f"{header['lowpass_hz'].partition(',')[0]} Hz"
        cut = f"the filter of {corner} takes PGA from {strongest:.3g} to {left:.3g} m s-2"
        warn([f"{cut}: does it leave the motion that the wall felt?"])
    even = even - even[0]
    resting = even < rest
    doubts = {"acceleration": _restless("acceleration", motion, "m s-2", 1.0, even, rest)}
    if displacement is not None:
        doubts["displacement"] = _restless("displacement", displacement, "mm", 1000.0, even, rest)
        if resting.any() and not doubts["displacement"]:
            zero = float(displacement[resting].mean())
            displacement, header["zero_removed_m"] = displacement - zero, f"{zero:.6g}"
        warn(of_displacement(displacement))
    if baseline == "none":  # who says so knows
        return Record(even, motion, displacement, header)
    warn([doubt for doubt in doubts.values() if doubt])
    if resting.any() and not doubts["acceleration"]:
        motion = _without_baseline(even, motion, resting, baseline, header)
    return Record(even, motion, displacement, header)


def _spike(elapsed: Array, moved: Array) -> list[str]:
    """Return a warning where the largest value is one sample, further from those beside it than half of itself."""
    at = int(np.abs(moved).argmax())
    if not 0 < at < moved.size - 1 or abs(moved[at] - moved[at - 1 : at + 2 : 2].mean()) <= abs(moved[at]) / 2:
        return []
    return [f"the wall's largest value, at {elapsed[at]:.6g} s, is one sample far from those beside it: is it a fault?"]


def _require_apart(raw: Raw, *channels: Channel | None) -> None:
    """Raise `InputError` where two channels have one column."""
    names = [channel.column for channel in channels if channel is not None]
    for name, other in combinations(names, 2):
        if np.array_equal(raw.column(name), raw.column(other), equal_nan=True):
            raise InputError(f"columns {name!r} and {other!r} have the same numbers; each channel must have its own")


def _of_motion(
    even: Array,
    motion: Array,
    displacement: Array | None,
    raw: Raw,
    acceleration: Channel | None,
    displacements: Mapping[str, Channel | None],
) -> list[str]:
    """Return a warning where a PGA is none of earthquakes; it names a displacement that may have been exchanged.

    None where the displacement of the table, or a wall's that holds it, says that the PGA is right.
    """
    if displacement is not None and _follows(*_likeness(even, motion, displacement)):
        return []
    pga = float(np.abs(motion).max())
    if acceleration is None:
        return of_motion(pga)
    taken = units.size(acceleration.unit, "m s-2") or 1.0
    unit = next((name for name, size in ACCELERATIONS.items() if size == taken), acceleration.unit)
    doubts = of_motion(pga, unit, taken)
    for name, other in displacements.items():
        if doubts and other is not None:
            shaken = taken * float(np.ptp(raw.column(other.column)))
            moved = (units.size(other.unit, "m") or 1.0) * float(np.ptp(raw.column(acceleration.column)))
            if not of_motion(shaken) and not of_displacement(moved):
                return [f"{doubts[0]}; or were its column and that of the {name} exchanged?"]
    return doubts


def _follows(alike: float, factor: float) -> bool:
    return alike > ALIKE and 1 / UNLIKE < factor < UNLIKE


def _of_table(even: Array, motion: Array, wall: Array, table: Array | None) -> list[str]:
    """Return a warning where the displacements of wall and table do not go with the acceleration of the table.

    A wall in resonance is a quarter of a cycle behind, and not alike.
    """
    alike, factor = _likeness(even, motion, wall)
    is_table = _follows(alike, factor)
    if table is None:
        said = "the wall's displacement is that of the table, as its acceleration gives it"
        asked = "was it measured from the ground? Then table must name the table's displacement"
        return [f"{said}; {asked}"] if is_table else []
    tables, factor = _likeness(even, motion, table)
    if is_table and 1 - tables > WORSE * (1 - alike):
        return ["the wall's channel follows the acceleration of the table better than the table's; were they swapped?"]
    if abs(tables) > ALIKE and not 1 / UNLIKE < factor < UNLIKE:
        asked = "is the sign of one wrong?" if tables < 0 else "are both units right?"
        return [f"the table's displacement is {factor:.3g} times what its acceleration gives; {asked}"]
    if abs(tables) < UNRELATED:
        asked = "is each the column that it should be, and the acceleration no velocity?"
        return [f"the table's displacement is unlike what its acceleration gives, correlation {tables:.2g}; {asked}"]
    return []


def _likeness(even: Array, motion: Array, displacement: Array) -> tuple[float, float]:
    """Return the correlation of a displacement with that of an acceleration, in the band of `COMPARED`, and the factor.

    0 and 1 where one of them is constant.
    """
    frequency = np.fft.rfftfreq(even.size, even[1] - even[0])
    band = (frequency > COMPARED[0]) & (frequency < COMPARED[1])
    integrated = -np.fft.rfft(motion)[band] / (2 * np.pi * frequency[band]) ** 2
    there = np.fft.rfft(displacement)[band]
    along = float(np.vdot(integrated, there).real)
    sizes = float(np.linalg.norm(integrated)), float(np.linalg.norm(there))
    if not along:
        return 0.0, 1.0
    return along / (sizes[0] * sizes[1]), along / sizes[0] ** 2


def _restless(name: str, values: Array, unit: str, factor: float, elapsed: Array, rest: float) -> str:
    """Return a warning where a channel varies far more in its rest than in the quietest part of the record.

    Parts are as long as the rest, or a quarter of the record where the rest is longer: it may hold all of the motion.
    """
    resting = int(np.count_nonzero(elapsed < rest))
    if not resting:
        return ""
    count = min(resting, max(values.size // 4, 2))
    last = resting - count  # where the last part of the rest begins
    starts = np.union1d(np.arange(0, values.size - count + 1, max(count // 4, 1)), last)
    spreads = np.array([np.std(values[start : start + count]) for start in starts])
    quietest, there = int(np.argmin(spreads)), float(spreads[starts <= last].max())
    least = float(spreads[quietest])
    if there <= max(RESTLESS * least, RESTLESS_SHARE * float(np.abs(values).max())):
        return ""
    length = rest if count == resting else count * float(elapsed[1] - elapsed[0])
    return (
        f"the first {rest:g} s are not at rest: the {name} varies there by {factor * there:.2g} {unit} (standard"
        f" deviation), and by {factor * least:.2g} {unit} in the quietest {length:.3g} s, from"
        f" {elapsed[starts[quietest]]:.3g} s on; nothing is subtracted from it: the rest must end before the motion"
        " begins, or the baseline must be none"
    )


def laboratory_free_rocking(
    raw: Raw,
    *,
    time: Channel | None = None,
    wall: Channel | None = None,
    rotation: Channel | None = None,
    frame_rate: float | None = None,
    scale: float | None = None,
    lowpass: float | None = None,
    rate: float | None = None,
    specimen: str = "not stated",
    source: str = "not stated",
    synthetic: bool = False,
) -> FreeRocking:
    """Make a free-rocking test of a raw channel: units to SI, the low-pass filter, one rate. No zero is taken off.

    Either `wall`, the displacement at the hinge or at the top of a parapet, or `rotation`, of the lower body. Of a
    video, `frame_rate` [Hz] takes the place of the time, and each row is a frame; `scale` is the size of a pixel [m],
    of a displacement in px. Up to `MOST_FILLED` neighbouring samples may be missing, as rows or as NaN; a cubic spline
    fills them, and the header counts them.
    """
    if (wall is None) == (rotation is None):
        raise InputError("a free-rocking test must be given once: as wall, a displacement, or as rotation")
    header = {"specimen": specimen, "source": source, "units": "s, m" if wall else "s, rad"}
    header |= {"synthetic": "yes" if synthetic else "no", "raw_sha256": raw.digest}
    _require_apart(raw, time, wall, rotation)
    if (time is None) == (frame_rate is None):
        raise InputError("the time must be given once: as time, a column, or as frame_rate of a video")
    if time is not None:
        elapsed = _in(raw, time, "s", "time", header)
    else:
        frames = number("frame_rate", frame_rate)
        require(frames > 0, "frame_rate", frames, "greater than 0 [Hz]")
        elapsed, header["frame_rate_hz"] = np.arange(len(raw.values)) / frames, f"{frames:g}"
    name, channel, unit = ("wall", wall, "m") if wall is not None else ("rotation", rotation, "rad")
    assert channel is not None
    if (channel.unit == PIXEL) != (scale is not None):
        raise InputError(f"{name} is in {channel.unit}; a channel in px, and no other, must have a scale, as 0.35mm/px")
    measured = _in(raw, channel, unit, name, header, scale)
    seen = np.isfinite(elapsed) & np.isfinite(measured)
    elapsed, measured = elapsed[seen], measured[seen]
    require(elapsed.size >= 2, "the number of samples that are seen", elapsed.size, "at least 2")
    interval = _check_time(elapsed, MOST_FILLED)
    even = elapsed[0] + interval * np.arange(int((elapsed[-1] - elapsed[0]) / interval * (1 + 1e-9) + 0.5) + 1)
    if filled := even.size - elapsed.size:
        header["samples_filled"] = str(filled)
    moved = CubicSpline(elapsed, measured)(np.minimum(even, elapsed[-1]))
    warn(_spike(even, moved))
    even, moved, _ = _filtered(even, moved, None, lowpass, rate, header)
    warn([*of_step(float(even[1] - even[0])), *(of_displacement(moved - moved.mean()) if name == "wall" else [])])
    displacement, turned = (moved, None) if name == "wall" else (None, moved)
    return FreeRocking(even - even[0], displacement, turned, header)


def _in(raw: Raw, channel: Channel, unit: str, name: str, header: dict[str, str], scale: float | None = None) -> Array:
    """Return a channel in SI, and state its factor in the header; `scale` is that of pixels [m]."""
    factor = ANGLES.get(channel.unit.lower()) if unit == "rad" else units.size(channel.unit, unit)
    if scale is not None:
        factor = number("scale", scale)
        require(factor > 0, "scale", factor, "greater than 0 [m]")
    if factor is None:
        raise InputError(f"{name} has the unit {channel.unit!r}, which is none of its kind, as {EXAMPLES[name]}")
    header[f"{name}_channel"] = f"{channel.column}, times {factor:.9g}"
    return raw.column(channel.column) * factor


EXAMPLES = {
    "time": "s, ms",
    "table_acceleration": "g, m/s2, cm/s2",
    "table_velocity": "m/s, mm/s, in/s",
    "wall": "mm, cm, m, in, and px with a scale",
    "table": "mm, cm, m, in",
    "rotation": ", ".join(ANGLES),
}


def _check_time(elapsed: Array, most_missing: int = 0) -> float:
    """Return the usual interval of times, which must increase; gaps are of at most so many samples."""
    intervals = np.diff(elapsed)
    usual = float(np.median(intervals))
    missing = np.clip(np.round(intervals / usual) - 1 if usual > 0 else 0 * intervals, 0, None)
    gap = int(np.argmax(missing))
    if 0 < most_missing < missing[gap]:
        raise InputError(
            f"{missing[gap]:.0f} samples are missing after {elapsed[gap]:.4g} s; it must be at most {most_missing} in a"
            " row, which a spline fills"
        )
    apart = intervals - usual * (1 + missing * (most_missing > 0))
    uneven = np.flatnonzero(~(np.abs(apart) <= MOST_UNEVEN * usual) | (intervals <= 0))
    if uneven.size:
        row = int(uneven[0]) + 2
        due = f"{usual:.4g} s after" if usual > 0 else "later than"
        slip = "" if usual > 0 else ": is this the column of the times?"
        raise InputError(f"time is {elapsed[row - 1]:.9g} s in row {row}; it must be {due} the row before{slip}")
    return usual


def _filtered(
    even: Array,
    motion: Array,
    displacement: Array | None,
    lowpass: float | None,
    rate: float | None,
    header: dict[str, str],
) -> tuple[Array, Array, Array | None]:
    """Return times and channels through the low-pass filter and at the rate that were asked for."""
    own, length = 1 / float(even[1] - even[0]), float(even[-1] - even[0])
    wanted = own
    if rate is not None:
        wanted, least, most = number("rate", rate), 3 / length, min(MOST_FINER * own, MOST_SAMPLES / length)
        require(least <= wanted <= most, "rate", wanted, f"between {least:.4g} and {most:.4g} [Hz]")
    corner = lowpass if lowpass is not None else KEPT * wanted if wanted < own * (1 - 1e-6) else None
    channels = [motion] if displacement is None else [motion, displacement]
    if corner is not None:
        corner = number("lowpass", corner)
        require(even.size >= FEWEST_FILTERED, "the number of rows", even.size, f"at least {FEWEST_FILTERED} to filter")
        least, most = 1 / length, min(own, wanted) / 2
        allowed = f"at least {least:.4g}, a cycle in the record, and below half the rate, {most:.4g} [Hz]"
        require(least <= corner < most, "lowpass", corner, allowed)
        sections = butter(FILTER_ORDER, corner, fs=own, output="sos")
        channels = [sosfiltfilt(sections, channel) for channel in channels]
        header["lowpass_hz"] = f"{corner:g}, Butterworth of order {FILTER_ORDER}, forwards and backwards"
    if rate is not None:
        at = even[0] + np.arange(int((even[-1] - even[0]) * wanted * (1 + 1e-9)) + 1) / wanted
        channels = [CubicSpline(even, channel)(at) for channel in channels]
        header["resampled_hz"] = f"{wanted:g}, from {own:.6g}, by a cubic spline"
        even = at
    return even, channels[0], channels[1] if displacement is not None else None


def _without_baseline(even: Array, motion: Array, resting: Array, baseline: str, header: dict[str, str]) -> Array:
    """Return the acceleration without its baseline, a constant or a line."""
    offset = float(motion[resting].mean())
    motion, header["acceleration_offset_removed_m_s2"] = motion - offset, f"{offset:.6g}"
    if baseline == "linear":
        ramp = np.maximum(even - even[resting][-1], 0.0)
        slope = float(np.trapezoid(motion, even) / np.trapezoid(ramp, even))
        motion, header["acceleration_slope_removed_m_s3"] = motion - slope * ramp, f"{slope:.6g}"
    return motion
