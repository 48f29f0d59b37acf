"""Refuse sizes and loads that no wall has, and warn of unlikely ones, which a slip of units makes.

The Python objects, the command line and the config all use these checks.
"""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.errors import InputError, InputWarning
from rockdamp.vocabulary import STANDARD_GRAVITY

# ASSUME: what is built of masonry and shaken by earthquakes; the paper has no such limits. Beyond these a mistaken unit
# is likelier than the wall or the motion.
THICKEST, HIGHEST = 2.0, 30.0  # [m]
THINNEST, LOWEST = 0.05, 0.5  # what a guess must lead to [m]
MOST_DAMPED = 0.5  # damping ratio [-]
FASTEST = 4.0  # PGV; the largest recorded are near 3 [m s-1]
WEAKEST, STRONGEST = 0.005, 3.0  # PGA in g

LENGTHS = {"millimetres": 0.001, "centimetres": 0.01, "inches": 0.0254, "feet": 0.3048}  # [m]
ACCELERATIONS = {"m s-2": 1.0, "g": STANDARD_GRAVITY, "cm s-2": 0.01, "mm s-2": 0.001}  # [m s-2]

_meant: ContextVar[bool] = ContextVar("meant", default=False)


@contextmanager
def as_meant() -> Iterator[None]:
    """Give no warnings of unlikely values in the body: for studies that use such values on purpose."""
    token = _meant.set(True)
    try:
        yield
    finally:
        _meant.reset(token)


def warn(doubts: Sequence[str]) -> None:
    """Warn of each doubt by an `InputWarning` that names the first line outside this package."""
    if _meant.get():
        return
    for doubt in doubts:
        warnings.warn(doubt, InputWarning, stacklevel=_outside())


def _outside() -> int:
    """Count the frames from `warn` up to the first outside this package, as `warnings.warn` counts them."""
    level, frame = 0, inspect.currentframe()
    while frame is not None and str(frame.f_globals.get("__name__", "")).startswith("rockdamp."):
        level, frame = level + 1, frame.f_back
    # Python drops the warnings of a Snakefile, whose code has no name.
    return level if frame is not None and frame.f_globals.get("__name__") else 1


# --- walls ------------------------------------------------------------------------------------------------------------


def require_rocking(
    thickness: ArrayLike, height: ArrayLike, restitution: ArrayLike, least_slenderness: float, law: str
) -> None:
    """Raise `InputError` for walls whose h/t is below the least, or whose e, by the formula `law`, is not above 0.

    Arrays broadcast; the first such wall is named.
    """
    t, h, e = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in (thickness, height, restitution)))
    squat = h / t < least_slenderness
    bad = squat | ~(e > 0)
    if not bad.any():
        return
    first = np.unravel_index(np.argmax(bad), bad.shape)
    t, h, e, squat = t[first], h[first], e[first], squat[first]
    sizes = f"thickness is {t:g} m and height {h:g} m, which is h/t = {h / t:.3g}"
    reason = f"it must be at least {least_slenderness:g}" if squat else f"e is {e:.3g} by {law}; it must be above 0"
    raise InputError(f"{sizes}; {reason}{_slip(float(t), float(h))}")


def of_wall(thickness: ArrayLike, height: ArrayLike) -> list[str]:
    """Return a doubt where sizes [m] are larger than those of masonry walls; of arrays the largest counts."""
    t, h = _largest(thickness), _largest(height)
    sizes = (("thickness", t, THICKEST), ("height", h, HIGHEST))
    large = [(f"{name} {size:g} m", f"{most:g} m") for name, size, most in sizes if size > most]
    if not large:
        return []
    stated, limits = (" and ".join(texts) for texts in zip(*large, strict=True))
    return [f"{stated.replace(' ', ' is ', 1)}, more than {limits}{_slip(t, h)}"]


def _slip(t: float, h: float) -> str:
    """Guess the mistake that turns a usual wall into this one: swapped values, or another unit than metres."""
    if _usual(h, t):
        return "; were the two swapped?"
    if THINNEST <= t <= THICKEST and LOWEST <= h <= HIGHEST:
        return ""
    both = [unit for unit, factor in LENGTHS.items() if _usual(factor * t, factor * h)]
    if both:
        return f"; were they in {' or '.join(both)}?"
    for name, wall in (
        ("thickness", lambda factor: (factor * t, h)),
        ("height", lambda factor: (t, factor * h)),
    ):
        one = [unit for unit, factor in LENGTHS.items() if _usual(*wall(factor))]
        if one:
            return f"; was the {name} in {' or '.join(one)}?"
    return ""


def _usual(t: float, h: float) -> bool:
    return THINNEST <= t <= THICKEST and LOWEST <= h <= HIGHEST and h >= 2 * t


# --- damping and motions ----------------------------------------------------------------------------------------------


def of_damping(damping_ratio: ArrayLike) -> list[str]:
    """Return a doubt where a damping ratio is larger than that of any wall; of an array the largest counts."""
    xi = _largest(damping_ratio)
    if xi <= MOST_DAMPED:
        return []
    slip = f"; was it in per cent ({xi / 100:g})?" if xi / 100 <= MOST_DAMPED else ""
    return [f"damping_ratio (xi) is {xi:g}, more than {MOST_DAMPED:g}{slip}"]


def of_velocity(pgv: ArrayLike) -> list[str]:
    """Return a doubt where a peak ground velocity [m s-1] is larger than those of earthquakes."""
    largest = _largest(pgv)
    if largest <= FASTEST:
        return []
    slip = f"; was it in cm s-1 ({largest / 100:g})?" if largest / 100 <= FASTEST else ""
    return [f"PGV is {largest:g} m s-1, more than {FASTEST:g}{slip}"]


def of_motion(pga: float, unit: str = "m s-2", taken: float = 1.0, scale: float = 1.0) -> list[str]:
    """Return a doubt where `scale` times the PGA [m s-2] is weaker or stronger than those of relevant earthquakes.

    `unit` is the unit in which the numbers of the record were read, and `taken` is its size in m s-2.
    """
    scaled = pga * abs(scale)
    if scaled == 0 or _shakes(scaled):
        return []
    beyond = f"over {STRONGEST:g} g" if scaled > STRONGEST * STANDARD_GRAVITY else f"under {WEAKEST:g} g"
    if scale != 1:
        return [f"PGA is {scaled:.3g} m s-2, {beyond}: {pga:.3g} m s-2 times the scale of {scale:g}"]
    elsewhere = {name: pga * factor / taken for name, factor in ACCELERATIONS.items()}
    likely = [f"{name} ({value:.3g} m s-2)" for name, value in elsewhere.items() if _shakes(value)]
    cause = f"it would not be if its numbers were in {' or '.join(likely)}" if likely else "no usual unit explains it"
    return [f"PGA is {pga:.3g} m s-2, {beyond}, with its numbers taken as {unit}; {cause}"]


def of_response(peak_ratio: ArrayLike, yield_displacement_ratio: float, pga: float, onset: float) -> list[str]:
    """Return a doubt where a motion does not make a wall rock: its peaks u/u_ins stay below a1.

    `onset` is the acceleration whose static load makes the wall rock. [m s-2]
    """
    if _largest(peak_ratio) >= yield_displacement_ratio or pga == 0:
        return []
    stated = f"PGA is {pga:.3g} m s-2, where {onset:.3g} m s-2 makes it rock"
    return [f"the wall does not rock: it stays below u1, a1 = {yield_displacement_ratio:g} of u_ins; {stated}"]


def _largest(values: ArrayLike) -> float:
    return float(np.max(np.asarray(values), initial=0.0))


def _shakes(pga: float) -> bool:
    return WEAKEST * STANDARD_GRAVITY <= pga <= STRONGEST * STANDARD_GRAVITY
