"""Command line. Its modules import click alone, and a command imports the rest when it runs: `--help` is quick."""

from __future__ import annotations

import click

from rockdamp import __version__
from rockdamp.cli.assessment import assess_command
from rockdamp.cli.batch import batch
from rockdamp.cli.calibration import calibrate_command
from rockdamp.cli.command import Command, Main
from rockdamp.cli.histories import decay, respond_command
from rockdamp.cli.record import record
from rockdamp.cli.results import datasets, nrml, verify
from rockdamp.cli.single import equivalent_command, presets, wall

__all__ = ["main"]


@click.group(
    cls=Main,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog='Numbers may have units: --thickness 102mm, --density "1.8 t/m^3". Plain numbers are SI.',
)
@click.version_option(__version__, prog_name="rockdamp")
def main() -> None:
    """Energy dissipation in rocking masonry walls."""


SHELLS = ("bash", "zsh", "fish")
VARIABLE = "_ROCKDAMP_COMPLETE"


@click.command(cls=Command, examples=["rockdamp completion bash"])
@click.argument("shell", type=click.Choice(SHELLS))
@click.pass_context
def completion(ctx: click.Context, shell: str) -> None:
    """Print the script for completion in a shell.

    \b
    bash: add  eval "$(rockdamp completion bash)"   to ~/.bashrc
    zsh:  add  eval "$(rockdamp completion zsh)"    to ~/.zshrc
    fish: rockdamp completion fish > ~/.config/fish/completions/rockdamp.fish
    """
    from click.shell_completion import BashComplete, FishComplete, ZshComplete

    completion_of = {"bash": BashComplete, "zsh": ZshComplete, "fish": FishComplete}
    click.echo(completion_of[shell](ctx.find_root().command, {}, "rockdamp", VARIABLE).source())


for command in (
    wall,
    equivalent_command,
    decay,
    respond_command,
    assess_command,
    batch,
    record,
    calibrate_command,
    presets,
    datasets,
    verify,
    nrml,
    completion,
):
    main.add_command(command)
