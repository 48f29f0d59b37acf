"""Collapse fragility: lognormal curves by maximum likelihood, with bootstrap intervals.

The bootstrap draws stations. The module also has the interval of a proportion of trials in
groups, such as the components of one station.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import erfcx, ndtri

from rockdamp.arrays import Array
from rockdamp.errors import InputError, check

INTERVAL_ENDS = (0.025, 0.975)  # probabilities at the ends of a 95 % interval

_TINY = 1e-300  # keeps divisions by zero away; the quotients are not used


class Fragility(NamedTuple):
    """Lognormal fragility P(collapse) = Phi(ln(s/median)/dispersion).

    Attributes
    ----------
    median : ndarray
        Intensity at which half of the runs collapse, in the unit of the intensity; NaN where the
        counts do not define a curve.
    dispersion : ndarray
        Standard deviation of the logarithm of the intensity. [-]
    reason : ndarray of str
        Reason why there is no curve; empty where there is one.
    """

    median: Array
    dispersion: Array
    reason: NDArray[np.str_]


def fit_fragility(intensity: ArrayLike, collapses: ArrayLike, runs: ArrayLike) -> Fragility:
    """Fit lognormal fragility curves to counts of collapses by maximum likelihood.

    The likelihood of binomial outcomes (Baker 2015, doi:10.1193/021113EQS025M) is that of a probit
    regression on ln s. It is concave, and Newton's method maximises it for all curves at once.

    Parameters
    ----------
    intensity : ndarray, shape (stripes,)
        Intensities, ascending and greater than 0, in any unit.
    collapses : ndarray, shape (..., stripes)
        Number of runs that collapse, or the sum of their weights. [-]
    runs : ndarray, shape (..., stripes)
        Number of runs, or the sum of their weights; it broadcasts with `collapses`. [-]

    Returns
    -------
    Fragility
        ``median`` and ``dispersion``, of shape (...). They are NaN, and ``reason`` states why,
        where no curve is the most likely or Newton's method does not converge. If no intensity with
        a collapse lies below one with a survival, any small dispersion fits equally well.

    Raises
    ------
    InputError
        If the intensities are not positive and ascending, or a count is below 0 or above the runs.

    Examples
    --------
    >>> import rockdamp as rd
    >>> curve = rd.fit_fragility([0.2, 0.4, 0.8, 1.6], collapses=[0, 4, 30, 43], runs=44)
    >>> round(float(curve.median), 3), round(float(curve.dispersion), 3)
    (0.676, 0.401)
    """
    s = check("intensity", intensity, lambda s: s > 0, "greater than 0")
    if s.ndim != 1:
        raise InputError(f"intensity has {s.ndim} dimensions; it must have one")
    steps = np.diff(s)
    check("step from one intensity to the next", steps, lambda step: step > 0, "greater than 0")
    runs = check("runs", runs, lambda n: n >= 0, "at least 0")
    collapses = check(
        "collapses", collapses, lambda k: (k >= 0) & (k <= runs), "at least 0 and at most the runs"
    )
    k, n, _ = np.broadcast_arrays(collapses, runs, s)
    lowest_collapse, highest_survival = _outcome_stripes(k, n)
    defined = lowest_collapse < highest_survival
    x = np.log(s)
    center = x.mean()
    spread = max(float(x.std()), 1e-12)  # of a single stripe it is 0
    a, b, converged = _maximize_likelihood((x - center) / spread, k[defined], n[defined])
    rises = np.zeros(defined.shape, dtype=bool)
    rises[defined] = b > 1e-9  # a smaller slope is the rounding of a share that does not rise
    fitted = converged & rises[defined]
    median = np.full(defined.shape, np.nan)
    dispersion = np.full(defined.shape, np.nan)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        median[defined] = np.where(fitted, np.exp(center - spread * a / b), np.nan)
        dispersion[defined] = np.where(fitted, spread / b, np.nan)
    reasons = {
        "": np.isfinite(median),
        "no fragility curve: there are no records": np.all(n == 0, axis=-1),
        "no fragility curve: no record causes collapse": np.all(k == 0, axis=-1),
        "no fragility curve: every record causes collapse": np.all(k == n, axis=-1),
        "no fragility curve: the fit does not converge": rises,
        "no fragility curve: the share of collapses does not rise with intensity": defined,
        "no fragility curve: at only one intensity do some records cause collapse and others not": (
            lowest_collapse == highest_survival
        ),
    }
    separated = (
        "no fragility curve: all records cause collapse from one intensity on, and none below it"
    )
    reason = np.select(list(reasons.values()), list(reasons), separated)
    return Fragility(median, dispersion, reason)


def fit_resampled(
    intensity: ArrayLike, collapses: ArrayLike, runs: ArrayLike, weights: Array
) -> tuple[Fragility, Fragility]:
    """Fit fragility curves to all records, and to each replicate of a bootstrap.

    A replicate draws whole groups, and groups differ in size: its runs are those of the records
    that it drew.

    Parameters
    ----------
    intensity : ndarray, shape (stripes,)
        Intensities, ascending.
    collapses, runs : ndarray, shape (records, ..., stripes)
        Counts for each record; they broadcast.
    weights : ndarray, shape (replicates, records)
        Weights of the records in each replicate, from `resample`.
    """
    collapses = np.asarray(collapses, dtype=float)
    runs = np.asarray(runs, dtype=float)
    collapses, runs = np.broadcast_arrays(collapses, runs)
    whole = fit_fragility(intensity, collapses.sum(axis=0), runs.sum(axis=0))
    drawn_collapses = np.tensordot(weights, collapses, 1)
    drawn_runs = np.tensordot(weights, runs, 1)
    return whole, fit_fragility(intensity, drawn_collapses, drawn_runs)


def _outcome_stripes(k: Array, n: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the index of the lowest stripe with a collapse, and of the highest with a survival."""
    stripes = np.arange(k.shape[-1])
    lowest_collapse = np.where(k > 0, stripes, k.shape[-1]).min(axis=-1)
    highest_survival = np.where(n > k, stripes, -1).max(axis=-1)
    return lowest_collapse, highest_survival


def _maximize_likelihood(z: Array, k: Array, n: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return a and b of the most likely P = Phi(a + b z), and whether they converged.

    The counts have the shape (curves, stripes).
    """
    total = np.maximum(n.sum(axis=-1), _TINY)
    # A start that rises with the share of collapses; Newton's method needs no better one.
    a = 2 * k.sum(axis=-1) / total - 1
    b = np.ones(k.shape[0])
    converged = np.zeros(k.shape[0], dtype=bool)
    for _ in range(50):  # counts drawn from a curve need fewer than 20, but for 1 in 100
        eta = a[:, None] + b[:, None] * z
        # The normal density divided by Phi(eta), and by Phi(-eta).
        collapse_ratio = np.sqrt(2 / np.pi) / erfcx(-eta / np.sqrt(2))
        survival_ratio = np.sqrt(2 / np.pi) / erfcx(eta / np.sqrt(2))
        slope = k * collapse_ratio - (n - k) * survival_ratio
        curvature = k * collapse_ratio * (collapse_ratio + eta)
        curvature = curvature + (n - k) * survival_ratio * (survival_ratio - eta)
        gradient_a = slope.sum(axis=-1)
        gradient_b = (slope * z).sum(axis=-1)
        h_aa = curvature.sum(axis=-1)
        h_ab = (curvature * z).sum(axis=-1)
        h_bb = (curvature * (z * z)).sum(axis=-1)
        determinant = np.maximum(h_aa * h_bb - h_ab * h_ab, _TINY)
        step_a = (h_bb * gradient_a - h_ab * gradient_b) / determinant
        step_b = (h_aa * gradient_b - h_ab * gradient_a) / determinant
        # No step moves the linear predictor by more than 2, or Newton's method may overshoot.
        largest_move = np.abs(step_a) + np.abs(step_b) * np.abs(z).max()
        shortening = np.minimum(1.0, 2.0 / np.maximum(largest_move, _TINY))
        step_a = shortening * step_a
        step_b = shortening * step_b
        a = a + step_a
        b = b + step_b
        converged = np.maximum(np.abs(step_a), np.abs(step_b)) < 1e-10
        if converged.all():
            break
    return a, b, converged


# --- the bootstrap -----------------------------------------------------------------------------


def resample(groups: ArrayLike, replicates: int, seed: int) -> Array:
    """Return how often each replicate draws each record, shape (replicates, records).

    Whole groups are drawn, with replacement, as the two components of a station are not
    independent.

    Parameters
    ----------
    groups : array-like, shape (records,)
        Group of each record, such as its station.
    replicates : int
        Number of replicates.
    seed : int
        Seed of the draws.
    """
    _, group = np.unique(np.asarray(groups), return_inverse=True)
    count = int(group.max()) + 1
    draws = np.random.default_rng(seed).integers(0, count, (replicates, count))
    group_weights = np.stack([np.bincount(draw, minlength=count) for draw in draws])
    return group_weights.astype(float)[:, group]


def weighted_quantile(
    values: Array, record: NDArray[np.int64], weights: Array, probability: float
) -> Array:
    """Return a quantile of values in each replicate of a bootstrap.

    It is the inverse of the weighted distribution function, averaged where that is flat.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Values, of any order.
    record : ndarray of int, shape (n,)
        Index of the record of each value.
    weights : ndarray, shape (replicates, records)
        Whole numbers, from `resample`.
    probability : float
        Probability of the quantile, 0 to 1.

    Returns
    -------
    ndarray, shape (replicates,)
        Quantiles; NaN where no value was drawn.
    """
    order = np.argsort(values, kind="stable")
    # Row i counts, for each record, its values among the i least.
    counts = np.zeros((values.size + 1, weights.shape[1]))
    counts[np.arange(1, values.size + 1), record[order]] = 1.0
    np.cumsum(counts, axis=0, out=counts)
    total = weights @ counts[-1]
    if not values.size:
        return np.full(total.shape, np.nan)
    # Weights are whole numbers, so a sum within 1e-12 of the target is equal to it. There the
    # distribution function is flat, and the two indices differ.
    target = probability * total
    low_index = _first_above(target * (1 - 1e-12), weights, counts)
    high_index = _first_above(target * (1 + 1e-12), weights, counts)
    ordered = values[order]
    middle = 0.5 * (ordered[low_index] + ordered[high_index])
    return np.where(total > 0, middle, np.nan)


def _first_above(target: Array, weights: Array, counts: Array) -> NDArray[np.int64]:
    """Return the index of the first value up to which the weight exceeds a target, by bisection."""
    low = np.zeros(target.size, dtype=np.int64)
    high = np.full(target.size, len(counts) - 2)
    while np.any(low < high):
        middle = (low + high) // 2
        above = np.einsum("ij,ij->i", weights, counts[middle + 1]) > target
        low = np.where(above, low, np.minimum(middle + 1, high))
        high = np.where(above, middle, high)
    return low


def interval(drawn: Array) -> Array:
    """Return the 95 % interval over the replicates of a bootstrap, the first axis, shape (..., 2).

    It is NaN where under nine in ten replicates define a value.
    """
    known = np.isfinite(drawn)
    count = known.sum(axis=0)
    ordered = np.sort(np.where(known, drawn, np.inf), axis=0)
    bounds = []
    for probability in INTERVAL_ENDS:
        place = (probability * (count - 1)).round().astype(int)
        place = np.clip(place, 0, len(drawn) - 1)
        bounds.append(np.take_along_axis(ordered, place[None], axis=0)[0])
    enough = count >= 0.9 * len(drawn)
    return np.where(enough[..., None], np.stack(bounds, axis=-1), np.nan)


# --- proportions -------------------------------------------------------------------------------


def wilson(share: ArrayLike, count: ArrayLike) -> Array:
    r"""Return the 95 % score interval of a proportion, shape (..., 2), within 0 to 1.

    .. math::
        \frac{\hat{p} + \frac{z^2}{2 n}
        \pm z \sqrt{\frac{\hat{p} (1 - \hat{p})}{n} + \frac{z^2}{4 n^2}}}{1 + z^2/n}

    Parameters
    ----------
    share : ndarray
        Proportion of successes, 0 to 1.
    count : ndarray
        Number of trials, which need not be whole.

    References
    ----------
    Wilson E.B. (1927). Probable inference, the law of succession, and statistical inference.
    *Journal of the American Statistical Association* 22(158), 209-212,
    doi:10.1080/01621459.1927.10502953.
    """
    p = np.asarray(share, dtype=float)
    n = np.asarray(count, dtype=float)
    p, n = np.broadcast_arrays(p, n)
    z = float(ndtri(INTERVAL_ENDS[1]))
    middle = p + z * z / (2 * n)
    half = z * np.sqrt(p * (1 - p) / n + (z / (2 * n)) ** 2)
    bounds = np.stack([middle - half, middle + half], axis=-1) / (1 + z * z / n)[..., None]
    # Rounding misses these ends.
    bounds[p == 0, 0] = 0.0
    bounds[p == 1, 1] = 1.0
    return bounds


def effective_count(counted: NDArray[Any], groups: ArrayLike, replicates: int, seed: int) -> Array:
    """Return the number of independent trials that tell as much as the grouped ones.

    It is p (1 - p), divided by the variance of the proportion p in a bootstrap over the groups
    (Kish 1965, *Survey Sampling*, Wiley): the number of trials if the outcomes within a group are
    independent; the number of groups if they agree, or if none or all are counted.

    Parameters
    ----------
    counted : ndarray of bool, shape (trials, ...)
        Outcomes.
    groups : ndarray, shape (trials,)
        Group of each trial.
    replicates : int
        Number of replicates of the bootstrap.
    seed : int
        Seed of the bootstrap.
    """
    trials = len(counted)
    group_count = np.unique(np.asarray(groups)).size
    if group_count == trials:
        return np.full(counted.shape[1:], float(trials))
    weights = resample(groups, replicates, seed)
    p = counted.mean(axis=0)
    drawn_sums = np.tensordot(weights, counted.astype(float), 1)
    drawn_shares = (drawn_sums.T / weights.sum(axis=1)).T
    # With g groups the variance of a bootstrap is (g - 1)/g of the true one.
    variance = drawn_shares.var(axis=0) * group_count / max(group_count - 1, 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        effective = np.where((p > 0) & (p < 1), p * (1 - p) / variance, group_count)
    return np.clip(effective, group_count, trials)
