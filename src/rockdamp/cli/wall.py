"""`wall` and `equivalent`: what needs no history."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

import rockdamp as rd
from rockdamp.cli import common, options
from rockdamp.cli.options import NUMBER, Quantity, option
from rockdamp.constants import RELEASES

UNITS = {
    "weight": "N",
    "effective_mass": "kg",
    "excitation_factor": "-",
    "rigid_strength": "N",
    "rigid_stiffness": "N/m",
    "instability_displacement": "m",
    "frequency_parameter": "rad/s",
    "rocking_onset": "m/s2",
}
AMPLITUDES = (0.1, 0.3, 0.5, 0.7, 0.9)


@click.command(
    epilog=common.examples(
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
    """Constants of a wall, its restitution and periods.

    With a curve (--preset, or --a1 and --b1) also the damping to type into a program for one e, by default the measured
    one: C and OpenSees' rayleigh alphaM of CDC, and which share of the collapses each damper misses.
    """
    built, e = common.build_wall(inputs), inputs["restitution"]
    has_curve = any(inputs[name] is not None for name in ("preset", "a1", "b1"))
    if e is not None and not has_curve:
        raise click.UsageError("--restitution belongs to a curve: --preset, or --a1 and --b1")
    curve = common.build_curve(inputs) if has_curve else None
    others = [name for name in ("hinge_ratio", "weakest_hinge_ratio") if hasattr(built, name)]
    names = [*UNITS, *(f"restitution_{rule}" for rule in options.RULES), *others]
    onset = built.rocking_onset(1.0 if curve is None else curve.strength_ratio)
    values = {
        name: float(onset if name == "rocking_onset" else getattr(built, name)) for name in names
    }
    periods, damping = _periods(built, curve), {}
    if curve is not None:
        from rockdamp.equivalence.programs import describe_damping

        e, _ = common.choose_restitution(built, "measured" if e is None else e)
        damping = describe_damping(built, curve, e)
    if inputs["as_json"]:
        common.print_json(values | {"periods": periods} | damping)
        return
    click.echo(f"{common.describe_wall(built, curve)}\n")
    for name, unit in UNITS.items():
        click.echo(f"{name:25s}{values[name]:>10.5g} {unit}")
    for rule in options.RULES:
        value = values[f"restitution_{rule}"]
        reason = common.choose_restitution(built, rule)[1] if value == value else "not known"
        click.echo(f"{f'restitution_{rule}':25s}{common.cell(value):>10s} {reason}")
    click.echo()
    common.print_table(
        [
            {f"{name} [s]" if "period" in name else name: row[name] for name in row}
            for row in periods
        ]
    )
    if damping:
        click.echo()
        common.print_dampers(damping, damping["damping"])
        (missed,) = (
            row["missed_collapse_rate"]
            for row in damping["damping"]
            if row["damping_model"] == "CDC"
        )
        click.echo(
            f"CDC: C = {damping['damping_coefficient']:.5g} N s/m. OpenSees: rayleigh {damping['rayleigh_alpha_m']:.5g}"
            f" 0 0 0 (alphaM = 2 xi w1). In the study's walls it misses {common.percent(missed)} of the collapses"
            " under restitution"
        )


def _periods(wall: Any, curve: rd.TrilinearCurve | None) -> list[dict[str, Any]]:
    """Return the periods of decays from some amplitudes, up to the end of the curve."""
    from rockdamp.mechanics.free_motion import rigid_period

    p, rows = wall.frequency_parameter, []
    for amplitude in AMPLITUDES:
        row = {"amplitude": amplitude, "rigid_period": rigid_period(amplitude) / p}
        if curve is None:
            rows.append(row)
        elif amplitude < curve.ultimate_displacement_ratio:
            rows.append(row | {"period": curve.period(amplitude) / p})
    return rows


@click.command(
    epilog=common.examples(
        "rockdamp equivalent --restitution 0.85 --a1 0.04 --b1 0.85",
        "rockdamp equivalent --damping-ratio 5% --preset moderate",
        "rockdamp equivalent --walls examples/my-walls.csv --output ratios.csv",
    ),
)
@option(
    "--restitution",
    type=Quantity(several=True),
    help=f"Restitution e, of releases from {RELEASES}; or several.",
)
@option("--damping-ratio", type=NUMBER, help="In place of it, a damping ratio xi: the answer is e.")
@options.curve_options
@option("--release", type=NUMBER, default=0.5, help="Release amplitude u0/u_ins.")
@option(
    "--walls",
    type=options.FILE,
    metavar="FILE",
    help="Table of walls, as of batch, in place of one e and curve.",
)
@options.output_option(".csv", help="Write the rows.")
@options.json_option
def equivalent(**inputs: Any) -> None:
    """Damping ratios equivalent to a restitution, or back.

    One row for each e and viscous model. damping_ratio has the least error (Eq. 17): use it. damping_ratio_energy is
    the closed form, damping_ratio_fit the paper's polynomials at b1 = 0.85, empty outside their range of a1 and e.
    """
    from rockdamp.equivalence.equivalent import equivalent_restitution

    e, xi, walls = (inputs[name] for name in ("restitution", "damping_ratio", "walls"))
    if [e, xi, walls].count(None) != 2:
        raise click.UsageError("there must be one of --restitution, --damping-ratio and --walls")
    if walls is not None:
        rows = _equivalent_walls(walls, inputs["release"])
    elif xi is not None:
        rows = equivalent_restitution(
            xi, common.build_curve(inputs), release_amplitude=inputs["release"]
        )
        if not any(row["restitution"] for row in rows):
            raise click.UsageError(
                f"--damping-ratio is {xi:g}; it must be that of an e from 0.60 to 0.99"
            )
    else:
        rows = rd.equivalent(e, common.build_curve(inputs), release_amplitude=inputs["release"])
    if inputs["output"] is not None:
        common.write_csv(rows, inputs["output"])
    common.print_json(rows) if inputs["as_json"] else common.print_table(rows)


def _equivalent_walls(path: Path, release: float) -> list[dict[str, Any]]:
    """Return the damping ratios of each wall of a table, by its id."""
    from rockdamp.assessment.table import BadRow, read_walls

    rows = []
    for wall in read_walls(path):
        if isinstance(wall, BadRow):
            raise rd.InputError(f"{path}: {wall.id}: {wall.error}")
        answers = rd.equivalent(wall.restitution, wall.curve, release_amplitude=release)
        rows += [{"id": wall.id, **answer} for answer in answers]
    return rows
