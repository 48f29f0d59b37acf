"""CR: what an impact takes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from rockdamp import kernels
from rockdamp.arrays import Array
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping.face import Damping


class Restitution(Damping):
    """CR, Eq. (8): the velocity is multiplied by e whenever u changes sign; between impacts nothing is lost."""

    model = "CR"
    names = ("restitution",)
    is_impact = True

    def rows(self, curve: TrilinearCurve) -> dict[int, Array]:
        return {kernels.E: self.restitution}

    def _newmark(self) -> Callable[..., None]:
        return kernels.restitution_located

    def _printed(self) -> Callable[..., None]:
        return kernels.restitution_printed

    def coefficient(self, curve: TrilinearCurve, x: ArrayLike, v: ArrayLike = 0.0) -> Array:
        return np.zeros(self._state(curve, x, v)[2])
