"""The damping models that a measured record is explained with: their parameters, and where these are looked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from rockdamp.arguments import instance, number, one_of
from rockdamp.arrays import Array
from rockdamp.errors import InputError, require
from rockdamp.laboratory.free_rocking_record import FreeRocking
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.records import Record
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
    def of(cls, name: str) -> Candidate:
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


def true_values(record: Record | FreeRocking, names: Sequence[str]) -> Array:
    """Return the values with which a synthetic record was made; NaN where it does not state them, or was measured."""
    stated = [record.header.get(f"generator_{name}", "nan") if record.synthetic else "nan" for name in names]
    try:
        return np.array([float(value) for value in stated])
    except ValueError:
        raise InputError(f"the record's generator_* values are {stated}; they must be numbers") from None
