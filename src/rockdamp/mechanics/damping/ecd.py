"""ECD: the damper that loses in every half cycle what an impact takes, of any order m.

Derived in docs/theory.md, sections 4 and 7. With the phase of the motion, tan phi = sqrt(V/T) and positive on the way
out, a coefficient C = w_E D(phi), w_E = abs(f)/sqrt(2V), loses the same fraction from every amplitude of any curve.
With an exponent g the damper's size kappa goes with E^-g, E = T + V, and the loss with the amplitude (section 8).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arguments import numbers
from rockdamp.arrays import Array, Quantity
from rockdamp.errors import InputError, holds, require
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping.base import RANGES, Damping

DOUBLED_ORDERS = (1, 2, 4, 8, 16, 32, 64, 128)  # their power takes multiplications alone, any other a library's power
# ASSUME: of kappa cos^(2m+1) phi sin phi, which is less than 1 where half cycles end. Beyond it the damper is no longer
# exact: the motion is then nearly the creep of an overdamped oscillator.
CAP = 0.95


# --- what a half cycle loses ------------------------------------------------------------------------------------------


def normalisation(order: ArrayLike) -> Array:
    r"""Return N_m, which makes 2 xi N_m the size kappa of the damper of order m with xi = delta/pi. [-]

    .. math:: N_m = \frac{\pi/2}{\int_{-\pi/2}^{\pi/2} \cos^{2m+2}\varphi\,d\varphi}
              = \frac{\sqrt{\pi}}{2}\,\frac{\Gamma(m+2)}{\Gamma(m+3/2)}

    It is 1, 4/3 and 8/5 at orders 0, 1 and 2, and tends to sqrt(pi m)/2.
    """
    m = numbers("order (m)", order)
    ratio = [math.exp(math.lgamma(one + 2) - math.lgamma(one + 1.5)) for one in np.ravel(m).tolist()]
    return np.where(m == 0, 1.0, math.sqrt(math.pi) / 2 * np.reshape(ratio, m.shape))


def damping_ratio(log_decrement: ArrayLike, order: ArrayLike = 0.0) -> Array:
    """Return xi with which ECD of order m loses delta = -ln e in every half cycle: exact, and without a fit. [-]

    It is delta/pi, at every order above 0. Order 0, which has no velocity in it, has the linear oscillator's,
    delta/sqrt(pi^2 + delta^2).
    """
    delta = np.asarray(log_decrement, dtype=float)
    return np.where(np.asarray(order) == 0, delta / np.hypot(np.pi, delta), delta / np.pi)


def log_decrement(damping_ratio: ArrayLike, order: ArrayLike = 0.0) -> Array:
    """Return delta = -ln e of a half cycle, the inverse of `damping_ratio`, for xi below 1. [-]"""
    xi = np.asarray(damping_ratio, dtype=float)
    return np.where(np.asarray(order) == 0, np.pi * xi / np.sqrt(1 - xi**2), np.pi * xi)


def loss_at(log_decrement: ArrayLike, exponent: ArrayLike) -> Array:
    """Return (1 - e^2g)/(2g), which takes the place of delta = -ln e where the loss has an exponent g. [-]"""
    delta, g = np.asarray(log_decrement, dtype=float), np.asarray(exponent, dtype=float)
    return np.where(g == 0, delta, -np.expm1(-2 * g * delta) / np.where(g == 0, 1.0, 2 * g))


def critical_damping_ratio(order: ArrayLike) -> Array:
    r"""Return xi from which a half cycle does not end: the motion creeps to the origin and never crosses it. [-]

    There kappa cos^(2m+1) phi sin phi reaches 1 at its largest, tan^2 phi = 1/(2m+1):

    .. math:: \xi_c = \frac{\sqrt{2m+2}}{2 N_m}\left(\frac{2m+2}{2m+1}\right)^{m+1/2}

    It rises from 1 at order 0, the linear oscillator's, to sqrt(2 exp(1)/pi) = 1.3155.
    """
    m = numbers("order (m)", order)
    return np.sqrt(2 * m + 2) / (2 * normalisation(m)) * np.exp((m + 0.5) * np.log1p(1 / (2 * m + 1)))


def least_restitution(order: ArrayLike) -> Array:
    """Return e below which a damper of an order above 0 is refused: its half cycles would not end. [-]"""
    return np.exp(-np.pi * CAP * critical_damping_ratio(order))


# --- the coefficient --------------------------------------------------------------------------------------------------


def of_order_0(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
    """Return C of order 0: it goes with the energy's frequency w, w^2 = f^2/(2V)."""
    return parameters[0] * np.sqrt(f * f / double_v)


def of_any_order(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
    """Return C of the order m that stands in the parameters; order 0 has no denominator."""
    double_t, root = v * v, np.sqrt(double_v)
    inverse = 1.0 / (double_t + double_v)
    size = parameters[0] * (double_t * inverse) ** parameters[1]
    outwards = np.minimum(size * v * root * inverse, 0.95) * (parameters[1] > 0.0)  # CAP: compiled code takes numbers
    return size * f / (root * (1.0 - outwards))


def of_any_loss(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
    """Return C of any order and exponent: kappa (2 E)^-g in place of kappa. Order 0 without a g has no denominator."""
    double_t, root = v * v, np.sqrt(double_v)
    inverse = 1.0 / (double_t + double_v)
    size = parameters[0] * inverse ** parameters[2] * (double_t * inverse) ** parameters[1]
    outwards = np.minimum(size * v * root * inverse, 0.95) * (parameters[1] + parameters[2] > 0.0)
    return size * f / (root * (1.0 - outwards))


def of_doubled_order(z: Any, f: Any, double_v: Any, v: Any, parameters: Any) -> Any:
    """Return C of an order m of `DOUBLED_ORDERS`, which stands in the parameters: one formula for all of them.

    m is a number. The kinetic fraction is squared where it is at least 2, and again where it is at least 4, 8 up to
    128: choices, of which the compiler makes vectors, as it does not of a chain of maxima.
    """
    double_t, root, m = v * v, np.sqrt(double_v), parameters[1]
    inverse = 1.0 / (double_t + double_v)
    power = double_t * inverse
    power = power * power if m >= 2.0 else power
    power = power * power if m >= 4.0 else power
    power = power * power if m >= 8.0 else power
    power = power * power if m >= 16.0 else power
    power = power * power if m >= 32.0 else power
    power = power * power if m >= 64.0 else power
    power = power * power if m >= 128.0 else power
    size = parameters[0] * power
    return size * f / (root * (1.0 - np.minimum(size * v * root * inverse, 0.95)))


def energy_law(z: float, f: float, double_v: float, v: float, parameters: tuple[float, ...]) -> float:
    """Return C by the tangent u of the phase, where the formulas have energies: cos^2 = 1/(1 + u^2).

    It is as smooth as its rounding: that of a power grows with m, and the event-driven solver's steps would shrink.
    """
    kappa, m, g, double_r = parameters
    root = math.sqrt(double_v)
    if m == 0.0 and g == 0.0:
        return kappa * f / root
    size = kappa * math.exp(-g * math.log((v * v + double_v) / double_r)) if g > 0.0 else kappa
    if v == 0.0:
        return size * f / root if m == 0.0 else 0.0
    u = root / v
    size *= math.exp(-m * math.log1p(u * u))
    return size * f / root / (1.0 - min(size / (u + 1.0 / u), CAP))


class EnergyConsistent(Damping):
    """ECD of order m: C = w_E kappa cos^2m/(1 - kappa cos^(2m+1) sin) of the phase, kappa = 2 xi N_m.

    ECD alone means m = 0, C = 2 xi w_E, without a phase. It loses the same fraction of the energy in every half cycle,
    from any amplitude, on any odd curve; as m grows it tends to restitution (docs/theory.md, section 7). With an
    exponent g the loss is that of `Damping.cr` with the same g, and xi belongs to the amplitude `at` (section 8).
    """

    model = "ECD"
    title = "energy-consistent damper"
    colour = "#9A4C95"
    names: ClassVar[tuple[str, ...]] = ("damping_ratio", "order")
    defaults: ClassVar[Mapping[str, float]] = {"order": 0.0}
    fades = True
    amplitude_independent = True

    def __init__(self, model: str, *values: Quantity, **named: Quantity) -> None:
        super().__init__(model, *values, **named)
        require(self.exponent < 0.5, "exponent", self.exponent, "at least 0, and for a damper less than 0.5")

    @cached_property
    def _one_order(self) -> float | None:
        """The order, where it is the same for all."""
        orders = np.ravel(self.order)
        return orders.item(0) if orders.size and holds(orders == orders[0]) else None

    @property
    def formula(self) -> Callable[..., Any]:
        order = self._one_order
        if self.loss_depends_on_amplitude:
            return of_any_loss
        if order == 0:
            return of_order_0
        return of_doubled_order if order in DOUBLED_ORDERS else of_any_order

    def formula_parameters(self, curve: TrilinearCurve) -> tuple[Quantity, ...]:
        kappa = 2 * self.damping_ratio * normalisation(self.order)
        if not self.loss_depends_on_amplitude:
            return kappa, self.order if self._one_order is None else self._one_order
        return kappa * self.reference_energy(curve) ** self.exponent, self.order, self.exponent

    @property
    def linear_branches(self) -> int:
        return 1 if self._one_order == 0 and not self.loss_depends_on_amplitude else 0

    law = staticmethod(energy_law)

    def law_parameters(self, curve: TrilinearCurve) -> tuple[float, ...]:
        m = float(self.order)
        # The integral of cos^(2m+2) over a half cycle is the beta function of m + 3/2 and 1/2.
        integral = math.exp(math.lgamma(m + 1.5) + math.lgamma(0.5) - math.lgamma(m + 2)) if m else math.pi / 2
        kappa = math.pi * float(self.damping_ratio) / integral
        if not self.loss_depends_on_amplitude:
            return kappa, m, 0.0, 1.0
        return kappa, m, float(self.exponent), float(self.reference_energy(curve))

    @classmethod
    def exact_damping_ratio(cls, restitution: ArrayLike, **named: Quantity) -> Array:
        m, delta = numbers("order (m)", named.get("order", 0.0)), 0.0 - np.log(restitution)
        g = numbers("exponent", named.get("exponent", 0.0))
        require(m >= 0, "order (m)", m, RANGES["order"][2])
        xi = np.where(g == 0, damping_ratio(delta, m), loss_at(delta, g) / np.pi)
        most = np.where((m == 0) & (g == 0), np.inf, CAP * critical_damping_ratio(m))
        if not holds(xi < most):
            least = np.max(np.exp(-np.pi * np.broadcast_to(most, xi.shape)[~(xi < most)]))
            raise InputError(
                f"restitution (e) is {np.min(restitution):.3g}; it must be at least {least:.3g} for a damper of an"
                " order above 0, whose half cycles would else not end"
            )
        return xi
