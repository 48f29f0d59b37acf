"""Types of options: quantities with units, ranges of numbers, files to write.

Units are read here and nowhere else; inside the package all is SI.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator, Sequence
from decimal import Decimal
from functools import cache
from pathlib import Path
from typing import Any

import click

from rockdamp.text import parse_number

MOST_VALUES = 1000  # of a range
UNITS = {
    "m": "102mm, 0.102m, 4in",
    "kg m-3": "1800, 1.8t/m^3, 112lb/ft^3",
    "s": "2s, 500ms, 1min",
    "m s-1": "0.4m/s, 40cm/s, 16in/s",
    "m s-2": "0.3g, 3m/s^2, 300cm/s^2",
}

_NUMBER = r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
_QUANTITY = re.compile(rf"\s*(?P<number>{_NUMBER})\s*(?P<units>[^\s\d.].*)", re.DOTALL)
_FACTOR = re.compile(r"(?P<slash>[*/·]?)\s*(?P<name>[^\W\d_]+)\s*(?:(?:\*\*|\^)?(?P<power>[-+]?\d))?\s*")


class Number(click.ParamType):
    """A number, as other programs read it: click takes 1_0 and digits of any script."""

    name = "float"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        try:
            return value if isinstance(value, float) else parse_number(value)
        except ValueError:
            self.fail(f"{value!r} is not a valid float.", param, ctx)


class Quantity(click.ParamType):
    """A number in SI, or a number with its unit, as `102mm`; g is that of the earth for an acceleration.

    Parameters
    ----------
    unit : str
        The SI unit, one of `UNITS`.
    """

    name = "quantity"

    def __init__(self, unit: str) -> None:
        self.unit = unit

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        return f"[{self.unit}]"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        try:
            number = value if isinstance(value, float) else parse_number(value)
        except ValueError:
            number = self._with_unit(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value!r} is not finite; it must be a finite number in {self.unit}", param, ctx)
        return number

    def _with_unit(self, text: str, param: click.Parameter | None, ctx: click.Context | None) -> float:
        allowed = f"it must be a number in {self.unit}, or one with its unit, as {UNITS[self.unit]}"
        match = _QUANTITY.fullmatch(text)
        units = list(_factors(match["units"])) if match else []
        units = [("standard_gravity", 1)] if units == [("g", 1)] and self.unit == "m s-2" else units
        if match is None or not units:
            self.fail(f"{text!r} is no quantity; {allowed}", param, ctx)
        import pint  # slow to load, and most numbers come without units

        try:
            return _registry().convert(float(match["number"]), _product(units), _product(_factors_of(self.unit)))
        except pint.UndefinedUnitError:
            self.fail(f"{text!r} has an unknown unit, {match['units'].strip()}; {allowed}", param, ctx)
        except (pint.DimensionalityError, pint.OffsetUnitCalculusError):
            self.fail(f"{text!r} is in {match['units'].strip()}; {allowed}", param, ctx)
        except (ValueError, ArithmeticError, AssertionError):
            self.fail(f"{text!r} is no quantity; {allowed}", param, ctx)


def _factors(text: str) -> Iterator[tuple[str, int]]:
    """Yield the units of a product and their powers; nothing where the text is none."""
    factors: list[tuple[str, int]] = []
    place = 0
    while place < len(text):
        match = _FACTOR.match(text, place)
        if match is None or bool(match["slash"]) != bool(factors) and match["slash"]:
            return
        power = int(match["power"] or 1)
        factors.append((match["name"], -power if match["slash"] == "/" else power))
        place = match.end()
    yield from factors


def _factors_of(unit: str) -> list[tuple[str, int]]:
    """Return the factors of one of `UNITS`."""
    return [(name, int(power or 1)) for name, power in re.findall(r"([a-z]+)(-?\d*)", unit)]


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()


def _product(factors: Sequence[tuple[str, int]]) -> str:
    return " * ".join(f"{name} ** {power}" for name, power in factors)


class Quantities(Quantity):
    """A quantity, several divided by commas, or a range `start:stop:step`; the last unit is that of numbers without."""

    name = "quantities"

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        return f"[{self.unit}]|A:B:STEP|A,B,..."

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return [float(number) for number in value]
        parts = re.split(r"[,:]", value)
        match = _QUANTITY.fullmatch(parts[-1])
        unit = match["units"] if match else ""
        bare = [part.removesuffix(unit).strip() for part in parts] if unit else parts
        if not all(re.fullmatch(_NUMBER, part) for part in bare):  # units of several kinds, or no quantity at all
            return [super(Quantities, self).convert(part, param, ctx) for part in _alone(value, parts)]
        super().convert(parts[-1], param, ctx)  # which says what is wrong with it in its own words
        factor = super().convert(f"1{unit}", param, ctx)
        separators = [*re.findall(r"[,:]", value), ""]
        plain = "".join(f"{part}{separator}" for part, separator in zip(bare, separators, strict=True))
        return [number * factor for number in Numbers().convert(plain, param, ctx)]


def _alone(value: str, parts: Sequence[str]) -> Sequence[str]:
    """Return the parts of a list; a range whose numbers differ in unit is left whole, and so refused."""
    return [value] if ":" in value else parts


class Numbers(click.ParamType):
    """A number, several divided by commas, or a range `start:stop:step` with both ends where they fit."""

    name = "numbers"

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        return "NUMBER|A:B:STEP|A,B,..."

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> list[float]:
        if not isinstance(value, str):
            return [float(number) for number in value]
        try:
            numbers = [number for part in value.split(",") for number in _range(part)]
        except (ValueError, ArithmeticError) as error:
            reason = str(error) if isinstance(error, _RangeError) else f"{value!r} is no number or range"
            allowed = "it must be numbers divided by commas, or start:stop:step, as 0.80:0.95:0.01"
            self.fail(f"{reason}; {allowed}", param, ctx)
        if len(numbers) > MOST_VALUES:
            self.fail(f"{value!r} has {len(numbers)} values; it must have at most {MOST_VALUES}", param, ctx)
        return numbers


class _RangeError(ValueError):
    """A range that says why it is none."""


def _range(text: str) -> list[float]:
    """Return the numbers of one part, computed in decimals: 0.8, 0.81, ... without noise."""
    if ":" not in text:
        return [parse_number(text)]
    numbers = [Decimal(part.strip()) for part in text.split(":") if math.isfinite(parse_number(part))]
    if len(numbers) != 3:
        raise _RangeError(f"{text!r} is no range of three finite numbers")
    start, stop, step = numbers
    if not (step > 0 and stop >= start):
        raise _RangeError(f"{text!r} does not rise")
    count = (stop - start) / step
    if count >= MOST_VALUES:
        raise _RangeError(f"{text!r} has more than {MOST_VALUES} values")
    return [float(start + index * step) for index in range(int(count) + 1)]


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
