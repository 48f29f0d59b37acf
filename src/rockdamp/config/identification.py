"""Checks of the section `identification` that the schema cannot say: its distributions exist, and hold what may be."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from rockdamp.config import Config
from rockdamp.config.schema import KeyPath, Problem

# What every value between the two ends of a parameter's distribution must be.
ALLOWED: dict[str, tuple[Callable[[float, float], bool], str]] = {
    "cracked_stiffness_ratio": (lambda low, high: low > 0, "greater than 0"),
    "plateau_ratio": (lambda low, high: 0 < low and high < 1, "between 0 and 1"),
    "restitution": (lambda low, high: 0 < low and high <= 1, "greater than 0 and at most 1"),
    "damping_ratio": (lambda low, high: low >= 0, "at least 0"),
    "order": (lambda low, high: low >= 0, "at least 0"),
    "sensor_deviation": (lambda low, high: low > 0, "greater than 0"),
    "sensor_correlation": (lambda low, high: -1 < low and high < 1, "between -1 and 1"),
    "pulse_peak": (lambda low, high: low > 0, "greater than 0"),
}


def identification_problems(config: Config) -> Iterator[Problem]:
    """Every distribution has a lower and a higher end, both of them values that its parameter can have."""
    section: KeyPath = ("identification",)
    of_prior, simulated = config["identification"]["prior"], config["identification"]["simulated"]
    for path, entries in (((*section, "prior"), of_prior), ((*section, "simulated"), simulated)):
        for name, entry in entries.items():
            if name in ALLOWED:
                yield from _interval_problems((*path, name), entry, *ALLOWED[name])


def _interval_problems(
    path: KeyPath, entry: Config, possible: Callable[[float, float], bool], allowed: str
) -> Iterator[Problem]:
    low, high = entry["low"], entry["high"]
    if not low < high:
        yield Problem((*path, "high"), f"is {high}; it must be greater than low, {low}")
    if entry["distribution"] == "loguniform" and not low > 0:
        yield Problem((*path, "low"), f"is {low}; it must be greater than 0 for loguniform")
    elif not possible(low, high):
        yield Problem(path, f"is {low} to {high}; it must be {allowed}")
