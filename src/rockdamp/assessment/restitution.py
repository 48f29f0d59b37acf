"""Rules for the coefficient of restitution of a wall for which none is stated, and how uncertain e is by them."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from rockdamp import plausibility
from rockdamp.arguments import number
from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.one_sided import OneSidedWall
from rockdamp.mechanics.wall import SORRENTINO_RATIO, Parapet, Wall
from rockdamp.vocabulary import BLOCK_RATIO, BLOCK_RESTITUTION_DEVIATION, WALL_RESTITUTION_DEVIATION

Rocking = Wall | Parapet
SORRENTINO = "Sorrentino, AlShawa and Decanini (2011), second-hand: a block that hits a return wall"

# By the name of the rule: what it gives, and what it is called for a wall.
RULES: Mapping[str, tuple[Callable[[Rocking], Array], str]] = {
    "measured": (
        lambda wall: wall.restitution_measured,
        f"{SORRENTINO_RATIO:.2f} of Eq. (7), near the upper end of the tests of walls that the paper quotes",
    ),
    "analytical": (lambda wall: wall.restitution, "Eq. (7): angular momentum about the new base pivot"),
    "impulsive": (lambda wall: wall.restitution_impulsive, "with the impulse of every support"),
}
# ASSUME: the paper's factor, section 4.1. The tests that it quotes give 0.86 of Eq. (7), 0.85 to 0.91, so that 0.90 is
# on the safe side.
DEFAULT_RULE = "measured"
HOUSNER = "Housner: one block that rocks on its base"
# The range of the rule ``measured``, and its source.
OF_WALLS = (
    "tests of walls that the paper quotes gave 0.86 of Eq. (7), 0.85 to 0.91; other reports, second-hand, differ:"
    " 0.90 to 0.97 of theory"
)
OF_BLOCKS = f"134 free-rocking trials of limestone blocks gave {BLOCK_RATIO} of Housner; other reports differ"
NODES = 5  # of e over its spread; the middle one is the median


def by_rule(wall: Rocking | OneSidedWall, rule: str = DEFAULT_RULE) -> tuple[Array, str]:
    """Return e of a wall by the name of a rule, and its reason; for a parapet every rule is Housner's. [-]"""
    if rule not in RULES:
        raise InputError(f"restitution (e) is {rule!r}; it must be a number, or one of {', '.join(RULES)}")
    if isinstance(wall, OneSidedWall):
        if isinstance(wall.mechanism, Wall):
            raise InputError(f"restitution (e) is {rule!r}; a strip against a stop has no rule: it must be a number")
        return wall.restitution_rigid, SORRENTINO
    if isinstance(wall, Parapet):
        return wall.restitution, HOUSNER
    formula, reason = RULES[rule]
    return formula(wall), reason


def restitution_and_reason(wall: Rocking | OneSidedWall, restitution: float | str) -> tuple[float, str]:
    """Return e, by its rule or as it is given, and the reason for it. [-]"""
    if isinstance(restitution, str):
        e, reason = by_rule(wall, restitution)
        return float(e), reason
    given = float(Damping.cr(number("restitution (e)", restitution)).restitution)
    if not isinstance(wall, OneSidedWall):  # against a stop an e of 0.3 is usual
        plausibility.warn(plausibility.of_restitution(given))
    return given, "as given"


def deviation_of(wall: Rocking) -> tuple[float, str]:
    """Return the standard deviation of e by the rule ``measured``, and where the range comes from. [-]"""
    if isinstance(wall, Parapet):
        return BLOCK_RESTITUTION_DEVIATION, OF_BLOCKS
    return WALL_RESTITUTION_DEVIATION, OF_WALLS


def spread(median: float, deviation: float) -> tuple[Array, Array]:
    """Return values of e that stand for its spread, and their weights, shape (NODES,)."""
    # ASSUME: e is normal about the rule's value and no more than 1; nodes and weights by Gauss and Hermite.
    at, weight = np.polynomial.hermite_e.hermegauss(NODES)
    return np.clip(median + deviation * at, 0.01, 1.0), weight / weight.sum()
