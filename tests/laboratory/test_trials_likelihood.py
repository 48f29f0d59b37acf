"""The likelihood of ratios: against direct integration, and truths that simulated trials give back."""

from functools import partial

import numpy as np
import pytest
from scipy import stats
from scipy.special import ndtr, ndtri

from rockdamp.laboratory.measured_rocking import restitution
from rockdamp.laboratory.trials import LOSSES, Trials, power_law
from rockdamp.laboratory.trials_likelihood import (
    CENTRES,
    START,
    Likelihood,
    TrialsFit,
    parameter_values,
)

IMPACTS, HOUSNER = 6, np.array([0.09, 0.06, 0.04, 0.02])
TRUTH = np.array([start for start, *_ in START.values()])[:-1]  # of the parameters but the exponent
law = partial(power_law, impacts=IMPACTS)


def simulated(count, random, exponent=0.0):
    """Return trials that the model makes with the truth."""
    values, geometry = parameter_values(TRUTH), np.arange(count) % HOUSNER.size
    centre = HOUSNER + values["centre"] + values["between"] * random.standard_normal(HOUSNER.size)
    lowest = ndtr(-centre / values["within"])[geometry]  # a loss below 0 is cut off
    loss = centre[geometry] + values["within"] * ndtri(
        lowest + (1 - lowest) * random.uniform(size=count)
    )
    level = values["noise"] * np.exp(values["noise_deviation"] * random.standard_normal(count))
    lean = values["lean"] + values["alternation"] * random.standard_normal(count)
    prediction = power_law(loss, exponent, IMPACTS)
    error = random.standard_t(values["freedom"], (IMPACTS, count))
    error *= np.exp(-0.5 * values["growth"] * prediction.log_energy)
    ratio = prediction.ratio + (-1.0) ** np.arange(IMPACTS)[:, None] * lean + level * error
    return Likelihood(Trials(ratio.T, geometry, HOUSNER), law)


@pytest.fixture(scope="module")
def made():
    """Forty trials of four blocks, some of four impacts, made with one e for all impacts of a trial."""
    likelihood = simulated(40, np.random.RandomState(5))
    likelihood.trials.ratio[30:, 4:] = np.nan
    return likelihood


@pytest.fixture(scope="module")
def fitted(made):
    return made.fit()


def test_likelihood_is_the_integral_over_loss_alternation_and_noise(made, fitted):
    """By sums over fine grids, of one trial of a geometry at each of its centres."""
    values = parameter_values(fitted.point)
    loss = 0.002 * (np.arange(150) + 0.5)
    prediction = law(loss, 0.0)
    lean, lean_weight = grid(values["lean"], values["alternation"])
    level, level_weight = grid(np.log(values["noise"]), values["noise_deviation"])
    for t in (0, 37):
        ratio, housner = made.trials.ratio[t : t + 1], HOUSNER[[t % 4]]
        one = Likelihood(Trials(ratio, np.zeros(1, int), housner), law)
        nodes = type(fitted.nodes)(
            *(part[t : t + 1] if part.shape[0] > 1 else part for part in fitted.nodes)
        )
        found = one.centre_likelihood(values, nodes)[0] - CENTRES[1]
        density = 1.0
        for k in range(np.isfinite(ratio).sum()):
            deviation = (
                np.exp(level)
                * np.exp(-0.5 * values["growth"] * prediction.log_energy[k])[:, None, None]
            )
            mean = prediction.ratio[k][:, None, None] + (-1) ** k * lean[:, None]
            density = density * stats.t.pdf(ratio[0, k], values["freedom"], mean, deviation)
        by_loss = np.einsum("cal,a,l->c", density, lean_weight, level_weight)
        centre = housner[0] + values["centre"] + values["between"] * CENTRES[0]
        prior = stats.norm.pdf(loss[:, None], centre, values["within"]) / stats.norm.sf(
            0, centre, values["within"]
        )
        expected = np.log((by_loss[:, None] * prior).sum(axis=0) * (loss[1] - loss[0]))
        np.testing.assert_allclose(
            found[3:12], expected[3:12], atol=0.03
        )  # centres further out have no weight


def grid(mean, deviation):
    at = np.linspace(-5, 5, 31)
    weight = np.exp(-0.5 * at**2)
    return mean + deviation * at, weight / weight.sum()


def test_maximum_is_one_and_near_the_truth(made, fitted):
    assert fitted.log_likelihood > made.log_likelihood(TRUTH, fitted.nodes)
    for step in np.diag([0.5 * scale for *_, scale in START.values()][:-1]):
        for sign in (1, -1):
            assert (
                made.log_likelihood(fitted.point + sign * step, fitted.nodes)
                < fitted.log_likelihood + 1e-3
            )
    found, true = parameter_values(fitted.point), parameter_values(TRUTH)
    assert (
        0.7 < found["noise"] / true["noise"] < 1.4 and abs(found["centre"] - true["centre"]) < 0.03
    )


def test_exponent_is_found_within_its_error():
    z = []
    for seed in range(6):
        made = simulated(60, np.random.RandomState(seed), exponent=-0.5)
        fit = made.fit(power_law=True)
        z.append((fit.point[-1] + 0.5) / made.standard_errors(fit)[-1])
    assert np.all(np.abs(z) < 3) and 0.3 < np.std(z) < 2


# --- restitution ------------------------------------------------------------------------------------------------------


def fitted_restitution(ratio, geometry, housner, **changes):
    """Return e over Housner's by a fit that nobody made."""
    values = {
        "noise": 0.03,
        "freedom": 1.0,
        "alternation": 1e-3,
        "lean": 0.0,
        "noise_deviation": 0.1,
        "growth": 1e-9,
    }
    values |= {"centre": 0.0} | changes
    plain = ("lean", "growth", "centre")
    point = np.array(
        [values[name] if name in plain else np.log(values[name]) for name in [*START][:-1]]
    )
    likelihood = Likelihood(
        Trials(ratio, geometry, housner), partial(power_law, impacts=ratio.shape[1])
    )
    return restitution(
        likelihood, TrialsFit(0.0, point, likelihood.spread_nodes(parameter_values(point)))
    )


def test_restitution_over_housner_and_its_spreads():
    """Two blocks of four trials: ln e of blocks is 0.02 off Housner's, ln e of trials 0.012 off their block's.

    Every first ratio is 0.03 larger than e, as of a bad start.
    """
    slenderness, geometry = np.array([3.0, 4.0]), np.repeat([0, 1], 4)
    housner = -np.log(1.5 * np.sin(np.arctan(slenderness)) ** 2 - 0.5)
    log_e = -housner[geometry] + np.array([0.02, -0.02])[geometry] + 0.012 * np.tile([1.0, -1.0], 4)
    ratio = np.repeat(np.exp(log_e)[:, None], 10, axis=1)
    ratio[:, 0] += 0.03
    found = fitted_restitution(ratio, geometry, housner, within=0.012, between=0.03)
    np.testing.assert_allclose(
        found["restitution_over_housner"][1], np.exp([0.02, -0.02]), atol=0.008
    )
    assert found["restitution_over_housner_mean"] == pytest.approx(1.0, abs=0.002)
    assert found["first_ratio_deviation_within"] == pytest.approx(
        np.log(ratio[:, 0]).reshape(2, 4).std(axis=1).mean(), rel=0.01
    )
    assert found["deviation_within"] == pytest.approx(0.012, rel=0.05)
    assert found["deviation_between"] == pytest.approx(0.03, rel=0.05)
    np.testing.assert_allclose(found["trial_deviation"][1], np.hypot(0.012, 0.03), rtol=0.05)


def test_blocks_that_lose_little_scatter_less():
    """A normal loss is cut off at 0: three deviations away at H/B = 4, a quarter of one at 15."""
    geometry = np.repeat([0, 1], 4)
    housner = -np.log(1.5 * np.sin(np.arctan([4.0, 15.0])) ** 2 - 0.5)
    ratio = np.repeat(np.exp(-housner[geometry])[:, None], 10, axis=1)
    found = fitted_restitution(ratio, geometry, housner, within=0.03, between=1e-3)
    expected = [stats.truncnorm(-loss / 0.03, np.inf, scale=0.03).std() for loss in housner]
    np.testing.assert_allclose(found["trial_deviation"][1], expected, rtol=0.02)


def test_intervals_hold_90_per_cent():
    """Trials that say nothing, as their noise is huge: 1.645 of the spread between blocks, or of all of it."""
    within, between = 0.03, 0.004
    found = fitted_restitution(
        np.full((4, 2), 0.85),
        np.zeros(4, int),
        np.array([0.16]),
        noise=5.0,
        within=within,
        between=between,
    )
    for name, deviation in (("restitution", between), ("trial", np.hypot(within, between))):
        ends = np.log(found[f"{name}_over_housner_interval"][1][0])
        np.testing.assert_allclose(ends, [-1.645 * deviation, 1.645 * deviation], rtol=0.03)


def test_grid_of_losses_holds_every_block():
    assert LOSSES[0] < 0.001 and LOSSES[-1] > 3 * HOUSNER.max()
