"""Read numbers with units, lists and ranges: one grammar for the command line and for files.

It imports nothing heavy, so that `--help` stays quick.
"""

from __future__ import annotations

import re
from decimal import Decimal
from math import isfinite
from typing import NamedTuple

from rockdamp.vocabulary import STANDARD_GRAVITY

MOST_VALUES = 1000  # of a list or range
_G = Decimal(repr(STANDARD_GRAVITY))
GRAVITY = {"g": _G, "%g": _G / 100, "gal": Decimal("0.01"), "gals": Decimal("0.01")}  # [m s-2]


class Unit(NamedTuple):
    """A unit: its size in SI, and its powers of length, mass and time."""

    size: Decimal
    length: int
    mass: int
    time: int


def _table() -> dict[str, Unit]:
    """Return the units by their names in small letters."""
    names = {
        (1, 0, 0): "m metre meter 1, mm 0.001, cm 0.01, dm 0.1, km 1000, in inch inches 0.0254, ft foot feet 0.3048",
        (0, 1, 0): "kg 1, g 0.001, t 1000, lb 0.45359237",
        (0, 0, 1): "s sec secs second seconds 1, ms msec msecs millisecond milliseconds 0.001, min 60, h 3600",
        (1, 1, -2): "n 1, kn 1000, lbf 4.4482216152605, kip kips 4448.2216152605",
        (-1, 1, -2): "pa 1, kpa 1000, mpa 1000000, psf 47.880258980336, psi 6894.7572931684",
        (-3, 1, 0): "pcf 16.018463373960",
    }
    rows = [(powers, part.split()) for powers, text in names.items() for part in text.split(",")]
    return {name: Unit(Decimal(size), *powers) for powers, (*alike, size) in rows for name in alike}


UNITS = _table()
# The number is atomic, (?>...): of "4e-1%" the unit is "%", and not "e-1%".
_QUANTITY = re.compile(
    r"(?P<number>(?>[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?))\s*(?P<unit>[^\W\d_].*)?", re.DOTALL
)
_FEET = re.compile(
    r"(?P<feet>[0-9]+(?:\.[0-9]+)?)\s*(?:ft|feet|foot|')"
    r"(?:[\s-]*(?P<inches>[0-9]+(?:\.[0-9]+)?)\s*(?:in|inch|inches|\"|''))?"
)
_PER_CENT = re.compile(r"([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))\s*%\s*g?")
_DECIMAL_COMMA = re.compile(r"[-+]?[0-9]+,[0-9]+")
_FACTOR = re.compile(r"(?P<sign>[/*.· ]?)(?P<name>[a-z]+)(?P<power>-?[0-9])?")
_SUPERSCRIPTS = str.maketrans("⁻¹²³⁴", "-1234")


class UnitError(ValueError):
    """A text that is no quantity, list or range; says why."""


def number(text: str) -> float:
    """Return the number that a text is, finite or not; `ValueError` for none, for 1_0 and for digits beyond ASCII."""
    try:
        return float(text if text.isascii() and "_" not in text else "")
    except ValueError:
        raise ValueError(f"{text!r} is no number{as_fraction(text)}") from None


def as_fraction(text: str, wanted: str = "") -> str:
    """Say how a number in per cent is written, to end an error with; nothing of another text."""
    match = _PER_CENT.fullmatch(text.strip())
    if match is None:
        return ""
    fraction = f"{float(match[1]) / 100:g}"
    if wanted == "m s-2":
        return f"; {fraction}g is {match[1]} per cent of g"
    other = f", and {match[1]} for {100 * float(match[1]):g}%" if 0 < float(match[1]) < 1 else ""
    return f"; per cent is a fraction here, {fraction} for {match[1]}%{other}"


def parse(text: str) -> Unit | None:
    """Return the unit that a text names, or None: cm/s2, CM/SEC**2, cm/s/s, cm s-2, cm·s⁻² and cm/(s^2) are one."""
    name = re.sub(r"(\^|\*\*)(?=\(?-?\d)", "", " ".join(text.lower().translate(_SUPERSCRIPTS).split()))
    name = re.sub(r"\s*([/*.·()])\s*", r"\1", name)
    name = re.sub(r"(?<=\w)\((-?\d)\)|(?<=/)\(([a-z]+-?\d?)\)", r"\1\2", name)
    size, place = Decimal(1), 0
    powers: tuple[int, ...] = (0, 0, 0)
    while place < len(name):
        factor = _FACTOR.match(name, place)
        if factor is None or bool(factor["sign"]) != bool(place) or factor["name"] not in UNITS:
            return None
        power = int(factor["power"] or 1) * (-1 if factor["sign"] == "/" else 1)
        unit, *of_unit = UNITS[factor["name"]]
        size *= unit**power
        powers = tuple(a + power * b for a, b in zip(powers, of_unit, strict=True))
        place = factor.end()
    return Unit(size, *powers) if place else None


def _size(text: str, wanted: str) -> Decimal | None:
    """Return the size of a unit in the SI unit `wanted`; None if it is none, or of another kind."""
    target = parse(wanted)
    if wanted == "m s-2" and (name := "".join(text.lower().split())) in GRAVITY:
        return GRAVITY[name]
    unit = parse(text)
    return unit.size if unit and target and unit[1:] == target[1:] else None


def size(text: str, wanted: str) -> float | None:
    """Return the size of a unit in the SI unit `wanted`, as 0.01 for "cm/s2" in "m s-2"; None if it has none."""
    factor = _size(text, wanted)
    return None if factor is None else float(factor)


def quantity(text: str, wanted: str) -> float:
    """Return a number with its unit, or a plain one, in the SI unit `wanted`, "" for numbers without a unit.

    The number is converted in decimals: 102mm is exactly 0.102. `UnitError` says why a text is no quantity.
    """
    return float(_decimal(text, wanted, ""))


def quantities(text: str, wanted: str) -> list[float]:
    """Return the numbers of a list, `0.2,0.4`, of ranges with both ends, `0.1:0.5:0.1`, or of both, in SI.

    A number without a unit has that of the last number. Ranges are computed in decimals: 0.8, 0.81, ... without noise.
    """
    if re.search(r"(?:^|[,:])\s*[-+]?0,[0-9]", text):
        raise UnitError(f"{text!r} has a comma after 0: a comma divides a list, and the decimal sign is a point")
    units = [match["unit"] for part in re.split("[,:]", text) if (match := _QUANTITY.fullmatch(part.strip()))]
    default = (units or [""])[-1] or "" if wanted else ""
    values: list[float] = []
    for part in text.split(","):
        numbers = [_decimal(each, wanted, default) for each in part.split(":")]
        values += map(float, _range(part, numbers) if len(numbers) > 1 else numbers)
    if any(units) and not default:
        raise UnitError(f"{text!r} has a unit, but not at its last number")
    if len(values) > MOST_VALUES:
        raise UnitError(f"{text!r} has {len(values)} values, more than {MOST_VALUES}")
    return values


def _range(text: str, numbers: list[Decimal]) -> list[Decimal]:
    if len(numbers) != 3:
        raise UnitError(f"{text!r} is no range of three numbers")
    start, stop, step = numbers
    if not (float(step) > 0 and stop >= start):
        raise UnitError(f"{text!r} does not rise")
    if stop - start < step and stop > start:
        raise UnitError(f"{text!r} has a step that is longer than the range")
    count = (stop - start) / step
    if count >= MOST_VALUES:
        raise UnitError(f"{text!r} has more than {MOST_VALUES} values")
    return [start + index * step for index in range(int(count) + 1)]


def _decimal(text: str, wanted: str, default: str) -> Decimal:
    """Return a quantity in SI; `default` is the unit of a number without one, "" for SI."""
    match = _QUANTITY.fullmatch(text.strip())
    if match is None or not isfinite(float(match["number"])) or (match["unit"] and not wanted):
        slip = "; the decimal sign is a point" if _DECIMAL_COMMA.match(text.strip()) else ""
        kind = "quantity" if wanted else "number"
        raise UnitError(f"{text!r} is no finite {kind}{as_fraction(text, wanted) or slip}")
    unit = match["unit"] or default
    factor = _size(unit, wanted) if unit else Decimal(1)
    if factor is None:
        if wanted == "s" and unit.lower() == "hz" and float(match["number"]) > 0:
            raise UnitError(f"{text!r} is a frequency; its period is {1 / float(match['number']):.4g}s")
        raise UnitError(f"{text!r} is in {unit}" if parse(unit) else f"{text!r} has an unknown unit, {unit}")
    return Decimal(match["number"]) * factor


# --- sizes and loads of walls: feet and inches, densities by weight, overburdens as a force ---------------------------

BY_WEIGHT = "N m-3"
FORCE, PER_METRE, PER_AREA = "N", "N m-1", "N m-2"


def length(text: str) -> float:
    """Return a length in metres: a quantity, or feet and inches, as ``13ft 6in``."""
    match = _FEET.fullmatch(text.strip().lower())
    if match is None:
        return quantity(text, "m")
    return quantity(f"{12 * Decimal(match['feet']) + Decimal(match['inches'] or 0)}in", "m")


def density(text: str) -> float:
    """Return a density in kg m-3; a weight by volume, as ``18kN/m3``, is divided by standard gravity."""
    try:
        return quantity(text, "kg m-3")
    except UnitError as error:
        try:
            return quantity(text, BY_WEIGHT) / STANDARD_GRAVITY
        except UnitError:
            raise error from None


def overburden(text: str) -> tuple[float, int]:
    """Return a vertical load and by how many lengths it is: N (0), N m-1 of wall (1), N m-2 of its top (2).

    It must have its unit.
    """
    for lengths, unit in enumerate((FORCE, PER_METRE, PER_AREA)):
        try:
            load = quantity(text, unit)
        except UnitError:
            continue
        if _is_plain(text):
            break
        return load, lengths
    raise UnitError(f"{text!r} is no load with its unit")


def overburden_ratio(load: float, lengths: int, weight: float, width: float, thickness: float) -> float:
    """Return O/W of a load as `overburden` returns it, on a wall of that weight [N], width and thickness [m]."""
    return load * (1.0, width, width * thickness)[lengths] / weight


def _is_plain(text: str) -> bool:
    try:
        number(text)
    except ValueError:
        return False
    return True
