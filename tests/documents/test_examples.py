"""The programs of `examples` that make records."""

import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
from repository import ROOT

import rockdamp as rd


def test_raw_channels_become_a_record(tmp_path):
    """The noise of 100 Hz is gone, the wall is relative to the table, and zeros are those of the
    rest.
    """
    elapsed = np.arange(1024) / 256
    shaken = np.sin(4 * np.pi * elapsed) * np.exp(-(((elapsed - 2) / 0.4) ** 2))
    noise = 0.01 * np.sin(200 * np.pi * elapsed)
    channels = {
        "t": elapsed,
        "a": 0.5 * shaken + noise + 0.012,
        "wall": 30 * shaken + 5,
        "table": 10 * shaken + 3.1,
    }
    pd.DataFrame(channels).to_csv(tmp_path / "raw.csv", index=False)
    files = [str(tmp_path / name) for name in ("raw.csv", "test.csv")]
    subprocess.run([sys.executable, str(ROOT / "examples/raw_channels.py"), *files], check=True)
    record = rd.read_record(files[1])
    np.testing.assert_allclose(record.elapsed, elapsed, atol=1e-12)
    inside = slice(50, -50)
    np.testing.assert_allclose(
        record.ground_acceleration[inside], 0.5 * 9.80665 * shaken[inside], atol=1e-3
    )
    np.testing.assert_allclose(record.displacement[inside], 0.02 * shaken[inside], atol=1e-6)


ESM = "STATION_CODE: X\nSAMPLING_INTERVAL_S: 0.010000\nUNITS: cm/s^2\n0.0\n-150.0\n25.0\n"
KNET = (
    "Origin Time       2011/03/11 14:46:00\nSampling Freq(Hz) 100Hz\nScale Factor      2000(gal)/8000000\nMemo.\n"
    "    1000     4000\n   -2000\n"
)
V2 = (
    "Corrected accelerogram\n    3 points of accel data equally spaced at  .010 sec, in cm/sec2. (UNITS)\n"
    "     .000  -150.000    25.000\n    3 points of veloc data equally spaced at  .010 sec, in cm/sec.\n 1.0 2.0 3.0\n"
)


@pytest.mark.parametrize(
    ("name", "text", "expected", "written"),
    [
        ("a.ASC", ESM, [0.0, -1.5, 0.25], "a.csv"),
        ("a.V2", V2, [0.0, -1.5, 0.25], "a.V2.csv"),
        (
            "a.EW",
            KNET,
            [0.0, 0.0075, -0.0075],
            "a.EW.csv",
        ),  # a mean of 1000 counts, each 2.5e-6 m s-2
    ],
)
def test_records_of_networks_are_converted(tmp_path, name, text, expected, written):
    (tmp_path / name).write_text(text, encoding="utf-8")
    command = [sys.executable, str(ROOT / "examples/convert_records.py"), str(tmp_path / name)]
    assert subprocess.run(command, capture_output=True, check=False).returncode == 0
    record = rd.read_record(tmp_path / written)
    np.testing.assert_allclose(record.ground_acceleration, expected, atol=1e-15)
    assert record.step == pytest.approx(0.01)
    other = text.replace("UNITS", "UNIT").replace("Scale", "Scales").replace("3 points", "4 points")
    (tmp_path / name).write_text(other, encoding="utf-8")
    refused = subprocess.run(command, capture_output=True, check=False, text=True)
    assert refused.returncode == 1 and (
        "no record of ESM" in refused.stderr or "states 4" in refused.stderr
    )
