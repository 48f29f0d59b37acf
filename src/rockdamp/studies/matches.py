"""The viscous models matched to the stored decays of a study."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config.parsing import Config
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.equivalence.matching import RESOLUTION, Cases, follow, match_cases, refined, response_length
from rockdamp.equivalence.scan import Scan
from rockdamp.progress import track
from rockdamp.solvers.newmark import available_threads
from rockdamp.studies.decays import describe, step_count
from rockdamp.studies.settings import Study, make_wall
from rockdamp.vocabulary import VISCOUS_MODELS


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
    restitution, scan = decays["restitution"].values, Scan(**config["matching"]["scan"])
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


def _windows_of_fixed_seconds(study: Study, config: Config, window: float) -> Array:
    """Window of each wall, in tau, when all have the length in seconds of the config's wall."""
    seconds = window / float(make_wall(config["wall"]).frequency_parameter)
    return seconds * study.frequency_parameter


def _match_each(cases: Cases, model: str, windows: Array, known: tuple[float, Array], scan: Scan, scheme: str) -> Array:
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
