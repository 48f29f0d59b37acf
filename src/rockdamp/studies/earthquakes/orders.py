"""ECD of order m under earthquakes: from which order on is it nearer to restitution than restitution is to itself?

Restitution's own sensitivity is what a small change of e does to its peaks, smaller than any test could tell. Every
order has the damping ratio that loses what an impact takes (docs/theory.md, section 8): nothing is fitted. Differences
are taken over the same histories, and bootstrapped over the stations of the records, both components together.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
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
from rockdamp.statistics.fragility import fit_resampled, interval, resample, weighted_quantile

VARIATIONS = ("step", "lower e", "higher e")  # of CR: a step twice as long, and e a little lower and higher
BOUND = ("lower", "upper")
EVERY_SET = "all"
HISTORIES = ("record", "scale", "wall", "restitution")


def chunk(number: str, config: Config) -> xr.Dataset:
    """Run every wall under one job's share of the records, with CR, its small changes, and each order.

    Parameters
    ----------
    number : str
        Of the job, from 0.
    config : dict
        Has the keys of `OrderRecordSettings`.

    Returns
    -------
    xarray.Dataset
        ``reference_peak`` and ``reference_collapsed`` (record, scale, wall, restitution) with CR; ``varied_peak`` and
        ``varied_collapsed`` with a last dimension variation; ``peak_ratio`` and ``collapsed`` with a last
        dimension order.
    """
    given = OrderRecordSettings.of(config)
    size = given.records_per_job
    mine = catalogue.listing(given.records)[int(number) * size : (int(number) + 1) * size]
    shares = [_under(catalogue.read(entry), given) for entry in track(mine, f"Orders, records {int(number) + 1}")]
    return xr.concat(shares, "record", join="exact")


def _under(motion: catalogue.GroundMotion, given: OrderRecordSettings) -> xr.Dataset:
    """All histories of one record."""
    pgv = intensity_measures(motion.record).pgv
    per_wall = [_of_wall(named, motion, pgv, given) for named in given.walls]
    last = {"reference": (), "varied": ("variation",), "by_order": ("order",)}
    names = {
        "reference": ("reference_peak", "reference_collapsed"),
        "varied": ("varied_peak", "varied_collapsed"),
        "by_order": ("peak_ratio", "collapsed"),
    }
    data: dict[str, Any] = {}
    for key, (peak, collapsed) in names.items():
        dims = ("scale", "wall", "restitution", *last[key])
        peaks, outcomes = (np.stack([wall[key][part] for wall in per_wall], axis=1) for part in (0, 1))
        data[peak], data[collapsed] = (dims, peaks), (dims, (outcomes == COLLAPSED).astype(np.int8))
    coords = {
        "scale": given.scale,
        "wall": [named.name for named in given.walls],
        "restitution": given.restitution,
        "variation": list(VARIATIONS),
        "order": given.order,
        "record": motion.name,
    }
    of_record = {"record_set": ("record", [motion.record_set]), "station": ("record", [motion.group])}
    return xr.Dataset(data, coords=coords).expand_dims("record").assign_coords(of_record)


def _of_wall(
    named: NamedWall, motion: catalogue.GroundMotion, pgv: float, given: OrderRecordSettings
) -> dict[str, tuple[Array, NDArray[np.int8]]]:
    """Peaks and outcomes of one wall under one record: of CR (scales, e), of its changes and of the orders, last."""
    wall = named.wall
    factor = given.scale * wall.frequency_parameter * wall.instability_displacement / EXCITATION_FACTOR / pgv
    forcing = Forcing.of(wall, motion.record, factor, rest=given.tail)
    coarser = forcing.substeps(2 * given.step / named.curve.initial_frequency)

    def run(damping: Damping, substeps: int) -> tuple[Array, NDArray[np.int8]]:
        by_scale = forcing.load_factor.reshape(-1, *(1 for _ in damping.shape))
        response = solve(named.curve, damping, **replace(forcing, load_factor=by_scale).newmark(substeps))
        return response.peak, response.outcome

    e, finer = given.restitution, 2 * coarser
    # CR and CR with e changed are one batch: its lanes fill the kernel's blocks.
    changed = run(Damping.cr(e[:, None] + given.restitution_change * np.array([0.0, -1.0, 1.0])), finer)
    coarse = run(Damping.cr(e), coarser)
    orders = [run(Damping.of_restitution(e, order=float(order)), finer) for order in given.order]
    peaks, outcomes = (np.concatenate([coarse[part][..., None], changed[part][..., 1:]], axis=-1) for part in (0, 1))
    return {
        "reference": (changed[0][..., 0], changed[1][..., 0]),
        "varied": (peaks, outcomes),
        "by_order": (np.stack([peak for peak, _ in orders], -1), np.stack([outcome for _, outcome in orders], -1)),
    }


# --- what they say together -------------------------------------------------------------------------------------------


def compare(config: Config, *shares: xr.Dataset) -> xr.Dataset:
    """Compare each order with CR, and with CR's own sensitivity, over all records, by set of records and by wall.

    Parameters
    ----------
    config : dict
        Has the keys of `OrderComparisonSettings`.
    *shares : xarray.Dataset
        Of `chunk`.

    Returns
    -------
    xarray.Dataset
        For each set of records, the first of them all, each e and each order, over the histories in which neither
        collapses: ``median_ratio`` of the peak to CR's, ``log_dispersion`` and ``log_error`` (root mean square) of its
        logarithm, ``pairs``; ``false_safe_rate`` of CR's collapses and ``false_collapse_rate`` of its survivals;
        ``median_intensity_ratio`` of the fragilities. The same of CR's variations with ``varied_`` before the name.
        ``excess``: log_error less CR's own sensitivity, which is the smaller of those to a lower and a higher e, over
        the histories that stand with all of them; ``smallest_order``: from which on the excess is negative, its
        interval included; NaN where there is none; ``recommended_order``: the smallest that is enough at every e over
        all records. ``wall_excess`` and ``wall_smallest_order`` by wall, ``band_log_error`` by band of CR's peak.
        Names with ``_interval`` are 95 % bootstrap intervals over stations.
    """
    given = OrderComparisonSettings.of(config)
    histories = xr.concat(shares, "record", join="exact").transpose(*HISTORIES, "variation", "order")
    sets = [EVERY_SET, *dict.fromkeys(histories["record_set"].values.tolist())]
    parts = []
    for name in track(sets, "Orders by set of records"):
        own = histories if name == EVERY_SET else histories.isel(record=histories["record_set"].values == name)
        weights = resample(own["station"].values, given.bootstrap.replicates, given.bootstrap.seed)
        parts.append(_of_set(own, weights, given.bands))
    compared = xr.concat(parts, "record_set", join="exact")
    return compared.assign_coords(
        record_set=sets,
        wall=histories["wall"].values,
        restitution=histories["restitution"].values,
        order=histories["order"].values,
        variation=list(VARIATIONS),
        bound=list(BOUND),
        band=np.arange(1, given.bands.size),
        band_start=("band", given.bands[:-1]),
        band_end=("band", given.bands[1:]),
    ).assign(
        records=histories.sizes["record"],
        stations=np.unique(histories["station"]).size,
        restitution_change=given.restitution_change,
        recommended_order=recommended_order(compared["smallest_order"].values[0]),
    )


def _of_set(own: xr.Dataset, weights: Array, bands: Array) -> xr.Dataset:
    """Every statistic of one set of records."""
    peak, fell = own["reference_peak"].values, own["reference_collapsed"].values == 1
    alternatives = {
        "varied_": (own["varied_peak"].values, own["varied_collapsed"].values == 1, "variation"),
        "": (own["peak_ratio"].values, own["collapsed"].values == 1, "order"),
    }
    scale, found = own["scale"].values, {}
    for prefix, (peaks, falls, dim) in alternatives.items():
        cells: dict[str, list[Any]] = {}
        for at in _each(peaks.shape[3:]):
            index: Any = (..., *at)
            pair = _Pair(peak[..., at[0]], fell[..., at[0]], peaks[index], falls[index], weights)
            for name, value in {**pair.ratios(), **pair.collapses(), **pair.fragility(scale)}.items():
                cells.setdefault(name, []).append(value)
        for name, values in cells.items():
            stacked = np.array(values).reshape(*peaks.shape[3:], *np.shape(values[0]))
            found[prefix + name] = (("restitution", dim, *(("bound",) if stacked.ndim > 2 else ())), stacked)
    return xr.Dataset({**found, **_excesses(own, weights), **_by_band(own, bands)})


def _each(shape: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
    return product(*map(range, shape))


class _Pair:
    """CR and one alternative at one e; histories of shape (record, scale, wall)."""

    def __init__(
        self, peak: Array, fell: NDArray[np.bool_], other: Array, other_fell: NDArray[np.bool_], weights: Array
    ) -> None:
        self.fell, self.other_fell, self.weights = fell, other_fell, weights
        stand = ~fell & ~other_fell
        self.record = np.broadcast_to(np.arange(len(peak))[:, None, None], peak.shape)[stand]
        self.logarithm = np.log(other[stand] / peak[stand])

    def ratios(self) -> dict[str, Any]:
        """Statistics of the logarithm of the ratio of the peaks, where both stand."""
        drawn = self.weights[:, self.record]
        once = np.ones((1, self.logarithm.size))
        of_all, of_drawn = (self._moments(weight) for weight in (once, drawn))
        values = {name: value[0] for name, value in of_all.items()}
        return {
            **values,
            "pairs": self.logarithm.size,
            **{f"{name}_interval": interval(value) for name, value in of_drawn.items()},
        }

    def _moments(self, weight: Array) -> dict[str, Array]:
        mean, square = (_quotient(weight @ self.logarithm**power, weight.sum(axis=1)) for power in (1, 2))
        return {
            "median_ratio": np.exp(weighted_quantile(self.logarithm, weight, 0.5)),
            "log_dispersion": np.sqrt(np.maximum(square - mean**2, 0.0)),
            "log_error": np.sqrt(square),
        }

    def collapses(self) -> dict[str, Any]:
        """Rates of collapses that only one of both has, of CR's collapses and of its survivals."""
        rates: dict[str, Any] = {}
        for name, wrong, of in (
            ("safe", self.fell & ~self.other_fell, self.fell),
            ("collapse", ~self.fell & self.other_fell, ~self.fell),
        ):
            wrongs, runs = (count.sum(axis=(1, 2)).astype(float) for count in (wrong, of))
            rates[f"false_{name}_rate"] = float(_quotient(wrongs.sum(), runs.sum()))
            rates[f"false_{name}_rate_interval"] = interval(_quotient(self.weights @ wrongs, self.weights @ runs))
        return rates

    def fragility(self, scale: Array) -> dict[str, Any]:
        """Ratio of the median intensity of collapse to CR's, all walls together; its interval by the same draws."""
        counts = np.stack([falls.sum(axis=2) for falls in (self.other_fell, self.fell)], axis=1)  # (record, 2, scale)
        whole, drawn = fit_resampled(scale, counts, self.fell.shape[2], self.weights)
        return {
            "median_intensity_ratio": float(whole.median[0] / whole.median[1]),
            "median_intensity_ratio_interval": interval(drawn.median[:, 0] / drawn.median[:, 1]),
        }


def _excesses(own: xr.Dataset, weights: Array) -> dict[str, Any]:
    """How much more each order errs than CR with e changed, on the histories that stand with all of them."""
    shape = (own.sizes["restitution"], own.sizes["order"])
    walls = own.sizes["wall"]
    excess, bounds = np.full(shape, np.nan), np.full((*shape, 2), np.nan)
    of_wall, wall_bounds = np.full((walls, *shape), np.nan), np.full((walls, *shape, 2), np.nan)
    nearby = [VARIATIONS.index("lower e"), VARIATIONS.index("higher e")]
    for e, m in _each(shape):
        peaks = np.stack(
            [
                own["peak_ratio"].values[..., e, m],
                *np.moveaxis(own["varied_peak"].values[..., e, nearby], -1, 0),
            ]
        )
        fell = (
            own["reference_collapsed"].values[..., e]
            + own["collapsed"].values[..., e, m]
            + own["varied_collapsed"].values[..., e, nearby].sum(axis=-1)
        )
        reference = own["reference_peak"].values[..., e]
        square = np.where(fell == 0, np.log(peaks / reference) ** 2, 0.0)  # (alternative, record, scale, wall)
        sums, counts = square.sum(axis=2), (fell == 0).sum(axis=1).astype(float)  # (3, record, wall), (record, wall)
        excess[e, m], bounds[e, m] = _excess(sums.sum(axis=-1), counts.sum(axis=-1), weights)
        for wall in range(walls):
            of_wall[wall, e, m], wall_bounds[wall, e, m] = _excess(sums[..., wall], counts[:, wall], weights)
    order = own["order"].values
    by = ("restitution", "order")
    return {
        "excess": (by, excess),
        "excess_interval": ((*by, "bound"), bounds),
        "smallest_order": (("restitution",), smallest_order(order, bounds[..., 1])),
        "wall_excess": (("wall", *by), of_wall),
        "wall_excess_interval": (("wall", *by, "bound"), wall_bounds),
        "wall_smallest_order": (("wall", "restitution"), smallest_order(order, wall_bounds[..., 1])),
    }


def _excess(sums: Array, counts: Array, weights: Array) -> tuple[float, Array]:
    """Excess from sums of squares, shape (order and the two changes, record), and counts (record,)."""

    def of(weight: Array) -> Array:
        root = np.sqrt(_quotient(np.einsum("br,ar->ab", weight, sums), (weight @ counts)[None]))
        return np.asarray(root[0] - np.minimum(root[1], root[2]))

    return float(of(np.ones((1, counts.size)))[0]), interval(of(weights))


def smallest_order(order: Array, upper: Array) -> Array:
    """Return the order from which on the upper bound of the excess, shape (..., order), is at most 0; NaN if none is.

    Parameters
    ----------
    order : ndarray, shape (orders,)
        Ascending.
    upper : ndarray, shape (..., orders)
        NaN counts as beyond.
    """
    within = np.nan_to_num(upper, nan=np.inf) <= 0
    onwards = np.logical_and.accumulate(within[..., ::-1], axis=-1)[..., ::-1]
    return np.where(onwards.any(axis=-1), order[onwards.argmax(axis=-1)], np.nan)


def recommended_order(smallest: Array) -> float:
    """Return the order that is enough at every e, from the smallest at each; NaN if some e has none.

    `rockdamp.vocabulary.RECOMMENDED_ORDER` is that of the full study.

    Parameters
    ----------
    smallest : ndarray, shape (restitutions,)
        `smallest_order` of all records.
    """
    return float(np.max(smallest))


def _by_band(own: xr.Dataset, bands: Array) -> dict[str, Any]:
    """log_error of each order and variation in bands of CR's peak."""
    peak = own["reference_peak"]
    results: dict[str, Any] = {}
    for name, peaks, falls in (
        ("band_log_error", "peak_ratio", "collapsed"),
        ("varied_band_log_error", "varied_peak", "varied_collapsed"),
    ):
        stand = (own["reference_collapsed"] == 0) & (own[falls] == 0)
        square = xr.apply_ufunc(np.log, own[peaks] / peak) ** 2
        errors = [
            square.where(stand & (peak >= low) & (peak < high)).mean(("record", "scale", "wall")) ** 0.5
            for low, high in zip(bands[:-1], bands[1:], strict=True)
        ]
        results[name] = xr.concat(errors, "band").transpose("restitution", ..., "band").variable
    return results


def _quotient(one: Any, other: Any) -> Any:
    """Quotient; NaN of nothing."""
    one, other = np.broadcast_arrays(one, other)
    return np.divide(one, other, out=np.full(one.shape, np.nan), where=other > 0)
