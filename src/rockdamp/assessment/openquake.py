"""Functions of fragility for OpenQuake, of a wall and of the population."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
import xarray as xr
from scipy.special import ndtr

from rockdamp.errors import require
from rockdamp.plausibility import per_cent, warn
from rockdamp.storage.nrml import Collapse

WIDEST = 2.0  # of a modelling dispersion


def description(modelling: float) -> str:
    """Return what a fragility model says of its dispersions."""
    also = f", and a modelling dispersion of {modelling:g}" if modelling else " alone"
    return f"Collapse of rocking walls, by rockdamp. Dispersions are record to record{also}."


def require_modelling(modelling: float) -> None:
    """Raise `InputError` for a modelling dispersion that is none."""
    slip = per_cent(modelling, lambda each: (each >= 0) & (each <= WIDEST))
    require(0 <= modelling <= WIDEST, "modelling_dispersion", modelling, f"between 0 and {WIDEST:g}{slip}")


def with_modelling(collapses: Iterable[Collapse], modelling: float) -> Iterator[Collapse]:
    """Yield fragilities with a modelling dispersion besides that of the records: the root of the sum of squares.

    The shares at the stripes become those of the wider function. A fragility without a function keeps its stripes, and
    is warned of.
    """
    require_modelling(modelling)
    for collapse in collapses:
        if not modelling or not np.isfinite(collapse.dispersion):
            if modelling:
                warn([f"{collapse.name!r} has no lognormal function; the modelling dispersion is not in its stripes"])
            yield collapse
            continue
        total = float(np.hypot(collapse.dispersion, modelling))
        share = ndtr(np.log(np.asarray(collapse.intensity) / collapse.median) / total)
        yield replace(collapse, dispersion=total, share=share.tolist())


def of_wall(answer: xr.Dataset, name: str) -> list[Collapse]:
    """Return the fragility of one wall under each damping model, of what `assess` returned."""
    measure = str(answer.attrs["intensity_measure"]).lower()
    share = answer["stripe_collapses"] / answer["records"]
    return _by_model(answer, name, f"median_{measure}", f"stripe_{measure}", share)


def of_population(population: xr.Dataset, name: str = "population") -> list[Collapse]:
    """Return the fragility under each damping model, by peak ground velocity, of `population.nc`."""
    return _by_model(population, name, "median_intensity", "intensity", population["collapse_fraction"])


def _by_model(dataset: xr.Dataset, name: str, median: str, level: str, share: xr.DataArray) -> list[Collapse]:
    return [
        Collapse(
            f"{name}-{model}",
            float(dataset[median].sel(damping_model=model)),
            float(dataset["dispersion"].sel(damping_model=model)),
            dataset[level].values.tolist(),
            share.sel(damping_model=model).values.tolist(),
        )
        for model in map(str, dataset["damping_model"].values)
    ]
