"""The damping models: the coefficient of restitution and the viscous dampers.

`Damping` is a model with its numbers. A subclass of `Damper` for each model holds its properties
that need no numbers, and its entry in the kernel.

Everything is dimensionless as in the solvers: unit mass, x = u/u_ins, tau = p t, C over m_eff p.
CR, CDC, CDR and SDR are the paper's, Eqs (8) and (10) to (12). ECD, BAND and CQD go beyond it:
docs/theory.md, sections 4 and 7 to 9. The formulas of C are in `solvers.kernel`, and a second time,
written independently, in the exact solver.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array, short_repr
from rockdamp.errors import InputError, Rule, check, check_choice
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.half_cycle_loss import (
    CAP,
    LARGEST_STRENGTH,
    band_strength,
    critical_damping_ratio,
    half_cycle_loss,
    normalisation,
)

LARGEST_BAND_RATIO = -math.log(0.01) / math.pi  # xi of e = 0.01, which takes 99.99 % of the energy
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

# ASSUME: the amplitude u/u_ins that e refers to where the loss depends on the amplitude and none is
# given.
REFERENCE_AMPLITUDE = 0.3
PARAMETERS = ("value", "order", "width", "loss_exponent", "reference_amplitude")


@dataclass(frozen=True, eq=False)
class Damping:
    """A damping model with its parameters, which broadcast against each other and the walls.

    Parameters
    ----------
    model : {"CR", "CDC", "CDR", "SDR", "ECD", "BAND", "CQD"}
        Name of the model.
    value : float or ndarray
        For CR the coefficient of restitution e, 0 to 1: whenever u changes sign, the velocity is
        multiplied by e. For the other models the damping ratio xi, at least 0; that of BAND is
        -ln(e)/pi: `from_restitution` takes e. [-]
    order : float or ndarray, optional
        Order m of ECD; a larger order is closer to restitution. The default is 0. [-]
    width : float or ndarray, optional
        For BAND the half width t_c, 0.2 by default: C acts where ``|x| < t_c |x'|/w1`` [rad]. For
        CQD the half width divided by a1, 0.25 by default [-].
    loss_exponent : float or ndarray
        Exponent g of CR and ECD. With g > 0 the relative loss is larger at small amplitudes: an
        impact at the energy E- leaves E+^g = E-^g - E_r^g (1 - e^2g), or stops the wall. For ECD
        less than 0.5. The default is 0. [-]
    reference_amplitude : float or ndarray
        Amplitude u/u_ins that the value refers to, with the energy E_r = V(u); less than a3 of the
        curve. The default is 0.3. [-]

    Examples
    --------
    >>> import rockdamp as rd
    >>> rd.Damping("CDR", 0.05).value.item()
    0.05
    >>> rd.Damping("ECD", 0.05, order=16).label
    'ECD16'
    """

    model: str
    value: Any
    order: Any = None
    width: Any = None
    loss_exponent: Any = 0.0
    reference_amplitude: Any = REFERENCE_AMPLITUDE

    def __post_init__(self) -> None:
        check_choice("damping_model", self.model, tuple(DAMPERS))
        damper = self.damper
        rules = {"reference_amplitude": ABOVE_0, **damper.rules}
        for parameter in PARAMETERS:
            value = getattr(self, parameter)
            if value is None and parameter in ("order", "width"):
                value = damper.defaults.get(parameter, 0.0)
            name = damper.value_name if parameter == "value" else parameter
            checked = check(name, value, *rules.get(parameter, NOT_TAKEN))
            object.__setattr__(self, parameter, checked)
        damper.check(self)

    def __repr__(self) -> str:
        return short_repr(self, {"order": 0.0, "width": 0.0} | self.damper.defaults)

    @classmethod
    def from_restitution(
        cls,
        e: ArrayLike,
        model: str = "BAND",
        *,
        order: ArrayLike | None = None,
        width: ArrayLike | None = None,
        loss_exponent: ArrayLike = 0.0,
        reference_amplitude: ArrayLike = REFERENCE_AMPLITUDE,
    ) -> Damping:
        """Return the damper that loses as much energy in each half cycle as one impact.

        It is exact and needs no fit.

        Parameters
        ----------
        e : float or ndarray
            Coefficient of restitution, in (0, 1]. [-]
        model : {"CR", "ECD", "BAND", "CQD"}
            CR is restitution itself. CQD becomes exact as its width tends to 0.
        order : float or ndarray, optional
            Order m of ECD. The default is 0. [-]
        width : float or ndarray, optional
            For BAND the half width t_c, 0.2 by default: C acts where ``|x| < t_c |x'|/w1`` [rad].
            For CQD the half width divided by a1, 0.25 by default [-].
        loss_exponent : float or ndarray
            Exponent g of CR and ECD; with g > 0 the relative loss is larger at small amplitudes.
            The default is 0. [-]
        reference_amplitude : float or ndarray
            Amplitude u/u_ins that e refers to, where the loss depends on the amplitude. The default
            is 0.3. [-]

        Raises
        ------
        InputError
            For CDC, CDR and SDR, whose ratio depends on curve and amplitude, and for an e at which
            a half cycle with ECD would not end.

        Examples
        --------
        >>> import rockdamp as rd
        >>> rd.Damping.from_restitution([0.8, 0.85]).value.round(4)
        array([0.071 , 0.0517])
        """
        damper = DAMPERS[check_choice("damping_model", model, tuple(DAMPERS))]
        start = damper.lossless_value
        lossless = cls(model, start, order, width, loss_exponent, reference_amplitude)
        value = damper.value_from_restitution(e, lossless)
        return replace(lossless, value=value)

    @property
    def damper(self) -> Damper:
        """Properties of the model that need no numbers."""
        return DAMPERS[self.model]

    @property
    def parameters(self) -> tuple[Array, ...]:
        """Value, order, width, loss exponent and reference amplitude."""
        return tuple(getattr(self, parameter) for parameter in PARAMETERS)

    @property
    def has_loss_exponent(self) -> bool:
        """Whether any loss depends on the amplitude."""
        return bool(np.any(self.loss_exponent != 0))

    @property
    def label(self) -> str:
        """Name in datasets: ECD16, BAND0.4; only the model for a default and for arrays."""
        number = self.family_parameter
        default = self.damper.defaults.get(self.damper.label_parameter or "", 0.0)
        if math.isnan(number) or number == default:
            return self.model
        return f"{self.model}{number:g}"

    @property
    def family_parameter(self) -> float:
        """Order of ECD, or width of BAND and CQD; NaN for other models and for arrays. [-]"""
        parameter = self.damper.label_parameter
        if parameter is None or getattr(self, parameter).ndim:
            return math.nan
        return float(getattr(self, parameter))

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape that the parameters broadcast to."""
        return np.broadcast_shapes(*(values.shape for values in self.parameters))

    def map(self, function: Callable[[Array], Array]) -> Damping:
        """Return the same model with a function applied to each parameter.

        Parameters
        ----------
        function : callable
            Takes an array of the shape `shape`, and returns some of its elements or repeats them.
        """
        parameters = np.broadcast_arrays(*self.parameters)
        return Damping(self.model, *map(function, parameters))

    def kernel_arguments(self, curve: TrilinearCurve) -> KernelArguments:
        """Return the name of the kernel's formula and its three parameters.

        Parameters
        ----------
        curve : TrilinearCurve
            Curve of the walls; the three parameters broadcast against its ratios.
        """
        return self.damper.kernel_arguments(self, curve)

    def double_reference_energy(self, curve: TrilinearCurve) -> Array:
        """Return 2V at the reference amplitude, which must be less than a3 of the curve.

        Parameters
        ----------
        curve : TrilinearCurve
            Curve of the walls, which broadcasts against the reference amplitude.
        """
        a3 = curve.ultimate_displacement_ratio
        check("reference_amplitude", self.reference_amplitude, lambda x: x < a3, "less than a3")
        return 2 * curve.energy(self.reference_amplitude)


# --- the models -----------------------------------------------------------------------------------


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

    def check(self, damping: Damping) -> None:
        """Refuse parameters that are allowed one by one, but not together."""

    def check_step(self, step: Array, damping: Damping, curve: TrilinearCurve) -> None:
        """Refuse steps of the batched solver, in tau, that are too long for the damper."""

    def value_from_restitution(self, e: ArrayLike, damping: Damping) -> ArrayLike:
        """Return the value with which each half cycle loses the energy that an impact takes.

        Parameters
        ----------
        e : float or ndarray
            Coefficient of restitution. [-]
        damping : Damping
            Damping with the other parameters; its value is not read.
        """
        raise InputError(
            f"damping_model is {self.name}; it must be CR, ECD, BAND or CQD, as the ratio of "
            "others depends on the curve: use equivalent"
        )

    def kernel_arguments(self, damping: Damping, curve: TrilinearCurve) -> KernelArguments:
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

    def check(self, damping: Damping) -> None:
        g = damping.loss_exponent
        check(
            "restitution",
            damping.value,
            lambda e: (e > 0) | (g == 0),
            "greater than 0 with a loss exponent",
        )

    def value_from_restitution(self, e: ArrayLike, damping: Damping) -> ArrayLike:
        return e

    def kernel_arguments(self, damping: Damping, curve: TrilinearCurve) -> KernelArguments:
        if not damping.has_loss_exponent:
            return "cr", (damping.value, 0.0, 0.0)
        double_reference = damping.double_reference_energy(curve)
        return "cr_law", (damping.value, damping.loss_exponent, double_reference)


class ScaledDamper(Damper):
    """A viscous damper whose formula in the kernel has its own name and one factor, `scale`."""

    def scale(self, xi: Array, w1: Array) -> Array:
        """Return the factor from the damping ratio and the initial frequency divided by p."""
        raise NotImplementedError

    def kernel_arguments(self, damping: Damping, curve: TrilinearCurve) -> KernelArguments:
        scale = self.scale(damping.value, curve.initial_frequency)
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
    """Stiffness-proportional damping ratio: C = 2 xi w^2/w1 of the secant frequency w, Eq. (12)."""

    name = "SDR"
    title = "stiffness-proportional damping ratio"

    def scale(self, xi: Array, w1: Array) -> Array:
        return 2 * xi / w1


class ECD(Damper):
    """Energy-consistent damper of order m, docs/theory.md, sections 4, 7 and 8."""

    name = "ECD"
    title = "energy-consistent damper"
    rules = {"value": AT_LEAST_0, "order": ECD_ORDER, "loss_exponent": ECD_EXPONENT}
    label_parameter = "order"
    is_amplitude_independent = True

    def value_from_restitution(self, e: ArrayLike, damping: Damping) -> Array:
        e = check("restitution", e, *ABOVE_0_UP_TO_1)
        m = damping.order
        g = damping.loss_exponent
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

    def kernel_arguments(self, damping: Damping, curve: TrilinearCurve) -> KernelArguments:
        m = damping.order
        g = damping.loss_exponent
        kappa = 2 * damping.value * normalisation(m)
        if damping.has_loss_exponent:
            return "ecd_any", (kappa * damping.double_reference_energy(curve) ** g, m, g)
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

    def value_from_restitution(self, e: ArrayLike, damping: Damping) -> Array:
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

    def check(self, damping: Damping) -> None:
        limit = half_cycle_loss(LARGEST_STRENGTH, damping.width) / math.pi
        allowed = f"at most {np.min(limit, initial=np.inf):.3g} with its width"
        check("damping_ratio", damping.value, lambda xi: xi <= limit, allowed)

    def check_step(self, step: Array, damping: Damping, curve: TrilinearCurve) -> None:
        limit = damping.width / curve.initial_frequency
        shortest = np.min(limit, initial=np.inf)
        allowed = f"at most t_c/w1 = {shortest:.3g}: two steps in the band"
        check("step", step, lambda h: h <= limit, allowed)

    def kernel_arguments(self, damping: Damping, curve: TrilinearCurve) -> KernelArguments:
        c = damping.width / curve.initial_frequency
        strength = band_strength(math.pi * damping.value, damping.width)
        return "band", (3 * strength / (4 * c), c, 0.0)


class CQD(BandDamper):
    """Band of fixed length, its force by the square of the velocity, docs/theory.md, section 9."""

    name = "CQD"
    title = "band of fixed length"
    rules = {"value": BAND_RATIO, "width": ABOVE_0_UP_TO_1}
    defaults = {"width": 0.25}

    def kernel_arguments(self, damping: Damping, curve: TrilinearCurve) -> KernelArguments:
        half_width = damping.width * curve.yield_displacement_ratio
        # The integral of mu over the band is 4/3 of the size, and must be delta = pi xi.
        return "cqd", (0.75 * math.pi * damping.value, half_width, 0.0)


DAMPER_CLASSES = (CR, CDC, CDR, SDR, ECD, BAND, CQD)
DAMPERS: dict[str, Damper] = {damper.name: damper() for damper in DAMPER_CLASSES}
