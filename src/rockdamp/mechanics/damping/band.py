"""BAND, a damper that acts for a fixed time about each crossing of u = 0, and CQD, one that acts over a fixed length.

Derived in docs/theory.md, section 9. Both need u and v alone. BAND loses the same share of the energy in every half
cycle; CQD stands beside it in comparisons only.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array, Quantity
from rockdamp.errors import require
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping.base import RANGES, Damping

MOST_STRENGTH = 3.4  # of delta'; a narrow band divides by zero at 2 sqrt(3) = 3.46
NODES, WEIGHTS = np.polynomial.legendre.leggauss(60)  # integrates the loss to the last digits


def half_cycle_loss(strength: ArrayLike, width: ArrayLike) -> Array:
    r"""Return delta = -ln e of a half cycle that crosses u = 0 on the first branch under BAND. [-]

    .. math:: \delta = \int_{-t_c}^{t_c} \frac{G\,(1+t^2)^{-2}}{1 + G\,t/(1+t^2)}\,dt, \qquad
              G = \frac{3\delta'}{4 t_c}\left(1 - \frac{t^2}{t_c^2}\right)

    Parameters
    ----------
    strength : float or ndarray
        delta', from 0 to 3.4, broadcasts. [-]
    width : float or ndarray
        t_c, broadcasts. [rad]
    """
    return _loss_and_slope(np.asarray(strength, dtype=float), np.asarray(width, dtype=float))[0]


def _loss_and_slope(strength: Array, width: Array) -> tuple[Array, Array]:
    """Return delta, and its derivative by delta'."""
    t = width[..., None] * NODES
    cosine = 1 / (1 + t * t)  # squared, of the phase
    per_strength = 0.75 * (1 - NODES**2)  # G t_c/delta'
    g = strength[..., None] / width[..., None] * per_strength
    below = 1 + g * t * cosine
    slope = WEIGHTS * per_strength * cosine**2 / below
    return np.sum(strength[..., None] * slope, axis=-1), np.sum(slope / below, axis=-1)


def band_strength(log_decrement: ArrayLike, width: ArrayLike) -> Array:
    """Return delta' with which a half cycle loses delta = -ln e, the inverse of `half_cycle_loss`. [-]

    The short form delta (1 + 0.4 t_c^2 - 0.097 t_c^4 - 0.043 delta^2) is within 0.1 % of it for e from 0.5 to 1 and
    t_c up to 0.4. Newton's method falls to it from a strength that loses more, as delta is convex in delta'.

    Parameters
    ----------
    log_decrement : float or ndarray
        delta, from 0 to that of delta' = 3.4, broadcasts. [-]
    width : float or ndarray
        t_c, broadcasts. [rad]
    """
    delta, t_c = np.broadcast_arrays(np.asarray(log_decrement, dtype=float), np.asarray(width, dtype=float))
    strength = np.minimum(delta * (1 + t_c**2), MOST_STRENGTH)
    while True:
        loss, slope = _loss_and_slope(strength, t_c)
        step = (loss - delta) / slope
        moves = step > 1e-15 * strength
        if not moves.any():
            return strength
        strength = np.where(moves, strength - step, strength)


def within_time(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
    """Return C of BAND: size (1 - (z/(c v))^2). At rest it is the size at z = 0, and 0 elsewhere."""
    size, c = parameters[0], parameters[1]
    r = np.minimum(z / np.maximum(c * np.abs(v), 1e-90), 1.0)
    return size * (1.0 - r * r)


def within_time_law(z: float, f: float, double_v: float, v: float, parameters: tuple[float, ...]) -> float:
    """Return the same by the distance to the edge of the band."""
    size, c = parameters
    reach = max(c * abs(v), 1e-90)
    return size * (reach - z) * (reach + z) / (reach * reach) if z < reach else 0.0


def within_length(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
    """Return C of CQD in a step h: the integral of mu from z - h v/2 to z + h v/2, over h."""
    size, w, h = parameters
    half = 0.5 * h * v
    a = np.minimum(np.maximum((z - half) / w, -1.0), 1.0)
    b = np.minimum(np.maximum((z + half) / w, -1.0), 1.0)
    return size * np.abs((b - a) * (1.0 - (a * a + a * b + b * b) / 3.0)) / h


def within_length_law(z: float, f: float, double_v: float, v: float, parameters: tuple[float, ...]) -> float:
    """Return mu |v|; it is asked inside the band alone, whose ends are ends of branches."""
    size, w = parameters
    return size * (w - z) * (w + z) / (w * w * w) * abs(v)


class Band(Damping):
    """A damper of the width `width` about u = 0, with the loss delta = pi xi."""

    names: ClassVar[tuple[str, ...]] = ("damping_ratio", "width")
    largest_damping_ratio = -math.log(0.01) / math.pi

    def __init__(self, model: str, *values: Quantity, **named: Quantity) -> None:
        super().__init__(model, *values, **named)
        most = self.largest_damping_ratio
        require(self.damping_ratio <= most, "damping_ratio (xi)", self.damping_ratio, f"at most {most:.3g}: e = 0.01")

    @classmethod
    def exact_damping_ratio(cls, restitution: ArrayLike, **named: Quantity) -> Array:
        return (0.0 - np.log(restitution)) / math.pi


class FixedTimeBand(Band):
    """BAND: C = (3 delta'/(4c)) max(0, 1 - (x/(c v))^2), c = t_c/w1.

    Every half cycle that enters the band on the first branch loses the same fraction of the energy, from any amplitude.
    """

    model = "BAND"
    title = "band of fixed time"
    colour = "#D0267F"
    # ASSUME: the paper has no such damper. A narrower band is nearer to restitution, with a force as 1/t_c [rad].
    defaults: ClassVar[Mapping[str, float]] = {"width": 0.2}
    amplitude_independent = True

    def __init__(self, model: str, *values: Quantity, **named: Quantity) -> None:
        super().__init__(model, *values, **named)
        most = half_cycle_loss(MOST_STRENGTH, self.width) / math.pi
        least = np.min(most, initial=self.largest_damping_ratio)
        require(
            self.damping_ratio <= most, "damping_ratio (xi)", self.damping_ratio, f"at most {least:.3g} with its width"
        )

    @property
    def _strength(self) -> Array:
        """delta' [-]."""
        return band_strength(math.pi * self.damping_ratio, self.width)

    def formula_parameters(self, curve: TrilinearCurve) -> tuple[Quantity, ...]:
        c = self.width / curve.initial_frequency
        return 3 * self._strength / (4 * c), c

    formula = staticmethod(within_time)
    law = staticmethod(within_time_law)

    def law_parameters(self, curve: TrilinearCurve) -> tuple[float, ...]:
        c = float(self.width) / math.sqrt(float(curve.initial_stiffness))
        return 0.75 * float(self._strength) / c, c

    def check_step(self, curve: TrilinearCurve, step: Quantity) -> None:
        c = self.width / curve.initial_frequency
        least = np.min(c, initial=np.inf)
        require(step <= c, "step", step, f"at most c = t_c/w1 = {least:.3g} (in tau): two steps in the band")


class FixedLengthBand(Band):
    """CQD: C = mu(x) |v|, mu = (3 delta/(4w)) max(0, 1 - (x/w)^2), w = width a1; delta is exact as w tends to 0.

    A march takes the mean of mu over its step, lest the wall pass the band between two steps.
    """

    model = "CQD"
    title = "band of fixed length"
    colour = "#7F7F7F"
    defaults: ClassVar[Mapping[str, float]] = {"width": 0.25}
    ranges: ClassVar[Mapping[str, Any]] = {
        **RANGES,
        "width": ("width (w/a1)", lambda width: (width > 0) & (width <= 1), "greater than 0 and at most 1"),
    }
    takes_step = True

    def formula_parameters(self, curve: TrilinearCurve) -> tuple[Quantity, ...]:
        return 0.75 * math.pi * self.damping_ratio, self.width * curve.yield_displacement_ratio

    formula = staticmethod(within_length)
    law = staticmethod(within_length_law)

    def law_parameters(self, curve: TrilinearCurve) -> tuple[float, ...]:
        return 3 * math.pi * float(self.damping_ratio) / 4, float(self.width) * float(curve.yield_displacement_ratio)

    def unchecked_coefficient(self, curve: TrilinearCurve, x: Array, v: Array) -> Quantity:
        size, w = self.formula_parameters(curve)
        return size / w * np.maximum(1 - (x / w) ** 2, 0) * np.abs(v)
