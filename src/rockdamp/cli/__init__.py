"""Command line. Its modules import click alone, and a command imports the rest when it runs: `--help` is quick."""

from __future__ import annotations

import click

from rockdamp import __version__
from rockdamp.cli.assessment import assess_command
from rockdamp.cli.batch import batch
from rockdamp.cli.calibration import calibrate_command
from rockdamp.cli.command import Main
from rockdamp.cli.histories import decay, respond_command
from rockdamp.cli.single import equivalent_command, wall

__all__ = ["main"]


@click.group(
    cls=Main,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog='Numbers may have units: --thickness 102mm, --density "1.8 t/m^3". Plain numbers are SI.',
)
@click.version_option(__version__, prog_name="rockdamp")
def main() -> None:
    """Energy dissipation in rocking masonry walls."""


for command in (
    wall,
    equivalent_command,
    decay,
    respond_command,
    assess_command,
    batch,
    calibrate_command,
):
    main.add_command(command)
