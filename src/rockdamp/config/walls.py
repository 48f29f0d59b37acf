"""The walls and curves of the config: of one section, of what earthquakes shake, and of what a study varies.

Meaning, unit and range of each key: workflow/schemas/config.schema.yaml.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Annotated, Any

import numpy as np

from rockdamp.arrays import Array, Quantity
from rockdamp.config.parsing import ConfigError, Settings, ascending, made_of, members, number, refusal, section, text
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.vocabulary import STUDIES


def _sizes(entries: Mapping[str, Any], key: str) -> dict[str, float]:
    """Sizes as `Wall` and `Parapet` take them; the section states slenderness (h/t) in place of the height."""
    sizes = {name: number(value, f"{key}.{name}") for name, value in entries.items()}
    return {"height": sizes["thickness"] * sizes.pop("slenderness"), **sizes}


def make_wall(value: Any, key: str = "wall") -> Wall:
    """Build the wall of a section, which states slenderness (h/t) in place of the height."""
    needed = ["slenderness", *(field.name for field in fields(Wall) if field.name != "height")]
    sizes = _sizes(members(value, key, needed), key)
    with made_of(key, needed):
        return Wall(**sizes)


def make_curve(value: Any, key: str = "curve") -> TrilinearCurve:
    """Build the curve of a section."""
    entries = members(value, key, [field.name for field in fields(TrilinearCurve)])
    with made_of(key, entries):
        return TrilinearCurve(**entries)


@dataclass(frozen=True)
class NamedWall:
    """A wall that earthquakes shake."""

    name: str
    wall: Wall | Parapet
    curve: TrilinearCurve


def make_named_wall(value: Any, key: str = "earthquakes.walls") -> NamedWall:
    """Build an entry of ``earthquakes.walls``: a preset, or a1 and b1, with a3 = 1; a parapet has no hinge."""
    stated = value if isinstance(value, Mapping) else {}
    parapet, preset = stated.get("parapet", False), "preset" in stated
    shape = ["preset"] if preset else ["yield_displacement_ratio", "strength_ratio"]
    of_wall = ["thickness", "slenderness", "overburden_ratio", *([] if parapet else ["hinge_ratio"])]
    entries = members(value, key, ["name", *of_wall, *shape], ["parapet"])
    sizes = _sizes({name: entries[name] for name in of_wall}, key)
    with made_of(key, entries):
        make = TrilinearCurve.preset if preset else TrilinearCurve
        curve = make(*(entries[name] for name in shape))
        wall = (Parapet if parapet else Wall)(**sizes)
    return NamedWall(text(entries["name"], f"{key}.name"), wall, curve)


Strip = Annotated[Wall, make_wall]
Curve = Annotated[TrilinearCurve, make_curve]


# --- the walls of a study ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class PlateauBeyond:
    """The plateau b1 of curves with `yield_displacement_ratio` or more, for which the reference's leaves no room."""

    yield_displacement_ratio: float
    strength_ratio: float

    def at(self, yield_displacement_ratio: Quantity, reference: Quantity) -> Array:
        """Return b1 at each a1, where `reference` is b1 of the other curves. [-]"""
        beyond = np.asarray(yield_displacement_ratio) >= self.yield_displacement_ratio
        return np.where(beyond, self.strength_ratio, reference)


@dataclass(frozen=True)
class Varied:
    """The values of the parameter that a study varies."""

    values: Array
    strength_ratio_beyond: PlateauBeyond | None


def _studies(value: Any, key: str) -> dict[str, Varied]:
    """Values that each study varies, of the studies that the section has."""
    if not isinstance(value, Mapping) or not value.keys() <= STUDIES.keys():
        raise refusal(value, key, f"a mapping with keys among {', '.join(STUDIES)}")
    return {name: _varied(STUDIES[name], entry, f"{key}.{name}") for name, entry in value.items()}


def _varied(parameter: str, value: Any, key: str) -> Varied:
    if parameter != "yield_displacement_ratio":
        return Varied(ascending(members(value, key, [parameter])[parameter], f"{key}.{parameter}"), None)
    entries = members(value, key, [parameter, "strength_ratio_beyond"])
    beyond = section(PlateauBeyond, entries["strength_ratio_beyond"], f"{key}.strength_ratio_beyond")
    return Varied(ascending(entries[parameter], f"{key}.{parameter}"), beyond)


@dataclass(frozen=True)
class Study:
    """The walls of one study: its `parameter` varies over `values`, and every array has one entry for each of them."""

    name: str
    parameter: str
    values: Array
    curve: TrilinearCurve
    release_amplitude: Array
    frequency_parameter: Array
    of_wall: bool


class StudySettings(Settings):
    """The reference wall and what studies vary of it, on which every stage depends that looks at a study's walls."""

    wall: Strip
    curve: Curve
    release_amplitude: float
    studies: Annotated[dict[str, Varied], _studies]

    def study(self, name: str) -> Study:
        """Return the walls of study `name`; a missing study, or a wall that cannot be, raises `ConfigError`."""
        if name not in self.studies:
            raise ConfigError(f"studies.{name}", "is missing")
        with made_of(f"studies.{name}", [STUDIES[name]]):
            return self._walls_of(name, STUDIES[name], self.studies[name])

    def _walls_of(self, name: str, parameter: str, varied: Varied) -> Study:
        values, wall, curve, release = (
            varied.values,
            self.wall,
            self.curve,
            np.full(varied.values.shape, self.release_amplitude),
        )
        of_wall = parameter in ("slenderness", *(field.name for field in fields(Wall)))
        if parameter == "release_amplitude":
            release = values
        elif parameter == "slenderness":
            wall = replace(wall, height=wall.thickness * values)
        elif parameter == "thickness":  # the config states the slenderness, so that stays
            wall = replace(wall, thickness=values, height=wall.height / wall.thickness * values)
        elif of_wall:
            wall = replace(wall, **{parameter: values})
        else:
            beyond = varied.strength_ratio_beyond
            b1 = curve.strength_ratio if beyond is None else beyond.at(values, curve.strength_ratio)
            changes: dict[str, Any] = {"strength_ratio": b1, parameter: values}
            curve = replace(curve, **changes)
        return Study(
            name,
            parameter,
            values,
            curve.map(lambda p: np.broadcast_to(p, values.shape)),
            release,
            np.broadcast_to(wall.frequency_parameter, values.shape),
            of_wall,
        )
