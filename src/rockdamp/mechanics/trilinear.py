"""The tri-linear curve at z = |x|, as formulas of plain numbers: force, tangent and twice the stored energy.

The same lines serve NumPy arrays and are compiled into the batched solver. They use no Python that Numba would not
compile. Symbols are the paper's: a1, b1 and a3 shape the curve, k1 = b1/a1 is the first branch's stiffness, and ks is
the softening branch's, taken positive. Forces are over K0 u_ins, displacements over u_ins.
"""

from typing import Any

import numpy as np

TINY = 1e-100  # keeps 0/0 away at x = 0; its square and the square's inverse are still normal numbers


def force(z: Any, k1: Any, b1: Any, ks: Any, a3: Any) -> Any:
    """Return the restoring force: the lowest of the three lines, zero beyond a3."""
    return np.maximum(np.minimum(np.minimum(k1 * z, b1), ks * (a3 - z)), 0.0)


def force_of_one(z: float, k1: float, b1: float, ks: float, a3: float) -> float:
    """Return the same force by Python alone, as NumPy takes long for one number."""
    return max(min(k1 * z, b1, ks * (a3 - z)), 0.0)


def tangent(z: Any, k1: Any, ks: Any, a1: Any, a2: Any, a3: Any) -> Any:
    """Return the slope of the force; at a corner that of the branch further out."""
    return k1 * (z < a1) - ks * ((z >= a2) & (z < a3))


def double_energy(z: Any, k1: Any, b1: Any, ks: Any, a1: Any, a2: Any, a3: Any) -> Any:
    """Return twice the stored energy 2V(z), V the integral of the force."""
    z1 = np.minimum(z, a1)
    z2 = np.minimum(np.maximum(z, a1), a2)
    z3 = np.minimum(np.maximum(z, a2), a3)
    return k1 * z1 * z1 + 2.0 * b1 * (z2 - a1) + ks * (z3 - a2) * (2.0 * a3 - a2 - z3)
