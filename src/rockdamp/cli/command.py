"""Commands with options under headings and errors of one line.

They never overwrite a file that they read.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

import click

import rockdamp as rd
from rockdamp.cli.options import SECTIONS, Option


class Command(click.Command):
    """A command with options in sections."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options under their headings."""
        records: dict[str, list[tuple[str, str]]] = {section: [] for section in SECTIONS}
        for param in self.get_params(ctx):
            record = param.get_help_record(ctx)
            if record is not None:
                records[getattr(param, "section", "Output")].append(record)
        for section in SECTIONS:
            if records[section]:
                with formatter.section(section):
                    formatter.write_dl(records[section])

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command, unless a file to write is one that it reads."""
        outputs = [
            (param.opts[0], ctx.params[str(param.name)])
            for param in self.params
            if isinstance(param, Option) and param.is_output
        ]
        for name, output in outputs:
            if output is not None and output.exists():
                for source in self._input_files(ctx):
                    if output.samefile(source):
                        raise click.UsageError(
                            f"{name} is {str(output)!r}, which the command reads; "
                            "choose another file"
                        )
        return super().invoke(ctx)

    def _input_files(self, ctx: click.Context) -> Iterator[Path]:
        """Yield the files that the parameters name and that exist."""
        for param in self.params:
            value = ctx.params[str(param.name)]
            if value is None or getattr(param, "is_output", False):
                continue
            if param.name == "records":
                from rockdamp.motions.catalogue import record_files

                paths = [Path(name) for name in record_files(value)]
            elif isinstance(param.type, click.Path):
                paths = list(value) if param.nargs == -1 else [value]
            else:
                continue
            yield from (path for path in paths if path.exists())


command = partial(click.command, cls=Command)


class Main(click.Group):
    """Commands that report every mistake in one line on standard error, with status 2."""

    def main(self, *arguments: Any, **settings: Any) -> NoReturn:
        try:
            status = super().main(*arguments, **{**settings, "standalone_mode": False})
        except click.ClickException as error:
            message = error.format_message()
        except click.Abort:
            sys.exit(1)
        except FileNotFoundError as error:
            message = f"{error.filename} does not exist" if error.filename else str(error)
        except (OSError, rd.InputError) as error:
            message = str(error)
        else:
            sys.exit(status)
        click.echo(f"Error: {' '.join(message.split())}", err=True)
        sys.exit(2)


def examples(*lines: str) -> str:
    """Return examples as the end of a help text."""
    return "\b\nExample:\n" + "\n".join(f"  {line}" for line in lines)
