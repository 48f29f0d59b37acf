"""The viscous dampers of the paper, and the general exponent that lies between them.

A viscous damper states its coefficient twice: `rows` and `formula` for the kernel, `law_parameters` and `law` for the
event-driven solver. They share nothing, so that each solver checks the other.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
from numba.extending import register_jitable

from rockdamp import kernels
from rockdamp.arrays import Array, Quantity
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping.face import Damping

# C of |x|, |f|, 2V, v and what `law_parameters` returns: plain numbers. It calls no function of its own file: numba's
# cache would not notice an edit of that.
Law = Callable[[float, float, float, float, tuple[float, ...]], float]


@register_jitable
def secant_law(z: float, f: float, double_v: float, v: float, given: tuple[float, ...]) -> float:
    """C goes with w^n, w^2 = f/x the secant's."""
    scale, k1, half_exponent = given
    return scale * (f / z / k1) ** half_exponent


class Viscous(Damping):
    """A viscous damper: a coefficient C(x, v), in proportion to xi."""

    names: ClassVar[tuple[str, ...]] = ("damping_ratio",)
    formula: Any  # of the kernel; it reads the rows
    printed_formula: Any = None  # that of the scheme as printed, if another
    law: Any  # of the event-driven solver, which compiles it; a `Law`
    constant_branches: Any = 0  # of the curve, counted from x = 0, on which C = 2 w1 xi, as if it were linear

    def _newmark(self) -> Callable[..., None]:
        return kernels.viscous_newmark(self.formula)

    def _printed(self) -> Callable[..., None]:
        return kernels.viscous_printed(self.printed_formula or self.formula)

    def by_rows(self, rows: Mapping[int, Array], x: Array, v: Array) -> Quantity:
        return self.formula(rows, 0, np.abs(x), v)[1]

    def law_parameters(self, k1: float) -> tuple[float, ...]:
        """Return what `law` is given besides the state, where the curve's first branch has the stiffness `k1`; for a
        damper of plain numbers."""
        raise NotImplementedError


class OfTheSecant(Viscous):
    """C = 2 xi w1 (w/w1)^n, w^2 = f/x the secant's."""

    law = staticmethod(secant_law)
    constant_branches = 1

    def law_parameters(self, k1: float) -> tuple[float, ...]:
        return 2 * float(self.damping_ratio) * math.sqrt(k1), k1, float(self.secant_exponent) / 2


class ConstantCoefficient(OfTheSecant):
    """CDC, Eq. (10)."""

    model = "CDC"
    secant_exponent = 0.0
    formula = staticmethod(kernels.constant_at)
    printed_formula = staticmethod(kernels.viscous_at)
    constant_branches = 3

    def rows(self, curve: TrilinearCurve) -> dict[int, Array]:
        return {kernels.C0: 2 * curve.initial_frequency * self.damping_ratio}


class ConstantRatio(OfTheSecant):
    """CDR, Eq. (11)."""

    model = "CDR"
    secant_exponent = 1.0
    formula = staticmethod(kernels.root_at)
    printed_formula = staticmethod(kernels.viscous_at)

    def rows(self, curve: TrilinearCurve) -> dict[int, Array]:
        return {kernels.C1: 2 * self.damping_ratio}


class StiffnessProportionalRatio(OfTheSecant):
    """SDR, Eq. (12): xi(w) = xi w/w1."""

    model = "SDR"
    secant_exponent = 2.0
    formula = staticmethod(kernels.linear_at)
    printed_formula = staticmethod(kernels.viscous_at)

    def rows(self, curve: TrilinearCurve) -> dict[int, Array]:
        return {kernels.C2: 2 * self.damping_ratio / curve.initial_frequency}


class GeneralExponent(OfTheSecant):
    """C = 2 xi w1 (w/w1)^n of any n: none of the models that are compared, but what lies between them."""

    model = "POWER"
    title = "general exponent"
    names = ("damping_ratio", "exponent")
    formula = staticmethod(kernels.power_at)

    @property
    def secant_exponent(self) -> Quantity:
        return self.exponent

    def rows(self, curve: TrilinearCurve) -> dict[int, Array]:
        n = self.exponent
        return {kernels.C0: 2 * self.damping_ratio * curve.initial_frequency ** (1 - n), kernels.HALF_N: n / 2}
