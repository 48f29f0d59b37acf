"""What Snakemake is told on its command line: files of a config, and values.

Snakemake reads the files before the Snakefile, and ends in a traceback where one is not text, nested too deep, or holds
what its YAML 1.1 takes for a date of no calendar. The profiles, which it reads first, call `refuse_unreadable`.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import yaml

from rockdamp.config.merging import merged, update
from rockdamp.errors import InputError
from rockdamp.storage import yaml_file

_KEY = re.compile(r"[a-zA-Z_][\w-]*\w")  # that Snakemake takes


def refuse_unreadable(arguments: Sequence[str], load: Callable[[Path], Any]) -> None:
    """End the program with one line where Snakemake would end in a traceback on a config that it is given.

    Parameters
    ----------
    arguments : sequence of str
        Of Snakemake, which took them already.
    load : function of a path
        By which Snakemake reads a file.

    Raises
    ------
    SystemExit
        With what is wrong, where a file cannot be read, or a value has no key.
    """
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--configfile", "--configfiles", nargs="+", type=Path, default=[])
    parser.add_argument("--config", "-C", nargs="*", default=[])
    given, _ = parser.parse_known_args(arguments)
    try:
        for file in given.configfile:
            _require_readable(file, load)
        values_of(given.config)
    except InputError as error:
        raise SystemExit(f"Error: {error}") from None


def _require_readable(file: Path, load: Callable[[Path], Any]) -> None:
    if file.exists() and not (file.is_file() or file.is_dir()):
        raise InputError(f"{file}: is a pipe or a device; a config is read more than once and must be a file")
    merged([file], {})
    try:
        load(file)
    except Exception as error:  # whatever the constructors of YAML 1.1 raise
        said = str(error).splitlines()[0]
        raise InputError(f"{file}: Snakemake cannot read it ({said}); put what is text in quotes") from None


def values_of(entries: Iterable[str]) -> dict[str, Any]:
    """Return the config that entries ``key=value`` of ``--config`` state, by YAML 1.2 as in a file.

    Snakemake takes 1_0 and digits of other scripts for numbers, and numbers within braces for text.

    Raises
    ------
    InputError
        If an entry has no key.
    """
    config: dict[str, Any] = {}
    for entry in entries:
        key, equals, text = entry.partition("=")
        if not equals or not _KEY.fullmatch(key):
            raise InputError(f"--config has {entry!r}; it must be KEY=VALUE, as results=results/mine")
        update(config, {key: _value(text)})
    return config


def _value(text: str) -> Any:
    try:
        return yaml_file.load(text)
    except yaml.YAMLError:
        return text  # as Snakemake takes what is no YAML
