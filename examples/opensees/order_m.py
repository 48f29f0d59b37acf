"""ECD of order m, the viscous damper that becomes restitution, in an OpenSees model. Copy this one file.

    pip install openseespy         # on Debian and Ubuntu also: apt-get install libblas3 liblapack3

`make_joint` adds a rocking joint to a model that has its two nodes: the elastic curve and, beside it, the damper.
`analyze` takes the place of `ops.analyze`: before each step it sets C(u, v) of every joint. Units are SI, or any
consistent ones; u may be a rotation [rad], with moments [N m] and a moment of inertia [kg m2]. `python order_m.py`
runs a wall that is released and a wall under a pulse.
"""

from dataclasses import dataclass
from math import comb, copysign, log, pi, sin, sqrt

import openseespy.opensees as ops


@dataclass
class Joint:
    """Rocking joint between two nodes of the model: its curve F(u), its mass and its damper."""

    tag: int
    nodes: tuple[int, int]
    dof: int
    corners: tuple[float, float, float]  # u1, u2, u3: ends of the first branch and the plateau, zero force [m]
    strength: float  # F of the plateau [N]
    mass: float  # of the mechanism, for a unit displacement u [kg]
    amplitude: float  # 2 xi N_m
    order: int

    def state(self):
        """Return u, v and a of the joint: those of the second node less those of the first."""
        i, j = self.nodes
        return [of(j, self.dof) - of(i, self.dof) for of in (ops.nodeDisp, ops.nodeVel, ops.nodeAccel)]

    def curve(self, u):
        """Return abs(F) [N], and the energy V [J] that the joint gives back when it closes."""
        (u1, u2, u3), f1, z = self.corners, self.strength, abs(u)
        if z < u1:
            return f1 / u1 * z, f1 / u1 * z * z / 2
        f = max(0.0, min(f1, f1 * (u3 - z) / (u3 - u2)))
        return f, f1 * u1 / 2 + f1 * (min(z, u2) - u1) + (f1 + f) / 2 * (min(z, u3) - min(z, u2))

    def coefficient(self, u, v):
        """Return C = abs(F) sqrt(m/(2 V)) q/(1 - q s), q = 2 xi N_m (T/(T + V))^m, s = sgn(u v) sqrt(T V)/(T + V).

        In N s/m. Order 0 has no s.
        """
        (f, energy), kinetic = self.curve(u), self.mass * v * v / 2
        if energy <= 0:  # at u = 0, abs(F) sqrt(m/(2 V)) is sqrt(k1 m)
            return self.amplitude * sqrt(self.strength / self.corners[0] * self.mass) if kinetic > 0 else 0.0
        q = self.amplitude * (kinetic / (kinetic + energy)) ** self.order
        s = copysign(sqrt(kinetic * energy), u * v) / (kinetic + energy) if self.order else 0.0
        return f * sqrt(self.mass / (2 * energy)) * q / (1 - q * s)


def make_joint(tag, nodes, dof, corners, strength, mass, restitution, order=16):
    """Add element `tag`, materials `tag` and `tag + 1`, and parameter `tag`: a joint along `dof` between two nodes.

    `corners` are u1, u2, u3 of the tri-linear curve [m], `strength` its plateau [N], `mass` that of the mechanism [kg].
    Beyond u3 the wall has collapsed: the force is zero, and nothing stops it.
    """
    if not (0 < corners[0] <= corners[1] < corners[2] and strength > 0 and mass > 0):
        raise ValueError(f"0 < u1 <= u2 < u3, strength > 0 and mass > 0, not {corners}, {strength}, {mass}")
    if not (0.2 <= restitution <= 1 and order == int(order) >= 0):
        raise ValueError(f"restitution e, no xi, from 0.2 to 1 and a whole order, not {restitution}, {order}")
    d = -log(restitution) / pi
    xi = d if order else d / sqrt(1 + d * d)
    amplitude = 2 * xi * 2 ** (2 * order + 1) / comb(2 * order + 2, order + 1)
    # The material goes on along its last slope: the far point keeps the force at zero beyond u3.
    u = [0.0, *corners, 1000 * corners[-1]]
    f = [0.0, strength, strength, 0.0, 0.0]
    law = ("-strain", *(-x for x in u[:0:-1]), *u, "-stress", *(-x for x in f[:0:-1]), *f)
    ops.uniaxialMaterial("ElasticMultiLinear", tag, 0.0, *law)
    ops.uniaxialMaterial("Viscous", tag + 1, 0.0, 1.0)
    ops.element("zeroLength", tag, *nodes, "-mat", tag, tag + 1, "-dir", dof, dof)
    ops.parameter(tag, "element", tag, "material", 2, "C")
    return Joint(tag, tuple(nodes), dof, tuple(corners), strength, mass, amplitude, order)


def analyze(joints, steps, dt):
    """Take `steps` steps of `dt` [s] as `ops.analyze` does; return what it returns, 0 for success."""
    for _ in range(steps):
        for joint in joints:
            u, v, a = joint.state()
            # C belongs to the balance at the end of the step: predict u and v there, which keeps second order.
            ops.updateParameter(joint.tag, joint.coefficient(u + dt * v + dt * dt / 2 * a, v + dt * a))
        if failed := ops.analyze(1, dt):
            return failed
    return 0


def demonstrate(dt=0.001):
    """Run a wall of 900 kg that is released, and the same wall under a pulse; print the peaks."""
    corners, strength, mass, e = (0.01, 0.04, 0.25), 4000.0, 900.0, 0.85
    for release in (0.12, 0.0):
        ops.wipe()
        ops.model("basic", "-ndm", 1, "-ndf", 1)
        ops.node(1, 0.0)
        ops.node(2, 0.0)
        ops.fix(1, 1)
        ops.mass(2, mass)
        joint = make_joint(1, (1, 2), 1, corners, strength, mass, e)
        if release:
            ops.setNodeDisp(2, 1, release, "-commit")
            ops.setNodeAccel(2, 1, -joint.curve(release)[0] / mass, "-commit")
        else:
            pulse = [5.0 * sin(pi * n * dt / 0.3) for n in range(round(0.3 / dt) + 1)]  # of the ground [m/s2]
            ops.timeSeries("Path", 1, "-dt", dt, "-values", *pulse, 0.0)
            ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
        ops.constraints("Plain")
        ops.numberer("Plain")
        ops.system("BandGeneral")
        ops.test("NormDispIncr", 1e-12, 50)
        ops.algorithm("Newton")
        ops.integrator("Newmark", 0.5, 0.25)
        ops.analysis("Transient")
        peaks, u, v = ([release] if release else []), 0.0, 0.0
        while len(peaks) < 5 and ops.getTime() < 30 and analyze([joint], 1, dt) == 0:
            before, (u, v, _) = v, joint.state()
            if before * v < 0:
                peaks.append(abs(u))
        print("released:" if release else "pulse:   ", *(f"{peak:.4f}" for peak in peaks), "m")
        if release:
            lost = [sqrt(joint.curve(b)[1] / joint.curve(a)[1]) for a, b in zip(peaks, peaks[1:], strict=False)]
            print("sqrt(V) of each peak over the one before:", *(f"{ratio:.4f}" for ratio in lost), f"; e is {e}")


if __name__ == "__main__":
    demonstrate()
