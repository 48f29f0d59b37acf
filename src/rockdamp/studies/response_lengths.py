"""Conclusions from Eq. (17) by the length of the response, and the length the paper implies."""

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
from rockdamp.studies.decays import LENGTH_STUDY, step_count
from rockdamp.studies.matches import flatten_decays
from rockdamp.studies.study import make_study

# Section 6: "in a range of e values between 0.91 and 0.8" CDR has the lowest error.
PAPER_RANGE = (0.80, 0.91)


def response_lengths(config: Config, decays: xr.Dataset) -> xr.Dataset:
    """Compute Err and damping ratio of the reference wall for every length of the response.

    Damping ratios are the minima of Err at the solver's step. Their uncertainty is twice the
    largest change at the coarser ones, and at least the resolution of the search.
    ``near_misclassified`` shows how sharp the inferred length is, at lengths between its
    neighbours, and ``inferred_response_length_of_release`` is the length that another release would
    imply.
    """
    study = make_study(LENGTH_STUDY, config)
    lengths = config.response_lengths.values()
    cases = flatten_decays(study, decays, lengths[-1], config.solver)
    count = decays.sizes["restitution"]
    releases = [
        cases.take(slice(row * count, (row + 1) * count)) for row in range(study.values.size)
    ]
    reference_row = int(np.argmin(np.abs(study.values - config.release_amplitude)))
    reference = releases[reference_row]
    errors = find_errors(reference, lengths, VISCOUS_MODELS)
    inferred = infer(errors)
    near_lengths = between_neighbours(lengths, inferred)
    near_misfits = misclassified(find_errors(reference, near_lengths, PAPER_MODELS))
    inferred_lengths = np.full(study.values.size, np.nan)
    fewest = np.full(study.values.size, np.nan)
    for row, release_amplitude in enumerate(track(study.values, "response_lengths")):
        # A length without a whole cycle defines no damping ratio at low e; far longer ones are left
        # out.
        cycle = float(config.curve.make().period(release_amplitude))
        usable = lengths[(lengths >= cycle) & (lengths <= 4 * inferred)]
        if not usable.size:
            continue
        if row == reference_row:
            release_errors = errors.sel(response_length=usable)
        else:
            release_errors = find_errors(releases[row], usable, PAPER_MODELS)
        inferred_lengths[row] = infer(release_errors)
        fewest[row] = misclassified(release_errors).min()
    return (
        errors.merge(flags(errors))
        .assign(
            damping_ratio_uncertainty=uncertainty(reference, lengths, errors["damping_ratio"]),
            near_misclassified=near_misfits.rename(response_length="near_response_length"),
            inferred_response_length_of_release=("release_amplitude", inferred_lengths),
            misclassified_of_release=("release_amplitude", fewest),
        )
        .assign_coords(inferred_response_length=inferred, release_amplitude=study.values)
    )


def find_errors(decays: Cases, lengths: Array, damping_models: Sequence[str]) -> xr.Dataset:
    """Return Err and damping ratio of each model matched to decays, by response length and e."""
    steps = np.array([step_count(length, decays.step) for length in lengths])
    displacement = np.ascontiguousarray(decays.displacement[:, : steps[-1] + 1])
    decays = replace(decays, displacement=displacement)
    matches = [global_minima(decays, model, steps) for model in damping_models]
    error = np.stack([match.error for match in matches], axis=-1)
    damping_ratio = np.stack([match.damping_ratio for match in matches], axis=-1)
    dims = ("response_length", "restitution", "damping_model")
    return xr.Dataset(
        {
            "error": (dims, error),
            "rms_error": (dims, np.sqrt(error / steps[:, None, None])),
            "damping_ratio": (dims, damping_ratio),
        },
        coords={
            "response_length": lengths,
            "restitution": decays.restitution,
            "damping_model": list(damping_models),
        },
    )


def uncertainty(decays: Cases, lengths: Array, damping_ratio: xr.DataArray) -> xr.DataArray:
    """Return twice the largest change of the damping ratios at coarser steps, or the resolution."""
    models = damping_ratio["damping_model"].values.tolist()
    changes = []
    # Steps that are coarser by two factors, as the change at one of them may vanish by chance.
    for factor in (1.6, 2.0):
        coarser = decays.refine(decays.steps, 1 / factor)
        steps = np.round(lengths / coarser.step).astype(int)
        ratios = [global_minima(coarser, model, steps).damping_ratio for model in models]
        changes.append(np.abs(np.stack(ratios, axis=-1) - damping_ratio.values))
    largest_change = np.max(changes, axis=0)
    return damping_ratio.copy(
        data=np.maximum(2 * largest_change, RESOLUTION * damping_ratio.values)
    )


def between_neighbours(lengths: Array, inferred: float) -> Array:
    """Return lengths between the neighbours of the inferred one, in tenths of the distance. [-]"""
    row = int(np.argmin(np.abs(lengths - inferred)))
    neighbours = lengths[[max(row - 1, 0), row, min(row + 1, lengths.size - 1)]]
    parts = [np.linspace(low, high, 11) for low, high in pairwise(neighbours)]
    return np.unique(np.concatenate(parts).round(9))


def misclassified(errors: xr.Dataset) -> xr.DataArray:
    """Count, for each response length, the values of e at which the lowest Err is not the paper's.

    In the paper, CDR has the lowest Err within `PAPER_RANGE` and nowhere else. The count is the
    objective of the inference. It was fixed before the response lengths were computed: the lowest
    Err among the paper's three models, every e of the grid with equal weight.
    """
    lowest = errors["error"].sel(damping_model=list(PAPER_MODELS)).argmin("damping_model")
    e = errors["restitution"]
    is_inside = (e > PAPER_RANGE[0] - 1e-9) & (e < PAPER_RANGE[1] + 1e-9)
    return ((lowest == PAPER_MODELS.index("CDR")) != is_inside).sum("restitution")


def infer(errors: xr.Dataset) -> float:
    """Return the length that reproduces the paper's range best: the middle of the best ones. [-]"""
    count = misclassified(errors)
    best = errors["response_length"].values[count.values == count.values.min()]
    return float(best[(best.size - 1) // 2])


def flags(errors: xr.Dataset) -> xr.Dataset:
    """Judge, for each response length, the claims of section 6 that depend on it."""
    error = errors["error"]
    secant = error.sel(damping_model=["CDR", "SDR"]).max("damping_model")
    constant = error.sel(damping_model="CDC", drop=True)
    is_below = (secant < constant).all("restitution")
    rises = (error.diff("restitution") < 0).all("restitution")
    return xr.Dataset(
        {
            "misclassified": misclassified(errors),
            "secant_below_constant": is_below.astype("int8"),
            "error_rises_as_restitution_falls": rises.astype("int8"),
        }
    )
