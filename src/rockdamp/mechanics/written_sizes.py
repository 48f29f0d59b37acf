"""Sizes and loads of walls as people write them: feet and inches, densities by weight, overburdens as a force."""

from __future__ import annotations

import re
from decimal import Decimal

from rockdamp import units
from rockdamp.units import UnitError
from rockdamp.vocabulary import STANDARD_GRAVITY

_FEET = re.compile(
    r"(?P<feet>[0-9]+(?:\.[0-9]+)?)\s*(?:ft|feet|foot|')"
    r"(?:[\s-]*(?P<inches>[0-9]+(?:\.[0-9]+)?)\s*(?:in|inch|inches|\"|''))?"
)
BY_WEIGHT = "N m-3"
FORCE, PER_METRE, PER_AREA = "N", "N m-1", "N m-2"


def length(text: str) -> float:
    """Return a length in metres: a quantity, or feet and inches, as ``13ft 6in``."""
    match = _FEET.fullmatch(text.strip().lower())
    if match is None:
        return units.quantity(text, "m")
    return units.quantity(f"{12 * Decimal(match['feet']) + Decimal(match['inches'] or 0)}in", "m")


def density(text: str) -> float:
    """Return a density in kg m-3; a weight by volume, as ``18kN/m3``, is divided by standard gravity."""
    try:
        return units.quantity(text, "kg m-3")
    except UnitError as error:
        try:
            return units.quantity(text, BY_WEIGHT) / STANDARD_GRAVITY
        except UnitError:
            raise error from None


def overburden(text: str) -> tuple[float, int]:
    """Return a vertical load and by how many lengths it is: N (0), N m-1 of wall (1), N m-2 of its top (2).

    It must have its unit.
    """
    for lengths, unit in enumerate((FORCE, PER_METRE, PER_AREA)):
        try:
            load = units.quantity(text, unit)
        except UnitError:
            continue
        if _is_plain(text):
            break
        return load, lengths
    raise UnitError(f"{text!r} is no load with its unit")


def overburden_ratio(load: float, lengths: int, weight: float, width: float, thickness: float) -> float:
    """Return O/W of a load as `overburden` returns it, on a wall of that weight [N], width and thickness [m]."""
    return load * (1.0, width, width * thickness)[lengths] / weight


def of_ties(text: str, unit: str) -> tuple[float, bool]:
    """Return a stiffness (``N m-1``) or strength (``N``) of ties and whether it is by metre of wall.

    A number without a unit is of all ties together.
    """
    try:
        return units.quantity(text, {FORCE: PER_METRE, PER_METRE: "N m-2"}[unit]), not _is_plain(text)
    except UnitError:
        return units.quantity(text, unit), False


def _is_plain(text: str) -> bool:
    try:
        units.number(text)
    except ValueError:
        return False
    return True
