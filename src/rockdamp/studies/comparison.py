"""Compare every damper with restitution under earthquakes, and restitution with small changes of itself.

Every statistic has a bootstrap interval over the stations of the records: see `statistics.paired`.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.constants import REFERENCE
from rockdamp.progress import track
from rockdamp.statistics.fragility import interval, resample
from rockdamp.statistics.paired import (
    BOUND,
    NOT_RUN,
    compare_fragilities,
    compare_pairs,
    quotient,
    root_mean_square,
)

SHARES = (0.5, 0.9, 0.99, 1.0)
BY_DAMPER = ("restitution", "damping_model", "damping_ratio_source")


def compare_dampers(config: Config, earthquakes: xr.Dataset) -> xr.Dataset:
    """Compare every damper, and CR with small changes, with CR, over all records and walls.

    A source of damping ratios that has none for some wall is compared on the others, beside CR on these too: ``pooled``
    tells which. CR with small changes is on every wall that has a ratio.

    The statistics are those of `paired.compare_pairs`, by band of CR's peak, where the first band is all of
    them. Those of CR with small changes begin with ``varied_``. ``excess`` is how much more a damper errs
    than the one of least error at that e, over the histories that survive with both.
    """
    bootstrap = config.comparison.bootstrap
    weights = resample(earthquakes["station"].values, bootstrap.replicates, bootstrap.seed)
    edges = np.array(config.comparison.bands)
    bands = [(edges[0], edges[-1]), *pairwise(edges)]
    has_ratio = _mark_pooled(earthquakes)
    some = has_ratio.any("damping_ratio_source").values
    pooled, taken = earthquakes.isel(wall=some), has_ratio.isel(wall=some)
    pooled = pooled.assign(collapsed=pooled["collapsed"].where(taken | (pooled["damping_model"] == REFERENCE), NOT_RUN))
    varied = compare_pairs(_pair_with_cr(pooled, "varied_peak", "varied_collapsed"), weights, bands, "Changes of CR")
    kept = [name for statistic in ("median_ratio", "log_error") for name in (statistic, f"{statistic}_interval")]
    statistics = xr.merge(
        [
            compare_pairs(_pair_with_cr(pooled, "peak", "collapsed"), weights, bands, "Dampers"),
            varied[kept].rename({name: f"varied_{name}" for name in kept}),
            _excess(pooled, edges, weights, covers_most(has_ratio).values),
            _pooled_fragility(pooled.assign(collapsed=pooled["collapsed"].where(taken, NOT_RUN)), weights),
            _wall_fragilities(earthquakes, weights),
        ],
        join="exact",
    )
    # Each history once: what CR has for one source it has for all.
    source = earthquakes["damping_ratio_source"]
    each = (source == source[0]) | (earthquakes["damping_model"] != REFERENCE)
    converged = earthquakes["converged"].where(each & (earthquakes["converged"] >= 0))
    return statistics.assign(
        converged_share=converged.mean(),
        records=earthquakes.sizes["record"],
        stations=np.unique(earthquakes["station"]).size,
        pooled=has_ratio.astype(np.int8),
        relative_uncertainty=("share", _uncertainty(earthquakes[["peak", "peak_uncertainty"]].where(each))),
    ).assign_coords(
        {name: earthquakes[name].values for name in (*BY_DAMPER, "variation", "wall", "velocity_ratio")}
        | {
            "bound": list(BOUND),
            "share": list(SHARES),
            "band": np.arange(edges.size),
            "band_start": ("band", [low for low, _ in bands]),
            "band_end": ("band", [high for _, high in bands]),
        }
    )


def _mark_pooled(earthquakes: xr.Dataset) -> xr.DataArray:
    """Return, by wall and source, where every damper has a ratio at every e; true everywhere if that is nowhere."""
    defined = earthquakes["damping_ratio"].notnull().sel(damping_model=earthquakes["damping_model"] != REFERENCE)
    everywhere = defined.all(("restitution", "damping_model")).transpose("wall", "damping_ratio_source")
    return (everywhere if everywhere.any() else xr.ones_like(everywhere)).reset_coords(drop=True)


def covers_most(pooled: xr.DataArray) -> xr.DataArray:
    """Return the sources that have as many walls as any: among these errors are of the same walls, and are ranked."""
    walls = (pooled == 1).sum("wall")
    return walls == walls.max()


def _uncertainty(earthquakes: xr.Dataset) -> Array:
    """Return fractiles of the bound of the peaks' error, as a fraction of the peak."""
    bound = (earthquakes["peak_uncertainty"] / earthquakes["peak"]).values
    known = bound[np.isfinite(bound)]
    return np.quantile(known, SHARES) if known.size else np.full(len(SHARES), np.nan)


def _pair_with_cr(earthquakes: xr.Dataset, peak: str, collapsed: str) -> xr.Dataset:
    """Select alternatives by the names of their peak and collapse, beside CR."""
    # CR has no damping ratio: what it has for one source it has for all.
    cr = earthquakes.sel(damping_model=REFERENCE).isel(damping_ratio_source=0)
    return xr.Dataset(
        {
            "reference_peak": cr["peak"].variable,
            "reference_collapsed": cr["collapsed"].variable,
            "peak": earthquakes[peak].variable,
            "collapsed": earthquakes[collapsed].variable,
        }
    )


def _cr(earthquakes: xr.Dataset) -> int:
    """Return the index of CR among the damping models."""
    return int(earthquakes["damping_model"].values.tolist().index(REFERENCE))


def _excess(earthquakes: xr.Dataset, edges: Array, weights: Array, ranked: NDArray[np.bool_]) -> xr.Dataset:
    """Return how much more each damper errs than the one of least error at its e, where the wall survives with both.

    Both errors are of the same histories in the same replicate, so that what is common to all dampers cancels. The
    least is that of the sources `ranked`.
    """
    stored = earthquakes.transpose("record", "velocity_ratio", "wall", *BY_DAMPER, ...)
    cr = _cr(earthquakes)
    excess, bounds = [], []
    for e in range(stored.sizes["restitution"]):
        peak, collapsed = (stored[name].isel(restitution=e).values for name in ("peak", "collapsed"))
        reference, fell = (values[..., cr : cr + 1, :1] for values in (peak, collapsed))
        stand = (collapsed == 0) & (fell == 0) & (reference >= edges[0]) & (reference < edges[-1])
        square = np.log(np.where(stand, peak / reference, 1.0)) ** 2
        error = root_mean_square(square.sum(axis=(0, 1, 2)), stand.sum(axis=(0, 1, 2)))
        error[cr] = np.nan
        candidates = np.where(ranked & np.isfinite(error), error, np.inf)
        least: Any = (..., *np.unravel_index(np.argmin(candidates), error.shape), None, None)
        both = stand & stand[least]
        # By record: the squares of each damper, of the best one over the same histories, and the count of these.
        sums, least_sums, runs = (np.where(both, each, 0.0).sum(axis=(1, 2)) for each in (square, square[least], both))
        whole, drawn = (
            root_mean_square(own, count) - root_mean_square(of_least, count)
            for own, of_least, count in (
                [np.tensordot(weight, each, 1) for each in (sums, least_sums, runs)]
                for weight in (np.ones((1, len(both))), weights)
            )
        )
        excess.append(np.where(np.isfinite(error), whole[0], np.nan))
        bounds.append(np.where(np.isfinite(error)[..., None], interval(drawn), np.nan))
    return xr.Dataset({"excess": (BY_DAMPER, excess), "excess_interval": ((*BY_DAMPER, "bound"), bounds)})


# --- collapse ---------------------------------------------------------------------------------------------------------


def _fragility(scale: Array, collapses: NDArray[Any], runs: NDArray[Any], weights: Array, cr: int) -> xr.Dataset:
    """Fit counts (record, restitution, damping model, source, scale), and divide the medians by CR's."""
    fitted = compare_fragilities(scale, collapses, runs, weights, (..., slice(cr, cr + 1), slice(None)))
    dims = {name: (*BY_DAMPER, "bound") if name.endswith("_interval") else BY_DAMPER for name in fitted}
    statistics = xr.Dataset({name: (dims[name], values) for name, values in fitted.items()})
    return statistics.rename(median="median_velocity_ratio", median_interval="median_velocity_ratio_interval")


def _pooled_fragility(pooled: xr.Dataset, weights: Array) -> xr.Dataset:
    """Fit the fragilities of all walls together."""
    stored = pooled["collapsed"].transpose("record", *BY_DAMPER, "velocity_ratio", "wall").values
    counts = (stored == 1).sum(axis=-1), (stored >= 0).sum(axis=-1)
    return _fragility(pooled["velocity_ratio"].values, *counts, weights, _cr(pooled))


def _wall_fragilities(earthquakes: xr.Dataset, weights: Array) -> xr.Dataset:
    """Return each wall's fragility, and the share of records that collapse it."""
    order = ("record", "wall", *BY_DAMPER, "velocity_ratio")
    stored = earthquakes["collapsed"].transpose(*order).values
    run, collapsed = (stored >= 0).astype(float), (stored == 1).astype(float)
    scale, cr = earthquakes["velocity_ratio"].values, _cr(earthquakes)
    by_wall = [
        _fragility(scale, collapsed[:, wall], run[:, wall], weights, cr)
        for wall in track(range(earthquakes.sizes["wall"]), "Fragilities of the walls")
    ]
    fragility = xr.concat(by_wall, "wall").drop_vars(["median_intensity_ratio", "median_intensity_ratio_interval"])
    share = quotient(collapsed.sum(axis=0), run.sum(axis=0))
    return fragility.rename({name: f"wall_{name}" for name in fragility}).assign(collapse_fraction=(order[1:], share))
