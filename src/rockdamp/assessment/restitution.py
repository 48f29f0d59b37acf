"""Rules for the coefficient of restitution of a wall for which none is stated, and how uncertain e is."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from scipy.special import ndtr

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
    "analytical": (lambda wall: wall.restitution_rigid, "Eq. (7): angular momentum about the new base pivot"),
    "impulsive": (lambda wall: wall.restitution_impulsive, "with the impulse of every support"),
}
# ASSUME: the paper's factor, section 4.1. The tests that it quotes give 0.86 of Eq. (7), 0.85 to 0.91: 0.90 is on the
# safe side of their mean, and not of rigid mechanics, `impulsive`, where h/t is some 15 and more.
DEFAULT_RULE = "measured"
HOUSNER = "Housner: one block that rocks on its base"
# The range of the rule ``measured``, and its source.
OF_WALLS = (
    "tests of walls that the paper quotes gave 0.86 of Eq. (7), 0.85 to 0.91; other reports, second-hand, differ:"
    " 0.90 to 0.97 of theory"
)
OF_BLOCKS = f"134 free-rocking trials of limestone blocks gave {BLOCK_RATIO} of Housner; other reports differ"
# ASSUME: a judgement, for averages over e: tests of walls are few, and rigid mechanics leaves the mortar out.
RULE_WEIGHTS: Mapping[str, float] = {"measured": 0.5, "impulsive": 0.5}
NODES = 48  # of e over its spread
FURTHEST = 3.5  # standard deviations from a rule to the last node
LOWEST, HIGHEST = 0.01, 1.0  # e; below and above, its distribution is cut off


def by_rule(wall: Rocking | OneSidedWall, rule: str = DEFAULT_RULE) -> tuple[Array, str]:
    """Return e of a wall by the name of a rule, and its reason; for a parapet every rule is Housner's. [-]"""
    if rule not in RULES:
        raise InputError(f"restitution (e) is {rule!r}; it must be a number, or one of {', '.join(RULES)}")
    if isinstance(wall, OneSidedWall):
        if isinstance(wall.mechanism, Wall):
            raise InputError(f"restitution (e) is {rule!r}; a strip against a stop has no rule: it must be a number")
        return wall.restitution_rigid, SORRENTINO
    if isinstance(wall, Parapet):
        return wall.restitution_rigid, HOUSNER
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


def nodes(wall: Rocking) -> tuple[Array, Array]:
    """Return values of e over its spread by all rules, ascending, and the probability of an e up to each.

    ASSUME: e is normal about each rule of `RULE_WEIGHTS`, with the deviation of `deviation_of`, and is cut off at
    `LOWEST` and `HIGHEST`.
    """
    deviation, _ = deviation_of(wall)
    rules = np.array([float(by_rule(wall, rule)[0]) for rule in RULE_WEIGHTS])
    weights = np.array(list(RULE_WEIGHTS.values()))

    def up_to(e: Array) -> Array:
        return np.asarray(weights @ ndtr((e - rules[:, None]) / deviation))

    fine = np.linspace(rules.min() - FURTHEST * deviation, rules.max() + FURTHEST * deviation, 100 * NODES)
    # As probable an e lies between any two nodes as between the next.
    probability = up_to(fine)
    e = np.interp(np.linspace(probability[0], probability[-1], NODES), probability, fine)
    values = np.unique(np.clip(e, LOWEST, HIGHEST))
    return values, up_to(values)


def over_spread(collapsed: Array, probability: Array) -> tuple[Array, Array]:
    """Return the share of records that collapse a wall, averaged over e, and the standard error of this integral.

    `collapsed`, 0 or 1, has the shape (nodes, records, ...), `probability` is that of an e up to each node. Between two
    nodes the mean of both outcomes is taken. Where a record's outcome changes there, the change is as likely at any
    probability between them: it errs by a uniform variable, independently of the other changes.
    """
    within, last = np.diff(probability), 1 - probability[-1]
    mean = np.tensordot(within, (collapsed[1:] + collapsed[:-1]) / 2, 1)
    mean = mean + probability[0] * collapsed[0] + last * collapsed[-1]
    variance = np.tensordot(within**2 / 12, np.abs(np.diff(collapsed, axis=0)), 1)
    return mean.mean(axis=0), np.sqrt(variance.sum(axis=0)) / collapsed.shape[1]
