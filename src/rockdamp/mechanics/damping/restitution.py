"""CR: what an impact takes."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rockdamp import kernels
from rockdamp.arrays import Array, Quantity
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

    def by_rows(self, rows: Mapping[int, Array], x: Array, v: Array) -> Quantity:
        return 0.0
