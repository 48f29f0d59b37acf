"""The closed form between restitution and damping ratio."""

import mpmath
import numpy as np
import pytest

from rockdamp.constants import VISCOUS_MODELS
from rockdamp.equivalence.closed_form import (
    damping_ratio_energy,
    equivalence_factor,
    giannini_masiani,
)
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import simulate

CURVES = [
    TrilinearCurve(0.04, 0.85),
    TrilinearCurve(0.02, 0.80, 0.9, "steeper"),
    TrilinearCurve(0.06, 0.72, 0.9, "translated"),
    TrilinearCurve(0.20, 0.50),
]
PAPER = CURVES[0]
EXPONENTS = {"CDC": 0, "CDR": 1, "SDR": 2}
every_curve = pytest.mark.parametrize(
    "curve", CURVES, ids=lambda curve: f"a1={curve.yield_displacement_ratio}"
)
continuous = pytest.mark.parametrize("model", [*EXPONENTS, "ECD"])


def factor(curve, model, x0):
    return equivalence_factor(curve, Damping(model, 1.0), x0)


def factor_by_mpmath(curve, model, x0):
    """Return g by adaptive quadrature of the integral as it stands, split at the corners."""
    k1, b1, ks, a1, a2, a3 = (mpmath.mpf(float(value)) for value in curve.parameters())

    def force(x):
        return max(min(k1 * x, b1, ks * (a3 - x)), 0)

    def energy(x):
        y1 = min(x, a1)
        y2 = min(max(x, a1), a2)
        y3 = max(x, a2)
        return k1 * y1**2 / 2 + b1 * (y2 - a1) + ks * (y3 - a2) * (2 * a3 - a2 - y3) / 2

    def coefficient(x):
        if model == "ECD":
            return 2 * force(x) / mpmath.sqrt(2 * energy(x))
        n = mpmath.mpf(EXPONENTS[model])
        return 2 * mpmath.sqrt(k1) * (force(x) / x / k1) ** (n / 2)

    x0 = mpmath.mpf(x0)
    v0 = energy(x0)

    def power(x):
        return coefficient(x) * mpmath.sqrt(2 * abs(v0 - energy(x)))

    corners = [corner for corner in (a1, a2) if corner < x0]
    return float(v0 / mpmath.quad(power, [mpmath.mpf(0), *corners, x0]))


@every_curve
@continuous
def test_factor_against_adaptive_quadrature(curve, model):
    x0 = np.array([0.03, 0.3, 0.85])
    expected = [factor_by_mpmath(curve, model, value) for value in x0]
    np.testing.assert_allclose(factor(curve, model, x0), expected, rtol=1e-9)


@every_curve
@continuous
def test_factor_of_an_array_to_the_last_bit(curve, model):
    x0 = np.array([0.03, 0.3, 0.85])
    single = [factor(curve, model, value).item() for value in x0]
    assert factor(curve, model, x0).tolist() == single


@every_curve
def test_factor_of_ecd_is_one_over_pi(curve):
    np.testing.assert_allclose(factor(curve, "ECD", [0.03, 0.3, 0.85]), 1 / np.pi, rtol=1e-9)


@pytest.mark.parametrize("model", VISCOUS_MODELS)
@pytest.mark.parametrize("x0", [0.1, 0.5, 0.9])
def test_loss_of_a_lightly_damped_half_cycle(model, x0):
    """xi/g is the logarithmic decrement of sqrt(V) over a half cycle, to first order in xi."""
    xi, step = 1e-3, 5e-4
    steps = int(0.55 * float(PAPER.period(x0)) / step)
    response = simulate(PAPER, Damping(model, xi), release_amplitude=x0, step=step, steps=steps)
    peak = -response.displacement.min()
    decrement = -0.5 * np.log(PAPER.energy(peak) / PAPER.energy(x0))
    assert decrement * factor(PAPER, model, x0).item() == pytest.approx(xi, rel=0.02)


RESTITUTION = np.array([[0.7], [0.9], [1.0]])
DELTA = -np.log(RESTITUTION)
AMPLITUDES = np.array([0.1, 0.5])


@pytest.mark.parametrize("model", EXPONENTS)
def test_ratio_is_the_factor_times_delta(model):
    ratio = damping_ratio_energy(PAPER, model, RESTITUTION, AMPLITUDES)
    expected = DELTA * factor(PAPER, model, AMPLITUDES)
    np.testing.assert_allclose(ratio, expected, rtol=1e-14)


@pytest.mark.parametrize(
    ("model", "exact"), [("ECD", DELTA / np.hypot(np.pi, DELTA)), ("BAND", DELTA / np.pi)]
)
def test_ratio_of_ecd_and_band_is_exact(model, exact):
    ratio = damping_ratio_energy(PAPER, model, RESTITUTION, AMPLITUDES)
    np.testing.assert_allclose(ratio, np.tile(exact, 2), rtol=1e-14)


def test_giannini_masiani_is_eq_15():
    expected = [2 / (3 * np.pi), 0.0]
    np.testing.assert_allclose(giannini_masiani([0.5, 1.0]), expected, rtol=1e-15)


def test_giannini_masiani_tends_to_the_exact_ratio():
    e = 1 - 1e-4
    assert giannini_masiani(e).item() == pytest.approx(-np.log(e) / np.pi, rel=1e-4)


@pytest.mark.parametrize("e", [0.0, 1.01])
def test_bad_restitution_is_refused(e):
    with pytest.raises(InputError, match="restitution"):
        giannini_masiani(e)
    with pytest.raises(InputError, match="restitution"):
        damping_ratio_energy(PAPER, "CDR", e, 0.5)


def test_factor_of_restitution_is_refused():
    with pytest.raises(InputError, match="damping_model"):
        equivalence_factor(PAPER, Damping("CR", 0.9), 0.5)


@pytest.mark.parametrize("x0", [0, 1])
def test_bad_amplitude_is_refused(x0):
    with pytest.raises(InputError, match="release_amplitude"):
        factor(PAPER, "CDR", x0)
