"""Calibration on records: the truth of a simulated record is found, within its standard errors."""

from dataclasses import replace

import numpy as np
import pytest
from coarse_scan import coarse_scan
from configs import configured
from experimental_style import WALL, synthetic_record
from repository import ROOT
from scipy.signal import lfilter

import rockdamp as rd
from rockdamp.errors import InputError
from rockdamp.histories.loads import sample_load
from rockdamp.histories.record_rest import rest_samples
from rockdamp.laboratory import uncertainty
from rockdamp.laboratory.calibration import calibrate, compare_dampers
from rockdamp.laboratory.record_fit import HIGHEST_POINT, LOWEST_POINT, RecordFit
from rockdamp.laboratory.stages import calibration
from rockdamp.laboratory.uncertainty import covariance_by_sensor
from rockdamp.motions.record import Record
from rockdamp.motions.record_file import read_record
from rockdamp.solvers.exact import exact_history

STEP = 0.01  # twice the default, for speed: the solver's error stays below the bounds used here
HALF = read_record(ROOT / "tests/data/cr-half.csv")
NINE_TENTHS = read_record(ROOT / "tests/data/cr-nine-tenths.csv")
ECD = read_record(ROOT / "tests/data/ecd-quarter.csv")


def cut(record, samples):
    """Return some samples of a record, for speed."""
    columns = (record.elapsed, record.ground_acceleration, record.displacement)
    return Record(*(column[samples] for column in columns))


SHORT = cut(HALF, slice(0, 410, 2))  # every other one of the first 1.6 s


@pytest.fixture(scope="module")
def record():
    return read_record(ROOT / "data/sin-03-00-synthetic.csv")


@pytest.fixture(scope="module")
def fitted(record):
    return calibration(configured(), record)


@pytest.fixture
def few_draws(monkeypatch):
    """Few draws of the motion's noise, for tests of estimates: standard errors then mean little."""
    monkeypatch.setattr(uncertainty, "MOTION_DRAWS", 16)


# --- estimates ------------------------------------------------------------------------------------


def test_shipped_record_gives_its_truth(fitted):
    """The rest is noise, mostly the accelerometer's."""
    error = np.abs(fitted["estimate"] - fitted["true_value"]).values
    assert np.all(error < 3 * fitted["standard_error"].values)
    assert np.all(error < [1e-3, 4e-3, 4e-3])


def test_residual_is_the_noise_of_the_sensor(fitted, record):
    noise = float(record.header["generator_sensor_noise_m"])
    tolerance = 5 / np.sqrt(2 * record.elapsed.size)
    assert float(fitted["residual_rms"]) == pytest.approx(noise, rel=tolerance)


def test_residual_is_that_of_the_stored_histories(fitted):
    residual = (fitted["measured"] - fitted["control_displacement"]).values
    assert np.std(residual) == pytest.approx(float(fitted["residual_rms"]), rel=1e-3)
    assert abs(residual.mean()) < 1e-9


@pytest.fixture(scope="module")
def clean_record():
    """A record without noise, of another wall than the shipped one."""
    return synthetic_record(
        noise=0,
        yield_displacement_ratio=0.02,
        strength_ratio=0.86,
        restitution=0.91,
        pulse_peak=14.6,
    )


def test_clean_record_gives_its_truth(clean_record, few_draws):
    fit = calibrate(clean_record, WALL, step=STEP)
    np.testing.assert_array_equal(fit["true_value"], [0.02, 0.86, 0.91])
    assert np.all(np.abs(fit["estimate"] - fit["true_value"]) < [2e-4, 5e-4, 5e-4])


@coarse_scan()
def test_measured_record_has_no_true_value(few_draws):
    measured = replace(SHORT, header={**HALF.header, "synthetic": "no"})
    assert np.isnan(calibrate(measured, WALL, step=0.03)["true_value"]).all()


@pytest.mark.parametrize("model", ["CDC", "BAND"])
def test_viscous_damper_has_the_e_of_its_ratio(model, few_draws):
    a1, b1, e = 0.031, 0.80, 0.85
    record = synthetic_record(noise=0.1)
    curve = rd.TrilinearCurve(a1, b1)
    xi = float(rd.damping_ratio_energy(curve, model, e, 0.3))
    response = rd.respond(WALL, curve, rd.Damping(model, xi), record, step=STEP)
    shaken = replace(record, displacement=response.control_displacement.values)
    fit = calibrate(shaken, WALL, damping_model=model, step=STEP)
    np.testing.assert_allclose(fit["estimate"], [a1, b1, e], rtol=2e-3)
    assert float(fit["damping_ratio"]) == pytest.approx(xi, rel=0.02)


def test_offset_and_drift_change_nothing(record, fitted, few_draws):
    drifting = record.displacement + 2e-3 + 3e-4 * record.elapsed
    fit = calibrate(replace(record, displacement=drifting), WALL)
    assert np.all(np.abs(fit["estimate"] - fitted["estimate"]) < 0.02 * fitted["standard_error"])


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
    fit = calibrate(record, WALL)
    assert np.all(np.abs(fit["estimate"] - estimate) < 0.02 * np.array(standard_error))
    np.testing.assert_allclose(fit["standard_error"], standard_error, rtol=0.06)


# --- several runs, several dampers ----------------------------------------------------------------

RUNS = [cut(synthetic_record(seed), slice(768)) for seed in (1, 2)]  # 3 s


@pytest.fixture(scope="module")
def run_fits():
    with coarse_scan():
        return [calibrate(run, WALL, step=STEP) for run in RUNS]


@pytest.fixture(scope="module")
def joint_fit():
    with coarse_scan():
        return calibrate(RUNS, WALL, step=STEP)


def test_runs_are_weighted_by_their_covariances(run_fits, joint_fit):
    precisions = [np.linalg.inv(fit["covariance"].values) for fit in run_fits]
    estimates = [fit["estimate"].values for fit in run_fits]
    weighted = precisions[0] @ estimates[0] + precisions[1] @ estimates[1]
    expected = np.linalg.solve(precisions[0] + precisions[1], weighted)
    np.testing.assert_allclose(joint_fit["estimate"], expected, rtol=1e-9)
    np.testing.assert_allclose(joint_fit["run_estimate"], estimates)


def test_two_similar_runs_have_smaller_errors(run_fits, joint_fit):
    expected = run_fits[0]["standard_error"] / np.sqrt(2)
    np.testing.assert_allclose(joint_fit["standard_error"], expected, rtol=0.2)


def test_samples_name_their_run(joint_fit):
    expected = [1] * RUNS[0].elapsed.size + [2] * RUNS[1].elapsed.size
    assert joint_fit["sample_run"].values.tolist() == expected


@pytest.fixture(scope="module")
def compared():
    with coarse_scan():
        return compare_dampers(ECD, WALL, step=STEP)


def test_damper_of_a_record_has_the_largest_weight(compared):
    weight = compared["weight"].to_series()
    assert weight.idxmax() == "ECD"
    assert weight.sum() == pytest.approx(1)


def test_damper_of_a_record_leaves_the_noise(compared):
    residual = compared["residual_over_noise"].sel(damping_model="ECD")
    assert float(residual) == pytest.approx(1, abs=0.1)


def test_weights_follow_the_residuals(compared):
    weight = compared["weight"].to_series()
    squares = compared["residual_rms"].to_series() ** 2 * ECD.elapsed.size
    variance = RecordFit(ECD, WALL).resting_deviation ** 2
    expected = np.exp(-(squares["CR"] - squares["ECD"]) / (2 * variance))
    assert weight["CR"] / weight["ECD"] == pytest.approx(expected, rel=1e-6)


# --- standard errors ------------------------------------------------------------------------------


def test_derivatives_are_those_of_the_event_driven_solver():
    """Steps of a1/a2 are a fifth of steps of a1: at cond 120 longer ones halve the error of a1."""
    fit = RecordFit(ECD, WALL)
    point = np.array([0.16510657, 0.81347024, 0.84102183])
    tau = WALL.frequency_parameter * ECD.step * np.arange(ECD.elapsed.size)
    load = sample_load(fit.load)

    def exact(point):
        a1, b1, e = fit.parameters(point)
        history = exact_history(rd.TrilinearCurve(a1, b1), rd.Damping("CR", e), tau, **load)
        return float(WALL.instability_displacement) * history.displacement

    columns = []
    for step in np.diag(1e-5 * (HIGHEST_POINT - LOWEST_POINT)):
        columns.append((exact(point + step) - exact(point - step)) / (2 * step.sum()))
    expected = fit.subtract_trend(np.array(columns)).T
    residual = fit.residual(point[None])[0]
    errors = [
        np.sqrt(np.diag(covariance_by_sensor(derivative, residual)))
        for derivative in (fit.derivative(point), expected)
    ]
    np.testing.assert_allclose(*errors, rtol=0.12)


def test_standard_errors_go_with_the_noise(fitted):
    with coarse_scan():
        half_noise = calibrate(synthetic_record(noise=0.5), WALL)
    ratio = (fitted["standard_error"] / half_noise["standard_error"]).values
    # The bandwidth, the rounding and the point of the fit change with the noise: a third either
    # way.
    np.testing.assert_allclose(ratio, 2, rtol=1 / 3)


@pytest.mark.parametrize("rho", [0.0, 0.8])
def test_covariance_of_correlated_residuals(rho):
    samples = 3000
    t = np.arange(samples)
    derivative = np.stack([np.sin(t / 40), np.cos(t / 55), np.sin(t / 90)], axis=1)
    bread = np.linalg.inv(derivative.T @ derivative)
    correlation = rho ** np.abs(t[:, None] - t)  # residuals of unit variance
    exact = np.diag(bread @ derivative.T @ correlation @ derivative @ bread)
    noise = np.sqrt(1 - rho**2) * np.random.RandomState(4).standard_normal((40, samples))
    noise[:, 0] /= np.sqrt(1 - rho**2)
    residuals = lfilter([1], [1, -rho], noise)
    variances = [np.diag(covariance_by_sensor(derivative, residual)) for residual in residuals]
    # Bartlett's weights cut the sum of correlations short: Andrews' bandwidth trades that for
    # variance. A fifth.
    np.testing.assert_allclose(np.mean(variances, axis=0), exact, rtol=0.2)
    assert rho == 0 or np.all(exact > 4 * np.diag(bread))  # the correlation matters


@pytest.mark.parametrize("period", [2.1, 3.0, 7.0, 20.0, 55.0])
def test_variances_are_positive(period):
    """Bartlett's weights make the sum of correlations positive; equal weights would not."""
    random = np.random.RandomState(7)
    t = np.arange(120)
    derivative = random.standard_normal((t.size, 3)).cumsum(axis=0)
    residual = np.sin(2 * np.pi * t / period) + 0.1 * random.standard_normal(t.size)
    scale = np.sqrt(np.diag(np.linalg.inv(derivative.T @ derivative)))
    covariance = covariance_by_sensor(derivative, residual) / np.outer(scale, scale)
    assert np.linalg.eigvalsh(covariance).min() > 0


def test_drift_and_first_motion_are_no_noise():
    is_moving = np.arange(SHORT.elapsed.size) >= 0.8 * rest_samples(SHORT)
    displacement = SHORT.displacement + 0.01 * SHORT.elapsed + np.where(is_moving, 2e-3, 0.0)
    drifting = RecordFit(replace(SHORT, displacement=displacement), WALL).resting_deviation
    still = RecordFit(SHORT, WALL).resting_deviation
    assert drifting == pytest.approx(still, rel=1e-6)
    assert still == pytest.approx(1.5e-4, rel=0.3)  # the sensor's noise


@coarse_scan()
def test_uncertain_size_adds_its_change_of_estimates(few_draws):
    """Half of the difference by a thicker and a thinner wall."""
    exact = calibrate(SHORT, WALL, step=0.03)
    uncertain = calibrate(SHORT, WALL, step=0.03, uncertain={"thickness": 1e-3})
    estimates = []
    for side in (1e-3, -1e-3):
        wall = replace(WALL, thickness=WALL.thickness + side)
        estimates.append(calibrate(SHORT, wall, step=0.03)["estimate"].values)
    added = np.sqrt(np.diag(uncertain["covariance"] - exact["covariance"]))
    expected = np.abs(estimates[0] - estimates[1]) / 2
    np.testing.assert_allclose(added, expected, rtol=0.2)  # the misfit is rough


# --- records that are refused ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        pytest.param(
            {"ground_acceleration": -SHORT.ground_acceleration}, "% of the peak", id="wrong sign"
        ),
        pytest.param(
            {"ground_acceleration": SHORT.ground_acceleration / 9.80665}, "% of the peak", id="g"
        ),
        pytest.param(
            {"displacement": np.abs(SHORT.displacement - SHORT.displacement[0])},
            "% of the peak",
            id="one side",
        ),
        pytest.param(
            {"displacement": 1000 * SHORT.displacement},
            "largest measured displacement",
            id="millimetres",
        ),
        pytest.param(
            {"displacement": 0 * SHORT.displacement}, "largest measured displacement", id="zeros"
        ),
    ],
)
@coarse_scan()
def test_impossible_record_is_refused(changes, named):
    with pytest.raises(InputError, match=named):
        calibrate(replace(SHORT, **changes), WALL, step=0.03)


@coarse_scan()
def test_wall_on_its_first_branch_is_refused():
    with pytest.raises(InputError, match="first branch"):
        calibrate(cut(synthetic_record(noise=0, pulse_peak=2.0), slice(768)), WALL, step=STEP)


@pytest.mark.parametrize("factor", [2.0, 0.0], ids=["proportional", "zero"])
def test_dependent_derivatives_are_refused(factor):
    sine = np.sin(np.arange(100.0))
    derivative = np.stack([sine, factor * sine, sine**2], axis=1)
    with pytest.raises(InputError, match="does not determine"):
        covariance_by_sensor(derivative, sine)


def test_best_fit_at_a_bound_is_refused():
    whole = synthetic_record(noise=0, restitution=1.0, pulse_peak=12.5)
    # For a wall that loses nothing, the steps' error in the frequency adds up: to 2 s it is small.
    with pytest.raises(InputError, match="restitution"):
        calibrate(cut(whole, slice(513)), WALL, step=STEP)
