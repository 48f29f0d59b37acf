"""What the height of a wall's hinge decides: restitution by Eq. (7), and where the wall is weakest by Eq. (5)."""

from __future__ import annotations

import numpy as np

from rockdamp.arguments import quantity
from rockdamp.arrays import Array, Quantity

# ASSUME: where tests found the hinge, section 2. Eq. (5) alone has its least at the top of a wall without overburden.
HINGE_RANGE = (0.5, 0.7)


def angular_momentum_restitution(thickness: Quantity, height: Quantity, hinge_ratio: Quantity) -> Array:
    """Return e by Eq. (7), for sizes of which there may be no wall too: it falls to -1 with the hinge's height. [-]"""
    lower = np.multiply(hinge_ratio, height)
    product = lower * (lower + height)
    return (product - 3 * np.square(thickness)) / (product + 3 * np.square(thickness))


def weakest_hinge_ratio(thickness: Quantity, overburden_ratio: Quantity, eccentricity: Quantity) -> Array:
    r"""Return r = h1/h at which F0 of Eq. (5) is least, within `HINGE_RANGE`. [-]

    .. math:: \frac{1 - r}{r} = \sqrt{\frac{\Psi \, (1 + 2 d/t)}{2 \, (1 + \Psi)}}, \qquad \Psi = \frac{O}{W}

    The sizes are those of `Wall`. [m], [-], [m]
    """
    sizes = {"thickness": thickness, "overburden_ratio (O/W)": overburden_ratio, "eccentricity": eccentricity}
    t, psi, d = (quantity(name, value) for name, value in sizes.items())
    with np.errstate(all="ignore"):  # of values that no wall has, which are refused later
        upper_over_lower = np.sqrt(np.maximum(np.divide(psi * (1 + np.divide(2 * d, t)), 2 * (1 + psi)), 0.0))
    return np.clip(1 / (1 + upper_over_lower), *HINGE_RANGE)
