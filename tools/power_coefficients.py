"""Make the coefficients of the kernel's power, LOG2 and EXP2 in src/rockdamp/kernels.py, and compare.

`.venv/bin/python tools/power_coefficients.py` prints them as they should stand there; the exit status says whether
they do, bit for bit. How far the polynomials are off, and what rounding adds, tests/solvers/test_power.py bounds.
"""

import sys
from collections.abc import Callable

import mpmath
from mpmath import mpf

from rockdamp import kernels

DIGITS = 60  # the equations lose some ten
ONE = mpf(1)
DEGREE_OF_LOG2, DEGREE_OF_EXP2 = 7, 12


def log2_over_s(q: mpf) -> mpf:
    """log2(m)/s by q = s^2, s = (m - 1)/(m + 1): 2 atanh(s)/(s ln 2)."""
    s = mpmath.sqrt(q)
    return 2 * mpmath.atanh(s) / s / mpmath.ln2


def slope_of_exp2(r: mpf) -> mpf:
    """(2^r - 1)/r."""
    return mpmath.expm1(r * mpmath.ln2) / r


def interpolated(function: Callable[[mpf], mpf], degree: int, low: mpf, high: mpf) -> list[float]:
    """Return the polynomial through a function at Chebyshev's points of an interval, the highest power first."""
    count = degree + 1
    points = [(low + high + (high - low) * mpmath.cospi((k + ONE / 2) / count)) / 2 for k in range(count)]
    powers = mpmath.matrix([[point ** (degree - k) for k in range(count)] for point in points])
    return [float(value) for value in mpmath.lu_solve(powers, mpmath.matrix([function(point) for point in points]))]


def coefficients() -> dict[str, tuple[float, ...]]:
    """Return both by their names in the kernels. 2^r = 1 + r (2^r - 1)/r is 1 at r = 0, and so is its polynomial."""
    with mpmath.workdps(DIGITS):
        root = mpmath.sqrt(mpf(2))
        largest = (root - 1) / (root + 1)  # s of m = sqrt(2)
        log2 = interpolated(log2_over_s, DEGREE_OF_LOG2, mpf(0), largest**2)
        slope = interpolated(slope_of_exp2, DEGREE_OF_EXP2 - 1, -ONE / 2, ONE / 2)
    return {"LOG2": tuple(log2), "EXP2": (*slope, 1.0)}


def main() -> bool:
    """Print both; return whether they are those of the kernels."""
    made = coefficients()
    for name, values in made.items():
        print(f"{name} = (", *(f"    {value!r}," for value in values), ")", sep="\n")
    return all(values == getattr(kernels, name) for name, values in made.items())


if __name__ == "__main__":
    sys.exit(0 if main() else "src/rockdamp/kernels.py has others.")
