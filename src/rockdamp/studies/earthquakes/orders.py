"""ECD of order m under earthquakes, beside restitution and restitution with a changed e.

Every order has the damping ratio that loses what an impact takes (docs/theory.md, section 7): nothing is fitted.
Differences are taken over the same histories, and bootstrapped over stations: see `statistics.against_restitution`.

An order is enough if it departs from restitution by no more than another loss does. An order and CR with a changed e
are compared with CR in the same histories. Three numbers are compared, each as a difference in the same bootstrap
replicates: the error of the peaks, and the rates of collapses missed and added. A change of e has two sides. Of
the errors the smaller one counts. A larger loss misses collapses and a smaller one adds them, so each rate is compared
with the side that causes it. docs/earthquakes.md states the rule, and that it came first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from itertools import chain

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.histories.loads import under_records
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.progress import track
from rockdamp.statistics.against_restitution import (
    BOUND,
    HISTORIES,
    bootstrapped,
    fragilities,
    in_bands,
    of_pairs,
    quotient,
    root_mean_square,
)
from rockdamp.statistics.fragility import interval, resample
from rockdamp.vocabulary import REFERENCE

SIDES = {"e": ("lower e", "higher e"), "loss": ("more loss", "less loss"), "tests": ("low test", "high test")}
MEASURES = ("log_error", "false_safe_rate", "false_collapse_rate")
ENOUGH, UNDECIDED, EXCEEDS = 1, 0, -1  # verdicts on an order
VARIATIONS = ("step", *chain(*SIDES.values()))  # of CR: a step twice as long, and each change of e
EVERY_SET = "all"
DRAWINGS = 12  # of the bootstrap, each with a seed of its own: how far a verdict depends on it


def chunk(number: str, config: Config) -> xr.Dataset:
    """Run every wall under one job's chunk of the records, with CR, its small changes, and each order."""
    quakes = config.earthquakes
    size, asked, e = quakes.chunk, quakes.orders, quakes.orders.restitution
    entries = catalogue.listing(config.records)[int(number) * size : (int(number) + 1) * size]
    motions = [catalogue.read(entry) for entry in entries]
    walls = {named.name: (named.wall, named.curve) for named in quakes.walls}

    def run(dampings: dict[str, Damping], dims: list[str], halvings: int, what: str) -> xr.Dataset:
        some = track(motions, f"Orders, records {int(number) + 1}, {what}")
        step, tail = 2 * asked.step, quakes.tail
        return under_records(
            some, walls, dampings, quakes.velocity_ratio, step=step, tail=tail, halvings=halvings, dims=dims
        )

    # CR and CR with e changed are one batch: its lanes fill the kernel's blocks.
    changes = quakes.restitution_change, asked.loss_change, asked.test_spread
    each_e = np.column_stack([e, changed(e, *changes)])
    runs = run({REFERENCE: Damping.cr(each_e)}, ["restitution", "variation"], 1, "restitution").isel(damping_model=0)
    coarse = run({REFERENCE: Damping.cr(e)}, ["restitution"], 0, "twice the step")
    orders = {f"{m:g}": Damping.of_restitution(e, order=float(m)) for m in asked.order}
    by_order = run(orders, ["restitution"], 1, "orders").rename(damping_model="order")
    reference = runs.isel(variation=0)
    varied = xr.concat([coarse.isel(damping_model=0), runs.isel(variation=slice(1, None))], "variation")
    parts = [
        by_order.transpose(..., "order").assign_coords(order=asked.order),
        reference.rename(peak="reference_peak", collapsed="reference_collapsed").drop_vars("damping_model"),
        varied.transpose(..., "variation")
        .rename(peak="varied_peak", collapsed="varied_collapsed")
        .drop_vars("damping_model")
        .assign_coords(variation=list(VARIATIONS)),
    ]
    return xr.merge(parts, join="exact", compat="equals").assign_coords(restitution=e)


# --- comparison -------------------------------------------------------------------------------------------------------


def compare_orders(config: Config, chunks: Sequence[xr.Dataset]) -> xr.Dataset:
    """Compare each order with CR, and with CR after each change of e, over all records, by set of records and by wall.

    The first set is all records. ``excess`` is how much more an order errs than CR with the change, and ``verdict``
    says whether that is enough. ``recommended_order`` is the smallest that is enough at every e over all records. The
    verdicts over all records are drawn again with other seeds of the bootstrap, ``drawn_``.
    """
    bootstrap = config.comparison.bootstrap
    quakes = config.earthquakes
    orders = quakes.orders
    histories = xr.concat(chunks, "record", join="exact").transpose(*HISTORIES, "restitution", "variation", "order")
    sets = [EVERY_SET, *dict.fromkeys(histories["record_set"].values.tolist())]
    parts = []
    for name in track(sets, "Orders by set of records"):
        of_set = histories if name == EVERY_SET else histories.isel(record=histories["record_set"].values == name)
        weights = resample(of_set["station"].values, bootstrap.replicates, bootstrap.seed)
        parts.append(_compare_set(of_set, weights, config.comparison.bands))
    compared = xr.concat(parts, "record_set", join="exact").merge(_splits(histories, config))
    compared = compared.merge(_drawings(histories, config))
    return compared.assign_coords(
        record_set=sets,
        wall=histories["wall"].values,
        restitution=histories["restitution"].values,
        order=histories["order"].values,
        variation=list(VARIATIONS),
        change=list(SIDES),
        measure=list(MEASURES),
        split=np.arange(compared.sizes["split"]),
        drawing=np.arange(DRAWINGS),
        bound=list(BOUND),
        band=np.arange(1, config.comparison.bands.size),
        band_start=("band", config.comparison.bands[:-1]),
        band_end=("band", config.comparison.bands[1:]),
    ).assign(
        records=histories.sizes["record"],
        stations=np.unique(histories["station"]).size,
        restitution_change=quakes.restitution_change,
        loss_change=orders.loss_change,
        test_spread=orders.test_spread,
        recommended_order=("change", recommended_order(compared["smallest_order"].values[0])),
    )


def _compare_set(histories: xr.Dataset, weights: Array, bands: Array) -> xr.Dataset:
    """Return every statistic of one set of records."""
    orders = histories.rename(peak="peak").drop_dims("variation")
    varied = histories.drop_dims("order").rename(varied_peak="peak", varied_collapsed="collapsed")
    of_varied = _statistics(varied, weights, bands)
    statistics = _statistics(orders, weights, bands).assign({f"varied_{name}": of_varied[name] for name in of_varied})
    judged = [_judged(histories, change, weights) for change in SIDES]
    return statistics.merge(xr.concat(judged, "change", join="exact"))


def _judged(histories: xr.Dataset, change: str, weights: Array) -> xr.Dataset:
    """Judge every order beside one change of e, over all walls together and by wall."""
    by = ("restitution", "order")
    excess, bounds, verdict = judge(Sums.from_histories(histories, change), weights)
    smallest = smallest_order(histories["order"].values, verdict)
    return xr.Dataset(
        {
            "excess": (("measure", *by), excess[:, 0]),
            "excess_interval": (("measure", *by, "bound"), bounds[:, 0]),
            "verdict": (by, verdict[0]),
            "smallest_order": (by[:1], smallest[0]),
            "wall_excess": (("measure", "wall", *by), excess[:, 1:]),
            "wall_excess_interval": (("measure", "wall", *by, "bound"), bounds[:, 1:]),
            "wall_verdict": (("wall", *by), verdict[1:]),
            "wall_smallest_order": (("wall", *by[:1]), smallest[1:]),
        }
    )


def _drawings(histories: xr.Dataset, config: Config) -> xr.Dataset:
    """Judge every order with other seeds of the bootstrap: all walls together, and for how many walls it is enough."""
    bootstrap, station = config.comparison.bootstrap, histories["station"].values
    seeds = np.random.SeedSequence(bootstrap.seed).generate_state(DRAWINGS).tolist()
    weights = [resample(station, bootstrap.replicates, seed) for seed in seeds]
    by = ("change", "drawing", "restitution", "order")
    drawn = np.stack(
        [
            [judge(sums, of_drawing)[2] for of_drawing in weights]
            for sums in (
                Sums.from_histories(histories, change)
                for change in track(list(SIDES), "Orders by seed of the bootstrap")
            )
        ]
    )
    return xr.Dataset(
        {"drawn_verdict": (by, drawn[:, :, 0]), "drawn_wall_count": (by, (drawn[:, :, 1:] == ENOUGH).sum(axis=2))}
    )


def _splits(histories: xr.Dataset, config: Config) -> xr.Dataset:
    """Choose and judge on different halves of the stations, beside each change of e."""
    order, station, halves = histories["order"].values, histories["station"].values, config.comparison.splits
    parts = [
        split(
            Sums.from_histories(histories, change),
            order,
            station,
            halves.count,
            config.comparison.bootstrap.replicates,
            halves.seed,
        )
        for change in track(list(SIDES), "Orders by halves of the stations")
    ]
    return xr.concat(parts, "change", join="exact")


def _statistics(histories: xr.Dataset, weights: Array, bands: Array) -> xr.Dataset:
    """Return statistics of the alternatives to CR, which are the last dimension."""
    statistics = bootstrapped(histories, weights).isel(band=0).drop_vars(["false_safe", "false_collapse"])
    reference, peak = histories["reference_peak"], histories["peak"]
    stand = (histories["reference_collapsed"] == 0) & (histories["collapsed"] == 0)
    by_band = of_pairs(in_bands((peak / reference).where(stand), reference, bands), HISTORIES)
    return statistics.merge(_intensity_ratio(histories, weights)).assign(
        band_log_error=by_band["log_error"].transpose(..., "band")
    )


def _intensity_ratio(histories: xr.Dataset, weights: Array) -> xr.Dataset:
    """Return the ratio of the median intensity of collapse to CR's, all walls together."""
    fell, other = (histories[name].values == 1 for name in ("reference_collapsed", "collapsed"))
    both = np.concatenate([fell[..., None], other], axis=-1).sum(axis=2)  # (record, scale, e, CR and alternatives)
    fitted = fragilities(
        histories["velocity_ratio"].values,
        np.moveaxis(both, 1, -1),
        histories.sizes["wall"],
        weights,
        (..., slice(0, 1)),
    )
    dims = histories["collapsed"].dims[3:]
    ratio, bounds = (fitted[f"median_intensity_ratio{end}"][:, 1:] for end in ("", "_interval"))
    return xr.Dataset(
        {"median_intensity_ratio": (dims, ratio), "median_intensity_ratio_interval": ((*dims, "bound"), bounds)}
    )


# By the name of a change of e: the side that loses more, and the side that loses less.


# --- the criterion ----------------------------------------------------------------------------------------------------


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
    `stand` counts the histories that survive with all three, shape (records, 1 + walls, e, orders). `wrong` counts the
    false answers of the order and of CR with the side that causes them, and `cases` the histories that could have one;
    shape (2, records, 1 + walls, e, orders) for `cases`: first collapses missed, then added.
    """

    squares: Array
    stand: Array
    wrong: Array
    wrong_of_change: Array
    cases: Array

    @classmethod
    def from_histories(cls, histories: xr.Dataset, change: str) -> Sums:
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
