"""The tri-linear force-displacement curve of a cracked wall and its undamped free motion, in dimensionless form."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arguments import broadcast, numbers, one_of, read_only, real, together
from rockdamp.arrays import Array, ByValue, Quantity
from rockdamp.errors import require
from rockdamp.mechanics import trilinear
from rockdamp.plausibility import as_meant, of_curve, per_cent, warn
from rockdamp.vocabulary import PRESETS, SOFTENING

# A branch shorter than this has no length but that of rounding: 1 - 0.85 is above 0.15 in floating point.
ROUNDING = 1e-12
# What messages call the three ratios.
TEXTS = {
    "yield_displacement_ratio": "yield_displacement_ratio (a1)",
    "strength_ratio": "strength_ratio (b1)",
    "ultimate_displacement_ratio": "ultimate_displacement_ratio (a3)",
}


def _slip(ratio: Quantity) -> str:
    """Ask whether a ratio that is none was stated in per cent, of which a1 has few."""
    return per_cent(ratio, lambda each: (each > 0) & (each <= 1), least=1.0)


@dataclass(frozen=True, eq=False)
class TrilinearCurve(ByValue):
    r"""Odd tri-linear law f(x), with f = F/(K0 u_ins) and x = u/u_ins (Section 3, Fig. 2).

    .. math::
        f(x) = \begin{cases}
            b_1 \, x/a_1 & 0 \le x \le a_1 \\
            b_1 & a_1 \le x \le a_2 \\
            b_1 \, (a_3 - x)/(a_3 - a_2) & a_2 \le x \le a_3 \\
            0 & x \ge a_3
        \end{cases}

    Parameters may be arrays that
    broadcast against each other; every method broadcasts against them too.

    Parameters
    ----------
    yield_displacement_ratio : float or ndarray
        a1 = u1/u_ins, in (0, a2). [-]
    strength_ratio : float or ndarray
        b1 = F_y/F0, in (0, 1). [-]
    ultimate_displacement_ratio : float or ndarray
        a3 = u3/u_ins, in (0, 1]. [-]
    softening : {"steeper", "translated"}
        For a3 < 1: the plateau ends on the bi-linear law and the last branch is steeper (a2 = 1 - b1), or the last
        branch keeps the slope -K0 and is moved towards the origin (a2 = a3 - b1).

    Raises
    ------
    InputError
        If a parameter lies outside its range, or a3 leaves no room for its softening variant.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> curve.force([0.02, 0.1, 0.5, 1.0]).round(3)
    array([0.425, 0.85 , 0.5  , 0.   ])
    >>> rd.TrilinearCurve.preset("severe").strength_ratio.item()
    0.5
    """

    yield_displacement_ratio: Quantity
    strength_ratio: Quantity
    ultimate_displacement_ratio: Quantity = 1.0
    softening: str = "steeper"

    def __post_init__(self) -> None:
        a1, b1, a3 = together(**{text: getattr(self, name) for name, text in TEXTS.items()})
        softening = one_of("softening", self.softening, SOFTENING)
        of_a1, of_b1, of_a3 = TEXTS.values()
        require(a1 > 0, of_a1, a1, "greater than 0")
        require((b1 > ROUNDING) & (b1 < 1), of_b1, b1, f"between 0 and 1, both excluded{_slip(b1)}")
        require((a3 > 0) & (a3 <= 1), of_a3, a3, f"greater than 0 and at most 1{_slip(a3)}")
        least, text = (1 - b1, "1 - b1") if softening == "steeper" else (a1 + b1, "a1 + b1")
        require(a3 > least + ROUNDING, of_a3, a3, f"greater than {text} with {softening} softening")
        for name, value in zip((*TEXTS, "softening"), (a1, b1, a3, softening), strict=True):
            object.__setattr__(self, name, value)
        allowed = f"less than a2, where the plateau ends (1 - b1){_slip(a1)}"
        require(a1 < self.plateau_end - ROUNDING, of_a1, a1, allowed)
        warn(of_curve(a1, self.strength_ratio))

    @classmethod
    def preset(cls, name: str, **kwargs: Quantity) -> TrilinearCurve:
        """Return the curve of one of Doherty's stages of degradation, quoted in section 3 of the paper.

        Parameters
        ----------
        name : {"new", "moderate", "severe"}
        **kwargs : float, ndarray or str
            What else the curve takes: ``ultimate_displacement_ratio``, ``softening``.

        Raises
        ------
        InputError
            If there is no such stage.
        """
        b1, a1 = PRESETS[one_of("preset", name, PRESETS)]
        return cls(a1, b1, **kwargs)

    # What follows from the parameters, which stay as they are, is computed once.

    @cached_property
    def plateau_end(self) -> Array:
        """a2 = u2/u_ins, where the plateau ends. [-]"""
        start = 1.0 if self.softening == "steeper" else self.ultimate_displacement_ratio
        return read_only(np.asarray(start - self.strength_ratio))

    @cached_property
    def initial_stiffness(self) -> Array:
        """k1 = b1/a1, the first branch's stiffness over K0. [-]"""
        return read_only(np.asarray(self.strength_ratio / self.yield_displacement_ratio))

    @cached_property
    def softening_stiffness(self) -> Array:
        """ks = b1/(a3 - a2) > 0, the last branch's stiffness over -K0. [-]"""
        return read_only(np.asarray(self.strength_ratio / (self.ultimate_displacement_ratio - self.plateau_end)))

    @cached_property
    def initial_frequency(self) -> Array:
        """w1 = sqrt(k1), the first branch's angular frequency over p. [-]"""
        return read_only(np.asarray(np.sqrt(self.initial_stiffness)))

    def map(self, function: Callable[[Array], Array]) -> TrilinearCurve:
        """Return the curve with a function applied to each of its parameters.

        Parameters
        ----------
        function : callable
            Picks or repeats elements of an array.
        """
        a1, b1, a3 = map(function, np.broadcast_arrays(*(getattr(self, name) for name in TEXTS)))
        with as_meant():  # it was asked about when it was made
            return TrilinearCurve(a1, b1, a3, self.softening)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Shape that the parameters broadcast to."""
        return broadcast(a1=self.yield_displacement_ratio, b1=self.strength_ratio, a3=self.ultimate_displacement_ratio)

    @cached_property
    def _parameters(self) -> tuple[Array, ...]:
        return (
            self.initial_stiffness,
            np.asarray(self.strength_ratio),
            self.softening_stiffness,
            np.asarray(self.yield_displacement_ratio),
            self.plateau_end,
            np.asarray(self.ultimate_displacement_ratio),
        )

    def parameters(self) -> tuple[Array, ...]:
        """Return k1, b1, ks, a1, a2, a3, in the order that the compiled functions take them."""
        return self._parameters

    def force(self, x: ArrayLike) -> Array:
        """Return f(x), the force over K0 u_ins. [-]

        Parameters
        ----------
        x : float or ndarray
            u/u_ins, broadcasts. [-]
        """
        at = numbers("x", x)
        k1, b1, ks, _, _, a3 = self.parameters()
        return np.sign(at) * trilinear.force(np.abs(at), k1, b1, ks, a3)

    def tangent(self, x: ArrayLike) -> Array:
        """Return df/dx; at a corner that of the branch further out. [-]

        Parameters
        ----------
        x : float or ndarray
            u/u_ins, broadcasts. [-]
        """
        k1, _, ks, a1, a2, a3 = self.parameters()
        return trilinear.tangent(np.abs(numbers("x", x)), k1, ks, a1, a2, a3)

    def secant(self, x: ArrayLike) -> Array:
        """Return f(x)/x, the square of the frequency w(x) of Eq. (9); k1 at x = 0. [-]

        Parameters
        ----------
        x : float or ndarray
            u/u_ins, broadcasts. [-]
        """
        k1, b1, ks, _, _, a3 = self.parameters()
        z = np.maximum(np.abs(numbers("x", x)), trilinear.TINY)
        return trilinear.force(z, k1, b1, ks, a3) / z

    def energy(self, x: ArrayLike) -> Array:
        r"""Return the energy that the wall stores at `x`, constant beyond a3. [-]

        .. math:: V(x) = \int_0^x f(s) \, \mathrm{d}s

        Parameters
        ----------
        x : float or ndarray
            u/u_ins, broadcasts. [-]
        """
        return 0.5 * trilinear.double_energy(np.abs(numbers("x", x)), *self.parameters())

    def amplitude(self, energy: ArrayLike) -> Array:
        """Return the x >= 0 at which the stored energy is `energy`: the inverse of `energy` on [0, a3]. [-]

        Parameters
        ----------
        energy : float or ndarray
            V, broadcasts. [-]

        Raises
        ------
        InputError
            If an energy is negative or more than the curve can store.
        """
        energy = real("energy", energy)
        k1, b1, ks, a1, a2, a3 = self.parameters()
        at_a1, at_a2, largest = self.energy(a1), self.energy(a2), self.energy(a3)
        allowed = "between 0 and V(a3), what the curve can store"
        require((energy >= 0) & (energy <= largest), "energy", energy, allowed)
        rising = np.sqrt(2 * np.maximum(energy, 0) / k1)
        plateau = a1 + (energy - at_a1) / b1
        falling = a3 - np.sqrt(np.maximum(2 * (largest - energy) / ks, 0))
        return np.where(energy <= at_a1, rising, np.where(energy <= at_a2, plateau, falling))

    def period(self, x0: ArrayLike) -> Array:
        r"""Return the period of the undamped free vibration of amplitude `x0`, by closed form on each branch. [-]

        .. math:: T(x_0) = 4 \int_0^{x_0} \frac{\mathrm{d}x}{\sqrt{2 \, (V(x_0) - V(x))}}

        Parameters
        ----------
        x0 : float or ndarray
            u0/u_ins, in (0, a3), broadcasts. [-]

        Returns
        -------
        ndarray
            In tau = p t. [-]

        Raises
        ------
        InputError
            If an amplitude lies outside (0, a3).
        """
        x0 = real("release_amplitude", x0)
        k1, b1, ks, a1, a2, a3 = self.parameters()
        require((x0 > 0) & (x0 < a3), "release_amplitude", x0, "greater than 0 and less than a3")
        v0 = self.energy(x0)

        def speed(x: Array) -> Array:
            return np.sqrt(np.maximum(2 * (v0 - self.energy(x)), 0))

        # Each branch covers [its start, min(its end, x0)]; empty branches give zero time.
        on1, on2 = np.minimum(x0, a1), np.clip(x0, a1, a2)
        first = np.arctan2(np.sqrt(k1) * on1, speed(on1)) / np.sqrt(k1)
        plateau = (speed(on1) - speed(on2)) / b1
        # Softening: with y = a3 - x growing from rest at y0 = a3 - x0, y = y0 cosh(sqrt(ks) t).
        reach = np.where(x0 > a2, (a3 - a2) / np.where(x0 > a2, a3 - x0, 1.0), 1.0)
        softening = np.where(x0 > a2, np.arccosh(np.maximum(reach, 1.0)) / np.sqrt(ks), 0.0)
        return 4 * (first + np.where(x0 > a1, plateau, 0.0) + softening)


def displacement_from_peak(curve: TrilinearCurve, amplitude: ArrayLike, tau: ArrayLike) -> Array:
    r"""Return the displacement at a time before or after the peak of undamped free motion, u/u_ins. [-]

    From rest at its amplitude the wall falls along a hyperbolic cosine on the softening branch, a parabola on the
    plateau, and a cosine on the first branch. A half cycle is this fall and its mirror image in time.

    It solves :math:`x'' + f(x) = 0` from rest at the amplitude. The zero of the displacement lies a quarter of
    `TrilinearCurve.period` from the peak; beyond it the first branch goes on to the other side.

    The arguments broadcast: the amplitude x0 = u0/u_ins in (0, a3) [-], and the time from the peak, of either sign. [-]
    """
    x0, s = real("amplitude", amplitude), np.abs(real("tau", tau))
    k1, b1, ks, a1, a2, a3 = curve.parameters()
    v0 = curve.energy(x0)
    # Where each branch begins on the way down, and with which speed; a branch above the peak begins there, at rest.
    on2, on1 = np.minimum(x0, a2), np.minimum(x0, a1)
    speed2, speed1 = (np.sqrt(np.maximum(2 * (v0 - curve.energy(x)), 0.0)) for x in (on2, on1))
    reach = np.where(x0 > a2, (a3 - a2) / np.where(x0 > a2, a3 - x0, 1.0), 1.0)
    end3 = np.arccosh(np.maximum(reach, 1.0)) / np.sqrt(ks)
    end2 = end3 + (speed1 - speed2) / b1
    softening = a3 - (a3 - x0) * np.cosh(np.sqrt(ks) * np.minimum(s, end3))
    on_plateau, on_first = s - end3, np.sqrt(k1) * (s - end2)
    plateau = on2 - speed2 * on_plateau - 0.5 * b1 * on_plateau**2
    first = on1 * np.cos(on_first) - speed1 / np.sqrt(k1) * np.sin(on_first)
    return np.where(s < end3, softening, np.where(s < end2, plateau, first))
