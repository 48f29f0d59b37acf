"""The config from its files, as Snakemake merges them, but read by the package's own YAML.

Snakemake reads them by YAML 1.1, in which of two sections of one name the first is lost and 010 is 8.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from rockdamp.errors import InputError
from rockdamp.storage import yaml_file


def merged(files: Iterable[str | Path], stated: Mapping[str, Any]) -> dict[str, Any]:
    """Return the config that files hold, the later before the earlier, and what the command line states before all.

    Raises
    ------
    InputError
        If a file cannot be read, or does not have keys at its top.
    """
    config: dict[str, Any] = {}
    for file in files:
        document = yaml_file.read(file)
        if not isinstance(document, Mapping):
            raise InputError(f"{file}: is not a mapping of keys to values; a config must be one")
        _update(config, document)
    _update(config, stated)
    return config


def _update(config: dict[str, Any], other: Mapping[str, Any]) -> None:
    for key, value in other.items():
        if isinstance(value, Mapping):
            inner = config.get(key)
            config[key] = inner = dict(inner) if isinstance(inner, Mapping) else {}
            _update(inner, value)
        else:
            config[key] = value
