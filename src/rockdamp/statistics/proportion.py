"""Interval of a proportion of trials that come in groups whose outcomes may agree."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri

from rockdamp.arrays import Array
from rockdamp.statistics.fragility import INTERVAL, resample

QUANTILE = float(ndtri(INTERVAL[1]))  # of the normal distribution


def wilson(share: ArrayLike, count: ArrayLike) -> Array:
    r"""Return the 95 % score interval of a proportion, shape (..., 2), within 0 to 1; `count` need not be whole.

    .. math::
        \frac{\hat{p} + \frac{z^2}{2 n} \pm z \sqrt{\frac{\hat{p} (1 - \hat{p})}{n} + \frac{z^2}{4 n^2}}}{1 + z^2/n}

    Wilson E.B. (1927). Probable inference, the law of succession, and statistical inference. *Journal of the American
    Statistical Association* 22(158), 209-212, doi:10.1080/01621459.1927.10502953.
    """
    p, n = np.broadcast_arrays(np.asarray(share, dtype=float), np.asarray(count, dtype=float))
    z = QUANTILE
    middle, half = p + z * z / (2 * n), z * np.sqrt(p * (1 - p) / n + (z / (2 * n)) ** 2)
    return np.clip(np.stack([middle - half, middle + half], axis=-1) / (1 + z * z / n)[..., None], 0.0, 1.0)


def effective_count(counted: NDArray[Any], groups: ArrayLike, replicates: int, seed: int) -> Array:
    """Return how many independent trials would leave the proportion as uncertain as the groups do.

    It is p (1 - p) over the variance of the proportion in a bootstrap over the groups (Kish 1965): as many as there are
    trials where those of a group know nothing of each other, as many as there are groups where they agree, or where
    none or all are `counted`, shape (trials, ...).
    """
    trials, number = len(counted), np.unique(np.asarray(groups)).size
    if number == trials:
        return np.full(counted.shape[1:], float(trials))
    weights = resample(groups, replicates, seed)
    values = counted.astype(float)
    drawn = np.tensordot(weights, values, 1) / weights.sum(axis=1).reshape(-1, *(1 for _ in values.shape[1:]))
    # Of g groups a bootstrap varies by (g - 1)/g too little.
    variance = drawn.var(axis=0) * number / max(number - 1, 1)
    p = values.mean(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        effective = np.where((p > 0) & (p < 1), p * (1 - p) / variance, number)
    return np.clip(effective, number, trials)
