"""The viscous models matched to the stored decays of a study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config, Matching, Study
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
from rockdamp.studies.decays import longest_response, response_lengths_of_fixed_seconds, step_count


def match(name: str, config: Config, decays: xr.Dataset) -> xr.Dataset:
    """Match every viscous model to the stored decays of one study, by the protocol of `equivalence.matching`.

    Where the study varies the wall, and with it the time scale 1/p, the response length is also held in seconds, at the
    length that the wall of the config has: then the walls' lengths in tau differ, and with them the damping ratios.
    Those other lengths are matched at the solver's step.
    """
    study, step = config.study(name), config.solver.step
    response_length = config.matching.response_length
    restitution = decays["restitution"].values
    steps = step_count(response_length, step)
    wall = config.wall.make()
    fixed = response_lengths_of_fixed_seconds(study, wall, response_length) if study.varies_wall else None
    last = step_count(longest_response(study, wall, response_length), step)
    stored = np.ascontiguousarray(decays["displacement"].values[..., : last + 1], dtype=float)
    cases = cases_of(study, restitution, stored, step, config.solver.scheme)
    matched = match_dampers(
        cases,
        VISCOUS_MODELS,
        steps,
        refinement=config.matching.refinement,
        description=f"match {name}",
    )
    of_model = {
        model: {
            "damping_ratio": of.damping_ratio,
            "damping_ratio_uncertainty": of.uncertainty,
            "damping_ratio_energy": damping_ratio_energy(
                cases.curve, model, cases.restitution, cases.release_amplitude
            ),
            "error": of.error,
            "rms_error": of.rms_error,
            "local_minima": of.local_minima,
        }
        for model, of in matched.items()
    }
    if fixed is not None:

        def at_fixed_seconds(model: str) -> Array:
            return _match_each(cases, model, fixed, (response_length, matched[model].damping_ratio))

        for model, ratio in map_in_threads(at_fixed_seconds, VISCOUS_MODELS, f"match {name} at fixed seconds").items():
            of_model[model]["damping_ratio_fixed_seconds"] = ratio
    dims = ("damping_model", study.parameter, "restitution")
    shape = (len(of_model), study.values.size, restitution.size)
    names = of_model[VISCOUS_MODELS[0]]
    dataset = xr.Dataset(
        {key: (dims, np.stack([values[key] for values in of_model.values()]).reshape(shape)) for key in names},
        coords={"damping_model": list(of_model), "restitution": restitution},
    )
    if name == "amplitude":
        dataset["damping_ratio_absolute"] = _least_absolute(config, cases, matched, steps, restitution)
    kept = {
        key: decays[key] for key in (study.parameter, "frequency_parameter", "strength_ratio") if key in decays.coords
    }
    finest = matched[VISCOUS_MODELS[0]]
    return dataset.assign_coords(kept).assign_coords(
        response_length=response_length, step=finest.step, steps=finest.steps
    )


def _least_absolute(
    config: Config, cases: Cases, matched: Mapping[str, Matched], steps: int, restitution: Array
) -> xr.DataArray:
    """Damping ratios by the words under Eq. (17) in place of its formula, from the reference amplitude."""
    at = np.flatnonzero(cases.release_amplitude == config.release_amplitude)

    def of_model(model: str) -> Array:
        squares = matched[model].damping_ratio[at]
        return least_absolute(cases.take(at), model, squares, steps)

    ratios = map_in_threads(of_model, VISCOUS_MODELS, "match by absolute differences")
    coords = {"damping_model": list(ratios), "restitution": restitution}
    return xr.DataArray(np.stack(list(ratios.values())), coords=coords, dims=("damping_model", "restitution"))


def match_decays(
    curve: TrilinearCurve,
    release_amplitude: Array,
    restitution: Array,
    damping_models: Sequence[str],
    matching: Matching,
    *,
    step: float,
    scheme: str,
    description: str = "",
) -> dict[str, Matched]:
    """Release walls under restitution and match models to their decays, by the protocol of `equivalence.matching`.

    Curve, release amplitude and e have the shape (cases,).
    """
    steps = step_count(matching.response_length, step)
    cases = Cases.release(curve, release_amplitude, restitution, step=step, steps=steps, scheme=scheme)
    return match_dampers(
        cases,
        damping_models,
        steps,
        refinement=matching.refinement,
        description=description,
    )


def cases_of(study: Study, restitution: Array, displacement: Array, step: float, scheme: str) -> Cases:
    """Flatten the decays of a study, shape (study parameter, restitution, tau), to cases."""
    count = restitution.size
    return Cases(
        study.curve.map(lambda parameter: np.repeat(parameter, count)),
        np.repeat(study.release_amplitude, count),
        np.tile(restitution, study.values.size),
        displacement.reshape(study.values.size * count, -1),
        step,
        scheme,
    )


def _match_each(cases: Cases, model: str, response_lengths: Array, known: tuple[float, Array]) -> Array:
    """Match each wall's cases at its own response length; `known` is a length with its damping ratios already."""
    per_wall = cases.restitution.size // response_lengths.size

    def of_wall(wall: int) -> Array:
        own = slice(wall * per_wall, (wall + 1) * per_wall)
        if np.isclose(response_lengths[wall], known[0], rtol=1e-12):
            return known[1][own]
        steps = step_count(response_lengths[wall], cases.step)
        return global_minima(cases.take(own), model, [steps]).damping_ratio[0]

    return np.concatenate([of_wall(wall) for wall in range(response_lengths.size)])
