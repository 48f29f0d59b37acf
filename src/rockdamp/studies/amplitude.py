"""Equivalent damping ratio against the amplitude, on the reference curve, by three measures.

Peaks: over the half cycle after the release the damper loses exactly as much energy as an impact,
V(x1) = e^2 V(x0). Err: Eq. (17). Closed form: first order in the loss (docs/theory.md derives it).
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike
from scipy.optimize import elementwise

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.constants import PAPER_MODELS
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.errors import InputError
from rockdamp.histories.half_cycles import turning_points
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import simulate
from rockdamp.studies.matches import match_decays

AMPLITUDE_MODELS = (*PAPER_MODELS, "ECD")


def amplitude(config: Config) -> xr.Dataset:
    """Return damping ratios by the closed form, the first peak and the least Err."""
    settings = config.amplitude
    release = np.array(settings.release_share) * config.curve.ultimate_displacement_ratio
    grid = np.meshgrid(release, settings.restitution, indexing="ij")
    x0, e = (values.ravel() for values in grid)
    curve = config.curve.make().map(lambda parameter: np.full(x0.size, parameter))
    matching = config.matching.model_copy(update={"refinement": settings.refinement})
    matches = match_decays(curve, x0, e, AMPLITUDE_MODELS, matching, config.solver, "amplitude")
    measures = {
        "damping_ratio": [match.damping_ratio for match in matches.values()],
        "damping_ratio_uncertainty": [match.uncertainty for match in matches.values()],
        "damping_ratio_peaks": [
            damping_ratio_peaks(curve, model, e, x0) for model in AMPLITUDE_MODELS
        ],
        "damping_ratio_energy": [
            damping_ratio_energy(curve, model, e, x0) for model in AMPLITUDE_MODELS
        ],
    }
    dims = ("damping_model", "release_amplitude", "restitution")
    shape = (len(AMPLITUDE_MODELS), release.size, -1)
    return xr.Dataset(
        {name: (dims, np.reshape(values, shape)) for name, values in measures.items()},
        coords={
            "damping_model": list(AMPLITUDE_MODELS),
            "release_amplitude": release,
            "restitution": settings.restitution,
            "response_length": config.matching.response_length,
        },
    )


def damping_ratio_peaks(
    curve: TrilinearCurve, damping_model: str, restitution: ArrayLike, release_amplitude: ArrayLike
) -> Array:
    """Return the damping ratio whose first half cycle ends at CR's peak, V(x1) = e^2 V(x0). [-]

    All arguments broadcast.

    Parameters
    ----------
    curve : TrilinearCurve
        Force-displacement curve.
    damping_model : str
        Viscous model.
    restitution : float or ndarray
        Restitution coefficient e. [-]
    release_amplitude : float or ndarray
        Displacement of the release, u0/u_ins. [-]

    Raises
    ------
    InputError
        If a ratio is not within 0.25 to 4 times the closed form's.
    """
    guess = damping_ratio_energy(curve, damping_model, restitution, release_amplitude)

    def flatten(value: ArrayLike) -> Array:
        return np.broadcast_to(np.asarray(value, dtype=float), guess.shape).ravel()

    curves = curve.map(flatten)
    e = flatten(restitution)
    x0 = flatten(release_amplitude)

    # The search evaluates only the lanes that have not converged, and passes numbers as floats.
    def excess(xi: Array, lane: Array) -> Array:
        index = lane.astype(np.int64)
        lane_curves = curves.map(lambda parameter: parameter[index])
        return decrement(lane_curves, Damping(damping_model, xi), x0[index]) + np.log(e[index])

    root = elementwise.find_root(
        excess,
        (0.25 * guess.ravel(), 4.0 * guess.ravel()),
        args=(np.arange(x0.size, dtype=float),),
        tolerances={"xrtol": 1e-9, "fatol": 1e-12},
    )
    if not root.success.all():
        lane = int(np.argmin(root.success))
        raise InputError(
            f"the damping ratio of {damping_model} from the first peak at u0/u_ins ="
            f" {x0[lane]:.6g} and e = {e[lane]:.6g} was not found; it must be within 0.25 and 4"
            f" times the closed form's, {guess.flat[lane]:.6g}"
        )
    return root.x.reshape(guess.shape)


def decrement(curve: TrilinearCurve, damping: Damping, release_amplitude: Array) -> Array:
    """Return ln sqrt(V(x0)/V(x1)) over the half cycle after a release, shape (lanes,). [-]"""
    # With these steps the damping ratio of ECD, whose exact value is known, is within 0.04 %.
    steps = 5000
    longest = 1.7  # half cycle over the undamped one
    step = longest * curve.period(release_amplitude) / 2 / steps
    history = simulate(curve, damping, release_amplitude=release_amplitude, step=step, steps=steps)
    turns, _ = turning_points(history.displacement, history.velocity, step)
    if not turns.shape[1] or np.isnan(turns[:, 0]).any():
        raise InputError(
            f"a half cycle under {damping.model} lasts more than {longest} times an undamped one"
        )
    return 0.5 * np.log(curve.energy(release_amplitude) / curve.energy(turns[:, 0]))
