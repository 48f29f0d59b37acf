"""Theory of ECD of order m as m grows, docs/theory.md: the limit is restitution, also under load, at a known rate."""

import numpy as np
import pytest
from order_m import of_restitution
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq
from scipy.special import beta

from rockdamp.mechanics.half_cycle_loss import log_decrement, normalisation


def test_the_decrement_has_a_limit_that_is_approached_like_one_over_m():
    def limit(xi):
        a = xi * np.sqrt(np.pi)
        return quad(lambda z: a * np.exp(-z * z) / (1 - (a * z * np.exp(-z * z)) ** 2), -8, 8, points=[-0.7, 0, 0.7])[0]

    for xi in (0.05, 0.4, 0.9):
        away = log_decrement(xi, np.array([64.0, 128.0, 256.0])) / limit(xi) - 1
        np.testing.assert_allclose(away[:-1] / away[1:], 2, rtol=0.02)
        assert abs(away[-1]) < 2e-3
    third = [(2 * float(normalisation(m))) ** 3 / np.pi * beta(1.5, 3 * m + 2.5) for m in (0, 1e6)]
    np.testing.assert_allclose(third, [0.5, np.pi / (6 * np.sqrt(3))], rtol=1e-5)


def after_crossing(e, order, load, slope=0.0, end=1.3):
    """(y, v) of a linear spring at a time after its crossing, less the same with an impact; omega_1 is 1."""
    start = [np.sin(-0.6), np.cos(-0.6)]
    accuracy = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15}
    a = of_restitution(e, order).amplitude

    def damped(t, s):
        y, v = s.tolist()
        return v, load + slope * t - y - a * v * (v * v / (y * y + v * v)) ** order

    def free(t, s):
        return s[1], load + slope * t - s[0]

    def crossing(_, s):
        return s[0]

    crossing.terminal = True
    found = solve_ivp(damped, (0, end), start, max_step=0.05 / np.sqrt(order), **accuracy).y[:, -1]
    before = solve_ivp(free, (0, end), start, events=crossing, max_step=0.05, **accuracy)
    time, speed = before.t[-1], before.y[1, -1]
    impact = solve_ivp(free, (time, end), [0.0, e * speed], **accuracy)
    return found - impact.y[:, -1], end - time, speed, impact.y[:, -1]


def layer_integrals(e):
    """The two integrals of the limit: of the delay and of the change of speed."""
    delta = -np.log(e)

    def decrement(a):
        return quad(lambda z: a * np.exp(-z * z) / (1 - (a * z * np.exp(-z * z)) ** 2), -8, 8, points=[-0.7, 0, 0.7])[0]

    a = brentq(lambda a: decrement(a) - delta, 0, 2.3)
    z = np.linspace(-8, 8, 160001)
    band = a * z * np.exp(-z * z)
    rate = a * np.exp(-z * z) / (1 + band)
    step = z[1] - z[0]
    ln_r = -np.concatenate([[0], np.cumsum((rate[1:] + rate[:-1]) / 2 * step)])  # from v_- on
    impact = np.where(z < 0, np.exp(-delta / 2), np.exp(delta / 2))  # mean speed over v_-, v_+
    impact[z == 0] = np.cosh(delta / 2)
    return np.sum(band**2 / (1 - band**2)) * step, np.sum(np.exp(-delta / 2 - ln_r) / (1 + band) ** 2 - impact) * step


@pytest.mark.parametrize(("e", "load"), [(0.95, 0.0), (0.85, 0.3), (0.7, 0.3), (0.7, -0.2)])
def test_after_a_crossing_under_load_the_error_falls_like_one_over_the_root_of_m(e, load):
    delta = -np.log(e)
    delay, change = layer_integrals(e)
    assert delay == pytest.approx(delta**2 / 4 / np.sqrt(2 * np.pi), rel=0.3 * delta**2)  # and even in delta
    assert change == pytest.approx(-(delta**2) / 2 / np.sqrt(2 * np.pi), rel=0.3 * delta**2)
    orders = np.array([1024.0, 4096.0, 16384.0])
    runs = [after_crossing(e, order, load) for order in orders]
    scaled = np.array([run[0] for run in runs]) * np.sqrt(orders)[:, None]
    once = 2 * scaled[1:] - scaled[:-1]  # extrapolated in 1/sqrt(m), twice
    measured = (4 * once[1] - once[0]) / 3
    _, since, speed, (y, v) = runs[0]
    mean = speed * np.sqrt(e)
    gained = change * load / mean * speed * e  # of the speed at the crossing
    expected = [-delay * v + gained * np.sin(since), -delay * (load - y) + gained * np.cos(since)]
    np.testing.assert_allclose(measured, expected, atol=1e-3 * np.abs(expected).max())


def test_at_small_losses_the_error_under_load_falls_like_one_over_m():
    away = [np.linalg.norm(after_crossing(0.999, order, 0.3, 0.5)[0]) for order in (64, 256, 1024)]
    np.testing.assert_allclose(np.divide(away[:-1], away[1:]), 4, rtol=0.1)
    away = [np.linalg.norm(after_crossing(0.85, order, 0.3, 0.5)[0]) for order in (8, 16, 32)]
    assert np.all(np.divide(away[:-1], away[1:]) > 1.7)  # at the orders in use: nearer to 2 than to its root


def test_a_start_from_rest_at_the_crossing_costs_velocity_like_one_over_the_root_of_m():
    """A linear spring with omega_1 = 1 under a constant load, from rest: y is behind by 2 delta p/sqrt(pi m) sin."""
    e, load, end = 0.999, 0.3, np.pi / 2
    scaled = []
    for order in (256, 1024, 4096):
        a = of_restitution(e, order).amplitude

        def rates(_, s, a=a, order=order):
            y, v = s.tolist()
            total = y * y + v * v
            return v, load - y - (a * v * (v * v / total) ** order if total else 0.0)

        run = solve_ivp(rates, (0, end), [0, 0], "DOP853", rtol=1e-12, atol=1e-15, max_step=0.05 / np.sqrt(order))
        scaled.append((load - run.y[0, -1]) * np.sqrt(order))
    first = 2 * scaled[1] - scaled[0], 2 * scaled[2] - scaled[1]  # what is left is of the order of 1/m
    assert (4 * first[1] - first[0]) / 3 == pytest.approx(2 * -np.log(e) * load / np.sqrt(np.pi), rel=2e-3)
