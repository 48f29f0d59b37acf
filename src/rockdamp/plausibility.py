"""Refuse sizes and loads that no wall has, and warn of unlikely ones, which a slip of units makes.

The Python objects, the command line and the config all use these checks.
"""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
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
TOO_THICK, TOO_HIGH = 100.0, 1000.0  # refused: of these there is neither a wall nor a building [m]
SLENDEREST = 40.0  # h/t; tests went to 28
LEAST_YIELD, LARGEST_YIELD = 0.002, 0.4  # a1; presets have 0.06 to 0.2, with b1 of 0.5 and more; a hundredth of 0.2
LEAST_STRENGTH = 0.3  # b1; the presets have 0.5 to 0.72, and calibrations search from 0.4
WIDEST = 100.0  # [m]
EASIEST_OF_LOADED = 1.5  # onset of rocking of walls in g; those of the config reach 1.25
LEAST_ELASTIC = 0.5  # e; the losses of a factor of two in velocity, beyond every test that is quoted here
MOST_OF_RIGID = 1.1  # e over that of rigid mechanics; tests of walls and blocks gave 0.85 to 1.03
LEAST_DAMPED = 0.001  # damping ratio; a hundredth of a tenth. A constant C has 0.002 at e = 0.98 and a1 = 0.02
MOST_DAMPED, MOST_FADING = 0.5, 1.0  # damping ratio; exponent g, of which blocks and walls have far less
FASTEST = 4.0  # PGV; the largest recorded are near 3 [m s-1]
WEAKEST, STRONGEST = 0.005, 3.0  # PGA in g
STRONGEST_IN_G = 1.2  # PGA of a file whose numbers are said to be in g; m s-2 under that name are likelier above it
STRONGEST_ASKED = 2.0  # PGA that a wall is assessed at, in g; maps and codes stay below
SHORTEST_STEP, LONGEST_STEP = 2e-5, 0.1  # between samples of a record; usual are 0.0001 to 0.02 [s]
LIGHTEST, HEAVIEST = 300.0, 3500.0  # aerated concrete and dense stone [kg m-3]
MOST_LOADED = 10.0  # O/W; the paper's tested wall, a thin leaf under the storeys of a building, has 6.2
LEAST_LOADED, LIGHTEST_LOAD = 0.05, 0.01  # O/W that a guess must lead to; of a load: no floor or roof weighs less
LEAST_PER_CENT = 5.0  # a fraction above 1 and below it is likelier a slip of a digit

LENGTHS = {"millimetres": 0.001, "centimetres": 0.01, "inches": 0.0254, "feet": 0.3048}  # [m]
DENSITIES = {"kN m-3": 1000 / STANDARD_GRAVITY, "t m-3": 1000.0, "lb ft-3": 0.45359237 / 0.3048**3}  # [kg m-3]
DENSITIES |= {"N m-3": 1 / STANDARD_GRAVITY}
ACCELERATIONS = {"m s-2": 1.0, "g": STANDARD_GRAVITY, "cm s-2": 0.01, "mm s-2": 0.001}  # [m s-2]
PER_CENT_OF_G = {"per cent of g": STANDARD_GRAVITY / 100}  # [m s-2]

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
    """Warn of each by an `InputWarning` that names the first line outside this package."""
    if _meant.get():
        return
    for doubt in doubts:
        warnings.warn(doubt, InputWarning, stacklevel=_outside())


def called_from_outside() -> bool:
    """Return True if the function that asks this was called from outside this package, or by its public name."""
    frame: Any = inspect.currentframe()
    return not str(frame.f_back.f_back.f_globals.get("__name__", "")).startswith("rockdamp.")


def _outside() -> int:
    """Count the frames from `warn` up to the first outside this package, as `warnings.warn` counts them."""
    level, frame = 0, inspect.currentframe()
    while frame is not None and str(frame.f_globals.get("__name__", "")).partition(".")[0] == "rockdamp":
        level, frame = level + 1, frame.f_back
    # Python drops the warnings of a Snakefile, whose code has no name.
    return level if frame is not None and frame.f_globals.get("__name__") else 1


# --- walls ------------------------------------------------------------------------------------------------------------


def require_rocking(
    thickness: ArrayLike, height: ArrayLike, restitution: ArrayLike, least_slenderness: float, law: str
) -> None:
    """Raise `InputError` for walls that cannot be; arrays broadcast, and the first such wall is named.

    That is, thicker or higher than any building, or with h/t below the least, or e, by the formula `law`, not above 0.
    """
    t, h, e = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in (thickness, height, restitution)))
    squat = h / t < least_slenderness
    huge = (t > TOO_THICK) | (h > TOO_HIGH)
    bad = squat | huge | ~(e > 0)
    if not bad.any():
        return
    first = np.unravel_index(np.argmax(bad), bad.shape)
    t, h, e, squat, huge = t[first], h[first], e[first], squat[first], huge[first]
    sizes = f"thickness is {t:g} m and height {h:g} m, which is h/t = {h / t:.3g}"
    reason = f"it must be at least {least_slenderness:g}" if squat else f"e is {e:.3g} by {law}; it must be above 0"
    if huge and not squat:
        sizes = f"thickness is {t:g} m and height {h:g} m"
        reason = f"they must be at most {TOO_THICK:g} m and {TOO_HIGH:g} m"
    raise InputError(f"{sizes}; {reason}{_slip(float(t), float(h))}")


def of_wall(thickness: ArrayLike, height: ArrayLike) -> list[str]:
    """Return a warning where sizes [m], or h/t, are larger than those of masonry; of arrays the largest counts."""
    t, h, slenderness = _largest(thickness), _largest(height), _largest(np.divide(height, thickness))
    sizes = (("thickness", t, THICKEST), ("height", h, HIGHEST))
    large = [(f"{name} {size:g} m", f"{most:g} m") for name, size, most in sizes if size > most]
    if not large and slenderness > SLENDEREST:
        feet = LENGTHS["feet"] * h
        slip = f"; was the height in feet ({feet:.3g} m)?" if _usual(t, feet) and feet <= SLENDEREST * t else ""
        slip = f"; was the thickness in m ({1000 * t:g} m)?" if t < THINNEST and _usual(1000 * t, h) else slip
        return [f"height over thickness is {slenderness:.3g}, more than {SLENDEREST:g}{slip}"]
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
            width = ", or is it the wall's width" if name == "thickness" and t <= HIGHEST else ""
            return f"; was the {name} in {' or '.join(one)}{width}?"
    return ""


def _usual(t: float, h: float) -> bool:
    return THINNEST <= t <= THICKEST and LOWEST <= h <= HIGHEST and h >= 2 * t


def of_density(density: ArrayLike) -> list[str]:
    """Return a warning where a density [kg m-3] is none of masonry; of an array the first such element is named."""
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
    """Return a warning where O/W is none that a load has; `weight` is the wall's own per metre. [N m-1]"""
    ratios, weights = np.broadcast_arrays(np.asarray(overburden_ratio, dtype=float), np.asarray(weight, dtype=float))
    if not ratios.size:
        return []
    first = int(np.argmax(ratios))
    ratio, per_metre = float(ratios.flat[first]), float(weights.flat[first])
    if 0 < ratio <= LIGHTEST_LOAD:
        meant = {f"{100 * ratio:.3g}": 100 * ratio, f"in kN (O/W {1000 * ratio:.3g})": 1000 * ratio}
        slips = " or ".join(slip for slip, value in meant.items() if LEAST_LOADED <= value <= MOST_LOADED)
        stated = f"overburden_ratio is {ratio:.2g} times the wall's weight, hardly a load"
        return [f"{stated}; was it {slips}?" if slips else stated]
    if ratio <= MOST_LOADED:
        return []
    meant = {"kN per metre": 1000 * ratio / per_metre, "N per metre": ratio / per_metre, "per cent": ratio / 100}
    likely = [f"{unit} (O/W {value:.3g})" for unit, value in meant.items() if LEAST_LOADED <= value <= MOST_LOADED]
    stated = f"overburden_ratio is {ratio:g} times the wall's weight, more than {MOST_LOADED:g}"
    return [f"{stated}{_question(likely)}"]


def of_curve(yield_displacement_ratio: ArrayLike, strength_ratio: ArrayLike = 1.0) -> list[str]:
    """Return warnings where a curve's first branch, or its plateau, is none of a wall; of arrays, where all are so."""
    stated, a1, b1 = "yield_displacement_ratio (a1) is", _least(yield_displacement_ratio), _largest(strength_ratio)
    if LARGEST_YIELD < a1 < np.inf:  # of an empty array it is infinite
        return [f"{stated} {a1:g}, more than {LARGEST_YIELD:g}; were a1 and b1 swapped?"]
    a1 = _largest(yield_displacement_ratio)
    rigid = f"{stated} {a1:g}, less than {LEAST_YIELD:g}: nearly a rigid block; was it {100 * a1:g}?"
    weak = f"strength_ratio (b1) is {b1:g}, less than {LEAST_STRENGTH:g}; the most degraded joints have 0.5"
    return [rigid] * (0 < a1 < LEAST_YIELD) + [weak] * (0 < b1 < LEAST_STRENGTH)


def of_width(width: ArrayLike, thickness: ArrayLike) -> list[str]:
    """Return a warning where a wall is wider than buildings, or narrower than a metre and than it is thick [m]."""
    widest, narrowest, thinnest = _largest(width), _least(width), _least(thickness)
    if narrowest < 1 and narrowest <= thinnest:
        stated, of_both = f"width is {narrowest:g} m", f"than the thickness of {thinnest:g} m"
        less = narrowest < thinnest
        return [f"{stated}, less {of_both}; were the two swapped?" if less else f"{stated}, no more {of_both}"]
    return [f"width is {widest:g} m, more than {WIDEST:g}; was it in millimetres?"] if widest > WIDEST else []


def of_onset(onset: ArrayLike) -> list[str]:
    """Return a warning where no earthquake makes a rigid wall rock."""
    value = float(np.min(onset))
    if value <= STRONGEST * STANDARD_GRAVITY:
        return []
    return [f"a rigid wall begins to rock at {in_g(value)}; are the overburden and the sizes right?"]


def per_cent(value: ArrayLike, within: Callable[[Any], Any], least: float = LEAST_PER_CENT) -> str:
    """Return a question to end an error with, where the first value out of its range is within it as a percentage."""
    values = np.ravel(np.asarray(value, dtype=float))
    bad = values[~np.asarray(within(values), dtype=bool)]
    if not bad.size or not least <= bad[0] <= 100 or not within(bad[0] / 100):
        return ""
    return f"; was it in per cent ({bad[0] / 100:g})?"


def _question(likely: Sequence[str]) -> str:
    return f"; was it in {' or '.join(likely)}?" if likely else ""


# --- damping and motions ----------------------------------------------------------------------------------------------


def of_damping(damping_ratio: ArrayLike) -> list[str]:
    """Return a warning where a damping ratio is none of a wall, or two slips of per cent; the largest counts."""
    xi = _largest(damping_ratio)
    if 0 < xi < LEAST_DAMPED:
        return [f"damping_ratio (xi) is {xi:g}, less than {LEAST_DAMPED:g}; was it {100 * xi:g}?"]
    if xi <= MOST_DAMPED:
        return []
    slip = f"; was it in per cent ({xi / 100:g})?" if xi / 100 <= MOST_DAMPED else ""
    slip = "; was it a coefficient of restitution (e)?" if xi < 1 else slip
    return [f"damping_ratio (xi) is {xi:g}, more than {MOST_DAMPED:g}{slip}"]


def of_dampings(dampings: Sequence[Any]) -> list[str]:
    """Return the warnings about the parameters of dampers."""
    doubts = of_damping([_largest(damping.value) for damping in dampings if damping.model != "CR"])
    doubts += of_exponent([_largest(damping.loss_exponent) for damping in dampings])
    return doubts + of_restitution([_least(damping.value) for damping in dampings if damping.model == "CR"])


def of_exponent(exponent: ArrayLike) -> list[str]:
    """Return a warning where the loss falls with the amplitude as none does; of an array the largest counts. [-]"""
    g = _largest(exponent)
    if g <= MOST_FADING:
        return []
    return [f"exponent (g) is {g:g}, more than {MOST_FADING:g}: a large impact then loses hardly anything"]


def of_restitution(restitution: ArrayLike) -> list[str]:
    """Return a warning where a restitution is less than that of any wall; of an array the least counts. [-]"""
    e = _least(restitution)
    if e >= LEAST_ELASTIC:
        return []
    return [f"restitution (e) is {e:g}, less than {LEAST_ELASTIC:g}; was it a damping ratio (xi)?"]


def of_sizes(restitution: ArrayLike, rigid: ArrayLike) -> list[str]:
    """Return a warning where e is far above what rigid mechanics gives for a wall's sizes; of arrays, for all. [-]"""
    e, most = _least(restitution), _largest(rigid)
    if e <= MOST_OF_RIGID * most or e == np.inf or not most:  # of empty arrays
        return []
    stated = f"restitution (e) is {e:g}, {e / most:.2g} times that of rigid mechanics, {most:.3g}"
    return [f"{stated}; are thickness and height right?"]


def of_velocity(pgv: ArrayLike) -> list[str]:
    """Return a warning where a peak ground velocity [m s-1] is larger than those of earthquakes."""
    largest = _largest(pgv)
    if largest <= FASTEST:
        return []
    units = {"cm s-1": largest / 100, "mm s-1": largest / 1000}
    likely = [f"{unit} ({value:g} m s-1)" for unit, value in units.items() if 0.1 <= value <= FASTEST]
    return [f"PGV is {largest:g} m s-1, more than {FASTEST:g}{_question(likely)}"]


def of_supports(acceleration: ArrayLike) -> list[str]:
    """Return a warning where the supports of a wall in a building shake more than any earthquake makes them [m s-2]."""
    strongest = _largest(acceleration)
    if strongest <= STRONGEST * STANDARD_GRAVITY:
        return []
    return [f"the supports peak at {in_g(strongest)} (median): the intensity must be that of the ground, not the floor"]


def of_stations(stations: int, fewest: int) -> list[str]:
    """Return a warning where the records are of fewer stations than a probability of collapse takes."""
    if stations >= fewest:
        return []
    these = "1 station: shares" if stations == 1 else f"{stations} stations: shares"
    return [f"the records are of {these} and medians are of these records alone; a probability takes at least {fewest}"]


def of_joints(offset: float, small: float, whose: str = "the joints of the wall") -> list[str]:
    """Return a warning where joints that the model closes together close further apart than `small`, over u_ins."""
    if offset <= small:
        return []
    beyond = f"displacements that differ by {offset:.2g} u_ins, more than {small:g}"
    return [f"the supports are so far apart that {whose} close at {beyond}; the model has them close together"]


def of_joints_of_walls(offsets: Mapping[str, float], small: float) -> list[str]:
    """Return the same of several walls, by id: of how many, and of which most."""
    if not offsets:
        return []
    furthest, far = max(offsets, key=offsets.__getitem__), sum(offset > small for offset in offsets.values())
    whose = f"the joints of {far} of {len(offsets)} walls, most those of {furthest!r},"
    return of_joints(offsets[furthest], small, whose)


def of_asked(pga: float) -> list[str]:
    """Return a warning where the PGA that a wall is assessed at [m s-2] is in another unit, likely."""
    if pga <= STRONGEST_ASKED * STANDARD_GRAVITY:
        return of_motion(pga)
    meant = {"per cent of g": pga * STANDARD_GRAVITY / 100, "cm s-2": pga / 100}
    if not _typed(pga):  # but in g
        meant = {"m s-2": pga / STANDARD_GRAVITY}
    least, most = 0.05 * STANDARD_GRAVITY, STRONGEST_ASKED * STANDARD_GRAVITY
    likely = [f"{unit} ({value / STANDARD_GRAVITY:.3g} g)" for unit, value in meant.items() if least <= value <= most]
    return [f"PGA is {in_g(pga)}, more than {STRONGEST_ASKED:g} g{_question(likely)}"]


def of_motion(pga: float, unit: str = "m s-2", taken: float = 1.0, scale: float = 1.0) -> list[str]:
    """Return a warning where `scale` times the PGA [m s-2] is weaker or stronger than those of relevant earthquakes.

    `unit` is the unit in which the numbers of the record were read, and `taken` is its size in m s-2.
    """
    scaled = pga * abs(scale)
    doubtful = unit == "g" and scale == 1 and scaled <= STRONGEST * STANDARD_GRAVITY
    strongest = STRONGEST_IN_G if doubtful else STRONGEST
    if scaled == 0 or _shakes(scaled) and scaled <= strongest * STANDARD_GRAVITY:
        return []
    beyond = f"over {strongest:g} g" if scaled > strongest * STANDARD_GRAVITY else f"under {WEAKEST:g} g"
    if scale != 1:
        return [f"PGA is {scaled:.3g} m s-2, {beyond}: {pga:.3g} m s-2 times the scale of {scale:g}"]
    per_cent = PER_CENT_OF_G if pga / taken >= LEAST_PER_CENT else {}
    elsewhere = {name: pga * factor / taken for name, factor in (ACCELERATIONS | per_cent).items()}
    likely = [f"{name} ({value:.3g} m s-2)" for name, value in elsewhere.items() if _shakes(value) and name != unit]
    cause = f"it would not be if its numbers were in {' or '.join(likely)}" if likely else "no usual unit explains it"
    return [f"PGA is {pga:.3g} m s-2, {beyond}, with its numbers taken as {unit}; {cause}"]


def of_response(peak: ArrayLike, yield_displacement_ratio: float, pga: float, onset: float) -> list[str]:
    """Return a warning where a motion does not make a wall rock: its peaks u/u_ins stay below a1.

    `onset` is the acceleration whose static load makes the wall rock. [m s-2]
    """
    if _largest(peak) >= yield_displacement_ratio or pga == 0:
        return []
    question = was_g(pga, onset) if pga < onset else ""
    stated = f"PGA is {in_g(pga)}, where {in_g(onset)} makes it rock{question}"
    return [f"the wall does not rock: it stays below u1, a1 = {yield_displacement_ratio:g} of u_ins; {stated}"]


def of_end(stored: Callable[[ArrayLike], Any], peak: Any, displacement: ArrayLike, velocity: Any) -> list[str]:
    """Return a warning where a wall ends its history with more energy than at its peak; NaN after a collapse. [-]"""
    further = np.ravel(stored(np.nan_to_num(displacement)) + velocity**2 / 2 > stored(peak))
    if not further.any():
        return []
    beyond = f"beyond its peak, {np.ravel(peak)[further].max():.3g} of u_ins, or collapse"
    return [f"at the end of the run the wall is so fast that it may rock {beyond}; let it rest, by a tail of 5 s"]


def of_level(measure: str, asked: float, onset: float, walls: str = "the wall") -> list[str]:
    """Return a warning of an intensity, in PGA [m s-2] or PGV [m s-1], at which no record makes walls rock.

    `onset` is the acceleration whose static load makes the easiest of them rock. [m s-2]
    """
    level = f"PGA is {in_g(asked)}" if measure == "PGA" else f"PGV is {asked:g} m s-1"
    question = was_g(asked, onset) if measure == "PGA" and _typed(asked) else ""
    if not question and onset > EASIEST_OF_LOADED * STANDARD_GRAVITY:
        question = "; are the overburden and the sizes right?"
    return [f"{level}: no record makes {walls} rock, which {in_g(onset)} does as a static load{question}"]


def _typed(number: float) -> bool:
    """Return True for a round number, in the unit in which it was typed."""
    return bool(np.isclose(number, float(f"{number:.3g}"), rtol=1e-9))


def in_g(acceleration: float) -> str:
    """Write an acceleration [m s-2] in both units."""
    return f"{acceleration:.3g} m s-2 ({acceleration / STANDARD_GRAVITY:.3g} g)"


def was_g(pga: float, onset: float) -> str:
    """Ask whether a number taken in m s-2 was meant in g, where that could make the wall rock, as it vibrates."""
    meant = pga * STANDARD_GRAVITY
    return f"; was it in g ({pga:.3g} g)?" if meant >= onset / 2 and _shakes(meant) else ""


def of_step(step: float) -> list[str]:
    """Return a warning where the time between samples of a record [s] is none that loggers have."""
    if SHORTEST_STEP <= step <= LONGEST_STEP:
        return []
    meant = {"milliseconds": step / 1000, "seconds": 1000 * step}
    likely = [f"{unit} ({value:.3g} s)" for unit, value in meant.items() if SHORTEST_STEP <= value <= LONGEST_STEP]
    slip = f"; were the times in {likely[0]}?" if likely else ""
    return [f"the time between samples is {step:.3g} s, beyond {SHORTEST_STEP:g} to {LONGEST_STEP:g} s{slip}"]


def _least(values: ArrayLike) -> float:
    return float(np.min(np.asarray(values), initial=np.inf))


def _largest(values: ArrayLike) -> float:
    return float(np.max(np.asarray(values), initial=0.0))


def _shakes(pga: float) -> bool:
    return WEAKEST * STANDARD_GRAVITY <= pga <= STRONGEST * STANDARD_GRAVITY
