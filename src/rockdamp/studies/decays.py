"""Free decays under a coefficient of restitution: the references of every study."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Wall
from rockdamp.solvers.coefficient import damping_coefficient
from rockdamp.solvers.newmark import simulate
from rockdamp.studies.study import Study, make_study

INFERS = "amplitude"  # the study from whose decays the length of the response is inferred


def step_count(length: float, step: float) -> int:
    """Steps that a response of `length` in tau takes."""
    return int(round(length / step))


def matched_lengths(study: Study, wall: Wall, response_length: float) -> Array:
    """Return the lengths of the response in tau at which a study's decays are matched.

    The first is that of the config. Where the study varies the wall, and with it the time scale 1/p, those of its walls
    follow for which the response lasts as long in seconds as that of `wall`.
    """
    if not study.varies_wall:
        return np.array([response_length])
    seconds = response_length / float(wall.frequency_parameter)
    return np.concatenate([[response_length], seconds * study.frequency_parameter])


def damped_decays(
    curve: TrilinearCurve,
    dampings: Mapping[str, Damping],
    release_amplitude: float,
    *,
    step: float,
    steps: int,
    scheme: str = "newmark",
) -> xr.Dataset:
    """Return ``displacement``, ``velocity`` and ``damping_force`` of a wall, over ``damping_model`` and ``tau``."""
    runs = []
    for damping in dampings.values():
        run = simulate(
            curve,
            damping,
            release_amplitude=release_amplitude,
            step=step,
            steps=steps,
            scheme=scheme,
        )
        force = damping_coefficient(curve, damping, run.displacement, run.velocity) * run.velocity
        runs.append((run.displacement, run.velocity, force))
    names = ("displacement", "velocity", "damping_force")
    return xr.Dataset(
        {
            name: (("damping_model", "tau"), values)
            for name, values in zip(names, np.stack(runs, axis=1), strict=True)
        },
        coords={"damping_model": list(dampings), "tau": step * np.arange(steps + 1)},
    )


def study(name: str, config: Config) -> xr.Dataset:
    """Run the free decays of one study, to the longest response that is matched to them.

    Those of `INFERS` run to the longest of the response lengths from which the paper's is inferred. The others run to
    that of the matching, in tau and in seconds.
    """
    walls, restitution, step = (
        make_study(name, config),
        config.restitution.values(),
        config.solver.step,
    )
    lengths = matched_lengths(walls, config.wall.make(), config.matching.response_length)
    steps = step_count(config.response_lengths.stop if name == INFERS else lengths.max(), step)
    response = simulate(
        walls.curve.map(lambda parameter: parameter[:, None]),
        Damping("CR", restitution),
        release_amplitude=walls.release_amplitude[:, None],
        step=step,
        steps=steps,
        scheme=config.solver.scheme,
    )
    dims = (walls.parameter, "restitution")
    coords: dict[str, Any] = {
        walls.parameter: walls.values,
        "restitution": restitution,
        "tau": step * np.arange(steps + 1),
        "frequency_parameter": (walls.parameter, walls.frequency_parameter),
    }
    if name == "cracked_stiffness":
        coords["strength_ratio"] = (walls.parameter, np.asarray(walls.curve.strength_ratio))
    return xr.Dataset(
        {
            "displacement": ((*dims, "tau"), response.displacement),
            "velocity": ((*dims, "tau"), response.velocity),
            "impacts": (dims, response.impacts),
        },
        coords=coords,
    )
