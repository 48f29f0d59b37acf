"""`completion`: print the script with which a shell completes commands and options."""

from __future__ import annotations

import click

from rockdamp.cli.command import Command

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
