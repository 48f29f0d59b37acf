"""The batched solver: any number of walls, dampers and releases advance together through the compiled kernel.

Everything is dimensionless: displacements over u_ins, times tau = p t.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from threading import Event
from typing import Any

import numpy as np
from numba import config
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.errors import InputError, Rule, check, check_choice, check_number, check_type
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers import kernel
from rockdamp.solvers.coefficient import damping_coefficient

SCHEMES = ("newmark", "paper")
WHOLE: Rule = (lambda n: (n >= 1) & (n == np.floor(n)), "a whole number, at least 1")
MOST_VALUES = 2**28  # of one array
STEPS_PER_CALL = (
    2**18
)  # of a block, in one call of the kernel: a fraction of a second, so that Ctrl-C is noticed


@dataclass(frozen=True, eq=False)
class Load:
    """A ground motion as the solver takes it: one motion, or several that add up.

    Parameters
    ----------
    ground : ndarray, shape (samples,) or (motions, samples)
        Acceleration, linear between its samples. [m s-2]
    factor : float or ndarray
        What makes it the load, `Wall.load_factor`; broadcasts to the batch. Of several motions they are its first
        axis. [s2 m-1]
    sampling : float or ndarray
        p dt, the time between two samples in tau; broadcasts to the batch. [-]
    substeps : int
        Steps of the solver between two samples.
    """

    ground: Any
    factor: Any
    sampling: Any
    substeps: int = 1

    def __post_init__(self) -> None:
        ground = check("ground acceleration", self.ground, np.isfinite, "a finite number")
        ground = ground[None] if ground.ndim == 1 else ground
        if ground.ndim != 2 or ground.shape[0] < 1 or ground.shape[1] < 2:
            raise InputError(
                f"ground acceleration has shape {ground.shape}; it must be (motions, 2 samples or more)"
            )
        factor = check("load factor", self.factor, np.isfinite, "a finite number")
        factor = factor[None] if len(ground) == 1 else factor
        if factor.shape[:1] != ground.shape[:1]:
            raise InputError(
                f"load factor has shape {factor.shape}; its first axis must be the {len(ground)} motions"
            )
        check_number("substeps", self.substeps, *WHOLE)
        object.__setattr__(self, "ground", ground)
        object.__setattr__(self, "factor", factor)
        object.__setattr__(
            self, "sampling", check("sampling", self.sampling, lambda h: h > 0, "greater than 0")
        )


@dataclass(frozen=True, eq=False)
class Reference:
    """Histories that Eq. (17) compares with while the kernel runs, so that no other history is stored.

    Parameters
    ----------
    displacement : ndarray, shape (cases, steps + 1)
        u/u_ins at each step of the solver. [-]
    case : int or ndarray of int, broadcasts to the batch
        The row that each lane is compared with.
    checkpoints : sequence of int, ascending
        Steps up to which the error is summed.
    """

    displacement: ArrayLike
    case: ArrayLike
    checkpoints: ArrayLike


@dataclass(frozen=True, eq=False)
class Histories:
    """Time histories of a batch; `shape` is what the inputs broadcast to.

    Attributes
    ----------
    displacement, velocity : ndarray, shape (..., stored)
        u/u_ins and its derivative by tau, the start included; NaN after a collapse. [-]
    peak, peak_tau : ndarray, shape
        Largest |u|/u_ins at the steps of the solver, and its time. [-]
    impacts : ndarray of int, shape
        Crossings of u = 0, whatever the damper. [-]
    collapsed : ndarray of bool, shape
        Whether |u| went beyond u3, where the run ends.
    end_tau : ndarray, shape
        Time of the last step, or of the one that collapsed. [-]
    """

    displacement: Array
    velocity: Array
    peak: Array
    peak_tau: Array
    impacts: NDArray[np.int64]
    collapsed: NDArray[np.bool_]
    end_tau: Array


@dataclass(frozen=True, eq=False)
class Peaks:
    """How far a batch of time histories came, and which of them collapsed.

    Attributes
    ----------
    peak : ndarray, shape
        Largest |u|/u_ins at the steps of the solver; a3 of a wall that collapsed. [-]
    collapsed : ndarray of bool, shape
    error : ndarray, shape (checkpoints, ...)
        Err of Eq. (17) at each checkpoint k: over the steps 1 to k, the sum of the squared differences between
        |u|/u_ins and the reference's; infinite where the wall collapsed. None without a reference. [-]
    """

    peak: Array
    collapsed: NDArray[np.bool_]
    error: Any = None


def stable_step(curve: TrilinearCurve) -> Array:
    r"""Return the stability limit of the `curve`, the step in tau that the explicit scheme must stay below. [-]

    .. math:: \Delta\tau < \frac{2}{\omega_1} = 2 \sqrt{\frac{a_1}{b_1}}

    Examples
    --------
    >>> import rockdamp as rd
    >>> rd.stable_step(rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)).round(
    ...     3
    ... ).item()
    0.434
    """
    check_type("curve", curve, TrilinearCurve)
    return np.asarray(2.0 / curve.initial_frequency)


def default_step(curve: TrilinearCurve) -> Array:
    """Return the step of the studies, 0.0025 in tau, or a 60th of the stability limit where a curve is stiffer. [-]"""
    return np.minimum(0.0025, 1 / 60 * 2 / curve.initial_frequency)


def simulate(
    curve: TrilinearCurve,
    damping: Damping,
    *,
    load: Load | None = None,
    step: ArrayLike | None = None,
    steps: int | None = None,
    release_amplitude: ArrayLike = 0.0,
    release_velocity: ArrayLike = 0.0,
    store_every: int = 1,
    scheme: str = "newmark",
    threads: int | None = None,
) -> Histories:
    r"""Integrate Eq. (16), or its undamped form with the impacts of Eq. (8), for every lane of a batch.

    .. math::
        \ddot{x} + C(x, \dot{x}) \, \dot{x} + f(x) = \gamma \, \ddot{u}_g(\tau); \qquad
        \text{CR:} \quad C = 0, \quad \dot{x}^+ = e \, \dot{x}^- \quad \text{at} \quad x = 0

    with the load's factor :math:`\gamma`. Curve, damping, load, step and release broadcast together to the batch.

    Parameters
    ----------
    curve, damping : TrilinearCurve, Damping
        One model for the whole batch.
    load : Load, optional
        None for a free decay.
    step : float or ndarray
        Of a free decay, in tau; a load has its own. Below the stability limit; without damping the corners of the curve
        feed energy in from a fifth of the limit on, so keep to a twentieth of it. [-]
    steps : int
        Number of steps; by default the load's length.
    release_amplitude, release_velocity : float or ndarray
        u/u_ins, less than a3, and its derivative by tau, at the start. [-]
    store_every : int
        Steps from one stored state to the next.
    scheme : {"newmark", "paper"}
        Explicit Newmark with located impacts, second order for every damper; or the paper's linear acceleration
        without iteration, with impacts at the end of the step.
    threads : int, optional
        By default those that the process may use.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> run = {"release_amplitude": 0.5, "step": 0.0025, "steps": 8000}
    >>> rd.simulate(curve, rd.Damping("CR", [0.8, 0.9]), store_every=100, **run).displacement.shape
    (2, 81)
    """
    batch = _Batch(curve, damping, load, step, steps, release_amplitude, release_velocity)
    every = int(check_number("store_every", store_every, *WHOLE))
    stored = batch.steps // every + 1
    batch.require_room(stored)
    displacement, velocity = np.full((2, batch.blocks, batch.width, stored), np.nan)
    march = batch.march("full", scheme)

    def run(part: slice, stopped: Event) -> None:
        blocks = batch.work[part], batch.width, batch.ground, batch.factors[part], batch.substeps
        length = max(STEPS_PER_CALL // max(part.stop - part.start, 1), 1)
        for first in range(1, batch.steps + 1, length):
            if stopped.is_set():
                return
            last = min(first + length - 1, batch.steps)
            march(*blocks, first, last, every, displacement[part], velocity[part])

    batch.in_threads(run, threads)
    displacement, velocity = (
        values.reshape(-1, stored)[: batch.lanes].reshape(*batch.shape, stored)
        for values in (displacement, velocity)
    )
    return Histories(
        displacement,
        velocity,
        peak=batch.row(kernel.PEAK),
        peak_tau=batch.row(kernel.PEAK_AT) * batch.step,
        impacts=batch.row(kernel.CROSSINGS).astype(np.int64),
        collapsed=batch.row(kernel.ALIVE) == 0,
        end_tau=batch.row(kernel.END) * batch.step,
    )


def peaks(
    curve: TrilinearCurve,
    damping: Damping,
    *,
    load: Load | None = None,
    step: ArrayLike | None = None,
    steps: int | None = None,
    release_amplitude: ArrayLike = 0.0,
    release_velocity: ArrayLike = 0.0,
    reference: Reference | None = None,
    scheme: str = "newmark",
    threads: int | None = None,
) -> Peaks:
    """Return peaks and collapses alone, the same as `simulate` finds, and Err of Eq. (17) against a reference.

    It is faster, as a history ends once its peak is sure. The parameters are those of `simulate`.

    Parameters
    ----------
    reference : Reference, optional

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> run = {"release_velocity": [0.2, 1.5], "step": 0.0025, "steps": 4000}
    >>> found = rd.peaks(curve, rd.Damping("CR", 0.8), **run)
    >>> found.collapsed.tolist(), found.peak.round(3).tolist()
    ([False, True], [0.044, 1.0])
    """
    batch = _Batch(
        curve, damping, load, step, steps, release_amplitude, release_velocity, reference
    )
    batch.require_room(batch.checkpoints.size)
    lanes = np.arange(batch.blocks * batch.width).reshape(-1, batch.width)
    batch.work[:, kernel.LANE : kernel.LANE + batch.width] = lanes
    outcome, peak = np.empty(batch.lanes, np.int8), np.empty(batch.lanes)
    error = np.empty((batch.checkpoints.size, batch.lanes if reference else 0))
    remaining = _remaining(batch.ground)
    march = batch.march("peaks", scheme)

    def run(part: slice, stopped: Event) -> None:
        blocks, factors, case = batch.work[part], batch.factors[part], batch.case[part]
        comparison = batch.reference, case, batch.checkpoints, error
        length = (
            max(STEPS_PER_CALL // max(part.stop - part.start, 1) // kernel.INTERVAL, 1)
            * kernel.INTERVAL
        )
        running, first = min(part.stop * batch.width, batch.lanes) - part.start * batch.width, 1
        while first <= batch.steps and running > 0 and not stopped.is_set():
            last = min(first + length - 1, batch.steps)
            span = batch.substeps, first, last, batch.steps
            running = march(
                blocks,
                batch.width,
                running,
                batch.ground,
                remaining,
                factors,
                *span,
                comparison,
                (outcome, peak),
            )
            first = last + 1

    batch.in_threads(run, threads)
    largest, collapsed = peak.reshape(batch.shape), outcome.reshape(batch.shape) == kernel.COLLAPSED
    if reference is None:
        return Peaks(largest, collapsed)
    return Peaks(
        largest, collapsed, np.where(collapsed, np.inf, error.reshape(len(error), *batch.shape))
    )


def _remaining(ground: Array) -> Array:
    """Return the integral of each motion's absolute value from each sample to the end, in units of time of a sample."""
    size = np.abs(ground)
    if not size.size:
        return np.zeros((1, 1))
    between = (size[:, 1:] + size[:, :-1]) / 2
    return np.pad(np.cumsum(between[:, ::-1], axis=1)[:, ::-1], ((0, 0), (0, 1)))


class _Batch:
    """The lanes of a batch in the kernel's blocks; copies of the last lane fill up the last block.

    The blocks are as narrow as they can be with so many of them, as an idle lane costs as much as a busy one.
    """

    def __init__(
        self,
        curve: TrilinearCurve,
        damping: Damping,
        load: Load | None,
        step: ArrayLike | None,
        steps: int | None,
        release_amplitude: ArrayLike,
        release_velocity: ArrayLike,
        reference: Reference | None = None,
    ) -> None:
        check_type("curve", curve, TrilinearCurve)
        check_type("damping", damping, Damping)
        if reference is not None:
            check_type("reference", reference, Reference)
        self.ground, self.substeps, factors = np.empty((1, 0)), 1, np.zeros(1)
        most = 10**9  # minutes for each block of lanes
        if load is not None:
            check_type("load", load, Load)
            self.ground, self.substeps, factors = load.ground, int(load.substeps), load.factor
            step, most = load.sampling / load.substeps, self.substeps * (self.ground.shape[1] - 1)
            steps = most if steps is None else steps
        if step is None or steps is None:
            raise InputError("a free decay needs a step and steps; a load has its own")
        whole = f"a whole number from 1 to {most}"
        self.steps = int(
            check_number(
                "steps", steps, lambda n: (n >= 1) & (n <= most) & (n == np.floor(n)), whole
            )
        )
        k1, b1, ks, a1, a2, a3 = curve.parameters()
        x = check("release_amplitude", release_amplitude, lambda x: np.abs(x) < a3, "less than a3")
        v = check("release_velocity", release_velocity, np.isfinite, "a finite number")
        self.step = _checked_step(step, curve, damping)
        self.damper, parameters = damping.kernel_arguments(curve)
        case = np.asarray(reference.case if reference else 0)
        shapes = (
            self.step.shape,
            x.shape,
            v.shape,
            curve.shape,
            damping.shape,
            factors.shape[1:],
            case.shape,
        )
        self.shape = np.broadcast_shapes(*shapes)
        self.lanes = math.prod(self.shape)
        least = -(-self.lanes // max(-(-self.lanes // kernel.LANES), 1))
        self.width = max(least, 1) if least < 4 else -(-least // kernel.VECTOR) * kernel.VECTOR
        self.blocks = -(-self.lanes // self.width)
        start = (
            np.einsum("m...,m->...", factors, self.ground[:, 0]) + 0.0 if load is not None else 0.0
        )
        restoring = np.sign(x) * kernel.force(np.abs(x), (k1, b1, ks, a1, a2, a3))
        drag = damping_coefficient(curve, damping, x, v) * v if v.any() else 0.0
        a = check(
            "acceleration at the start", start - restoring - drag, np.isfinite, "a finite number"
        )
        g = factors[0] if len(factors) == 1 else start
        number = float(kernel.DAMPERS.index(self.damper))
        state = x, v, a, 1.0, 0.0, np.abs(x), 0.0, 0.0, 0.0
        rows = (*state, k1, b1, ks, a1, a2, a3, self.step, g, g, *parameters, number)
        self.require_room(0)
        self.work = self._in_blocks(rows, kernel.LANES).reshape(
            self.blocks, kernel.ROWS * kernel.LANES
        )
        several = len(factors) > 1
        self.factors = (
            self._in_blocks(factors, self.width) if several else np.empty((self.blocks, 0, 0))
        )
        self.reference, self.checkpoints = np.empty((0, 0)), np.zeros(1, np.int64)
        self.case = np.empty((self.blocks if reference else 0, self.width), np.int64)
        if reference:
            self._compare(reference, case)

    def _compare(self, reference: Reference, case: NDArray[np.int64]) -> None:
        compared = np.ascontiguousarray(
            check("reference", reference.displacement, np.isfinite, "a finite number")
        )
        if compared.ndim != 2 or compared.shape[1] <= self.steps:
            raise InputError(
                f"reference has shape {compared.shape}; it must be (cases, more than {self.steps} steps)"
            )
        check(
            "case", case, lambda row: (row >= 0) & (row < len(compared)), "a row of the reference"
        )
        self.reference, self.checkpoints = compared, np.array(reference.checkpoints, np.int64)
        marks = np.diff([0, *self.checkpoints, self.steps + 1])
        check(
            "the space between checkpoints",
            marks,
            lambda n: n > 0,
            f"positive, from 1 to {self.steps} steps",
        )
        self.case = self._in_blocks((case,), self.width)[:, 0].astype(np.int64)

    def _in_blocks(self, rows: Sequence[Any] | Array, width: int) -> Array:
        """Return rows of values in the shape (blocks, rows, width)."""
        lane = np.minimum(np.arange(self.blocks * self.width), self.lanes - 1)
        # From a line of the processor's cache on, 8 numbers: a vector that lay in two would cost up to 8 % of the time.
        size = self.blocks * len(rows) * width
        spare = np.zeros(size + 7)
        start = -(spare.ctypes.data // spare.itemsize) % 8
        blocks = spare[start : start + size].reshape(self.blocks, len(rows), width)
        for number, row in enumerate(rows):
            values = np.broadcast_to(row, self.shape).reshape(-1)[lane]
            blocks[:, number, : self.width] = values.reshape(self.blocks, self.width)
        return blocks

    def row(self, place: int) -> Array:
        """Return a row of the kernel's blocks in the shape of the batch."""
        return (
            self.work[:, place : place + self.width].reshape(-1)[: self.lanes].reshape(self.shape)
        )

    def require_room(self, stored: int) -> None:
        """Raise `InputError` where the lanes, with what is stored of each, are more than an array may hold."""
        if self.lanes * max(stored, kernel.ROWS) > MOST_VALUES:
            raise InputError(
                f"{self.lanes} histories of {stored} values are more than {MOST_VALUES} values; run parts"
            )

    def march(self, name: str, scheme: str) -> Callable[..., Any]:
        """Return the compiled march of the damper, or of all dampers by the printed scheme."""
        damper = "paper" if check_choice("scheme", scheme, SCHEMES) == "paper" else self.damper
        march: Callable[..., Any] = getattr(kernel, f"{name}_{damper}")
        return march

    def in_threads(self, run: Callable[..., None], threads: int | None) -> None:
        """Call `run` on parts of the blocks, side by side; the parts do not change a bit.

        Where one part fails, or the user interrupts the run, the others stop between two calls of the kernel.
        """
        stopped = Event()
        # For fewer than 8 192 steps of a block a thread would cost more than it gives.
        if threads is not None:
            threads = int(check_number("threads", threads, *WHOLE))
        workers = threads or min(available_threads(), self.blocks * self.steps // 2**13)
        workers = min(workers, self.blocks)
        if workers <= 1:
            run(slice(0, self.blocks), stopped)
            return
        edges = np.linspace(0, self.blocks, min(4 * workers, self.blocks) + 1).astype(int).tolist()
        with ThreadPoolExecutor(workers) as pool:
            try:
                list(pool.map(partial(run, stopped=stopped), map(slice, edges[:-1], edges[1:])))
            finally:
                stopped.set()


def _checked_step(step: ArrayLike, curve: TrilinearCurve, damping: Damping) -> Array:
    limit = stable_step(curve)
    allowed = f"below the stability limit 2 sqrt(a1/b1) = {np.min(limit, initial=np.inf):.6g} in tau, and positive"
    # The printed scheme divides by the step's square.
    checked = check("step", step, lambda h: (h >= 1e-12) & (h < limit), allowed)
    damping.damper.check_step(checked, damping.parameters, curve)
    return checked


def available_threads() -> int:
    """Return the threads this process may use: NUMBA_NUM_THREADS where set, else its processors."""
    return int(config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]


def uneven_collapses(
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

    The force need not be odd, and may change with time. Everything but the motions broadcasts to the result's shape.

    Parameters
    ----------
    step, substeps : ndarray
        In tau, and how many there are between two samples of the motions.
    load, ground, lift, vertical : ndarray
        Factors of the lanes on the two motions, and these, shape (samples,). The weights are never less than none.
    side : two ndarrays
        What times the curve is that of u > 0, and of u < 0, in force and displacement alike.
    """
    up = np.zeros_like(ground) if vertical is None else vertical
    if up.shape != ground.shape:
        raise InputError(
            f"vertical has {up.size} samples; it must have those of the ground motion, {ground.size}"
        )
    columns = np.broadcast_arrays(
        *curve.parameters(), restitution, step, substeps, load, lift, *side
    )
    lanes = np.stack([np.ravel(np.asarray(column, dtype=float)) for column in columns], axis=-1)
    collapsed = np.empty(len(lanes), dtype=bool)
    kernel.uneven_march(lanes, np.array(ground), np.array(up), collapsed)
    return collapsed.reshape(columns[0].shape)
