"""The batched solver: any number of walls, dampers and releases advance together.

Everything is dimensionless: displacements divided by u_ins, times tau = p t.
"""

from __future__ import annotations

from dataclasses import dataclass
from threading import Event
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.errors import InputError, check, check_choice, check_number, check_type
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers import kernel
from rockdamp.solvers.blocks import WHOLE, Blocks, steps_per_call
from rockdamp.solvers.coefficient import damping_coefficient

SCHEMES = ("newmark", "paper")


@dataclass(frozen=True, eq=False)
class Load:
    """A ground motion for the solver: one motion, or several that are added.

    Parameters
    ----------
    ground : ndarray, shape (samples,) or (motions, samples)
        Ground acceleration, linear between its samples. [m s-2]
    factor : float or ndarray
        Factor from the ground acceleration to the load, `Wall.load_factor`, which broadcasts to the
        batch. For several motions, its first axis has a factor for each. [s2 m-1]
    sampling : float or ndarray
        Time p dt between two samples, in tau; broadcasts to the batch. [-]
    substeps : int
        Steps of the solver between two samples. The default is 1.
    """

    ground: Any
    factor: Any
    sampling: Any
    substeps: int = 1

    def __post_init__(self) -> None:
        ground = check("ground acceleration", self.ground, np.isfinite, "a finite number")
        ground = np.atleast_2d(ground)
        if ground.ndim != 2 or ground.shape[0] < 1 or ground.shape[1] < 2:
            raise InputError(
                f"ground acceleration has shape {ground.shape}; it must be (motions, 2 samples or "
                "more)"
            )
        motions = len(ground)
        factor = check("load factor", self.factor, np.isfinite, "a finite number")
        if motions == 1:
            factor = factor[None]
        if factor.shape[:1] != (motions,):
            raise InputError(
                f"load factor has shape {factor.shape}; its first axis must be the {motions} "
                "motions"
            )
        sampling = check("sampling", self.sampling, lambda h: h > 0, "greater than 0")
        check_number("substeps", self.substeps, *WHOLE)
        object.__setattr__(self, "ground", ground)
        object.__setattr__(self, "factor", factor)
        object.__setattr__(self, "sampling", sampling)


@dataclass(frozen=True, eq=False)
class Reference:
    """Histories to which Eq. (17) compares a run as it proceeds, without storing the run.

    Parameters
    ----------
    displacement : ndarray, shape (cases, steps + 1)
        u/u_ins at each step of the solver. [-]
    case : int or ndarray of int
        Row of the displacements to which each history is compared; broadcasts to the batch.
    checkpoints : sequence of int
        Steps up to which the error is summed, ascending.
    """

    displacement: ArrayLike
    case: ArrayLike
    checkpoints: ArrayLike


@dataclass(frozen=True, eq=False)
class Histories:
    """Time histories of a batch; `shape` is the broadcast shape of its inputs.

    Attributes
    ----------
    displacement, velocity : ndarray, shape (..., stored)
        u/u_ins and its derivative with respect to tau, from the start; NaN after a collapse. [-]
    peak, peak_tau : ndarray, shape
        Largest |u|/u_ins at the steps of the solver, and its time. [-]
    impacts : ndarray of int, shape
        Number of crossings of u = 0, with any damper.
    collapsed : ndarray of bool, shape
        Whether |u| exceeded u3, where the run ends.
    end_tau : ndarray, shape
        Time of the last step, or of the step that collapsed. [-]
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
    """Peaks and collapses of a batch of time histories.

    Attributes
    ----------
    peak : ndarray, shape
        Largest |u|/u_ins at the steps of the solver; a3 for a wall that collapsed. [-]
    collapsed : ndarray of bool, shape
        Whether |u| exceeded u3.
    error : ndarray, shape (checkpoints, ...)
        Err of Eq. (17) at each checkpoint k: the sum, over the steps 1 to k, of the squared
        differences between |u|/u_ins and that of the reference; infinite where the wall collapsed.
        None without a reference. [-]
    """

    peak: Array
    collapsed: NDArray[np.bool_]
    error: Any = None


def stable_step(curve: TrilinearCurve) -> Array:
    r"""Return the stability limit of a curve: the explicit scheme needs a shorter step in tau. [-]

    .. math:: \Delta\tau < \frac{2}{\omega_1} = 2 \sqrt{\frac{a_1}{b_1}}

    Parameters
    ----------
    curve : TrilinearCurve
        Force-displacement curves.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> rd.stable_step(curve).round(3).item()
    0.434
    """
    check_type("curve", curve, TrilinearCurve)
    return np.asarray(2.0 / curve.initial_frequency)


def default_step(curve: TrilinearCurve) -> Array:
    """Return the step of the studies in tau. [-]

    It is 0.0025, or a 60th of the stability limit where a curve is stiffer. On random walls the
    median error of a history is 2e-6 u_ins at 0.0025 (docs/accuracy.md), and 2e-5 u_ins at a 60th
    of the limit; with BAND it is ten times as large.

    Parameters
    ----------
    curve : TrilinearCurve
        Force-displacement curves.
    """
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
    r"""Integrate Eq. (16), or its undamped form with the impacts of Eq. (8), for a batch.

    .. math::
        \ddot{x} + C(x, \dot{x}) \, \dot{x} + f(x) = \gamma \, \ddot{u}_g(\tau); \qquad
        \text{CR:} \quad C = 0, \quad \dot{x}^+ = e \, \dot{x}^- \quad \text{at} \quad x = 0

    with the factor :math:`\gamma` of the load. Curve, damping, load, step and release broadcast
    together to the shape of the batch.

    Parameters
    ----------
    curve : TrilinearCurve
        Force-displacement curves of the walls.
    damping : Damping
        Damping, one model for the whole batch.
    load : Load, optional
        Ground motion. By default the walls decay freely.
    step : float or ndarray
        Step of a free decay, in tau; a load has its own. It must be below the stability limit,
        `stable_step`. The corners of the curve add energy, the more the longer the step; use
        at most a twentieth of the limit. [-]
    steps : int
        Number of steps; by default the length of the load.
    release_amplitude, release_velocity : float or ndarray
        u/u_ins, less than a3, and its derivative with respect to tau, at the start. Default: 0. [-]
    store_every : int
        Steps from one stored state to the next. The default is 1.
    scheme : {"newmark", "paper"}
        Explicit Newmark with located impacts, of second order for every damper; or the paper's
        linear acceleration without iteration, with impacts at the end of the step. The default is
        newmark.
    threads : int, optional
        Threads to use; by default all that are available to the process.

    Raises
    ------
    InputError
        If a value is out of its range, or the histories do not fit into an array.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> run = {"release_amplitude": 0.5, "step": 0.0025, "steps": 8000}
    >>> rd.simulate(curve, rd.Damping("CR", [0.8, 0.9]), store_every=100, **run).displacement.shape
    (2, 81)
    """
    problem = _check_problem(curve, damping, load, step, steps, release_amplitude, release_velocity)
    march = kernel.FULL[check_choice("scheme", scheme, SCHEMES), problem.formula]
    stride = int(check_number("store_every", store_every, *WHOLE))
    stored = problem.steps // stride + 1
    blocks = Blocks(problem.shape, stored)
    work = problem.arrange_rows(blocks)
    factors = problem.arrange_factors(blocks)
    displacement, velocity = np.full((2, blocks.count, blocks.width, stored), np.nan)

    def run(part: slice, stopped: Event) -> None:
        length = steps_per_call(part)
        motion = problem.ground, factors[part], problem.substeps
        states = displacement[part], velocity[part]
        for first in range(1, problem.steps + 1, length):
            if stopped.is_set():
                return
            last = min(first + length - 1, problem.steps)
            march(work[part], blocks.width, *motion, first, last, stride, *states)

    blocks.run_in_threads(run, problem.steps, threads)

    def row(place: int) -> Array:
        return blocks.batch(work[:, place : place + blocks.width])

    return Histories(
        blocks.batch(displacement),
        blocks.batch(velocity),
        peak=row(kernel.PEAK),
        peak_tau=row(kernel.PEAK_STEP) * problem.step,
        impacts=row(kernel.CROSSINGS).astype(np.int64),
        collapsed=row(kernel.ALIVE) == 0,
        end_tau=row(kernel.END) * problem.step,
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
    """Return only the peaks and collapses of `simulate`, and Err of Eq. (17) against a reference.

    It is faster, because each run ends once its peak is known.

    Parameters
    ----------
    curve : TrilinearCurve
        Force-displacement curves of the walls.
    damping : Damping
        Damping, one model for the whole batch.
    load : Load, optional
        Ground motion. By default the walls decay freely.
    step : float or ndarray
        Step of a free decay, in tau; a load has its own. It must be below the stability limit,
        `stable_step`. [-]
    steps : int
        Number of steps; by default the length of the load.
    release_amplitude, release_velocity : float or ndarray
        u/u_ins, less than a3, and its derivative with respect to tau, at the start. Default: 0. [-]
    reference : Reference, optional
        Histories to compare with. By default `error` is None.
    scheme : {"newmark", "paper"}
        The scheme, as described for `simulate`.
    threads : int, optional
        Threads to use; by default all that are available to the process.

    Raises
    ------
    InputError
        If a value is out of its range, or the batch does not fit into an array.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> run = {"release_velocity": [0.2, 1.5], "step": 0.0025, "steps": 4000}
    >>> result = rd.peaks(curve, rd.Damping("CR", 0.8), **run)
    >>> result.collapsed.tolist(), result.peak.round(3).tolist()
    ([False, True], [0.044, 1.0])
    """
    problem = _check_problem(
        curve, damping, load, step, steps, release_amplitude, release_velocity, reference
    )
    march = kernel.PEAKS[check_choice("scheme", scheme, SCHEMES), problem.formula]
    checkpoints = problem.checkpoints
    blocks = Blocks(problem.shape, checkpoints.size)
    work = problem.arrange_rows(blocks)
    lane_numbers = np.arange(blocks.count * blocks.width).reshape(-1, blocks.width)
    work[:, kernel.LANE : kernel.LANE + blocks.width] = lane_numbers
    factors = problem.arrange_factors(blocks)
    case = blocks.arrange([problem.case], blocks.width)[:, 0].astype(np.int64)
    outcome = np.empty(blocks.lanes, np.int8)
    peak = np.empty(blocks.lanes)
    error = np.empty((checkpoints.size, blocks.lanes if reference else 0))
    remaining = _remaining_integral(problem.ground)

    def run(part: slice, stopped: Event) -> None:
        length = steps_per_call(part, kernel.INTERVAL)
        comparison = problem.reference, case[part], checkpoints, error
        motion = problem.ground, remaining, factors[part], problem.substeps
        running = min(part.stop * blocks.width, blocks.lanes) - part.start * blocks.width
        first = 1
        while first <= problem.steps and running > 0 and not stopped.is_set():
            last = min(first + length - 1, problem.steps)
            span = first, last, problem.steps
            lanes = work[part], blocks.width, running
            running = march(*lanes, *motion, *span, comparison, (outcome, peak))
            first = last + 1

    blocks.run_in_threads(run, problem.steps, threads)
    largest = peak.reshape(problem.shape)
    collapsed = outcome.reshape(problem.shape) == kernel.COLLAPSED
    if reference is None:
        return Peaks(largest, collapsed)
    error = error.reshape(checkpoints.size, *problem.shape)
    return Peaks(largest, collapsed, np.where(collapsed, np.inf, error))


def _remaining_integral(ground: Array) -> Array:
    """Return the integral of |motion| from each sample to the end, with samples as unit of time."""
    if not ground.size:
        return np.zeros((1, 1))
    size = np.abs(ground)
    between_samples = (size[:, 1:] + size[:, :-1]) / 2
    integral = np.cumsum(between_samples[:, ::-1], axis=1)[:, ::-1]
    return np.pad(integral, ((0, 0), (0, 1)))


# --- the checked problem --------------------------------------------------------------------------


class _Problem(NamedTuple):
    """A checked run of a batch; the values of its lanes broadcast to `shape`."""

    shape: tuple[int, ...]
    curve: TrilinearCurve
    formula: str  # name of the damper in the kernel
    parameters: tuple[Any, Any, Any]  # parameters of the damper in the kernel
    start: tuple[Array, Array, Array]  # displacement, velocity and acceleration
    step: Array
    steps: int
    ground: Array  # shape (motions, samples); without samples in a free decay
    substeps: int
    factors: Array  # shape (motions, ...)
    load: Any  # factor on one motion, or the load of several at the start
    reference: Array  # shape (cases, samples); without cases where nothing is compared
    case: Array
    checkpoints: NDArray[np.int64]

    def arrange_rows(self, blocks: Blocks) -> Array:
        """Return the rows of the kernel in blocks."""
        x, v, a = self.start
        alive = 1.0
        # In the order of the kernel's rows: X to ERROR, K1 to A3, H to G_START, P0 to P2.
        state = (x, v, a, alive, 0.0, np.abs(x), 0.0, 0.0, 0.0)
        loads = (self.step, self.load, self.load)
        rows = (*state, *self.curve.parameters(), *loads, *self.parameters)
        arranged = blocks.arrange(rows, kernel.LANES)
        return arranged.reshape(blocks.count, kernel.ROWS * kernel.LANES)

    def arrange_factors(self, blocks: Blocks) -> Array:
        """Return the factors on several motions in blocks."""
        if len(self.factors) == 1:
            return np.empty((blocks.count, 0, 0))
        return blocks.arrange(self.factors, blocks.width)


def _check_problem(
    curve: TrilinearCurve,
    damping: Damping,
    load: Load | None,
    step: ArrayLike | None,
    steps: int | None,
    release_amplitude: ArrayLike,
    release_velocity: ArrayLike,
    reference: Reference | None = None,
) -> _Problem:
    check_type("curve", curve, TrilinearCurve)
    check_type("damping", damping, Damping)
    step, steps = _check_steps(load, step, steps)
    a3 = curve.ultimate_displacement_ratio
    x = check("release_amplitude", release_amplitude, lambda x: np.abs(x) < a3, "less than a3")
    v = check("release_velocity", release_velocity, np.isfinite, "a finite number")
    step = _check_step(step, curve, damping)
    formula, parameters = damping.kernel_arguments(curve)
    ground = np.empty((1, 0))
    substeps = 1
    factors = np.zeros(1)
    start_load: Any = 0.0
    if load is not None:
        ground = load.ground
        substeps = int(load.substeps)
        factors = load.factor
        start_load = np.einsum("m...,m->...", factors, ground[:, 0])
    drag = damping_coefficient(curve, damping, x, v) * v if v.any() else 0.0
    restoring = np.sign(x) * kernel.force(np.abs(x), curve.parameters())
    a = check(
        "acceleration at the start",
        start_load - restoring - drag,
        np.isfinite,
        "a finite number",
    )
    row_load = factors[0] if len(factors) == 1 else start_load
    displacements, case, checkpoints = _check_reference(reference, steps)
    lanes = (step, x, v, curve, damping, factors[0], case)
    return _Problem(
        np.broadcast_shapes(*(values.shape for values in lanes)),
        curve,
        formula,
        parameters,
        (x, v, a),
        step,
        steps,
        ground,
        substeps,
        factors,
        row_load,
        displacements,
        case,
        checkpoints,
    )


def _check_steps(
    load: Load | None, step: ArrayLike | None, steps: int | None
) -> tuple[ArrayLike, int]:
    """Return step and number of steps; a load has its own step, and at most so many steps."""
    limit = 10**9  # minutes for each block of lanes
    if load is not None:
        check_type("load", load, Load)
        step = load.sampling / load.substeps
        limit = int(load.substeps) * (load.ground.shape[1] - 1)
        steps = limit if steps is None else steps
    if step is None or steps is None:
        raise InputError(f"step is {step!r} and steps is {steps!r}; a free decay must have both")
    checked = check_number(
        "steps",
        steps,
        lambda n: (n >= 1) & (n <= limit) & (n == np.floor(n)),
        f"a whole number from 1 to {limit}",
    )
    return step, int(checked)


def _check_step(step: ArrayLike, curve: TrilinearCurve, damping: Damping) -> Array:
    limit = stable_step(curve)
    smallest = np.min(limit, initial=np.inf)
    allowed = f"below the stability limit 2 sqrt(a1/b1) = {smallest:.6g} in tau, and positive"
    # The printed scheme divides by the square of the step.
    checked = check("step", step, lambda h: (h >= 1e-12) & (h < limit), allowed)
    damping.damper.check_step(checked, damping, curve)
    return checked


def _check_reference(
    reference: Reference | None, steps: int
) -> tuple[Array, Array, NDArray[np.int64]]:
    """Return displacements to compare with, the row of them for each lane, and checkpoints."""
    if reference is None:
        return np.empty((0, 0)), np.zeros(()), np.zeros(1, np.int64)
    check_type("reference", reference, Reference)
    finite = "a finite number"
    checked = check("reference", reference.displacement, np.isfinite, finite)
    displacements = np.ascontiguousarray(checked)
    if displacements.ndim != 2 or displacements.shape[1] <= steps:
        raise InputError(
            f"reference has shape {displacements.shape}; it must be (cases, more than {steps} "
            "steps)"
        )
    rows = len(displacements)
    case = check("case", reference.case, lambda c: (c >= 0) & (c < rows), "a row of the reference")
    checkpoints = np.array(reference.checkpoints, np.int64)
    spaces = np.diff([0, *checkpoints, steps + 1])
    allowed = f"positive, from 1 to {steps} steps"
    check("the space between checkpoints", spaces, lambda n: n > 0, allowed)
    return displacements, case, checkpoints


# --- walls with an uneven force -------------------------------------------------------------------


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
    """Return which lanes of x'' + (1 + lift vertical) f(x) = load ground collapse, from rest.

    Each impact multiplies the velocity by e. The force need not be odd, and may change with time.
    Everything but the motions broadcasts to the shape of the result.

    Parameters
    ----------
    curve : TrilinearCurve
        Force-displacement curves of the walls.
    restitution : float or ndarray
        Coefficient of restitution e. [-]
    step : float or ndarray
        Step in tau. [-]
    substeps : int or ndarray of int
        Steps between two samples of the motions.
    load : float or ndarray
        Load factor on the horizontal motion. [s2 m-1]
    ground : ndarray, shape (samples,)
        Horizontal acceleration. [m s-2]
    lift : float or ndarray
        Factor on the vertical motion; the weights never fall below zero. [s2 m-1]
    vertical : ndarray, shape (samples,), optional
        Vertical acceleration. The default is none. [m s-2]
    side : pair of float or ndarray
        Scale factors of the curve for u > 0 and u < 0, in force and displacement alike. [-]
    """
    vertical = np.zeros_like(ground) if vertical is None else vertical
    if vertical.shape != ground.shape:
        raise InputError(
            f"vertical has {vertical.size} samples; it must have those of the ground motion, "
            f"{ground.size}"
        )
    parameters = (*curve.parameters(), restitution, step, substeps, load, lift, *side)
    columns = np.broadcast_arrays(*parameters)
    flat_columns = [np.ravel(np.asarray(column, dtype=float)) for column in columns]
    lanes = np.stack(flat_columns, axis=-1)
    collapsed = np.empty(len(lanes), dtype=bool)
    # Writable copies: the kernel is compiled for these.
    kernel.uneven_march(lanes, np.array(ground), np.array(vertical), collapsed)
    return collapsed.reshape(columns[0].shape)
