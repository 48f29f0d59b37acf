"""Compare an alternative with restitution: how far its peaks are off, and which walls it collapses otherwise.

An alternative is a damper, or restitution with a slightly different e. The same walls are shaken by the same records
with both, so histories come in pairs. These numbers describe the pairs:

- median ratio: median of the alternative's peak over that under restitution, where neither wall collapses;
- log error: root mean square of the logarithm of that ratio; log dispersion: its standard deviation; its typical size
  and its tail: the median of the logarithm's size, its 90 % quantile, and the part of the squares that comes from the
  largest hundredth of the pairs;
- missed and added collapses: those that only restitution, or only the alternative, has;
- median intensity ratio: the intensity that collapses half of the walls over that under restitution.

**The paired bootstrap.** The study has some dozens of stations out of all that could have recorded an earthquake; the
interval says how far another draw of stations would move a number. A replicate draws as many stations as there are,
with replacement, and each history counts as often as its record was drawn (`weights`, from `fragility.resample`). Both
components of a station are drawn together, as they saw the same earthquake.

It is *paired*: both sides of a ratio, or of a difference, are taken from the same replicate. A record that is hard on
every wall raises the peaks with the damper and those under restitution alike, and cancels. Two separate bootstraps
would count such a record as scatter of the damper, and call dampers equal that differ in every single history.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.progress import track
from rockdamp.statistics.fragility import fit_resampled, interval, weighted_quantile

BOUND = ("lower", "upper")
HISTORIES = ("record", "velocity_ratio", "wall")


def compare_pairs(
    histories: xr.Dataset, weights: Array, bands: Sequence[tuple[float, float]], description: str = ""
) -> xr.Dataset:
    """Return the statistics of each alternative at each e, with their intervals.

    `histories` has ``reference_peak`` and ``reference_collapsed`` (record, velocity_ratio, wall, restitution) under
    restitution, and ``peak`` and ``collapsed`` with the alternatives' dimensions beside these. Collapsed is 1, survived
    0, not run -1. `bands` are of the peak under restitution [u/u_ins]; `description` is that of the progress bar.
    Missed collapses (``false_safe``) and added ones (``false_collapse``) come as counts, and as rates among the
    collapses and the survivals under restitution, of what the alternative ran.
    """
    order = (*HISTORIES, "restitution")
    other = histories["peak"].transpose(*order, ...)
    peak, fell = (histories[f"reference_{name}"].transpose(*order).values for name in ("peak", "collapsed"))
    peaks, falls = other.values, histories["collapsed"].transpose(*other.dims).values
    shape, dims = other.shape[3:], other.dims[3:]
    cells = []
    for at in track(list(product(*map(range, shape))), description):
        own: Any = (..., *at)
        pair = peak[..., at[0]], fell[..., at[0]], peaks[own], falls[own]
        cells.append(_compare_peaks(*pair, weights, bands) | _compare_outcomes(pair[1], pair[3], weights))
    statistics = {}
    for name in cells[0]:
        values = np.array([cell[name] for cell in cells])
        band = () if name.startswith("false") else ("band",)
        bound = ("bound",) if name.endswith("_interval") else ()
        statistics[name] = ((*dims, *band, *bound), values.reshape(*shape, *values.shape[1:]))
    return xr.Dataset(statistics)


def _compare_peaks(
    reference: Array,
    fell: NDArray[np.int8],
    other: Array,
    falls: NDArray[np.int8],
    weights: Array,
    bands: Sequence[tuple[float, float]],
) -> dict[str, Any]:
    """Return statistics of the ratio of the peaks where both survive, by band; histories (record, scale, wall)."""
    record = np.broadcast_to(np.arange(len(reference))[:, None, None], reference.shape)
    results = []
    for low, high in bands:
        part = (fell == 0) & (falls == 0) & (reference >= low) & (reference < high)
        logarithm = np.log(other[part] / reference[part])
        whole, drawn = (_moments(logarithm, record[part], w) for w in (np.ones((1, len(reference))), weights))
        values = {name: value[0] for name, value in whole.items()}
        values |= {f"{name}_interval": interval(value) for name, value in drawn.items()}
        results.append({**values, **error_sizes(logarithm), "pairs": logarithm.size})
    return {name: [values[name] for values in results] for name in results[0]}


def _moments(logarithm: Array, record: NDArray[np.int64], weights: Array) -> dict[str, Array]:
    """Return statistics of each replicate from the logarithms of records, and the weights (replicates, records)."""
    count, total, squares = (weights @ np.bincount(record, logarithm**power, weights.shape[1]) for power in (0, 1, 2))
    mean, square = quotient(total, count), quotient(squares, count)
    return {
        "median_ratio": np.exp(weighted_quantile(logarithm, record, weights, 0.5)),
        "log_dispersion": np.sqrt(np.maximum(square - mean**2, 0.0)),
        "log_error": np.sqrt(square),
    }


def error_sizes(logarithm: Array) -> dict[str, float]:
    """Return what a root mean square hides of logarithms of ratios, all counted alike; NaN of none.

    The median and the 90 % quantile of their size, and the part of the sum of squares that comes from the largest
    hundredth of them, at least one.
    """
    if not logarithm.size:
        return dict.fromkeys(("log_error_median", "log_error_90", "tail_share"), np.nan)
    size = np.sort(np.abs(logarithm))
    largest = size[-max(round(0.01 * size.size), 1) :]
    median, high = np.quantile(size, (0.5, 0.9))
    share = float(quotient((largest**2).sum(), (size**2).sum()))
    return {"log_error_median": float(median), "log_error_90": float(high), "tail_share": share}


def _compare_outcomes(fell: NDArray[np.int8], falls: NDArray[np.int8], weights: Array) -> dict[str, Any]:
    """Count missed and added collapses, also as rates of the collapses and survivals under restitution."""
    values: dict[str, Any] = {}
    for name, before, after in (("false_safe", 1, 0), ("false_collapse", 0, 1)):
        cases = (fell == before) & (falls >= 0)
        # Sums by record: a replicate weighs them by how often it drew the record.
        wrong, ran = (count.sum(axis=(1, 2)).astype(float) for count in (cases & (falls == after), cases))
        values[name] = int(wrong.sum())
        values[f"{name}_rate"] = quotient(wrong.sum(), ran.sum())
        values[f"{name}_rate_interval"] = interval(quotient(weights @ wrong, weights @ ran))
    return values


def compare_fragilities(
    intensity: Array, collapses: Array, runs: Any, weights: Array, reference: Any
) -> dict[str, Array]:
    """Fit fragility curves, and compare their medians with restitution's; arrays of shape (...), and their intervals.

    `collapses` and `runs` count by record, shape (records, ..., stripes), and broadcast. `reference` indexes the curves
    under restitution: ``median[reference]`` broadcasts with ``median``.
    """
    fits = fit_resampled(intensity, collapses, runs, weights)
    whole, drawn = (
        {
            "median": fit.median,
            "dispersion": fit.dispersion,
            # Paired: each replicate's median is divided by restitution's in the same replicate.
            "median_intensity_ratio": fit.median / fit.median[reference],
        }
        for fit in fits
    )
    return whole | {f"{name}_interval": interval(replicates) for name, replicates in drawn.items()}


def root_mean_square(squares: Any, count: Any) -> Array:
    """Return the root of sums of squares over their count; NaN of none."""
    return np.sqrt(quotient(squares, count))


def quotient(part: Any, whole: Any) -> Any:
    """Return part over whole; NaN of none."""
    part, whole = np.broadcast_arrays(part, whole)
    return np.divide(part, whole, out=np.full(part.shape, np.nan), where=whole > 0)
