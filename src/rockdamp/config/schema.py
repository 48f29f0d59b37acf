"""Where a config departs from its schema: one line for each thing, which names key, value and what is allowed."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from jsonschema import Draft202012Validator
from jsonschema.exceptions import ValidationError

from rockdamp.storage import yaml_file

KeyPath = tuple[str | int, ...]

NOUNS = {
    "number": "a number",
    "integer": "a whole number",
    "string": "text",
    "boolean": "true or false",
    "object": "a mapping of keys to values",
}
BOUNDS = {
    "exclusiveMinimum": "greater than",
    "minimum": "at least",
    "exclusiveMaximum": "less than",
    "maximum": "at most",
}


COMMAND_LINE = "the command line"
ODD_TEXT = "has a control character, or half a character; it must be one line of text"
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")


class Problem(NamedTuple):
    """What is wrong with the value of one key."""

    path: KeyPath
    text: str

    def __str__(self) -> str:
        return f"{dotted(self.path)} {self.text}"


def dotted(path: KeyPath) -> str:
    """Return a path as it is written: ``studies.amplitude.release_amplitude[2]``."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.removeprefix(".") or "the config"


def schema_problems(config: Mapping[str, Any], schema: Mapping[str, Any]) -> list[Problem]:
    """List where `config` does not fit `schema` (JSON Schema, draft 2020-12), or holds a number that is not finite."""
    departures = [
        Problem(path, f"is {value}; it must be a finite number" if isinstance(value, float) else ODD_TEXT)
        for path, value in _odd((), config)
    ]
    missing: list[KeyPath] = []
    meant: set[KeyPath] = set()  # keys that are there, but misspelt
    for error in sorted(Draft202012Validator(schema).iter_errors(config), key=lambda error: error.json_path):
        path = tuple(error.absolute_path)
        if error.validator == "additionalProperties":
            known = list(error.schema["properties"])
            for key in (key for key in error.instance if key not in known):
                near = difflib.get_close_matches(str(key), known, n=1)
                meant |= {(*path, name) for name in near}
                hint = f"did you mean {near[0]!r}?" if near else f"it must be one of {', '.join(known)}"
                departures.append(Problem((*path, key), f"is not a key; {hint}"))
        elif error.validator == "required":
            missing += [(*path, key) for key in error.validator_value if key not in error.instance]
        else:
            departures.append(Problem(path, _misfit(error)))
    departures += [Problem(path, "is missing") for path in missing if path not in meant]
    return list(dict.fromkeys(departures))


def _odd(path: KeyPath, value: Any) -> Iterator[tuple[KeyPath, float | str]]:
    """Numbers that are not finite, and texts that a terminal or a file name cannot hold."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            if isinstance(key, str) and _CONTROL.search(key):
                yield path, key
            else:
                yield from _odd((*path, key), inner)
    elif isinstance(value, list):
        for index, inner in enumerate(value):
            yield from _odd((*path, index), inner)
    elif isinstance(value, float) and not math.isfinite(value) or isinstance(value, str) and _CONTROL.search(value):
        yield path, value


def _misfit(error: ValidationError) -> str:
    value = error.instance
    if error.validator == "uniqueItems":
        twice = next(item for index, item in enumerate(value) if item in value[:index])
        return f"has {twice!r} twice; its values must differ"
    if error.validator == "minItems":
        return f"has {len(value)} of them; it must be {_allowed(error.schema)}"
    if isinstance(value, str) and _is_number(value):
        return f"is the text {value!r}; it must be {_allowed(error.schema)} (YAML's numbers have no quotes)"
    shown = "a mapping of keys to values" if isinstance(value, Mapping) else repr(value)
    return f"is {shown}; it must be {_allowed(error.schema)}"


def _is_number(text: str) -> bool:
    """Whether a text would be a number without its quotes."""
    return any(re.fullmatch(yaml_file.NUMBERS[kind][0], text) for kind in ("int", "float"))


def _allowed(schema: Mapping[str, Any]) -> str:
    """Say in words what a part of the schema accepts."""
    if "anyOf" in schema:
        return " or ".join(_allowed(option) for option in schema["anyOf"])
    if "const" in schema:
        return repr(schema["const"])
    if "enum" in schema:
        return f"one of {', '.join(map(str, schema['enum']))}"
    if schema.get("type") == "array":
        return f"a list of at least {schema['minItems']}" if "minItems" in schema else "a list"
    bounds = " and ".join(f"{word} {schema[keyword]}" for keyword, word in BOUNDS.items() if keyword in schema)
    return f"{NOUNS[schema['type']]} {bounds}".strip()


def origin(path: KeyPath, config: Mapping[str, Any], files: Sequence[str | Path]) -> str:
    """Say where the value at `path` of the merged `config` is from.

    Parameters
    ----------
    path : tuple
        Keys and list indices. Of a key that is missing, its section is looked for.
    config : dict
    files : sequence of paths
        In the order in which they were merged: the last that has the key gives its value.

    Returns
    -------
    str
        ``config/default.yaml, line 9``; or ``the command line`` for a value that none of the files gives.
    """
    there = _at(config, path) is not None
    for depth in [len(path)] if there else range(len(path) - 1, 0, -1):
        for file in reversed(files):
            text = Path(file).read_text(encoding="utf-8")
            line = _line(yaml.compose(text, Loader=yaml_file.Loader), path[:depth])
            if line is not None:
                same = not there or _at(yaml_file.load(text), path) == _at(config, path)
                return f"{file}, line {line}" if same else COMMAND_LINE
    return COMMAND_LINE


def _at(config: Any, path: KeyPath) -> str | None:
    try:
        for part in path:
            config = config[part]
    except LookupError:
        return None
    return repr(config)  # not the value: NaN does not equal itself


def _line(node: yaml.Node | None, path: KeyPath) -> int | None:
    """Line of the key, or of the item of a list, to which `path` leads."""
    line = None
    for part in path:
        if isinstance(node, yaml.MappingNode):
            pairs = [pair for pair in node.value if pair[0].value == str(part)]
            if not pairs:
                return None
            line, node = pairs[-1][0].start_mark.line + 1, pairs[-1][1]
        elif isinstance(node, yaml.SequenceNode) and isinstance(part, int) and part < len(node.value):
            node = node.value[part]
            line = node.start_mark.line + 1
        else:
            return None
    return line


def ascending(path: KeyPath, values: Sequence[float]) -> Iterator[Problem]:
    """Yield a problem for each value that is not greater than the one before it."""
    for index, (before, value) in enumerate(pairwise(values), start=1):
        if not before < value:
            yield Problem((*path, index), f"is {value}; it must be greater than the value before it, {before}")
