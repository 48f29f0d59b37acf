"""Accuracy: errors of the solver and of the damping ratios, where small rotations matter, and the energy audit."""

from __future__ import annotations

from collections.abc import Iterator
from operator import itemgetter

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config.parsing import Config
from rockdamp.mechanics.damping import Damping
from rockdamp.progress import track
from rockdamp.solvers import event_driven
from rockdamp.studies.accuracy import energy_audit, matched_ratios
from rockdamp.studies.accuracy.ensemble import EXCITATIONS, Ensemble, collect, fitted_order
from rockdamp.studies.accuracy.small_rotations import rotations
from rockdamp.vocabulary import MODELS, STUDIES


def accuracy(
    config: Config,
    amplitude: xr.Dataset,
    slenderness: xr.Dataset,
    overburden: xr.Dataset,
    cracked_stiffness: xr.Dataset,
    loops: xr.Dataset,
    *decays: xr.Dataset,
) -> xr.Dataset:
    """Measure how accurate the published numbers are.

    Parameters
    ----------
    config : dict
        Validated; uses ``solver``, ``wall``, ``curve``, ``release_amplitude``, ``restitution``, ``studies``,
        ``matching``, ``loops``, ``validation`` and ``accuracy``.
    amplitude, slenderness, overburden, cracked_stiffness : xarray.Dataset
        What `matching_studies.match` returned for each study.
    loops : xarray.Dataset
        What `loops.loops` returned.
    *decays : xarray.Dataset
        What `decay.study` returned for each study, in the order of `STUDIES`.
    """
    matches = dict(zip(STUDIES, (amplitude, slenderness, overburden, cracked_stiffness), strict=True))
    ensemble = collect(config, matches)
    parts = [
        solver_errors(config, ensemble),
        matched_ratios.uncertainty(matches),
        matched_ratios.minima(config, matches),
        rotations(config, loops),
        energy_audit.residuals(config, ensemble),
        energy_audit.stored(config, loops, dict(zip(STUDIES, decays, strict=True))),
        energy_audit.losses(config, loops),
    ]
    return xr.merge(parts, compat="no_conflicts", join="exact")


def solver_errors(config: Config, ensemble: Ensemble) -> xr.Dataset:
    """Compare the pipeline's solver with the event-driven one, free and forced, against the step.

    The error of a history is the root mean square of u/u_ins less the exact one, over the times of the coarsest step.

    Parameters
    ----------
    config : dict
        Validated; uses ``solver`` and ``accuracy``.
    ensemble : Ensemble
    """
    steps, own = ensemble.steps, int(np.argmin(np.abs(ensemble.steps - config["solver"]["step"])))
    error = np.empty((len(EXCITATIONS), len(MODELS), *ensemble.factor.shape, steps.size))
    largest = np.empty(error.shape[:2])
    peak = np.zeros((len(EXCITATIONS), *ensemble.factor.shape))
    cells = [(x, m) for x in range(len(EXCITATIONS)) for m in range(len(MODELS))]
    lanes = ensemble.factor.size
    references = iter(track(_exact(ensemble, cells), "exact histories", len(cells) * lanes))
    for x, m in cells:
        expected = np.stack([next(references) for _ in range(lanes)]).reshape(*ensemble.factor.shape, -1)
        peak[x] = np.maximum(peak[x], np.abs(expected).max(axis=-1))
        for k, step in enumerate(steps):
            found, _ = ensemble.histories(MODELS[m], EXCITATIONS[x], float(step), 2**k)
            error[x, m, ..., k] = np.sqrt(np.mean((found - expected) ** 2, axis=-1))
            if k == own:
                largest[x, m] = np.abs(found - expected).max()
    dims = ("excitation", "damping_model")
    median = np.median(error, axis=(2, 3))
    return xr.Dataset(
        {
            "solver_error": ((*dims, "case", "restitution", "step"), error),
            "median_solver_error": ((*dims, "step"), median),
            "largest_solver_error": ((*dims, "step"), error.max(axis=(2, 3))),
            "order": (dims, fitted_order(steps, median)),
            "largest_difference": (dims, largest),
            "largest_displacement": (("excitation", "case", "restitution"), peak),
        },
        coords={
            "excitation": list(EXCITATIONS),
            "damping_model": list(MODELS),
            "restitution": ensemble.restitution,
            "step": steps,
            "solver_step": float(config["solver"]["step"]),
            "published_step": float(config["solver"]["step"]) / int(config["matching"]["refinement"]),
            "release_amplitude": ("case", ensemble.release_amplitude[:, 0]),
            "cracked_stiffness_ratio": ("case", ensemble.curve.cracked_stiffness_ratio[:, 0]),
            "plateau_ratio": ("case", ensemble.curve.plateau_ratio[:, 0]),
        },
    )


def _exact(ensemble: Ensemble, cells: list[tuple[int, int]]) -> Iterator[Array]:
    """Yield the exact displacement of each lane of each cell, at the multiples of the coarsest step."""
    spacing = float(ensemble.steps[0])
    times = spacing * np.arange(round((ensemble.load.shape[-1] - 1) * ensemble.sample / spacing) + 1)
    for x, m in cells:
        forced = EXCITATIONS[x] == "forced"
        parameter = np.broadcast_to(ensemble.damping(MODELS[m]).parameter, ensemble.factor.shape)
        for case, e in np.ndindex(*ensemble.factor.shape):
            yield event_driven.history(
                ensemble.curve.map(itemgetter((case, 0))),
                Damping(MODELS[m], float(parameter[case, e])),
                times,
                release_amplitude=0.0 if forced else float(ensemble.release_amplitude[case, 0]),
                load=ensemble.factor[case, e] * ensemble.load[case] if forced else (),
                load_step=ensemble.sample,
            ).displacement
