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
from contextvars import copy_context
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import DAMPERS, Damping
from rockdamp.progress import track
from rockdamp.solvers.newmark import Reference, available_threads, peaks, simulate, stable_step

T = TypeVar("T")
K = TypeVar("K", bound=Hashable)

# The global minimum.
SCAN = np.geomspace(0.3, 3.0, 200)  # damping ratios tried, over the closed form's
SCAN_STEP = 0.01  # in tau; finding the basins needs no more
SCAN_STEPS = 20  # at least in the stability limit: four of them cross the band of BAND
LENGTHS_AT_ONCE = 8  # whose minima are refined together: each history runs to the longest of them
RIVALS = 1.5  # local minima of the scan within this factor of the lowest are refined, then compared
RESOLUTION = 3e-5  # of the minimiser, as a fraction of xi
FLAT = 1e-13  # relative changes of a function below it are rounding
MOST_ITERATIONS = 100
# The minimum of the integral.
NODES = np.linspace(-1.0, 1.0, 13)  # damping ratios tried, from the middle of their range in parts of its half width
INNER = slice(3, 10)  # those in the inner half of the range
HALF_WIDTH = 8.0  # of the range over its middle, over the step in tau: so it holds as many periods at every step
WIDEST = 0.1  # half width at most
MOVES = 50  # of the middle, before a minimum that no range holds is given up
# The published ratio.
REFINEMENT = 8  # steps of the last minimisation in place of each of the solver's
COARSER = (2.0, 1.6, 1.0)  # steps of the last three minimisations, over the finest; not multiples, lest ripples agree


@dataclass(frozen=True)
class Cases:
    """Decays to be matched, one per row."""

    curve: TrilinearCurve  # with parameters of shape (cases,)
    release_amplitude: Array  # shape (cases,)
    restitution: Array
    displacement: Array  # of the reference, at each step of the solver, shape (cases, steps + 1) [-]
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
        decays = simulate(
            curve,
            Damping("CR", restitution),
            release_amplitude=release_amplitude,
            step=step,
            steps=steps,
            scheme=scheme,
        )
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
        return Cases.release(*start, step=self.step * steps / finer, steps=finer, scheme=self.scheme)

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
        ratios = self.curve.yield_displacement_ratio, self.curve.strength_ratio, self.curve.ultimate_displacement_ratio
        parameters = np.broadcast_arrays(*ratios, self.release_amplitude, self.restitution)
        _, first, index = np.unique(np.stack(parameters, axis=1), axis=0, return_index=True, return_inverse=True)
        return first, index

    def errors(self, damping_model: str, damping_ratio: Array, case: Any, marks: ArrayLike, every: int = 1) -> Array:
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
    cases: Cases, damping_models: Sequence[str], steps: int, *, refinement: int = REFINEMENT, description: str = ""
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
    finer = [unique.refine(steps, refinement / factor) for factor in COARSER]
    finest = finer[-1]

    def match_model(model: str) -> Matched:
        best = global_minima(unique, model, [steps])
        ratio = integral_minima(unique, model, steps, best.damping_ratio[0])[0]
        minima = []
        for decays in finer:
            minima.append(integral_minima(decays, model, decays.steps, ratio))
            ratio = minima[-1][0]
        uncertainty = np.maximum(2 * np.abs(np.concatenate(minima) - ratio).max(axis=0), RESOLUTION * ratio)
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


def map_in_threads(function: Callable[[K], T], items: Sequence[K], description: str = "") -> dict[K, T]:
    """Return a function's value for each item, computed side by side: the few lanes of one alone fill no processor."""
    with ThreadPoolExecutor(available_threads()) as pool:
        # Each in a copy of the context: the caller says what becomes of floating-point errors.
        running = [pool.submit(copy_context().run, function, item) for item in items]
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
    lossy = np.flatnonzero(cases.restitution < 1)  # where e = 1, xi = 0 follows the reference without error
    if not lossy.size:
        return best
    cases = cases.take(lossy)
    first = cases.curve.period(cases.release_amplitude).max() / 4
    if lengths.min() * cases.step <= first:
        raise InputError(
            f"response_length is {lengths.min() * cases.step:.6g}; it must be longer than {first:.6g} in tau, the"
            " time of the first impact, before which no damping ratio is defined"
        )
    guess = damping_ratio_energy(cases.curve, damping_model, cases.restitution, cases.release_amplitude)
    trial = guess[:, None] * SCAN
    trial = np.minimum(trial, DAMPERS[damping_model].largest_value)
    longest = min(SCAN_STEP, float(stable_step(cases.curve).min()) / SCAN_STEPS)
    every = max(1, int(longest / cases.step + 0.5))
    every_case = np.arange(lossy.size)[:, None]
    coarse = cases.errors(damping_model, trial, every_case, np.maximum(lengths // every, 1), every)
    _require_interior(cases, damping_model, lengths, coarse, trial)
    inner = coarse[..., 1:-1]
    lower = (inner < coarse[..., :-2]) & (inner <= coarse[..., 2:])
    best.local_minima[:, lossy] = lower.sum(axis=-1)
    best.error[:, lossy] = np.inf
    rivals = lower & (inner <= RIVALS * coarse.min(axis=-1)[..., None])
    for start in range(0, lengths.size, LENGTHS_AT_ONCE):
        length, case, point = np.nonzero(rivals[start : start + LENGTHS_AT_ONCE])
        bracket = np.stack([trial[case, point + shift] for shift in range(3)])
        ratio, error = _refine(cases, damping_model, lengths[start : start + LENGTHS_AT_ONCE], length, case, bracket)
        for at, c, xi, value in zip(start + length, lossy[case], ratio, error, strict=True):
            if value < best.error[at, c]:  # ascending in xi: of equal errors the first stays
                best.damping_ratio[at, c], best.error[at, c] = xi, value
    return best


def _require_interior(cases: Cases, model: str, lengths: NDArray[np.int64], coarse: Array, trial: Array) -> None:
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

    # Brackets of several lengths share most of their points, and a history tells Err at all lengths.
    points = np.stack([np.broadcast_to(case, bracket.shape), bracket]).reshape(2, -1)
    (unique_case, unique), index = np.unique(points, axis=1, return_inverse=True)
    error = cases.errors(model, unique, unique_case.astype(np.int64), lengths)
    value = error[length, index.reshape(bracket.shape)]
    low, middle, high = value
    bracketed = (middle <= low) & (middle <= high) & ((middle < low) | (middle < high))
    wide = np.flatnonzero(~bracketed)
    if wide.size:  # the coarser step of the scan moved the minimum by a point
        from scipy.optimize import elementwise  # slow to import, and seldom needed

        low, middle, high = bracket[:, wide]
        found = elementwise.bracket_minimum(err, middle, xl0=low, xr0=high, xmin=0.0, args=(wide.astype(float),))
        bracket[:, wide], value[:, wide] = found.bracket, found.f_bracket
        value[:, wide[~found.success]] = np.nan
    ratio, error = bracketed_minima(err, bracket, value)
    if not np.isfinite(ratio).all():
        near = bracket[1, ~np.isfinite(ratio)][0]
        raise InputError(f"the minimum of Err of {model} near xi = {near:.6g} could not be bracketed")
    return ratio, error


def bracketed_minima(
    function: Callable[[Array, NDArray[np.int64]], Array], place: Array, value: Array
) -> tuple[Array, Array]:
    """Return places of minima, within `RESOLUTION`, and values there, shape (functions,) each.

    A parabola through the best three points is taken where two in a row agree, and a golden section elsewhere
    (Chandrupatla 1998, doi:10.1016/S0045-7825(97)00190-4). SciPy's `elementwise.find_minimum` does the same, bit by
    bit; it is slow to import, and takes the values in the bracket a second time.

    `function` takes places, and the index of each one's function. The brackets, shape (3, functions), are ascending
    places and values of which the middle one is least. NaN stands where a value is not finite, or no end is reached.
    """
    golden = 0.5 + 0.5 * 5**0.5
    x, f, fitted, lane = place.copy(), value.copy(), place[2].copy(), np.arange(place.shape[1])
    least = np.full((2, lane.size), np.nan)
    for _ in range(MOST_ITERATIONS):
        nearer = np.abs(x[2] - x[1]) < np.abs(x[1] - x[0])  # the last point is to be the one further off
        x[:, nearer], f[:, nearer] = x[::-1, nearer], f[::-1, nearer]
        within = np.abs(x[1]) * RESOLUTION
        done = (np.abs(x[2] - x[1]) <= 2 * within) | (f[0] - 2 * f[1] + f[2] <= 2 * (np.abs(f[1]) * FLAT))
        least[:, lane[done]] = x[1, done], f[1, done]
        going = ~done & np.isfinite(f).all(axis=0)
        x, f, fitted, lane, within = x[:, going], f[:, going], fitted[going], lane[going], within[going]
        if not lane.size:
            break
        near, far = x[1] - x[0], x[2] - x[1]
        part, other = near * (f[2] - f[1]), far * (f[0] - f[1])
        vertex = 0.5 * (part / (part + other) * (x[0] - x[2]) + x[1] + x[2])
        moved = np.where(np.abs(vertex - x[1]) <= within, x[1] + np.sign(far) * within, vertex)
        agree = np.abs(vertex - fitted) < 0.5 * np.abs(near)
        tried, fitted = np.where(agree, moved, x[1] + (2 - golden) * far), vertex
        reached = function(tried, lane)
        higher = reached > f[1]
        # The better of the middle and the point tried is the middle; the other one, an end, on its side of it.
        last = (np.sign(tried - x[1]) == np.sign(far)) == higher
        for points, new in ((x, tried), (f, reached)):
            end = np.where(higher, new, points[1])
            points[1] = np.where(higher, points[1], new)
            points[2], points[0] = np.where(last, end, points[2]), np.where(last, points[0], end)
    return least[0], least[1]


# --- the minimum of the integral, free of the ripple of its steps -----------------------------------------------------


def integral_minima(cases: Cases, damping_model: str, steps: int, damping_ratio: Array) -> Array:
    """Find the damping ratios of the least integral of (|u_CR| - |u|)^2 next to those given, shape (2, cases). [-]

    First by all damping ratios tried, then by the inner half of them: the difference says how well a cubic fits. A
    ratio of 0, which belongs to e = 1, stays. It raises `InputError` where it finds no minimum.
    """
    width = min(HALF_WIDTH * cases.step, WIDEST)
    middle, least = damping_ratio.copy(), np.zeros((2, damping_ratio.size))
    moving = np.flatnonzero(damping_ratio > 0)
    for _ in range(MOVES):
        if not moving.size:
            return least
        tried = middle[moving, None] * (1 + width * NODES)
        # The trapezoidal integral over the step: its last sample counts half, and the first is 0.
        integral = cases.errors(damping_model, tried, moving[:, None], [steps - 1, steps]).mean(axis=0)
        whole, inner = (_least_of_cubic(NODES[part], integral[:, part]) for part in (slice(None), INNER))
        least[:, moving] = middle[moving] * (1 + width * np.stack([whole, inner]))
        middle[moving] = least[0, moving]
        moving = moving[np.abs(whole) > NODES[INNER][-1]]  # the inner range has to hold it
    near = damping_ratio[moving[0]]
    raise InputError(f"the minimum of Err of {damping_model} near xi = {near:.6g} could not be bracketed")


def _least_of_cubic(nodes: Array, values: Array) -> Array:
    """Return the place in [-1, 1] where the cubic fitted to each row is least: its minimum, or the end downhill."""
    fit = np.linalg.pinv(np.vander(nodes, 4, increasing=True))[1:]
    # Node by node: a product of matrices rounds otherwise with another number of rows, and a wall has one xi.
    slope, curvature, third = sum(np.multiply.outer(fit[:, node], values[:, node]) for node in range(nodes.size))
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
            response = simulate(
                cases.take_curve(case),
                Damping(damping_model, trial),
                release_amplitude=cases.release_amplitude[case],
                step=cases.step,
                steps=steps,
                scheme=cases.scheme,
            )
            apart = np.abs(np.abs(response.displacement) - np.abs(cases.displacement[case, : steps + 1]))
            ratio, width = trial[apart.sum(axis=-1).argmin()], trial[1] / trial[0]
        found[case] = ratio
    return found
