"""Collapse fragility: lognormal curves by maximum likelihood, and the bootstrap over stations that bounds them.

And the interval of a proportion of trials that come in groups whose outcomes may agree.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import erfcx, ndtri

from rockdamp.arrays import Array
from rockdamp.errors import InputError, check

INTERVAL = (0.025, 0.975)


class Fragility(NamedTuple):
    """Lognormal fragility P(collapse) = Phi(ln(s/median)/dispersion).

    Attributes
    ----------
    median : ndarray
        Intensity at which half collapse, in the unit of the intensity; NaN where the outcomes do not define it.
    dispersion : ndarray
        Standard deviation of the logarithm of the intensity. [-]
    reason : ndarray of str
        Why there is no curve; empty where there is one.
    """

    median: Array
    dispersion: Array
    reason: NDArray[np.str_]


def fit_fragility(intensity: ArrayLike, collapses: ArrayLike, runs: ArrayLike) -> Fragility:
    """Fit lognormal fragility curves to counts of collapses at stripes of intensity, by maximum likelihood.

    The likelihood of binomial outcomes (Baker 2015, doi:10.1193/021113EQS025M) is that of a probit regression on ln s:
    it is concave, and Newton's method climbs it for all curves at once.

    Parameters
    ----------
    intensity : ndarray, shape (stripes,)
        Ascending, greater than 0.
    collapses, runs : ndarray, shape (..., stripes)
        Counts, or sums of weights; they broadcast. [-]

    Returns
    -------
    Fragility
        ``median`` and ``dispersion``, of shape (...); NaN where no curve is most likely, and ``reason`` says why:
        without a collapse below a survival the outcomes are separated and any small dispersion is as good.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.fit_fragility([0.2, 0.4, 0.8, 1.6], collapses=[0, 4, 30, 43], runs=44)
    >>> round(float(curve.median), 3), round(float(curve.dispersion), 3)
    (0.676, 0.401)
    """
    s = check("intensity", intensity, lambda s: s > 0, "greater than 0")
    if s.ndim != 1 or np.any(np.diff(s) <= 0):
        raise InputError("intensity must be ascending and have one dimension")
    runs = check("runs", runs, lambda n: n >= 0, "at least 0")
    collapses = check(
        "collapses", collapses, lambda k: (k >= 0) & (k <= runs), "at least 0 and at most the runs"
    )
    k, n, _ = np.broadcast_arrays(collapses, runs, s)
    x = np.log(s)
    center, spread = x.mean(), max(float(x.std()), 1e-12)
    defined = _overlap(k, n)
    a, b = _climb((x - center) / spread, k[defined], n[defined])
    median, dispersion = (np.full(k.shape[:-1], np.nan) for _ in range(2))
    with np.errstate(invalid="ignore", divide="ignore"):
        median[defined] = np.where(b > 0, np.exp(center - spread * a / b), np.nan)
        dispersion[defined] = np.where(b > 0, spread / b, np.nan)
    reason = np.select(
        [np.isfinite(median), np.all(k == 0, -1), np.all(k == n, -1), defined],
        ["", "no run collapses", "every run collapses", "collapses become fewer with intensity"],
        "all runs collapse from one stripe on, and none below it",
    )
    return Fragility(
        median, dispersion, np.where(reason == "", "", np.char.add("no fragility: ", reason))
    )


def fit_resampled(
    intensity: ArrayLike, collapses: ArrayLike, runs: ArrayLike, weights: Array
) -> tuple[Fragility, Fragility]:
    """Fit fragility curves to counts by record: of all records, and of each replicate of a bootstrap.

    `collapses` and `runs` have the shape (records, ..., stripes) and broadcast; `weights` is that of `resample`. A
    replicate draws whole groups, and groups differ in size: its runs are those of what it drew, not all of them.
    """
    counts = np.broadcast_arrays(np.asarray(collapses, dtype=float), np.asarray(runs, dtype=float))
    whole = fit_fragility(intensity, *(count.sum(axis=0) for count in counts))
    return whole, fit_fragility(intensity, *(np.tensordot(weights, count, 1) for count in counts))


def _overlap(k: Array, n: Array) -> NDArray[np.bool_]:
    """Return which curves have a collapse at a lower stripe than a survival."""
    stripes = np.arange(k.shape[-1])
    lowest = np.where(k > 0, stripes, k.shape[-1]).min(axis=-1)
    highest = np.where(n > k, stripes, -1).max(axis=-1)
    return np.asarray(lowest < highest)


def _climb(z: Array, k: Array, n: Array) -> tuple[Array, Array]:
    """Maximise the log likelihood of P = Phi(a + b z) by Newton's method, for counts of shape (curves, stripes)."""
    total = np.maximum(n.sum(axis=-1), 1e-300)
    a, b = 2 * k.sum(axis=-1) / total - 1, np.ones(k.shape[0])
    for _ in range(50):
        eta = a[:, None] + b[:, None] * z
        # The normal density over Phi(eta), and over Phi(-eta).
        up, down = (np.sqrt(2 / np.pi) / erfcx(side * eta / np.sqrt(2)) for side in (-1.0, 1.0))
        slope = k * up - (n - k) * down
        curvature = k * up * (up + eta) + (n - k) * down * (down - eta)
        g0, g1 = slope.sum(axis=-1), (slope * z).sum(axis=-1)
        h00, h01, h11 = (np.sum(curvature * power, axis=-1) for power in (1.0, z, z * z))
        determinant = np.maximum(h00 * h11 - h01 * h01, 1e-300)
        da, db = (h11 * g0 - h01 * g1) / determinant, (h00 * g1 - h01 * g0) / determinant
        # No step moves the linear predictor by more than 2.
        shorten = np.minimum(
            1.0, 2.0 / np.maximum(np.abs(da) + np.abs(db) * np.abs(z).max(), 1e-300)
        )
        a, b = a + shorten * da, b + shorten * db
        if not a.size or max(np.abs(shorten * da).max(), np.abs(shorten * db).max()) < 1e-10:
            break
    return a, b


# --- the bootstrap ----------------------------------------------------------------------------------------------------


def resample(groups: ArrayLike, replicates: int, seed: int) -> Array:
    """Return bootstrap weights: how often each record is drawn in each replicate, shape (replicates, records).

    Whole groups are drawn, with replacement: the two components of a station are not independent.
    """
    _, group = np.unique(np.asarray(groups), return_inverse=True)
    count = int(group.max()) + 1
    drawn = np.random.default_rng(seed).integers(0, count, (replicates, count))
    return np.stack([np.bincount(row, minlength=count) for row in drawn]).astype(float)[:, group]


def weighted_quantile(
    values: Array, record: NDArray[np.int64], weights: Array, probability: float
) -> Array:
    """Return the quantile of values, shape (n,), of these records, by each replicate's weights of the records.

    The inverse of the weighted distribution function, averaged where it is flat; NaN where nothing was drawn. The
    weights are those of `resample`.
    """
    order = np.argsort(values, kind="stable")
    upto = np.zeros(
        (values.size + 1, weights.shape[1])
    )  # of each record's values, how many are among the least
    upto[np.arange(1, values.size + 1), record[order]] = 1.0
    np.cumsum(upto, axis=0, out=upto)
    total = weights @ upto[-1]
    if not values.size:
        return np.full(total.shape, np.nan)

    def first(target: Array) -> NDArray[np.int64]:
        """Return the first value, by bisection, up to which a weight lies that is above the target."""
        low, high = np.zeros(total.size, dtype=np.int64), np.full(total.size, values.size - 1)
        while np.any(low < high):
            middle = (low + high) // 2
            above = np.einsum("ij,ij->i", weights, upto[middle + 1]) > target
            low, high = (
                np.where(above, low, np.minimum(middle + 1, high)),
                np.where(above, middle, high),
            )
        return low

    # Weights are whole numbers: so small a part of them decides between equal and above.
    ends = [values[order][first(probability * total * (1 + side * 1e-12))] for side in (-1.0, 1.0)]
    return np.where(total > 0, 0.5 * (ends[0] + ends[1]), np.nan)


def interval(drawn: Array) -> Array:
    """Return the 95 % interval over the replicates, the first axis; NaN where under nine in ten define a value."""
    known = np.isfinite(drawn)
    order, count = np.sort(np.where(known, drawn, np.inf), axis=0), known.sum(axis=0)
    places = [np.clip((p * (count - 1)).round().astype(int), 0, len(drawn) - 1) for p in INTERVAL]
    bounds = np.stack(
        [np.take_along_axis(order, place[None], axis=0)[0] for place in places], axis=-1
    )
    return np.where((count >= 0.9 * len(drawn))[..., None], bounds, np.nan)


# --- proportions ------------------------------------------------------------------------------------------------------


def wilson(share: ArrayLike, count: ArrayLike) -> Array:
    r"""Return the 95 % score interval of a proportion, shape (..., 2), within 0 to 1; `count` need not be whole.

    .. math::
        \frac{\hat{p} + \frac{z^2}{2 n} \pm z \sqrt{\frac{\hat{p} (1 - \hat{p})}{n} + \frac{z^2}{4 n^2}}}{1 + z^2/n}

    Wilson E.B. (1927). Probable inference, the law of succession, and statistical inference. *Journal of the American
    Statistical Association* 22(158), 209-212, doi:10.1080/01621459.1927.10502953.
    """
    p, n = np.broadcast_arrays(np.asarray(share, dtype=float), np.asarray(count, dtype=float))
    z = float(ndtri(INTERVAL[1]))
    middle, half = p + z * z / (2 * n), z * np.sqrt(p * (1 - p) / n + (z / (2 * n)) ** 2)
    bounds = np.stack([middle - half, middle + half], axis=-1) / (1 + z * z / n)[..., None]
    bounds[p == 0, 0], bounds[p == 1, 1] = 0.0, 1.0  # which rounding misses
    return bounds


def effective_count(counted: NDArray[Any], groups: ArrayLike, replicates: int, seed: int) -> Array:
    """Return how many independent trials would leave the proportion as uncertain as the groups do.

    It is p (1 - p) over the variance of the proportion in a bootstrap over the groups (Kish 1965): as many as there are
    trials where those of a group know nothing of each other, as many as there are groups where they agree, or where
    none or all are `counted`, shape (trials, ...).
    """
    trials, number = len(counted), np.unique(np.asarray(groups)).size
    if number == trials:
        return np.full(counted.shape[1:], float(trials))
    weights, p = resample(groups, replicates, seed), counted.mean(axis=0)
    drawn = (np.tensordot(weights, counted.astype(float), 1).T / weights.sum(axis=1)).T
    # Of g groups a bootstrap varies by (g - 1)/g too little.
    variance = drawn.var(axis=0) * number / max(number - 1, 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        effective = np.where((p > 0) & (p < 1), p * (1 - p) / variance, number)
    return np.clip(effective, number, trials)
