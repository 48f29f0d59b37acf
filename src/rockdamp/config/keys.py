"""Access to the values of a config by dotted keys, such as ``earthquakes.step``."""

from __future__ import annotations

from collections.abc import Iterable
from operator import attrgetter
from typing import Any

from rockdamp.config.model import Config, NamedWall, Section


def select_values(config: Config, *keys: str) -> dict[str, Any]:
    """Return the values at and below some keys.

    Parameters
    ----------
    config : Config
        The whole config.
    *keys : str
        Dotted keys of values or of sections.

    Returns
    -------
    dict
        Values by their own dotted keys. A list of walls gives the names of the walls in their
        order, and the values of each wall under its name: ``earthquakes.walls.church.slenderness``.
    """
    values: dict[str, Any] = {}
    for key in keys:
        values |= _flatten(key, attrgetter(key)(config))
    return values


def _flatten(key: str, value: Any) -> dict[str, Any]:
    if isinstance(value, list) and isinstance(value[0], NamedWall):
        return _flatten_walls(key, value)
    if not isinstance(value, Section):
        return {key: value}
    values: dict[str, Any] = {}
    for name, member in value:
        values |= _flatten(f"{key}.{name}", member)
    return values


def _flatten_walls(key: str, walls: list[NamedWall]) -> dict[str, Any]:
    values: dict[str, Any] = {key: [wall.name for wall in walls]}
    for wall in walls:
        sizes = wall.model_dump(exclude={"name"}, exclude_none=True)
        values |= {f"{key}.{wall.name}.{name}": size for name, size in sizes.items()}
    return values


def restrict(config: Config, keys: Iterable[str]) -> Config:
    """Return a config that has the values at and below some dotted keys only.

    Reading any other value raises `AttributeError`. Thus a stage reads no value that its rule does
    not name.
    """
    restricted: Config = _restrict(config, [key.split(".") for key in keys])
    return restricted


def _restrict(value: Any, paths: list[list[str]]) -> Any:
    if not isinstance(value, Section) or [] in paths:
        return value
    inner_paths: dict[str, list[list[str]]] = {}
    for name, *path in paths:
        inner_paths.setdefault(name, []).append(path)
    members = {name: _restrict(getattr(value, name), inner) for name, inner in inner_paths.items()}
    return type(value).model_construct(**members)
