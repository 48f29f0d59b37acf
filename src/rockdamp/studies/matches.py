"""The viscous models matched to the stored decays of a study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

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


def match(name: str, config: Config, decays: xr.Dataset) -> xr.Dataset:
    """Match every viscous model to the stored decays of one study, by the protocol of `equivalence.matching`.

    Where the study varies the wall, the response length is also held in seconds, at the length that the wall of the
    config has. Those other lengths are matched at the solver's step.
    """
    study, step, restitution = (
        make_study(name, config),
        config.solver.step,
        decays["restitution"].values,
    )
    first, *others = matched_lengths(study, config.wall.make(), config.matching.response_length)
    cases, steps = (
        flatten_decays(study, decays, max(first, *others, 0.0), config.solver),
        step_count(first, step),
    )
    refinement = config.matching.refinement
    matched = match_dampers(
        cases, VISCOUS_MODELS, steps, refinement=refinement, description=f"match {name}"
    )
    energy = [
        damping_ratio_energy(cases.curve, model, cases.restitution, cases.release_amplitude)
        for model in matched
    ]
    names = ("damping_ratio", "error", "rms_error", "local_minima")
    measures: dict[str, list[Any]] = {
        name: [getattr(match, name) for match in matched.values()] for name in names
    }
    measures["damping_ratio_uncertainty"] = [match.uncertainty for match in matched.values()]
    measures["damping_ratio_energy"] = energy
    if others:

        def match_fixed_seconds(model: str) -> Array:
            ratios = matched[model].damping_ratio.reshape(len(others), restitution.size).copy()
            for wall, length in enumerate(others):
                if not np.isclose(length, first, rtol=1e-12):
                    wall_cases = cases.take(
                        slice(wall * restitution.size, (wall + 1) * restitution.size)
                    )
                    ratios[wall] = global_minima(
                        wall_cases, model, [step_count(length, step)]
                    ).damping_ratio[0]
            return ratios

        fixed = map_in_threads(
            match_fixed_seconds, VISCOUS_MODELS, f"match {name} at fixed seconds"
        )
        measures["damping_ratio_fixed_seconds"] = [*fixed.values()]
    dims, shape = (
        ("damping_model", study.parameter, "restitution"),
        (-1, study.values.size, restitution.size),
    )
    dataset = xr.Dataset(
        {key: (dims, np.stack(values).reshape(shape)) for key, values in measures.items()},
        coords={"damping_model": list(matched), "restitution": restitution},
    )
    if name == "amplitude":
        dataset["damping_ratio_absolute"] = _match_absolute(
            config, cases, matched, steps, restitution
        )
    finest, kept = (
        matched[VISCOUS_MODELS[0]],
        {study.parameter, "frequency_parameter", "strength_ratio"},
    )
    return dataset.assign_coords(
        {key: decays[key] for key in kept & set(decays.coords)}
    ).assign_coords(response_length=first, step=finest.step, steps=finest.steps)


def _match_absolute(
    config: Config, cases: Cases, matched: Mapping[str, Matched], steps: int, restitution: Array
) -> xr.DataArray:
    """Return damping ratios by the words under Eq. (17) in place of its formula, from the reference amplitude."""
    reference = np.flatnonzero(cases.release_amplitude == config.release_amplitude)
    ratios = map_in_threads(
        lambda model: least_absolute(
            cases.take(reference), model, matched[model].damping_ratio[reference], steps
        ),
        VISCOUS_MODELS,
        "match by absolute differences",
    )
    coords = {"damping_model": list(ratios), "restitution": restitution}
    return xr.DataArray(
        np.stack(list(ratios.values())), coords=coords, dims=("damping_model", "restitution")
    )


def match_decays(
    curve: TrilinearCurve,
    release_amplitude: Array,
    restitution: Array,
    damping_models: Sequence[str],
    matching: Matching,
    solver: Solver,
    description: str = "",
) -> dict[str, Matched]:
    """Release walls under restitution and match models to their decays, by the protocol of `equivalence.matching`.

    Curve, release amplitude and e have the shape (cases,).
    """
    step, steps = solver.step, step_count(matching.response_length, solver.step)
    cases = Cases.release(
        curve, release_amplitude, restitution, step=step, steps=steps, scheme=solver.scheme
    )
    return match_dampers(
        cases, damping_models, steps, refinement=matching.refinement, description=description
    )


def flatten_decays(study: Study, decays: xr.Dataset, length: float, solver: Solver) -> Cases:
    """Flatten the stored decays of a study to cases, e varying fastest, up to a length in tau."""
    e, walls, samples = (
        decays["restitution"].values,
        study.values.size,
        step_count(length, solver.step) + 1,
    )
    displacement = np.ascontiguousarray(decays["displacement"].values[..., :samples], dtype=float)
    return Cases(
        study.curve.map(lambda parameter: np.repeat(parameter, e.size)),
        np.repeat(study.release_amplitude, e.size),
        np.tile(e, walls),
        displacement.reshape(walls * e.size, -1),
        solver.step,
        solver.scheme,
    )
