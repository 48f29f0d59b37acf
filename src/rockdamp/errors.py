"""The one exception that bad input raises, the checks that raise it, and the warning of input that may be bad."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import ArrayLike


class InputError(ValueError):
    """Input outside what the model allows: names the value, the allowed range and where it came from.

    Examples
    --------
    >>> import rockdamp as rd
    >>> try:
    ...     rd.Damping.cr(1.2)
    ... except rd.InputError as error:
    ...     print(error)
    restitution (e) is 1.2; it must be greater than 0 and at most 1
    """


class RecordWarning(UserWarning):
    """A record that can be used but may not be what it is taken for: names the file, the value and the likely cause."""


def require(condition: ArrayLike, name: str, value: Any, allowed: str) -> None:
    """Raise `InputError` unless `condition` holds everywhere.

    Parameters
    ----------
    condition : bool or array of bool
        Must be true for every element.
    name : str
        What the value is called where the user wrote it, e.g. ``plateau_ratio (b1)``.
    value : object
        The value given; of an array, the first offending element is named.
    allowed : str
        What would have been accepted, e.g. ``between 0 and 1``.
    """
    condition = np.asarray(condition)
    if condition.all():
        return
    if np.ndim(value):
        values, bad = np.broadcast_arrays(np.asarray(value), ~condition)
        value = values[bad][0]
    raise InputError(f"{name} is {_plain(value)}; it must be {allowed}")


def require_finite(name: str, value: ArrayLike) -> None:
    """Raise `InputError` unless every element of `value` is a finite number."""
    try:
        numbers = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name} is {value!r}; it must be a number") from None
    require(np.isfinite(numbers), name, numbers, "a finite number")


def _plain(value: Any) -> str:
    scalar = isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim == 0)
    return repr(value.item() if scalar else value)


@contextmanager
def warnings_as_lines() -> Iterator[None]:
    """Show each `RecordWarning` as one line, ``warning: ...``, without the line of Python that gave it."""
    usual = warnings.formatwarning

    def shown(message: Any, category: type[Warning], filename: str, lineno: int, line: str | None = None) -> str:
        if issubclass(category, RecordWarning):
            return f"warning: {message}\n"
        return usual(message, category, filename, lineno, line)

    warnings.formatwarning = shown
    try:
        yield
    finally:
        warnings.formatwarning = usual
