"""The noise of the measured motion: its main directions, its mean, and the response to it as it follows parameters."""

from dataclasses import replace

import numpy as np
import pytest
from experimental_style import WALL
from random_tests import drawn
from repository import ROOT
from scipy.linalg import eigh

from rockdamp.errors import InputError
from rockdamp.histories.measured_test import motion_noise, rest_samples
from rockdamp.laboratory import problem
from rockdamp.laboratory.candidates import Candidate, Prior
from rockdamp.laboratory.least_squares import RecordFit
from rockdamp.laboratory.noise import MOST_DIRECTIONS, MotionNoise, Noise, correlated, main_directions, noise_directions
from rockdamp.laboratory.problem import Problem
from rockdamp.laboratory.sampler import Draws
from rockdamp.motions.records import Record, read_record
from rockdamp.plausibility import as_meant

MADE = np.array([0.0305, 0.798, 0.84])
SENSOR = (1.5e-4, 0.1)


@pytest.fixture(scope="module")
def noise():
    record = read_record(ROOT / "data/test_series/cr-nine-tenths.csv")
    fit = RecordFit.from_record(
        record, WALL, Candidate.from_name("CR"), ultimate_displacement_ratio=1.0, softening="steeper", step=0.00125
    )  # fine, so that the solver is smooth
    return MotionNoise.at(fit, MADE, np.zeros(record.elapsed.size), 1e-3 * fit.trend.T, SENSOR)


@pytest.mark.parametrize("samples", [MOST_DIRECTIONS // 2, 2 * MOST_DIRECTIONS])
def test_a_motion_that_is_the_sum_of_the_directions_is_as_noisy_as_the_record(samples):
    random, elapsed = np.random.RandomState(5), np.arange(samples) / 500
    pulse = np.sin(np.arange(samples) / 40) * (np.abs(elapsed / elapsed[-1] - 0.5) < 0.2)
    record = Record(elapsed, pulse + 0.01 * random.standard_normal(samples))
    directions = noise_directions(record)
    noise = np.einsum("k,kt->t", random.standard_normal(len(directions)), directions)
    assert np.std(noise) == pytest.approx(motion_noise(record), rel=0.1)


def test_the_main_directions_hold_all_but_a_negligible_variance():
    random = np.random.RandomState(2)
    shapes = np.stack([np.sin(np.arange(60) / 7), np.cos(np.arange(60) / 3), np.linspace(0, 1, 60)])
    effect = random.standard_normal((256, 3)) @ (shapes * [[3.0], [1.0], [0.5]])
    rows = main_directions(effect, 1e-6)
    assert len(rows) == 3
    np.testing.assert_allclose(rows.T @ rows, effect.T @ effect, atol=1e-5)
    whole = np.sum(effect**2, axis=0)
    fewer = main_directions(effect, 0.2 * whole.max())
    left = whole - np.sum(fewer**2, axis=0)
    assert len(fewer) < 3 and 0 < left.max() <= 0.2 * whole.max()


@as_meant()
@pytest.mark.parametrize("number", [5, 26])
def test_what_is_neglected_of_the_noise_adds_at_most_a_twentieth_to_the_scatter_of_the_parameters(number):
    """By the covariance of the generalised least squares under all directions, weighted by the main ones alone."""
    made, prior = drawn(7, number), Prior()
    fit = RecordFit.from_record(
        made.record,
        made.wall,
        Candidate.from_name("CR"),
        ultimate_displacement_ratio=1.0,
        softening="steeper",
        step=0.01,
    )
    trend = fit.trend.T * [[prior.sensor_zero], [prior.sensor_drift]]
    sensor = (made.sensor_deviation, 0.45)
    motion = MotionNoise.at(fit, np.array(made.truth), np.zeros(made.record.elapsed.size), trend, sensor)

    def scatter(main):
        weighted = Noise(np.concatenate([trend, main])).by_inverse(
            motion.derivative, *(np.full(3, value) for value in sensor)
        )
        stated = np.linalg.inv(weighted @ motion.derivative.T)
        by_all, by_main = stated @ weighted @ motion.effect.T, stated @ weighted @ main.T
        return np.sqrt(1 + np.diag(by_all @ by_all.T - by_main @ by_main.T) / np.diag(stated))

    assert scatter(motion.noise.rows[2:]).max() < 1.05
    with_drift = float(np.std(fit.measured[: rest_samples(made.record)]))  # the drift taken for noise
    assert scatter(main_directions(motion.effect, (0.1 * with_drift) ** 2)).max() > 1.5


def test_the_mean_of_the_noise_explains_what_a_known_noise_did(noise):
    made = np.random.RandomState(1).standard_normal(noise.about.size)
    residual = made @ noise.effect
    found = noise.mean(residual[None], np.array([SENSOR[0]]), np.array([0.0]))[0]
    # It has no part in directions that the response does not show, and so it is smaller than what was made.
    assert np.linalg.norm(found) < 0.5 * np.linalg.norm(made)
    assert np.std(residual) > 5 * np.std(residual - found @ noise.effect)


@pytest.fixture(scope="module")
def ridge(noise):
    """One standard deviation along that change of parameters which the noise of the motion hides best."""
    by_sensor_alone = noise.derivative @ noise.derivative.T / SENSOR[0] ** 2
    return eigh(by_sensor_alone, noise.precision)[1][:, -1]


def test_the_noise_follows_the_parameters_so_that_the_response_stays_where_it_was(noise, ridge):
    there = np.stack([MADE, MADE + ridge, MADE - ridge])
    followed, alone = noise.computed(there), noise.fit.computed(there)
    np.testing.assert_array_equal(followed[0], alone[0])
    for with_noise, without in zip(followed[1:], alone[1:], strict=True):
        assert np.std(with_noise - followed[0]) < 0.3 * np.std(without - alone[0])


def test_what_is_left_is_as_if_the_noise_had_not_followed_where_its_effect_is_small_enough_to_be_linear(noise, ridge):
    there = np.stack([MADE + 0.1 * ridge, MADE - 0.1 * ridge])
    followed, alone = noise.computed(there), noise.fit.computed(there)
    left = noise.residuals(there, followed)
    assert np.std(followed - alone) > 5 * np.std(left - (noise.fit.measured - alone))


@pytest.fixture(scope="module")
def made(noise):
    return Problem.about(noise.fit.with_step(0.02).solution(), Prior())


def test_a_noise_that_is_corrected_leaves_less_that_is_not_linear_and_the_same_likelihood_near_by(noise, ridge):
    there, corrected = np.stack([MADE + 2 * ridge, MADE - 2 * ridge]), replace(noise, corrected=True)
    sensor = [np.full(2, value) for value in SENSOR]
    assert np.std(corrected.beyond(there, *sensor)) < 0.2 * np.std(noise.beyond(there, *sensor))
    _, residuals, about = corrected._corrected(there, *sensor)
    again = noise.noise.mean(residuals, *sensor)[:, 2:]
    assert np.abs(again - about).max() < 1e-4 * np.abs(about).max()  # one more step moves it no more
    near = np.stack([MADE, MADE + 0.02 * ridge])
    likelihoods = [one.noise.log_likelihood(one.response(near, *sensor)[1], *sensor) for one in (noise, corrected)]
    assert np.abs(np.diff(likelihoods[0])) > 0.01
    np.testing.assert_allclose(*(value - value[0] for value in likelihoods), atol=0.1)


def test_a_response_that_is_not_linear_in_the_noise_is_corrected_or_refused(monkeypatch, made):
    points = made.mode + 0.5 * np.random.RandomState(3).standard_normal((4, 5)) @ made._neighbourhood().lower.T
    draws = Draws(np.clip(points, 1e-3, 1 - 1e-3), np.full(4, 0.25), np.zeros(4), 0.0)
    monkeypatch.setattr(Problem, "_drawn", lambda self, *_: (self, draws))
    monkeypatch.setattr(problem, "LINEAR", 10.0)
    assert made.drawn(300, 1)[0] is made
    monkeypatch.setattr(problem, "LINEAR", made.beyond_linear(draws) / 2)
    monkeypatch.setattr(problem, "FINER", 1.0)
    assert made.drawn(300, 1)[0].runs[0].corrected
    monkeypatch.setattr(problem, "LINEAR", 1e-9)
    with pytest.raises(InputError, match=r"differs from a linear one by .* noise moves the response by .* mm"):
        made.drawn(300, 1)


def test_a_model_that_leaves_more_than_the_noise_at_rest_is_doubted(made):
    at_rest = made.fit.rest_deviation
    assert not made.doubts(1.4 * at_rest)
    (doubt,) = made.doubts(3.2 * at_rest)
    assert doubt.startswith("what CR leaves of the record is 3.2 times the sensor's noise at rest")


def test_a_short_rest_is_no_measure_of_the_sensors_noise():
    """Of samples from one distribution the deviation is as much too small as told once in a thousand times."""
    random = np.random.RandomState(6)
    rests = random.standard_normal((4000, 20))
    beyond = np.mean([1 / rest.std() > problem._by_chance(rest) for rest in rests])
    assert 0 < beyond < 0.004
    assert problem._by_chance(random.standard_normal(2000)) < 1.1
    # Neighbours that follow each other tell less: as if all were independent, one of nine would seem beyond chance.
    following = [correlated(1.0, 0.8, random.standard_normal(100)) for _ in range(1000)]
    assert np.mean([1 / rest.std() > problem._by_chance(rest) for rest in following]) < 0.03
