"""The likelihood of ratios: against direct integration, and truths that simulated trials give back."""

import numpy as np
import pytest
from scipy import stats

from rockdamp.laboratory.trials_fit import (
    Expansion,
    Search,
    TrialsFit,
    at_each_centre,
    fit,
    share_below,
    simulated,
)
from rockdamp.laboratory.velocity_ratios import (
    CENTRES,
    LOSSES,
    STARTS,
    ErrorModel,
    Trials,
    by_impact,
    power_law,
)

IMPACTS = 6
HOUSNER = np.array([0.09, 0.06, 0.04, 0.02])


def constant(losses, _):
    return power_law(losses, 0.0, IMPACTS)


def truth(trials, **changes):
    """Return a fit that nobody made: the parameters that simulate trials."""
    named = {name: STARTS[name][0] for name in trials.errors.names} | changes
    point = np.array(list(named.values()))
    return TrialsFit(0.0, point, trials.values(point), np.empty(0), None)


@pytest.fixture(scope="module")
def trials():
    """Forty trials of four blocks, made with one e for all impacts of a trial."""
    shape = Trials(np.zeros((40, IMPACTS)), np.arange(40) % 4, HOUSNER)
    return simulated(shape, constant, truth(shape), np.random.RandomState(5))


@pytest.fixture(scope="module")
def fitted(trials):
    return fit(trials, constant)


def test_the_power_law_with_exponent_0_is_a_geometric_decay_and_others_follow_the_energy():
    losses = np.array([0.02, 0.1])
    ratio, log_energy = power_law(losses, 0.0, 5)
    np.testing.assert_allclose(ratio, np.exp(-np.broadcast_to(losses, (5, 2))), rtol=1e-14)
    np.testing.assert_allclose(log_energy, -2 * np.arange(5)[:, None] * losses, rtol=1e-12)
    ratio, log_energy = power_law(losses, 0.5, 5)
    np.testing.assert_allclose(-np.log(ratio), losses * np.exp(0.5 * log_energy), rtol=1e-12)
    np.testing.assert_allclose(np.diff(log_energy, axis=0), 2 * np.log(ratio[:-1]), rtol=1e-12)


def test_a_profile_by_impact_has_the_mean_loss_and_goes_on_from_the_energy_that_is_left():
    losses = np.array([0.02, 0.1])
    ratio, log_energy = by_impact(losses, np.array([0.3, -0.1]))
    loss = -np.log(ratio)
    np.testing.assert_allclose(np.log(loss).mean(axis=0), np.log(losses), rtol=1e-12)
    np.testing.assert_allclose(loss[0] / losses, np.exp(0.3), rtol=1e-12)
    np.testing.assert_allclose(log_energy[2], -2 * (loss[0] + loss[1]), rtol=1e-12)


def test_the_likelihood_of_a_trial_is_the_integral_over_its_loss_alternation_and_noise(trials, fitted):
    """By sums over fine grids, of every trial at each of its geometry's centres."""
    values, nodes = fitted.values, fitted.nodes
    search = Search(trials, constant, nodes)
    found = trials.at_centres(values, search.of_losses(fitted.point), nodes)
    loss = 0.002 * (np.arange(150) + 0.5)
    prediction = power_law(loss, 0.0, IMPACTS)
    lean, lean_weight = grid(values["lean"], values["alternation"])
    level, level_weight = grid(np.log(values["noise"]), values["noise_deviation"])
    for t in (0, 7):
        density = 1.0
        for k in range(IMPACTS):
            deviation = np.exp(level) * np.exp(-0.5 * values["growth"] * prediction.log_energy[k])[:, None, None]
            mean = prediction.ratio[k][:, None, None] + (-1) ** k * lean[:, None]
            density = density * stats.t.pdf(trials.ratio[t, k], values["freedom"], mean, deviation)
        of_loss = np.einsum("cal,a,l->c", density, lean_weight, level_weight)
        centre = HOUSNER[trials.geometry[t]] + values["centre"] + values["between"] * CENTRES[0]
        prior = stats.norm.pdf(loss[:, None], centre, values["within"]) / stats.norm.sf(0, centre, values["within"])
        expected = np.log((of_loss[:, None] * prior).sum(axis=0) * (loss[1] - loss[0]))
        # Centres further out have no weight.
        np.testing.assert_allclose(found[t, 3:12], expected[3:12], atol=0.03)


def grid(mean, deviation):
    at = np.linspace(-5, 5, 31)
    weight = np.exp(-0.5 * at**2)
    return mean + deviation * at, weight / weight.sum()


@pytest.mark.parametrize(
    ("errors", "predict", "shape"),
    [
        (ErrorModel(correlation=True), lambda losses, shape: power_law(losses, shape[0], IMPACTS), [0.2]),
        (ErrorModel(by_trial=False, alternation=False), by_impact, [0.05, -0.1, 0.02, 0.1, 0.0]),
    ],
)
def test_the_gradient_is_that_of_differences(trials, errors, predict, shape):
    """With trials of fewer impacts among them."""
    ratio = trials.ratio.copy()
    ratio[30:, 4:] = np.nan
    shorter = Trials(ratio, trials.geometry, HOUSNER, errors)
    named = {name: STARTS[name][0] for name in errors.names} | ({"correlation": 0.3} if errors.correlation else {})
    point = np.array([*named.values(), *shape])
    nodes = shorter.spread_nodes(shorter.values(point))
    search = Search(shorter, predict, nodes)
    ahead, behind = (
        [search.negative(point + sign * step)[0] for step in 1e-5 * np.eye(point.size)] for sign in (1, -1)
    )
    np.testing.assert_allclose(search.negative(point)[1], np.subtract(ahead, behind) / 2e-5, rtol=1e-6, atol=1e-5)


def test_the_maximum_is_one_and_near_what_made_the_trials(trials, fitted):
    search = Search(trials, constant, fitted.nodes)
    made = truth(trials)
    assert fitted.log_likelihood > -search.negative(made.point)[0]
    ratio = fitted.values["noise"] / made.values["noise"]
    assert 0.7 < ratio < 1.4
    assert abs(fitted.values["centre"] - made.values["centre"]) < 0.03
    steeper = fit(trials, lambda losses, _: power_law(losses, 0.5, IMPACTS), start=fitted)
    assert steeper.log_likelihood < fitted.log_likelihood


def test_correlation_of_neighbouring_errors_is_found_where_it_is_and_not_where_it_is_not():
    errors = ErrorModel(correlation=True, growth=0.0, heavy_tails=False, alternation=False, by_trial=False)
    shape = Trials(np.zeros((60, 10)), np.arange(60) % 4, HOUSNER, errors)
    random, noise = np.random.RandomState(2), 0.01
    deviations = noise * random.standard_normal((60, 11))
    mean = np.exp(-HOUSNER[shape.geometry])[:, None]
    found = []
    for part in (0.0, -0.6):
        ratio = mean + deviations[:, 1:] + part * deviations[:, :-1]
        made = Trials(ratio, shape.geometry, HOUSNER, errors)
        found.append(fit(made, lambda losses, _: power_law(losses, 0.0, 10)).values["correlation"])
    assert abs(found[0]) < 0.1 and abs(found[1] + 0.6) < 0.1


def test_an_expansion_gives_the_fits_of_trials_that_are_drawn_again_or_left_out(trials, fitted):
    expansion = Expansion.about(trials, constant, fitted)
    ones = np.ones(len(trials.ratio))
    np.testing.assert_allclose(expansion.negative(fitted.point, ones)[0], -fitted.log_likelihood, rtol=1e-6)
    slope = expansion.negative(fitted.point, ones)[1]
    step = 1e-5 * np.eye(slope.size)
    differences = [
        (expansion.negative(fitted.point + d, ones)[0] - expansion.negative(fitted.point - d, ones)[0]) / 2e-5
        for d in step
    ]
    np.testing.assert_allclose(slope, differences, atol=0.01)
    kept = trials.geometry != 3
    fewer = Trials(trials.ratio[kept], trials.geometry[kept], HOUSNER)
    exact = fit(fewer, constant, start=fitted, other_ratios=True)
    near = expansion.fit(kept)
    deviation = expansion.deviation
    for name in ("noise", "centre", "growth"):
        index = trials.errors.names.index(name)
        assert abs(near[index] - exact.point[index]) < 0.5 * deviation[index], name


def test_ranks_of_simulated_first_ratios_are_uniform(trials):
    """Each of its own geometry, as those of one share a centre."""
    made = truth(trials)
    many = Trials(np.zeros((300, 1)), np.arange(300), np.full(300, HOUSNER[0]))
    one = simulated(many, lambda losses, _: power_law(losses, 0.0, 1), made, np.random.RandomState(3))
    assert stats.kstest(share_below(one, made.values, np.arange(300)), "uniform").pvalue > 0.01


def test_losses_at_each_centre_are_normal_about_it_and_cut_off_at_zero(trials):
    values = truth(trials).values
    centre = HOUSNER[:, None] + values["centre"] + values["between"] * CENTRES[0]
    mean = stats.truncnorm.mean(-centre / values["within"], np.inf, loc=centre, scale=values["within"])
    np.testing.assert_allclose(np.einsum("c,gcj->gj", LOSSES, at_each_centre(trials, values)), mean, atol=5e-4)


def test_the_grid_of_losses_holds_every_block():
    assert LOSSES[0] < 0.001 and LOSSES[-1] > 3 * HOUSNER.max()
