"""Command line. Its modules import click alone, and a command imports the rest when it runs: `--help` is quick."""

from __future__ import annotations

import click

from rockdamp import __version__
from rockdamp.cli.assess import assess_command, batch
from rockdamp.cli.calibrate import calibrate_command
from rockdamp.cli.common import Main
from rockdamp.cli.histories import decay, respond_command
from rockdamp.cli.wall import equivalent_command, wall

__all__ = ["main"]


@click.group(
    cls=Main,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    invoke_without_command=True,
    epilog="Numbers are SI, or have a unit: --thickness 102mm, --pga 0.3g. Begin with: rockdamp wall --help",
)
@click.version_option(__version__, prog_name="rockdamp")
@click.pass_context
def main(ctx: click.Context) -> None:
    """Energy dissipation in rocking masonry walls."""
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


for command in (wall, equivalent_command, decay, respond_command, assess_command, batch, calibrate_command):
    main.add_command(command)
