"""The files of a config: merged as Snakemake merges them, and where in them a value stands."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rockdamp import units
from rockdamp.config import Config
from rockdamp.errors import InputError, shown
from rockdamp.storage import yaml_file
from rockdamp.storage.dotted_keys import KeyPath, dotted, stated

COMMAND_LINE = "the command line"
SUFFIXES = (".yaml", ".yml", ".json")  # of a config


def merged(files: Iterable[str | Path], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the config of `files`, of which a later one replaces values of an earlier one, with `values` over all."""
    config: dict[str, Any] = {}
    for document in (*map(_read, files), values):
        _update(config, document)
    return config


def _read(file: str | Path) -> Mapping[str, Any]:
    document = yaml_file.read(file)
    if not isinstance(document, Mapping):
        raise InputError(f"{file}: is not a mapping of keys to values; a config must be one")
    return document


def _update(config: dict[str, Any], other: Mapping[str, Any]) -> None:
    for key, value in other.items():
        if isinstance(value, Mapping):
            inner = config.get(key)
            config[key] = inner = dict(inner) if isinstance(inner, Mapping) else {}
            _update(inner, value)
        else:
            config[key] = value


def refuse_unreadable(arguments: Sequence[str]) -> None:
    """End the program with one line where Snakemake would end in a traceback on a config file, or not name it.

    Snakemake reads the files of ``--configfile`` before the Snakefile. The profiles, which it reads first, call this
    with the arguments of its command line. Of ``--config`` Snakemake takes 0.8_5 for a number, as Python does.
    """
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("--configfile", "--configfiles", nargs="+", type=Path, default=[])
    parser.add_argument("--config", "-C", nargs="+", default=[])
    stated = parser.parse_known_args(arguments)[0]
    for file in stated.configfile:
        try:
            _read(file)
        except InputError as error:
            target = file.suffix.lower() not in SUFFIXES
            hint = "; --configfile takes every name that follows it: name targets before it" if target else ""
            raise SystemExit(f"Error: {error}{hint}") from None
    for key, _, value in (entry.partition("=") for entry in stated.config):
        if _is_number(float, value) and not _is_number(units.number, value):
            raise SystemExit(f"Error: --config {key} is {value!r}; a number must have plain digits and no underscore")


def _is_number(read: Callable[[str], float], text: str) -> bool:
    try:
        read(text)
    except ValueError:
        return False
    return True


def refuse_other_readings(config: Config, files: Sequence[str | Path], values: Mapping[str, Any]) -> None:
    """Raise `InputError` where Snakemake, which reads YAML 1.1, took something else from the files than YAML 1.2 does.

    `config` is as Snakemake read it from `files`, in their order, and from the `values` of the command line.
    """
    meant = merged(files, values)
    lines = [
        f"{origin(path, meant, files)}: {dotted(path)} is {shown(value)} in YAML 1.2, and {shown(taken)} in YAML 1.1,"
        " by which Snakemake reads; write it so that both agree: 1.0e-3 for 1e-3, text in quotes"
        for path, value, taken in _differences(meant, config, ())
    ]
    if lines:
        raise InputError("\n".join(lines))


def _differences(one: Any, other: Any, path: KeyPath) -> Iterable[tuple[KeyPath, Any, Any]]:
    """Yield path and both values wherever two documents differ."""
    if isinstance(one, Mapping) and isinstance(other, Mapping) and set(one) == set(other):
        for key in one:
            yield from _differences(one[key], other[key], (*path, key))
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for index, pair in enumerate(zip(one, other, strict=True)):
            yield from _differences(*pair, (*path, index))
    elif repr(one) != repr(other):  # not the values: NaN does not equal itself
        yield path, one, other


def origin(path: KeyPath, config: Config, files: Sequence[str | Path]) -> str:
    """Return the file and line of the value at `path` of the merged `config`, or of its section without such a key.

    The last of the `files` that has the key gives its value; a value that none of them gives is of the command line.
    """
    there = _at(config, path) is not None
    for depth in [len(path)] if there else range(len(path) - 1, 0, -1):
        for file in reversed(files):
            line = yaml_file.line_of(file, path[:depth])
            if line is not None:
                same = not there or _at(yaml_file.read(file), path) == _at(config, path)
                return f"{file}, line {line}" if same else COMMAND_LINE
    return COMMAND_LINE


def _at(config: Any, path: KeyPath) -> str | None:
    try:
        return repr(stated(config, path))  # not the value: NaN does not equal itself
    except LookupError:
        return None
