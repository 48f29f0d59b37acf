"""Brackets and minima of many cases at once, against SciPy's."""

import numpy as np
import pytest
from scipy.optimize import elementwise

from rockdamp.equivalence.scalar_minima import bracket, least

RESOLUTION = 3e-5


def both(function, low, middle, high):
    """Our brackets and minima, and SciPy's, with the number of calls of each."""
    calls = [0, 0]

    def ours(x, case):
        calls[0] += 1
        return function(x, case)

    def theirs(x, case):
        calls[1] += 1
        return function(x, case.astype(int))

    points, values = bracket(ours, low, middle, high)
    found = least(ours, points, values, RESOLUTION)
    args = (np.arange(middle.size, dtype=float),)
    held = elementwise.bracket_minimum(theirs, middle, xl0=low, xr0=high, xmin=0.0, args=args)
    tolerances = {"xrtol": RESOLUTION, "frtol": 1e-13}
    minimum = elementwise.find_minimum(theirs, held.bracket, args=args, tolerances=tolerances)
    return (np.sort(points, axis=0), *found), (np.stack(held.bracket), minimum.x, minimum.f_x), calls


def test_brackets_and_minima_are_scipy_s_to_the_bit_with_fewer_calls():
    random = np.random.default_rng(5)
    count = 400
    true, skew, ripple = (
        random.uniform(0.01, 3, count),
        random.uniform(-0.9, 0.9, count),
        random.uniform(0, 0.02, count),
    )

    def function(x, case):
        away = np.log(x / true[case])
        return away**2 * (1.5 + skew[case] * np.tanh(away)) + ripple[case] * np.cos(40 * away) + 1e-3

    middle = true * np.exp(random.uniform(-1.5, 1.5, count))
    ours, theirs, calls = both(function, middle * 0.97, middle, middle * 1.04)
    for our, their in zip(ours, theirs, strict=True):
        np.testing.assert_array_equal(our, their)
    assert calls[0] <= calls[1] - 3


@pytest.mark.parametrize("power", [1, 2, 4])
def test_a_minimum_that_is_zero_or_has_a_kink_is_found(power):
    ours, theirs, _ = both(lambda x, case: np.abs(x - 0.3) ** power, *np.array([[0.1], [0.2], [0.7]]))
    assert ours[1][0] == theirs[1][0] == pytest.approx(0.3, rel=1e-3 if power == 4 else 2 * RESOLUTION)


def test_a_case_without_a_minimum_or_with_an_infinite_end_is_not_a_number_and_the_others_are_found():
    def function(x, case):
        value = np.where(case == 0, -x, (x - 1.0) ** 2)
        return np.where((case == 1) & (x > 1.05), np.inf, value)

    around = np.tile([[0.9], [1.01], [1.1]], 3)
    points, values = bracket(function, *around)
    assert np.isnan(values[1]).tolist() == [True, False, False]
    at, value = least(function, points, values, RESOLUTION)
    assert np.isnan(at).tolist() == np.isnan(value).tolist() == [True, True, False]
    assert at[2] == pytest.approx(1.0, rel=RESOLUTION)
