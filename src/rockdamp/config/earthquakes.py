"""The sections ``natural`` and ``population`` of the config, parsed: what each stage under earthquakes depends on."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

from rockdamp.arrays import Array
from rockdamp.config.parsing import Ascending, Settings, each, geometric, members, number, section
from rockdamp.config.settings import Matching, Solver
from rockdamp.config.walls import NamedWall, make_named_wall
from rockdamp.statistics.distribution import Distribution

# What describes a wall of the population.
PARAMETERS = (
    "thickness",
    "slenderness",
    "overburden_ratio",
    "hinge_ratio",
    "cracked_stiffness_ratio",
    "plateau_ratio",
    "restitution",
)

NamedWalls = Annotated[tuple[NamedWall, ...], partial(each, make_named_wall)]


@dataclass(frozen=True)
class Bootstrap:
    replicates: int
    seed: int


def _distributions(value: Any, key: str) -> dict[str, Distribution]:
    """The distribution of each parameter of a population."""
    given = members(value, key, PARAMETERS)
    return {name: section(Distribution, entry, f"{key}.{name}") for name, entry in given.items()}


def _correlations(value: Any, key: str) -> dict[tuple[str, str], float]:
    """The correlation of each pair of a population's parameters."""
    given = members(value, key, (), PARAMETERS)
    stated = {name: members(others, f"{key}.{name}", (), PARAMETERS) for name, others in given.items()}
    return {
        (name, other): number(correlation, f"{key}.{name}.{other}")
        for name, others in stated.items()
        for other, correlation in others.items()
    }


# --- walls under records ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class EarthquakeWallSettings(Settings):
    solver: Solver
    walls: Annotated[NamedWalls, "natural.walls"]
    restitution: Annotated[Ascending, "natural.restitution"]
    release_amplitude: float
    matching: Matching


@dataclass(frozen=True)
class EarthquakeRecordSettings(Settings):
    records: tuple[str, ...]
    walls: Annotated[NamedWalls, "natural.walls"]
    restitution_change: Annotated[float, "natural.restitution_change"]
    scale: Annotated[Array, "natural.scale", geometric]
    step: Annotated[float, "natural.step"]
    tail: Annotated[float, "natural.tail"]
    records_per_job: Annotated[int, "natural.records_per_job"]


@dataclass(frozen=True)
class ComparisonSettings(Settings):
    bands: Annotated[Ascending, "natural.bands"]
    bootstrap: Annotated[Bootstrap, "natural.bootstrap"]


@dataclass(frozen=True)
class OrderRecordSettings(Settings):
    records: tuple[str, ...]
    walls: Annotated[NamedWalls, "natural.walls"]
    restitution: Annotated[Ascending, "natural.orders.restitution"]
    restitution_change: Annotated[float, "natural.restitution_change"]
    order: Annotated[Ascending, "natural.orders.order"]
    scale: Annotated[Array, "natural.scale", geometric]
    step: Annotated[float, "natural.orders.step"]
    tail: Annotated[float, "natural.tail"]
    records_per_job: Annotated[int, "natural.records_per_job"]


@dataclass(frozen=True)
class OrderComparisonSettings(Settings):
    restitution_change: Annotated[float, "natural.restitution_change"]
    bands: Annotated[Ascending, "natural.bands"]
    bootstrap: Annotated[Bootstrap, "natural.bootstrap"]


@dataclass(frozen=True)
class EventDrivenCheckSettings(Settings):
    records: tuple[str, ...]
    walls: Annotated[NamedWalls, "natural.walls"]
    tail: Annotated[float, "natural.tail"]
    histories: Annotated[int, "natural.check.histories"]
    seed: Annotated[int, "natural.check.seed"]


# --- population ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class PopulationWallSettings(Settings):
    count: Annotated[int, "population.walls"]
    seed: Annotated[int, "population.seed"]
    parameters: Annotated[dict[str, Distribution], "population.parameters", _distributions]
    correlations: Annotated[dict[tuple[str, str], float], "population.correlations", _correlations]
    redrawn: Annotated[int, "population.redrawn"]
    release_amplitude: float


@dataclass(frozen=True)
class PopulationShareSettings(Settings):
    walls_per_job: Annotated[int, "population.walls_per_job"]
    records: Annotated[tuple[str, ...], "population.records"]
    intensity: Annotated[Array, "population.intensity", geometric]
    step: Annotated[float, "population.step"]
    tail: Annotated[float, "population.tail"]


@dataclass(frozen=True)
class PopulationCheckSettings(Settings):
    records: Annotated[tuple[str, ...], "population.records"]
    tail: Annotated[float, "population.tail"]
    histories: Annotated[int, "population.check.histories"]
    seed: Annotated[int, "population.check.seed"]


@dataclass(frozen=True)
class PopulationSettings(Settings):
    bootstrap: Annotated[Bootstrap, "population.bootstrap"]
