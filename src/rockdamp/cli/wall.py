"""`wall` and `equivalent`: what needs no history."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rockdamp.cli.common import (
    FILE,
    NUMBER,
    Quantity,
    curve_options,
    describe_wall,
    examples,
    find_restitution,
    in_g,
    json_option,
    known,
    make_curve,
    make_wall,
    option,
    output_option,
    print_json,
    print_table,
    restitution_option,
    wall_options,
    write_csv,
)
from rockdamp.constants import RELEASES

if TYPE_CHECKING:
    from rockdamp.mechanics.curve import TrilinearCurve

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
RULES = ("measured", "rigid", "impulsive")  # for e
AMPLITUDES = (0.1, 0.3, 0.5, 0.7, 0.9)


@click.command(
    epilog=examples(
        "rockdamp wall --thickness 0.3 --height 4.5 --overburden-ratio 2",
        "rockdamp wall --thickness 102mm --height 2.75m --preset moderate",
        "rockdamp wall --thickness 12in --height 13ft --hinge-ratio weakest --overburden 12kN/m",
    )
)
@wall_options
@curve_options
@restitution_option
@json_option
def wall(restitution: float | str | None, as_json: bool, **given: Any) -> None:
    """Constants of a wall, its restitution by three rules, and its periods.

    With a curve (--preset, or --a1 and --b1) also the damping to type into a program for one e, by default the measured
    one: C and OpenSees' rayleigh alphaM of CDC, and which share of the collapses each damper misses.
    """
    built, has_curve = make_wall(given), given["preset"] or given["a1"] or given["b1"]
    curve = make_curve(given) if has_curve else None
    if restitution is not None and curve is None:
        raise click.UsageError("--restitution belongs to a curve: --preset, or --a1 and --b1")
    values = {name: getattr(built, name) for name in UNITS if name != "rocking_onset"}
    values |= {f"restitution_{rule}": getattr(built, f"restitution_{rule}") for rule in RULES}
    values |= {name: getattr(built, name) for name in ("hinge_ratio", "weakest_hinge_ratio") if hasattr(built, name)}
    values["rocking_onset"] = built.rocking_onset(1.0 if curve is None else curve.strength_ratio)
    values = {name: known(value) for name, value in values.items()}
    periods = [row for amplitude in AMPLITUDES if (row := _period(built, curve, amplitude))]
    damping = {} if curve is None else _damping(built, curve, restitution or "measured")
    if as_json:
        print_json(values | {"periods": periods} | damping)
        return
    click.echo(f"{describe_wall(built)}; rocking starts at {in_g(values['rocking_onset'])}\n")
    for name, unit in UNITS.items():
        click.echo(f"{name:25s}{values[name]:>10.5g} {unit}")
    for rule in RULES:
        e, reason = find_restitution(built, rule) if values[f"restitution_{rule}"] is not None else (None, "not known")
        click.echo(f"{f'restitution_{rule}':25s}{'-' if e is None else f'{e:.5g}':>10s} {reason}")
    click.echo()
    print_table([{f"{name}{'' if name == 'amplitude' else ' [s]'}": row[name] for name in row} for row in periods])
    if curve is not None:
        _print_damping(damping)


def _period(wall: Any, curve: TrilinearCurve | None, amplitude: float) -> dict[str, float]:
    """Return the periods of a decay from an amplitude; nothing beyond the end of the curve."""
    import numpy as np

    p, row = float(wall.frequency_parameter), {"amplitude": amplitude}
    row["rigid_period"] = float(4 * np.arccosh(1 / (1 - amplitude)) / p)
    if curve is not None:
        if amplitude >= curve.ultimate_displacement_ratio:
            return {}
        row["period"] = float(curve.period(amplitude) / p)
    return row


def _damping(wall: Any, curve: TrilinearCurve, restitution: float | str) -> dict[str, Any]:
    """Return what a program with viscous damping needs; of CDC also C, and alphaM = 2 xi w1 of Rayleigh's damping."""
    from rockdamp.equivalence.programs import frequencies, program_inputs

    e, _ = find_restitution(wall, restitution)
    rows = program_inputs(wall, curve, e)
    (cdc,) = (row for row in rows if row.damping_model == "CDC")
    w1, period = frequencies(wall, curve)
    return {
        "initial_frequency": w1,
        "initial_period": period,
        "damping_restitution": e,
        "damping_coefficient": cdc.damping_coefficient,
        "rayleigh_alpha_m": 2 * cdc.damping_ratio * w1,
        "damping": [asdict(row) for row in rows],
    }


def _print_damping(damping: dict[str, Any]) -> None:
    names = {"damping_model": "damper", "damping_ratio": "xi", "refers_to": "xi refers to"}
    w1, e = damping["initial_frequency"], damping["damping_restitution"]
    click.echo(f"\nviscous damping for e = {e:.4g}; w1 = {w1:.4g} rad/s, T1 = {damping['initial_period']:.4g} s")
    rows = [
        {new: row[old] for old, new in names.items()}
        | {"collapses missed": f"{100 * row['missed_collapse_rate']:.2g} %"}
        for row in damping["damping"]
    ]
    print_table(rows)
    missed, c, alpha = rows[0]["collapses missed"], damping["damping_coefficient"], damping["rayleigh_alpha_m"]
    click.echo(
        f"CDC: C = {c:.5g} N s/m. OpenSees: rayleigh {alpha:.5g} 0 0 0 (alphaM = 2 xi w1); it misses {missed} of the"
        " collapses under restitution"
    )


@click.command(
    "equivalent",
    epilog=examples(
        "rockdamp equivalent --restitution 0.85 --a1 0.04 --b1 0.85",
        "rockdamp equivalent --damping-ratio 5% --preset moderate",
        "rockdamp equivalent --walls examples/my-walls.csv --output ratios.csv",
    ),
)
@option("--restitution", type=Quantity(several=True), help=f"Restitution e, of releases from {RELEASES}; or several.")
@option("--damping-ratio", type=NUMBER, help="In place of it, a damping ratio xi: the answer is e.")
@curve_options
@option("--release", type=NUMBER, default=0.5, help="Release amplitude u0/u_ins.")
@option("--walls", type=FILE, metavar="FILE", help="Table of walls, as of batch, in place of one e and curve.")
@output_option(".csv", help="Write the rows.")
@json_option
def equivalent_command(
    restitution: list[float] | None,
    damping_ratio: float | None,
    release: float,
    walls: Path | None,
    output: Path | None,
    as_json: bool,
    **given: Any,
) -> None:
    """Damping ratios equivalent to a restitution, or the restitution that a damping ratio stands for.

    One row for each e and viscous model. damping_ratio has the least error (Eq. 17): use it. damping_ratio_energy is
    the closed form, damping_ratio_fit the paper's polynomials at b1 = 0.85, empty outside their range of a1 and e.
    """
    if [restitution, damping_ratio, walls].count(None) != 2:
        raise click.UsageError("there must be one of --restitution, --damping-ratio and --walls")
    from rockdamp.equivalence.equivalent import equivalent, equivalent_restitution

    if walls is not None:
        rows = _equivalent_walls(walls, release)
    elif damping_ratio is not None:
        rows = equivalent_restitution(damping_ratio, make_curve(given), release_amplitude=release)
    else:
        rows = equivalent(restitution or [], make_curve(given), release_amplitude=release)
    if output is not None:
        write_csv(rows, output)
    print_json(rows) if as_json else print_table(rows)


def _equivalent_walls(path: Path, release: float) -> list[dict[str, Any]]:
    """Return the damping ratios of each wall of a table; errors in a column."""
    from rockdamp.assessment.table import BadRow, read_walls
    from rockdamp.equivalence.equivalent import equivalent
    from rockdamp.errors import InputError
    from rockdamp.progress import track

    names = ("restitution", "damping_model", "damping_ratio", "rms_error", "damping_ratio_energy", "damping_ratio_fit")
    found = []
    for row in track(read_walls(path), "Walls"):
        try:
            if isinstance(row, BadRow):
                raise InputError(row.error)
            answers = equivalent(row.restitution, row.curve, release_amplitude=release)
            found += [{"id": row.id, **answer, "error": ""} for answer in answers]
        except InputError as error:
            found.append({"id": row.id, **dict.fromkeys(names), "error": str(error)})
    return found
