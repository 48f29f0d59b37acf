"""BAND, a damper of a rocking wall, in an OpenSees model. Copy this one file.

    pip install openseespy         # on Debian and Ubuntu also: apt-get install libblas3 liblapack3

`make_joint` adds a rocking joint to a model that has its two nodes: the elastic curve and, beside
it, the damper. `analyze` takes the place of `ops.analyze`: before each step it sets C(u, v) of
every joint. Units are SI, or any consistent ones; u may be a rotation [rad], with moments [N m] and
a moment of inertia [kg m2]. `python band.py` runs a wall under a half sine.
"""

from dataclasses import dataclass
from math import log, pi, sin, sqrt

import openseespy.opensees as ops


@dataclass
class Joint:
    """Damper of a rocking joint between two nodes of the model."""

    tag: int
    nodes: tuple[int, int]
    dof: int
    largest: float  # C at the crossing [N s/m]
    c: float  # half of the time that it acts [s]

    def state(self):
        """Return u, v and a of the joint: those of the second node less those of the first."""
        i, j = self.nodes
        return [
            of(j, self.dof) - of(i, self.dof) for of in (ops.nodeDisp, ops.nodeVel, ops.nodeAccel)
        ]

    def coefficient(self, u, v):
        """Return C [N s/m] at u [m] and v [m/s]."""
        r = min(abs(u) / max(self.c * abs(v), 1e-90), 1)
        return self.largest * (1 - r * r)


def make_joint(tag, nodes, dof, corners, strength, mass, restitution, t_c=0.2):
    """Add a joint along `dof` between two nodes.

    It has the element `tag`, the materials `tag` and `tag + 1`, and the parameter `tag`. `corners`
    are u1, u2, u3 of the tri-linear curve [m]: ends of the first branch, of the plateau, and zero
    force. `strength` is the plateau [N], `mass` that of the mechanism for a unit displacement [kg],
    `t_c` the half-width of the band [rad]. Beyond u3 the wall has collapsed: the force is zero, and
    nothing stops it.
    """
    if not (0 < corners[0] <= corners[1] < corners[2] and strength > 0 and mass > 0):
        raise ValueError(
            f"0 < u1 <= u2 < u3, strength > 0 and mass > 0, not {corners}, {strength}, {mass}"
        )
    if not (0.5 <= restitution <= 1 and 0 < t_c <= 0.4):
        raise ValueError(
            f"restitution from 0.5 to 1 and t_c up to 0.4 rad, not {restitution}, {t_c}"
        )
    d = -log(restitution)
    c = t_c / sqrt(strength / corners[0] / mass)
    band_strength = d * (1 + 0.4 * t_c**2 - 0.097 * t_c**4 - 0.043 * d**2)
    # The material goes on along its last slope: the far point keeps the force at zero beyond u3.
    u = [0.0, *corners, 1000 * corners[-1]]
    f = [0.0, strength, strength, 0.0, 0.0]
    law = ("-strain", *(-x for x in u[:0:-1]), *u, "-stress", *(-x for x in f[:0:-1]), *f)
    ops.uniaxialMaterial("ElasticMultiLinear", tag, 0.0, *law)
    ops.uniaxialMaterial("Viscous", tag + 1, 0.0, 1.0)
    ops.element("zeroLength", tag, *nodes, "-mat", tag, tag + 1, "-dir", dof, dof)
    ops.parameter(tag, "element", tag, "material", 2, "C")
    return Joint(tag, tuple(nodes), dof, mass * 3 * band_strength / (4 * c), c)


def analyze(joints, steps, dt):
    """Take `steps` steps of `dt` [s], at most c/4; return 0 for success, as `ops.analyze` does."""
    for _ in range(steps):
        for joint in joints:
            u, v, a = joint.state()
            # C belongs to the balance at the end of the step: predict u and v there, which keeps
            # second order.
            ops.updateParameter(
                joint.tag, joint.coefficient(u + dt * v + dt * dt / 2 * a, v + dt * a)
            )
        if failed := ops.analyze(1, dt):
            return failed
    return 0


def peak_of_half_sine(dt=0.001):
    """Return the first peak of a wall under 2 sin(pi t/0.7), from rest.

    The wall is dimensionless, with a1 = 0.04, b1 = 0.85 and e = 0.85.
    """
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0)
    ops.fix(1, 1)
    ops.mass(2, 1.0)
    joint = make_joint(1, (1, 2), 1, (0.04, 0.15, 1.0), 0.85, 1.0, 0.85)
    ground = [-2 * sin(pi * n * dt / 0.7) for n in range(round(0.7 / dt))]
    ops.timeSeries("Path", 1, "-dt", dt, "-values", *ground, 0.0)
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", 1e-12, 50)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    peak = 0.0
    while ops.getTime() < 2 and analyze([joint], 1, dt) == 0:
        peak = max(peak, joint.state()[0])
    return peak


if __name__ == "__main__":
    print(f"first peak {peak_of_half_sine():.4f}; under restitution it is 0.400")
