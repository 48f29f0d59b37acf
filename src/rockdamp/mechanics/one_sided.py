"""Walls that rock to one side, away from a stop: facades in front of return walls or floors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.mechanics.wall import Parapet, Wall


# ASSUME: the stop is rigid and moves as the base does.
@dataclass(frozen=True)
class OneSidedWall:
    """A wall that rocks to one side, away from a rigid stop: u >= 0, and an impact turns v into -e v.

    Its sizes are those of its mechanism. `load_factor` is less than 0: a ground that accelerates towards the stop's
    side throws the wall off it.

    Parameters
    ----------
    mechanism : Wall or Parapet
        A `Parapet` is a block that rocks about its base corner, as a facade does; a `Wall` spans between two
        supports.

    Examples
    --------
    >>> import rockdamp as rd
    >>> front = rd.OneSidedWall(rd.Parapet(thickness=0.8, height=12))
    >>> round(float(front.restitution_measured), 3)
    0.511
    """

    mechanism: Wall | Parapet

    @property
    def instability_displacement(self) -> Array:
        """u_ins. [m]"""
        return self.mechanism.instability_displacement

    @property
    def frequency_parameter(self) -> Array:
        """p. [rad s-1]"""
        return self.mechanism.frequency_parameter

    @property
    def load_factor(self) -> Array:
        """Factor from the ground acceleration to the dimensionless load. [s2 m-1]"""
        return self.mechanism.load_factor

    @property
    def velocity_scale(self) -> Array:
        """p u_ins/lambda. [m s-1]"""
        return self.mechanism.velocity_scale

    @property
    def restitution_measured(self) -> Array:
        r"""Restitution of a block that hits a return wall: 0.41 at h/t = 5, 0.525 of a slender one. [-]

        .. math:: e = 1.05 \, (1 - \tfrac{3}{2} \sin^2 \alpha)^2 \, |1 - \tfrac{3}{2} \cos^2 \alpha|,
            \qquad \tan \alpha = \frac{t}{h}

        Sorrentino, AlShawa and Decanini (2011), second-hand. A wall with a hinge has none.
        """
        sine2 = 1 / (1 + self.mechanism.slenderness**2)
        return np.asarray(1.05 * (1 - 1.5 * sine2) ** 2 * np.abs(1 - 1.5 * (1 - sine2)))

    def rocking_onset(self, strength_ratio: ArrayLike = 1.0) -> Array:
        """Return the ground acceleration whose static load reaches the plateau. [m s-2]

        Parameters
        ----------
        strength_ratio : float or ndarray
            b1 of a cracked wall, broadcasts. [-]
        """
        return self.mechanism.rocking_onset(strength_ratio)
