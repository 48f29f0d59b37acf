"""ECD of order m under earthquakes: the order from which on it errs less than restitution with a slightly changed e.

That change of e is smaller than any test could tell. Every order has the damping ratio that loses what an impact takes
(docs/theory.md, section 8): nothing is fitted. Differences are taken over the same histories, and bootstrapped over
stations: see `statistics.against_restitution`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.earthquakes import OrderComparisonSettings, OrderRecordSettings
from rockdamp.config.walls import NamedWall
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
    CHANGES_OF_E,
    HISTORIES,
    bootstrapped,
    fragilities,
    in_bands,
    of_pairs,
    root_mean_square,
)
from rockdamp.statistics.fragility import interval, resample

VARIATIONS = ("step", *CHANGES_OF_E)  # of CR: a step twice as long, and e a little lower and higher
EVERY_SET = "all"


def chunk(number: str, config: Config) -> xr.Dataset:
    """Run every wall under one job's share of the records, with CR, its small changes, and each order."""
    settings = OrderRecordSettings.of(config)
    size = settings.records_per_job
    mine = catalogue.listing(settings.records)[int(number) * size : (int(number) + 1) * size]
    shares = [_under(catalogue.read(entry), settings) for entry in track(mine, f"Orders, records {int(number) + 1}")]
    return xr.concat(shares, "record", join="exact")


def _under(motion: catalogue.GroundMotion, settings: OrderRecordSettings) -> xr.Dataset:
    """Run all histories of one record."""
    pgv = intensity_measures(motion.record).pgv
    per_wall = [_of_wall(named, motion, pgv, settings) for named in settings.walls]
    last = {"reference": (), "varied": ("variation",), "by_order": ("order",)}
    names = {
        "reference": ("reference_peak", "reference_collapsed"),
        "varied": ("varied_peak", "varied_collapsed"),
        "by_order": ("peak_ratio", "collapsed"),
    }
    data: dict[str, Any] = {}
    for key, (peak, collapsed) in names.items():
        dims = ("velocity_ratio", "wall", "restitution", *last[key])
        peaks, outcomes = (np.stack([wall[key][part] for wall in per_wall], axis=1) for part in (0, 1))
        data[peak], data[collapsed] = (dims, peaks), (dims, (outcomes == COLLAPSED).astype(np.int8))
    coords = {
        "velocity_ratio": settings.scale,
        "wall": [named.name for named in settings.walls],
        "restitution": settings.restitution,
        "variation": list(VARIATIONS),
        "order": settings.order,
        "record": motion.name,
    }
    of_record = {"record_set": ("record", [motion.record_set]), "station": ("record", [motion.group])}
    return xr.Dataset(data, coords=coords).expand_dims("record").assign_coords(of_record)


def _of_wall(
    named: NamedWall, motion: catalogue.GroundMotion, pgv: float, settings: OrderRecordSettings
) -> dict[str, tuple[Array, NDArray[np.int8]]]:
    """Return peaks and outcomes of one wall under one record: of CR (scales, e), its changes and the orders."""
    wall = named.wall
    factor = settings.scale * wall.frequency_parameter * wall.instability_displacement / EXCITATION_FACTOR / pgv
    forcing = Forcing.of(wall, motion.record, factor, rest=settings.tail)
    coarser = forcing.substeps(2 * settings.step / named.curve.initial_frequency)

    def run(damping: Damping, substeps: int) -> tuple[Array, NDArray[np.int8]]:
        by_scale = forcing.load_factor.reshape(-1, *(1 for _ in damping.shape))
        response = solve(named.curve, damping, **replace(forcing, load_factor=by_scale).newmark(substeps))
        return response.peak, response.outcome

    e, finer = settings.restitution, 2 * coarser
    # CR and CR with e changed are one batch: its lanes fill the kernel's blocks.
    changed = run(Damping.cr(e[:, None] + settings.restitution_change * np.array([0.0, -1.0, 1.0])), finer)
    coarse = run(Damping.cr(e), coarser)
    orders = [run(Damping.of_restitution(e, order=float(order)), finer) for order in settings.order]
    peaks, outcomes = (np.concatenate([coarse[part][..., None], changed[part][..., 1:]], axis=-1) for part in (0, 1))
    return {
        "reference": (changed[0][..., 0], changed[1][..., 0]),
        "varied": (peaks, outcomes),
        "by_order": (np.stack([peak for peak, _ in orders], -1), np.stack([outcome for _, outcome in orders], -1)),
    }


# --- comparison -------------------------------------------------------------------------------------------------------


def compare_orders(config: Config, *shares: xr.Dataset) -> xr.Dataset:
    """Compare each order with CR, and with CR's sensitivity to e, over all records, by set of records and by wall.

    The first set is all records. ``excess`` is log_error less CR's sensitivity, the smaller of those to a lower and a
    higher e, over the histories that stand with all of them. From ``smallest_order`` on the excess is negative, its
    interval included; ``recommended_order`` is the smallest that is enough at every e over all records.
    """
    settings = OrderComparisonSettings.of(config)
    histories = xr.concat(shares, "record", join="exact").transpose(*HISTORIES, "restitution", "variation", "order")
    sets = [EVERY_SET, *dict.fromkeys(histories["record_set"].values.tolist())]
    parts = []
    for name in track(sets, "Orders by set of records"):
        of_set = histories if name == EVERY_SET else histories.isel(record=histories["record_set"].values == name)
        weights = resample(of_set["station"].values, settings.bootstrap.replicates, settings.bootstrap.seed)
        parts.append(_compare_set(of_set, weights, settings.bands))
    compared = xr.concat(parts, "record_set", join="exact")
    return compared.assign_coords(
        record_set=sets,
        wall=histories["wall"].values,
        restitution=histories["restitution"].values,
        order=histories["order"].values,
        variation=list(VARIATIONS),
        bound=list(BOUND),
        band=np.arange(1, settings.bands.size),
        band_start=("band", settings.bands[:-1]),
        band_end=("band", settings.bands[1:]),
    ).assign(
        records=histories.sizes["record"],
        stations=np.unique(histories["station"]).size,
        restitution_change=settings.restitution_change,
        recommended_order=recommended_order(compared["smallest_order"].values[0]),
    )


def _compare_set(histories: xr.Dataset, weights: Array, bands: Array) -> xr.Dataset:
    """Return every statistic of one set of records."""
    orders = histories.rename(peak_ratio="peak").drop_dims("variation")
    varied = histories.drop_dims("order").rename(varied_peak="peak", varied_collapsed="collapsed")
    of_varied = _statistics(varied, weights, bands)
    statistics = _statistics(orders, weights, bands).assign({f"varied_{name}": of_varied[name] for name in of_varied})
    return statistics.merge(_excess(histories, weights))


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
    scale, walls, dims = histories["velocity_ratio"].values, histories.sizes["wall"], histories["collapsed"].dims[3:]
    ratio, bounds = np.empty(other.shape[3:]), np.empty((*other.shape[3:], 2))
    for e, alternative in np.ndindex(ratio.shape):
        both = np.stack([other[..., e, alternative].sum(axis=2), fell[..., e].sum(axis=2)], axis=1)
        fitted = fragilities(scale, both, walls, weights, (..., slice(1, 2)))
        ratio[e, alternative] = fitted["median_intensity_ratio"][0]
        bounds[e, alternative] = fitted["median_intensity_ratio_interval"][0]
    return xr.Dataset(
        {"median_intensity_ratio": (dims, ratio), "median_intensity_ratio_interval": ((*dims, "bound"), bounds)}
    )


def _excess(histories: xr.Dataset, weights: Array) -> xr.Dataset:
    """Return how much more each order errs than CR with e changed, where the wall stands with all; and by wall."""
    changes = histories.sel(variation=list(CHANGES_OF_E))
    peak, reference = histories["peak_ratio"].values, histories["reference_peak"].values
    changed = np.moveaxis(changes["varied_peak"].values, -1, 0)
    falls = histories["reference_collapsed"] + changes["varied_collapsed"].sum("variation") + histories["collapsed"]
    walls, shape = histories.sizes["wall"], peak.shape[3:]
    excess, bounds = np.empty((1 + walls, *shape)), np.empty((1 + walls, *shape, 2))  # all walls first
    for e, m in np.ndindex(shape):
        ratio = np.stack([peak[..., e, m], *changed[..., e]]) / reference[..., e]
        stand = falls.values[..., e, m] == 0
        square = np.where(stand, np.log(ratio) ** 2, 0.0)
        sums, counts = square.sum(axis=2), stand.sum(axis=1).astype(float)  # of each record and wall
        parts = [(sums.sum(axis=-1), counts.sum(axis=-1)), *((sums[..., i], counts[:, i]) for i in range(walls))]
        for row, (squares, count) in enumerate(parts):
            excess[row, e, m] = _over_sensitivity(squares, count, np.ones((1, count.size)))[0]
            bounds[row, e, m] = interval(_over_sensitivity(squares, count, weights))
    smallest = smallest_order(histories["order"].values, bounds[..., 1])
    by = ("restitution", "order")
    return xr.Dataset(
        {
            "excess": (by, excess[0]),
            "excess_interval": ((*by, "bound"), bounds[0]),
            "smallest_order": (by[:1], smallest[0]),
            "wall_excess": (("wall", *by), excess[1:]),
            "wall_excess_interval": (("wall", *by, "bound"), bounds[1:]),
            "wall_smallest_order": (("wall", *by[:1]), smallest[1:]),
        }
    )


def _over_sensitivity(sums: Array, counts: Array, weight: Array) -> Array:
    """Return the error of an order less the smaller one of CR with a lower and a higher e, in each replicate.

    `sums`, shape (3, records), are squares of the order, of the lower and of the higher e; `counts`, shape (records,),
    are the histories, the same for all three; `weight` has the shape (replicates, records).
    """
    order, lower, higher = root_mean_square(np.einsum("br,ar->ab", weight, sums), (weight @ counts)[None])
    return np.asarray(order - np.minimum(lower, higher))


def smallest_order(order: Array, upper: Array) -> Array:
    """Return the order from which on the excess's upper bound, shape (..., orders), is at most 0; NaN if none is."""
    within = np.nan_to_num(upper, nan=np.inf) <= 0
    onwards = np.logical_and.accumulate(within[..., ::-1], axis=-1)[..., ::-1]
    return np.where(onwards.any(axis=-1), order[onwards.argmax(axis=-1)], np.nan)


def recommended_order(smallest: Array) -> float:
    """Return the order that is enough at every e, from the smallest at each; NaN if some e has none.

    `rockdamp.vocabulary.RECOMMENDED_ORDER` is that of the full study.
    """
    return float(np.max(smallest))
