"""A damping model with its numbers: the coefficient of restitution or a viscous damper."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array, short_repr
from rockdamp.errors import check, check_choice
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.dampers import (
    ABOVE_0,
    DAMPERS,
    NOT_TAKEN,
    Damper,
    KernelArguments,
    Parameters,
)

# ASSUME: the amplitude u/u_ins that e refers to where the loss depends on the amplitude and none is
# given.
REFERENCE_AMPLITUDE = 0.3


@dataclass(frozen=True, eq=False)
class Damping:
    """A damping model with its parameters, which broadcast against each other and the walls.

    Parameters
    ----------
    model : {"CR", "CDC", "CDR", "SDR", "ECD", "BAND", "CQD"}
        Name of the model.
    value : float or ndarray
        For CR the coefficient of restitution e, 0 to 1: whenever u changes sign, the velocity is
        multiplied by e. For the other models the damping ratio xi, at least 0. [-]
    order : float or ndarray, optional
        Order m of ECD; a larger order is closer to restitution. The default is 0. [-]
    width : float or ndarray, optional
        For BAND t_c, 0.2 by default: C acts where ``|x| < t_c |x'|/w1`` [rad]. For CQD the half
        width over a1, 0.25 by default [-].
    loss_exponent : float or ndarray
        Exponent g of CR and ECD. With g > 0 the loss falls with the amplitude: an impact at the
        energy E- leaves E+^g = E-^g - E_r^g (1 - e^2g), or stops the wall. For ECD less than 0.5.
        The default is 0. [-]
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
        for field in Parameters._fields:
            value = getattr(self, field)
            if value is None and field in ("order", "width"):
                value = damper.defaults.get(field, 0.0)
            name = damper.value_name if field == "value" else field
            checked = check(name, value, *rules.get(field, NOT_TAKEN))
            object.__setattr__(self, field, checked)
        damper.check(self.parameters)

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
            For BAND t_c, 0.2 by default: C acts where ``|x| < t_c |x'|/w1`` [rad]. For CQD the
            half width over a1, 0.25 by default [-].
        loss_exponent : float or ndarray
            Exponent g of CR and ECD; with g > 0 the loss falls with the amplitude. The default is
            0. [-]
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
        value = damper.value_from_restitution(e, lossless.parameters)
        return replace(lossless, value=value)

    @property
    def damper(self) -> Damper:
        """Properties of the model that need no numbers."""
        return DAMPERS[self.model]

    @property
    def parameters(self) -> Parameters:
        """All fields but the model."""
        return Parameters(*(getattr(self, field) for field in Parameters._fields))

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
        return self.damper.kernel_arguments(self.parameters, curve)
