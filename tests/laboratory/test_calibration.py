"""Calibration: what made a record is found again, with errors that are honest."""

from dataclasses import replace

import numpy as np
import pytest
from configs import configured
from experimental_style import WALL, synthetic_record
from repository import ROOT

from rockdamp.errors import InputError
from rockdamp.laboratory import least_squares
from rockdamp.laboratory.calibration import PARAMETERS, calibrate, study, true_values
from rockdamp.motions.record import Record, read_record

STEP = 0.01  # twice the config's, for speed: the solver's error stays below the bounds used here

# What the estimates may be off by. The model joins samples of the motion by straight lines, which takes up to 2.4e-4
# off the pulse, and b1 with it; the rest is noise, mostly the accelerometer's.
BOUNDS = np.array([1e-3, 4e-3, 4e-3])
CLEAN_BOUNDS = np.array([2e-4, 5e-4, 5e-4])


@pytest.fixture(scope="module")
def record():
    return read_record(ROOT / "data/sin-03-00-synthetic.csv")


@pytest.fixture(scope="module")
def result(record):
    return study(configured(), record)


@pytest.fixture
def few_draws(monkeypatch):
    """For tests of the estimates alone: their standard errors then mean little."""
    monkeypatch.setattr(least_squares, "DRAWS", 4)


def test_the_shipped_record_gives_back_what_made_it(result):
    error = np.abs(result["estimate"] - result["true_value"]).values
    assert np.all(error < 3 * result["standard_error"].values)
    assert np.all(error < BOUNDS)
    # The nominal values of Fig. 8 are told apart from those, where they differ by more than the error.
    assert abs(result["estimate"].sel(parameter="restitution") - 0.835) > 3 * result["standard_error"].sel(
        parameter="restitution"
    )


def test_the_fitted_history_leaves_no_more_than_the_sensors_noise(result, record):
    noise = float(record.header["generator_sensor_noise_m"])
    spread = 5 / np.sqrt(2 * record.elapsed.size)
    assert float(result["residual_deviation"]) == pytest.approx(noise, rel=spread)
    left = (result["measured"] - result["control_displacement"]).values
    assert np.std(left) == pytest.approx(float(result["residual_deviation"]), rel=0.01)
    assert abs(np.mean(left)) < 1e-9


def test_a_clean_record_of_another_wall_gives_back_what_made_it(few_draws):
    a1, b1, e = truth = (0.02, 0.86, 0.91)
    record = synthetic_record(noise=0, yield_displacement_ratio=a1, strength_ratio=b1, restitution=e, pulse_peak=14.6)
    assert np.ptp(record.displacement) > 0.2 * float(WALL.instability_displacement)  # it rocks
    found = calibrate(record, WALL, step=STEP)
    np.testing.assert_array_equal(found["true_value"].values, truth)
    assert np.all(np.abs(found["estimate"].values - truth) < CLEAN_BOUNDS)


def test_quieter_instruments_give_smaller_errors_in_proportion(result):
    half = calibrate(synthetic_record(noise=0.5), WALL)
    # The bandwidth, the rounding and the point of the fit change a little with the noise: a third either way.
    np.testing.assert_allclose((result["standard_error"] / half["standard_error"]).values, 2, rtol=1 / 3)


def test_the_sensors_offset_and_drift_are_profiled_out(record, result, few_draws):
    moved = record.displacement + 2e-3 + 3e-4 * record.elapsed
    found = calibrate(replace(record, displacement=moved), WALL)
    assert float(found["sensor_drift"] - result["sensor_drift"]) == pytest.approx(3e-4, rel=1e-3)
    assert float(found["sensor_offset"] - result["sensor_offset"]) == pytest.approx(2e-3, rel=1e-3)
    # The two problems are the same but for rounding: the minimiser's stopping is all that may differ.
    assert np.all(np.abs(found["estimate"] - result["estimate"]) < 0.02 * result["standard_error"])


def test_a_measured_record_has_no_true_values(record):
    measured = replace(record, header={**record.header, "synthetic": "no"})
    assert np.isnan(true_values(measured.header, PARAMETERS)).all()
    with pytest.raises(InputError, match="generator_.* must be numbers"):
        true_values({**record.header, "generator_restitution": "high"}, PARAMETERS)


# What was found when the records were made: the search and the errors must go on finding it.
FOUND = {
    "cr-half": ([0.0303687, 0.797495, 0.839919], [9.3388e-05, 0.00070687, 0.00021254]),
    "cr-nine-tenths": ([0.0305314, 0.798374, 0.840144], [1.5865e-4, 9.9969e-4, 1.5759e-4]),
    "ecd-quarter": ([0.0307973, 0.813470, 0.841022], [8.2531e-5, 6.3552e-4, 6.2431e-4]),
}


@pytest.mark.parametrize("name", FOUND)
def test_records_on_three_levels_give_what_they_gave(name):
    estimate, standard_error = map(np.array, FOUND[name])
    found = calibrate(read_record(ROOT / f"tests/data/{name}.csv"), WALL)
    np.testing.assert_allclose(found["standard_error"], standard_error, rtol=0.02)
    assert np.all(np.abs(found["estimate"] - estimate) < 0.02 * standard_error)


# --- the covariance, where theory knows it


@pytest.mark.parametrize("rho", [0.0, 0.8])
def test_the_covariance_matches_theory_for_residuals_that_follow_each_other(rho):
    samples, random = 3000, np.random.RandomState(4)
    t = np.arange(samples)
    derivative = np.stack([np.sin(t / 40), np.cos(t / 55), np.sin(t / 90)], axis=1)
    lags = np.abs(t[:, None] - t)
    bread = np.linalg.inv(derivative.T @ derivative)
    exact = bread @ derivative.T @ rho**lags @ derivative @ bread  # residuals of unit variance
    found = []
    for _ in range(40):
        steps = random.standard_normal(samples)
        residual = np.empty(samples)
        residual[0] = steps[0]
        for i in range(1, samples):
            residual[i] = rho * residual[i - 1] + np.sqrt(1 - rho**2) * steps[i]
        found.append(np.diag(least_squares.covariance_by_sensor(derivative, residual)[0]))
    # Bartlett's weights cut the sum of correlations short: Andrews' bandwidth trades that for variance. A fifth.
    np.testing.assert_allclose(np.mean(found, axis=0), np.diag(exact), rtol=0.2)
    white = np.diag(bread)
    assert rho == 0 or np.all(np.diag(exact) > 4 * white)  # the correlation matters in this case


def test_no_residuals_whatever_give_a_negative_variance():
    """Bartlett's weights make the sum of correlations a spectrum, which is positive; equal weights would not."""
    random, t = np.random.RandomState(7), np.arange(120)
    for period in (2.1, 3.0, 7.0, 20.0, 55.0):
        derivative = random.standard_normal((t.size, 3)).cumsum(axis=0)
        residual = np.sin(2 * np.pi * t / period) + 0.1 * random.standard_normal(t.size)
        covariance, bandwidth = least_squares.covariance_by_sensor(derivative, residual)
        scale = np.sqrt(np.diag(np.linalg.inv(derivative.T @ derivative)))
        assert bandwidth >= 1
        assert np.linalg.eigvalsh(covariance / np.outer(scale, scale)).min() > 0


# --- records that do not serve


def test_a_wall_that_does_not_rock_is_refused():
    record = synthetic_record(noise=0, pulse_peak=2.0)
    with pytest.raises(InputError, match="on the first branch, .* it must go beyond to determine a1 and b1"):
        calibrate(record, WALL, step=STEP)


def test_a_wall_of_arrays_is_refused(record):
    with pytest.raises(InputError, match="the number of dimensions of wall is 1; it must be 0: one wall"):
        calibrate(record, replace(WALL, thickness=np.array([WALL.thickness])))


def test_derivatives_that_tell_no_parameters_apart_are_refused():
    one = np.sin(np.arange(100.0))
    with pytest.raises(InputError, match="does not determine a1, b1 and e"):
        least_squares.covariance_by_sensor(np.stack([one, 2 * one, one**2], axis=1), one)
    with pytest.raises(InputError, match="does not determine a1, b1 and e"):
        least_squares.covariance_by_sensor(np.stack([one, 0 * one, one**2], axis=1), one)


def test_a_best_fit_at_a_bound_is_an_error_that_says_so():
    whole = synthetic_record(noise=0, restitution=1.0, pulse_peak=12.5)
    # Of a wall that loses nothing, the steps' error in the frequency adds up: to 2 s it is small.
    record = Record(*(column[:513] for column in (whole.elapsed, whole.ground_acceleration, whole.displacement)))
    with pytest.raises(InputError, match=r"the best fit has restitution \(e\) 1; it must lie inside 0.5 to 1"):
        calibrate(record, WALL, step=STEP)
