"""Units that a file may state of itself: each is believed, which means converted or compared, or refused."""

from __future__ import annotations

import re

from rockdamp.errors import InputError
from rockdamp.vocabulary import STANDARD_GRAVITY

SECONDS = {"s": 1.0, "sec": 1.0, "secs": 1.0, "second": 1.0, "seconds": 1.0}
TIMES = SECONDS | {"ms": 1e-3, "msec": 1e-3, "msecs": 1e-3, "millisecond": 1e-3, "milliseconds": 1e-3}  # in s
LENGTHS = {"mm": 1e-3, "cm": 1e-2, "dm": 0.1, "m": 1.0, "in": 0.0254, "inch": 0.0254, "inches": 0.0254}  # in m
LENGTHS |= {"ft": 0.3048, "feet": 0.3048}
GRAVITY = {"g": STANDARD_GRAVITY, "gal": 1e-2, "gals": 1e-2}  # in m s-2

# cm/s2, CM/SEC**2, cm/s/s, cm s-2, cm·s⁻², cm/(s2)
_SECOND = rf"(?:{'|'.join(sorted(SECONDS, key=len, reverse=True))})"
_POWER = r"(?:\^|\*\*)?"
_ACCELERATION = re.compile(
    rf"(?P<length>{'|'.join(sorted(LENGTHS, key=len, reverse=True))})"
    rf"(?:/{_SECOND}(?:{_POWER}2|²|/{_SECOND})|/\({_SECOND}{_POWER}2\)|[ *.·]?{_SECOND}(?:{_POWER}(?:-2|\(-2\))|⁻²))"
)


def acceleration(text: str) -> float | None:
    """Return an acceleration's unit in m s-2, or None where the text names none."""
    name = re.sub(r"\s*([/*^·.()])\s*", r"\1", " ".join(text.lower().split()))
    match = _ACCELERATION.fullmatch(name)
    return GRAVITY.get(name) if match is None else LENGTHS[match["length"]]


def velocity(text: str) -> float | None:
    """Return a velocity's unit in m s-1, or None where the text names none."""
    name = " ".join(text.lower().split())
    length, mark, second = name.partition("/") if "/" in name else name.removesuffix("-1").partition(" ")
    known = length.strip() in LENGTHS and mark and second.strip() in SECONDS
    return LENGTHS[length.strip()] if known else None


def time(text: str) -> float | None:
    """Return a time's unit in s, or None where the text names none."""
    return TIMES.get(text.strip().lower())


def length(text: str) -> float | None:
    """Return a length's unit in m, or None where the text names none."""
    return LENGTHS.get(text.strip().lower())


def require_stated(stated: str, of_acceleration: str, remedy: str) -> None:
    """Check a list of units, ``s, m s-2, m``, against those that the numbers are taken in: s, that one, and m.

    Raises
    ------
    InputError
        If one of them is another, or no unit of time, acceleration or length.
    """
    for name in re.split("[,;]", stated):
        known = (time(name) == 1, acceleration(name) == acceleration(of_acceleration), length(name) == 1)
        if not any(known):
            wrong = f"has {name.strip()!r}; the numbers are taken in s, {of_acceleration} and m: {remedy}"
            raise InputError(f"units is {stated!r} and {wrong}")
