"""The energy that leaves a wall is what its damper takes, Eq. (14), or its impacts, Eq. (13)."""

import numpy as np
import pytest

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import solve
from rockdamp.vocabulary import VISCOUS_MODELS

CURVE = TrilinearCurve(0.06, 0.8)
LOAD = 0.4 * np.sin(np.arange(31) * 0.2 * 1.7 + 0.4)  # every 0.2 in tau


def left_over(damping, substeps, forced):
    """Largest energy that is not accounted for, over the most that the wall was given."""
    step, steps = 0.2 / substeps, 30 * substeps
    load = np.interp(np.arange(steps + 1) / substeps, np.arange(31), LOAD) if forced else np.zeros(steps + 1)
    options = {"ground_acceleration": LOAD, "load_factor": 1.0} if forced else {"release_amplitude": 0.6}
    run = solve(CURVE, damping, step=step, steps=steps, substeps=substeps, store_every=1, **options)
    x, v = run.displacement, run.velocity
    energy, rate = v**2 / 2 + CURVE.energy(x), damping.coefficient(CURVE, x, v) * v**2
    lost = np.append(0, np.cumsum(step * (rate[1:] + rate[:-1]) / 2))
    work = np.append(0, np.cumsum((load[1:] + load[:-1]) / 2 * np.diff(x)))
    return np.abs(energy[0] + work - lost - energy).max() / (energy[0] + work).max()


@pytest.mark.parametrize("forced", [False, True], ids=["free", "forced"])
@pytest.mark.parametrize("model", VISCOUS_MODELS)
def test_a_damper_takes_what_leaves_the_wall_to_second_order(model, forced):
    coarse, fine = (left_over(Damping(model, 0.05), substeps, forced) for substeps in (10, 80))
    assert fine < 2e-4 and np.log(coarse / fine) / np.log(8) > 1.5


@pytest.mark.parametrize("forced", [False, True], ids=["free", "forced"])
def test_a_wall_that_loses_nothing_keeps_its_energy_and_what_the_load_gives(forced):
    assert left_over(Damping.cr(1.0), 80, forced) < 2e-4


def test_each_impact_takes_one_less_e_squared_of_the_energy():
    run = solve(CURVE, Damping.cr(0.85), release_amplitude=0.6, step=0.0025, steps=4000, store_every=1)
    turns = np.flatnonzero(np.diff(np.sign(run.velocity[1:]))) + 1
    energy = CURVE.energy(run.displacement[turns])
    np.testing.assert_allclose(energy[1:6] / energy[:5], 0.85**2, rtol=1e-3)
