"""Compare an alternative with restitution: how far its peaks are off, and which walls it collapses otherwise.

An alternative is a damper, or restitution with a slightly different e. The same walls are shaken by the same records
with both, so histories come in pairs. These numbers describe the pairs:

- median ratio: median of the alternative's peak over that under restitution, where neither wall collapses;
- log error: root mean square of the logarithm of that ratio; log dispersion: its standard deviation; its typical size
  and its tail: the median of the logarithm's size, its 90 % quantile, and the part of the squares that comes from the
  largest hundredth of the pairs;
- unconservative and conservative errors, "collapses missed" and "added" in the documents (`false_safe`,
  `false_collapse`): collapses that only restitution, or only the alternative, has;
- median intensity ratio: the intensity that collapses half of the walls over that under restitution.

**The paired bootstrap.** The study has some dozens of stations out of all that could have recorded an earthquake; the
interval says how far another draw of stations would move a number. A replicate draws as many stations as there are,
with replacement, and each history counts as often as its record was drawn (`weights`, from `fragility.resample`). Both
components of a station are drawn together, as they saw the same earthquake. The number is computed anew from each
replicate, and the interval reaches from the 2.5 % to the 97.5 % quantile of the replicates.

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
ALL = ((0.0, np.inf),)  # one band that holds every peak
TAIL = 0.01  # of the pairs, those that are furthest apart


def bootstrapped(
    histories: xr.Dataset, weights: Array, bands: Sequence[tuple[float, float]] = ALL, description: str = ""
) -> xr.Dataset:
    """Return the statistics of each alternative at each e, with their intervals.

    `histories` has ``reference_peak`` and ``reference_collapsed`` (record, velocity_ratio, wall, restitution) under
    restitution, and ``peak`` and ``collapsed`` with the alternatives' dimensions beside these. Collapsed is 1, survived
    0, not run -1. `bands` are of the peak under restitution [u/u_ins]; `description` is that of the progress bar. False
    answers come as counts and as rates among the collapses and the survivals under restitution, of what the alternative
    ran.
    """
    order = (*HISTORIES, "restitution")
    other = histories["peak"].transpose(*order, ...)
    peak, fell = (histories[f"reference_{name}"].transpose(*order).values for name in ("peak", "collapsed"))
    peaks, falls = other.values, histories["collapsed"].transpose(*other.dims).values
    shape, dims = other.shape[3:], other.dims[3:]
    cells: dict[str, list[Any]] = {}
    for at in track(list(product(*map(range, shape))), description):
        one: Any = (..., at[0])
        index: Any = (..., *at)
        values = {
            **_ratios(peak[one], fell[one], peaks[index], falls[index], weights, bands),
            **_outcomes(fell[one] == 1, falls[index], weights),
        }
        for name, value in values.items():
            cells.setdefault(name, []).append(value)
    return xr.Dataset(
        {name: ((*dims, *_last(name)), np.reshape(cell, (*shape, *np.shape(cell[0])))) for name, cell in cells.items()}
    )


def _last(name: str) -> tuple[str, ...]:
    """Return the dimensions of a statistic beside those of the alternatives."""
    band = () if name.startswith("false") else ("band",)
    return (*band, "bound") if name.endswith("_interval") else band


def _ratios(
    reference: Array,
    fell: NDArray[np.int8],
    other: Array,
    other_fell: NDArray[np.int8],
    weights: Array,
    bands: Sequence[tuple[float, float]],
) -> dict[str, Array]:
    """Return statistics of the ratio of the peaks where both survive, in each band; histories (record, scale, wall)."""
    record = np.broadcast_to(np.arange(len(reference))[:, None, None], reference.shape)
    stand = (fell == 0) & (other_fell == 0)
    results = []
    for low, high in bands:
        part = stand & (reference >= low) & (reference < high)
        logarithm = np.log(other[part] / reference[part])
        whole, drawn = (_moments(logarithm, record[part], w) for w in (np.ones((1, len(reference))), weights))
        of_band: dict[str, Any] = {name: value[0] for name, value in whole.items()}
        of_band |= {f"{name}_interval": interval(value) for name, value in drawn.items()}
        results.append({**of_band, **tail(logarithm), "pairs": logarithm.size})
    return {name: np.array([of_band[name] for of_band in results]) for name in results[0]}


def tail(logarithm: Array) -> dict[str, float]:
    """Return what a root mean square hides of logarithms of ratios, all counted alike; NaN of none.

    The median and the 90 % quantile of their size, and the part of the sum of squares that comes from the largest
    hundredth of them, at least one.
    """
    if not logarithm.size:
        return dict.fromkeys(("log_error_median", "log_error_90", "tail_share"), np.nan)
    size = np.sort(np.abs(logarithm))
    most = size[-max(round(TAIL * size.size), 1) :]
    median, high = np.quantile(size, (0.5, 0.9))
    share = float(quotient((most**2).sum(), (size**2).sum()))
    return {"log_error_median": float(median), "log_error_90": float(high), "tail_share": share}


def _moments(logarithm: Array, record: NDArray[np.int64], weights: Array) -> dict[str, Array]:
    """Return statistics of each replicate from the logarithms of records, and the weights (replicates, records)."""
    count, total, squares = (weights @ np.bincount(record, logarithm**power, weights.shape[1]) for power in (0, 1, 2))
    mean, square = quotient(total, count), quotient(squares, count)
    return {
        "median_ratio": np.exp(weighted_quantile(logarithm, record, weights, 0.5)),
        "log_dispersion": np.sqrt(np.maximum(square - mean**2, 0.0)),
        "log_error": np.sqrt(square),
    }


def _outcomes(fell: NDArray[np.bool_], other: NDArray[np.int8], weights: Array) -> dict[str, Any]:
    """Count collapses that only one of both has, also as rates of the collapses and survivals under restitution."""
    rates: dict[str, Any] = {}
    ran = other >= 0
    for name, wrong, cases in (
        ("safe", fell & (other == 0), fell & ran),
        ("collapse", ~fell & (other == 1), ~fell & ran),
    ):
        # Sums by record: a replicate weighs them by how often it drew the record.
        wrongs, runs = (count.sum(axis=(1, 2)).astype(float) for count in (wrong, cases))
        rates[f"false_{name}"] = int(wrongs.sum())
        rates[f"false_{name}_rate"] = quotient(wrongs.sum(), runs.sum())
        rates[f"false_{name}_rate_interval"] = interval(quotient(weights @ wrongs, weights @ runs))
    return rates


def fragilities(intensity: Array, collapses: Array, runs: Any, weights: Array, reference: Any) -> dict[str, Array]:
    """Fit fragility curves, and compare their medians with restitution's; arrays of shape (...), and their intervals.

    `collapses` and `runs` count by record, shape (records, ..., stripes), and broadcast. `reference` indexes the curves
    under restitution: ``median[reference]`` broadcasts with ``median``.
    """
    whole, drawn = fit_resampled(intensity, collapses, runs, weights)
    values = {
        "median": (whole.median, drawn.median),
        "dispersion": (whole.dispersion, drawn.dispersion),
        # Paired: each replicate's median is divided by restitution's in the same replicate.
        "median_intensity_ratio": (whole.median / whole.median[reference], drawn.median / drawn.median[reference]),
    }
    estimates = {name: estimate for name, (estimate, _) in values.items()}
    return estimates | {f"{name}_interval": interval(replicates) for name, (_, replicates) in values.items()}


def root_mean_square(squares: Any, count: Any) -> Array:
    """Return the root of sums of squares over their count; NaN of none."""
    return np.sqrt(quotient(squares, count))


def quotient(part: Any, whole: Any) -> Any:
    """Return part over whole; NaN of none."""
    part, whole = np.broadcast_arrays(part, whole)
    return np.divide(part, whole, out=np.full(part.shape, np.nan), where=whole > 0)
