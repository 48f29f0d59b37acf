"""A two-storey elastic frame with a rocking wall between its floors; run it beside `band.py`.

The wall spans from the first floor to the roof: two bodies, pinned at the floors, and the joint
between them at mid-height, which turns. Its numbers are those of a wall 0.25 m thick, 3 m high and
1 m wide, of 1800 kg/m3: in a model of several parts the joint carries the *physical* moment.
"""

from math import pi, sin

import openseespy.opensees as ops
from band import analyze, make_joint

T = 0.25  # thickness [m]
H = 3.0  # height [m]
R = 0.5  # height of the hinge over that of the wall
DENSITY = 1800.0  # [kg/m3]
E = 0.85  # restitution
MASS = DENSITY * T * H  # of one metre of wall [kg]
# The wall as an oscillator of one coordinate u: instability displacement [m] and strength [N].
U_INS = T
STRENGTH = 2 * MASS * 9.80665 * T / (R * H)
A1 = 0.04
B1 = 0.85
# Turning of the joint for a unit displacement of the hinge, and the moment of half the force: the
# oscillator has the mass 2 m/3 and the force F, twice what the coordinate u of the real bodies has.
TURN = 1 / (R * H) + 1 / ((1 - R) * H)  # [rad/m]
CORNERS = tuple(TURN * x * U_INS for x in (A1, 1 - B1, 1.0))  # [rad]
MOMENT = B1 * STRENGTH / 2 / TURN  # of the plateau [N m]
INERTIA = MASS / 3 / TURN**2  # of the mechanism for a unit *relative* rotation [kg m2]
# Nodes: the frame, then the wall, whose joint turns between LOWER and UPPER.
BASE = 1
FLOORS = (2, 3)
FOOT = 4
LOWER = 5
UPPER = 6
HEAD = 7
JOINT = 100  # its element


def build(ground, dt, storey_period=0.3, restitution=E):
    """Make the frame and the wall under `ground` [m/s2], sampled at `dt` [s]; return the joint."""
    floor_mass = 20000.0
    stiffness = floor_mass * (2 * pi / storey_period) ** 2  # of a storey [N/m]
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    heights = {
        BASE: 0.0,
        2: H,
        3: 2 * H,
        FOOT: H,
        LOWER: H * (1 + R),
        UPPER: H * (1 + R),
        HEAD: 2 * H,
    }
    for node, y in heights.items():
        ops.node(node, 0.0, y)
    ops.fix(BASE, 1, 1, 1)
    for floor in FLOORS:  # which move sideways and stay level
        ops.fix(floor, 0, 1, 1)
        ops.mass(floor, floor_mass, 0.0, 0.0)
    ops.geomTransf("Linear", 1)
    columns = (
        0.3,
        3e10,
        stiffness * H**3 / 12 / 3e10,
        1,
    )  # area, modulus of elasticity, second moment, transformation
    bodies = (T, 3e10, T**3 / 12, 1)  # nearly rigid; their bending belongs to a1 of the curve
    for storey, ends in enumerate(((BASE, 2), (2, 3)), start=1):
        ops.element("elasticBeamColumn", storey, *ends, *columns)
    ops.region(
        1, "-ele", 1, 2, "-rayleigh", 0.0, 0.0, 0.02 * storey_period / pi, 0.0
    )  # of the frame alone
    # A sixth of a body's mass at each end and two thirds in its middle have the inertia of a rod.
    for tag, (below, above), share in ((11, (FOOT, LOWER), R), (13, (UPPER, HEAD), 1 - R)):
        ops.node(tag, 0.0, (heights[below] + heights[above]) / 2)
        for node, part in ((below, 1 / 6), (tag, 2 / 3), (above, 1 / 6)):
            ops.mass(node, *(part * share * MASS,) * 2, 0.0)
        ops.element("elasticBeamColumn", tag, below, tag, *bodies)
        ops.element("elasticBeamColumn", tag + 1, tag, above, *bodies)
    # Stiff springs for pins: under UniformExcitation `equalDOF` was right with Plain constraints
    # and wrong with Transformation; the mass of elements was loaded twice (OpenSees 3.7.1).
    ops.uniaxialMaterial("Elastic", 1, 1e10)
    for tag, ends in ((21, (2, FOOT)), (22, (LOWER, UPPER)), (23, (HEAD, 3))):  # pins
        ops.element("zeroLength", tag, *ends, "-mat", 1, 1, "-dir", 1, 2)
    joint = make_joint(JOINT, (LOWER, UPPER), 3, CORNERS, MOMENT, INERTIA, restitution)
    ops.timeSeries("Path", 1, "-dt", dt, "-values", *ground, 0.0)
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", 1e-11, 50)
    ops.algorithm("Newton")
    # The joint turns two nodes without rotational mass. Newmark (1/2, 1/4) never damps the noise of
    # their velocities, and the damper then acts at the wrong moment: a little algorithmic damping
    # keeps it right.
    ops.integrator("HHT", 0.7)
    ops.analysis("Transient")
    return joint


def run(ground, dt, steps, **options):
    """Return the histories of u of the hinge [m] and the floors' accelerations [m/s2]."""
    joint, rows = build(ground, dt, **options), []
    for n in range(steps):
        if analyze([joint], 1, dt):
            raise RuntimeError(f"OpenSees stopped at {n * dt:g} s")
        floors = [
            ops.nodeAccel(floor, 1) + (ground[n + 1] if n + 1 < len(ground) else 0.0)
            for floor in FLOORS
        ]
        rows.append((joint.state()[0] / TURN, *floors))
    return [list(column) for column in zip(*rows, strict=True)]


if __name__ == "__main__":
    dt = 0.001
    ground = [1.5 * sin(pi * n * dt / 0.4) for n in range(801)]
    u, *floors = run(ground, dt, 6000)
    print(
        f"largest displacement of the hinge {max(map(abs, u)):.4f} m, of {U_INS} m at instability"
    )
    print(
        "largest accelerations of the floors:", *(f"{max(map(abs, a)):.2f}" for a in floors), "m/s2"
    )
    peaks = [
        b
        for a, b, c in zip(u, u[1:], u[2:], strict=False)
        if abs(b) > max(abs(a), abs(c)) and abs(b) > 0.001
    ]
    print("peaks of the hinge:", *(f"{peak:.4f}" for peak in peaks[:8]), "m")
