"""Prior distributions of wall, damper and instruments, before the record is seen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, get_type_hints

import numpy as np
from pydantic import ValidationError, create_model

from rockdamp.arrays import Array
from rockdamp.config.files import problems
from rockdamp.config.kinds import Section, distribution
from rockdamp.errors import InputError, require
from rockdamp.statistics.distribution import KINDS, Distribution
from rockdamp.storage.dotted_keys import dotted

SIZES = ("thickness", "height", "hinge_ratio", "overburden_ratio")  # of the wall, that may be uncertain


@dataclass(frozen=True)
class Prior:
    """Independent distributions of all parameters, of e or xi and of m where a model has them.

    a1 is also below the end of the plateau. The sensor's noise has a standard deviation [m] and a correlation of a
    sample and the next. Its zero, beyond its mean at rest [m], and its drift [m s-1] are normal about 0 with these
    deviations. A size of the wall that has a distribution is a parameter; without one it is known. [m] [-]
    """

    yield_displacement_ratio: Distribution = Distribution("loguniform", 0.015, 0.20)
    strength_ratio: Distribution = Distribution("uniform", 0.40, 0.95)
    restitution: Distribution = Distribution("uniform", 0.60, 1.00)
    damping_ratio: Distribution = Distribution("uniform", 0.0, 0.20)
    order: Distribution = Distribution("loguniform", 0.25, 32.0)
    sensor_deviation: Distribution = Distribution("loguniform", 1e-6, 1e-1)
    sensor_correlation: Distribution = Distribution("uniform", 0.0, 0.999)
    sensor_zero: float = 2e-3
    sensor_drift: float = 1e-3
    thickness: Distribution | None = None
    height: Distribution | None = None
    hinge_ratio: Distribution | None = None
    overburden_ratio: Distribution | None = None

    @classmethod
    def of(cls, given: Mapping[str, Any], section_name: str = "prior") -> Prior:
        """Return the prior of masonry walls with the changes of a section, which has the fields' names."""
        of_wall = Annotated[Distribution, distribution(KINDS)]
        kinds = {name: float if kind is float else of_wall for name, kind in get_type_hints(cls).items()}
        fields: dict[str, Any] = {name: (kind, None) for name, kind in kinds.items()}
        model = create_model("Prior", __base__=Section, **fields)
        try:
            changes = model.model_validate(given)
        except ValidationError as error:
            wrong = problems(error, model.model_json_schema())
            raise InputError("; ".join(f"{dotted((section_name, *path))} {text}" for path, text in wrong)) from None
        return replace(cls(), **{name: getattr(changes, name) for name in changes.model_fields_set})

    def __post_init__(self) -> None:
        phi = self.sensor_correlation
        require(-1 < phi.low and phi.high < 1, "sensor_correlation", [phi.low, phi.high], "between -1 and 1")
        require(self.restitution.high <= 1, "restitution", self.restitution.high, "at most 1")
        for name in ("yield_displacement_ratio", "strength_ratio", "restitution", "sensor_deviation"):
            require(getattr(self, name).low > 0, name, getattr(self, name).low, "greater than 0")
        for name in ("damping_ratio", "order"):
            require(getattr(self, name).low >= 0, name, getattr(self, name).low, "at least 0")
        require(self.strength_ratio.high < 1, "strength_ratio", self.strength_ratio.high, "less than 1")
        for name in ("sensor_zero", "sensor_drift"):
            require(0 < getattr(self, name) < np.inf, name, getattr(self, name), "greater than 0, and finite")

    @property
    def sizes(self) -> tuple[str, ...]:
        """The sizes of the wall that are parameters."""
        return tuple(name for name in SIZES if getattr(self, name) is not None)

    def distribution(self, name: str) -> Distribution:
        """Return the distribution of a parameter; one of a run, "restitution 2", has that of all runs."""
        distribution = getattr(self, name.split()[0])
        assert isinstance(distribution, Distribution)
        return distribution

    def values(self, names: tuple[str, ...], points: Array) -> Array:
        """Return the values at points of the unit cube, shape (batch, names), in which the prior is uniform."""
        return np.stack([self.distribution(name).quantile(points[:, i]) for i, name in enumerate(names)], axis=1)

    def points(self, names: tuple[str, ...], values: Array) -> Array:
        """Return the points of the unit cube at which values lie, shape (batch, names)."""
        return np.stack([self.distribution(name).probability(values[:, i]) for i, name in enumerate(names)], axis=1)
