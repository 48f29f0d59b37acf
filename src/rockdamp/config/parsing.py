"""From values of the config to the fields of a frozen dataclass: a field's type says what its value must be.

An annotation may add the dotted key that the value stands at, ``Annotated[float, "windows.stop"]``, and a function that
parses it, ``Annotated[Array, geometric]``; a field without the first is named after its key.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import NoneType
from typing import Annotated, Any, Self, get_args, get_origin, get_type_hints

import numpy as np

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.errors import InputError

Parser = Callable[[Any, str], Any]  # takes a value and its dotted key


class Settings:
    """Base of what a stage depends on: a frozen dataclass whose fields name keys of the config."""

    @classmethod
    def of(cls, config: Config) -> Self:
        """Parse the config, or a part of it that has the stage's keys.

        Raises
        ------
        InputError
            If a key is missing, a section has a key that is not known, or a value is of another kind.
        """
        return cls(**{name: parse(_at(config, key), key) for name, (key, parse) in _fields(cls).items()})

    @classmethod
    def keys(cls) -> list[str]:
        """Return the dotted keys of the config that `of` reads."""
        return [key for key, _ in _fields(cls).values()]


def section(kind: type[Any], value: Any, key: str) -> Any:
    """Parse a whole section as the dataclass `kind`; only a field that may be None may be left out."""
    known = _fields(kind)
    hints = get_type_hints(kind)
    optional = [name for name in known if NoneType in get_args(hints[name])]
    given = members(value, key, [name for name in known if name not in optional], optional)
    return kind(**{name: known[name][1](inner, f"{key}.{name}") for name, inner in given.items()})


def members(value: Any, key: str, needed: Sequence[str], optional: Sequence[str] = ()) -> dict[str, Any]:
    """Return the values of a section that has the `needed` keys, may have the `optional` ones, and no others."""
    if not isinstance(value, Mapping):
        raise refusal(value, key, "a mapping of keys to values")
    for name in value:
        if name not in needed and name not in optional:
            allowed = ", ".join([*needed, *optional])
            raise InputError(f"{key}.{name} is not a key of the config; it must be one of {allowed}")
    for name in needed:
        if name not in value:
            raise InputError(f"{key}.{name} is missing from the config")
    return dict(value)


def refusal(value: Any, key: str, allowed: str) -> InputError:
    """Return the error that says what the config has at `key`, and what it must be."""
    return InputError(f"{key} of the config is {value!r}; it must be {allowed}")


def number(value: Any, key: str) -> float:
    """Return a number, as a float."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise refusal(value, key, "a number")
    return float(value)


def whole(value: Any, key: str) -> int:
    """Return a whole number; 8.0 is one, as it is in the schema."""
    if isinstance(value, bool) or not isinstance(value, int | float) or value != int(value):
        raise refusal(value, key, "a whole number")
    return int(value)


def text(value: Any, key: str) -> str:
    """Return a text."""
    if not isinstance(value, str):
        raise refusal(value, key, "text")
    return value


def each(parse: Parser, value: Any, key: str) -> tuple[Any, ...]:
    """Parse the items of a list."""
    if not isinstance(value, list | tuple):
        raise refusal(value, key, "a list")
    return tuple(parse(item, f"{key}[{index}]") for index, item in enumerate(value))


def numbers(value: Any, key: str) -> Array:
    """Return a list of numbers as an array."""
    return np.array(each(number, value, key))


def arithmetic(value: Any, key: str) -> Array:
    """Return the values from ``start`` to ``stop`` by ``step``, rounded to 12 decimals, lest 0.85 be a little more."""
    given = {
        name: number(inner, f"{key}.{name}") for name, inner in members(value, key, ("start", "stop", "step")).items()
    }
    count = round((given["stop"] - given["start"]) / given["step"]) + 1
    return np.round(given["start"] + given["step"] * np.arange(count), 12)


def geometric(value: Any, key: str) -> Array:
    """Return ``count`` values from ``start`` to ``stop`` in a geometric sequence."""
    given = members(value, key, ("start", "stop", "count"))
    start, stop = (number(given[name], f"{key}.{name}") for name in ("start", "stop"))
    return np.geomspace(start, stop, whole(given["count"], f"{key}.count"))


def _at(config: Any, key: str) -> Any:
    for name in key.split("."):
        if not isinstance(config, Mapping) or name not in config:
            raise InputError(f"{key} is missing from the config")
        config = config[name]
    return config


def _fields(kind: type[Any]) -> dict[str, tuple[str, Parser]]:
    """The key that each field of a dataclass is read from, and what parses it."""
    return {name: _read(name, hint) for name, hint in get_type_hints(kind, include_extras=True).items()}


def _read(name: str, hint: Any) -> tuple[str, Parser]:
    added = hint.__metadata__ if get_origin(hint) is Annotated else ()
    key = next((part for part in added if isinstance(part, str)), name)
    parse = next((part for part in added if callable(part)), None)
    return key, parse or _parser(get_args(hint)[0] if added else hint)


def _parser(kind: Any) -> Parser:
    kind = next((part for part in get_args(kind) if NoneType in get_args(kind) and part is not NoneType), kind)
    if kind in PARSERS:
        return PARSERS[kind]
    return partial(section, kind)


PARSERS: dict[Any, Parser] = {
    float: number,
    int: whole,
    str: text,
    Array: numbers,
    tuple[str, ...]: partial(each, text),
}
