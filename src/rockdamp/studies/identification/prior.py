"""What is held possible of wall, damper and instruments before the record is seen."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np

from rockdamp.arrays import Array
from rockdamp.config.parsing import section
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


def _interval(value: Any, key: str) -> Interval:
    made: Interval = section(Interval, value, key)
    return made


Bounds = Annotated[Interval, _interval]


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

    cracked_stiffness_ratio: Bounds = field(default=Interval("loguniform", 0.005, 0.25))
    plateau_ratio: Bounds = field(default=Interval("uniform", 0.40, 0.95))
    restitution: Bounds = field(default=Interval("uniform", 0.60, 1.00))
    damping_ratio: Bounds = field(default=Interval("uniform", 0.0, 0.20))
    order: Bounds = field(default=Interval("loguniform", 0.25, 32.0))
    sensor_deviation: Bounds = field(default=Interval("loguniform", 1e-6, 1e-1))
    sensor_correlation: Bounds = field(default=Interval("uniform", 0.0, 0.999))
    sensor_zero: float = 2e-3
    sensor_drift: float = 1e-3

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
