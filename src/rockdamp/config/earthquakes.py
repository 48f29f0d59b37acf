"""The sections of the config of walls under earthquakes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from rockdamp.arrays import Array
from rockdamp.config.kinds import (
    Bands,
    Count,
    Duration,
    Fraction,
    Fractions,
    Geometric,
    Orders,
    Overburden,
    Positive,
    Records,
    Refusal,
    Section,
    Seed,
    Text,
    Whole,
    ascending,
    made_of,
)
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Parapet, Wall

# --- walls under records ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class NamedWall:
    """A wall that earthquakes shake."""

    name: str
    wall: Wall | Parapet
    curve: TrilinearCurve


class EarthquakeWall(Section):
    name: Text = Field(description="Name of the wall.")
    thickness: Positive = Field(description="Thickness t. [m]")
    slenderness: Positive = Field(description="Slenderness h/t. [-]")
    overburden_ratio: Overburden = Field(
        description="Overburden ratio O/W: the vertical force on the top over the wall's weight. [-]"
    )
    parapet: bool = Field(
        default=False,
        description="Whether the wall is one block that rocks on its base; otherwise it is a wall between two floors.",
    )
    hinge_ratio: Fraction = Field(default=0.5, description="Height h1 of the hinge over h; of such a wall only. [-]")
    preset: Literal["new", "moderate", "severe"] = Field(
        default="new", description="Doherty's stage of degradation, in place of a1 and b1."
    )
    yield_displacement_ratio: Positive = Field(
        default=0.5, description="a1 = u1/u_ins, less than a2, where the plateau ends; without a preset. [-]"
    )
    strength_ratio: Fraction = Field(default=0.5, description="b1 = F_y/F0; without a preset. [-]")

    def named_wall(self) -> NamedWall:
        """Return the wall: one with a hinge, or a parapet, with a preset or its own a1 and b1; a3 = 1."""
        of_curve = ("preset",) if "preset" in self.model_fields_set else ("yield_displacement_ratio", "strength_ratio")
        needed = {"name", "thickness", "slenderness", "overburden_ratio", *of_curve}
        needed |= set() if self.parapet else {"hinge_ratio"}
        for name in sorted(self.model_fields_set ^ needed - {"parapet"}):
            if name in needed:
                raise Refusal("is missing", name)
            if name != "parapet":
                what = "a parapet" if name == "hinge_ratio" else "a wall with a preset"
                raise Refusal(f"is not a key of {what}; it must be left out", name)
        sizes = {"thickness": self.thickness, "height": self.thickness * self.slenderness}
        sizes["overburden_ratio"] = self.overburden_ratio
        wall = Parapet(**sizes) if self.parapet else Wall(**sizes, hinge_ratio=self.hinge_ratio)
        values = (getattr(self, name) for name in of_curve)
        make = TrilinearCurve.preset if "preset" in of_curve else TrilinearCurve
        return NamedWall(self.name, wall, make(*values))


def _different_names(walls: list[NamedWall]) -> tuple[NamedWall, ...]:
    found = [wall.name for wall in walls]
    for index, name in enumerate(found):
        if name in found[:index]:
            text = f"is named {name!r}, as one before it; each must have a name of its own"
            raise Refusal(text, index, "name")
    return tuple(walls)


_NamedWall = Annotated[NamedWall, made_of(EarthquakeWall, EarthquakeWall.named_wall)]
NamedWalls = Annotated[
    tuple[NamedWall, ...],
    made_of(Annotated[list[_NamedWall], Field(min_length=1, max_length=1000)], _different_names),
]


Step = Annotated[float, Field(ge=1e-4, lt=0.5)]


class Bilinear(Section):
    records: Records = Field(description="Records, as the top level's records.")
    velocity_ratio: Geometric = Field(
        description="Intensities that every record is scaled to, lambda PGV/(p u_ins); a geometric sequence. [-]"
    )
    step: float = Field(
        ge=1e-4, lt=0.5, description="Longest step, times the angular frequency of the first branch. [-]"
    )
    tail: Duration = Field(description="Rest after the record. [s]")


class Check(Section):
    histories: Whole = Field(ge=1, le=100_000, description="Number of histories.")
    seed: Seed = Field(description="Seed of the sample.")


class Earthquakes(Section):
    walls: NamedWalls = Field(description="Each has a name of its own, and a preset or a1 and b1; a3 is 1.")
    restitution: Fractions = Field(description="Coefficients of restitution e, ascending. [-]")
    restitution_change: Positive = Field(
        description="How much e is lowered and raised to see how sensitive CR's own answer is; e stays between 0 and 1."
        " [-]"
    )
    velocity_ratio: Geometric = Field(
        description="Intensities that every record is scaled to for every wall, lambda PGV/(p u_ins); a geometric"
        " sequence. [-]"
    )
    step: float = Field(
        ge=1e-4,
        lt=0.5,
        description="Longest step of the published histories, times the angular frequency of the first branch; a"
        " record's step is divided until it is no longer. Errors are bounded with steps two and four times as"
        " long, so less than 0.5. [-]",
    )
    tail: Duration = Field(description="Rest after the record. [s]")
    chunk: Count = Field(description="Records that one job runs; fewer make more jobs, for more cores.")
    check: Check = Field(
        description="Histories that are solved again, event by event: as many of each stratum, from walls far from"
        " collapse to those whose outcome depends on the step."
    )


class Bootstrap(Section):
    replicates: Whole = Field(ge=10, le=100_000, description="Number of resamplings.")
    seed: Seed = Field(description="Seed of the resampling.")


class Comparison(Section):
    bands: Bands = Field(
        description="Edges of the bands of the peak under restitution, u/u_ins, in which peaks are compared; ascending."
        " [-]"
    )
    bootstrap: Bootstrap = Field(
        description="Resampling of the stations, which bounds what a few dozen of them can say."
    )


class Order(Section):
    order: Orders = Field(description="Orders m of ECD, at least 0, ascending. [-]")
    band_width: Fractions = Field(description="Half widths t_c of BAND, a phase of the first branch, ascending. [rad]")
    length_width: Fractions = Field(description="Half widths of CQD over a1, ascending. [-]")
    restitution: Fractions = Field(description="Coefficients of restitution e, ascending. [-]")
    restitution_change: Positive = Field(description="How much e is lowered and raised, for CR beside them. [-]")
    loss_change: Fraction = Field(description="Fraction by which the loss delta = -ln e is lowered and raised. [-]")
    step: Step = Field(
        description="Longest step, times the angular frequency of the first branch; a band has at least eight. [-]"
    )
    ladder: Annotated[Array, ascending(Step)] = Field(
        description="Steps of which the largest converged one is sought, times the same frequency, ascending. [-]"
    )
    finest_step: Step = Field(description="Step that these are compared with, times the same frequency. [-]")
    ladder_every: Whole = Field(ge=1, le=10_000, description="One record of so many runs with the ladder.")


class LossLaw(Section):
    restitution: Fraction = Field(description="Coefficient of restitution e of the constant, and of each law. [-]")
    exponent: Fractions = Field(description="Exponents g: the loss goes with the energy to the power -g. [-]")
    amplitude: Fractions = Field(description="Amplitudes u/u_ins that e of a law belongs to. [-]")
    step: Step = Field(description="Longest step, times the angular frequency of the first branch. [-]")


class Supports(Section):
    diaphragm_period: Annotated[Array, ascending(Positive)] = Field(
        description="Periods of a flexible floor at the top of the walls. [s]"
    )
    diaphragm_damping: Fraction = Field(description="Damping ratio of that floor. [-]")
    vertical: Fraction = Field(
        description="Factor on the other horizontal component of a station, which stands for the vertical one. [-]"
    )
    eccentricity: float = Field(
        gt=0, le=0.5, description="Distance of the overburden from mid-thickness, over the thickness. [-]"
    )
    velocity_ratio: Geometric = Field(
        description="Intensities of the ground's motion, lambda PGV/(p u_ins); a geometric sequence. [-]"
    )
    step: float = Field(ge=1e-4, lt=0.5, description="Step, times the first branch's angular frequency, at most. [-]")
