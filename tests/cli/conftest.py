"""A record that the tests of commands share."""

import numpy as np
import pytest

import rockdamp as rd


@pytest.fixture
def record(tmp_path):
    """Two seconds of a pulse of 3 m s-2, sampled at 100 Hz, that comes to rest."""
    elapsed = 0.01 * np.arange(200)
    motion = np.where(elapsed < 0.4, 3 * np.sin(2 * np.pi * elapsed / 0.4), 0.0)
    rd.write_record(tmp_path / "pulse.csv", rd.Record(elapsed, motion, header={"synthetic": "yes"}))
    return tmp_path / "pulse.csv"
