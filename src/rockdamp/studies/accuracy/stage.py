"""Accuracy: errors of the solver and of the damping ratios, where small rotations matter, and the energy audit.

Of the published damping ratios: their stored bounds, and minima of Eq. (17) by the exact solver.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter

import numpy as np
import xarray as xr
from scipy.optimize import minimize_scalar

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.study import Study
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.progress import track
from rockdamp.solvers import event_driven
from rockdamp.studies.accuracy import energy_audit
from rockdamp.studies.accuracy.convergence import EXCITATIONS, Ensemble, collect, fitted_order, halved
from rockdamp.studies.accuracy.energy_audit import Audited
from rockdamp.studies.accuracy.small_rotations import rotations
from rockdamp.studies.mechanism import matched_histories
from rockdamp.vocabulary import MODELS, STUDIES


def accuracy(
    config: Config, loops: xr.Dataset, matches: Sequence[xr.Dataset], decays: Sequence[xr.Dataset]
) -> xr.Dataset:
    """Measure how accurate the published numbers are.

    `matches` and `decays` are those of each study, in the order of `STUDIES`.
    """
    step, scheme, sizes = config.solver.step, config.solver.scheme, config.accuracy
    matched, decaying = (dict(zip(STUDIES, of_each, strict=True)) for of_each in (matches, decays))
    studies = {name: config.study(name) for name in STUDIES}
    ensemble = collect(
        studies,
        matched,
        restitutions=sizes.restitutions,
        seed=sizes.seed,
        length=config.matching.response_length,
        step=step,
        steps=halved(step, sizes.doublings, sizes.halvings),
        scheme=scheme,
    )
    audited = audited_walls(config, loops)
    parts = [
        solver_errors(ensemble, step, refinement=config.matching.refinement),
        uncertainty(matched),
        minima(studies, matched, count=sizes.minima, bracket=sizes.bracket, seed=sizes.seed),
        rotations(
            loops,
            config.damping_force.rigid.wall,
            restitution=config.damping_force.rigid.restitution,
            slenderness=sizes.rigid.slenderness,
            hinge_ratio=sizes.rigid.hinge_ratio,
            release_amplitude=sizes.rigid.release_amplitude,
            peaks=sizes.rigid.peaks,
        ),
        energy_audit.residuals(ensemble, step),
        energy_audit.stored(audited["reference"], decaying, studies, step),
        energy_audit.losses(audited, config.release_amplitude, step),
    ]
    return xr.merge(parts, compat="no_conflicts", join="exact")


def audited_walls(config: Config, loops: xr.Dataset) -> dict[str, Audited]:
    """Return the reference wall with its histories in `damping_force.nc`, and that of Fig. 8 with such histories."""
    histories = matched_histories(
        config.validation.curve,
        config.validation.restitution,
        config.release_amplitude,
        config.matching,
        length=config.damping_force.response_length,
        step=config.solver.step,
        scheme=config.solver.scheme,
    )
    return {
        "reference": Audited(config.wall, config.curve, config.damping_force.restitution, loops),
        "Fig. 8": Audited(config.validation.wall, config.validation.curve, config.validation.restitution, histories),
    }


def solver_errors(ensemble: Ensemble, step: float, refinement: int) -> xr.Dataset:
    """Compare the pipeline's solver with the event-driven one, free and forced, against the step.

    The error of a history is the root mean square of u/u_ins less the exact one, over the times of the coarsest step.
    The ensemble's steps include the pipeline's; the published damping ratios have `refinement` steps in place of each.
    """
    steps, own = ensemble.steps, int(np.argmin(np.abs(ensemble.steps - step)))
    error = np.empty((len(EXCITATIONS), len(MODELS), *ensemble.factor.shape, steps.size))
    largest = np.empty(error.shape[:2])
    peak = np.zeros((len(EXCITATIONS), *ensemble.factor.shape))
    cells = [(x, m) for x in range(len(EXCITATIONS)) for m in range(len(MODELS))]
    lanes = ensemble.factor.size
    references = iter(track(_exact(ensemble, cells), "exact histories", len(cells) * lanes))
    for x, m in cells:
        expected = np.stack([next(references) for _ in range(lanes)]).reshape(*ensemble.factor.shape, -1)
        peak[x] = np.maximum(peak[x], np.abs(expected).max(axis=-1))
        for k in range(steps.size):
            displacement, _ = ensemble.histories(MODELS[m], EXCITATIONS[x], float(steps[k]), 2**k)
            error[x, m, ..., k] = np.sqrt(np.mean((displacement - expected) ** 2, axis=-1))
            if k == own:
                largest[x, m] = np.abs(displacement - expected).max()
    dims = ("excitation", "damping_model")
    median = np.median(error, axis=(2, 3))
    return xr.Dataset(
        {
            "solver_error": ((*dims, "case", "restitution", "step"), error),
            "median_solver_error": ((*dims, "step"), median),
            "largest_solver_error": ((*dims, "step"), error.max(axis=(2, 3))),
            "convergence_order": (dims, fitted_order(steps, median)),
            "largest_history_error": (dims, largest),
            "largest_displacement": (("excitation", "case", "restitution"), peak),
        },
        coords={
            "excitation": list(EXCITATIONS),
            "damping_model": list(MODELS),
            "restitution": ensemble.restitution,
            "step": steps,
            "solver_step": step,
            "published_step": step / refinement,
            "release_amplitude": ("case", ensemble.release_amplitude[:, 0]),
            "yield_displacement_ratio": ("case", ensemble.curve.yield_displacement_ratio[:, 0]),
            "strength_ratio": ("case", ensemble.curve.strength_ratio[:, 0]),
        },
    )


def _exact(ensemble: Ensemble, cells: list[tuple[int, int]]) -> Iterator[Array]:
    """Yield the exact displacement of each lane of each cell, at the multiples of the coarsest step."""
    spacing = float(ensemble.steps[0])
    times = spacing * np.arange(round((ensemble.load.shape[-1] - 1) * ensemble.sample / spacing) + 1)
    for x, m in cells:
        forced = EXCITATIONS[x] == "forced"
        damping = ensemble.damping(MODELS[m]).map(lambda parameter: np.broadcast_to(parameter, ensemble.factor.shape))
        for case, e in np.ndindex(*ensemble.factor.shape):
            yield event_driven.history(
                ensemble.curve.map(itemgetter((case, 0))),
                damping.map(itemgetter((case, e))),
                times,
                release_amplitude=0.0 if forced else float(ensemble.release_amplitude[case, 0]),
                load=ensemble.factor[case, e] * ensemble.load[case] if forced else (),
                load_step=ensemble.sample,
            ).displacement


THOUSANDTH = 1e-3
HALVES = ("largest error", "drawn")  # of the sample
QUANTILES = np.concatenate([np.linspace(0.0, 0.98, 50), [0.99, 1.0]])
SPACING = 0.0005  # in tau, of the samples of the integral: halving it moves no minimum by more than 3e-7 of itself

Studies = Mapping[str, Study]
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


def sample(studies: Studies, matches: Matches, *, count: int, seed: int) -> dict[str, list[Published]]:
    """Choose `count` published ratios of each model: half of the largest Err, half drawn; none has another's case.

    The uncertainty has no say in it, as it is what the sample tests.
    """
    rng = np.random.default_rng(seed)
    chosen = {}
    for model in (str(model) for model in next(iter(matches.values()))["damping_model"].values):
        places = _unlike(studies, {name: match.sel(damping_model=model) for name, match in matches.items()})
        worst, others = places[: largest_errors(count)], places[largest_errors(count) :]
        drawn = rng.choice(len(others), min(count - len(worst), len(others)), replace=False)
        places = worst + [others[i] for i in drawn]
        chosen[model] = [_published(studies[name], matches[name], model, *place) for name, place in places]
    return chosen


def _unlike(studies: Studies, matches: Matches) -> list[tuple[str, tuple[int, ...]]]:
    """Study and place of each case of one model that differs from the others, the largest Err first."""
    cases: dict[tuple[float, ...], tuple[float, str, tuple[int, ...]]] = {}
    for name, match in matches.items():
        study, e = studies[name], match["restitution"].values
        error = match["rms_error"].transpose(study.parameter, "restitution").values
        problem = np.stack([*study.curve.parameters(), study.release_amplitude], axis=1)
        for place in np.ndindex(error.shape):
            cases[*problem[place[0]].tolist(), float(e[place[1]])] = float(error[place]), name, place
    return [(name, place) for _, name, place in sorted(cases.values(), key=lambda case: -case[0])]


def largest_errors(count: int) -> int:
    """Return how many of a sample of `count` are those of the largest Err: half, rounded up."""
    return -(-count // 2)


def _published(study: Study, match: xr.Dataset, model: str, value: int, e: int) -> Published:
    there = match.sel(damping_model=model).isel({study.parameter: value, "restitution": e})
    return Published(
        study.curve.map(itemgetter(value)),
        float(study.release_amplitude[value]),
        float(there["restitution"]),
        model,
        float(there["damping_ratio"]),
        float(relative_uncertainty(there)),
    )


def minima(studies: Studies, matches: Matches, *, count: int, bracket: float, seed: int) -> xr.Dataset:
    """Find the exact minimum next to each damping ratio of the sample, and how far the published one is from it.

    ``share_within_uncertainty`` is the part of each half of the sample whose exact minimum lies within the uncertainty.
    """
    chosen = sample(studies, matches, count=count, seed=seed)
    response_length = float(next(iter(matches.values()))["response_length"])
    all_models = [published for of_model in chosen.values() for published in of_model]
    exact = np.array(
        [exact_minimum(published, response_length, bracket) for published in track(all_models, "exact minima")]
    )
    ratio = np.array([published.ratio for published in all_models])
    difference = ratio / exact - 1
    bound = np.array([published.bound for published in all_models])
    columns = {
        "sample_published_ratio": ratio,
        "sample_exact_ratio": exact,
        "sample_difference": difference,
        "sample_bound": bound,
        "sample_yield_displacement_ratio": np.array(
            [float(published.curve.yield_displacement_ratio) for published in all_models]
        ),
        "sample_release_amplitude": np.array([published.release_amplitude for published in all_models]),
        "sample_restitution": np.array([published.restitution for published in all_models]),
    }
    within = (np.abs(ratio - exact) <= bound * ratio).reshape(len(chosen), -1)
    halves = np.split(within, [largest_errors(count)], axis=1)
    return xr.Dataset(
        {key: (("viscous_model", "sample"), value.reshape(len(chosen), -1)) for key, value in columns.items()}
        | {"share_within_uncertainty": (("sample_half", "viscous_model"), [half.mean(axis=1) for half in halves])},
        coords={"viscous_model": list(chosen), "sample": np.arange(within.shape[1]), "sample_half": list(HALVES)},
    )


def exact_minimum(published: Published, response_length: float, bracket: float) -> float:
    """Return the damping ratio with the least integral of (|u_CR| - |u|)^2, within `bracket` of the published one. [-]

    The integral is what the sum of Eq. (17) tends to as its step goes to zero, at first order: its last term counts
    whole where the integral counts half. It raises `InputError` if the integral is least at an end of the bracket.
    """
    e, x0 = published.restitution, published.release_amplitude
    squared = Distance(published.curve, published.model, e, x0, response_length)
    ends = published.ratio * (1 - bracket), published.ratio * (1 + bracket)
    options = {"xatol": 1e-6 * published.ratio}
    damping_ratio = float(minimize_scalar(squared, bounds=ends, method="bounded", options=options).x)
    if not min(damping_ratio - ends[0], ends[1] - damping_ratio) > 1e-3 * (ends[1] - ends[0]):
        raise InputError(
            f"accuracy.bracket is {bracket:g}; it must be larger: Err of {published.model} at e = {e:g} and"
            f" u0/u_ins = {x0:g} is least beyond it, near xi = {damping_ratio:.6g}"
        )
    return damping_ratio


class Distance:
    """Integral of (|u_CR| - |u|)^2 over a response length against the damping ratio, both solutions exact.

    |u| has a kink at each crossing of zero; sampled there as at any other time, it puts a ripple on the sum that shifts
    minima by parts in 10^4. Here the crossings are nodes, so the trapezoidal sum is smooth in the damping ratio.
    """

    def __init__(
        self, curve: TrilinearCurve, model: str, restitution: float, release: float, response_length: float
    ) -> None:
        self._curve, self._model, self._release = curve, model, release
        even = np.linspace(0.0, response_length, round(response_length / SPACING) + 1)
        target = event_driven.history(curve, Damping.cr(restitution), even, release_amplitude=release)
        self._nodes = np.union1d(even, target.impacts)
        self._target = np.abs(np.interp(self._nodes, target.times, target.displacement))
        self._target[np.isin(self._nodes, target.impacts)] = 0.0

    def __call__(self, damping_ratio: float) -> float:
        nodes = self._nodes
        history = event_driven.history(
            self._curve, Damping(self._model, damping_ratio), nodes, release_amplitude=self._release
        )
        squared = (self._target - np.abs(history.displacement)) ** 2
        at_crossings = np.interp(history.impacts, nodes, self._target) ** 2
        place = np.searchsorted(nodes, history.impacts)
        return float(np.trapezoid(np.insert(squared, place, at_crossings), np.insert(nodes, place, history.impacts)))
