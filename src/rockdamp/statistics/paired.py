"""Compare an alternative with restitution: errors of peaks, missed and added collapses.

An alternative is a damper, or restitution with a slightly different e. The same records shake the
same walls with both, so that histories come in pairs. These numbers describe the pairs:

- median ratio: median of the alternative's peak over that under restitution, where neither wall
  collapses;
- log error: root mean square of the logarithm of that ratio; beside it the median and the 90 %
  quantile of the size of the logarithm, and the share of pairs where it is above
  `LARGE_LOG_RATIO`;
- missed collapses: those that only restitution has, as a rate of the collapses under restitution;
- added collapses: those that only the alternative has, as a rate of the survivals under
  restitution;
- median intensity ratio: intensity that collapses half of the walls, divided by that under
  restitution.

**The paired bootstrap.** The records are those of some dozens of stations out of all that could
have recorded an earthquake; the interval says how far another draw of stations would move a number.
A replicate draws as many stations as there are, with replacement, and each history counts as often
as its record was drawn (`weights`, from `fragility.resample`). Both components of a station are
drawn together, as they saw the same earthquake.

It is *paired*: both sides of a ratio, or of a difference, are taken from the same replicate. A
record that is hard on every wall raises the peaks with the damper and those under restitution
alike, and cancels. Two separate bootstraps would count such a record as scatter of the damper, and
call dampers equal that differ in every single history.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.progress import track
from rockdamp.statistics.fragility import Fragility, fit_resampled, interval, weighted_quantile

BOUND = ("lower", "upper")
HISTORIES = ("record", "velocity_ratio", "wall")
LARGE_LOG_RATIO = 0.05  # about 5 % of a peak
NOT_RUN = -1  # as an outcome


def compare_pairs(
    histories: xr.Dataset,
    weights: Array,
    bands: Sequence[tuple[float, float]],
    description: str = "",
) -> xr.Dataset:
    """Return the statistics of each alternative with their intervals.

    Those of the peaks are given in bands of the peak under restitution.

    Parameters
    ----------
    histories : xarray.Dataset
        ``peak`` [u/u_ins] and ``collapsed`` of the alternatives over `HISTORIES` and other
        dimensions, and ``reference_peak`` and ``reference_collapsed`` of restitution, which
        broadcast. An outcome is 1 for a collapse, 0 for a survival, -1 where nothing was run.
    weights : ndarray, shape (replicates, records)
        Weights of the records in each replicate, from `fragility.resample`.
    bands : sequence of pairs
        Bands of the peak under restitution; the lower edge belongs to a band. [u/u_ins]
    description : str
        Label of the progress bar; no bar if empty.
    """
    alternative = histories["peak"].transpose(*HISTORIES, ...)
    names = ("reference_peak", "reference_collapsed", "peak", "collapsed")
    arrays = []
    for name in names:
        broadcast = histories[name].broadcast_like(alternative)
        arrays.append(broadcast.transpose(*alternative.dims).values)
    shape = alternative.shape[3:]
    # The first replicate is the sample itself.
    sample = np.ones((1, weights.shape[1]))
    drawn = np.concatenate([sample, weights])
    cells = []
    for cell in track(list(np.ndindex(shape)), description):
        histories_of_cell = [values[(..., *cell)] for values in arrays]
        cells.append(_compare_cell(histories_of_cell, bands, drawn))
    statistics: dict[str, Any] = {}
    for name, first_values in cells[0].items():
        values = np.stack([cell[name] for cell in cells]).reshape(*shape, *first_values.shape)
        dims = alternative.dims[3:]
        if not name.endswith("rate"):
            dims = (*dims, "band")
        statistics[name] = (dims, values[..., 0])
        if name != "pairs":
            bounds = interval(np.moveaxis(values[..., 1:], -1, 0))
            statistics[f"{name}_interval"] = ((*dims, "bound"), bounds)
    return xr.Dataset(statistics)


def _compare_cell(
    histories: Sequence[Array],
    bands: Sequence[tuple[float, float]],
    drawn: Array,
) -> dict[str, Array]:
    """Return the statistics of one alternative in each replicate.

    The histories have the shape (record, velocity ratio, wall); `drawn` holds the weights of the
    sample itself and of the replicates.
    """
    reference_peak, reference_collapsed, peak, collapsed = histories
    both_survive = (reference_collapsed == 0) & (collapsed == 0)
    by_band = []
    for low, high in bands:
        pairs = both_survive & (reference_peak >= low) & (reference_peak < high)
        by_band.append(_compare_peaks(reference_peak, peak, pairs, drawn))
    statistics = {name: np.stack([band[name] for band in by_band]) for name in by_band[0]}
    was_run = collapsed > NOT_RUN
    collapses = (reference_collapsed == 1) & was_run
    survivals = (reference_collapsed == 0) & was_run
    missed = collapses & (collapsed == 0)
    added = survivals & (collapsed == 1)
    statistics["missed_collapse_rate"] = _rate(missed, collapses, drawn)
    statistics["added_collapse_rate"] = _rate(added, survivals, drawn)
    return statistics


def _compare_peaks(
    reference_peak: Array, peak: Array, pairs: NDArray[np.bool_], drawn: Array
) -> dict[str, Array]:
    """Return statistics of the ratio of peaks in each replicate, over the pairs that count."""
    record = np.broadcast_to(np.arange(len(peak))[:, None, None], peak.shape)[pairs]
    log_ratio = np.log(peak[pairs] / reference_peak[pairs])
    size = np.abs(log_ratio)

    def total(values: Array) -> Array:
        return drawn @ np.bincount(record, values, len(peak))

    count = total(np.ones(size.size))
    large = (size > LARGE_LOG_RATIO).astype(float)
    return {
        "median_ratio": np.exp(weighted_quantile(log_ratio, record, drawn, 0.5)),
        "log_error": root_mean_square(total(size**2), count),
        "log_error_median": weighted_quantile(size, record, drawn, 0.5),
        "log_error_90": weighted_quantile(size, record, drawn, 0.9),
        "share_above": quotient(total(large), count),
        "pairs": count.astype(int),
    }


def _rate(events: NDArray[np.bool_], cases: NDArray[np.bool_], drawn: Array) -> Array:
    """Return the share of the cases in which an event happens, in each replicate."""
    event_count = drawn @ events.sum(axis=(1, 2))
    case_count = drawn @ cases.sum(axis=(1, 2))
    return np.asarray(quotient(event_count, case_count))


def compare_fragilities(
    intensity: Array, collapses: Array, runs: Any, weights: Array, reference: Any
) -> dict[str, Array]:
    """Fit fragility curves and compare their medians with those under restitution.

    Parameters
    ----------
    intensity : ndarray, shape (stripes,)
        Intensities, ascending.
    collapses, runs : ndarray, shape (records, ..., stripes)
        Counts for each record; they broadcast.
    weights : ndarray, shape (replicates, records)
        Weights of the records in each replicate, from `fragility.resample`.
    reference : index
        Index of the curves under restitution: ``median[reference]`` broadcasts with ``median``.

    Returns
    -------
    dict of str to ndarray
        ``median``, ``dispersion`` and ``median_intensity_ratio`` of shape (...), and the interval
        of each.
    """
    fit, drawn_fits = fit_resampled(intensity, collapses, runs, weights)
    statistics = _with_ratio(fit, reference)
    # Paired: each replicate's median is divided by the one under restitution in the same replicate.
    for name, replicates in _with_ratio(drawn_fits, reference).items():
        statistics[f"{name}_interval"] = interval(replicates)
    return statistics


def _with_ratio(fit: Fragility, reference: Any) -> dict[str, Array]:
    return {
        "median": fit.median,
        "dispersion": fit.dispersion,
        "median_intensity_ratio": fit.median / fit.median[reference],
    }


def root_mean_square(squares: Any, count: Any) -> Array:
    """Return the root of sums of squares divided by their count; NaN where the count is 0."""
    return np.sqrt(quotient(squares, count))


def quotient(part: Any, whole: Any) -> Any:
    """Return part / whole; NaN where the whole is not above 0."""
    part, whole = np.broadcast_arrays(part, whole)
    return np.divide(part, whole, out=np.full(part.shape, np.nan), where=whole > 0)
