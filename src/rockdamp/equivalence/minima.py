"""Minima over the damping ratio of a viscous model, against decays: of Err, Eq. (17), and of the integral it tends to.

Err samples |u|, which has a kink wherever u crosses zero, and the corners of the curve fall anywhere in a step of the
solver. When the damping ratio changes, kinks and corners move across the steps: that puts a ripple on Err, of second
order in the step and with a period of first order. So the least sample lies a *first* order of the step from the least
integral, and two steps can agree on it by chance. A cubic through many periods of the ripple has its mean alone, which
is of second order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rockdamp.arrays import Array
from rockdamp.equivalence.closed_form import Scan, damping_ratio_energy
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import RULES, TrilinearCurve
from rockdamp.mechanics.damping import Damping, damper_classes
from rockdamp.solvers.newmark import solve, stable_step
from rockdamp.solvers.response import Options, Reference

SCAN = Scan(smallest=0.3, largest=3.0, points=200)
SCAN_STEP = 0.01  # in tau; finding the basins needs no more
RIVALS = 1.5  # local minima of the scan within this factor of the lowest are refined, then compared
LENGTHS_AT_ONCE = 8
RESOLUTION = 3e-5  # of the minimiser, as a fraction of xi
GOLDEN = 0.5 + 0.5 * 5**0.5
MOST_ITERATIONS = 100
# Relative changes of a function below this part of it are rounding.
FLAT = 1e-13
NODES = np.linspace(-1.0, 1.0, 13)  # damping ratios tried, from the middle of their range in parts of its half width
INNER = slice(3, 10)  # those in the inner half of the range
HALF_WIDTH = 8.0  # of the range over its middle, over the step in tau: so it holds as many periods at every step
WIDEST = 0.1  # half width at most
MOVES = 50  # of the middle, before a minimum that no range holds is given up


@dataclass(frozen=True)
class Cases:
    """Decays to be matched, one per row."""

    curve: TrilinearCurve  # with parameters of shape (cases,)
    release_amplitude: Array  # shape (cases,)
    restitution: Array
    displacement: Array  # of the reference, at each step of the solver, shape (cases, steps + 1) [-]
    step: float  # in tau

    @classmethod
    def released(
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
        start: Options = {"release_amplitude": release_amplitude, "step": step, "steps": steps, "scheme": scheme}
        response = solve(curve, Damping.cr(restitution), store_every=1, **start)
        return cls(curve, release_amplitude, restitution, response.displacement, step)

    def refined(self, steps: int, refinement: float, scheme: str = "newmark") -> Cases:
        """Return the decays over `steps` steps again, with `refinement` steps in place of each, or nearly so.

        They are as long as before, over a whole number of steps.
        """
        finer = round(steps * refinement)
        released, step = (self.curve, self.release_amplitude, self.restitution), self.step * steps / finer
        return Cases.released(*released, step=step, steps=finer, scheme=scheme)

    @property
    def steps(self) -> int:
        """Steps of the decays."""
        return self.displacement.shape[1] - 1

    def take(self, case: slice | NDArray[np.int64]) -> Cases:
        """Return some of the cases."""
        return Cases(
            self.curve_of(case),
            self.release_amplitude[case],
            self.restitution[case],
            self.displacement[case],
            self.step,
        )

    def curve_of(self, case: Any) -> TrilinearCurve:
        """Return the curves of some cases."""
        return self.curve.map(lambda parameter: parameter[case])

    def errors(
        self, damping_model: str, damping_ratio: Array, case: Any, marks: Any, scheme: str, every: int = 1
    ) -> Array:
        """Return Err, Eq. (17), of damping ratios of some cases at each of the marks; these count `every` steps as one.

        The shape is that of the ratios, after that of the marks.
        """
        response = solve(
            self.curve_of(case),
            Damping(damping_model, damping_ratio),
            release_amplitude=self.release_amplitude[case],
            step=self.step * every,
            steps=int(marks[-1]),
            reference=Reference(self.displacement[:, ::every], case, marks),
            peaks_only=True,
            scheme=scheme,
        )
        return response.error

    def unlike(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return the cases that differ, and which of these each case is: walls of one curve pose one problem in tau."""
        shape = [getattr(self.curve, name) for name in RULES]
        problem = np.stack([*shape, self.release_amplitude, self.restitution], axis=1)
        _, first, which = np.unique(problem, axis=0, return_index=True, return_inverse=True)
        return first, which


@dataclass(frozen=True)
class Minima:
    """Global minima of Err; every array has the shape (response lengths, cases)."""

    damping_ratio: Array  # xi at the minimum [-]
    error: Array  # Err, Eq. (17), over the steps 1 to k of the response length [-]
    local_minima: NDArray[np.int64]  # of Err over the damping ratios tried


def global_minima(
    cases: Cases,
    damping_model: str,
    response_length_steps: ArrayLike,
    scan: Scan = SCAN,
    scheme: str = "newmark",
) -> Minima:
    """Find the global minimum of Err over the damping ratio for each case and response length (in steps, ascending).

    A scan over multiples of the closed form's damping ratio finds the basins, for all response lengths in one pass. The
    lowest are refined by bracketing, all lanes at once. Of equal minima the smaller damping ratio is taken. It raises
    `InputError` where a minimum lies at the edge of the scan, or a response length ends before the first impact.
    """
    lengths = np.asarray(response_length_steps, dtype=np.int64)
    lossy = np.flatnonzero(cases.restitution < 1)
    if lossy.size < cases.restitution.size:
        return _with_lossless(cases, damping_model, lengths, scan, scheme, lossy)
    _require_impacts(cases, lengths)
    guess = damping_ratio_energy(cases.curve, damping_model, cases.restitution, cases.release_amplitude)
    trial = guess[:, None] * np.geomspace(scan.smallest, scan.largest, scan.points)
    trial = np.minimum(trial, damper_classes()[damping_model].largest_damping_ratio)
    coarse = _scan(cases, damping_model, trial, lengths, scheme)
    lower = (coarse[..., 1:-1] < coarse[..., :-2]) & (coarse[..., 1:-1] <= coarse[..., 2:])
    lowest = coarse.min(axis=-1)
    _require_interior(cases, damping_model, lengths, coarse, trial)
    rivals = lower & (coarse[..., 1:-1] <= RIVALS * lowest[..., None])
    length, case, point = np.nonzero(rivals)
    ratio, error = np.empty(length.size), np.empty(length.size)
    for some in np.array_split(np.arange(lengths.size), -(-lengths.size // LENGTHS_AT_ONCE)):
        chosen = np.isin(length, some)
        around = [trial[case[chosen], point[chosen] + shift] for shift in (0, 1, 2)]
        place = length[chosen] - some[0], case[chosen]
        ratio[chosen], error[chosen] = _refine(cases, damping_model, lengths[some], *place, around, scheme)
    best = Minima(np.full(lowest.shape, np.nan), np.full(lowest.shape, np.inf), lower.sum(axis=-1))
    for w, c, xi, value in zip(length, case, ratio, error, strict=True):
        # Ascending in xi: of equal errors the first stays.
        if value < best.error[w, c]:
            best.damping_ratio[w, c], best.error[w, c] = xi, value
    return best


def _with_lossless(
    cases: Cases, model: str, lengths: NDArray[np.int64], scan: Scan, scheme: str, lossy: NDArray[np.int64]
) -> Minima:
    """Search where energy is lost; where e = 1, xi = 0 follows the reference, with one minimum and no error."""
    shape = (lengths.size, cases.restitution.size)
    best = Minima(np.zeros(shape), np.zeros(shape), np.ones(shape, dtype=np.int64))
    if lossy.size:
        of_lossy = global_minima(cases.take(lossy), model, lengths, scan, scheme)
        best.damping_ratio[:, lossy], best.error[:, lossy] = of_lossy.damping_ratio, of_lossy.error
        best.local_minima[:, lossy] = of_lossy.local_minima
    return best


def _require_impacts(cases: Cases, lengths: NDArray[np.int64]) -> None:
    first = cases.curve.period(cases.release_amplitude).max() / 4
    if lengths.min() * cases.step <= first:
        raise InputError(
            f"response_length is {lengths.min() * cases.step:.6g}; it must be longer than {first:.6g} in tau, the"
            " time of the first impact, before which no damping ratio is defined"
        )


def _require_interior(cases: Cases, model: str, lengths: NDArray[np.int64], coarse: Array, trial: Array) -> None:
    at = coarse.argmin(axis=-1)
    bad = np.argwhere((at == 0) | (at == coarse.shape[-1] - 1))
    if bad.size:
        w, c = bad[0]
        raise InputError(
            f"Err of {model} at e = {cases.restitution[c]:.6g}, u0/u_ins = {cases.release_amplitude[c]:.6g} and"
            f" response_length {lengths[w] * cases.step:.6g} is lowest at the edge of the scan,"
            f" xi = {trial[c, at[w, c]]:.6g}; matching.scan must reach further"
        )


def _scan(cases: Cases, model: str, trial: Array, lengths: NDArray[np.int64], scheme: str) -> Array:
    """Return Err on the grid of damping ratios, shape (response lengths, cases, points), at a coarser step."""
    longest = float(stable_step(cases.curve).min()) / (20 if model == "BAND" else 4)  # four steps in a band
    every = max(1, int(min(SCAN_STEP, longest) / cases.step + 0.5))
    marks = np.maximum(lengths // every, 1)
    index = np.arange(cases.restitution.size)[:, None]
    return cases.errors(model, trial, index, marks, scheme, every)


def _refine(
    cases: Cases,
    model: str,
    lengths: NDArray[np.int64],
    length: NDArray[np.int64],
    case: NDArray[np.int64],
    around: list[Array],
    scheme: str,
) -> tuple[Array, Array]:
    """Return damping ratio and Err at the minimum next to each bracket of the scan."""

    def err(xi: Array, lane: NDArray[np.int64]) -> Array:
        error = cases.errors(model, xi, case[lane], lengths, scheme)
        return np.take_along_axis(error, length[lane][None], axis=0)[0]

    # Brackets of several lengths share most of their points, and a history tells Err at all lengths.
    place = np.stack(around)
    points = np.stack([np.broadcast_to(case, place.shape), place]).reshape(2, -1)
    (of_case, xi), which = np.unique(points, axis=1, return_inverse=True)
    value = cases.errors(model, xi, of_case.astype(np.int64), lengths, scheme)[length, which.reshape(place.shape)]
    low, middle, high = value
    bracketed = (middle <= low) & (middle <= high) & ((middle < low) | (middle < high))
    open_ = np.flatnonzero(~bracketed)
    if open_.size:  # the coarser step of the scan moved the minimum by a point
        from scipy.optimize import elementwise  # slow to import, and seldom needed

        def err_of(xi: Array, lane: Array) -> Array:
            return err(xi, lane.astype(np.int64))

        low, middle, high = place[:, open_]
        found = elementwise.bracket_minimum(err_of, middle, xl0=low, xr0=high, xmin=0.0, args=(open_.astype(float),))
        if not found.success.all():
            bad = np.flatnonzero(~found.success)[0]
            raise InputError(f"the minimum of Err of {model} near xi = {middle[bad]:.6g} could not be bracketed")
        place[:, open_], value[:, open_] = found.bracket, found.f_bracket
    ratio, error = bracketed_minima(err, place, value, RESOLUTION)
    if not np.isfinite(ratio).all():
        bad = np.flatnonzero(~np.isfinite(ratio))[0]
        raise InputError(f"the minimum of Err of {model} near xi = {around[1][bad]:.6g} did not converge")
    return ratio, error


def bracketed_minima(
    function: Callable[[Array, NDArray[np.int64]], Array], place: Array, value: Array, resolution: float
) -> tuple[Array, Array]:
    """Return places of minima within a part of themselves, and values there, shape (functions,) each.

    A parabola through the best three points is taken where two in a row agree, and a golden section elsewhere
    (Chandrupatla 1998, doi:10.1016/S0045-7825(97)00190-4). SciPy's `elementwise.find_minimum` does the same, bit by
    bit; it is slow to import, and takes the values in the bracket a second time.

    The function takes places, and of which functions. The brackets, shape (3, functions), are ascending places and
    values of which the middle one is least. NaN stands where a value is not finite, or no end is reached.
    """
    x, f, fitted, lane = place.copy(), value.copy(), place[2].copy(), np.arange(place.shape[1])
    least = np.full((2, lane.size), np.nan)
    for _ in range(MOST_ITERATIONS):
        nearer = np.abs(x[2] - x[1]) < np.abs(x[1] - x[0])  # the last point is to be the one further off
        x[:, nearer], f[:, nearer] = x[::-1, nearer], f[::-1, nearer]
        within = np.abs(x[1]) * resolution
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
        tried, fitted = np.where(agree, moved, x[1] + (2 - GOLDEN) * far), vertex
        reached = function(tried, lane)
        higher = reached > f[1]
        # The better of the middle and the point tried is the middle; the other one, an end, on its side of it.
        last = (np.sign(tried - x[1]) == np.sign(far)) == higher
        for points, new in ((x, tried), (f, reached)):
            end = np.where(higher, new, points[1])
            points[1] = np.where(higher, points[1], new)
            points[2], points[0] = np.where(last, end, points[2]), np.where(last, points[0], end)
    return least[0], least[1]


# --- of the integral, free of the ripple of its steps -----------------------------------------------------------------


def integral_minima(
    cases: Cases, damping_model: str, steps: int, damping_ratio: Array, scheme: str = "newmark"
) -> Array:
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
        integral = _integral(cases, damping_model, steps, middle[moving, None] * (1 + width * NODES), moving, scheme)
        of_all, of_inner = (_least_of_cubic(NODES[part], integral[:, part]) for part in (slice(None), INNER))
        least[:, moving] = middle[moving] * (1 + width * np.stack([of_all, of_inner]))
        middle[moving] = least[0, moving]
        moving = moving[np.abs(of_all) > NODES[INNER][-1]]  # the inner range has to hold it
    raise InputError(
        f"the minimum of Err of {damping_model} near xi = {damping_ratio[moving[0]]:.6g} could not be bracketed"
    )


def error_at(cases: Cases, damping_model: str, steps: int, damping_ratio: Array, scheme: str = "newmark") -> Array:
    """Return Err, Eq. (17), over the steps, shape (cases,). [-]"""
    lossy = np.flatnonzero(damping_ratio > 0)  # e = 1 is followed without error
    error = np.zeros(damping_ratio.size)
    error[lossy] = cases.errors(damping_model, damping_ratio[lossy, None], lossy[:, None], [steps], scheme)[0, :, 0]
    return error


def _integral(
    cases: Cases, model: str, steps: int, damping_ratio: Array, case: NDArray[np.int64], scheme: str
) -> Array:
    """Return the trapezoidal integral, over the step; its last sample counts half, and the first is 0."""
    return cases.errors(model, damping_ratio, case[:, None], [steps - 1, steps], scheme).mean(axis=0)


def _least_of_cubic(nodes: Array, values: Array) -> Array:
    """Return the place in [-1, 1] where the cubic fitted to each row is least: its minimum, or the end downhill."""
    fit = np.linalg.pinv(np.vander(nodes, 4, increasing=True))[1:]
    # Node by node: a product of matrices rounds otherwise with another number of rows, and a wall has one xi.
    slope, curvature, third = sum(np.multiply.outer(fit[:, node], values[:, node]) for node in range(nodes.size))
    root = np.sqrt(np.maximum(curvature**2 - 3 * slope * third, 0.0))
    convex = curvature + root > 0
    minimum = -slope / np.where(convex, curvature + root, 1.0)
    return np.clip(np.where(convex, minimum, -np.sign(slope)), -1.0, 1.0)
