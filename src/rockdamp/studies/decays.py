"""Free decays under a coefficient of restitution: the references of every study."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from rockdamp.config import Config
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import solve
from rockdamp.studies.settings import DecaySettings


def step_count(length: float, step: float) -> int:
    """Steps that a response of `length` in tau takes."""
    return int(round(length / step))


def study(name: str, config: Config) -> xr.Dataset:
    """Run the free decays of one study, to the longest window.

    Parameters
    ----------
    name : {"amplitude", "slenderness", "overburden", "cracked_stiffness"}
    config : dict
        Has the keys of `DecaySettings`.

    Returns
    -------
    xarray.Dataset
        ``displacement`` and ``velocity`` (study parameter, restitution, tau) and ``impacts``.
    """
    given = DecaySettings.of(config)
    walls, restitution, step = given.study(name), given.restitution, given.solver.step
    steps = step_count(given.length, step)
    response = solve(
        walls.curve.map(lambda parameter: parameter[:, None]),
        Damping.cr(restitution),
        release_amplitude=walls.release_amplitude[:, None],
        step=step,
        steps=steps,
        store_every=1,
        scheme=given.solver.scheme,
    )
    dims = (walls.parameter, "restitution")
    coords: dict[str, Any] = {
        walls.parameter: walls.values,
        "restitution": restitution,
        "tau": step * np.arange(steps + 1),
        "frequency_parameter": (walls.parameter, walls.frequency_parameter),
    }
    if name == "cracked_stiffness":
        coords["plateau_ratio"] = (walls.parameter, np.asarray(walls.curve.plateau_ratio))
    return xr.Dataset(
        {
            "displacement": ((*dims, "tau"), response.displacement),
            "velocity": ((*dims, "tau"), response.velocity),
            "impacts": (dims, response.impacts),
        },
        coords=coords,
    )
