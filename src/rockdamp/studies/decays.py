"""Free decays under a coefficient of restitution: the references of every study."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config, Study
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Wall
from rockdamp.solvers.newmark import simulate

INFERS = "amplitude"  # the study from whose decays the length of the response is inferred


def step_count(length: float, step: float) -> int:
    """Steps that a response of `length` in tau takes."""
    return int(round(length / step))


def response_lengths_of_fixed_seconds(study: Study, wall: Wall, response_length: float) -> Array:
    """Return the response length of each wall of a study, in tau, when all have the length in seconds of `wall`'s."""
    seconds = response_length / float(wall.frequency_parameter)
    return seconds * study.frequency_parameter


def longest_response(study: Study, wall: Wall, response_length: float) -> float:
    """Return the longest response that is matched to the decays of a study, in tau."""
    fixed = (
        response_lengths_of_fixed_seconds(study, wall, response_length)
        if study.varies_wall
        else np.array([response_length])
    )
    return max(response_length, float(fixed.max()))


def study(name: str, config: Config) -> xr.Dataset:
    """Run the free decays of one study, to the longest response that is matched to them.

    Those of `INFERS` run to the longest of the response lengths from which the paper's is inferred. The others run to
    that of the matching, in tau and in seconds.
    """
    matching = config.matching
    walls, restitution, step = config.study(name), config.restitution.values(), config.solver.step
    length = (
        config.response_lengths.stop
        if name == INFERS
        else longest_response(walls, config.wall.make(), matching.response_length)
    )
    steps = step_count(length, step)
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
