"""Compare an alternative with restitution: how far its peaks are off, and which walls it collapses otherwise.

An alternative is a damper, or restitution with a slightly different e. The same walls are shaken by the same records
with both, so histories come in pairs. These numbers describe the pairs:

- median ratio: median of the alternative's peak over that under restitution, where neither wall collapses;
- log error: root mean square of the logarithm of that ratio; of the logarithm's size the median, the 90 % quantile and
  the share above `LARGE`;
- missed and added collapses: those that only restitution, or only the alternative, has, as rates of the collapses and
  the survivals under restitution;
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
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rockdamp.arrays import Array
from rockdamp.progress import track
from rockdamp.statistics.fragility import fit_resampled, interval, weighted_quantile

BOUND = ("lower", "upper")
HISTORIES = ("record", "velocity_ratio", "wall")
LARGE = 0.05  # of the size of a logarithm
NOT_RUN = -1  # as an outcome


def compare_pairs(
    histories: xr.Dataset,
    weights: Array,
    bands: Sequence[tuple[float, float]],
    description: str = "",
) -> xr.Dataset:
    """Return the statistics of each alternative with their intervals, those of the peaks by band.

    Parameters
    ----------
    histories : xarray.Dataset
        ``peak`` [u/u_ins] and ``collapsed`` of the alternatives over `HISTORIES` and dimensions of their own, and
        ``reference_peak`` and ``reference_collapsed``, which broadcast. Collapsed is 1, survived 0, not run -1.
    weights : ndarray, shape (replicates, records)
        Of `fragility.resample`.
    bands : sequence of pairs
        Of the reference's peak; the first edge belongs to a band. [u/u_ins]
    description : str
        Of the progress bar; none if empty.
    """
    other = histories["peak"].transpose(*HISTORIES, ...)
    names = ("reference_peak", "reference_collapsed", "peak", "collapsed")
    arrays = [histories[name].broadcast_like(other).transpose(*other.dims).values for name in names]
    shape, dims = other.shape[3:], other.dims[3:]
    drawn = np.concatenate(
        [np.ones((1, weights.shape[1])), weights]
    )  # the first replicate is the sample itself
    cells = []
    for at in track(list(np.ndindex(shape)), description):
        reference, fell, peak, falls = (values[(..., *at)] for values in arrays)
        stand = (fell == 0) & (falls == 0)
        by_band = [
            _compare_peaks(reference, peak, stand & (reference >= low) & (reference < high), drawn)
            for low, high in bands
        ]
        rates = {
            "missed_collapse_rate": _rate(
                (fell == 1) & (falls == 0), (fell == 1) & (falls >= 0), drawn
            ),
            "added_collapse_rate": _rate(
                (fell == 0) & (falls == 1), (fell == 0) & (falls >= 0), drawn
            ),
        }
        cells.append(
            {name: np.stack([one[name] for one in by_band]) for name in by_band[0]} | rates
        )
    statistics = {}
    for name in cells[0]:
        values = np.stack([cell[name] for cell in cells]).reshape(*shape, *cells[0][name].shape)
        band = () if name.endswith("rate") else ("band",)
        statistics[name] = ((*dims, *band), values[..., 0])
        if name != "pairs":
            statistics[f"{name}_interval"] = (
                (*dims, *band, "bound"),
                interval(np.moveaxis(values[..., 1:], -1, 0)),
            )
    return xr.Dataset(statistics)


def _compare_peaks(
    reference: Array, peak: Array, among: NDArray[np.bool_], drawn: Array
) -> dict[str, Array]:
    """Return statistics of the ratio of peaks in each replicate; histories (record, velocity ratio, wall)."""
    record = np.broadcast_to(np.arange(len(peak))[:, None, None], peak.shape)[among]
    logarithm = np.log(peak[among] / reference[among])
    size = np.abs(logarithm)

    def total(values: Array) -> Array:
        return drawn @ np.bincount(record, values, len(peak))

    count = total(np.ones(size.size))
    return {
        "median_ratio": np.exp(weighted_quantile(logarithm, record, drawn, 0.5)),
        "log_error": root_mean_square(total(size**2), count),
        "log_error_median": weighted_quantile(size, record, drawn, 0.5),
        "log_error_90": weighted_quantile(size, record, drawn, 0.9),
        "share_above": quotient(total((size > LARGE).astype(float)), count),
        "pairs": count.astype(int),
    }


def _rate(wrong: NDArray[np.bool_], cases: NDArray[np.bool_], drawn: Array) -> Array:
    """Return in which part of the cases something is wrong, in each replicate."""
    return np.asarray(quotient(*(drawn @ count.sum(axis=(1, 2)) for count in (wrong, cases))))


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
