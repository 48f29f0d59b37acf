"""The damping models against a record: phases, half cycles, damping ratios and misfits."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from configs import configured
from experimental_style import OVERSAMPLING, PULSE_CENTRE, SAMPLING, WALL, synthetic_record
from repository import ROOT

from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.errors import InputError
from rockdamp.histories.half_cycles import half_cycles
from rockdamp.histories.loads import Forcing
from rockdamp.histories.measured_test import computed_response
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.pulse_shapes import ricker
from rockdamp.motions.records import Record, read_record
from rockdamp.solvers.event_driven import history
from rockdamp.solvers.response import Histories
from rockdamp.studies.validation import _misfits, compared, damping_ratios, validate
from rockdamp.vocabulary import MODELS, VISCOUS_MODELS

U_INS, P = float(WALL.instability_displacement), float(WALL.frequency_parameter)
RICKER_PEAK = 14.0  # [m s-2]; near the strength of the wall, which peaks at 0.36 u_ins
NOMINAL = {"yield_displacement_ratio": 0.03, "strength_ratio": 0.80, "restitution": 0.835}


def validated(config, record, equivalence):
    """Of one record, without the dimension that holds several."""
    return validate(config, record, {}, equivalence).isel(record=0)


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
def nominal_record():
    """A record that the nominal CR model would have made, without noise."""
    return synthetic_record(noise=0, **NOMINAL)


def record_of(motion):
    """Record of the nominal CR model, without noise, under a motion at `OVERSAMPLING` times the record's sampling."""
    elapsed = np.arange(motion.size // OVERSAMPLING + 1) / SAMPLING
    solved = history(
        TrilinearCurve(NOMINAL["yield_displacement_ratio"], NOMINAL["strength_ratio"]),
        Damping.cr(NOMINAL["restitution"]),
        P * elapsed,
        load=float(WALL.load_factor) * motion,
        load_step=P / (SAMPLING * OVERSAMPLING),
    )
    assert solved.outcome == "completed"
    return Record(elapsed, motion[::OVERSAMPLING], U_INS * solved.displacement)


@pytest.fixture(scope="module")
def ricker_motion():
    """The 2 Hz Ricker pulse that the paper names: over 0.45 s after its peak."""
    fine = np.arange(int(4 * SAMPLING * OVERSAMPLING) + 1) / (SAMPLING * OVERSAMPLING)
    return fine, ricker(fine - PULSE_CENTRE, 2.0, RICKER_PEAK)


@pytest.fixture(scope="module")
def result(config, record, equivalence):
    return validated(config, record, equivalence)


@pytest.fixture(scope="module")
def free_result(config, ricker_motion, equivalence):
    """Of a record that holds a free decay."""
    return validated(config, record_of(ricker_motion[1]), equivalence)


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
    response = computed_response(record, WALL, curve, Damping.cr(0.835), 0.0025)
    exact = history(
        curve,
        Damping.cr(0.835),
        P * record.elapsed,
        **Forcing.from_record(WALL, record).event_driven(),
    )
    coarse = computed_response(record, WALL, curve, Damping.cr(0.835), 0.01)
    error, coarser = (np.abs(one.displacement - exact.displacement).max() for one in (response, coarse))
    # Second order, erratic in a single history: a quarter of the step takes off the better part of the error.
    assert error < 0.5 * coarser
    assert error < 1e-3 * np.abs(exact.displacement).max()


# --- the comparison


def test_the_model_that_made_a_record_fits_it(config, nominal_record, equivalence):
    result = validated(config, nominal_record, equivalence).sel(damping_model="CR")
    # The record was made with the smooth motion; between its samples the model takes a straight line, which lowers the
    # pulse by up to 2.4e-4 of its peak, and near its strength the wall responds ten times as strongly to that.
    assert float(result["peak_ratio_to_measured"]) == pytest.approx(1, abs=5e-3)
    assert float(result["decay_peak_misfit"]) < 5e-3 * float(result["measured_peak_displacement"])
    assert float(result["rms_misfit"]) < 5e-3 * float(result["measured_peak_displacement"])
    assert float(result["period_drift"]) == pytest.approx(0, abs=5e-3)


def test_decrements_and_misfits_of_peaks_do_not_depend_on_what_is_left_of_the_motion(
    config, equivalence, ricker_motion, free_result
):
    """The same once more with the motion cut off where the decay begins to be free, for the wall and for the models."""
    fine, motion = ricker_motion
    whole = free_result
    free = float(whole["free_phase_start"])
    assert free == pytest.approx(PULSE_CENTRE + 0.45, abs=0.06)
    assert int(whole["half_cycle_free"].sum()) >= 5
    cut = validated(config, record_of(np.where(fine < free, motion, 0.0)), equivalence)
    assert int(cut["half_cycle_free"].sum()) == int(whole["half_cycle_free"].sum())
    for name in ("log_decrement", "measured_log_decrement"):
        np.testing.assert_allclose(whole[name], cut[name], rtol=0.01, err_msg=name)
    largest = float(whole["measured_decay_peak"][whole["half_cycle_free"] == 1].max())
    np.testing.assert_allclose(whole["decay_peak_misfit"], cut["decay_peak_misfit"], atol=0.01 * largest)
    # The decrement of the model that made the record is that of the record.
    decrement = float(whole["log_decrement"].sel(damping_model="CR"))
    assert decrement == pytest.approx(float(whole["measured_log_decrement"]), rel=5e-3)


def test_a_decay_under_a_side_lobe_is_not_called_free(result):
    """The shipped record's motion pushes at 2 % of the plateau until the response is lost in the sensor's noise."""
    assert int(result["half_cycle_free"].sum()) == 0
    for name in ("log_decrement", "measured_log_decrement", "decay_peak_misfit", "decay_peak_ratio", "period_drift"):
        assert result[name].isnull().all()


def test_misfits_are_those_of_the_stored_histories(result):
    for model in MODELS:
        one = result.sel(damping_model=model)
        moving = result["elapsed"].values >= 0.75  # the motion passes 2 % of its peak near 0.69 s
        difference = (one["control_displacement"] - one["measured"]).values
        assert float(one["rms_misfit"]) == pytest.approx(np.sqrt(np.mean(difference[moving] ** 2)), rel=0.02)
        assert float(one["peak_displacement"]) == pytest.approx(
            float(np.abs(one["control_displacement"]).max()), rel=1e-3
        )


def test_misfits_of_peaks_are_those_of_the_free_half_cycles(free_result):
    result = free_result
    free = result["half_cycle_free"].values == 1
    assert 0 < free.sum() < free.size
    # Free is what begins after the start of the free phase: of the peaks after it, all or all but the first.
    after = (result["measured_decay_peak_elapsed"] > result["free_phase_start"]).values
    assert free.sum() in (after.sum(), after.sum() - 1) and np.all(after[free]) and np.all(free[-free.sum() :])
    for model in MODELS:
        one = result.sel(damping_model=model)
        compared = free & np.isfinite(one["decay_peak"].values)  # a model may come to rest before the wall does
        peaks, measured = one["decay_peak"].values[compared], one["measured_decay_peak"].values[compared]
        assert float(one["decay_peak_misfit"]) == pytest.approx(np.sqrt(np.mean((peaks - measured) ** 2)), rel=1e-12)
        assert float(one["decay_peak_ratio"]) == pytest.approx(np.mean(peaks / measured), rel=1e-12)
        expected = np.log(peaks[0] / peaks[-1]) / (compared.sum() - 1)
        assert float(one["log_decrement"]) == pytest.approx(expected, rel=1e-12)


def test_the_sensors_zero_does_not_matter(config, record, equivalence, result):
    moved = validated(config, replace(record, displacement=record.displacement + 0.01), equivalence)
    assert float(moved["sensor_zero"] - result["sensor_zero"]) == pytest.approx(0.01, rel=1e-9)
    np.testing.assert_allclose(moved["measured"], result["measured"], atol=1e-15)
    np.testing.assert_allclose(moved["rms_misfit"], result["rms_misfit"], rtol=1e-9)


@pytest.mark.parametrize("stretch", [0.98, 1.0, 1.03])
def test_a_decay_whose_half_cycles_last_longer_than_the_measured_has_a_drift_above_zero(stretch):
    """Two damped sines of the same peaks, one of which is slower by a known factor."""
    elapsed = np.arange(0.0, 3.0, 0.001)

    def decay(slower):
        cycles = elapsed / slower / 0.5
        return 0.02 * np.sin(2 * np.pi * cycles) * 0.8**cycles

    measured = decay(1.0)
    none = np.zeros(())
    response = Histories(none, none, np.array(0.02 / U_INS), none, none, decay(stretch) / U_INS, 0 * elapsed)
    halves, free = half_cycles(elapsed, measured, 0.001)[slice(1, 9)], np.ones(8, dtype=bool)
    found = _misfits(elapsed, response, U_INS, measured, halves, free, 0)
    assert found["period_drift"][1] == pytest.approx(stretch - 1, abs=2e-4)
    assert found["decay_peak_ratio"][1] == pytest.approx(1.0, abs=2e-3)
    assert found["log_decrement"][1] == pytest.approx(-np.log(0.8) / 2, rel=1e-2)


def test_a_model_that_collapses_says_so_and_has_no_misfit(config, record, equivalence):
    weak = configured({"validation": {"curve": {"strength_ratio": 0.76}}})
    one = validated(weak, record, equivalence).sel(damping_model="CR")
    assert int(one["collapsed"]) == 1
    assert float(one["peak_displacement"]) >= U_INS
    assert int(one["matched_half_cycles"]) == 0
    for name in ("rms_misfit", "decay_peak_misfit", "decay_peak_ratio", "log_decrement", "period_drift"):
        assert np.isnan(one[name])
    assert np.isnan(one["control_displacement"][-1]) and not np.isnan(one["control_displacement"][0])


def test_a_record_that_cannot_be_compared_says_why(config, record, equivalence):
    with pytest.raises(InputError, match="no column displacement_m"):
        validated(config, replace(record, displacement=None), equivalence)

    def part(start, stop):
        return Record(
            record.elapsed[start:stop], record.ground_acceleration[start:stop], record.displacement[start:stop]
        )

    with pytest.raises(InputError, match="samples at rest before the motion is 0; it must be at least 10"):
        validated(config, part(300, None), equivalence)
    with pytest.raises(InputError, match="still strong at the end of the record"):
        validated(config, part(None, int(PULSE_CENTRE * SAMPLING)), equivalence)
    with pytest.raises(InputError, match="no half cycle beyond .* it must hold a decay"):
        validated(config, replace(record, displacement=0.001 * record.displacement), equivalence)


# --- a test series of records


@pytest.fixture(scope="module")
def levels(config):
    paths = [ROOT / path for path in config.validation.test_series if "/cr-" in path]
    return {path.stem: read_record(path) for path in paths}


def test_a_test_series_is_compared_record_by_record_in_place_of_a_synthetic_one(config, record, levels, equivalence):
    whole = validate(config, record, levels, equivalence)
    assert list(whole["record"].values) == list(levels)
    assert set(whole["record_made_by"].values) == {"CR"}
    name = "cr-half"
    one = validated(config, levels[name], equivalence)
    of_one = whole.sel(record=name).isel(half_cycle=slice(one.sizes["half_cycle"]))
    xr.testing.assert_identical(of_one.drop_attrs().drop_vars("record"), one.drop_attrs().drop_vars("record"))
    # The higher levels hold a free decay, with decrements; the lowest hardly rocks.
    free = whole["half_cycle_free"].sum("half_cycle").values
    assert free[0] == 0 and np.all(free[1:] >= 8)
    for name in ("log_decrement", "measured_log_decrement", "decay_peak_misfit", "period_drift"):
        assert np.all(whole[name].isel(record=slice(1, None)).notnull()), name
        assert np.all(whole[name].isel(record=0).isnull()), name
    assert np.all(np.diff(whole["measured_peak_displacement"]) > 0)


def test_a_measured_record_is_not_mixed_with_a_synthetic_test_series(config, record, levels, equivalence):
    measured = replace(record, header={**record.header, "synthetic": "no"})
    alone = validate(config, measured, levels, equivalence)
    assert alone.sizes["record"] == 1
    assert alone.attrs["record_synthetic"] == "no"
    assert list(alone["record_made_by"].values) == ["measured"]
    own = {name: replace(one, header={**one.header, "synthetic": "no"}) for name, one in levels.items()}
    assert list(compared(measured, own)) == list(own)
    assert list(compared(record, {})) == ["record"]


def test_records_of_a_test_series_must_be_sampled_alike(record, levels):
    with pytest.raises(InputError, match="other begins at 0 s with a step of 0.01 s; .* at 0 s with 0.00390625 s"):
        compared(
            record, {**levels, "other": Record(0.01 * np.arange(9), np.zeros(9), np.zeros(9), {"synthetic": "yes"})}
        )


def test_what_is_wrong_with_a_record_of_a_test_series_names_it(config, record, levels, equivalence):
    with pytest.raises(InputError, match="cr-half: the record has no column displacement_m"):
        validate(config, record, {**levels, "cr-half": replace(levels["cr-half"], displacement=None)}, equivalence)
