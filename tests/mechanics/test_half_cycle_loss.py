"""The half cycle's loss under ECD of order m against its integral in high precision, SymPy and its limits."""

import mpmath
import numpy as np
import pytest
import sympy as sp

from rockdamp.errors import InputError
from rockdamp.mechanics.half_cycle_loss import critical_damping_ratio, damping_ratio, log_decrement, normalisation

ORDERS = (0, 0.3, 1, 2, 4, 8, 16, 32, 64)
RESTITUTIONS = (1e-6, 0.05, 0.5, 0.85, 0.999)


def decrement(xi, m):
    """Integrate delta(xi; m) over phi as it stands, in 30 digits."""
    with mpmath.workdps(30):
        xi, m = mpmath.mpf(float(xi)), mpmath.mpf(float(m))
        a = xi * mpmath.pi / mpmath.quad(lambda p: mpmath.cos(p) ** (2 * m + 2), [-mpmath.pi / 2, 0, mpmath.pi / 2])

        def integrand(p):
            c = mpmath.cos(p)
            return a * c ** (2 * m + 2) / (1 - (a * mpmath.sin(p) * c ** (2 * m + 1)) ** 2)

        peak = mpmath.atan(1 / mpmath.sqrt(2 * m + 1))  # where the denominator is least
        marks = [peak * share for share in (0, 0.5, 0.9, 1, 1.1, 1.5)]
        marks += [p for p in (2 * peak, 3 * peak, 5 * peak) if p < 1.4] + [mpmath.pi / 2]
        return 2 * mpmath.quad(integrand, sorted(marks))


@pytest.mark.parametrize("order", range(7))
def test_the_normalisation_is_half_pi_over_the_integral_of_the_cosine_s_power(order):
    phi = sp.symbols("phi", real=True)
    integral = sp.integrate(sp.cos(phi) ** (2 * order + 2), (phi, -sp.pi / 2, sp.pi / 2))
    central = sp.Rational(2 ** (2 * order + 1)) / sp.binomial(2 * order + 2, order + 1)
    assert sp.simplify(sp.pi / 2 / integral - central) == 0
    assert float(normalisation(order)) == pytest.approx(float(central), rel=1e-15)


def test_the_normalisation_is_a_ratio_of_gamma_functions_at_any_real_order():
    orders = np.array([0, 1e-9, 0.25, 0.5, 1.7, 12.3, 64, 169.5, 1000, 1e7])
    with mpmath.workdps(30):
        half_root = mpmath.sqrt(mpmath.pi) / 2
        expected = [float(half_root * mpmath.gammaprod([m + 2], [m + mpmath.mpf(3) / 2])) for m in orders]
    np.testing.assert_allclose(normalisation(orders), expected, rtol=1e-15)
    assert normalisation(0) == 1.0  # to the bit: order 0 is ECD
    np.testing.assert_allclose(normalisation(1e6), np.sqrt(np.pi * 1e6) / 2, rtol=1e-6)


@pytest.mark.parametrize("order", ORDERS)
def test_the_decrement_is_its_integral_and_the_damping_ratio_its_inverse(order):
    delta = -np.log(np.array(RESTITUTIONS))
    xi = damping_ratio(delta, order)
    exact = [decrement(x, order) for x in xi]
    np.testing.assert_allclose(log_decrement(xi, order), np.array(exact, dtype=float), rtol=1e-14)
    # What the ratio misses, delta over the slope of delta(xi), which is at least pi.
    away = [float(found - mpmath.mpf(float(wanted))) for found, wanted in zip(exact, delta, strict=True)]
    slope = (log_decrement(xi, order) - log_decrement(xi * (1 - 1e-6), order)) / (1e-6 * xi)
    np.testing.assert_allclose(away / slope / xi, 0, atol=1e-14)


def test_order_zero_is_the_linear_oscillator_s_closed_form():
    theta, a = sp.symbols("theta a", positive=True)  # theta = 2 phi, a = A/2 = xi; the part with cos theta is odd
    root = sp.sqrt(1 - a**2)
    antiderivative = sp.atan(root * sp.tan(theta)) / root
    assert sp.simplify(sp.diff(antiderivative, theta) - 1 / (1 - a**2 * sp.sin(theta) ** 2)) == 0
    # It gains pi/root between two poles of the tangent, and the integral, a/2 times it, covers two of them.
    delta = -np.log(np.array(RESTITUTIONS))
    np.testing.assert_array_equal(damping_ratio(delta), delta / np.hypot(np.pi, delta))
    xi = np.array([0.01, 0.5, 0.97])
    np.testing.assert_allclose(log_decrement(xi), np.pi * xi / np.sqrt(1 - xi**2), rtol=1e-14)
    np.testing.assert_allclose(damping_ratio(delta, 1e-9), damping_ratio(delta), rtol=1e-8)  # and no jump beside it


@pytest.mark.parametrize("order", ORDERS)
def test_the_decrement_grows_from_pi_xi_without_bound_up_to_the_critical_ratio(order):
    critical = float(critical_damping_ratio(order))
    with mpmath.workdps(30):
        m = mpmath.mpf(order)
        steepest = mpmath.atan(1 / mpmath.sqrt(2 * m + 1))
        largest = mpmath.sin(steepest) * mpmath.cos(steepest) ** (2 * m + 1)
        a = 2 * mpmath.mpf(critical) * mpmath.mpf(float(normalisation(order)))
        assert float(a * largest) == pytest.approx(1, rel=1e-14)  # the denominator's zero, and it is the first
        for p in np.linspace(0, np.pi / 2, 200):
            assert mpmath.sin(p) * mpmath.cos(p) ** (2 * m + 1) <= largest
    # Near it delta is like 1/sqrt(1 - xi/xi_c): without bound, and 100 times closer is 10 times as much.
    near = [decrement(critical * (1 - gap), order) for gap in (1e-6, 1e-8)]
    assert float(near[1] / near[0]) == pytest.approx(10, rel=2e-3)
    xi = critical * np.linspace(0, 0.95, 40)
    delta = log_decrement(xi, order)
    assert np.all(np.diff(delta, 2) > 0)  # convex, so above its tangent at 0
    assert delta[0] == 0
    np.testing.assert_allclose(log_decrement(1e-5, order), np.pi * 1e-5, rtol=1e-9)


def test_the_damping_ratio_rises_with_the_order_between_that_of_order_zero_and_that_of_small_losses():
    delta = -np.log(np.array(RESTITUTIONS))[:, None]
    xi = damping_ratio(delta, np.array([*ORDERS, 500]))
    assert xi.shape == (len(RESTITUTIONS), len(ORDERS) + 1)
    assert np.all(np.diff(xi, axis=1) >= -1e-12 * xi[:, 1:])
    assert np.all(xi <= delta / np.pi)
    np.testing.assert_array_equal(xi[:, 3], damping_ratio(delta[:, 0], 2))


def test_nothing_lost_is_no_damping_at_every_order():
    np.testing.assert_array_equal(damping_ratio(0.0, [0, 0.5, 8]), 0)
    np.testing.assert_array_equal(log_decrement(0.0, [0, 0.5, 8]), 0)
    tiny = np.array([1e-300, 1e-12, 0.99e-8, 1.01e-8])
    np.testing.assert_allclose(damping_ratio(tiny, 8), tiny / np.pi, rtol=1e-14)


BAD = [
    (lambda: normalisation(-1), r"order \(m\) is -1\.0; it must be at least 0"),
    (lambda: damping_ratio(-0.1, 2), r"log_decrement \(delta\) is -0\.1; it must be between 0 and 13\.8"),
    (lambda: damping_ratio([1, 14], [[0], [2]]), r"log_decrement \(delta\) is 14\.0; it must be between 0 and 13\.8"),
]


@pytest.mark.parametrize(("call", "message"), BAD, ids=[message.split(";")[0] for _, message in BAD])
def test_what_no_half_cycle_loses_is_refused_with_the_value_and_what_is_allowed(call, message):
    with pytest.raises(InputError, match=message):
        call()
