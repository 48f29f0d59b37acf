"""Records of accelerations that a test states."""

import numpy as np

from rockdamp.motions.record import Record


def record(acceleration, step=0.01):
    return Record(step * np.arange(len(acceleration)), np.asarray(acceleration, dtype=float))


def sine(amplitude=2.0, period=0.5, cycles=4, points=1000):
    phase = 2 * np.pi * np.arange(cycles * points + 1) / points
    return record(amplitude * np.sin(phase), period / points)
