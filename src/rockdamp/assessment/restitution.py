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
        lambda wall: wall.restitution_measured,
        f"{SORRENTINO_RATIO:.2f} of Eq. (7), the mean of tests of other walls",
    ),
    "analytical": (lambda wall: wall.restitution, "Eq. (7): angular momentum about the new base pivot"),
    "impulsive": (lambda wall: wall.restitution_impulsive, "with the impulse of every support"),
}
# ASSUME: tests give 0.90 of Eq. (7) (section 4.1), so that is what a wall has of which nothing else is known.
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
