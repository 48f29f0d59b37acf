"""Where the minimum of Err is looked for before it is refined."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Scan:
    """Damping ratios tried, in a geometric sequence.

    Parameters
    ----------
    smallest, largest : float
        Over the closed form's damping ratio. [-]
    points : int
        How many are tried.
    """

    smallest: float
    largest: float
    points: int
