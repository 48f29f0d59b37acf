"""The damping models against a record: damping ratios, half cycles and misfits."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from configs import configured
from experimental_style import PULSE_CENTRE, SAMPLING, WALL, synthetic_record
from repository import ROOT

from rockdamp.constants import MODELS, VISCOUS_MODELS
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.errors import InputError
from rockdamp.histories.half_cycles import half_cycles
from rockdamp.histories.loads import make_load, sample_load
from rockdamp.histories.respond import respond
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.record import Record, read_record
from rockdamp.solvers.exact import exact_history
from rockdamp.studies.validation import _misfits, damping_ratios, validate

U_INS, P = float(WALL.instability_displacement), float(WALL.frequency_parameter)
METRICS = ("rms_misfit", "decay_peak_misfit", "decay_peak_ratio", "log_decrement", "period_drift")


def calibrated(a1=0.031, b1=0.799, e=0.84):
    """What the calibration would give: by default the values that made the shipped record."""
    names = ["yield_displacement_ratio", "strength_ratio", "restitution"]
    return xr.Dataset({"estimate": ("parameter", [a1, b1, e])}, coords={"parameter": names})


@pytest.fixture(scope="module")
def config():
    return configured()


@pytest.fixture(scope="module")
def equivalence():
    """Polynomials through the closed form: near the matched ones, and made in no time."""
    e, a1 = np.arange(0.70, 0.985, 0.01), [0.02, 0.04, 0.06]
    ratios = [
        [damping_ratio_energy(TrilinearCurve(one, 0.85), model, e, 0.5) for one in a1] for model in VISCOUS_MODELS
    ]
    fits = np.polynomial.polynomial.polyfit(e, np.reshape(ratios, (-1, e.size)).T, 2)
    return xr.Dataset(
        {"coefficient": (("damping_model", "yield_displacement_ratio", "degree"), fits.T.reshape(-1, 3, 3))},
        coords={
            "damping_model": list(VISCOUS_MODELS),
            "yield_displacement_ratio": a1,
            "degree": [0, 1, 2],
            "restitution": e,
        },
    )


@pytest.fixture(scope="module")
def record():
    return read_record(ROOT / "data/sin-03-00-synthetic.csv")


@pytest.fixture(scope="module")
def result(config, record, equivalence):
    return validate(config, record, equivalence, calibrated())


# --- damping ratios


def test_damping_ratios_are_the_mean_of_the_polynomials_as_in_the_paper(equivalence):
    found = damping_ratios(equivalence, 0.835, [0.02, 0.04])
    for model in VISCOUS_MODELS:
        fits = equivalence["coefficient"].sel(damping_model=model)
        each = [
            np.polynomial.polynomial.polyval(0.835, fits.sel(yield_displacement_ratio=a1).values) for a1 in (0.02, 0.04)
        ]
        assert found[model] == pytest.approx(np.mean(each), rel=1e-12)


# --- responses


def test_the_response_to_a_record_is_that_of_the_event_driven_solver(record):
    curve = TrilinearCurve(0.03, 0.80)
    load = sample_load(make_load(WALL, record, substeps=64))
    exact = exact_history(curve, Damping("CR", 0.835), P * record.elapsed, **load)
    runs = [respond(WALL, curve, Damping("CR", 0.835), record, step=step) for step in (0.0025, 0.01)]
    error, coarser = (float(np.abs(run["displacement"] - exact.displacement).max()) for run in runs)
    # Second order, erratic in a single history: a quarter of the step takes off the better part of the error.
    assert error < 0.5 * coarser
    assert error < 1e-3 * np.abs(exact.displacement).max()


def test_straight_lines_between_samples_of_the_motion_would_lower_the_peak_by_a_third_of_a_percent():
    smooth = synthetic_record(noise=0)
    straight = Record(smooth.elapsed, smooth.ground_acceleration)  # without a response it is no spline
    curve = TrilinearCurve(0.031, 0.799)
    peaks = [float(respond(WALL, curve, Damping("CR", 0.84), one)["peak"]) for one in (smooth, straight)]
    assert 1 - peaks[1] / peaks[0] == pytest.approx(0.003, abs=5e-4)


# --- the comparison


def test_curve_and_restitution_are_those_of_the_calibration(config, result):
    assert float(result["yield_displacement_ratio"]) == 0.031
    assert float(result["strength_ratio"]) == 0.799
    assert float(result["restitution"]) == 0.84
    assert float(config.validation.curve.yield_displacement_ratio) != 0.031
    assert "record" not in result.dims


def test_the_model_that_made_a_record_fits_it(config, equivalence):
    record = synthetic_record(noise=0)
    result = validate(config, record, equivalence, calibrated()).sel(damping_model="CR")
    # The record was made with the smooth motion; the model's is a spline through its samples, rounded to 1 mm s-2.
    assert float(result["peak_ratio_to_measured"]) == pytest.approx(1, abs=2e-3)
    peak = float(result["measured_peak_displacement"])
    assert float(result["decay_peak_misfit"]) < 5e-3 * peak
    assert float(result["rms_misfit"]) < 5e-3 * peak
    assert float(result["period_drift"]) == pytest.approx(0, abs=5e-3)
    assert float(result["log_decrement"]) == pytest.approx(float(result["measured_log_decrement"]), rel=5e-3)


def test_the_shipped_record_tells_the_models_apart_and_leaves_no_metric_undefined(result):
    for name in METRICS:
        assert result[name].notnull().all(), name
    peaks, ratios = (result[name].to_series() for name in ("peak_ratio_to_measured", "decay_peak_ratio"))
    assert peaks["CR"] == pytest.approx(0.99, abs=0.02)
    assert peaks["SDR"] < peaks["CDR"] < peaks["CDC"] < peaks["CR"]
    assert ratios["SDR"] < ratios["CDR"] < ratios["CR"] < ratios["CDC"]  # SDR damps small amplitudes most, CDC least
    assert result["decay_peak_misfit"].to_series().idxmin() == "CR"


def test_misfits_are_those_of_the_stored_histories(result):
    for model in MODELS:
        one = result.sel(damping_model=model)
        moving = result["elapsed"].values >= 1.07  # the motion passes 2 % of its peak
        difference = (one["control_displacement"] - one["measured"]).values
        assert float(one["rms_misfit"]) == pytest.approx(np.sqrt(np.mean(difference[moving] ** 2)), rel=0.02)
        assert float(one["peak_displacement"]) == pytest.approx(
            float(np.abs(one["control_displacement"]).max()), rel=5e-3
        )


def test_the_decay_is_every_half_cycle_after_the_largest_peak(result):
    """Of the record: its largest half cycle is the first beyond ten times the noise, and seven follow."""
    measured, elapsed = result["measured"].values, result["elapsed"].values
    whole = half_cycles(elapsed, measured, 1.54e-3)
    largest = int(np.argmax(np.abs(whole.peak)))
    peaks = np.abs(whole.peak[largest + 1 :])
    assert peaks.size == 7 and np.all(result["matched_half_cycles"] == 7)
    assert float(result["measured_log_decrement"]) == pytest.approx(np.log(peaks[0] / peaks[-1]) / 6, rel=1e-12)
    one = result.sel(damping_model="CR")
    computed = half_cycles(elapsed, one["control_displacement"].values, 1e-3 * U_INS)
    start = int(np.argmax(np.abs(computed.peak))) + 1
    of_model = np.abs(computed.peak[start : start + 7])
    assert float(one["decay_peak_ratio"]) == pytest.approx(np.mean(of_model / peaks), rel=1e-12)
    assert float(one["decay_peak_misfit"]) == pytest.approx(np.sqrt(np.mean((of_model - peaks) ** 2)), rel=1e-12)


def test_the_sensors_zero_does_not_matter(config, record, equivalence, result):
    moved = replace(record, displacement=record.displacement + 0.01)
    again = validate(config, moved, equivalence, calibrated())
    assert float(again["sensor_zero"] - result["sensor_zero"]) == pytest.approx(0.01, rel=1e-9)
    np.testing.assert_allclose(again["measured"], result["measured"], atol=1e-15)
    np.testing.assert_allclose(again["rms_misfit"], result["rms_misfit"], rtol=1e-9)


@pytest.mark.parametrize("stretch", [0.98, 1.0, 1.03])
def test_a_decay_whose_half_cycles_last_longer_than_the_measured_has_a_drift_above_zero(stretch):
    """Two damped sines of the same peaks, one of which is slower by a known factor."""
    elapsed = np.arange(0.0, 3.0, 0.001)

    def decay(slower):
        cycles = elapsed / slower / 0.5
        return 0.02 * np.sin(2 * np.pi * cycles) * 0.8**cycles

    measured = decay(1.0)
    response = xr.Dataset(
        {
            "control_displacement": ("elapsed", decay(stretch)),
            "instability_displacement": U_INS,
            "collapsed": 0,
            "peak_displacement": 0.02,
        },
        coords={"elapsed": elapsed},
    )
    halves = half_cycles(elapsed, measured, 0.001)[slice(1, 9)]
    found = _misfits(response, measured, halves, 0)
    assert float(found["period_drift"]) == pytest.approx(stretch - 1, abs=2e-4)
    assert float(found["decay_peak_ratio"]) == pytest.approx(1.0, abs=2e-3)
    assert float(found["log_decrement"]) == pytest.approx(-np.log(0.8) / 2, rel=1e-2)


def test_a_model_that_collapses_says_so_and_has_no_misfit(config, record, equivalence):
    one = validate(config, record, equivalence, calibrated(b1=0.70)).sel(damping_model="CR")
    assert int(one["collapsed"]) == 1
    assert float(one["peak_displacement"]) >= U_INS
    assert int(one["matched_half_cycles"]) == 0
    for name in METRICS:
        assert np.isnan(one[name])
    assert np.isnan(one["control_displacement"][-1]) and not np.isnan(one["control_displacement"][0])


@pytest.mark.parametrize(
    "estimate, name",
    [({"e": 0.69}, "restitution"), ({"a1": 0.015}, "yield_displacement_ratio"), ({"a1": 0.07}, "yield_displacement")],
)
def test_an_e_or_a1_outside_the_polynomials_is_refused(config, record, equivalence, estimate, name):
    with pytest.raises(InputError, match=f"{name}.* within the range of the fits"):
        validate(config, record, equivalence, calibrated(**estimate))


def test_a_record_that_cannot_be_compared_says_why(config, record, equivalence):
    def of(changed):
        return validate(config, changed, equivalence, calibrated())

    def part(start, stop):
        return Record(
            record.elapsed[start:stop], record.ground_acceleration[start:stop], record.displacement[start:stop]
        )

    with pytest.raises(InputError, match="no column displacement_m"):
        of(replace(record, displacement=None))
    with pytest.raises(InputError, match="samples at rest before the motion is 0; it must be at least 10"):
        of(part(300, None))
    with pytest.raises(InputError, match="0 half cycles .* it must have at least 2"):
        of(part(None, int(PULSE_CENTRE * SAMPLING)))
    with pytest.raises(InputError, match="0 half cycles .* it must have at least 2"):
        of(replace(record, displacement=0.001 * record.displacement))
