"""The decays that the report's explorer shows: every damping model at each release and restitution of a study."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rockdamp.config import Config
from rockdamp.mechanics.damping import Damping
from rockdamp.progress import track
from rockdamp.solvers.newmark import solve
from rockdamp.studies.decays import step_count
from rockdamp.studies.settings import ExplorerSettings
from rockdamp.vocabulary import MODELS


def explorer(config: Config, matches: xr.Dataset) -> xr.Dataset:
    """Run the decay under restitution, and under each damper at its matched ratio, and keep a few points of each.

    Parameters
    ----------
    config : dict
        Has the keys of `ExplorerSettings`.
    matches : xarray.Dataset
        What `matches.match` returned for the amplitude study.

    Returns
    -------
    xarray.Dataset
        ``displacement`` (damping_model, release_amplitude, restitution, tau), and the matched ``damping_ratio`` of each
        damper, NaN for CR.
    """
    given = ExplorerSettings.of(config)
    curve, step, scheme = given.curve, given.solver.step, given.solver.scheme
    every = max(1, int(given.explorer.spacing / step + 1e-9))
    steps = every * step_count(given.explorer.length, every * step)
    release, restitution = matches["release_amplitude"].values, matches["restitution"].values
    matched = matches["damping_ratio"].reindex(damping_model=list(MODELS))  # NaN for CR
    displacement, ratio = [], []
    for model in track(MODELS, "explorer"):
        ratio.append(matched.sel(damping_model=model).values)
        damping = Damping.of(model, restitution=restitution, damping_ratio=ratio[-1])
        response = solve(
            curve, damping, release_amplitude=release[:, None], step=step, steps=steps, store_every=every, scheme=scheme
        )
        displacement.append(response.displacement)
    dims = ("damping_model", "release_amplitude", "restitution")
    return xr.Dataset(
        {"displacement": ((*dims, "tau"), np.stack(displacement)), "damping_ratio": (dims, np.stack(ratio))},
        coords={
            "damping_model": list(MODELS),
            "release_amplitude": release,
            "restitution": restitution,
            "tau": every * step * np.arange(steps // every + 1),
            "window": float(matches["window"]),
            "cracked_stiffness_ratio": float(curve.cracked_stiffness_ratio),
            "plateau_ratio": float(curve.plateau_ratio),
            "plateau_end_ratio": float(curve.plateau_end),
            "ultimate_ratio": float(curve.ultimate_ratio),
        },
    )
