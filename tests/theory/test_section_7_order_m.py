"""Section 7 of docs/theory.md: ECD of order m, its limit and its errors under load."""

import numpy as np
import pytest
import sympy as sp
from exact_cases import cr_peaks, random_curve
from order_m_motion import Damper, forced_peak, half_cycle, of_restitution
from pages import stated_rows
from scipy.integrate import quad, solve_ivp
from scipy.special import erf

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.half_cycle_loss import CAP, critical_damping_ratio, normalisation
from rockdamp.solvers.exact import exact_history

PAPER = TrilinearCurve(0.04, 0.85)
THEORY = "docs/theory.md"
ACCURATE = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15}
phi, D, r, m, kappa = sp.symbols("phi D r m kappa", positive=True)
COS, SIN = sp.cos(phi), sp.sin(phi)
LOSS_BY_PHASE = D * COS**2 / (1 + D * SIN * COS)


def is_zero(expression):
    return sp.simplify(expression) == 0


# --- the polar form ------------------------------------------------------------------------------


def test_polar_form():
    y, v = r * SIN, r * COS
    dy, dv = v, -y - D * v
    assert is_zero((y * dy + v * dv) / r**2 + D * COS**2)  # (ln r)'
    assert is_zero((dy * v - y * dv) / r**2 - 1 - D * SIN * COS)  # phi'


def test_stretched_time():
    """y' = v in the time s, as dy/dx = f/y = omega_E."""
    x = sp.symbols("x", positive=True)
    force, potential = sp.Function("f")(x), sp.Function("V")(x)
    slope = sp.diff(sp.sqrt(2 * potential), x).subs(sp.diff(potential, x), force)
    assert is_zero(slope - force / sp.sqrt(2 * potential))


def test_polar_form_under_load():
    q = sp.symbols("q")
    growth = -D * COS**2 + q * COS / r
    phase = 1 + D * SIN * COS - q * SIN / r
    first_order = sp.diff(growth / phase, q).subs(q, 0)
    assert is_zero(first_order - COS / r / (1 + D * SIN * COS) ** 2)


@pytest.mark.parametrize(("e", "share"), [(0.7, 0.9), (0.9, 0.02)])
@pytest.mark.parametrize(
    "curve",
    [PAPER, TrilinearCurve(0.20, 0.50), TrilinearCurve(0.06, 0.72, 0.9, "translated")],
    ids=["paper", "severe", "translated"],
)
def test_event_driven_peaks_are_exact(curve, e, share):
    x0 = share * float(curve.ultimate_displacement_ratio)
    end = 1.5 * float(curve.period(x0))
    for order in (0, 1, 2.5, 8, 32):
        damping = Damping.from_restitution(e, "ECD", order=order)
        history = exact_history(curve, damping, [end], release_amplitude=x0)
        peaks = np.abs(history.turning_displacement)
        assert peaks.size >= 2, order
        expected = cr_peaks(curve, e, x0, peaks.size)
        np.testing.assert_allclose(peaks, expected, rtol=1e-9, err_msg=f"order {order}")


def test_peaks_of_a_hundred_random_cases():
    rng = np.random.default_rng(20250)
    for case in range(100):
        curve = random_curve(rng, case)
        share = np.exp(rng.uniform(np.log(1e-3), np.log(0.98)))
        x0 = float(curve.ultimate_displacement_ratio) * share
        e = rng.choice([0.05, 0.3, 0.5, 0.7, 0.85, 0.95, 0.999])
        order = rng.choice([0, 0.5, 1, 2, 4, 8, 16, 32, 64, rng.uniform(0, 64)])
        turn = half_cycle(curve, of_restitution(e, order), x0)
        expected = float(curve.amplitude(e**2 * curve.energy(x0)))
        assert turn.displacement == pytest.approx(expected, rel=1e-10), (curve, x0, e, order)


def test_coefficient_follows_from_the_loss_by_phase():
    (solution,) = sp.solve(sp.Eq(LOSS_BY_PHASE, kappa * COS ** (2 * m + 2)), D)
    denominator = 1 - kappa * COS ** (2 * m + 1) * SIN
    assert is_zero(solution - kappa * COS ** (2 * m) / denominator)
    assert is_zero(1 / (1 + solution * SIN * COS) - denominator)  # ds/d phi


def test_range_of_the_critical_ratio():
    critical = critical_damping_ratio(np.array([1, 8, 64]))
    assert np.all((critical >= 2 / np.sqrt(3)) & (critical < np.sqrt(2 * np.e / np.pi)))


@pytest.mark.parametrize("order", [0.5, 4, 32])
@pytest.mark.parametrize("e", [0.05, 0.5, 0.95])
def test_duration_on_a_linear_spring(order, e):
    turn = half_cycle(PAPER, of_restitution(e, order), 0.03)
    assert turn.duration == pytest.approx(np.pi / float(PAPER.initial_frequency), rel=1e-10)
    assert turn.displacement == pytest.approx(0.03 * e, rel=1e-10)


def test_order_zero_differs_in_second_order():
    """ECD has no denominator; with it xi is delta/pi."""
    phases = np.linspace(-1.5, 1.5, 301)
    differences = []
    for delta in (0.1, 0.05):
        k = 2 * delta / np.pi
        with_denominator = k / (1 - k * np.sin(phases) * np.cos(phases))
        ecd = 2 * delta / np.hypot(np.pi, delta)
        differences.append(np.abs(with_denominator - ecd).max())
    assert differences[0] / differences[1] == pytest.approx(4, rel=0.05)


def test_table_of_orders():
    orders, n, least, forces = np.transpose(stated_rows(THEORY, "order m | N_m"))
    np.testing.assert_allclose(n, normalisation(orders), atol=5.1e-4)
    smallest = np.exp(-CAP * np.pi * critical_damping_ratio(orders[1:]))
    np.testing.assert_allclose(least[1:], smallest, atol=5.1e-4)
    for order, force in zip(orders, forces, strict=True):
        damper = of_restitution(0.85, order)
        speed = half_cycle(PAPER, damper, 0.5).crossing_speed
        drag = damper.amplitude * float(PAPER.initial_frequency) * speed
        assert drag / 0.85 == pytest.approx(force, abs=5.1e-3), order


# --- which dampers -------------------------------------------------------------------------------


def test_loss_by_phase_needs_a_coefficient_by_phase():
    loss = sp.symbols("g")
    (solution,) = sp.solve(sp.Eq(LOSS_BY_PHASE, loss), D)
    assert is_zero(solution - loss / (COS**2 - loss * SIN * COS))


def test_order_chosen_at_each_turn_is_exact_too():
    e = 0.8
    peaks = [0.9]
    while peaks[-1] > 0.2:
        order = 8 if peaks[-1] > 0.5 else 1 + peaks[-1]
        peaks.append(half_cycle(PAPER, of_restitution(e, order), peaks[-1]).displacement)
    expected = PAPER.amplitude(e ** (2 * np.arange(len(peaks))) * PAPER.energy(0.9))
    np.testing.assert_allclose(peaks, expected, rtol=1e-9)


def test_speed_at_the_crossing_depends_on_the_order():
    speeds = [half_cycle(PAPER, of_restitution(0.8, m), 0.5).crossing_speed for m in (0, 8)]
    assert speeds[1] / speeds[0] - 1 > 9e-4


class Stepped(Damper):
    """C = w_E (2 xi + 0.1) beyond the first branch, and ECD within."""

    def coefficient(self, branch, z, v):
        inner = super().coefficient(branch, z, v)
        return inner * (1 + 0.1 / self.amplitude) if branch.low > 0 else inner


def test_more_damping_beyond_an_amplitude_loses_more():
    xi = float(Damping.from_restitution(0.85, "ECD").value)
    curve, damper = TrilinearCurve(0.1, 0.85), Stepped(2 * xi, 0)
    losses = []
    for x0 in (0.05, 0.1, 0.1005, 0.101, 0.105):
        x1 = half_cycle(curve, damper, x0).displacement
        losses.append(np.log(curve.energy(x0) / curve.energy(x1)) / 2)
    np.testing.assert_allclose(losses[:2], -np.log(0.85), rtol=1e-9)
    assert np.all(np.diff(losses[1:]) > 1e-5)


# --- limits of the damper ------------------------------------------------------------------------

FIRST_PEAKS = stated_rows(THEORY, "load over F0, duration in tau")


def half_sine(strength, duration):
    def load(tau):
        return strength * np.sin(np.pi * tau / duration) if tau < duration else 0.0

    return load


@pytest.mark.parametrize("row", FIRST_PEAKS, ids=lambda row: f"{row[0]}, {row[1]}")
def test_table_of_first_peaks(row):
    strength, duration, *ratios = row
    load = half_sine(strength, duration)
    peaks = [forced_peak(PAPER, of_restitution(0.85, m), load, duration) for m in (0, 4, 16, 64)]
    samples = [load(tau) for tau in np.linspace(0, duration, 257)]
    for model, width in (("BAND", 0.2), ("BAND", 0.1), ("CQD", 0.25)):
        damping = Damping.from_restitution(0.85, model, width=width)
        history = exact_history(PAPER, damping, [3.0], load=samples, sampling=duration / 256)
        peaks.append(history.turning_displacement[0])
    free = forced_peak(PAPER, Damper(0.0, 0), load, duration)
    np.testing.assert_allclose(np.divide(peaks, free), ratios, atol=6e-4)


def test_amplitudes_of_the_table_of_first_peaks():
    peaks = []
    for strength, duration, *_ in FIRST_PEAKS:
        load = half_sine(strength, duration)
        peaks.append(forced_peak(PAPER, Damper(0.0, 0), load, duration))
    np.testing.assert_allclose(np.sort(peaks), [0.06, 0.33, 0.40, 0.58], atol=0.005)


@pytest.mark.parametrize("order", [0, 4])
@pytest.mark.parametrize("x0", [0.05, 0.3])
def test_two_different_sides_lose_the_same_fraction(order, x0):
    right_curve = TrilinearCurve(0.15, 0.4, 0.8)
    damper = of_restitution(0.85, order)
    first = half_cycle(PAPER, damper, x0, beyond=(right_curve, damper)).displacement
    expected = float(right_curve.amplitude(0.85**2 * PAPER.energy(x0)))
    assert first == pytest.approx(expected, rel=1e-9)
    second = half_cycle(right_curve, damper, first, beyond=(PAPER, damper)).displacement
    expected = float(PAPER.amplitude(0.85**4 * PAPER.energy(x0)))
    assert second == pytest.approx(expected, rel=1e-9)


# --- restitution is the limit --------------------------------------------------------------------


def damped_rates(amplitude, order, load, slope=0.0):
    """Return the rates of (y, v) of a linear spring, omega_1 = 1, under a load linear in time."""

    def rates(t, state):
        y, v = state.tolist()
        total = y * y + v * v
        if total == 0:
            return v, load
        q = amplitude * (v * v / total) ** order
        return v, load + slope * t - y - q * v / (1 - q * y * v / total)

    return rates


def after_crossing(e, order, load, slope=0.0, end=1.3):
    """Return (y, v) at a time after a crossing less the same with an impact.

    Also the time since the crossing, and the speed there.
    """
    start = [np.sin(-0.6), np.cos(-0.6)]
    rates = damped_rates(of_restitution(e, order).amplitude, order, load, slope)
    short = 0.05 / np.sqrt(order)
    damped = solve_ivp(rates, (0, end), start, max_step=short, **ACCURATE).y[:, -1]

    def free(t, state):
        return state[1], load + slope * t - state[0]

    def crossing(_, state):
        return state[0]

    crossing.terminal = True
    before = solve_ivp(free, (0, end), start, events=crossing, max_step=0.05, **ACCURATE)
    time, speed = before.t[-1], before.y[1, -1]
    impact = solve_ivp(free, (time, end), [0.0, e * speed], **ACCURATE)
    return damped - impact.y[:, -1], end - time, speed


def layer_integral(e):
    """Return the integral of the limit, of the change of speed."""
    delta = -np.log(e)

    def change(z):
        band = delta / np.sqrt(np.pi) * z * np.exp(-z * z)
        damped = np.exp(delta / 2 * erf(z)) * (1 - band) ** 2
        return damped - np.exp(np.copysign(delta / 2, z))

    return quad(change, -8, 8, points=[0.0])[0]


def extrapolate(values):
    """Extrapolate three values, each at four times the order, in 1/sqrt(m) twice."""
    first = 2 * values[1] - values[0]
    second = 2 * values[2] - values[1]
    return (4 * second - first) / 3


@pytest.mark.parametrize("e", [0.95, 0.85, 0.7])
def test_layer_integral_to_second_order(e):
    delta = -np.log(e)
    expected = -(5 / 4) * delta**2 / np.sqrt(2 * np.pi)
    assert layer_integral(e) == pytest.approx(expected, rel=0.3 * delta**2)


@pytest.mark.parametrize(("e", "load"), [(0.95, 0.0), (0.85, 0.3), (0.7, 0.3), (0.7, -0.2)])
def test_limit_of_the_error_after_a_crossing(e, load):
    """A change of speed at the crossing, and no delay."""
    orders = (1024.0, 4096.0, 16384.0)
    runs = [after_crossing(e, order, load) for order in orders]
    scaled = [history[0] * np.sqrt(order) for history, order in zip(runs, orders, strict=True)]
    _, elapsed, speed = runs[0]
    gain = layer_integral(e) * load / (speed * np.sqrt(e)) * speed * e
    expected = np.array([gain * np.sin(elapsed), gain * np.cos(elapsed)])
    tolerance = 1e-3 * np.abs(expected).max() + 1e-9
    np.testing.assert_allclose(extrapolate(scaled), expected, atol=tolerance)


@pytest.mark.parametrize(
    ("e", "orders", "ratios", "tolerance"),
    [(0.999, (64, 256, 1024), [4.0, 4.0], 0.4), (0.85, (8, 16, 32), [1.7, 1.9], 0.06)],
    ids=["small loss", "orders in use"],
)
def test_error_after_a_crossing_falls_with_the_order(e, orders, ratios, tolerance):
    errors = [np.linalg.norm(after_crossing(e, order, 0.3, 0.5)[0]) for order in orders]
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), ratios, atol=tolerance)


def test_limit_of_a_start_from_rest():
    """A linear spring under a constant load: y is behind by 2 delta p/sqrt(pi m) sin."""
    e, load, end = 0.999, 0.3, np.pi / 2
    scaled = []
    for order in (256, 1024, 4096):
        rates = damped_rates(of_restitution(e, order).amplitude, order, load)
        accuracy = {"rtol": 1e-12, "atol": 1e-15, "max_step": 0.05 / np.sqrt(order)}
        history = solve_ivp(rates, (0, end), [0, 0], "DOP853", **accuracy)
        scaled.append((load - history.y[0, -1]) * np.sqrt(order))
    expected = 2 * -np.log(e) * load / np.sqrt(np.pi)
    assert extrapolate(scaled) == pytest.approx(expected, rel=2e-3)
