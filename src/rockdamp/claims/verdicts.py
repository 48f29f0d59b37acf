"""Combine the parts of a claim into a verdict, and put measured values into words."""

from __future__ import annotations

import string
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from rockdamp.errors import InputError
from rockdamp.storage.dataset import Datasets

REPRODUCED = "reproduced"
CONDITIONAL = "reproduced under conditions"
NOT_REPRODUCED = "not reproduced"
NOT_JUDGED = "not judged"

Claim = Mapping[str, Any]


@dataclass(frozen=True)
class Measured:
    """One measured quantity in words: a sentence, or a quantity with its values."""

    quantity: str
    values: tuple[str, ...] = ()
    by: str = ""  # the case that each value is of, ``half cycle``; empty where the values say it

    def __str__(self) -> str:
        quantity = f"{self.by} by {self.by} {self.quantity}" if self.by else self.quantity
        return f"{quantity}: {'; '.join(self.values)}" if self.values else quantity


def measured(quantity: str, *values: str, by: str = "") -> tuple[Measured, ...]:
    """Return one measured quantity as what a `Part` takes; several are added."""
    return (Measured(quantity, values, by),)


@dataclass(frozen=True)
class Part:
    """One part of a claim, judged."""

    holds: bool  # in every case
    measured: tuple[Measured, ...] = ()
    finding: Mapping[str, str] = field(default_factory=dict)  # fills the gaps of the claim's ``finding``
    where: str = ""  # the cases in which it holds, where these are enough but not all


@dataclass(frozen=True)
class Verdict:
    """The verdict on a claim, with all that the tables and the report say of it."""

    id: str
    section: str
    claim: str
    verdict: str
    measured: tuple[Measured, ...]
    threshold: str
    reasons: tuple[str, ...]  # that hold the verdict back, beside the parts
    finding: str  # in one sentence, with its numbers
    holds: tuple[str, ...]  # the words of the parts that hold, as in the next two
    holds_in_part: tuple[str, ...]
    does_not_hold: tuple[str, ...]
    figure: str
    later: str  # what was added or corrected with results known

    @property
    def condition(self) -> str:
        """Reasons and, for a claim that holds under conditions, its parts: the column of the table."""
        parts = {"holds": self.holds, "holds in part": self.holds_in_part, "does not hold": self.does_not_hold}
        shown = parts if self.verdict == CONDITIONAL else {}
        return "; ".join([*self.reasons, *(f"{label}: {', '.join(words)}" for label, words in shown.items() if words)])


class Limits(dict[str, Any]):
    """Hold the numbers of one claim, and remember which decided: another is a mistake in the data file."""

    def __init__(self, claim: Claim) -> None:
        super().__init__(claim["limits"])
        self.claim, self.used = claim["id"], set[str]()

    def __getitem__(self, name: str) -> Any:
        self.used.add(name)
        return super().__getitem__(name)

    def __missing__(self, name: str) -> Any:
        raise InputError(f"claim {self.claim}: limits has no {name!r}, by which it is judged")


Judge = Callable[[Limits, Datasets], dict[str, Part]]


def by_id(*judges: Callable[..., Any]) -> dict[str, Any]:
    """Return functions by the identifiers in the data file, ``fig3-energy`` for ``fig3_energy``."""
    return {judge.__name__.replace("_", "-"): judge for judge in judges}


def combine(claim: Claim, parts: Mapping[str, Part], capped: bool) -> str:
    """Return the verdict on a claim from its parts; `capped` allows no more than `CONDITIONAL`."""
    needed = claim["needed"]
    names, count = (needed["of"], needed["count"]) if isinstance(needed, Mapping) else (needed, len(needed))
    if sum(parts[name].holds or bool(parts[name].where) for name in names) < count:
        return NOT_REPRODUCED
    return REPRODUCED if all(part.holds for part in parts.values()) and not capped else CONDITIONAL


def sorted_out(claim: Claim, parts: Mapping[str, Part]) -> dict[str, tuple[str, ...]]:
    """Return the words of the parts by the field of `Verdict` that they belong to."""
    words = claim["parts"]
    return {
        "holds": tuple(words[name] for name, part in parts.items() if part.holds),
        "holds_in_part": tuple(
            f"{words[name]} ({part.where})" for name, part in parts.items() if not part.holds and part.where
        ),
        "does_not_hold": tuple(words[name] for name, part in parts.items() if not part.holds and not part.where),
    }


def finding_of(claim: Claim, parts: Mapping[str, Part]) -> str:
    """Return the sentence of a claim's finding, its gaps filled from its parts and its limits.

    A gap that nothing fills, or a part's words that it does not use, raise `InputError`.
    """
    values = {name: words for part in parts.values() for name, words in part.finding.items()}
    gaps = {name for _, name, _, _ in string.Formatter().parse(claim["finding"]) if name is not None}
    limits = {name: value for name, value in claim["limits"].items() if name in gaps}
    if gaps != {*values, *limits}:
        problem = f"has the gaps {', '.join(sorted(gaps - {*limits}))}; they must be {', '.join(sorted(values))}"
        raise InputError(f"claim {claim['id']}: finding {problem}")
    return str(claim["finding"].format_map({**limits, **values}))


# --- cases ---------------------------------------------------------------------------------------------------------


def judged(
    held: xr.DataArray,
    measured: tuple[Measured, ...],
    noun: str,
    enough: float = 0.0,
    finding: Mapping[str, str] | None = None,
) -> Part:
    """Return the part that holds in the cases of `held` (boolean, one dimension with a coordinate).

    Where it fails in some of them but holds in at least the part `enough`, it says which. Without cases it fails.
    """
    cases = held.astype(bool)
    holds = bool(cases.size) and bool(cases.all())
    partly = not holds and bool(cases.any()) and float(cases.mean()) >= enough
    return Part(holds, measured, finding or {}, spans(cases, noun) if partly else "")


def spans(held: xr.DataArray, noun: str) -> str:
    """Say in which cases a condition holds: ``e 0.7 to 0.8, 0.95``, or ``none``."""
    values, true = held[held.dims[0]].values, np.flatnonzero(held.values.astype(bool))
    if not true.size:
        return "none"
    runs = np.split(true, np.flatnonzero(np.diff(true) > 1) + 1)
    if values.dtype.kind not in "fiu":
        return f"{noun} {', '.join(map(str, values[true]))}"
    ends = ((number(values[run[0]]), number(values[run[-1]])) for run in runs)
    return f"{noun} {', '.join(first if first == last else f'{first} to {last}' for first, last in ends)}"


def steady(values: xr.DataArray, dim: str, sign: int) -> xr.DataArray:
    """Return true where `values` change with that sign from each coordinate of `dim` to the next."""
    return (sign * values.sortby(dim).diff(dim) > 0).all(dim)


# --- words ---------------------------------------------------------------------------------------------------------


def number(value: Any) -> str:
    """Return three significant digits."""
    return f"{float(value):.3g}"


def percent(value: Any) -> str:
    """Return three significant digits, in percent."""
    return f"{100 * float(value):.3g}%"


def brief(value: Any) -> str:
    """Return two significant digits, in percent."""
    return f"{float(f'{100 * float(value):.2g}'):g}%"


def between(values: Any, words: Callable[[Any], str] = brief) -> str:
    """Return the least and the largest: ``37% to 43%``; ``none`` where there is no value."""
    if not np.size(values):
        return "none"
    low, high = words(np.min(values)), words(np.max(values))
    return low if low == high else f"{low} to {high}"


def words_by_model(values: xr.DataArray) -> dict[str, str]:
    """Return a value of each model by its name in lower case, for a finding."""
    models = [str(model).lower() for model in values["damping_model"].values]
    return {model: brief(value) for model, value in zip(models, values.values, strict=True)}


def per_model(values: xr.DataArray, words: Callable[[Any], str] = number) -> str:
    """Return values with the names of their models: ``CDC 1.2, CDR 3.4``."""
    models = [str(model) for model in values["damping_model"].values]
    return ", ".join(f"{model} {words(value)}" for model, value in zip(models, values.values, strict=True))


def listed(names: Iterable[str]) -> str:
    """Return names joined: ``CDC and SDR``, or ``none``."""
    return " and ".join(names) or "none"
