"""The sections ``earthquakes`` and ``population`` of the config, parsed for each stage under earthquakes."""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any

from rockdamp.arrays import Array
from rockdamp.config.parsing import (
    Ascending,
    Section,
    Settings,
    each,
    geometric,
    made_of,
    members,
    number,
    section,
    whole,
)
from rockdamp.config.settings import Bootstrap, DampingForce, Matching, Pulses, Solver
from rockdamp.config.walls import Curve, NamedWall, make_named_wall
from rockdamp.mechanics.building import Building
from rockdamp.statistics.distribution import Distribution

# What describes a wall of the population.
PARAMETERS = (
    "thickness",
    "slenderness",
    "overburden_ratio",
    "hinge_ratio",
    "yield_displacement_ratio",
    "strength_ratio",
    "restitution",
)

NamedWalls = Annotated[tuple[NamedWall, ...], partial(each, make_named_wall)]


class Splits(Section):
    count: int
    seed: int


def _distributions(value: Any, key: str) -> dict[str, Distribution]:
    """Parse the distribution of each parameter of a population."""
    parameters = members(value, key, PARAMETERS)
    return {name: section(Distribution, entry, f"{key}.{name}") for name, entry in parameters.items()}


def _correlations(value: Any, key: str) -> dict[tuple[str, str], float]:
    """Parse the correlation of each pair of a population's parameters."""
    return {
        (name, other): number(correlation, f"{key}.{name}.{other}")
        for name, others in members(value, key, (), PARAMETERS).items()
        for other, correlation in members(others, f"{key}.{name}", (), PARAMETERS).items()
    }


# --- walls under records ---------------------------------------------------------------------------------------------


class EarthquakeWallSettings(Settings):
    solver: Solver
    walls: Annotated[NamedWalls, "earthquakes.walls"]
    restitution: Annotated[Ascending, "earthquakes.restitution"]
    release_amplitude: float
    matching: Matching


class ShakenWallSettings(Settings):
    """The walls, and the records that shake them."""

    records: tuple[str, ...]
    walls: Annotated[NamedWalls, "earthquakes.walls"]
    tail: Annotated[float, "earthquakes.tail"]


class RecordSettings(ShakenWallSettings):
    """The walls, and the records that shake them at several intensities, a share at a time."""

    restitution_change: Annotated[float, "earthquakes.restitution_change"]
    scale: Annotated[Array, "earthquakes.velocity_ratio", geometric]
    records_per_job: Annotated[int, "earthquakes.records_per_job"]


class EarthquakeRecordSettings(RecordSettings):
    step: Annotated[float, "earthquakes.step"]


class ComparisonSettings(Settings):
    bands: Annotated[Ascending, "earthquakes.bands"]
    bootstrap: Annotated[Bootstrap, "earthquakes.bootstrap"]


class OrderRecordSettings(RecordSettings):
    restitution: Annotated[Ascending, "earthquakes.orders.restitution"]
    order: Annotated[Ascending, "earthquakes.orders.order"]
    step: Annotated[float, "earthquakes.orders.step"]
    loss_change: Annotated[float, "earthquakes.orders.loss_change"]
    test_spread: Annotated[float, "earthquakes.orders.test_spread"]


class OrderComparisonSettings(ComparisonSettings):
    restitution_change: Annotated[float, "earthquakes.restitution_change"]
    loss_change: Annotated[float, "earthquakes.orders.loss_change"]
    test_spread: Annotated[float, "earthquakes.orders.test_spread"]
    splits: Annotated[Splits, "earthquakes.orders.splits"]


class LocalDampingSettings(ComparisonSettings, ShakenWallSettings):
    """The pulses on the reference curve, and the records that shake the walls."""

    curve: Curve
    damping_force: DampingForce
    pulses: Pulses
    scale: Annotated[Array, "earthquakes.velocity_ratio", geometric]
    step: Annotated[float, "earthquakes.orders.step"]


def make_building(value: Any, key: str = "spectrum_method.building") -> Building:
    """Build the building of a section, which deforms in shear."""
    names = ("period", "storeys", "storey", "damping_ratio")
    entries = members(value, key, names)
    parsers = dict.fromkeys(names, number) | dict.fromkeys(("storeys", "storey"), whole)
    parsed: dict[str, Any] = {name: parse(entries[name], f"{key}.{name}") for name, parse in parsers.items()}
    with made_of(key, names):
        return Building(**parsed)


class SpectrumMethodSettings(ShakenWallSettings):
    restitution: Annotated[Ascending, "earthquakes.restitution"]
    capacity: Annotated[Ascending, "spectrum_method.capacity"]
    levels: Annotated[Array, "spectrum_method.velocity_ratio", geometric]
    step: Annotated[float, "spectrum_method.step"]
    building: Annotated[Building, "spectrum_method.building", make_building]


class EventDrivenCheckSettings(ShakenWallSettings):
    histories: Annotated[int, "earthquakes.check.histories"]
    seed: Annotated[int, "earthquakes.check.seed"]


# --- population ------------------------------------------------------------------------------------------------------


class PopulationWallSettings(Settings):
    count: Annotated[int, "population.walls"]
    seed: Annotated[int, "population.seed"]
    parameters: Annotated[dict[str, Distribution], "population.parameters", _distributions]
    correlations: Annotated[dict[tuple[str, str], float], "population.correlations", _correlations]
    release_amplitude: float


class PopulationShareSettings(Settings):
    walls_per_job: Annotated[int, "population.walls_per_job"]
    records: Annotated[tuple[str, ...], "population.records"]
    intensity: Annotated[Array, "population.intensity", geometric]
    step: Annotated[float, "population.step"]
    tail: Annotated[float, "population.tail"]


class PopulationCheckSettings(Settings):
    records: Annotated[tuple[str, ...], "population.records"]
    tail: Annotated[float, "population.tail"]
    histories: Annotated[int, "population.check.histories"]
    seed: Annotated[int, "population.check.seed"]


class PopulationSettings(Settings):
    bootstrap: Annotated[Bootstrap, "population.bootstrap"]
