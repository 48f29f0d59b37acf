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
from rockdamp.motions.record import read_record

SHIPPED = ROOT / "data" / "sin-03-00-synthetic.csv"
U_INS = float(experimental_style.WALL.instability_displacement)


def ratios(record):
    return (record.displacement - experimental_style.SENSOR_ZERO) / U_INS


def test_the_shipped_record_is_what_the_tool_makes_and_says_so(tmp_path, monkeypatch):
    path = tmp_path / "made.csv"
    monkeypatch.setattr(sys, "argv", ["synthetic", str(path)])
    runpy.run_path(str(ROOT / "tools/experimental_style.py"), run_name="__main__")
    assert_shipped(path.read_text(encoding="utf-8"), SHIPPED.read_text(encoding="utf-8"))
    record = read_record(SHIPPED)
    assert record.synthetic and record.step == 1 / 256
    assert float(record.header["generator_strength_ratio"]) == experimental_style.STRENGTH_RATIO


def test_the_wall_rocks_under_a_ricker_wavelet_of_2_hz_and_comes_to_rest():
    made = synthetic_record(noise=0)
    peak, crossing = 1.35 * STANDARD_GRAVITY, 1 / (np.pi * 2.0 * np.sqrt(2))
    assert made.ground_acceleration.max() == pytest.approx(peak, abs=5e-4)
    assert made.ground_acceleration.min() == pytest.approx(-2 * np.exp(-1.5) * peak, rel=2e-3)
    assert np.ptp(made.elapsed[made.ground_acceleration > 0]) == pytest.approx(
        2 * crossing, abs=2 / 256
    )
    u = ratios(made)
    assert (
        np.count_nonzero(np.diff(np.sign(u[np.abs(u) > 0.02]))) >= 7
    )  # half cycles of clear rocking
    assert np.abs(u[(made.elapsed < 0.6) | (made.elapsed > 4)]).max() < 0.003


def test_the_peak_is_as_steep_in_the_motion_as_the_caption_of_fig_8_has_it():
    captions = (ROOT / "src/rockdamp/report/figures.yaml").read_text(encoding="utf-8")
    caption = yaml.safe_load(captions)["fig8"]["caption"]
    for level, peak in ((1.30, "0.096"), (1.35, "0.145"), (1.40, "0.233")):
        made = synthetic_record(noise=0, pulse_peak=level * STANDARD_GRAVITY)
        assert f"{np.abs(ratios(made)).max():.3f}" == peak
        assert peak in caption and f"{level:.2f}" in caption
    with pytest.raises(InputError, match="pulse_peak"):
        synthetic_record(noise=0, pulse_peak=1.45 * STANDARD_GRAVITY)


def test_a_ricker_wavelet_has_its_peak_zeros_and_troughs_where_the_formula_puts_them():
    assert ricker(0.0, 2.0, 3.0) == 3.0
    zero = 1 / (np.pi * 2.0 * np.sqrt(2))
    assert 2 * zero == pytest.approx(0.225, abs=5e-4)  # the width that physics gives a 2 Hz wavelet
    np.testing.assert_allclose(ricker([-zero, zero], 2.0, 3.0), 0, atol=1e-15)
    trough = minimize_scalar(
        lambda t: float(ricker(t, 2.0, 3.0)), bounds=(zero, 0.5), method="bounded"
    )
    assert trough.fun == pytest.approx(-3.0 * 2 * np.exp(-1.5), rel=1e-9)
    velocity, lobe = (2 * quad(ricker, 0, end, args=(2.0, 1.0))[0] for end in (2.0, zero))
    assert abs(velocity) < 1e-9 * lobe
