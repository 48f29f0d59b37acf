"""Types of a quantity, and a short text of an object that holds quantities."""

from collections.abc import Mapping
from dataclasses import MISSING, fields
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Quantity: TypeAlias = Any  # a number or an array of numbers; NumPy's ArrayLike has no arithmetic


def short_repr(instance: Any, defaults: Mapping[str, Any] | None = None) -> str:
    """Return the call that makes a dataclass, as text, without the fields that have their defaults.

    Parameters
    ----------
    instance : dataclass
        An object with numbers, texts and arrays as fields.
    defaults : dict, optional
        Value that the object stores for a field whose default in the call is None, by field.
    """
    arguments = []
    for field in fields(instance):
        value = getattr(instance, field.name)
        default = field.default if field.default_factory is MISSING else field.default_factory()
        default = (defaults or {}).get(field.name, default)
        if default is MISSING or not np.array_equal(value, default):
            arguments.append(f"{field.name}={_format_value(value)}")
    return f"{type(instance).__name__}({', '.join(arguments)})"


def _format_value(value: Any) -> str:
    if not isinstance(value, np.ndarray):
        return repr(value)
    if value.size <= 6:  # a longer list is hard to read
        return repr(value.tolist())
    return f"<array of shape {value.shape}>"
