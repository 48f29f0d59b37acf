"""Command line: modules import only click, and commands the rest, so that `--help` is quick."""

from __future__ import annotations

import click

from rockdamp import __version__
from rockdamp.cli.assess import assess, batch
from rockdamp.cli.calibrate import calibrate
from rockdamp.cli.command import Main
from rockdamp.cli.histories import decay, respond
from rockdamp.cli.wall import equivalent, wall

__all__ = ["main"]


@click.group(
    cls=Main,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    invoke_without_command=True,
    epilog="Numbers are in SI or have a unit: --thickness 102mm, --pga 0.3g. "
    "Begin with: rockdamp wall --help. The paper that options and outputs quote: Energy "
    "dissipation involved in the out-of-plane response of unreinforced masonry walls.",
)
@click.version_option(__version__, prog_name="rockdamp")
@click.pass_context
def main(ctx: click.Context) -> None:
    """Out-of-plane rocking and collapse of masonry walls in earthquakes."""
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


for subcommand in (wall, equivalent, decay, respond, assess, batch, calibrate):
    main.add_command(subcommand)
