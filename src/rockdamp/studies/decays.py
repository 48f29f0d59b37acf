"""Free decays under a restitution coefficient: the references of every study."""

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

# The study from whose decays the length of the response is inferred.
LENGTH_STUDY = "amplitude"


def step_count(length: float, step: float) -> int:
    """Return the number of steps in a response of `length` in tau."""
    return int(round(length / step))


def matched_lengths(study: Study, wall: Wall, response_length: float) -> Array:
    """Return the lengths of the response in tau at which a study's decays are matched.

    The first is that of the config. If the study varies the wall, and with it the time scale 1/p,
    the lengths of its walls follow, for a response as long in seconds as that of `wall`.
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
    """Return displacement, velocity and damping force of a wall, over damping_model and tau.

    Parameters
    ----------
    curve : TrilinearCurve
        Force-displacement curve of the wall.
    dampings : mapping of Damping
        Dampers by their label.
    release_amplitude : float
        Displacement of the release, u0/u_ins. [-]
    step : float
        Step of the solver in tau. [-]
    steps : int
        Number of steps.
    scheme : {"newmark", "paper"}
        Scheme of the solver. Default: "newmark".
    """
    histories = []
    for damping in dampings.values():
        history = simulate(
            curve,
            damping,
            release_amplitude=release_amplitude,
            step=step,
            steps=steps,
            scheme=scheme,
        )
        coefficient = damping_coefficient(curve, damping, history.displacement, history.velocity)
        histories.append((history.displacement, history.velocity, coefficient * history.velocity))
    displacement, velocity, force = np.stack(histories, axis=1)
    dims = ("damping_model", "tau")
    return xr.Dataset(
        {
            "displacement": (dims, displacement),
            "velocity": (dims, velocity),
            "damping_force": (dims, force),
        },
        coords={"damping_model": list(dampings), "tau": step * np.arange(steps + 1)},
    )


def decay(name: str, config: Config) -> xr.Dataset:
    """Run the free decays of one study, to the longest response that is matched to them.

    Decays of `LENGTH_STUDY` run to the longest of the response lengths from which the paper's is
    inferred; the others run to the length of the matching, in tau and in seconds.
    """
    study = make_study(name, config)
    restitution = config.restitution.values()
    step = config.solver.step
    length = config.response_lengths.stop
    if name != LENGTH_STUDY:
        reference_wall = config.wall.make()
        length = matched_lengths(study, reference_wall, config.matching.response_length).max()
    steps = step_count(length, step)
    histories = simulate(
        study.curve.map(lambda parameter: parameter[:, None]),
        Damping("CR", restitution),
        release_amplitude=study.release_amplitude[:, None],
        step=step,
        steps=steps,
        scheme=config.solver.scheme,
    )
    dims = (study.parameter, "restitution")
    coords: dict[str, Any] = {
        study.parameter: study.values,
        "restitution": restitution,
        "tau": step * np.arange(steps + 1),
        "frequency_parameter": (study.parameter, study.frequency_parameter),
    }
    if name == "cracked_stiffness":
        strength_ratio = np.asarray(study.curve.strength_ratio)
        coords["strength_ratio"] = (study.parameter, strength_ratio)
    return xr.Dataset(
        {
            "displacement": ((*dims, "tau"), histories.displacement),
            "velocity": ((*dims, "tau"), histories.velocity),
            "impacts": (dims, histories.impacts),
        },
        coords=coords,
    )
