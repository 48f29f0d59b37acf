"""The closed-form equivalence between a coefficient of restitution and a viscous damping ratio.

An impact takes the fraction 1 - e^2 of the energy V(x0) that a half cycle starts with. A damper C = xi c_hat(x) takes,
to first order in the loss, the work of C along the undamped motion. Equating the two separates e from the curve:

    xi = delta g(x0; a1, b1, a3),   delta = -ln e,
    g  = V(x0) / integral_0^x0 c_hat(x) sqrt(2 (V(x0) - V(x))) dx.

For the energy-consistent damper g = 1/pi at any amplitude and of any curve, and the result is exact beyond first
order: xi = delta/sqrt(pi^2 + delta^2); of BAND xi = delta/pi.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.constants import VISCOUS_MODELS
from rockdamp.errors import Rule, check, check_choice, check_type
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.coefficient import damping_coefficient

RESTITUTION: Rule = (lambda e: (e > 0) & (e <= 1), "greater than 0 and at most 1")
NODES, WEIGHTS = np.polynomial.legendre.leggauss(32)


def equivalence_factor(
    curve: TrilinearCurve, damping: Damping, release_amplitude: ArrayLike
) -> Array:
    r"""Return the factor g of the closed form, for the model of `damping` (its xi is not used). [-]

    .. math::
        g(x_0; a_1, b_1, a_3) = \frac{V(x_0)}{\int_0^{x_0} \hat{c}(x) \sqrt{2 \, (V(x_0) - V(x))} \, \mathrm{d}x},
        \qquad C = \xi \, \hat{c}

    Derived in docs/theory.md, section 2. The integral is taken branch by branch in s = sqrt(x0 - x), in which the
    integrand is smooth up to the turning point, by Gauss and Legendre's rule.

    Parameters
    ----------
    curve : TrilinearCurve
        Broadcasts.
    damping : Damping
        A viscous model; broadcasts.
    release_amplitude : float or ndarray
        x0, in (0, a3), broadcasts. [-]

    Examples
    --------
    Times pi, it is how much more damping a wall needs than a linear oscillator.

    >>> import numpy as np
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> [
    ...     round(np.pi * rd.equivalence_factor(curve, rd.Damping(model, 1), 0.5).item(), 2)
    ...     for model in ("CDC", "SDR")
    ... ]
    [0.44, 1.26]
    """
    check_type("curve", curve, TrilinearCurve)
    check_type("damping", damping, Damping)
    check_choice("damping_model", damping.model, (*VISCOUS_MODELS, "CQD"))
    a1, a2, a3 = (
        curve.yield_displacement_ratio,
        curve.plateau_end,
        curve.ultimate_displacement_ratio,
    )
    x0 = check(
        "release_amplitude",
        release_amplitude,
        lambda x0: (x0 > 0) & (x0 < a3),
        "greater than 0, below a3",
    )
    work = np.zeros(np.broadcast_shapes(x0.shape, curve.shape, damping.shape))
    if (
        damping.model == "BAND"
    ):  # by its construction; the quadrature would not see the end of the band
        return work + 1 / np.pi
    small = (
        2.0**-40
    )  # xi of the work: to first order, as some C are not in proportion to xi; no bit is lost
    damping, v0 = replace(damping, value=small), curve.energy(x0)
    inner = [
        a1 * (a2 / a1) ** (piece / 4) for piece in range(5)
    ]  # frequencies fall as powers of x along the plateau
    ends = [0.0, *(np.minimum(end, x0) for end in inner), x0]
    nodes, weights = (values.reshape(-1, *(1,) * work.ndim) for values in (NODES, WEIGHTS))
    for low, high in pairwise(ends):
        s0, s1 = np.sqrt(x0 - high), np.sqrt(x0 - low)
        s = 0.5 * (s0 + s1) + 0.5 * (s1 - s0) * nodes
        x = x0 - s * s
        speed = np.sqrt(np.maximum(2 * (v0 - curve.energy(x)), 0))
        # One after the other: the sum of a wall has the same bits whatever walls stand beside it.
        work = sum(
            0.5
            * (s1 - s0)
            * weights
            * 2
            * s
            * damping_coefficient(curve, damping, x, speed)
            * speed,
            start=work,
        )
    return v0 * small / work


def damping_ratio_energy(
    curve: TrilinearCurve, damping_model: str, restitution: ArrayLike, release_amplitude: ArrayLike
) -> Array:
    r"""Return the damping ratio by the closed form; for ECD and BAND the exact one: every peak of a decay. [-]

    .. math::
        \xi = g(x_0; a_1, b_1, a_3) \, \delta, \qquad \delta = -\ln e; \qquad
        \text{ECD:} \quad \xi = \frac{\delta}{\sqrt{\pi^2 + \delta^2}}, \quad
        \text{BAND:} \quad \xi = \frac{\delta}{\pi}

    Derived in docs/theory.md, sections 2, 4 and 9; g is `equivalence_factor`.

    Parameters
    ----------
    curve : TrilinearCurve
        Broadcasts.
    damping_model : str
        A viscous model.
    restitution : float or ndarray
        e, in (0, 1], broadcasts. [-]
    release_amplitude : float or ndarray
        u0/u_ins, in (0, a3), broadcasts. [-]

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> rd.damping_ratio_energy(curve, "ECD", [0.8, 0.9], 0.5).round(4)
    array([0.0709, 0.0335])
    """
    e = check("restitution", restitution, *RESTITUTION)
    g = equivalence_factor(curve, Damping(damping_model, 1.0), release_amplitude)
    delta = 0.0 - np.log(e)
    if damping_model == "ECD":
        return delta / np.hypot(np.pi, delta) + np.zeros_like(g)
    if damping_model == "BAND":
        return delta / np.pi + np.zeros_like(g)
    return delta * g


def giannini_masiani(restitution: ArrayLike) -> Array:
    r"""Return the damping ratio of Giannini and Masiani, Eq. (15), which knows neither curve nor amplitude. [-]

    .. math:: \xi = \frac{2 \, (1 - e)}{\pi \, (1 + e)}

    Parameters
    ----------
    restitution : float or ndarray
        e, in (0, 1]. [-]

    Examples
    --------
    >>> import rockdamp as rd
    >>> rd.giannini_masiani([0.8, 1.0]).round(4)
    array([0.0707, 0.    ])
    """
    e = check("restitution", restitution, *RESTITUTION)
    return 2 * (1 - e) / (np.pi * (1 + e))
