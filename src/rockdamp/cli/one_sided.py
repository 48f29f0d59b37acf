"""Options of walls that rock to one side, and what the commands print of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import click

from rockdamp import units
from rockdamp.cli.types import Read, quantity

if TYPE_CHECKING:
    import xarray as xr

    from rockdamp.mechanics.curve import TrilinearCurve
    from rockdamp.mechanics.one_sided import OneSidedWall, Tie
    from rockdamp.mechanics.wall import Parapet, Wall

TIE = ("tie_stiffness", "tie_strength", "tie_gap", "tie_height")
SIGNS = ("both", "+", "-")


def _per_metre(unit: str) -> Callable[[str], tuple[float, bool]]:
    """Return the reader of a quantity of a tie: of all ties of the wall, or by metre of its width."""

    def read(text: str) -> tuple[float, bool]:
        per = {"N m-1": "N m-2", "N": "N m-1"}[unit]
        try:
            return units.quantity(text, per), True
        except units.UnitError:
            return units.quantity(text, unit), False

    def plain(text: str) -> tuple[float, bool]:
        try:
            return units.number(text), False
        except ValueError:
            return read(text)

    return plain


STIFFNESS = Read(_per_metre("N m-1"), "[N m-1|N m-2]", "one, as 2e6N/m/m of wall, or 2e6N/m on its whole width")
STRENGTH = Read(_per_metre("N"), "[N|N m-1]", "one, as 3kN/m of wall, or 3kN on its whole width")


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


def one_sided_wall(options: Mapping[str, Any], wall: Wall | Parapet) -> Wall | Parapet | OneSidedWall:
    """Return the wall against a stop where --one-sided says so."""
    given = [name for name in TIE if options.get(name) is not None]
    if not options.get("one_sided"):
        if given:
            raise click.UsageError(f"--{given[0].replace('_', '-')} must be given with --one-sided, or not at all")
        return wall
    for other in ("building_period", "diaphragm_period", "top_records", "top_record"):
        if options.get(other):
            raise click.UsageError(f"--{other.replace('_', '-')} and --one-sided exclude each other: the stop and the base move alike")
    from rockdamp.mechanics.one_sided import OneSidedWall

    return OneSidedWall(wall, tie(options, wall) if given else None)


def tie(options: Mapping[str, Any], wall: Wall | Parapet) -> Tie:
    """Return the tie that the options describe."""
    from rockdamp.errors import require
    from rockdamp.mechanics.one_sided import Tie

    for name in ("tie_stiffness", "tie_strength"):
        if options.get(name) is None:
            raise click.UsageError(f"--{name.replace('_', '-')} is missing; a tie must have a stiffness and a strength")
    stiffness, strength = (
        value * (float(wall.width) if by_metre else 1.0)
        for value, by_metre in (options["tie_stiffness"], options["tie_strength"])
    )
    level = float(wall.height) if not hasattr(wall, "lower_height") else float(wall.lower_height)
    height = level if options.get("tie_height") is None else options["tie_height"]
    require(0 < height <= level, "--tie-height", height, f"greater than 0 and at most {level:g} m, where u is measured")
    return Tie(stiffness, strength, options.get("tie_gap") or 0.0, height_ratio=height / level)


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
