"""Walls whose restoring force is not odd, or changes with time: which of them collapse under restitution.

A wall may be stronger to one side than to the other, and vertical shaking may change its weights; `newmark` has neither
of them. The scheme is the same, explicit Newmark with the impact located inside the step; lanes run one after the
other, each up to its collapse.

Dimensionless: x = u/u_ins, tau = p t, unit mass, forces over F0.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numba.extending import register_jitable
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.solvers.compiled import compiled
from rockdamp.solvers.newmark_kernel import crossed, force, impact_within, odd

# --- compiled ---------------------------------------------------------------------------------------------------------


@register_jitable
def collapses_alone(lane, ground, vertical):
    """Tell if a lane collapses; `lane` is a row of what `collapses` broadcasts."""
    k1, b1, ks, a3, e, h, substeps, load, lift, positive, negative = lane
    parts = int(substeps)
    x, v, end = 0.0, 0.0, load * ground[0]
    a = end
    for sample in range(ground.size - 1):
        for part in range(1, parts + 1):
            share = part / parts
            start, end = end, load * (ground[sample] + (ground[sample + 1] - ground[sample]) * share)
            rest, moved = h, x + h * (v + 0.5 * h * a)
            if crossed(x, moved):
                until = impact_within(x, v, a, h)
                at = start + (end - start) * (until / h)  # at x = 0 the acceleration is the load's alone
                v += 0.5 * until * (a + at)
                v *= e
                a, rest = at, h - until
                moved = rest * (v + 0.5 * rest * a)
            x = moved
            scale = negative if x < 0.0 else positive
            z = np.abs(x) / scale
            if z > a3:
                return True
            up = vertical[sample] + (vertical[sample + 1] - vertical[sample]) * share
            pull = odd(x, scale * force(z, k1, b1, ks, a3)) * max(1.0 + lift * up, 0.0)
            v, a = v + 0.5 * rest * (a + end - pull), end - pull
    return False


def march(lanes, ground, vertical, fell):
    """Write which lanes, shape (lanes, parameters), collapse."""
    for i in range(lanes.shape[0]):
        fell[i] = collapses_alone(lanes[i], ground, vertical)


# --- called from outside ----------------------------------------------------------------------------------------------


def collapses(
    curve: TrilinearCurve,
    restitution: ArrayLike,
    *,
    step: ArrayLike,
    substeps: ArrayLike,
    load: ArrayLike,
    ground: Array,
    lift: ArrayLike = 0.0,
    vertical: Array | None = None,
    side: tuple[ArrayLike, ArrayLike] = (1.0, 1.0),
) -> NDArray[np.bool_]:
    """Return which lanes collapse: x'' + (1 + lift vertical) f(x) = load ground, and e at each impact, from rest.

    Everything but the motions broadcasts to the lanes' shape, which is that of the result.

    Parameters
    ----------
    step, substeps : ndarray
        In tau, and how many there are between two samples of the motions.
    load, ground, lift, vertical : ndarray
        Factors of the lanes on the two motions, and these, shape (samples,). The weights are never less than none.
    side : two ndarrays
        What times the curve is that of u > 0, and of u < 0, in force and displacement alike.
    """
    k1, b1, ks, _, _, a3 = curve.parameters()
    columns = np.broadcast_arrays(k1, b1, ks, a3, restitution, step, substeps, load, lift, *side)
    lanes = np.stack([np.ravel(np.asarray(column, dtype=float)) for column in columns], axis=-1)
    fell = np.empty(len(lanes), dtype=bool)
    _compiled()(lanes, ground, np.zeros_like(ground) if vertical is None else vertical, fell)
    return fell.reshape(columns[0].shape)


@cache
def _compiled() -> Any:
    return compiled(march, march)
