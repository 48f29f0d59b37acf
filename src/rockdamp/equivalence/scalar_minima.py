"""Least values of a function of one variable, for many cases at once: a bracket, and Chandrupatla's method in it.

T. R. Chandrupatla (1998), "An efficient quadratic fit, sectioning algorithm for minimization without derivatives",
Computer Methods in Applied Mechanics and Engineering 152, 211-217. The results are those of SciPy's
`optimize.elementwise`, to the bit, with three evaluations fewer; to import that takes as long as to match a wall.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from rockdamp.arrays import Array

Function = Callable[[Array, NDArray[np.int64]], Array]  # of x and of the cases that they belong to

EXPANSIONS = 200  # of a bracket, each to twice the distance or half the way to 0
ITERATIONS = 100
GOLDEN = 0.5 + 0.5 * 5**0.5
FLAT = 1e-13  # second difference over the value at which rounding hides what is left of a minimum


def bracket(function: Function, low: Array, middle: Array, high: Array) -> tuple[Array, Array]:
    """Return three points around a local minimum of each case and the values there, both of shape (3, cases).

    Where those that are given hold none, they go downhill from there: away from 0, or towards it and not to it. The
    value in the middle is NaN where nothing is found.

    Parameters
    ----------
    function : callable
        Value of each case: it is given x and the number of the case, both of shape (some cases,).
    low, middle, high : ndarray, shape (cases,)
        0 < low < middle < high.
    """
    moving = np.arange(middle.size)
    x = np.stack([low, middle, high])
    f = np.stack([function(each, moving) for each in x])
    towards_zero = f[0] < f[2]  # from here on, downhill is from the first to the last
    x[:, towards_zero], f[:, towards_zero] = x[::-1, towards_zero], f[::-1, towards_zero]
    start, pace = x[2].copy(), x[2] - x[1]
    for expansion in range(1, EXPANSIONS + 1):
        moving = moving[~_holds_a_minimum(f[:, moving])]
        moving = moving[np.isfinite(f[2, moving])]
        if not moving.size:
            break
        away = start[moving] + pace[moving] * 2.0**expansion
        ahead = np.where(towards_zero[moving], start[moving] * 0.5**expansion, away)
        x[:, moving] = x[1, moving], x[2, moving], ahead
        f[:, moving] = f[1, moving], f[2, moving], function(ahead, moving)
    f[1, ~_holds_a_minimum(f)] = np.nan
    return x, f


def _holds_a_minimum(f: Array) -> NDArray[np.bool_]:
    return ((f[0] >= f[1]) & (f[2] > f[1])) | ((f[0] > f[1]) & (f[2] >= f[1]))


def least(function: Function, x: Array, f: Array, resolution: float) -> tuple[Array, Array]:
    """Return x of the local minimum in each bracket, and its value; NaN where the bracket holds none.

    Parameters
    ----------
    function : callable
        As of `bracket`.
    x, f : ndarray, shape (3, cases)
        What `bracket` returns.
    resolution : float
        Of x, over x.
    """
    cases = np.flatnonzero(np.isfinite(x).all(axis=0) & np.isfinite(f).all(axis=0))
    at, value = np.full(x.shape[1], np.nan), np.full(x.shape[1], np.nan)
    order = np.argsort(x[:, cases], axis=0)
    x, f = (np.take_along_axis(array[:, cases], order, axis=0) for array in (x, f))
    vertex = x[2]  # of the parabola, one iteration before
    for _ in range(ITERATIONS):
        swapped = np.abs(x[2] - x[1]) < np.abs(x[1] - x[0])  # the larger interval is the second one
        x[:, swapped], f[:, swapped] = x[::-1, swapped], f[::-1, swapped]
        close = np.abs(x[2] - x[1]) <= 2 * np.abs(x[1]) * resolution
        done = close | (f[0] - 2 * f[1] + f[2] <= 2 * np.abs(f[1]) * FLAT)
        at[cases[done]], value[cases[done]] = x[1, done], f[1, done]
        if done.all():
            break
        cases, x, f, before = cases[~done], x[:, ~done], f[:, ~done], vertex[~done]
        vertex = _vertex(x, f)
        tried = _tried(x, vertex, before, np.abs(x[1]) * resolution)
        _take(x, f, tried, function(tried, cases))
    return at, value


def _vertex(x: Array, f: Array) -> Array:
    """Where the parabola through the three points is least."""
    a, b = (x[1] - x[0]) * (f[2] - f[1]), (x[2] - x[1]) * (f[0] - f[1])
    c = a / (a + b)
    return 0.5 * (c * (x[0] - x[2]) + x[1] + x[2])


def _tried(x: Array, vertex: Array, before: Array, distance: Array) -> Array:
    """The vertex where it has settled, at a least distance from the middle; else a golden section of the second."""
    reach = x[2] - x[1]
    beside = np.where(np.abs(vertex - x[1]) <= distance, x[1] + np.sign(reach) * distance, vertex)
    return np.where(np.abs(vertex - before) < 0.5 * np.abs(x[1] - x[0]), beside, x[1] + (2 - GOLDEN) * reach)


def _take(x: Array, f: Array, tried: Array, value: Array) -> None:
    """Narrow the brackets by a point each, in place: the lower of it and the middle is the middle."""
    worse = value > f[1]
    beyond = np.sign(tried - x[1]) == np.sign(x[2] - x[1])
    end, case = np.where(worse == beyond, 2, 0), np.arange(worse.size)
    x[end, case], f[end, case] = np.where(worse, tried, x[1]), np.where(worse, value, f[1])
    x[1], f[1] = np.where(worse, x[1], tried), np.where(worse, f[1], value)
