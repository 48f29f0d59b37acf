"""The section of the config of walls that rock to one side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from rockdamp.arrays import Array
from rockdamp.config.kinds import (
    AtLeastZero,
    Duration,
    Fraction,
    Fractions,
    Geometric,
    Positive,
    Records,
    Section,
    Text,
    ascending,
    made_of,
)
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.one_sided import OneSidedWall, Tie
from rockdamp.mechanics.wall import Parapet


@dataclass(frozen=True)
class NamedFacade:
    """A facade against a stop, and its curve."""

    name: str
    wall: OneSidedWall
    curve: TrilinearCurve


class Facade(Section):
    name: Text = Field(description="Name of the facade.")
    thickness: Positive = Field(description="Thickness t. [m]")
    height: Positive = Field(description="Height h. [m]")
    yield_displacement_ratio: Positive = Field(description="a1 = u1/u_ins. [-]")
    strength_ratio: Fraction = Field(description="b1 = F_y/F0. [-]")
    initial_strength_ratio: AtLeastZero = Field(default=0.0, description="f(0+), at most b1. [-]")
    tie_stiffness: AtLeastZero = Field(default=0.0, description="Of ties at the top; 0 for none. [kN m-1]")
    tie_strength: AtLeastZero = Field(default=0.0, description="At which they yield. [kN]")
    tie_gap: AtLeastZero = Field(default=0.0, description="How far they move before they pull. [m]")

    def named_facade(self) -> NamedFacade:
        """Return the facade, one metre wide."""
        tie = Tie(1e3 * self.tie_stiffness, 1e3 * self.tie_strength, self.tie_gap) if self.tie_stiffness else None
        wall = OneSidedWall(
            Parapet(self.thickness, self.height), tie, initial_strength_ratio=self.initial_strength_ratio
        )
        curve = TrilinearCurve(self.yield_displacement_ratio, self.strength_ratio)
        wall.force(curve)
        return NamedFacade(self.name, wall, curve)


_Facade = Annotated[NamedFacade, made_of(Facade, Facade.named_facade)]


class OneSided(Section):
    facades: Annotated[list[_Facade], Field(min_length=1, max_length=100)] = Field(description="One metre wide each.")
    records: Records = Field(description="Records, as the top level's records; each acts both ways.")
    restitution: Fractions = Field(description="Coefficients of restitution e at the stop, ascending. [-]")
    restitution_change: Fraction = Field(description="How much e is lowered and raised beside it. [-]")
    contact_stiffness: Annotated[Array, ascending(Positive)] = Field(
        description="Stiffness of the stop with a dashpot over that of the first branch, ascending; the last one"
        " is also run as a stop that may pull. [-]"
    )
    contact_step: Fractions = Field(
        description="Steps at which the restitution of single impacts on the stiffest stop is measured, times the"
        " stop's frequency. [-]"
    )
    two_sided_restitution: Fractions = Field(description="e of the two-sided wall that stands in its place. [-]")
    velocity_ratio: Geometric = Field(
        description="Intensities that every record is scaled to, lambda PGV/(p u_ins); a geometric sequence. [-]"
    )
    step: float = Field(ge=1e-4, lt=0.5, description="Of the two-sided wall, times its first frequency. [-]")
    tail: Duration = Field(description="Rest after the record. [s]")
