"""Numbers as readers take them in: few digits, powers of ten written out, lists with their models."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import SupportsFloat

from markupsafe import Markup

LEAST = 1e-4  # a smaller fraction is told as less than that
SMALL, LARGE = 1e-3, 1e5  # beyond these a power of ten is shorter to read


def number(value: SupportsFloat, digits: int = 3) -> Markup:
    """Return a number with some significant digits, as HTML."""
    x = float(value)
    if x == 0 or not math.isfinite(x):
        return Markup("0" if x == 0 else "not defined")
    mantissa, exponent = f"{x:.{digits - 1}e}".split("e")
    if SMALL <= abs(x) < LARGE:
        if x == int(x):
            return Markup(str(int(x)).replace("-", "−"))
        decimals = max(digits - 1 - int(exponent), 0)
        return Markup(f"{x:.{decimals}f}".replace("-", "−"))
    power = str(int(exponent)).replace("-", "−")
    return Markup(f"{mantissa.replace('-', '−')}&nbsp;×&nbsp;10<sup>{power}</sup>")


def plain(value: SupportsFloat) -> str:
    """Return a parameter as it was chosen: 0.5, not 0.500."""
    return f"{float(value):.6g}".replace("-", "−")


def percent(value: SupportsFloat, digits: int = 2) -> Markup:
    """Return a fraction, not negative, as a percentage."""
    if 0 < float(value) < LEAST:
        return Markup("less than {}").format(percent(LEAST, 1))
    return Markup("{}&nbsp;%").format(number(100 * float(value), digits))


def listed(parts: Iterable[str]) -> Markup:
    """Join with commas, the last with "and"."""
    parts = list(parts)
    if len(parts) < 2:
        return Markup("").join(parts)
    return Markup("{} and {}").format(Markup(", ").join(parts[:-1]), parts[-1])


def of_models(values: Mapping[str, str]) -> Markup:
    """Name the model of each value: "0.029 (CDC), 0.045 (CDR)"."""
    return listed(Markup("{} ({})").format(value, model) for model, value in values.items())


def ranges(values: Sequence[float], holds: Sequence[bool]) -> Markup:
    """Say at which of ascending values something holds: "0.80 to 0.91 and 0.95"; "none" where nowhere."""
    runs: list[list[float]] = []
    before = False
    for value, now in zip(values, holds, strict=True):
        if now and before:
            runs[-1].append(value)
        elif now:
            runs.append([value])
        before = bool(now)
    if not runs:
        return Markup("none")
    return listed(f"{run[0]:.2f}" if len(run) == 1 else f"{run[0]:.2f} to {run[-1]:.2f}" for run in runs)
