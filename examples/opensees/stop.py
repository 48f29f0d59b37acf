"""A wall that rocks to one side, against a stop, in an OpenSees model, by shipped materials alone. Copy this one file.

    pip install openseespy         # on Debian and Ubuntu also: apt-get install libblas3 liblapack3

`make_wall` adds the wall's curve between two nodes, and `make_stop` the stop that takes restitution: a spring with a
dashpot, which act in compression alone. A contact without tension (ENT) stands between the wall and the stop's own
node, so that the dashpot damps nothing while the wall is away. Units are SI, or any consistent ones. Analyze with steps
of at most 0.1 sqrt(m/kc). `python stop.py` runs a facade that is released.
"""

from math import acos, acosh, log, sqrt

import openseespy.opensees as ops

STIFFEST = 1e4  # the contact's stiffness over the stop's


def damping_ratio(restitution):
    """Return xi of a stop that cannot pull, on which an impact takes e, from 0.05 to 1."""
    delta, low, high = -log(restitution), 0.0, 2.0 / restitution
    for _ in range(60):
        xi = (low + high) / 2
        if xi < 1:
            loss = 2 * xi * acos(xi) / sqrt(1 - xi * xi)
        else:
            loss = 2 * xi * acosh(xi) / sqrt(xi * xi - 1) if xi > 1 else 2.0
        low, high = (xi, high) if loss < delta else (low, xi)
    return (low + high) / 2


def make_wall(tag, nodes, dof, corners, strength):
    """Add element and material `tag`: the force that closes the wall, of u > 0 alone, along `dof` from node to node.

    `corners` are u1, u2, u3 of the tri-linear curve [m], `strength` its plateau [N]. Beyond u3 the wall has collapsed.
    """
    u1, u2, u3 = corners
    u = [-1000 * u3, 0.0, u1, u2, u3, 1000 * u3]  # the material goes on along its last slope
    f = [0.0, 0.0, strength, strength, 0.0, 0.0]
    ops.uniaxialMaterial("ElasticMultiLinear", tag, 0.0, "-strain", *u, "-stress", *f)
    ops.element("zeroLength", tag, *nodes, "-mat", tag, "-dir", dof)


def make_stop(tag, nodes, own, dof, stiffness, mass, restitution):
    """Add elements `tag` and `tag + 1`, materials `tag` to `tag + 2`: a stop between two nodes, and `own`, its node.

    The stop is at the first node and the wall at the second, with the same coordinates; `own`, a third node there, has
    no mass and must be free along `dof` alone. `stiffness` is kc [N/m], 2500 times that of the first branch in place of
    a rigid stop; `mass` is that of the wall for a unit displacement u [kg].
    """
    if not (stiffness > 0 and mass > 0 and 0.05 <= restitution <= 1):
        raise ValueError(f"stiffness and mass > 0, restitution from 0.05 to 1, not {stiffness}, {mass}, {restitution}")
    ops.uniaxialMaterial("Elastic", tag, stiffness)
    ops.uniaxialMaterial("Viscous", tag + 1, 2 * damping_ratio(restitution) * sqrt(stiffness * mass), 1.0)
    ops.uniaxialMaterial("ENT", tag + 2, STIFFEST * stiffness)
    ops.element("zeroLength", tag, nodes[0], own, "-mat", tag, tag + 1, "-dir", dof, dof)
    ops.element("zeroLength", tag + 1, own, nodes[1], "-mat", tag + 2, "-dir", dof)


def build(corners, strength, mass, stiffness, restitution, release=0.0):
    """Make a facade of one node against its stop; node 2 is the wall."""
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    for node in (1, 2, 3):
        ops.node(node, 0.0)
    ops.fix(1, 1)
    ops.mass(2, mass)
    make_wall(1, (1, 2), 1, corners, strength)
    make_stop(2, (1, 2), 3, 1, stiffness, mass, restitution)
    if release:
        ops.setNodeDisp(2, 1, release, "-commit")
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("BandGeneral")
    ops.test("NormUnbalance", 1e-7 * strength, 100)
    ops.algorithm("Newton")
    ops.integrator("HHT", 0.9)  # the stop's node has no mass: a scheme without any damping lets its velocity ring
    ops.analysis("Transient")


def demonstrate():
    """Release a facade, and print sqrt(V) of each peak over the one before: it is e."""
    corners, strength, mass, e = (0.02, 0.10, 0.60), 4000.0, 2000.0, 0.5
    stiffness = 2500 * strength / corners[0]
    build(corners, strength, mass, stiffness, e, release=0.2)
    dt, peaks, u, v = 0.05 * sqrt(mass / stiffness), [0.2], 0.2, 0.0
    while len(peaks) < 4 and ops.analyze(1, dt) == 0:
        before, u, v = v, ops.nodeDisp(2, 1), ops.nodeVel(2, 1)
        if before > 0 >= v and u > 0:
            peaks.append(u)
    print("peaks", *(f"{peak:.5f}" for peak in peaks), "m")


if __name__ == "__main__":
    demonstrate()
