"""Results of the batched solver, a type for each thing that it can be asked for, and the histories to compare with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Required, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rockdamp.arguments import real, whole_numbers
from rockdamp.arrays import Array, ByValue

COMPLETED, COLLAPSED = 0, 1
OUTCOMES = ("completed", "collapsed")


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
