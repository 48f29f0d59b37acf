"""Histories as labelled datasets: the solver's numbers with names and units."""

import numpy as np
import pytest
import xarray as xr

import rockdamp as rd
from rockdamp.histories.respond import scale_factors, tabulate
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures

CURVE = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
WALL = rd.Wall(thickness=0.3, height=4.5, overburden_ratio=1.0)
U_INS = float(WALL.instability_displacement)
P = float(WALL.frequency_parameter)
CR = rd.Damping("CR", 0.85)
SDR = rd.Damping("SDR", 0.06)
DAMPERS = [CR, SDR, rd.Damping("ECD", 0.05, order=16)]


def pulse(start=0.0):
    """Return one sine of 0.6 s and a rest, sampled at 100 Hz."""
    elapsed = 0.01 * np.arange(300)
    acceleration = np.where(elapsed < 0.6, 3 * np.sin(2 * np.pi * elapsed / 0.6), 0.0)
    return rd.Record(start + elapsed, acceleration)


# --- free decay -----------------------------------------------------------------------------------

RELEASE = {"release_amplitude": 0.6, "length": 10.0, "step": 0.002}


@pytest.fixture(scope="module")
def decay():
    return rd.free_decay(CURVE, CR, **RELEASE)


def test_decay_is_the_solvers(decay):
    histories = rd.simulate(CURVE, CR, release_amplitude=0.6, step=0.002, steps=5000)
    for name, values in vars(histories).items():
        np.testing.assert_array_equal(decay[name], values)
    np.testing.assert_allclose(decay.tau, 0.002 * np.arange(5001))


def test_wall_adds_metres_and_seconds(decay):
    full = rd.free_decay(CURVE, CR, wall=WALL, **RELEASE)
    xr.testing.assert_identical(full[list(decay.data_vars)].drop_vars("elapsed"), decay)
    np.testing.assert_allclose(full.elapsed * P, decay.tau)
    np.testing.assert_allclose(full.control_displacement, U_INS * decay.displacement)
    np.testing.assert_allclose(full.control_velocity, U_INS * P * decay.velocity)
    assert full.peak_displacement == U_INS * 0.6
    assert full.peak_elapsed == 0
    assert full.end_elapsed == 10.0 / P


def test_default_step_is_400_a_unit_of_tau():
    assert rd.free_decay(CURVE, CR, length=1.0).sizes["tau"] == 401


def test_default_step_is_less_on_a_stiff_curve():
    stiff = rd.TrilinearCurve(yield_displacement_ratio=0.001, strength_ratio=0.85)
    steps = rd.free_decay(stiff, CR, length=1.0).sizes["tau"] - 1
    assert steps == np.ceil(60 / float(rd.stable_step(stiff)))


# --- dampers --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def comparison():
    return rd.respond(WALL, CURVE, DAMPERS, pulse(), scale=[1.0, 20.0], tail=1.0)


def test_dampers_are_named_by_label_family_and_parameter(comparison):
    assert comparison.displacement.dims == ("damping_model", "scale_factor", "elapsed")
    assert comparison.damping_model.values.tolist() == ["CR", "SDR", "ECD16"]
    assert comparison.damper_family.values.tolist() == ["CR", "SDR", "ECD"]
    np.testing.assert_array_equal(comparison.damper_parameter, [np.nan, np.nan, 16])


def test_values_of_dampers_are_coordinates(comparison):
    np.testing.assert_array_equal(comparison.restitution, [0.85, np.nan, np.nan])
    np.testing.assert_array_equal(comparison.damping_ratio, [np.nan, 0.06, 0.05])


@pytest.mark.parametrize("damping", DAMPERS, ids=["CR", "SDR", "ECD16"])
def test_each_damper_is_what_it_is_alone(damping, comparison):
    single = rd.respond(WALL, CURVE, damping, pulse(), scale=20.0, tail=1.0)
    assert single.sizes == {"elapsed": 400}
    selected = comparison.sel(damping_model=damping.label, scale_factor=20.0)
    other_value = {"restitution", "damping_ratio"} - set(single.coords)
    xr.testing.assert_equal(single, selected.drop_vars(other_value))


def test_every_variable_has_a_unit_and_a_meaning(comparison):
    for name, variable in comparison.variables.items():
        assert variable.attrs["units"], name
        assert variable.attrs["long_name"], name


@pytest.mark.parametrize(("model", "name"), [("CR", "restitution"), ("CDR", "damping_ratio")])
def test_values_of_one_damper_are_a_dimension(model, name):
    damping = rd.Damping(model, [0.1, 0.2])
    responses = rd.respond(WALL, CURVE, damping, pulse(), scale=[1.0, 2.0, 20.0])
    assert responses.displacement.dims == ("scale_factor", name, "elapsed")
    single = rd.respond(WALL, CURVE, rd.Damping(model, 0.2), pulse(), scale=2.0)
    selected = responses.displacement.sel({name: 0.2, "scale_factor": 2.0})
    np.testing.assert_array_equal(selected, single.displacement)


# --- response -------------------------------------------------------------------------------------


def test_response_is_the_solvers_with_a_rest_behind():
    response = rd.respond(WALL, CURVE, SDR, pulse(), scale=0.5, tail=1.0, step=P * 0.002)
    ground = np.concatenate([pulse().ground_acceleration, np.zeros(100)])
    load = rd.Load(ground, 0.5 * WALL.load_factor, P * 0.01, substeps=5)
    histories = rd.simulate(CURVE, SDR, load=load, store_every=5)
    np.testing.assert_allclose(response.displacement, histories.displacement, rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(response.ground_acceleration, 0.5 * ground)


def test_response_ends_with_the_rest():
    response = rd.respond(WALL, CURVE, SDR, pulse(), scale=0.5, tail=1.0)
    assert float(response.elapsed[-1]) == pytest.approx(3.99)
    assert float(response.end_elapsed) == pytest.approx(3.99)
    assert float(response.end_tau) == pytest.approx(3.99 * P)


def test_later_start_moves_times_alone():
    early = rd.respond(WALL, CURVE, CR, pulse(0.0), scale=20.0, tail=1.0)
    late = rd.respond(WALL, CURVE, CR, pulse(5.0), scale=20.0, tail=1.0)
    for name in ("peak_elapsed", "end_elapsed", "elapsed"):
        np.testing.assert_allclose(late[name] - 5.0, early[name], atol=1e-9)
    for name in ("peak_displacement", "peak_tau", "end_tau", "tau"):
        np.testing.assert_allclose(late[name], early[name], rtol=1e-9, atol=1e-9)


def test_after_a_collapse_there_is_no_number():
    response = rd.respond(WALL, CURVE, CR, pulse(), scale=[0.5, 20.0], tail=2.0)
    assert response.collapsed.values.tolist() == [0, 1]
    displacement = response.control_displacement
    assert np.isfinite(displacement.isel(scale_factor=0)).all()
    collapse = response.end_elapsed.isel(scale_factor=1)
    is_number = np.isfinite(displacement.isel(scale_factor=1))
    assert not is_number.where(response.elapsed > collapse, drop=True).any()
    assert is_number.where(response.elapsed < collapse, drop=True).all()


# --- the table ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def table():
    motions = [GroundMotion(name, name, "own", pulse()) for name in ("one", "two")]
    return list(tabulate(motions, WALL, CURVE, [CR, SDR], {"pgv": [0.2, 8.0]}, 1.0))


def test_table_has_a_row_for_each_record_scale_and_damper(table):
    assert [row["record"] for row in table] == 4 * ["one"] + 4 * ["two"]
    assert [row["damping_model"] for row in table] == 4 * ["CR", "SDR"]
    assert [row["damping_ratio"] for row in table] == 4 * [None, 0.06]
    np.testing.assert_allclose([row["pgv"] for row in table], 2 * [0.2, 0.2, 8.0, 8.0])


def test_table_states_outcomes(table):
    outcomes = ["survived", "survived", "collapsed", "collapsed"]
    assert [row["outcome"] for row in table] == 2 * outcomes


def test_table_states_the_pga_of_the_scaled_record(table):
    measures = intensity_measures(pulse())
    assert table[3]["pga"] == pytest.approx(8.0 / measures.pgv * measures.pga)


def test_row_is_what_respond_returns(table):
    scale = 8.0 / intensity_measures(pulse()).pgv
    response = rd.respond(WALL, CURVE, SDR, pulse(), scale=scale, tail=1.0)
    assert table[3]["peak"] == response.peak.item()
    assert table[3]["peak_elapsed"] == response.peak_elapsed.item()
    assert table[3]["outcome_elapsed"] == response.end_elapsed.item()


# --- input ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("length", {"length": 0.0}),
        ("number of steps", {"length": 1e9}),
        ("step", {"step": 0.0}),
        ("release_amplitude", {"release_amplitude": 1.0}),
    ],
)
def test_bad_input_of_a_decay_is_named(name, arguments):
    with pytest.raises(rd.InputError, match=name):
        rd.free_decay(CURVE, CR, **arguments)


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("tail", {"tail": -1.0}),
        ("tail", {"tail": 1e6}),
        ("scale", {"scale": [[1.0], [2.0]]}),
        ("step", {"step": 0.0}),
    ],
)
def test_bad_input_of_a_response_is_named(name, arguments):
    with pytest.raises(rd.InputError, match=name):
        rd.respond(WALL, CURVE, CR, pulse(), **arguments)


def test_an_intensity_of_zero_is_named():
    with pytest.raises(rd.InputError, match="pgv is 0; it must be greater than 0"):
        scale_factors(pulse(), {"pgv": [0.2, 0.0]})
