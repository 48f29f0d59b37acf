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


def factor_by_mpmath(curve, model, x0):
    """g by adaptive quadrature of the integral as it stands, split at the corners."""
    k1, b1, ks, a1, a2, a3 = (mpmath.mpf(float(value)) for value in curve.parameters())

    def f(x):
        return max(min(k1 * x, b1, ks * (a3 - x)), 0)

    def v(x):
        y1, y2, y3 = min(x, a1), min(max(x, a1), a2), max(x, a2)
        return k1 * y1**2 / 2 + b1 * (y2 - a1) + ks * (y3 - a2) * (2 * a3 - a2 - y3) / 2

    def c(x):
        if model == "ECD":
            return 2 * f(x) / mpmath.sqrt(2 * v(x))
        n = {"CDC": 0, "CDR": 1, "SDR": 2}[model]
        return 2 * mpmath.sqrt(k1) * (f(x) / x / k1) ** (mpmath.mpf(n) / 2)

    x0 = mpmath.mpf(x0)
    v0 = v(x0)
    edges = [mpmath.mpf(0), *sorted(p for p in (a1, a2) if p < x0), x0]
    return float(v0 / mpmath.quad(lambda x: c(x) * mpmath.sqrt(2 * abs(v0 - v(x))), edges))


@pytest.mark.parametrize("curve", CURVES, ids=lambda c: f"a1={c.yield_displacement_ratio}")
@pytest.mark.parametrize("model", ["CDC", "CDR", "SDR", "ECD"])
def test_the_factor_equals_adaptive_quadrature_and_of_ecd_it_is_one_over_pi(curve, model):
    x0 = np.array([0.03, 0.3, 0.85])
    factor = equivalence_factor(curve, Damping(model, 1.0), x0)
    np.testing.assert_allclose(
        factor, [factor_by_mpmath(curve, model, one) for one in x0], rtol=1e-9
    )
    if model == "ECD":
        np.testing.assert_allclose(factor, 1 / np.pi, rtol=1e-9)
    alone = [equivalence_factor(curve, Damping(model, 1.0), one).item() for one in x0]
    assert factor.tolist() == alone  # to the last bit


@pytest.mark.parametrize("model", VISCOUS_MODELS)
@pytest.mark.parametrize("x0", [0.1, 0.5, 0.9])
def test_the_factor_is_what_a_lightly_damped_half_cycle_loses(model, x0):
    """xi g^-1 is the logarithmic decrement of sqrt(V) over a half cycle, to first order in xi: error O(xi)."""
    curve, xi, step = CURVES[0], 1e-3, 5e-4
    steps = int(0.55 * float(curve.period(x0)) / step)
    response = simulate(curve, Damping(model, xi), release_amplitude=x0, step=step, steps=steps)
    decrement = -0.5 * np.log(curve.energy(-response.displacement.min()) / curve.energy(x0))
    assert decrement * equivalence_factor(curve, Damping(model, 1.0), x0).item() == pytest.approx(
        xi, rel=0.02
    )


def test_the_ratio_is_the_factor_times_the_logarithm_and_exact_for_ecd_and_band():
    e = np.array([[0.7], [0.9], [1.0]])
    x0, delta = np.array([0.1, 0.5]), -np.log(e)
    ratio = {model: damping_ratio_energy(CURVES[0], model, e, x0) for model in VISCOUS_MODELS}
    for model in ("CDC", "CDR", "SDR"):
        factor = equivalence_factor(CURVES[0], Damping(model, 1.0), x0)
        np.testing.assert_allclose(ratio[model], delta * factor, rtol=1e-14)
    np.testing.assert_allclose(ratio["ECD"], np.tile(delta / np.hypot(np.pi, delta), 2), rtol=1e-14)
    np.testing.assert_allclose(ratio["BAND"], np.tile(delta / np.pi, 2), rtol=1e-14)


def test_giannini_and_masiani_is_eq_15_and_tends_to_the_exact_ratio():
    np.testing.assert_allclose(giannini_masiani([0.5, 1.0]), [2 / (3 * np.pi), 0.0], rtol=1e-15)
    e = 1 - 1e-4
    assert giannini_masiani(e).item() == pytest.approx(-np.log(e) / np.pi, rel=1e-4)


@pytest.mark.parametrize(
    ("compute", "named"),
    [
        *((lambda e=e: giannini_masiani(e), "restitution") for e in (0.0, 1.01)),
        (lambda: damping_ratio_energy(CURVES[0], "CDR", 1.01, 0.5), "restitution"),
        (lambda: equivalence_factor(CURVES[0], Damping("CR", 0.9), 0.5), "damping_model"),
        *(
            (
                lambda x0=x0: equivalence_factor(CURVES[0], Damping("CDR", 1.0), x0),
                "release_amplitude",
            )
            for x0 in (0, 1)
        ),
    ],
)
def test_what_is_outside_its_range_is_named(compute, named):
    with pytest.raises(InputError, match=named):
        compute()
