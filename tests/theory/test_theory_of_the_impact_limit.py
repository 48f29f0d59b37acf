"""Theory of ECD of order m as m grows, docs/theory.md: the limit is restitution, also under load, at a known rate."""

import numpy as np
import pytest
from order_m_motion import of_restitution
from scipy.integrate import cumulative_trapezoid, quad, solve_ivp
from scipy.special import erf


def after_crossing(e, order, load, slope=0.0, end=1.3):
    """(y, v) of a linear spring at a time after its crossing, less the same with an impact; omega_1 is 1."""
    start = [np.sin(-0.6), np.cos(-0.6)]
    accuracy = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15}
    a = of_restitution(e, order).amplitude

    def damped(t, s):
        y, v = s.tolist()
        total = y * y + v * v
        q = a * (v * v / total) ** order
        return v, load + slope * t - y - q * v / (1 - q * y * v / total)

    def free(t, s):
        return s[1], load + slope * t - s[0]

    def crossing(_, s):
        return s[0]

    crossing.terminal = True
    found = solve_ivp(damped, (0, end), start, max_step=0.05 / np.sqrt(order), **accuracy).y[:, -1]
    before = solve_ivp(free, (0, end), start, events=crossing, max_step=0.05, **accuracy)
    time, speed = before.t[-1], before.y[1, -1]
    impact = solve_ivp(free, (time, end), [0.0, e * speed], **accuracy)
    return found - impact.y[:, -1], end - time, speed


def layer_integral(e):
    """The integral of the limit, of the change of speed."""
    delta = -np.log(e)

    def change(z):
        band = delta / np.sqrt(np.pi) * z * np.exp(-z * z)
        return np.exp(delta / 2 * erf(z)) * (1 - band) ** 2 - np.exp(np.copysign(delta / 2, z))

    return quad(change, -8, 8, points=[0.0])[0]


def test_without_the_denominator_the_error_under_load_is_smaller():
    """The same integral for d ln r/dz = -a exp(-z^2)/(1 + a z exp(-z^2)): -(1/2) delta^2/sqrt(2 pi)."""
    z, delta = np.linspace(-8, 8, 160001), 0.1
    a = delta / np.sqrt(np.pi)
    divisor = 1 + a * z * np.exp(-z * z)
    loss = cumulative_trapezoid(a * np.exp(-z * z) / divisor, z, initial=0)
    change = np.exp(loss - loss[-1] / 2) / divisor**2 - np.exp(np.sign(z) * loss[-1] / 2)
    assert np.trapezoid(change, z) == pytest.approx(-0.5 * loss[-1] ** 2 / np.sqrt(2 * np.pi), rel=0.02)


@pytest.mark.parametrize(("e", "load"), [(0.95, 0.0), (0.85, 0.3), (0.7, 0.3), (0.7, -0.2)])
def test_after_a_crossing_under_load_the_error_falls_like_one_over_the_root_of_m(e, load):
    delta = -np.log(e)
    change = layer_integral(e)
    assert change == pytest.approx(-(5 / 4) * delta**2 / np.sqrt(2 * np.pi), rel=0.3 * delta**2)  # and even in delta
    orders = np.array([1024.0, 4096.0, 16384.0])
    runs = [after_crossing(e, order, load) for order in orders]
    scaled = np.array([run[0] for run in runs]) * np.sqrt(orders)[:, None]
    once = 2 * scaled[1:] - scaled[:-1]  # extrapolated in 1/sqrt(m), twice
    measured = (4 * once[1] - once[0]) / 3
    _, since, speed = runs[0]
    mean = speed * np.sqrt(e)
    gained = change * load / mean * speed * e  # of the speed at the crossing
    expected = [gained * np.sin(since), gained * np.cos(since)]  # and no delay
    np.testing.assert_allclose(measured, expected, atol=1e-3 * np.abs(expected).max() + 1e-9)


def test_at_small_losses_the_error_under_load_falls_like_one_over_m():
    away = [np.linalg.norm(after_crossing(0.999, order, 0.3, 0.5)[0]) for order in (64, 256, 1024)]
    np.testing.assert_allclose(np.divide(away[:-1], away[1:]), 4, rtol=0.1)
    away = [np.linalg.norm(after_crossing(0.85, order, 0.3, 0.5)[0]) for order in (8, 16, 32)]
    np.testing.assert_allclose(np.divide(away[:-1], away[1:]), [1.7, 1.9], atol=0.06)  # at the orders in use


def test_a_start_from_rest_at_the_crossing_costs_velocity_like_one_over_the_root_of_m():
    """A linear spring with omega_1 = 1 under a constant load, from rest: y is behind by 2 delta p/sqrt(pi m) sin."""
    e, load, end = 0.999, 0.3, np.pi / 2
    scaled = []
    for order in (256, 1024, 4096):
        a = of_restitution(e, order).amplitude

        def rates(_, s, a=a, order=order):
            y, v = s.tolist()
            total = y * y + v * v
            q = a * (v * v / total) ** order if total else 0.0
            return v, load - y - q * v / (1 - (q * y * v / total if total else 0.0))

        run = solve_ivp(rates, (0, end), [0, 0], "DOP853", rtol=1e-12, atol=1e-15, max_step=0.05 / np.sqrt(order))
        scaled.append((load - run.y[0, -1]) * np.sqrt(order))
    first = 2 * scaled[1] - scaled[0], 2 * scaled[2] - scaled[1]  # what is left is of the order of 1/m
    assert (4 * first[1] - first[0]) / 3 == pytest.approx(2 * -np.log(e) * load / np.sqrt(np.pi), rel=2e-3)
