"""`wall` and `equivalent`: properties of a wall and equivalent damping ratios."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

import rockdamp as rd
from rockdamp.cli import inputs as build
from rockdamp.cli import options, printing
from rockdamp.cli.command import command, examples
from rockdamp.cli.options import NUMBER, RULE_WORDS, Quantity, option
from rockdamp.constants import RELEASES

# The constants of a wall: label, printed unit, and its size in SI.
WALL_LINES = {
    "weight": ("weight W", "kN", 1000.0),
    "effective_mass": ("effective mass m_eff", "kg", 1.0),
    "excitation_factor": ("excitation factor lambda", "-", 1.0),
    "rigid_strength": ("strength of rigid blocks F0", "kN", 1000.0),
    "rigid_stiffness": ("slope of the falling branch K0", "kN/m", 1000.0),
    "instability_displacement": ("instability displacement u_ins", "mm", 0.001),
    "frequency_parameter": ("frequency parameter p", "rad/s", 1.0),
    "rocking_onset": ("acceleration that starts rocking", "m/s2", 1.0),
}
PERIOD_AMPLITUDES = (0.1, 0.3, 0.5, 0.7, 0.9)
RATIO_HEADS = {
    "id": "wall",
    "restitution": "e",
    "damping_model": "damper",
    "damping_ratio": "xi",
    "rms_error": "rms error [u/u_ins]",
    "damping_ratio_energy": "xi by the closed form",
    "damping_ratio_fit": "xi by the polynomial (b1 = 0.85)",
}
ONE_SIDED = (
    "a one-sided wall has no damping ratio: a viscous damper would damp it before its first impact"
)


@command(
    epilog=examples(
        "rockdamp wall --thickness 0.3 --height 4.5 --overburden-ratio 2",
        "rockdamp wall --thickness 102mm --height 2.75m --preset moderate",
        "rockdamp wall --thickness 12in --height 13ft --hinge-ratio weakest --overburden 12kN/m",
    )
)
@options.wall_options()
@options.curve_options
@options.restitution_option()
@options.json_option
def wall(**inputs: Any) -> None:
    """Properties of a wall: constants, restitution and periods.

    With a curve (--preset, or --a1 and --b1) it also lists the viscous dampers that can replace one
    e, by default that of the rule "measured": the damping ratio xi of each, the share of collapses
    that it missed in our study of eight walls, and for CDC the coefficient C and OpenSees' alphaM.
    """
    restitution = inputs["restitution"]
    has_curve = any(inputs[name] is not None for name in ("preset", "a1", "b1"))
    if restitution is not None and not has_curve:
        raise click.UsageError("--restitution needs a curve: add --preset, or --a1 and --b1")
    body = build.build_wall(inputs)
    curve = build.build_curve(inputs) if has_curve else None
    values = _wall_values(body, curve)
    periods = _period_rows(body, curve)
    damping: dict[str, Any] = {}
    if curve is not None:
        from rockdamp.equivalence.programs import describe_damping

        rule = "measured" if restitution is None else restitution
        e, _ = build.choose_restitution(body, rule)
        damping = describe_damping(body, curve, e)
    if inputs["as_json"]:
        printing.print_json(values | {"periods": periods} | damping)
        return
    click.echo(printing.describe_wall(body, curve))
    _print_constants(body, values)
    _print_restitutions(body, values)
    _print_periods(periods)
    if damping:
        _print_damping(damping, float(body.width))


def _wall_values(body: Any, curve: rd.TrilinearCurve | None) -> dict[str, float]:
    """Return the constants of a wall by name; e of a rule is NaN where it is not known."""
    strength_ratio = 1.0 if curve is None else curve.strength_ratio
    hinges = [name for name in ("hinge_ratio", "weakest_hinge_ratio") if hasattr(body, name)]
    rules = [f"restitution_{rule}" for rule in RULE_WORDS]
    values = {}
    for name in (*WALL_LINES, *rules, *hinges):
        if name == "rocking_onset":
            values[name] = float(body.rocking_onset(strength_ratio))
        else:
            values[name] = float(getattr(body, name))
    return values


def _period_rows(body: Any, curve: rd.TrilinearCurve | None) -> list[dict[str, Any]]:
    """Return the periods of free vibration from several amplitudes, up to the end of the curve."""
    from rockdamp.mechanics.free_motion import rigid_period

    p = body.frequency_parameter
    rows = []
    for amplitude in PERIOD_AMPLITUDES:
        row = {"amplitude": amplitude, "rigid_period": rigid_period(amplitude) / p}
        if curve is None:
            rows.append(row)
        elif amplitude < curve.ultimate_displacement_ratio:
            rows.append(row | {"period": curve.period(amplitude) / p})
    return rows


def _print_constants(body: Any, values: dict[str, float]) -> None:
    click.echo(f"\nConstants of {float(body.width):g} m of wall:")
    for name, (label, unit, size) in WALL_LINES.items():
        click.echo(f"  {label:34s}{printing.cell(values[name] / size):>8s} {unit}")


def _print_restitutions(body: Any, values: dict[str, float]) -> None:
    click.echo("\nCoefficient of restitution e, by rule:")
    is_parapet = isinstance(body, rd.Parapet)
    for rule in ["every rule"] if is_parapet else RULE_WORDS:
        name = "measured" if is_parapet else rule
        e = values[f"restitution_{name}"]
        reason = "not known for an overburden with mass"
        if e == e:  # not NaN
            reason = build.choose_restitution(body, name)[1].partition(": ")[2]
        click.echo(f"  {rule:34s}{printing.cell(e):>8s}  ({reason})")


def _print_periods(periods: list[dict[str, Any]]) -> None:
    heads = {
        "amplitude": "u0/u_ins",
        "rigid_period": "rigid body [s]",
        "period": "tri-linear curve [s]",
    }
    rows = [{heads[name]: value for name, value in row.items()} for row in periods]
    click.echo()
    printing.print_table(
        rows, "Period of free vibration at the amplitude u0 (rigid body: without the first branch):"
    )


def _print_damping(damping: dict[str, Any], width: float) -> None:
    click.echo()
    printing.print_dampers(damping, damping["damping"])
    click.echo(
        f"CDC for {width:g} m of wall: C = {damping['damping_coefficient']:.4g} N s/m; in OpenSees"
        f" rayleigh {damping['rayleigh_alpha_m']:.4g} 0 0 0 (alphaM = 2 xi w1), if m_eff is the"
        " only mass of the model"
    )


@command(
    epilog=examples(
        "rockdamp equivalent --restitution 0.85 --a1 0.04 --b1 0.85",
        "rockdamp equivalent --damping-ratio 5% --preset moderate",
        "rockdamp equivalent --walls examples/my-walls.csv --output ratios.csv",
    ),
)
@option(
    "--restitution",
    type=Quantity(several=True),
    help=f"Coefficient of restitution e, from releases at {RELEASES}, or several.",
    section="Damping",
)
@option(
    "--damping-ratio",
    type=NUMBER,
    help="Damping ratio xi to convert to e; alternative to --restitution.",
    section="Damping",
)
@options.curve_options
@option(
    "--release",
    type=NUMBER,
    default=0.5,
    help="Release amplitude u0/u_ins.",
    section="Free decay",
)
@option(
    "--walls",
    type=options.INPUT_FILE,
    metavar="FILE",
    help="Table of walls, as for batch; alternative to one e and curve.",
    section="Wall",
)
@options.output_option(".csv", help="Save the rows as CSV.")
@options.json_option
def equivalent(**inputs: Any) -> None:
    """Damping ratios equivalent to a coefficient of restitution, or vice versa.

    The table has a row for each e and viscous damper. Use the column xi: it has the smallest error
    in free decay, Eq. (17) of the paper. Two more columns give xi by the closed form and by the
    polynomials, which are fitted for b1 = 0.85 and empty outside their range of a1 and e.
    """
    e = inputs["restitution"]
    xi = inputs["damping_ratio"]
    walls = inputs["walls"]
    release = inputs["release"]
    if [e, xi, walls].count(None) != 2:
        raise click.UsageError("give exactly one of --restitution, --damping-ratio and --walls")
    if walls is not None:
        rows = _equivalent_walls(walls, release)
    elif xi is not None:
        rows = _equivalent_restitutions(xi, build.build_curve(inputs), release)
    else:
        rows = rd.equivalent(e, build.build_curve(inputs), release_amplitude=release)
    if inputs["output"] is not None:
        printing.write_csv(rows, inputs["output"])
    if inputs["as_json"]:
        printing.print_json(rows)
        return
    _print_ratios(rows, release)


def _equivalent_restitutions(
    xi: float, curve: rd.TrilinearCurve, release: float
) -> list[dict[str, Any]]:
    """Return the e that a damping ratio stands for, by damper; there must be one."""
    from rockdamp.equivalence.equivalent import equivalent_restitution

    rows = equivalent_restitution(xi, curve, release_amplitude=release)
    if not any(row["restitution"] for row in rows):
        raise click.UsageError(
            f"--damping-ratio is {xi:g}; it must correspond to an e from 0.60 to 0.99"
            f" (for {xi:g} % write {xi:g}%)"
        )
    return rows


def _equivalent_walls(path: Path, release: float) -> list[dict[str, Any]]:
    """Return the damping ratios of each wall of a table by its id, or why it has none."""
    from rockdamp.assessment.table import BadRow, read_walls

    rows: list[dict[str, Any]] = []
    for row in read_walls(path):
        if isinstance(row, BadRow):
            rows.append({"id": row.id, "error": row.error})
        elif isinstance(row.wall, rd.OneSidedWall):
            rows.append({"id": row.id, "error": ONE_SIDED})
        else:
            answers = rd.equivalent(row.restitution, row.curve, release_amplitude=release)
            rows += [{"id": row.id, **answer, "error": None} for answer in answers]
    ratios = [row for row in rows if row["error"] is None]
    if not ratios:
        first = rows[0]
        raise rd.InputError(f"{path}: no wall has a damping ratio; {first['id']}: {first['error']}")
    columns = dict.fromkeys(ratios[0])
    return [columns | row for row in rows]


def _print_ratios(rows: list[dict[str, Any]], release: float) -> None:
    """Print the rows, and which damper has the smallest error."""
    for row in rows:
        if row.get("error"):
            click.echo(f"{row['id']}: {row['error']}")
    rows = [row for row in rows if not row.get("error")]
    table = [{RATIO_HEADS.get(name, name): row[name] for name in row} for row in rows]
    printing.print_table(
        table, f"Damping ratio xi equivalent to e, in free decay from {release:g} u_ins:"
    )
    errors = {row["damping_model"]: row.get("rms_error") for row in rows}
    known_errors = {model: error for model, error in errors.items() if error is not None}
    if known_errors:
        best = min(known_errors, key=lambda model: known_errors[model])
        click.echo(
            f"{best} has the smallest error. Use the column xi in your program; for BAND use e"
            " itself; `rockdamp wall` prints the frequency that xi refers to."
        )
