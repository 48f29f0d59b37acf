"""The programs of `examples` that make records."""

import runpy
import sys

import numpy as np
import pandas as pd
import pytest
from repository import ROOT

import rockdamp as rd
from rockdamp.constants import STANDARD_GRAVITY


@pytest.fixture
def run_example(monkeypatch):
    """Run a program of `examples` as from the command line."""

    def run_example(name, *arguments):
        monkeypatch.setattr(sys, "argv", [name, *map(str, arguments)])
        runpy.run_path(str(ROOT / "examples" / name), run_name="__main__")

    return run_example


def test_raw_channels_become_a_record(tmp_path, run_example):
    """The program removes offsets and noise, and takes the table's motion from the wall's."""
    elapsed = np.arange(1024) / 256
    motion = np.sin(4 * np.pi * elapsed) * np.exp(-(((elapsed - 2) / 0.4) ** 2))
    noise = 0.01 * np.sin(200 * np.pi * elapsed)
    channels = {
        "t": elapsed,
        "a": 0.5 * motion + noise + 0.012,
        "wall": 30 * motion + 5,
        "table": 10 * motion + 3.1,
    }
    pd.DataFrame(channels).to_csv(tmp_path / "raw.csv", index=False)
    run_example("raw_channels.py", tmp_path / "raw.csv", tmp_path / "test.csv")
    record = rd.read_record(tmp_path / "test.csv")
    np.testing.assert_allclose(record.elapsed, elapsed, atol=1e-12)
    inner = slice(50, -50)  # the filter is less accurate at the ends
    acceleration = 0.5 * STANDARD_GRAVITY * motion
    np.testing.assert_allclose(record.ground_acceleration[inner], acceleration[inner], atol=1e-3)
    np.testing.assert_allclose(record.displacement[inner], 0.02 * motion[inner], atol=1e-6)


ESM = """\
STATION_CODE: X
SAMPLING_INTERVAL_S: 0.010000
UNITS: cm/s^2
0.0
-150.0
25.0
"""
KNET = """\
Origin Time       2011/03/11 14:46:00
Sampling Freq(Hz) 100Hz
Scale Factor      2000(gal)/8000000
Memo.
    1000     4000
   -2000
"""
V2 = """\
Corrected accelerogram
    3 points of accel data equally spaced at  .010 sec, in cm/sec2. (UNITS)
     .000  -150.000    25.000
    3 points of veloc data equally spaced at  .010 sec, in cm/sec.
 1.0 2.0 3.0
"""


@pytest.mark.parametrize(
    ("name", "text", "expected", "converted_name"),
    [
        ("a.ASC", ESM, [0.0, -1.5, 0.25], "a.csv"),
        ("a.V2", V2, [0.0, -1.5, 0.25], "a.V2.csv"),
        # A count is 2.5e-6 m s-2, and the mean is 1000 counts.
        ("a.EW", KNET, [0.0, 0.0075, -0.0075], "a.EW.csv"),
    ],
    ids=["ESM", "CSMIP", "K-NET"],
)
def test_network_record_is_converted(tmp_path, run_example, name, text, expected, converted_name):
    (tmp_path / name).write_text(text, encoding="utf-8")
    run_example("convert_records.py", tmp_path / name)
    record = rd.read_record(tmp_path / converted_name)
    np.testing.assert_allclose(record.ground_acceleration, expected, atol=1e-15)
    assert record.step == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.ASC", ESM.replace("UNITS", "UNIT"), "no record of ESM"),
        ("a.EW", KNET.replace("Scale", "Scales"), "no record of ESM"),
        ("a.V2", V2.replace("3 points", "4 points"), "states 4"),
    ],
    ids=["ESM", "K-NET", "CSMIP"],
)
def test_unreadable_network_record_is_refused(tmp_path, run_example, name, text, message):
    (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(SystemExit, match=message):
        run_example("convert_records.py", tmp_path / name)
    assert [path.name for path in tmp_path.iterdir()] == [name]
