"""SDR: a stiffness proportional damping ratio."""

from __future__ import annotations

from typing import Any

from rockdamp.arrays import Quantity
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping.secant import SecantDamper


class StiffnessProportionalRatio(SecantDamper):
    """SDR, Eq. (12): C = 2 xi(w) w with xi(w) = xi w/w1."""

    model = "SDR"
    title = "stiffness proportional damping ratio"
    colour = "#009E73"
    secant_exponent = 2.0

    def formula_parameters(self, curve: TrilinearCurve) -> tuple[Quantity, ...]:
        return (2 * self.damping_ratio / curve.initial_frequency,)

    @staticmethod
    def formula(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
        return parameters[0] * (f / z)
