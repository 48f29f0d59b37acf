"""OpenSees' `damping SecStif`: proportional to the tangent, not to the secant, of a rocking wall's curve.

`make test-peers` runs this. Its source has the force beta (q - q_committed)/dt, q the element's force.
"""

import numpy as np
import pytest
from peers import opensees

from rockdamp.mechanics.curve import TrilinearCurve

ops = opensees()

pytestmark = pytest.mark.peers

A1, B1, A2, A3 = 0.04, 0.85, 0.15, 1.0  # of the paper's curve; unit mass, dimensionless
CURVE = TrilinearCurve(A1, B1)
BETA, STEP, STEPS = 0.01, 1e-4, 9000


def launched(beta):
    """Return x and v of a wall that leaves x = 0 fast enough to come far down the softening branch."""
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0)
    ops.fix(1, 1)
    ops.mass(2, 1.0)
    strain, stress = np.array([0.0, A1, A2, A3, 100.0]), np.array([0.0, B1, B1, 0.0, 0.0])
    law = ("-strain", *(-strain[:0:-1]), *strain, "-stress", *(-stress[:0:-1]), *stress)
    ops.uniaxialMaterial("ElasticMultiLinear", 1, 0.0, *law)
    damped = ()
    if beta:
        ops.damping("SecStif", 1, beta)
        damped = ("-damp", 1)
    ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1, *damped)
    ops.setNodeVel(2, 1, 0.93, "-commit")
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", 1e-13, 50)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    states = []
    for _ in range(STEPS):
        assert ops.analyze(1, STEP) == 0
        states.append((ops.nodeDisp(2, 1), ops.nodeVel(2, 1)))
    return np.array(states).T


def test_secstif_damps_nothing_on_the_plateau_and_feeds_energy_in_on_the_softening_branch():
    x, v = launched(BETA)
    assert x.max() > 0.5 and v.min() > 0
    energy = v**2 / 2 + CURVE.energy(x)
    on_plateau = energy[(x > A1 + 0.002) & (x < A2 - 0.002)]
    softening = energy[(x > A2 + 0.002) & (x < 0.5)]
    first_branch = 0.93**2 / 2 - on_plateau[0]
    assert first_branch > 0.01 * 0.93**2 / 2  # so that it does damp
    assert np.ptp(on_plateau) < 1e-3 * first_branch
    assert (np.diff(softening) > 0).all()
    # beta times the tangent, k1 on the first branch and -1 beyond the plateau, along the motion.
    k1 = B1 / A1
    speed = np.interp(A1 / 2, x, v)
    assert first_branch == pytest.approx(BETA * k1 * speed * A1, rel=0.01)
    part = (x > A2) & (x < 0.5)
    assert np.ptp(softening) == pytest.approx(BETA * np.trapezoid(v[part], x[part]), rel=0.02)
