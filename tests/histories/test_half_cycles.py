"""Crossings of zero, turning points and half cycles of stored histories."""

import numpy as np
import pytest

from rockdamp.histories.half_cycles import half_cycles, passes_zero, turning_points
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import simulate

ELAPSED = np.arange(0, 1.0005, 0.001)
HALF_PERIOD = 0.1
LOSS = 0.8  # factor on the amplitude in a half period


def decay(elapsed):
    """Return a damped sine of unit amplitude."""
    return np.sin(np.pi / HALF_PERIOD * elapsed) * LOSS ** (elapsed / HALF_PERIOD)


# --- crossings ------------------------------------------------------------------------------------


def test_step_that_starts_at_zero_does_not_pass_it():
    u = np.array([0.0, 1.0, 0.5, 0.0, -0.5, -0.1, 0.2, np.nan, 0.3])
    assert np.flatnonzero(passes_zero(u)).tolist() == [2, 5]


def test_either_side_passes_zero_alike():
    u = np.array([1.0, 0.0, -0.5, 0.2])
    np.testing.assert_array_equal(passes_zero([u, -u]), [passes_zero(u)] * 2)


@pytest.mark.parametrize("damping", [Damping("CR", 0.85), Damping("SDR", 0.05)], ids=["CR", "SDR"])
def test_steps_that_pass_zero_are_the_solvers_impacts(damping):
    curve = TrilinearCurve(0.04, 0.85)
    response = simulate(curve, damping, release_amplitude=0.5, step=0.005, steps=6000)
    assert passes_zero(response.displacement).sum() == response.impacts > 10


# --- half cycles ----------------------------------------------------------------------------------


@pytest.fixture
def cycles():
    return half_cycles(ELAPSED, decay(ELAPSED), 0.15)


def test_peaks_of_a_damped_sine(cycles):
    """Peaks come before the quarter period; they are found to half a sample."""
    lag = np.arctan(np.log(LOSS) / np.pi) / np.pi * HALF_PERIOD
    times = HALF_PERIOD * (0.5 + np.arange(cycles.peak.size)) + lag
    np.testing.assert_allclose(cycles.peak_elapsed, times, atol=0.0006)
    np.testing.assert_allclose(cycles.peak, decay(times), rtol=1e-3)


def test_crossings_of_a_damped_sine(cycles):
    crossings = HALF_PERIOD * np.arange(1, cycles.peak.size)
    np.testing.assert_allclose(cycles.start[1:], crossings, atol=1e-5)
    np.testing.assert_allclose(cycles.duration[1:-1], HALF_PERIOD, atol=2e-5)


def test_ends_of_a_history_are_no_crossings(cycles):
    assert np.isnan(cycles.start[0])
    assert np.isnan(cycles.end[-1])


def test_slice_keeps_the_arrays_of_half_cycles_apart(cycles):
    part = cycles[1:3]
    for name in ("peak", "peak_elapsed", "start", "end"):
        assert getattr(part, name).tolist() == getattr(cycles, name)[1:3].tolist()


def test_peaks_pass_the_threshold(cycles):
    assert np.abs(cycles.peak).min() > 0.15
    assert LOSS * np.abs(cycles.peak).min() < 0.15


def test_noise_near_zero_makes_no_half_cycles(cycles):
    noise = 0.01 * np.random.RandomState(1).standard_normal(ELAPSED.size)
    history = decay(ELAPSED) + noise
    assert np.count_nonzero(np.diff(np.sign(history))) > 2 * cycles.peak.size
    noisy = half_cycles(ELAPSED, history, 0.15)
    assert noisy.peak.size == cycles.peak.size
    # Six standard deviations of the noise over the slope at the last crossing.
    slope = np.pi / HALF_PERIOD * LOSS**7
    np.testing.assert_allclose(noisy.start[1:], cycles.start[1:], atol=6 * 0.01 / slope)


def test_noisy_crossing_is_the_middle_of_its_changes_of_sign():
    """By hand: signs change half way through the second, third and fifth second."""
    u = np.array([1.0, 0.1, -0.1, 0.1, 0.1, -0.1, -1.0, -0.4])
    cycles = half_cycles(np.arange(8.0), u, 0.5)
    assert cycles.end[0] == pytest.approx(3.0)
    assert cycles.start[1] == pytest.approx(3.0)


def test_crossing_between_two_samples():
    cycles = half_cycles(np.arange(3.0), np.array([1.0, -1.0, 1.0]), 0.5)
    assert cycles.end[:2].tolist() == [0.5, 1.5]


def test_history_below_the_threshold_has_no_half_cycles():
    assert half_cycles(np.arange(3.0), np.array([0.1, -0.1, 0.1]), 0.5).peak.size == 0


# --- turning points -------------------------------------------------------------------------------

FREQUENCY = np.array([[1.0], [2.5]])  # of two oscillators, which turn at every half period


def turn(step):
    tau = step * np.arange(round(8.0 / step) + 1)
    displacement = np.cos(FREQUENCY * tau)
    velocity = -FREQUENCY * np.sin(FREQUENCY * tau)
    return turning_points(displacement, velocity, step)


def test_lanes_have_their_turns_and_nan_behind():
    turns, elapsed = turn(0.02)
    assert turns.shape == elapsed.shape == (2, 6)
    assert np.isfinite(turns).sum(axis=1).tolist() == [2, 6]
    assert np.sign(turns[1]).tolist() == [-1, 1] * 3


def test_turning_points_are_of_second_order():
    expected = np.pi / FREQUENCY * np.arange(1, 7)
    for step, time_error, size_error in ((0.04, 8e-4, 8e-5), (0.02, 1e-4, 1e-5)):
        turns, elapsed = turn(step)
        assert np.nanmax(np.abs(elapsed - expected)) < time_error
        assert np.nanmax(np.abs(np.abs(turns) - 1)) < size_error


def test_release_is_no_turn():
    turns, _ = turning_points(np.ones((2, 4)), np.zeros((2, 4)), 0.1)
    assert turns.shape == (2, 0)
