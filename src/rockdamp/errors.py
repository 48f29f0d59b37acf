"""Exception for bad input, checks that raise it, and warnings of input that may be bad."""

from __future__ import annotations

import re
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

MOST_SHOWN = 80  # characters of a value
_LONG = re.compile(r"\S{300,}|'[^']{300,}'")  # no path that is meant is as long
_UNPRINTABLE = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")


def printable(text: str) -> str:
    """Return a text with long values cut off, and control characters, which a terminal would obey, as escapes."""
    text = _LONG.sub(lambda value: f"{value[0][:MOST_SHOWN]}...", text)
    return _UNPRINTABLE.sub(lambda letter: letter[0].encode("unicode_escape").decode("ascii"), text)


class InputError(ValueError):
    """Report input outside what the model allows: its name, value, allowed range and source.

    Examples
    --------
    >>> import rockdamp as rd
    >>> try:
    ...     rd.Damping("CR", 1.2)
    ... except rd.InputError as error:
    ...     print(error)
    restitution is 1.2; it must be at least 0 and at most 1
    """

    def __init__(self, message: str, name: str = "") -> None:
        super().__init__(printable(message))
        self.name = name.partition(" ")[0]  # of the argument that the message begins with, if any
        self.text = printable(message[len(name) :].strip())


class InputWarning(UserWarning):
    """Warn of input that is possible and unlikely: its value, what is usual, and the likely slip.

    Examples
    --------
    >>> import warnings
    >>> import rockdamp as rd
    >>> with warnings.catch_warnings(record=True) as caught:
    ...     warnings.simplefilter("always")
    ...     wall = rd.Wall(thickness=0.24, height=300)
    >>> caught[0].category is rd.InputWarning
    True
    """


Rule: TypeAlias = tuple[Callable[[NDArray[np.float64]], ArrayLike], str]  # what is valid, and the same in words


def check(name: str, value: ArrayLike, valid: Callable[[NDArray[np.float64]], ArrayLike], allowed: str) -> NDArray[Any]:
    """Return `value` as an array of floats. Raise `InputError` unless it is finite and `valid` everywhere.

    The message reads ``NAME is VALUE; it must be ALLOWED`` and shows the first value that is wrong.
    """
    array = np.asarray(value, dtype=float)
    good = np.isfinite(array) & np.asarray(valid(array))
    if not good.all():
        wrong = np.broadcast_to(array, good.shape)[~good].flat[0]
        raise InputError(f"{name} is {wrong:g}; it must be {allowed}", name)
    return array


def check_fields(instance: object, rules: Mapping[str, Rule]) -> None:
    """Check the fields of a frozen dataclass by their rules, and store them as arrays of floats."""
    for name, (valid, allowed) in rules.items():
        object.__setattr__(instance, name, check(name, getattr(instance, name), valid, allowed))


def check_choice(name: str, value: str, choices: Sequence[str]) -> str:
    """Return `value`. Raise `InputError` unless it is one of the choices."""
    if value not in choices:
        raise InputError(f"{name} is {value!r}; it must be one of {', '.join(choices)}", name)
    return value


def require(condition: ArrayLike, name: str, value: Any, allowed: str) -> None:
    """Raise `InputError` unless `condition` holds everywhere; of an array the first offending element is named.

    The message reads ``NAME is VALUE; it must be ALLOWED``.
    """
    if holds(condition):
        return
    if np.ndim(value):
        values, bad = np.broadcast_arrays(np.asarray(value), ~np.asarray(condition))
        value = values[bad][0]
    raise InputError(f"{name} is {shown(value)}; it must be {allowed}", name)


def holds(condition: ArrayLike | bool) -> bool:
    """Return True if a condition holds everywhere."""
    if isinstance(condition, bool):  # the usual case, quickly
        return condition
    condition = np.asarray(condition)
    if condition.size == 1:
        return bool(condition.item())
    return bool(np.count_nonzero(condition) == condition.size)  # `all` takes four times as long where there are few


def shown(value: Any) -> str:
    """Return a value as an error shows it: on one line, and cut off where it is long."""
    if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim == 0):
        value = value.item()
    text = " ".join(repr(value).split())
    return text if len(text) <= MOST_SHOWN else f"{text[:MOST_SHOWN]}..."


def tell(text: str) -> None:
    """Print a line on standard error, if that is open and has room; `print` would write to standard output instead."""
    if sys.stderr is not None:
        with suppress(OSError):
            print(printable(text), file=sys.stderr, flush=True)


@contextmanager
def warnings_as_lines() -> Iterator[None]:
    """Show each `InputWarning` as one line, ``warning: ...``, once and without the line of Python that gave it."""
    shown_before: set[str] = set()
    with warnings.catch_warnings():
        usual = warnings.showwarning

        def show(message: Warning | str, category: type[Warning], *others: Any, **more: Any) -> None:
            if not issubclass(category, InputWarning):
                usual(message, category, *others, **more)
            elif str(message) not in shown_before:
                shown_before.add(str(message))
                tell(f"warning: {message}")

        warnings.simplefilter("always", InputWarning)
        warnings.showwarning = show
        yield
