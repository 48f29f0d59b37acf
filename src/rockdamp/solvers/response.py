"""Results of the batched solver, a type for each thing that it can be asked for, and the histories to compare with.

`Batch` lays the lanes out as the kernel wants them, and reads back what these results hold.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Required, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rockdamp.arguments import MOST_ELEMENTS, real, whole_numbers
from rockdamp.arrays import Array, ByValue, Quantity
from rockdamp.errors import InputError, require
from rockdamp.solvers import newmark_kernel as kernel

COMPLETED, COLLAPSED = 0, 1


class Options(TypedDict, total=False):
    """The arguments of `newmark.solve` that have no bearing on the type of what it returns."""

    step: Required[ArrayLike]
    steps: Required[int]
    release_amplitude: ArrayLike
    release_velocity: ArrayLike
    load_factor: ArrayLike
    ground_acceleration: ArrayLike
    substeps: int
    scheme: str
    threads: int | None


@dataclass(frozen=True, eq=False, init=False)
class Reference(ByValue):
    """Histories that Eq. (17) compares with, while the kernel runs, so that no other history is stored.

    Parameters
    ----------
    displacement : ndarray, shape (cases, steps + 1)
        u/u_ins at each step of the solver. [-]
    case : ndarray of int, broadcasts to the lanes
        Which row each lane is compared with.
    checkpoints : sequence of int, ascending
        Steps up to which the error is summed.

    Raises
    ------
    InputError
        If the histories are no numbers, or cases or checkpoints not whole.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> run = {"release_amplitude": 0.5, "step": 0.0025, "steps": 3200}
    >>> decay = rd.solve(curve, rd.Damping.cr(0.85), store_every=1, **run)
    >>> reference = rd.Reference(decay.displacement[None], case=0, checkpoints=[3200])
    >>> error = rd.solve(curve, rd.Damping("CDR", [0.03, 0.045, 0.06]), reference=reference, **run).error
    >>> error.argmin().item()
    1
    """

    displacement: Array
    case: NDArray[np.int64]
    checkpoints: NDArray[np.int64]

    def __init__(self, displacement: ArrayLike, case: ArrayLike, checkpoints: ArrayLike) -> None:
        histories = real("the reference's displacement", displacement)
        rows, marks = whole_numbers("case", case), whole_numbers("checkpoints", checkpoints)
        for name, value in (("displacement", histories), ("case", rows), ("checkpoints", marks)):
            object.__setattr__(self, name, value)


@dataclass(frozen=True, eq=False)
class Response(ByValue):
    """Ends of a batch of time histories; `shape` is what the inputs broadcast to.

    Attributes
    ----------
    outcome : ndarray of int, shape
        0 where the run was completed, 1 where the wall collapsed: `|u|` went beyond u3 and the run ended. [-]
    outcome_tau : ndarray, shape
        Dimensionless time of the end: of the last step, or of the step that collapsed. [-]
    peak, peak_tau : ndarray, shape
        Largest |u|/u_ins at the steps, and its time. [-]
    impacts : ndarray of int, shape
        Crossings of u = 0, whatever the damper. [-]

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> response = rd.solve(curve, rd.Damping.cr(0.8), release_amplitude=0.5, step=0.0025, steps=4000)
    >>> response.outcome.item(), response.peak.item()
    (0, 0.5)
    """

    outcome: NDArray[np.int8]
    outcome_tau: Array
    peak: Array
    peak_tau: Array
    impacts: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Histories(Response):
    """A response with its time histories, from `solve` with `store_every`.

    Attributes
    ----------
    displacement, velocity : ndarray, shape (..., stored)
        u/u_ins and its derivative by tau, the start included; NaN after a collapse. [-]

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> run = {"release_amplitude": 0.5, "step": 0.0025, "steps": 4000}
    >>> rd.solve(curve, rd.Damping.cr([0.8, 0.9]), store_every=100, **run).velocity.shape
    (2, 41)
    """

    displacement: Array
    velocity: Array


@dataclass(frozen=True, eq=False)
class Comparison(Response):
    """A response compared with a `Reference`, from `solve` with `reference`.

    Attributes
    ----------
    error : ndarray, shape (checkpoints, ...)
        Err of Eq. (17) at each checkpoint k: over the steps 1 to k, the sum of the squared differences between
        |u|/u_ins and the reference's; infinite where the response collapsed. [-]

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> rest = rd.Reference(displacement=[[0.0] * 401], case=0, checkpoints=[200, 400])
    >>> run = {"release_amplitude": 0.5, "step": 0.0025, "steps": 400}
    >>> rd.solve(curve, rd.Damping.cr([0.8, 0.9, 1.0]), reference=rest, **run).error.shape
    (2, 3)
    """

    error: Array


@dataclass(frozen=True, eq=False)
class ComparedHistories(Histories, Comparison):
    """A response with its time histories and compared with a `Reference`: what `Histories` and `Comparison` hold.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> rest = rd.Reference(displacement=[[0.0] * 401], case=0, checkpoints=[400])
    >>> run = {"release_amplitude": 0.5, "step": 0.0025, "steps": 400}
    >>> response = rd.solve(curve, rd.Damping.cr(0.8), store_every=1, reference=rest, **run)
    >>> bool(np.isclose(response.error[0], (response.displacement[1:] ** 2).sum()))
    True
    """


@dataclass(frozen=True, eq=False)
class Peaks(ByValue):
    """How a batch of time histories ended, and how far they came, from `solve` with `peaks_only`.

    Attributes
    ----------
    outcome : ndarray of int, shape
        0 where the run was completed, 1 where the wall collapsed. [-]
    peak : ndarray, shape
        Largest `|u|`/u_ins at the steps, as a `Response` has it; of a wall that collapsed u3/u_ins, where it did. [-]

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> run = {"release_velocity": [0.2, 1.5], "step": 0.0025, "steps": 4000}
    >>> peaks = rd.solve(curve, rd.Damping.cr(0.8), peaks_only=True, **run)
    >>> peaks.outcome.tolist(), peaks.peak.round(3).tolist()
    ([0, 1], [0.044, 1.0])
    """

    outcome: NDArray[np.int8]
    peak: Array


@dataclass(frozen=True, eq=False)
class ComparedPeaks(Peaks):
    """Peaks compared with a `Reference`, from `solve` with `peaks_only` and `reference`.

    Attributes
    ----------
    error : ndarray, shape (checkpoints, ...)
        As of a `Comparison`.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
    >>> rest = rd.Reference(displacement=[[0.0] * 401], case=0, checkpoints=[200, 400])
    >>> run = {"release_amplitude": 0.5, "step": 0.0025, "steps": 400}
    >>> compared = rd.solve(curve, rd.Damping.cr(0.8), reference=rest, peaks_only=True, **run)
    >>> bool((compared.error == rd.solve(curve, rd.Damping.cr(0.8), reference=rest, **run).error).all())
    True
    """

    error: Array


# By whether histories are stored, and whether there is a reference.
RESPONSES: dict[tuple[bool, bool], type[Response]] = {
    (False, False): Response,
    (True, False): Histories,
    (False, True): Comparison,
    (True, True): ComparedHistories,
}


# --- lanes as the kernel wants them -----------------------------------------------------------------------------------

CACHE_LINE = 8  # doubles
OBSERVED = (kernel.ALIVE, kernel.END, kernel.PEAK, kernel.PEAK_AT, kernel.CROSSINGS)
# As a short history alone takes no longer than what prepares it, nothing is made anew that nothing is written to.
NO_HISTORIES = np.empty((0, 0, 0))
NO_FACTORS = np.empty((1, 0, 0))
NO_COMPARISON = (np.empty((0, 0)), np.empty((0, 0), dtype=np.int64), np.zeros(1, dtype=np.int64), NO_HISTORIES)


class Batch:
    """A batch of lanes of some shape, in the kernel's blocks; copies of the last lane fill up the last block.

    The blocks are as narrow as they can be with so many of them, as an idle lane costs as much as a busy one. Few lanes
    stand in a block each if they are `apart`.
    """

    def __init__(self, shape: tuple[int, ...], apart: bool = False) -> None:
        self.shape = shape
        self.lanes = math.prod(shape)
        least = max(-(-self.lanes // kernel.LANES), 1)
        self.width = kernel.WIDTHS[bisect_left(kernel.WIDTHS, -(-self.lanes // least))]
        if apart and self.width < kernel.VECTOR:
            self.width = 1
        self.blocks = -(-self.lanes // self.width)

    def require_room(self, stored: int, checkpoints: int) -> None:
        """Raise `InputError` where the lanes, with what is stored of each, are more than an array may hold."""
        each = max(stored, checkpoints)
        if max(self.lanes, 1) * max(kernel.ROWS, each) > MOST_ELEMENTS:
            raise InputError(
                f"the batch has {self.lanes:,} lanes, of each of which {each:,} values are stored; there must be at"
                f" most {MOST_ELEMENTS:,} values, and {MOST_ELEMENTS // kernel.ROWS:,} lanes"
            )

    def plain(self, *values: Quantity) -> tuple[Quantity, ...]:
        """Return numbers for arrays where there is one lane, as Python computes faster with these."""
        if self.lanes != 1:
            return values
        return tuple([value.item() if hasattr(value, "item") else value for value in values])

    def _lay(self, rows: NDArray[Any], blocks: NDArray[Any]) -> None:
        """Lay rows of some values in the batch's shape out in blocks, shape (blocks, rows, width or more)."""
        rows = rows.reshape(len(rows), self.lanes)
        full, rest = divmod(self.lanes, self.width)
        within = rows[:, : full * self.width].reshape(len(rows), full, self.width)
        blocks[:full, :, : self.width] = within.swapaxes(0, 1)
        if rest:
            blocks[full, :, :rest] = rows[:, full * self.width :]
            blocks[full, :, rest : self.width] = rows[:, -1:]

    def pack(self, rows: Sequence[Quantity]) -> Array:
        """Lay the first rows out as the kernel wants them, shape (blocks, ROWS * LANES); the others are zero."""
        if self.lanes == 1:
            block = np.zeros((1, kernel.ROWS * kernel.LANES))
            block[0, : len(rows) * kernel.LANES : kernel.LANES] = rows
            return block
        laid = np.zeros((kernel.ROWS, *self.shape))
        for row, value in enumerate(rows):
            laid[row] = value
        blocks = _aligned_zeros(self.blocks * kernel.ROWS * kernel.LANES)
        self._lay(laid, blocks.reshape(self.blocks, kernel.ROWS, kernel.LANES))
        return blocks.reshape(self.blocks, kernel.ROWS * kernel.LANES)

    def unpack(self, work: Array, rows: Sequence[int]) -> list[Array]:
        """Return some rows that follow on each other, each in the batch's shape."""
        first, count = rows[0] // kernel.LANES, len(rows)
        blocks = work.reshape(self.blocks, kernel.ROWS, kernel.LANES)[:, first : first + count, : self.width]
        flat = blocks.swapaxes(0, 1).reshape(count, self.blocks * self.width)
        return [row[: self.lanes].reshape(self.shape) for row in flat]

    def by_motion(self, factors: Array) -> Array:
        """Return the lanes' factors on each of several motions, shape (blocks, motions, width)."""
        if len(factors) == 1:
            return NO_FACTORS if self.blocks == 1 else np.empty((self.blocks, 0, 0))
        each = np.empty((len(factors), *self.shape))
        for motion, factor in enumerate(factors):
            each[motion] = factor
        blocks = np.empty((self.blocks, len(factors), self.width))
        self._lay(each, blocks)
        return blocks

    def ended(self, work: Array, step: Array) -> dict[str, NDArray[Any]]:
        """Return what `Response` holds: how each lane ended, and its peak."""
        if self.lanes == 1:
            alive, end, peak, peak_at, crossings = work[0, OBSERVED[0] : OBSERVED[-1] + 1 : kernel.LANES].tolist()
            shape = self.shape
            return {
                "outcome": np.array(alive == 0.0, np.int8).reshape(shape),
                "outcome_tau": np.array(end * step).reshape(shape),
                "peak": np.array(peak).reshape(shape),
                "peak_tau": np.array(peak_at * step).reshape(shape),
                "impacts": np.array(crossings, np.int64).reshape(shape),
            }
        alive, end, peak, peak_at, crossings = self.unpack(work, OBSERVED)
        return {
            "outcome": (alive == 0.0).astype(np.int8),
            "outcome_tau": end * step,
            "peak": peak.copy(),  # a view would keep the whole batch in memory
            "peak_tau": peak_at * step,
            "impacts": crossings.astype(np.int64),
        }

    def compare(
        self, reference: Reference | None, steps: int
    ) -> tuple[Array, NDArray[np.int64], NDArray[np.int64], Array]:
        """Return displacements to compare with, the row of each lane in them, the checkpoints and room for the sums."""
        if reference is None:
            return NO_COMPARISON
        case_of_lane = np.zeros((self.blocks, 1, self.width), dtype=np.int64)
        # The kernel is compiled for arrays that can be written.
        checkpoints, compared, case = reference.checkpoints.copy(), reference.displacement, reference.case
        within = (checkpoints >= 1) & (checkpoints <= steps)
        # Here and not when it is made: it is not copied, as it may be large.
        require(np.isfinite(compared), "the reference's displacement", compared, "a finite number")
        require(compared.ndim == 2, "the number of dimensions of the reference", compared.ndim, "2, cases and steps")
        marks = checkpoints.shape
        require(len(marks) == 1 and marks[0] > 0, "the shape of checkpoints", str(marks), "(count,)")
        require(np.diff(checkpoints) > 0, "checkpoints", checkpoints[1:], "ascending")
        require(within, "checkpoints", checkpoints, f"within 1 to {steps} steps")
        if compared.shape[1] <= steps:
            raise InputError(f"the reference has {compared.shape[1] - 1} steps; it must have at least {steps}")
        require((case >= 0) & (case < compared.shape[0]), "case", case, "a row of the reference")
        self._lay(np.broadcast_to(case, self.shape)[None], case_of_lane)
        return compared, case_of_lane[:, 0], checkpoints, np.empty((self.blocks, checkpoints.size, self.width))

    def by_checkpoint(self, error: Array) -> Array:
        """Return sums, shape (blocks, checkpoints, width), in the shape (checkpoints, *shape)."""
        count = error.shape[1]
        return error.swapaxes(0, 1).reshape(count, -1)[:, : self.lanes].reshape(count, *self.shape)

    def histories(self, stored: int) -> Array:
        """Return room for `stored` values of each lane, NaN until they are reached."""
        if not stored:
            return NO_HISTORIES
        room = np.empty((self.blocks, self.width, stored))
        room.fill(np.nan)
        return room

    def trim(self, histories: Array) -> Array:
        """Return histories in the shape (*shape, stored)."""
        stored = histories.shape[-1]
        return histories.reshape(-1, stored)[: self.lanes].reshape(*self.shape, stored)


def _aligned_zeros(count: int) -> Array:
    """Return zeros that begin with a line of the processor's cache, so that no vector of a block lies in two."""
    spare = np.zeros(count + CACHE_LINE - 1)
    address: int = spare.__array_interface__["data"][0]
    start = -(address // spare.itemsize) % CACHE_LINE
    return spare[start : start + count]
