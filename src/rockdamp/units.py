"""Numbers with a unit: on the command line, in heads of tables and in files of records. Inside the package all is SI.

It imports nothing heavy, so that `--help` stays quick.
"""

from __future__ import annotations

import re
from math import pi

from rockdamp.constants import STANDARD_GRAVITY

POUND, FOOT = 0.45359237, 0.3048  # [kg], [m]
# By the SI unit: the spellings that a number may have, in capital or small letters, and their sizes.
UNITS: dict[str, dict[str, float]] = {
    "": {"%": 0.01, "-": 1.0},
    "m": {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": FOOT / 12, "ft": FOOT},
    "s": {"s": 1.0, "ms": 0.001, "min": 60.0},
    "rad": {"rad": 1.0, "mrad": 0.001, "deg": pi / 180},
    "m s-1": {"m/s": 1.0, "cm/s": 0.01, "mm/s": 0.001, "in/s": FOOT / 12},
    "m s-2": {
        "m/s2": 1.0,
        "m/s/s": 1.0,
        "cm/s2": 0.01,
        "cm/s/s": 0.01,
        "mm/s2": 0.001,
        "mm/s/s": 0.001,
        "g": STANDARD_GRAVITY,
        "%g": STANDARD_GRAVITY / 100,
        "mg": STANDARD_GRAVITY / 1000,
        "Gal": 0.01,
        "in/s2": FOOT / 12,
    },
    "kg m-3": {
        "kg/m3": 1.0,
        "t/m3": 1000.0,
        "g/cm3": 1000.0,
        "kN/m3": 1000 / STANDARD_GRAVITY,
        "lb/ft3": POUND / FOOT**3,
    },
    "N m-1": {"N/m": 1.0, "kN/m": 1000.0, "lb/ft": POUND * STANDARD_GRAVITY / FOOT},
}
_NUMBER = re.compile(
    r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)\s*(.*?)\s*", re.IGNORECASE | re.ASCII
)
_FEET = re.compile(
    r"\s*(\d+)\s*(?:ft|')\s*(\d+(?:\.\d+)?)\s*(?:in|\")\s*", re.IGNORECASE | re.ASCII
)
_HEAD = re.compile(r"\s*([^\[(]*?)\s*(?:[\[(](.*)[\])])?\s*")


def size(text: str, unit: str) -> float | None:
    """Return the size of a unit in the SI unit, as 0.01 for "CM/SEC**2" in "m s-2"; None for another unit."""
    folded = (
        re.sub(r"\*\*|\^|[()]", "", text.strip().lower())
        .replace("sec", "s")
        .replace("²", "2")
        .replace("³", "3")
    )
    folded = re.sub(r"[\s·]+([a-z]+)-(\d)", r"/\1\2", folded).replace(" ", "")  # of "m s-2"
    return {spelling.lower(): value for spelling, value in UNITS[unit].items()}.get(
        folded.removesuffix("1")
    )


def quantity(text: str, unit: str = "") -> float:
    """Return a number in the SI unit: a plain one, or with one of its `UNITS`; a length may be ``13ft 6in``.

    Of a conversion fifteen digits are kept: ``102mm`` is exactly 0.102.
    """
    if unit == "m" and (feet := _FEET.fullmatch(text)):
        return float(f"{float(feet[1]) * FOOT + float(feet[2]) * FOOT / 12:.15g}")
    match = _NUMBER.fullmatch(text)
    factor = None if match is None else size(match[2], unit) if match[2] else 1.0
    if match is None or factor is None:
        raise ValueError(
            f"{text!r} must be a number{f' in {unit}' if unit else ''}, or one with {', '.join(UNITS[unit])}"
        )
    value = float(match[1])
    return value if factor == 1 else float(f"{value * factor:.15g}")


def quantities(text: str, unit: str = "") -> list[float]:
    """Return the numbers of a list, ``0.2g,0.4g``, in the SI unit; all have a unit, or none has."""
    parts = text.split(",")
    if len({part.strip()[-1:].isdigit() for part in parts}) > 1:
        raise ValueError(f"{text!r} must have a unit at each number, or at none")
    return [quantity(part, unit) for part in parts]


def name_and_unit(head: str) -> tuple[str, str]:
    """Return the name and the unit of a column's head: ``thickness [mm]``, ``time (s)``; "" where it has none."""
    match = _HEAD.fullmatch(head)
    return (match[1], match[2] or "") if match else (head, "")
