"""The damping models: the coefficient of restitution and four viscous dampers, with the general exponent n.

Dimensionless as in the kernels: unit mass, C over m_eff p. Eqs (8), (10), (11), (12) of the paper; ECD is beyond it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rockdamp import kernels
from rockdamp.arrays import Array, Quantity, together
from rockdamp.errors import InputError, require, require_finite
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.vocabulary import MODELS

EXPONENTS = {"CDC": 0.0, "CDR": 1.0, "SDR": 2.0}  # C grows with this power of the secant's frequency
ENERGY_EXPONENTS = {"ECD": 1.0}  # or with this one of the energy's


@dataclass(frozen=True)
class Damping:
    """One damping model with its parameter, a number or an array that broadcasts against the walls it is given to.

    Make one with `Damping("CDR", 0.05)`, `Damping.cr(0.85)` or `Damping.power(1.3, 0.05)`.

    Parameters
    ----------
    model : str
        One of `MODELS`, or ``"POWER"`` for the general exponent.
    parameter : float or ndarray
        e for CR, in (0, 1]; the damping ratio xi for the others, >= 0. [-]
    exponent : float or ndarray
        n of the general exponent, >= 0; unused by the named models. [-]

    Raises
    ------
    InputError
        If the model is unknown or a value lies outside its range.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(cracked_stiffness_ratio=0.04, plateau_ratio=0.85)
    >>> rd.Damping("CDR", 0.05).coefficient(curve, [0.02, 0.5]).round(3)  # falls with the secant stiffness
    array([0.461, 0.1  ])
    """

    model: str
    parameter: Quantity
    exponent: Quantity = 0.0

    def __post_init__(self) -> None:
        if self.model not in (*MODELS, "POWER"):
            raise InputError(f"damping_model is {self.model!r}; it must be one of {', '.join(MODELS)}")
        name = "restitution (e)" if self.model == "CR" else "damping_ratio (xi)"
        require_finite(name, self.parameter)
        require_finite("exponent (n)", self.exponent)
        parameter, exponent = together(**{name: self.parameter}, exponent=self.exponent)
        if self.model == "CR":
            require((parameter > 0) & (parameter <= 1), name, parameter, "greater than 0 and at most 1")
        else:
            require(parameter >= 0, name, parameter, "at least 0")
        require(exponent >= 0, "exponent (n)", exponent, "at least 0")
        object.__setattr__(self, "parameter", parameter)
        object.__setattr__(self, "exponent", exponent)

    @classmethod
    def cr(cls, restitution: Quantity) -> Damping:
        """CR, Eq. (8): the velocity is multiplied by e whenever u changes sign."""
        return cls("CR", restitution)

    @classmethod
    def power(cls, exponent: Quantity, damping_ratio: Quantity) -> Damping:
        """C = 2 m_eff w1 xi (w/w1)^n, which is CDC, CDR and SDR at n = 0, 1 and 2."""
        return cls("POWER", damping_ratio, exponent)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape that the parameters broadcast to."""
        return np.broadcast_shapes(np.shape(self.parameter), np.shape(self.exponent))

    def terms(self, curve: TrilinearCurve) -> dict[int, Array]:
        """Return the rows that the kernel needs, by row: each of a shape that broadcasts with the curve's.

        In C = c0 + c1 sqrt(w^2) + c2 w^2 (see `kernels.viscous`), w^2 is the secant's or, for ECD, the energy's.
        """
        w1, xi = curve.initial_frequency, np.asarray(self.parameter)
        if self.model == "CR":
            return {kernels.E: xi}
        if self.model == "CDC":  # Eq. (10)
            return {kernels.C0: 2 * w1 * xi}
        if self.model == "CDR":  # Eq. (11)
            return {kernels.C1: 2 * xi}
        if self.model == "SDR":  # Eq. (12), xi(w) = xi w/w1
            return {kernels.C2: 2 * xi / w1}
        if self.model == "ECD":  # C = 2 xi w_E, w_E = |f|/sqrt(2V)
            return {kernels.C1: 2 * xi, kernels.BY_ENERGY: np.ones(())}
        n = np.asarray(self.exponent)
        return {kernels.C0: 2 * xi * w1 ** (1 - n), kernels.HALF_N: n / 2}

    def kind(self, scheme: str) -> int:
        """Return the kernel's kind of step for this model under `scheme`.

        Raises
        ------
        InputError
            If the scheme is unknown, or is ``paper`` for a general exponent, which the paper does not have.
        """
        if scheme not in ("newmark", "paper"):
            raise InputError(f"scheme is {scheme!r}; it must be one of newmark, paper")
        if self.model == "POWER":
            if scheme == "paper":
                raise InputError("scheme is 'paper'; it must be 'newmark' for a general exponent n")
            return kernels.POWER_NEWMARK
        if self.model == "CR":
            return kernels.RESTITUTION_LOCATED if scheme == "newmark" else kernels.RESTITUTION_PRINTED
        return kernels.VISCOUS_NEWMARK if scheme == "newmark" else kernels.VISCOUS_PRINTED

    def coefficient(self, curve: TrilinearCurve, x: ArrayLike) -> Array:
        """C(x) over m_eff p at displacement `x`; zero for CR, which damps by impacts. [-]"""
        if self.model == "CR":
            return np.zeros(np.broadcast_shapes(np.shape(x), curve.shape, self.shape))
        terms, z = self.terms(curve), np.abs(x)
        if self.model == "POWER":
            k1, b1, ks, _, _, a3 = curve.parameters()
            return kernels.power(z, k1, b1, ks, a3, terms[kernels.C0], terms[kernels.HALF_N])[1]
        rows = [terms.get(row, np.zeros(())) for row in (kernels.C0, kernels.C1, kernels.C2, kernels.BY_ENERGY)]
        return kernels.viscous(z, *curve.parameters(), *rows)[1]
