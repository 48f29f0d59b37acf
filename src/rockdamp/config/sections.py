"""The sections of the config: meaning, unit and bounds of each key, and what a section is made into.

Values stand in config/default.yaml alone, so every key is required. Bounds leave out what no wall has, and what no
computer can run. What one key demands of another is checked in `rockdamp.config.checks`.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from rockdamp.arrays import Array
from rockdamp.config.kinds import (
    ArithmeticGrid,
    Fraction,
    Fractions,
    Length,
    Overburden,
    Positive,
    Positives,
    Refusal,
    Restitution,
    Section,
    Seed,
    Step,
    Text,
    Whole,
    ascending,
    made_of,
    names,
)
from rockdamp.config.study import PlateauBeyond, RigidWall
from rockdamp.equivalence.closed_form import Scan
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Wall
from rockdamp.vocabulary import DEFAULT_RESPONSE_LENGTH

# --- the solver, walls and curves ------------------------------------------------------------------------------------


class Solver(Section):
    scheme: Literal["newmark", "paper"] = Field(
        description="newmark is explicit Newmark with located impacts, second order; paper is the paper's linear"
        " acceleration without iteration, with impacts at the end of the step, first order."
    )
    step: Step = Field(
        description="Step in dimensionless time tau = p t; below the stability limit 2 sqrt(a1/b1) of every curve. [-]"
    )


class WallSection(Section):
    thickness: Positive = Field(description="Thickness t. [m]")
    slenderness: Positive = Field(description="Slenderness h/t. [-]")
    hinge_ratio: Fraction = Field(description="Height h1 of the hinge over h. [-]")
    overburden_ratio: Overburden = Field(
        description="Overburden ratio O/W: the vertical force on the top over the wall's weight. [-]"
    )
    eccentricity: float = Field(
        ge=-1000,
        le=1000,
        description="Distance of the overburden from mid-thickness, positive towards the top contact corner; at most"
        " t/2 either way. [m]",
    )
    density: Positive = Field(description="Density of the masonry. [kg m-3]")
    width: Positive = Field(description="Horizontal width of the wall. [m]")

    def wall(self) -> Wall:
        """Return the wall, whose height is slenderness times thickness."""
        sizes = self.model_dump(exclude={"slenderness"})
        return Wall(height=self.thickness * self.slenderness, **sizes)


class CurveSection(Section):
    yield_displacement_ratio: Positive = Field(description="a1 = u1/u_ins, less than a2, where the plateau ends. [-]")
    strength_ratio: Fraction = Field(description="b1 = F_y/F0. [-]")
    ultimate_displacement_ratio: float = Field(
        gt=0,
        le=1,
        description="a3 = u3/u_ins, where the force is zero again; more than 1 - b1 (steeper) or a1 + b1 (translated)."
        " [-]",
    )
    softening: Literal["steeper", "translated"] = Field(
        description="For a3 < 1: steeper keeps the end of the plateau on the bi-linear law (a2 = 1 - b1), translated"
        " keeps the slope -K0 (a2 = a3 - b1)."
    )

    def curve(self) -> TrilinearCurve:
        return TrilinearCurve(**self.model_dump())


StatedWall = Annotated[Wall, made_of(WallSection, WallSection.wall)]
Curve = Annotated[TrilinearCurve, made_of(CurveSection, CurveSection.curve)]


# --- studies of free decay -------------------------------------------------------------------------------------------


class OfAmplitude(Section):
    release_amplitude: Annotated[Array, ascending(Positive)] = Field(
        description="Release amplitudes u0/u_ins, each less than a3; the top level's release_amplitude must be among"
        " them. [-]"
    )


class OfSlenderness(Section):
    slenderness: Annotated[Array, ascending(Positive)] = Field(description="Slenderness h/t. [-]")


class OfOverburden(Section):
    overburden_ratio: Annotated[Array, ascending(Overburden)] = Field(description="Overburden ratio O/W. [-]")


class OfCrackedStiffness(Section):
    yield_displacement_ratio: Annotated[Array, ascending(Positive)] = Field(
        description="a1 = u1/u_ins, each less than a2, where the plateau ends. [-]"
    )
    strength_ratio_beyond: PlateauBeyond = Field(
        description="The plateau of the softer curves, for which curve.strength_ratio leaves no room."
    )


class Studies(Section):
    """A field for each study of `rockdamp.vocabulary.STUDIES`."""

    amplitude: OfAmplitude = Field(description="Release amplitudes, for Fig. 5 and the response lengths.")
    slenderness: OfSlenderness = Field(description="Slenderness, for the top of Fig. 6.")
    overburden: OfOverburden = Field(description="Overburden, for the centre of Fig. 6.")
    cracked_stiffness: OfCrackedStiffness = Field(
        description="yield_displacement_ratio, for the bottom of Fig. 6 and the fits of Fig. 7."
    )


class ScanSection(Section):
    smallest: Positive = Field(description="The smallest one tried, over the closed form's. [-]")
    largest: Positive = Field(description="The largest one tried, over the closed form's. [-]")
    points: Whole = Field(ge=8, le=10_000, description="How many are tried, in a geometric sequence.")

    def scan(self) -> Scan:
        return Scan(**self.model_dump())


class Matching(Section):
    refinement: Whole = Field(
        ge=2,
        le=1000,
        multiple_of=2,
        description="Steps in place of each of the solver's in the last minimisation, from which the damping ratio is"
        " published; what fewer steps give, down to half as many, says how certain it is. Even. [-]",
    )
    response_length: Annotated[
        float,
        made_of(Literal["default"] | Length, lambda given: DEFAULT_RESPONSE_LENGTH if given == "default" else given),
    ] = Field(
        description='Length of the response in tau that Eq. (17) sums over; "default" is the package\'s, which'
        " results/response_lengths.nc infers. Longer than the time to the latest first impact, and at most"
        " response_lengths.stop. [-]"
    )
    scan: Annotated[Scan, made_of(ScanSection, ScanSection.scan)] = Field(
        description="Damping ratios among which the basins of Err are looked for, before the lowest are refined."
    )


class RestitutionGrid(ArithmeticGrid):
    start: Restitution = Field(description="The smallest e. [-]")
    stop: Restitution = Field(description="The largest e. [-]")
    step: float = Field(
        ge=0.0005,
        le=1,
        description="Spacing; there are at least three values, as the fits of Fig. 7 have three coefficients. [-]",
    )


class ResponseLengths(ArithmeticGrid):
    start: Length = Field(description="The shortest, longer than the time to the latest first impact. [-]")
    stop: Length = Field(description="The longest; the decays of the study of the amplitude are computed to it. [-]")
    step: float = Field(ge=0.01, le=1000, description="Spacing. [-]")


def _possible(rigid: RigidWall) -> RigidWall:
    rigid.wall, rigid.curve  # noqa: B018 - the constructors refuse what cannot be
    return rigid


def made(lengths: ResponseLengths) -> ResponseLengths:
    """Return a grid whose values can be made."""
    lengths.values()  # refuses what is no grid
    return lengths


class DampingForce(Section):
    restitution: Restitution = Field(
        description="Coefficient of restitution e of the decay that the viscous models are matched to. [-]"
    )
    response_length: Length = Field(description="Length of the histories in tau. [-]")
    rigid: Annotated[RigidWall, made_of(RigidWall, _possible)] = Field(
        description="The wall of Fig. 4a, whose curve is all but bi-linear."
    )


class Validation(Section):
    record: Text = Field(
        description="The record, seen from the folder of the run; a CSV with the columns elapsed_s,"
        " ground_acceleration_m_s2 and displacement_m."
    )
    wall: StatedWall = Field(description="The wall of the test.")
    curve: Curve = Field(
        description="The curve that is expected: its a3 and softening are kept, a1 and b1 are those of the calibration."
    )
    fit_yield_displacement_ratios: Positives = Field(
        description="The a1 of the polynomials xi(e) whose mean is each viscous model's damping ratio. [-]"
    )
    step: Step = Field(description="Longest step in tau; the record's step is divided until it is no longer. [-]")


class Amplitude(Section):
    release_share: Fractions = Field(description="Release amplitudes over the displacement of zero force, u0/u3. [-]")
    restitution: Fractions = Field(description="Coefficients of restitution e. [-]")
    refinement: Whole = Field(
        ge=2,
        le=1000,
        multiple_of=2,
        description="Steps in place of each of the solver's in the last minimisation, as matching.refinement. [-]",
    )


class Convergence(Section):
    seed: Seed = Field(description="Seed of the random walls and of the load.")
    lanes: Whole = Field(ge=1, le=100_000, description="Number of walls.")
    length: Length = Field(description="Length of the histories in tau, a whole number of the coarsest step. [-]")
    coarsest: Step = Field(description="The longest step in tau. [-]")
    halvings: Whole = Field(ge=1, le=15, description="How often the coarsest step is halved.")


def _with_png(formats: tuple[str, ...]) -> tuple[str, ...]:
    if "png" not in formats:
        raise Refusal(f"is {list(formats)}; png must be among them")
    return formats


class Figures(Section):
    formats: Annotated[tuple[str, ...], names(Literal["pdf", "png", "svg"]), AfterValidator(_with_png)] = Field(
        description="File formats of each figure; png must be among them, as the report shows it."
    )
    resolution: Whole = Field(ge=30, le=1200, description="Dots per inch of the PNG.")
