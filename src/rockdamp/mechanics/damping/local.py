"""LOCAL: Cundall's local damping, which programs of discrete elements apply by default."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array, Quantity
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping.base import NET_FORCE, Damping
from rockdamp.mechanics.trilinear import TINY


class LocalDamping(Damping):
    """LOCAL: a force alpha |g| against the velocity, g the force that accelerates the wall: x'' = g - alpha |g| sgn(v).

    None of the models that are compared. In free decay g = -f, and a half cycle leaves e^2 = (1 - alpha)/(1 + alpha) of
    the energy, from any amplitude on any curve (docs/theory.md, section 8). The solvers know that it acts on g; the
    coefficient C here, by which it is the viscous damper C v, is that of a wall without load.
    """

    # ASSUME: the motion of the supports is a load on a wall that is fixed to them, as everywhere in this package. A
    # program that moves the supports takes each block's force and the sign of its velocity in space.
    model = "LOCAL"
    title = "local damping"
    colour = "#6B7A00"
    names: ClassVar[tuple[str, ...]] = ("local_damping",)
    amplitude_independent = True
    step_kind = NET_FORCE

    def formula_parameters(self, curve: TrilinearCurve) -> tuple[Quantity, ...]:
        return (self.local_damping,)

    @staticmethod
    def formula(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
        return parameters[0] * f / np.maximum(np.abs(v), TINY)

    @staticmethod
    def law(z: float, f: float, double_v: float, v: float, parameters: tuple[float, ...]) -> float:
        return parameters[0] * f / max(abs(v), TINY)  # no branch asks it: a piece of the motion has a closed form

    def law_parameters(self, curve: TrilinearCurve) -> tuple[float, ...]:
        return (float(self.local_damping),)

    @classmethod
    def exact_damping_ratio(cls, restitution: ArrayLike, **named: Quantity) -> Array:
        """Return alpha = tanh(delta), delta = -ln e, with e in (0, 1]. [-]"""
        return np.tanh(0.0 - np.log(restitution))
