"""Free motion of the tri-linear wall between two impacts, without damping, in closed form.

From rest at its amplitude the wall falls along a hyperbolic cosine on the softening branch, a parabola on the plateau,
and a cosine on the first branch. A half cycle is this fall and its mirror image in time.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arguments import real
from rockdamp.arrays import Array
from rockdamp.mechanics.curve import TrilinearCurve


def displacement_from_peak(curve: TrilinearCurve, amplitude: ArrayLike, tau: ArrayLike) -> Array:
    r"""Return the displacement at a time before or after the peak of undamped free motion, u/u_ins. [-]

    It solves :math:`x'' + f(x) = 0` from rest at the amplitude. The zero of the displacement lies a quarter of
    `TrilinearCurve.period` from the peak; beyond it the first branch goes on to the other side.

    The arguments broadcast: the amplitude x0 = u0/u_ins in (0, a3) [-], and the time from the peak, of either sign. [-]
    """
    x0, s = real("amplitude", amplitude), np.abs(real("tau", tau))
    k1, b1, ks, a1, a2, a3 = curve.parameters()
    v0 = curve.energy(x0)
    # Where each branch begins on the way down, and with which speed; a branch above the peak begins there, at rest.
    on2, on1 = np.minimum(x0, a2), np.minimum(x0, a1)
    speed2, speed1 = (np.sqrt(np.maximum(2 * (v0 - curve.energy(x)), 0.0)) for x in (on2, on1))
    reach = np.where(x0 > a2, (a3 - a2) / np.where(x0 > a2, a3 - x0, 1.0), 1.0)
    end3 = np.arccosh(np.maximum(reach, 1.0)) / np.sqrt(ks)
    end2 = end3 + (speed1 - speed2) / b1
    softening = a3 - (a3 - x0) * np.cosh(np.sqrt(ks) * np.minimum(s, end3))
    on_plateau, on_first = s - end3, np.sqrt(k1) * (s - end2)
    plateau = on2 - speed2 * on_plateau - 0.5 * b1 * on_plateau**2
    first = on1 * np.cos(on_first) - speed1 / np.sqrt(k1) * np.sin(on_first)
    return np.where(s < end3, softening, np.where(s < end2, plateau, first))
