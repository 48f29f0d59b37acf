"""The batched solver: any number of walls, dampers and releases advance together through the compiled kernel."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rockdamp import kernels
from rockdamp.curve import TrilinearCurve
from rockdamp.damping import Damping
from rockdamp.errors import InputError, require, require_finite

COMPLETED, COLLAPSED = 0, 1
OUTCOMES = ("completed", "collapsed")

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Reference:
    """Histories that Eq. (17) compares with, while the kernel runs, so that no other history is stored.

    Parameters
    ----------
    displacement : ndarray, shape (cases, steps + 1)
        u/u_ins at each step of the solver. [-]
    case : ndarray of int, broadcasts to the lanes
        Which row each lane is compared with.
    checkpoints : sequence of int, ascending
        Steps up to which the error is summed.
    """

    displacement: Array
    case: ArrayLike
    checkpoints: ArrayLike


@dataclass(frozen=True)
class Response:
    """What a batch of time histories ended with; `shape` is what the inputs broadcast to.

    Attributes
    ----------
    outcome : ndarray of int, shape
        `COMPLETED`, or `COLLAPSED` where |u| went beyond u3 and the run ended. [-]
    outcome_tau : ndarray, shape
        Dimensionless time of the end: of the last step, or of the step that collapsed. [-]
    peak, peak_tau : ndarray, shape
        Largest |u|/u_ins at the steps, and its time. [-]
    impacts : ndarray of int, shape
        Crossings of u = 0, whatever the damper. [-]
    error : ndarray, shape (checkpoints, *shape), or None
        Eq. (17) at each checkpoint; infinite for a collapsed lane. [-]
    displacement, velocity : ndarray, shape (*shape, stored), or None
        u/u_ins and its derivative by tau; NaN after a collapse. [-]
    """

    outcome: NDArray[np.int8]
    outcome_tau: Array
    peak: Array
    peak_tau: Array
    impacts: NDArray[np.int64]
    error: Array | None = None
    displacement: Array | None = None
    velocity: Array | None = None


def stable_step(curve: TrilinearCurve) -> Array:
    """Stability limit of the explicit scheme, 2/w1, in tau. [-]"""
    return np.asarray(2.0 / curve.initial_frequency)


def solve(
    curve: TrilinearCurve,
    damping: Damping,
    *,
    step: ArrayLike,
    steps: int,
    release_amplitude: ArrayLike = 0.0,
    release_velocity: ArrayLike = 0.0,
    load_factor: ArrayLike = 0.0,
    ground_acceleration: ArrayLike = (),
    substeps: int = 1,
    reference: Reference | None = None,
    store_every: int = 0,
    scheme: str = "newmark",
    threads: int | None = None,
) -> Response:
    """Integrate Eq. (16), or its undamped form with Eq. (8), for every lane of a batch.

    Everything is dimensionless: displacements over u_ins, times tau = p t. Arguments that say so broadcast together;
    what they broadcast to is the batch.

    Parameters
    ----------
    curve, damping : TrilinearCurve, Damping
        Broadcast. One model for the whole batch.
    step : float or ndarray
        Step in tau, broadcasts. [-]
    steps : int
        Number of steps.
    release_amplitude, release_velocity : float or ndarray
        Displacement and velocity at the start, broadcast. [-]
    load_factor : float or ndarray
        Factor that makes `ground_acceleration` the load: `Wall.load_factor`, broadcasts. [s2 m-1]
    ground_acceleration : ndarray, shape (samples,)
        Shared record, linear between its samples; empty for a free decay. [m s-2]
    substeps : int
        Steps of the solver per sample of the record.
    reference : Reference, optional
        Sum Eq. (17) against it.
    store_every : int
        Store the histories at every this many steps; 0 stores none.
    scheme : {"newmark", "paper"}
        Explicit Newmark with located impacts, second order for every damper; or the paper's linear acceleration
        without iteration, with impacts at the end of the step.
    threads : int, optional
        Threads to use; by default those that the process may use.

    Returns
    -------
    Response

    Raises
    ------
    InputError
        If a value lies outside its range, a release is at or beyond a3, or the step is beyond the stability limit.
    """
    kind = damping.kind(scheme)
    ground = np.ascontiguousarray(ground_acceleration, dtype=float)
    for name, value in (
        ("step", step), ("release_amplitude", release_amplitude), ("release_velocity", release_velocity),
        ("load_factor", load_factor), ("ground_acceleration", ground),
    ):  # fmt: skip
        require_finite(name, value)
    for name, count, least in (("steps", steps, 1), ("substeps", substeps, 1), ("store_every", store_every, 0)):
        whole = isinstance(count, (int, np.integer)) and count >= least
        require(whole, name, count, f"a whole number, at least {least}")
    require(ground.ndim == 1, "the number of dimensions of ground_acceleration", ground.ndim, "1")
    if ground.size and steps > (ground.size - 1) * substeps:
        raise InputError(f"steps is {steps}; it must be at most {(ground.size - 1) * substeps}, the record's length")
    h, x0, v0, g = (
        np.asarray(value, dtype=float) for value in (step, release_amplitude, release_velocity, load_factor)
    )
    limit = stable_step(curve)
    require(h > 0, "step", h, "greater than 0")
    beyond = np.broadcast_to(limit, np.broadcast_shapes(h.shape, limit.shape))[~(h < limit)]
    allowed = f"less than the stability limit 2 sqrt(a1/b1) = {beyond[0]:.6g} (in tau)" if beyond.size else ""
    require(h < limit, "step", h, allowed)
    require(np.abs(x0) < curve.ultimate_ratio, "release_amplitude", x0, "less than a3, where the wall collapses")

    case = np.zeros((), dtype=np.int64) if reference is None else np.asarray(reference.case, dtype=np.int64)
    shape = np.broadcast_shapes(curve.shape, damping.shape, h.shape, x0.shape, v0.shape, g.shape, case.shape)
    lanes = int(np.prod(shape))
    blocks = -(-lanes // kernels.LANES)

    def fill(target: NDArray[Any], value: ArrayLike) -> None:
        flat = target.reshape(-1)
        flat[:lanes] = np.broadcast_to(value, shape).reshape(-1)
        flat[lanes:] = flat[0] if lanes else 0.0  # pad the last block with copies of the first lane

    rows = {
        kernels.X: x0, kernels.V: v0, kernels.ALIVE: 1.0, kernels.PEAK: np.abs(x0), kernels.H: h, kernels.G: g,
        kernels.E: 1.0, **dict(zip((kernels.K1, kernels.B1, kernels.KS, kernels.A1, kernels.A2, kernels.A3),
        curve.parameters())), **damping.terms(curve),
    }  # fmt: skip
    load = g * ground[0] if ground.size else 0.0
    rows[kernels.A] = load - curve.force(x0) - damping.coefficient(curve, x0) * v0
    work = np.zeros((kernels.ROWS, blocks * kernels.LANES))
    for index, value in rows.items():
        fill(work[index // kernels.LANES], value)
    work = np.ascontiguousarray(work.reshape(kernels.ROWS, blocks, kernels.LANES).swapaxes(0, 1))
    work = work.reshape(blocks, kernels.ROWS * kernels.LANES)

    empty = np.empty((0, 0, 0))
    checkpoints = np.array([0], dtype=np.int64)
    compared, error = np.empty((0, 0)), empty
    case_of_lane = np.zeros((blocks, kernels.LANES), dtype=np.int64)
    if reference is not None:
        checkpoints = np.ascontiguousarray(reference.checkpoints, dtype=np.int64)
        compared = np.ascontiguousarray(reference.displacement, dtype=float)
        require_finite("the reference's displacement", compared)
        require(compared.ndim == 2, "the number of dimensions of the reference", compared.ndim, "2, cases and steps")
        require(np.diff(checkpoints) > 0, "checkpoints", checkpoints[1:], "ascending")
        require(
            (checkpoints >= 1) & (checkpoints <= steps),
            "checkpoints",
            checkpoints,
            f"within 1 to {steps} steps",
        )
        if compared.shape[1] <= steps:
            raise InputError(f"the reference has {compared.shape[1] - 1} steps; it must have at least {steps}")
        require((case >= 0) & (case < compared.shape[0]), "case", case, "a row of the reference")
        fill(case_of_lane, case)
        error = np.full((blocks, checkpoints.size, kernels.LANES), np.inf)
    stored = steps // store_every + 1 if store_every else 0
    histories = [np.full((blocks, kernels.LANES, stored), np.nan) if store_every else empty for _ in range(2)]

    def advance(part: slice) -> None:
        kernels.march(
            kind, work[part], ground, substeps, steps, compared, case_of_lane[part], checkpoints, error[part],
            max(store_every, 1), histories[0][part], histories[1][part],
        )  # fmt: skip

    _in_threads(advance, blocks, threads)

    by_row = work.reshape(blocks, kernels.ROWS, kernels.LANES).swapaxes(0, 1).reshape(kernels.ROWS, -1)

    def take(index: int) -> Array:
        return by_row[index // kernels.LANES, :lanes].reshape(shape)

    collapsed = take(kernels.ALIVE) == 0.0
    if error.size:
        error = error.swapaxes(0, 1).reshape(checkpoints.size, -1)[:, :lanes].reshape(checkpoints.size, *shape)
        error[:, collapsed] = np.inf
    return Response(
        outcome=collapsed.astype(np.int8),
        outcome_tau=take(kernels.END) * h,
        peak=take(kernels.PEAK).copy(),
        peak_tau=take(kernels.PEAK_AT) * h,
        impacts=take(kernels.CROSSINGS).astype(np.int64),
        error=error if reference is not None else None,
        displacement=histories[0].reshape(-1, stored)[:lanes].reshape(*shape, stored) if store_every else None,
        velocity=histories[1].reshape(-1, stored)[:lanes].reshape(*shape, stored) if store_every else None,
    )


def _in_threads(advance, blocks: int, threads: int | None) -> None:  # type: ignore[no-untyped-def]
    """Call `advance` on slices of the blocks, at once on as many threads as are allowed; the slices do not matter."""
    threads = min(threads or available_threads(), blocks)
    if threads <= 1:
        advance(slice(0, blocks))
        return
    chunks = min(blocks, 4 * threads)  # a few each, so that no thread idles at the end
    edges = np.linspace(0, blocks, chunks + 1).astype(int)
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(advance, (slice(start, stop) for start, stop in zip(edges[:-1], edges[1:]))))


def available_threads() -> int:
    """Threads this process may use: NUMBA_NUM_THREADS where set, else the processors it may run on."""
    stated = os.environ.get("NUMBA_NUM_THREADS")
    if stated and stated.isdigit() and int(stated) > 0:
        return int(stated)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
