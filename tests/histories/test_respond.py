"""Histories as labelled datasets: the solver's numbers, with names and units, alone and side by side."""

import numpy as np
import pytest
import xarray as xr

import rockdamp as rd
from rockdamp.histories.respond import scale_factors, tabulate
from rockdamp.motions.catalogue import GroundMotion
from rockdamp.motions.intensity import intensity_measures

CURVE = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
WALL = rd.Wall(thickness=0.3, height=4.5, overburden_ratio=1.0)
U_INS, P = float(WALL.instability_displacement), float(WALL.frequency_parameter)
DAMPERS = [rd.Damping("CR", 0.85), rd.Damping("SDR", 0.06), rd.Damping("ECD", 0.05, order=16)]


def pulse(start=0.0):
    elapsed = 0.01 * np.arange(300)
    return rd.Record(
        start + elapsed, np.where(elapsed < 0.6, 3 * np.sin(2 * np.pi * elapsed / 0.6), 0.0)
    )


def test_decay_is_the_solvers_in_metres_and_seconds():
    decay = rd.free_decay(
        CURVE, rd.Damping("CR", 0.9), release_amplitude=0.6, length=10.0, step=0.002
    )
    same = rd.simulate(CURVE, rd.Damping("CR", 0.9), release_amplitude=0.6, step=0.002, steps=5000)
    for name, values in vars(same).items():
        np.testing.assert_array_equal(decay[name], values)
    np.testing.assert_allclose(decay.tau, 0.002 * np.arange(5001))
    full = rd.free_decay(
        CURVE, rd.Damping("CR", 0.9), wall=WALL, release_amplitude=0.6, length=10.0, step=0.002
    )
    xr.testing.assert_identical(full[list(decay.data_vars)].drop_vars("elapsed"), decay)
    np.testing.assert_allclose(full.elapsed * P, decay.tau)
    np.testing.assert_allclose(full.control_displacement, U_INS * decay.displacement)
    np.testing.assert_allclose(full.control_velocity, U_INS * P * decay.velocity)
    assert (
        full.peak_displacement == U_INS * 0.6
        and full.peak_elapsed == 0
        and full.end_elapsed == 10.0 / P
    )


def test_default_step_is_less_on_a_stiff_curve():
    stiff = rd.TrilinearCurve(yield_displacement_ratio=0.001, strength_ratio=0.85)
    steps = [
        rd.free_decay(curve, DAMPERS[0], length=1.0).sizes["tau"] - 1 for curve in (CURVE, stiff)
    ]
    assert steps == [400, np.ceil(60 / float(rd.stable_step(stiff)))]


def test_dampers_stand_side_by_side_as_each_alone():
    together = rd.respond(WALL, CURVE, DAMPERS, pulse(), scale=[1.0, 20.0], tail=1.0)
    assert together.displacement.dims == ("damping_model", "scale_factor", "elapsed")
    assert together.damping_model.values.tolist() == ["CR", "SDR", "ECD16"]
    np.testing.assert_array_equal(together.restitution, [0.85, np.nan, np.nan])
    np.testing.assert_array_equal(together.damping_ratio, [np.nan, 0.06, 0.05])
    for damping in DAMPERS:
        alone = rd.respond(WALL, CURVE, damping, pulse(), scale=20.0, tail=1.0)
        same = together.sel(damping_model=damping.label, scale_factor=20.0)
        assert alone.sizes == {"elapsed": 400}
        xr.testing.assert_equal(
            alone, same.drop_vars({"restitution", "damping_ratio"} - {*alone.coords})
        )
    for name, variable in together.variables.items():
        assert variable.attrs["units"] and variable.attrs["long_name"], name


@pytest.mark.parametrize(("model", "name"), [("CR", "restitution"), ("CDR", "damping_ratio")])
def test_values_of_a_damper_are_coordinates(model, name):
    values = np.array([0.1, 0.2])
    many = rd.respond(WALL, CURVE, rd.Damping(model, values), pulse(), scale=[1.0, 2.0, 20.0])
    assert many.displacement.dims == ("scale_factor", name, "elapsed")
    one = rd.respond(WALL, CURVE, rd.Damping(model, 0.2), pulse(), scale=2.0)
    np.testing.assert_array_equal(
        many.displacement.sel({name: 0.2, "scale_factor": 2.0}), one.displacement
    )


def test_response_is_the_solvers_with_a_rest_behind():
    response = rd.respond(
        WALL, CURVE, rd.Damping("SDR", 0.06), pulse(), scale=0.5, tail=1.0, step=P * 0.002
    )
    ground = np.concatenate([pulse().ground_acceleration, np.zeros(100)])
    load = rd.Load(ground, 0.5 * WALL.load_factor, P * 0.01, substeps=5)
    same = rd.simulate(CURVE, rd.Damping("SDR", 0.06), load=load, store_every=5)
    np.testing.assert_allclose(response.displacement, same.displacement, rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(response.ground_acceleration, 0.5 * ground)
    assert float(response.elapsed[-1]) == pytest.approx(3.99)
    assert response.end_elapsed == pytest.approx(3.99) and response.end_tau == pytest.approx(
        3.99 * P
    )


def test_later_start_moves_times_alone():
    early, late = (
        rd.respond(WALL, CURVE, DAMPERS[0], pulse(start), scale=20.0, tail=1.0)
        for start in (0.0, 5.0)
    )
    for name in ("peak_elapsed", "end_elapsed", "elapsed"):
        np.testing.assert_allclose(late[name] - 5.0, early[name], atol=1e-9)
    for name in ("peak_displacement", "peak_tau", "end_tau", "tau"):
        np.testing.assert_allclose(late[name], early[name], rtol=1e-9, atol=1e-9)


def test_after_a_collapse_there_is_no_number():
    response = rd.respond(WALL, CURVE, DAMPERS[0], pulse(), scale=[0.5, 20.0], tail=2.0)
    assert response.collapsed.values.tolist() == [0, 1]
    stands, fell = (response.isel(scale_factor=index) for index in (0, 1))
    assert np.isfinite(stands.control_displacement).all()
    assert np.isnan(
        fell.control_displacement.where(fell.elapsed > fell.end_elapsed, drop=True)
    ).all()
    assert np.isfinite(
        fell.control_displacement.where(fell.elapsed < fell.end_elapsed, drop=True)
    ).all()


def test_row_for_each_record_scale_and_damper():
    motions = [GroundMotion(name, name, "own", pulse()) for name in ("one", "two")]
    rows = list(tabulate(motions, WALL, CURVE, DAMPERS[:2], {"pgv": [0.2, 8.0]}, 1.0))
    assert [row["record"] for row in rows] == 4 * ["one"] + 4 * ["two"]
    assert [row["damping_model"] for row in rows] == 4 * ["CR", "SDR"]
    assert [row["damping_ratio"] for row in rows] == 4 * [None, 0.06]
    np.testing.assert_allclose([row["pgv"] for row in rows], 2 * [0.2, 0.2, 8.0, 8.0])
    assert [row["outcome"] for row in rows] == 2 * [
        "completed",
        "completed",
        "collapsed",
        "collapsed",
    ]
    measures = intensity_measures(pulse())
    assert rows[3]["pga"] == pytest.approx(8.0 / measures.pgv * measures.pga)
    same = rd.respond(WALL, CURVE, DAMPERS[1], pulse(), scale=8.0 / measures.pgv, tail=1.0)
    for name, variable in {
        "peak": "peak",
        "peak_elapsed": "peak_elapsed",
        "outcome_elapsed": "end_elapsed",
    }.items():
        assert rows[3][name] == same[variable].item()


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("length", lambda: rd.free_decay(CURVE, DAMPERS[0], length=0.0)),
        ("number of steps", lambda: rd.free_decay(CURVE, DAMPERS[0], length=1e9)),
        ("step", lambda: rd.free_decay(CURVE, DAMPERS[0], step=0.0)),
        ("release_amplitude", lambda: rd.free_decay(CURVE, DAMPERS[0], release_amplitude=1.0)),
        ("tail", lambda: rd.respond(WALL, CURVE, DAMPERS[0], pulse(), tail=-1.0)),
        ("--to-pgv", lambda: scale_factors(pulse(), {"pgv": [0.2, 0.0]})),
    ],
)
def test_bad_input_is_named(name, call):
    with pytest.raises(rd.InputError, match=name):
        call()
