"""What a quantity may be: a number, an array, or one of xarray's, which broadcasts by name and not by position."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rockdamp.errors import InputError

Array: TypeAlias = NDArray[np.float64]

# A number or an array of numbers. NumPy's ArrayLike admits text and nested lists too, which no formula takes.
Quantity: TypeAlias = Any


def is_named(value: Quantity) -> bool:
    """Whether a value is an array of xarray's; a number or one of NumPy's has no names."""
    return hasattr(value, "dims")


def together(**values: Quantity) -> list[Any]:
    """Return the parameters of one object as numbers; broadcast by name where any of them has named dimensions.

    Parameters
    ----------
    **values : float, ndarray or xarray.DataArray
        By their names, which errors state.

    Returns
    -------
    list
        In the order given: plain arrays as they are, named ones broadcast to one shape.

    Raises
    ------
    InputError
        If arrays with and without names are mixed, or two have unlike values along a dimension of one name.
    """
    if not any(is_named(value) for value in values.values()):
        return [np.asarray(value, dtype=float) for value in values.values()]
    import xarray as xr  # only who brings such an array waits for it to load

    for name, value in values.items():
        if np.ndim(value) and not is_named(value):
            raise InputError(f"{name} is an array without names; beside named ones it must be an xarray.DataArray")
    named = {name: value.astype(float) for name, value in values.items() if is_named(value)}
    try:
        named = dict(zip(named, xr.broadcast(*xr.align(*named.values(), join="exact", copy=False)), strict=True))
    except ValueError:
        raise InputError(f"{', '.join(named)} have unlike values along a dimension that they share") from None
    return [named[name] if name in named else np.asarray(value, dtype=float) for name, value in values.items()]
