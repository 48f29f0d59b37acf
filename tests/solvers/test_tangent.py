"""Derivatives of a response by its ground motion and by parameters, against differences of the response itself."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.tangent import derivatives

CURVE = TrilinearCurve(0.1, 0.7)
SAMPLES, SUBSTEPS, STEP, LOAD_FACTOR = 161, 20, 0.005, 0.4
TIME = np.arange(SAMPLES) * SUBSTEPS * STEP
MOTION = 2.0 * np.exp(-((TIME - 3) ** 2)) * np.sin(2 * TIME)
DAMPERS = [Damping.cr(0.8), Damping("CDC", 0.05), Damping("SDR", 0.1), Damping.of_restitution(0.8, order=16)]


def at_steps(samples):
    return CubicSpline(np.arange(SAMPLES), samples)(np.arange((SAMPLES - 1) * SUBSTEPS + 1) / SUBSTEPS)


def response(curve, damping, samples):
    ground = at_steps(samples)
    run = {"step": STEP, "steps": ground.size - 1, "load_factor": LOAD_FACTOR, "store_every": SUBSTEPS}
    return solve(curve, damping, ground_acceleration=ground, **run).displacement.reshape(-1)


def along(damping, motion, directions, sides=()):
    run = {"step": STEP, "substeps": SUBSTEPS, "load_factor": LOAD_FACTOR, "ground_acceleration": at_steps(motion)}
    return derivatives((CURVE, damping), directions, sides, **run)


@pytest.mark.parametrize("damping", DAMPERS, ids=lambda damping: damping.model)
def test_the_derivative_by_the_motion_is_what_a_small_change_of_it_does(damping):
    random = np.random.RandomState(4)
    # From a slow change to one from sample to sample; a spline is another one near its ends.
    rough = np.where(abs(np.arange(SAMPLES) - 80) < 70, random.standard_normal(SAMPLES), 0.0)
    directions = np.stack([np.sin(TIME), rough, np.eye(SAMPLES)[60]])
    found, _ = along(damping, MOTION, directions)
    assert np.abs(response(CURVE, damping, MOTION)).max() > 0.2  # beyond the first branch and with impacts
    for direction, derivative in zip(directions, found, strict=True):
        size = 2e-3 / np.abs(direction).max()
        more, less = (response(CURVE, damping, MOTION + sign * size * direction) for sign in (1, -1))
        np.testing.assert_allclose(2 * size * derivative, more - less, atol=0.02 * np.abs(more - less).max())


@pytest.mark.parametrize("damping", DAMPERS, ids=lambda damping: damping.model)
def test_the_derivative_by_a_parameter_is_what_a_little_more_of_it_does(damping):
    apart = 1e-4
    loss = "restitution" if damping.step_kind == "impact" else "damping_ratio"
    value, order = float(getattr(damping, loss)), {"order": 16} if damping.model == "ECD" else {}
    change = [Damping(damping.model, value + sign * apart, **order) for sign in (1, -1)]
    sides = [
        ((TrilinearCurve(0.1 + apart, 0.7), damping), (TrilinearCurve(0.1 - apart, 0.7), damping), 2 * apart),
        ((TrilinearCurve(0.1, 0.7 + apart), damping), (TrilinearCurve(0.1, 0.7 - apart), damping), 2 * apart),
        ((CURVE, change[0]), (CURVE, change[1]), 2 * apart),
    ]
    _, found = along(damping, MOTION, np.zeros((1, SAMPLES)), sides)
    for (more, less, width), derivative in zip(sides, found, strict=True):
        difference = (response(*more, MOTION) - response(*less, MOTION)) / width
        # But for samples at an impact, which is now before and now after them.
        assert np.quantile(np.abs(derivative - difference), 0.95) < 0.02 * np.abs(difference).max()


def test_impacts_before_a_motion_without_noise_add_nothing():
    """The spline through a short pulse rings before it, by less and less, and the wall with it through zero."""
    squared = (6 * (TIME - 10)) ** 2
    motion = 9.0 * (1 - 2 * squared) * np.exp(-squared)
    early = np.eye(SAMPLES)[[10, 40, 60]]
    found, _ = along(Damping.cr(0.8), motion, early)
    for direction, derivative in zip(early, found, strict=True):
        more, less = (response(CURVE, Damping.cr(0.8), motion + sign * 1e-3 * direction) for sign in (1, -1))
        assert np.abs(2e-3 * derivative).max() < np.abs(more - less).max()


def test_a_wall_that_collapses_has_no_derivatives():
    with pytest.raises(InputError, match="the wall collapses; derivatives are those of a response that does not end"):
        along(Damping.cr(0.9), 20 * MOTION, np.zeros((1, SAMPLES)))
