"""How the samples of a motion are joined: one rule for the motion of a test, another for an accelerogram alone."""

from dataclasses import replace

import numpy as np
import pytest
from experimental_style import WALL

import rockdamp as rd
from rockdamp.histories.loads import Forcing
from rockdamp.histories.measured_test import computed_response
from rockdamp.laboratory.least_squares import RecordFit
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.pulses import ricker
from rockdamp.motions.record import Record
from rockdamp.solvers.exact import exact_history

CURVE, DAMPING, STEP = TrilinearCurve(0.03, 0.80), Damping("CR", 0.835), 0.0025


def test_record(rate, displacement=True):
    """A quick pulse, 5 Hz, sampled at a rate [Hz]; with a response it is a test's."""
    elapsed = np.arange(int(2 * rate) + 1) / rate
    motion = ricker(elapsed - 1.0, 5.0, 20.0)
    return Record(elapsed, motion, np.zeros(elapsed.size) if displacement else None)


test_record.__test__ = False


def peak(record):
    return float(computed_response(record, WALL, CURVE, DAMPING, STEP).peak)


def test_the_motion_of_a_test_is_smooth_between_its_samples():
    """Sampled at 64 Hz the spline leads where 4096 Hz lead; straight lines cut the pulse's peak off."""
    true = peak(test_record(4096, displacement=False))
    assert peak(test_record(64)) == pytest.approx(true, rel=2e-3)
    assert abs(peak(test_record(64, displacement=False)) / true - 1) > 0.01


def test_one_motion_moves_the_wall_alike_in_every_use_of_a_test():
    record = test_record(128)
    record = replace(record, displacement=np.r_[np.zeros(100), 1e-3 * np.ones(record.elapsed.size - 100)])
    fit = RecordFit.from_record(record, WALL, ultimate_displacement_ratio=1.0, softening="steeper", step=STEP)
    forcing = Forcing.from_record(WALL, record)
    np.testing.assert_allclose(forcing.newmark(forcing.substeps(STEP))["ground_acceleration"], fit.motion, atol=1e-12)
    response = rd.respond(WALL, CURVE, DAMPING, record, step=STEP)
    assert float(response.peak_displacement) == pytest.approx(peak(record) * float(WALL.instability_displacement))


def test_an_accelerogram_alone_is_linear_between_its_samples():
    record = test_record(64, displacement=False)
    assert float(rd.respond(WALL, CURVE, DAMPING, record).peak_displacement) > 0
    arguments = Forcing.from_record(WALL, record).newmark(5)
    assert arguments["substeps"] == 5
    np.testing.assert_array_equal(arguments["ground_acceleration"], record.ground_acceleration)


def test_both_solvers_follow_the_same_smooth_motion():
    record = test_record(64)
    forcing = Forcing.from_record(WALL, record, tail=0.5)
    end = float(forcing.sampling) * forcing.intervals
    history = exact_history(CURVE, DAMPING, [end], **forcing.event_driven())
    assert np.abs(history.turning_displacement).max() == pytest.approx(peak(record), rel=1e-3)
