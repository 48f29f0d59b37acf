"""One CDC wall by OpenSeesPy and by rockdamp: time of a step, and time for the same error."""

from __future__ import annotations

import time

import numpy as np
import openseespy.opensees as ops
from walls import record

from rockdamp import Damping, Load, TrilinearCurve, exact_history, simulate

CURVE = TrilinearCurve(0.06, 0.75, 0.95)
XI = 0.03
SAMPLES = 400
SAMPLING = 0.05  # of the record, in tau
GROUND = 0.8 * record(SAMPLES + 1, SAMPLING)
ERROR = 1e-4  # largest allowed error of the displacements at the samples [u/u_ins]


def set_up() -> None:
    """Set up the wall in OpenSees: unit mass, average acceleration, Newton's iterations."""
    corners = [CURVE.yield_displacement_ratio, CURVE.plateau_end, CURVE.ultimate_displacement_ratio]
    b1 = float(CURVE.strength_ratio)
    strains = [0.0, *map(float, corners), 100.0]  # the last, beyond any displacement
    stresses = [0.0, b1, b1, 0.0, 0.0]
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0)
    ops.fix(1, 1)
    ops.mass(2, 1.0)
    mirrored = [[-value for value in values[:0:-1]] + values for values in (strains, stresses)]
    ops.uniaxialMaterial(
        "ElasticMultiLinear", 1, 0.0, "-strain", *mirrored[0], "-stress", *mirrored[1]
    )
    ops.uniaxialMaterial("Viscous", 2, 2 * XI * float(CURVE.initial_frequency), 1.0)
    ops.uniaxialMaterial("Parallel", 3, 1, 2)
    ops.element("zeroLength", 1, 1, 2, "-mat", 3, "-dir", 1)
    ops.timeSeries("Path", 1, "-dt", SAMPLING, "-values", *GROUND.tolist(), "-factor", -1.0)
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ops.setNodeAccel(2, 1, float(GROUND[0]), "-commit")
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", 1e-10, 50)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")


def opensees_history(substeps: int) -> np.ndarray:
    """Return the displacements at the samples, shape (SAMPLES + 1,)."""
    set_up()
    displacement = [0.0]
    for _ in range(SAMPLES):
        assert ops.analyze(substeps, SAMPLING / substeps) == 0
        displacement.append(ops.nodeDisp(2, 1))
    return np.array(displacement)


def rockdamp_history(substeps: int) -> np.ndarray:
    """Return the displacements at the samples by rockdamp, shape (SAMPLES + 1,)."""
    load = Load(GROUND, 1.0, SAMPLING, substeps)
    return simulate(CURVE, Damping("CDC", XI), load=load, store_every=substeps).displacement


def steps_for_error(history, truth: np.ndarray) -> int:
    """Return the number of steps from which on the error stays below ERROR.

    The numbers of steps that are tried are SAMPLES times the powers of two.
    """
    counts = [2**k for k in range(10)]
    errors = [np.abs(history(count) - truth).max() for count in counts]
    last_bad = max(index for index, error in enumerate(errors) if error >= ERROR)
    return SAMPLES * counts[last_bad + 1]


def opensees_step() -> float:
    """Return the best seconds of one step, all steps in one call and without output."""
    best = np.inf
    substeps = 8
    for _ in range(5):
        set_up()
        start = time.process_time()
        assert ops.analyze(SAMPLES * substeps, SAMPLING / substeps) == 0
        best = min(best, time.process_time() - start)
    return best / (SAMPLES * substeps)


def rows(rockdamp_step: float) -> list[list[str]]:
    """Return the rows of the table; `rockdamp_step` is one wall's share of a step [s]."""
    times = SAMPLING * np.arange(SAMPLES + 1)
    truth = exact_history(
        CURVE, Damping("CDC", XI), times, load=GROUND, sampling=SAMPLING
    ).displacement
    rockdamp_steps = steps_for_error(rockdamp_history, truth)
    opensees_steps = steps_for_error(opensees_history, truth)
    step = opensees_step()
    return [
        ["a step of one CDC wall [ns]", f"{rockdamp_step * 1e9:.2f}", "", "", f"{step * 1e9:,.0f}"],
        [
            f"its history with errors below {ERROR:g} u_ins [µs]",
            f"{rockdamp_step * rockdamp_steps * 1e6:.1f}",
            "",
            "",
            f"{step * opensees_steps * 1e6:,.0f}",
        ],
    ]
