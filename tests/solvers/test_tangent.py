"""The derivative of a response by its ground motion, against differences of the response itself."""

import numpy as np
import pytest

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.tangent import derivative_by_motion

CURVE = TrilinearCurve(0.1, 0.7)
SAMPLES, SUBSTEPS, STEP, LOAD_FACTOR = 161, 20, 0.005, 0.4
TIME = np.arange(SAMPLES) * SUBSTEPS * STEP
DAMPERS = [Damping.cr(0.8), Damping("CDC", 0.05), Damping("SDR", 0.1), Damping.of_restitution(0.8, order=16)]


def at_steps(samples):
    from scipy.interpolate import CubicSpline

    return CubicSpline(np.arange(SAMPLES), samples)(np.arange((SAMPLES - 1) * SUBSTEPS + 1) / SUBSTEPS)


def response(damping, samples):
    ground = at_steps(samples)
    run = {"step": STEP, "steps": ground.size - 1, "load_factor": LOAD_FACTOR, "store_every": SUBSTEPS}
    return solve(CURVE, damping, ground_acceleration=ground, **run).displacement.reshape(-1)


@pytest.mark.parametrize("damping", DAMPERS, ids=lambda damping: damping.model)
def test_the_derivative_is_what_a_small_change_of_the_motion_does(damping):
    motion = 2.0 * np.exp(-((TIME - 3) ** 2)) * np.sin(2 * TIME)
    random = np.random.RandomState(4)
    # From a slow change to one from sample to sample.
    rough = np.where(
        abs(np.arange(SAMPLES) - 80) < 70, random.standard_normal(SAMPLES), 0.0
    )  # ends are splines of their own
    directions = np.stack([np.sin(TIME), rough, np.eye(SAMPLES)[60]])
    found = derivative_by_motion(
        CURVE,
        damping,
        directions,
        step=STEP,
        substeps=SUBSTEPS,
        load_factor=LOAD_FACTOR,
        ground_acceleration=at_steps(motion),
    )
    assert np.abs(response(damping, motion)).max() > 0.2  # beyond the first branch and with impacts
    for direction, derivative in zip(directions, found, strict=True):
        small = 2e-3 * direction / np.abs(direction).max()
        difference = (response(damping, motion + small) - response(damping, motion - small)) / 2
        scale = np.abs(difference).max()
        np.testing.assert_allclose(2e-3 / np.abs(direction).max() * derivative, difference, atol=0.02 * scale)
