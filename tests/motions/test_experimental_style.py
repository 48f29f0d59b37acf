"""The pulses and the experimental-style record."""

import runpy
import sys

import numpy as np
import pytest
import yaml
from repository import ROOT
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar

from rockdamp.config.walls import make_wall
from rockdamp.errors import InputError
from rockdamp.motions import experimental_style
from rockdamp.motions.experimental_style import ricker, synthetic_record, table_pulse
from rockdamp.motions.records import read_record

SHIPPED = ROOT / "data" / "sin-03-00-synthetic.csv"
U_INS = float(experimental_style.WALL.instability_displacement)


@pytest.fixture(scope="module")
def clean():
    return synthetic_record(noise=0)


# --- pulses


def test_a_ricker_wavelet_has_its_peak_zeros_and_troughs_where_the_formula_puts_them():
    assert ricker(0.0, 2.0, 3.0) == 3.0
    zero = 1 / (np.pi * 2.0 * np.sqrt(2))
    assert 2 * zero == pytest.approx(0.225, abs=5e-4)  # the width that physics gives a 2 Hz wavelet
    np.testing.assert_allclose(ricker([-zero, zero], 2.0, 3.0), 0, atol=1e-15)
    trough = minimize_scalar(lambda t: float(ricker(t, 2.0, 3.0)), bounds=(zero, 0.5), method="bounded")
    assert trough.fun == pytest.approx(-3.0 * 2 * np.exp(-1.5), rel=1e-9)


@pytest.mark.parametrize(("width", "side_lobe"), [(0.29, 0.23), (0.29, 0.18), (0.25, 0.28), (0.4, 0.4)])
def test_a_table_pulse_has_the_width_and_side_lobes_asked_for(width, side_lobe):
    def pulse(t):
        return float(table_pulse(t, 5.0, width=width, side_lobe=side_lobe))

    assert pulse(0.0) == pytest.approx(5.0, rel=1e-14)
    assert brentq(pulse, 0.01, width) == pytest.approx(width / 2, rel=1e-10)
    trough = minimize_scalar(pulse, bounds=(width / 2, 2 * width), method="bounded")
    assert trough.fun == pytest.approx(-5.0 * side_lobe, rel=1e-8)
    assert trough.x == pytest.approx(np.sqrt(3) * width / 2, rel=1e-4)


@pytest.mark.parametrize("side_lobe", [0.18, 0.23, 0.28])
def test_a_table_pulse_leaves_no_velocity_and_no_displacement(side_lobe):
    lobe = quad(table_pulse, -0.145, 0.145, args=(1.0,))[0]
    velocity = 2 * sum(quad(lambda t: table_pulse(t, 1.0, side_lobe=side_lobe), *ends)[0] for ends in ((0, 1), (1, 9)))
    assert abs(velocity) < 1e-9 * lobe
    t = np.linspace(0, 2, 500)
    np.testing.assert_array_equal(table_pulse(t, 1.0), table_pulse(-t, 1.0))  # even: no displacement either


def test_a_table_pulse_tends_to_a_ricker_wavelet_as_its_side_lobes_deepen():
    t = np.linspace(-1, 1, 2001)
    wavelet = ricker(t, 2.0, 1.0)
    width = 2 / (np.pi * 2.0 * np.sqrt(2))
    apart = [np.abs(table_pulse(t, 1.0, width=width, side_lobe=s) - wavelet).max() for s in (0.40, 0.44, 0.4459)]
    # Near r = 1 the pulse and its side lobe both depart from the wavelet in proportion to (1 - r)^2.
    assert apart[2] < 2e-3  # the side lobe itself is 4e-4 short
    assert apart[0] > 3 * apart[1] > 9 * apart[2]


@pytest.mark.parametrize("side_lobe", [0.0, 0.446, 1.0, np.nan])
def test_a_side_lobe_that_no_table_pulse_has_is_refused(side_lobe):
    with pytest.raises(InputError, match="side_lobe"):
        table_pulse(0.0, 1.0, side_lobe=side_lobe)


def test_a_pulse_without_duration_is_refused():
    with pytest.raises(InputError, match="width is 0"):
        table_pulse(0.0, 1.0, width=0)
    with pytest.raises(InputError, match="frequency is -2"):
        ricker(0.0, -2, 1.0)


# --- the shipped record


def test_the_shipped_record_is_exactly_what_the_generator_makes(tmp_path, monkeypatch):
    path = tmp_path / "made.csv"
    monkeypatch.setattr(sys, "argv", ["synthetic", str(path)])
    monkeypatch.delitem(sys.modules, "rockdamp.motions.experimental_style")  # else runpy warns of a second copy
    runpy.run_module("rockdamp.motions.experimental_style", run_name="__main__")
    assert path.read_text(encoding="utf-8") == SHIPPED.read_text(encoding="utf-8")


def test_running_the_generator_without_a_path_says_how_to_run_it(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["synthetic"])
    monkeypatch.delitem(sys.modules, "rockdamp.motions.experimental_style")
    with pytest.raises(SystemExit, match="usage: python -m rockdamp.motions.experimental_style PATH"):
        runpy.run_module("rockdamp.motions.experimental_style", run_name="__main__")


def test_the_shipped_record_says_that_it_is_synthetic_whose_it_is_and_what_made_it():
    record = read_record(SHIPPED)
    assert record.synthetic
    assert record.header["licence"] == "CC0-1.0"
    assert {"specimen", "source", "units"} <= set(record.header)
    assert float(record.header["generator_plateau_ratio"]) == experimental_style.PLATEAU_RATIO
    assert record.step == 1 / 256
    assert "sin-03-00-synthetic.csv,The rockdamp developers,CC0-1.0,yes" in (ROOT / "data/sources.csv").read_text()


def test_the_generator_has_the_walls_geometry_of_the_config_but_not_its_nominal_parameters():
    section = yaml.safe_load((ROOT / "config/default.yaml").read_text())["validation"]
    wall = make_wall(section["wall"])
    assert wall.frequency_parameter == pytest.approx(float(experimental_style.WALL.frequency_parameter), rel=1e-12)
    assert U_INS == pytest.approx(float(wall.instability_displacement), rel=1e-12)
    for made, nominal in (
        (experimental_style.CRACKED_STIFFNESS_RATIO, section["curve"]["cracked_stiffness_ratio"]),
        (experimental_style.PLATEAU_RATIO, section["curve"]["plateau_ratio"]),
        (experimental_style.RESTITUTION, section["restitution"]),
    ):
        assert 0.004 < abs(made / nominal - 1) < 0.12  # different, slightly


# --- what the generator makes


def test_the_wall_rocks_to_a_third_of_instability_and_comes_to_rest(clean):
    u = (clean.displacement - experimental_style.SENSOR_ZERO) / U_INS
    assert 0.3 < np.abs(u).max() < 0.6
    assert np.count_nonzero(np.diff(np.sign(u[np.abs(u) > 0.02]))) >= 8  # half cycles of clear rocking
    assert np.abs(u[clean.elapsed < 0.6]).max() < 0.003
    assert np.abs(u[clean.elapsed > 4]).max() < 0.003


def test_a_positive_pulse_throws_the_wall_to_the_negative_side_first(clean):
    u = clean.displacement - experimental_style.SENSOR_ZERO
    assert clean.ground_acceleration[np.argmax(np.abs(clean.ground_acceleration))] > 0
    assert u[np.argmax(np.abs(u) > 0.1 * U_INS)] < 0


def test_the_noise_of_both_instruments_is_as_large_as_stated(clean):
    record = synthetic_record(3)
    samples = record.elapsed.size
    spread = 5 / np.sqrt(2 * samples)  # five standard deviations of a standard deviation's estimate
    acceleration = np.std(record.ground_acceleration - clean.ground_acceleration)
    # Rounding to 0.001 m s-2 adds 3e-4 in quadrature: nothing to see.
    assert acceleration == pytest.approx(experimental_style.ACCELEROMETER_NOISE, rel=spread)
    # Differences between samples leave out the slow drift.
    displacement = np.std(np.diff(record.displacement - clean.displacement)) / np.sqrt(2)
    assert displacement == pytest.approx(experimental_style.SENSOR_NOISE, rel=2 * spread)


def test_the_same_seed_makes_the_same_record_and_another_seed_other_noise():
    one, again, other = synthetic_record(5), synthetic_record(5), synthetic_record(6)
    np.testing.assert_array_equal(one.displacement, again.displacement)
    assert np.mean(one.displacement == other.displacement) < 0.1


def test_a_pulse_that_overturns_the_wall_is_refused():
    with pytest.raises(InputError, match="pulse_peak is 20.0; it must be small enough not to overturn the wall"):
        synthetic_record(pulse_peak=20.0)
    with pytest.raises(InputError, match="noise is -1"):
        synthetic_record(noise=-1)
