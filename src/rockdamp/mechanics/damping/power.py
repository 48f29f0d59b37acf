"""POWER: the general exponent, between and beyond CDC, CDR and SDR."""

from __future__ import annotations

from typing import Any, ClassVar

from rockdamp.arrays import Quantity
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping.secant import OfTheSecant


class GeneralExponent(OfTheSecant):
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
