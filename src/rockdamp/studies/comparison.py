"""Compare every damper with restitution under earthquakes, and restitution with small changes of itself.

Every statistic has a bootstrap interval over the stations of the records: see `statistics.paired`.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr

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
    root_mean_square,
)

BY_DAMPER = ("restitution", "damping_model", "damping_ratio_source")


def compare_dampers(config: Config, earthquakes: xr.Dataset) -> xr.Dataset:
    """Compare every damper, and CR with small changes, with CR, over all records and walls.

    A source of damping ratios that has none for some wall is compared on the others, beside CR on these too: ``pooled``
    tells which. CR with small changes is on every wall that has a ratio.

    The statistics are those of `paired.compare_pairs`, by band of CR's peak, where the first band is all of
    them. Those of CR with small changes begin with ``varied_``. ``excess`` is how much more a damper errs
    than the one of least error at that e, over the histories that survive with both.
    """
    bootstrap, edges = config.comparison.bootstrap, np.array(config.comparison.bands)
    weights = resample(earthquakes["station"].values, bootstrap.replicates, bootstrap.seed)
    bands = [(edges[0], edges[-1]), *pairwise(edges)]
    has_ratio, is_cr = find_pooled(earthquakes), earthquakes["damping_model"] == REFERENCE
    columns = has_ratio.any("damping_ratio_source").values
    pooled, is_pooled = earthquakes.isel(wall=columns), has_ratio.isel(wall=columns)
    pooled = pooled.assign(collapsed=pooled["collapsed"].where(is_pooled | is_cr, NOT_RUN))
    varied = compare_pairs(
        _pair_with_cr(pooled, "varied_peak", "varied_collapsed"), weights, bands, "Changes of CR"
    )
    kept = [
        name
        for statistic in ("median_ratio", "log_error")
        for name in (statistic, f"{statistic}_interval")
    ]
    statistics = xr.merge(
        [
            compare_pairs(_pair_with_cr(pooled, "peak", "collapsed"), weights, bands, "Dampers"),
            varied[kept].rename({name: f"varied_{name}" for name in kept}),
            _excess(pooled, edges, weights, has_ratio.sum("wall")),
            _fragility(pooled["collapsed"].where(is_pooled, NOT_RUN), weights),
            _wall_fragilities(earthquakes["collapsed"], weights),
        ],
        join="exact",
    )
    # Each history once: what CR has for one source it has for all.
    source = earthquakes["damping_ratio_source"]
    converged = earthquakes["converged"].where(
        ((source == source[0]) | ~is_cr) & (earthquakes["converged"] >= 0)
    )
    return statistics.assign(
        converged_share=converged.mean(),
        records=earthquakes.sizes["record"],
        stations=np.unique(earthquakes["station"]).size,
        pooled=has_ratio.astype(np.int8),
    ).assign_coords(
        {
            name: earthquakes[name].values
            for name in (*BY_DAMPER, "variation", "wall", "velocity_ratio")
        }
        | {
            "bound": list(BOUND),
            "band": np.arange(edges.size),
            "band_start": ("band", [low for low, _ in bands]),
            "band_end": ("band", [high for _, high in bands]),
        }
    )


def find_pooled(earthquakes: xr.Dataset) -> xr.DataArray:
    """Return, by wall and source, where every damper has a ratio at every e; true everywhere if that is nowhere."""
    defined = (
        earthquakes["damping_ratio"]
        .notnull()
        .sel(damping_model=earthquakes["damping_model"] != REFERENCE)
    )
    everywhere = defined.all(("restitution", "damping_model")).transpose(
        "wall", "damping_ratio_source"
    )
    return (everywhere if everywhere.any() else xr.ones_like(everywhere)).reset_coords(drop=True)


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


def _cr(histories: xr.Dataset | xr.DataArray) -> int:
    """Return the index of CR among the damping models."""
    return int(histories["damping_model"].values.tolist().index(REFERENCE))


def _excess(
    earthquakes: xr.Dataset, edges: Array, weights: Array, walls: xr.DataArray
) -> xr.Dataset:
    """Return how much more each damper errs than the one of least error at its e, where the wall survives with both.

    Both errors are of the same histories in the same replicate, so that what is common to all dampers cancels. The
    least is that of the sources that have a ratio of the most `walls`: their errors are of the same walls.
    """
    ranked = (walls == walls.max()).values
    stored = earthquakes.transpose("record", "velocity_ratio", "wall", *BY_DAMPER, ...)
    cr = _cr(earthquakes)
    excess, bounds = [], []
    for e in range(stored.sizes["restitution"]):
        peak, collapsed = (
            stored[name].isel(restitution=e).values for name in ("peak", "collapsed")
        )
        cr_peak, cr_collapsed = (values[..., cr : cr + 1, :1] for values in (peak, collapsed))
        survived = (
            (collapsed == 0) & (cr_collapsed == 0) & (cr_peak >= edges[0]) & (cr_peak < edges[-1])
        )
        square = np.log(np.where(survived, peak / cr_peak, 1.0)) ** 2
        error = root_mean_square(square.sum(axis=(0, 1, 2)), survived.sum(axis=(0, 1, 2)))
        error[cr] = np.nan
        candidates = np.where(ranked & np.isfinite(error), error, np.inf)
        best: Any = (..., *np.unravel_index(np.argmin(candidates), error.shape), None, None)
        both = survived & survived[best]
        # By record: the squares of each damper, of the best one over the same histories, and the count of these.
        sums = [
            np.where(both, values, 0.0).sum(axis=(1, 2)) for values in (square, square[best], both)
        ]
        differences = []
        for weight in (np.ones((1, len(both))), weights):  # the sample itself, and its replicates
            squares, best_squares, count = (np.tensordot(weight, values, 1) for values in sums)
            differences.append(
                root_mean_square(squares, count) - root_mean_square(best_squares, count)
            )
        excess.append(np.where(np.isfinite(error), differences[0][0], np.nan))
        bounds.append(np.where(np.isfinite(error)[..., None], interval(differences[1]), np.nan))
    return xr.Dataset(
        {"excess": (BY_DAMPER, excess), "excess_interval": ((*BY_DAMPER, "bound"), bounds)}
    )


# --- collapse ---------------------------------------------------------------------------------------------------------


def _fragility(collapsed: xr.DataArray, weights: Array) -> xr.Dataset:
    """Fit the fragility under each damper, of all walls together, and divide the medians by CR's."""
    ended = collapsed.transpose("record", *BY_DAMPER, "velocity_ratio", "wall").values
    scale, cr = collapsed["velocity_ratio"].values, _cr(collapsed)
    reference = (..., slice(cr, cr + 1), slice(None))
    fitted = compare_fragilities(
        scale, (ended == 1).sum(axis=-1), (ended >= 0).sum(axis=-1), weights, reference
    )
    dims = {
        name: (*BY_DAMPER, "bound") if name.endswith("_interval") else BY_DAMPER for name in fitted
    }
    statistics = xr.Dataset({name: (dims[name], values) for name, values in fitted.items()})
    return statistics.rename(
        median="median_velocity_ratio", median_interval="median_velocity_ratio_interval"
    )


def _wall_fragilities(collapsed: xr.DataArray, weights: Array) -> xr.Dataset:
    """Return each wall's fragility, and the share of records that collapse it."""
    columns = track(range(collapsed.sizes["wall"]), "Fragilities of the walls")
    fragility = xr.concat(
        [_fragility(collapsed.isel(wall=[column]), weights) for column in columns], "wall"
    )
    fragility = fragility.drop_vars(["median_intensity_ratio", "median_intensity_ratio_interval"])
    run = (collapsed >= 0).sum("record")
    share = ((collapsed == 1).sum("record") / run.where(run > 0)).transpose(
        "wall", *BY_DAMPER, "velocity_ratio"
    )
    return fragility.rename({name: f"wall_{name}" for name in fragility}).assign(
        collapse_fraction=share.variable
    )
