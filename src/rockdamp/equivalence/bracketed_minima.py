"""Minima of many functions of one variable at once, within brackets: no derivatives, and few values of each."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from rockdamp.arrays import Array

GOLDEN = 0.5 + 0.5 * 5**0.5
MOST_ITERATIONS = 100
# Relative changes of a function below this part of it are rounding.
FLAT = 1e-13


def bracketed_minima(
    function: Callable[[Array, NDArray[np.int64]], Array], place: Array, value: Array, resolution: float
) -> tuple[Array, Array]:
    """Return places of minima within a part of themselves, and values there, shape (functions,) each.

    A parabola through the best three points is taken where two in a row agree, and a golden section elsewhere
    (Chandrupatla 1998, doi:10.1016/S0045-7825(97)00190-4). SciPy's `elementwise.find_minimum` does the same, bit by
    bit; it is slow to import, and takes the values in the bracket a second time.

    The function takes places, and of which functions. The brackets, shape (3, functions), are ascending places and
    values of which the middle one is least. NaN stands where a value is not finite, or no end is reached.
    """
    x, f, fitted, lane = place.copy(), value.copy(), place[2].copy(), np.arange(place.shape[1])
    least = np.full((2, lane.size), np.nan)
    for _ in range(MOST_ITERATIONS):
        nearer = np.abs(x[2] - x[1]) < np.abs(x[1] - x[0])  # the last point is to be the one further off
        x[:, nearer], f[:, nearer] = x[::-1, nearer], f[::-1, nearer]
        within = np.abs(x[1]) * resolution
        done = (np.abs(x[2] - x[1]) <= 2 * within) | (f[0] - 2 * f[1] + f[2] <= 2 * (np.abs(f[1]) * FLAT))
        least[:, lane[done]] = x[1, done], f[1, done]
        going = ~done & np.isfinite(f).all(axis=0)
        x, f, fitted, lane, within = x[:, going], f[:, going], fitted[going], lane[going], within[going]
        if not lane.size:
            break
        near, far = x[1] - x[0], x[2] - x[1]
        part, other = near * (f[2] - f[1]), far * (f[0] - f[1])
        vertex = 0.5 * (part / (part + other) * (x[0] - x[2]) + x[1] + x[2])
        moved = np.where(np.abs(vertex - x[1]) <= within, x[1] + np.sign(far) * within, vertex)
        agree = np.abs(vertex - fitted) < 0.5 * np.abs(near)
        tried, fitted = np.where(agree, moved, x[1] + (2 - GOLDEN) * far), vertex
        reached = function(tried, lane)
        higher = reached > f[1]
        # The better of the middle and the point tried is the middle; the other one, an end, on its side of it.
        last = (np.sign(tried - x[1]) == np.sign(far)) == higher
        for points, new in ((x, tried), (f, reached)):
            end = np.where(higher, new, points[1])
            points[1] = np.where(higher, points[1], new)
            points[2], points[0] = np.where(last, end, points[2]), np.where(last, points[0], end)
    return least[0], least[1]
