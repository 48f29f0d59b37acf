"""What is held possible of wall, damper and instruments before the record is seen."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, get_type_hints

import numpy as np

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.parsing import members, number, section
from rockdamp.errors import InputError, require

KINDS = ("uniform", "loguniform")


@dataclass(frozen=True)
class Interval:
    """A distribution, uniform in a value or in its logarithm, between two bounds."""

    distribution: str
    low: float
    high: float

    def __post_init__(self) -> None:
        if self.distribution not in KINDS:
            raise InputError(f"distribution is {self.distribution!r}; it must be {' or '.join(KINDS)}")
        lowest = 0 if self.distribution == "loguniform" else -np.inf
        require(self.low > lowest, "low", self.low, "greater than 0 for loguniform")
        require(self.high > self.low, "high", self.high, f"greater than low, {self.low:g}")

    @property
    def bounds(self) -> tuple[float, float]:
        """In the coordinate in which it is uniform."""
        low, high = self.coordinate(np.array([self.low, self.high]))
        return float(low), float(high)

    def coordinate(self, value: Array) -> Array:
        """From the value to the coordinate in which it is uniform."""
        return np.log(value) if self.distribution == "loguniform" else value

    def value(self, coordinate: Array) -> Array:
        """Back from the coordinate."""
        return np.exp(coordinate) if self.distribution == "loguniform" else coordinate


@dataclass(frozen=True)
class Prior:
    """Independent distributions of all parameters; e and xi, m where a model has them.

    Parameters
    ----------
    cracked_stiffness_ratio, plateau_ratio, restitution, damping_ratio, order : Interval
        a1, b1, e, xi and m; a1 also below the end of the plateau. [-]
    sensor_deviation, sensor_correlation : Interval
        Of the displacement sensor's noise: its standard deviation [m], and the correlation of a sample and the next,
        between -1 and 1. [-]
    sensor_zero, sensor_drift : float
        Standard deviations of normal distributions about 0: of the sensor's zero beyond its mean at rest [m], and of
        its drift [m s-1].
    """

    cracked_stiffness_ratio: Interval = Interval("loguniform", 0.015, 0.20)
    plateau_ratio: Interval = Interval("uniform", 0.40, 0.95)
    restitution: Interval = Interval("uniform", 0.60, 1.00)
    damping_ratio: Interval = Interval("uniform", 0.0, 0.20)
    order: Interval = Interval("loguniform", 0.25, 32.0)
    sensor_deviation: Interval = Interval("loguniform", 1e-6, 1e-1)
    sensor_correlation: Interval = Interval("uniform", 0.0, 0.999)
    sensor_zero: float = 2e-3
    sensor_drift: float = 1e-3

    @classmethod
    def of(cls, given: Config, section_name: str = "prior") -> Prior:
        """Return the prior of masonry walls but for what is given: a section with the fields' names.

        Raises
        ------
        InputError
            If a name is unknown, or a value is no distribution.
        """
        kinds = get_type_hints(cls)
        parsed: dict[str, Any] = {}
        for name, value in members(given, section_name, (), list(kinds)).items():
            key = f"{section_name}.{name}"
            parsed[name] = number(value, key) if kinds[name] is float else section(Interval, value, key)
        return replace(cls(), **parsed)

    def __post_init__(self) -> None:
        phi = self.sensor_correlation
        require(-1 < phi.low and phi.high < 1, "sensor_correlation", [phi.low, phi.high], "between -1 and 1")
        require(self.restitution.high <= 1, "restitution", self.restitution.high, "at most 1")
        for name in ("cracked_stiffness_ratio", "plateau_ratio", "restitution", "sensor_deviation"):
            require(getattr(self, name).low > 0, name, getattr(self, name).low, "greater than 0")
        for name in ("damping_ratio", "order"):
            require(getattr(self, name).low >= 0, name, getattr(self, name).low, "at least 0")
        require(self.plateau_ratio.high < 1, "plateau_ratio", self.plateau_ratio.high, "less than 1")
        require(self.sensor_zero > 0, "sensor_zero", self.sensor_zero, "greater than 0")
        require(self.sensor_drift > 0, "sensor_drift", self.sensor_drift, "greater than 0")

    def bounds(self, names: tuple[str, ...]) -> tuple[Array, Array]:
        """Lowest and highest coordinates of parameters."""
        low, high = np.array([getattr(self, name).bounds for name in names]).T
        return low, high

    def values(self, names: tuple[str, ...], coordinates: Array) -> Array:
        """From coordinates, shape (batch, names), to values."""
        columns = [getattr(self, name).value(coordinates[:, index]) for index, name in enumerate(names)]
        return np.stack(columns, axis=1)

    def coordinates(self, names: tuple[str, ...], values: Array) -> Array:
        """From values, shape (batch, names), to coordinates."""
        columns = [getattr(self, name).coordinate(values[:, index]) for index, name in enumerate(names)]
        return np.stack(columns, axis=1)
