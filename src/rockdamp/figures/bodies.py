"""The rigid bodies of a wall as they are drawn, at displacements of any size."""

from __future__ import annotations

import math

import numpy as np

from rockdamp.arrays import Array


def rotation(thickness: float, height: float, offset: float) -> float:
    """Return the rotation of a body whose top left corner moves `offset` >= 0 to the right. [rad]

    It follows from t - t cos(theta) + h sin(theta) = offset. Beyond its diagonal the body lies on its side.
    """
    across = min((offset - thickness) / math.hypot(thickness, height), 1.0)
    return math.atan2(thickness, height) + math.asin(across)


def turned(thickness: float, height: float, offset: float) -> Array:
    """Return the corners of a body that turns about its bottom right one, the origin, shape (4, 2). [m]

    They are bottom left, bottom right, top right, top left.
    """
    angle = rotation(thickness, height, offset)
    upright = np.array([(-thickness, 0.0), (0.0, 0.0), (0.0, height), (-thickness, height)])
    turn = np.array([(math.cos(angle), -math.sin(angle)), (math.sin(angle), math.cos(angle))])
    return upright @ turn


def wall_corners(thickness: float, height: float, hinge_ratio: float, offset: float) -> list[Array]:
    """Return the corners of the lower and the upper body, or of a parapet alone where `hinge_ratio` is NaN. [m]

    x is from mid-thickness. For offset > 0 the lower body turns about its right base corner. The upper one turns about
    its right top corner, which the support holds. They touch at the hinge, on the left face; offset < 0 mirrors all.
    """
    side, size = (-1.0 if offset < 0 else 1.0), abs(offset)
    lower_height = height if math.isnan(hinge_ratio) else hinge_ratio * height
    bodies = [turned(thickness, lower_height, size)]
    if not math.isnan(hinge_ratio):
        upper = turned(thickness, height - lower_height, size) * (1.0, -1.0)  # upside down about its top corner
        upper[:, 1] += bodies[0][3, 1] - upper[3, 1]
        bodies.append(upper)
    return [(corners + (thickness / 2, 0.0)) * (side, 1.0) for corners in bodies]
