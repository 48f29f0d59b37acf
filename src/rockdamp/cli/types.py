"""Types of options: numbers, quantities with units, lists and ranges, files to write. Inside the package all is SI."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import click

from rockdamp import units

EXAMPLES = {
    "": "0.85; a list, 0.80,0.85; or start:stop:step, 0.80:0.95:0.01",
    "m": "102mm, 0.102m, 4in",
    "kg m-3": "1800, 1.8t/m^3, 112lb/ft^3",
    "s": "2s, 500ms, 1min",
    "m s-1": "0.4m/s, 40cm/s, 16in/s",
    "m s-2": "0.3g, 3m/s^2, 300cm/s^2",
}


class Read(click.ParamType):
    """What a function reads from a text; its `ValueError` ends in what is allowed. Defaults that are no text stay."""

    name = "value"

    def __init__(self, read: Callable[[str], Any], metavar: str, allowed: str) -> None:
        self.read, self.metavar, self.allowed = read, metavar, allowed

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        return self.metavar

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return value
        try:
            return self.read(value)
        except ValueError as error:
            self.fail(f"{error}; it must be {self.allowed}", param, ctx)


def word_or_number(*words: str) -> Callable[[str], str | float]:
    """Return a reader of a number, or of one of some words."""
    return lambda text: text if text in words else units.number(text)


NUMBER = Read(units.number, "FLOAT", "one with a decimal point, as 0.85")  # click's own also takes 1_0
HINGE_RATIO = Read(word_or_number("weakest"), "FLOAT|weakest", "one, or weakest")


def in_unit(unit: str, read: Callable[[str, str], Any], metavar: str) -> Read:
    """Return the type of what `read` reads in an SI unit, or of plain numbers."""
    kind = f"a number in {unit}, or one with its unit" if unit else "a number"
    return Read(lambda text: read(text, unit), metavar, f"{kind}, as {EXAMPLES[unit]}")


def quantity(unit: str, read: Callable[[str, str], float] = units.quantity) -> Read:
    """Return the type of a number in SI, or with its unit, as `102mm`; g is standard gravity for an acceleration."""
    return in_unit(unit, read, f"[{unit}]")


def quantities(unit: str = "") -> Read:
    """Return the type of a quantity, a list `A,B,...`, or a range `start:stop:step`; without a unit, of numbers."""
    return in_unit(unit, units.quantities, f"{f'[{unit}]' if unit else 'NUMBER'}|A:B:STEP|A,B,...")


def uncertain(unit: str) -> Read:
    """Return the type of a quantity, exact or with its standard deviation: `110mm±2mm`, `0.11+-0.002`."""
    return in_unit(unit, _measured, f"{f'[{unit}]' if unit else 'NUMBER'}[±DEVIATION]")


class Whole(click.IntRange):
    """A whole number within a range, in plain digits."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if isinstance(value, str) and not re.fullmatch(r"[-+]?[0-9]+", value):
            self.fail(f"{value!r} is not a valid integer.", param, ctx)
        return super().convert(value, param, ctx)


class Measured(float):
    """A number with its standard deviation, 0 where it is exact."""

    deviation: float = 0.0


def _measured(text: str, unit: str) -> Measured:
    value, *deviation = text.replace("+-", "±").split("±")
    if len(deviation) > 1:
        raise units.UnitError(f"{text!r} has more than one standard deviation")
    if not deviation:
        return Measured(units.quantity(value, unit))
    numbers = units.quantities(f"{value},{deviation[0]}", unit)
    if len(numbers) != 2 or not numbers[1] > 0:
        raise units.UnitError(f"{text!r} has no standard deviation above 0")
    measured = Measured(numbers[0])
    measured.deviation = numbers[1]
    return measured


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
