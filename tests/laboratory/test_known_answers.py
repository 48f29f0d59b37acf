"""What selects and summarises measured trials, on made-up cases whose answer is known by hand."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import ndtr
from scipy.stats import truncnorm

from rockdamp.laboratory import measured_rocking as stage
from rockdamp.laboratory.trials_fit import TrialsFit, drawn, share_below
from rockdamp.laboratory.velocity_ratios import CENTRES, MOST, UNSCALED, Trials, impacts_to_stop, law_of_loss
from rockdamp.solvers.exact import kept_velocity


def fit_of(trials, **values):
    """Return a fit that nobody made, by its parameters as they are."""
    named = {name: values[name] for name in trials.errors.names}
    point = np.array([value if name in UNSCALED else np.log(value) for name, value in named.items()])
    of = trials.values(point)
    return TrialsFit(0.0, point, of, np.empty(0), trials.spread_nodes(of))


def study_of(ratio, geometry, thickness, height, **settings):
    """Return the study of some ratios, shape (trials, impacts)."""
    measured = SimpleNamespace(
        ratio=ratio,
        geometry=geometry,
        thickness=np.asarray(thickness),
        height=np.asarray(height),
        slenderness=np.asarray(height) / np.asarray(thickness),
    )
    shown = {"shown_impacts": ratio.shape[1], "shown_yield_displacement_ratio": 0.01, "shown_release_amplitude": 0.5}
    return stage._Study(SimpleNamespace(**shown, **settings), measured)


def test_a_fit_never_sees_the_trials_that_it_is_judged_by(monkeypatch):
    """Ten trials of five blocks, two blocks held out in each of the ten choices; of four shares two lie inside."""
    geometry, seen, judged = np.repeat(np.arange(5), 2), [], []

    def fitted(weights):
        seen.append(np.asarray(weights, dtype=bool))
        return "the fit"

    def below(trials, values, members):
        judged.append(members)
        assert values == "its values"
        return np.array([0.04, 0.06, 0.94, 0.96])  # an interval of 90 % reaches from 0.05 to 0.95

    monkeypatch.setattr(stage.Expansion, "about", lambda *_: SimpleNamespace(fit=fitted))
    monkeypatch.setattr(stage, "share_below", below)
    monkeypatch.setattr(stage.Trials, "values", lambda *_: "its values")
    study = study_of(np.full((10, 3), 0.9), geometry, np.full(5, 0.05), np.linspace(0.2, 0.5, 5), held_out=2)
    found = study.held_out(None)
    assert found["held_out_coverage"].values.tolist() == [0.5] * 10
    for weights, members in zip(seen, judged, strict=True):
        assert sorted([*np.flatnonzero(weights), *members]) == list(range(10))
        assert len(members) == 4 and len(set(geometry[members])) == 2


def test_trials_are_drawn_with_replacement_within_their_block():
    """Of ten drawn ten times each is missed by 0.9 ** 10 = 0.349 of the draws."""
    geometry, random = np.repeat([0, 1], 10), np.random.RandomState(3)
    weights = np.array([drawn(geometry, random) for _ in range(400)])
    assert np.all(weights[:, :10].sum(axis=1) == 10) and np.all(weights[:, 10:].sum(axis=1) == 10)
    assert np.mean(weights == 0) == pytest.approx(0.9**10, abs=0.02)


@pytest.mark.parametrize("away", [-1.0, 0.0, 1.0])
def test_the_share_below_a_first_ratio_has_noise_alternation_and_lean(away):
    """Noise and alternation are normal here, and so is their sum: the share is that of a normal distribution."""
    noise, alternation, lean, loss = 0.02, 0.015, 0.01, 0.1
    values = {"noise": noise, "noise_deviation": 0.0, "alternation": alternation, "lean": lean, "freedom": 200.0}
    values |= {"centre": 0.0, "within": 1e-3, "between": 1e-6}
    deviation = np.hypot(noise, alternation)
    ratio = np.array([[np.exp(-loss) + lean + away * deviation]])
    trials = Trials(ratio, np.array([0]), np.array([loss]))
    assert share_below(trials, values, np.array([0])) == pytest.approx(ndtr(away), abs=0.02)


def test_the_interval_of_a_profile_is_that_of_its_parabola():
    """ln L = -(x - m)^2 / (2 s^2): an interval of 90 % reaches 1.645 s to either side of m."""
    at, middle, s = np.linspace(-1.0, 1.0, 9), 0.1, 0.3
    best, (low, high), largest = stage.profile(at, 7.0 - (at - middle) ** 2 / (2 * s**2))
    assert (best, largest) == pytest.approx((middle, 7.0), abs=1e-3)
    assert (low, high) == pytest.approx((middle - 1.645 * s, middle + 1.645 * s), abs=1e-3)
    assert not stage.profile(at, -((at + 0.5) ** 2) / (2 * 0.1**2))[1][1] >= 0  # 0 is five deviations away


@pytest.fixture(scope="module")
def spread():
    """Two blocks of four trials: ln e of the blocks is 0.02 off Housner's either way, that of trials 0.012 off theirs.

    Every first ratio is 0.03 larger than e, as of a bad start.
    """
    thickness, height = np.full(2, 0.05), np.array([0.15, 0.20])
    housner = 1.5 * np.sin(np.arctan(height / thickness)) ** 2 - 0.5
    geometry = np.repeat([0, 1], 4)
    log_e = np.log(housner)[geometry] + np.array([0.02, -0.02])[geometry] + 0.012 * np.tile([1.0, -1.0], 4)
    ratio = np.repeat(np.exp(log_e)[:, None], 10, axis=1)
    ratio[:, 0] += 0.03
    study = study_of(ratio, geometry, thickness, height)
    trials = Trials(ratio, geometry, -np.log(housner), stage.AS_DESCRIBED)
    values = {"noise": 0.03, "freedom": 1.0, "alternation": 1e-3, "lean": 0.0, "noise_deviation": 0.1}
    fitted = fit_of(trials, **values, growth=0.0, centre=0.0, within=0.012, between=0.03)
    return study.restitution(fitted), np.exp(log_e), housner, geometry


def test_e_over_housner_is_that_of_all_impacts_and_not_of_the_first_ratios(spread):
    found, e, housner, geometry = spread
    means = np.array([np.exp(np.log(e[geometry == g]).mean()) for g in (0, 1)]) / housner
    np.testing.assert_allclose(found["restitution_over_housner"], means, atol=0.008)
    assert np.all(found["first_ratio_over_housner"] - means > 0.025)
    # The mean is that of all blocks there are: the fit has it at Housner's, whatever these two are.
    assert float(found["restitution_over_housner_mean"]) == pytest.approx(1.0, abs=0.002)
    assert float(found["first_ratio_mean"]) == pytest.approx(np.sqrt(np.prod(found["first_ratio_over_housner"])))


def test_the_spread_within_blocks_is_not_that_between_them(spread):
    found, e, housner, geometry = spread
    first = np.log(e + 0.03) - np.log(housner)[geometry]
    means = np.array([first[geometry == g].mean() for g in (0, 1)])
    assert float(found["first_ratio_deviation_between"]) == pytest.approx(abs(means[1] - means[0]) / 2, rel=1e-9)
    within = np.sqrt(np.mean((first - means[geometry]) ** 2))
    assert float(found["first_ratio_deviation_within"]) == pytest.approx(within, rel=1e-9)
    assert within < 0.8 * float(found["first_ratio_deviation_between"])
    assert float(found["deviation_within"]) == pytest.approx(0.012, rel=0.05)
    assert float(found["deviation_between"]) == pytest.approx(0.03, rel=0.05)
    np.testing.assert_allclose(found["trial_deviation"], np.hypot(0.012, 0.03), rtol=0.05)


def test_blocks_that_lose_little_scatter_less_as_no_impact_gains_energy():
    """A normal loss about Housner's, cut off at 0: at H/B = 4 three deviations from there, at 15 a quarter of one."""
    thickness, height, geometry = np.full(2, 0.05), np.array([0.2, 0.75]), np.repeat([0, 1], 4)
    loss = -np.log(1.5 * np.sin(np.arctan(height / thickness)) ** 2 - 0.5)
    ratio = np.repeat(np.exp(-loss[geometry])[:, None], 10, axis=1)
    study = study_of(ratio, geometry, thickness, height)
    values = {"noise": 0.03, "freedom": 1.0, "alternation": 1e-3, "lean": 0.0, "noise_deviation": 0.1, "growth": 0.0}
    trials = Trials(ratio, geometry, loss, stage.AS_DESCRIBED)
    found = study.restitution(fit_of(trials, **values, centre=0.0, within=0.03, between=1e-3))
    expected = [truncnorm(-each / 0.03, np.inf, scale=0.03).std() for each in loss]
    np.testing.assert_allclose(found["trial_deviation"], expected, rtol=0.02)
    assert expected[1] < 0.7 * expected[0]


def test_intervals_of_a_block_and_of_its_next_trial_are_of_90_per_cent(monkeypatch):
    """Trials that say nothing of their block: 1.645 of the spread between blocks, or of all of it, to either side."""
    height, within, between = np.array([0.15]), 0.03, 0.004
    ratio = np.full((4, 10), 0.85)
    study = study_of(ratio, np.zeros(4, dtype=int), [0.05], height)
    values = {"noise": 0.03, "freedom": 1.0, "alternation": 1e-3, "lean": 0.0, "noise_deviation": 0.1, "growth": 0.0}
    fitted = fit_of(study.trials(10), **values, centre=0.0, within=within, between=between)
    monkeypatch.setattr(stage.Trials, "centres_seen", lambda *_: np.exp(CENTRES[1])[None])
    found = study.restitution(fitted)
    for name, deviation in (("restitution", between), ("trial", np.hypot(within, between))):
        ends = np.log(found[f"{name}_over_housner_interval"].values[0])
        np.testing.assert_allclose(ends, [-1.645 * deviation, 1.645 * deviation], rtol=0.02)


def test_the_interval_by_bootstrap_leaves_a_twentieth_of_the_replicates_on_either_side(monkeypatch):
    """Of 101 replicates with the exponents 0, 1 ... 100: from 5 to 95."""
    found = iter([(0.0, [0.0, 0.0], 0.0), *((float(k), [0.0, 0.0], 0.0) for k in range(101))])
    one = SimpleNamespace(log_likelihood=0.0, fit=lambda weights: None, negative=lambda point, weights: (0.0, None))
    monkeypatch.setattr(stage, "profile", lambda *_: next(found))
    monkeypatch.setattr(stage, "fit", lambda *_, **__: one)
    monkeypatch.setattr(stage.Expansion, "about", lambda *_: one)
    bootstrap = SimpleNamespace(replicates=101, seed=1)
    tried = {"impacts_used": np.array([3.0]), "amplitude_exponent": np.array([-1.0, 0.0, 1.0]), "bootstrap": bootstrap}
    study = study_of(np.full((4, 3), 0.9), np.zeros(4, dtype=int), [0.05], [0.2], **tried)
    interval = study.by_amplitude()[0]["amplitude_exponent_bootstrap_interval"]
    np.testing.assert_allclose(interval, [5.0, 95.0])


@pytest.mark.parametrize(("g", "loss"), [(0.26, 0.05), (0.4, 0.1), (0.13, 0.2)])
def test_the_law_of_loss_is_that_of_the_impact_and_stops_where_it_says(g, loss):
    """The impacts one after the other, by the formula of the event-driven solver: 40, 13 and 20 of them."""
    stop = int(impacts_to_stop(np.array([loss]), g)[0])
    predicted = law_of_loss(np.array([loss]), g, stop + 1)
    speed, ratios = 1.0, []
    for _ in range(stop - 1):
        e = kept_velocity(speed, np.exp(-loss), g, 1.0)  # 2 V_1 = 1
        ratios.append(max(e, np.exp(-MOST)))
        speed *= e
    np.testing.assert_allclose(predicted.ratio[: stop - 1, 0], ratios, rtol=1e-9)
    assert speed > 0 and kept_velocity(speed, np.exp(-loss), g, 1.0) == 0.0
    np.testing.assert_allclose(predicted.ratio[stop - 1 :, 0], np.exp(-MOST))
    energy = np.exp(g * predicted.log_energy[: stop - 1, 0])
    np.testing.assert_allclose(np.diff(energy), -(1 - np.exp(-2 * g * loss)), rtol=1e-9)
    np.testing.assert_allclose(law_of_loss(np.array([loss]), 1e-9, 5).ratio, np.exp(-loss), rtol=1e-7)


def test_impacts_beyond_the_stop_and_the_middle_stop_are_weighted_by_probability():
    stop, probability = np.array([[30.0, 20.0, 10.0], [5.0, 6.0, 7.0]]), np.array([[0.2, 0.3, 0.5], [2.0, 1.0, 1.0]])
    assert stage.beyond_stop(stop, probability, np.array([15, 6])).tolist() == [0.5, 0.5]
    assert stage.beyond_stop(stop, probability, np.array([10, 8])).tolist() == [0.0, 1.0]
    assert stage.middle(stop, probability).tolist() == [10.0, 5.0]


def test_the_law_is_found_in_trials_that_follow_it():
    """Forty trials of two blocks with g = 0.3, of a noise of 0.005; half of them went on for longer than it allows."""
    random, g, count = np.random.RandomState(5), 0.3, 40
    height, geometry = np.array([0.2, 0.3]), np.repeat([0, 1], count // 2)
    housner = -np.log(1.5 * np.sin(np.arctan(height / 0.05)) ** 2 - 0.5)
    loss = housner[geometry] + 0.01 * random.standard_normal(count)
    ratio = law_of_loss(loss, g, 8).ratio.T + 0.005 * random.standard_normal((count, 8))
    allowed = impacts_to_stop(loss, g)
    whole = np.full((count, int(2 * allowed.max())), np.nan)
    whole[:, :8] = ratio
    for trial, last in enumerate(allowed):
        whole[trial, : int(last * (1.5 if trial % 2 else 0.7))] = 0.9
    whole[:, :8] = ratio
    study = study_of(whole, geometry, [0.05, 0.05], height, impacts_used=np.array([8.0]))
    study.settings.shown_impacts = 8
    found = study.by_law()
    assert float(found["loss_exponent"][0]) == pytest.approx(g, abs=0.05)
    assert float(found["share_beyond_stop"][0]) == pytest.approx(0.5, abs=0.05)
    np.testing.assert_allclose(found["allowed_impacts"], allowed, rtol=0.25)
    np.testing.assert_array_equal(found["measured_impacts"], np.isfinite(whole).sum(axis=1))
