"""What a config costs, estimated before the first job: no number beyond all use, no job beyond all computers.

The estimates stand in costs.yaml. They are computed as logarithms, which no config overflows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.resources import files
from typing import Any, NamedTuple

from rockdamp.config import Config
from rockdamp.config.schema import KeyPath, Problem
from rockdamp.storage import yaml_file
from rockdamp.vocabulary import DEFAULT_WINDOW

SMALLEST, LARGEST = 1e-12, 1e15  # of the numbers of a config, apart from 0
LIMITS = {"steps": 1e13, "values": 4e9, "jobs": 1e4, "solved": 1e6}  # what they mean: costs.yaml


class Term(NamedTuple):
    """A key that a cost depends on: how, and the value that it usually has."""

    key: str
    kind: str  # "of", "per" or "doubled"
    usual: float

    def size(self, value: Any) -> float:
        """Return the decimal logarithm of what a value contributes."""
        if self.kind == "doubled":
            return float(value) * math.log10(2)
        return math.log10(_amount(value)) * (-1 if self.kind == "per" else 1)

    def bound(self, value: Any, room: float) -> tuple[KeyPath, str]:
        """Return the key to change and what it must be, for a contribution whose logarithm is `room`."""
        path: KeyPath = tuple(self.key.split("."))
        if self.kind == "doubled":
            return path, f"it must be at most {max(math.floor(room / math.log10(2)), 0)}"
        if self.kind == "per":
            return path, f"it must be at least {10**-room:.3g}"
        if isinstance(value, Mapping):
            least = (value["stop"] - value["start"]) / max(10**room - 1, 1)
            return (*path, "step"), f"it must be at least {least:.3g}"
        return path, f"it must {'have' if isinstance(value, list) else 'be'} at most {10**room:.3g}"


class Cost(NamedTuple):
    """A product of terms that must stay below a limit."""

    what: str
    limit: float
    times: float
    terms: tuple[Term, ...]


@cache
def costs() -> tuple[Cost, ...]:
    """Return the table of costs.yaml."""
    table = yaml_file.load(files("rockdamp.config").joinpath("costs.yaml").read_text(encoding="utf-8"))
    return tuple(
        Cost(
            entry["what"],
            LIMITS[entry["limit"]],
            entry["times"],
            tuple(
                Term(key, kind, usual)
                for kind in ("of", "per", "doubled")
                for key, usual in entry.get(kind, {}).items()
            ),
        )
        for entry in table
    )


def size_problems(config: Config) -> list[Problem]:
    """List the numbers that are beyond all use; formulas of the other checks would overflow with them."""
    allowed = f"it must be 0, or between {SMALLEST:g} and {LARGEST:g} in size"
    return [Problem(path, f"is {_shown(value)}; {allowed}") for path, value in _numbers((), config) if _beyond(value)]


def cost_problems(config: Config) -> list[Problem]:
    """List the keys that make a job which no computer can run, each with the least of the bounds that it must keep."""
    worst: dict[str, tuple[float, Problem]] = {}
    for cost in costs():
        values = {term: _at(config, term.key) for term in cost.terms}
        sizes = {term: term.size(value) for term, value in values.items()}
        total = math.log10(cost.times) + sum(sizes.values())
        excess = total - math.log10(cost.limit)
        named = max(cost.terms, key=lambda term: sizes[term] - term.size(term.usual))
        if excess <= worst.get(named.key, (0.0,))[0]:
            continue
        path, must = named.bound(values[named], sizes[named] - excess)
        value = _at(config, ".".join(map(str, path)))
        has = f"has {len(value)} values" if isinstance(value, list) else f"is {value}"
        text = f"{has}, with which {cost.what} would be some 1e{round(total)}, over {cost.limit:.0e}; {must}"
        worst[named.key] = (excess, Problem(path, text))
    return [problem for _, problem in worst.values()]


def _amount(value: Any) -> float:
    """A number, or how many values a list or a grid has; the default length of the response is the package's."""
    if isinstance(value, Mapping):
        return (value["stop"] - value["start"]) / value["step"] + 1
    if isinstance(value, list):
        return len(value)
    return DEFAULT_WINDOW if isinstance(value, str) else value


def _at(config: Config, key: str) -> Any:
    value: Any = config
    for name in key.split("."):
        value = value[name]
    return value


def _numbers(path: KeyPath, value: Any) -> Iterator[tuple[KeyPath, float]]:
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _numbers((*path, key), inner)
    elif isinstance(value, list):
        for index, inner in enumerate(value):
            yield from _numbers((*path, index), inner)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield path, value


def _beyond(value: float) -> bool:
    return value != 0 and not SMALLEST <= abs(value) <= LARGEST


def _shown(value: float) -> str:
    text = str(value)
    return text if len(text) < 30 else f"{text[:10]}... ({len(text)} digits)"
