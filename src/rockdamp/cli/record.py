"""`record`: from a laboratory's raw channels to a record."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from rockdamp.cli.command import Command, concerning, print_json, print_values, write_figure
from rockdamp.cli.options import json_option, with_default
from rockdamp.cli.types import Number, OutputFile, Quantity

UNITS = {"samples": "-", "step": "s", "duration": "s", "peak_acceleration": "m s-2", "peak_displacement": "m"}


@click.command(
    cls=Command,
    examples=[
        "rockdamp record examples/my-test-raw.csv --time t --table-acceleration a:g --wall d1:mm --table d2:mm"
        " --rest 0.2s --synthetic --output my-test.csv --plot my-test.png",
    ],
)
@click.argument("raw", type=click.Path(path_type=Path))
@click.option("--time", required=True, metavar="COLUMN[:UNIT]", help="Column of the time; in s without a unit.")
@click.option("--table-acceleration", metavar="COLUMN:UNIT", help="Column of the supports' acceleration.")
@click.option("--table-velocity", metavar="COLUMN:UNIT", help="Column of the supports' velocity, to differentiate.")
@click.option("--wall", metavar="COLUMN:UNIT", help="Column of the wall's displacement at its hinge.")
@click.option("--table", metavar="COLUMN:UNIT", help="Column of the table's displacement, subtracted from the wall's.")
@with_default("--rest", type=Quantity("s"), default=0.5, help="Rest at the start; zeros are its means.")
@click.option("--lowpass", type=Number(), help="Corner of a low-pass filter without delay, in Hz.")
@click.option("--rate", type=Number(), help="Sampling rate of the record, in Hz.  [default: that of the channels]")
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
def record(raw: Path, output: Path, plot: Path | None, as_json: bool, **options: Any) -> None:
    """Make a record from raw channels of a laboratory.

    RAW is a table of numbers, with or without a line of names; a COLUMN is a name, or a number from 1 on. The header of
    the record states units, filter, resampling, zero and baseline, and that displacements are relative to the table. A
    table of times and velocities is a motion too.
    """
    from rockdamp.motions.laboratory import Channel, laboratory_record, read_raw
    from rockdamp.motions.records import write_record

    channels = {name: options.pop(name) for name in ("time", "table_acceleration", "table_velocity", "wall", "table")}
    usual = {"time": "s"}
    parsed: dict[str, Any] = {
        name: Channel.of(text, usual.get(name, "")) for name, text in channels.items() if text is not None
    }
    table = read_raw(raw)
    with concerning(raw):
        made = laboratory_record(table, **parsed, **options)
    write_record(output, made)
    click.echo(f"{output} written", err=True)
    if plot is not None:
        from rockdamp.figures.record import record_figure

        write_figure(record_figure(made), plot)
    values = {
        "samples": made.elapsed.size,
        "step": made.step,
        "duration": float(made.elapsed[-1]),
        "peak_acceleration": float(abs(made.ground_acceleration).max()),
    }
    if made.displacement is not None:
        values["peak_displacement"] = float(abs(made.displacement).max())
    if as_json:
        print_json(values)
    else:
        print_values(values, UNITS)
