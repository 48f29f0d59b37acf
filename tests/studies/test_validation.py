"""The damping models against a record: damping ratios, half cycles and misfits."""

from dataclasses import replace

import numpy as np
import pytest
from configs import configured
from experimental_style import PULSE_CENTRE, SAMPLING, WALL, synthetic_record
from made_datasets import make_dataset
from repository import ROOT

from rockdamp.constants import VISCOUS_MODELS
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.errors import InputError
from rockdamp.histories.half_cycles import half_cycles
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.motions.record import Record
from rockdamp.motions.record_file import read_record
from rockdamp.studies.validation import compare, damping_ratios, validate

U_INS = float(WALL.instability_displacement)
METRICS = ["rms_misfit", "decay_peak_misfit", "decay_peak_ratio", "log_decrement", "period_drift"]


def calibrated(a1=0.031, b1=0.799, e=0.84):
    """Return a calibration; by default the values that made the shipped record."""
    names = ["yield_displacement_ratio", "strength_ratio", "restitution"]
    return make_dataset("calibration", {"parameter": names}, estimate=[a1, b1, e])


@pytest.fixture(scope="module")
def equivalence():
    """Polynomials through the closed form: near the matched ones, and made in no time."""
    e = np.arange(0.70, 0.985, 0.01)
    yield_displacement_ratios = [0.02, 0.04, 0.06]
    coefficients = []
    for model in VISCOUS_MODELS:
        for a1 in yield_displacement_ratios:
            ratio = damping_ratio_energy(TrilinearCurve(a1, 0.85), model, e, 0.5)
            coefficients.append(np.polynomial.polynomial.polyfit(e, ratio, 2))
    dims = {
        "damping_model": list(VISCOUS_MODELS),
        "yield_displacement_ratio": yield_displacement_ratios,
        "degree": 3,
    }
    values = np.reshape(coefficients, (-1, 3, 3))
    return make_dataset("equivalence", {**dims, "restitution": e}, coefficient=(list(dims), values))


@pytest.fixture(scope="module")
def record():
    return read_record(ROOT / "data/sin-03-00-synthetic.csv")


@pytest.fixture(scope="module")
def run(equivalence):
    def run_validation(record, **estimate):
        return validate(configured(), record, equivalence, calibrated(**estimate))

    return run_validation


@pytest.fixture(scope="module")
def validation(record, run):
    return run(record)


# --- parameters -----------------------------------------------------------------------------------


@pytest.mark.parametrize("model", VISCOUS_MODELS)
def test_damping_ratio_is_the_mean_of_the_polynomials(equivalence, model):
    """The paper averages two fits."""
    ratios = damping_ratios(equivalence, 0.835, [0.02, 0.04])
    fits = equivalence["coefficient"].sel(
        damping_model=model, yield_displacement_ratio=[0.02, 0.04]
    )
    xi = (fits * 0.835 ** fits["degree"]).sum("degree")
    assert ratios[model] == pytest.approx(float(xi.mean()), rel=1e-12)


@pytest.mark.parametrize(
    ("name", "value"),
    [("yield_displacement_ratio", 0.031), ("strength_ratio", 0.799), ("restitution", 0.84)],
)
def test_parameters_are_those_of_the_calibration(validation, name, value):
    assert float(validation[name]) == value


def test_config_has_another_a1_than_the_calibration():
    assert float(configured().validation.curve.yield_displacement_ratio) != 0.031


# --- metrics --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def clean(run):
    """CR on a record that CR made, without noise.

    The record was made with the smooth motion; the model's is a spline through its samples, rounded
    to 1 mm s-2.
    """
    return run(synthetic_record(noise=0)).sel(damping_model="CR")


def test_model_of_a_record_has_its_peak(clean):
    assert float(clean["peak_ratio_to_measured"]) == pytest.approx(1, abs=2e-3)


@pytest.mark.parametrize("name", ["decay_peak_misfit", "rms_misfit"])
def test_model_of_a_record_fits_it(clean, name):
    assert float(clean[name]) < 5e-3 * float(clean["measured_peak_displacement"])


def test_model_of_a_record_has_its_decay(clean):
    expected = float(clean["measured_log_decrement"])
    assert float(clean["period_drift"]) == pytest.approx(0, abs=5e-3)
    assert float(clean["log_decrement"]) == pytest.approx(expected, rel=5e-3)


def test_shipped_record_defines_every_metric(validation):
    assert validation[METRICS].to_array().notnull().all()


def test_shipped_record_orders_the_peaks(validation):
    peaks = validation["peak_ratio_to_measured"].to_series()
    assert peaks["CR"] == pytest.approx(0.99, abs=0.02)
    assert peaks["SDR"] < peaks["CDR"] < peaks["CDC"] < peaks["CR"]


def test_shipped_record_orders_the_decays(validation):
    """SDR damps small amplitudes most, CDC least."""
    ratios = validation["decay_peak_ratio"].to_series()
    assert ratios["SDR"] < ratios["CDR"] < ratios["CR"] < ratios["CDC"]
    assert validation["decay_peak_misfit"].to_series().idxmin() == "CR"


def test_misfit_is_that_of_the_stored_histories(validation):
    """The motion passes 2 % of its peak at 1.07 s, where the rest ends."""
    difference = validation["control_displacement"] - validation["measured"]
    moving = difference.sel(elapsed=slice(1.07, None))
    expected = np.sqrt((moving**2).mean("elapsed"))
    np.testing.assert_allclose(validation["rms_misfit"], expected, rtol=0.02)


def test_peak_is_that_of_the_stored_histories(validation):
    largest = abs(validation["control_displacement"]).max("elapsed")
    np.testing.assert_allclose(validation["peak_displacement"], largest, rtol=5e-3)


@pytest.fixture(scope="module")
def measured_peaks(validation):
    """Peaks of the record after its largest, beyond ten times the noise."""
    elapsed = validation["elapsed"].values
    peaks = np.abs(half_cycles(elapsed, validation["measured"].values, 1.54e-3).peak)
    return peaks[np.argmax(peaks) + 1 :]


def test_decay_is_every_half_cycle_after_the_peak(validation, measured_peaks):
    assert measured_peaks.size == 7
    assert (validation["matched_half_cycles"] == 7).all()


def test_measured_decrement_is_that_of_the_decay(validation, measured_peaks):
    expected = np.log(measured_peaks[0] / measured_peaks[-1]) / 6
    assert float(validation["measured_log_decrement"]) == pytest.approx(expected, rel=1e-12)


def test_peaks_of_the_decay_are_compared_in_order(validation, measured_peaks):
    cr = validation.sel(damping_model="CR")
    history = cr["control_displacement"].values
    peaks = np.abs(half_cycles(validation["elapsed"].values, history, 1e-3 * U_INS).peak)
    peaks = peaks[np.argmax(peaks) + 1 :][:7]
    misfit = np.sqrt(np.mean((peaks - measured_peaks) ** 2))
    assert float(cr["decay_peak_ratio"]) == pytest.approx(
        np.mean(peaks / measured_peaks), rel=1e-12
    )
    assert float(cr["decay_peak_misfit"]) == pytest.approx(misfit, rel=1e-12)


def test_zero_of_the_sensor_does_not_matter(record, run, validation):
    moved = run(replace(record, displacement=record.displacement + 0.01))
    change = float(moved["sensor_zero"] - validation["sensor_zero"])
    assert change == pytest.approx(0.01, rel=1e-9)
    np.testing.assert_allclose(moved["measured"], validation["measured"], atol=1e-15)
    np.testing.assert_allclose(moved["rms_misfit"], validation["rms_misfit"], rtol=1e-9)


def damped_sine(elapsed, stretch=1.0):
    """Return a decay that keeps its peaks when it is stretched in time."""
    return 0.02 * np.sin(4 * np.pi * elapsed / stretch) * 0.8 ** (2 * elapsed / stretch)


@pytest.mark.parametrize("stretch", [0.98, 1.0, 1.03])
def test_slower_decay_has_a_positive_drift(stretch):
    elapsed = np.arange(0.0, 3.0, 0.001)
    response = make_dataset(
        "response",
        {"elapsed": elapsed},
        control_displacement=damped_sine(elapsed, stretch),
        instability_displacement=U_INS,
        collapsed=0,
    )
    measured = damped_sine(elapsed)
    decay = half_cycles(elapsed, measured, 0.001)[slice(1, 9)]
    metrics = compare(response, measured, decay, 0)
    assert float(metrics["period_drift"]) == pytest.approx(stretch - 1, abs=2e-4)
    assert float(metrics["decay_peak_ratio"]) == pytest.approx(1.0, abs=2e-3)
    assert float(metrics["log_decrement"]) == pytest.approx(-np.log(0.8) / 2, rel=1e-2)


# --- collapse and refusals ------------------------------------------------------------------------


@pytest.fixture(scope="module")
def collapsed(record, run):
    return run(record, b1=0.70).sel(damping_model="CR")


def test_collapse_is_stated(collapsed):
    assert int(collapsed["collapsed"]) == 1
    assert float(collapsed["peak_displacement"]) >= U_INS


def test_collapse_has_no_metrics(collapsed):
    assert int(collapsed["matched_half_cycles"]) == 0
    assert collapsed[METRICS].to_array().isnull().all()


def test_history_ends_at_the_collapse(collapsed):
    displacement = collapsed["control_displacement"].values
    assert np.isnan(displacement[-1])
    assert not np.isnan(displacement[0])


@pytest.mark.parametrize(
    ("estimate", "name"),
    [
        ({"e": 0.69}, "restitution"),
        ({"a1": 0.015}, "yield_displacement_ratio"),
        ({"a1": 0.07}, "yield_displacement"),
    ],
)
def test_estimate_beyond_the_polynomials_is_refused(record, run, estimate, name):
    with pytest.raises(InputError, match=f"{name}.* within the range of the fits"):
        run(record, **estimate)


@pytest.mark.parametrize(
    ("part", "scale", "name"),
    [
        pytest.param(slice(None), None, "displacement_m", id="no displacement"),
        pytest.param(slice(300, None), 1, "samples at rest", id="no rest"),
        pytest.param(slice(int(PULSE_CENTRE * SAMPLING)), 1, "0 half cycles", id="no decay"),
        pytest.param(slice(None), 0.001, "0 half cycles", id="metres for millimetres"),
    ],
)
def test_unusable_record_is_refused(record, run, part, scale, name):
    displacement = None if scale is None else scale * record.displacement[part]
    with pytest.raises(InputError, match=name):
        run(Record(record.elapsed[part], record.ground_acceleration[part], displacement))
