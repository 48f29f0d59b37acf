"""Numbers as text, with Unicode signs and no-break spaces, for HTML, Markdown and figures alike."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import SupportsFloat

DASH = "–"  # replaces a number that is not finite, where a study is too small to define it
NO_BREAK_SPACE = "\u00a0"

_MINUS = str.maketrans("-", "−")
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: SupportsFloat, digits: int = 3) -> str:
    """Write a number with `digits` significant digits; a dash if it is not finite."""
    x = float(value)
    if not math.isfinite(x):
        return DASH
    mantissa, exponent = f"{x:.{digits - 1}e}".split("e")
    if x != 0 and not 1e-3 <= abs(x) < 1e5:  # beyond these a power of ten is shorter to read
        power = str(int(exponent)).translate(_RAISED)
        parts = (mantissa.translate(_MINUS), "×", f"10{power}")
        return NO_BREAK_SPACE.join(parts)
    decimals = 0 if x == int(x) else max(digits - 1 - int(exponent), 0)
    return f"{x:.{decimals}f}".translate(_MINUS)


def plain(value: SupportsFloat) -> str:
    """Write a parameter as it was chosen: 0.5, not 0.500."""
    return f"{float(value):.6g}".translate(_MINUS)


def percent(value: SupportsFloat, digits: int = 2) -> str:
    """Write a fraction that is not negative as a percentage; a dash if it is not finite."""
    fraction = float(value)
    if not math.isfinite(fraction):
        return DASH
    if 0 < fraction < 1e-4:
        return f"less than {percent(1e-4, 1)}"
    return f"{number(100 * fraction, digits)}{NO_BREAK_SPACE}%"


def join_words(words: Iterable[str]) -> str:
    """Join words with commas, the last with "and"."""
    *first, last = list(words) or [""]
    return f"{', '.join(first)} and {last}" if first else last


def count_noun(count: int, noun: str) -> str:
    """Write a count with its noun: "1 station", "4 stations"."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
