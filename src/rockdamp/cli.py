"""The command line: one wall and one coefficient of restitution."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from typing import Any

import click

from rockdamp import __version__
from rockdamp.errors import InputError

BAD_INPUT = 2


class _Command(click.Command):
    """A command whose bad input ends with one line on standard error and exit status 2."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except InputError as error:
            click.echo(f"Error: {error}", err=True)
            ctx.exit(BAD_INPUT)


def _curve_options(command: Any) -> Any:
    for option in (
        click.option("--softening", type=click.Choice(["steeper", "translated"]), default="steeper", show_default=True,
                     help="Last branch for a3 < 1."),
        click.option("--a3", type=float, default=1.0, show_default=True, help="Ultimate ratio u3/u_ins."),
        click.option("--b1", type=float, required=True, help="Plateau ratio F_y/F0."),
        click.option("--a1", type=float, required=True, help="Cracked stiffness ratio u1/u_ins."),
    ):  # fmt: skip
        command = option(command)
    return command


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="rockdamp")
def main() -> None:
    """Energy dissipation in rocking masonry walls."""


@main.command(
    cls=_Command,
    epilog="Example:  rockdamp equivalent --restitution 0.85 --a1 0.04 --b1 0.85",
)
@click.option("--restitution", type=float, required=True, help="Coefficient of restitution e.")
@_curve_options
@click.option("--release", type=float, default=0.5, show_default=True, help="Release amplitude u0/u_ins.")
@click.option("--window", type=float, default=None, help="Length of the response in tau = p t.  [default: 8]")
@click.option("--json", "as_json", is_flag=True, help="Print a list of objects for programs.")
def equivalent(
    restitution: float, a1: float, b1: float, a3: float, softening: str, release: float, window: float | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Damping ratio of each viscous model that is equivalent to a coefficient of restitution."""
    from rockdamp.matching import DEFAULT_WINDOW
    from rockdamp.single import equivalent as compute

    rows = compute(restitution, a1, b1, a3, softening, release, DEFAULT_WINDOW if window is None else window)
    _print(rows, as_json)
    if not as_json and any(row["damping_ratio_fit"] is None for row in rows):
        click.echo("\n-: outside the range of the polynomials (a1 or e)", err=True)


@main.command(
    cls=_Command,
    epilog="Example:  rockdamp wall --thickness 0.3 --height 4.5 --overburden-ratio 2",
)
@click.option("--thickness", type=float, required=True, help="t [m].")
@click.option("--height", type=float, required=True, help="h [m].")
@click.option("--width", type=float, default=1.0, show_default=True, help="Length of the strip [m].")
@click.option("--density", type=float, default=1800.0, show_default=True, help="Of the masonry [kg m-3].")
@click.option("--hinge-ratio", type=float, default=0.7, show_default=True, help="h1/h; unused by a parapet.")
@click.option("--overburden-ratio", type=float, default=0.0, show_default=True, help="O/W.")
@click.option("--eccentricity", type=float, default=0.0, show_default=True, help="Of the overburden [m].")
@click.option("--parapet", is_flag=True, help="One block that rocks on its base.")
@click.option("--json", "as_json", is_flag=True, help="Print an object for programs.")
def wall(parapet: bool, as_json: bool, hinge_ratio: float, **options: float) -> None:
    """Constants of a wall's equation of motion."""
    from rockdamp.wall import Parapet, Wall

    made = Parapet(**options) if parapet else Wall(hinge_ratio=hinge_ratio, **options)
    keys = (
        "weight", "effective_mass", "excitation_factor", "rigid_strength", "rigid_stiffness",
        "instability_displacement", "frequency_parameter", "restitution", "restitution_impulsive",
    )  # fmt: skip
    values = {key: float(getattr(made, key)) for key in keys}
    if as_json:
        click.echo(json.dumps(values, indent=2))
        return
    units = {
        "weight": "N", "effective_mass": "kg", "rigid_strength": "N", "rigid_stiffness": "N m-1",
        "instability_displacement": "m", "frequency_parameter": "rad s-1",
    }  # fmt: skip
    for key, value in values.items():
        click.echo(f"{key:26s} {value:14.6g} {units.get(key, '-')}")


def _print(rows: Sequence[Mapping[str, Any]], as_json: bool) -> None:
    """Print rows as a table to read, or as JSON and nothing else."""
    if as_json:
        json.dump(rows, sys.stdout, indent=2)
        click.echo()
        return
    names = list(rows[0])
    cells = [names, *([_cell(row[name]) for name in names] for row in rows)]
    widths = [max(len(line[i]) for line in cells) for i in range(len(names))]
    for line in cells:
        click.echo("  ".join(cell.rjust(width) for cell, width in zip(line, widths)))


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    return value if isinstance(value, str) else f"{value:.5g}"


if __name__ == "__main__":
    main()
