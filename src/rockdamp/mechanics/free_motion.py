"""Undamped free motion in closed form: of the rigid wall, and of the tri-linear curve."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.mechanics.curve import TrilinearCurve


def rigid_period(release_amplitude: ArrayLike) -> Array:
    r"""Return the period of the rigid wall, x'' = -sgn(x) (1 - \|x\|), in tau = p t. [-]

    .. math:: T = 4 \operatorname{arcosh} \frac{1}{1 - x_0}

    Parameters
    ----------
    release_amplitude : float or ndarray
        Amplitude x0 = u0/u_ins, between 0 and 1. [-]
    """
    return 4 * np.arccosh(1 / (1 - np.asarray(release_amplitude, dtype=float)))


def displacement_from_peak(curve: TrilinearCurve, amplitude: Array, tau: Array) -> Array:
    r"""Return the displacement u/u_ins at a time before or after a peak. [-]

    It solves :math:`x'' + f(x) = 0` from rest at the peak: a hyperbolic cosine on the softening
    branch, a parabola on the plateau, a cosine on the first branch. The displacement is zero at a
    quarter of `TrilinearCurve.period` from the peak; later the first branch continues to the
    other side. All parameters broadcast against each other.

    Parameters
    ----------
    curve : TrilinearCurve
        Force-displacement curve.
    amplitude : ndarray
        Displacement x0 = u0/u_ins of the peak, between 0 and a3. [-]
    tau : ndarray
        Time from the peak, of either sign. [-]
    """
    x0 = amplitude
    s = np.abs(tau)
    k1, b1, ks, a1, a2, a3 = curve.parameters()
    v0 = curve.energy(x0)

    def speed(x: Array) -> Array:
        return np.sqrt(np.maximum(2 * (v0 - curve.energy(x)), 0.0))

    # Start and end of the plateau on the way down. Branches above the peak have no length.
    x2 = np.minimum(x0, a2)
    x1 = np.minimum(x0, a1)
    reach = np.where(x0 > a2, (a3 - a2) / np.where(x0 > a2, a3 - x0, 1.0), 1.0)
    softening_end = np.arccosh(np.maximum(reach, 1.0)) / np.sqrt(ks)
    plateau_end = softening_end + (speed(x1) - speed(x2)) / b1
    softening = a3 - (a3 - x0) * np.cosh(np.sqrt(ks) * np.minimum(s, softening_end))
    s2 = s - softening_end
    plateau = x2 - speed(x2) * s2 - 0.5 * b1 * s2**2
    phase = np.sqrt(k1) * (s - plateau_end)
    first = x1 * np.cos(phase) - speed(x1) / np.sqrt(k1) * np.sin(phase)
    lower = np.where(s < plateau_end, plateau, first)
    return np.where(s < softening_end, softening, lower)
