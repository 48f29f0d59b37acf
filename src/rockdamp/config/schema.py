"""Where a config departs from its schema: one line for each thing, which names key, value and what is allowed."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from jsonschema import Draft202012Validator
from jsonschema.exceptions import ValidationError

from rockdamp.errors import InputError, shown
from rockdamp.storage.dotted_keys import KeyPath, dotted

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

# Old names of keys, whole or of their last part alone, and the names that they have now.
RENAMED = {
    "natural": "earthquakes",
    "earthquakes.scale": "earthquakes.velocity_ratio",
    "windows": "response_lengths",
    "window": "response_length",
    "loops": "damping_force",
    "dispersion": "amplitude_dependence",
    "ladder": "test_series",
    "cracked_stiffness_ratio": "yield_displacement_ratio",
    "fit_cracked_stiffness_ratios": "fit_yield_displacement_ratios",
    "plateau_ratio": "strength_ratio",
    "plateau_ratio_beyond": "strength_ratio_beyond",
    "ultimate_ratio": "ultimate_displacement_ratio",
}
RENAMED_TARGETS = {**RENAMED, "orders": "convergence"}  # the stages were named as their sections of the config
_OLD_TARGET = re.compile(rf"(fig_|)({'|'.join(RENAMED_TARGETS)})(_ratio|)")

ITEMS = {"minItems": "at least", "maxItems": "at most"}
ODD_TEXT = "has a control character, or half a character; it must be one line of text"
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", re.IGNORECASE)
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")


class Problem(NamedTuple):
    """A key, and what is wrong with its value."""

    path: KeyPath
    text: str

    def __str__(self) -> str:
        return f"{dotted(self.path) or 'the config'} {self.text}"


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
                near, text = _unknown((*path, key), known)
                meant |= {(*path, name) for name in near}
                departures.append(Problem((*path, key), text))
        elif error.validator == "required":
            missing += [(*path, key) for key in error.validator_value if key not in error.instance]
        elif "propertyNames" in error.absolute_schema_path:
            name = (*path, error.instance)
            departures.append(Problem(name, _unknown(name, error.validator_value)[1]))
        else:
            departures.append(Problem(path, _misfit(error)))
    departures += [Problem(path, "is missing") for path in missing if path not in meant]
    return list(dict.fromkeys(departures))


def _unknown(path: KeyPath, known: list[str]) -> tuple[list[str], str]:
    """The keys that may be meant by one that is unknown, and what is wrong with it."""
    names = [part for part in path if isinstance(part, str)]
    new = RENAMED.get(".".join(names), RENAMED.get(names[-1])) if names else None
    if new is not None:
        return [new.rpartition(".")[2]], f"is now called {new}"
    near = difflib.get_close_matches(str(path[-1]), known, n=1)
    hint = f"did you mean {near[0]!r}?" if near else f"it must be one of {', '.join(known)}"
    return near, f"is not a key; {hint}"


def refuse_old_targets(targets: Iterable[str]) -> None:
    """Raise `InputError` for a target by its old name, such as ``natural`` or ``fig_natural_ratio``."""
    for old in filter(None, map(_OLD_TARGET.fullmatch, targets)):
        raise InputError(f"{old[0]} is now called {old[1]}{RENAMED_TARGETS[old[2]]}{old[3]}")


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
    if error.validator in ("minItems", "maxItems"):
        return f"has {len(value)} of them; it must be {_allowed(error.schema)}"
    if error.validator == "contains":
        return f"is {shown(value)}; {error.validator_value['const']} must be among them"
    if isinstance(value, str) and _NUMBER.fullmatch(value):
        return f"is the text {value!r}; it must be {_allowed(error.schema)} (YAML's numbers have no quotes)"
    said = "a mapping of keys to values" if isinstance(value, Mapping) else shown(value)
    return f"is {said}; it must be {_allowed(error.schema)}"


def _allowed(schema: Mapping[str, Any]) -> str:
    """Say in words what a part of the schema accepts."""
    if "anyOf" in schema:
        return " or ".join(_allowed(option) for option in schema["anyOf"])
    if "const" in schema:
        return repr(schema["const"])
    if "enum" in schema:
        return f"one of {', '.join(map(str, schema['enum']))}"
    if schema.get("type") == "array":
        bounds = " and ".join(f"{word} {schema[keyword]}" for keyword, word in ITEMS.items() if keyword in schema)
        return f"a list of {bounds}" if bounds else "a list"
    bounds = " and ".join(f"{word} {schema[keyword]:.15g}" for keyword, word in BOUNDS.items() if keyword in schema)
    return f"{NOUNS[schema.get('type', 'number')]} {bounds}".strip()
