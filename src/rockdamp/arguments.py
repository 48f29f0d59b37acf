"""What is given, made into what is computed with: one conversion for each kind of argument, where it comes in.

Each names the argument and says what it wants. Numbers are real and finite, and none of text, truth values, complex
numbers, masks or units of another package is taken for them. Arrays are copied, and the copy cannot be written: what
was checked stays as it was.
"""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Collection, Mapping
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rockdamp.arrays import Array, Quantity, is_named
from rockdamp.errors import InputError, require, shown

MOST_ELEMENTS = 2**28  # of one array: 2 GB, beyond which the system ends the process instead of raising an error
NUMBER = "a number, or an array of them"


def numbers(name: str, value: Any) -> Array:
    """Return real, finite numbers as an array of floats of its own, which cannot be written.

    Parameters
    ----------
    name : str
        What the argument is called, for the error.
    value : object
        A number, an array, or a sequence of numbers; of one of xarray's the names are dropped.

    Raises
    ------
    InputError
        If it is anything else, or not finite.
    """
    array = np.array(real(name, value))
    require(np.isfinite(array), name, array, "a finite number")
    return kept(array)


def kept(array: Any) -> Any:
    """Return an array that cannot be written from now on."""
    array.setflags(write=False)
    return array


def real(name: str, value: Any) -> Array:
    """Return real numbers as a contiguous array of floats, not copied where they are one, finite or not.

    Raises
    ------
    InputError
        If it is anything else.
    """
    if type(value) is float or type(value) is np.ndarray and value.dtype == np.float64:
        return np.asarray(value, order="C")  # what is given most often, without the search for what else it may be
    _refuse_what_looks_like_numbers(name, value)
    try:
        found = value.values if is_named(value) else np.asarray(value)
        if found.dtype.kind == "O" and isinstance(value, Real):  # a fraction, or more than 64 bits
            found = np.asarray(float(value))
        kind = found.dtype.kind
    except OverflowError:
        raise InputError(f"{name} is {shown(value)}; it must be a finite number") from None
    except Exception:  # whatever an object raises when it is asked for its numbers
        kind = ""
    if kind not in ("i", "u", "f"):
        raise InputError(f"{name} is {shown(value)}; it must be {NUMBER}")
    if found.dtype == np.float64:
        return np.asarray(found, order="C")
    with np.errstate(over="ignore"):
        return np.asarray(found, dtype=float, order="C")


def whole_numbers(name: str, value: Any) -> NDArray[np.int64]:
    """Return whole numbers as an array of its own, which cannot be written.

    Raises
    ------
    InputError
        If one is not whole or beyond 64 bits, or it is anything else.
    """
    given = numbers(name, value)
    within = (given == np.floor(given)) & (np.abs(given) < 2**53)
    require(within, name, given, "whole")
    return kept(given.astype(np.int64))


def _refuse_what_looks_like_numbers(name: str, value: Any) -> None:
    """Raise for what NumPy would turn into numbers and leave the half of: masks, units, datasets."""
    if isinstance(value, np.ma.MaskedArray):
        raise InputError(f"{name} is a masked array; it must be {NUMBER}, with what is masked filled or left out")
    if isinstance(value, np.ndarray | float) and hasattr(value, "unit") or hasattr(value, "magnitude"):
        raise InputError(f"{name} is {shown(value)}; it must be {NUMBER}, in SI units and without the unit")
    if is_named(value) and not isinstance(getattr(value, "values", None), np.ndarray):
        raise InputError(f"{name} is {shown(value)}; it must be {NUMBER}, or an xarray.DataArray")


def number(name: str, value: Any) -> float:
    """Return one real, finite number.

    Raises
    ------
    InputError
        If it is anything else, as an array is.
    """
    array = numbers(name, value)
    if array.ndim:
        raise InputError(f"{name} has shape {array.shape}; it must be one number")
    return float(array)


def quantity(name: str, value: Any) -> Quantity:
    """Return a number as a float, an array as `numbers` does, and one of xarray's with its names.

    Raises
    ------
    InputError
        As `numbers`.
    """
    array = numbers(name, value)
    if is_named(value):
        own = value.astype(float)
        own.values.flags.writeable = False
        return own
    return array if array.ndim else float(array)


def together(**values: Quantity) -> list[Any]:
    """Return the parameters of one object as arrays; broadcast by name where any of them has named dimensions.

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
        If a value is no number, arrays with and without names are mixed, shapes do not broadcast, or two have unlike
        values along a dimension of one name.
    """
    plain = {name: numbers(name, value) for name, value in values.items()}
    if not any(is_named(value) for value in values.values()):
        broadcast(**plain)
        return list(plain.values())
    import xarray as xr  # only who brings such an array waits for it to load

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
    """Return the shape that values broadcast to: of arrays, or of what has a `shape`.

    Raises
    ------
    InputError
        If they do not.
    """
    shapes: dict[str, tuple[int, ...]] = {}
    for name, value in values.items():
        own = getattr(value, "shape", None)
        shapes[name] = np.shape(value) if own is None else own
    unlike = {shape for shape in shapes.values() if shape}  # NumPy is slow at scalars and at shapes that are alike
    try:
        shape = np.broadcast_shapes(*unlike) if len(unlike) > 1 else unlike.pop() if unlike else ()
    except ValueError:
        raise InputError(f"shapes do not broadcast against each other: {_stated(shapes)}") from None
    if math.prod(shape) > MOST_ELEMENTS:
        most = f"there must be at most {MOST_ELEMENTS:,} elements"
        raise InputError(f"shapes broadcast to {shape}: {_stated(shapes)}; {most}")
    return shape


def _stated(shapes: Mapping[str, tuple[int, ...]]) -> str:
    return ", ".join(f"{name} {shape}" for name, shape in shapes.items() if shape)


def whole(name: str, value: Any, least: int, most: int | None = None) -> int:
    """Return a whole number between `least` and `most`.

    Raises
    ------
    InputError
        If it is anything else: 8.0 is none.
    """
    try:
        if isinstance(value, bool | np.bool_):
            raise TypeError
        count = operator.index(value)
        within = least <= count and (most is None or count <= most)
    except Exception:  # whatever an object raises when it is asked for its number
        count, within = value, False
    if not within:
        allowed = f"a whole number, at least {least}" + (f" and at most {most:,}" if most is not None else "")
        raise InputError(f"{name} is {shown(count)}; it must be {allowed}")
    return count


def one_of(name: str, value: Any, allowed: Collection[str], why: str = "") -> str:
    """Return the one of the `allowed` names that is meant, in capitals or in small letters.

    Raises
    ------
    InputError
        If it is none of them.
    """
    known = {text.casefold(): text for text in allowed}
    meant = known.get(value.casefold()) if isinstance(value, str) else None
    if meant is None:
        raise InputError(f"{name} is {shown(value)}; it must be one of {', '.join(allowed)}{why}")
    return meant


def instance(name: str, value: Any, *kinds: type[Any]) -> Any:
    """Return an object of one of some classes.

    Raises
    ------
    InputError
        If it is of another one.
    """
    if not isinstance(value, kinds):
        wanted = " or ".join(f"a {kind.__name__}" for kind in kinds)
        raise InputError(f"{name} is {shown(value)}; it must be {wanted}")
    return value


def path(name: str, value: Any) -> Path:
    """Return a path.

    Raises
    ------
    InputError
        If it is no text or path of the system.
    """
    try:
        text = os.fspath(value) if isinstance(value, str | os.PathLike) else ""
        usable = isinstance(text, str) and text != "" and b"\0" not in os.fsencode(text)
    except Exception:  # whatever an object raises when it is asked for its path, or a name that no system has
        usable = False
    if not usable:
        raise InputError(f"{name} is {shown(value)}; it must be a path")
    return Path(text)


def several(name: str, value: Any, wanted: str) -> list[Any]:
    """Return what is given one after the other as a list.

    Raises
    ------
    InputError
        If it is a mapping, bytes, or cannot be gone through.
    """
    try:
        if isinstance(value, Mapping | bytes):
            raise TypeError
        return list(value)
    except Exception:  # whatever an object raises when it is gone through
        raise InputError(f"{name} is {shown(value)}; it must be {wanted}") from None
