# ruff: noqa: F403, F405
"""A rocking block in Yade: without damping, with its local damping, and with ECD of order 16 at its joint.

Run it by `yade -n -x block.py`. A rigid clump stands on four balls. It is released from half of its instability.
Printed is sqrt(V) of each peak over the one before, which restitution of 0.85 would make 0.85.
"""

import math

from yade import *  # as Yade's scripts do

T, H, GRAVITY, E = 0.3, 1.5, 9.80665, 0.85  # thickness, height [m], restitution
MASS = 1800 * T * H
ALPHA = math.atan(T / H)  # the rotation at which it falls
INERTIA = MASS * (T * T + H * H) / 12
TURNING = INERTIA + MASS * (T * T + H * H) / 4  # about a foot: T is this times the rate squared over two
RELEASE, STEP, BALL = 0.5 * ALPHA, 2e-5, 0.02
AMPLITUDE = 2 * -math.log(E) / math.pi * 3.680970  # 2 xi N_16


def curve(rotation):
    """Return abs(M) [N m] and V [J]: two springs that lift at THETA1, then the block about one foot."""
    z, strength = abs(rotation), MASS * GRAVITY * T / 2
    if z < THETA1:
        return strength / THETA1 * z, strength / THETA1 * z * z / 2
    moment = max(0.0, strength * (ALPHA - z) / (ALPHA - THETA1))
    return moment, strength * THETA1 / 2 + (strength + moment) / 2 * (min(z, ALPHA) - THETA1)


def rotation():
    axis, angle = (BLOCK.state.ori * UPRIGHT).toAxisAngle()
    return angle * axis[1]


def damp():
    """Apply the couple C v of the joint, before the block is moved."""
    moment, energy = curve(rotation())
    rate = BLOCK.state.angVel[1]
    kinetic = TURNING * rate * rate / 2
    if kinetic > 0:
        near = abs(rotation()) < THETA1
        w = math.sqrt(MASS * GRAVITY * T / 2 / THETA1 * TURNING) if near else moment * math.sqrt(TURNING / (2 * energy))
        q = AMPLITUDE * (kinetic / (kinetic + energy)) ** 16
        s = math.copysign(math.sqrt(kinetic * energy), rotation() * rate) / (kinetic + energy)
        c = w * q / (1 - q * s)
        O.forces.addT(BLOCK.id, Vector3(0, -c * rate, 0))


def look():
    HISTORY.append((rotation(), BLOCK.state.angVel[1]))


def run(local, order_m=False):
    """Return sqrt(V) of each of the first peaks over the one before."""
    global BLOCK, UPRIGHT, THETA1, HISTORY
    O.reset()
    O.materials.append(FrictMat(young=2e8, poisson=1.0, frictionAngle=1.3, density=1800, label="stone"))
    O.bodies.append(utils.box((0, 0, -0.1), (2, 2, 0.1), fixed=True, material="stone"))
    corners = [(x * T / 2, y * 0.4, z) for x in (-1, 1) for y in (-1, 1) for z in (BALL, H)]
    BLOCK = O.bodies[O.bodies.appendClumped([utils.sphere(at, BALL, material="stone") for at in corners])[0]]
    state = BLOCK.state
    state.mass, state.inertia, state.blockedDOFs = MASS, (INERTIA, INERTIA, INERTIA), "yXZ"
    newton = NewtonIntegrator(damping=0.8, gravity=(0, 0, -GRAVITY))
    contacts = InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom()],
        [Ip2_FrictMat_FrictMat_FrictPhys()],
        [Law2_ScGeom_FrictPhys_CundallStrack()],
    )
    collider = InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Box_Aabb()])
    O.engines, O.dt = [ForceResetter(), collider, contacts, newton], STEP
    O.run(int(0.3 / STEP), True)  # it settles
    stiffness = sum(contact.phys.kn for contact in O.interactions if contact.isReal) / 2  # of one side [N/m]
    THETA1, UPRIGHT, HISTORY = MASS * GRAVITY / (stiffness * T), state.ori.conjugate(), []
    foot, turn = Vector3(T / 2, 0, state.pos[2] - H / 2), Quaternion((0, 1, 0), RELEASE)
    state.pos, state.ori = foot + turn * (state.pos - foot), turn * state.ori
    state.vel = state.angVel = Vector3(0, 0, 0)
    newton.damping = local
    engines = [PyRunner(iterPeriod=1, command="damp()")] if order_m else []
    O.engines = [ForceResetter(), collider, contacts, *engines, newton, PyRunner(iterPeriod=20, command="look()")]
    O.run(int(2.5 / STEP), True)
    peaks = [RELEASE]
    for (_, before), (now, rate) in zip(HISTORY, HISTORY[1:], strict=False):
        if before * rate < 0 and now * peaks[-1] < 0 and abs(now) > 2 * THETA1:
            peaks.append(now)
    energies = [curve(peak)[1] for peak in peaks[:5]]
    return [math.sqrt(b / a) for a, b in zip(energies, energies[1:], strict=False)]


for name, local, order_m in (
    ("none", 0.0, False),
    ("local damping, tanh(-ln e)", math.tanh(-math.log(E)), False),
    ("local damping, 0.2", 0.2, False),
    ("order 16", 0.0, True),
):
    print(f"{name}:", *(f"{ratio:.3f}" for ratio in run(local, order_m)), flush=True)
