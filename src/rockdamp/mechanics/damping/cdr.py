"""CDR: a constant damping ratio."""

from __future__ import annotations

from typing import Any

import numpy as np

from rockdamp.arrays import Quantity
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping.secant import SecantDamper


class ConstantRatio(SecantDamper):
    """CDR, Eq. (11): C = 2 xi w, w^2 = f/x the secant's."""

    model = "CDR"
    title = "constant damping ratio"
    colour = "#D55E00"
    secant_exponent = 1.0

    def formula_parameters(self, curve: TrilinearCurve) -> tuple[Quantity, ...]:
        return (2 * self.damping_ratio,)

    @staticmethod
    def formula(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
        return parameters[0] * np.sqrt(f / z)
