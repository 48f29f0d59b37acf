"""Rules for the coefficient of restitution of a wall for which none is stated."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.mechanics.wall import SORRENTINO_RATIO, Parapet, Wall

Rocking = Wall | Parapet

# By the name of the rule: what it gives, and what it is called for a wall.
RULES: Mapping[str, tuple[Callable[[Rocking], Array], str]] = {
    "measured": (
        lambda wall: SORRENTINO_RATIO * wall.restitution,
        f"{SORRENTINO_RATIO:.2f} of Eq. (7), high among tests",
    ),
    "analytical": (lambda wall: wall.restitution, "Eq. (7): angular momentum about the new base pivot"),
    "impulsive": (lambda wall: wall.restitution_impulsive, "with the impulse of every support"),
}
# ASSUME: the paper's factor, section 4.1. The tests that it quotes give 0.86 of Eq. (7), 0.85 to 0.91, so that 0.90 is
# on the safe side.
DEFAULT_RULE = "measured"
HOUSNER = "Housner: one block that rocks on its base"


def by_rule(wall: Rocking, rule: str = DEFAULT_RULE) -> tuple[Array, str]:
    """Return e of a wall by the name of a rule, and its reason; for a parapet every rule is Housner's. [-]"""
    if rule not in RULES:
        raise InputError(f"restitution (e) is {rule!r}; it must be a number, or one of {', '.join(RULES)}")
    if isinstance(wall, Parapet):
        return wall.restitution, HOUSNER
    formula, reason = RULES[rule]
    return formula(wall), reason
