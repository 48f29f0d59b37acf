"""Free motion in closed form, against its equation, the period and the event-driven solver."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.free_motion import displacement_from_peak, rigid_period
from rockdamp.solvers.exact import exact_history

CURVES = [
    TrilinearCurve(0.05, 0.8),
    TrilinearCurve(0.02, 0.9),
    TrilinearCurve(0.1, 0.6, 0.8),
    TrilinearCurve(0.06, 0.5, 0.7, "translated"),
]


@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize("share", [0.02, 0.2, 0.6, 0.95])
def test_free_motion_solves_its_equation(curve, share):
    x0 = share * float(curve.ultimate_displacement_ratio)
    quarter = float(curve.period(x0)) / 4
    tau = np.linspace(0, quarter, 25)
    x = displacement_from_peak(curve, x0, tau)
    exact = solve_ivp(
        lambda _, y: [y[1], -float(curve.force(y[0]))],
        (0, quarter),
        [x0, 0],
        t_eval=tau,
        rtol=1e-10,
        atol=1e-13,
    )
    np.testing.assert_allclose(x, exact.y[0], atol=1e-7)
    assert x[0] == pytest.approx(x0) and abs(x[-1]) < 1e-12
    np.testing.assert_array_equal(displacement_from_peak(curve, x0, -tau), x)


def test_joined_excursions_are_the_decay_of_the_event_driven_solver():
    """An impact multiplies sqrt(V) by e; between two of them the motion is free."""
    curve, e, x0 = CURVES[0], 0.85, 0.5
    tau = np.linspace(0, 12, 400)
    history = exact_history(curve, Damping("CR", e), tau, release_amplitude=x0).displacement
    amplitude = curve.amplitude(curve.energy(x0) * e ** (2.0 * np.arange(12)))
    quarter = curve.period(amplitude) / 4
    crossing = quarter[0] + np.concatenate([[0], np.cumsum(2 * quarter[1:])])
    peak = np.concatenate([[0.0], crossing[:-1] + quarter[1:]])
    index = np.searchsorted(crossing, tau)
    x = (-1.0) ** index * displacement_from_peak(curve, amplitude[index], tau - peak[index])
    np.testing.assert_allclose(x, history, atol=1e-8)


def test_rigid_period_is_the_limit_of_a_nearly_rigid_curve():
    nearly_rigid = TrilinearCurve(2e-5, 1 - 4e-5)
    for x0 in (0.1, 0.5, 0.9):
        assert rigid_period(x0) == pytest.approx(float(nearly_rigid.period(x0)), rel=1e-3), x0
