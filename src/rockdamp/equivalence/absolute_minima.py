"""The damping ratio of least sum of absolute differences, by the text under Eq. (17) and not by its formula."""

from __future__ import annotations

import numpy as np

from rockdamp.arrays import Array
from rockdamp.equivalence.minima import Cases
from rockdamp.solvers.newmark import solve

# Around the ratio of least squares: a coarse grid that holds the minimum, then a fine one between its neighbours.
WIDEST, COARSE, FINE = 1.8, 41, 101


def least_absolute(cases: Cases, damping_model: str, least_squares: Array, steps: int, scheme: str) -> Array:
    """Return the damping ratio that minimises the sum of ``||u_CR| - |u_DAF||`` over a response, for each case.

    It is looked for within a factor `WIDEST` of the ratio of least squares; the fine grid is spaced by 0.06 %.
    """
    found = np.empty_like(least_squares)
    for case, middle in enumerate(least_squares.tolist()):
        ratios = middle * np.geomspace(1 / WIDEST, WIDEST, COARSE)
        best = ratios[_sums(cases, case, damping_model, ratios, steps, scheme).argmin()]
        spacing = ratios[1] / ratios[0]
        ratios = best * np.geomspace(1 / spacing, spacing, FINE)
        found[case] = ratios[_sums(cases, case, damping_model, ratios, steps, scheme).argmin()]
    return found


def _sums(cases: Cases, case: int, damping_model: str, ratios: Array, steps: int, scheme: str) -> Array:
    """Return the sum of the absolute differences for each of some damping ratios. [-]"""
    history = solve(
        cases.curve_of(case),
        cases.damping_of(damping_model, ratios, case),
        step=cases.step,
        steps=steps,
        release_amplitude=float(cases.release_amplitude[case]),
        scheme=scheme,
        store_every=1,
    )
    apart = np.abs(np.abs(history.displacement) - np.abs(cases.displacement[case, : steps + 1]))
    total: Array = apart.sum(axis=-1)
    return total
