"""The config from its files, as Snakemake merges them, but read by the package's own YAML.

Snakemake reads them by YAML 1.1, in which of two sections of one name the first is lost and 010 is 8.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import yaml

from rockdamp.errors import InputError
from rockdamp.storage import input_file, yaml_file


def merged(files: Iterable[str | Path], stated: Mapping[str, Any]) -> dict[str, Any]:
    """Return the config that files hold, the later before the earlier, and what the command line states before all.

    Raises
    ------
    InputError
        If a file cannot be read, or does not have keys at its top.
    """
    config: dict[str, Any] = {}
    for file in files:
        document = _read(file)
        if not isinstance(document, Mapping):
            raise InputError(f"{file}: is not a mapping of keys to values; a config must be one")
        update(config, document)
    update(config, stated)
    return config


def _read(path: str | Path) -> Any:
    """Return what a YAML file holds; what goes wrong is one line, with the file and where it can be told the line."""
    text = input_file.text(input_file.content(path, "YAML"), path)
    try:
        return yaml_file.load(text)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
        line = f", line {mark.line + 1}" if mark else ""
        said = getattr(error, "problem", None) or " ".join(str(error).split())
        raise InputError(f"{path}{line}: {said}; it must be YAML") from None


def update(config: dict[str, Any], other: Mapping[str, Any]) -> None:
    """Put the values of `other` into `config`, section by section, as Snakemake does."""
    for key, value in other.items():
        if isinstance(value, Mapping):
            inner = config.get(key)
            config[key] = inner = dict(inner) if isinstance(inner, Mapping) else {}
            update(inner, value)
        else:
            config[key] = value
