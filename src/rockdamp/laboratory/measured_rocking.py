"""The stage: which damping model measured free rocking supports, and how restitution scatters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline
from scipy.special import chdtri, ndtri

from rockdamp.arrays import Array
from rockdamp.config import Config, MeasuredRocking
from rockdamp.constants import PAPER_MODELS, REFERENCE
from rockdamp.laboratory.trials import NearlyRigid, RockingTrials, by_solver, read_rocking_trials
from rockdamp.laboratory.trials_fit import (
    Expansion,
    Search,
    TrialsFit,
    at_each_centre,
    drawn,
    fit,
    share_below,
    simulated,
)
from rockdamp.laboratory.velocity_ratios import (
    CENTRES,
    LOSSES,
    ErrorModel,
    Nodes,
    Predict,
    Prediction,
    Trials,
    by_impact,
    impacts_to_stop,
    law_of_loss,
    power_law,
)
from rockdamp.mechanics.wall import Parapet
from rockdamp.progress import track

LEVEL = 0.90  # of every interval
HALF_CHI_SQUARE = round(float(chdtri(1, 1 - LEVEL)) / 2, 4)  # half of its quantile, with one degree of freedom
NORMAL = round(float(ndtri((1 + LEVEL) / 2)), 4)  # quantile of the normal distribution
LEAST_EXPONENT = 1e-3  # of the law of loss; at 0 a block never stops
MODELS = (REFERENCE, *PAPER_MODELS)  # ECD and BAND lose as REFERENCE does
POWER_LAW = "power law"  # of the loss in the energy left, at its most likely exponent
COMPARED = ("CDC", REFERENCE, "SDR")  # what a simulated set is made by, and between which it chooses
# What the error of a ratio has, or lacks.
AS_DESCRIBED = ErrorModel()
ERROR_MODELS = {
    "as described": AS_DESCRIBED,
    "with correlation": ErrorModel(correlation=True),
    "without alternation": ErrorModel(alternation=False),
    "without alternation, with correlation": ErrorModel(alternation=False, correlation=True),
    "without heavy tails": ErrorModel(heavy_tails=False),
    "one level of noise": ErrorModel(by_trial=False),
    "noise of the velocity alone": ErrorModel(growth=1.0),
    "noise independent of speed": ErrorModel(growth=0.0),
}


def measured_rocking(config: Config) -> xr.Dataset:
    """Fit each damper, and a power law of the loss, to measured ratios; describe restitution and its spread."""
    settings = config.measured_rocking
    measured = read_rocking_trials(settings.trials)
    study = _Study(settings, measured)
    amplitude, largest = study.by_amplitude()
    models, fits = study.by_model(largest)
    shown = fits[REFERENCE]
    parts = [
        models,
        study.by_curve(fits),
        amplitude,
        study.by_law(),
        study.by_error_model(),
        study.by_impact(fits, float(amplitude["amplitude_exponent"].sel(impacts_used=settings.shown_impacts))),
        study.restitution(shown),
        study.held_out(shown),
        study.simulation(fits),
    ]
    return xr.merge(parts, combine_attrs="drop", compat="no_conflicts", join="exact").assign(
        impacts=measured.impacts,
        trials=measured.trials,
        duplicates=measured.duplicates,
        shown_impacts=settings.shown_impacts,
        shown_yield_displacement_ratio=settings.shown_yield_displacement_ratio,
        shown_release_amplitude=settings.shown_release_amplitude,
    )


def _seen(trials: Trials, predict: Predict, fitted: TrialsFit) -> tuple[Mapping[str, float], Array, Nodes]:
    """Return what the trials' distributions after their ratios follow from."""
    return fitted.values, Search(trials, predict, fitted.nodes).of_losses(fitted.point), fitted.nodes


def _fixed(predict: Callable[[Array], Any]) -> Predict:
    """Return a prediction without a parameter of its shape."""
    return lambda losses, _: predict(losses)


@dataclass
class _Study:
    settings: MeasuredRocking
    measured: RockingTrials

    def trials(self, impacts: int, errors: ErrorModel = AS_DESCRIBED) -> Trials:
        """Return the ratios of the first impacts, and Housner's loss of each block."""
        restitution = Parapet(self.measured.thickness, self.measured.height).restitution_rigid
        return Trials(self.measured.ratio[:, :impacts], self.measured.geometry, -np.log(restitution), errors)

    @property
    def shown(self) -> Trials:
        return self.trials(self.settings.shown_impacts)

    @property
    def block(self) -> NearlyRigid:
        return NearlyRigid(self.settings.shown_yield_displacement_ratio, self.settings.shown_release_amplitude)

    def predictions(self, impacts: int) -> dict[str, Predict]:
        """Return what each damper predicts, by the solver on the shown curve."""
        return {model: _fixed(by_solver(self.block, model, impacts)) for model in MODELS}

    # --- which damper -------------------------------------------------------------------------------------------------

    def by_model(self, power_law: Array) -> tuple[xr.Dataset, dict[str, TrialsFit]]:
        """Return the log-likelihood of each damper by the number of impacts, and the fits of the shown number.

        That of the power law is given.
        """
        s, fits = self.settings, {}
        likelihood = np.empty((len(MODELS), len(s.impacts_used)))
        for column, impacts in enumerate(track(s.impacts_used, "dampers")):
            last = None
            for row, (model, predict) in enumerate(self.predictions(impacts).items()):
                last = fit(self.trials(impacts), predict, start=last)
                likelihood[row, column] = last.log_likelihood
                if impacts == s.shown_impacts:
                    fits[model] = last
        coords = {"damping_model": [*MODELS, POWER_LAW], "impacts_used": s.impacts_used}
        return xr.Dataset({"log_likelihood": (tuple(coords), [*likelihood, power_law])}, coords=coords), fits

    def by_curve(self, fits: dict[str, TrialsFit]) -> xr.Dataset:
        """Return the log-likelihood of the paper's dampers on other curves, and from other releases."""
        s, trials = self.settings, self.shown
        cases = [NearlyRigid(a1, s.shown_release_amplitude) for a1 in s.yield_displacement_ratio]
        cases += [NearlyRigid(s.shown_yield_displacement_ratio, u0) for u0 in s.release_amplitude]
        values = [
            [
                fit(trials, _fixed(by_solver(block, model, s.shown_impacts)), start=fits[model]).log_likelihood
                for block in track(cases, f"curves, {model}")
            ]
            for model in PAPER_MODELS
        ]
        of_curves, of_releases = np.split(np.array(values), [len(s.yield_displacement_ratio)], axis=1)
        return xr.Dataset(
            {
                "log_likelihood_by_curve": (("viscous_model", "yield_displacement_ratio"), of_curves),
                "log_likelihood_by_release": (("viscous_model", "release_amplitude"), of_releases),
            },
            coords={
                "viscous_model": list(PAPER_MODELS),
                "yield_displacement_ratio": s.yield_displacement_ratio,
                "release_amplitude": s.release_amplitude,
            },
        )

    def by_amplitude(self) -> tuple[xr.Dataset, Array]:
        """Return the exponent of the energy left that the loss has, by the number of impacts; by bootstrap for one.

        Beside it stands the largest log-likelihood of any exponent.
        """
        s, tried = self.settings, np.array(self.settings.amplitude_exponent)
        values, found, expansions = np.empty((len(s.impacts_used), tried.size)), [], []
        for row, impacts in enumerate(track(s.impacts_used, "exponents of the amplitude")):
            trials, last = self.trials(impacts), None
            for column, gamma in enumerate(tried):
                predict = _fixed(partial(power_law, exponent=float(gamma), impacts=impacts))
                last = fit(trials, predict, start=last)
                values[row, column] = last.log_likelihood
                if impacts == s.shown_impacts:
                    expansions.append(Expansion.about(trials, predict, last))
            found.append(profile(tried, values[row]))
        random = np.random.RandomState(s.bootstrap.seed)
        replicates = []
        for _ in track(range(s.bootstrap.replicates), "trials drawn again"):
            weights = drawn(self.measured.geometry, random)
            values_drawn = [-each.negative(each.fit(weights), weights)[0] for each in expansions]
            replicates.append(profile(tried, np.array(values_drawn))[0])
        tails = [(1 - LEVEL) / 2, (1 + LEVEL) / 2]
        dataset = xr.Dataset(
            {
                "log_likelihood_by_amplitude_exponent": (("impacts_used", "tried_amplitude_exponent"), values),
                "amplitude_exponent": ("impacts_used", [each[0] for each in found]),
                "amplitude_exponent_interval": (("impacts_used", "bound"), [each[1] for each in found]),
                "amplitude_exponent_bootstrap_interval": ("bound", np.quantile(replicates, tails)),
                "bootstrap_replicates": len(replicates),
            },
            coords={
                "impacts_used": s.impacts_used,
                "tried_amplitude_exponent": tried,
                "bound": ["lower", "upper"],
            },
        )
        return dataset, np.array([each[2] for each in found])

    def by_law(self) -> xr.Dataset:
        """Return the likelihood of the law of loss, and how many impacts it allows a block beside those measured.

        The loss of each trial is distributed as its first ratios say; its later impacts are not seen by the fit.
        """
        s, measured, rows = self.settings, np.isfinite(self.measured.ratio).sum(axis=1), []
        for impacts in track(s.impacts_used, "law of loss"):
            trials = self.trials(impacts)

            def predict(losses: Array, shape: Array, impacts: int = impacts) -> Prediction:
                return law_of_loss(losses, shape[0], impacts)

            found = fit(trials, predict, shape=[(0.2, LEAST_EXPONENT, 2.0, 0.1)])
            probability = trials.total(*_seen(trials, predict, found))[1]
            stop = impacts_to_stop(found.nodes.loss, found.shape[0])
            rows.append((found.log_likelihood, found.shape[0], np.mean(beyond_stop(stop, probability, measured))))
            if impacts == s.shown_impacts:
                allowed = middle(stop, probability)
        names = ("law_log_likelihood", "loss_exponent", "share_beyond_stop")
        return xr.Dataset(
            {name: ("impacts_used", column) for name, column in zip(names, np.array(rows).T, strict=True)}
            | {"measured_impacts": ("trial", measured), "allowed_impacts": ("trial", allowed)},
            coords={"trial": np.arange(1, measured.size + 1)},
        )

    # --- errors -------------------------------------------------------------------------------------------------------

    def by_error_model(self) -> xr.Dataset:
        """Return what each part of the error model brings, with the exponent of the amplitude free."""
        impacts, rows = self.settings.shown_impacts, []
        for errors in track(list(ERROR_MODELS.values()), "error models"):
            trials = self.trials(impacts, errors)
            free = fit(trials, lambda x, shape: power_law(x, shape[0], impacts), shape=[(-0.2, -2.0, 2.0, 0.1)])
            rows.append((free.log_likelihood, free.shape[0], free.values["correlation"]))
        names = ("error_log_likelihood", "error_amplitude_exponent", "error_correlation")
        columns = dict(zip(names, np.array(rows).T, strict=True))
        return xr.Dataset(
            {name: ("error_model", column) for name, column in columns.items()},
            coords={"error_model": list(ERROR_MODELS)},
        )

    def by_impact(self, fits: dict[str, TrialsFit], exponent: float) -> xr.Dataset:
        """Return the loss at each impact over the trial's mean: free at each impact, and of each damper.

        That of the power law is of its most likely exponent.
        """
        impacts = self.settings.shown_impacts
        trials = self.shown
        free = fit(trials, by_impact, shape=[(0.0, -2.0, 2.0, 0.1)] * (impacts - 1), start=fits[REFERENCE])
        deviation = Expansion.about(trials, by_impact, free).covariance
        last = -np.ones(impacts - 1)  # the last impact's logarithm is less the sum of the others
        change = np.vstack([np.eye(impacts - 1), last])
        size = NORMAL * np.sqrt(np.diag(change @ deviation[-(impacts - 1) :, -(impacts - 1) :] @ change.T))
        profile = np.append(free.shape, -free.shape.sum())
        law = _fixed(partial(power_law, exponent=exponent, impacts=impacts))
        predictions = self.predictions(impacts) | {POWER_LAW: law}
        fits = fits | {POWER_LAW: fit(trials, law, start=fits[REFERENCE])}
        lines = [self._mean_profile(trials, predict, fits[model]) for model, predict in predictions.items()]
        return xr.Dataset(
            {
                "loss_by_impact": ("impact", np.exp(profile)),
                "loss_by_impact_interval": (("impact", "bound"), np.exp(profile[:, None] + np.outer(size, [-1, 1]))),
                "loss_by_impact_of_model": (("damping_model", "impact"), lines),
                "free_log_likelihood": free.log_likelihood,
            },
            coords={"impact": np.arange(1, impacts + 1), "bound": ["lower", "upper"], "damping_model": list(fits)},
        )

    @staticmethod
    def _mean_profile(trials: Trials, predict: Predict, fitted: TrialsFit) -> Array:
        """Return a damper's loss at each impact over the mean; the trials are weighted by information."""
        of_loss = trials.total(*_seen(trials, predict, fitted))[1]
        loss = (of_loss * fitted.nodes.loss).sum(axis=1)
        log_loss = np.log(-np.log(predict(loss, fitted.shape).ratio))
        log_loss -= log_loss.mean(axis=0)
        # The information of a trial on the logarithm of its loss grows with the square of the loss.
        return np.asarray(np.exp(np.average(log_loss, axis=1, weights=loss**2)))

    # --- restitution --------------------------------------------------------------------------------------------------

    def restitution(self, fitted: TrialsFit) -> xr.Dataset:
        """Return e over Housner's of each geometry, and its spread within and between them."""
        trials, measured = self.shown, self.measured
        housner = trials.housner[:, None]
        by_centre = at_each_centre(trials, fitted.values)
        mean = np.einsum("c,gcj->gj", LOSSES, by_centre)
        variance = np.einsum("gcj,gcj->gj", (LOSSES[:, None] - mean[:, None, :]) ** 2, by_centre)
        prior = np.exp(CENTRES[1])
        overall = mean @ prior
        within, between = variance @ prior, (mean - overall[:, None]) ** 2 @ prior
        predict = self.predictions(self.settings.shown_impacts)[REFERENCE]
        seen = trials.centres_seen(*_seen(trials, predict, fitted))
        estimate = (seen * mean).sum(axis=1)
        scatter = np.sqrt((seen * (mean - estimate[:, None]) ** 2).sum(axis=1))
        new = np.einsum("gj,gcj->gc", seen, by_centre)
        below = np.cumsum(new, axis=1) - new / 2  # half of a loss's own part lies below it
        of_trial = np.array([np.interp([(1 + LEVEL) / 2, (1 - LEVEL) / 2], one, LOSSES) for one in below])
        first = np.log(measured.ratio[:, 0]) + trials.housner[measured.geometry]
        means = np.array([first[measured.geometry == g].mean() for g in range(housner.size)])
        bounds = np.exp(housner - estimate[:, None] - np.outer(scatter, [NORMAL, -NORMAL]))
        return xr.Dataset(
            {
                "housner_restitution": ("geometry", np.exp(-trials.housner)),
                "geometry_trials": ("geometry", np.bincount(measured.geometry)),
                "restitution_over_housner": ("geometry", np.exp(trials.housner - estimate)),
                "restitution_over_housner_interval": (("geometry", "bound"), bounds),
                "trial_over_housner_interval": (("geometry", "bound"), np.exp(housner - of_trial)),
                "restitution_over_housner_mean": float(np.exp((trials.housner - overall).mean())),
                "trial_deviation": ("geometry", np.sqrt(within + between)),
                "deviation_within": float(np.sqrt(within.mean())),
                "deviation_between": float(np.sqrt(between.mean())),
                "first_ratio_over_housner": ("geometry", np.exp(means)),
                "first_ratio_mean": float(np.exp(first.mean())),
                "first_ratio_deviation_within": float(np.sqrt(np.mean((first - means[measured.geometry]) ** 2))),
                "first_ratio_deviation_between": float(np.std(means)),
                "first_ratios_above_one": float(np.mean(measured.ratio[:, 0] > 1)),
                "noise": fitted.values["noise"],
                "noise_deviation": fitted.values["noise_deviation"],
                "alternation": fitted.values["alternation"],
                "alternation_mean": fitted.values["lean"],
                "noise_growth": fitted.values["growth"],
                "tail_freedom": fitted.values["freedom"],
            },
            coords={"geometry": measured.slenderness, "bound": ["lower", "upper"]},
        )

    # --- checks -------------------------------------------------------------------------------------------------------

    def held_out(self, fitted: TrialsFit) -> xr.Dataset:
        """Return how often the interval of the first ratio holds where geometries are held out, over all choices."""
        impacts, trials = self.settings.shown_impacts, self.shown
        expansion = Expansion.about(trials, _fixed(partial(power_law, exponent=0.0, impacts=impacts)), fitted)
        shares = []
        for out in track(list(combinations(range(trials.housner.size), self.settings.held_out)), "held out"):
            left = np.isin(trials.geometry, out)
            below = share_below(trials, trials.values(expansion.fit(~left)), np.flatnonzero(left))
            shares.append(np.mean(np.abs(below - 0.5) < LEVEL / 2))
        return xr.Dataset({"held_out_coverage": ("choice", shares)}, coords={"choice": np.arange(len(shares))})

    def simulation(self, fits: dict[str, TrialsFit]) -> xr.Dataset:
        """Return how often the damper that made a simulated set has the largest likelihood."""
        s, trials = self.settings.simulated, self.shown
        predictions = self.predictions(self.settings.shown_impacts)
        chosen = np.zeros((len(COMPARED), len(COMPARED)), dtype=int)
        for row, maker in enumerate(COMPARED):
            random = np.random.RandomState([s.seed, row])
            for _ in track(range(s.draws), f"sets made by {maker}"):
                made = simulated(trials, predictions[maker], fits[maker], random)
                last = fit(made, predictions[maker], start=fits[maker], other_ratios=True)
                likelihood = [
                    (last if model == maker else fit(made, predictions[model], start=last)).log_likelihood
                    for model in COMPARED
                ]
                chosen[row, int(np.argmax(likelihood))] += 1
        coords: dict[str, Sequence[str]] = {"made_by": list(COMPARED), "chosen": list(COMPARED)}
        return xr.Dataset({"simulated_choices": (tuple(coords), chosen)}, coords=coords)


def beyond_stop(stop: Array, probability: Array, measured: Array) -> Array:
    """Return the probability that a trial has more impacts than the law allows, shape (trials,).

    `stop` and `probability`, shape (trials, losses), are the last impact by the trial's loss and how probable that is.
    """
    return np.asarray((probability * (stop < measured[:, None])).sum(axis=1) / probability.sum(axis=1))


def middle(stop: Array, probability: Array) -> Array:
    """Return the median of the last impact of each trial, shape (trials,); arguments are as for `beyond_stop`."""
    order = np.argsort(stop, axis=1)
    below = np.cumsum(np.take_along_axis(probability, order, axis=1), axis=1)
    at = np.argmax(below >= 0.5 * below[:, -1:], axis=1)
    return np.asarray(np.take_along_axis(stop, order, axis=1)[np.arange(len(stop)), at])


def profile(at: Array, log_likelihood: Array) -> tuple[float, list[float], float]:
    """Return where a profile has its maximum, the 90 % interval by likelihood, and the maximum."""
    spline, fine = CubicSpline(at, log_likelihood), np.linspace(at[0], at[-1], 4001)
    values = spline(fine)
    inside = fine[values > values.max() - HALF_CHI_SQUARE]
    return float(fine[np.argmax(values)]), [float(inside[0]), float(inside[-1])], float(values.max())
