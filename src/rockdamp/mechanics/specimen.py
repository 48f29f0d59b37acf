"""A specimen: a wall with its force-displacement curve and its damping."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, fields
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import OneSidedWall, Parapet, Wall

AnyWall: TypeAlias = Wall | Parapet | OneSidedWall
Part = TypeVar("Part", bound=AnyWall | TrilinearCurve | Damping)


@dataclass(frozen=True, eq=False)
class Specimen:
    """A wall with its force-displacement curve and its damping.

    One case has parameters that are numbers. Many cases have arrays of shape (cases,) among
    them; a parameter that all cases share may stay a number.

    Parameters
    ----------
    wall : Wall, Parapet or OneSidedWall
        Sizes, weights and kind of the wall.
    curve : TrilinearCurve
        Force-displacement curve of the wall.
    damping : Damping
        Restitution or viscous damper of the wall.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.TrilinearCurve(0.04, 0.85)
    >>> specimens = [
    ...     Specimen(rd.Wall(0.3, height), curve, rd.Damping("CR", 0.85)) for height in (3, 4)
    ... ]
    >>> Specimen.stack(specimens).wall.height
    array([3., 4.])
    >>> Specimen.stack(specimens).take(1).wall.height.item()
    4.0
    """

    wall: AnyWall
    curve: TrilinearCurve
    damping: Damping

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape that the parameters broadcast to: () for one case, (cases,) for many."""
        return np.broadcast_shapes(
            np.shape(self.wall.load_factor), self.curve.shape, self.damping.shape
        )

    @property
    def kind(self) -> Hashable:
        """Key that is equal for specimens of numbers that can be stacked."""
        damping = self.damping
        return (
            type(self.wall),
            self.curve.softening,
            damping.model,
            float(damping.order),
            float(damping.width),
        )

    def take(self, index: int | NDArray[np.intp]) -> Specimen:
        """Return the cases at `index`; a number stays a number.

        Parameters
        ----------
        index : int or ndarray of int
            Positions among the cases. An integer gives a specimen of numbers.
        """
        shape = self.shape
        return Specimen(
            _take(self.wall, shape, index),
            _take(self.curve, shape, index),
            _take(self.damping, shape, index),
        )

    @classmethod
    def stack(cls, specimens: Sequence[Specimen]) -> Specimen:
        """Return specimens of numbers, all of one `kind`, as one of arrays of shape (cases,).

        Parameters
        ----------
        specimens : sequence of Specimen
            The cases, at least one, in the order of the arrays.
        """
        kinds = {specimen.kind for specimen in specimens}
        if len(kinds) != 1:
            raise ValueError(f"specimens of {len(kinds)} kinds; they must be of one")
        return cls(
            stack_parts([specimen.wall for specimen in specimens]),
            stack_parts([specimen.curve for specimen in specimens]),
            stack_parts([specimen.damping for specimen in specimens]),
        )


def stack_parts(parts: Sequence[Part]) -> Part:
    """Return walls, curves or dampings of numbers as one of arrays; a text is taken from the first.

    Parameters
    ----------
    parts : sequence of Wall, Parapet, OneSidedWall, TrilinearCurve or Damping
        Objects of one class, at least one.
    """
    parameters: dict[str, Any] = {}
    for field in fields(parts[0]):
        values = [getattr(part, field.name) for part in parts]
        if isinstance(values[0], str):
            parameters[field.name] = values[0]
        elif isinstance(values[0], Wall | Parapet):  # the mechanism of a one-sided wall
            parameters[field.name] = stack_parts(values)
        else:
            parameters[field.name] = np.array(values, dtype=float)
    return type(parts[0])(**parameters)


def _take(part: Part, shape: tuple[int, ...], index: int | NDArray[np.intp]) -> Part:
    """Return a wall, curve or damping with the elements at `index` of its arrays."""
    parameters: dict[str, Any] = {}
    for field in fields(part):
        value = getattr(part, field.name)
        if isinstance(value, Wall | Parapet):  # the mechanism of a one-sided wall
            value = _take(value, shape, index)
        elif np.ndim(value):
            value = np.broadcast_to(value, shape)[index]
        parameters[field.name] = value
    return type(part)(**parameters)
