"""Kinds of values in the config: bounded numbers, lists, grids, and what sections are made into.

A kind is an annotated type, so that its bounds are checked and stand in the schema, and mypy sees what is made of it.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, GetPydanticSchema
from pydantic_core import core_schema

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.plausibility import as_meant

WHOLE = 1e-9  # how far from a whole number of steps a grid's end may lie, as a fraction of the number of steps
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")


class Refusal(ValueError):
    """Say what is wrong with a value of the config, or with what stands at a path below it."""

    def __init__(self, text: str, *path: str | int) -> None:
        super().__init__(text)
        self.text, self.path = text, path


class Section(BaseModel):
    """Base of a section: it takes its own keys alone, and no value for another kind of value."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, arbitrary_types_allowed=True
    )


def made_of(kind: Any, make: Callable[[Any], Any]) -> GetPydanticSchema:
    """Return an annotation of a field that is checked as `kind`, and holds what `make` makes of it.

    An `InputError` of `make` is one of the key that it names.
    """

    def checked(value: Any) -> Any:
        try:
            with as_meant():  # `rockdamp.config.checks` warns of what is unlikely, once
                return make(value)
        except InputError as error:
            if isinstance(value, BaseModel) and error.name in type(value).model_fields:
                raise Refusal(error.text, error.name) from None
            raise Refusal(f"cannot be used: {error}") from None

    return GetPydanticSchema(
        lambda _, handler: core_schema.no_info_after_validator_function(checked, handler.generate_schema(kind))
    )


# A section of a study that null leaves out. What a stage is given has all of its sections, so that none is None there.
OrNull = GetPydanticSchema(lambda source, handler: core_schema.nullable_schema(handler(source)))


# --- numbers and texts -----------------------------------------------------------------------------------------------


def _one_line(text: str) -> str:
    if _CONTROL.search(text):
        raise Refusal("has a control character, or half a character; it must be one line of text")
    return text


Text = Annotated[str, Field(min_length=1), AfterValidator(_one_line)]

# 8.0 is a whole number, as it is in JSON.
INTEGRAL = BeforeValidator(lambda value: int(value) if isinstance(value, float) and value.is_integer() else value)


Whole = Annotated[int, INTEGRAL]
Positive = Annotated[float, Field(gt=0, le=1e6)]
Step = Annotated[float, Field(ge=1e-4, le=1)]
Length = Annotated[float, Field(gt=0, le=1000)]  # in tau
Duration = Annotated[float, Field(gt=0, le=1000)]  # in seconds
Fraction = Annotated[float, Field(gt=0, lt=1)]
Restitution = Annotated[float, Field(gt=0, le=1)]
Overburden = Annotated[float, Field(ge=0, le=1000)]  # O/W
Edge = Annotated[float, Field(gt=0, le=10)]  # of a band of peaks, u/u_ins
Order = Annotated[float, Field(ge=0, le=1000)]
Seed = Annotated[int, Field(ge=0, le=2**32 - 1), INTEGRAL]
Count = Annotated[int, Field(ge=1, le=1_000_000), INTEGRAL]


# --- lists -----------------------------------------------------------------------------------------------------------


def _shown(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else repr(value)


def _differ(values: list[Any]) -> list[Any]:
    for index, value in enumerate(values):
        if value in values[:index]:
            raise Refusal(f"has {_shown(value)} twice; its values must differ")
    return values


def _ascending(values: list[Any]) -> list[Any]:
    for index, (before, after) in enumerate(zip(values, values[1:], strict=False)):
        if not after > before:
            text = f"is {_shown(after)}; it must be greater than the value before it, {_shown(before)}"
            raise Refusal(text, index + 1)
    return values


def _list(item: Any, least: int, *checks: Callable[[list[Any]], list[Any]]) -> Any:
    bounds = Field(min_length=least, max_length=1000, json_schema_extra={"uniqueItems": True})
    return Annotated[(list[item], bounds, AfterValidator(_differ), *map(AfterValidator, checks))]


def values(item: Any, least: int = 1) -> GetPydanticSchema:
    """Return the annotation of an array of different values, such as ``Annotated[Array, values(Positive)]``."""
    return made_of(_list(item, least), np.array)


def ascending(item: Any, least: int = 1) -> GetPydanticSchema:
    """Return the annotation of an array of values, each greater than the one before it."""
    return made_of(_list(item, least, _ascending), np.array)


def names(item: Any = Text, least: int = 1) -> GetPydanticSchema:
    """Return the annotation of a tuple of different names."""
    return made_of(_list(item, least), tuple)


Positives = Annotated[Array, values(Positive)]
Fractions = Annotated[Array, ascending(Fraction)]
Bands = Annotated[Array, ascending(Edge, 2)]
Orders = Annotated[Array, ascending(Order)]
Records = Annotated[tuple[str, ...], names()]


# --- grids -----------------------------------------------------------------------------------------------------------


def _require_start_below_stop(start: float, stop: float) -> None:
    if not start < stop:
        raise Refusal(f"is {stop}; it must be greater than start, {start:g}", "stop")


class ArithmeticGrid(Section):
    start: float = Field(description="The smallest value.")
    stop: float = Field(description="The largest value.")
    step: float = Field(description="Spacing; a whole number of steps leads from start to stop.")

    def values(self) -> Array:
        """Return the values, both ends included, rounded to 12 decimals, lest 0.85 be a little more."""
        _require_start_below_stop(self.start, self.stop)
        steps = (self.stop - self.start) / self.step
        if not abs(steps - round(steps)) <= WHOLE * steps:
            allowed = f"such that a whole number of steps leads from start, {self.start:g}, to stop, {self.stop:g}"
            raise Refusal(f"is {self.step}; it must be {allowed}", "step")
        return np.round(self.start + self.step * np.arange(round(steps) + 1), 12)


class GeometricGrid(Section):
    start: Positive = Field(description="The smallest value.")
    stop: Positive = Field(description="The largest value.")
    count: Whole = Field(ge=2, le=10_000, description="Number of values.")

    def values(self) -> Array:
        _require_start_below_stop(self.start, self.stop)
        return np.geomspace(self.start, self.stop, self.count)


Geometric = Annotated[Array, made_of(GeometricGrid, GeometricGrid.values)]
