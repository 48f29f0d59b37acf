"""The walls that studies compute with, made of several keys: unlike the sections, part of what a result depends on."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from pydantic import Field

from rockdamp.arrays import Array, Quantity
from rockdamp.config.kinds import Fraction, Positive, Restitution, Section
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Wall
from rockdamp.plausibility import as_meant
from rockdamp.vocabulary import STUDIES


class PlateauBeyond(Section):
    """The plateau b1 of curves with `yield_displacement_ratio` or more, for which the reference's leaves no room."""

    yield_displacement_ratio: Positive = Field(description="The a1 from which on this plateau is used. [-]")
    strength_ratio: Fraction = Field(description="b1 from there on. [-]")

    def at(self, yield_displacement_ratio: Quantity, reference: Quantity) -> Array:
        """Return b1 at each a1, where `reference` is b1 of the other curves. [-]"""
        beyond = np.asarray(yield_displacement_ratio) >= self.yield_displacement_ratio
        return np.where(beyond, self.strength_ratio, reference)


class RigidWall(Section):
    """The wall of Fig. 4a; sizes of which there is no wall or curve are refused."""

    thickness: Positive = Field(description="Thickness t. [m]")
    height: Positive = Field(description="Height h. [m]")
    hinge_ratio: Fraction = Field(description="Height h1 of the hinge over h. [-]")
    restitution: Restitution = Field(description="Coefficient of restitution e, as the paper's figure gives it. [-]")
    release_amplitude: Fraction = Field(description="Release amplitude u0/u_ins, less than 1. [-]")
    yield_displacement_ratio: Positive = Field(description="a1 = u1/u_ins, small. [-]")
    strength_ratio: Fraction = Field(description="b1 = F_y/F0, near 1. [-]")

    @property
    def wall(self) -> Wall:
        return Wall(self.thickness, self.height, hinge_ratio=self.hinge_ratio)

    @property
    def curve(self) -> TrilinearCurve:
        return TrilinearCurve(self.yield_displacement_ratio, self.strength_ratio)


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


@as_meant()  # `rockdamp.config.checks` asks
def walls_of(name: str, varied: Section, wall: Wall, curve: TrilinearCurve, release_amplitude: float) -> Study:
    """Return the walls of the study `name`, whose values the section `varied` holds under the name of its parameter.

    `wall`, `curve` and `release_amplitude` (u0/u_ins) are those of the reference, of which it varies one.
    """
    parameter = STUDIES[name]
    values: Array = getattr(varied, parameter)
    release = np.full(values.shape, release_amplitude)
    of_wall = parameter in ("slenderness", *(field.name for field in fields(Wall)))
    if parameter == "release_amplitude":
        release = values
    elif parameter == "slenderness":
        wall = replace(wall, height=wall.thickness * values)
    elif parameter == "thickness":  # the config states the slenderness, so that stays
        wall = replace(wall, thickness=values, height=wall.height / wall.thickness * values)
    elif of_wall:
        changed: Any = {parameter: values}
        wall = replace(wall, **changed)
    else:
        beyond: PlateauBeyond | None = getattr(varied, "strength_ratio_beyond", None)
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
