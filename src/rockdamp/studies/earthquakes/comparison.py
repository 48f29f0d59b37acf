"""What earthquakes say of each damper: peaks against CR's, collapses, fragilities, and CR's own sensitivity.

Every headline number is bootstrapped over the stations of the records, both components of a station together.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.earthquakes import ComparisonSettings
from rockdamp.progress import track
from rockdamp.statistics.fragility import fit_resampled, interval, resample, weighted_quantile
from rockdamp.vocabulary import REFERENCE

FRACTILES = (0.16, 0.50, 0.84)
BOUND = ("lower", "upper")

# Statistics of the ratio of a peak to CR's, in this order.
RATIO = ("median_ratio", "log_dispersion", "log_error", "pairs")


def compare(config: Config, earthquakes: xr.Dataset) -> xr.Dataset:
    """Compare every damper, and CR with small changes of its own, with CR.

    Parameters
    ----------
    config : dict
        Has the keys of `ComparisonSettings`.
    earthquakes : xarray.Dataset
        Of `incremental.gather`.

    Returns
    -------
    xarray.Dataset
        Over all records, scales and the walls that have a damping ratio from every source: ``median_ratio``,
        ``log_dispersion`` (standard deviation of the logarithm), ``log_error`` (root mean square of the logarithm) and
        ``pairs`` of the peaks over CR's where neither collapses, by band of CR's peak (the first band is all of them);
        ``log_error_excess``, how much more a damper errs than the one of least error at that e, over the histories that
        stand with both; ``false_safe_rate`` (of CR's collapses) and ``false_collapse_rate`` (of its survivals);
        ``median_scale``, ``dispersion`` and ``median_intensity_ratio`` of the fragilities. Names with ``_interval``
        are 95 % bootstrap intervals, those of ratios and of the excess paired; those with ``varied_`` are CR's own
        under small changes. For each wall: ``wall_median_scale``, its ratio to CR's, ``wall_dispersion``,
        ``collapse_fraction`` and ``fractile`` of the peaks.
    """
    given = ComparisonSettings.of(config)
    weights = resample(earthquakes["station"].values, given.bootstrap.replicates, given.bootstrap.seed)
    edges = given.bands
    pooled = earthquakes.isel(wall=_complete(earthquakes))
    damper = _Alternatives(pooled, "peak_ratio", "collapsed", ("damping_model", "damping_ratio_source"))
    varied = _Alternatives(pooled, "varied_peak", "varied_collapsed", ("variation",))
    statistics = xr.merge(
        [
            damper.ratios(edges, weights, ""),
            _excess(pooled, edges, weights),
            damper.collapses(weights, ""),
            varied.ratios(edges, weights, "varied_"),
            varied.collapses(weights, "varied_"),
            damper.fragility(weights),
            _per_wall(earthquakes, weights),
            _misfit(pooled),
        ],
        join="exact",
    )
    kept = ("damping_model", "damping_ratio_source", "variation", "restitution", "wall", "scale")
    settled = earthquakes["settled"].where(earthquakes["settled"] >= 0)
    return statistics.assign(
        settled_share=settled.mean(),
        records=earthquakes.sizes["record"],
        stations=np.unique(earthquakes["station"]).size,
        pooled=("wall", _complete(earthquakes).astype(np.int8)),
        relative_uncertainty=("share", _uncertainty(earthquakes)),
    ).assign_coords(
        {name: earthquakes[name].values for name in kept}
        | {
            "bound": list(BOUND),
            "probability": list(FRACTILES),
            "share": [0.5, 0.9, 0.99, 1.0],
            "band": np.arange(edges.size),
            "band_start": ("band", np.r_[edges[0], edges[:-1]]),
            "band_end": ("band", np.r_[edges[-1], edges[1:]]),
        }
    )


def _complete(earthquakes: xr.Dataset) -> NDArray[np.bool_]:
    """Walls that have a damping ratio from every source: sources can only be compared on the same walls."""
    defined = earthquakes["damping_ratio"].notnull().sel(damping_model=earthquakes["damping_model"] != REFERENCE)
    complete = defined.all(("restitution", "damping_model", "damping_ratio_source")).values
    return complete if complete.any() else np.ones_like(complete)


def _uncertainty(earthquakes: xr.Dataset) -> Array:
    """Fractiles of the bound of the peaks' error, as a fraction of the peak."""
    bound = (earthquakes["peak_ratio_uncertainty"] / earthquakes["peak_ratio"]).values
    known = bound[np.isfinite(bound)]
    return np.quantile(known, [0.5, 0.9, 0.99, 1.0]) if known.size else np.full(4, np.nan)


@dataclass(frozen=True)
class _Alternatives:
    """Alternatives to CR with their peaks and collapses; `dims` are those of the alternatives."""

    earthquakes: xr.Dataset
    peak: str
    collapsed: str
    dims: tuple[str, ...]

    def _arrays(self) -> tuple[xr.DataArray, xr.DataArray, xr.DataArray, xr.DataArray]:
        """CR's peak and collapse, and those of the alternatives, dimensions of histories first."""
        cr = self.earthquakes.sel(damping_model=REFERENCE).isel(damping_ratio_source=0)
        order = ("record", "scale", "wall", "restitution")
        return (
            cr["peak_ratio"].transpose(*order),
            cr["collapsed"].transpose(*order),
            self.earthquakes[self.peak].transpose(*order, *self.dims),
            self.earthquakes[self.collapsed].transpose(*order, *self.dims),
        )

    def _each(self, values: Callable[..., Mapping[str, Any]], dims: Mapping[str, tuple[str, ...]]) -> xr.Dataset:
        """Collect what `values(restitution index, alternative's index)` returns for each of them."""
        shape = (self.earthquakes.sizes["restitution"], *(self.earthquakes.sizes[dim] for dim in self.dims))
        cells: dict[str, list[Any]] = {name: [] for name in dims}
        for index in track(list(product(*map(range, shape))), f"Statistics of {self.peak}"):
            for name, value in values(*index).items():
                cells[name].append(value)
        lead = ("restitution", *self.dims)
        return xr.Dataset(
            {
                name: ((*lead, *of), np.array(cells[name]).reshape(*shape, *np.shape(cells[name][0])))
                for name, of in dims.items()
            }
        )

    def ratios(self, edges: Array, weights: Array, prefix: str) -> xr.Dataset:
        """Statistics of the ratios of peaks, over all bands and in each."""
        reference, fell, peaks, collapsed = (array.values for array in self._arrays())
        record = np.broadcast_to(np.arange(reference.shape[0])[:, None, None], reference.shape[:3])
        bands = [(edges[0], edges[-1]), *pairwise(edges)]

        def values(e: int, *alternative: int) -> dict[str, Any]:
            at: Any = (..., e, *alternative)
            stand = (fell[..., e] == 0) & (collapsed[at] == 0)
            parts = [stand & (reference[..., e] >= low) & (reference[..., e] < high) for low, high in bands]
            results = [
                _ratio_statistics(np.log(peaks[at][part] / reference[..., e][part]), record[part], weights)
                for part in parts
            ]
            return {prefix + name: np.array([of_band[name] for of_band in results]) for name in results[0]}

        dims: dict[str, tuple[str, ...]] = {prefix + name: ("band",) for name in RATIO}
        dims |= {f"{prefix}{name}_interval": ("band", "bound") for name in RATIO[:3]}
        return self._each(values, dims)

    def collapses(self, weights: Array, prefix: str) -> xr.Dataset:
        """Collapses that only one of both has, as a fraction of CR's collapses and survivals."""
        _, fell, _, collapsed = (array.values for array in self._arrays())

        def values(e: int, *alternative: int) -> dict[str, Any]:
            at: Any = (..., e, *alternative)
            down, other = fell[..., e] == 1, collapsed[at]
            rates: dict[str, Any] = {}
            for name, wrong, of in (("safe", down & (other == 0), down), ("collapse", ~down & (other == 1), ~down)):
                counts = wrong.sum(axis=(1, 2)).astype(float), of.sum(axis=(1, 2)).astype(float)
                rates[f"{prefix}false_{name}"] = int(counts[0].sum())
                rates[f"{prefix}false_{name}_rate"] = _divide(counts[0].sum(), counts[1].sum())
                rates[f"{prefix}false_{name}_rate_interval"] = interval(
                    _divide(weights @ counts[0], weights @ counts[1])
                )
            return rates

        dims: dict[str, tuple[str, ...]] = {}
        for name in ("safe", "collapse"):
            dims |= {f"{prefix}false_{name}": (), f"{prefix}false_{name}_rate": ()}
            dims[f"{prefix}false_{name}_rate_interval"] = ("bound",)
        return self._each(values, dims)

    def fragility(self, weights: Array) -> xr.Dataset:
        """Fragilities over all walls together, and the ratio of their medians to CR's."""
        lead = ("restitution", *self.dims)
        stored = self.earthquakes["collapsed"].transpose("record", *lead, "scale", "wall").values
        collapses, runs = ((stored == 1).sum(axis=-1), (stored >= 0).sum(axis=-1))
        whole, drawn = fit_resampled(self.earthquakes["scale"].values, collapses, runs, weights)
        ratio, drawn_ratio = (_over_reference(self.earthquakes, each.median) for each in (whole, drawn))
        return xr.Dataset(
            {
                "median_scale": (lead, whole.median),
                "dispersion": (lead, whole.dispersion),
                "median_intensity_ratio": (lead, ratio),
                "median_scale_interval": ((*lead, "bound"), interval(drawn.median)),
                "dispersion_interval": ((*lead, "bound"), interval(drawn.dispersion)),
                "median_intensity_ratio_interval": ((*lead, "bound"), interval(drawn_ratio)),
            }
        )


def _ratio_statistics(logarithm: Array, record: NDArray[np.int64], weights: Array) -> dict[str, Any]:
    """Statistics of logarithms of ratios, and their bootstrap intervals by the weights of their records."""
    statistics = [logarithm[None], np.ones((1, logarithm.size))], [logarithm[None], weights[:, record]]
    whole, drawn = (_moments(*given) for given in statistics)
    estimates: dict[str, Any] = {name: values[0] for name, values in whole.items()}
    return {**estimates, "pairs": logarithm.size, **{f"{name}_interval": interval(drawn[name]) for name in drawn}}


def _moments(logarithm: Array, weight: Array) -> dict[str, Array]:
    total = weight.sum(axis=1)
    mean, square = (_divide(weight @ logarithm[0] ** power, total) for power in (1, 2))
    return {
        "median_ratio": np.exp(weighted_quantile(logarithm[0], weight, 0.5)),
        "log_dispersion": np.sqrt(np.maximum(square - mean**2, 0.0)),
        "log_error": np.sqrt(square),
    }


def _excess(earthquakes: xr.Dataset, edges: Array, weights: Array) -> xr.Dataset:
    """How much more each damper errs than the one of least error at its e, over the histories that stand with both.

    Both errors are of the same histories in the same replicate, so that what is common to all dampers cancels.
    """
    dims = ("restitution", "damping_model", "damping_ratio_source")
    stored = earthquakes.transpose("record", "scale", "wall", *dims, ...)
    cr = earthquakes["damping_model"].values.tolist().index(REFERENCE)
    excess, bounds = [], []
    for e in range(stored.sizes["restitution"]):
        peak, collapsed = (stored[name].isel(restitution=e).values for name in ("peak_ratio", "collapsed"))
        reference, fell = (values[..., cr : cr + 1, :1] for values in (peak, collapsed))
        stand = (collapsed == 0) & (fell == 0) & (reference >= edges[0]) & (reference < edges[-1])
        square = np.log(np.where(stand, peak / reference, 1.0)) ** 2
        error = _root(square.sum(axis=(0, 1, 2)), stand.sum(axis=(0, 1, 2)))
        error[cr] = np.nan
        least: Any = (..., *np.unravel_index(np.argmin(np.nan_to_num(error, nan=np.inf)), error.shape), None, None)
        both = stand & stand[least]
        of_records = [np.where(both, each, 0.0).sum(axis=(1, 2)) for each in (square, square[least], both)]
        whole, drawn = (
            _root(sums, runs) - _root(least_sums, runs)
            for sums, least_sums, runs in (
                [np.tensordot(weight, each, 1) for each in of_records] for weight in (np.ones((1, len(both))), weights)
            )
        )
        excess.append(np.where(np.isfinite(error), whole[0], np.nan))
        bounds.append(np.where(np.isfinite(error)[..., None], interval(drawn), np.nan))
    return xr.Dataset({"log_error_excess": (dims, excess), "log_error_excess_interval": ((*dims, "bound"), bounds)})


def _root(squares: Any, count: Any) -> Array:
    """Root of the mean square; NaN of nothing."""
    return np.sqrt(_divide(squares, count))


def _divide(part: Any, whole: Any) -> Any:
    """Quotient; NaN of nothing."""
    return np.divide(part, whole, out=np.full(np.shape(part), np.nan), where=np.asarray(whole) > 0)


# --- each wall, and the decay -----------------------------------------------------------------------------------------


def _over_reference(earthquakes: xr.Dataset, median: Array) -> Array:
    """Medians, shape (..., damping model, source), over CR's of the same replicate."""
    cr = earthquakes["damping_model"].values.tolist().index(REFERENCE)
    return np.asarray(median / median[..., cr : cr + 1, :])


def _per_wall(earthquakes: xr.Dataset, weights: Array) -> xr.Dataset:
    """Fragility of each wall with its interval, the share of records that collapse it, and fractiles of the peaks."""
    order = ("record", "wall", "restitution", "damping_model", "damping_ratio_source", "scale")
    stored = earthquakes["collapsed"].transpose(*order)
    run = (stored >= 0).values.astype(float)
    collapsed = (stored == 1).values.astype(float)
    scale = earthquakes["scale"].values
    lead = order[1:-1]
    of_walls = []
    for row in track(range(earthquakes.sizes["wall"]), "Fragilities of the walls"):
        whole, drawn = fit_resampled(scale, collapsed[:, row], run[:, row], weights)
        ratio, drawn_ratio = (_over_reference(earthquakes, each.median) for each in (whole, drawn))
        of_walls.append(
            (whole.median, whole.dispersion, ratio, *map(interval, (drawn.median, drawn.dispersion, drawn_ratio)))
        )
    median, dispersion, median_ratio, *intervals = (np.stack(parts) for parts in zip(*of_walls, strict=True))
    peaks = np.where(collapsed == 1, np.inf, np.where(run == 1, earthquakes["peak_ratio"].transpose(*order), np.nan))
    fractiles = np.quantile(peaks, FRACTILES, axis=0, method="inverted_cdf")
    count = run.sum(axis=0)
    return xr.Dataset(
        {
            "wall_median_scale": (lead, median),
            "wall_dispersion": (lead, dispersion),
            "wall_median_intensity_ratio": (lead, median_ratio),
            "wall_median_scale_interval": ((*lead, "bound"), intervals[0]),
            "wall_dispersion_interval": ((*lead, "bound"), intervals[1]),
            "wall_median_intensity_ratio_interval": ((*lead, "bound"), intervals[2]),
            "collapse_fraction": ((*lead, "scale"), _divide(collapsed.sum(axis=0), count)),
            "fractile": (("probability", *lead, "scale"), np.where(np.isfinite(fractiles), fractiles, np.nan)),
        }
    )


def _misfit(earthquakes: xr.Dataset) -> xr.Dataset:
    """Median over records and walls of the misfit over the decay, at each scale."""
    median = earthquakes["decay_misfit"].median(("record", "wall"))
    return xr.Dataset(
        {"median_decay_misfit": median.transpose("restitution", "damping_model", "damping_ratio_source", "scale")}
    )


def best(compared: xr.Dataset, restitution: float) -> tuple[str, str]:
    """Return the damper and the source of its damping ratio whose peaks err least from CR's, over all bands."""
    error = compared["log_error"].sel(restitution=restitution).isel(band=0).drop_sel(damping_model=REFERENCE)
    at = np.unravel_index(int(np.nanargmin(error.values)), error.shape)
    return str(error["damping_model"].values[at[0]]), str(error["damping_ratio_source"].values[at[1]])
