"""The experimental-style record."""

import runpy
import sys

import experimental_style
import numpy as np
import pytest
from experimental_style import synthetic_record
from repository import ROOT
from rounded_texts import assert_shipped

from rockdamp.motions.records import read_record

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


def test_the_wall_rocks_to_a_third_of_instability_and_comes_to_rest(clean):
    u = (clean.displacement - experimental_style.SENSOR_ZERO) / U_INS
    assert 0.3 < np.abs(u).max() < 0.6
    assert np.count_nonzero(np.diff(np.sign(u[np.abs(u) > 0.02]))) >= 8  # half cycles of clear rocking
    assert np.abs(u[clean.elapsed < 0.6]).max() < 0.003
    assert np.abs(u[clean.elapsed > 4]).max() < 0.003
