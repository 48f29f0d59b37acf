"""`record`: from a laboratory's raw channels to a record."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rockdamp import units
from rockdamp.cli.command import (
    NUMBER,
    Command,
    OutputFile,
    Read,
    concerning,
    print_json,
    print_values,
    quantity,
    write_figure,
)
from rockdamp.cli.options import json_option, was_given, with_default

if TYPE_CHECKING:
    from rockdamp.laboratory.releases import FreeRocking
    from rockdamp.motions.records import Record

CHANNELS = ("table_acceleration", "table_velocity", "wall", "table")
SHARED = ("lowpass", "rate", "specimen", "source", "synthetic")
OF_RECORDS = ("table_acceleration", "table_velocity", "table", "rest", "baseline")
OF_FREE_ROCKING = ("rotation", "frame_rate", "scale")
MILLI = 1000.0
UNITS = {  # as printed; JSON is in SI throughout
    "samples": "-",
    "samples_filled": "-",
    "step": "s",
    "duration": "s",
    "peak_acceleration": "m s-2",
    "peak_displacement": "m",
    "acceleration_offset_removed": "m s-2",
    "displacement_offset_removed": "mm",
    "lowest_displacement": "m",
    "highest_displacement": "m",
    "lowest_rotation": "rad",
    "highest_rotation": "rad",
}


def _scale(text: str) -> float:
    """Return the size of a pixel. [m]"""
    size = units.quantity(text.strip().removesuffix("px").rstrip("/ "), "m")
    if not size > 0 or not text.strip().endswith("px"):
        raise ValueError(f"{text!r} is no size of a pixel")
    return size


SCALE = Read(_scale, "[m/px]", "a length for each pixel, as 0.35mm/px")


@click.command(
    cls=Command,
    examples=[
        "rockdamp record examples/my-test-raw.csv --time t --table-acceleration a:g --wall d1:mm --table d2:mm"
        " --rest 0.2s --synthetic --output my-test.csv --plot my-test.png",
        "rockdamp record examples/my-free-rocking-raw.csv --free-rocking --time t:ms --wall d:mm --synthetic"
        " --output my-free-rocking.csv",
    ],
)
@click.argument("raw", type=click.Path(path_type=Path))
@click.option("--time", metavar="COLUMN[:UNIT]", help="Column of the time; in s without a unit.")
@click.option("--table-acceleration", metavar="COLUMN:UNIT", help="Column of the supports' acceleration.")
@click.option("--table-velocity", metavar="COLUMN:UNIT", help="Column of the supports' velocity, to differentiate.")
@click.option("--wall", metavar="COLUMN:UNIT", help="Column of the wall's displacement at its hinge.")
@click.option("--table", metavar="COLUMN:UNIT", help="Column of the table's displacement, subtracted from the wall's.")
@with_default("--rest", type=quantity("s"), default=0.5, help="Rest at the start; zeros are its means.")
@click.option("--free-rocking", is_flag=True, help="Make a pull-and-release test, without a motion of the ground.")
@click.option("--rotation", metavar="COLUMN:UNIT", help="With --free-rocking: column of the rotation, as r:deg.")
@click.option("--frame-rate", type=NUMBER, help="With --free-rocking: frames per second of a video, for --time.")
@click.option("--scale", type=SCALE, help="With --free-rocking: size of a pixel of a video, for --wall x:px.")
@click.option("--lowpass", type=NUMBER, help="Corner of a low-pass filter without delay, in Hz.")
@click.option("--rate", type=NUMBER, help="Sampling rate of the record, in Hz.  [default: that of the channels]")
@with_default(
    "--baseline",
    type=click.Choice(["constant", "linear", "none"]),
    default="constant",
    help="Subtract from the acceleration its mean at rest, a line, or nothing.",
)
@click.option("--specimen", default="not stated", help="Specimen that the header names.")
@click.option("--source", default="not stated", help="Source that the header names.")
@click.option("--synthetic", is_flag=True, help="State in the header that the channels were computed.")
@click.option("--output", type=OutputFile(".csv"), required=True, help="Write the record.")
@click.option("--plot", type=OutputFile(".png", ".pdf", ".svg"), help="Draw the record.")
@json_option
def record(raw: Path, output: Path, plot: Path | None, as_json: bool, free_rocking: bool, **options: Any) -> None:
    """Make a record, or a free-rocking test, from raw channels of a laboratory.

    RAW is a table of numbers, with or without a line of names; a COLUMN is a name, or a number from 1 on. The header of
    the record states units, filter, resampling, zero and baseline, and that displacements are relative to the table. A
    table of times and velocities is a motion too. A free-rocking test has the displacement of the wall or its rotation
    alone; its zero is not taken off, as the fit finds it. Of a video it may be in pixels, and up to five samples in a
    row may be missing: they are filled, and counted.
    """
    if options["time"] is None and not (free_rocking and options["frame_rate"] is not None):
        raise click.UsageError("--time is missing; a video's --frame-rate, with --free-rocking, stands in its place")
    from rockdamp.laboratory.channels import Channel, laboratory_free_rocking, laboratory_record, read_raw
    from rockdamp.laboratory.releases import write_free_rocking
    from rockdamp.motions.records import write_record

    for name in OF_RECORDS if free_rocking else OF_FREE_ROCKING:
        if was_given(name):
            option = "--" + name.replace("_", "-")
            where = "a test with ground motion; --free-rocking must be without it" if free_rocking else "--free-rocking"
            raise click.UsageError(f"{option} belongs to {where}")
    names = ("wall", "rotation") if free_rocking else CHANNELS
    channels = {name: options[name] for name in ("time", *names)}
    own = ("frame_rate", "scale") if free_rocking else ("rest", "baseline")
    settings = {name: options[name] for name in (*SHARED, *own)}
    usual = {"time": "s"}
    parsed: dict[str, Any] = {
        name: Channel.from_text(text, usual.get(name, "")) for name, text in channels.items() if text is not None
    }
    table = read_raw(raw, gaps=free_rocking)
    with concerning(raw):
        make: Any = laboratory_free_rocking if free_rocking else laboratory_record
        made = make(table, **parsed, **settings)
    write: Any = write_free_rocking if free_rocking else write_record
    write(output, made)
    click.echo(f"{output} written", err=True)
    if plot is not None:
        from rockdamp.laboratory.figures import record_figure

        write_figure(record_figure(made), plot)
    values = {"samples": made.elapsed.size, "step": made.step, "duration": float(made.elapsed[-1] - made.elapsed[0])}
    values |= _of_free_rocking(made) if free_rocking else _of_record(made)
    if as_json:
        print_json(values)
    else:
        if "displacement_offset_removed" in values:
            values["displacement_offset_removed"] *= MILLI
        print_values(values, UNITS)


def _of_free_rocking(made: FreeRocking) -> dict[str, float]:
    kind = "displacement" if made.rotation is None else "rotation"
    filled = {"samples_filled": int(made.header["samples_filled"])} if "samples_filled" in made.header else {}
    return filled | {f"lowest_{kind}": float(made.measured.min()), f"highest_{kind}": float(made.measured.max())}


def _of_record(made: Record) -> dict[str, float | str]:
    values: dict[str, float | str] = {"peak_acceleration": float(abs(made.ground_acceleration).max())}
    removed = {
        "acceleration_offset_removed": "acceleration_offset_removed_m_s2",
        "displacement_offset_removed": "zero_removed_m",
    }
    if made.displacement is not None:
        values["displacement"] = made.header["displacement"]
        values["peak_displacement"] = float(abs(made.displacement).max())
    return values | {name: float(made.header[key]) for name, key in removed.items() if key in made.header}
