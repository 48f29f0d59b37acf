"""Conclusions from Eq. (17) by the unstated length of the response, and the length that the paper implies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.constants import PAPER_MODELS, VISCOUS_MODELS
from rockdamp.equivalence.matching import RESOLUTION, Cases, global_minima
from rockdamp.progress import track
from rockdamp.studies.decays import INFERS, step_count
from rockdamp.studies.matches import flatten_decays
from rockdamp.studies.study import make_study

# Section 6: "in a range of e values between 0.91 and 0.8" CDR has the lowest error.
PAPER_RANGE = (0.80, 0.91)


def response_lengths(config: Config, decays: xr.Dataset) -> xr.Dataset:
    """Compute Err and damping ratio of the reference wall for every length of the response.

    Damping ratios are the minima of Err at the solver's step. Their uncertainty is twice the largest change at the
    coarser ones, and at least the resolution of the search. ``near_misclassified`` shows how sharp the inferred
    length is, at lengths between those next to it.
    ``inferred_response_length_of_release`` is what another wall would imply.
    """
    study, lengths = make_study(INFERS, config), config.response_lengths.values()
    cases, count = (
        flatten_decays(study, decays, lengths[-1], config.solver),
        decays.sizes["restitution"],
    )
    releases = [
        cases.take(slice(row * count, (row + 1) * count)) for row in range(study.values.size)
    ]
    reference = int(np.argmin(np.abs(study.values - config.release_amplitude)))
    dataset = find_errors(releases[reference], lengths, VISCOUS_MODELS)
    inferred = infer(dataset)
    near = find_errors(releases[reference], between_neighbours(lengths, inferred), PAPER_MODELS)
    findings = np.full((2, study.values.size), np.nan)
    for row, release in enumerate(track(study.values, "response_lengths")):
        # A length that holds no whole cycle defines no damping ratio at low e; far longer ones are not asked for.
        cycle = float(config.curve.make().period(release))
        wide = lengths[(lengths >= cycle) & (lengths <= 4 * inferred)]
        if wide.size:
            is_reference = row == reference
            errors = (
                dataset.sel(response_length=wide)
                if is_reference
                else find_errors(releases[row], wide, PAPER_MODELS)
            )
            findings[:, row] = infer(errors), misclassified(errors).min()
    return (
        dataset.merge(flags(dataset))
        .assign(
            damping_ratio_uncertainty=uncertainty(
                releases[reference], lengths, dataset["damping_ratio"]
            ),
            near_misclassified=misclassified(near).rename(response_length="near_response_length"),
            inferred_response_length_of_release=("release_amplitude", findings[0]),
            misclassified_of_release=("release_amplitude", findings[1]),
        )
        .assign_coords(inferred_response_length=inferred, release_amplitude=study.values)
    )


def find_errors(decays: Cases, lengths: Array, damping_models: Sequence[str]) -> xr.Dataset:
    """Return Err and damping ratio of each model matched to the decays of a wall, by response length and e."""
    steps = np.array([step_count(length, decays.step) for length in lengths])
    decays = replace(
        decays, displacement=np.ascontiguousarray(decays.displacement[:, : steps[-1] + 1])
    )
    matches = [global_minima(decays, model, steps) for model in damping_models]
    error = np.stack([match.error for match in matches], axis=-1)
    dims = ("response_length", "restitution", "damping_model")
    return xr.Dataset(
        {
            "error": (dims, error),
            "rms_error": (dims, np.sqrt(error / steps[:, None, None])),
            "damping_ratio": (dims, np.stack([match.damping_ratio for match in matches], axis=-1)),
        },
        coords={
            "response_length": lengths,
            "restitution": decays.restitution,
            "damping_model": list(damping_models),
        },
    )


def uncertainty(decays: Cases, lengths: Array, damping_ratio: xr.DataArray) -> xr.DataArray:
    """Return twice the largest change of the damping ratios at coarser steps, and at least the search's resolution."""
    changes = []
    for factor in (1.6, 2.0):
        coarser = decays.refine(decays.steps, 1 / factor)
        steps = np.round(lengths / coarser.step).astype(int)
        models = map(str, damping_ratio["damping_model"].values)
        ratios = [global_minima(coarser, model, steps).damping_ratio for model in models]
        changes.append(np.abs(np.stack(ratios, axis=-1) - damping_ratio.values))
    return damping_ratio.copy(
        data=np.maximum(2 * np.max(changes, axis=0), RESOLUTION * damping_ratio.values)
    )


def between_neighbours(lengths: Array, inferred: float) -> Array:
    """Return lengths from the one before the inferred to the one after it, in tenths of the distance. [-]"""
    row = int(np.argmin(np.abs(lengths - inferred)))
    ends = lengths[[max(row - 1, 0), row, min(row + 1, lengths.size - 1)]]
    return np.unique(
        np.concatenate([np.linspace(low, high, 11) for low, high in pairwise(ends)]).round(9)
    )


def misclassified(dataset: xr.Dataset) -> xr.DataArray:
    """Count, for each response length, the values of e at which CDR is wrongly lowest, or not, against `PAPER_RANGE`.

    This is the objective of the inference. It was fixed before the response lengths were computed: the lowest Err among
    the paper's three models, every e of the grid with equal weight.
    """
    lowest = dataset["error"].sel(damping_model=list(PAPER_MODELS)).argmin("damping_model")
    e = dataset["restitution"]
    inside = (e > PAPER_RANGE[0] - 1e-9) & (e < PAPER_RANGE[1] + 1e-9)
    return ((lowest == PAPER_MODELS.index("CDR")) != inside).sum("restitution")


def infer(dataset: xr.Dataset) -> float:
    """Return the length that reproduces the paper's range best: the middle of those with the fewest misfits. [-]"""
    count = misclassified(dataset)
    best = dataset["response_length"].values[count.values == count.values.min()]
    return float(best[(best.size - 1) // 2])


def flags(dataset: xr.Dataset) -> xr.Dataset:
    """Judge, for each response length, the claims of section 6 that depend on the length of the response."""
    error = dataset["error"]
    secant, constant = (
        error.sel(damping_model=["CDR", "SDR"]).max("damping_model"),
        error.sel(damping_model="CDC"),
    )
    return xr.Dataset(
        {
            "misclassified": misclassified(dataset),
            "secant_below_constant": (secant < constant.drop_vars("damping_model"))
            .all("restitution")
            .astype("int8"),
            "error_rises_as_restitution_falls": (error.diff("restitution") < 0)
            .all("restitution")
            .astype("int8"),
        }
    )
