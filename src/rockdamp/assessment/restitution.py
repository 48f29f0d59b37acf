"""The coefficient of restitution of a wall: a number, or a rule for it."""

from __future__ import annotations

import numpy as np

from rockdamp.errors import InputError, check, check_choice
from rockdamp.mechanics.specimen import AnyWall
from rockdamp.mechanics.wall import SORRENTINO_RATIO, OneSidedWall, Parapet, Wall

# ASSUME: `measured` has the paper's factor, section 4.1. The tests quoted there give 0.86 of
# Eq. (7), 0.85 to 0.91: 0.90 is on the safe side of their mean. For slender walls it does not
# follow from rigid-body mechanics, as `impulsive` does.
DEFAULT_RULE = "measured"
RESTITUTION_RULES = {
    "measured": f"{SORRENTINO_RATIO:.2f} times Eq. (7) of the paper, from tests of other walls",
    "rigid": "Eq. (7) of the paper: angular momentum about the new base pivot",
    "impulsive": "rigid bodies, with the impulse of every support",
}


def find_restitution(wall: AnyWall, restitution: float | str) -> tuple[float, str]:
    """Return e and the reason for it. [-]

    Parameters
    ----------
    wall : Wall, Parapet or OneSidedWall
        One wall.
    restitution : float or str
        Number, 0 to 1, or a rule: ``measured``, ``rigid`` or ``impulsive``. For a parapet every
        rule is Housner's; a one-sided block has ``measured`` alone, a one-sided wall with a hinge
        none.

    Raises
    ------
    InputError
        If e lies outside its range, or the rule does not exist for the wall.
    """
    if not isinstance(restitution, str):
        check("restitution", restitution, lambda e: (e >= 0) & (e <= 1), "at least 0 and at most 1")
        return float(restitution), "given"
    if isinstance(wall, OneSidedWall):
        if isinstance(wall.mechanism, Wall):
            raise InputError(
                "restitution is missing, or a rule; a one-sided wall with a hinge needs a number"
            )
        if restitution != DEFAULT_RULE:
            raise InputError(
                f"restitution is {restitution!r}; it must be a number or measured for a one-sided"
                " parapet"
            )
        e = float(wall.restitution_measured)
        return e, (
            "Sorrentino, AlShawa and Decanini (2011), from a secondary source: a block that hits"
            " a return wall"
        )
    check_choice("restitution", restitution, tuple(RESTITUTION_RULES))
    e = float(getattr(wall, f"restitution_{restitution}"))
    if np.isnan(e):  # no such rule holds with a mass on the wall
        raise InputError(
            f"restitution is {restitution!r}; with overburden_mass it must be a number, measured or"
            " rigid"
        )
    if isinstance(wall, Parapet):
        return e, "Housner: one block that rocks on its base"
    return e, RESTITUTION_RULES[restitution]
