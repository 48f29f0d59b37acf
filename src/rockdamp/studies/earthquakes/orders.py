"""ECD of order m under earthquakes, beside restitution and restitution with a changed e.

Every order has the damping ratio that loses what an impact takes (docs/theory.md, section 8): nothing is fitted.
Differences are taken over the same histories, and bootstrapped over stations: see `statistics.against_restitution`.
Which order is enough is judged in `order_criterion`.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.earthquakes import NamedWall
from rockdamp.histories.forcing import Forcing
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import EXCITATION_FACTOR
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.progress import track
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.response import COLLAPSED
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

VARIATIONS = ("step", *chain(*SIDES.values()))  # of CR: a step twice as long, and each change of e
EVERY_SET = "all"


def chunk(number: str, config: Config) -> xr.Dataset:
    """Run every wall under one job's share of the records, with CR, its small changes, and each order."""
    size = config.earthquakes.chunk
    mine = catalogue.listing(config.records)[int(number) * size : (int(number) + 1) * size]
    shares = [_under(catalogue.read(entry), config) for entry in track(mine, f"Orders, records {int(number) + 1}")]
    return xr.concat(shares, "record", join="exact")


def _under(motion: catalogue.GroundMotion, config: Config) -> xr.Dataset:
    """Run all histories of one record."""
    quakes = config.earthquakes
    orders = quakes.orders
    pgv = intensity_measures(motion.record).pgv
    per_wall = [_of_wall(named, motion, pgv, config) for named in quakes.walls]
    last = {"reference": (), "varied": ("variation",), "by_order": ("order",)}
    names = {
        "reference": ("reference_peak", "reference_collapsed"),
        "varied": ("varied_peak", "varied_collapsed"),
        "by_order": ("peak", "collapsed"),
    }
    data: dict[str, Any] = {}
    for key, (peak, collapsed) in names.items():
        dims = ("velocity_ratio", "wall", "restitution", *last[key])
        peaks, outcomes = (np.stack([wall[key][part] for wall in per_wall], axis=1) for part in (0, 1))
        data[peak], data[collapsed] = (dims, peaks), (dims, (outcomes == COLLAPSED).astype(np.int8))
    coords = {
        "velocity_ratio": quakes.velocity_ratio,
        "wall": [named.name for named in quakes.walls],
        "restitution": orders.restitution,
        "variation": list(VARIATIONS),
        "order": orders.order,
        "record": motion.name,
    }
    of_record = {"record_set": ("record", [motion.record_set]), "station": ("record", [motion.group])}
    return xr.Dataset(data, coords=coords).expand_dims("record").assign_coords(of_record)


def _of_wall(
    named: NamedWall, motion: catalogue.GroundMotion, pgv: float, config: Config
) -> dict[str, tuple[Array, NDArray[np.int8]]]:
    """Return peaks and outcomes of one wall under one record: of CR (scales, e), its changes and the orders."""
    quakes = config.earthquakes
    asked = quakes.orders
    wall = named.wall
    factor = quakes.velocity_ratio * wall.frequency_parameter * wall.instability_displacement / EXCITATION_FACTOR / pgv
    forcing = Forcing.of(wall, motion.record, factor, rest=quakes.tail)
    coarser = forcing.substeps(2 * asked.step / named.curve.initial_frequency)

    def run(damping: Damping, substeps: int) -> tuple[Array, NDArray[np.int8]]:
        by_scale = forcing.load_factor.reshape(-1, *(1 for _ in damping.shape))
        response = solve(
            named.curve, damping, peaks_only=True, **replace(forcing, load_factor=by_scale).newmark(substeps)
        )
        return response.peak, response.outcome

    e, finer = asked.restitution, 2 * coarser
    # CR and CR with e changed are one batch: its lanes fill the kernel's blocks.
    changes = quakes.restitution_change, asked.loss_change, asked.test_spread
    changed = run(Damping.cr(np.column_stack([e, order_criterion.changed(e, *changes)])), finer)
    coarse = run(Damping.cr(e), coarser)
    orders = [run(Damping.of_restitution(e, order=float(order)), finer) for order in asked.order]
    peaks, outcomes = (np.concatenate([coarse[part][..., None], changed[part][..., 1:]], axis=-1) for part in (0, 1))
    return {
        "reference": (changed[0][..., 0], changed[1][..., 0]),
        "varied": (peaks, outcomes),
        "by_order": (np.stack([peak for peak, _ in orders], -1), np.stack([outcome for _, outcome in orders], -1)),
    }


# --- comparison -------------------------------------------------------------------------------------------------------


def compare_orders(config: Config, *shares: xr.Dataset) -> xr.Dataset:
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
