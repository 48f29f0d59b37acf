"""The damping ratio that follows a decay under restitution best: the least Err, Eq. (17), and the protocol around it.

Every damping ratio of least Err that is published comes from `match_dampers`. It finds the global minimum of Err
against decays at the solver's step. What is published is the minimum next to it of the integral that Err tends to,
followed to finer steps in the reference and in the model.

Err samples |u|, which has a kink wherever u crosses zero, and the corners of the curve fall anywhere in a step of the
solver. When the damping ratio changes, kinks and corners move across the steps: that puts a ripple on Err, of second
order in the step and with a period of first order. So the least sample lies a *first* order of the step from the least
integral, and two steps can agree on it by chance. A cubic through many periods of the ripple has its mean alone, which
is of second order.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.dampers import DAMPERS
from rockdamp.mechanics.damping import Damping
from rockdamp.progress import track
from rockdamp.solvers.blocks import available_threads
from rockdamp.solvers.newmark import Reference, peaks, simulate, stable_step

T = TypeVar("T")
K = TypeVar("K", bound=Hashable)

SCAN = np.geomspace(0.3, 3.0, 200)  # damping ratios tried, over the closed form's
RESOLUTION = 3e-5  # of the minimiser, as a fraction of xi
REFINEMENT = 8  # steps of the last minimisation in place of each of the solver's
# Damping ratios of the integral's minimum, from the middle of their range in parts of its half width; the inner half.
NODES, INNER = np.linspace(-1.0, 1.0, 13), slice(3, 10)


@dataclass(frozen=True)
class Cases:
    """Decays to be matched, one per row."""

    curve: TrilinearCurve  # with parameters of shape (cases,)
    release_amplitude: Array  # shape (cases,)
    restitution: Array
    displacement: (
        Array  # of the reference, at each step of the solver, shape (cases, steps + 1) [-]
    )
    step: float  # in tau
    scheme: str = "newmark"  # of the solver

    @classmethod
    def release(
        cls,
        curve: TrilinearCurve,
        release_amplitude: Array,
        restitution: Array,
        *,
        step: float,
        steps: int,
        scheme: str = "newmark",
    ) -> Cases:
        """Release walls at rest: their decays under restitution over `steps` steps of the solver."""
        run: dict[str, Any] = {
            "release_amplitude": release_amplitude,
            "step": step,
            "steps": steps,
            "scheme": scheme,
        }
        decays = simulate(curve, Damping("CR", restitution), **run)
        return cls(curve, release_amplitude, restitution, decays.displacement, step, scheme)

    @property
    def steps(self) -> int:
        """Steps of the decays."""
        return self.displacement.shape[1] - 1

    def refine(self, steps: int, refinement: float) -> Cases:
        """Return the decays over `steps` steps again, with `refinement` steps in place of each, or nearly so.

        They are as long as before, over a whole number of steps.
        """
        finer = round(steps * refinement)
        start = self.curve, self.release_amplitude, self.restitution
        return Cases.release(
            *start, step=self.step * steps / finer, steps=finer, scheme=self.scheme
        )

    def take(self, case: slice | NDArray[np.int64]) -> Cases:
        """Return some of the cases."""
        return replace(
            self,
            curve=self.take_curve(case),
            release_amplitude=self.release_amplitude[case],
            restitution=self.restitution[case],
            displacement=self.displacement[case],
        )

    def take_curve(self, case: Any) -> TrilinearCurve:
        """Return the curves of some cases."""
        return self.curve.map(lambda parameter: parameter[case])

    def unique(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return the unique cases, and the index of each case among them: walls of one curve have one decay in tau."""
        ratios = (
            self.curve.yield_displacement_ratio,
            self.curve.strength_ratio,
            self.curve.ultimate_displacement_ratio,
        )
        parameters = np.broadcast_arrays(*ratios, self.release_amplitude, self.restitution)
        _, first, index = np.unique(
            np.stack(parameters, axis=1), axis=0, return_index=True, return_inverse=True
        )
        return first, index

    def errors(
        self, damping_model: str, damping_ratio: Array, case: Any, marks: ArrayLike, every: int = 1
    ) -> Array:
        """Return Err, Eq. (17), of damping ratios of some cases over the steps up to each mark.

        The marks count `every` steps as one. The shape is (marks, ...), with that of the ratios.
        """
        found = peaks(
            self.take_curve(case),
            Damping(damping_model, damping_ratio),
            release_amplitude=self.release_amplitude[case],
            step=self.step * every,
            steps=int(np.max(marks)),
            reference=Reference(self.displacement[:, ::every], case, marks),
            scheme=self.scheme,
        )
        return np.asarray(found.error)


@dataclass(frozen=True)
class Matched:
    """Damping ratios of least Err; every array has the shape (cases,)."""

    damping_ratio: Array  # xi of the least integral of (|u_CR| - |u|)^2 [-]
    uncertainty: Array  # bound of its error [-]
    error: Array  # Err, Eq. (17), over the `steps` at xi [-]
    local_minima: NDArray[np.int64]  # of Err over the damping ratios tried
    step: float  # the finest one, at which xi is the minimum, in tau
    steps: int  # k, over which Err sums

    @property
    def rms_error(self) -> Array:
        """sqrt(Err/k), in u/u_ins. [-]"""
        return np.sqrt(self.error / self.steps)


def match_dampers(
    cases: Cases,
    damping_models: Sequence[str],
    steps: int,
    *,
    refinement: int = REFINEMENT,
    description: str = "",
) -> dict[str, Matched]:
    """Match viscous models to decays under restitution over `steps` of the solver; returned by model, in their order.

    Equal cases are matched once. The last minimisation takes `refinement` steps in place of each of the solver's. The
    uncertainty is twice the largest difference from what the coarser of the last three steps give, and from what the
    inner half of the damping ratios tried gives at each of them; it is never less than the resolution of the minimiser.
    Without a `description` no progress is shown. It raises `InputError` where a minimum lies at the edge of the scan,
    or the response ends before the first impact.
    """
    first, index = cases.unique()
    unique = cases.take(first)
    # Steps of the last minimisations, over the finest: not multiples of each other, lest ripples agree.
    finer = [unique.refine(steps, refinement / coarser) for coarser in (2.0, 1.6, 1.0)]
    finest = finer[-1]

    def match_model(model: str) -> Matched:
        best = global_minima(unique, model, [steps])
        ratio = integral_minima(unique, model, steps, best.damping_ratio[0])[0]
        minima = []
        for decays in finer:
            minima.append(integral_minima(decays, model, decays.steps, ratio))
            ratio = minima[-1][0]
        uncertainty = np.maximum(
            2 * np.abs(np.concatenate(minima) - ratio).max(axis=0), RESOLUTION * ratio
        )
        lossy = np.flatnonzero(ratio > 0)  # e = 1 is followed without error
        error = np.zeros(ratio.size)
        if lossy.size:
            error[lossy] = finest.errors(model, ratio[lossy], lossy, [finest.steps])[0]
        return Matched(
            damping_ratio=ratio[index],
            uncertainty=uncertainty[index],
            error=error[index],
            local_minima=best.local_minima[0][index],
            step=finest.step,
            steps=finest.steps,
        )

    return map_in_threads(match_model, damping_models, description)


def map_in_threads(
    function: Callable[[K], T], items: Sequence[K], description: str = ""
) -> dict[K, T]:
    """Return a function's value for each item, computed side by side: the few lanes of one alone fill no processor."""
    with ThreadPoolExecutor(available_threads()) as pool:
        running = [pool.submit(function, item) for item in items]
        done = track(running, description) if description else running
        return {item: run.result() for item, run in zip(items, done, strict=True)}


# --- the global minimum of Err ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Minima:
    """Global minima of Err; every array has the shape (response lengths, cases)."""

    damping_ratio: Array  # xi at the minimum [-]
    error: Array  # Err, Eq. (17), over the steps 1 to k of the response length [-]
    local_minima: NDArray[np.int64]  # of Err over the damping ratios tried


def global_minima(cases: Cases, damping_model: str, response_length_steps: ArrayLike) -> Minima:
    """Find the global minimum of Err over the damping ratio for each case and response length (in steps, ascending).

    A scan over multiples of the closed form's damping ratio finds the basins, for all response lengths in one pass. The
    lowest are refined by bracketing, all cases at once. Of equal minima the smaller damping ratio is taken. It raises
    `InputError` where a minimum lies at the edge of the scan, or a response length ends before the first impact.
    """
    lengths = np.asarray(response_length_steps, dtype=np.int64)
    shape = (lengths.size, cases.restitution.size)
    best = Minima(np.zeros(shape), np.zeros(shape), np.ones(shape, dtype=np.int64))
    lossy = np.flatnonzero(
        cases.restitution < 1
    )  # where e = 1, xi = 0 follows the reference without error
    if not lossy.size:
        return best
    cases = cases.take(lossy)
    first = cases.curve.period(cases.release_amplitude).max() / 4
    if lengths.min() * cases.step <= first:
        raise InputError(
            f"response_length is {lengths.min() * cases.step:.6g}; it must be longer than {first:.6g} in tau, the"
            " time of the first impact, before which no damping ratio is defined"
        )
    guess = damping_ratio_energy(
        cases.curve, damping_model, cases.restitution, cases.release_amplitude
    )
    trial = np.minimum(guess[:, None] * SCAN, DAMPERS[damping_model].largest_value)
    # Finding the basins needs no shorter step: of the 20 in the stability limit, four cross the band of BAND.
    longest = min(0.01, float(stable_step(cases.curve).min()) / 20)
    every = max(1, int(longest / cases.step + 0.5))
    every_case = np.arange(lossy.size)[:, None]
    coarse = cases.errors(damping_model, trial, every_case, np.maximum(lengths // every, 1), every)
    _require_interior(cases, damping_model, lengths, coarse, trial)
    inner = coarse[..., 1:-1]
    lower = (inner < coarse[..., :-2]) & (inner <= coarse[..., 2:])
    best.local_minima[:, lossy] = lower.sum(axis=-1)
    best.error[:, lossy] = np.inf
    rivals = lower & (
        inner <= 1.5 * coarse.min(axis=-1)[..., None]
    )  # they are refined, then compared
    for start in range(
        0, lengths.size, 8
    ):  # a few at once: each history runs to the longest of them
        part = slice(start, start + 8)
        length, case, point = np.nonzero(rivals[part])
        bracket = np.stack([trial[case, point + shift] for shift in range(3)])
        ratio, error = _refine(cases, damping_model, lengths[part], length, case, bracket)
        for at, c, xi, value in zip(start + length, lossy[case], ratio, error, strict=True):
            if value < best.error[at, c]:  # ascending in xi: of equal errors the first stays
                best.damping_ratio[at, c], best.error[at, c] = xi, value
    return best


def _require_interior(
    cases: Cases, model: str, lengths: NDArray[np.int64], coarse: Array, trial: Array
) -> None:
    lowest = coarse.argmin(axis=-1)
    bad = np.argwhere((lowest == 0) | (lowest == coarse.shape[-1] - 1))
    if bad.size:
        at, c = bad[0]
        raise InputError(
            f"Err of {model} at e = {cases.restitution[c]:.6g}, u0/u_ins = {cases.release_amplitude[c]:.6g} and"
            f" response_length {lengths[at] * cases.step:.6g} is lowest at the edge of the scan,"
            f" xi = {trial[c, lowest[at, c]]:.6g}"
        )


def _refine(
    cases: Cases,
    model: str,
    lengths: NDArray[np.int64],
    length: NDArray[np.int64],
    case: NDArray[np.int64],
    bracket: Array,
) -> tuple[Array, Array]:
    """Return damping ratio and Err at the minimum next to each bracket of the scan, shape (3, brackets)."""

    def err(xi: Array, lane: NDArray[Any]) -> Array:
        lane = lane.astype(np.int64)  # SciPy makes floats of it
        return cases.errors(model, xi, case[lane], lengths)[length[lane], np.arange(lane.size)]

    from scipy.optimize import elementwise  # slow to import

    low, middle, high = bracket
    lane = np.arange(middle.size, dtype=float)
    # The coarser step of the scan may have moved the minimum by a point.
    ends = elementwise.bracket_minimum(err, middle, xl0=low, xr0=high, xmin=0.0, args=(lane,))
    found = elementwise.find_minimum(
        err, ends.bracket, args=(lane,), tolerances={"xrtol": RESOLUTION, "frtol": 1e-13}
    )
    failed = ~(ends.success & found.success)
    if failed.any():
        near = middle[failed][0]
        raise InputError(
            f"the minimum of Err of {model} near xi = {near:.6g} could not be bracketed"
        )
    return found.x, found.f_x


# --- the minimum of the integral, free of the ripple of its steps -----------------------------------------------------


def integral_minima(cases: Cases, damping_model: str, steps: int, damping_ratio: Array) -> Array:
    """Find the damping ratios of the least integral of (|u_CR| - |u|)^2 next to those given, shape (2, cases). [-]

    First by all damping ratios tried, then by the inner half of them: the difference says how well a cubic fits. A
    ratio of 0, which belongs to e = 1, stays. It raises `InputError` where it finds no minimum.
    """
    # Half the range over its middle. In proportion to the step, it holds as many periods of the ripple at every step.
    width = min(8.0 * cases.step, 0.1)
    middle, least = damping_ratio.copy(), np.zeros((2, damping_ratio.size))
    moving = np.flatnonzero(damping_ratio > 0)
    for _ in range(50):
        if not moving.size:
            return least
        tried = middle[moving, None] * (1 + width * NODES)
        # The trapezoidal integral over the step: its last sample counts half, and the first is 0.
        integral = cases.errors(damping_model, tried, moving[:, None], [steps - 1, steps]).mean(
            axis=0
        )
        whole, inner = (
            _least_of_cubic(NODES[part], integral[:, part]) for part in (slice(None), INNER)
        )
        least[:, moving] = middle[moving] * (1 + width * np.stack([whole, inner]))
        middle[moving] = least[0, moving]
        moving = moving[np.abs(whole) > NODES[INNER][-1]]  # the inner range has to hold it
    near = damping_ratio[moving[0]]
    raise InputError(
        f"the minimum of Err of {damping_model} near xi = {near:.6g} could not be bracketed"
    )


def _least_of_cubic(nodes: Array, values: Array) -> Array:
    """Return the place in [-1, 1] where the cubic fitted to each row is least: its minimum, or the end downhill."""
    fit = np.linalg.pinv(np.vander(nodes, 4, increasing=True))[1:]
    # Node by node: a product of matrices rounds otherwise with another number of rows, and a wall has one xi.
    slope, curvature, third = sum(
        np.multiply.outer(fit[:, node], values[:, node]) for node in range(nodes.size)
    )
    root = np.sqrt(np.maximum(curvature**2 - 3 * slope * third, 0.0))
    convex = curvature + root > 0
    minimum = -slope / np.where(convex, curvature + root, 1.0)
    return np.clip(np.where(convex, minimum, -np.sign(slope)), -1.0, 1.0)


# --- the words under Eq. (17) in place of its formula -----------------------------------------------------------------


def least_absolute(cases: Cases, damping_model: str, least_squares: Array, steps: int) -> Array:
    """Return the damping ratio of the least sum of ``||u_CR| - |u||`` over a response, for each case. [-]

    It is looked for within a factor 1.8 of the ratio of least squares, by a coarse grid and a fine one between the
    neighbours of its minimum, spaced by 0.06 %.
    """
    found = np.empty_like(least_squares)
    for case, ratio in enumerate(least_squares):
        width = 1.8
        for count in (41, 101):
            trial = ratio * np.geomspace(1 / width, width, count)
            run = {
                "release_amplitude": cases.release_amplitude[case],
                "step": cases.step,
                "steps": steps,
            }
            response = simulate(
                cases.take_curve(case), Damping(damping_model, trial), **run, scheme=cases.scheme
            )
            apart = np.abs(
                np.abs(response.displacement) - np.abs(cases.displacement[case, : steps + 1])
            )
            ratio, width = trial[apart.sum(axis=-1).argmin()], trial[1] / trial[0]
        found[case] = ratio
    return found
