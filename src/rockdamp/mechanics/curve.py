"""The dimensionless tri-linear force-displacement curve of a cracked wall."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array, Quantity, short_repr
from rockdamp.constants import PRESETS, SOFTENING
from rockdamp.errors import Rule, check, check_choice, check_fields

# A shorter branch only comes from rounding: in floating point 1 - 0.85 is above 0.15.
SHORTEST_BRANCH = 1e-12
CURVE_RULES: dict[str, Rule] = {
    # ASSUME: joints are rougher than some micrometres, 1e-5 of the thickness of a wall.
    "yield_displacement_ratio": (lambda a1: a1 >= 1e-5, "at least 1e-5, as joints are rough"),
    "strength_ratio": (
        lambda b1: (b1 > SHORTEST_BRANCH) & (b1 < 1),
        "greater than 0 and less than 1",
    ),
    "ultimate_displacement_ratio": (
        lambda a3: (a3 > 0) & (a3 <= 1),
        "greater than 0 and at most 1",
    ),
}


@dataclass(frozen=True)
class TrilinearCurve:
    r"""Odd tri-linear law f(x), with f = F/(K0 u_ins) and x = u/u_ins (Section 3, Fig. 2).

    .. math::
        f(x) = \begin{cases}
            b_1 \, x/a_1 & 0 \le x \le a_1 \\
            b_1 & a_1 \le x \le a_2 \\
            b_1 \, (a_3 - x)/(a_3 - a_2) & a_2 \le x \le a_3 \\
            0 & x \ge a_3
        \end{cases}

    The parameters may be arrays, which broadcast against each other and against the arguments of
    the methods.

    Parameters
    ----------
    yield_displacement_ratio : float or ndarray
        a1 = u1/u_ins, in (0, a2). [-]
    strength_ratio : float or ndarray
        b1 = F_y/F0, in (0, 1). [-]
    ultimate_displacement_ratio : float or ndarray
        a3 = u3/u_ins, at most 1, and above 1 - b1 (steeper) or a1 + b1 (translated). The default is
        1. [-]
    softening : {"steeper", "translated"}
        Variant for a3 < 1. Steeper: the plateau ends on the bi-linear law (a2 = 1 - b1) and the
        last branch is steeper. Translated: the last branch keeps the slope -K0 and moves towards
        the origin (a2 = a3 - b1). The default is steeper.

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

    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_fields(self, CURVE_RULES)
        check_choice("softening", self.softening, SOFTENING)
        a1, b1, a3 = self.ratios
        if self.softening == "steeper":
            smallest = 1 - b1
            allowed = "greater than 1 - b1"
            end = "1 - b1"
        else:
            smallest = a1 + b1
            allowed = "greater than a1 + b1"
            end = "a3 - b1"
        has_softening = a3 > smallest + SHORTEST_BRANCH
        check("ultimate_displacement_ratio", a3, lambda a3: has_softening, allowed)
        has_plateau = a1 < self.plateau_end - SHORTEST_BRANCH
        allowed = f"less than a2 = {end}, where the plateau ends"
        check("yield_displacement_ratio", a1, lambda a1: has_plateau, allowed)

    @classmethod
    def preset(cls, name: str, **others: Quantity) -> TrilinearCurve:
        """Return the curve of one of Doherty's stages of degradation, quoted in section 3.

        Parameters
        ----------
        name : {"new", "moderate", "severe"}
            Stage of degradation.
        **others : float, ndarray or str
            Other parameters of the curve: ``ultimate_displacement_ratio``, ``softening``.
        """
        b1, a1 = PRESETS[check_choice("preset", name, tuple(PRESETS))]
        return cls(a1, b1, **others)

    @property
    def ratios(self) -> tuple[Array, Array, Array]:
        """The parameters a1, b1 and a3. [-]"""
        return (
            self.yield_displacement_ratio,
            self.strength_ratio,
            self.ultimate_displacement_ratio,
        )

    @property
    def plateau_end(self) -> Array:
        """a2 = u2/u_ins, where the plateau ends. [-]"""
        return plateau_end(self.strength_ratio, self.ultimate_displacement_ratio, self.softening)

    @property
    def initial_stiffness(self) -> Array:
        """k1 = b1/a1, the stiffness of the first branch divided by K0. [-]"""
        return np.asarray(self.strength_ratio / self.yield_displacement_ratio)

    @property
    def softening_stiffness(self) -> Array:
        """ks = b1/(a3 - a2) > 0, the stiffness of the last branch divided by -K0. [-]"""
        length = self.ultimate_displacement_ratio - self.plateau_end
        return np.asarray(self.strength_ratio / length)

    @property
    def initial_frequency(self) -> Array:
        """w1 = sqrt(k1), the initial frequency divided by p. [-]"""
        return np.asarray(np.sqrt(self.initial_stiffness))

    @property
    def shape(self) -> tuple[int, ...]:
        """Broadcast shape of the parameters."""
        return np.broadcast_shapes(*(np.shape(ratio) for ratio in self.ratios))

    def map(self, function: Callable[[Array], Array]) -> TrilinearCurve:
        """Return the curve with a function applied to each of its ratios.

        Parameters
        ----------
        function : callable
            Takes an array of the shape `shape`, and returns some of its elements or repeats them.
        """
        a1, b1, a3 = map(function, np.broadcast_arrays(*self.ratios))
        return TrilinearCurve(a1, b1, a3, self.softening)

    def parameters(self) -> tuple[Array, ...]:
        """Return k1, b1, ks, a1, a2 and a3, the arguments of the solvers. [-]"""
        a1, b1, a3 = self.ratios
        return self.initial_stiffness, b1, self.softening_stiffness, a1, self.plateau_end, a3

    def force(self, x: ArrayLike) -> Array:
        """Return the force f(x), divided by K0 u_ins. [-]

        Parameters
        ----------
        x : float or ndarray
            Displacement u/u_ins. [-]
        """
        x = np.asarray(x, dtype=float)
        k1, b1, ks, _, _, a3 = self.parameters()
        z = np.abs(x)
        lowest_line = np.minimum(np.minimum(k1 * z, b1), ks * (a3 - z))
        return np.sign(x) * np.maximum(lowest_line, 0.0)

    def energy(self, x: ArrayLike) -> Array:
        r"""Return the stored energy V(x), constant beyond a3. [-]

        .. math:: V(x) = \int_0^x f(s) \, \mathrm{d}s

        Parameters
        ----------
        x : float or ndarray
            Displacement u/u_ins. [-]
        """
        k1, b1, ks, a1, a2, a3 = self.parameters()
        z = np.abs(np.asarray(x, dtype=float))
        z1 = np.minimum(z, a1)
        z2 = np.minimum(np.maximum(z, a1), a2)
        z3 = np.minimum(np.maximum(z, a2), a3)
        # Last branch: 2V grows by ks ((a3 - a2)^2 - (a3 - z)^2), factorised.
        softening = ks * (z3 - a2) * (2.0 * a3 - a2 - z3)
        return np.asarray(0.5 * (k1 * z1 * z1 + 2.0 * b1 * (z2 - a1) + softening))

    def amplitude(self, energy: ArrayLike) -> Array:
        """Return the x >= 0 at which the stored energy is V, the inverse of `energy`. [-]

        Parameters
        ----------
        energy : float or ndarray
            Energy V, from 0 to V(a3). [-]
        """
        k1, b1, ks, a1, a2, a3 = self.parameters()
        v1 = self.energy(a1)
        v2 = self.energy(a2)
        largest = self.energy(a3)
        v = check(
            "energy",
            energy,
            lambda v: (v >= 0) & (v <= largest),
            "from 0 to V(a3), the largest energy that the curve stores",
        )
        rising = np.sqrt(2 * v / k1)
        plateau = a1 + (v - v1) / b1
        falling = a3 - np.sqrt(np.maximum(2 * (largest - v) / ks, 0))
        outer = np.where(v <= v2, plateau, falling)
        return np.where(v <= v1, rising, outer)

    def period(self, x0: ArrayLike) -> Array:
        r"""Return the period of undamped free vibration in tau = p t, in closed form. [-]

        .. math:: T(x_0) = 4 \int_0^{x_0} \frac{\mathrm{d}x}{\sqrt{2 \, (V(x_0) - V(x))}}

        Parameters
        ----------
        x0 : float or ndarray
            Amplitude u0/u_ins, in (0, a3). [-]
        """
        k1, b1, ks, a1, a2, a3 = self.parameters()
        allowed = "greater than 0 and less than a3"
        x0 = check("release_amplitude", x0, lambda x0: (x0 > 0) & (x0 < a3), allowed)
        v0 = self.energy(x0)

        def speed(x: Array) -> Array:
            return np.sqrt(np.maximum(2 * (v0 - self.energy(x)), 0))

        # A quarter period is the time from 0 to x0. Each branch covers its start to min(its end,
        # x0); empty branches give zero time. First branch: tan(w1 t) = w1 x/v. Plateau: the speed
        # falls at the rate b1.
        end1 = np.minimum(x0, a1)
        end2 = np.clip(x0, a1, a2)
        first = np.arctan2(np.sqrt(k1) * end1, speed(end1)) / np.sqrt(k1)
        plateau = (speed(end1) - speed(end2)) / b1
        # Softening: with y = a3 - x growing from rest at y0 = a3 - x0, y = y0 cosh(sqrt(ks) t).
        y0 = np.where(x0 > a2, a3 - x0, 1.0)
        growth = np.where(x0 > a2, (a3 - a2) / y0, 1.0)
        softening = np.arccosh(np.maximum(growth, 1.0)) / np.sqrt(ks)
        plateau = np.where(x0 > a1, plateau, 0.0)
        return 4 * (first + plateau + np.where(x0 > a2, softening, 0.0))


def plateau_end(
    strength_ratio: Quantity, ultimate_displacement_ratio: Quantity, softening: str
) -> Array:
    """Return a2, where the plateau ends: 1 - b1 (steeper) or a3 - b1 (translated). [-]

    Parameters
    ----------
    strength_ratio : float or ndarray
        Strength b1. [-]
    ultimate_displacement_ratio : float or ndarray
        Displacement a3 at which the force is zero. [-]
    softening : {"steeper", "translated"}
        Variant of the last branch.
    """
    end = 1.0 if softening == "steeper" else ultimate_displacement_ratio
    return np.asarray(end - strength_ratio)
