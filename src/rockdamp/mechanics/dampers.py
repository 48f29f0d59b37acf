"""The dampers: a class for each damping model, with its parameters and its entry in the kernel.

Everything is dimensionless as in the solvers: unit mass, x = u/u_ins, tau = p t, C over m_eff p.
CR, CDC, CDR and SDR are the paper's, Eqs (8) and (10) to (12). ECD, BAND and CQD go beyond it:
docs/theory.md, sections 4 and 7 to 9. The formulas of C are in `solvers.kernel`, and a second time,
written independently, in the exact solver.
"""

from __future__ import annotations

import math
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.errors import InputError, Rule, check
from rockdamp.mechanics.curve import TrilinearCurve

# ASSUME: kappa cos^(2m+1) phi sin phi of ECD, at the phase phi of tan^2 phi = V/T, is at most this
# value. From 1 on half cycles would not end; near 1 the motion is almost the creep of an overdamped
# oscillator.
CAP = 0.95
LARGEST_BAND_RATIO = -math.log(0.01) / math.pi  # xi of e = 0.01, which takes 99.99 % of the energy
# delta' of BAND. For a narrow band the integrand of `half_cycle_loss` has a pole from
# 2 sqrt(3) = 3.46 on.
LARGEST_STRENGTH = 3.4
DOUBLED_ORDERS = (1, 2, 4, 8, 16, 32, 64, 128)  # orders of ECD by repeated squares in the kernel

AT_LEAST_0: Rule = (lambda x: x >= 0, "at least 0")
ABOVE_0: Rule = (lambda x: x > 0, "greater than 0")
UP_TO_1: Rule = (lambda x: (x >= 0) & (x <= 1), "at least 0 and at most 1")
ABOVE_0_UP_TO_1: Rule = (lambda x: (x > 0) & (x <= 1), "greater than 0 and at most 1")
BAND_RATIO: Rule = (
    lambda xi: (xi >= 0) & (xi <= LARGEST_BAND_RATIO),
    "at least 0 and at most 1.47, that of e = 0.01",
)
ECD_ORDER: Rule = (
    lambda m: (m >= 0) & (m <= 10_000),  # with a larger order a step could pass over the peak of C
    "0 to 10 000",
)
ECD_EXPONENT: Rule = (lambda g: (g >= 0) & (g < 0.5), "at least 0 and less than 0.5")
NOT_TAKEN: Rule = (lambda x: x == 0, "0, as it belongs to another model")

KernelArguments = tuple[str, tuple[Any, Any, Any]]


class Parameters(NamedTuple):
    """Parameters of a `Damping`, which describes them: arrays of floats that broadcast."""

    value: Array
    order: Array
    width: Array
    loss_exponent: Array
    reference_amplitude: Array

    @property
    def has_loss_exponent(self) -> bool:
        """Whether any loss depends on the amplitude."""
        return bool(np.any(self.loss_exponent != 0))

    def double_reference_energy(self, curve: TrilinearCurve) -> Array:
        """Return 2V at the reference amplitude, which must be less than a3 of the curve."""
        a3 = curve.ultimate_displacement_ratio
        check("reference_amplitude", self.reference_amplitude, lambda x: x < a3, "less than a3")
        return 2 * curve.energy(self.reference_amplitude)


class Damper:
    """A damping model without its numbers. A subclass states what differs.

    Attributes
    ----------
    name, title : str
        Name in `Damping` and the datasets, and in words.
    rules : dict
        Rules of the parameters that the model takes. Parameters that are not listed must be 0.
    defaults : dict
        Parameters that are not 0 where they are not given.
    label_parameter : str, optional
        Parameter whose number is part of the label, as in ECD16.
    value_name : str
        Name of the parameter `value` in messages.
    lossless_value : float
        The value with which no energy is lost.
    largest_value : float
        Upper limit of the value.
    is_amplitude_independent : bool
        Whether every half cycle loses the same share of its energy.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    rules: ClassVar[dict[str, Rule]] = {"value": AT_LEAST_0}
    defaults: ClassVar[dict[str, float]] = {}
    label_parameter: ClassVar[str | None] = None
    value_name: ClassVar[str] = "damping_ratio"
    lossless_value: ClassVar[float] = 0.0
    largest_value: ClassVar[float] = math.inf
    is_amplitude_independent: ClassVar[bool] = False

    def check(self, parameters: Parameters) -> None:
        """Refuse parameters that are allowed one by one, but not together."""

    def check_step(self, step: Array, parameters: Parameters, curve: TrilinearCurve) -> None:
        """Refuse steps of the batched solver, in tau, that are too long for the damper."""

    def value_from_restitution(self, e: ArrayLike, parameters: Parameters) -> ArrayLike:
        """Return the value with which each half cycle loses the energy that an impact takes.

        Parameters
        ----------
        e : float or ndarray
            Coefficient of restitution. [-]
        parameters : Parameters
            The other parameters; their value is not read.
        """
        raise InputError(
            f"damping_model is {self.name}; it must be CR, ECD, BAND or CQD: for others use "
            "equivalent"
        )

    def kernel_arguments(self, parameters: Parameters, curve: TrilinearCurve) -> KernelArguments:
        """Return the name of the kernel's formula and its three parameters.

        The parameters broadcast against each other and against the curve's.
        """
        raise NotImplementedError


class CR(Damper):
    """Coefficient of restitution e, Eq. (8): each impact multiplies the velocity by e."""

    name = "CR"
    title = "coefficient of restitution"
    rules = {"value": UP_TO_1, "loss_exponent": AT_LEAST_0}
    value_name = "restitution"
    lossless_value = 1.0

    def check(self, parameters: Parameters) -> None:
        g = parameters.loss_exponent
        check(
            "restitution",
            parameters.value,
            lambda e: (e > 0) | (g == 0),
            "above 0 with an exponent",
        )

    def value_from_restitution(self, e: ArrayLike, parameters: Parameters) -> ArrayLike:
        return e

    def kernel_arguments(self, parameters: Parameters, curve: TrilinearCurve) -> KernelArguments:
        if not parameters.has_loss_exponent:
            return "cr", (parameters.value, 0.0, 0.0)
        double_reference = parameters.double_reference_energy(curve)
        return "cr_law", (parameters.value, parameters.loss_exponent, double_reference)


class ScaledDamper(Damper):
    """A viscous damper whose formula in the kernel has its own name and one factor, `scale`."""

    def scale(self, xi: Array, w1: Array) -> Array:
        """Return the factor from the damping ratio and the first branch's frequency over p."""
        raise NotImplementedError

    def kernel_arguments(self, parameters: Parameters, curve: TrilinearCurve) -> KernelArguments:
        scale = self.scale(parameters.value, curve.initial_frequency)
        return self.name.lower(), (scale, 0.0, 0.0)


class CDC(ScaledDamper):
    """Constant damping coefficient C = 2 xi w1, Eq. (10)."""

    name = "CDC"
    title = "constant damping coefficient"

    def scale(self, xi: Array, w1: Array) -> Array:
        return 2 * w1 * xi


class CDR(ScaledDamper):
    """Constant damping ratio: C = 2 xi w of the secant frequency w, Eq. (11)."""

    name = "CDR"
    title = "constant damping ratio"

    def scale(self, xi: Array, w1: Array) -> Array:
        return 2 * xi


class SDR(ScaledDamper):
    """Stiffness proportional damping ratio: C = 2 xi w^2/w1 of the secant frequency w, Eq. (12)."""

    name = "SDR"
    title = "stiffness proportional damping ratio"

    def scale(self, xi: Array, w1: Array) -> Array:
        return 2 * xi / w1


class ECD(Damper):
    """Energy-consistent damper of order m, docs/theory.md, sections 4, 7 and 8."""

    name = "ECD"
    title = "energy-consistent damper"
    rules = {"value": AT_LEAST_0, "order": ECD_ORDER, "loss_exponent": ECD_EXPONENT}
    label_parameter = "order"
    is_amplitude_independent = True

    def value_from_restitution(self, e: ArrayLike, parameters: Parameters) -> Array:
        e = check("restitution", e, *ABOVE_0_UP_TO_1)
        m = parameters.order
        g = parameters.loss_exponent
        delta = 0.0 - np.log(e)  # 0 and not -0 for e = 1
        has_no_phase = (m == 0) & (g == 0)
        divisor = np.where(g == 0, 1.0, 2 * g)
        # (1 - e^2g)/(2g), which tends to delta as g tends to 0.
        loss = np.where(g == 0, delta, -np.expm1(-2 * g * delta) / divisor)
        # Order 0 on the first branch is the linear oscillator: xi = delta/sqrt(pi^2 + delta^2).
        xi = np.where(has_no_phase, delta / np.hypot(np.pi, delta), loss / np.pi)
        limit = np.where(has_no_phase, np.inf, CAP * critical_damping_ratio(m))
        least = np.max(np.exp(-np.pi * limit), initial=0)
        allowed = f"at least {least:.3g}, or half cycles would not end"
        check("restitution", e, lambda e: xi < limit, allowed)
        return xi

    def kernel_arguments(self, parameters: Parameters, curve: TrilinearCurve) -> KernelArguments:
        m = parameters.order
        g = parameters.loss_exponent
        kappa = 2 * parameters.value * normalisation(m)
        if parameters.has_loss_exponent:
            return "ecd_any", (kappa * parameters.double_reference_energy(curve) ** g, m, g)
        if not m.size or np.any(m != m.flat[0]):
            return "ecd_any", (kappa, m, 0.0)
        order = m.flat[0]
        if order == 0:
            return "ecd", (kappa, order, 0.0)
        if order in DOUBLED_ORDERS:
            return "ecd_doubled", (kappa, order, 0.0)
        return "ecd_any", (kappa, order, 0.0)


class BandDamper(Damper):
    """A damper that acts in a band about x = 0 alone: BAND and CQD."""

    label_parameter = "width"
    largest_value = LARGEST_BAND_RATIO

    def value_from_restitution(self, e: ArrayLike, parameters: Parameters) -> Array:
        e = check("restitution", e, *ABOVE_0_UP_TO_1)
        return (0.0 - np.log(e)) / math.pi


class BAND(BandDamper):
    """Band of fixed time: C acts within t_c of each crossing, docs/theory.md, section 9."""

    name = "BAND"
    title = "band of fixed time"
    rules = {"value": BAND_RATIO, "width": ABOVE_0}
    # ASSUME: the paper has no such band. A narrower one is nearer to restitution, with a force as
    # 1/t_c.
    defaults = {"width": 0.2}
    is_amplitude_independent = True

    def check(self, parameters: Parameters) -> None:
        limit = half_cycle_loss(LARGEST_STRENGTH, parameters.width) / math.pi
        allowed = f"at most {np.min(limit, initial=np.inf):.3g} with its width"
        check("damping_ratio", parameters.value, lambda xi: xi <= limit, allowed)

    def check_step(self, step: Array, parameters: Parameters, curve: TrilinearCurve) -> None:
        limit = parameters.width / curve.initial_frequency
        shortest = np.min(limit, initial=np.inf)
        allowed = f"at most t_c/w1 = {shortest:.3g}: two steps in the band"
        check("step", step, lambda h: h <= limit, allowed)

    def kernel_arguments(self, parameters: Parameters, curve: TrilinearCurve) -> KernelArguments:
        c = parameters.width / curve.initial_frequency
        strength = band_strength(math.pi * parameters.value, parameters.width)
        return "band", (3 * strength / (4 * c), c, 0.0)


class CQD(BandDamper):
    """Band of fixed length, its force by the square of the velocity, docs/theory.md, section 9."""

    name = "CQD"
    title = "band of fixed length"
    rules = {"value": BAND_RATIO, "width": ABOVE_0_UP_TO_1}
    defaults = {"width": 0.25}

    def kernel_arguments(self, parameters: Parameters, curve: TrilinearCurve) -> KernelArguments:
        half_width = parameters.width * curve.yield_displacement_ratio
        # The integral of mu over the band is 4/3 of the size, and must be delta = pi xi.
        return "cqd", (0.75 * math.pi * parameters.value, half_width, 0.0)


DAMPERS: dict[str, Damper] = {
    damper.name: damper() for damper in (CR, CDC, CDR, SDR, ECD, BAND, CQD)
}


# --- ECD in closed form ---------------------------------------------------------------------------


def normalisation(order: ArrayLike) -> Array:
    r"""Return N_m, with which kappa = 2 xi N_m is the size of ECD of order m for xi = delta/pi. [-]

    .. math:: N_m = \frac{\pi/2}{\int_{-\pi/2}^{\pi/2} \cos^{2m+2}\varphi\,d\varphi}
              = \frac{\sqrt{\pi}}{2}\,\frac{\Gamma(m+2)}{\Gamma(m+3/2)}

    It is 1, 4/3 and 8/5 at orders 0, 1 and 2, and tends to sqrt(pi m)/2.

    Parameters
    ----------
    order : float or ndarray
        Order m, at least 0. [-]
    """
    orders = np.asarray(order, dtype=float)
    log_ratios = [math.lgamma(m + 2) - math.lgamma(m + 1.5) for m in orders.flat]
    ratios = [math.exp(log_ratio) for log_ratio in log_ratios]
    at_order = math.sqrt(math.pi) / 2 * np.reshape(ratios, orders.shape)
    return np.where(orders == 0, 1.0, at_order)


def critical_damping_ratio(order: ArrayLike) -> Array:
    r"""Return xi from which a half cycle does not end: the motion creeps to the origin. [-]

    There the largest kappa cos^(2m+1) phi sin phi, at tan^2 phi = 1/(2m+1), reaches 1:

    .. math:: \xi_c = \frac{\sqrt{2m+2}}{2 N_m}\left(\frac{2m+2}{2m+1}\right)^{m+1/2}

    It rises from 1 at order 0, as for the linear oscillator, to sqrt(2 exp(1)/pi) = 1.3155.

    Parameters
    ----------
    order : float or ndarray
        Order m, at least 0. [-]
    """
    m = np.asarray(order, dtype=float)
    power = np.exp((m + 0.5) * np.log1p(1 / (2 * m + 1)))
    return np.sqrt(2 * m + 2) / (2 * normalisation(m)) * power


# --- the strength of BAND -------------------------------------------------------------------------


def _gauss_rule(count: int) -> tuple[Array, Array]:
    """Return the positive nodes of Gauss's rule in (-1, 1), and their weights."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes[count // 2 :], weights[count // 2 :]


COARSE_RULE = _gauss_rule(24)  # integrates the loss to 1e-13 for delta up to 1
FINE_RULE = _gauss_rule(60)  # for a larger delta, whose integrand comes near its pole


def half_cycle_loss(strength: ArrayLike, width: ArrayLike) -> Array:
    r"""Return delta = -ln e of a half cycle that crosses x = 0 on the first branch under BAND. [-]

    .. math:: \delta = \int_{-t_c}^{t_c} \frac{G\,(1+t^2)^{-2}}{1 + G\,t/(1+t^2)}\,dt, \qquad
              G = \frac{3\delta'}{4 t_c}\left(1 - \frac{t^2}{t_c^2}\right)

    Parameters
    ----------
    strength : float or ndarray
        delta', from 0 to 3.4, broadcasts. [-]
    width : float or ndarray
        t_c, broadcasts. [rad]
    """
    terms = _loss_terms(np.asarray(width, dtype=float), FINE_RULE)
    loss, _ = _sum_loss(np.asarray(strength, dtype=float), terms)
    return loss


def band_strength(log_decrement: ArrayLike, width: ArrayLike) -> Array:
    """Return delta' with which a half cycle loses delta = -ln e, the inverse of `half_cycle_loss`.

    The short form delta (1 + 0.4 t_c^2 - 0.097 t_c^4 - 0.043 delta^2) is within 0.1 % of it for e
    from 0.5 to 1 and t_c up to 0.4.

    Parameters
    ----------
    log_decrement : float or ndarray
        delta, from 0 to that of delta' = 3.4, broadcasts. [-]
    width : float or ndarray
        t_c, broadcasts. [rad]
    """
    delta = np.asarray(log_decrement, dtype=float)
    delta, t_c = np.broadcast_arrays(delta, np.asarray(width, dtype=float))
    strength = np.empty(delta.shape)
    is_small = delta <= 1.0
    for rule, members in ((COARSE_RULE, is_small), (FINE_RULE, ~is_small)):
        if members.any():
            strength[members] = _invert_loss(delta[members], t_c[members], rule)
    return strength


def _invert_loss(delta: Array, t_c: Array, rule: tuple[Array, Array]) -> Array:
    """Return the strengths by Newton's method, each with the steps it would take alone."""
    terms = _loss_terms(t_c, rule)
    # The short form's first terms lie above the root. From there the steps fall to it, as the loss
    # is convex.
    strength = np.minimum(delta * (1 + 0.4 * t_c**2), LARGEST_STRENGTH)
    moves = np.ones(delta.shape, dtype=bool)
    while moves.any():
        loss, slope = _sum_loss(strength, terms)
        step = np.where(moves, (loss - delta) / slope, 0.0)
        strength = strength - step
        # The error after a step is as the square of the step: after 1e-8 it is that of rounding.
        moves = np.abs(step) > 1e-8 * strength
    return strength


def _loss_terms(t_c: Array, rule: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return b and w, with which the loss is the sum of delta' w/(1 - (b delta')^2).

    The variable of integration is the phase theta, t = tan(theta), in which the integrand of a wide
    band is smooth. The two nodes at +theta and -theta have one term. The terms are the last axis.
    """
    nodes, weights = rule
    width = t_c[..., None]
    edge = np.arctan(width)
    t = np.tan(edge * nodes)
    cosine_squared = 1 / (1 + t * t)
    g = 0.75 * (1 - (t / width) ** 2) / width  # G/delta'
    return g * t * cosine_squared, 2 * weights * edge * g * cosine_squared


def _sum_loss(strength: Array, terms: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return delta and its derivative by delta'."""
    b, w = terms
    square = (strength[..., None] * b) ** 2
    part = w / (1 - square)
    slope = np.sum(part * (1 + square) / (1 - square), axis=-1)
    return strength * np.sum(part, axis=-1), slope
