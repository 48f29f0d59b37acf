"""Write examples/my-test-raw.csv: raw channels as a laboratory's logger would have them, of the synthetic record.

`.venv/bin/python tools/raw_channels.py`. The table's displacement is the double integral of its pulse; the wall's
potentiometer stands on the ground. The accelerometer and the table's sensor have zeros of their own.
"""

from pathlib import Path

import numpy as np
from experimental_style import PULSE_CENTRE, PULSE_PEAK, synthetic_record

from rockdamp.motions.pulse_shapes import table_pulse
from rockdamp.vocabulary import STANDARD_GRAVITY

FILE = Path(__file__).resolve().parents[1] / "examples/my-test-raw.csv"
OFFSET, TABLE_ZERO = 0.012, 3.1  # of the accelerometer [g], of the table's sensor [mm]
FINE = 16  # steps of the integral between two samples


def text() -> str:
    """Return the file's lines."""
    record = synthetic_record()
    fine = np.linspace(record.elapsed[0], record.elapsed[-1], FINE * (record.elapsed.size - 1) + 1)
    step = fine[1] - fine[0]
    pulse = table_pulse(fine - PULSE_CENTRE, PULSE_PEAK)
    velocity = np.concatenate([[0.0], np.cumsum((pulse[1:] + pulse[:-1]) / 2) * step])
    moved = np.concatenate([[0.0], np.cumsum((velocity[1:] + velocity[:-1]) / 2) * step])
    table = 1000 * moved[::FINE]
    wall = 1000 * np.asarray(record.displacement) + table
    acceleration = record.ground_acceleration / STANDARD_GRAVITY + OFFSET
    rows = zip(record.elapsed, acceleration, wall, table + TABLE_ZERO, strict=True)
    lines = [f"{t:.8f},{a:.5f},{d1:.3f},{d2:.3f}" for t, a, d1, d2 in rows]
    return "\n".join(["# a wall like SIN-03-00, synthetic: s, g, mm, mm", "t,a,d1,d2", *lines]) + "\n"


if __name__ == "__main__":
    FILE.write_text(text(), encoding="utf-8")
