"""Damping models: coefficients against the paper's equations, ECD and BAND in closed form, bad
input.
"""

import mpmath
import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad

from rockdamp.constants import PAPER_MODELS
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import DAMPERS, Damping
from rockdamp.mechanics.half_cycle_loss import (
    CAP,
    band_strength,
    critical_damping_ratio,
    half_cycle_loss,
    normalisation,
)
from rockdamp.solvers.coefficient import damping_coefficient

CURVE = TrilinearCurve(0.06, 0.72, 0.9)
X = np.array(
    [-0.95, -0.7, -0.2, -0.06, -0.01, 0.0, 1e-9, 0.03, 0.06, 0.15, 0.28, 0.5, 0.89, 0.9, 1.2]
)
XI = 0.07
ORDERS = (0, 0.5, 1, 2, 4, 8, 16, 32, 64, 128)


# --- the coefficients -----------------------------------------------------------------------------


def secant_frequency(x):
    """Eq. (9)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        stiffness = np.where(x == 0, CURVE.initial_stiffness, CURVE.force(x) / x)
    return np.sqrt(stiffness)


@pytest.mark.parametrize(
    ("model", "expected"),
    [
        ("CDC", lambda w, w1: 2 * w1 * XI * np.ones_like(w)),  # Eq. (10)
        ("CDR", lambda w, w1: 2 * w * XI),  # Eq. (11)
        ("SDR", lambda w, w1: 2 * w * (XI * w / w1)),  # Eq. (12)
    ],
)
def test_coefficient_follows_the_equation_of_the_paper(model, expected):
    c = damping_coefficient(CURVE, Damping(model, XI), X)
    equation = expected(secant_frequency(X), CURVE.initial_frequency)
    np.testing.assert_allclose(c, equation, rtol=1e-14, atol=1e-300)


@pytest.mark.parametrize("x", [0.02, 0.06, 0.2, 0.5, 0.85])
def test_ecd_has_the_force_over_the_root_of_the_energy(x):
    energy, _ = quad(CURVE.force, 0, x, points=[0.06, 0.28], epsabs=1e-13)
    expected = 2 * XI * CURVE.force(x) / np.sqrt(2 * energy)
    c = damping_coefficient(CURVE, Damping("ECD", XI), [x, -x])
    assert c == pytest.approx([expected, expected], rel=1e-11)


@pytest.mark.parametrize("model", [*PAPER_MODELS, "ECD"])
def test_first_branch_is_the_linear_oscillators(model):
    x = CURVE.yield_displacement_ratio * np.array([0.0, 1e-200, 1e-12, 0.3, 1.0])
    c = damping_coefficient(CURVE, Damping(model, XI), x)
    np.testing.assert_allclose(c, 2 * CURVE.initial_frequency * XI, rtol=1e-14)


@pytest.mark.parametrize("model", [*PAPER_MODELS, "ECD"])
def test_only_cdc_damps_beyond_the_end_of_the_curve(model):
    c = damping_coefficient(CURVE, Damping(model, XI), 1.5)
    assert (c > 0) == (model == "CDC")


@pytest.mark.parametrize("model", DAMPERS)
def test_coefficients_broadcast(model):
    curves = TrilinearCurve(np.array([0.02, 0.05])[:, None, None], 0.8)
    dampings = Damping(model, np.array([0.02, 0.05, 0.1])[:, None])
    together = damping_coefficient(curves, dampings, X, 0.2)
    alone = damping_coefficient(TrilinearCurve(0.05, 0.8), Damping(model, 0.05), X, 0.2)
    assert together.shape == (2, 3, X.size)
    np.testing.assert_allclose(together[1, 1], alone, rtol=1e-14)


@pytest.mark.parametrize("model", DAMPERS)
def test_only_restitution_has_no_coefficient(model):
    c = damping_coefficient(CURVE, Damping(model, 0.05), X, 0.2)
    assert c.any() == (model != "CR")


@pytest.mark.parametrize("order", ORDERS)
def test_ecd_of_an_order_is_that_of_any_order_and_no_source(order):
    """Coefficients are finite and feed no energy in."""
    x = np.linspace(-0.9, 0.9, 181)[:, None]
    v = np.linspace(-2, 2, 81)
    xi = np.array([0.05, 1.2, 5.0])[:, None, None]
    c = damping_coefficient(CURVE, Damping("ECD", xi, order=order), x, v)
    assert np.isfinite(c).all()
    assert (c >= 0).all()
    mixed_orders = np.array([order, 7.0])[:, None, None, None]
    mixed = damping_coefficient(CURVE, Damping("ECD", xi, order=mixed_orders), x, v)
    np.testing.assert_allclose(c, mixed[0], rtol=1e-12, atol=1e-300)


# --- ECD in closed form ---------------------------------------------------------------------------


@pytest.mark.parametrize("order", range(7))
def test_normalisation_is_half_pi_over_an_integral(order):
    phi = sp.symbols("phi", real=True)
    integral = sp.integrate(sp.cos(phi) ** (2 * order + 2), (phi, -sp.pi / 2, sp.pi / 2))
    expected = float(sp.pi / 2 / integral)
    assert float(normalisation(order)) == pytest.approx(expected, rel=1e-14)


def test_normalisation_is_a_ratio_of_gamma_functions():
    orders = np.array([0, 1e-9, 0.25, 0.5, 1.7, 12.3, 64, 169.5, 1000])
    expected = []
    with mpmath.workdps(30):
        for m in orders:
            ratio = mpmath.gammaprod([m + 2], [m + mpmath.mpf(3) / 2])
            expected.append(float(mpmath.sqrt(mpmath.pi) / 2 * ratio))
    np.testing.assert_allclose(normalisation(orders), expected, rtol=2e-12)


def test_normalisation_of_order_zero_is_one_to_the_bit():
    assert normalisation(0) == 1.0


@pytest.mark.parametrize("order", [0, 0.5, 1, 8, 64])
def test_half_cycles_end_below_the_critical_ratio(order):
    """There kappa cos^(2m+1) phi sin phi reaches 1."""
    phi = np.linspace(0, np.pi / 2, 200_001)
    largest = np.max(np.cos(phi) ** (2 * order + 1) * np.sin(phi))
    kappa = 2 * critical_damping_ratio(order) * normalisation(order)
    assert kappa * largest == pytest.approx(1, rel=1e-8)


E = np.array([0.1, 0.5, 0.85, 0.999, 1.0])
DELTA = -np.log(E)


def test_ratio_of_order_zero_is_that_of_the_linear_oscillator():
    xi = Damping.from_restitution(E, "ECD").value
    np.testing.assert_allclose(xi, DELTA / np.sqrt(np.pi**2 + DELTA**2))


@pytest.mark.parametrize("order", [0.5, 16.0])
def test_ratio_of_other_orders_is_delta_over_pi(order):
    xi = Damping.from_restitution(E, "ECD", order=order).value
    np.testing.assert_allclose(xi, DELTA / np.pi)


@pytest.mark.parametrize("g", [0.1, 0.45])
def test_ratio_with_a_loss_exponent(g):
    """The power g of the energy loses its share 1 - e^2g."""
    xi = Damping.from_restitution(0.85, "ECD", order=8, loss_exponent=g).value
    assert xi == pytest.approx((1 - 0.85 ** (2 * g)) / (2 * np.pi * g), rel=1e-12)


def test_ratio_of_band_is_delta_over_pi():
    xi = Damping.from_restitution(E[1:], "ECD", order=0.5).value
    np.testing.assert_array_equal(Damping.from_restitution(E[1:]).value, xi)


def test_restitution_is_its_own_damper():
    assert Damping.from_restitution(0.85, "CR").value == 0.85
    assert Damping("CR", 0.0).value == 0


@pytest.mark.parametrize("order", [0.5, 1, 16])
def test_e_that_the_cap_would_touch_is_refused(order):
    smallest = float(np.exp(-CAP * np.pi * critical_damping_ratio(order)))
    assert Damping.from_restitution(1.001 * smallest, "ECD", order=order).value > 0
    with pytest.raises(InputError, match=f"restitution is .* at least {smallest:.3g}"):
        Damping.from_restitution(0.999 * smallest, "ECD", order=order)


# --- the strength of BAND -------------------------------------------------------------------------


def loss_in_thirty_digits(strength, width):
    """Return delta of BAND from its definition, by mpmath's adaptive quadrature in t."""

    def integrand(t):
        g = 3 * strength / (4 * width) * (1 - (t / width) ** 2)
        return g / (1 + t * t) ** 2 / (1 + g * t / (1 + t * t))

    inner_points = [t for t in (-1, 0, 1) if abs(t) < width]
    return mpmath.quad(integrand, [-width, *inner_points, width])


# The limit of 24 nodes is e = 0.37; at 0.0101 the strength is near the largest that is allowed.
STRENGTHS = [
    (e, width)
    for width in (1e-6, 0.2, 0.6, 1.0, 5.0)
    for e in (1 - 1e-12, 0.85, 0.37, 0.36, 0.0101)
    if -np.log(e) < half_cycle_loss(3.4, width)
]


@pytest.mark.parametrize(("e", "width"), STRENGTHS)
def test_band_strength_loses_delta_in_thirty_digits(e, width):
    delta = -np.log(e)
    strength = float(band_strength(delta, width))
    with mpmath.workdps(30):
        loss = loss_in_thirty_digits(mpmath.mpf(strength), mpmath.mpf(width))
        slope = mpmath.diff(
            lambda s: loss_in_thirty_digits(s, mpmath.mpf(width)), mpmath.mpf(strength), h=1e-8
        )
        error = float((loss - mpmath.mpf(delta)) / slope)
    assert abs(error) < 6e-14 * strength


def test_band_strength_of_no_loss_is_zero():
    assert band_strength(0.0, 0.2) == 0.0


def test_band_strength_of_a_wall_does_not_depend_on_others():
    delta = -np.log(np.linspace(0.02, 0.999, 50))
    width = np.linspace(0.05, 0.6, 50)
    together = band_strength(delta, width)
    alone = [float(band_strength(d, w)) for d, w in zip(delta, width, strict=True)]
    np.testing.assert_array_equal(together, alone)


# --- parameters -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("label", "damping"),
    [
        ("ECD", Damping("ECD", XI)),
        ("ECD16", Damping("ECD", XI, order=16)),
        ("BAND", Damping("BAND", XI)),
        ("BAND0.4", Damping("BAND", XI, width=0.4)),
        ("CQD", Damping("CQD", XI)),
        ("CR", Damping("CR", 0.9, loss_exponent=0.1)),
    ],
)
def test_label_has_a_parameter_other_than_its_default(label, damping):
    assert damping.label == label
    assert damping.shape == ()


def test_defaults():
    assert Damping("BAND", XI).width == 0.2
    assert Damping("CQD", XI).width == 0.25
    assert Damping("ECD", XI).order == 0
    assert Damping("CR", 0.9).reference_amplitude == 0.3


def test_parameters_broadcast_and_arrays_have_no_label():
    dampings = Damping("ECD", [XI, XI], order=[[1.0], [2.0], [3.0]])
    assert dampings.shape == (3, 2)
    assert dampings.label == "ECD"
    assert dampings.map(lambda values: values[:, :1]).shape == (3, 1)


BAD_DAMPINGS = [
    ("restitution", lambda: Damping("CR", [0.9, -0.1])),
    ("restitution", lambda: Damping("CR", np.array([0.9, 1.2]))),
    ("restitution", lambda: Damping("CR", 0.0, loss_exponent=0.2)),
    ("restitution", lambda: Damping.from_restitution([0.5, 0.0], "BAND")),
    ("restitution", lambda: Damping.from_restitution(0.0, "ECD")),
    ("equivalent", lambda: Damping.from_restitution(0.85, "CDR")),
    ("damping_ratio", lambda: Damping("CDC", -0.01)),
    ("damping_ratio", lambda: Damping("BAND", 1.47)),
    ("damping_ratio", lambda: Damping("CQD", 1.47)),
    ("damping_ratio", lambda: Damping("BAND", 1.0, width=2.0)),
    ("order", lambda: Damping("ECD", 0.05, order=-1)),
    ("order", lambda: Damping("ECD", 0.05, order=10_001)),
    ("order", lambda: Damping.from_restitution(0.8, "ECD", order=-1)),
    ("order", lambda: Damping("CDR", 0.05, order=1)),
    ("width", lambda: Damping("BAND", 0.05, width=0.0)),
    ("width", lambda: Damping("CQD", 0.05, width=1.01)),
    ("width", lambda: Damping("CR", 0.9, width=0.2)),
    ("loss_exponent", lambda: Damping("CR", 0.9, loss_exponent=-1.0)),
    ("loss_exponent", lambda: Damping("ECD", 0.05, loss_exponent=0.5)),
    ("loss_exponent", lambda: Damping("CDR", 0.1, loss_exponent=0.1)),
    ("reference_amplitude", lambda: Damping("CR", 0.9, loss_exponent=0.1, reference_amplitude=0.0)),
]


@pytest.mark.parametrize(("name", "make"), BAD_DAMPINGS)
def test_bad_damping_is_refused_by_name(name, make):
    with pytest.raises(InputError, match=name):
        make()
