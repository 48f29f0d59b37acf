"""Error minimisation: the damping ratio with which a viscous model follows a decay under restitution best, Eq. (17)."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import elementwise

from rockdamp.curve import TrilinearCurve
from rockdamp.damping import VISCOUS_MODELS, Damping
from rockdamp.decay import Config, Study, describe, make_wall, step_count
from rockdamp.energy import damping_ratio_energy
from rockdamp.errors import InputError, Quantity
from rockdamp.newmark import Reference, available_threads, solve, stable_step
from rockdamp.progress import track

# ASSUME: the length of the response, in tau, which the paper does not state. Inferred as `windows.infer` says, and kept
# equal to results/windows.nc by a test.
DEFAULT_WINDOW = 8.0

SCAN: dict[str, Any] = {"smallest": 0.3, "largest": 3.0, "points": 200}
SCAN_STEP = 0.01  # in tau; finding the basins needs no more
RIVALS = 1.5  # local minima of the scan within this factor of the lowest are refined, then compared
WINDOWS_AT_ONCE = 8
RESOLUTION = 3e-5  # of the minimiser, in parts of xi
NEARBY = 0.001  # first bracket around a damping ratio that is known already, in parts of it

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Cases:
    """Decays to be matched, one per row.

    Parameters
    ----------
    curve : TrilinearCurve
        With parameters of shape (cases,).
    release_amplitude, restitution : ndarray, shape (cases,)
    displacement : ndarray, shape (cases, steps + 1)
        Of the reference, at each step of the solver. [-]
    step : float
        In tau.
    exponent : float or ndarray, shape (cases,)
        n of the general exponent, for the model ``"POWER"`` alone. [-]
    """

    curve: TrilinearCurve
    release_amplitude: Array
    restitution: Array
    displacement: Array
    step: float
    exponent: Quantity = 0.0

    def take(self, case: slice | NDArray[np.int64]) -> Cases:
        """Return some of the cases."""
        return Cases(
            self.curve_of(case),
            self.release_amplitude[case],
            self.restitution[case],
            self.displacement[case],
            self.step,
            self.exponents[case],
        )

    def curve_of(self, case: Any) -> TrilinearCurve:
        """Return the curves of some cases."""
        return self.curve.map(lambda parameter: parameter[case])

    @property
    def exponents(self) -> Array:
        """The exponent of each case."""
        return np.broadcast_to(np.asarray(self.exponent, dtype=float), self.restitution.shape)

    def damping_of(self, damping_model: str, damping_ratio: Array, case: Any) -> Damping:
        """Return the dampers of some cases."""
        return Damping(damping_model, damping_ratio, self.exponents[case])


@dataclass(frozen=True)
class Match:
    """Best damping ratios; every array has the shape (windows, cases).

    Attributes
    ----------
    damping_ratio : ndarray
        xi at the global minimum of Err. [-]
    error : ndarray
        Err, Eq. (17), over the steps 1 to k of the window. [-]
    local_minima : ndarray of int
        Number of local minima of Err over the damping ratios tried.
    """

    damping_ratio: Array
    error: Array
    local_minima: NDArray[np.int64]


def match_cases(
    cases: Cases,
    damping_model: str,
    window_steps: ArrayLike,
    scan: dict[str, Any] | None = None,
    scheme: str = "newmark",
) -> Match:
    """Find the global minimum of Err over the damping ratio for each case and window.

    A scan over multiples of the closed form's damping ratio finds the basins, for all windows in one pass; the lowest
    are refined by bracketing, all lanes at once. Of equal minima the smaller damping ratio is taken.

    Parameters
    ----------
    cases : Cases
    damping_model : str
        One of `VISCOUS_MODELS`, or ``"POWER"`` with the exponents of the cases.
    window_steps : sequence of int, ascending
        Lengths of the response in steps.
    scan : dict
        ``smallest``, ``largest`` (over the closed form's damping ratio) and ``points``.
    scheme : str
        Of `newmark.solve`.

    Raises
    ------
    InputError
        If a minimum lies at the edge of the scan, or a window ends before the first impact.
    """
    windows = np.asarray(window_steps, dtype=np.int64)
    scan = scan or SCAN
    lossy = np.flatnonzero(cases.restitution < 1)
    if lossy.size < cases.restitution.size:
        return _lossless(cases, damping_model, windows, scan, scheme, lossy)
    _require_impacts(cases, windows)
    guess = damping_ratio_energy(
        cases.curve, damping_model, cases.restitution, cases.release_amplitude, cases.exponents
    )
    trial = guess[:, None] * np.geomspace(scan["smallest"], scan["largest"], scan["points"])
    coarse = _scan(cases, damping_model, trial, windows, scheme)
    lower = (coarse[..., 1:-1] < coarse[..., :-2]) & (coarse[..., 1:-1] <= coarse[..., 2:])
    lowest = coarse.min(axis=-1)
    _require_interior(cases, damping_model, windows, coarse, trial)
    rivals = lower & (coarse[..., 1:-1] <= RIVALS * lowest[..., None])
    window, case, point = np.nonzero(rivals)
    ratio, error = np.empty(window.size), np.empty(window.size)
    for some in np.array_split(np.arange(windows.size), -(-windows.size // WINDOWS_AT_ONCE)):
        chosen = np.isin(window, some)
        around = [trial[case[chosen], point[chosen] + shift] for shift in (0, 1, 2)]
        ratio[chosen], error[chosen] = _refine(
            cases, damping_model, windows[some], window[chosen] - some[0], case[chosen], around, scheme
        )
    best = Match(np.full(lowest.shape, np.nan), np.full(lowest.shape, np.inf), lower.sum(axis=-1))
    for w, c, xi, value in zip(window, case, ratio, error):  # ascending in xi: of equal errors the first stays
        if value < best.error[w, c]:
            best.damping_ratio[w, c], best.error[w, c] = xi, value
    return best


def _lossless(
    cases: Cases, model: str, windows: NDArray[np.int64], scan: dict[str, Any], scheme: str, lossy: NDArray[np.int64]
) -> Match:
    """Match the cases that lose energy; where e = 1, xi = 0 follows the reference, with one minimum and no error."""
    shape = (windows.size, cases.restitution.size)
    best = Match(np.zeros(shape), np.zeros(shape), np.ones(shape, dtype=np.int64))
    if lossy.size:
        found = match_cases(cases.take(lossy), model, windows, scan, scheme)
        best.damping_ratio[:, lossy], best.error[:, lossy] = found.damping_ratio, found.error
        best.local_minima[:, lossy] = found.local_minima
    return best


def _require_impacts(cases: Cases, windows: NDArray[np.int64]) -> None:
    first = cases.curve.period(cases.release_amplitude).max() / 4
    if windows.min() * cases.step <= first:
        raise InputError(
            f"window is {windows.min() * cases.step:.6g}; it must be longer than {first:.6g} in tau, the time of the"
            " first impact, before which no damping ratio is defined"
        )


def _require_interior(cases: Cases, model: str, windows: NDArray[np.int64], coarse: Array, trial: Array) -> None:
    at = coarse.argmin(axis=-1)
    bad = np.argwhere((at == 0) | (at == coarse.shape[-1] - 1))
    if bad.size:
        w, c = bad[0]
        raise InputError(
            f"Err of {model} at e = {cases.restitution[c]:.6g}, u0/u_ins = {cases.release_amplitude[c]:.6g} and window"
            f" {windows[w] * cases.step:.6g} is lowest at the edge of the scan, xi = {trial[c, at[w, c]]:.6g};"
            " matching.scan must reach further"
        )


def _scan(cases: Cases, model: str, trial: Array, windows: NDArray[np.int64], scheme: str) -> Array:
    """Err on the grid of damping ratios, shape (windows, cases, points), at a coarser step."""
    stable = float(stable_step(cases.curve).min())
    every = max(1, int(min(SCAN_STEP, stable / 4) / cases.step + 0.5))
    marks = np.maximum(windows // every, 1)
    index = np.arange(cases.restitution.size)[:, None]
    response = solve(
        cases.curve_of(index),
        cases.damping_of(model, trial, index),
        release_amplitude=cases.release_amplitude[:, None],
        step=cases.step * every,
        steps=int(marks[-1]),
        reference=Reference(cases.displacement[:, ::every], index, marks),
        scheme=scheme,
    )
    assert response.error is not None
    return response.error


def _refine(
    cases: Cases,
    model: str,
    windows: NDArray[np.int64],
    window: NDArray[np.int64],
    case: NDArray[np.int64],
    around: list[Array],
    scheme: str,
) -> tuple[Array, Array]:
    """Damping ratio and Err at the minimum next to each bracket of the scan."""

    def err(xi: Array, window_: Array, case_: Array) -> Array:
        window, case = window_.astype(np.int64), case_.astype(np.int64)
        response = solve(
            cases.curve_of(case),
            cases.damping_of(model, xi, case),
            release_amplitude=cases.release_amplitude[case],
            step=cases.step,
            steps=int(windows[-1]),
            reference=Reference(cases.displacement, case, windows),
            scheme=scheme,
        )
        assert response.error is not None
        return np.take_along_axis(response.error, window[None], axis=0)[0]

    args = (window.astype(float), case.astype(float))
    low, middle, high = around
    bracket = elementwise.bracket_minimum(err, middle, xl0=low, xr0=high, xmin=0.0, args=args)
    if not bracket.success.all():
        bad = np.flatnonzero(~bracket.success)[0]
        raise InputError(f"the minimum of Err of {model} near xi = {middle[bad]:.6g} could not be bracketed")
    found = elementwise.find_minimum(err, bracket.bracket, args=args, tolerances={"xrtol": RESOLUTION, "frtol": 1e-13})
    if not found.success.all():
        bad = np.flatnonzero(~found.success)[0]
        raise InputError(f"the minimum of Err of {model} near xi = {middle[bad]:.6g} did not converge")
    return found.x, found.f_x


def cases_of(study: Study, restitution: Array, displacement: Array, step: float) -> Cases:
    """Flatten the decays of a study, shape (study parameter, restitution, tau), to cases."""
    count = restitution.size
    return Cases(
        study.curve.map(lambda parameter: np.repeat(parameter, count)),
        np.repeat(study.release_amplitude, count),
        np.tile(restitution, study.values.size),
        displacement.reshape(study.values.size * count, -1),
        step,
    )


def response_length(config: Config) -> float:
    """Return the window that the config states, in tau."""
    window = config["matching"]["window"]
    return DEFAULT_WINDOW if window == "default" else float(window)


def match(name: str, config: Config, decays: xr.Dataset) -> xr.Dataset:
    """Match every viscous model to the stored decays of one study.

    The global minimum is found against the stored decays and then followed to a finer step, in the reference and in
    the model. The uncertainty is twice the change over the last halving of the step, where the change itself would
    bound the error of a first-order method: |u| sampled at the steps puts a ripple of that order on Err. It is never
    less than the resolution of the minimiser.

    For slenderness and overburden the response length is also held in seconds, at the length that the wall of the
    config has: then the walls' lengths in tau differ, and with them the damping ratios. Those other lengths are matched
    at the solver's step.

    Parameters
    ----------
    name : str
        One of `decay.STUDIES`.
    config : dict
        Validated; uses what `decay.study` uses, and ``matching``.
    decays : xarray.Dataset
        What `decay.study` returned.

    Returns
    -------
    xarray.Dataset
        ``damping_ratio``, ``damping_ratio_uncertainty``, ``damping_ratio_energy``, ``error``, ``rms_error`` and
        ``local_minima`` (damping_model, study parameter, restitution), with the ``step`` and the number of ``steps``
        that Err sums over.
    """
    study, step, scheme = describe(name, config), float(config["solver"]["step"]), config["solver"]["scheme"]
    restitution, scan = decays["restitution"].values, config["matching"]["scan"]
    window, refinement = response_length(config), int(config["matching"]["refinement"])
    steps = step_count(window, step)
    fixed = _windows_of_fixed_seconds(study, config, window) if name in ("slenderness", "overburden") else None
    last = steps if fixed is None else max(steps, step_count(float(fixed.max()), step))
    stored = np.ascontiguousarray(decays["displacement"].values[..., : last + 1], dtype=float)
    cases = cases_of(study, restitution, stored, step)
    unlike, which = _alike(cases)
    some = cases.take(unlike)
    finest, coarser = (refined(some, steps, many, scheme) for many in (refinement, refinement / 2))
    dims = ("damping_model", study.parameter, "restitution")
    shape = (study.values.size, restitution.size)
    found: dict[str, list[Array]] = {}

    def of_model(model: str) -> dict[str, Array]:
        best = match_cases(some, model, [steps], scan, scheme)
        before, _ = follow(coarser, model, best.damping_ratio[0], scheme)
        ratio, error = follow(finest, model, before, scheme)
        values = {
            "damping_ratio": ratio,
            "damping_ratio_uncertainty": np.maximum(2 * np.abs(ratio - before), RESOLUTION * ratio),
            "damping_ratio_energy": damping_ratio_energy(some.curve, model, some.restitution, some.release_amplitude),
            "error": error,
            "rms_error": np.sqrt(error / (steps * refinement)),
            "local_minima": best.local_minima[0],
        }
        values = {key: value[which] for key, value in values.items()}
        if fixed is not None:
            known = (window, values["damping_ratio"])
            values["damping_ratio_fixed_seconds"] = _match_each(cases, model, fixed, known, scan, scheme)
        return values

    with ThreadPoolExecutor(available_threads()) as pool:  # models side by side: a few lanes alone fill no processor
        for values in track(pool.map(of_model, VISCOUS_MODELS), f"match {name}", len(VISCOUS_MODELS)):
            for key, value in values.items():
                found.setdefault(key, []).append(value.reshape(shape))
    dataset = xr.Dataset(
        {key: (dims, np.stack(value)) for key, value in found.items()},
        coords={"damping_model": list(VISCOUS_MODELS), "restitution": restitution},
    )
    kept = {
        key: decays[key] for key in (study.parameter, "frequency_parameter", "plateau_ratio") if key in decays.coords
    }
    return dataset.assign_coords(kept).assign_coords(window=window, step=finest.step, steps=steps * refinement)


def refined(cases: Cases, steps: int, refinement: float, scheme: str = "newmark") -> Cases:
    """Return the decays over `steps` steps again, with `refinement` steps in place of each."""
    step = cases.step / refinement
    response = solve(
        cases.curve,
        Damping.cr(cases.restitution),
        release_amplitude=cases.release_amplitude,
        step=step,
        steps=round(steps * refinement),
        store_every=1,
        scheme=scheme,
    )
    assert response.displacement is not None
    return replace(cases, displacement=response.displacement, step=step)


def follow(cases: Cases, model: str, ratio: Array, scheme: str = "newmark") -> tuple[Array, Array]:
    """Return the damping ratio and Err, each of shape (cases,), of the minimum next to `ratio` over all the steps."""
    case = np.flatnonzero(ratio > 0)  # xi = 0 belongs to e = 1, which stays there
    found, error = np.zeros(ratio.size), np.zeros(ratio.size)
    if case.size:
        around = [ratio[case] * factor for factor in (1 - NEARBY, 1.0, 1 + NEARBY)]
        steps, window = np.array([cases.displacement.shape[1] - 1]), np.zeros(case.size, dtype=np.int64)
        found[case], error[case] = _refine(cases, model, steps, window, case, around, scheme)
    return found, error


def _windows_of_fixed_seconds(study: Study, config: Config, window: float) -> Array:
    """Window of each wall, in tau, when all have the length in seconds of the config's wall."""
    seconds = window / float(make_wall(config["wall"]).frequency_parameter)
    return seconds * study.frequency_parameter


def _match_each(
    cases: Cases, model: str, windows: Array, known: tuple[float, Array], scan: dict[str, Any], scheme: str
) -> Array:
    """Damping ratio of each wall's cases at its own window; `known` holds a window that is matched already."""
    per_wall = cases.restitution.size // windows.size

    def of_wall(wall: int) -> Array:
        own = slice(wall * per_wall, (wall + 1) * per_wall)
        if np.isclose(windows[wall], known[0], rtol=1e-12):
            return known[1][own]
        return match_cases(cases.take(own), model, [step_count(windows[wall], cases.step)], scan, scheme).damping_ratio[
            0
        ]

    return np.concatenate([of_wall(wall) for wall in range(windows.size)])


def _alike(cases: Cases) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Indices of the cases that differ, and which of them each case is: walls of one curve pose one problem in tau."""
    c = cases.curve
    problem = [c.cracked_stiffness_ratio, c.plateau_ratio, c.ultimate_ratio, cases.release_amplitude, cases.restitution]
    _, first, which = np.unique(np.stack(problem, axis=1), axis=0, return_index=True, return_inverse=True)
    return first, which
