"""Dependence of the equivalent damping ratio on the amplitude, on the reference curve, by three measures.

Peaks: over the half cycle after the release the damper loses exactly what an impact takes, V(x1) = e^2 V(x0).
Err: Eq. (17). Closed form: first order in the loss (docs/theory.md derives it).
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

DAMPERS = (*PAPER_MODELS, "ECD")
HALF_CYCLE_STEPS = 5000  # the damping ratio of ECD from peaks, whose exact value is known, is then within 0.04 %
LONGER = 1.7  # bounds what a half cycle lasts under damping, over its undamped duration
BRACKET = (0.25, 4.0)  # of the damping ratio from peaks, over the closed form's
TOLERANCES = {"xrtol": 1e-9, "fatol": 1e-12}


def amplitude(config: Config) -> xr.Dataset:
    """Return the damping ratio of each damper by the closed form, the first peak and the least Err."""
    release = np.array(config.amplitude.release_share) * config.curve.ultimate_displacement_ratio
    restitution = np.array(config.amplitude.restitution)
    x0, e = (grid.ravel() for grid in np.meshgrid(release, restitution, indexing="ij"))
    curve = config.curve.make().map(lambda parameter: np.full(x0.size, parameter))
    matched = match_decays(
        curve,
        x0,
        e,
        DAMPERS,
        config.matching.model_copy(update={"refinement": config.amplitude.refinement}),
        step=config.solver.step,
        scheme=config.solver.scheme,
        description="amplitude",
    ).values()
    measures = {
        "damping_ratio": [match.damping_ratio for match in matched],
        "damping_ratio_uncertainty": [match.uncertainty for match in matched],
        "damping_ratio_peaks": [damping_ratio_peaks(curve, model, e, x0) for model in DAMPERS],
        "damping_ratio_energy": [damping_ratio_energy(curve, model, e, x0) for model in DAMPERS],
    }
    dims, shape = ("damping_model", "release_amplitude", "restitution"), (len(DAMPERS), release.size, restitution.size)
    return xr.Dataset(
        {name: (dims, np.reshape(values, shape)) for name, values in measures.items()},
        coords={
            "damping_model": list(DAMPERS),
            "release_amplitude": release,
            "restitution": restitution,
            "response_length": config.matching.response_length,
        },
    )


def damping_ratio_peaks(
    curve: TrilinearCurve, damping_model: str, restitution: ArrayLike, release_amplitude: ArrayLike
) -> Array:
    """Return the damping ratio with which the half cycle after a release ends at CR's peak, V(x1) = e^2 V(x0). [-]

    All arguments broadcast. It raises `InputError` where a ratio lies outside `BRACKET` times the closed form's.
    """
    guess = damping_ratio_energy(curve, damping_model, restitution, release_amplitude)
    shape = guess.shape

    def flat(value: ArrayLike) -> Array:
        return np.broadcast_to(np.asarray(value, dtype=float), shape).ravel()

    curves = curve.map(flat)
    delta, x0 = -np.log(flat(restitution)), flat(release_amplitude)

    def excess(xi: Array, at: Array) -> Array:
        case = at.astype(np.int64)
        some = curves.map(lambda parameter: parameter[case])
        return decrement(some, Damping(damping_model, xi), x0[case]) - delta[case]

    low, high = (factor * guess.ravel() for factor in BRACKET)
    root = elementwise.find_root(excess, (low, high), args=(np.arange(x0.size, dtype=float),), tolerances=TOLERANCES)
    if not root.success.all():
        bad = int(np.flatnonzero(~root.success)[0])
        raise InputError(
            f"the damping ratio of {damping_model} from the first peak at u0/u_ins = {x0[bad]:.6g} and"
            f" e = {np.exp(-delta[bad]):.6g} is not within {BRACKET} times the closed form's, {guess.ravel()[bad]:.6g}"
        )
    return root.x.reshape(shape)


def decrement(curve: TrilinearCurve, damping: Damping, release_amplitude: Array) -> Array:
    """Return ln sqrt(V(x0)/V(x1)) over the half cycle that begins at rest at x0, shape (lanes,). [-]"""
    step = LONGER * curve.period(release_amplitude) / 2 / HALF_CYCLE_STEPS
    response = simulate(curve, damping, release_amplitude=release_amplitude, step=step, steps=HALF_CYCLE_STEPS)
    turned, _ = turning_points(response.displacement, response.velocity, step)
    if not turned.shape[1] or np.isnan(turned[:, 0]).any():
        raise InputError(f"a half cycle under {damping.model} lasts more than {LONGER} times an undamped one")
    return 0.5 * np.log(curve.energy(release_amplitude) / curve.energy(turned[:, 0]))
