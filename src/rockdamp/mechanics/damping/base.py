"""The base of every damping model, and the table that makes one by its name.

A damper is one file of this folder with a subclass of `Damping`, and one line of `vocabulary.DAMPERS` names it. All is
dimensionless: z = |x| = |u|/u_ins, f = |F|/(K0 u_ins), v = dx/dtau, and C is over m_eff p. A damper must have

1. `model`, `title` and `colour`: its short name, what it stands for, and its colour in figures as ``"#rrggbb"``;
2. `names`, and `defaults` of those that need not be given: its parameters, each with a range in `RANGES`;
3. `formula(z, f, double_v, v, parameters)`: the coefficient C for the batched solver, which compiles it; of an impact,
   the factor on the velocity v at x = 0, e;
4. `formula_parameters(curve)`: up to three values, of shapes that broadcast with the curve's, that `formula` reads;
5. `law(z, f, double_v, v, parameters)`: C once more, for the event-driven solver, which compiles it too. Write it from
   the paper and not from the formula, with `math` alone, as each of the two solvers is checked by the other;
6. `law_parameters(curve)`: the plain numbers that `law` reads.

`formula` is called with numbers and with arrays; it uses arithmetic and NumPy's functions of one number. `v` is
positive where the wall moves away from x = 0, and `double_v` is twice the stored energy; what a formula does not use
costs it nothing, as the compiler drops it. A damper can have

7. `linear_branches`: on how many branches of the curve, counted from x = 0, C is 2 w1 xi; there the event-driven
   solver has a closed form;
8. `secant_exponent`: n, if C goes with w^n of the secant's frequency and with nothing else;
9. `amplitude_independent` and `exact_damping_ratio`: if every half cycle loses the same fraction of its energy,
   xi follows from e alone, exactly. The other closed forms take `formula` and need nothing;
10. `step_kind`, by which the solvers choose the step: ``viscous``, a force C v, if none is said; or ``impact``, a
    factor on the velocity at x = 0;
11. `takes_step`, if `formula` reads the step of the march, as the last of its parameters;
12. `largest_damping_ratio`, if there is one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, cached_property
from importlib import import_module
from math import inf
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rockdamp import plausibility
from rockdamp.arguments import broadcast, finite, instance, numbers, one_of, together
from rockdamp.arrays import Array, ByValue, Quantity
from rockdamp.errors import InputError, holds, require
from rockdamp.mechanics import trilinear
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.vocabulary import DAMPERS, MODELS, parameter_of_word

LARGEST_ORDER = 10_000  # of ECD; steps of the solver would pass over its band about u = 0
VISCOUS, IMPACT = "viscous", "impact"  # kinds of steps

# A parameter's name in messages, its range, and the range in words.
RANGES: Mapping[str, tuple[str, Callable[[Array], Any], str]] = {
    "restitution": ("restitution (e)", lambda e: (e > 0) & (e <= 1), "greater than 0 and at most 1"),
    "damping_ratio": ("damping_ratio (xi)", lambda xi: xi >= 0, "at least 0"),
    "exponent": ("exponent", lambda exponent: exponent >= 0, "at least 0"),
    "order": ("order (m)", lambda m: (m >= 0) & (m <= LARGEST_ORDER), f"at least 0 and at most {LARGEST_ORDER:g}"),
    "width": ("width (t_c, rad)", lambda width: width > 0, "greater than 0"),
    "at": ("at (u/u_ins)", lambda at: at > 0, "greater than 0"),
}


# ASSUME: the amplitude that e belongs to where the loss depends on the amplitude and no other is said [u/u_ins].
REFERENCE_AMPLITUDE = 0.3


@cache
def damper_classes() -> dict[str, type[Damping]]:
    """Return the class of each damper that `vocabulary.DAMPERS` names."""
    classes = {}
    for model, place in DAMPERS.items():
        file, name = place.split(":")
        classes[model] = getattr(import_module(f"rockdamp.mechanics.damping.{file}"), name)
    return classes


class _Named(type):
    """Class whose missing attributes, where they are names of models, say how the model is made."""

    def __getattr__(cls, name: str) -> Any:
        model = name.upper()
        if model not in DAMPERS:
            raise AttributeError(f"type object {cls.__name__!r} has no attribute {name!r}")
        made = f"Damping({model!r}, {', '.join(damper_classes()[model].names)})"
        if model in Damping.exact_models():
            made = f"Damping.of_restitution(e, {model!r}) or {made}"
        raise AttributeError(f"Damping has no {name!r}; {made} makes one")


class Damping(ByValue, metaclass=_Named):
    """One damping model with its parameters, numbers or arrays that broadcast against the walls they are given to.

    Make one with `Damping("CDR", 0.05)`, `Damping.cr(0.85)` or, as the damper that loses in every half cycle what an
    impact takes, `Damping.of_restitution(0.85, order=8)`.

    Parameters
    ----------
    model : str
        One of `vocabulary.MODELS`, or ``"CQD"``.
    *values, **named : float or ndarray
        Its parameters, in the order of `names` or by name: ``restitution`` e for CR, in [0, 1]; ``damping_ratio`` xi
        for the others, >= 0; after it, by name, ``order`` m for ECD, >= 0 and 0 if not given; ``width``, > 0, t_c of
        BAND, 0.2 if not given [rad], and over a1 of CQD, 0.25 if not given and at most 1. CR and ECD take, by name,
        ``exponent`` g of a loss that falls with the amplitude, 0 if not given, and ``at``: see `cr`. [-]

    Attributes
    ----------
    model, title : str
        Its short name and what it stands for.
    step_kind : str
        How it takes energy: ``viscous``, by a force C v; ``impact``, by `restitution`.
    restitution, damping_ratio, exponent, order, width, at : ndarray
        Its parameters; a model has those of `names` alone. [-]
    names : tuple of str
        Names of its parameters.
    defaults : dict
        Values of the parameters that need not be given, by name. [-]
    secant_exponent : float or None
        The power of the secant's frequency that C is in proportion to, if it depends on nothing else. [-]
    amplitude_independent : bool
        Whether every half cycle of any curve loses the same fraction of its energy.
    fades : bool
        Whether its loss can fall with the amplitude, by ``exponent`` and ``at``.
    ranges : dict
        Of each parameter its name in errors, what holds of a value that is allowed, and that in words.

    Raises
    ------
    InputError
        If the model is unknown, a parameter is missing or is not the model's, or a value lies outside its range.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> rd.Damping("CDR", 0.05).coefficient(curve, [0.02, 0.5]).round(3)  # falls with the secant stiffness
    array([0.461, 0.1  ])
    """

    model: ClassVar[str]
    title: ClassVar[str]
    colour: ClassVar[str]
    names: ClassVar[tuple[str, ...]] = ("damping_ratio",)
    defaults: ClassVar[Mapping[str, float]] = {}  # of parameters that need not be given, and are by name alone
    fades: ClassVar[bool] = False  # whether its loss can depend on the amplitude, by an exponent and `at`
    formula: Any
    law: Any
    step_kind: ClassVar[str] = VISCOUS
    linear_branches: Any = 0
    secant_exponent: ClassVar[float | None] = None
    amplitude_independent: ClassVar[bool] = False
    takes_step: ClassVar[bool] = False
    largest_damping_ratio: ClassVar[float] = inf
    ranges: ClassVar[Mapping[str, tuple[str, Callable[[Array], Any], str]]] = RANGES

    restitution: Quantity
    damping_ratio: Quantity
    exponent: Quantity
    order: Quantity
    width: Quantity
    at: Quantity

    def __new__(cls, model: str = "", *values: Quantity, **named: Quantity) -> Damping:
        if cls is not Damping:
            return super().__new__(cls)
        return super().__new__(damper_classes()[_known(model)])

    def __init__(self, model: str, *values: Quantity, **named: Quantity) -> None:
        if self.fades:
            loss = {"exponent": 0.0, "at": REFERENCE_AMPLITUDE} | {
                k: named.pop(k) for k in ("exponent", "at") if k in named
            }
            if np.any(finite("exponent", loss["exponent"]) != 0):
                self.__dict__["names"] = (*self.names, *loss)
                named |= loss
            else:
                self.__dict__.update({name: self._within(name, numbers(name, value)) for name, value in loss.items()})
        required = [name for name in self.names if name not in self.defaults]
        given = {**self.defaults, **dict(zip(required, values, strict=False)), **named}
        others = ["another value"] * (len(values) - len(required))
        if others or given.keys() != {*self.names}:
            raise InputError(
                f"{self.model} takes {', '.join(self.names)} and nothing else;"
                f" it was given {', '.join([*given, *others]) or 'no value'}"
                + (f"; Damping.of_restitution(e, {self.model!r}) makes it of e" if self.amplitude_independent else "")
            )
        arrays = together(**{RANGES[name][0]: given[name] for name in self.names})
        for name, array in zip(self.names, arrays, strict=True):
            self.__dict__[name] = self._within(name, array)

    def _within(self, name: str, array: Any) -> Any:
        """Return a parameter that lies in its range."""
        text, within, allowed = self.ranges[name]
        if not holds(within(array.item() if array.size == 1 else array)):  # NumPy is slow at one number
            require(within(array), text, array, f"{allowed}{plausibility.per_cent(array, within)}")
        return array

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{name} cannot be set: a damper keeps its parameters; `replace` makes another")

    def _parts(self) -> tuple[Any, ...]:
        return tuple(self.parameters.values())

    def __repr__(self) -> str:
        return f"Damping({self.model!r}, {', '.join(f'{name}={value!r}' for name, value in self.parameters.items())})"

    @classmethod
    def cr(cls, restitution: Quantity, *, exponent: Quantity = 0.0, at: Quantity = REFERENCE_AMPLITUDE) -> Damping:
        r"""Return CR, Eq. (8): the velocity is multiplied by e whenever u changes sign.

        With an exponent g > 0 the loss falls with the amplitude (docs/theory.md, section 8): an impact that the wall
        reaches with the energy :math:`E_-` leaves :math:`E_+^g = E_-^g - E_r^g (1 - e^{2g})`, or stops it.

        Parameters
        ----------
        restitution : float or ndarray
            e, in [0, 1]; at 0 the wall stops, until the load pushes it on. With an exponent, that of the amplitude
            `at`, greater than 0; without one, that of releases from 0.3 to 0.5 u_ins (docs/earthquakes.md). [-]
        exponent : float or ndarray
            g, at least 0. [-]
        at : float or ndarray
            Amplitude u/u_ins that e belongs to, E_r = V(at); greater than 0 and less than the a3 of the curve. [-]
        """
        made = Damping("CR", restitution, exponent=exponent, at=at)
        without = plausibility.called_from_outside() and not made.loss_depends_on_amplitude
        if without and np.any(made.at != REFERENCE_AMPLITUDE):
            plausibility.warn([f"at is {at} of u_ins and has no effect: the exponent is 0"])
        return made

    @classmethod
    def of_restitution(cls, restitution: Quantity, model: str = "ECD", **named: Quantity) -> Damping:
        """Return the damper that loses in every half cycle what an impact takes: exact, and without a fit.

        Parameters
        ----------
        restitution : float or ndarray
            e, in (0, 1]. [-]
        model : str
            ``"ECD"``, the energy-consistent damper, ``"BAND"``, or ``"CR"`` itself; ``"CQD"``, which loses less at
            small amplitudes, by the same formula.
        **named : float or ndarray
            ``order`` m of ECD, >= 0; the larger, the nearer to restitution under any load. ``exponent`` g, less than
            0.5 for a damper, and ``at`` as for `cr`. ``width`` of BAND and CQD. [-]

        Raises
        ------
        InputError
            If e lies outside its range, or another model is asked for: its damping ratio depends on curve and
            amplitude, and `rockdamp.equivalent` finds it.

        Examples
        --------
        >>> import rockdamp as rd
        >>> rd.Damping.of_restitution([0.8, 0.85], order=8).damping_ratio.round(4)
        array([0.071 , 0.0517])
        """
        _refuse_word(model)
        model = one_of("damping_model", model, (*Damping.exact_models(), "CQD"), ": the others need a fit")
        kind = damper_classes()[model]
        e = numbers("restitution (e)", restitution)
        if kind.step_kind == IMPACT:
            return Damping(model, e, **named)
        text, within, allowed = RANGES["restitution"]
        require(within(e), text, e, f"{allowed}: no damper stops the wall{plausibility.per_cent(e, within)}")
        plausibility.warn(plausibility.of_restitution(e))
        return Damping(model, kind.exact_damping_ratio(e, **named), **named)

    @staticmethod
    def exact_models() -> tuple[str, ...]:
        """Return the models that a coefficient of restitution describes exactly and without a fit, CR first."""
        of = damper_classes()
        return tuple(name for name in MODELS if of[name].step_kind == IMPACT or of[name].amplitude_independent)

    @classmethod
    def exact_damping_ratio(cls, restitution: ArrayLike, **named: Quantity) -> Array:
        """Return xi of the damper that loses in every half cycle as much as an impact. [-]

        Parameters
        ----------
        restitution : float or ndarray
            e, in (0, 1]. [-]
        **named : float or ndarray
            The model's other parameters, by name. [-]
        """
        raise NotImplementedError

    @classmethod
    def from_values(cls, model: str, **values: Quantity) -> Damping:
        """Return a model with those of the values that are its own: of e and xi, say, the one that it has.

        Parameters
        ----------
        model : str
            As for `Damping`.
        **values : float or ndarray
            By name; those that the model does not have are left out. [-]
        """
        names = damper_classes()[_known(model)].names
        return Damping(model, **{name: values[name] for name in names if name in values})

    @property
    def parameters(self) -> dict[str, Quantity]:
        """Its parameters by name."""
        return {name: getattr(self, name) for name in self.names}

    def replace(self, **named: Quantity) -> Damping:
        """Return the same model with other values of the parameters that are given.

        Parameters
        ----------
        **named : float or ndarray
            By name. [-]
        """
        return Damping(self.model, **(self.parameters | named))

    def map(self, function: Callable[[Array], Quantity]) -> Damping:
        """Return the same model with a function applied to each of its parameters.

        Parameters
        ----------
        function : callable
            Picks or repeats elements of an array.
        """
        return self.replace(**{name: function(value) for name, value in self.parameters.items()})

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Shape that the parameters broadcast to."""
        return broadcast(**self.parameters) if len(self.names) > 1 else getattr(self, self.names[0]).shape

    def formula_parameters(self, curve: TrilinearCurve) -> tuple[Quantity, ...]:
        """Return what `formula` reads besides the state, at most three values that broadcast with the curve's.

        Parameters
        ----------
        curve : TrilinearCurve
            C is in proportion to its first branch's frequency w1.
        """
        raise NotImplementedError(
            f"{type(self).__name__} has no `formula_parameters`; {__name__} lists what it must have"
        )

    def law_parameters(self, curve: TrilinearCurve) -> tuple[float, ...]:
        """Return what `law` reads besides the state, of a damper of plain numbers.

        Parameters
        ----------
        curve : TrilinearCurve
            Of one wall.
        """
        raise NotImplementedError(f"{type(self).__name__} has no `law_parameters`; {__name__} lists what it must have")

    def check_step(self, curve: TrilinearCurve, step: Quantity) -> None:
        """Raise `InputError` for a step that passes over the damper.

        Parameters
        ----------
        curve : TrilinearCurve
            Broadcasts.
        step : float or ndarray
            In tau, broadcasts. [-]
        """

    @property
    def loss_depends_on_amplitude(self) -> bool:
        """Whether an exponent g > 0 is given."""
        return self.fades and "exponent" in self.names

    def reference_energy(self, curve: TrilinearCurve) -> Array:
        """Return twice the energy V(at), to which e or xi belongs. [-]

        Parameters
        ----------
        curve : TrilinearCurve
            Broadcasts with `at`.

        Raises
        ------
        InputError
            If `at` is not less than a3.
        """
        require(
            self.at < curve.ultimate_displacement_ratio, "at (u/u_ins)", self.at, "less than a3, the end of the curve"
        )
        return 2 * curve.energy(self.at)

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
        return np.broadcast_to(self.unchecked_coefficient(curve, at, speed), shape).copy()

    def unchecked_coefficient(self, curve: TrilinearCurve, x: Array, v: Array) -> Quantity:
        """Return the coefficient of arrays that were checked, in a shape that broadcasts to theirs. [-]"""
        if self.step_kind == IMPACT:
            return 0.0
        z = np.maximum(np.abs(x), trilinear.TINY)
        k1, b1, ks, a1, a2, a3 = curve.parameters()
        f, double_v = trilinear.force(z, k1, b1, ks, a3), trilinear.double_energy(z, k1, b1, ks, a1, a2, a3)
        return self.formula(z, f, double_v, np.where(x < 0, -v, v), self.formula_parameters(curve))


def _known(model: str) -> str:
    """Return the name of a model that there is."""
    _refuse_word(model)
    named = model if isinstance(model, str) and model.upper() in DAMPERS else None
    return named.upper() if named is not None else one_of("damping_model", model, MODELS)


def _refuse_word(model: Any) -> None:
    """Refuse a word of the command line, which has a parameter in it."""
    name, parameter = parameter_of_word(model) if isinstance(model, str) else ("", {})
    for of, value in parameter.items():
        raise InputError(f"damping_model is {model!r}; it must be {name}, {of}={value:g}")
