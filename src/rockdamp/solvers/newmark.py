"""The batched solver: any number of walls, dampers and releases advance together through the compiled kernel."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from itertools import pairwise
from threading import Event
from typing import Literal, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rockdamp.arguments import broadcast, finite, instance, one_of, whole
from rockdamp.arrays import Array, Quantity, is_named
from rockdamp.errors import InputError, holds, require
from rockdamp.mechanics import trilinear
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.damping.base import IMPACT
from rockdamp.plausibility import called_from_outside, of_dampings, warn
from rockdamp.questions import of_rest, of_run, of_start
from rockdamp.solvers import newmark_kernel as kernel
from rockdamp.solvers import peaks_kernel
from rockdamp.solvers.response import (
    COLLAPSED,
    RESPONSES,
    Batch,
    ComparedHistories,
    ComparedPeaks,
    Comparison,
    Histories,
    Options,
    Peaks,
    Reference,
    Response,
)

SCHEMES = tuple(kernel.STEPS)
BRANCHES = 3  # of the curve
MOST_STEPS = 10**9  # of a run: minutes for each block of lanes
SLICE = 2**18  # steps of a block of lanes between two looks at whether the run was interrupted: a fraction of a second
SHARE = 2**13  # of them that a thread has at least, by default: for fewer it would cost more than it gives
NEVER = Event()
ACCELERATION = "the acceleration at the start, of load, curve and damper"
SHORTEST = 1e-12  # step in tau; of far shorter ones the square vanishes, by which the scheme as printed divides


def stable_step(curve: TrilinearCurve) -> Array:
    r"""Return the stability limit of the explicit scheme, the step in tau that `solve` must stay below. [-]

    .. math:: \Delta\tau < \frac{2}{\omega_1} = 2 \sqrt{\frac{a_1}{b_1}}

    Parameters
    ----------
    curve : TrilinearCurve

    Returns
    -------
    ndarray, shape of the curve's parameters

    Examples
    --------
    >>> import rockdamp as rd
    >>> rd.stable_step(rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)).round(3).item()
    0.434
    """
    instance("curve", curve, TrilinearCurve)
    return np.asarray(2.0 / curve.initial_frequency)


@overload
def solve(
    curve: TrilinearCurve,
    damping: Damping,
    *,
    reference: None = None,
    store_every: None = None,
    peaks_only: Literal[False] = False,
    **options: Unpack[Options],
) -> Response: ...


@overload
def solve(
    curve: TrilinearCurve,
    damping: Damping,
    *,
    reference: None = None,
    store_every: int,
    peaks_only: Literal[False] = False,
    **options: Unpack[Options],
) -> Histories: ...


@overload
def solve(
    curve: TrilinearCurve,
    damping: Damping,
    *,
    reference: Reference,
    store_every: None = None,
    peaks_only: Literal[False] = False,
    **options: Unpack[Options],
) -> Comparison: ...


@overload
def solve(
    curve: TrilinearCurve,
    damping: Damping,
    *,
    reference: Reference,
    store_every: int,
    peaks_only: Literal[False] = False,
    **options: Unpack[Options],
) -> ComparedHistories: ...


@overload
def solve(
    curve: TrilinearCurve,
    damping: Damping,
    *,
    reference: None = None,
    store_every: None = None,
    peaks_only: Literal[True],
    **options: Unpack[Options],
) -> Peaks: ...


@overload
def solve(
    curve: TrilinearCurve,
    damping: Damping,
    *,
    reference: Reference,
    store_every: None = None,
    peaks_only: Literal[True],
    **options: Unpack[Options],
) -> ComparedPeaks: ...


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
    store_every: int | None = None,
    peaks_only: bool = False,
    scheme: str = "newmark",
    threads: int | None = None,
) -> Response | Peaks:
    r"""Integrate Eq. (16), or its undamped form with the impacts of Eq. (8), for every lane of a batch.

    .. math::
        \ddot{x} + C(x, \dot{x}) \, \dot{x} + f(x) = \gamma \, \ddot{u}_g(\tau); \qquad
        \text{CR:} \quad C = 0, \quad \dot{x}^+ = e \, \dot{x}^- \quad \text{at} \quad x = 0

    with the `load_factor` :math:`\gamma`. Everything is dimensionless: displacements over u_ins, times tau = p t.
    Arguments that say so broadcast together; what they broadcast to is the batch.

    Parameters
    ----------
    curve, damping : TrilinearCurve, Damping
        Broadcast. One model for the whole batch.
    step : float or ndarray
        Step in tau, broadcasts. Below the stability limit; without damping the corners of the curve feed energy in
        from a fifth of the limit on, so keep to a twentieth of it. [-]
    steps : int
        Number of steps.
    release_amplitude, release_velocity : float or ndarray
        Displacement and velocity at the start, broadcast. [-]
    load_factor : float or ndarray
        Factor that makes `ground_acceleration` the load: `Wall.load_factor`, broadcasts. Of several motions it has
        them as its first axis: a lane's load is their sum, each times the lane's factor on it. [s2 m-1]
    ground_acceleration : ndarray, shape (samples,) or (motions, samples)
        Shared record, or several, linear between the samples; empty for a free decay. [m s-2]
    substeps : int
        Steps of the solver per sample of the record.
    reference : Reference, optional
        Sum Eq. (17) against it.
    store_every : int, optional
        Store the histories at every this many steps; by default none are stored.
    peaks_only : bool
        Return outcomes and peaks alone, and with `reference` the sums: faster, as a history may end once its peak is
        sure. Not with `store_every`.
    scheme : {"newmark", "paper"}
        Explicit Newmark with located impacts, second order for every damper; or the paper's linear acceleration
        without iteration, with impacts at the end of the step.
    threads : int, optional
        Threads to use; by default those that the process may use.

    Returns
    -------
    Response
        `Histories` with `store_every`, `Comparison` with `reference`, and `ComparedHistories` with both. With
        `peaks_only` it is `Peaks`, and `ComparedPeaks` with `reference`.

    Raises
    ------
    InputError
        If a value lies outside its range, a release is at or beyond a3, or the step is beyond the stability limit.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> run = {"release_amplitude": 0.5, "step": 0.0025, "steps": 8000}
    >>> rd.solve(curve, rd.Damping.cr([0.8, 0.9]), store_every=100, **run).displacement.shape
    (2, 81)
    """
    instance("curve", curve, TrilinearCurve)
    instance("damping", damping, Damping)
    if asked := called_from_outside():
        warn(of_dampings([damping]))
    scheme = scheme if scheme in SCHEMES else one_of("scheme", scheme, SCHEMES)
    is_constant = damping.linear_branches == BRANCHES
    loops = peaks_kernel if peaks_only else kernel
    march = loops.compiled_march(scheme, damping.formula, damping.step_kind, is_constant)
    starts = {"step": step, "release_amplitude": release_amplitude, "release_velocity": release_velocity}
    loads = {"load_factor": load_factor, "ground_acceleration": ground_acceleration}
    _refuse_names({"yield_displacement_ratio": curve.yield_displacement_ratio, **damping.parameters, **starts, **loads})
    steps, substeps = whole("steps", steps, 1, MOST_STEPS), whole("substeps", substeps, 1, MOST_STEPS)
    every = 1 if store_every is None else whole("store_every", store_every, 1, MOST_STEPS)
    threads = None if threads is None else whole("threads", threads, 1)
    ground = _check_record(ground_acceleration, steps, substeps, scheme)
    arrays = {name: finite(name, value) for name, value in starts.items()}
    factors = _factors(load_factor, len(ground))
    cases = {} if reference is None else {"case": instance("reference", reference, Reference).case}
    if peaks_only and store_every is not None:
        raise InputError(
            f"store_every is {every} with peaks_only; it must be left out, as peaks come without histories"
        )
    # Two or three walls under restitution are faster one by one: a block computes each impact for all of its lanes.
    shape = broadcast(curve=curve, damping=damping, **arrays, load_factor=factors[0], **cases)
    batch = Batch(shape, apart=damping.step_kind == IMPACT and not peaks_only)
    stored = steps // every + 1 if store_every is not None else 0
    batch.require_room(stored, 0 if reference is None else reference.checkpoints.size)
    parts = (*arrays.values(), curve.initial_frequency, *curve.parameters(), *damping.formula_parameters(curve))
    parts += (arrays["step"],) if damping.takes_step else ()
    h, x0, v0, w1, *described = batch.plain(*parts)
    scales = batch.plain(*factors) if len(factors) > 1 else batch.plain(factors[0])
    _check_start(h, x0, 2.0 / w1, described[5])
    damping.check_step(curve, arrays["step"])
    if asked:
        rest = of_start(x0, curve.yield_displacement_ratio) if np.all(v0 == 0) and not ground.any() else []
        warn(rest + of_run(h, 2.0 / w1, steps, substeps, factors, ground, shape))
    load, acceleration = _balance(curve, described[:6], damping, x0, v0, scales, ground)
    (acceleration,) = batch.plain(acceleration)
    g = scales[0] if len(scales) == 1 else load
    state = x0, v0, acceleration, 1.0, 0.0, abs(x0), 0.0, 0.0, 0.0
    work = batch.pack((*state, *described[:6], h, g, g, *described[6:]))
    compared, case_of_lane, checkpoints, error = batch.compare(reference, steps)
    by_lane = batch.by_motion(factors)
    if peaks_only:
        parts_of = work, batch.width, ground, by_lane, substeps, steps, compared, case_of_lane, checkpoints
        peaks = _peaks(march, batch, threads, reference is not None, *parts_of)
        warn(of_rest(peaks.peak, factors, ground, curve) if asked else [])
        return peaks
    displacement, velocity = batch.histories(stored), batch.histories(stored)

    each = work, by_lane, case_of_lane, error, displacement, velocity

    def advance(part: slice, stopped: Event) -> None:
        for blocks, first, last in _slices(part, steps, substeps):
            if stopped.is_set():
                return
            w, by_motion, case, sums, x, v = [array[blocks] for array in each] if batch.blocks > 1 else each
            span = substeps, first, last
            march(w, batch.width, ground, by_motion, *span, compared, case, checkpoints, sums, every, x, v)

    _in_threads(advance, batch.blocks, steps, threads)

    ended = batch.ended(work, h)
    warn(of_rest(ended["peak"], factors, ground, curve) if asked else [])
    if store_every is not None:
        ended |= {"displacement": batch.trim(displacement), "velocity": batch.trim(velocity)}
    if reference is not None:
        collapsed = ended["outcome"] == COLLAPSED
        ended["error"] = np.where(collapsed, np.inf, batch.by_checkpoint(error))
    return RESPONSES[store_every is not None, reference is not None](**ended)


def _peaks(
    march: Callable[..., int],
    batch: Batch,
    threads: int | None,
    is_compared: bool,
    work: Array,
    width: int,
    ground: Array,
    by_lane: Array,
    substeps: int,
    steps: int,
    compared: Array,
    case_of_lane: NDArray[np.int64],
    checkpoints: NDArray[np.int64],
) -> Peaks:
    """Run the march of peaks alone."""
    work[:, peaks_kernel.LANE : peaks_kernel.LANE + width] = np.arange(batch.blocks * width).reshape(-1, width)
    outcome, peak = np.empty(batch.lanes, np.int8), np.empty(batch.lanes)
    error = np.empty((checkpoints.size, batch.lanes if is_compared else 0))
    remaining = _remaining(ground)
    length = -(-SLICE // peaks_kernel.INTERVAL) * peaks_kernel.INTERVAL

    def advance(part: slice, stopped: Event) -> None:
        blocks, by_motion, case = work[part], by_lane[part], case_of_lane[part]
        moving = min(part.stop * width, batch.lanes) - part.start * width
        first = 1
        while first <= steps and moving > 0 and not stopped.is_set():
            last = min(first - 1 + max(length // (part.stop - part.start), peaks_kernel.INTERVAL), steps)
            span = substeps, first, last, steps
            of_reference = compared, case, checkpoints, error
            moving = march(blocks, width, moving, ground, remaining, by_motion, *span, *of_reference, outcome, peak)
            first = last + 1

    _in_threads(advance, batch.blocks, steps, threads)
    ends = outcome.reshape(batch.shape), peak.reshape(batch.shape)
    if not is_compared:
        return Peaks(*ends)
    return ComparedPeaks(*ends, np.where(ends[0] == COLLAPSED, np.inf, error.reshape(checkpoints.size, *batch.shape)))


def _remaining(ground: Array) -> Array:
    """Return the integral of each motion's absolute value from each sample to the end, in units of time of a sample."""
    size = np.abs(ground)
    if not size.size:
        return np.zeros((1, 1))
    between = (size[:, 1:] + size[:, :-1]) / 2
    return np.pad(np.cumsum(between[:, ::-1], axis=1)[:, ::-1], ((0, 0), (0, 1)))


def _refuse_names(given: Mapping[str, ArrayLike]) -> None:
    """Raise `InputError` for arrays with named dimensions, which would be taken by position."""
    for name, value in given.items():
        if is_named(value):
            raise InputError(f"{name} has named dimensions; give them to rockdamp.free_decay or rockdamp.respond")


def _check_record(ground_acceleration: ArrayLike, steps: int, substeps: int, scheme: str) -> Array:
    """Return the motions, shape (motions, samples)."""
    # A copy, and not a read-only one: the kernel is compiled for arrays that can be written.
    ground = finite("ground_acceleration", ground_acceleration).copy()
    if ground.ndim != 1:
        require(ground.ndim == 2, "the number of dimensions of ground_acceleration", ground.ndim, "1 or 2")
    if ground.size and steps > (ground.shape[-1] - 1) * substeps:
        of = "" if ground.ndim == 1 else f"; ground_acceleration has shape {ground.shape}, (motions, samples)"
        raise InputError(
            f"steps is {steps}; it must be at most {(ground.shape[-1] - 1) * substeps}, the record's length{of}"
        )
    motions = ground if ground.ndim == 2 else ground[None]
    if len(motions) != 1:
        require(len(motions) > 0, "the number of motions", len(motions), "at least 1")
        require(motions.size > 0, "the number of samples of several motions", 0, "at least 1")
        require(scheme != "paper", "the number of motions", len(motions), "1 by the scheme 'paper'")
    return motions


def _factors(load_factor: ArrayLike, motions: int) -> Array:
    """Return the lanes' factors on each motion, shape (motions, ...)."""
    factors = finite("load_factor", load_factor)
    if motions == 1:
        return factors[None]
    shape = factors.shape or (1,)
    require(
        shape[0] == motions,
        "the first axis of load_factor",
        shape[0],
        f"{motions}, a factor on each motion, which add up",
    )
    return factors


def _check_start(h: Quantity, x0: Quantity, limit: Quantity, a3: Quantity) -> None:
    """Raise `InputError` for a step beyond its limits, and for a release beyond the collapse."""
    if not holds(h >= SHORTEST):
        require(h > 0, "step", h, "greater than 0")
        require(h >= SHORTEST, "step", h, f"at least {SHORTEST} (in tau)")
    if not holds(h < limit):
        stable = np.asarray(h < limit)
        beyond = np.broadcast_to(limit, stable.shape)[~stable]
        require(stable, "step", h, f"less than the stability limit 2 sqrt(a1/b1) = {beyond[0]:.6g} (in tau)")
    require(abs(x0) < a3, "release_amplitude", x0, "less than a3, where the wall collapses")


def _balance(
    curve: TrilinearCurve,
    described: Sequence[Quantity],
    damping: Damping,
    x0: Quantity,
    v0: Quantity,
    factors: Sequence[Quantity],
    ground: Array,
) -> tuple[Quantity, Quantity]:
    """Return the load at the start and the acceleration that balances the forces there; refuse what is out of scale."""
    k1, b1, ks, _, _, a3 = described
    if isinstance(x0, float) and len(factors) == 1 and v0 == 0:  # the usual case
        load = factors[0] * ground.item(0) + 0.0 if ground.size else 0.0
        net = load - math.copysign(trilinear.force_of_one(abs(x0), k1, b1, ks, a3), x0)
        require(math.isfinite(net), ACCELERATION, net, "a finite number")
        return load, net
    with np.errstate(over="ignore", invalid="ignore"):
        load = np.einsum("m...,m->...", factors, ground[:, 0]) + 0.0 if ground.size else 0.0
        net = load - np.sign(x0) * trilinear.force(np.abs(x0), k1, b1, ks, a3)
        start = net
        if not holds(v0 == 0):
            start = net - damping.unchecked_coefficient(curve, x0, v0) * v0
    require(np.isfinite(start), ACCELERATION, start, "a finite number")
    return load, start


def _slices(part: slice, steps: int, substeps: int) -> Iterable[tuple[slice, int, int]]:
    """Return blocks and steps, first and last, for one call of the kernel after the other: `SLICE` steps at once."""
    if (part.stop - part.start) * steps <= SLICE:
        return ((part, 1, steps),)
    return _several_slices(part, steps, substeps)


def _several_slices(part: slice, steps: int, substeps: int) -> Iterator[tuple[slice, int, int]]:
    at_once = max(SLICE // steps, 1)
    length = max(SLICE // substeps, 1) * substeps  # from sample to sample of the record
    for start in range(part.start, part.stop, at_once):
        blocks = slice(start, min(start + at_once, part.stop))
        for first in range(1, steps + 1, length):
            yield blocks, first, min(first + length - 1, steps)


def _in_threads(advance: Callable[[slice, Event], None], blocks: int, steps: int, threads: int | None) -> None:
    """Call `advance` on parts of the blocks, on as many threads as are allowed; the parts do not change a bit.

    Where one part fails, or the user interrupts the run, the others stop between two calls of the kernel.
    """
    workers = min(blocks, threads or blocks * steps // SHARE)
    if threads is None and workers > 1:
        workers = min(workers, available_threads())
    if workers <= 1:
        advance(slice(0, blocks), NEVER)
        return
    stopped = Event()
    with ThreadPoolExecutor(workers) as pool:
        done = [pool.submit(advance, part, stopped) for part in _parts(blocks, workers)]
        try:
            for part in as_completed(done):
                part.result()
        finally:
            stopped.set()


def _parts(blocks: int, workers: int) -> list[slice]:
    """Return blocks for one worker after the other to take: smaller ones as they end, so that none idles long."""
    edges = [0]
    while edges[-1] < blocks:
        edges.append(edges[-1] + max((blocks - edges[-1]) // (2 * workers), 1))
    return [slice(*ends) for ends in pairwise(edges)]


def available_threads() -> int:
    """Return the threads this process may use: NUMBA_NUM_THREADS where set, else its processors."""
    stated = os.environ.get("NUMBA_NUM_THREADS")
    if stated and stated.isdigit() and int(stated) > 0:
        return int(stated)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
