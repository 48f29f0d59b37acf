"""A CDC wall against OpenSees: the same wall in SI units, another program, another integration method.

OpenSees' averaged acceleration (Newmark 1/2, 1/4, with Newton's iterations) and the explicit scheme are both of second
order, so their difference must shrink with the square of the step. `make test-peers` runs this; OpenSeesPy's wheel
needs the system's BLAS and LAPACK.
"""

import numpy as np
import pytest
from peers import opensees

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Wall
from rockdamp.motions import catalogue
from rockdamp.solvers.newmark import Load, simulate

ops = opensees()

pytestmark = pytest.mark.peers

WALL = Wall(0.3, 4.5, overburden_ratio=0.5)
A1, B1, A3 = 0.06, 0.75, 0.95
CURVE = TrilinearCurve(A1, B1, A3)
DAMPING_RATIOS = (0.01, 0.03, 0.08)
SAMPLE, SAMPLES = 0.02, 151  # of the record [s]
ELAPSED = SAMPLE * np.arange(SAMPLES)
SUBSTEPS = 2 ** np.arange(2, 7)


def opensees_history(damping_ratio, release, ground, substeps, wall=WALL, curve=CURVE, sample=SAMPLE, samples=SAMPLES):
    """Displacements at the samples. [m]"""
    u_ins, strength = float(wall.instability_displacement), float(wall.rigid_strength)
    mass, b1 = float(wall.effective_mass), float(curve.strength_ratio)
    corners = [float(x) for x in (curve.yield_displacement_ratio, curve.plateau_end, curve.ultimate_displacement_ratio)]
    w1 = np.sqrt(b1 * strength / (corners[0] * u_ins) / mass)
    # The material goes on along its last slope: the far point keeps it at zero beyond the collapse.
    strain = np.array([0.0, *corners, 100.0]) * u_ins
    stress = np.array([0.0, b1, b1, 0.0, 0.0]) * strength
    law = ("-strain", *(-strain[:0:-1]), *strain, "-stress", *(-stress[:0:-1]), *stress)
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0)
    ops.fix(1, 1)
    ops.mass(2, mass)
    ops.uniaxialMaterial("ElasticMultiLinear", 1, 0.0, *law)
    ops.uniaxialMaterial("Viscous", 2, 2 * mass * w1 * damping_ratio, 1.0)
    ops.uniaxialMaterial("Parallel", 3, 1, 2)
    ops.element("zeroLength", 1, 1, 2, "-mat", 3, "-dir", 1)
    start = release * u_ins
    acceleration = -np.interp(start, strain, stress) / mass
    if ground is not None:
        ops.timeSeries("Path", 1, "-dt", sample, "-values", *ground, "-factor", wall.excitation_factor)
        ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
        acceleration -= wall.excitation_factor * ground[0]
    ops.setNodeDisp(2, 1, start, "-commit")
    ops.setNodeAccel(2, 1, acceleration, "-commit")
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", 1e-13 * u_ins, 50)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    found = [start]
    for _ in range(samples - 1):
        assert ops.analyze(substeps, sample / substeps) == 0
        found.append(ops.nodeDisp(2, 1))
    return np.array(found)


def rockdamp_histories(release, ground, substeps):
    """Displacements at the samples, for each damping ratio. [m]"""
    response = simulate(
        CURVE,
        Damping("CDC", DAMPING_RATIOS),
        release_amplitude=release,
        store_every=substeps,
        load=Load(
            () if ground is None else ground,
            WALL.load_factor,
            float(WALL.frequency_parameter) * SAMPLE / substeps * substeps,
            substeps,
        ),
    )
    return response.displacement * WALL.instability_displacement


def ricker():
    """A pulse that rocks the wall well beyond its plateau without collapse. [m s-2]"""
    s = (np.pi * 0.8 * (ELAPSED - 0.9)) ** 2
    return 0.88 * float(WALL.rigid_strength / WALL.mass) * (1 - 2 * s) * np.exp(-s)


@pytest.mark.parametrize("forced", [False, True], ids=["free", "forced"])
def test_the_difference_to_opensees_vanishes_with_the_square_of_the_step(forced):
    release, ground = (0.0, ricker()) if forced else (0.6, None)
    difference = []
    for substeps in SUBSTEPS.tolist():
        ours = rockdamp_histories(release, ground, substeps)
        theirs = [opensees_history(ratio, release, ground, substeps) for ratio in DAMPING_RATIOS]
        difference.append(np.sqrt(np.mean((ours - theirs) ** 2, axis=1)) / float(WALL.instability_displacement))
    assert 0.3 < np.abs(ours).max() / WALL.instability_displacement < A3
    typical = np.exp(np.log(difference).mean(axis=1))
    order = -np.polyfit(np.log(SUBSTEPS), np.log(typical), 1)[0]
    assert order == pytest.approx(2, abs=0.3)  # three histories only
    # Each errs by some fraction of (w1 step)^2.
    w1 = float(WALL.frequency_parameter) * np.sqrt(B1 / A1)
    assert np.max(difference[-1]) < (w1 * SAMPLE / SUBSTEPS[-1]) ** 2


@pytest.mark.parametrize(
    "name", ["far-field/1/a", "near-field-pulse/2/b", "near-field-no-pulse/16/a"], ids=lambda name: name.split("/")[0]
)
def test_peaks_under_earthquakes_agree_within_what_halving_the_steps_says(name):
    """As the study of earthquakes runs them: the record to its end and after, at every scale from rest to collapse."""
    motion = catalogue.load_records([f"fema-p695:{name}"])[0]
    step, ground = motion.record.step, motion.record.ground_acceleration
    wall, curve, ratio = Wall(0.25, 3.0, hinge_ratio=0.6, overburden_ratio=1.0), TrilinearCurve.preset("new"), 0.04
    u_ins, p = float(wall.instability_displacement), float(wall.frequency_parameter)
    velocity = p * u_ins / wall.excitation_factor / np.abs(np.cumsum(ground) * step).max()
    scales = np.array([0.2, 0.4, 0.7, 1.0]) * velocity
    substeps = int(np.ceil(p * step * float(curve.initial_frequency) / 0.05))

    def ours(substeps):
        found = simulate(
            curve,
            Damping("CDC", ratio),
            store_every=substeps,
            load=Load(ground, float(wall.load_factor) * scales, p * step / substeps * substeps, substeps),
        )
        return np.abs(found.displacement).max(axis=1), found.collapsed

    def theirs(substeps):
        found = [
            opensees_history(ratio, 0.0, scale * ground, substeps, wall, curve, step, ground.size) for scale in scales
        ]
        return np.abs(found).max(axis=1) / u_ins

    (coarse, _), (fine, outcome) = ours(substeps), ours(2 * substeps)
    coarse_peer, fine_peer = theirs(substeps), theirs(2 * substeps)
    stands = outcome == 0
    assert (fine[stands] > curve.yield_displacement_ratio).any() and (fine_peer[~stands] > 1).all()
    bound = np.abs(coarse - fine) + np.abs(coarse_peer - fine_peer) + 1e-3 * fine
    assert (np.abs(fine - fine_peer)[stands] <= bound[stands]).all()
