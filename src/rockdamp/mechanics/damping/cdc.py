"""CDC: a constant damping coefficient."""

from __future__ import annotations

from typing import Any

from rockdamp.arrays import Quantity
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping.secant import SecantDamper


class ConstantCoefficient(SecantDamper):
    """CDC, Eq. (10): C = 2 xi w1."""

    model = "CDC"
    title = "constant damping coefficient"
    colour = "#0072B2"
    secant_exponent = 0.0
    linear_branches = 3

    def formula_parameters(self, curve: TrilinearCurve) -> tuple[Quantity, ...]:
        return (2 * curve.initial_frequency * self.damping_ratio,)

    @staticmethod
    def formula(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
        return parameters[0]
