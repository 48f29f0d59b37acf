"""Likelihood of ratios: against direct integration, and the truths of simulated trials."""

from functools import partial

import numpy as np
import pytest
from scipy import stats
from scipy.special import ndtr, ndtri

from rockdamp.laboratory.trials import FIRST_LOSSES, Trials, power_law
from rockdamp.laboratory.trials_likelihood import (
    CENTRES,
    SEARCH_RANGES,
    Likelihood,
    Nodes,
    Quadrature,
    parameter_values,
)

IMPACTS = 6
HOUSNER = np.array([0.09, 0.06, 0.04, 0.02])
RANGES = list(SEARCH_RANGES.values())[:-1]  # without the exponent
TRUTH = np.array([search_range.start for search_range in RANGES])
LAW = partial(power_law, impacts=IMPACTS)


def simulate_trials(count, random, exponent=0.0):
    """Return the likelihood of trials that follow its model at the truth."""
    values = parameter_values(TRUTH)
    geometry = np.arange(count) % HOUSNER.size
    centre = HOUSNER + values["centre"] + values["between"] * random.standard_normal(HOUSNER.size)
    below_zero = ndtr(-centre / values["within"])[geometry]  # the normal distribution is cut off
    share = below_zero + (1 - below_zero) * random.uniform(size=count)
    loss = centre[geometry] + values["within"] * ndtri(share)
    level = values["noise"] * np.exp(values["noise_deviation"] * random.standard_normal(count))
    lean = values["lean"] + values["alternation"] * random.standard_normal(count)
    prediction = power_law(loss, exponent, IMPACTS)
    error = random.standard_t(values["freedom"], (IMPACTS, count))
    error *= np.exp(-0.5 * values["growth"] * prediction.log_energy)
    sign = (-1.0) ** np.arange(IMPACTS)[:, None]
    ratio = prediction.ratio + sign * lean + level * error
    return Likelihood(Trials(ratio.T, geometry, HOUSNER), LAW)


@pytest.fixture(scope="module")
def simulated():
    """Forty trials of four blocks, some of four impacts, with one e for all impacts of a trial."""
    likelihood = simulate_trials(40, np.random.RandomState(5))
    likelihood.trials.ratio[30:, 4:] = np.nan
    return likelihood


@pytest.fixture(scope="module")
def fitted(simulated):
    return simulated.fit()


def normal_grid(mean, deviation):
    """Return values within five deviations and their weights."""
    standard = np.linspace(-5, 5, 31)
    weight = np.exp(-0.5 * standard**2)
    return mean + deviation * standard, weight / weight.sum()


def direct_log_likelihoods(ratio, housner, values):
    """Return the log-likelihood of one trial at each centre, by sums over fine grids."""
    loss = 0.002 * (np.arange(150) + 0.5)
    lean, lean_weight = normal_grid(values["lean"], values["alternation"])
    level, level_weight = normal_grid(np.log(values["noise"]), values["noise_deviation"])
    prediction = LAW(loss, 0.0)
    density = 1.0
    for k, measured in enumerate(ratio[np.isfinite(ratio)]):
        growth = np.exp(-0.5 * values["growth"] * prediction.log_energy[k])
        mean = prediction.ratio[k][:, None, None] + (-1) ** k * lean[:, None]
        deviation = np.exp(level) * growth[:, None, None]
        density = density * stats.t.pdf(measured, values["freedom"], mean, deviation)
    by_loss = np.einsum("cal,a,l->c", density, lean_weight, level_weight)
    centre = housner + values["centre"] + values["between"] * CENTRES.nodes
    prior = stats.norm.pdf(loss[:, None], centre, values["within"])
    prior /= stats.norm.sf(0, centre, values["within"])
    return np.log((by_loss[:, None] * prior).sum(axis=0) * (loss[1] - loss[0]))


def nodes_of(trial, nodes):
    """Return the nodes of one trial; weights that all trials share have one row."""
    quadratures = [
        Quadrature(
            quadrature.nodes[trial : trial + 1],
            np.broadcast_to(quadrature.log_weights, quadrature.nodes.shape)[trial : trial + 1],
        )
        for quadrature in nodes
    ]
    return Nodes(*quadratures)


@pytest.mark.parametrize("trial", [0, 37])
def test_likelihood_is_the_direct_integral(simulated, fitted, trial):
    """Over loss, alternation and noise of one trial, at each centre of its geometry."""
    values = parameter_values(fitted.point)
    ratio = simulated.trials.ratio[trial]
    housner = HOUSNER[trial % 4]
    single = Likelihood(Trials(ratio[None], np.zeros(1, int), np.array([housner])), LAW)
    weighted = single.centre_likelihood(values, nodes_of(trial, fitted.nodes))[0]
    expected = direct_log_likelihoods(ratio, housner, values)
    # Centres further out have no weight.
    np.testing.assert_allclose((weighted - CENTRES.log_weights)[3:12], expected[3:12], atol=0.03)


def test_maximum_exceeds_the_likelihood_of_the_truth(simulated, fitted):
    assert fitted.log_likelihood > simulated.log_likelihood(TRUTH, fitted.nodes)


@pytest.mark.parametrize("sign", [1, -1])
def test_maximum_exceeds_its_neighbours(simulated, fitted, sign):
    for step in np.diag([0.5 * search_range.scale for search_range in RANGES]):
        neighbour = simulated.log_likelihood(fitted.point + sign * step, fitted.nodes)
        assert neighbour < fitted.log_likelihood + 1e-3


def test_maximum_is_near_the_truth(fitted):
    values = parameter_values(fitted.point)
    truth = parameter_values(TRUTH)
    assert 0.7 < values["noise"] / truth["noise"] < 1.4
    assert abs(values["centre"] - truth["centre"]) < 0.03


def test_exponent_is_found_within_its_error():
    scores = []
    for seed in range(4):
        likelihood = simulate_trials(40, np.random.RandomState(seed), exponent=-0.5)
        fit = likelihood.fit(power_law=True)
        scores.append((fit.point[-1] + 0.5) / likelihood.standard_errors(fit)[-1])
    assert np.all(np.abs(scores) < 3)
    assert 0.3 < np.std(scores) < 2


def test_first_losses_cover_every_block():
    assert FIRST_LOSSES[0] < 0.001
    assert FIRST_LOSSES[-1] > 3 * HOUSNER.max()
