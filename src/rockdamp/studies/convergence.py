"""Order of convergence of both schemes for each damper, on walls, free and forced."""

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

SCHEMES = ("newmark", "paper")
EXCITATIONS = ("free", "forced")


def fitted_order(steps: ArrayLike, error: ArrayLike) -> Array:
    """Return the slope of log(error) against log(step), fitted over the last axis. [-]"""
    log_steps = np.log(np.asarray(steps, dtype=float))
    log_errors = np.log(np.asarray(error, dtype=float))
    columns = log_errors.reshape(-1, log_errors.shape[-1]).T
    slope = np.polyfit(log_steps, columns, 1)[0]
    return np.asarray(slope.reshape(log_errors.shape[:-1]))


class Ensemble(NamedTuple):
    """Seeded walls and a shared load.

    The error of a single history is erratic: its corners fall anywhere in a step.

    Parameters
    ----------
    curve : TrilinearCurve
        Curves, shape (lanes,).
    release_amplitude : ndarray, shape (lanes,)
        Displacements of the release, u0/u_ins. [-]
    restitution : ndarray, shape (lanes,)
        Restitution coefficients. [-]
    load_factor : ndarray, shape (lanes,)
        Factors of the load. [-]
    ground : ndarray, shape (samples,)
        Shared load.
    """

    curve: TrilinearCurve
    release_amplitude: Array
    restitution: Array
    load_factor: Array
    ground: Array


def draw(seed: int, lanes: int, samples: int, sample: float) -> Ensemble:
    """Draw walls and a band-limited load with a sample every `sample` in tau."""
    rng = np.random.default_rng(seed)
    curve = TrilinearCurve(rng.uniform(0.02, 0.12, lanes), rng.uniform(0.5, 0.85, lanes))
    # Twelve sines; phases are in turns.
    frequency, phase = rng.uniform(0.3, 3.0, (2, 12))[..., None]
    tau = sample * np.arange(samples)
    ground = np.sin(frequency * tau + 2 * np.pi * phase).sum(axis=0)
    release_amplitude = rng.uniform(0.2, 0.8, lanes)
    restitution = rng.uniform(0.75, 0.95, lanes)
    load_factor = rng.uniform(0.01, 0.05, lanes)
    return Ensemble(curve, release_amplitude, restitution, load_factor, ground)


def convergence(config: Config) -> xr.Dataset:
    """Measure the error of the displacement against the step, and its order.

    The error of a history is the root mean square over the times of the coarsest step, against the
    default scheme at a sixteenth of the finest step. The error of the ensemble is the median, on
    which a wall near collapse has no influence.
    """
    settings = config.convergence
    coarsest = settings.coarsest
    substeps = 2 ** np.arange(settings.halvings + 1)
    finest = 16 * int(substeps[-1])
    samples = step_count(settings.length, coarsest) + 1
    ensemble = draw(settings.seed, settings.lanes, samples, coarsest)
    error = np.empty((len(SCHEMES), len(EXCITATIONS), len(MODELS), substeps.size))
    for excitation_index, model_index in track(list(np.ndindex(error.shape[1:3])), "orders"):
        excitation = EXCITATIONS[excitation_index]
        model = MODELS[model_index]
        exact = run_ensemble(ensemble, model, excitation, "newmark", coarsest, finest)
        for scheme_index, scheme in enumerate(SCHEMES):
            for k, count in enumerate(substeps):
                displacement = run_ensemble(
                    ensemble, model, excitation, scheme, coarsest, int(count)
                )
                lane_error = np.sqrt(np.mean((displacement - exact) ** 2, axis=-1))
                error[scheme_index, excitation_index, model_index, k] = np.nanmedian(lane_error)
    steps = coarsest / substeps
    dims = ("scheme", "excitation", "damping_model")
    return xr.Dataset(
        {
            "solver_error": ((*dims, "step"), error),
            "convergence_order": (dims, fitted_order(steps, error)),
            "finest_convergence_order": (dims, np.log2(error[..., -2] / error[..., -1])),
        },
        coords={
            "scheme": list(SCHEMES),
            "excitation": list(EXCITATIONS),
            "damping_model": list(MODELS),
            "step": steps,
        },
    )


def run_ensemble(
    ensemble: Ensemble, model: str, excitation: str, scheme: str, sample: float, substeps: int
) -> Array:
    """Return displacements at the samples of the load, NaN in lanes that collapse.

    Parameters
    ----------
    ensemble : Ensemble
        Walls and load.
    model : str
        Damping model.
    excitation : {"free", "forced"}
        Decay after the release, without or with the load.
    scheme : {"newmark", "paper"}
        Scheme of the solver.
    sample : float
        Time between samples in tau. [-]
    substeps : int
        Steps of the solver between samples.
    """
    e = ensemble.restitution
    if model == REFERENCE:
        damping = Damping(model, e)
    else:
        # Any damping ratio would do; this one loses about as much as e.
        xi = Damping.from_restitution(e, "ECD").value
        damping = Damping(model, xi)
    load_factor = ensemble.load_factor if excitation == "forced" else 0.0
    histories = simulate(
        ensemble.curve,
        damping,
        release_amplitude=ensemble.release_amplitude,
        load=Load(ensemble.ground, load_factor, sample, substeps),
        store_every=substeps,
        scheme=scheme,
    )
    return np.where(histories.collapsed[:, None], np.nan, histories.displacement)
