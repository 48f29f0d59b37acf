"""Numbers as text, in Unicode and with no-break spaces: the same serves HTML, Markdown and figures."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import SupportsFloat

DASH = "–"  # where a study is too small to define a number
MINUS = str.maketrans("-", "−")
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: SupportsFloat, digits: int = 3) -> str:
    """Write a number with some significant digits; a dash where it is not finite."""
    x = float(value)
    if not math.isfinite(x):
        return DASH
    mantissa, exponent = f"{x:.{digits - 1}e}".split("e")
    if x != 0 and not 1e-3 <= abs(x) < 1e5:  # a power of ten is shorter to read
        return f"{mantissa.translate(MINUS)}\u00a0×\u00a010{str(int(exponent)).translate(RAISED)}"
    decimals = 0 if x == int(x) else max(digits - 1 - int(exponent), 0)
    return f"{x:.{decimals}f}".translate(MINUS)


def plain(value: SupportsFloat) -> str:
    """Write a parameter as it was chosen: 0.5, not 0.500."""
    return f"{float(value):.6g}".translate(MINUS)


def percent(value: SupportsFloat, digits: int = 2) -> str:
    """Write a fraction, not negative, as a percentage; a dash where it is not finite."""
    fraction = float(value)
    if not math.isfinite(fraction):
        return DASH
    return (
        f"less than {percent(1e-4, 1)}"
        if 0 < fraction < 1e-4
        else f"{number(100 * fraction, digits)}\u00a0%"
    )


def join_words(parts: Iterable[str]) -> str:
    """Join with commas, the last with "and"."""
    *first, last = list(parts) or [""]
    return f"{', '.join(first)} and {last}" if first else last


def count_noun(count: int, noun: str) -> str:
    """Write a number of things: "1 station", "4 stations"."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
