"""`decay` and `respond`: time histories as tables, files and plots."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

import rockdamp as rd
from rockdamp import units
from rockdamp.cli import inputs as build
from rockdamp.cli import options, printing
from rockdamp.cli.command import command, examples
from rockdamp.cli.inputs import Inputs
from rockdamp.cli.options import NUMBER, Quantity, option
from rockdamp.constants import RELEASES

if TYPE_CHECKING:
    import xarray as xr


@command(
    epilog=examples(
        "rockdamp decay --preset moderate --damping-model CDR --damping-ratio 0.05",
        "rockdamp decay --a1 0.04 --b1 0.85 --compare --restitution 0.85 --plot decay.png",
    )
)
@options.curve_options
@options.damping_options
@option(
    "--restitution",
    type=NUMBER,
    help=f"Coefficient of restitution e, from releases at {RELEASES}.",
    section="Damping",
)
@option(
    "--release",
    type=NUMBER,
    default=0.5,
    help="Release amplitude u0/u_ins.",
    section="Free decay",
)
@option(
    "--length",
    type=NUMBER,
    default=20.0,
    help="Length of the history in tau = p t.",
    section="Free decay",
)
@options.output_option(".nc", help="Save the histories as NetCDF.")
@options.plot_option
@options.json_option
def decay(**inputs: Any) -> None:
    """Free decay after a release from rest.

    The table gives the peak of each half cycle, u/u_ins, and, for one damper, its dimensionless
    time tau = p t. `rockdamp wall` prints p, the frequency parameter. In Python,
    rockdamp.free_decay takes a wall and gives metres and seconds.
    """
    curve = build.build_curve(inputs)
    release = inputs["release"]
    e = inputs["restitution"]
    dampings = build.build_dampings(inputs, curve, e, release_amplitude=release)
    histories = rd.free_decay(curve, dampings, release_amplitude=release, length=inputs["length"])
    printing.write_dataset(histories, "free_decay", inputs)
    if inputs["plot"] is not None:
        from rockdamp.figures.commands import decay_figure

        printing.save_plot(decay_figure(histories), inputs["plot"])
    rows = _half_cycle_rows(histories)
    if inputs["as_json"]:
        printing.print_json(rows)
    elif not rows:
        click.echo("No half cycle ends within this length: give a longer --length.")
    elif inputs["compare"]:
        caption = "Peak u/u_ins after each crossing of u = 0, by damper (-: the history has ended):"
        printing.print_table(_side_by_side(rows), caption)
        ratios = [f"{damping.label} {damping.value:.3g}" for damping in dampings[1:]]
        click.echo(f"e = {e:g}; equivalent damping ratios xi: {', '.join(ratios)}")
    else:
        heads = {"damping_model": "damper", "impacts": "crossings", "tau": "tau", "peak": "peak"}
        table = [{head: row[name] for name, head in heads.items()} for row in rows]
        printing.print_table(table, "Peak u/u_ins of each half cycle, at the time tau = p t:")


def _half_cycle_rows(decay: xr.Dataset) -> list[dict[str, Any]]:
    """Return peak, time and impacts before of each half cycle that ends, the release first."""
    from math import isnan

    from rockdamp.histories.half_cycles import LEAST_PEAK, half_cycles

    rows = []
    for model in decay["damping_model"].values:
        displacement = decay["displacement"].sel(damping_model=model).values
        cycles = half_cycles(decay["tau"].values, displacement, LEAST_PEAK)
        peaks = zip(cycles.peak, cycles.peak_elapsed, cycles.end, strict=True)
        for impacts, (peak, tau, end) in enumerate(peaks):
            if not isnan(end):
                row = {"damping_model": str(model), "impacts": impacts}
                rows.append(row | {"tau": float(tau), "peak": abs(float(peak))})
    return rows


def _side_by_side(rows: list[dict[str, Any]]) -> list[dict[Any, Any]]:
    """Return a row for each number of crossings before the peak, with a column for each model."""
    import pandas as pd

    models = list(dict.fromkeys(row["damping_model"] for row in rows))
    table = pd.DataFrame(rows).pivot_table(index="impacts", columns="damping_model", values="peak")
    return table[models].rename_axis("crossings").reset_index().to_dict("records")


@command(
    epilog=examples(
        "rockdamp respond --record data/sin-03-00-synthetic.csv --thickness 102mm \\",
        "    --height 2.754m --overburden-ratio 6.2 --a1 0.03 --b1 0.8 --restitution 0.85 \\",
        "    --compare --plot response.png",
        'rockdamp respond --records "fema-p695:far-field/[1-3]/*" --thickness 0.3 --height 3 \\',
        "    --preset new --restitution measured --to-pgv 20cm/s,40cm/s --output peaks.csv",
        "rockdamp respond --record fema-p695:far-field/1/a --thickness 0.3 --height 2 --parapet \\",
        "    --preset new --damping-model BAND --restitution 0.9 --to-pga 0.3g",
    ),
)
@options.motion_options
@options.wall_options()
@options.one_sided_option
@options.curve_options
@options.damping_options
@options.restitution_option()
@options.motion_option(
    "--scale",
    type=Quantity(several=True),
    help="Factor on the accelerations, or several factors.  [default: 1]",
)
@options.motion_option(
    "--to-pga",
    type=Quantity("m s-2", several=True),
    help="PGA to scale each record to; alternative to --scale.",
)
@options.motion_option(
    "--to-pgv",
    type=Quantity("m s-1", several=True),
    help="PGV to scale each record to; alternative to --scale.",
)
@options.tail_option(0.0)
@options.support_options
@options.output_option(
    ".csv", ".nc", help="Save the rows as CSV, or the histories of one record as NetCDF."
)
@options.plot_option
@options.json_option
def respond(**inputs: Any) -> None:
    """Response of a wall to records, from rest: peak and outcome.

    The table has a row for each record, scale and damper. A wall that collapses has no peak. PGA
    and PGV are those of the scaled motion; with a building or a flexible floor, those of the
    ground. With --one-sided, each record acts in both directions.
    """
    wall = build.build_wall(inputs)
    curve = build.build_curve(inputs)
    target = _target(inputs)
    rule = inputs["restitution"]
    e: float | None = None
    reason = ""
    if rule is not None or inputs["one_sided"]:
        e, reason = build.choose_restitution(wall, "measured" if rule is None else rule)
    dampings = build.build_dampings(inputs, curve, e)
    motions = build.read_support_motions(inputs)
    one_history = len(motions) == len(next(iter(target.values()))) == 1 and not inputs["one_sided"]
    if _saves_histories(inputs) and not one_history:
        raise click.UsageError(
            "--plot and .nc output need one record and one scale, and exclude --one-sided"
        )
    rows = _respond_rows(inputs, motions, wall, curve, dampings, target)
    if _saves_histories(inputs):
        scale = rows[0]["scale"]
        histories = rd.respond(wall, curve, dampings, motions[0], scale=scale, tail=inputs["tail"])
        records = printing.digests(motions)
        printing.write_dataset(histories, "response", inputs, records=records, scale=scale)
        _save_plot(histories, motions[0].name, inputs)
    if inputs["output"] is not None and inputs["output"].suffix == ".csv":
        printing.write_csv(rows, inputs["output"])
    if inputs["as_json"]:
        one_row = one_history and len(dampings) == 1
        printing.print_json(rows[0] if one_row else rows)
        return
    click.echo(printing.describe_records(motions))
    on_floors = bool(build.build_supports(inputs))
    click.echo(printing.describe_wall(wall, curve, e, reason, on_floors=on_floors))
    click.echo()
    printing.print_table(
        _printed_rows(rows, inputs), "Response to each record, from rest, with each damper:"
    )


def _target(inputs: Inputs) -> dict[str, list[float]]:
    """Return the factors, or the PGA or PGV that the records are scaled to."""
    names = {"scale": "scale", "to_pga": "pga", "to_pgv": "pgv"}
    targets = {names[name]: inputs[name] for name in names if inputs[name] is not None}
    if len(targets) > 1:
        raise click.UsageError("give one of --scale, --to-pga and --to-pgv")
    return targets or {"scale": [1.0]}


def _saves_histories(inputs: Inputs) -> bool:
    output = inputs["output"]
    return inputs["plot"] is not None or (output is not None and output.suffix == ".nc")


def _respond_rows(
    inputs: Inputs,
    motions: Any,
    wall: Any,
    curve: rd.TrilinearCurve,
    dampings: list[rd.Damping],
    target: dict[str, list[float]],
) -> list[dict[str, Any]]:
    """Return a row for each record, scale and damper; a collapse has no peak."""
    from rockdamp.histories.one_sided import respond_one_sided
    from rockdamp.histories.respond import tabulate
    from rockdamp.mechanics.specimen import Specimen

    tail = inputs["tail"]
    if not inputs["one_sided"]:
        rows = list(tabulate(motions, wall, curve, dampings, target, tail))
    elif [damping.label for damping in dampings] == ["CR"]:
        specimen = Specimen(wall, curve, dampings[0])
        rows = list(respond_one_sided(motions, specimen, target, tail))
    else:
        raise click.UsageError(
            "--one-sided needs restitution (CR); omit --compare and viscous dampers"
        )
    build.warn_of_rest(max(row["peak"] for row in rows), curve)
    for row in rows:
        if row["outcome"] == "collapsed":
            row |= dict.fromkeys(("peak_displacement", "peak", "peak_elapsed"))
    return rows


def _save_plot(histories: xr.Dataset, record_name: str, inputs: Inputs) -> None:
    if inputs["plot"] is not None:
        from rockdamp.figures.commands import response_figure

        if histories.attrs["record_source"] == "not stated":
            histories = histories.assign_attrs(record_source=record_name)
        printing.save_plot(response_figure(histories), inputs["plot"])


def _printed_rows(rows: list[dict[str, Any]], inputs: Inputs) -> list[dict[str, Any]]:
    """Return the rows that are printed: PGA and PGV in the units asked for, peaks in mm."""
    pga_unit = "g" if inputs["to_pga"] is None else inputs["to_pga"].unit
    pgv_unit = "m/s" if inputs["to_pgv"] is None else inputs["to_pgv"].unit
    pga_size = units.quantity(f"1 {pga_unit}", "m s-2")
    pgv_size = units.quantity(f"1 {pgv_unit}", "m s-1")
    printed = []
    for row in rows:
        peak = row["peak_displacement"]
        printed.append(
            {
                "record": row["record"],
                f"PGA [{pga_unit}]": row["pga"] / pga_size,
                f"PGV [{pgv_unit}]": row["pgv"] / pgv_size,
                "damper": row["damping_model"],
                "xi": row["damping_ratio"],
                "peak [mm]": None if peak is None else 1000 * peak,
                "peak/u_ins": row["peak"],
                "outcome": row["outcome"],
            }
        )
    return printed
