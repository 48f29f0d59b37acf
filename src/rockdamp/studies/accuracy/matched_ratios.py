"""How precise the published damping ratios are: their stored bounds, and minima of Eq. (17) by the exact solver."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from operator import itemgetter

import numpy as np
import xarray as xr
from scipy.optimize import minimize_scalar

from rockdamp.config.parsing import Config
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.progress import track
from rockdamp.solvers import event_driven
from rockdamp.studies.decays import describe

THOUSANDTH = 1e-3
QUANTILES = np.concatenate([np.linspace(0.0, 0.98, 50), [0.99, 1.0]])
SPACING = 0.0005  # in tau, of the samples of the integral: halving it moves no minimum by more than 3e-7 of itself

Matches = Mapping[str, xr.Dataset]


@dataclass(frozen=True)
class Published:
    """One published damping ratio and what it belongs to; `bound` is its uncertainty over itself."""

    curve: TrilinearCurve
    release_amplitude: float
    restitution: float
    model: str
    ratio: float
    bound: float


def relative_uncertainty(match: xr.Dataset) -> xr.DataArray:
    """Return the uncertainty of each damping ratio over the damping ratio. [-]"""
    return match["damping_ratio_uncertainty"] / match["damping_ratio"]


def uncertainty(matches: Matches) -> xr.Dataset:
    """Summarise the bounds of all published damping ratios, per model: quantiles, and the share within 0.1 %.

    A quantile is a value that occurs, the next larger one in doubt.
    """
    models = [str(model) for model in next(iter(matches.values()))["damping_model"].values]
    each = [relative_uncertainty(match).transpose("damping_model", ...).values for match in matches.values()]
    together = np.concatenate([values.reshape(len(models), -1) for values in each], axis=1)
    quantile = np.quantile(together, QUANTILES, axis=1, method="higher").T
    return xr.Dataset(
        {
            "uncertainty_quantile": (("viscous_model", "quantile"), quantile),
            "share_within_thousandth": ("viscous_model", (together < THOUSANDTH).mean(axis=1)),
            "published_count": together.shape[1],
        },
        coords={"viscous_model": models, "quantile": QUANTILES},
    )


def sample(config: Config, matches: Matches) -> dict[str, list[Published]]:
    """Choose published damping ratios of each model: half the least certain, half drawn from the studies in turn."""
    rng, count = np.random.default_rng(config["accuracy"]["seed"]), config["accuracy"]["minima"]
    names = list(matches)
    models = [str(model) for model in matches[names[0]]["damping_model"].values]
    relative = {name: relative_uncertainty(match) for name, match in matches.items()}
    bounds = {name: values.transpose("damping_model", ...).values for name, values in relative.items()}
    chosen = {}
    for m, model in enumerate(models):
        ranked = sorted(
            ((name, place) for name in names for place in np.ndindex(bounds[name][m].shape)),
            key=lambda one, m=m: -bounds[one[0]][m][one[1]],  # type: ignore[misc]
        )
        places = ranked[: least(config)]
        while len(places) < count:
            name = names[(m + len(places)) % len(names)]
            place = tuple(int(rng.integers(size)) for size in bounds[name][m].shape)
            places.append((name, place))
        chosen[model] = [_published(config, matches[name], name, model, *place) for name, place in places]
    return chosen


def least(config: Config) -> int:
    """Return how many of the sample are the least certain ones: half, rounded up."""
    return -(-int(config["accuracy"]["minima"]) // 2)


def _published(config: Config, match: xr.Dataset, name: str, model: str, value: int, e: int) -> Published:
    study = describe(name, config)
    one = match.sel(damping_model=model).isel({study.parameter: value, "restitution": e})
    return Published(
        study.curve.map(itemgetter(value)),
        float(study.release_amplitude[value]),
        float(one["restitution"]),
        model,
        float(one["damping_ratio"]),
        float(relative_uncertainty(one)),
    )


def minima(config: Config, matches: Matches) -> xr.Dataset:
    """Find the exact minimum next to each damping ratio of the sample, and how far the published one is from it.

    ``share_converged`` counts the published damping ratios that are within 0.1 % by their own uncertainty or, where
    that is larger and they are in the sample, of the exact minimum.
    """
    chosen, bracket = sample(config, matches), float(config["accuracy"]["bracket"])
    window = float(next(iter(matches.values()))["window"])
    flat = [one for group in chosen.values() for one in group]
    found = np.array([exact_minimum(one, window, bracket) for one in track(flat, "exact minima")])
    published = np.array([one.ratio for one in flat])
    difference = published / found - 1
    bound = np.array([one.bound for one in flat])
    saved = ((bound >= THOUSANDTH) & (np.abs(difference) < THOUSANDTH)).reshape(len(chosen), -1)[:, : least(config)]
    columns = {
        "sample_published_ratio": published,
        "sample_exact_ratio": found,
        "sample_difference": difference,
        "sample_bound": bound,
        "sample_cracked_stiffness_ratio": np.array([float(one.curve.cracked_stiffness_ratio) for one in flat]),
        "sample_release_amplitude": np.array([one.release_amplitude for one in flat]),
        "sample_restitution": np.array([one.restitution for one in flat]),
    }
    shares = uncertainty(matches)
    return xr.Dataset(
        {key: (("viscous_model", "sample"), value.reshape(len(chosen), -1)) for key, value in columns.items()}
        | {"share_converged": shares["share_within_thousandth"] + saved.sum(axis=1) / int(shares["published_count"])},
        coords={"viscous_model": list(chosen), "sample": np.arange(config["accuracy"]["minima"])},
    )


def exact_minimum(one: Published, window: float, bracket: float) -> float:
    """Return the damping ratio with the least integral of (|u_CR| - |u|)^2, within `bracket` of the published one. [-]

    The integral is what the sum of Eq. (17) tends to as its step goes to zero, at first order: its last term counts
    whole where the integral counts half.

    Raises
    ------
    InputError
        If the integral is least at an end of the bracket.
    """
    squared = Distance(one.curve, one.model, one.restitution, one.release_amplitude, window)
    ends = one.ratio * (1 - bracket), one.ratio * (1 + bracket)
    found = float(minimize_scalar(squared, bounds=ends, method="bounded", options={"xatol": 1e-6 * one.ratio}).x)
    if not min(found - ends[0], ends[1] - found) > 1e-3 * (ends[1] - ends[0]):
        raise InputError(
            f"accuracy.bracket is {bracket:g}; it must be larger: Err of {one.model} at e = {one.restitution:g} and"
            f" u0/u_ins = {one.release_amplitude:g} is least beyond it, near xi = {found:.6g}"
        )
    return found


class Distance:
    """Integral of (|u_CR| - |u|)^2 over a window against the damping ratio, both solutions exact.

    |u| has a kink at each crossing of zero; sampled there as at any other time, it puts a ripple on the sum that shifts
    minima by parts in 10^4. Here the crossings are nodes, so the trapezoidal sum is smooth in the damping ratio.
    """

    def __init__(self, curve: TrilinearCurve, model: str, restitution: float, release: float, window: float) -> None:
        self._curve, self._model, self._release = curve, model, release
        even = np.linspace(0.0, window, round(window / SPACING) + 1)
        target = event_driven.history(curve, Damping.cr(restitution), even, release_amplitude=release)
        self._nodes = np.union1d(even, target.impacts)
        self._target = np.abs(np.interp(self._nodes, target.times, target.displacement))
        self._target[np.isin(self._nodes, target.impacts)] = 0.0

    def __call__(self, damping_ratio: float) -> float:
        nodes = self._nodes
        found = event_driven.history(
            self._curve, Damping(self._model, damping_ratio), nodes, release_amplitude=self._release
        )
        squared = (self._target - np.abs(found.displacement)) ** 2
        at_crossings = np.interp(found.impacts, nodes, self._target) ** 2
        place = np.searchsorted(nodes, found.impacts)
        return float(np.trapezoid(np.insert(squared, place, at_crossings), np.insert(nodes, place, found.impacts)))
