"""Judge whether an order of ECD is enough: it departs from restitution by no more than another loss does.

An order and CR with a changed e stand beside CR in the same histories. Three numbers are compared, each as a difference
in the same bootstrap replicates: the error of the peaks, and the rates of false safe and of false collapse. A change of
e has two sides. Of the errors the smaller one counts. A larger loss misses collapses and a smaller one adds them, so
each rate is compared with the side that causes it. docs/earthquakes.md states the rule, and that it came first.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.statistics.against_restitution import quotient, root_mean_square
from rockdamp.statistics.fragility import interval, resample

# By the name of a change of e: the side that loses more, and the side that loses less.
SIDES = {"e": ("lower e", "higher e"), "loss": ("more loss", "less loss"), "tests": ("low test", "high test")}
MEASURES = ("log_error", "false_safe_rate", "false_collapse_rate")
ENOUGH, UNDECIDED, EXCEEDS = 1, 0, -1  # verdicts on an order


def changed(e: Array, restitution_change: float, loss_change: float, test_spread: float) -> Array:
    """Return e after each change, in the order of `SIDES`, shape (e, 6). [-]"""
    sides = np.array([1.0, -1.0])
    by_e = e[:, None] - restitution_change * sides
    by_loss = e[:, None] ** (1 + loss_change * sides)  # delta = -ln e times 1 -+ the change
    by_test = e[:, None] * np.exp(-test_spread * sides)
    return np.concatenate([by_e, by_loss, by_test], axis=1)


@dataclass(frozen=True)
class Sums:
    """Sums over the histories of each record, of all walls together and then of each wall.

    `squares` of ln r: shape (3, records, 1 + walls, e, orders), of the order and of CR with more and with less loss.
    `stand` counts the histories that stand with all three, shape (records, 1 + walls, e, orders). `wrong` counts the
    false answers of the order and of CR with the side that causes them, and `cases` the histories that could have one;
    shape (2, records, 1 + walls, e, orders) for `cases`: first false safe, then false collapse.
    """

    squares: Array
    stand: Array
    wrong: Array
    wrong_of_change: Array
    cases: Array

    @classmethod
    def of(cls, histories: xr.Dataset, change: str) -> Sums:
        """Sum histories of the dimensions (record, velocity_ratio, wall, restitution, ...)."""
        sides = histories.sel(variation=list(SIDES[change]))
        reference, fell = (histories[f"reference_{name}"].values[..., None] for name in ("peak", "collapsed"))
        peak, falls = histories["peak"].values, histories["collapsed"].values == 1
        side_peak, side_falls = (np.moveaxis(sides[f"varied_{name}"].values, -1, 0) for name in ("peak", "collapsed"))
        fell, (more_falls, less_falls) = fell == 1, (side_falls == 1)[..., None]
        stand = ~(fell | falls | more_falls | less_falls)
        compared = (peak, *(np.broadcast_to(side[..., None], peak.shape) for side in side_peak))
        squares = [np.where(stand, np.log(each / reference) ** 2, 0.0) for each in compared]
        every = np.ones_like(falls)
        return cls(
            squares=np.stack([_by_record(each) for each in squares]),
            stand=_by_record(stand),
            wrong=np.stack([_by_record(fell & ~falls), _by_record(~fell & falls)]),
            wrong_of_change=np.stack([_by_record(every & fell & ~more_falls), _by_record(every & ~fell & less_falls)]),
            cases=np.stack([_by_record(every & fell), _by_record(every & ~fell)]),
        )

    def part(self, record: NDArray[np.bool_], row: slice) -> Sums:
        """Return the sums of some records and rows: row 0 is all walls together."""
        values = (getattr(self, each.name) for each in fields(self))
        return Sums(*(value[..., record, :, :, :][..., row, :, :] for value in values))

    def excess(self, weights: Array) -> Array:
        """Return how much more an order errs than CR with the change, shape (measures, replicates, 1 + walls, ...)."""

        def drawn(values: Array) -> Array:
            return np.asarray(np.tensordot(weights, values, 1))

        stand = drawn(self.stand)
        order, more, less = (root_mean_square(drawn(each), stand) for each in self.squares)
        rates = [
            quotient(drawn(wrong) - drawn(by_change), drawn(cases))
            for wrong, by_change, cases in zip(self.wrong, self.wrong_of_change, self.cases, strict=True)
        ]
        return np.stack([order - np.minimum(more, less), *rates])


def _by_record(values: NDArray[np.generic]) -> Array:
    """Sum over the velocity ratios, of all walls and then of each wall; shape (records, 1 + walls, ...)."""
    by_wall = values.astype(float).sum(axis=1)
    return np.concatenate([by_wall.sum(axis=1, keepdims=True), by_wall], axis=1)


def judge(sums: Sums, weights: Array) -> tuple[Array, Array, NDArray[np.int8]]:
    """Return excess (measures, ...), its interval (measures, ..., 2), and the verdict on each order (...)."""
    excess = sums.excess(np.ones((1, weights.shape[1])))[:, 0]
    bounds = np.stack([interval(drawn) for drawn in sums.excess(weights)])
    return excess, bounds, verdict(bounds)


def verdict(bounds: Array) -> NDArray[np.int8]:
    """Return `ENOUGH` where no interval (measures, ..., 2) reaches above 0, `EXCEEDS` where one lies above."""
    enough, exceeds = (bounds[..., 1] <= 0).all(axis=0), (bounds[..., 0] > 0).any(axis=0)
    return np.select([enough, exceeds], [ENOUGH, EXCEEDS], UNDECIDED).astype(np.int8)


def smallest_order(order: Array, judged: NDArray[np.int8]) -> Array:
    """Return the order from which on all are enough, from verdicts of shape (..., orders); NaN if none is."""
    onwards = np.logical_and.accumulate((judged == ENOUGH)[..., ::-1], axis=-1)[..., ::-1]
    return np.where(onwards.any(axis=-1), order[onwards.argmax(axis=-1)], np.nan)


def recommended_order(smallest: Array) -> Array:
    """Return the order that is enough at every e, the last axis, from the smallest at each; NaN if some e has none.

    `rockdamp.vocabulary.RECOMMENDED_ORDER` is that of the full study.
    """
    return np.asarray(np.max(smallest, axis=-1))


def split(sums: Sums, order: Array, station: NDArray[np.generic], count: int, replicates: int, seed: int) -> xr.Dataset:
    """Choose an order on one half of the stations and judge all on the other, `count` times, all walls together.

    ``split_order`` is the one chosen, NaN where none is enough at every e. ``split_verdict`` is the worst over e of the
    other half's verdicts on each order. One station alone has no halves: no order is chosen, and all are undecided.
    """
    names, of_record = np.unique(station, return_inverse=True)
    random = np.random.default_rng(seed)
    chosen, judged = np.full(count, np.nan), np.full((count, order.size), UNDECIDED, dtype=np.int8)
    for i in range(count if names.size > 1 else 0):
        first = np.isin(of_record, random.permutation(names.size)[: names.size // 2])
        verdicts = []
        for half in (first, ~first):
            weights = resample(station[half], replicates, int(random.integers(2**32)))
            verdicts.append(judge(sums.part(half, slice(1)), weights)[2][0])
        chosen[i] = recommended_order(smallest_order(order, verdicts[0]))
        judged[i] = verdicts[1].min(axis=0)
    return xr.Dataset({"split_order": ("split", chosen), "split_verdict": (("split", "order"), judged)})
