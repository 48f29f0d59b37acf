"""Refuse sizes and loads that no wall has, and warn of unlikely ones, which a slip of units makes.

The Python objects, the command line and the config all use these checks.
"""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

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
LIGHTEST, HEAVIEST = 300.0, 3500.0  # aerated concrete and dense stone [kg m-3]
MOST_LOADED = 10.0  # O/W; the paper's tested wall, a thin leaf under the storeys of a building, has 6.2
LEAST_LOADED = 0.05  # what a guess must lead to
LEAST_PER_CENT = 5.0  # a fraction above 1 and below it is likelier a slip of a digit

LENGTHS = {"millimetres": 0.001, "centimetres": 0.01, "inches": 0.0254, "feet": 0.3048}  # [m]
DENSITIES = {"kN m-3": 1000 / STANDARD_GRAVITY, "t m-3": 1000.0, "lb ft-3": 0.45359237 / 0.3048**3}  # [kg m-3]
DENSITIES |= {"N m-3": 1 / STANDARD_GRAVITY}
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


def of_density(density: ArrayLike) -> list[str]:
    """Return a doubt where a density [kg m-3] is none of masonry; of an array the first such element is named."""
    values = np.ravel(np.asarray(density, dtype=float))
    odd = values[(values < LIGHTEST) | (values > HEAVIEST)]
    if not odd.size:
        return []
    value = float(odd[0])
    beyond = f"less than {LIGHTEST:g}" if value < LIGHTEST else f"more than {HEAVIEST:g}"
    meant = {unit: value * factor for unit, factor in DENSITIES.items()}
    likely = [f"{unit} ({kg:.4g} kg m-3)" for unit, kg in meant.items() if LIGHTEST <= kg <= HEAVIEST]
    return [f"density is {value:g} kg m-3, {beyond}{_question(likely)}"]


def of_overburden(overburden_ratio: ArrayLike, weight: ArrayLike) -> list[str]:
    """Return a doubt where O/W is larger than few walls have; `weight` is the wall's own per metre. [N m-1]"""
    ratios, weights = np.broadcast_arrays(np.asarray(overburden_ratio, dtype=float), np.asarray(weight, dtype=float))
    first = int(np.argmax(ratios))
    ratio, per_metre = float(ratios.flat[first]), float(weights.flat[first])
    if ratio <= MOST_LOADED:
        return []
    meant = {"kN per metre": 1000 * ratio / per_metre, "N per metre": ratio / per_metre, "per cent": ratio / 100}
    likely = [f"{unit} (O/W {value:.3g})" for unit, value in meant.items() if LEAST_LOADED <= value <= MOST_LOADED]
    stated = f"overburden_ratio is {ratio:g} times the wall's weight, more than {MOST_LOADED:g}"
    return [f"{stated}{_question(likely)}"]


def per_cent(value: ArrayLike, within: Callable[[Any], Any]) -> str:
    """Return a question to end an error with, where the first value out of its range is within it as a percentage."""
    values = np.ravel(np.asarray(value, dtype=float))
    bad = values[~np.asarray(within(values), dtype=bool)]
    if not bad.size or not LEAST_PER_CENT <= bad[0] <= 100 or not within(bad[0] / 100):
        return ""
    return f"; was it in per cent ({bad[0] / 100:g})?"


def _question(likely: Sequence[str]) -> str:
    return f"; was it in {' or '.join(likely)}?" if likely else ""


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
    stated = f"PGA is {in_g(pga)}, where {in_g(onset)} makes it rock{was_g(pga, onset)}"
    return [f"the wall does not rock: it stays below u1, a1 = {yield_displacement_ratio:g} of u_ins; {stated}"]


def of_level(pga: ArrayLike, onset: float, level: str = "", walls: str = "the wall") -> list[str]:
    """Return a doubt where no intensity asked for reaches the onset of rocking.

    `pga` holds the strongest record's at each intensity, and `onset` is the acceleration whose static load makes the
    wall rock [m s-2]. `level` describes the intensity where that is no PGA: "PGV is 0.02 m s-1, and".
    """
    strongest = _largest(pga)
    if strongest >= onset:
        return []
    # A number that was typed in g is no round one in m s-2.
    typed = bool(np.isclose(strongest, float(f"{strongest:.3g}"), rtol=1e-9))
    question = was_g(strongest, onset) if typed and not level else ""
    return [f"{level} PGA is {in_g(strongest)}; {walls} begins to rock at {in_g(onset)}{question}".strip()]


def in_g(acceleration: float) -> str:
    """Write an acceleration [m s-2] in both units."""
    return f"{acceleration:.3g} m s-2 ({acceleration / STANDARD_GRAVITY:.3g} g)"


def was_g(pga: float, onset: float) -> str:
    """Ask whether a number taken in m s-2 was meant in g, where that would make the wall rock."""
    meant = pga * STANDARD_GRAVITY
    return f"; was it in g ({pga:.3g} g)?" if meant >= onset and _shakes(meant) else ""


def _largest(values: ArrayLike) -> float:
    return float(np.max(np.asarray(values), initial=0.0))


def _shakes(pga: float) -> bool:
    return WEAKEST * STANDARD_GRAVITY <= pga <= STRONGEST * STANDARD_GRAVITY
