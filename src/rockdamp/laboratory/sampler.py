"""Draws from a posterior and the evidence of its model, by the nested sampling of the package nautilus.

Nested sampling starts from draws of the whole prior and closes in on the posterior, which takes the longer the smaller
the posterior is within the prior: of a record it is some 1e-12 of it. Nearly all of that way is spared, as the place of
the posterior is known beforehand, by a change of variables (`Neighbourhood`): the cube that nautilus meets is the
prior's, stretched where the posterior is thought to be. The density is corrected for the stretch, so that posterior and
evidence are those of the prior, wherever the stretch was put: a poor guess costs time alone. Of a good guess draws of
the whole cube suffice, which is importance sampling; only otherwise does nautilus close in.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.stats import t

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.progress import counting

DEGREES = 2.0  # of freedom of the neighbourhood's t distributions: their tails reach what is far from the guess
AT_ONCE = 256  # densities, while all draws are of the whole cube
GOOD = 0.15  # effective share of the first of these, from which on the guess is good
WIDER = 1.5  # the neighbourhood than the guess of the posterior, where it is not
# Few large batches: the bounds that nautilus computes between two of them take longer than the densities.
LIVE, BATCH = 100, 512  # live points, and densities computed at once
REMAINING = 0.5  # share of the evidence in the live points at which nautilus stops to close in, and draws
# Densities computed at most, to close in and for each effective draw: where these do not suffice, the record seldom
# determines the model's parameters at all.
MOST, MOST_A_DRAW = 4_000, 6
ZERO = -1e100  # logarithm of a density that is zero: nautilus takes finite numbers alone


@dataclass(frozen=True)
class Neighbourhood:
    """A distribution over the unit cube about a guess of the posterior, as a map from another unit cube.

    Each coordinate has a t distribution whose centre follows from the coordinates before it, and which is cut off at
    the bounds. So no point falls outside, even where the posterior lies at a bound.
    """

    centre: Array
    lower: Array  # triangular root of the covariance

    def points(self, cube: Array) -> tuple[Array, Array]:
        """Map another unit cube to this one: points, and the logarithm of the distribution's density there."""
        tails = t(DEGREES)
        standard, points, log_density = np.empty_like(cube), np.empty_like(cube), np.zeros(len(cube))
        for i, (row, centre) in enumerate(zip(self.lower, self.centre, strict=True)):
            middle, scale = centre + standard[:, :i] @ row[:i], row[i]
            below, above = tails.cdf(-middle / scale), tails.sf((1 - middle) / scale)
            inside = 1 - below - above
            # From whichever end is nearer, as 1 - p has no digits left where p is small.
            p, q = below + cube[:, i] * inside, above + (1 - cube[:, i]) * inside
            standard[:, i] = np.where(p < q, tails.ppf(np.minimum(p, 0.5)), tails.isf(np.minimum(q, 0.5)))
            points[:, i] = middle + scale * standard[:, i]
            log_density += tails.logpdf(standard[:, i]) - np.log(scale * inside)
        return points, log_density


@dataclass(frozen=True)
class Draws:
    """Weighted draws from a posterior over the unit cube, and the likelihood averaged over the prior, the evidence."""

    points: Array  # shape (draws, dimensions)
    weights: Array  # of sum 1
    log_density: Array
    log_evidence: float

    @property
    def effective(self) -> float:
        """Effective number of draws. [-]"""
        return float(1 / np.sum(self.weights**2))

    @property
    def error(self) -> float:
        """Standard error of the logarithm of the evidence, at most."""
        return float(1 / np.sqrt(self.effective))

    def resampled(self, count: int, random: np.random.RandomState) -> Array:
        """Return draws of equal weight, shape (count, dimensions)."""
        return self.points[random.choice(self.weights.size, count, p=self.weights)]


def sample(log_density: Callable[[Array], Array], about: Neighbourhood, effective: float, seed: int) -> Draws:
    """Draw from a density over the unit cube until enough draws are effective; the same seed gives the same draws.

    The density is -inf where it is zero. It raises `InputError` if so many draws take too long, or nautilus is missing.
    """

    most = MOST + round(MOST_A_DRAW * effective)
    with counting(most, "draws, by likelihoods at most") as advance:

        def stretched(about: Neighbourhood, cube: Array) -> Array:
            points, stretch = about.points(cube)
            density = np.maximum(log_density(points) - stretch, ZERO)
            advance(len(cube))
            return density

        drawn = _of_cube(partial(stretched, about), about.centre.size, effective, most, seed)
        if drawn is None:
            about = replace(about, lower=WIDER * about.lower)
            drawn = _closing_in(partial(stretched, about), about.centre.size, effective, most, seed)
    if drawn is None:
        raise InputError(f"{most} likelihoods do not suffice for the posterior; the record may not determine it")
    cube, log_weights, log_stretched, log_evidence = drawn
    points, stretch = about.points(cube)
    weights = np.exp(log_weights - log_weights.max())
    return Draws(points, weights / weights.sum(), log_stretched + stretch, log_evidence)


Drawn = tuple[Array, Array, Array, float]  # points, logarithms of their weights and densities, and of the evidence


def _of_cube(
    density: Callable[[Array], Array], dimensions: int, effective: float, most: int, seed: int
) -> Drawn | None:
    """Draw from the whole cube; None if few of these draws are effective."""
    most = min(most, round(effective / GOOD))
    sampler = _sampler(density, dimensions, AT_ONCE, AT_ONCE, seed)
    sampler.run(f_live=1.0, n_eff=effective, n_like_max=AT_ONCE)
    if sampler.n_eff < GOOD * AT_ONCE or not sampler.run(f_live=1.0, n_eff=effective, n_like_max=most):
        return None
    return (*sampler.posterior(), float(sampler.log_z))


def _closing_in(
    density: Callable[[Array], Array], dimensions: int, effective: float, most: int, seed: int
) -> Drawn | None:
    """Close in on the posterior, and draw anew; None if it takes too long."""
    sampler = _sampler(density, dimensions, LIVE, BATCH, seed)
    if not sampler.run(f_live=REMAINING, n_eff=effective, n_like_max=most, discard_exploration=True):
        return None
    return (*sampler.posterior(), float(sampler.log_z))


def _sampler(density: Callable[[Array], Array], dimensions: int, live: int, batch: int, seed: int) -> Any:
    return nautilus().Sampler(
        lambda cube: cube,
        density,
        dimensions,
        n_live=live,
        n_batch=batch,
        n_networks=0,  # ellipsoids alone: networks take longer to train than they spare
        vectorized=True,
        pass_dict=False,
        seed=seed,
    )


def nautilus() -> Any:
    """Import the package that only those need who ask for a posterior."""
    try:
        import nautilus
    except ImportError:
        raise InputError(
            "a posterior needs the package nautilus-sampler, the extra [laboratory]: pip install nautilus-sampler"
        ) from None
    return nautilus
