"""Parse values of the config into the fields of a `Section`, a frozen dataclass: a field says what its value must be.

An annotation may add the dotted key of the value, ``Annotated[float, "response_lengths.stop"]``, and a function that
parses it, ``Annotated[Array, geometric]``. A field without the first is named after its key.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from types import NoneType
from typing import Annotated, Any, Self, dataclass_transform, get_args, get_origin, get_type_hints

import numpy as np

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.errors import InputError
from rockdamp.storage.dotted_keys import stated

Parser = Callable[[Any, str], Any]  # takes a value and its dotted key
WHOLE = 1e-9  # how far from a whole number of steps a grid's end may lie, as a fraction of the number of steps
_NAMED = re.compile(r"(\w+)(?: \(\w+\))? (is .*)", re.DOTALL)  # an error of a constructor: its argument and the rest


class ConfigError(InputError):
    """Say what is wrong with the value at a dotted key of the config."""

    def __init__(self, key: str, text: str) -> None:
        super().__init__(f"{key} {text}")
        self.key, self.text = key, text


@contextmanager
def made_of(key: str, names: Iterable[str]) -> Iterator[None]:
    """Name the key of the config in an error of what is made of a section with `names`."""
    try:
        yield
    except ConfigError:
        raise
    except InputError as error:
        named = _NAMED.fullmatch(str(error))
        if named and named[1] in names:
            raise ConfigError(f"{key}.{named[1]}", named[2]) from None
        raise ConfigError(key, f"cannot be used: {error}") from None


@dataclass_transform(frozen_default=True)
class Section:
    """Base of a section of the config: a frozen dataclass whose fields name its keys."""

    def __init_subclass__(cls) -> None:
        dataclass(frozen=True)(cls)


class Settings(Section):
    """Base of what a stage depends on, whose fields may name keys of any section."""

    @classmethod
    def of(cls, config: Config) -> Self:
        """Parse the config, or a part of it that has the stage's keys."""
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
    entries = members(value, key, [name for name in known if name not in optional], optional)
    parsed = {name: known[name][1](inner, f"{key}.{name}") for name, inner in entries.items()}
    with made_of(key, parsed):
        return kind(**parsed)


def members(value: Any, key: str, needed: Sequence[str], optional: Sequence[str] = ()) -> dict[str, Any]:
    """Return the values of a section that has the `needed` keys, may have the `optional` ones, and no others."""
    if not isinstance(value, Mapping):
        raise refusal(value, key, "a mapping of keys to values")
    for name in value:
        if name not in needed and name not in optional:
            allowed = ", ".join([*needed, *optional])
            raise ConfigError(f"{key}.{name}", f"is not a key; it must be one of {allowed}")
    for name in needed:
        if name not in value:
            raise ConfigError(f"{key}.{name}", "is missing")
    return dict(value)


def refusal(value: Any, key: str, allowed: str) -> ConfigError:
    """Return the error that says which value the config has at `key`, and what it must be."""
    return ConfigError(key, f"is {value!r}; it must be {allowed}")


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


def ascending(value: Any, key: str) -> Array:
    """Return a list of numbers, each greater than the one before it."""
    array = numbers(value, key)
    for index in np.flatnonzero(~(np.diff(array) > 0)):
        allowed = f"greater than the value before it, {value[index]}"
        raise refusal(value[index + 1], f"{key}[{index + 1}]", allowed)
    return array


Ascending = Annotated[Array, ascending]


def arithmetic(value: Any, key: str) -> Array:
    """Return the values from ``start`` to ``stop`` by ``step``, rounded to 12 decimals, lest 0.85 be a little more."""
    start, stop, step = _grid(value, key, "step")
    steps = (stop - start) / step
    if not abs(steps - round(steps)) <= WHOLE * steps:
        allowed = f"such that a whole number of steps leads from {key}.start, {start:g}, to {key}.stop, {stop:g}"
        raise refusal(value["step"], f"{key}.step", allowed)
    return np.round(start + step * np.arange(round(steps) + 1), 12)


def geometric(value: Any, key: str) -> Array:
    """Return ``count`` values from ``start`` to ``stop`` in a geometric sequence."""
    start, stop, count = _grid(value, key, "count")
    return np.geomspace(start, stop, whole(count, f"{key}.count"))


def _grid(value: Any, key: str, spacing: str) -> list[float]:
    """The numbers of a section with ``start``, ``stop`` and what divides the distance between them."""
    names = ("start", "stop", spacing)
    entries = members(value, key, names)
    start, stop, divider = (number(entries[name], f"{key}.{name}") for name in names)
    if not start < stop:
        raise refusal(entries["stop"], f"{key}.stop", f"greater than {key}.start, {start:g}")
    return [start, stop, divider]


def _at(config: Config, key: str) -> Any:
    try:
        return stated(config, key)
    except LookupError:
        raise ConfigError(key, "is missing") from None


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
