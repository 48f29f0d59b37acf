"""The damping ratio that follows a decay under restitution best: the least Err, Eq. (17).

Every published damping ratio of least Err comes from `match_dampers`. It finds the global minimum
of Err against decays at the solver's step. As the step shrinks, Err tends to an integral. The
published ratio is the minimum of this integral next to the global minimum of Err, followed to finer
steps of both the reference and the model.

Err samples |u|, which has a kink wherever u crosses zero, and the corners of the curve fall
anywhere in a step of the solver. When the damping ratio changes, kinks and corners move across the
steps. This puts a ripple on Err, of second order in the step and with a period of first order. The
least sample therefore lies a *first* order of the step away from the least integral, and two steps
can agree on it by chance. A cubic fitted over many periods of the ripple averages it: only the mean
of the ripple remains, which is of second order.
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
from rockdamp.mechanics.damping import DAMPERS, Damping
from rockdamp.progress import track
from rockdamp.solvers.blocks import available_threads
from rockdamp.solvers.newmark import Reference, peaks, simulate, stable_step

Result = TypeVar("Result")
Key = TypeVar("Key", bound=Hashable)

SCAN = np.geomspace(0.3, 3.0, 200)  # damping ratios of the scan, divided by the closed form's
RESOLUTION = 3e-5  # of the minimiser, as a fraction of xi
# Damping ratios about the minimum of the integral, in parts of the half width of their range.
CUBIC_NODES = np.linspace(-1.0, 1.0, 13)
INNER_NODES = slice(3, 10)  # the nodes from -0.5 to 0.5


@dataclass(frozen=True)
class Cases:
    """Decays under restitution that are matched, one in each row.

    Parameters
    ----------
    curve : TrilinearCurve
        Force-displacement curves, with parameters of shape (cases,).
    release_amplitude : ndarray, shape (cases,)
        Amplitude u0/u_ins. [-]
    restitution : ndarray, shape (cases,)
        Coefficient of restitution e. [-]
    displacement : ndarray, shape (cases, steps + 1)
        Decay u/u_ins at each step of the solver. [-]
    step : float
        Step of the solver, in tau. [-]
    scheme : {"newmark", "paper"}
        Scheme of the solver.
    """

    curve: TrilinearCurve
    release_amplitude: Array
    restitution: Array
    displacement: Array
    step: float
    scheme: str = "newmark"

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
        """Release walls at rest and follow their decays under restitution.

        Parameters
        ----------
        curve : TrilinearCurve
            Force-displacement curves, with parameters of shape (cases,).
        release_amplitude : ndarray, shape (cases,)
            Amplitude u0/u_ins. [-]
        restitution : ndarray, shape (cases,)
            Coefficient of restitution e. [-]
        step : float
            Step of the solver, in tau. [-]
        steps : int
            Number of steps.
        scheme : {"newmark", "paper"}
            Scheme of the solver.
        """
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
        """Number of steps of the decays."""
        return self.displacement.shape[1] - 1

    def refine(self, steps: int, refinement: float) -> Cases:
        """Return the decays over `steps` steps again, at a finer step.

        The decays keep their length; their number of steps is `steps` times `refinement`, rounded.
        """
        finer = round(steps * refinement)
        return Cases.release(
            self.curve,
            self.release_amplitude,
            self.restitution,
            step=self.step * steps / finer,
            steps=finer,
            scheme=self.scheme,
        )

    def take(self, case: slice | NDArray[np.int64]) -> Cases:
        """Return the cases at an index."""
        return replace(
            self,
            curve=self.take_curve(case),
            release_amplitude=self.release_amplitude[case],
            restitution=self.restitution[case],
            displacement=self.displacement[case],
        )

    def take_curve(self, case: Any) -> TrilinearCurve:
        """Return the curves of the cases at an index."""
        return self.curve.map(lambda parameter: parameter[case])

    def unique(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return the indices of unique cases, and the index of each case among them.

        Walls with the same curve have the same decay in tau.
        """
        parameters = np.broadcast_arrays(
            self.curve.yield_displacement_ratio,
            self.curve.strength_ratio,
            self.curve.ultimate_displacement_ratio,
            self.release_amplitude,
            self.restitution,
        )
        rows = np.stack(parameters, axis=1)
        _, first, index = np.unique(rows, axis=0, return_index=True, return_inverse=True)
        return first, index

    def errors(
        self, damping_model: str, damping_ratio: Array, case: Any, marks: ArrayLike, stride: int = 1
    ) -> Array:
        """Return Err, Eq. (17), shape (marks, ...) with the shape of the damping ratios. [-]

        Parameters
        ----------
        damping_model : str
            Viscous model.
        damping_ratio : ndarray
            Damping ratios xi. [-]
        case : ndarray of int
            Case of each damping ratio; broadcasts with them.
        marks : sequence of int
            Numbers of steps over which Err is summed, counted in steps of the model, ascending.
        stride : int
            Steps of the decays in one step of the model.
        """
        ended = peaks(
            self.take_curve(case),
            Damping(damping_model, damping_ratio),
            release_amplitude=self.release_amplitude[case],
            step=self.step * stride,
            steps=int(np.max(marks)),
            reference=Reference(self.displacement[:, ::stride], case, marks),
            scheme=self.scheme,
        )
        return np.asarray(ended.error)


@dataclass(frozen=True)
class Matched:
    """Damping ratios of least Err.

    Attributes
    ----------
    damping_ratio : ndarray, shape (cases,)
        Damping ratio xi of the least integral of (|u_CR| - |u|)^2. [-]
    uncertainty : ndarray, shape (cases,)
        Bound of the error of xi. [-]
    error : ndarray, shape (cases,)
        Err, Eq. (17), at xi, over `steps`. [-]
    local_minima : ndarray of int, shape (cases,)
        Number of local minima of Err in the scan.
    step : float
        Finest step, at which xi is the minimum, in tau. [-]
    steps : int
        Number of steps k over which Err is summed.
    """

    damping_ratio: Array
    uncertainty: Array
    error: Array
    local_minima: NDArray[np.int64]
    step: float
    steps: int

    @property
    def rms_error(self) -> Array:
        """Root mean square error sqrt(Err/k), in u/u_ins. [-]"""
        return np.sqrt(self.error / self.steps)


def match_dampers(
    cases: Cases,
    damping_models: Sequence[str],
    steps: int,
    *,
    refinement: int = 8,
    description: str = "",
) -> dict[str, Matched]:
    """Match viscous models to decays under restitution.

    Equal cases are matched once. The ratio is found at three steps, and at each of them from all
    nodes of a cubic and from their inner half. The uncertainty is twice the largest difference of
    these six from the ratio returned. It is never less than the resolution of the minimiser.

    Parameters
    ----------
    cases : Cases
        Decays.
    damping_models : sequence of str
        Viscous models, in the order of the result.
    steps : int
        Number of steps of the decays over which Err is summed.
    refinement : int
        Steps of the last minimisation for each step of the solver. The default is 8.
    description : str
        Text of the progress bar; without it no progress is shown.

    Returns
    -------
    dict of Matched
        Match of each model, by name.

    Raises
    ------
    InputError
        If a minimum lies at the edge of the scan, or the response ends before the first impact.
    """
    first, index = cases.unique()
    unique = cases.take(first)
    # These steps are not all multiples of each other, so that the ripples of Err do not agree by
    # chance.
    refined = [unique.refine(steps, refinement / coarser) for coarser in (2.0, 1.6, 1.0)]
    finest = refined[-1]

    def match_model(model: str) -> Matched:
        scanned = global_minima(unique, model, [steps])
        ratio = integral_minima(unique, model, steps, scanned.damping_ratio[0])[0]
        ratio, uncertainty = _follow_to_finer_steps(refined, model, ratio)
        lossy = np.flatnonzero(ratio > 0)  # where e = 1, xi = 0 has no error
        error = np.zeros(ratio.size)
        if lossy.size:
            error[lossy] = finest.errors(model, ratio[lossy], lossy, [finest.steps])[0]
        return Matched(
            damping_ratio=ratio[index],
            uncertainty=uncertainty[index],
            error=error[index],
            local_minima=scanned.local_minima[0][index],
            step=finest.step,
            steps=finest.steps,
        )

    return map_in_threads(match_model, damping_models, description)


def _follow_to_finer_steps(
    refined: Sequence[Cases], damping_model: str, ratio: Array
) -> tuple[Array, Array]:
    """Return the damping ratio at the finest step, and its uncertainty."""
    minima = []
    for decays in refined:
        minima.append(integral_minima(decays, damping_model, decays.steps, ratio))
        ratio = minima[-1][0]
    changes = np.abs(np.concatenate(minima) - ratio)
    return ratio, np.maximum(2 * changes.max(axis=0), RESOLUTION * ratio)


def map_in_threads(
    function: Callable[[Key], Result], items: Sequence[Key], description: str = ""
) -> dict[Key, Result]:
    """Return the value of a function for each item, computed side by side.

    One item alone has too few lanes to keep a processor busy.
    """
    with ThreadPoolExecutor(available_threads()) as pool:
        futures = [pool.submit(function, item) for item in items]
        progress = track(futures, description) if description else futures
        return {item: future.result() for item, future in zip(items, progress, strict=True)}


# --- the global minimum of Err -------------------------------------------------------------------


@dataclass(frozen=True)
class Minima:
    """Global minima of Err.

    Attributes
    ----------
    damping_ratio : ndarray, shape (lengths, cases)
        Damping ratio xi at the minimum. [-]
    error : ndarray, shape (lengths, cases)
        Err, Eq. (17), over the steps of the response length. [-]
    local_minima : ndarray of int, shape (lengths, cases)
        Number of local minima of Err in the scan.
    """

    damping_ratio: Array
    error: Array
    local_minima: NDArray[np.int64]


def global_minima(cases: Cases, damping_model: str, response_length_steps: ArrayLike) -> Minima:
    """Find the global minimum of Err over the damping ratio for each case and response length.

    A scan over multiples of the closed form's ratio finds the basins of all response lengths in
    one pass. The lowest basins are refined by bracketing, all cases at once. Of equal minima the
    smaller damping ratio is taken.

    Parameters
    ----------
    cases : Cases
        Decays.
    damping_model : str
        Viscous model.
    response_length_steps : sequence of int
        Response lengths in steps of the decays, ascending.

    Raises
    ------
    InputError
        If a minimum lies at the edge of the scan, or a response ends before the first impact.
    """
    lengths = np.asarray(response_length_steps, dtype=np.int64)
    shape = (lengths.size, cases.restitution.size)
    minima = Minima(np.zeros(shape), np.zeros(shape), np.ones(shape, dtype=np.int64))
    lossy = np.flatnonzero(cases.restitution < 1)  # where e = 1, xi = 0 has no error
    if not lossy.size:
        return minima
    cases = cases.take(lossy)
    _require_impact(cases, lengths)
    trial, scanned = _scan(cases, damping_model, lengths)
    _require_interior(cases, damping_model, lengths, scanned, trial)
    inner = scanned[..., 1:-1]
    is_minimum = (inner < scanned[..., :-2]) & (inner <= scanned[..., 2:])
    minima.local_minima[:, lossy] = is_minimum.sum(axis=-1)
    minima.error[:, lossy] = np.inf
    lowest = scanned.min(axis=-1)[..., None]
    # The ripple and the longer step of the scan change Err by less than half.
    rivals = is_minimum & (inner <= 1.5 * lowest)
    at_once = 8  # response lengths that are refined together: each runs to the longest of them
    for start in range(0, lengths.size, at_once):
        part = slice(start, start + at_once)
        length, case, point = np.nonzero(rivals[part])
        bracket = np.stack([trial[case, point + shift] for shift in range(3)])
        ratio, error = _refine(cases, damping_model, lengths[part], length, case, bracket)
        # In ascending order of xi, so that of equal errors the first stays.
        for row, column, xi, value in zip(start + length, lossy[case], ratio, error, strict=True):
            if value < minima.error[row, column]:
                minima.damping_ratio[row, column] = xi
                minima.error[row, column] = value
    return minima


def _require_impact(cases: Cases, lengths: NDArray[np.int64]) -> None:
    shortest = lengths.min() * cases.step
    first_impact = cases.curve.period(cases.release_amplitude).max() / 4
    if shortest <= first_impact:
        raise InputError(
            f"response_length is {shortest:.6g}; it must be longer than {first_impact:.6g} in tau, "
            "the time of the first impact, before which no damping ratio is defined"
        )


def _scan(
    cases: Cases, damping_model: str, lengths: NDArray[np.int64]
) -> tuple[Array, NDArray[Any]]:
    """Return damping ratios, shape (cases, ratios), and their Err for each response length."""
    guess = damping_ratio_energy(
        cases.curve, damping_model, cases.restitution, cases.release_amplitude
    )
    trial = np.minimum(guess[:, None] * SCAN, DAMPERS[damping_model].largest_value)
    # A longer step suffices to find the basins: for 140 walls and five dampers, scans with caps of
    # 0.0025 to 0.04 led to the same ratios within 0.5 %. At a twentieth of the stability limit,
    # four steps cross BAND's band.
    longest = min(0.01, float(stable_step(cases.curve).min()) / 20)
    stride = max(1, int(longest / cases.step + 0.5))
    rows = np.arange(len(trial))[:, None]
    marks = np.maximum(lengths // stride, 1)
    return trial, cases.errors(damping_model, trial, rows, marks, stride)


def _require_interior(
    cases: Cases, model: str, lengths: NDArray[np.int64], scanned: Array, trial: Array
) -> None:
    lowest = scanned.argmin(axis=-1)
    edges = np.argwhere((lowest == 0) | (lowest == scanned.shape[-1] - 1))
    if edges.size:
        row, case = edges[0]
        raise InputError(
            f"Err of {model} at e = {cases.restitution[case]:.6g}, "
            f"u0/u_ins = {cases.release_amplitude[case]:.6g} and "
            f"response_length {lengths[row] * cases.step:.6g} is lowest at the edge of the scan, "
            f"xi = {trial[case, lowest[row, case]]:.6g}; use damping_ratio_energy, which needs none"
        )


def _refine(
    cases: Cases,
    model: str,
    lengths: NDArray[np.int64],
    length: NDArray[np.int64],
    case: NDArray[np.int64],
    bracket: Array,
) -> tuple[Array, Array]:
    """Return damping ratio and Err at the minimum of each bracket of the scan, shape (brackets,).

    `length` and `case` are the place of each bracket among the lengths and the cases; `bracket`,
    shape (3, brackets), has the damping ratio of its lowest point between its neighbours.
    """
    from scipy.optimize import elementwise  # slow to import

    def err(xi: Array, lane: NDArray[Any]) -> Array:
        lane = lane.astype(np.int64)  # SciPy makes floats of it
        errors = cases.errors(model, xi, case[lane], lengths)
        return errors[length[lane], np.arange(lane.size)]

    low, middle, high = bracket
    lane = np.arange(middle.size, dtype=float)
    # The longer step of the scan may have moved the minimum by a point.
    ends = elementwise.bracket_minimum(err, middle, xl0=low, xr0=high, xmin=0.0, args=(lane,))
    tolerances = {"xrtol": RESOLUTION, "frtol": 1e-13}
    minimum = elementwise.find_minimum(err, ends.bracket, args=(lane,), tolerances=tolerances)
    failed = ~(ends.success & minimum.success)
    if failed.any():
        raise _not_bracketed(model, middle[failed][0])
    return minimum.x, minimum.f_x


def _not_bracketed(model: str, xi: float) -> InputError:
    return InputError(
        f"Err of {model} has no minimum near xi = {xi:.6g}; use damping_ratio_energy, which needs "
        "none"
    )


# --- the minimum of the integral, free of the ripple of its steps --------------------------------


def integral_minima(cases: Cases, damping_model: str, steps: int, damping_ratio: Array) -> Array:
    """Find the least integral of (|u_CR| - |u|)^2 next to damping ratios; shape (2, cases). [-]

    The first row is found from all nodes of the cubic, the second from the inner half of them:
    their difference says how well a cubic fits.

    Parameters
    ----------
    cases : Cases
        Decays.
    damping_model : str
        Viscous model.
    steps : int
        Number of steps of the decays over which the integral is taken.
    damping_ratio : ndarray, shape (cases,)
        Damping ratios to start from. A ratio of 0, which belongs to e = 1, stays. [-]

    Raises
    ------
    InputError
        If there is no minimum next to a damping ratio.
    """
    # Half the range, divided by its middle. The range is proportional to the step, so that it holds
    # the same number of periods of the ripple at every step. Over more than a tenth of xi, Err is
    # no cubic.
    width = min(8.0 * cases.step, 0.1)
    middle = damping_ratio.copy()
    minima = np.zeros((2, damping_ratio.size))
    moving = np.flatnonzero(damping_ratio > 0)
    for _ in range(50):  # the first range nearly always holds the minimum
        if not moving.size:
            return minima
        trial = middle[moving, None] * (1 + width * CUBIC_NODES)
        sums = cases.errors(damping_model, trial, moving[:, None], [steps - 1, steps])
        # The integral by the trapezoidal rule, divided by the step: the mean of the two sums counts
        # the last sample half, and the first sample is 0.
        integral = sums.mean(axis=0)
        minimum = _least_of_cubic(CUBIC_NODES, integral)
        inner = _least_of_cubic(CUBIC_NODES[INNER_NODES], integral[:, INNER_NODES])
        minima[:, moving] = middle[moving] * (1 + width * np.stack([minimum, inner]))
        middle[moving] = minima[0, moving]
        largest = CUBIC_NODES[INNER_NODES][-1]  # the inner range must hold the minimum
        moving = moving[np.abs(minimum) > largest]
    raise _not_bracketed(damping_model, damping_ratio[moving[0]])


def _least_of_cubic(nodes: Array, values: Array) -> Array:
    """Return the place in [-1, 1] of the least value of a cubic fitted to each row.

    It is the minimum of the cubic, or the end downhill.
    """
    fit = np.linalg.pinv(np.vander(nodes, 4, increasing=True))[1:]
    # Node by node: a product of matrices rounds otherwise with another number of rows, and the
    # ratio of a wall must not depend on the others.
    terms = [np.multiply.outer(fit[:, node], values[:, node]) for node in range(nodes.size)]
    slope, curvature, third = sum(terms)
    # The slope of the cubic is slope + 2 curvature x + 3 third x^2. Its zero with a rising slope is
    # written so that a third of 0 divides nothing.
    root = np.sqrt(np.maximum(curvature**2 - 3 * slope * third, 0.0))
    convex = curvature + root > 0
    minimum = -slope / np.where(convex, curvature + root, 1.0)
    return np.clip(np.where(convex, minimum, -np.sign(slope)), -1.0, 1.0)


# --- the words under Eq. (17) in place of its formula --------------------------------------------


def least_absolute(cases: Cases, damping_model: str, least_squares: Array, steps: int) -> Array:
    """Return the damping ratio of the least sum of ``||u_CR| - |u||`` for each case. [-]

    A coarse grid within a factor 1.8 of the start, and a fine one between the neighbours of its
    minimum, with points 0.06 % apart.

    Parameters
    ----------
    cases : Cases
        Decays.
    damping_model : str
        Viscous model.
    least_squares : ndarray, shape (cases,)
        Damping ratios of least squares, from which the search starts. [-]
    steps : int
        Number of steps of the decays over which the sum is taken.
    """
    ratios = np.empty_like(least_squares)
    for case, ratio in enumerate(least_squares):
        reference = np.abs(cases.displacement[case, : steps + 1])
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
            sums = np.abs(np.abs(response.displacement) - reference).sum(axis=-1)
            ratio = trial[sums.argmin()]
            width = trial[1] / trial[0]
        ratios[case] = ratio
    return ratios
