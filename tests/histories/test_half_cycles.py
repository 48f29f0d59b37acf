"""Crossings of zero, turning points and half cycles of stored histories."""

import numpy as np
import pytest

from rockdamp.histories.half_cycles import half_cycles, passes_zero, turning_points
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import simulate


def test_step_that_starts_at_zero_does_not_pass_it():
    u = np.array([0.0, 1.0, 0.5, 0.0, -0.5, -0.1, 0.2, np.nan, 0.3])
    assert np.flatnonzero(passes_zero(u)).tolist() == [2, 5]
    np.testing.assert_array_equal(passes_zero([u, -u]), [passes_zero(u)] * 2)


@pytest.mark.parametrize("damping", [Damping("CR", 0.85), Damping("SDR", 0.05)])
def test_steps_that_pass_zero_are_the_solvers_impacts(damping):
    curve = TrilinearCurve(0.04, 0.85)
    response = simulate(curve, damping, release_amplitude=0.5, step=0.005, steps=6000)
    assert passes_zero(response.displacement).sum() == response.impacts > 10


def decaying(elapsed):
    """Half periods of 0.1 s, amplitude down by a factor of 0.8 over each."""
    return np.sin(10 * np.pi * elapsed) * 0.8 ** (elapsed / 0.1)


def test_half_cycles_of_a_damped_sine_are_its_own():
    elapsed = np.arange(0, 1.0005, 0.001)
    cycles = half_cycles(elapsed, decaying(elapsed), 0.15)
    lag = np.arctan(np.log(0.8) / np.pi) / (10 * np.pi)  # peaks stand before the quarter period
    times = 0.05 + 0.1 * np.arange(cycles.peak.size) + lag
    np.testing.assert_allclose(cycles.peak_elapsed, times, atol=0.0006)  # half a sample
    np.testing.assert_allclose(cycles.peak, decaying(times), rtol=1e-3)
    np.testing.assert_allclose(cycles.start[1:], 0.1 * np.arange(1, cycles.peak.size), atol=1e-5)
    np.testing.assert_allclose(cycles.duration[1:-1], 0.1, atol=2e-5)
    assert np.isnan(cycles.start[0]) and np.isnan(cycles.end[-1])
    assert np.abs(cycles.peak).min() > 0.15


def test_noise_near_zero_makes_no_half_cycles():
    elapsed = np.arange(0, 1.0005, 0.001)
    noise = 0.01 * np.random.RandomState(1).standard_normal(elapsed.size)
    quiet, noisy = (half_cycles(elapsed, decaying(elapsed) + part, 0.15) for part in (0, noise))
    assert np.count_nonzero(np.diff(np.sign(decaying(elapsed) + noise))) > 2 * quiet.peak.size
    assert noisy.peak.size == quiet.peak.size
    # Six standard deviations of noise over the slope at the crossing, the least of which is 10 pi 0.8^7.
    np.testing.assert_allclose(
        noisy.start[1:], quiet.start[1:], atol=6 * 0.01 / (10 * np.pi * 0.8**7)
    )


def test_turning_points_are_of_second_order():
    lanes = np.array(
        [[1.0], [2.5]]
    )  # a linear spring of two stiffnesses: turns at every half period, in amplitude 1
    away = []
    for step in (0.04, 0.02):
        tau = step * np.arange(round(8.0 / step) + 1)
        found, elapsed = turning_points(np.cos(lanes * tau), -lanes * np.sin(lanes * tau), step)
        assert np.isfinite(found).sum(axis=1).tolist() == [
            2,
            6,
        ] and found.shape == elapsed.shape == (2, 6)
        expected = np.pi / lanes * np.arange(1, 7)
        away.append([np.nanmax(np.abs(elapsed - expected)), np.nanmax(np.abs(np.abs(found) - 1))])
        assert np.sign(found[1]).tolist() == [-1, 1] * 3
    assert np.all(np.array(away[1]) < [1e-4, 1e-5])
    assert turning_points(np.ones((2, 4)), np.zeros((2, 4)), 0.1)[0].shape == (2, 0)


def test_noisy_crossing_is_the_middle_of_its_changes_of_sign():
    """By hand: signs change half way through the second, third and fifth second."""
    u = np.array([1.0, 0.1, -0.1, 0.1, 0.1, -0.1, -1.0, -0.4])
    found = half_cycles(np.arange(8.0), u, 0.5)
    np.testing.assert_allclose(found.end[0], 3.0)
    np.testing.assert_allclose(found.start[1], 3.0)
    assert half_cycles(np.arange(3.0), np.array([0.1, -0.1, 0.1]), 0.5).peak.size == 0
    np.testing.assert_array_equal(
        half_cycles(np.arange(3.0), np.array([1.0, -1.0, 1.0]), 0.5).end[:2], [0.5, 1.5]
    )
