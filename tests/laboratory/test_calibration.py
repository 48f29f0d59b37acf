"""Calibration: the truth of a simulated record is found, within its standard errors."""

from dataclasses import replace

import numpy as np
import pytest
from configs import configured
from experimental_style import WALL, synthetic_record
from repository import ROOT
from scipy.signal import lfilter

import rockdamp as rd
from rockdamp.errors import InputError
from rockdamp.histories.loads import sample_load
from rockdamp.histories.measured_test import rest_samples
from rockdamp.laboratory import record_fit, uncertainty
from rockdamp.laboratory.calibration import calibrate, compare_dampers, study
from rockdamp.laboratory.record_fit import RecordFit
from rockdamp.laboratory.uncertainty import covariance_by_sensor
from rockdamp.motions.record import Record
from rockdamp.motions.record_file import read_record
from rockdamp.solvers.exact import exact_history

STEP = 0.01  # twice the default, for speed: the solver's error stays below the bounds used here
HALF, NINE_TENTHS, ECD = (
    read_record(ROOT / f"tests/data/{name}.csv")
    for name in ("cr-half", "cr-nine-tenths", "ecd-quarter")
)
# Every other sample of the first 1.6 s, for speed.
SHORT = Record(
    *(column[:410:2] for column in (HALF.elapsed, HALF.ground_acceleration, HALF.displacement))
)


@pytest.fixture(scope="module")
def record():
    return read_record(ROOT / "data/sin-03-00-synthetic.csv")


@pytest.fixture(scope="module")
def result(record):
    return study(configured(), record)


@pytest.fixture
def few_draws(monkeypatch):
    """For tests of the estimates: their standard errors then mean little."""
    monkeypatch.setattr(uncertainty, "DRAWS", 16)


@pytest.fixture
def coarse(monkeypatch):
    """A coarser scan, for speed."""
    monkeypatch.setattr(
        record_fit, "GRID", (record_fit.GRID[0], np.linspace(0.42, 0.94, 27), record_fit.GRID[2])
    )
    monkeypatch.setattr(record_fit, "HALVINGS", 4)


# --- estimates --------------------------------------------------------------------------------------------------------


def test_shipped_record_gives_its_truth(result, record):
    error = np.abs(result["estimate"] - result["true_value"]).values
    # What is left is noise, mostly the accelerometer's.
    assert np.all(error < 3 * result["standard_error"].values) and np.all(
        error < [1e-3, 4e-3, 4e-3]
    )
    noise = float(record.header["generator_sensor_noise_m"])
    assert float(result["residual_rms"]) == pytest.approx(
        noise, rel=5 / np.sqrt(2 * record.elapsed.size)
    )
    residual = (result["measured"] - result["control_displacement"]).values
    assert (
        np.std(residual) == pytest.approx(float(result["residual_rms"]), rel=1e-3)
        and abs(residual.mean()) < 1e-9
    )


def test_clean_record_of_another_wall(few_draws):
    a1, b1, e = truth = (0.02, 0.86, 0.91)
    record = synthetic_record(
        noise=0, yield_displacement_ratio=a1, strength_ratio=b1, restitution=e, pulse_peak=14.6
    )
    found = calibrate(record, WALL, step=STEP)
    np.testing.assert_array_equal(found["true_value"], truth)
    assert np.all(np.abs(found["estimate"].values - truth) < [2e-4, 5e-4, 5e-4])
    measured = replace(record, header={**record.header, "synthetic": "no"})
    assert np.isnan(calibrate(measured, WALL, step=STEP)["true_value"]).all()


@pytest.mark.parametrize("model", ["CDC", "BAND"])
def test_viscous_damper_has_the_e_of_its_ratio(model, few_draws):
    truth, record = (0.031, 0.80, 0.85), synthetic_record(noise=0.1)
    curve = rd.TrilinearCurve(*truth[:2])
    xi = float(rd.damping_ratio_energy(curve, model, truth[2], 0.3))
    shaken = rd.respond(WALL, curve, rd.Damping(model, xi), record, step=STEP)
    made = replace(record, displacement=shaken.control_displacement.values)
    found = calibrate(made, WALL, damping_model=model, step=STEP)
    np.testing.assert_allclose(found["estimate"], truth, rtol=2e-3)
    assert float(found["damping_ratio"]) == pytest.approx(xi, rel=0.02)


def test_offset_and_drift_change_nothing(record, result, few_draws):
    moved = calibrate(
        replace(record, displacement=record.displacement + 2e-3 + 3e-4 * record.elapsed), WALL
    )
    assert np.all(np.abs(moved["estimate"] - result["estimate"]) < 0.02 * result["standard_error"])


@pytest.mark.parametrize(
    ("record", "estimate", "standard_error"),
    [
        (NINE_TENTHS, [0.0305314, 0.798374, 0.840144], [2.06e-4, 1.45e-3, 1.97e-4]),
        (ECD, [0.0307973, 0.813470, 0.841022], [1.61e-4, 1.12e-3, 5.9e-4]),
    ],
    ids=["cr-nine-tenths", "ecd-quarter"],
)
def test_estimates_keep_their_values(record, estimate, standard_error):
    """The standard errors are those by derivatives of the event-driven solver."""
    found = calibrate(record, WALL)
    assert np.all(np.abs(found["estimate"] - estimate) < 0.02 * np.array(standard_error))
    np.testing.assert_allclose(found["standard_error"], standard_error, rtol=0.06)


def test_runs_are_weighted_by_their_covariances():
    """Two similar runs: their mean, and 1/sqrt(2) of the errors."""
    runs = [synthetic_record(seed) for seed in (1, 2)]
    one, other, both = (calibrate(record, WALL, step=STEP) for record in (*runs, runs))
    first, second = (np.linalg.inv(fit["covariance"].values) for fit in (one, other))
    expected = np.linalg.solve(
        first + second, first @ one["estimate"].values + second @ other["estimate"].values
    )
    np.testing.assert_allclose(both["estimate"], expected, rtol=1e-9)
    np.testing.assert_allclose(both["run_estimate"], [one["estimate"], other["estimate"]])
    np.testing.assert_allclose(both["standard_error"], one["standard_error"] / np.sqrt(2), rtol=0.2)
    assert (
        both["sample_run"].values.tolist()
        == [1] * runs[0].elapsed.size + [2] * runs[1].elapsed.size
    )


def test_dampers_are_weighted_by_their_residuals():
    compared = compare_dampers(ECD, WALL, step=STEP)
    weight = compared["weight"].to_series()
    assert weight.idxmax() == "ECD" and weight.sum() == pytest.approx(1)
    assert float(compared["residual_over_noise"].sel(damping_model="ECD")) == pytest.approx(
        1, abs=0.1
    )
    squares = compared["residual_rms"].to_series() ** 2 * ECD.elapsed.size
    expected = np.exp(
        -(squares["CR"] - squares["ECD"]) / (2 * RecordFit(ECD, WALL).resting_deviation ** 2)
    )
    assert weight["CR"] / weight["ECD"] == pytest.approx(expected, rel=1e-6)


# --- standard errors --------------------------------------------------------------------------------------------------


def test_derivatives_are_those_of_the_event_driven_solver():
    """Steps of a1/a2 are a fifth of steps of a1: at cond 120 a longer step halves the standard error of a1."""
    fit = RecordFit(ECD, WALL)
    point = np.array([0.16510657, 0.81347024, 0.84102183])
    at = WALL.frequency_parameter * ECD.step * np.arange(ECD.elapsed.size)

    def exact(point):
        a1, b1, e = fit.parameters(point)
        found = exact_history(
            rd.TrilinearCurve(a1, b1), rd.Damping("CR", e), at, **sample_load(fit.load)
        )
        return float(WALL.instability_displacement) * found.displacement

    steps = np.diag(1e-5 * (record_fit.HIGH - record_fit.LOW))
    expected = fit.subtract_trend(
        np.array([(exact(point + h) - exact(point - h)) / (2 * h.sum()) for h in steps])
    ).T
    residual = fit.residual(point[None])[0]
    errors = [
        np.sqrt(np.diag(covariance_by_sensor(d, residual)))
        for d in (fit.derivative(point), expected)
    ]
    np.testing.assert_allclose(*errors, rtol=0.12)


def test_standard_errors_go_with_the_noise(result):
    half = calibrate(synthetic_record(noise=0.5), WALL)
    # The bandwidth, the rounding and the point of the fit change a little with the noise: a third either way.
    np.testing.assert_allclose(
        (result["standard_error"] / half["standard_error"]).values, 2, rtol=1 / 3
    )


@pytest.mark.parametrize("rho", [0.0, 0.8])
def test_covariance_of_correlated_residuals(rho):
    samples, random = 3000, np.random.RandomState(4)
    t = np.arange(samples)
    derivative = np.stack([np.sin(t / 40), np.cos(t / 55), np.sin(t / 90)], axis=1)
    bread = np.linalg.inv(derivative.T @ derivative)
    exact = (
        bread @ derivative.T @ rho ** np.abs(t[:, None] - t) @ derivative @ bread
    )  # residuals of unit variance
    noise = np.sqrt(1 - rho**2) * random.standard_normal((40, samples))
    noise[:, 0] /= np.sqrt(1 - rho**2)
    residuals = lfilter([1], [1, -rho], noise)
    found = [np.diag(covariance_by_sensor(derivative, residual)) for residual in residuals]
    # Bartlett's weights cut the sum of correlations short: Andrews' bandwidth trades that for variance. A fifth.
    np.testing.assert_allclose(np.mean(found, axis=0), np.diag(exact), rtol=0.2)
    assert rho == 0 or np.all(
        np.diag(exact) > 4 * np.diag(bread)
    )  # the correlation matters in this case


def test_variances_are_positive():
    """Bartlett's weights make the sum of correlations a spectrum, which is positive; equal weights would not."""
    random, t = np.random.RandomState(7), np.arange(120)
    for period in (2.1, 3.0, 7.0, 20.0, 55.0):
        derivative = random.standard_normal((t.size, 3)).cumsum(axis=0)
        residual = np.sin(2 * np.pi * t / period) + 0.1 * random.standard_normal(t.size)
        scale = np.sqrt(np.diag(np.linalg.inv(derivative.T @ derivative)))
        assert (
            np.linalg.eigvalsh(
                covariance_by_sensor(derivative, residual) / np.outer(scale, scale)
            ).min()
            > 0
        )


def test_drift_and_first_motion_are_no_noise_of_the_sensor():
    moving = np.where(np.arange(SHORT.elapsed.size) < 0.8 * rest_samples(SHORT), 0.0, 2e-3)
    moved = replace(SHORT, displacement=SHORT.displacement + 0.01 * SHORT.elapsed + moving)
    still, moving = (RecordFit(record, WALL).resting_deviation for record in (SHORT, moved))
    assert moving == pytest.approx(still, rel=1e-6) and still == pytest.approx(
        1.5e-4, rel=0.3
    )  # the sensor's


def test_uncertain_size_adds_its_change_of_the_estimates(coarse, few_draws):
    """Half of the difference by a thicker and a thinner wall."""
    exact, uncertain = (
        calibrate(SHORT, WALL, step=0.03, uncertain=sizes) for sizes in (None, {"thickness": 1e-3})
    )
    sides = (replace(WALL, thickness=WALL.thickness + side) for side in (1e-3, -1e-3))
    thick, thin = (calibrate(SHORT, wall, step=0.03)["estimate"].values for wall in sides)
    added = np.sqrt(np.diag(uncertain["covariance"] - exact["covariance"]))
    np.testing.assert_allclose(added, np.abs(thick - thin) / 2, rtol=0.2)  # the misfit is rough


# --- records that are refused -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"ground_acceleration": -SHORT.ground_acceleration}, "% of the peak"),
        ({"ground_acceleration": SHORT.ground_acceleration / 9.80665}, "% of the peak"),
        ({"displacement": np.abs(SHORT.displacement - SHORT.displacement[0])}, "% of the peak"),
        ({"displacement": 1000 * SHORT.displacement}, "largest measured displacement"),
        ({"displacement": 0 * SHORT.displacement}, "largest measured displacement"),
    ],
)
def test_impossible_record_is_refused(changes, named, coarse):
    with pytest.raises(InputError, match=named):
        calibrate(replace(SHORT, **changes), WALL, step=0.03)


def test_wall_on_its_first_branch_is_refused():
    with pytest.raises(InputError, match="first branch"):
        calibrate(synthetic_record(noise=0, pulse_peak=2.0), WALL, step=STEP)


def test_dependent_derivatives_are_refused():
    one = np.sin(np.arange(100.0))
    for other in (2 * one, 0 * one):
        with pytest.raises(InputError, match="does not determine"):
            covariance_by_sensor(np.stack([one, other, one**2], axis=1), one)


def test_best_fit_at_a_bound_is_refused():
    whole = synthetic_record(noise=0, restitution=1.0, pulse_peak=12.5)
    # Of a wall that loses nothing, the steps' error in the frequency adds up: to 2 s it is small.
    record = Record(
        *(column[:513] for column in (whole.elapsed, whole.ground_acceleration, whole.displacement))
    )
    with pytest.raises(InputError, match="restitution"):
        calibrate(record, WALL, step=STEP)
