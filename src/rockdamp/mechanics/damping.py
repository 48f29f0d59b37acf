"""The damping models: the coefficient of restitution and the viscous dampers, one class each behind one face.

Dimensionless as in the kernels: unit mass, C over m_eff p. Eqs (8), (10), (11), (12) of the paper; ECD is beyond it.

A viscous damper states its coefficient twice: `rows` and `formula` for the kernel, and `law` for the event-driven
solver, in plain numbers. They share nothing, so that each solver checks the other.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rockdamp import kernels
from rockdamp.arrays import Array, Quantity, together
from rockdamp.errors import InputError, require, require_finite
from rockdamp.mechanics import half_cycle_loss
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.vocabulary import MODELS, TITLES

SCHEMES = ("newmark", "paper")
# What a message calls a parameter, its range, and the range in words.
RANGES: Mapping[str, tuple[str, Callable[[Array], Any], str]] = {
    "restitution": ("restitution (e)", lambda e: (e > 0) & (e <= 1), "greater than 0 and at most 1"),
    "damping_ratio": ("damping_ratio (xi)", lambda xi: xi >= 0, "at least 0"),
    "exponent": ("exponent (n)", lambda n: n >= 0, "at least 0"),
    "order": ("order (m)", lambda m: m >= 0, "at least 0"),
}
Formula = Callable[..., tuple[Any, Any]]
Law = Callable[[float, float, float, float], float]
MULTIPLIED_ORDERS = (0, 1, 2, 4, 8, 16, 32)

_KINDS: dict[str, type[Damping]] = {}


class Damping:
    """One damping model with its parameters, numbers or arrays that broadcast against the walls they are given to.

    Make one with `Damping("CDR", 0.05)`, `Damping.cr(0.85)`, `Damping.power(1.3, 0.05)` or, as the damper that loses in
    every half cycle what an impact takes, `Damping.of_restitution(0.85, order=8)`.

    Parameters
    ----------
    model : str
        One of `vocabulary.MODELS`, or ``"POWER"`` for the general exponent.
    *values, **named : float or ndarray
        Its parameters, in the order of `names` or by name: ``restitution`` e for CR, in (0, 1]; ``damping_ratio`` xi
        for the others, >= 0; after it ``exponent`` n for POWER and, by name, ``order`` m for ECD, which is 0 if not
        given; both >= 0. [-]

    Attributes
    ----------
    model, title : str
        Its short name and what it stands for.
    is_impact : bool
        Whether it takes energy at impacts, by `restitution`, rather than on the way, by `damping_ratio`.
    restitution, damping_ratio, exponent, order : ndarray
        Its parameters; a model has those of `names` alone. [-]
    names : tuple of str
        Names of its parameters.
    defaults : dict
        Values of the parameters that need not be given, by name. [-]
    secant_exponent : float, ndarray or None
        The power of the secant's frequency that C is in proportion to, if it depends on nothing else. [-]
    same_loss_at_any_amplitude : bool
        Whether every half cycle of any curve loses the same fraction of its energy.

    Raises
    ------
    InputError
        If the model is unknown, a parameter is missing or is not the model's, or a value lies outside its range.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(cracked_stiffness_ratio=0.04, plateau_ratio=0.85)
    >>> rd.Damping("CDR", 0.05).coefficient(curve, [0.02, 0.5]).round(3)  # falls with the secant stiffness
    array([0.461, 0.1  ])
    """

    model: ClassVar[str]
    names: ClassVar[tuple[str, ...]]
    defaults: ClassVar[Mapping[str, float]] = {}  # of parameters that need not be given, and are by name alone
    is_impact: ClassVar[bool] = False
    secant_exponent: Any = None  # C goes with this power of the secant's frequency and with nothing else, where set
    same_loss_at_any_amplitude: ClassVar[bool] = False  # of energy, as a fraction, in every half cycle of any curve

    restitution: Quantity
    damping_ratio: Quantity
    exponent: Quantity
    order: Quantity

    def __new__(cls, model: str = "", *values: Quantity, **named: Quantity) -> Damping:
        if cls is not Damping:
            return super().__new__(cls)
        if model not in _KINDS:
            raise InputError(f"damping_model is {model!r}; it must be one of {', '.join(MODELS)}")
        return super().__new__(_KINDS[model])

    def __init__(self, model: str, *values: Quantity, **named: Quantity) -> None:
        required = [name for name in self.names if name not in self.defaults]
        given = {**self.defaults, **dict(zip(required, values, strict=False)), **named}
        others = ["another value"] * (len(values) - len(required))
        if others or set(given) != set(self.names):
            raise InputError(
                f"{self.model} takes {', '.join(self.names)} and nothing else;"
                f" it was given {', '.join([*given, *others]) or 'no value'}"
            )
        for name, value in given.items():
            require_finite(RANGES[name][0], value)
        arrays = together(**{RANGES[name][0]: given[name] for name in self.names})
        for name, array in zip(self.names, arrays, strict=True):
            text, within, allowed = RANGES[name]
            require(within(array), text, array, allowed)
            self.__dict__[name] = array

    def __init_subclass__(cls) -> None:
        if "model" in cls.__dict__:
            _KINDS[cls.model] = cls

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{name} cannot be set: a damper keeps its parameters; `changed` makes another")

    def __repr__(self) -> str:
        return f"Damping({self.model!r}, {', '.join(f'{name}={value!r}' for name, value in self.own.items())})"

    @classmethod
    def cr(cls, restitution: Quantity) -> Damping:
        """Return CR, Eq. (8): the velocity is multiplied by e whenever u changes sign.

        Parameters
        ----------
        restitution : float or ndarray
            e, in (0, 1]. [-]
        """
        return Damping("CR", restitution)

    @classmethod
    def power(cls, exponent: Quantity, damping_ratio: Quantity) -> Damping:
        r"""Return the damper of the general exponent, which is CDC, CDR and SDR at n = 0, 1 and 2.

        .. math:: C = 2 \, m_\mathrm{eff} \, \omega_1 \, \xi \left(\frac{\omega(x)}{\omega_1}\right)^n

        Parameters
        ----------
        exponent : float or ndarray
            n, at least 0. [-]
        damping_ratio : float or ndarray
            xi, at least 0. [-]
        """
        return Damping("POWER", damping_ratio, exponent)

    @classmethod
    def of_restitution(cls, restitution: Quantity, model: str = "ECD", **named: Quantity) -> Damping:
        """Return the damper that loses in every half cycle what an impact takes: exact, and without a fit.

        Parameters
        ----------
        restitution : float or ndarray
            e, in (0, 1]. [-]
        model : str
            ``"ECD"``, the energy-consistent damper, or ``"CR"`` itself.
        **named : float or ndarray
            ``order`` m of ECD, >= 0; the larger, the nearer to restitution under any load. [-]

        Raises
        ------
        InputError
            If e lies outside its range, or another model is asked for: its damping ratio depends on curve and
            amplitude, and `rockdamp.equivalent` finds it.

        Examples
        --------
        >>> import rockdamp as rd
        >>> rd.Damping.of_restitution([0.8, 0.85], order=8).damping_ratio.round(4)
        array([0.0709, 0.0517])
        """
        kind = _KINDS.get(model)
        if kind is None or not (kind.is_impact or kind.same_loss_at_any_amplitude):
            exact = ", ".join(
                name for name, kind in _KINDS.items() if kind.is_impact or kind.same_loss_at_any_amplitude
            )
            raise InputError(f"damping_model is {model!r}; it must be one of {exact}: the others need a fit")
        e = np.asarray(Damping.cr(restitution).restitution)
        return Damping(model, e if kind.is_impact else kind.exact_damping_ratio(e, **named), **named)

    @classmethod
    def exact_damping_ratio(cls, restitution: ArrayLike, **named: Quantity) -> Array:
        """Return the damping ratio that loses in every half cycle what an impact takes, of a model that has one. [-]

        Parameters
        ----------
        restitution : float or ndarray
            e, in (0, 1]. [-]
        **named : float or ndarray
            The model's other parameters, by name. [-]
        """
        raise NotImplementedError

    @classmethod
    def of(cls, model: str, **values: Quantity) -> Damping:
        """Return a model with those of the values that are its own: of e and xi, say, the one that it has.

        Parameters
        ----------
        model : str
            As for `Damping`.
        **values : float or ndarray
            By name; those that the model does not have are left out. [-]
        """
        names = _KINDS[model].names if model in _KINDS else ()
        return Damping(model, **{name: values[name] for name in names if name in values})

    @property
    def title(self) -> str:
        """What the model's short name stands for."""
        return TITLES[self.model]

    @property
    def own(self) -> dict[str, Quantity]:
        """Its parameters by name."""
        return {name: getattr(self, name) for name in self.names}

    def changed(self, **named: Quantity) -> Damping:
        """Return the same model with other values of the parameters that are given.

        Parameters
        ----------
        **named : float or ndarray
            By name. [-]
        """
        return Damping(self.model, **(self.own | named))

    def map(self, function: Callable[[Array], Quantity]) -> Damping:
        """Return the same model with a function applied to each of its parameters.

        Parameters
        ----------
        function : callable
            Picks or repeats elements of an array.
        """
        return self.changed(**{name: function(value) for name, value in self.own.items()})

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape that the parameters broadcast to."""
        return np.broadcast_shapes(*(np.shape(value) for value in self.own.values()))

    def rows(self, curve: TrilinearCurve) -> dict[int, Array]:
        """Return what the kernel's step reads of the damper, by row: of shapes that broadcast with the curve's.

        Parameters
        ----------
        curve : TrilinearCurve
            The damper is in proportion to its first branch's frequency w1.
        """
        raise NotImplementedError

    def step(self, scheme: str) -> Callable[..., None]:
        """Return the kernel's step for this model.

        Parameters
        ----------
        scheme : {"newmark", "paper"}
            As for `rockdamp.solve`.

        Raises
        ------
        InputError
            If the scheme is unknown.
        """
        if scheme not in SCHEMES:
            raise InputError(f"scheme is {scheme!r}; it must be one of {', '.join(SCHEMES)}")
        return self._newmark() if scheme == "newmark" else self._printed()

    def _newmark(self) -> Callable[..., None]:
        raise NotImplementedError

    def _printed(self) -> Callable[..., None]:
        raise NotImplementedError

    def coefficient(self, curve: TrilinearCurve, x: ArrayLike, v: ArrayLike = 0.0) -> Array:
        """Return the coefficient C over m_eff p, which for CR is zero. [-]

        Parameters
        ----------
        curve : TrilinearCurve
            Broadcasts.
        x, v : float or ndarray
            u/u_ins and its derivative by tau, broadcast; not every damper depends on the velocity. [-]
        """
        raise NotImplementedError


class Restitution(Damping):
    """CR, Eq. (8): the velocity is multiplied by e whenever u changes sign; between impacts nothing is lost."""

    model = "CR"
    names = ("restitution",)
    is_impact = True

    def rows(self, curve: TrilinearCurve) -> dict[int, Array]:
        return {kernels.E: self.restitution}

    def _newmark(self) -> Callable[..., None]:
        return kernels.restitution_located

    def _printed(self) -> Callable[..., None]:
        return kernels.restitution_printed

    def coefficient(self, curve: TrilinearCurve, x: ArrayLike, v: ArrayLike = 0.0) -> Array:
        return np.zeros(np.broadcast_shapes(np.shape(x), np.shape(v), curve.shape, self.shape))


class Viscous(Damping):
    """A viscous damper: a coefficient C(x, v), in proportion to xi."""

    names: ClassVar[tuple[str, ...]] = ("damping_ratio",)
    formula: Any  # of the kernel; it reads the rows
    printed_formula: Any = None  # that of the scheme as printed, if another
    constant_branches: Any = 0  # of the curve, counted from x = 0, on which C = 2 w1 xi, as if it were linear

    def _newmark(self) -> Callable[..., None]:
        return kernels.viscous_newmark(self.formula)

    def _printed(self) -> Callable[..., None]:
        return kernels.viscous_printed(self.printed_formula or self.formula)

    def coefficient(self, curve: TrilinearCurve, x: ArrayLike, v: ArrayLike = 0.0) -> Array:
        lane = dict(zip(kernels.CURVE, curve.parameters(), strict=True)) | self.rows(curve)
        shape = np.broadcast_shapes(np.shape(x), np.shape(v), curve.shape, self.shape)
        return np.broadcast_to(self.formula(lane, 0, np.abs(x), np.asarray(v))[1], shape).copy()

    def law(self, k1: float) -> Law:
        """Return C as a function of |x|, |f|, 2V and v on a curve whose first branch has the stiffness `k1`, for a
        damper of plain numbers."""
        raise NotImplementedError


class OfTheSecant(Viscous):
    """C = 2 xi w1 (w/w1)^n, w^2 = f/x the secant's."""

    constant_branches = 1

    def law(self, k1: float) -> Law:
        scale, half_exponent = 2 * float(self.damping_ratio) * math.sqrt(k1), float(self.secant_exponent) / 2
        return lambda z, f, double_v, v: scale * (f / z / k1) ** half_exponent


class ConstantCoefficient(OfTheSecant):
    """CDC, Eq. (10)."""

    model = "CDC"
    secant_exponent = 0.0
    formula = staticmethod(kernels.constant_at)
    printed_formula = staticmethod(kernels.viscous_at)
    constant_branches = 3

    def rows(self, curve: TrilinearCurve) -> dict[int, Array]:
        return {kernels.C0: 2 * curve.initial_frequency * self.damping_ratio}


class ConstantRatio(OfTheSecant):
    """CDR, Eq. (11)."""

    model = "CDR"
    secant_exponent = 1.0
    formula = staticmethod(kernels.root_at)
    printed_formula = staticmethod(kernels.viscous_at)

    def rows(self, curve: TrilinearCurve) -> dict[int, Array]:
        return {kernels.C1: 2 * self.damping_ratio}


class StiffnessProportionalRatio(OfTheSecant):
    """SDR, Eq. (12): xi(w) = xi w/w1."""

    model = "SDR"
    secant_exponent = 2.0
    formula = staticmethod(kernels.linear_at)
    printed_formula = staticmethod(kernels.viscous_at)

    def rows(self, curve: TrilinearCurve) -> dict[int, Array]:
        return {kernels.C2: 2 * self.damping_ratio / curve.initial_frequency}


class GeneralExponent(OfTheSecant):
    """C = 2 xi w1 (w/w1)^n of any n: none of the models that are compared, but what lies between them."""

    model = "POWER"
    title = "general exponent"
    names = ("damping_ratio", "exponent")
    formula = staticmethod(kernels.power_at)

    @property
    def secant_exponent(self) -> Quantity:
        return self.exponent

    def rows(self, curve: TrilinearCurve) -> dict[int, Array]:
        n = self.exponent
        return {kernels.C0: 2 * self.damping_ratio * curve.initial_frequency ** (1 - n), kernels.HALF_N: n / 2}


class EnergyConsistent(Viscous):
    """ECD of order m: C = 2 xi N_m w_E (T/(T + V))^m, w_E = |f|/sqrt(2V); m = 0, which is meant by ECD alone, has no T.

    It loses the same fraction of the energy in every half cycle, from any amplitude, on any odd curve; as m grows it
    tends to restitution (docs/theory.md, section 8).
    """

    model = "ECD"
    names = ("damping_ratio", "order")
    defaults = {"order": 0.0}
    same_loss_at_any_amplitude = True

    @property
    def formula(self) -> Formula:
        m = self._multiplied
        if m is None:
            return kernels.energy_of_any_order_at
        return kernels.energy_of_order_at(m) if m else kernels.energy_at

    @property
    def printed_formula(self) -> Formula:
        return self.formula if self._multiplied != 0 else kernels.viscous_at

    @property
    def _multiplied(self) -> int | None:
        """m where it is one for all and its power takes multiplications alone: the kernel has a formula for each."""
        orders = np.unique(self.order)
        return int(orders[0]) if orders.size == 1 and orders[0] in MULTIPLIED_ORDERS else None

    @property
    def constant_branches(self) -> int:
        return 1 if np.all(self.order == 0) else 0

    @classmethod
    def exact_damping_ratio(cls, restitution: ArrayLike, **named: Quantity) -> Array:
        return half_cycle_loss.damping_ratio(0.0 - np.log(restitution), named.get("order", 0.0))

    def rows(self, curve: TrilinearCurve) -> dict[int, Array]:
        scale = 2 * self.damping_ratio * half_cycle_loss.normalisation(self.order)
        return {kernels.C1: scale, kernels.BY_ENERGY: np.ones(()), kernels.ORDER: self.order}

    def law(self, k1: float) -> Law:
        w1, m = math.sqrt(k1), float(self.order)
        # N_m by Gamma functions of its own, and cos^2 of the phase's angle: the kernel has the energies' ratio.
        size = math.exp(math.lgamma(m + 2) - math.lgamma(m + 1.5)) * math.sqrt(math.pi) / 2 if m else 1.0
        scale = 2 * float(self.damping_ratio) * w1 * size

        def of_state(z: float, f: float, double_v: float, v: float) -> float:
            root = math.sqrt(double_v)
            kinetic = math.cos(math.atan2(root, abs(v))) ** (2 * m) if m else 1.0
            return scale * (f / root / w1) * kinetic

        return of_state
