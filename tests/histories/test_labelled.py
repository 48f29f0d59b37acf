"""Histories as labelled datasets: the same numbers as the solver's, with names, units and broadcasting by name."""

import numpy as np
import pytest
import xarray as xr

import rockdamp as rd
from rockdamp.histories.measured_test import computed_response
from rockdamp.plausibility import as_meant

CURVE = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
WALL = rd.Wall(thickness=0.3, height=4.5, overburden_ratio=1.0)


def pulse():
    elapsed = 0.01 * np.arange(300)
    return rd.Record(elapsed, np.where(elapsed < 0.6, 3 * np.sin(2 * np.pi * elapsed / 0.6), 0.0))


def test_a_decay_is_what_the_solver_returns():
    decay = rd.free_decay(CURVE, rd.Damping("CR", 0.9), release_amplitude=0.6, length=10.0, points=101, step=0.002)
    same = rd.simulate(CURVE, rd.Damping("CR", 0.9), release_amplitude=0.6, step=0.002, steps=5000, store_every=50)
    np.testing.assert_allclose(decay.displacement, same.displacement, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(decay.velocity, same.velocity, rtol=1e-9, atol=1e-12)
    assert decay.impacts == same.impacts and decay.outcome == "completed"
    np.testing.assert_allclose(decay.tau, 0.1 * np.arange(101))


def test_a_wall_turns_the_same_decay_into_metres_and_seconds():
    u_ins, p = float(WALL.instability_displacement), float(WALL.frequency_parameter)
    bare = rd.free_decay(CURVE, rd.Damping("CDR", 0.05), length=12.0)
    full = rd.free_decay(CURVE, rd.Damping("CDR", 0.05), wall=WALL, length=12.0 / p)
    np.testing.assert_allclose(full.elapsed * p, bare.tau)
    np.testing.assert_allclose(full.control_displacement, u_ins * bare.displacement, atol=1e-9)
    np.testing.assert_allclose(full.control_velocity, u_ins * p * bare.velocity, atol=1e-7)
    assert full.peak_displacement == pytest.approx(u_ins * 0.5)


def test_parameters_broadcast_by_name_and_plain_arrays_are_named_after_what_they_are():
    curve = rd.TrilinearCurve([0.02, 0.04, 0.06], [0.8, 0.85, 0.9])
    damping = rd.Damping("CDR", xr.DataArray([0.03, 0.05], dims="damper"))
    decay = rd.free_decay(curve, damping, length=4.0, points=5)
    assert dict(decay.displacement.sizes) == {"yield_displacement_ratio": 3, "damper": 2, "tau": 5}
    assert decay.strength_ratio.dims == ("yield_displacement_ratio",) and decay.damping_ratio.dims == ("damper",)
    one = rd.free_decay(rd.TrilinearCurve(0.06, 0.9), rd.Damping("CDR", 0.03), length=4.0, points=5)
    np.testing.assert_allclose(decay.displacement[2, 0], one.displacement, atol=1e-12)


def test_a_response_is_the_validations_with_the_record_and_a_rest_behind_it():
    record = pulse()
    with as_meant():  # too weak a motion to rock the wall
        response = rd.respond(WALL, CURVE, rd.Damping("SDR", 0.06), record, tail=1.0, step=0.005)
    same = computed_response(record, WALL, CURVE, rd.Damping("SDR", 0.06), 0.005)
    u_ins = float(WALL.instability_displacement)
    np.testing.assert_allclose(response.control_displacement[:300], u_ins * same.displacement, rtol=1e-9, atol=1e-12)
    assert response.sizes["elapsed"] == 400 and float(response.elapsed[-1]) == pytest.approx(3.99)
    assert (response.ground_acceleration[300:] == 0).all()
    assert response.peak_displacement >= np.abs(response.control_displacement).max()


def test_a_record_that_starts_later_moves_every_time_and_no_size():
    early, late = (
        rd.respond(
            WALL,
            CURVE,
            rd.Damping("CR", 0.85),
            rd.Record(start + 0.01 * np.arange(300), pulse().ground_acceleration),
            scale=[1.0, 20.0],
            tail=1.0,
        )
        for start in (0.0, 5.0)
    )
    for name in ("peak_elapsed", "outcome_elapsed", "elapsed"):
        np.testing.assert_allclose(late[name] - 5.0, early[name], atol=1e-9)
    np.testing.assert_allclose(late["peak_displacement"], early["peak_displacement"], rtol=1e-9)
    assert float(late["peak_elapsed"].sel(scale_factor=1.0)) > 5.0
    at_peak = abs(late["control_displacement"].sel(scale_factor=1.0)).sel(
        elapsed=late["peak_elapsed"].sel(scale_factor=1.0), method="nearest"
    )
    assert at_peak == pytest.approx(float(late["peak_displacement"].sel(scale_factor=1.0)), rel=1e-2)


def test_a_motion_in_g_that_rocks_no_wall_is_questioned_and_one_that_rocks_it_is_not():
    elapsed = 0.01 * np.arange(300)
    strong = 1.5 * float(WALL.rocking_onset(0.85)) * np.sin(2 * np.pi * elapsed / 0.6) * (elapsed < 0.6)
    record, in_g = (rd.Record(elapsed, strong / unit) for unit in (1.0, 9.80665))
    with pytest.warns(rd.InputWarning, match=r"the wall does not rock.*was it in g"):
        rd.respond(WALL, CURVE, rd.Damping("CR", 0.9), in_g)
    rd.respond(WALL, CURVE, rd.Damping("CR", 0.9), record)


def test_a_scale_that_brings_the_wall_down_says_so_and_leaves_no_number_behind():
    response = rd.respond(WALL, CURVE, rd.Damping("CR", 0.85), pulse(), scale=[0.5, 20.0], tail=2.0)
    assert response.outcome.values.tolist() == ["completed", "collapsed"]
    assert np.isfinite(response.control_displacement.sel(scale_factor=0.5)).all()
    gone = response.sel(scale_factor=20.0)
    assert np.isnan(gone.control_displacement.where(gone.elapsed > gone.outcome_elapsed, drop=True)).all()
    np.testing.assert_allclose(
        response.ground_acceleration.sel(scale_factor=20.0)[:300], 20 * pulse().ground_acceleration
    )


@pytest.mark.filterwarnings("ignore::rockdamp.errors.InputWarning")  # 6 g, so that walls collapse
def test_without_histories_the_rest_is_the_same_and_memory_does_not_grow_with_the_record():
    arguments = (WALL, CURVE, rd.Damping("CR", [0.8, 0.9]), pulse())
    whole, short = (rd.respond(*arguments, scale=20.0, tail=1.0, histories=kept) for kept in (True, False))
    left_out = {"control_displacement", "control_velocity", "ground_acceleration", "elapsed"}
    assert set(whole.variables) - set(short.variables) == left_out
    xr.testing.assert_identical(short, whole.drop_vars(left_out))
    assert short.nbytes == rd.respond(*arguments, scale=20.0, tail=50.0, histories=False).nbytes


def test_every_variable_says_its_unit_and_meaning():
    for history in (
        rd.free_decay(CURVE, rd.Damping("ECD", [0.05, 0.06], order=2), length=2.0, points=3),
        rd.respond(WALL, rd.TrilinearCurve([0.02, 0.04], 0.85), rd.Damping("ECD", [0.05]), pulse(), scale=[1, 2]),
    ):
        for name, variable in history.variables.items():
            assert variable.attrs["units"] and variable.attrs["long_name"], name


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"length": 0.0}, "length is 0.0"),
        ({"points": 1}, "points is 1"),
        ({"release_amplitude": np.full((2, 2), 0.5)}, "number of dimensions of release_amplitude is 2"),
        ({"release_amplitude": xr.DataArray([0.1, 0.2], dims="restitution", coords={"restitution": [1, 2]})}, "unlike"),
    ],
)
def test_bad_input_is_named(arguments, expected):
    with pytest.raises(rd.InputError, match=expected):
        rd.free_decay(CURVE, rd.Damping("CR", [0.8, 0.9]), **arguments)


@pytest.mark.parametrize("dim", ["tau", "elapsed", "damping_model"])
def test_a_dimension_that_the_result_has_already_is_refused(dim):
    with pytest.raises(rd.InputError, match=f"a dimension is called '{dim}', as a part of the result"):
        rd.free_decay(CURVE, rd.Damping("CR", xr.DataArray([0.8, 0.9], dims=dim)), length=1.0)
