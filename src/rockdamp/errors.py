"""The exception for bad input, and the checks that raise it: a rule is what is valid, and the same in words."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Rule: TypeAlias = tuple[Callable[[NDArray[np.float64]], ArrayLike], str]


class InputError(ValueError):
    """Report input outside what the model allows: its name, value and what is allowed.

    Examples
    --------
    >>> import rockdamp as rd
    >>> try:
    ...     rd.Damping("CR", 1.2)
    ... except rd.InputError as error:
    ...     print(error)
    restitution is 1.2; it must be at least 0 and at most 1
    """


def check(
    name: str, value: ArrayLike, valid: Callable[[NDArray[np.float64]], ArrayLike], allowed: str
) -> NDArray[Any]:
    """Return `value` as an array of floats. Raise `InputError` unless it is finite and `valid` everywhere.

    The message reads ``NAME is VALUE; it must be ALLOWED`` and shows the first value that is wrong.
    """
    array = np.asarray(value, dtype=float)
    good = np.isfinite(array) & np.asarray(valid(array))
    if not good.all():
        wrong = np.broadcast_to(array, good.shape)[~good].flat[0]
        raise InputError(f"{name} is {wrong:g}; it must be {allowed}")
    return array


def check_fields(instance: object, rules: Mapping[str, Rule]) -> None:
    """Check the fields of a frozen dataclass by their rules, and store them as arrays of floats."""
    for name, (valid, allowed) in rules.items():
        object.__setattr__(instance, name, check(name, getattr(instance, name), valid, allowed))


def check_choice(name: str, value: str, choices: Sequence[str]) -> str:
    """Return `value`. Raise `InputError` unless it is one of the choices."""
    if value not in choices:
        raise InputError(f"{name} is {value!r}; it must be one of {', '.join(choices)}")
    return value
