"""ECD: the damper that loses in every half cycle what an impact takes, of any order m."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numba.extending import register_jitable
from numpy.typing import ArrayLike

from rockdamp import kernels
from rockdamp.arrays import Array, Quantity
from rockdamp.errors import holds
from rockdamp.mechanics import half_cycle_loss
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping.viscous import Viscous
from rockdamp.vocabulary import RECOMMENDED, RECOMMENDED_ORDER

Formula = Callable[..., tuple[Any, Any]]
MULTIPLIED_ORDERS = (0, 1, 2, 4, 8, 16, 32)


@register_jitable
def energy_law(z: float, f: float, double_v: float, v: float, given: tuple[float, ...]) -> float:
    """C goes with the energy's frequency and cos^2m of the phase's angle: the kernel has the energies' ratio."""
    scale, w1, m = given
    root = math.sqrt(double_v)
    kinetic = math.cos(math.atan2(root, abs(v))) ** (2.0 * m) if m > 0.0 else 1.0
    return scale * (f / root / w1) * kinetic


class EnergyConsistent(Viscous):
    """ECD of order m: C = 2 xi N_m w_E (T/(T + V))^m, w_E = |f|/sqrt(2V); m = 0, which is meant by ECD alone, has no T.

    It loses the same fraction of the energy in every half cycle, from any amplitude, on any odd curve; as m grows it
    tends to restitution (docs/theory.md, section 8).
    """

    model = "ECD"
    names: ClassVar[tuple[str, ...]] = ("damping_ratio", "order")
    defaults: ClassVar[Mapping[str, float]] = {"order": 0.0}
    same_loss_at_any_amplitude = True

    @property
    def formula(self) -> Formula:
        m = self._multiplied
        if m is None:
            return kernels.energy_of_any_order_at
        return kernels.energy_of_order_at(m) if m else kernels.energy_at

    @property
    def printed_formula(self) -> Formula:
        return self.formula if self._multiplied != 0 else kernels.viscous_at

    @cached_property
    def _multiplied(self) -> int | None:
        """m where it is one for all and its power takes multiplications alone: the kernel has a formula for each."""
        orders = np.ravel(self.order)
        one = orders.size > 0 and holds(orders == orders[0])
        return int(orders[0]) if one and orders[0] in MULTIPLIED_ORDERS else None

    @property
    def constant_branches(self) -> int:
        return 1 if np.all(self.order == 0) else 0

    @classmethod
    def exact_damping_ratio(cls, restitution: ArrayLike, **named: Quantity) -> Array:
        return half_cycle_loss.damping_ratio(0.0 - np.log(restitution), named.get("order", 0.0))

    def rows(self, curve: TrilinearCurve) -> dict[int, Array]:
        scale = 2 * self.damping_ratio * half_cycle_loss.normalisation(self.order)
        return {kernels.C1: scale, kernels.BY_ENERGY: np.ones(()), kernels.ORDER: self.order}

    law = staticmethod(energy_law)

    def law_parameters(self, k1: float) -> tuple[float, ...]:
        w1, m = math.sqrt(k1), float(self.order)
        # N_m by Gamma functions of its own.
        size = math.exp(math.lgamma(m + 2) - math.lgamma(m + 1.5)) * math.sqrt(math.pi) / 2 if m else 1.0
        return 2 * float(self.damping_ratio) * w1 * size, w1, m


class RecommendedOrder(EnergyConsistent):
    """ECD of the order that results/natural/orders.nc recommends: a model of its own beside ECD, with xi alone."""

    model = RECOMMENDED
    names = ("damping_ratio",)
    defaults = {}

    @property
    def order(self) -> Quantity:
        return np.array(float(RECOMMENDED_ORDER))

    @classmethod
    def exact_damping_ratio(cls, restitution: ArrayLike, **named: Quantity) -> Array:
        return super().exact_damping_ratio(restitution, order=RECOMMENDED_ORDER)
