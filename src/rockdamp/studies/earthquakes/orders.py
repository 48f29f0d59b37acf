"""ECD of order m under earthquakes, beside restitution and restitution with a changed e.

Every order has the damping ratio that loses what an impact takes (docs/theory.md, section 8): nothing is fitted.
Differences are taken over the same histories, and bootstrapped over stations: see `statistics.against_restitution`.
Which order is enough is judged in `order_criterion`.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import numpy as np
import xarray as xr

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
)
from rockdamp.statistics.fragility import resample
from rockdamp.studies.earthquakes import order_criterion
from rockdamp.studies.earthquakes.order_criterion import MEASURES, SIDES, Sums
from rockdamp.vocabulary import REFERENCE

VARIATIONS = ("step", *chain(*SIDES.values()))  # of CR: a step twice as long, and each change of e
EVERY_SET = "all"


def chunk(number: str, config: Config) -> xr.Dataset:
    """Run every wall under one job's share of the records, with CR, its small changes, and each order."""
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
    each_e = np.column_stack([e, order_criterion.changed(e, *changes)])
    changed = run({REFERENCE: Damping.cr(each_e)}, ["restitution", "variation"], 1, "restitution").isel(damping_model=0)
    coarse = run({REFERENCE: Damping.cr(e)}, ["restitution"], 0, "twice the step")
    orders = {f"{m:g}": Damping.of_restitution(e, order=float(m)) for m in asked.order}
    by_order = run(orders, ["restitution"], 1, "orders").rename(damping_model="order")
    reference = changed.isel(variation=0)
    varied = xr.concat([coarse.isel(damping_model=0), changed.isel(variation=slice(1, None))], "variation")
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


def compare_orders(config: Config, shares: Sequence[xr.Dataset]) -> xr.Dataset:
    """Compare each order with CR, and with CR after each change of e, over all records, by set of records and by wall.

    The first set is all records. ``excess`` is how much more an order errs than CR with the change, and ``verdict``
    says whether that is enough. ``recommended_order`` is the smallest that is enough at every e over all records.
    """
    bootstrap = config.comparison.bootstrap
    quakes = config.earthquakes
    orders = quakes.orders
    histories = xr.concat(shares, "record", join="exact").transpose(*HISTORIES, "restitution", "variation", "order")
    sets = [EVERY_SET, *dict.fromkeys(histories["record_set"].values.tolist())]
    parts = []
    for name in track(sets, "Orders by set of records"):
        of_set = histories if name == EVERY_SET else histories.isel(record=histories["record_set"].values == name)
        weights = resample(of_set["station"].values, bootstrap.replicates, bootstrap.seed)
        parts.append(_compare_set(of_set, weights, config.comparison.bands))
    compared = xr.concat(parts, "record_set", join="exact").merge(_splits(histories, config))
    return compared.assign_coords(
        record_set=sets,
        wall=histories["wall"].values,
        restitution=histories["restitution"].values,
        order=histories["order"].values,
        variation=list(VARIATIONS),
        change=list(SIDES),
        measure=list(MEASURES),
        split=np.arange(compared.sizes["split"]),
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
        recommended_order=("change", order_criterion.recommended_order(compared["smallest_order"].values[0])),
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
    excess, bounds, verdict = order_criterion.judge(Sums.of(histories, change), weights)
    smallest = order_criterion.smallest_order(histories["order"].values, verdict)
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


def _splits(histories: xr.Dataset, config: Config) -> xr.Dataset:
    """Choose and judge on different halves of the stations, beside each change of e."""
    order, station, halves = histories["order"].values, histories["station"].values, config.comparison.splits
    parts = [
        order_criterion.split(
            Sums.of(histories, change),
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
