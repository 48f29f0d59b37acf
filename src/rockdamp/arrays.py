"""Types of a quantity: a number, an array, or an xarray.DataArray, which broadcasts by name. Equality by value."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]

# A number or an array of numbers. NumPy's ArrayLike admits text and nested lists too, which no formula takes.
Quantity: TypeAlias = Any


def is_named(value: Quantity) -> bool:
    """Return True for an xarray.DataArray; numbers and NumPy arrays have no named dimensions."""
    return type(value) is not np.ndarray and hasattr(value, "dims")  # quick for the usual case


class ByValue:
    """Compare objects that hold arrays by value, with one answer for all elements.

    Objects of numbers alone have a hash; with arrays the error says why not.
    """

    def _parts(self) -> tuple[Any, ...]:
        return tuple(getattr(self, field.name) for field in fields(self) if field.compare)  # type: ignore[arg-type]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, type(self)) or type(other) is not type(self):
            return NotImplemented
        return all(_equal(one, another) for one, another in zip(self._parts(), other._parts(), strict=True))

    def __hash__(self) -> int:
        parts = tuple(part.item() if np.ndim(part) == 0 and hasattr(part, "item") else part for part in self._parts())
        try:
            return hash((type(self), *parts))
        except TypeError:
            name = type(self).__name__
            raise TypeError(f"a {name} that holds arrays has no hash: compare it with ==, or give it a name") from None


def _equal(one: Any, other: Any) -> bool:
    if is_named(one) or is_named(other):
        return is_named(one) and is_named(other) and bool(one.equals(other))
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other, equal_nan=True)
    return bool(one == other) or bool(one != one and other != other)  # NaN, as of an array
