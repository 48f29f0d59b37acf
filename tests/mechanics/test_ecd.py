"""What ECD of order m has in closed form: its normalisation, its ratio, and where it is refused."""

import mpmath
import numpy as np
import pytest
import sympy as sp

from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.damping.ecd import CAP, critical_damping_ratio, damping_ratio, log_decrement, normalisation


@pytest.mark.parametrize("order", range(7))
def test_the_normalisation_is_half_pi_over_the_integral_of_the_cosine_s_power(order):
    phi = sp.symbols("phi", real=True)
    integral = sp.integrate(sp.cos(phi) ** (2 * order + 2), (phi, -sp.pi / 2, sp.pi / 2))
    central = sp.Rational(2 ** (2 * order + 1)) / sp.binomial(2 * order + 2, order + 1)
    assert sp.simplify(sp.pi / 2 / integral - central) == 0
    assert float(normalisation(order)) == pytest.approx(float(central), rel=1e-14)


def test_the_normalisation_is_a_ratio_of_gamma_functions_at_any_real_order():
    orders = np.array([0, 1e-9, 0.25, 0.5, 1.7, 12.3, 64, 169.5, 1000])
    with mpmath.workdps(30):
        half_root = mpmath.sqrt(mpmath.pi) / 2
        expected = [float(half_root * mpmath.gammaprod([m + 2], [m + mpmath.mpf(3) / 2])) for m in orders]
    np.testing.assert_allclose(normalisation(orders), expected, rtol=2e-12)
    assert normalisation(0) == 1.0  # to the bit: order 0 is ECD
    np.testing.assert_allclose(normalisation(1e6), np.sqrt(np.pi * 1e6) / 2, rtol=1e-6)


def test_both_solvers_have_the_size_of_the_damper_by_their_own_formula():
    curve = TrilinearCurve(0.04, 0.85)
    for order in (0.3, 1, 16, 40.7):
        damping = Damping("ECD", 0.05, order=order)
        batched, exact = damping.formula_parameters(curve)[0], damping.law_parameters(curve)[0]
        assert exact == pytest.approx(float(batched), rel=1e-13)


def test_the_ratio_is_delta_over_pi_and_that_of_order_zero_the_linear_oscillator_s():
    delta = -np.log(np.array([0.05, 0.5, 0.85, 0.999, 1.0]))
    orders = np.array([[0.0], [0.5], [16.0]])
    xi = damping_ratio(delta, orders)
    np.testing.assert_allclose(xi[0], delta / np.sqrt(np.pi**2 + delta**2))
    np.testing.assert_allclose(xi[1:], np.broadcast_to(delta / np.pi, (2, 5)))
    np.testing.assert_allclose(log_decrement(xi, orders), np.broadcast_to(delta, xi.shape), rtol=1e-12)
    expected = [damping_ratio(-np.log(0.5), 0), damping_ratio(-np.log(0.9), 8)]
    np.testing.assert_array_equal(Damping.of_restitution([0.5, 0.9], order=[0, 8]).damping_ratio, expected)


@pytest.mark.filterwarnings("ignore::rockdamp.errors.InputWarning")  # beyond any wall
@pytest.mark.parametrize("order", [0.5, 1, 16])
def test_an_e_that_the_cap_would_touch_is_refused_with_the_least_that_is_not(order):
    least = float(np.exp(-CAP * np.pi * critical_damping_ratio(order)))
    assert Damping.of_restitution(1.001 * least, order=order).damping_ratio > 0
    with pytest.raises(InputError, match=rf"at least {least:.3g} for a damper of an order above 0"):
        Damping.of_restitution(0.999 * least, order=order)
    with pytest.raises(InputError, match=r"order \(m\) is -1"):
        Damping.of_restitution(0.8, order=-1)


def test_at_any_ratio_the_coefficient_is_finite_and_does_not_feed_energy_in():
    curve, x, v = TrilinearCurve(0.04, 0.85), np.linspace(-0.9, 0.9, 181)[:, None], np.linspace(-2, 2, 81)
    for order in (0, 0.5, 1, 16):
        for xi in (0.05, 1.2, 5.0):
            coefficient = Damping("ECD", xi, order=order).coefficient(curve, x, v)
            assert np.isfinite(coefficient).all() and (coefficient >= 0).all()
