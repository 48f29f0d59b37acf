"""CR: the coefficient of restitution, of an amplitude or of all."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np

from rockdamp.arrays import Quantity
from rockdamp.errors import require
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping.base import IMPACT, RANGES, Damping


def constant(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
    """Return e."""
    return parameters[0]


def by_amplitude(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
    """Return e of an impact at the speed v: E+^g = E-^g - E_r^g (1 - e_r^2g), and 0 where nothing is left.

    Written by the quotient of the energies, which is well conditioned down to g = 0, where e is e_r.
    """
    e, g, double_r = parameters
    steep = np.minimum(g * np.log(double_r / np.maximum(v * v, 1e-200)), 700.0)  # far beyond a stop
    left = np.exp(steep) * np.expm1(2.0 * g * np.log(e))
    changed = np.exp(np.log1p(np.maximum(left, -1.0 + 1e-16)) / np.maximum(2.0 * g, 1e-300))
    kept = changed if left > -1.0 else 0.0
    return e if g == 0.0 else kept


def impact_law(z: float, f: float, double_v: float, v: float, parameters: tuple[float, ...]) -> float:
    """Return e once more, by the powers of the energies themselves."""
    e, g, double_r = parameters
    if g == 0.0:
        return e
    level, lost = math.log(v * v / double_r), math.expm1(2.0 * g * math.log(e))
    left = math.exp(g * level) + lost  # E+^g/E_r^g
    if left <= 0.0:
        return 0.0
    rise = (
        math.log1p(math.expm1(g * level) + lost) if abs(left - 1.0) < 0.5 else math.log(left)
    )  # near 1 to the last bit
    return math.exp((rise / g - level) / 2.0)


class Restitution(Damping):
    """CR, Eq. (8): the velocity is multiplied by e whenever u changes sign; between impacts nothing is lost."""

    model = "CR"
    title = "coefficient of restitution"
    colour = "#1A1A1A"
    names: ClassVar[tuple[str, ...]] = ("restitution",)
    step_kind = IMPACT
    fades = True
    ranges: ClassVar[Mapping[str, Any]] = {
        **RANGES,
        "restitution": (RANGES["restitution"][0], lambda e: (e >= 0) & (e <= 1), "at least 0 and at most 1"),
    }

    def __init__(self, model: str, *values: Quantity, **named: Quantity) -> None:
        super().__init__(model, *values, **named)
        if self.loss_depends_on_amplitude:
            text, within, allowed = RANGES["restitution"]
            require(within(self.restitution), text, self.restitution, f"{allowed} with an exponent")

    @property
    def formula(self) -> Callable[..., Any]:
        return by_amplitude if self.loss_depends_on_amplitude else constant

    def formula_parameters(self, curve: TrilinearCurve) -> tuple[Quantity, ...]:
        if not self.loss_depends_on_amplitude:
            return (self.restitution,)
        return self.restitution, self.exponent, self.reference_energy(curve)

    law = staticmethod(impact_law)

    def law_parameters(self, curve: TrilinearCurve) -> tuple[float, ...]:
        if not self.loss_depends_on_amplitude:
            return float(self.restitution), 0.0, 1.0
        return float(self.restitution), float(self.exponent), float(self.reference_energy(curve))
