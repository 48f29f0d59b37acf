"""The outcome of a judgement, and the words and statistics that several claims share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.constants import PAPER_MODELS
from rockdamp.text import number, percent, plain

Limits: TypeAlias = Mapping[str, Any]

MODELS = list(PAPER_MODELS)
A1 = "yield_displacement_ratio"
RELEASE = "release_amplitude"


class Judgement(NamedTuple):
    """The outcome of one claim."""

    parts: dict[str, bool]  # whether each part of the claim holds
    numbers: str  # the numbers that decide, as text
    finding: str  # a sentence beside them


class Untestable(Exception):
    """A study has too few values for a claim; the message is a sentence that names them."""


# --- words -------------------------------------------------------------------------------------


short = partial(number, digits=2)


def list_models(values: xr.DataArray, write: Callable[..., str] = percent) -> str:
    """Write a value for each model: ``CDC 48 %, CDR 8.2 %``."""
    models = values["damping_model"].values
    return ", ".join(
        f"{model} {write(value)}" for model, value in zip(models, values.values, strict=True)
    )


def extremes(values: Any, write: Callable[..., str] = percent) -> str:
    """Write the smallest and the largest value: ``37 % to 43 %``."""
    return f"{write(np.min(values))} to {write(np.max(values))}"


def spans(holds: xr.DataArray) -> str:
    """Write the coordinates at which a condition of one dimension holds: ``3 to 5, 8``."""
    coordinates = holds[holds.dims[0]].values
    indices = np.flatnonzero(holds.values.astype(bool))
    if not indices.size:
        return "none"
    runs = np.split(indices, np.flatnonzero(np.diff(indices) > 1) + 1)
    words = []
    for span in runs:
        first = plain(coordinates[span[0]])
        last = plain(coordinates[span[-1]])
        words.append(first if first == last else f"{first} to {last}")
    return ", ".join(words)


def count_cases(holds: xr.DataArray) -> str:
    """Count the values of e at which a condition holds: ``28 of 29 values of e``."""
    count = "all" if holds.all() else f"{int(holds.sum())} of"
    return f"{count} {holds.size} values of e"


# --- statistics --------------------------------------------------------------------------------


def rms(values: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def several(values: xr.DataArray, dim: str) -> xr.DataArray:
    """Return `values`, or raise `Untestable` if they have a single coordinate along `dim`."""
    if values.sizes[dim] < 2:
        name = dim.replace("_", " ")
        raise Untestable(f"The study has one value of the {name}, {plain(values[dim][0])}.")
    return values


def select_paper_values(
    values: xr.DataArray, dim: str, paper_values: Sequence[float]
) -> xr.DataArray:
    """Select the paper's values of `dim`, or all values if fewer than two of them are there."""
    is_paper_value = np.isclose(values[dim].values[:, None], paper_values).any(axis=1)
    if is_paper_value.sum() < 2:
        return values
    return values.isel({dim: is_paper_value})


def dispersion(xi: xr.DataArray, dim: str) -> xr.DataArray:
    """Return the largest less the smallest value along `dim`."""
    several(xi, dim)
    return xi.max(dim) - xi.min(dim)


def spread(xi: xr.DataArray, dim: str) -> xr.DataArray:
    """Return (largest - smallest)/mean along `dim`."""
    return dispersion(xi, dim) / xi.mean(dim)


def mean_spread(xi: xr.DataArray, dim: str) -> xr.DataArray:
    """Return the spread along `dim`, averaged over e: one value for each model."""
    return spread(xi, dim).mean("restitution")


def low_over_high_restitution(values: xr.DataArray) -> xr.DataArray:
    """Return the mean over the lower third of e, divided by that over the upper third."""
    ascending = several(values, "restitution").sortby("restitution")
    third = max(ascending.sizes["restitution"] // 3, 1)
    low = ascending.isel(restitution=slice(None, third)).mean("restitution")
    high = ascending.isel(restitution=slice(-third, None)).mean("restitution")
    return low / high


def is_largest(values: xr.DataArray, model: str) -> xr.DataArray:
    """Return true where `model` has the largest of the models' values."""
    other_models = values.drop_sel(damping_model=model)
    return (values.sel(damping_model=model) > other_models).all("damping_model")


def is_smallest(values: xr.DataArray, model: str) -> xr.DataArray:
    """Return true where `model` has the smallest of the models' values."""
    return is_largest(-values, model)


def rises(values: xr.DataArray, dim: str) -> xr.DataArray:
    """Return true where `values` rise from each coordinate of `dim` to the next."""
    steps = several(values, dim).sortby(dim).diff(dim)
    return (steps > 0).all(dim)


def falls(values: xr.DataArray, dim: str) -> xr.DataArray:
    """Return true where `values` fall from each coordinate of `dim` to the next."""
    return rises(-values, dim)
