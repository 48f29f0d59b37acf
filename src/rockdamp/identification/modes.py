"""Modes of a posterior, with its scale about them, by Newton's method on differences of its density."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from rockdamp.arrays import Array

APART = 0.5  # of the scale: steps of the differences, wide enough for the solver's roughness not to show
ROUNDS = 25
LONGEST = np.array([1.0, 0.5, 0.25, 0.1, 0.03, 0.01, 2.0])  # of Newton's step, of which the best is taken
CURVED = (
    0.25,
    1e4,
)  # curvatures in the scale, bounded: at most doubled or a hundredth of it from one round to the next
LOWEST = -50.0  # below the centre, in place of minus infinity
GAINED = 0.05  # in the logarithm of the density: below it the mode is found
STEADY = 0.7  # change of the logarithm of a curvature, at most, by then


@dataclass(frozen=True)
class Mode:
    """A point of greatest density, the root of the covariance about it, and the density's logarithm."""

    centre: Array
    lower: Array
    log_density: float
    free: NDArray[np.intp]  # indices of the dimensions that were moved in

    def near(self, other: Mode) -> bool:
        """Say whether another mode is one with this one: within its scale, and the same in what was not moved in."""
        away = other.centre - self.centre
        inside = np.linalg.norm(np.linalg.solve(self.lower, away[self.free])) < 1
        return bool(inside and not np.delete(away, self.free).any())


def climb(
    log_density: Callable[[Array], Array],
    centre: Array,
    lower: Array,
    bounds: tuple[Array, Array],
    free: NDArray[np.intp] | None = None,
) -> Mode:
    """Find the mode uphill from a point.

    Parameters
    ----------
    log_density : callable
        Of points, shape (batch, dimensions).
    centre : ndarray, shape (dimensions,)
    lower : ndarray, shape (free, free)
        The scale to begin with, as the root of a covariance.
    bounds : tuple of ndarray
        Beyond which the density is taken as its mirror image: a mode at a bound is then one as any other.
    free : ndarray of int, optional
        Which dimensions to move in, by default all.
    """
    moved = np.arange(centre.size) if free is None else free
    offsets, pairs = _offsets(moved.size)

    def at(steps: Array) -> Array:
        points = np.repeat(centre[None], len(steps), axis=0)
        points[:, moved] += steps @ lower.T
        return _mirrored(points, *bounds)

    best = float(log_density(centre[None])[0])
    for _ in range(ROUNDS if np.isfinite(best) else 0):
        around = log_density(at(offsets))
        gradient, curvature = _derivatives(np.maximum(around - around[0], LOWEST), moved.size, pairs)
        values, vectors = np.linalg.eigh(curvature)
        values = np.clip(values, *CURVED)
        candidates = at(LONGEST[:, None] * (vectors @ (gradient @ vectors / values)))
        higher = log_density(candidates)
        chosen = int(np.argmax(higher))
        gained = float(higher[chosen] - around[0])
        if gained > 0:
            centre, best = candidates[chosen], float(higher[chosen])
        lower = triangular(lower @ vectors / np.sqrt(values))
        if gained < GAINED and np.abs(np.log(values)).max() < STEADY:
            break
    return Mode(centre, lower, best, moved)


def triangular(root: Array) -> Array:
    """Return the lower triangular root of a covariance from another root, shape (dimensions, at least as many)."""
    lower = np.linalg.qr(root.T)[1].T
    return np.asarray(lower * np.where(np.diag(lower) < 0, -1.0, 1.0), dtype=float)


def _offsets(dimensions: int) -> tuple[Array, list[tuple[int, int]]]:
    """Steps of the differences: none, along each axis both ways, along each pair of axes both ways."""
    axes = APART * np.eye(dimensions)
    pairs = list(combinations(range(dimensions), 2))
    both = np.array([axes[i] + axes[j] for i, j in pairs]).reshape(-1, dimensions)
    return np.concatenate([np.zeros((1, dimensions)), axes, -axes, both, -both]), pairs


def _derivatives(around: Array, dimensions: int, pairs: list[tuple[int, int]]) -> tuple[Array, Array]:
    """Gradient and negative matrix of second derivatives by differences from the centre, in the order of `_offsets`."""
    up, down = around[1 : 1 + dimensions], around[1 + dimensions : 1 + 2 * dimensions]
    curvature = np.diag((up + down) / APART**2)
    mixed = around[1 + 2 * dimensions :].reshape(2, -1).sum(axis=0) / APART**2
    for (i, j), value in zip(pairs, mixed, strict=True):
        curvature[i, j] = curvature[j, i] = (value - curvature[i, i] - curvature[j, j]) / 2
    return (up - down) / (2 * APART), -curvature


def _mirrored(points: Array, low: Array, high: Array) -> Array:
    """Reflect what lies beyond a bound, and set what would then lie beyond the other one in between."""
    reflected = np.where(points <= low, 2 * low - points, np.where(points >= high, 2 * high - points, points))
    return np.where((reflected > low) & (reflected < high), reflected, (low + high) / 2)
