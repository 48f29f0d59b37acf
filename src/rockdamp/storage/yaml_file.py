"""YAML: documents of the package by PyYAML's compiled parser, those of users by YAML 1.2, with lines for errors.

Dotted keys, ``studies.amplitude.release_amplitude[2]``, name what stands in a document.

Every job reads the package's documents, which both versions of YAML read alike. In a user's file YAML 1.1 takes 1:30
for 90 and 010 for 8, and of two keys of one name it keeps the last; ruamel.yaml, which reads YAML 1.2, does not.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from copy import deepcopy
from functools import cache, lru_cache
from typing import Any

import yaml

from rockdamp.errors import InputError
from rockdamp.storage import input_file

try:
    from yaml import CSafeLoader as _Loader
except ImportError:  # a PyYAML built without libyaml
    from yaml import SafeLoader as _Loader  # type: ignore[assignment]

KeyPath = tuple[str | int, ...]

_PART = re.compile(r"\[(\d+)\]|([^.\[\]]+)")


def load(text: str) -> Any:
    """Return what a document of the package holds."""
    return yaml.load(text, Loader=_Loader)


def read(path: str | os.PathLike[str]) -> Any:
    """Return what a user's YAML file holds.

    What cannot be read, is not text in UTF-8 or not YAML, has a key twice, or has an alias of what it stands in raises
    `InputError`, in one line.
    """
    document = _parsed(path, "safe")
    loop = _loop(document, (), ())
    if loop is not None:
        raise InputError(f"{os.fspath(path)}: {dotted(loop)} is an alias of what it stands in; it must be a value")
    return deepcopy(document)


def _loop(value: Any, key: KeyPath, around: tuple[int, ...]) -> KeyPath | None:
    """Return the key of the first value that is one of those `around` it; None where there is none."""
    if id(value) in around:
        return key
    items = value.items() if isinstance(value, Mapping) else enumerate(value) if isinstance(value, list) else ()
    below = (_loop(inner, (*key, name), (*around, id(value))) for name, inner in items)
    return next((found for found in below if found is not None), None)


def line_of(path: str | os.PathLike[str], key: KeyPath) -> int | None:
    """Return the line of a key, or of an item of a list, in a YAML file; None where the file does not have it."""
    node, line = _parsed(path, "rt"), None
    for part in key:
        try:
            line = (node.lc.item(part) if isinstance(part, int) else node.lc.key(part))[0] + 1
            node = node[part]
        except (AttributeError, LookupError, TypeError):
            return None
    return line


def _parsed(path: str | os.PathLike[str], kind: str) -> Any:
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    text = input_file.text(input_file.content(path, "YAML"), path)
    try:
        return _document(text, kind)
    except RecursionError:
        raise InputError(f"{os.fspath(path)}: is nested too deep; it must be YAML") from None
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f", line {mark.line + 1}" if mark else ""
        said = " ".join(str(error.problem or error.context).split()).partition(" with value ")[0]
        raise InputError(f"{os.fspath(path)}{line}: {said}; it must be YAML") from None
    except (
        YAMLError,
        ValueError,
        OverflowError,
        TypeError,
        AttributeError,
    ) as error:  # of values that are tagged wrongly
        raise InputError(f"{os.fspath(path)}: {' '.join(str(error).split())}; it must be YAML") from None


@lru_cache(maxsize=8)  # the values and the lines of few files, for one error after the other
def _document(text: str, kind: str) -> Any:
    from ruamel.yaml import YAML

    parser = YAML(typ=kind, pure=True)
    if kind == "safe":
        parser.Constructor = _constructor()
    return parser.load(text)


@cache
def _constructor() -> type[Any]:
    """Return ruamel.yaml's constructor of plain values, without 0.8_5, which no other input takes for a number."""
    from ruamel.yaml.constructor import ConstructorError, SafeConstructor

    class Constructor(SafeConstructor):
        pass

    def number(constructor: Any, node: Any) -> Any:
        if "_" in node.value:
            said = f"{node.value!r} is no number; text must stand in quotes"
            raise ConstructorError(None, None, said, node.start_mark)
        return plain[node.tag](constructor, node)

    tags = ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")
    plain = {tag: SafeConstructor.yaml_constructors[tag] for tag in tags}
    for tag in tags:
        Constructor.add_constructor(tag, number)
    return Constructor


# --- dotted keys -----------------------------------------------------------------------------------------------------


def path_of(key: str) -> KeyPath:
    """Return the keys and list indices that a dotted key names."""
    return tuple(int(index) if index else name for index, name in _PART.findall(key))


def dotted(path: KeyPath) -> str:
    """Return a path as a dotted key."""
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path).removeprefix(".")


def get(whole: Any, key: str | KeyPath) -> Any:
    """Return the value at a dotted key; without such a key it raises `LookupError`."""
    value: Any = whole
    for part in path_of(key) if isinstance(key, str) else key:
        if not isinstance(value, list if isinstance(part, int) else Mapping):
            raise KeyError(key)
        value = value[part]  # type: ignore[index] # the kind fits the part
    return value
