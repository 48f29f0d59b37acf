"""The damping coefficient C of any damper, by the formulas of the kernel."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.errors import check, check_type
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers import kernel


def damping_coefficient(
    curve: TrilinearCurve, damping: Damping, x: ArrayLike, v: ArrayLike = 0.0
) -> Array:
    """Return the damping coefficient C divided by m_eff p; zero for CR. [-]

    All parameters broadcast against each other.

    Parameters
    ----------
    curve : TrilinearCurve
        Force-displacement curve.
    damping : Damping
        Damping model with its parameters.
    x : float or ndarray
        Displacement u/u_ins. [-]
    v : float or ndarray
        Velocity d(u/u_ins)/dtau, which CDC, CDR and SDR do not use. [-]

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> rd.damping_coefficient(curve, rd.Damping("CDR", 0.05), [0.02, 0.5]).round(3)
    array([0.461, 0.1  ])
    """
    check_type("curve", curve, TrilinearCurve)
    check_type("damping", damping, Damping)
    x = check("x", x, np.isfinite, "a finite number")
    v = check("v", v, np.isfinite, "a finite number")
    shape = np.broadcast_shapes(x.shape, v.shape, curve.shape, damping.shape)
    formula, parameters = damping.kernel_arguments(curve)
    if damping.model == "CR":
        return np.zeros(shape)
    if damping.model == "CQD":  # here without the kernel's mean over a step
        size, half_width, _ = parameters
        share = np.maximum(1 - (x / half_width) ** 2, 0)
        c = size / half_width * share * np.abs(v)
    else:
        ratios = curve.parameters()
        z = np.maximum(np.abs(x), kernel.TINY)
        f = kernel.force(z, ratios)
        double_v = kernel.double_energy(z, ratios)
        outward_v = np.where(x < 0, -v, v)
        c = kernel.COEFFICIENTS[formula](z, f, double_v, outward_v, 0.0, parameters)
    return np.broadcast_to(c, shape).copy()
