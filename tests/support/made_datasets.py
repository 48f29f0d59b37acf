"""Datasets made up for tests, with names, units and meanings from the glossary."""

import numpy as np
import xarray as xr

from rockdamp.storage import dataset


def make_dataset(kind, coordinates, **values):
    """Return a dataset of a kind of the glossary, with the variables that a test needs.

    Parameters
    ----------
    kind : str
        Kind of dataset, such as "earthquakes".
    coordinates : dict
        Values of each dimension in order, or their number; a float is a coordinate without a
        dimension.
    **values : number, array or (dimensions, array)
        Variables: a number, an array over all dimensions, or a pair that names its dimensions.

    Examples
    --------
    >>> study = make_dataset(
    ...     "supports", {"assumption": ["one", "two"], "wall": ["all"]}, stations=8
    ... )
    """
    unknown = {*coordinates, *values} - set(dataset.variables(kind))
    if unknown:
        raise ValueError(f"the glossary has no {sorted(unknown)} in {kind}")
    coords = {}
    for name, members in coordinates.items():
        coords[name] = np.arange(members) if isinstance(members, int) else members
    dims = [name for name, members in coords.items() if np.ndim(members)]
    shape = tuple(len(coords[name]) for name in dims)
    variables = {}
    for name, value in values.items():
        if isinstance(value, tuple) or np.ndim(value) == 0:
            variables[name] = value
        elif np.shape(value) == shape:
            variables[name] = (dims, np.asarray(value))
        else:
            raise ValueError(
                f"{name} has shape {np.shape(value)}; name its dimensions, or use {shape}"
            )
    return dataset.describe(xr.Dataset(variables, coords=coords), kind)
