"""Read the registry of datasets and their variables, variables.yaml, once in a process."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from importlib.resources import files
from typing import Any

from rockdamp.storage import yaml_file


@cache
def registry() -> dict[str, Any]:
    """Return the registry with all that stands in it once filled in: attributes, coordinates and intervals."""
    raw: dict[str, Any] = yaml_file.load(
        files("rockdamp.storage").joinpath("variables.yaml").read_text(encoding="utf-8")
    )
    common, texts = raw["common"], raw["common"] | raw["coordinates"]
    for entry in raw["datasets"].values():
        stated = dict(_with_intervals(entry["variables"]))
        dims = dict.fromkeys(dim for fields in stated.values() for dim in fields["dims"])
        coordinates = {dim: {**texts[dim], "dims": [dim]} for dim in dims if dim in texts and dim not in stated}
        entry["variables"] = coordinates | {name: {**common.get(name, {}), **stated[name]} for name in stated}
    return raw


def _with_intervals(variables: dict[str, dict[str, Any]]) -> Iterator[tuple[str, dict[str, Any]]]:
    for name, fields in variables.items():
        yield name, fields
        if fields.get("bootstrapped"):
            text = f"95 % bootstrap interval of {name}"
            yield f"{name}_interval", {"units": fields["units"], "long_name": text, "dims": [*fields["dims"], "bound"]}
