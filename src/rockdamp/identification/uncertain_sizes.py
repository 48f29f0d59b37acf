"""Sizes of a wall that are known with a standard deviation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields

from rockdamp.arguments import instance, number, one_of
from rockdamp.errors import require
from rockdamp.mechanics.wall import Parapet, Wall


def size_deviations(wall: Wall | Parapet, uncertain: Mapping[str, float] | None) -> dict[str, float]:
    """Return the standard deviations of the wall's uncertain sizes, by name, or raise `InputError`."""
    deviations = {}
    for name, deviation in instance("uncertain", {} if uncertain is None else uncertain, Mapping).items():
        one_of("a size that is uncertain", name, [field.name for field in fields(wall)])
        deviations[name] = number(f"uncertain {name}", deviation)
        require(deviations[name] > 0, f"uncertain {name}", deviations[name], "greater than 0")
    return deviations
