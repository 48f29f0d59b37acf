"""Functions of fragility for OpenQuake, of a wall and of the population."""

from __future__ import annotations

import xarray as xr

from rockdamp.storage.nrml import Collapse


def of_wall(answer: xr.Dataset, name: str) -> list[Collapse]:
    """Return the fragility of one wall under each damping model, of what `assess` returned.

    Parameters
    ----------
    answer : xarray.Dataset
    name : str
        Of the wall; that of the damping model follows it.
    """
    measure = str(answer.attrs["intensity_measure"]).lower()
    return [
        Collapse(
            f"{name}-{model}",
            float(answer[f"median_{measure}"].sel(damping_model=model)),
            float(answer["dispersion"].sel(damping_model=model)),
            answer[f"stripe_{measure}"].values.tolist(),
            (answer["stripe_collapses"].sel(damping_model=model) / answer["records"]).values.tolist(),
        )
        for model in map(str, answer["damping_model"].values)
    ]


def of_population(population: xr.Dataset, name: str = "population") -> list[Collapse]:
    """Return the fragility of the population of walls under each damping model, by peak ground velocity.

    Parameters
    ----------
    population : xarray.Dataset
        Of `population.nc`.
    name : str
    """
    return [
        Collapse(
            f"{name}-{model}",
            float(population["median_intensity"].sel(damping_model=model)),
            float(population["dispersion"].sel(damping_model=model)),
            population["intensity"].values.tolist(),
            population["collapse_fraction"].sel(damping_model=model).values.tolist(),
        )
        for model in map(str, population["damping_model"].values)
    ]
