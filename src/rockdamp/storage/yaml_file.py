"""YAML, by PyYAML's compiled parser where there is one: the package's documents are long, and every job reads them."""

from __future__ import annotations

from typing import Any

import yaml

LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # a PyYAML built without libyaml has the second only


def load(text: str) -> Any:
    """Return what a YAML document holds; raise `yaml.YAMLError` where it is none."""
    return yaml.load(text, Loader=LOADER)
