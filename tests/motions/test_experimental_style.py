"""The experimental-style record."""

import runpy
import sys

import experimental_style
import numpy as np
import pytest
import yaml
from experimental_style import synthetic_record
from repository import ROOT
from rounded_texts import assert_shipped

from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.errors import InputError
from rockdamp.motions.record import read_record

SHIPPED = ROOT / "data" / "sin-03-00-synthetic.csv"
U_INS = float(experimental_style.WALL.instability_displacement)


@pytest.fixture(scope="module")
def clean():
    return synthetic_record(noise=0)


# --- the shipped record


def test_the_shipped_record_is_what_the_generator_makes(tmp_path, monkeypatch):
    path = tmp_path / "made.csv"
    monkeypatch.setattr(sys, "argv", ["synthetic", str(path)])
    runpy.run_path(str(ROOT / "tools/experimental_style.py"), run_name="__main__")
    assert_shipped(path.read_text(encoding="utf-8"), SHIPPED.read_text(encoding="utf-8"))


def test_the_shipped_record_says_that_it_is_synthetic_whose_it_is_and_what_made_it():
    record = read_record(SHIPPED)
    assert record.synthetic
    assert record.header["licence"] == "CC0-1.0"
    assert {"specimen", "source", "units"} <= set(record.header)
    assert float(record.header["generator_strength_ratio"]) == experimental_style.STRENGTH_RATIO
    assert record.step == 1 / 256
    assert "sin-03-00-synthetic.csv,The rockdamp developers,CC0-1.0,yes" in (ROOT / "data/sources.csv").read_text()


# --- what the generator makes


def test_the_pulse_is_a_ricker_wavelet_of_2_hz_and_the_header_says_so(clean):
    assert clean.header["generator_pulse_frequency_hz"] == "2"
    peak, crossing = 1.35 * STANDARD_GRAVITY, 1 / (np.pi * 2.0 * np.sqrt(2))
    assert clean.ground_acceleration.max() == pytest.approx(peak, abs=5e-4)
    inside = clean.elapsed[clean.ground_acceleration > 0]
    assert np.ptp(inside) == pytest.approx(2 * crossing, abs=2 / 256)
    assert clean.ground_acceleration.min() == pytest.approx(-2 * np.exp(-1.5) * peak, rel=2e-3)


def test_the_wall_rocks_far_beyond_its_first_branch_and_comes_to_rest(clean):
    u = (clean.displacement - experimental_style.SENSOR_ZERO) / U_INS
    assert np.abs(u).max() == pytest.approx(0.145, abs=5e-4)
    assert np.count_nonzero(np.diff(np.sign(u[np.abs(u) > 0.02]))) >= 7  # half cycles of clear rocking
    assert np.abs(u[clean.elapsed < 0.6]).max() < 0.003
    assert np.abs(u[clean.elapsed > 4]).max() < 0.003


def test_the_caption_of_fig8_says_how_steep_the_peak_is_in_the_motion():
    captions = (ROOT / "src/rockdamp/report/figures.yaml").read_text(encoding="utf-8")
    caption = yaml.safe_load(captions)["fig8"]["caption"]
    for level, peak in ((1.30, "0.096"), (1.35, "0.145"), (1.40, "0.233")):
        made = synthetic_record(noise=0, pulse_peak=level * STANDARD_GRAVITY)
        reached = np.abs(made.displacement - experimental_style.SENSOR_ZERO).max() / U_INS
        assert f"{reached:.3f}" == peak
        assert peak in caption and f"{level:.2f}" in caption
    with pytest.raises(InputError, match="pulse_peak"):
        synthetic_record(noise=0, pulse_peak=1.45 * STANDARD_GRAVITY)
    assert "collapses at 1.45 g" in caption
