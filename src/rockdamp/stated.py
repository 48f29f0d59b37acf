"""Doubts about a wall as a user states it: its storey or building, a parapet, and a table of walls.

The sizes, loads and motions alone are in `plausibility`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.plausibility import (
    HIGHEST,
    LENGTHS,
    SLENDEREST,
    of_density,
    of_onset,
    of_overburden,
    of_wall,
    of_width,
)

# ASSUME: thresholds of doubt are a judgement. Codes ask for clear heights of 2.1 m (7 ft) and more. The second height
# of a storey holds in a building, where that of the whole is known, the last one anywhere.
LOWEST_STOREY, HIGH_STOREY, HIGHEST_STOREY, HIGHEST_SPAN = 2.1, 5.0, 6.0, 8.0  # [m]
SLENDER = 20.0  # h/t of a wall higher than a storey: the paper's walls of 30 are a storey high [-]
SQUATTEST = 4.0  # h/t of a wall: two bodies as squat as this are hardly walls [-]
SQUATTEST_BLOCK, SLENDEREST_BLOCK = 2.0, 20.0  # h/t of a parapet or facade; those of the studies have 8 to 15 [-]
LOWEST_HINGE, HIGHEST_HINGE = 0.4, 0.8  # of h; tests found 0.5 to 0.7, and the studies go to 0.75
ALIKE = 0.05  # how near to a half, or to a multiple, the height of a wall is over that of the others
FEWEST = 3  # walls of a table that can be compared


def of_stated(wall: Any, storeys: int | None = None) -> list[str]:
    """Return the warnings about one wall, parapet or wall against a stop as a user states it; of arrays the extremes.

    `storeys` is the number of those of the building that it stands in.
    """
    mechanism = getattr(wall, "mechanism", wall)
    if not np.size(mechanism.load_factor):
        return []
    spans, loaded = hasattr(mechanism, "hinge_ratio"), np.any(mechanism.overburden_ratio)
    height, thickness, width = mechanism.height, mechanism.thickness, mechanism.width
    doubts = of_wall(thickness, height) or _of_shape(height, thickness, spans, storeys, stopped=mechanism is not wall)
    doubts += of_width(width, thickness) or _of_squat(height, thickness, spans)
    doubts += of_density(mechanism.density)
    load = of_overburden(mechanism.overburden_ratio, np.divide(mechanism.weight, width))
    doubts += load or of_onset(mechanism.rocking_onset())
    doubts += of_hinge(mechanism.hinge_ratio) if spans else []
    if (eccentricity := np.max(np.abs(mechanism.eccentricity))) and not loaded:
        doubts.append(f"eccentricity is {eccentricity:g} m and has no effect: there is no overburden")
    if (part := np.max(getattr(mechanism, "overburden_mass", 0.0))) and not loaded:
        doubts.append(f"overburden_mass is {part:g} and has no effect: there is no overburden")
    return doubts


def of_hinge(hinge_ratio: ArrayLike) -> list[str]:
    """Return a warning where a hinge is where tests found none; of an array the first such element is named."""
    ratios = np.ravel(np.asarray(hinge_ratio, dtype=float))
    unlike = ratios[(ratios < LOWEST_HINGE) | (ratios > HIGHEST_HINGE)]
    if not unlike.size:
        return []
    slip = "; was it the restitution (e)?" if unlike[0] > HIGHEST_HINGE else ""
    return [f"hinge_ratio is {unlike[0]:g} of the height; tests found 0.5 to 0.7{slip}"]


def _of_squat(height: ArrayLike, thickness: ArrayLike, spans: bool) -> list[str]:
    """Return a warning where h/t is less than that of walls that span, or of blocks that stand free."""
    squat, least = float(np.min(np.divide(height, thickness))), SQUATTEST if spans else SQUATTEST_BLOCK
    if squat >= least:
        return []
    stated = f"height over thickness is {squat:.3g}, less than {least:g}"
    return [f"{stated}; is the thickness right, and not the wall's width?"]


def _of_shape(height: ArrayLike, thickness: ArrayLike, spans: bool, storeys: int | None, stopped: bool) -> list[str]:
    """Return the warnings about the height of a wall that spans, or of a block that stands free."""
    low, high = float(np.min(height)), float(np.max(height))
    slender = float(np.max(np.divide(height, thickness)))
    if spans:
        return of_storey(low if low < LOWEST_STOREY else high, slender, storeys)
    if storeys is not None and high > LOWEST_STOREY and not stopped:
        return [f"the parapet is {high:g} m high, as a storey is; does it stand free, or is it a wall below a floor?"]
    if not SLENDEREST_BLOCK < slender <= SLENDEREST:
        return []
    stated = f"height over thickness is {slender:.3g}, more than {SLENDEREST_BLOCK:g}"
    return [f"{stated} of a block that stands free; are both right?"]


def of_storey(height: float, slenderness: float, storeys: int | None) -> list[str]:
    """Return a warning where the height of a wall that spans [m] is likelier half of it, or that of a building."""
    if height < LOWEST_STOREY:
        whole = f"was it half of it ({2 * height:g} m), or is the wall a parapet, or a specimen?"
        return [f"the height is {height:g} m, less than a storey has; {whole}"]
    stated = f"the height is {height:g} m, more than a storey has; was it that of the building"
    if storeys and storeys > 1 and HIGH_STOREY < height <= HIGHEST_STOREY * storeys:
        return [f"{stated} ({storeys} storeys of {height / storeys:.3g} m)?"]
    if height > HIGHEST or slenderness > SLENDEREST:  # which `of_wall` says
        return []
    if height <= HIGHEST_SPAN and (height <= HIGHEST_STOREY or slenderness <= SLENDER):
        return []
    feet = LENGTHS["feet"] * height
    return [f"{stated}, or in feet ({feet:.3g} m)?" if feet >= LOWEST_STOREY else f"{stated}?"]


def of_heights(heights: Mapping[int, float]) -> dict[int, str]:
    """Return, by line, a question where a wall of a table is half as high as most are, or two or three times so. [m]"""
    if len(heights) < FEWEST:
        return {}
    usual = float(np.median(list(heights.values())))
    doubts = {}
    for line, height in heights.items():
        times = height / usual
        if abs(times - 0.5) <= ALIKE / 2 and height >= LOWEST_STOREY:
            doubts[line] = f"the height is {height:g} m, where most are some {usual:.3g} m; was it half of it?"
        elif round(times) in (2, 3) and abs(times / round(times) - 1) <= ALIKE and height <= HIGHEST_SPAN:
            of = f"{round(times)} storeys of {height / round(times):.3g} m"
            doubts[line] = f"the height is {height:g} m, where most are some {usual:.3g} m; was it that of {of}?"
    return doubts
