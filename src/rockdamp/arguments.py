"""Convert what a user passes in, once, where it comes in: one function for each kind of argument.

Each function raises `InputError`, which names the argument, its value and what is allowed. Arrays are copied, and the
copy is read-only: what was checked stays as it was.
"""

from __future__ import annotations

import math
import operator
import os
import re
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rockdamp.arrays import Array, Quantity, is_named
from rockdamp.errors import InputError, holds, require, shown

MOST_ELEMENTS = 2**28  # of one array: 2 GB, beyond which the system ends the process instead of raising an error
NUMBER = "a number, or an array of them"
_SECONDS = (r"[0-9]{1,9}(\.[0-9]{0,9})?", "a number of seconds, at least 0")
ENVIRONMENT = {  # variables that Numba, Matplotlib and tqdm read, what they must match, and that in words
    "NUMBA_NUM_THREADS": ("0*[1-9][0-9]{0,4}", "a whole number greater than 0"),
    "SOURCE_DATE_EPOCH": ("[0-9]{1,11}", "a whole number of seconds"),
    "TQDM_MININTERVAL": _SECONDS,
    "TQDM_MAXINTERVAL": _SECONDS,
}


def real(name: str, value: Any) -> Array:
    """Return real numbers, finite or not, as a contiguous array of floats; not copied where they are one.

    Text, truth values, complex numbers, masked values, numbers that carry a unit and names without coordinates are
    refused: NumPy would convert them and lose half of what they say.
    """
    if type(value) is float or type(value) is np.ndarray and value.dtype == np.float64:
        return np.asarray(value, order="C")  # the usual case, quickly
    if isinstance(value, np.ma.MaskedArray):
        if np.ma.is_masked(value):
            raise InputError(
                f"{name} is an array with masked values; it must be {NUMBER}: fill them, or leave them out"
            )
        value = value.data  # netCDF4 masks arrays that miss nothing
    if is_named(value) and not hasattr(value, "coords"):
        raise InputError(f"{name} is a {type(value).__name__} of xarray; it must be {NUMBER}, or an xarray.DataArray")
    inner = getattr(value, "data", value) if is_named(value) else value
    if hasattr(inner, "magnitude") or isinstance(inner, np.ndarray | float) and hasattr(inner, "unit"):  # pint, astropy
        raise InputError(f"{name} is {shown(value)}; it must be {NUMBER}, in SI units and without the unit")
    try:
        array = np.asarray(value.values if is_named(value) else value)
    except (TypeError, ValueError):  # of ragged lists
        array = np.array("")
    if array.dtype.kind not in "iuf":
        raise InputError(f"{name} is {shown(value)}; it must be {NUMBER}")
    return np.asarray(array, dtype=float, order="C")


def finite(name: str, value: Any) -> Array:
    """Return real, finite numbers; not copied where they are an array of floats."""
    array = real(name, value)
    if not (math.isfinite(array.item()) if array.size == 1 else not array.size or holds(np.isfinite(array))):
        require(np.isfinite(array), name, array, "a finite number")
    return array


def numbers(name: str, value: Any) -> Array:
    """Return real, finite numbers as a read-only copy; an xarray.DataArray loses the names of its dimensions."""
    return read_only(finite(name, value).copy())


def read_only(array: Any) -> Any:
    """Return the array, from now on read-only."""
    array.setflags(write=False)
    return array


def number(name: str, value: Any) -> float:
    """Return one real, finite number."""
    array = numbers(name, value)
    if array.ndim:
        raise InputError(f"{name} has shape {array.shape}; it must be one number")
    return float(array)


def whole_numbers(name: str, value: Any) -> NDArray[np.int64]:
    """Return whole numbers as a read-only copy."""
    array = numbers(name, value)
    require((array == np.floor(array)) & (np.abs(array) < 2**53), name, array, "whole")
    return read_only(array.astype(np.int64))


def whole(name: str, value: Any, least: int, most: int | None = None) -> int:
    """Return a whole number between `least` and `most`; 8.0 is none."""
    if type(value) is int and least <= value and (most is None or value <= most):
        return value  # the usual case, quickly
    try:
        count = least - 1 if isinstance(value, bool | np.bool_) else operator.index(value)
    except TypeError:
        count = least - 1
    if count < least or (most is not None and count > most):
        allowed = f"a whole number, at least {least}" + (f" and at most {most:,}" if most is not None else "")
        raise InputError(f"{name} is {shown(value)}; it must be {allowed}")
    return count


def quantity(name: str, value: Any) -> Quantity:
    """Return a number as a float, an array as `numbers` does, and an xarray.DataArray with its names."""
    array = numbers(name, value)
    if is_named(value):
        copy = value.astype(float)
        read_only(copy.values)
        return copy
    return array if array.ndim else float(array)


def together(**values: Quantity) -> list[Any]:
    """Return the parameters of one object as arrays, broadcast by name where any of them is an xarray.DataArray.

    Arrays with and without names are not mixed, and two that share a dimension must agree on its values.
    """
    plain = {name: numbers(name, value) for name, value in values.items()}
    if not any(map(is_named, values.values())):
        if len(plain) > 1:
            broadcast(**plain)
        return list(plain.values())
    import xarray as xr  # slow to load, so only where such an array is passed

    for name, value in values.items():
        if plain[name].ndim and not is_named(value):
            raise InputError(f"{name} is an array without names; beside named ones it must be an xarray.DataArray")
    named = {name: quantity(name, value) for name, value in values.items() if is_named(value)}
    try:
        named = dict(zip(named, xr.broadcast(*xr.align(*named.values(), join="exact", copy=False)), strict=True))
    except ValueError:
        raise InputError(f"{', '.join(named)} have unlike values along a dimension that they share") from None
    return [named.get(name, plain[name]) for name in values]


def broadcast(**values: Any) -> tuple[int, ...]:
    """Return the shape that arrays, or other objects with a `shape`, broadcast to."""
    unlike = {value.shape for value in values.values()}
    unlike.discard(())  # NumPy is slow at scalars and at shapes that are alike
    try:
        shape = np.broadcast_shapes(*unlike) if len(unlike) > 1 else unlike.pop() if unlike else ()
    except ValueError:
        raise InputError(f"shapes do not broadcast against each other: {_stated(values)}") from None
    if math.prod(shape) > MOST_ELEMENTS:
        most = f"there must be at most {MOST_ELEMENTS:,} elements"
        raise InputError(f"shapes broadcast to {shape}: {_stated(values)}; {most}")
    return shape


def _stated(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} {value.shape}" for name, value in values.items() if value.shape)


def one_of(name: str, value: Any, allowed: Collection[str], why: str = "") -> str:
    """Return the one of the `allowed` names that is meant, in capitals or in small letters."""
    known = {text.casefold(): text for text in allowed}
    meant = known.get(value.casefold()) if isinstance(value, str) else None
    if meant is None:
        raise InputError(f"{name} is {shown(value)}; it must be one of {', '.join(allowed)}{why}")
    return meant


def instance(name: str, value: Any, *kinds: type[Any]) -> Any:
    """Return an object of one of some classes."""
    if not isinstance(value, kinds):
        wanted = " or ".join(f"a {kind.__name__}" for kind in kinds)
        raise InputError(f"{name} is {shown(value)}; it must be {wanted}")
    return value


def path(name: str, value: Any) -> Path:
    """Return a path: text, or a path of the system."""
    text = os.fspath(value) if isinstance(value, str | os.PathLike) else ""
    if not isinstance(text, str) or text == "" or "\0" in text:
        raise InputError(f"{name} is {shown(value)}; it must be a path")
    return Path(text)


def several(name: str, value: Any, wanted: str) -> list[Any]:
    """Return what can be iterated over as a list; mappings and bytes are refused."""
    try:
        if isinstance(value, Mapping | bytes):
            raise TypeError
        return list(value)
    except TypeError:
        raise InputError(f"{name} is {shown(value)}; it must be {wanted}") from None


def check_environment() -> None:
    """Raise `InputError` for a variable of the environment on which Numba, Matplotlib or tqdm would break."""
    for name, (pattern, allowed) in ENVIRONMENT.items():
        stated = os.environ.get(name)
        if stated is not None and not re.fullmatch(pattern, stated):
            raise InputError(f"{name} is {stated!r} in the environment; it must be {allowed}, or not set")
