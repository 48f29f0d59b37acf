"""The config, parsed: a frozen dataclass for each section of it, and one for what each stage depends on.

A stage begins with ``PulseSettings.of(config)``; the functions below it take values by name. `config` may be the part
that has the stage's keys, or more. A missing key is an error, and so is one that a section does not know. Meaning, unit
and range of each key stand in workflow/schemas/config.schema.yaml.
"""

from __future__ import annotations

from typing import Annotated, Any

from rockdamp.arrays import Array
from rockdamp.config.parsing import Ascending, Section, Settings, arithmetic, geometric, number
from rockdamp.config.walls import Curve, PlateauBeyond, Strip, StudySettings
from rockdamp.equivalence.scan import Scan
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Wall
from rockdamp.vocabulary import DEFAULT_RESPONSE_LENGTH

# --- sections ---------------------------------------------------------------------------------------------------------


def _response_length(value: Any, key: str) -> float:
    return DEFAULT_RESPONSE_LENGTH if value == "default" else number(value, key)


ResponseLength = Annotated[float, _response_length]  # in tau; "default" is the package's own


class Solver(Section):
    scheme: str
    step: float


class Matching(Section):
    response_length: ResponseLength
    refinement: int
    scan: Scan


class RigidWall(Section):
    thickness: float
    height: float
    hinge_ratio: float
    restitution: float
    release_amplitude: float
    yield_displacement_ratio: float
    strength_ratio: float

    def __post_init__(self) -> None:
        self.wall, self.curve  # noqa: B018 - sizes of which there is no wall or curve are refused here

    @property
    def wall(self) -> Wall:
        return Wall(self.thickness, self.height, hinge_ratio=self.hinge_ratio)

    @property
    def curve(self) -> TrilinearCurve:
        return TrilinearCurve(self.yield_displacement_ratio, self.strength_ratio)


class DampingForce(Section):
    restitution: float
    response_length: float
    rigid: RigidWall


class CurveMap(Section):
    yield_displacement_ratio: Ascending
    strength_ratio: Ascending


class AmplitudeDependence(Section):
    release_share: Ascending
    restitution: Ascending
    yield_displacement_ratio: Array
    ultimate_displacement_ratio: float
    refinement: int
    map: CurveMap


class OrderPulses(Section):
    frequency: Annotated[Array, geometric]
    load: Annotated[Array, geometric]
    step: float
    tail: float


class Pulses(OrderPulses):
    restitution: Ascending
    bands: Ascending


class DamperOrder(Section):
    order: Ascending
    restitution: Ascending
    restitution_change: float
    release_share: Ascending
    pulses: OrderPulses


class Bootstrap(Section):
    replicates: int
    seed: int


class SimulatedTrials(Section):
    draws: int
    seed: int


class MeasuredRocking(Section):
    trials: str
    impacts_used: Ascending
    shown_impacts: int
    yield_displacement_ratio: Ascending
    release_amplitude: Ascending
    shown_yield_displacement_ratio: float
    shown_release_amplitude: float
    exponent: Ascending
    amplitude_exponent: Ascending
    held_out: int
    bootstrap: Bootstrap
    simulated: SimulatedTrials


class Convergence(Section):
    seed: int
    lanes: int
    length: float
    coarsest: float
    halvings: int


class RigidRocking(Section):
    slenderness: Array
    hinge_ratio: Array
    release_amplitude: Array
    peaks: int


class Accuracy(Section):
    seed: int
    restitutions: int
    doublings: int
    halvings: int
    minima: int
    bracket: float
    rigid: RigidRocking


# --- stages -----------------------------------------------------------------------------------------------------------


class DecaySettings(StudySettings):
    solver: Solver
    restitution: Annotated[Array, arithmetic]
    response_length: Annotated[ResponseLength, "matching.response_length"]
    longest: Annotated[float, "response_lengths.stop"]


class MatchSettings(StudySettings):
    solver: Solver
    matching: Matching


class ResponseLengthSettings(StudySettings):
    solver: Solver
    scan: Annotated[Scan, "matching.scan"]
    response_lengths: Annotated[Array, arithmetic]


class PolynomialSettings(Settings):
    strength_ratio: Annotated[float, "curve.strength_ratio"]
    ultimate_displacement_ratio: Annotated[float, "curve.ultimate_displacement_ratio"]
    release_amplitude: float


class MatchedSettings(Settings):
    """The reference curve, and how damping ratios are matched on it."""

    solver: Solver
    curve: Curve
    release_amplitude: float
    matching: Matching


class DampingForceSettings(MatchedSettings):
    damping_force: DampingForce


class ForceCurveSettings(Settings):
    wall: Strip
    curve: Curve
    tested_wall: Annotated[Strip, "validation.wall"]


class BilinearSettings(Settings):
    wall: Strip
    curve: Curve
    damping_force: DampingForce
    pulses: Pulses
    records: tuple[str, ...]
    scale: Annotated[Array, "earthquakes.velocity_ratio", geometric]
    step: Annotated[float, "earthquakes.step"]
    tail: Annotated[float, "earthquakes.tail"]


class AmplitudeDependenceSettings(Settings):
    solver: Solver
    strength_ratio: Annotated[float, "curve.strength_ratio"]
    strength_ratio_beyond: Annotated[PlateauBeyond, "studies.cracked_stiffness.strength_ratio_beyond"]
    matching: Matching
    amplitude_dependence: AmplitudeDependence


class TestedSettings(Settings):
    tested_wall: Annotated[Strip, "validation.wall"]
    tested_curve: Annotated[Curve, "validation.curve"]
    tested_restitution: Annotated[float, "validation.restitution"]


class DamperOrderSettings(MatchedSettings, TestedSettings):
    """The reference curve, those of the amplitude dependence, and the wall and record of a test."""

    amplitude_dependence: AmplitudeDependence
    strength_ratio_beyond: Annotated[PlateauBeyond, "studies.cracked_stiffness.strength_ratio_beyond"]
    damper_order: DamperOrder
    shown_restitution: Annotated[float, "damping_force.restitution"]
    tested_step: Annotated[float, "validation.step"]


class PulseSettings(MatchedSettings):
    pulses: Pulses


class RecommendationSettings(Settings):
    curve: Curve
    release_amplitude: float


class MeasuredRockingSettings(Settings):
    measured_rocking: MeasuredRocking


class ConvergenceSettings(Settings):
    convergence: Convergence


class ValidationSettings(Settings):
    wall: Annotated[Strip, "validation.wall"]
    curve: Annotated[Curve, "validation.curve"]
    restitution: Annotated[float, "validation.restitution"]
    fit_yield_displacement_ratios: Annotated[Array, "validation.fit_yield_displacement_ratios"]
    step: Annotated[float, "validation.step"]


class CalibrationSettings(Settings):
    wall: Annotated[Strip, "validation.wall"]
    ultimate_displacement_ratio: Annotated[float, "validation.curve.ultimate_displacement_ratio"]
    softening: Annotated[str, "validation.curve.softening"]
    step: Annotated[float, "validation.step"]


class AccuracySettings(MatchSettings, TestedSettings):
    damping_force: DampingForce
    accuracy: Accuracy
