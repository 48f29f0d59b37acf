"""The closed form between restitution and damping ratio."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rockdamp.equivalence.closed_form import (
    damping_ratio_energy,
    equivalence_factor,
    exact_ratio,
    giannini_masiani,
)
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import solve
from rockdamp.vocabulary import PAPER_MODELS, VISCOUS_MODELS

CURVES = [
    TrilinearCurve(0.04, 0.85),
    TrilinearCurve(0.02, 0.80, 0.9, "steeper"),
    TrilinearCurve(0.06, 0.72, 0.9, "translated"),
    TrilinearCurve(0.20, 0.50),
]
QUADRATURES = [Damping(model, 1.0) for model in (*PAPER_MODELS, "ECD")]


def factor_by_mpmath(curve, damping, x0):
    """g by adaptive quadrature of the integral as it stands, split at the corners."""
    k1, b1, ks, a1, a2, a3 = (mpmath.mpf(float(p)) for p in curve.parameters())

    def f(x):
        return max(min(k1 * x, b1, ks * (a3 - x)), 0)

    def v(x):
        y1, y2 = min(x, a1), min(max(x, a1), a2)
        y3 = max(x, a2)
        return k1 * y1**2 / 2 + b1 * (y2 - a1) + ks * (y3 - a2) * (2 * a3 - a2 - y3) / 2

    def c(x):
        if damping.model == "ECD":
            return 2 * f(x) / mpmath.sqrt(2 * v(x))
        n = {"CDC": 0, "CDR": 1, "SDR": 2}[damping.model]
        return 2 * mpmath.sqrt(k1) * (f(x) / x / k1) ** (mpmath.mpf(n) / 2)

    x0 = mpmath.mpf(x0)
    v0 = v(x0)
    edges = [mpmath.mpf(0), *sorted(p for p in (a1, a2) if p < x0), x0]
    work = mpmath.quad(lambda x: c(x) * mpmath.sqrt(2 * abs(v0 - v(x))), edges)
    return float(v0 / work)


@pytest.mark.parametrize("curve", CURVES, ids=lambda c: f"a1={c.yield_displacement_ratio}")
@pytest.mark.parametrize("damping", QUADRATURES, ids=lambda damping: damping.model)
@pytest.mark.parametrize("x0", [0.03, 0.3, 0.85])
def test_the_factor_equals_adaptive_quadrature(curve, damping, x0):
    assert float(equivalence_factor(curve, damping, x0)) == pytest.approx(
        factor_by_mpmath(curve, damping, x0), rel=1e-9
    )


@settings(max_examples=50, deadline=None)
@given(
    a1=st.floats(0.005, 0.14),
    b1=st.floats(0.3, 0.85),
    share=st.floats(0.001, 0.999),
    softening=st.sampled_from(["steeper", "translated"]),
)
def test_the_energy_consistent_damper_has_the_factor_one_over_pi_of_any_curve(a1, b1, share, softening):
    a3 = 1.0 if softening == "steeper" else min(1.0, a1 + b1 + 0.5 * (1 - a1 - b1) + 1e-3)
    curve = TrilinearCurve(a1, b1, a3, softening)
    factor = float(equivalence_factor(curve, Damping("ECD", 1.0), share * a3))
    assert factor == pytest.approx(1 / np.pi, rel=1e-9)


@pytest.mark.parametrize("model", VISCOUS_MODELS)
@pytest.mark.parametrize("x0", [0.1, 0.5, 0.9])
def test_the_factor_is_what_a_lightly_damped_half_cycle_loses(model, x0):
    """xi g^-1 is the logarithmic decrement of sqrt(V) over a half cycle, to first order in xi: error O(xi)."""
    curve, xi, step = CURVES[0], 1e-3, 5e-4
    half = float(curve.period(x0)) / 2
    steps = int(1.1 * half / step)
    response = solve(curve, Damping(model, xi), release_amplitude=x0, step=step, steps=steps, store_every=1)
    peak = -response.displacement.min()
    decrement = -0.5 * np.log(curve.energy(peak) / curve.energy(x0))
    assert decrement * float(equivalence_factor(curve, Damping(model, 1.0), x0)) == pytest.approx(xi, rel=0.02)


def test_the_closed_form_is_proportional_to_the_logarithm_of_restitution():
    e = np.array([0.7, 0.8, 0.9])
    ratio = damping_ratio_energy(CURVES[0], "CDR", e, 0.5) / -np.log(e)
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-14)


def test_giannini_and_masiani_agree_with_the_exact_ratio_where_the_loss_is_small():
    e = 1 - 1e-4
    assert float(giannini_masiani(e)) == pytest.approx(float(exact_ratio(e)), rel=1e-4)


@pytest.mark.parametrize("e", [0.0, -0.1, 1.01, np.nan])
def test_a_restitution_outside_its_range_is_named(e):
    with pytest.raises(InputError, match=r"restitution \(e\)"):
        exact_ratio(e)


def test_restitution_has_no_viscous_factor():
    with pytest.raises(InputError, match="viscous"):
        equivalence_factor(CURVES[0], Damping.cr(0.9), 0.5)


@pytest.mark.parametrize("x0", [0.0, 1.0, -0.5])
def test_an_amplitude_without_a_half_cycle_is_named(x0):
    with pytest.raises(InputError, match="release_amplitude"):
        equivalence_factor(CURVES[0], Damping("CDR", 1.0), x0)
