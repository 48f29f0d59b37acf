"""What every damping model can be asked, and how one is made by its name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arguments import broadcast, instance, numbers, one_of, together
from rockdamp.arrays import Array, ByValue, Quantity
from rockdamp.errors import InputError, require
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

_KINDS: dict[str, type[Damping]] = {}


class Damping(ByValue):
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
        return super().__new__(_KINDS[_known(model)])

    def __init__(self, model: str, *values: Quantity, **named: Quantity) -> None:
        required = [name for name in self.names if name not in self.defaults]
        given = {**self.defaults, **dict(zip(required, values, strict=False)), **named}
        others = ["another value"] * (len(values) - len(required))
        if others or set(given) != set(self.names):
            raise InputError(
                f"{self.model} takes {', '.join(self.names)} and nothing else;"
                f" it was given {', '.join([*given, *others]) or 'no value'}"
            )
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

    def _parts(self) -> tuple[Any, ...]:
        return tuple(self.own.values())

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
        exact = Damping.exact_models()
        model = one_of("damping_model", model, exact, ": the others need a fit")
        kind = _KINDS[model]
        e = np.asarray(Damping.cr(restitution).restitution)
        return Damping(model, e if kind.is_impact else kind.exact_damping_ratio(e, **named), **named)

    @staticmethod
    def exact_models() -> tuple[str, ...]:
        """Return the models that a coefficient of restitution describes exactly and without a fit, CR first."""
        return tuple(name for name in MODELS if _KINDS[name].is_impact or _KINDS[name].same_loss_at_any_amplitude)

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
        names = _KINDS[_known(model)].names
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

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Shape that the parameters broadcast to."""
        return broadcast(**self.own)

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
        return self._newmark() if one_of("scheme", scheme, SCHEMES) == "newmark" else self._printed()

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
        instance("curve", curve, TrilinearCurve)
        at, speed = numbers("x", x), numbers("v", v)
        shape = broadcast(x=at, v=speed, curve=curve, damping=self)
        return np.broadcast_to(self.by_rows(curve.rows() | self.rows(curve), at, speed), shape).copy()

    def by_rows(self, rows: Mapping[int, Array], x: Array, v: Array) -> Quantity:
        """Return the coefficient as `coefficient` does, by rows of curve and damper and by numbers that were checked.

        Parameters
        ----------
        rows : mapping
            `TrilinearCurve.rows` and `rows`.
        x, v : ndarray
            u/u_ins and its derivative by tau. [-]

        Returns
        -------
        float or ndarray
            Of a shape that broadcasts to theirs.
        """
        raise NotImplementedError


def _known(model: str) -> str:
    """Return the name of a model that there is; the general exponent is one, and none of those that are compared."""
    named = model if isinstance(model, str) and model.upper() in _KINDS else None
    return named.upper() if named is not None else one_of("damping_model", model, MODELS)
