"""The kernel's power x^n = 2^(n log2 x): its polynomials, what rounding adds, and the ends of its range."""

from itertools import pairwise

import mpmath
import numpy as np
import power_coefficients
import pytest
from numba import njit
from numpy.polynomial import Chebyshev

from rockdamp import kernels
from rockdamp.kernels import EXP2, LOG2, exp2_within, log2_over_s, power

ROUNDING = 2.0**-53
TAYLOR = 40  # terms of a series, far more than 30 digits need
LARGEST_S = (np.sqrt(2) - 1) / (np.sqrt(2) + 1) * (1 + 1e-12)  # (m - 1)/(m + 1) of m = sqrt(2)
LARGEST_R = 0.5 + 2.0**-43  # of y - floor(y + 0.5), where |y| is 1023 and the sum is rounded by 2^-44


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


def test_the_coefficients_are_those_that_their_program_makes():
    assert power_coefficients.coefficients() == {"LOG2": LOG2, "EXP2": EXP2}


def off_of_log2():
    """Bound how far the logarithm's polynomial is from 2 atanh(s)/(s ln 2), in roundings of it."""
    assert LARGEST_S ** (2 * TAYLOR) < 1e-40  # what the series leaves out
    with mpmath.workdps(40):
        series = [2 / mpmath.log(2) / (2 * k + 1) for k in range(TAYLOR)]
    return largest_difference(LOG2, series, 0.0, LARGEST_S**2) / LOG2[-1] / ROUNDING


def off_of_exp2():
    """Bound how far the polynomial of 2^r is from it, in roundings of it."""
    with mpmath.workdps(40):
        series = [mpmath.log(2) ** k / mpmath.factorial(k) for k in range(TAYLOR)]
    assert series[-1] * LARGEST_R**TAYLOR < 1e-60  # what the series leaves out
    return largest_difference(EXP2, series, -LARGEST_R, LARGEST_R) / 2**-LARGEST_R / ROUNDING


def test_the_logarithm_s_polynomial_is_off_by_a_fifth_of_a_rounding_at_most():
    assert off_of_log2() < 1 / 5


def test_the_power_of_two_s_polynomial_is_off_by_a_third_of_a_rounding_at_most():
    assert off_of_exp2() < 1 / 3


class Rounded:
    """A computed number: between which two it lies, and how far at most it is from the exact one.

    Each sum and each product rounds once; where the compiler fuses the two, they round less.
    """

    def __init__(self, low, high, error=0.0):
        self.low, self.high, self.error = low, high, error

    @property
    def largest(self):
        return max(abs(self.low), abs(self.high))

    @classmethod
    def of(cls, corners, error):
        rounding = ROUNDING * (max(map(abs, corners)) + error)
        return cls(min(corners) - rounding, max(corners) + rounding, error + rounding)

    def __add__(self, other):
        other = other if isinstance(other, Rounded) else Rounded(other, other)
        return self.of([self.low + other.low, self.high + other.high], self.error + other.error)

    def __mul__(self, other):
        other = other if isinstance(other, Rounded) else Rounded(other, other)
        corners = [a * b for a in (self.low, self.high) for b in (other.low, other.high)]
        error = self.error * other.largest + other.error * self.largest + self.error * other.error
        return self.of(corners, error)

    __radd__, __rmul__ = __add__, __mul__


def largest_rounding(polynomial, low, high, relative_error, pieces=64):
    """Bound what rounding adds to a polynomial's value, in roundings of it; its argument is off by so much already."""
    ends = np.linspace(low, high, pieces + 1)
    values = [polynomial(Rounded(a, b, relative_error * max(abs(a), abs(b)))) for a, b in pairwise(ends)]
    return max(value.error / value.low for value in values) / ROUNDING


def test_the_bound_of_a_power_holds_for_every_rounding_of_its_formula():
    """What the kernel's comment counts, m - 1, e, y - floor(y + 1/2) and the last product being exact."""
    of_s = 2.0  # of m + 1 and of the quotient
    of_series = largest_rounding(log2_over_s, 0.0, LARGEST_S**2, (2 * of_s + 1) * ROUNDING) + off_of_log2()
    of_product = of_s + of_series + 1
    assert of_series < 1.3
    # Beside an e that is not 0 |log2 x| is at least 1/2, and the product at most 1/2.
    of_n_log2 = of_product + 1 + 1
    of_exp2 = largest_rounding(exp2_within, -LARGEST_R, LARGEST_R, 0.0) + off_of_exp2()
    assert of_n_log2 * np.log(2) < 4.4
    assert of_exp2 < 2.3
    # The bound states 4 and 5 |n log2 x|, which leaves room for products of two roundings: these are 1e-12 of it.


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
