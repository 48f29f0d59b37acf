"""Types of options: numbers, quantities with units, lists and ranges, files to write. Inside the package all is SI."""

from __future__ import annotations

import os
import re
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


class Number(click.ParamType):
    """A number as other programs read it: click also takes 1_0 and digits of any script."""

    name = "float"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        try:
            return value if isinstance(value, float) else units.number(value)
        except ValueError:
            self.fail(f"{value!r} is no number; it must be one with a decimal point, as 0.85", param, ctx)


class HingeRatio(click.ParamType):
    """A height of the hinge, or the word for the one at which the wall is weakest."""

    name = "hinge"

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        return "FLOAT|weakest"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        try:
            return value if isinstance(value, float) or value == "weakest" else units.number(value)
        except ValueError:
            self.fail(f"{value!r} is no number; it must be one, or weakest", param, ctx)


class Whole(click.IntRange):
    """A whole number within a range, in plain digits."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if isinstance(value, str) and not re.fullmatch(r"[-+]?[0-9]+", value):
            self.fail(f"{value!r} is not a valid integer.", param, ctx)
        return super().convert(value, param, ctx)


class _InUnit(click.ParamType):
    """A text that `rockdamp.units` reads in one SI unit."""

    def __init__(self, unit: str = "") -> None:
        self.unit = unit

    def read(self, text: str) -> Any:
        raise NotImplementedError

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return value
        try:
            return self.read(value)
        except units.UnitError as error:
            kind = f"a number in {self.unit}, or one with its unit" if self.unit else "a number"
            self.fail(f"{error}; it must be {kind}, as {EXAMPLES[self.unit]}", param, ctx)


class Quantity(_InUnit):
    """A number in SI, or a number with its unit, as `102mm`; g is standard gravity for an acceleration."""

    name = "quantity"

    def read(self, text: str) -> float:
        return units.quantity(text, self.unit)

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        return f"[{self.unit}]"


class Measured(float):
    """A number with its standard deviation, 0 where it is exact."""

    deviation: float = 0.0

    @classmethod
    def of(cls, value: float, deviation: float) -> Measured:
        measured = cls(value)
        measured.deviation = deviation
        return measured


class Uncertain(_InUnit):
    """A quantity, exact or with its standard deviation: `110mm±2mm`, `0.11+-0.002`."""

    name = "uncertain quantity"

    def read(self, text: str) -> Measured:
        value, *deviation = text.replace("+-", "±").split("±")
        if len(deviation) > 1:
            raise units.UnitError(f"{text!r} has more than one standard deviation")
        if not deviation:
            return Measured(units.quantity(value, self.unit))
        numbers = units.quantities(f"{value},{deviation[0]}", self.unit)
        if len(numbers) != 2 or not numbers[1] > 0:
            raise units.UnitError(f"{text!r} has no standard deviation above 0")
        return Measured.of(*numbers)

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        return f"{f'[{self.unit}]' if self.unit else 'NUMBER'}[±DEVIATION]"


class Quantities(_InUnit):
    """A quantity, a list `A,B,...`, or a range `start:stop:step`; without a unit, plain numbers."""

    name = "quantities"

    def read(self, text: str) -> list[float]:
        return units.quantities(text, self.unit)

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        return f"{f'[{self.unit}]' if self.unit else 'NUMBER'}|A:B:STEP|A,B,..."


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
        path = Path(value)
        if path.suffix not in self.suffixes:
            self.fail(f"{str(path)!r} must end in {' or '.join(self.suffixes)}", param, ctx)
        try:
            str(path).encode("utf-8")  # NetCDF takes no other names
            self._check_place(path, param, ctx)
        except (OSError, ValueError) as error:  # a name too long, or with a null in it
            self.fail(f"{str(path)!r} is no file name ({error})", param, ctx)
        return path

    def _check_place(self, path: Path, param: click.Parameter | None, ctx: click.Context | None) -> None:
        if not path.parent.is_dir():
            self.fail(f"{str(path)!r} would be in {str(path.parent)!r}, which is no folder", param, ctx)
        if path.is_dir():
            self.fail(f"{str(path)!r} is a folder; it must be a file", param, ctx)
        if not os.access(path.parent, os.W_OK) or (path.exists() and not os.access(path, os.W_OK)):
            self.fail(f"{str(path)!r} may not be written", param, ctx)
