"""The response to the shipped record, beside the event-driven solver, which shares no code."""

import numpy as np
import pytest
from experimental_style import WALL
from repository import ROOT

from rockdamp.histories.loads import make_load, sample_load
from rockdamp.histories.respond import respond
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.record import Record
from rockdamp.motions.record_file import read_record
from rockdamp.solvers.exact import exact_history

CURVE = TrilinearCurve(0.03, 0.80)
DAMPING = Damping("CR", 0.835)


@pytest.fixture(scope="module")
def record():
    return read_record(ROOT / "data/sin-03-00-synthetic.csv")


def test_response_tends_to_the_exact_one(record):
    """Second order, erratic in a single history: a quarter of the step at least halves it."""
    load = sample_load(make_load(WALL, record, substeps=64))
    tau = float(WALL.frequency_parameter) * record.elapsed
    exact = exact_history(CURVE, DAMPING, tau, **load).displacement
    errors = []
    for step in (0.0025, 0.01):
        response = respond(WALL, CURVE, DAMPING, record, step=step)
        errors.append(float(np.abs(response["displacement"] - exact).max()))
    fine, coarse = errors
    assert fine < 0.5 * coarse
    assert fine < 1e-3 * np.abs(exact).max()


def test_record_with_a_response_is_a_spline(record):
    """A motion without a measured response is taken as straight between its samples."""
    straight = Record(record.elapsed, record.ground_acceleration)
    peaks = [float(respond(WALL, CURVE, DAMPING, motion)["peak"]) for motion in (record, straight)]
    assert 1e-3 < 1 - peaks[1] / peaks[0] < 5e-3
