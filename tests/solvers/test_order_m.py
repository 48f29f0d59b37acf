"""The energy-consistent damper of order m in both solvers: exact in free decay, second order, and CR as m grows."""

import numpy as np
import pytest
from exact_cases import cr_peaks

from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.damping.ecd import DOUBLED_ORDERS
from rockdamp.solvers.exact import exact_history
from rockdamp.solvers.newmark import solve

ORDERS = (0, 1, 2.5, 8, 32)
CURVES = {
    "paper": TrilinearCurve(0.04, 0.85),
    "severe": TrilinearCurve(0.20, 0.50),
    "steeper": TrilinearCurve(0.06, 0.72, 0.9, "steeper"),
    "translated": TrilinearCurve(0.04, 0.85, 0.9, "translated"),
}


def pulse(step, amplitude=1.1, length=1.5, end=8.0):
    """One sine of the load, sampled at `step`."""
    tau = np.arange(round(end / step) + 1) * step
    return np.where(tau < length, amplitude * np.sin(2 * np.pi * tau / length), 0.0)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
def test_every_peak_of_the_free_decay_is_cr_s_from_any_amplitude(order, curve):
    for e, share in ((0.7, 0.9), (0.9, 0.02)):
        x0 = share * float(curve.ultimate_displacement_ratio)
        end = 1.5 * float(curve.period(x0))
        run = exact_history(curve, Damping.of_restitution(e, order=order), [end], release_amplitude=x0)
        peaks = np.abs(run.turning_displacement)
        assert peaks.size >= 2
        np.testing.assert_allclose(peaks, cr_peaks(curve, e, x0, peaks.size), rtol=1e-9)


def test_as_the_order_grows_the_response_under_a_load_tends_to_restitution():
    sample, load = 0.005, pulse(0.005)
    run = {
        "step": sample / 4,
        "steps": 4 * (load.size - 1),
        "ground_acceleration": load,
        "load_factor": 1.0,
        "substeps": 4,
        "store_every": 4,
    }
    for curve in CURVES.values():
        impact = solve(curve, Damping.cr(0.85), **run).displacement
        away = [
            np.sqrt(np.mean((solve(curve, Damping.of_restitution(0.85, order=m), **run).displacement - impact) ** 2))
            for m in (8, 64, 512)
        ]
        assert away[0] > 2 * away[1] > 4 * away[2] > 0


def first_branch(order, e, step, steps):
    """Decays that never leave the first branch, from many amplitudes, so that crossings meet the step anywhere."""
    curve = TrilinearCurve(0.4, 0.5)
    w1, amplitude = float(curve.initial_frequency), np.linspace(0.2, 0.3, 40)
    damping = Damping.of_restitution(e, order=order)
    run = solve(curve, damping, step=step / w1, steps=steps, release_amplitude=amplitude, store_every=1)
    return amplitude, run.displacement, np.hypot(run.displacement, run.velocity / w1)


@pytest.mark.parametrize("order", [0, 1, 16, 64])
@pytest.mark.parametrize("e", [0.5, 0.95])
def test_every_order_is_stable_up_to_the_limit_of_the_undamped_wall(order, e):
    for step in (0.3, 0.8, 1.2, 1.6, 1.98):  # w1 h
        amplitude, x, _ = first_branch(order, e, step, 400)
        assert np.abs(x).max() < 0.4
        assert (np.abs(x[:, -60:]).max(axis=1) <= amplitude).all()


@pytest.mark.parametrize("e", [0.85, 0.95])
def test_the_step_that_an_order_needs(e):
    """The decrement of eight half cycles, by the energy at the eighth turning point, where the damper takes nothing."""
    worst = {}
    for order in (0, 1, 4, 16, 32):
        for step in (0.1, 0.05, 0.025):
            amplitude, x, size = first_branch(order, e, step, int(8.9 * np.pi / step))
            away = np.abs(x)
            for wall in range(amplitude.size):
                inner = away[wall, 1:-1]
                turns = 1 + np.flatnonzero((inner >= away[wall, :-2]) & (inner > away[wall, 2:]))
                lost = np.log(size[wall, turns[7]] / amplitude[wall]) / (8 * np.log(e))
                worst[order] = max(worst.get(order, 0.0), abs(lost - 1) / step**2)
    assert 0.25 < max(worst.values()) < 0.30 and worst[0] == pytest.approx(0.042, abs=0.003)
    assert worst[0] < worst[1] < worst[4] < worst[16]


def test_an_order_by_multiplications_is_the_power_of_any_order():
    curve, x = CURVES["paper"], np.array([0.01, 0.04, 0.3, 0.7])
    v = np.array([[0.0], [0.1], [-0.4]])
    for m in DOUBLED_ORDERS:
        squared = Damping("ECD", 0.05, order=m)
        power = Damping("ECD", 0.05, order=np.full((3, 1), [[m], [m], [m + 0.5]]))
        assert squared.formula is not power.formula
        np.testing.assert_allclose(squared.coefficient(curve, x, v)[:2], power.coefficient(curve, x, v)[:2], rtol=1e-13)


def test_of_restitution_takes_the_models_that_need_no_fit():
    assert Damping.of_restitution(0.85, "CR").restitution == 0.85
    with pytest.raises(
        InputError, match="damping_model is 'CDR'; it must be one of CR, ECD, .*: the others need a fit"
    ):
        Damping.of_restitution(0.85, "CDR")
    with pytest.raises(InputError, match=r"restitution \(e\) is 1.2"):
        Damping.of_restitution(1.2, order=8)
