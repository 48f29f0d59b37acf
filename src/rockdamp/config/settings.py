"""The config, parsed: a frozen dataclass for each section of it, and one for what each stage depends on.

A stage begins with ``PulseSettings.of(config)``; the functions below it take values by name. `config` may be the part
that has the stage's keys, or more. A missing key is an error, and so is one that a section does not know. Meaning, unit
and range of each key stand in workflow/schemas/config.schema.yaml.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from rockdamp.arrays import Array
from rockdamp.config.parsing import Ascending, Settings, arithmetic, geometric, number
from rockdamp.config.walls import Curve, PlateauBeyond, Strip, StudySettings
from rockdamp.equivalence.scan import Scan
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.wall import Wall
from rockdamp.vocabulary import DEFAULT_RESPONSE_LENGTH

# --- sections ---------------------------------------------------------------------------------------------------------


def _response_length(value: Any, key: str) -> float:
    return DEFAULT_RESPONSE_LENGTH if value == "default" else number(value, key)


ResponseLength = Annotated[float, _response_length]  # in tau; "default" is the package's own


@dataclass(frozen=True)
class Solver:
    scheme: str
    step: float


@dataclass(frozen=True)
class Matching:
    response_length: ResponseLength
    refinement: int
    scan: Scan


@dataclass(frozen=True)
class RigidWall:
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


@dataclass(frozen=True)
class DampingForce:
    restitution: float
    response_length: float
    rigid: RigidWall


@dataclass(frozen=True)
class CurveMap:
    yield_displacement_ratio: Ascending
    strength_ratio: Ascending


@dataclass(frozen=True)
class AmplitudeDependence:
    release_share: Ascending
    restitution: Ascending
    yield_displacement_ratio: Array
    ultimate_displacement_ratio: float
    refinement: int
    map: CurveMap


@dataclass(frozen=True)
class Pulses:
    frequency: Annotated[Array, geometric]
    load: Annotated[Array, geometric]
    restitution: Ascending
    step: float
    tail: float
    bands: Ascending


@dataclass(frozen=True)
class OrderPulses:
    frequency: Annotated[Array, geometric]
    load: Annotated[Array, geometric]
    step: float
    tail: float


@dataclass(frozen=True)
class DamperOrder:
    order: Ascending
    restitution: Ascending
    restitution_change: float
    release_share: Ascending
    pulses: OrderPulses


@dataclass(frozen=True)
class Resampling:
    replicates: int
    seed: int


@dataclass(frozen=True)
class SimulatedTrials:
    draws: int
    seed: int


@dataclass(frozen=True)
class MeasuredRocking:
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
    bootstrap: Resampling
    simulated: SimulatedTrials


@dataclass(frozen=True)
class Convergence:
    seed: int
    lanes: int
    length: float
    coarsest: float
    halvings: int


@dataclass(frozen=True)
class RigidRocking:
    slenderness: Array
    hinge_ratio: Array
    release_amplitude: Array
    peaks: int


@dataclass(frozen=True)
class Accuracy:
    seed: int
    restitutions: int
    doublings: int
    halvings: int
    minima: int
    bracket: float
    rigid: RigidRocking


# --- stages -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class DecaySettings(StudySettings):
    solver: Solver
    restitution: Annotated[Array, arithmetic]
    response_length: Annotated[ResponseLength, "matching.response_length"]
    longest: Annotated[float, "response_lengths.stop"]


@dataclass(frozen=True)
class MatchSettings(StudySettings):
    solver: Solver
    matching: Matching


@dataclass(frozen=True)
class ResponseLengthSettings(StudySettings):
    solver: Solver
    scan: Annotated[Scan, "matching.scan"]
    response_lengths: Annotated[Array, arithmetic]


@dataclass(frozen=True)
class PolynomialSettings(Settings):
    strength_ratio: Annotated[float, "curve.strength_ratio"]
    ultimate_displacement_ratio: Annotated[float, "curve.ultimate_displacement_ratio"]
    release_amplitude: float


@dataclass(frozen=True)
class MatchedSettings(Settings):
    """The reference curve, and how damping ratios are matched on it."""

    solver: Solver
    curve: Curve
    release_amplitude: float
    matching: Matching


@dataclass(frozen=True)
class DampingForceSettings(MatchedSettings):
    damping_force: DampingForce


@dataclass(frozen=True)
class ForceCurveSettings(Settings):
    wall: Strip
    curve: Curve
    tested_wall: Annotated[Strip, "validation.wall"]


@dataclass(frozen=True)
class BilinearSettings(Settings):
    wall: Strip
    curve: Curve
    damping_force: DampingForce
    pulses: Pulses
    records: tuple[str, ...]
    scale: Annotated[Array, "earthquakes.velocity_ratio", geometric]
    step: Annotated[float, "earthquakes.step"]
    tail: Annotated[float, "earthquakes.tail"]


@dataclass(frozen=True)
class AmplitudeDependenceSettings(Settings):
    solver: Solver
    strength_ratio: Annotated[float, "curve.strength_ratio"]
    strength_ratio_beyond: Annotated[PlateauBeyond, "studies.cracked_stiffness.strength_ratio_beyond"]
    matching: Matching
    amplitude_dependence: AmplitudeDependence


@dataclass(frozen=True)
class DamperOrderSettings(MatchedSettings):
    """The reference curve, those of the amplitude dependence, and the wall and record of a test."""

    amplitude_dependence: AmplitudeDependence
    strength_ratio_beyond: Annotated[PlateauBeyond, "studies.cracked_stiffness.strength_ratio_beyond"]
    damper_order: DamperOrder
    shown_restitution: Annotated[float, "damping_force.restitution"]
    tested_wall: Annotated[Strip, "validation.wall"]
    tested_curve: Annotated[Curve, "validation.curve"]
    tested_restitution: Annotated[float, "validation.restitution"]
    tested_step: Annotated[float, "validation.step"]


@dataclass(frozen=True)
class PulseSettings(MatchedSettings):
    pulses: Pulses


@dataclass(frozen=True)
class RecommendationSettings(Settings):
    curve: Curve
    release_amplitude: float


@dataclass(frozen=True)
class MeasuredRockingSettings(Settings):
    measured_rocking: MeasuredRocking


@dataclass(frozen=True)
class ConvergenceSettings(Settings):
    convergence: Convergence


@dataclass(frozen=True)
class ValidationSettings(Settings):
    wall: Annotated[Strip, "validation.wall"]
    curve: Annotated[Curve, "validation.curve"]
    restitution: Annotated[float, "validation.restitution"]
    fit_yield_displacement_ratios: Annotated[Array, "validation.fit_yield_displacement_ratios"]
    step: Annotated[float, "validation.step"]


@dataclass(frozen=True)
class CalibrationSettings(Settings):
    wall: Annotated[Strip, "validation.wall"]
    ultimate_displacement_ratio: Annotated[float, "validation.curve.ultimate_displacement_ratio"]
    softening: Annotated[str, "validation.curve.softening"]
    step: Annotated[float, "validation.step"]


@dataclass(frozen=True)
class AccuracySettings(StudySettings):
    solver: Solver
    matching: Matching
    damping_force: DampingForce
    tested_wall: Annotated[Strip, "validation.wall"]
    tested_curve: Annotated[Curve, "validation.curve"]
    tested_restitution: Annotated[float, "validation.restitution"]
    accuracy: Accuracy
