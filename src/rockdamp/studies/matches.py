"""The viscous models matched to the stored decays of a study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config, Matching, Solver
from rockdamp.constants import VISCOUS_MODELS
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.equivalence.matching import (
    Cases,
    Matched,
    global_minima,
    least_absolute,
    map_in_threads,
    match_dampers,
)
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.studies.decays import matched_lengths, step_count
from rockdamp.studies.study import Study, make_study

# Variables of the dataset, and the attributes of a match that they hold.
MATCH_VARIABLES = {
    "damping_ratio": "damping_ratio",
    "error": "error",
    "rms_error": "rms_error",
    "local_minima": "local_minima",
    "damping_ratio_uncertainty": "uncertainty",
}


def match(name: str, config: Config, decays: xr.Dataset) -> xr.Dataset:
    """Match every viscous model to the stored decays of one study.

    `equivalence.matching` has the protocol. If the study varies the wall, the response length is
    also held in seconds, at that of the config's wall; these other lengths are matched at the
    solver's step.
    """
    study = make_study(name, config)
    restitution = decays["restitution"].values
    lengths = matched_lengths(study, config.wall.make(), config.matching.response_length)
    response_length = lengths[0]
    cases = flatten_decays(study, decays, lengths.max(), config.solver)
    steps = step_count(response_length, config.solver.step)
    matches = match_dampers(
        cases,
        VISCOUS_MODELS,
        steps,
        refinement=config.matching.refinement,
        description=f"match {name}",
    )
    measures = {}
    for variable, attribute in MATCH_VARIABLES.items():
        measures[variable] = [getattr(match, attribute) for match in matches.values()]
    measures["damping_ratio_energy"] = [
        damping_ratio_energy(cases.curve, model, cases.restitution, cases.release_amplitude)
        for model in matches
    ]
    if study.varies_wall:
        measures["damping_ratio_fixed_seconds"] = _match_lengths(name, cases, matches, lengths)
    dims = ("damping_model", study.parameter, "restitution")
    shape = (-1, study.values.size, restitution.size)
    dataset = xr.Dataset(
        {key: (dims, np.stack(values).reshape(shape)) for key, values in measures.items()},
        coords={"damping_model": list(matches), "restitution": restitution},
    )
    if name == "amplitude":
        ratios = _match_absolute(config, cases, matches, steps)
        dataset["damping_ratio_absolute"] = (("damping_model", "restitution"), np.stack(ratios))
    coords = {
        key: decays[key]
        for key in (study.parameter, "frequency_parameter", "strength_ratio")
        if key in decays.coords
    }
    finest = matches[VISCOUS_MODELS[0]]
    return dataset.assign_coords(coords).assign_coords(
        response_length=response_length, step=finest.step, steps=finest.steps
    )


def _match_lengths(
    name: str, cases: Cases, matches: Mapping[str, Matched], lengths: Array
) -> list[Array]:
    """Return damping ratios of each model, each wall at its own length, from ``lengths[1:]``."""
    response_length, *wall_lengths = lengths

    def match_model(model: str) -> Array:
        ratios = matches[model].damping_ratio.reshape(len(wall_lengths), -1).copy()
        count = ratios.shape[1]
        for wall, length in enumerate(wall_lengths):
            if np.isclose(length, response_length, rtol=1e-12):
                continue
            wall_cases = cases.take(slice(wall * count, (wall + 1) * count))
            minima = global_minima(wall_cases, model, [step_count(length, cases.step)])
            ratios[wall] = minima.damping_ratio[0]
        return ratios

    ratios = map_in_threads(match_model, VISCOUS_MODELS, f"match {name} at fixed seconds")
    return list(ratios.values())


def _match_absolute(
    config: Config, cases: Cases, matches: Mapping[str, Matched], steps: int
) -> list[Array]:
    """Return damping ratios of each model by absolute differences, at the reference amplitude.

    The words under Eq. (17) describe absolute differences, its formula squares. The shape of each
    model's ratios is (restitution,).
    """
    reference = np.flatnonzero(cases.release_amplitude == config.release_amplitude)
    reference_cases = cases.take(reference)

    def match_model(model: str) -> Array:
        least_squares = matches[model].damping_ratio[reference]
        return least_absolute(reference_cases, model, least_squares, steps)

    ratios = map_in_threads(match_model, VISCOUS_MODELS, "match by absolute differences")
    return list(ratios.values())


def match_decays(
    curve: TrilinearCurve,
    release_amplitude: Array,
    restitution: Array,
    damping_models: Sequence[str],
    matching: Matching,
    solver: Solver,
    description: str = "",
) -> dict[str, Matched]:
    """Release walls under restitution and match models to their decays.

    `equivalence.matching` has the protocol.

    Parameters
    ----------
    curve : TrilinearCurve, shape (cases,)
        Curve of each case.
    release_amplitude : ndarray, shape (cases,)
        Displacement of the release, u0/u_ins. [-]
    restitution : ndarray, shape (cases,)
        Restitution coefficient e. [-]
    damping_models : sequence of str
        Viscous models.
    matching : Matching
        Response length and refinement of the config.
    solver : Solver
        Step and scheme of the config.
    description : str
        Text of the progress bar. Default: none.
    """
    steps = step_count(matching.response_length, solver.step)
    cases = Cases.release(
        curve, release_amplitude, restitution, step=solver.step, steps=steps, scheme=solver.scheme
    )
    return match_dampers(
        cases, damping_models, steps, refinement=matching.refinement, description=description
    )


def flatten_decays(study: Study, decays: xr.Dataset, length: float, solver: Solver) -> Cases:
    """Flatten the stored decays of a study to cases, e varying fastest, up to a length in tau."""
    e = decays["restitution"].values
    walls = study.values.size
    samples = step_count(length, solver.step) + 1
    displacement = np.ascontiguousarray(decays["displacement"].values[..., :samples], dtype=float)
    return Cases(
        study.curve.map(lambda parameter: np.repeat(parameter, e.size)),
        np.repeat(study.release_amplitude, e.size),
        np.tile(e, walls),
        displacement.reshape(walls * e.size, -1),
        solver.step,
        solver.scheme,
    )
