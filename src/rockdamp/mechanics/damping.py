"""Damping models: the coefficient of restitution and the viscous dampers, with their parameters.

Dimensionless as in the solvers: unit mass, x = u/u_ins, tau = p t, C over m_eff p. Eqs (8), (10), (11), (12) of the
paper; ECD, BAND and CQD are beyond it. ECD is derived in docs/theory.md, sections 4 and 7, a loss that depends on the
amplitude in section 8, BAND and CQD in section 9. The formulas of C are in `solvers.kernel`, and once more, written
independently, in the exact solver.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.errors import InputError, Rule, check, check_choice
from rockdamp.mechanics.curve import TrilinearCurve

# ASSUME: the amplitude that e belongs to where the loss depends on the amplitude and no other is said [u/u_ins].
REFERENCE_AMPLITUDE = 0.3
# ASSUME: of kappa cos^(2m+1) phi sin phi, which is less than 1 where half cycles end. Beyond it the damper is no longer
# exact: the motion is then nearly the creep of an overdamped oscillator.
CAP = 0.95
LARGEST_BAND_RATIO = -math.log(0.01) / math.pi  # xi of e = 0.01
LARGEST_STRENGTH = 3.4  # delta' of BAND; a narrow band divides by zero at 2 sqrt(3) = 3.46

AT_LEAST_0: Rule = (lambda x: x >= 0, "at least 0")
ABOVE_0: Rule = (lambda x: x > 0, "greater than 0")
BAND_RATIO: Rule = (
    lambda xi: (xi >= 0) & (xi <= LARGEST_BAND_RATIO),
    "at least 0 and at most 1.47, that of e = 0.01",
)
NOT_TAKEN: Rule = (lambda x: x == 0, "0, as it belongs to another model")
DEFAULTS = {
    "order": NOT_TAKEN,
    "width": NOT_TAKEN,
    "loss_exponent": NOT_TAKEN,
    "reference_amplitude": ABOVE_0,
}


class Damper(NamedTuple):
    """What holds of a model: its title, and the rules of its parameters."""

    title: str
    rules: dict[str, Rule]
    default_width: float = 0.0
    is_amplitude_independent: bool = False  # every half cycle loses the same share of its energy
    largest_value: float = math.inf


# ASSUME: the paper has no band of fixed time. A narrower one is nearer to restitution, with a force as 1/t_c.
DAMPERS = {
    "CR": Damper(
        "coefficient of restitution",
        {
            "value": (lambda e: (e >= 0) & (e <= 1), "at least 0 and at most 1"),
            "loss_exponent": AT_LEAST_0,
        },
    ),
    "CDC": Damper("constant damping coefficient", {"value": AT_LEAST_0}),
    "CDR": Damper("constant damping ratio", {"value": AT_LEAST_0}),
    "SDR": Damper("stiffness proportional damping ratio", {"value": AT_LEAST_0}),
    "ECD": Damper(
        "energy-consistent damper",
        {
            "value": AT_LEAST_0,
            "order": (
                lambda m: (m >= 0) & (m <= 10_000),
                "0 to 10 000",
            ),  # steps would pass over the band of a larger
            "loss_exponent": (lambda g: (g >= 0) & (g < 0.5), "at least 0 and less than 0.5"),
        },
        is_amplitude_independent=True,
    ),
    "BAND": Damper(
        "band of fixed time", {"value": BAND_RATIO, "width": ABOVE_0}, 0.2, True, LARGEST_BAND_RATIO
    ),
    "CQD": Damper(
        "band of fixed length",
        {
            "value": BAND_RATIO,
            "width": (lambda w: (w > 0) & (w <= 1), "greater than 0 and at most 1"),
        },
        default_width=0.25,
        largest_value=LARGEST_BAND_RATIO,
    ),
}
PARAMETERS = ("value", *DEFAULTS)


@dataclass(frozen=True, eq=False)
class Damping:
    """A damping model with its parameters, which broadcast against each other and the walls they are given to.

    Parameters
    ----------
    model : {"CR", "CDC", "CDR", "SDR", "ECD", "BAND", "CQD"}
    value : float or ndarray
        Coefficient of restitution e of CR, 0 to 1: the velocity is multiplied by it whenever u changes sign. Damping
        ratio xi of the others, at least 0. [-]
    order : float or ndarray, optional
        m of ECD, 0 if not given; the larger, the nearer to restitution. [-]
    width : float or ndarray, optional
        t_c of BAND, 0.2 if not given [rad]; of CQD its half width over a1, 0.25 if not given. [-]
    loss_exponent : float or ndarray
        g of CR and ECD. With g > 0 the loss falls with the amplitude: an impact that the wall reaches with the energy
        E- leaves E+^g = E-^g - E_r^g (1 - e^2g), or stops it. Below 0.5 for ECD. [-]
    reference_amplitude : float or ndarray
        u/u_ins of the energy E_r = V(u) that the value belongs to; less than a3 of the curve. [-]

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> rd.Damping("CDR", 0.05).coefficient(curve, [0.02, 0.5]).round(
    ...     3
    ... )  # falls with the secant stiffness
    array([0.461, 0.1  ])
    """

    model: str
    value: Any
    order: Any = None
    width: Any = None
    loss_exponent: Any = 0.0
    reference_amplitude: Any = REFERENCE_AMPLITUDE

    def __post_init__(self) -> None:
        damper = DAMPERS[check_choice("damping_model", self.model, tuple(DAMPERS))]
        absent = {"order": 0.0, "width": damper.default_width}
        for name, (valid, allowed) in (DEFAULTS | damper.rules).items():
            value = getattr(self, name)
            value = absent[name] if value is None else value
            text = (
                name
                if name != "value"
                else "restitution"
                if self.model == "CR"
                else "damping_ratio"
            )
            object.__setattr__(self, name, check(text, value, valid, allowed))
        if self.model == "CR":
            check(
                "restitution",
                self.value,
                lambda e: (e > 0) | (self.loss_exponent == 0),
                "above 0 with an exponent",
            )
        if self.model == "BAND":
            most = half_cycle_loss(LARGEST_STRENGTH, self.width) / math.pi
            allowed = f"at most {np.min(most, initial=np.inf):.3g} with its width"
            check("damping_ratio", self.value, lambda xi: xi <= most, allowed)

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
        """Return the damper that loses in every half cycle what an impact takes: exact, and without a fit.

        Its other parameters are those of `Damping`.

        Parameters
        ----------
        e : float or ndarray
            Coefficient of restitution, in (0, 1]. [-]
        model : {"CR", "ECD", "BAND", "CQD"}
            CR is restitution itself. CQD is exact as its width tends to 0.

        Raises
        ------
        InputError
            For CDC, CDR and SDR, whose ratio depends on curve and amplitude, and for an e at which half cycles of ECD
            would not end.

        Examples
        --------
        >>> import rockdamp as rd
        >>> rd.Damping.from_restitution([0.8, 0.85]).value.round(4)
        array([0.071 , 0.0517])
        """
        if model in ("CDC", "CDR", "SDR"):
            raise InputError(
                f"damping_model is {model}; it must be CR, ECD, BAND or CQD: for others use equivalent"
            )
        parts = {
            "width": width,
            "loss_exponent": loss_exponent,
            "reference_amplitude": reference_amplitude,
        }
        if model == "CR":
            return cls(model, e, order, **parts)
        e = check("restitution", e, lambda e: (e > 0) & (e <= 1), "greater than 0 and at most 1")
        m, g = (
            np.asarray(0.0 if order is None else order, dtype=float),
            np.asarray(loss_exponent, dtype=float),
        )
        delta = 0.0 - np.log(e)
        if model != "ECD":
            return cls(model, delta / math.pi, order, **parts)
        plain = (m == 0) & (g == 0)
        loss = np.where(g == 0, delta, -np.expm1(-2 * g * delta) / np.where(g == 0, 1.0, 2 * g))
        xi = np.where(plain, delta / np.hypot(np.pi, delta), loss / np.pi)
        most = np.where(plain, np.inf, CAP * critical_damping_ratio(np.maximum(m, 0)))
        allowed = (
            f"at least {np.max(np.exp(-np.pi * most), initial=0):.3g}, or half cycles would not end"
        )
        check("restitution", e, lambda e: xi < most, allowed)
        return cls(model, xi, order, **parts)

    @property
    def label(self) -> str:
        """Name in datasets: ECD16, BAND0.4; the model alone at the default, and where the parameter is an array."""
        number = {"ECD": self.order, "BAND": self.width, "CQD": self.width}.get(
            self.model, np.zeros(())
        )
        default = DAMPERS[self.model].default_width
        return self.model if number.ndim or number == default else f"{self.model}{number:g}"

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape that the parameters broadcast to."""
        return np.broadcast_shapes(*(getattr(self, name).shape for name in PARAMETERS))

    def map(self, function: Callable[[Array], Array]) -> Damping:
        """Return the same model with a function, which picks or repeats elements, applied to each of its parameters."""
        values = np.broadcast_arrays(*(getattr(self, name) for name in PARAMETERS))
        return Damping(self.model, **dict(zip(PARAMETERS, map(function, values), strict=True)))

    def kernel_arguments(self, curve: TrilinearCurve) -> tuple[str, tuple[Any, Any, Any]]:
        """Return the name of the damper in the kernel and its three parameters there, which broadcast with the curve's.

        Parameters
        ----------
        curve : TrilinearCurve
        """
        value, w1, m, g = self.value, curve.initial_frequency, self.order, self.loss_exponent
        has_law = np.any(g != 0)
        a3, at = curve.ultimate_displacement_ratio, self.reference_amplitude
        if has_law:
            check("reference_amplitude", at, lambda x: x < a3, "less than a3")
        double_reference = 2 * curve.energy(at)
        if self.model == "CR":
            return (
                ("cr_law", (value, g, double_reference)) if has_law else ("cr", (value, 0.0, 0.0))
            )
        if self.model == "BAND":
            c = self.width / w1
            return "band", (3 * band_strength(math.pi * value, self.width) / (4 * c), c, 0.0)
        if self.model == "CQD":
            return "cqd", (0.75 * math.pi * value, self.width * curve.yield_displacement_ratio, 0.0)
        if self.model != "ECD":
            scale = {"CDC": 2 * w1 * value, "CDR": 2 * value, "SDR": 2 * value / w1}[self.model]
            return self.model.lower(), (scale, 0.0, 0.0)
        kappa = 2 * value * normalisation(m)
        if has_law:
            return "ecd_any", (kappa * double_reference**g, m, g)
        if not m.size or np.any(m != m.flat[0]):
            return "ecd_any", (kappa, m, 0.0)
        names = {0: "ecd", **dict.fromkeys((1, 2, 4, 8, 16, 32, 64, 128), "ecd_doubled")}
        return names.get(m.flat[0], "ecd_any"), (kappa, m.flat[0], 0.0)

    def coefficient(self, curve: TrilinearCurve, x: ArrayLike, v: ArrayLike = 0.0) -> Array:
        """Return the coefficient C over m_eff p, which for CR is zero. [-]

        Parameters
        ----------
        curve : TrilinearCurve
            Broadcasts.
        x, v : float or ndarray
            u/u_ins and its derivative by tau, broadcast; not every damper depends on the velocity. [-]
        """
        from rockdamp.solvers import kernel  # here, as Numba is slow to import

        x, v = np.asarray(x, dtype=float), np.asarray(v, dtype=float)
        shape = np.broadcast_shapes(x.shape, v.shape, curve.shape, self.shape)
        name, parameters = self.kernel_arguments(curve)
        if self.model == "CR":
            return np.zeros(shape)
        if self.model == "CQD":  # the kernel takes the mean over a step
            size, w, _ = parameters
            return np.broadcast_to(
                size / w * np.maximum(1 - (x / w) ** 2, 0) * np.abs(v), shape
            ).copy()
        shape_of_curve = curve.parameters()
        z = np.maximum(np.abs(x), kernel.TINY)
        f, double_v = kernel.force(z, shape_of_curve), kernel.double_energy(z, shape_of_curve)
        c = getattr(kernel, name)(z, f, double_v, np.where(x < 0, -v, v), 0.0, parameters)
        return np.broadcast_to(c, shape).copy()


# --- ECD --------------------------------------------------------------------------------------------------------------


def normalisation(order: ArrayLike) -> Array:
    r"""Return N_m, which makes 2 xi N_m the size kappa of ECD of order m with xi = delta/pi. [-]

    .. math:: N_m = \frac{\pi/2}{\int_{-\pi/2}^{\pi/2} \cos^{2m+2}\varphi\,d\varphi}
              = \frac{\sqrt{\pi}}{2}\,\frac{\Gamma(m+2)}{\Gamma(m+3/2)}

    It is 1, 4/3 and 8/5 at orders 0, 1 and 2, and tends to sqrt(pi m)/2.
    """
    m = np.asarray(order, dtype=float)
    ratio = [
        math.exp(math.lgamma(one + 2) - math.lgamma(one + 1.5)) for one in np.ravel(m).tolist()
    ]
    return np.where(m == 0, 1.0, math.sqrt(math.pi) / 2 * np.reshape(ratio, m.shape))


def critical_damping_ratio(order: ArrayLike) -> Array:
    r"""Return xi from which a half cycle does not end: the motion creeps to the origin and never crosses it. [-]

    There kappa cos^(2m+1) phi sin phi reaches 1 at its largest, tan^2 phi = 1/(2m+1):

    .. math:: \xi_c = \frac{\sqrt{2m+2}}{2 N_m}\left(\frac{2m+2}{2m+1}\right)^{m+1/2}

    It rises from 1 at order 0, the linear oscillator's, to sqrt(2 exp(1)/pi) = 1.3155.
    """
    m = np.asarray(order, dtype=float)
    return (
        np.sqrt(2 * m + 2) / (2 * normalisation(m)) * np.exp((m + 0.5) * np.log1p(1 / (2 * m + 1)))
    )


# --- BAND -------------------------------------------------------------------------------------------------------------

NODES, WEIGHTS = np.polynomial.legendre.leggauss(60)  # integrates the loss to the last digits
SHAPE = 0.75 * (1 - NODES**2)  # G t_c/delta'


def half_cycle_loss(strength: ArrayLike, width: ArrayLike) -> Array:
    r"""Return delta = -ln e of a half cycle that crosses u = 0 on the first branch under BAND. [-]

    .. math:: \delta = \int_{-t_c}^{t_c} \frac{G\,(1+t^2)^{-2}}{1 + G\,t/(1+t^2)}\,dt, \qquad
              G = \frac{3\delta'}{4 t_c}\left(1 - \frac{t^2}{t_c^2}\right)

    Parameters
    ----------
    strength : float or ndarray
        delta', from 0 to 3.4, broadcasts. [-]
    width : float or ndarray
        t_c, broadcasts. [rad]
    """
    g, t_c = np.asarray(strength, dtype=float)[..., None], np.asarray(width, dtype=float)[..., None]
    t, cosine, weight = _at_nodes(t_c)
    return np.sum(g * (weight / (1 + g / t_c * SHAPE * t * cosine)), axis=-1)


def _at_nodes(width: Array) -> tuple[Array, Array, Array]:
    """Return t, the square of the phase's cosine there, and what the integrand's numerator has without delta'."""
    t = width * NODES
    cosine = 1 / (1 + t * t)
    return t, cosine, WEIGHTS * SHAPE * cosine**2


def band_strength(log_decrement: ArrayLike, width: ArrayLike) -> Array:
    """Return delta' with which a half cycle loses delta = -ln e, the inverse of `half_cycle_loss`. [-]

    The short form delta (1 + 0.4 t_c^2 - 0.097 t_c^4 - 0.043 delta^2) is within 0.1 % of it for e from 0.5 to 1 and
    t_c up to 0.4. Newton's method falls to it from a strength that loses more, as delta is convex in delta'.

    Parameters
    ----------
    log_decrement : float or ndarray
        delta, from 0 to that of delta' = 3.4, broadcasts. [-]
    width : float or ndarray
        t_c, broadcasts. [rad]
    """
    delta, t_c = np.broadcast_arrays(
        np.asarray(log_decrement, dtype=float), np.asarray(width, dtype=float)
    )
    pairs, which = np.unique(delta + 1j * t_c, return_inverse=True)  # lanes share a few dampers
    shape, delta, t_c = delta.shape, pairs.real, pairs.imag
    strength = np.minimum(delta * (1 + t_c**2), LARGEST_STRENGTH)
    t, cosine, weight = _at_nodes(t_c[..., None])
    while True:
        g = strength[..., None]
        below = 1 + g / t_c[..., None] * SHAPE * t * cosine
        slope = weight / below
        step = (np.sum(g * slope, axis=-1) - delta) / np.sum(slope / below, axis=-1)
        moves = step > 1e-15 * strength
        if not moves.any():
            return strength[which].reshape(shape)
        strength = np.where(moves, strength - step, strength)
