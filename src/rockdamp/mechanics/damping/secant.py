"""The dampers whose coefficient follows the secant's frequency w, w^2 = f/x, and POWER, of a general exponent."""

from __future__ import annotations

import math
from typing import Any, ClassVar

from rockdamp.arrays import Quantity
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping.base import Damping


def secant_law(z: float, f: float, double_v: float, v: float, parameters: tuple[float, ...]) -> float:
    """Return 2 xi w1 (w/w1)^n for any n; the formulas are those of one n each."""
    scale, k1, half_exponent = parameters
    return float(scale * (f / z / k1) ** half_exponent)


class SecantDamper(Damping):
    """C = 2 xi w1 (w/w1)^n: on the first branch of the curve, where w = w1, it is the linear oscillator's."""

    law = staticmethod(secant_law)
    linear_branches = 1

    def law_parameters(self, curve: TrilinearCurve) -> tuple[float, ...]:
        k1 = float(curve.initial_stiffness)
        return 2 * float(self.damping_ratio) * math.sqrt(k1), k1, float(self.secant_exponent) / 2


class GeneralExponent(SecantDamper):
    """C = 2 xi w1 (w/w1)^n of any n >= 0: none of the models that are compared."""

    model = "POWER"
    title = "general exponent"
    colour = "#8C6D1F"
    names: ClassVar[tuple[str, ...]] = ("damping_ratio", "exponent")

    @property
    def secant_exponent(self) -> Quantity:
        return self.exponent

    def formula_parameters(self, curve: TrilinearCurve) -> tuple[Quantity, ...]:
        n = self.exponent
        return 2 * self.damping_ratio * curve.initial_frequency ** (1 - n), n / 2

    @staticmethod
    def formula(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
        return parameters[0] * (f / z) ** parameters[1]
