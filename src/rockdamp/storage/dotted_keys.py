"""Dotted keys of nested mappings and lists: ``studies.amplitude.release_amplitude[2]``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

KeyPath = tuple[str | int, ...]

_PART = re.compile(r"\[(\d+)\]|([^.\[\]]+)")


def path_of(key: str) -> KeyPath:
    """Return the keys and list indices that a dotted key names."""
    return tuple(int(index) if index else name for index, name in _PART.findall(key))


def dotted(path: KeyPath) -> str:
    """Return a path as a dotted key."""
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path).removeprefix(".")


def stated(whole: Any, key: str | KeyPath) -> Any:
    """Return the value at a dotted key; without such a key it raises `LookupError`."""
    value: Any = whole
    for part in path_of(key) if isinstance(key, str) else key:
        if not isinstance(value, list if isinstance(part, int) else Mapping):
            raise KeyError(key)
        value = value[part]  # type: ignore[index] # the kind fits the part
    return value
