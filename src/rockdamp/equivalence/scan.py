"""Damping ratios among which the minimum of Err is looked for before it is refined."""

from __future__ import annotations

from dataclasses import dataclass

from rockdamp.errors import require


@dataclass(frozen=True)
class Scan:
    """Damping ratios tried, in a geometric sequence."""

    smallest: float  # over the closed form's damping ratio [-]
    largest: float
    points: int

    def __post_init__(self) -> None:
        require(self.smallest < self.largest, "largest", self.largest, f"greater than smallest, {self.smallest:g}")
