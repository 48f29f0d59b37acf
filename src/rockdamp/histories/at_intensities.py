"""Many walls under one record at several intensities: how each history ended, and nothing of it in between."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.histories.labelled import MOST_STEPS
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.records import Record, followed_by_rest
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.response import COLLAPSED

SUBSTEPS_BASE = 2  # substeps are powers of it, so that what a wall does depends on no other wall


def ends(
    record: Record,
    wall: Wall | Parapet,
    curve: TrilinearCurve,
    dampings: Sequence[Damping],
    factor: ArrayLike,
    *,
    step: float,
    tail: float,
) -> tuple[Array, NDArray[np.bool_]]:
    """Run walls with each damper under a record that is scaled by each of some factors.

    Parameters
    ----------
    record : Record
    wall, curve : Wall or Parapet, TrilinearCurve
        Their parameters are numbers, or arrays of shape (walls,).
    dampings : sequence of Damping
        Likewise.
    factor : ndarray, shape (factors,) or (walls, factors)
        On the record's acceleration. [-]
    step : float
        The longest, times the angular frequency of the first branch. [-]
    tail : float
        Rest after the record. [s]

    Returns
    -------
    peak, collapsed : ndarray, shape (walls, factors, dampings)
        Largest |u|/u_ins, which of a wall that collapsed means nothing, and whether it did. [-]

    Raises
    ------
    InputError
        If a history would take more than `MOST_STEPS` steps.
    """
    factor = np.atleast_2d(np.asarray(factor, dtype=float))
    shapes = [damping.shape for damping in dampings]
    count = np.broadcast_shapes(np.shape(wall.load_factor), curve.shape, *shapes, factor.shape[:1], (1,))
    spread = partial(np.broadcast_to, shape=count)
    frequency, load, curve = spread(wall.frequency_parameter), spread(wall.load_factor), curve.map(spread)
    factor = np.broadcast_to(factor, (*count, factor.shape[1]))
    ground = followed_by_rest(record.ground_acceleration, record.step, tail)
    sampling = frequency * record.step
    substeps = substeps_of(sampling * curve.initial_frequency, step)
    peak, collapsed = (np.empty((*factor.shape, len(dampings)), dtype=kind) for kind in (float, bool))
    _require_affordable(int(substeps.max()) * (ground.size - 1), float(frequency.max()))
    for many in np.unique(substeps):
        some = np.flatnonzero(substeps == many)
        # The intensities come first: where all walls of a block have collapsed, the kernel leaves it.
        loads = load[some] * factor[some].T
        for column, damping in enumerate(dampings):
            response = solve(
                curve.map(lambda parameter, some=some: parameter[some]),  # type: ignore[misc]
                damping.map(lambda parameter, some=some: spread(parameter)[some]),  # type: ignore[misc]
                step=sampling[some] / many,
                steps=int(many) * (ground.size - 1),
                load_factor=loads,
                ground_acceleration=ground,
                substeps=int(many),
            )
            peak[some, :, column], collapsed[some, :, column] = response.peak.T, (response.outcome == COLLAPSED).T
    return peak, collapsed


def substeps_of(sampling: ArrayLike, step: float) -> NDArray[np.int64]:
    """Count the solver's steps between two samples.

    Parameters
    ----------
    sampling : float or ndarray
        Of the record, times the angular frequency of the first branch. [-]
    step : float
        The longest, as `sampling`. [-]
    """
    needed = np.asarray(sampling, dtype=float) / step
    return SUBSTEPS_BASE ** np.maximum(np.ceil(np.log2(needed)), 0).astype(int)


def _require_affordable(steps: int, frequency: float) -> None:
    if steps > MOST_STEPS:
        raise InputError(
            f"a history would take {steps:.3g} steps of the solver; they must be at most {MOST_STEPS:.3g} (p is"
            f" {frequency:.3g} rad/s: the wall may be far smaller than is meant)"
        )
