"""Read the registry of datasets and their variables, variables.yaml, once in a process."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import Any

from rockdamp.storage import yaml_file


@cache
def registry() -> dict[str, Any]:
    """Return the registry with the common attributes filled in."""
    raw: dict[str, Any] = yaml_file.load(
        files("rockdamp.storage").joinpath("variables.yaml").read_text(encoding="utf-8")
    )
    for entry in raw["datasets"].values():
        entry["variables"] = {
            name: {**raw["common"].get(name, {}), **fields} for name, fields in entry["variables"].items()
        }
    return raw
