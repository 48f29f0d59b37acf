"""CR: the coefficient of restitution."""

from __future__ import annotations

from typing import Any, ClassVar

from rockdamp.arrays import Quantity
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping.base import Damping
from rockdamp.mechanics.damping.secant import secant_law


class Restitution(Damping):
    """CR, Eq. (8): the velocity is multiplied by e whenever u changes sign; between impacts nothing is lost."""

    model = "CR"
    title = "coefficient of restitution"
    colour = "#1A1A1A"
    names: ClassVar[tuple[str, ...]] = ("restitution",)
    is_impact = True

    def formula_parameters(self, curve: TrilinearCurve) -> tuple[Quantity, ...]:
        return (self.restitution,)

    @staticmethod
    def formula(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
        return 0.0

    law = staticmethod(secant_law)  # of a scale of zero: no branch asks it

    def law_parameters(self, k1: float) -> tuple[float, ...]:
        return 0.0, k1, 0.0
