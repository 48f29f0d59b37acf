"""Order of convergence of both schemes for each damper, measured on an ensemble of walls, free and forced."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.constants import MODELS, REFERENCE
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.progress import track
from rockdamp.solvers.newmark import Load, simulate
from rockdamp.studies.decays import step_count


def fitted_order(steps: ArrayLike, error: ArrayLike) -> Array:
    """Return the slope of log(error) against log(step), fitted over the last axis. [-]"""
    logs = np.log(np.asarray(error, dtype=float))
    slope = np.polyfit(
        np.log(np.asarray(steps, dtype=float)), logs.reshape(-1, logs.shape[-1]).T, 1
    )[0]
    return np.asarray(slope.reshape(logs.shape[:-1]))


class Ensemble(NamedTuple):
    """Seeded walls and a shared load. A single history's error is erratic: its corners fall anywhere in a step."""

    curve: TrilinearCurve
    release_amplitude: Array
    restitution: Array
    load_factor: Array
    ground: Array


def draw(seed: int, lanes: int, samples: int, sample: float) -> Ensemble:
    """Draw walls and a band-limited load sampled every `sample` in tau."""
    rng = np.random.default_rng(seed)
    curve = TrilinearCurve(rng.uniform(0.02, 0.12, lanes), rng.uniform(0.5, 0.85, lanes))
    frequency, phase = rng.uniform(0.3, 3.0, (2, 12))[..., None]
    ground = np.sin(frequency * (sample * np.arange(samples)) + 2 * np.pi * phase).sum(axis=0)
    release, e, factor = (
        rng.uniform(low, high, lanes) for low, high in ((0.2, 0.8), (0.75, 0.95), (0.01, 0.05))
    )
    return Ensemble(curve, release, e, factor, ground)


def convergence(config: Config) -> xr.Dataset:
    """Measure the error of the displacement against the step, and its order.

    The error of a history is the root mean square over the times of the coarsest step, against the default scheme at a
    sixteenth of the finest step. That of the ensemble is the median, which a wall near collapse does not govern.
    """
    settings, schemes, excitations = config.convergence, ("newmark", "paper"), ("free", "forced")
    coarsest, finest = settings.coarsest, 16 * 2**settings.halvings
    steps = coarsest / 2.0 ** np.arange(settings.halvings + 1)
    ensemble = draw(
        settings.seed, settings.lanes, step_count(settings.length, coarsest) + 1, coarsest
    )
    error = np.empty((len(schemes), len(excitations), len(MODELS), steps.size))
    for x, m in track(list(np.ndindex(error.shape[1:3])), "orders"):
        exact = run_ensemble(ensemble, MODELS[m], excitations[x], "newmark", coarsest, finest)
        for s, scheme in enumerate(schemes):
            for k in range(steps.size):
                displacement = run_ensemble(
                    ensemble, MODELS[m], excitations[x], scheme, coarsest, 2**k
                )
                lane_error = np.sqrt(np.mean((displacement - exact) ** 2, axis=-1))
                error[s, x, m, k] = np.nanmedian(lane_error)
    dims = ("scheme", "excitation", "damping_model")
    return xr.Dataset(
        {
            "solver_error": ((*dims, "step"), error),
            "convergence_order": (dims, fitted_order(steps, error)),
            "finest_convergence_order": (dims, np.log2(error[..., -2] / error[..., -1])),
        },
        coords={
            "scheme": list(schemes),
            "excitation": list(excitations),
            "damping_model": list(MODELS),
            "step": steps,
        },
    )


def run_ensemble(
    ensemble: Ensemble, model: str, excitation: str, scheme: str, sample: float, substeps: int
) -> Array:
    """Displacements at the samples of the load; NaN in lanes that collapse."""
    e = ensemble.restitution
    response = simulate(
        ensemble.curve,
        Damping(model, e if model == REFERENCE else Damping.from_restitution(e, "ECD").value),
        release_amplitude=ensemble.release_amplitude,
        load=Load(
            ensemble.ground,
            ensemble.load_factor if excitation == "forced" else 0.0,
            sample,
            substeps,
        ),
        store_every=substeps,
        scheme=scheme,
    )
    return np.where(response.collapsed[:, None], np.nan, response.displacement)
