"""ECD: the damper that loses in every half cycle what an impact takes, of any order m; and ECD16."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array, Quantity
from rockdamp.errors import holds
from rockdamp.mechanics import half_cycle_loss
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping.base import Damping
from rockdamp.vocabulary import RECOMMENDED, RECOMMENDED_ORDER

DOUBLED_ORDERS = (1, 2, 4, 8, 16, 32)  # their power takes multiplications alone, any other a library's power


def of_order_0(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
    """Return C of order 0: it goes with the energy's frequency w, w^2 = f^2/(2V)."""
    return parameters[0] * np.sqrt(f * f / double_v)


def of_any_order(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
    """Return C of the order m that stands in the parameters."""
    double_t = v * v
    fraction = double_t / (double_t + double_v)
    return parameters[0] * np.sqrt(f * f / double_v) * fraction ** parameters[1]


def of_recommended_order(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
    """Return C of the order of `vocabulary.RECOMMENDED_ORDER`.

    At rest at the origin, where there is no energy, the kinetic fraction is 0: 2V is not, as z is not.
    """
    double_t = v * v
    fraction = double_t / (double_t + double_v)
    return parameters[0] * np.sqrt(f * f / double_v) * fraction**RECOMMENDED_ORDER


def of_doubled_order(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
    """Return C of an order m of `DOUBLED_ORDERS`, which stands in the parameters: one formula for all of them.

    The fraction is squared where m is at least 2, and again where it is at least 4, 8, 16 and 32; elsewhere it is
    multiplied by 1, so that there is no branch.
    """
    double_t, m = v * v, parameters[1]
    power = double_t / (double_t + double_v)
    power = power * np.maximum(power, np.minimum(2.0 - m, 1.0))
    power = power * np.maximum(power, np.minimum(4.0 - m, 1.0))
    power = power * np.maximum(power, np.minimum(8.0 - m, 1.0))
    power = power * np.maximum(power, np.minimum(16.0 - m, 1.0))
    power = power * np.maximum(power, np.minimum(32.0 - m, 1.0))
    return parameters[0] * np.sqrt(f * f / double_v) * power


def energy_law(z: float, f: float, double_v: float, v: float, parameters: tuple[float, ...]) -> float:
    """Return C by (1 + V/T)^-m and logarithms, where the formulas have a power of the energies' ratio.

    It is as smooth as its rounding: that of a power grows with m, and the event-driven solver's steps would shrink.
    """
    scale, w1, m = parameters
    root = math.sqrt(double_v)
    kinetic = 1.0
    if m > 0.0:
        kinetic = math.exp(-m * math.log1p((root / v) * (root / v))) if v != 0.0 else 0.0
    return scale * (f / root / w1) * kinetic


class EnergyConsistent(Damping):
    """ECD of order m: C = 2 xi N_m w_E (T/(T + V))^m, w_E = |f|/sqrt(2V). ECD alone means m = 0, which has no T.

    It loses the same fraction of the energy in every half cycle, from any amplitude, on any odd curve; as m grows it
    tends to restitution (docs/theory.md, section 8).
    """

    model = "ECD"
    title = "energy-consistent damper"
    colour = "#9A4C95"
    names: ClassVar[tuple[str, ...]] = ("damping_ratio", "order")
    defaults: ClassVar[Mapping[str, float]] = {"order": 0.0}
    same_loss_at_any_amplitude = True
    javascript = "((2 * size * f) / Math.sqrt(doubleV)) * ((v * v) / (v * v + doubleV)) ** m"

    @cached_property
    def _one_order(self) -> float | None:
        """The order, where it is the same for all."""
        orders = np.ravel(self.order)
        return orders.item(0) if orders.size and holds(orders == orders[0]) else None

    @property
    def formula(self) -> Callable[..., Any]:
        order = self._one_order
        if order == 0:
            return of_order_0
        if order == RECOMMENDED_ORDER:
            return of_recommended_order
        return of_doubled_order if order in DOUBLED_ORDERS else of_any_order

    def formula_parameters(self, curve: TrilinearCurve) -> tuple[Quantity, ...]:
        return 2 * self.damping_ratio * half_cycle_loss.of_order(self.order), self.order

    @property
    def constant_branches(self) -> int:
        return 1 if self._one_order == 0 else 0

    law = staticmethod(energy_law)

    def law_parameters(self, k1: float) -> tuple[float, ...]:
        w1, m = math.sqrt(k1), float(self.order)
        # N_m by Gamma functions, which half_cycle_loss does not use.
        size = math.exp(math.lgamma(m + 2) - math.lgamma(m + 1.5)) * math.sqrt(math.pi) / 2 if m else 1.0
        return 2 * float(self.damping_ratio) * w1 * size, w1, m

    @classmethod
    def exact_damping_ratio(cls, restitution: ArrayLike, **named: Quantity) -> Array:
        return half_cycle_loss.damping_ratio(0.0 - np.log(restitution), named.get("order", 0.0))


class RecommendedOrder(EnergyConsistent):
    """ECD of the order that results/earthquakes/orders.nc recommends: a model beside ECD, with xi alone."""

    model = RECOMMENDED
    title = f"energy-consistent damper of order {RECOMMENDED_ORDER}"
    colour = "#D0267F"
    names = ("damping_ratio",)
    defaults = {}

    @property
    def order(self) -> Quantity:
        return np.array(float(RECOMMENDED_ORDER))

    @classmethod
    def exact_damping_ratio(cls, restitution: ArrayLike, **named: Quantity) -> Array:
        return super().exact_damping_ratio(restitution, order=RECOMMENDED_ORDER)
