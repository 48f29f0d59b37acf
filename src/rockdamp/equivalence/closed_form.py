"""The closed-form equivalence between a coefficient of restitution and a viscous damping ratio.

An impact takes the fraction 1 - e^2 of the energy V(x0) with which a half cycle starts. A damper
C = xi c_hat(x) takes, to first order in the loss, the work of C along the undamped motion. If both
are equal, e and the curve separate:

    xi  = delta chi(x0; a1, b1, a3),   delta = -ln e,
    chi = V(x0) / integral_0^x0 c_hat(x) sqrt(2 (V(x0) - V(x))) dx.

The energy-consistent damper has chi = 1/pi at any amplitude and on any curve, and is exact beyond
first order: xi = delta/sqrt(pi^2 + delta^2). BAND is exact too, with xi = delta/pi.
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

RESTITUTION_RULE: Rule = (lambda e: (e > 0) & (e <= 1), "greater than 0 and at most 1")
# On 600 random curves, 32 nodes a piece give the factors of CDC, CDR, SDR and ECD within 1e-9, and
# that of CQD, whose coefficient has a corner inside a piece, within 1 %.
GAUSS_NODES, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(32)
# Damping ratio at which C is evaluated. Some C are not proportional to xi; at a small xi they are,
# to first order. Scaling by a power of two loses no bit.
SMALL_RATIO = 2.0**-40
# Pieces of the integral along the plateau, in equal ratios: frequencies fall like powers of x.
PLATEAU_PIECES = 4


def equivalence_factor(
    curve: TrilinearCurve, damping: Damping, release_amplitude: ArrayLike
) -> Array:
    r"""Return the factor chi of the closed form. [-]

    .. math::
        \chi(x_0; a_1, b_1, a_3) =
        \frac{V(x_0)}{\int_0^{x_0} \hat{c}(x) \sqrt{2 \, (V(x_0) - V(x))} \, \mathrm{d}x},
        \qquad C = \xi \, \hat{c}

    Section 2 of docs/theory.md derives it. Gauss-Legendre quadrature integrates branch by branch
    in s = sqrt(x0 - x), in which the integrand is smooth up to the turning point. All parameters
    broadcast against each other.

    Parameters
    ----------
    curve : TrilinearCurve
        Force-displacement curve.
    damping : Damping
        A viscous model with its parameters; its damping ratio is not used.
    release_amplitude : float or ndarray
        Amplitude x0 = u0/u_ins, between 0 and a3. [-]

    Examples
    --------
    The product pi chi is the damping ratio of a wall divided by that of a linear oscillator with
    the same loss.

    >>> import numpy as np
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> for model in ("CDC", "SDR"):
    ...     factor = rd.equivalence_factor(curve, rd.Damping(model, 1), 0.5)
    ...     print(model, round(np.pi * factor.item(), 2))
    CDC 0.44
    SDR 1.26
    """
    check_type("curve", curve, TrilinearCurve)
    check_type("damping", damping, Damping)
    check_choice("damping_model", damping.model, (*VISCOUS_MODELS, "CQD"))
    a3 = curve.ultimate_displacement_ratio
    x0 = check(
        "release_amplitude",
        release_amplitude,
        lambda x0: (x0 > 0) & (x0 < a3),
        "greater than 0, below a3",
    )
    shape = np.broadcast_shapes(x0.shape, curve.shape, damping.shape)
    if damping.model == "BAND":  # the quadrature would not see where the band ends
        return np.full(shape, 1 / np.pi)
    work = _first_order_work(curve, replace(damping, value=SMALL_RATIO), x0, shape)
    return curve.energy(x0) * SMALL_RATIO / work


def _first_order_work(
    curve: TrilinearCurve, damping: Damping, x0: Array, shape: tuple[int, ...]
) -> Array:
    """Return the work of C along the undamped motion from x0 to 0."""
    a1 = curve.yield_displacement_ratio
    a2 = curve.plateau_end
    pieces = range(PLATEAU_PIECES + 1)
    corners = [np.minimum(a1 * (a2 / a1) ** (piece / PLATEAU_PIECES), x0) for piece in pieces]
    nodes, weights = (
        values.reshape(-1, *(1,) * len(shape)) for values in (GAUSS_NODES, GAUSS_WEIGHTS)
    )
    v0 = curve.energy(x0)
    work = np.zeros(shape)
    for low, high in pairwise([0.0, *corners, x0]):
        start = np.sqrt(x0 - high)
        end = np.sqrt(x0 - low)
        s = 0.5 * (start + end) + 0.5 * (end - start) * nodes
        x = x0 - s * s
        speed = np.sqrt(np.maximum(2 * (v0 - curve.energy(x)), 0))
        coefficient = damping_coefficient(curve, damping, x, speed)
        terms = 0.5 * (end - start) * weights * 2 * s * coefficient * speed
        # Summed one by one, a wall has the same bits whatever walls stand beside it.
        work = sum(terms, start=work)
    return work


def damping_ratio_energy(
    curve: TrilinearCurve, damping_model: str, restitution: ArrayLike, release_amplitude: ArrayLike
) -> Array:
    r"""Return the damping ratio by the closed form. [-]

    .. math::
        \xi = \chi(x_0; a_1, b_1, a_3) \, \delta, \qquad \delta = -\ln e; \qquad
        \text{ECD:} \quad \xi = \frac{\delta}{\sqrt{\pi^2 + \delta^2}}, \quad
        \text{BAND:} \quad \xi = \frac{\delta}{\pi}

    The factor chi is `equivalence_factor`. For ECD and BAND the ratio is exact: every peak of a
    free decay equals that under restitution. Sections 2, 4 and 9 of docs/theory.md derive them. All
    parameters broadcast against each other.

    Parameters
    ----------
    curve : TrilinearCurve
        Force-displacement curve.
    damping_model : {"CDC", "CDR", "SDR", "ECD", "BAND", "CQD"}
        Viscous model.
    restitution : float or ndarray
        Coefficient of restitution e, greater than 0 and at most 1. [-]
    release_amplitude : float or ndarray
        Amplitude u0/u_ins, between 0 and a3. [-]

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> rd.damping_ratio_energy(curve, "ECD", [0.8, 0.9], 0.5).round(4)
    array([0.0709, 0.0335])
    """
    e = check("restitution", restitution, *RESTITUTION_RULE)
    factor = equivalence_factor(curve, Damping(damping_model, 1.0), release_amplitude)
    delta = 0.0 - np.log(e)  # 0 and not -0 for e = 1
    if damping_model == "ECD":
        return delta / np.hypot(np.pi, delta) + np.zeros_like(factor)
    if damping_model == "BAND":
        return delta / np.pi + np.zeros_like(factor)
    return delta * factor


def giannini_masiani(restitution: ArrayLike) -> Array:
    r"""Return the damping ratio of Giannini and Masiani, Eq. (15). [-]

    .. math:: \xi = \frac{2 \, (1 - e)}{\pi \, (1 + e)}

    It depends neither on the curve nor on the amplitude.

    Parameters
    ----------
    restitution : float or ndarray
        Coefficient of restitution e, greater than 0 and at most 1. [-]

    Examples
    --------
    >>> import rockdamp as rd
    >>> rd.giannini_masiani([0.8, 1.0]).round(4)
    array([0.0707, 0.    ])
    """
    e = check("restitution", restitution, *RESTITUTION_RULE)
    return 2 * (1 - e) / (np.pi * (1 + e))
