"""The dampers whose coefficient follows the secant's frequency w, w^2 = f/x."""

from __future__ import annotations

import math
from typing import ClassVar

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
    secant_exponent: ClassVar[float]

    def law_parameters(self, curve: TrilinearCurve) -> tuple[float, ...]:
        k1 = float(curve.initial_stiffness)
        return 2 * float(self.damping_ratio) * math.sqrt(k1), k1, float(self.secant_exponent) / 2
