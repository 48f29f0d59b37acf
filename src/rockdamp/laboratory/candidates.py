"""What a measured record is explained with: damping models, their parameters and where these are looked for, priors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Annotated, Any, get_type_hints

import numpy as np
from pydantic import ValidationError, create_model

from rockdamp.arguments import instance, number, one_of
from rockdamp.arrays import Array
from rockdamp.config.files import problems
from rockdamp.config.kinds import Section, distribution
from rockdamp.errors import InputError, require
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.records import Sampled
from rockdamp.statistics.distribution import KINDS, Distribution
from rockdamp.storage.yaml_file import dotted
from rockdamp.vocabulary import ANY_ORDER, CANDIDATES

SEARCHED_ORDER = 4.0  # of the damper of any order, while the others are searched

# ASSUME: where a masonry wall is looked for. a1 is searched as a1/a2, which keeps it below the plateau's end a2;
# Doherty's stages span a1/a2 = 0.21 to 0.40 and b1 = 0.50 to 0.72, the paper's walls 0.13 to 0.4 and 0.75 to 0.85. The
# damping ratios span what ECD has of the coefficients of restitution.
SEARCHED = {
    "yield_displacement_ratio": "yield_displacement_ratio over the plateau's end (a1/a2)",
    "strength_ratio": "strength_ratio (b1)",
    "restitution": "restitution (e)",
    "damping_ratio": "damping_ratio (xi)",
}
RANGE = {
    "yield_displacement_ratio": (0.02, 0.90),
    "strength_ratio": (0.40, 0.95),
    "restitution": (0.50, 1.00),
    "damping_ratio": (0.00, 0.25),
}
GRID = {
    "yield_displacement_ratio": np.geomspace(0.03, 0.65, 11),
    "strength_ratio": np.linspace(0.42, 0.94, 53),
    "restitution": np.linspace(0.56, 1.00, 12),
    "damping_ratio": np.linspace(0.002, 0.20, 12),
}


@dataclass(frozen=True)
class Candidate:
    """A damping model of `vocabulary.CANDIDATES` with the parameters by which a record may be explained.

    The `order` of `ANY_ORDER` is fixed while the others are searched, and a parameter of the posterior.
    """

    name: str
    order: float | None = None

    @classmethod
    def from_name(cls, name: str) -> Candidate:
        """Return the candidate of a name; where the order is free, the others are searched at one in between."""
        name = one_of("damping_model", name, CANDIDATES)
        return cls(name, SEARCHED_ORDER if name == ANY_ORDER else None)

    @property
    def loss(self) -> str:
        """Name of the parameter of what is lost: e of models that it describes exactly, else xi."""
        return "restitution" if self.name == ANY_ORDER or self.name in Damping.exact_models() else "damping_ratio"

    @property
    def searched(self) -> tuple[str, str, str]:
        """The three parameters that least squares fit."""
        return "yield_displacement_ratio", "strength_ratio", self.loss

    @property
    def parameters(self) -> tuple[str, ...]:
        """The parameters of wall and damper that a posterior has."""
        return (*self.searched, "order") if self.name == ANY_ORDER else self.searched

    def damping(self, loss: Array, order: Array | None = None) -> Damping:
        """Return the damper of values of its parameters."""
        if self.name == ANY_ORDER:
            return Damping.of_restitution(loss, order=self.order if order is None else order)
        if self.loss == "restitution":
            return Damping.of_restitution(loss, self.name)
        return Damping(self.name, loss)


def size_deviations(wall: Wall | Parapet, uncertain: Mapping[str, float] | None) -> dict[str, float]:
    """Return the standard deviations of the wall's uncertain sizes, by name, or raise `InputError`."""
    deviations = {}
    for name, deviation in instance("uncertain", {} if uncertain is None else uncertain, Mapping).items():
        one_of("a size that is uncertain", name, [field.name for field in fields(wall)])
        deviations[name] = number(f"uncertain {name}", deviation)
        require(deviations[name] > 0, f"uncertain {name}", deviations[name], "greater than 0")
    return deviations


def true_values(record: Sampled, names: Sequence[str]) -> Array:
    """Return the values with which a synthetic record was made; NaN where it does not state them, or was measured."""
    stated = [record.header.get(f"generator_{name}", "nan") if record.synthetic else "nan" for name in names]
    try:
        return np.array([float(value) for value in stated])
    except ValueError:
        raise InputError(f"the record's generator_* values are {stated}; they must be numbers") from None


# --- prior distributions ----------------------------------------------------------------------------------------------

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
    def from_mapping(cls, given: Mapping[str, Any]) -> Prior:
        """Return the prior of masonry walls with the changes of a section, which has the fields' names."""
        of_wall = Annotated[Distribution, distribution(KINDS)]
        kinds = {name: float if kind is float else of_wall for name, kind in get_type_hints(cls).items()}
        fields: dict[str, Any] = {name: (kind, None) for name, kind in kinds.items()}
        model = create_model("Prior", __base__=Section, **fields)
        try:
            changes = model.model_validate(given)
        except ValidationError as error:
            wrong = problems(error, model.model_json_schema())
            raise InputError("; ".join(f"{dotted(('prior', *path))} {text}" for path, text in wrong)) from None
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


def require_unlike(kind: str, displacements: Sequence[Array | None]) -> None:
    """Refuse a test that is given twice: it would count twice, and the errors come out too small."""
    first: dict[bytes, int] = {}
    for place, shown in enumerate(displacements, start=1):
        same = place if shown is None else first.setdefault(shown.tobytes(), place)
        if same != place:
            raise InputError(f"{kind} {same} and {place} have the same displacements; each must be given once")
