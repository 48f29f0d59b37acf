"""The config and what must hold of it: the schema, and the rules between its keys.

It is checked here and parsed into settings in studies; nothing further down sees it.
"""

from collections.abc import Mapping
from typing import Any

Config = Mapping[str, Any]  # or a section of it: what a YAML file holds, by key
