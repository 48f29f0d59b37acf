"""The exception for bad input, and the checks that raise it.

A rule is a pair: a function that tests values, and the allowed values in words. Every number that a
user passes comes through `check`, which copies it: frozen objects do not change with the caller's
arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

Rule: TypeAlias = tuple[Callable[[NDArray[np.float64]], ArrayLike], str]
T = TypeVar("T")


class InputError(ValueError):
    """Bad input: the name, the value and the allowed range.

    A message reads ``NAME is VALUE; it must be ALLOWED``.

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
    """Return a copy of `value` as an array of floats.

    The message of an error reads ``NAME is VALUE; it must be ALLOWED`` and shows the first wrong
    value.

    Parameters
    ----------
    name : str
        Name of the quantity in the message.
    value : float or array_like
        Number or numbers to check.
    valid : callable
        Test of an array; its result broadcasts against the array.
    allowed : str
        Allowed values in words, for the message.

    Raises
    ------
    InputError
        If `value` is neither a number nor an array of numbers, or if any of its numbers is not
        finite or not `valid`.
    """
    array = _copy_numbers(name, value)
    good = np.isfinite(array) & np.asarray(valid(array))
    if not good.all():
        wrong = np.broadcast_to(array, good.shape)[~good].flat[0]
        raise InputError(f"{name} is {wrong:g}; it must be {allowed}")
    return array


def check_number(
    name: str, value: ArrayLike, valid: Callable[[NDArray[np.float64]], ArrayLike], allowed: str
) -> float:
    """Return one number as a float; raise as `check` does, and for an array of another size."""
    array = check(name, value, valid, allowed)
    if array.size != 1:
        raise InputError(f"{name} is {_shorten(value)}; it must be one number, {allowed}")
    return float(array.item())


def check_fields(instance: object, rules: Mapping[str, Rule]) -> None:
    """Check the fields of a frozen dataclass by their rules, and store them as arrays of floats."""
    for name, (valid, allowed) in rules.items():
        object.__setattr__(instance, name, check(name, getattr(instance, name), valid, allowed))


def check_choice(name: str, value: str, choices: Sequence[str]) -> str:
    """Return `value`. Raise `InputError` unless it is one of the choices."""
    if not isinstance(value, str) or value not in choices:
        raise InputError(f"{name} is {_shorten(value)}; it must be one of {', '.join(choices)}")
    return value


def check_type(name: str, value: T, *types: type) -> T:
    """Return `value`. Raise `TypeError` unless it is an instance of one of the types."""
    if not isinstance(value, types):
        allowed = " or ".join(kind.__name__ for kind in types)
        raise TypeError(f"{name} is {_shorten(value)}; it must be {allowed}")
    return value


def check_list(name: str, value: T | Iterable[T], kind: type[T]) -> list[T]:
    """Return one object of a type, or several, as a list.

    Raise `TypeError` for other types, `InputError` for an empty list.
    """
    if isinstance(value, kind):
        return [value]
    if isinstance(value, str) or not isinstance(value, Iterable):
        raise TypeError(f"{name} is {_shorten(value)}; it must be {kind.__name__}, or a list of it")
    members = [check_type(name, member, kind) for member in value]
    if not members:
        raise InputError(f"{name} is empty; it must be {kind.__name__}, or a list of it")
    return members


def _copy_numbers(name: str, value: ArrayLike) -> NDArray[np.float64]:
    allowed = "a number or an array of numbers"
    if np.ma.is_masked(value):
        raise InputError(f"{name} has masked values; it must be {allowed}")
    try:
        array = np.asarray(value)
    except ValueError:
        raise InputError(f"{name} is a ragged list; it must be {allowed}") from None
    if array.dtype.kind not in "biuf":
        raise InputError(f"{name} is {_shorten(value)}; it must be {allowed}")
    if isinstance(value, list | tuple) and not array.size:
        raise InputError(f"{name} is empty; it must be {allowed}")
    return np.array(array, dtype=float)


def _shorten(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 50 else f"{text[:50]}..."
