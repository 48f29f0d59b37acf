"""Minima over the damping ratio of the integral that Err, Eq. (17), tends to, free of the ripple of its steps.

Err samples |u|, which has a kink wherever u crosses zero, and the corners of the curve fall anywhere in a step of the
solver. When the damping ratio changes, kinks and corners move across the steps: that puts a ripple on Err, of second
order in the step and with a period of first order. So the least sample lies a *first* order of the step from the least
integral, and two steps can agree on it by chance. A cubic through many periods of the ripple has its mean alone, which
is of second order.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.equivalence.minima import Cases
from rockdamp.errors import InputError

NODES = np.linspace(-1.0, 1.0, 13)  # damping ratios tried, from the middle of their range in parts of its half width
INNER = slice(3, 10)  # those in the inner half of the range
HALF_WIDTH = 8.0  # of the range over its middle, over the step in tau: so it holds as many periods at every step
WIDEST = 0.1  # half width at most
MOVES = 50  # of the middle, before a minimum that no range holds is given up


def integral_minima(
    cases: Cases, damping_model: str, steps: int, damping_ratio: Array, scheme: str = "newmark"
) -> Array:
    """Find the damping ratios of the least integral of (|u_CR| - |u|)^2 next to those given, shape (2, cases). [-]

    First by all damping ratios tried, then by the inner half of them: the difference says how well a cubic fits. A
    ratio of 0, which belongs to e = 1, stays. It raises `InputError` where it finds no minimum.
    """
    width = min(HALF_WIDTH * cases.step, WIDEST)
    middle, least = damping_ratio.copy(), np.zeros((2, damping_ratio.size))
    moving = np.flatnonzero(damping_ratio > 0)
    for _ in range(MOVES):
        if not moving.size:
            return least
        integral = _integral(cases, damping_model, steps, middle[moving, None] * (1 + width * NODES), moving, scheme)
        of_all, of_inner = (_least_of_cubic(NODES[part], integral[:, part]) for part in (slice(None), INNER))
        least[:, moving] = middle[moving] * (1 + width * np.stack([of_all, of_inner]))
        middle[moving] = least[0, moving]
        moving = moving[np.abs(of_all) > NODES[INNER][-1]]  # the inner range has to hold it
    raise InputError(
        f"the minimum of Err of {damping_model} near xi = {damping_ratio[moving[0]]:.6g} could not be bracketed"
    )


def error_at(cases: Cases, damping_model: str, steps: int, damping_ratio: Array, scheme: str = "newmark") -> Array:
    """Return Err, Eq. (17), over the steps, shape (cases,). [-]"""
    lossy = np.flatnonzero(damping_ratio > 0)  # e = 1 is followed without error
    error = np.zeros(damping_ratio.size)
    error[lossy] = cases.errors(damping_model, damping_ratio[lossy, None], lossy[:, None], [steps], scheme)[0, :, 0]
    return error


def _integral(
    cases: Cases, model: str, steps: int, damping_ratio: Array, case: NDArray[np.int64], scheme: str
) -> Array:
    """Return the trapezoidal integral, over the step; its last sample counts half, and the first is 0."""
    return cases.errors(model, damping_ratio, case[:, None], [steps - 1, steps], scheme).mean(axis=0)


def _least_of_cubic(nodes: Array, values: Array) -> Array:
    """Return the place in [-1, 1] where the cubic fitted to each row is least: its minimum, or the end downhill."""
    fit = np.linalg.pinv(np.vander(nodes, 4, increasing=True))[1:]
    # Node by node: a product of matrices rounds otherwise with another number of rows, and a wall has one xi.
    slope, curvature, third = sum(np.multiply.outer(fit[:, node], values[:, node]) for node in range(nodes.size))
    root = np.sqrt(np.maximum(curvature**2 - 3 * slope * third, 0.0))
    convex = curvature + root > 0
    minimum = -slope / np.where(convex, curvature + root, 1.0)
    return np.clip(np.where(convex, minimum, -np.sign(slope)), -1.0, 1.0)
