"""The damping models against a record: damping ratios, half cycles and misfits."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
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
    return lambda record, **estimate: validate(
        configured(), record, equivalence, calibrated(**estimate)
    )


@pytest.fixture(scope="module")
def result(record, run):
    return run(record)


def test_damping_ratios_are_the_mean_of_the_polynomials_as_in_the_paper(equivalence):
    found = damping_ratios(equivalence, 0.835, [0.02, 0.04])
    fits = equivalence["coefficient"].sel(yield_displacement_ratio=[0.02, 0.04])
    mean = (fits * 0.835 ** fits["degree"]).sum("degree").mean("yield_displacement_ratio")
    for model in VISCOUS_MODELS:
        assert found[model] == pytest.approx(float(mean.sel(damping_model=model)), rel=1e-12)


def test_curve_and_restitution_are_those_of_the_calibration(result):
    names = ("yield_displacement_ratio", "strength_ratio", "restitution")
    assert [float(result[name]) for name in names] == [0.031, 0.799, 0.84]
    assert float(configured().validation.curve.yield_displacement_ratio) != 0.031


def test_the_model_that_made_a_record_fits_it(run):
    """The record was made with the smooth motion; the model's is a spline through its samples, rounded to 1 mm s-2."""
    found = run(synthetic_record(noise=0)).sel(damping_model="CR")
    peak = float(found["measured_peak_displacement"])
    assert float(found["peak_ratio_to_measured"]) == pytest.approx(1, abs=2e-3)
    assert (
        float(found["decay_peak_misfit"]) < 5e-3 * peak and float(found["rms_misfit"]) < 5e-3 * peak
    )
    assert float(found["period_drift"]) == pytest.approx(0, abs=5e-3)
    assert float(found["log_decrement"]) == pytest.approx(
        float(found["measured_log_decrement"]), rel=5e-3
    )


def test_the_shipped_record_tells_the_models_apart_and_leaves_no_metric_undefined(result):
    assert result[METRICS].to_array().notnull().all()
    peaks, ratios = (
        result[name].to_series() for name in ("peak_ratio_to_measured", "decay_peak_ratio")
    )
    assert peaks["CR"] == pytest.approx(0.99, abs=0.02)
    assert peaks["SDR"] < peaks["CDR"] < peaks["CDC"] < peaks["CR"]
    assert (
        ratios["SDR"] < ratios["CDR"] < ratios["CR"] < ratios["CDC"]
    )  # SDR damps small amplitudes most, CDC least
    assert result["decay_peak_misfit"].to_series().idxmin() == "CR"


def test_misfits_are_those_of_the_stored_histories(result):
    # The motion passes 2 % of its peak at 1.07 s.
    difference = (result["control_displacement"] - result["measured"]).sel(
        elapsed=slice(1.07, None)
    )
    np.testing.assert_allclose(
        result["rms_misfit"], np.sqrt((difference**2).mean("elapsed")), rtol=0.02
    )  # from the rest
    largest = abs(result["control_displacement"]).max("elapsed")
    np.testing.assert_allclose(result["peak_displacement"], largest, rtol=5e-3)


def test_the_decay_is_every_half_cycle_after_the_largest_peak(result):
    """Of the record: its largest half cycle is the first beyond ten times the noise, and seven follow."""
    elapsed = result["elapsed"].values
    measured = np.abs(half_cycles(elapsed, result["measured"].values, 1.54e-3).peak)
    peaks = measured[np.argmax(measured) + 1 :]
    assert peaks.size == 7 and (result["matched_half_cycles"] == 7).all()
    assert float(result["measured_log_decrement"]) == pytest.approx(
        np.log(peaks[0] / peaks[-1]) / 6, rel=1e-12
    )
    one = result.sel(damping_model="CR")
    every = np.abs(half_cycles(elapsed, one["control_displacement"].values, 1e-3 * U_INS).peak)
    computed = every[np.argmax(every) + 1 :][:7]
    assert float(one["decay_peak_ratio"]) == pytest.approx(np.mean(computed / peaks), rel=1e-12)
    assert float(one["decay_peak_misfit"]) == pytest.approx(
        np.sqrt(np.mean((computed - peaks) ** 2)), rel=1e-12
    )


def test_the_sensors_zero_does_not_matter(record, run, result):
    again = run(replace(record, displacement=record.displacement + 0.01))
    assert float(again["sensor_zero"] - result["sensor_zero"]) == pytest.approx(0.01, rel=1e-9)
    np.testing.assert_allclose(again["measured"], result["measured"], atol=1e-15)
    np.testing.assert_allclose(again["rms_misfit"], result["rms_misfit"], rtol=1e-9)


@pytest.mark.parametrize("stretch", [0.98, 1.0, 1.03])
def test_a_decay_whose_half_cycles_last_longer_than_the_measured_has_a_drift_above_zero(stretch):
    """Two damped sines of the same peaks, one of which is slower by a known factor."""
    elapsed = np.arange(0.0, 3.0, 0.001)

    def decay(slower):
        return 0.02 * np.sin(4 * np.pi * elapsed / slower) * 0.8 ** (2 * elapsed / slower)

    scalars = {"instability_displacement": U_INS, "collapsed": 0}
    response = xr.Dataset(
        {"control_displacement": ("elapsed", decay(stretch)), **scalars},
        coords={"elapsed": elapsed},
    )
    measured = decay(1.0)
    found = compare(response, measured, half_cycles(elapsed, measured, 0.001)[slice(1, 9)], 0)
    assert float(found["period_drift"]) == pytest.approx(stretch - 1, abs=2e-4)
    assert float(found["decay_peak_ratio"]) == pytest.approx(1.0, abs=2e-3)
    assert float(found["log_decrement"]) == pytest.approx(-np.log(0.8) / 2, rel=1e-2)


def test_a_model_that_collapses_says_so_and_has_no_misfit(record, run):
    one = run(record, b1=0.70).sel(damping_model="CR")
    assert (int(one["collapsed"]), int(one["matched_half_cycles"])) == (1, 0)
    assert float(one["peak_displacement"]) >= U_INS
    assert one[METRICS].to_array().isnull().all()
    assert np.isnan(one["control_displacement"][-1]) and not np.isnan(
        one["control_displacement"][0]
    )


@pytest.mark.parametrize(
    "estimate, name",
    [
        ({"e": 0.69}, "restitution"),
        ({"a1": 0.015}, "yield_displacement_ratio"),
        ({"a1": 0.07}, "yield_displacement"),
    ],
)
def test_an_e_or_a1_outside_the_polynomials_is_refused(record, run, estimate, name):
    with pytest.raises(InputError, match=f"{name}.* within the range of the fits"):
        run(record, **estimate)


@pytest.mark.parametrize(
    "part, scale, name",
    [
        (slice(None), None, "displacement_m"),
        (slice(300, None), 1, "samples at rest"),
        (slice(int(PULSE_CENTRE * SAMPLING)), 1, "0 half cycles"),
        (slice(None), 0.001, "0 half cycles"),
    ],
)
def test_a_record_that_cannot_be_compared_is_refused(record, run, part, scale, name):
    displacement = None if scale is None else scale * record.displacement[part]
    with pytest.raises(InputError, match=name):
        run(Record(record.elapsed[part], record.ground_acceleration[part], displacement))
