"""The motion of one branch in closed form, against the matrix exponential of the same linear equations."""

import numpy as np
import pytest
from scipy.linalg import expm

from rockdamp.solvers.oscillator import acceleration_zeros, closed_state, closed_turn

SLOPE = 0.7
DAMPED = [(0.3, 4.0), (0.0, 4.0), (5.0, 2.0), (4.0, 4.0), (0.5, -1.2), (0.4, 0.0)]  # c and k, all kinds of roots
STARTS = [(0.2, -0.5, 0.3), (-0.4, 1.1, 0.1), (0.5, 0.3, -0.2), (0.1, -1.0, 1.5)]  # x, v and the load q


def step_of(c, k, t):
    """Return the matrix that takes x, v, the load and 1 over t, under a load that grows by `SLOPE`."""
    return expm(t * np.array([[0, 1, 0, 0], [-k, -c, 1, 0], [0, 0, 0, SLOPE], [0, 0, 0, 0]]))


def motion(c, k, start, t):
    """Return x, v and the acceleration after t."""
    x, v, q, _ = step_of(c, k, t) @ [*start, 1.0]
    return x, v, q - c * v - k * x


@pytest.mark.parametrize(("c", "k"), DAMPED)
@pytest.mark.parametrize("start", STARTS)
def test_the_state_is_that_of_the_matrix_exponential(c, k, start):
    x, v, q = start
    for t in (1e-3, 0.4, 2.5):
        np.testing.assert_allclose(closed_state(x, v, c, k, q, SLOPE, t), motion(c, k, start, t)[:2], rtol=1e-9)


@pytest.mark.parametrize(("c", "k"), [pair for pair in DAMPED if pair[1]])
@pytest.mark.parametrize("start", STARTS)
def test_the_acceleration_is_zero_first_where_the_kernel_says_and_then_at_equal_times(c, k, start):
    x, v, q = start
    first, spacing = acceleration_zeros(x, v, c, k, q, SLOPE)
    before = np.array([motion(c, k, start, t)[2] for t in np.linspace(1e-6, 0.999 * min(first, 6.0), 200)])
    assert (before > 0).all() or (before < 0).all()
    zeros = [first + n * spacing for n in range(3) if np.isfinite(first + n * spacing)] if np.isfinite(first) else []
    assert [motion(c, k, start, t)[2] for t in zeros] == pytest.approx([0.0] * len(zeros), abs=1e-9)


@pytest.mark.parametrize(("c", "k"), [pair for pair in DAMPED if pair[1]])
def test_the_stretch_of_a_turn_holds_the_first_change_of_the_velocity_s_sign(c, k):
    random, times = np.random.RandomState(2), np.linspace(0.0, 4.0, 400)
    step, turned = step_of(c, k, times[1]), 0
    for x, v, q in random.uniform(-1, 1, (40, 3)):
        states = [np.array([x, v, q, 1.0])]
        for _ in times[1:]:
            states.append(step @ states[-1])
        changes = np.flatnonzero(np.diff(np.sign([state[1] for state in states])))
        start, stop, turns = closed_turn(x, v, c, k, q, SLOPE, times[-1])
        assert turns == bool(changes.size)
        if turns:
            turned += 1
            assert start <= times[changes[0] + 1] and stop >= times[changes[0]]
            assert changes.size < 2 or stop <= times[changes[1] + 1]
    assert turned > 5
