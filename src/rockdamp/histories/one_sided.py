"""Walls that rock to one side under records: peaks and collapses, exactly or by the damper at the stop.

A record shakes such a wall in two ways: as it is, and turned round, as the wall would stand on the other side of the
building. Both are run where nobody says which way the facade looks.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.one_sided import CONTACT_STEP, OneSidedWall, Stop
from rockdamp.motions.records import Record, followed_by_rest
from rockdamp.solvers import one_sided_events, one_sided_march
from rockdamp.solvers.response import COLLAPSED

SIGNS = {"both": (1.0, -1.0), "+": (1.0,), "-": (-1.0,)}  # of a record: as it is, or turned round


def peaks_and_collapses(
    record: Record,
    wall: OneSidedWall,
    curve: TrilinearCurve,
    restitution: ArrayLike,
    factor: ArrayLike,
    *,
    tail: float,
    contact_stiffness: float | None = None,
    pulls: bool = False,
    step: float = CONTACT_STEP,
    threads: int = 1,
) -> tuple[Array, NDArray[np.bool_]]:
    """Run a wall under a record that is scaled by each factor, a negative one to turn it round.

    Parameters
    ----------
    record, wall, curve : Record, OneSidedWall, TrilinearCurve
        Of one wall.
    restitution, factor : float or ndarray
        Broadcast; what they broadcast to are the histories. [-]
    tail : float
        Rest after the record. [s]
    contact_stiffness : float, optional
        By default restitution acts at the impact itself, event by event. With a number, a spring of so many times the
        first branch's stiffness stands at the stop, with its dashpot, and the stepper runs. [-]
    pulls : bool
        Whether that stop may pull.
    step : float
        Of the stepper, times the frequency of the stop. [-]
    threads : int

    Returns
    -------
    peak, collapsed : ndarray
        Largest u/u_ins, meaningless for a wall that collapsed, and whether it did.
    """
    force = wall.force(curve)
    ground = followed_by_rest(record.ground_acceleration, record.step, tail)
    e, load_factor = np.broadcast_arrays(restitution, wall.load_factor * np.asarray(factor))
    sampling = float(wall.frequency_parameter) * record.step
    if contact_stiffness is None:
        exact = one_sided_events.ends(
            force,
            Stop(force.stop_stiffness, e),
            load_factor=load_factor,
            ground_acceleration=ground,
            sampling=sampling,
            duration=sampling * (ground.size - 1),
            threads=threads,
        )
        return exact.peak, exact.outcome == COLLAPSED
    kc = min(contact_stiffness * float(curve.initial_stiffness), float(force.stop_stiffness))
    substeps = max(int(np.ceil(sampling * np.sqrt(kc) / step)), 1)
    stepped = one_sided_march.solve(
        force,
        Stop(kc, e, pulls),
        step=sampling / substeps,
        steps=substeps * (ground.size - 1),
        load_factor=load_factor,
        ground_acceleration=ground,
        substeps=substeps,
        threads=threads,
    )
    return stepped.peak, stepped.outcome == COLLAPSED


def response(
    record: Record,
    wall: OneSidedWall,
    curve: TrilinearCurve,
    restitution: float,
    *,
    scale: float = 1.0,
    tail: float = 0.0,
    signs: Sequence[float] = SIGNS["+"],
) -> xr.Dataset:
    """Return the history of one wall under a record, as it is and turned round, at the samples of the record.

    Returns
    -------
    xarray.Dataset
        ``control_displacement`` [m] by ``sign`` and ``elapsed`` [s], ``ground_acceleration`` [m s-2] as it acts,
        ``peak`` (u/u_ins), ``collapsed``, ``outcome_elapsed`` [s], and ``impacts``.
    """
    force, u_ins, p = wall.force(curve), float(wall.instability_displacement), float(wall.frequency_parameter)
    ground = scale * followed_by_rest(record.ground_acceleration, record.step, tail)
    elapsed = record.step * np.arange(ground.size)
    rows = []
    for sign in signs:
        history = one_sided_events.history(
            force,
            Stop(force.stop_stiffness, restitution),
            p * elapsed,
            load=float(wall.load_factor) * sign * ground,
            load_step=p * record.step,
        )
        peaks = np.nanmax([0.0, np.nanmax(history.displacement), *history.of_kind("turn")[:, 1]])
        rows.append(
            {
                "control_displacement": ("elapsed", u_ins * history.displacement),
                "ground_acceleration": ("elapsed", sign * ground),
                "peak": ((), peaks),
                "collapsed": ((), history.outcome == "collapsed"),
                "outcome_elapsed": ((), history.outcome_tau / p),
                "impacts": ((), len(history.of_kind("impact"))),
            }
        )
    coords = {"elapsed": elapsed}
    each = [xr.Dataset(row, coords=coords) for row in rows]
    return xr.concat(each, xr.DataArray(list(signs), dims="sign", name="sign"))
