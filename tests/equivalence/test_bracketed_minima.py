"""Minima within brackets, against SciPy's and in closed form."""

import numpy as np
import pytest
from scipy.optimize import elementwise

from rockdamp.equivalence.minima import bracketed_minima

TOP, STEEP = np.random.default_rng(7).uniform([[0.5], [0.1]], [[2.0], [40.0]], (2, 200))


def bumpy(x, top, steep):
    """A parabola with a kink, ripples and one minimum at `top`."""
    return steep * (x - top) ** 2 + np.abs(x - top) ** 1.5 + 1e-3 * np.sin(30 * (x - top)) ** 2 + 1


def brackets(function):
    place = TOP * np.array([[0.6], [1.1], [1.7]])
    return place, np.stack([function(x, np.arange(TOP.size)) for x in place])


def test_places_and_values_are_those_of_scipy_bit_by_bit():
    """Its signature differs, and it takes each value in the bracket again."""
    place, value = brackets(lambda x, lane: bumpy(x, TOP[lane], STEEP[lane]))
    expected = elementwise.find_minimum(
        bumpy, tuple(place), args=(TOP, STEEP), tolerances={"xrtol": 3e-5, "frtol": 1e-13}
    )
    x, f = bracketed_minima(lambda x, lane: bumpy(x, TOP[lane], STEEP[lane]), place, value, 3e-5)
    assert expected.success.all() and (x == expected.x).all() and (f == expected.f_x).all()
    assert x == pytest.approx(TOP, rel=6e-5)


def test_a_value_that_is_not_finite_leaves_that_minimum_open():
    def function(x, lane):
        return np.where((lane == 3) & (x < 0.9 * TOP[lane]), np.inf, bumpy(x, TOP[lane], STEEP[lane]))

    x, f = bracketed_minima(function, *brackets(function), 3e-5)
    assert np.flatnonzero(np.isnan(x)).tolist() == np.flatnonzero(np.isnan(f)).tolist() == [3]
