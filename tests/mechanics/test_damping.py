"""The damping models' coefficients against the paper's equations, what ECD has in closed form, and bad input."""

import mpmath
import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad

from rockdamp.constants import PAPER_MODELS
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.dampers import CAP, DAMPERS, critical_damping_ratio, normalisation
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.coefficient import damping_coefficient

CURVE = TrilinearCurve(0.06, 0.72, 0.9)
X = np.array(
    [-0.95, -0.7, -0.2, -0.06, -0.01, 0.0, 1e-9, 0.03, 0.06, 0.15, 0.28, 0.5, 0.89, 0.9, 1.2]
)
XI = 0.07


# --- the coefficients -------------------------------------------------------------------------------------------------


def test_the_paper_s_three_coefficients_are_eqs_10_11_and_12():
    with np.errstate(divide="ignore", invalid="ignore"):
        w = np.sqrt(np.where(X == 0, CURVE.initial_stiffness, CURVE.force(X) / X))  # Eq. (9)
    w1 = CURVE.initial_frequency
    expected = {
        "CDC": 2 * w1 * XI * np.ones_like(X),
        "CDR": 2 * w * XI,
        "SDR": 2 * w * (XI * w / w1),
    }
    for model in PAPER_MODELS:
        np.testing.assert_allclose(
            damping_coefficient(CURVE, Damping(model, XI), X),
            expected[model],
            rtol=1e-14,
            atol=1e-300,
        )


def test_the_energy_consistent_coefficient_holds_the_force_over_the_root_of_the_stored_energy():
    for x in (0.02, 0.06, 0.2, 0.5, 0.85):
        energy, _ = quad(CURVE.force, 0, x, points=[0.06, 0.28], epsabs=1e-13)
        expected = 2 * XI * CURVE.force(x) / np.sqrt(2 * energy)
        assert damping_coefficient(CURVE, Damping("ECD", XI), [x, -x]) == pytest.approx(
            [expected, expected], rel=1e-11
        )


def test_dampers_are_the_linear_oscillator_s_on_the_first_branch_and_cdc_alone_damps_beyond_the_end():
    inside = CURVE.yield_displacement_ratio * np.array([0.0, 1e-200, 1e-12, 0.3, 1.0])
    for model in (*PAPER_MODELS, "ECD"):
        expected = 2 * CURVE.initial_frequency * XI
        np.testing.assert_allclose(
            damping_coefficient(CURVE, Damping(model, XI), inside), expected, rtol=1e-14
        )
        assert (damping_coefficient(CURVE, Damping(model, XI), 1.5) > 0) == (model == "CDC")


def test_coefficients_broadcast_and_restitution_has_none():
    curves = TrilinearCurve(np.array([0.02, 0.05])[:, None, None], 0.8)
    for model in DAMPERS:
        many = damping_coefficient(
            curves, Damping(model, np.array([0.02, 0.05, 0.1])[:, None]), X, 0.2
        )
        one = damping_coefficient(TrilinearCurve(0.05, 0.8), Damping(model, 0.05), X, 0.2)
        assert many.shape == (2, 3, X.size) and many.any() == (model != "CR")
        np.testing.assert_allclose(many[1, 1], one, rtol=1e-14)


def test_every_order_has_the_formula_of_any_order_is_finite_and_does_not_feed_energy_in():
    x, v = np.linspace(-0.9, 0.9, 181)[:, None], np.linspace(-2, 2, 81)
    for order in (0, 0.5, 1, 2, 4, 8, 16, 32, 64, 128):
        mixed = np.array([order, 7.0])[:, None, None]
        for xi in (0.05, 1.2, 5.0):
            c = damping_coefficient(CURVE, Damping("ECD", xi, order=order), x, v)
            assert np.isfinite(c).all() and (c >= 0).all()
            other = damping_coefficient(CURVE, Damping("ECD", xi, order=mixed), x, v)[0]
            np.testing.assert_allclose(c, other, rtol=1e-12, atol=1e-300)


# --- ECD in closed form -----------------------------------------------------------------------------------------------


def test_the_normalisation_is_half_pi_over_the_integral_of_the_cosine_s_power_at_any_order():
    phi = sp.symbols("phi", real=True)
    for order in range(7):
        integral = sp.integrate(sp.cos(phi) ** (2 * order + 2), (phi, -sp.pi / 2, sp.pi / 2))
        assert float(normalisation(order)) == pytest.approx(float(sp.pi / 2 / integral), rel=1e-14)
    orders = np.array([0, 1e-9, 0.25, 0.5, 1.7, 12.3, 64, 169.5, 1000])
    with mpmath.workdps(30):
        half_root = mpmath.sqrt(mpmath.pi) / 2
        expected = [
            float(half_root * mpmath.gammaprod([m + 2], [m + mpmath.mpf(3) / 2])) for m in orders
        ]
    np.testing.assert_allclose(normalisation(orders), expected, rtol=2e-12)
    assert normalisation(0) == 1.0  # to the bit: order 0 is ECD


def test_the_ratio_is_delta_over_pi_and_that_of_order_zero_the_linear_oscillator_s():
    e = np.array([0.1, 0.5, 0.85, 0.999, 1.0])
    delta, orders = -np.log(e), np.array([[0.0], [0.5], [16.0]])
    xi = Damping.from_restitution(e, "ECD", order=orders).value
    np.testing.assert_allclose(xi[0], delta / np.sqrt(np.pi**2 + delta**2))
    np.testing.assert_allclose(xi[1:], np.broadcast_to(delta / np.pi, (2, 5)))
    np.testing.assert_array_equal(Damping.from_restitution(e[1:]).value, xi[1, 1:])
    assert Damping.from_restitution(0.85, "CR").value == 0.85 and Damping("CR", 0.0).value == 0


@pytest.mark.parametrize("order", [0.5, 1, 16])
def test_an_e_that_the_cap_would_touch_is_refused(order):
    least = float(np.exp(-CAP * np.pi * critical_damping_ratio(order)))
    assert Damping.from_restitution(1.001 * least, "ECD", order=order).value > 0
    with pytest.raises(InputError, match="restitution"):
        Damping.from_restitution(0.999 * least, "ECD", order=order)


# --- parameters -------------------------------------------------------------------------------------------------------


def test_the_defaults_the_label_and_the_shape():
    labels = {
        "ECD": Damping("ECD", XI),
        "ECD16": Damping("ECD", XI, order=16),
        "BAND": Damping("BAND", XI),
        "BAND0.4": Damping("BAND", XI, width=0.4),
        "CQD": Damping("CQD", XI),
        "CR": Damping("CR", 0.9, loss_exponent=0.1),
    }
    for label, damping in labels.items():
        assert damping.label == label and damping.shape == ()
    assert (
        labels["BAND"].width == 0.2
        and labels["CQD"].width == 0.25
        and labels["CR"].reference_amplitude == 0.3
    )
    many = Damping("ECD", [XI, XI], order=[[1.0], [2.0], [3.0]])
    assert (
        many.shape == (3, 2)
        and many.label == "ECD"
        and many.map(lambda values: values[:, :1]).shape == (3, 1)
    )


BAD = [
    ("damping_model", lambda: Damping("CRD", 0.9)),
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


@pytest.mark.parametrize(("name", "make"), BAD)
def test_bad_damping_is_refused_with_the_name(name, make):
    with pytest.raises(InputError, match=name):
        make()
