"""The closed-form equivalence between a coefficient of restitution and a viscous damping ratio.

An impact takes the fraction 1 - e^2 of the energy V(x0) that a half cycle starts with. A damper C = xi c_hat(x) takes,
to first order in the loss, the work of C along the undamped motion. Equating the two separates e from the curve:

    xi = delta g(x0; a1, b1, a3),   delta = -ln e,
    g  = V(x0) / integral_0^x0 c_hat(x) sqrt(2 (V(x0) - V(x))) dx.

For the energy-consistent damper g = 1/pi at any amplitude and of any curve, and the result is exact beyond first
order: xi = delta/sqrt(pi^2 + delta^2); of BAND xi = delta/pi.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arguments import broadcast, instance, numbers
from rockdamp.arrays import Array
from rockdamp.errors import require
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.damping.base import IMPACT, RANGES
from rockdamp.plausibility import of_restitution, per_cent, warn
from rockdamp.questions import of_exchanged, of_start

NODES, WEIGHTS = np.polynomial.legendre.leggauss(32)
AT_ONCE = 2**15  # values of the integrand: few enough for the processor's cache
FIRST_ORDER = 2.0**-40  # the xi of the work: to first order, as some C are not in proportion to xi; no bit is lost
PLATEAU_PIECES = 4  # in geometric progression: the frequencies fall as powers of x along the plateau


@dataclass(frozen=True)
class Scan:
    """Damping ratios, in a geometric sequence, among which the least error is looked for before it is refined."""

    smallest: float  # over the closed form's damping ratio [-]
    largest: float
    points: int

    def __post_init__(self) -> None:
        require(self.smallest < self.largest, "largest", self.largest, f"greater than smallest, {self.smallest:g}")


def equivalence_factor(curve: TrilinearCurve, damping: Damping, release_amplitude: ArrayLike) -> Array:
    r"""Return the factor g of the closed form, for the model of `damping` (its xi is not used).

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
        A viscous model.
    release_amplitude : float or ndarray
        x0, in (0, a3), broadcasts. [-]

    Returns
    -------
    ndarray, of the shape that the arguments broadcast to
        g. [-]

    Raises
    ------
    InputError
        If the model is CR, or an amplitude lies outside (0, a3).

    Examples
    --------
    Times pi, it is how much more damping a wall needs than a linear oscillator.

    >>> import numpy as np
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> [round(np.pi * rd.equivalence_factor(curve, rd.Damping(model, 1), 0.5).item(), 2) for model in ("CDC", "SDR")]
    [0.44, 1.26]
    """
    instance("curve", curve, TrilinearCurve)
    instance("damping", damping, Damping)
    require(damping.step_kind != IMPACT, "damping_model", damping.model, "a viscous model")
    x0 = numbers("release_amplitude", release_amplitude)
    broadcast(release_amplitude=x0, curve=curve, damping=damping)
    require(
        (x0 > 0) & (x0 < curve.ultimate_displacement_ratio), "release_amplitude", x0, "greater than 0 and less than a3"
    )
    if damping.model == "BAND":  # by its construction; the quadrature would not see the end of the band
        return np.full(np.broadcast_shapes(x0.shape, curve.shape, damping.shape), 1 / np.pi)
    unit = damping.replace(damping_ratio=np.full((), FIRST_ORDER))
    v0 = curve.energy(x0)
    _, _, _, a1, a2, _ = curve.parameters()
    inner = [a1 * (a2 / a1) ** (piece / PLATEAU_PIECES) for piece in range(PLATEAU_PIECES + 1)]
    ends = [np.zeros(()), *(np.minimum(end, x0) for end in inner), x0]
    work = np.zeros(np.broadcast_shapes(x0.shape, curve.shape, unit.shape))
    at_once = max(AT_ONCE // max(work.size, 1), 1)
    rule = np.stack([NODES, WEIGHTS], axis=1).reshape(-1, 2, *(1,) * work.ndim)
    for low, high in pairwise(ends):
        s0, s1 = np.sqrt(x0 - high), np.sqrt(x0 - low)
        for first in range(0, NODES.size, at_once):
            node, weight = rule[first : first + at_once].swapaxes(0, 1)
            s = 0.5 * (s0 + s1) + 0.5 * (s1 - s0) * node
            x = x0 - s * s
            speed = np.sqrt(np.maximum(2 * (v0 - curve.energy(x)), 0))
            # One after the other: how many are computed at once must not change a bit of their sum.
            for part in 0.5 * (s1 - s0) * weight * 2 * s * unit.coefficient(curve, x, speed) * speed:
                work = work + part
    return v0 * FIRST_ORDER / work


def damping_ratio_energy(
    curve: TrilinearCurve,
    damping_model: str,
    restitution: ArrayLike,
    release_amplitude: ArrayLike,
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

    Returns
    -------
    ndarray, of the shape that the arguments broadcast to
        xi. [-]

    Raises
    ------
    InputError
        If e lies outside (0, 1], the model is not viscous, or an amplitude lies outside (0, a3).

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> rd.damping_ratio_energy(curve, "ECD", [0.8, 0.9], 0.5).round(4)
    array([0.0709, 0.0335])
    """
    e = check_restitution(restitution)
    damping = Damping.from_values(damping_model, damping_ratio=np.ones(()), restitution=e)
    x0, of = numbers("release_amplitude", release_amplitude), instance("curve", curve, TrilinearCurve)
    broadcast(restitution=e, release_amplitude=x0, curve=of)
    warn([*of_restitution(e), *of_exchanged(e, x0), *of_start(x0, of.yield_displacement_ratio)])
    g = equivalence_factor(curve, damping, release_amplitude)
    delta = 0.0 - np.log(e)
    if not damping.amplitude_independent:
        return delta * g
    ratio = Damping.of_restitution(e, damping.model).damping_ratio
    return np.broadcast_to(ratio, np.broadcast_shapes(e.shape, g.shape)).copy()


def exact_ratio(restitution: ArrayLike) -> Array:
    r"""Return the damping ratio of ECD on any curve, and of a linear oscillator with one impact per crossing. [-]

    .. math:: \xi = \frac{\delta}{\sqrt{\pi^2 + \delta^2}}, \qquad \delta = -\ln e
    """
    delta = 0.0 - np.log(check_restitution(restitution))
    return delta / np.hypot(np.pi, delta)


def giannini_masiani(restitution: ArrayLike) -> Array:
    r"""Return the damping ratio of Giannini and Masiani, Eq. (15), which knows neither curve nor amplitude. [-]

    .. math:: \xi = \frac{2 \, (1 - e)}{\pi \, (1 + e)}

    Parameters
    ----------
    restitution : float or ndarray
        e, in (0, 1]. [-]

    Returns
    -------
    ndarray, shape of `restitution`
        xi. [-]

    Raises
    ------
    InputError
        If e lies outside (0, 1].

    Examples
    --------
    >>> import rockdamp as rd
    >>> rd.giannini_masiani([0.8, 1.0]).round(4)
    array([0.0707, 0.    ])
    """
    e = check_restitution(restitution)
    warn(of_restitution(e))
    return 2 * (1 - e) / (np.pi * (1 + e))


def check_restitution(restitution: ArrayLike) -> Array:
    """Return e as an array of floats, or raise `InputError` unless it lies in (0, 1]."""
    e = numbers("restitution (e)", restitution)
    text, within, allowed = RANGES["restitution"]
    require(within(e), text, e, f"{allowed}{per_cent(e, within)}")
    return e
