"""Recommend a damper in place of restitution, from the studies of earthquakes, orders and decays.

The damper to use is the one that errs least from restitution under earthquakes, or whose error is not significantly
larger than the least, at every coefficient of restitution. Beside it stands what a user has to know of it: the typical
error and the tail beside those that another e makes, and what it misses.

`compare_dampers` compares every damper with CR under earthquakes, and CR with small changes of itself. Every statistic
has a bootstrap interval over the stations of the records: see `statistics.against_restitution`.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.mechanics.damping import Damping
from rockdamp.progress import track
from rockdamp.statistics.against_restitution import (
    BOUND,
    CHANGES_OF_E,
    bootstrapped,
    fragilities,
    quotient,
    root_mean_square,
)
from rockdamp.statistics.fragility import interval, resample
from rockdamp.vocabulary import DECISIVE_CHANGE, RECOMMENDED_ORDER, REFERENCE

EXACT_SOURCE = "closed form"  # of a damping ratio that is exact for some dampers, and needs no history

# ASSUME: a damper holds where its error is no more than twice what CR's own answer moves after a small change of e or
# of the analysis, or where it is a tenth.
MULTIPLE = 2.0  # of the small-change error of CR
TOLERANCE = 0.10

CHOICES = ("damping_model", "damping_ratio_source")
SIZES = ("log_error", "log_error_median", "log_error_90")  # of the difference of the peaks: rms, typical, tail


def recommend(config: Config, compared: xr.Dataset, orders: xr.Dataset, by_order: xr.Dataset) -> xr.Dataset:
    """Recommend a damper and the source of its damping ratio, and collect the reasons.

    `compared` and `orders` hold the dampers, and ECD of each order, under earthquakes; `by_order` holds ECD of each
    order in free decay.
    """
    e, models = compared["restitution"].values, compared["damping_model"].values
    ratio = [
        np.full(e.size, np.nan)
        if model == REFERENCE
        else damping_ratio_energy(config.curve, str(model), e, config.release_amplitude)
        for model in models
    ]
    near = by_order.sel(order=RECOMMENDED_ORDER, method="nearest")
    return under_earthquakes(compared).assign(
        damping_ratio_energy=(("damping_model", "restitution"), np.stack(ratio)),
        release_amplitude=config.release_amplitude,
        crossing_force=float(abs(near["shown_damping_force"]).max()),  # of the order nearest to the recommended one
        recommended_order=orders["recommended_order"].sel(change=DECISIVE_CHANGE, drop=True),
        restitution_change=orders["restitution_change"],
        records=orders["records"],
    )


def under_earthquakes(compared: xr.Dataset) -> xr.Dataset:
    """Return the part of the recommendation that the comparison under earthquakes gives."""
    whole, largest = (compared.isel(band=band, drop=True) for band in (0, -1))
    own = compared["varied_log_error"].max("variation")
    # The smaller of both sides: what a change of e makes at the least.
    change = {name: compared[f"varied_{name}"].sel(variation=list(CHANGES_OF_E)).min("variation") for name in SIZES}
    more_loss, less_loss = (compared.sel(variation=side) for side in CHANGES_OF_E)
    sizes = {name: whole[name] for name in SIZES}
    sizes |= {_of_change(name): change[name].isel(band=0, drop=True) for name in SIZES}
    sizes |= {f"near_collapse_{name}": largest[name] for name in SIZES}
    sizes |= {f"near_collapse_{_of_change(name)}": change[name].isel(band=-1, drop=True) for name in SIZES}
    return judge(whole).assign(
        {
            **sizes,
            "tail_share": whole["tail_share"],
            "log_error_interval": whole["log_error_interval"],
            "excess": whole["log_error_excess"],
            "excess_interval": whole["log_error_excess_interval"],
            "sensitivity": own,
            "holds": holds(compared["log_error"], own).astype(np.int8),
            "near_collapse_start": compared["band_start"].values[-1],
            "false_safe_rate": whole["false_safe_rate"],
            "false_collapse_rate": whole["false_collapse_rate"],
            # More loss misses collapses, less loss adds them.
            "sensitivity_false_safe_rate": more_loss["varied_false_safe_rate"].drop_vars("variation"),
            "sensitivity_false_collapse_rate": less_loss["varied_false_collapse_rate"].drop_vars("variation"),
        }
    )


def _of_change(name: str) -> str:
    """Return the name of a size of the difference that a change of e makes."""
    return f"sensitivity_to_restitution{name.removeprefix('log_error')}"


# --- which damper -----------------------------------------------------------------------------------------------------


def judge(whole: xr.Dataset) -> xr.Dataset:
    """Mark at each e the least error and those not significantly larger, and over all e what to use.

    Significantly larger is where the interval of the difference of both errors, over the same histories, is above zero.
    That the intervals of both errors overlap says nothing: the dampers share the records. `whole` is over all
    amplitudes.
    """
    ordered = whole.transpose("restitution", *CHOICES, ...)
    is_damper = (whole["damping_model"] != REFERENCE).values[:, None]
    error = np.where(is_damper, ordered["log_error"].values, np.nan)
    ranked = np.where(covers_most(whole["pooled"]).values, error, np.nan)
    known = np.isfinite(ranked).any(axis=(1, 2), keepdims=True)  # e at which any damper has an error
    least = np.zeros(error.shape, dtype=bool)
    for e in np.flatnonzero(known):
        least[e].flat[np.nanargmin(ranked[e])] = True
    lower = ordered["log_error_excess_interval"].sel(bound="lower").values
    near = least | ((lower <= 0) & is_damper & known)
    everywhere: NDArray[np.bool_] = near.all(axis=0)
    use = np.zeros_like(everywhere)
    if everywhere.any():
        # Of several the one of least error over all e; if its damper has an exact ratio, with that.
        square = np.where(everywhere, np.nan_to_num(ranked**2, nan=np.inf).mean(axis=0), np.inf)
        model, source = divmod(int(np.argmin(square)), square.shape[1])
        exact = whole["damping_ratio_source"].values.tolist().index(EXACT_SOURCE)
        if str(whole["damping_model"].values[model]) in Damping.exact_models() and everywhere[model, exact]:
            source = exact
        use[model, source] = True
    by_e = ("restitution", *CHOICES)
    return xr.Dataset(
        {
            "least_error": (by_e, least.astype(np.int8)),
            "not_told_apart": (by_e, near.astype(np.int8)),
            "recommended": (CHOICES, use.astype(np.int8)),
            "as_good": (CHOICES, (everywhere & ~use).astype(np.int8)),
        },
        coords={name: whole[name].values for name in (*by_e, "bound")},
    )


# --- when, and when not -----------------------------------------------------------------------------------------------


def holds(error: xr.DataArray, own: xr.DataArray) -> xr.DataArray:
    """Tell where an error is within the multiple of CR's small-change error, or the tolerance; unknown is not."""
    return error <= np.maximum(MULTIPLE * own, TOLERANCE)


FRACTILES = (0.16, 0.50, 0.84)
NOT_RUN = -1  # as an outcome
SHARES = (0.5, 0.9, 0.99, 1.0)
BY_DAMPER = ("restitution", "damping_model", "damping_ratio_source")


def compare_dampers(config: Config, earthquakes: xr.Dataset) -> xr.Dataset:
    """Compare every damper, and CR with small changes, with CR, over all records and walls.

    A source of damping ratios that has none for some wall is compared on the others, beside CR on these too: ``pooled``
    tells which. CR with small changes is on every wall that has a ratio.

    The statistics are those of `against_restitution.bootstrapped`, by band of CR's peak, where the first band is all of
    them. Those of CR with small changes begin with ``varied_``. ``log_error_excess`` is how much more a damper errs
    than the one of least error at that e, over the histories that survive with both.
    """
    bootstrap = config.comparison.bootstrap
    weights = resample(earthquakes["station"].values, bootstrap.replicates, bootstrap.seed)
    edges = config.comparison.bands
    bands = [(edges[0], edges[-1]), *pairwise(edges)]
    has_ratio = _with_ratio(earthquakes)
    some = has_ratio.any("damping_ratio_source").values
    pooled, taken = earthquakes.isel(wall=some), has_ratio.isel(wall=some)
    pooled = pooled.assign(collapsed=pooled["collapsed"].where(taken | (pooled["damping_model"] == REFERENCE), NOT_RUN))
    varied = bootstrapped(_beside_cr(pooled, "varied_peak", "varied_collapsed"), weights, bands, "Changes of CR")
    statistics = xr.merge(
        [
            bootstrapped(_beside_cr(pooled, "peak", "collapsed"), weights, bands, "Dampers"),
            varied.rename({name: f"varied_{name}" for name in varied}),
            _excess(pooled, edges, weights, covers_most(has_ratio).values),
            _pooled_fragility(pooled.assign(collapsed=pooled["collapsed"].where(taken, NOT_RUN)), weights),
            _per_wall(earthquakes, weights),
            _misfit(pooled.assign(decay_misfit=pooled["decay_misfit"].where(taken))),
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
            "fractile_probability": list(FRACTILES),
            "share": list(SHARES),
            "band": np.arange(edges.size),
            "band_start": ("band", [low for low, _ in bands]),
            "band_end": ("band", [high for _, high in bands]),
        }
    )


def _with_ratio(earthquakes: xr.Dataset) -> xr.DataArray:
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


def _beside_cr(earthquakes: xr.Dataset, peak: str, collapsed: str) -> xr.Dataset:
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
    return xr.Dataset(
        {"log_error_excess": (BY_DAMPER, excess), "log_error_excess_interval": ((*BY_DAMPER, "bound"), bounds)}
    )


# --- collapse, and the decay ------------------------------------------------------------------------------------------


def _fragility(scale: Array, collapses: NDArray[Any], runs: NDArray[Any], weights: Array, cr: int) -> xr.Dataset:
    """Fit counts (record, restitution, damping model, source, scale), and divide the medians by CR's."""
    fitted = fragilities(scale, collapses, runs, weights, (..., slice(cr, cr + 1), slice(None)))
    dims = {name: (*BY_DAMPER, "bound") if name.endswith("_interval") else BY_DAMPER for name in fitted}
    statistics = xr.Dataset({name: (dims[name], values) for name, values in fitted.items()})
    return statistics.rename(median="median_velocity_ratio", median_interval="median_velocity_ratio_interval")


def _pooled_fragility(pooled: xr.Dataset, weights: Array) -> xr.Dataset:
    """Fit the fragilities of all walls together."""
    stored = pooled["collapsed"].transpose("record", *BY_DAMPER, "velocity_ratio", "wall").values
    counts = (stored == 1).sum(axis=-1), (stored >= 0).sum(axis=-1)
    return _fragility(pooled["velocity_ratio"].values, *counts, weights, _cr(pooled))


def _per_wall(earthquakes: xr.Dataset, weights: Array) -> xr.Dataset:
    """Return each wall's fragility, the share of records that collapse it, and fractiles of the peaks."""
    order = ("record", "wall", *BY_DAMPER, "velocity_ratio")
    stored = earthquakes["collapsed"].transpose(*order).values
    run, collapsed = (stored >= 0).astype(float), (stored == 1).astype(float)
    scale, cr = earthquakes["velocity_ratio"].values, _cr(earthquakes)
    by_wall = [
        _fragility(scale, collapsed[:, wall], run[:, wall], weights, cr)
        for wall in track(range(earthquakes.sizes["wall"]), "Fragilities of the walls")
    ]
    peaks = np.where(collapsed == 1, np.inf, np.where(run == 1, earthquakes["peak"].transpose(*order), np.nan))
    fractiles = np.quantile(peaks, FRACTILES, axis=0, method="inverted_cdf")
    fragility = xr.concat(by_wall, "wall")
    return fragility.rename({name: f"wall_{name}" for name in fragility}).assign(
        collapse_fraction=(order[1:], quotient(collapsed.sum(axis=0), run.sum(axis=0))),
        fractile=(("fractile_probability", *order[1:]), np.where(np.isfinite(fractiles), fractiles, np.nan)),
    )


def _misfit(earthquakes: xr.Dataset) -> xr.Dataset:
    """Return the median over records and walls of the misfit over the decay, at each scale."""
    median = earthquakes["decay_misfit"].median(("record", "wall"))
    return xr.Dataset({"median_decay_misfit": median.transpose(*BY_DAMPER, "velocity_ratio")})
