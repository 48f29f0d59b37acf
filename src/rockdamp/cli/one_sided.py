"""Options of walls that rock to one side, and what the commands print of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from rockdamp.cli.types import Read, quantity

if TYPE_CHECKING:
    import xarray as xr

    from rockdamp.mechanics.curve import TrilinearCurve
    from rockdamp.mechanics.one_sided import OneSidedWall, Tie
    from rockdamp.mechanics.wall import Parapet, Wall

TIE = ("tie_stiffness", "tie_strength", "tie_gap", "tie_height")
SIGNS = ("both", "+", "-")


def _of_ties(text: str, unit: str) -> tuple[float, bool]:
    from rockdamp.mechanics import written_sizes

    return written_sizes.of_ties(text, unit)


STIFFNESS = Read(lambda text: _of_ties(text, "N m-1"), "[N m-1|N m-2]", "one, as 2e6N/m/m of wall, or 2e6N/m in all")
STRENGTH = Read(lambda text: _of_ties(text, "N"), "[N|N m-1]", "one, as 3kN/m of wall, or 3kN in all")


def one_sided_options(command: Any) -> Any:
    """Add the options of a wall that rocks to one side."""
    for option in (
        click.option("--tie-height", type=quantity("m"), help="Height of the ties.  [default: where u is measured]"),
        click.option("--tie-gap", type=quantity("m"), help="Slack of the ties: how far they move before they pull."),
        click.option("--tie-strength", type=STRENGTH, help="Force at which the ties yield, of all of them."),
        click.option("--tie-stiffness", type=STIFFNESS, help="Stiffness of the ties, of all of them."),
        click.option("--one-sided", is_flag=True, help="The wall rocks to one side, away from a stop behind it."),
    ):
        command = option(command)
    return command


def one_sided_wall(options: Mapping[str, Any], wall: Wall | Parapet) -> Any:
    """Return the wall against a stop where --one-sided says so."""
    given = [name for name in TIE if options.get(name) is not None]
    if not options.get("one_sided"):
        if given:
            raise click.UsageError(f"--{given[0].replace('_', '-')} must be given with --one-sided, or not at all")
        return wall
    for other in ("building_period", "diaphragm_period", "top_records", "top_record"):
        if options.get(other):
            name = "--top-record" if "top" in other else f"--{other.replace('_', '-')}"
            raise click.UsageError(f"{name} must be given without --one-sided: the stop moves as the base does")
    from rockdamp.mechanics.one_sided import OneSidedWall

    return OneSidedWall(wall, tie(options, wall) if given else None)


def tie(options: Mapping[str, Any], wall: Wall | Parapet) -> Tie:
    """Return the tie that the options describe."""
    from rockdamp.mechanics.one_sided import tie_of

    for name in ("tie_stiffness", "tie_strength"):
        if options.get(name) is None:
            raise click.UsageError(f"--{name.replace('_', '-')} is missing; a tie must have a stiffness and a strength")
    stiffness, strength, gap, height = (options[name] for name in TIE)
    return tie_of(wall, stiffness, strength, gap or 0.0, height)


def beside(wall: OneSidedWall, curve: TrilinearCurve, restitution: float) -> dict[str, float]:
    """Return the damper at the stop as a program takes it, at u: its spring, dashpot and longest step."""
    from rockdamp.mechanics.one_sided import AT_THE_DISPLACEMENT, CONTACT_STEP, CONTACT_STIFFNESS, Stop

    k1, p = float(curve.initial_stiffness), float(wall.frequency_parameter)
    stop = Stop(CONTACT_STIFFNESS * k1, restitution)
    stiffness = float(stop.stiffness) * float(wall.mechanism.rigid_stiffness) / AT_THE_DISPLACEMENT
    dashpot = float(stop.coefficient) * float(wall.mechanism.rigid_stiffness) / p / AT_THE_DISPLACEMENT
    step = CONTACT_STEP / (p * float(stop.stiffness) ** 0.5)
    return {
        "stop_stiffness": stiffness,
        "stop_damping_ratio": float(stop.damping_ratio),
        "stop_damping_coefficient": dashpot,
        "stop_step": step,
    }


def without_ties(
    wall: OneSidedWall, curve: TrilinearCurve, answer: xr.Dataset, motions: Any
) -> dict[str, float | list[float] | None] | None:
    """Return the answer without the ties, under restitution; None for a wall that has none."""
    if wall.tie is None:
        return None
    from dataclasses import replace
    from math import isfinite

    from rockdamp.assessment.assess import assess

    measure = answer.attrs["intensity_measure"].lower()
    options: dict[str, Any] = {measure: answer[measure].values.tolist(), "tail": float(answer["tail"])}
    bare = assess(replace(wall, tie=None), curve, motions, restitution=float(answer["restitution"]), **options)
    cr = bare.sel(damping_model="CR")
    share, median = cr["collapse_probability"].values.tolist(), float(cr[f"median_{measure}"])
    return {
        "collapse_probability": share[0] if len(share) == 1 else share,
        "median_intensity": median if isfinite(median) else None,
    }


def show_one_sided(
    wall: OneSidedWall, values: Mapping[str, float], bare: Mapping[str, Any] | None, records: int
) -> None:
    """Print what a wall against a stop has beside any other."""
    click.echo(f"\neach record acts both ways, as it is and turned round: {records // 2} records, {records} histories")
    if bare is not None and wall.tie is not None:
        shares = bare["collapse_probability"]
        listed = shares if isinstance(shares, list) else [shares]
        median = bare["median_intensity"]
        without = ", ".join(f"{share:.0%}" for share in listed)
        click.echo(
            f"without the ties: probability of collapse {without}"
            + ("" if median is None else f", median {median:.3g}")
            + f"; with them as above, of {float(wall.tie.strength) / 1000:.3g} kN"
        )
    click.echo(
        "in a program of your own, at the stop and where u is measured: a spring of "
        f"{values['stop_stiffness']:.3g} N/m with a dashpot of {values['stop_damping_coefficient']:.3g} N s/m that act "
        f"in compression alone, and steps of at most {1000 * values['stop_step']:.2g} ms; STOP is this"
    )
    click.echo(
        "CR is solved exactly from impact to impact: what is left open is e, the curve and the ties; "
        "how good the damper at the stop is: docs/one-sided.md"
    )


def constants(wall: OneSidedWall, curve: TrilinearCurve | None, restitution: float | None) -> dict[str, float]:
    """Return what `wall` says of a wall against a stop: its e, its ties, and with a curve the damper at the stop."""
    from rockdamp.mechanics.wall import Parapet

    block = isinstance(wall.mechanism, Parapet)
    values = {"restitution_one_sided": float(wall.restitution_rigid)} if block else {}
    if wall.tie is not None:
        values |= {
            "tie_strength": float(wall.tie.strength),
            "tie_stiffness": float(wall.tie.stiffness),
            "tie_yield_stretch": float(wall.tie.yield_stretch),
        }
    e = restitution if restitution is not None else values.get("restitution_one_sided")
    return values | ({} if curve is None or e is None else beside(wall, curve, e))


def restitution_of(options: Mapping[str, Any], wall: OneSidedWall) -> float:
    """Return e of a wall against a stop; refuse any damper but restitution."""
    from rockdamp.assessment.table import DEFAULT_RULE, restitution_and_reason

    if options["compare"] or options["damping_model"] not in (None, "CR") or options["damping_ratio"] is not None:
        raise click.UsageError(
            "--one-sided takes restitution alone: a damper of the wall, ECD of any order too, damps a wall that starts "
            "from rest at the stop before it has hit it; damp the stop (docs/one-sided.md)"
        )
    stated = options["restitution"]
    e, reason = restitution_and_reason(wall, DEFAULT_RULE if stated is None else stated)
    if stated is None:
        click.echo(f"restitution e = {e:.4g}: {reason}", err=True)
    return e


def respond_one_sided(
    wall: OneSidedWall,
    curve: TrilinearCurve,
    motions: Any,
    asked: Mapping[str, list[float]],
    options: Mapping[str, Any],
    tail: float,
    as_json: bool,
) -> None:
    """Run a wall against a stop under records, both ways unless --sign says which, and print a row for each."""
    from rockdamp.cli.command import print_json, print_table, write_dataset, write_figure, write_table
    from rockdamp.histories.labelled import scales_of
    from rockdamp.histories.one_sided import SIGNS as WAYS
    from rockdamp.histories.one_sided import response

    e, sign = restitution_of(options, wall), options["sign"]
    files = [f"--{name}" for name in ("output", "plot") if options[name] is not None]
    if files and (sign == "both" or len(motions) > 1 or len(next(iter(asked.values()))) > 1):
        raise click.UsageError(f"{files[0]} takes one history; there must be one record, one scale and --sign + or -")
    rows = []
    for motion in motions:
        for scale in scales_of(motion.intensity_record, asked):
            history = response(motion.record, wall, curve, e, scale=float(scale), tail=tail, signs=WAYS[sign])
            for index, way in enumerate(history["sign"].values.tolist()):
                one = history.isel(sign=index)
                fell = bool(one["collapsed"])
                peak = float(one["peak"])
                metres = peak * float(wall.instability_displacement)
                rows.append(
                    {
                        "record": motion.name,
                        "sign": "+" if way > 0 else "-",
                        "scale": float(scale),
                        "peak_displacement": None if fell else metres,
                        "peak": None if fell else peak,
                        "outcome": "collapsed" if fell else "completed",
                        "outcome_elapsed": float(one["outcome_elapsed"]),
                        "impacts": int(one["impacts"]),
                    }
                )
    if options["output"] is not None:
        read = {"records": motions[0].record.digest or motions[0].name, "sign": sign}
        write_dataset(history, options["output"], "one_sided_response", "rockdamp.histories.one_sided", **read)
    if options["plot"] is not None:
        from rockdamp.figures.one_sided import history_figure

        write_figure(history_figure(history), options["plot"])
    if options["table"] is not None:
        write_table(rows, options["table"])
    if as_json:
        print_json(rows)
    else:
        print_table(rows, {"peak_displacement": "m", "outcome_elapsed": "s"})
        if sign == "both":
            click.echo(
                "sign: each record acts as it is, +, and turned round, -; the wall moves away from its stop only"
            )
