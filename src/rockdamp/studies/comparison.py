"""Every damper against restitution under earthquakes, and restitution against small changes.

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

STATISTIC_DIMS = ("restitution", "damping_model", "damping_ratio_source")
VARIED_STATISTICS = ("median_ratio", "median_ratio_interval", "log_error", "log_error_interval")


def compare_dampers(config: Config, earthquakes: xr.Dataset) -> xr.Dataset:
    """Compare every damper, and CR with small changes, with CR, over all records and walls.

    A source that lacks a damping ratio for some wall is compared over the other walls, and CR
    beside it too: ``pooled`` marks these walls. CR with small changes is compared over every wall
    that is marked for any source.

    Parameters
    ----------
    config : Config
        Bands of CR's peak, and the bootstrap.
    earthquakes : xarray.Dataset
        Histories from `studies.earthquakes`.

    Returns
    -------
    xarray.Dataset
        Statistics of `paired.compare_pairs`, by band of CR's peak; the first band is all of them.
        Statistics of CR with small changes begin with ``varied_``. ``excess`` is the error of a
        damper less that of the damper of least error at that e, over the histories that survive
        with both.
    """
    bootstrap = config.comparison.bootstrap
    edges = np.array(config.comparison.bands)
    bands = [(edges[0], edges[-1]), *pairwise(edges)]
    weights = resample(earthquakes["station"].values, bootstrap.replicates, bootstrap.seed)
    has_ratio = find_pooled(earthquakes)
    is_cr = earthquakes["damping_model"] == REFERENCE
    columns = has_ratio.any("damping_ratio_source").values
    histories = earthquakes.isel(wall=columns)
    is_pooled = has_ratio.isel(wall=columns)
    histories = histories.assign(collapsed=histories["collapsed"].where(is_pooled | is_cr, NOT_RUN))
    dampers = _pair_with_cr(histories, "peak", "collapsed")
    variations = compare_pairs(
        _pair_with_cr(histories, "varied_peak", "varied_collapsed"),
        weights,
        bands,
        "Changes of CR",
    )
    statistics = xr.merge(
        [
            compare_pairs(dampers, weights, bands, "Dampers"),
            variations[list(VARIED_STATISTICS)].rename(
                {name: f"varied_{name}" for name in VARIED_STATISTICS}
            ),
            _find_excess(histories, edges, weights, has_ratio.sum("wall")),
            _fit_fragilities(histories["collapsed"].where(is_pooled, NOT_RUN), weights),
            _fit_wall_fragilities(earthquakes["collapsed"], weights),
        ],
        join="exact",
    )
    dims = (*STATISTIC_DIMS, "variation", "wall", "velocity_ratio")
    return statistics.assign(
        converged_share=_find_converged_share(earthquakes),
        records=earthquakes.sizes["record"],
        stations=np.unique(earthquakes["station"]).size,
        pooled=has_ratio.astype(np.int8),
    ).assign_coords(
        {
            **{name: earthquakes[name].values for name in dims},
            "bound": list(BOUND),
            "band": np.arange(edges.size),
            "band_start": ("band", [start for start, _ in bands]),
            "band_end": ("band", [end for _, end in bands]),
        }
    )


def find_pooled(earthquakes: xr.Dataset) -> xr.DataArray:
    """Return, by wall and source, where every damper has a ratio at every e.

    Parameters
    ----------
    earthquakes : xarray.Dataset
        Damping ratios. If no wall has all ratios from any source, every wall counts.
    """
    is_damper = earthquakes["damping_model"] != REFERENCE
    is_defined = earthquakes["damping_ratio"].notnull().sel(damping_model=is_damper)
    has_all = is_defined.all(("restitution", "damping_model"))
    has_all = has_all.transpose("wall", "damping_ratio_source").reset_coords(drop=True)
    return has_all if has_all.any() else xr.ones_like(has_all)


def _find_converged_share(earthquakes: xr.Dataset) -> xr.DataArray:
    """Return the share of histories that end alike at every step, each history counted once."""
    # CR has the same histories for every source.
    source = earthquakes["damping_ratio_source"]
    is_cr = earthquakes["damping_model"] == REFERENCE
    is_single = (source == source[0]) | ~is_cr
    converged = earthquakes["converged"]
    return converged.where(is_single & (converged != NOT_RUN)).mean()


def _pair_with_cr(earthquakes: xr.Dataset, peak: str, collapsed: str) -> xr.Dataset:
    """Select alternatives by the names of their peak and collapse, beside CR."""
    # CR has no damping ratio, and the same histories for every source.
    cr = earthquakes.sel(damping_model=REFERENCE).isel(damping_ratio_source=0)
    return xr.Dataset(
        {
            "reference_peak": cr["peak"].variable,
            "reference_collapsed": cr["collapsed"].variable,
            "peak": earthquakes[peak].variable,
            "collapsed": earthquakes[collapsed].variable,
        }
    )


def _find_cr(histories: xr.Dataset | xr.DataArray) -> int:
    """Return the index of CR among the damping models."""
    return int(histories["damping_model"].values.tolist().index(REFERENCE))


def _find_excess(
    earthquakes: xr.Dataset, edges: Array, weights: Array, walls: xr.DataArray
) -> xr.Dataset:
    """Return the error of each damper less the least error at its e, with the interval.

    Both errors have the same histories, which survive with both dampers, in the same replicate, so
    that what is common to all dampers cancels. The least error is sought among the sources that
    have a ratio for the most `walls`: their errors are of the same walls.
    """
    is_ranked = (walls == walls.max()).values
    stored = earthquakes.transpose("record", "velocity_ratio", "wall", *STATISTIC_DIMS, ...)
    cr = _find_cr(earthquakes)
    excess = []
    intervals = []
    for index in range(stored.sizes["restitution"]):
        one_e = stored.isel(restitution=index)
        square, survived = _square_logarithms(one_e, edges, cr)
        error = root_mean_square(square.sum(axis=(0, 1, 2)), survived.sum(axis=(0, 1, 2)))
        error[cr] = np.nan
        candidates = np.where(is_ranked & np.isfinite(error), error, np.inf)
        # Damper and source of the least error, with axes of length 1 in place of theirs.
        best: Any = (..., *np.unravel_index(np.argmin(candidates), error.shape), None, None)
        survived_both = survived & survived[best]
        # By record: squares of each damper, squares of the best one, and the number of histories.
        sums = [
            np.where(survived_both, values, 0.0).sum(axis=(1, 2))
            for values in (square, square[best], survived_both)
        ]
        sample = np.ones((1, len(survived_both)))
        difference = _subtract_errors(sums, sample)[0]
        replicates = _subtract_errors(sums, weights)
        is_known = np.isfinite(error)
        excess.append(np.where(is_known, difference, np.nan))
        intervals.append(np.where(is_known[..., None], interval(replicates), np.nan))
    return xr.Dataset(
        {
            "excess": (STATISTIC_DIMS, excess),
            "excess_interval": ((*STATISTIC_DIMS, "bound"), intervals),
        }
    )


def _square_logarithms(histories: xr.Dataset, edges: Array, cr: int) -> tuple[Array, Array]:
    """Return the squares of ln(peak over CR's), and which histories survive with both."""
    peak = histories["peak"].values
    collapsed = histories["collapsed"].values
    cr_peak = peak[..., cr : cr + 1, :1]
    cr_collapsed = collapsed[..., cr : cr + 1, :1]
    is_in_bands = (cr_peak >= edges[0]) & (cr_peak < edges[-1])
    survived = (collapsed == 0) & (cr_collapsed == 0) & is_in_bands
    return np.log(np.where(survived, peak / cr_peak, 1.0)) ** 2, survived


def _subtract_errors(sums: list[Array], weights: Array) -> Array:
    """Return the errors of dampers less that of the best one, in each replicate."""
    squares, best_squares, count = (np.tensordot(weights, values, 1) for values in sums)
    return root_mean_square(squares, count) - root_mean_square(best_squares, count)


# --- collapse -------------------------------------------------------------------------------------


def _fit_fragilities(collapsed: xr.DataArray, weights: Array) -> xr.Dataset:
    """Fit the fragility of all walls under each damper, and divide the medians by CR's."""
    outcomes = collapsed.transpose("record", *STATISTIC_DIMS, "velocity_ratio", "wall").values
    cr = _find_cr(collapsed)
    fitted = compare_fragilities(
        collapsed["velocity_ratio"].values,
        (outcomes == 1).sum(axis=-1),
        (outcomes != NOT_RUN).sum(axis=-1),
        weights,
        (..., slice(cr, cr + 1), slice(None)),
    )
    statistics = xr.Dataset()
    for name in ("median", "dispersion", "median_intensity_ratio"):
        statistics[name] = (STATISTIC_DIMS, fitted[name])
        bounds = fitted[f"{name}_interval"]
        statistics[f"{name}_interval"] = ((*STATISTIC_DIMS, "bound"), bounds)
    return statistics.rename(
        median="median_velocity_ratio", median_interval="median_velocity_ratio_interval"
    )


def _fit_wall_fragilities(collapsed: xr.DataArray, weights: Array) -> xr.Dataset:
    """Return each wall's fragility, and the share of records that collapse it."""
    columns = track(range(collapsed.sizes["wall"]), "Fragilities of the walls")
    fragility = xr.concat(
        [_fit_fragilities(collapsed.isel(wall=[column]), weights) for column in columns], "wall"
    )
    fragility = fragility.drop_vars(["median_intensity_ratio", "median_intensity_ratio_interval"])
    runs = (collapsed != NOT_RUN).sum("record")
    share = (collapsed == 1).sum("record") / runs.where(runs > 0)
    share = share.transpose("wall", *STATISTIC_DIMS, "velocity_ratio")
    return fragility.rename({name: f"wall_{name}" for name in fragility}).assign(
        collapse_fraction=share.variable
    )
