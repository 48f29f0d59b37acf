"""Read the data files that list claims and errata."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

from rockdamp.config.merging import origin
from rockdamp.config.schema import schema_problems
from rockdamp.errors import InputError
from rockdamp.storage import yaml_file
from rockdamp.storage.dotted_keys import KeyPath, dotted

Check = Callable[[Sequence[dict[str, Any]]], list[tuple[KeyPath, str]]]


def read_list(path: str | os.PathLike[str], key: str, schema: str, check: Check) -> list[dict[str, Any]]:
    """Read the list under `key`, the one key of a YAML file, that fits `schema`; every ``id`` must differ.

    `schema` is a file of this package, JSON Schema as YAML. `check` may return more that is wrong with the list, as
    paths of keys and texts. An `InputError` has a line for each thing that does not fit, and where it stands.
    """
    document = yaml_file.read(path)
    if not isinstance(document, dict):
        raise InputError(f"{os.fspath(path)} must be a mapping with the key {key}")
    wanted = yaml_file.load(files("rockdamp.claims").joinpath(schema).read_text(encoding="utf-8"))
    problems = [(problem.path, problem.text) for problem in schema_problems(document, wanted)]
    if not problems:
        problems = _repeated(key, document[key]) + check(document[key])
    if problems:
        lines = (f"{origin(where, document, [Path(path)])}: {dotted(where)} {text}" for where, text in problems)
        raise InputError("\n".join(lines))
    return document[key]


def _repeated(key: str, entries: Sequence[dict[str, Any]]) -> list[tuple[KeyPath, str]]:
    ids = [entry["id"] for entry in entries]
    return [
        ((key, index, "id"), f"is {name!r} again; each must differ")
        for index, name in enumerate(ids)
        if name in ids[:index]
    ]
