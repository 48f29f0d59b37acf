"""Read the glossary of what datasets store, glossary.yaml: the unit and the meaning of each name."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import yaml

from rockdamp.vocabulary import STUDIES

FILE = Path(__file__).with_name("glossary.yaml")
INTERVAL = "_interval"
ANY_STUDY = "STUDIES"


@cache
def read() -> dict[str, dict[str, Any]]:
    """Return the glossary: the entries of all ``names``, and what it says of each kind of ``datasets``."""
    whole: dict[str, dict[str, Any]] = yaml.load(FILE.read_text(encoding="utf-8"), Loader=yaml.CSafeLoader)
    return whole


def entry(name: str) -> dict[str, Any]:
    """Return the entry of a name, with ``units`` and ``long_name``; an unknown name raises `KeyError`."""
    names = read()["names"]
    if name not in names and name.endswith(INTERVAL):
        own = name.removesuffix(INTERVAL)
        return {"units": names[own]["units"], "long_name": f"95 % bootstrap interval of {own}"}
    return dict(names[name])


def variables(kind: str) -> dict[str, dict[str, Any]]:
    """Return the entries of the names that a kind of dataset has; ``optional`` ones only some of its files."""
    dataset = read()["datasets"][kind]
    optional, says = dataset.get("optional", []), dataset.get("says", {})
    if ANY_STUDY in optional:
        optional = [*STUDIES.values(), *(name for name in optional if name != ANY_STUDY)]
    entries = {name: {**entry(name), **says.get(name, {})} for name in [*dataset["variables"], *optional]}
    return entries | {name: {**entries[name], "optional": True} for name in optional}
