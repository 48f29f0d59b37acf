"""`wall` and `equivalent`: constants of a wall, without a history."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rockdamp.cli.assessment import show_damping
from rockdamp.cli.command import (
    NUMBER,
    SOME_FAILED,
    Command,
    OutputFile,
    Quantity,
    print_json,
    print_table,
    print_values,
    write_table,
)
from rockdamp.cli.options import (
    CURVE,
    RESTITUTION,
    RESTITUTION_MEANT,
    WALL,
    curve_options,
    json_option,
    make_curve,
    make_optional_wall,
    make_wall,
    refuse_unused,
    strict_option,
    table_of_walls,
    tell_overburden,
    wall_options,
    with_default,
)
from rockdamp.constants import STANDARD_GRAVITY

if TYPE_CHECKING:
    from rockdamp.equivalence.programs import ProgramInput
    from rockdamp.mechanics.curve import TrilinearCurve
    from rockdamp.mechanics.wall import Parapet, Wall

KEYS = (
    "weight",
    "effective_mass",
    "excitation_factor",
    "rigid_strength",
    "rigid_stiffness",
    "instability_displacement",
    "frequency_parameter",
    "restitution_rigid",
    "restitution_impulsive",
    "restitution_measured",
)
HINGE = ("hinge_ratio", "weakest_hinge_ratio")  # of a wall, which a parapet has not
UNITS = {
    "weight": "N",
    "effective_mass": "kg",
    "rigid_strength": "N",
    "rigid_stiffness": "N m-1",
    "instability_displacement": "m",
    "frequency_parameter": "rad s-1",
    "displacement": "m",
    "rigid_period": "s",
    "period": "s",
    "rocking_onset": "m s-2",
    "initial_frequency": "rad s-1",
    "initial_period": "s",
}
AMPLITUDES = tuple(tenths / 10 for tenths in range(1, 10))


@click.command(
    cls=Command,
    examples=[
        "rockdamp wall --thickness 0.3 --height 4.5 --overburden-ratio 2",
        "rockdamp wall --thickness 102mm --height 2.75m --preset moderate",
        'rockdamp wall --thickness 12in --height 15ft --density "112 lb/ft^3"',
    ],
)
@wall_options()
@curve_options
@click.option("--amplitude", type=Quantity(several=True), help="Amplitudes u0/u_ins of the periods.")
@click.option(
    "--restitution",
    type=RESTITUTION,
    help=f"{RESTITUTION_MEANT}, or a rule for it.  [default: measured]",
)
@json_option
def wall(amplitude: list[float] | None, as_json: bool, **options: Any) -> None:
    """Constants of a wall's motion, onset of rocking, restitution, periods.

    Restitution is printed by each formula, with its source; one is recommended. Periods are printed for several
    amplitudes. With a curve (--a1 and --b1, or --preset) the periods of the cracked wall stand beside those of the
    rigid one, rocking starts at the strength of the plateau, and there is viscous damping to type into a program, for
    one e. The JSON holds the constants and their units, and with --amplitude the periods; restitution_impulsive is null
    with --overburden-mass.
    """
    from rockdamp.assessment.table import DEFAULT_RULE, restitution_and_reason

    built = make_wall(options)
    keys = (*KEYS, *HINGE) if hasattr(built, "hinge_ratio") else KEYS
    values = {key: float(getattr(built, key)) for key in keys}
    curve = None
    if any(options[name] is not None for name in ("a1", "b1", "preset")):
        curve = make_curve(options)
    else:
        refuse_unused(("a3", "softening", "restitution"), "--a1 and --b1, or --preset")
    values["rocking_onset"] = float(built.rocking_onset(1.0 if curve is None else curve.strength_ratio))
    in_g = values["rocking_onset"] / STANDARD_GRAVITY
    rows = _periods(built, curve, AMPLITUDES if amplitude is None else amplitude, strict=amplitude is not None)
    typed, of_curve, e = None, (0.0, 0.0), 0.0
    if curve is not None:
        from rockdamp.assessment.collapses import LEAST_OF_DAMPER
        from rockdamp.equivalence.programs import frequencies, program_inputs

        e, _ = restitution_and_reason(built, options["restitution"] or DEFAULT_RULE)
        of_curve = frequencies(built, curve)
        values |= dict(zip(("initial_frequency", "initial_period"), of_curve, strict=True))
        e = max(e, LEAST_OF_DAMPER)
        typed = program_inputs(built, curve, e)
    restitutions = _restitutions(built)
    if as_json:
        damping = {} if typed is None else _damping(typed, e)
        periods = {} if amplitude is None else {"periods": rows}
        units_of = {key: UNITS.get(key, "1") for key in (*values, *(rows[0] if periods else ()))}
        units_of |= {"rocking_onset_g": "g"} | ({"damping_coefficient": "N s m-1"} if damping else {})
        more = {"restitutions": restitutions, "units": units_of, **damping, **periods}
        numbers = {key: None if isnan(value) else value for key, value in values.items()}
        print_json({**numbers, "rocking_onset_g": in_g, **more})
        return
    constants = {key: value for key, value in values.items() if not key.startswith("restitution")}
    print_values(constants, UNITS | {"rocking_onset": f"m s-2, which is {in_g:.4g} g"})
    tell_overburden(built)
    click.echo()
    for row in restitutions:
        recommended = " (recommended)" if row["recommended"] else ""
        click.echo(f"{'restitution':26s} {row['restitution']:10.5g}  {row['reason']}{recommended}")
    click.echo()
    print_table(rows, UNITS)
    if typed:
        show_damping(typed, of_curve, e)


def _damping(typed: list[ProgramInput], e: float) -> dict[str, Any]:
    """Return the dampers for the JSON; C by itself for each that can be a dashpot."""
    constant = {row.damping_model: row.damping_coefficient for row in typed if row.damping_coefficient}
    return {"damping_restitution": e, "damping_coefficient": constant, "damping": list(map(asdict, typed))}


def _restitutions(wall: Wall | Parapet) -> list[dict[str, Any]]:
    """Return e by each rule, and what it rests on; the rule that is taken where none is stated is recommended."""
    from rockdamp.assessment.table import DEFAULT_RULE, RULES, by_rule

    rows: dict[str, dict[str, Any]] = {}
    for rule in RULES:
        if rule == "impulsive" and isnan(wall.restitution_impulsive):  # of a mass on the wall
            continue
        e, reason = by_rule(wall, rule)  # of a parapet the same by every rule
        row = {"rule": rule, "restitution": float(e), "reason": reason, "recommended": rule == DEFAULT_RULE}
        if not e > 0:
            row["reason"] = f"{reason}: they stop the wall, which does not rock on"
        rows.setdefault(reason, row)
    return list(rows.values())


def _periods(
    wall: Wall | Parapet, curve: TrilinearCurve | None, amplitudes: Iterable[float], strict: bool
) -> list[dict[str, float]]:
    """Return the rows of periods; unless `strict`, amplitudes beyond the end of the curve are left out."""
    import numpy as np

    from rockdamp.errors import check

    rows = []
    for x0 in amplitudes:
        check("release_amplitude", x0, lambda x0: (x0 > 0) & (x0 < 1), "greater than 0 and less than 1")
        if curve is not None and not strict and x0 >= float(curve.ultimate_displacement_ratio):
            continue
        row = {
            "amplitude": x0,
            "displacement": x0 * float(wall.instability_displacement),
            "rigid_period": float(4 * np.arccosh(1 / (1 - x0)) / wall.frequency_parameter),
        }
        if curve is not None:
            row["period"] = float(curve.period(x0) / wall.frequency_parameter)
        rows.append(row)
    return rows


@click.command(
    "equivalent",
    cls=Command,
    examples=[
        "rockdamp equivalent --restitution 0.85 --a1 0.04 --b1 0.85",
        "rockdamp equivalent --restitution 0.80,0.85,0.90 --preset moderate --json",
        "rockdamp equivalent --walls examples/my-walls.csv --output ratios.csv",
    ],
)
@click.option("--restitution", type=Quantity(several=True), help=f"{RESTITUTION_MEANT}.")
@curve_options
@with_default("--release", type=NUMBER, default=0.5, help="Release amplitude u0/u_ins.")
@click.option("--response-length", type=NUMBER, help="Length of the matched response in tau = p t.  [default: 8]")
@click.option("--walls", type=click.Path(path_type=Path), metavar="FILE", help="Table of walls, in place of one wall.")
@click.option("--output", type=OutputFile(".csv"), help="Write the damping ratios of --walls.")
@strict_option
@wall_options(required=False)
@json_option
def equivalent_command(
    restitution: list[float] | None, release: float, walls: Path | None, as_json: bool, **options: Any
) -> None:
    """Damping ratios equivalent to a restitution.

    Print one row for each coefficient of restitution and viscous model. damping_ratio has the least error (Eq. 17): use
    it. damping_ratio_energy is the closed form: it differs most for CDC, where it errs more under earthquakes.
    With --thickness and --height a row has C too, if that is constant. Of a table of walls, in the format of batch, the
    ratios of least error are searched on all cores; 3 000 walls take less than a minute of one. Where a wall
    has none, the column error says why. No one ratio stands for a loss that depends on the amplitude: decay and
    respond take its --exponent.
    """
    if walls is not None:
        refuse_unused(("restitution", *CURVE, *WALL), "one wall, without --walls (whose table has a column for it)")
        refuse_unused(("response_length",), "one wall, without --walls")
        _of_walls(walls, release, as_json, options)
        return
    refuse_unused(("output", "strict"), "--walls")
    if restitution is None:
        raise click.UsageError("there must be --restitution and a curve, or --walls")
    from rockdamp.constants import DEFAULT_RESPONSE_LENGTH
    from rockdamp.equivalence.equivalent import equivalent
    from rockdamp.equivalence.polynomials import SHIPPED_STRENGTH_RATIO

    curve, built = make_curve(options), make_optional_wall(options)
    length = DEFAULT_RESPONSE_LENGTH if options["response_length"] is None else options["response_length"]
    rows = equivalent(restitution, curve, release_amplitude=release, response_length=length)
    if built is not None:
        from rockdamp.equivalence.programs import advice, dashpot, frequencies

        for row in rows:
            row["damping_coefficient"] = dashpot(built, curve, row["damping_model"], row["damping_ratio"])
    if as_json:
        print_json(rows)
        return
    print_table(rows, {"damping_coefficient": "N s m-1"})
    if built is not None:
        w1, period = frequencies(built, curve)
        click.echo(f"\nw1 = {w1:.4g} rad s-1, T1 = {period:.4g} s; -, damping_coefficient: C is not constant")
        click.echo(advice(restitution[0]))
    if any(row["damping_ratio_fit"] is None for row in rows):
        click.echo(
            "\n-, damping_ratio_fit: outside the range of the polynomials (a1 or e), or the damper has none", err=True
        )
    if curve.strength_ratio != SHIPPED_STRENGTH_RATIO:
        stated = f"damping_ratio_fit is that of b1 = {SHIPPED_STRENGTH_RATIO:g}, not of {float(curve.strength_ratio):g}"
        click.echo(f"\n{stated}", err=True)


def _of_walls(walls: Path, release: float, as_json: bool, options: dict[str, Any]) -> None:
    """Write or print the damping ratios of a table of walls."""
    from rockdamp.assessment.answers import RATIO_COLUMNS, ratios
    from rockdamp.errors import InputError

    output = options["output"]
    rows = list(ratios(table_of_walls(walls), release))
    if all(row["damping_ratio"] is None for row in rows):
        raise InputError(f"{walls}: {rows[0]['error']}")
    if output is not None:
        write_table(rows, output, RATIO_COLUMNS)
    if as_json:
        print_json(rows)
    elif output is None:
        print_table(rows)
    failed = sum(row["damping_ratio"] is None for row in rows)
    if failed:
        click.echo(f"{failed} of {len(rows)} damping ratios were not found; the column error says why", err=True)
        if options["strict"]:
            click.get_current_context().exit(SOME_FAILED)
