"""Shared parts of the commands: types of options, errors of one line with status 2, examples in the help, files.

Inside the package all is SI.
"""

from __future__ import annotations

import json
import os
import re
import sys
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from glob import glob
from itertools import product
from math import isfinite
from pathlib import Path
from shlex import join
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import click

from rockdamp import units

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


# --- types of options ------------------------------------------------------------------------------------------------


class Quantity(click.ParamType):
    """A number in SI, or with one of the units that `units` has: `102mm`; a list of them, or one of some words."""

    name = "value"

    def __init__(self, unit: str = "", several: bool = False, words: Sequence[str] = ()) -> None:
        self.unit, self.several, self.words = unit, several, words

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        one = f"[{self.unit}]" if self.unit else "NUMBER"
        return "|".join([f"{one},..." if self.several else one, *self.words])

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str) or value in self.words:
            return value
        try:
            return (units.quantities if self.several else units.quantity)(value, self.unit)
        except ValueError as error:
            self.fail(", or ".join([str(error), *self.words]), param, ctx)


class Measured(float):
    """A number with its standard deviation, 0 where it is exact."""

    deviation: float = 0.0


class Uncertain(Quantity):
    """A quantity, exact or with its standard deviation, `110mm±2mm`, `0.11+-0.002`; or a word."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str) or value in self.words:
            return value
        number, _, deviation = value.replace("+-", "±").partition("±")
        measured = Measured(super().convert(number, param, ctx))
        measured.deviation = super().convert(deviation, param, ctx) if deviation else 0.0
        return measured


NUMBER = Quantity()
HINGE_RATIO = Quantity(words=("weakest",))


class Whole(click.IntRange):
    """A whole number within a range, in plain digits."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if isinstance(value, str) and not re.fullmatch(r"[-+]?[0-9]+", value):
            self.fail(f"{value!r} is not a valid integer.", param, ctx)
        return super().convert(value, param, ctx)


class OutputFile(click.ParamType):
    """A file to write, of one of a few formats, in a folder that exists: checked before anything is computed."""

    name = "file"

    def __init__(self, *suffixes: str) -> None:
        self.suffixes = suffixes

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        return f"FILE{'|'.join(self.suffixes)}"

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[Any]:
        from click.shell_completion import CompletionItem

        return [CompletionItem(incomplete, type="file")]

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        path, fail = Path(value), partial(self.fail, param=param, ctx=ctx)
        if path.suffix not in self.suffixes:
            fail(f"{str(path)!r} must end in {' or '.join(self.suffixes)}")
        try:
            str(path).encode("utf-8")  # NetCDF takes no other names
            if not path.parent.is_dir():
                fail(f"{str(path)!r} would be in {str(path.parent)!r}, which is no folder")
            if path.is_dir():
                fail(f"{str(path)!r} is a folder; it must be a file")
            if not os.access(path.parent, os.W_OK) or (path.exists() and not os.access(path, os.W_OK)):
                fail(f"{str(path)!r} may not be written")
        except (OSError, ValueError) as error:  # a name too long, or with a null in it
            fail(f"{str(path)!r} is no file name ({error})")
        return path


# --- commands --------------------------------------------------------------------------------------------------------

BAD_INPUT = 2
SOME_FAILED = 3  # of a table's rows, with --strict
FEW = 21  # options that a help shows without headings
HEADINGS = {
    "Wall": (
        "thickness height width density hinge_ratio overburden_ratio overburden eccentricity overburden_mass parapet"
        " one_sided"
    ).split(),
    "Curve": "a1 b1 preset a3 softening".split(),
    "Losses": "restitution exponent at damping_model damping_ratio order compare".split(),
    "Motion": "records record pgv pga scale to_pga to_pgv tail".split(),
    "What holds the wall": (
        "building_period storeys storey building_damping diaphragm_period diaphragm_damping".split()
    ),
    "Files to write": "output plot report csv".split(),
}
ARGUMENTS = "rockdamp.arguments"  # of the command, kept for the page that states it


class Command(click.Command):
    """A command that reports bad input in one line on standard error, with exit status 2; `examples` end its help."""

    def __init__(self, *args: Any, examples: Sequence[str] = (), **kwargs: Any) -> None:
        lines = "\n".join(_wrapped(example) for example in examples)
        kwargs["epilog"] = f"\b\nExample:\n{lines}"
        super().__init__(*args, **kwargs)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        ctx.meta[ARGUMENTS] = list(args)
        return super().parse_args(ctx, args)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options under headings, where there are many."""
        named = [(param.name, record) for param in self.get_params(ctx) if (record := param.get_help_record(ctx))]
        rest = [record for name, record in named if not any(name in names for names in HEADINGS.values())]
        for heading, names in HEADINGS.items() if len(named) > FEW else ():
            if records := [record for name, record in named if name in names]:
                with formatter.section(heading):
                    formatter.write_dl(records)
        with formatter.section("Options"):
            formatter.write_dl(rest if len(named) > FEW else [record for _, record in named])

    def invoke(self, ctx: click.Context) -> Any:
        import numpy as np

        try:
            # Numbers too large or too small for the formulas are bad input, not results.
            _refuse_same_files(ctx)
            os.environ["MPLBACKEND"] = "agg"  # pictures are files, whatever the user's notebooks show
            with warnings.catch_warnings(), np.errstate(over="raise", divide="raise", invalid="raise"):
                warnings.showwarning = lambda message, *_: click.echo(f"warning: {message}", err=True)
                return super().invoke(ctx)
        except (ArithmeticError, MemoryError) as error:
            _fail(ctx, f"a value is too large or too small to compute with ({error})")
        except EOFError as error:
            raise RuntimeError(f"a file ended too early ({error})") from error  # click would take it for Ctrl-C
        except BrokenPipeError:
            raise  # who reads the output has seen enough, as `head` does: click ends quietly
        except OSError as error:
            _fail(ctx, f"{error.filename or 'standard output'}: {error.strerror or error}")
        except ValueError as error:
            # Compared here, as importing the classes above would make the help slow.
            from rockdamp.errors import InputError

            if not isinstance(error, InputError):
                raise
            _fail(ctx, str(error))


class Main(click.Group):
    """The group of commands: errors before a command is chosen are one line too."""

    def main(self, args: Sequence[str] | None = None, *others: Any, **kwargs: Any) -> Any:
        try:
            return super().main(args, *others, **kwargs)
        except OSError as error:  # the help, on a disk that is full
            if not kwargs.get("standalone_mode", True):
                raise
            click.echo(f"Error: {error.filename or 'standard output'}: {error.strerror or error}", err=True)
            with open(os.devnull, "w") as nothing:  # what could not be written is not tried again at the end
                os.dup2(nothing.fileno(), sys.stdout.fileno())
            sys.exit(BAD_INPUT)


def command_line() -> str:
    """Return the command as it was typed, quoted for a shell."""
    ctx = click.get_current_context()
    return join(["rockdamp", ctx.info_name or "", *ctx.meta[ARGUMENTS]])


def _refuse_same_files(ctx: click.Context) -> None:
    """Raise `click.UsageError` where an output would overwrite an input, which a pattern or a folder may name."""
    stated = [(param, _paths(ctx.params.get(param.name or ""))) for param in ctx.command.params]
    written = [
        (param.opts[0], path)
        for param, paths in stated
        for path in paths
        if isinstance(param.type, OutputFile) and os.path.exists(path)
    ]
    if not written:
        return
    for param, paths in stated:
        reads = isinstance(param.type, click.Path) or param.multiple  # names of records are text
        sources = [source for path in paths for source in glob(path) + glob(f"{path}/*")] if reads else []
        for (output, target), source in product(written, sources):
            if os.path.samefile(target, source):
                raise click.UsageError(f"{output} is {target!r}, which {param.opts[0]} reads; it must be another file")


def _paths(value: Any) -> list[str]:
    values = value if isinstance(value, list | tuple) else [value]
    return [os.fspath(path) for path in values if isinstance(path, str | Path)]


def _wrapped(example: str) -> str:
    """Break a long example into lines that a shell joins."""
    return " \\\n".join(wrap(example, 88, initial_indent="  ", subsequent_indent="      ", break_on_hyphens=False))


def _fail(ctx: click.Context, message: str) -> None:
    click.echo(f"Error: {message}", err=True)
    ctx.exit(BAD_INPUT)


@contextmanager
def concerning(path: Path | str) -> Iterator[None]:
    """Name the file in errors about its content."""
    from rockdamp.errors import InputError

    try:
        yield
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """State that the body wrote a file; turn a failure into an error that names it."""
    from rockdamp.errors import InputError

    try:
        yield
    except (OSError, RuntimeError) as error:
        raise InputError(f"{path} cannot be written ({getattr(error, 'strerror', None) or error})") from None
    click.echo(f"{path} written", err=True)


def write_table(rows: Iterable[Mapping[str, Any]], path: Path, columns: Sequence[str] | None = None) -> None:
    """Write rows as CSV, whole or not at all; the default columns are those of the first row."""
    import csv

    from rockdamp.storage.files import replace_file

    rows = list(rows)
    with writing(path), replace_file(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        table: Any = csv.DictWriter(file, columns or list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def write_dataset(dataset: xr.Dataset, path: Path, kind: str, **read: Any) -> None:
    """Write the result of a command as NetCDF; the options of the command stand for the config.

    `read` replaces options that name a file by the digest of its content: the result does not depend on where the file
    lies, and a pipe is not read twice.
    """
    from importlib.metadata import version

    from rockdamp.storage import dataset as storage

    files = ("output", "plot", "report", "table", "as_json")
    options = {name: value for name, value in click.get_current_context().params.items() if name not in files}
    with writing(path):
        storage.write(dataset, path, kind, config={**options, **read}, code_version=version("rockdamp"))


def write_figure(figure: Figure, path: Path) -> None:
    """Write a figure in the format of the suffix."""
    from rockdamp.figures.style import save

    with writing(path):
        save(figure, [path], 200)


def print_json(value: Any) -> None:
    click.echo(json.dumps(value, indent=2, allow_nan=False))


def print_table(rows: Sequence[Mapping[str, Any]], units: Mapping[str, str] | None = None) -> None:
    """Print rows as a table, with units under the names of the columns."""
    names = list(rows[0])
    lines = [names, *([cell(row[name]) for name in names] for row in rows)]
    if units and not units.keys().isdisjoint(names):
        lines.insert(1, [f"[{units[name]}]" if name in units else "" for name in names])
    widths = [max(len(line[i]) for line in lines) for i in range(len(names))]
    for line in lines:
        click.echo("  ".join(text.rjust(width) for text, width in zip(line, widths, strict=True)).rstrip())


def print_values(values: Mapping[str, Any], units: Mapping[str, str]) -> None:
    """Print one name, value and unit a line."""
    width = max(map(len, values)) + 1
    for name, value in values.items():
        click.echo(
            f"{name:{width}s} {cell(value):>12s} {units.get(name, '' if isinstance(value, str) else '-')}".rstrip()
        )


def known(value: xr.DataArray) -> float | int | None:
    """Return a number for JSON; null is not known or not determined."""
    return value.item() if isfinite(value) else None


def without_unknown(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Leave the true values out where none is known."""
    out = () if any(row["true_value"] is not None for row in rows) else ("true_value",)
    return [{key: value for key, value in row.items() if key not in out} for row in rows]


def cell(value: Any) -> str:
    """Return the text of a value in a table."""
    if value is None:
        return "-"
    return value if isinstance(value, str) else f"{value + 0:.5g}"  # no "-0"
