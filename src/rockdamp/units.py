"""Numbers with units, as users write them on the command line, in heads of tables and in files of
records.

Inside the package all numbers are in SI. The module imports nothing heavy, so that `--help` is
quick.
"""

from __future__ import annotations

import re
from math import pi

from rockdamp.constants import STANDARD_GRAVITY

POUND = 0.45359237  # [kg]
FOOT = 0.3048  # [m]
# For each SI unit, the spellings of the units that a number may have, in capital or small letters,
# and the size of each in the SI unit. The first spelling is that of the SI unit.
UNITS: dict[str, dict[str, float]] = {
    "": {"-": 1.0, "%": 0.01},
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
INTENSITY_UNITS = {"PGV": "m s-1", "PGA": "m s-2"}  # SI units of the intensity measures

_NUMBER_AND_UNIT = re.compile(
    r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)\s*(.*?)\s*", re.IGNORECASE | re.ASCII
)
_FEET_AND_INCHES = re.compile(
    r"\s*(\d+)\s*(?:ft|')\s*(\d+(?:\.\d+)?)\s*(?:in|\")\s*", re.IGNORECASE | re.ASCII
)
_HEAD = re.compile(r"\s*([^\[(]*?)\s*(?:[\[(](.*)[\])])?\s*")


def size(text: str, unit: str) -> float | None:
    """Return the size of a unit in an SI unit, such as 0.01 for "CM/SEC**2" in "m s-2"; None if it
    is no such unit.
    """
    name = spelling(text, unit)
    return None if name is None else UNITS[unit][name]


def spelling(text: str, unit: str) -> str | None:
    """Return the spelling in `UNITS` of a unit, such as "cm/s2" for "CM/SEC**2"; None if it is no
    such unit.
    """
    folded = re.sub(r"\*\*|\^|[()]", "", text.strip().lower())
    folded = folded.replace("sec", "s").replace("²", "2").replace("³", "3")
    folded = re.sub(r"[\s·]+([a-z]+)-(\d)", r"/\1\2", folded)  # "m s-2" is "m/s2"
    folded = folded.replace(" ", "").removesuffix("1")  # "m/s1", from "m s-1", is "m/s"
    names = {name.lower(): name for name in UNITS[unit]}
    return names.get(folded)


def quantity(text: str, unit: str = "") -> float:
    """Return a number in an SI unit.

    Parameters
    ----------
    text : str
        Plain number, in the SI unit, or a number with one of the spellings in `UNITS`; a length may
        be ``13ft 6in``.
    unit : str
        SI unit, a key of `UNITS`.

    Returns
    -------
    float
        Number in the SI unit. A conversion keeps fifteen digits: ``102mm`` is exactly 0.102.

    Raises
    ------
    ValueError
        If the text is no number, has another unit or a decimal comma.
    """
    value = _parse(text, unit)
    if value is not None:
        return value
    if _parse(text.replace(",", "."), unit) is not None:
        raise ValueError(f"{text!r} has a decimal comma; the decimal sign must be a point")
    in_unit = f" in {unit}" if unit else ""
    spellings = ", ".join(UNITS[unit])
    raise ValueError(f"{text!r} must be a number{in_unit}, or a number with a unit ({spellings})")


def _parse(text: str, unit: str) -> float | None:
    """Return a number in an SI unit; None for a text that is none."""
    feet = _FEET_AND_INCHES.fullmatch(text)
    if feet and unit == "m":
        return _round(float(feet[1]) * FOOT + float(feet[2]) * FOOT / 12)
    match = _NUMBER_AND_UNIT.fullmatch(text)
    if match is None:
        return None
    value = float(match[1])
    factor = size(match[2], unit) if match[2] else 1.0
    if factor is None:
        return None
    return value if factor == 1 else _round(value * factor)


def _round(value: float) -> float:
    return float(f"{value:.15g}")


def quantities(text: str, unit: str = "") -> list[float]:
    """Return the numbers of a list, such as ``0.2g,0.4g``, in an SI unit; all must have a unit, or
    none.
    """
    # "0,25" is a number with a decimal comma rather than a list of 0 and 25.
    if re.fullmatch(r"\s*0,\d+\s*", text):
        raise ValueError(f"{text!r} has a decimal comma; the decimal sign must be a point")
    parts = text.split(",")
    ends_with_digit = {part.strip()[-1:].isdigit() for part in parts}
    if len(ends_with_digit) > 1:
        raise ValueError(
            f"{text!r} must have a unit at each number, or at none; "
            "the decimal sign must be a point"
        )
    return [quantity(part, unit) for part in parts]


def stated_unit(text: str, unit: str) -> str:
    """Return the spelling of the unit of a list of numbers; the SI unit if the list states none."""
    match = _NUMBER_AND_UNIT.fullmatch(text.partition(",")[0])
    name = spelling(match[2], unit) if match and match[2] else None
    return next(iter(UNITS[unit])) if name is None else name


def intensity_unit(measure: str, unit: str | None = None) -> tuple[str, float]:
    """Return the unit of an intensity measure, and its size in SI.

    Parameters
    ----------
    measure : {"pga", "pgv"}
        Intensity measure.
    unit : str, optional
        Unit. Default: g for a PGA and m/s for a PGV.
    """
    if unit is None:
        unit = "g" if measure == "pga" else "m/s"
    return unit, quantity(f"1 {unit}", INTENSITY_UNITS[measure.upper()])


def name_and_unit(head: str) -> tuple[str, str]:
    """Return the name and the unit of a column from its head, ``thickness [mm]`` or ``time (s)``;
    "" for no unit.
    """
    match = _HEAD.fullmatch(head)
    if match is None:
        return head, ""
    return match[1], match[2] or ""
