"""The shipped synthetic record of a shaking-table test, and the tool that makes it."""

import runpy
import sys

import experimental_style
import numpy as np
import pytest
import yaml
from experimental_style import ricker, synthetic_record
from repository import ROOT
from rounded_texts import assert_shipped
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.errors import InputError
from rockdamp.motions.record_file import read_record

SHIPPED = ROOT / "data" / "sin-03-00-synthetic.csv"
U_INS = float(experimental_style.WALL.instability_displacement)
RICKER_ZERO = 1 / (np.pi * 2.0 * np.sqrt(2))  # [s], of a wavelet of 2 Hz


@pytest.fixture(scope="module")
def noiseless():
    return synthetic_record(noise=0)


def displacement_ratios(record):
    return (record.displacement - experimental_style.SENSOR_ZERO) / U_INS


def test_shipped_record_is_the_one_that_the_tool_makes(tmp_path, monkeypatch):
    path = tmp_path / "made.csv"
    monkeypatch.setattr(sys, "argv", ["synthetic", str(path)])
    runpy.run_path(str(ROOT / "tools/experimental_style.py"), run_name="__main__")
    assert_shipped(path.read_text(encoding="utf-8"), SHIPPED.read_text(encoding="utf-8"))


def test_shipped_record_says_that_it_is_synthetic():
    record = read_record(SHIPPED)
    assert record.synthetic and record.step == 1 / 256
    assert float(record.header["generator_strength_ratio"]) == experimental_style.STRENGTH_RATIO


def test_ground_moves_as_a_ricker_wavelet_of_2_hz(noiseless):
    peak = 1.35 * STANDARD_GRAVITY
    acceleration = noiseless.ground_acceleration
    assert acceleration.max() == pytest.approx(peak, abs=5e-4)
    assert acceleration.min() == pytest.approx(-2 * np.exp(-1.5) * peak, rel=2e-3)
    positive_duration = np.ptp(noiseless.elapsed[acceleration > 0])
    assert positive_duration == pytest.approx(2 * RICKER_ZERO, abs=2 / 256)


def test_wall_rocks_and_comes_to_rest(noiseless):
    ratios = displacement_ratios(noiseless)
    clear = ratios[np.abs(ratios) > 0.02]
    assert np.count_nonzero(np.diff(np.sign(clear))) >= 7
    rest = (noiseless.elapsed < 0.6) | (noiseless.elapsed > 4)
    assert np.abs(ratios[rest]).max() < 0.003


@pytest.mark.parametrize(("level", "peak"), [(1.30, "0.096"), (1.35, "0.145"), (1.40, "0.233")])
def test_caption_of_fig_8_has_the_peaks_of_three_motions(level, peak):
    captions = (ROOT / "src/rockdamp/report/figures.yaml").read_text(encoding="utf-8")
    caption = yaml.safe_load(captions)["fig8"]["caption"]
    record = synthetic_record(noise=0, pulse_peak=level * STANDARD_GRAVITY)
    assert f"{np.abs(displacement_ratios(record)).max():.3f}" == peak
    assert peak in caption and f"{level:.2f}" in caption


def test_motion_that_collapses_the_wall_makes_no_record():
    with pytest.raises(InputError, match="pulse_peak"):
        synthetic_record(noise=0, pulse_peak=1.45 * STANDARD_GRAVITY)


def test_ricker_wavelet_has_its_peak_zeros_and_troughs():
    assert ricker(0.0, 2.0, 3.0) == 3.0
    # Physics gives a wavelet of 2 Hz this width.
    assert 2 * RICKER_ZERO == pytest.approx(0.225, abs=5e-4)
    np.testing.assert_allclose(ricker([-RICKER_ZERO, RICKER_ZERO], 2.0, 3.0), 0, atol=1e-15)
    trough = minimize_scalar(
        lambda t: float(ricker(t, 2.0, 3.0)), bounds=(RICKER_ZERO, 0.5), method="bounded"
    )
    assert trough.fun == pytest.approx(-3.0 * 2 * np.exp(-1.5), rel=1e-9)


def test_ricker_wavelet_ends_without_velocity():
    velocity = 2 * quad(ricker, 0, 2.0, args=(2.0, 1.0))[0]
    velocity_of_the_lobe = 2 * quad(ricker, 0, RICKER_ZERO, args=(2.0, 1.0))[0]
    assert abs(velocity) < 1e-9 * velocity_of_the_lobe
