"""The kernel's power x^n = 2^(n log2 x): its polynomials, what rounding adds, and the ends of its range."""

import mpmath
import numpy as np
import pytest
from numba import njit
from numpy.polynomial import Chebyshev

from rockdamp import kernels
from rockdamp.kernels import EXP2, LOG2, power

ROUNDING = 2.0**-53
TAYLOR = 40  # terms of a series, far more than 30 digits need


def largest_difference(coefficients, series, low, high):
    """Bound |polynomial - series| on [low, high]: no Chebyshev polynomial is larger than 1 there."""
    with mpmath.workdps(40):
        middle, half = mpmath.mpf(low + high) / 2, mpmath.mpf(high - low) / 2
        differences = [mpmath.mpf(0)] * len(series)
        for power_of_x, term in enumerate(series):
            own = mpmath.mpf(coefficients[-1 - power_of_x]) if power_of_x < len(coefficients) else mpmath.mpf(0)
            for k in range(power_of_x + 1):  # of x = middle + half t, by t
                way = mpmath.binomial(power_of_x, k) * middle ** (power_of_x - k) * half**k
                differences[k] += (own - term) * way
        # t^k has Chebyshev coefficients of sum 1, all of them positive.
        chebyshev = [mpmath.mpf(0)] * len(series)
        for k, difference in enumerate(differences):
            for j in range(k % 2, k + 1, 2):
                share = mpmath.binomial(k, (k - j) // 2) * mpmath.mpf(2) ** (1 - k)
                chebyshev[j] += difference * (share if j else share / 2)
        return float(sum(abs(value) for value in chebyshev))


def test_a_power_in_chebyshev_polynomials_is_what_the_bound_takes_it_for():
    wanted = Chebyshev([0, 10 / 16, 0, 5 / 16, 0, 1 / 16])  # of t^5
    np.testing.assert_allclose(wanted(np.linspace(-1, 1, 7)), np.linspace(-1, 1, 7) ** 5, atol=1e-15)
    zero = [0.0] * 6
    assert largest_difference(zero, [*zero[:5], 1], -1, 1) == pytest.approx(1.0, abs=1e-15)


def test_the_logarithm_s_polynomial_is_off_by_a_fifth_of_a_rounding_at_most():
    largest = (np.sqrt(2) - 1) / (np.sqrt(2) + 1) * (1 + 1e-12)
    with mpmath.workdps(40):
        series = [2 / mpmath.log(2) / (2 * k + 1) for k in range(TAYLOR)]  # 2 atanh(s)/(s ln 2)
    assert largest ** (2 * TAYLOR) < 1e-40  # what the series leaves out
    assert largest_difference(LOG2, series, 0.0, largest**2) / LOG2[-1] < ROUNDING / 5


def test_the_power_of_two_s_polynomial_is_off_by_a_third_of_a_rounding_at_most():
    with mpmath.workdps(40):
        series = [mpmath.log(2) ** k / mpmath.factorial(k) for k in range(TAYLOR)]
    assert largest_difference(EXP2, series, -0.5, 0.5) / 2**-0.5 < ROUNDING / 3


@pytest.fixture(scope="module")
def compiled():
    """The same function as numba makes it in the kernel."""
    return njit(fastmath=True, error_model="numpy")(lambda x, n: power(x, n))


def samples():
    """Any size of x and n, and where e or the whole part of n log2 x changes."""
    random = np.random.default_rng(8)
    x, n = 2 ** random.uniform(-1022, 1023, 300), 10 ** random.uniform(-3, 0, 300)
    near = np.concatenate(
        [1 + random.uniform(-1, 1, 60) * 10 ** random.uniform(-16, -1, 60), random.uniform(0.1, 50, 240)]
    )
    edge = np.array([1.0, np.sqrt(0.5), np.sqrt(2), 2.0, 0.5, kernels.SMALLEST, np.finfo(float).max])
    edge = np.concatenate([edge, np.nextafter(edge[:5], 0), np.nextafter(edge[:5], 9)])
    half = 2 ** (np.arange(0.5, 20.5) / 0.65)  # where n log2 x is rounded up or down
    return [
        (x, n),
        (near, random.uniform(0, 20, 300)),
        (edge, np.full(edge.size, 0.65)),
        (half, np.full(half.size, 0.65)),
    ]


@pytest.mark.parametrize("as_compiled", [False, True])
def test_a_power_is_within_its_bound_of_the_exact_one(as_compiled, compiled):
    function = np.vectorize(compiled, otypes=[float]) if as_compiled else power
    for x, n in samples():
        with mpmath.workdps(40):
            y = [mpmath.mpf(b) * mpmath.log(mpmath.mpf(a), 2) for a, b in zip(x, n, strict=True)]
            off = [abs(mpmath.mpf(v) / 2**e - 1) for v, e in zip(function(x, n), y, strict=True)]
        bound = (4 + 5 * np.abs(np.array(y, dtype=float))) * ROUNDING
        assert np.all(np.array(off, dtype=float) <= bound)


@pytest.mark.parametrize("as_compiled", [False, True])
def test_zero_and_what_is_beyond_the_range_of_normal_numbers(as_compiled, compiled):
    function = np.vectorize(compiled, otypes=[float]) if as_compiled else power
    x = np.array([0.0, 0.0, 5.0, 1e200, 1e-200, 5e-324, 1.0])
    n = np.array([0.65, 0.0, 0.0, 2.0, 2.0, 1.0, 1e300])
    assert function(x, n).tolist() == [0.0, 1.0, 1.0, 2.0**1023, 2.0**-1022, 2.0**-1022, 1.0]
