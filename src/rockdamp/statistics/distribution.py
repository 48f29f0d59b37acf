"""Distributions between two bounds: of identified parameters."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rockdamp.arrays import Array
from rockdamp.errors import InputError, require

KINDS = ("uniform", "loguniform", "normal")


@dataclass(frozen=True)
class Distribution:
    """Distribution of values between the bounds `low` and `high`.

    It is ``uniform`` in the value, ``loguniform`` or ``normal``; a normal one is cut off at the bounds, and it alone
    has moments, those before it is cut off.
    """

    distribution: str
    low: float
    high: float
    mean: float | None = None
    standard_deviation: float | None = None

    def __post_init__(self) -> None:
        kind = self.distribution
        require(kind in KINDS, "distribution", kind, f"one of {', '.join(KINDS)}")
        for name in ("low", "high", "mean", "standard_deviation"):
            value = getattr(self, name)
            require(value is None or math.isfinite(value), name, value, "a finite number")
        require(kind != "loguniform" or self.low > 0, "low", self.low, "greater than 0 for loguniform")
        require(self.high > self.low, "high", self.high, f"greater than low, {self.low:g}")
        stated = [moment is not None for moment in (self.mean, self.standard_deviation)]
        if stated != [kind == "normal"] * 2:
            raise InputError(
                f"distribution is {kind!r}; mean and standard_deviation must be stated for normal, and for it alone"
            )
        deviation = self.standard_deviation
        require(deviation is None or deviation > 0, "standard_deviation", deviation, "greater than 0")

    def quantile(self, probability: ArrayLike) -> Array:
        """Return the value below which a random value lies with a probability between 0 and 1."""
        p = np.asarray(probability, dtype=float)
        if self.distribution == "uniform":
            return self.low + (self.high - self.low) * p
        if self.distribution == "loguniform":
            return np.asarray(self.low * (self.high / self.low) ** p)
        from scipy import stats  # takes long to import, and most distributions need none of it

        return np.asarray(stats.truncnorm.ppf(p, *self._standard_bounds, loc=self.mean, scale=self.standard_deviation))

    def probability(self, value: ArrayLike) -> Array:
        """Return the probability that a random value is below `value`: the inverse of `quantile`."""
        x = np.clip(np.asarray(value, dtype=float), self.low, self.high)
        if self.distribution == "uniform":
            return (x - self.low) / (self.high - self.low)
        if self.distribution == "loguniform":
            return np.log(x / self.low) / np.log(self.high / self.low)
        from scipy import stats

        return np.asarray(stats.truncnorm.cdf(x, *self._standard_bounds, loc=self.mean, scale=self.standard_deviation))

    @property
    def _standard_bounds(self) -> tuple[float, float]:
        """Return the bounds in standard deviations from the mean, as SciPy's truncnorm takes them."""
        assert self.mean is not None and self.standard_deviation is not None
        return (self.low - self.mean) / self.standard_deviation, (self.high - self.mean) / self.standard_deviation
