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
from rockdamp.mechanics.dampers import CAP, critical_damping_ratio, normalisation
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.exact import exact_history

PAPER = TrilinearCurve(0.04, 0.85)
THEORY = "docs/theory.md"
phi, D, r, m = sp.symbols("phi D r m", positive=True)


# --- the polar form --------------------------------------------------------------------------------------------------


def test_polar_form():
    y, v = r * sp.sin(phi), r * sp.cos(phi)
    dy, dv = v, -y - D * v
    assert sp.simplify((y * dy + v * dv) / r**2 + D * sp.cos(phi) ** 2) == 0  # (ln r)'
    assert sp.simplify((dy * v - y * dv) / r**2 - 1 - D * sp.sin(phi) * sp.cos(phi)) == 0  # phi'
    x = sp.symbols("x", positive=True)  # and y' = v in the time s: dy/dx = f/y = omega_E
    force, potential = sp.Function("f")(x), sp.Function("V")(x)
    slope = sp.diff(sp.sqrt(2 * potential), x).subs(sp.diff(potential, x), force)
    assert sp.simplify(slope - force / sp.sqrt(2 * potential)) == 0


def test_polar_form_under_load():
    q, c, s = sp.symbols("q"), sp.cos(phi), sp.sin(phi)
    ln_r, phase = -D * c**2 + q * c / r, 1 + D * s * c - q * s / r
    first = sp.diff(ln_r / phase, q).subs(q, 0)
    assert sp.simplify(first - c / r / (1 + D * s * c) ** 2) == 0


@pytest.mark.parametrize("order", [0, 1, 2.5, 8, 32])
def test_event_driven_peaks_are_exact(order):
    for curve in (PAPER, TrilinearCurve(0.20, 0.50), TrilinearCurve(0.06, 0.72, 0.9, "translated")):
        for e, share in ((0.7, 0.9), (0.9, 0.02)):
            x0 = share * float(curve.ultimate_displacement_ratio)
            damping = Damping.from_restitution(e, "ECD", order=order)
            run = exact_history(
                curve, damping, [1.5 * float(curve.period(x0))], release_amplitude=x0
            )
            peaks = np.abs(run.turning_displacement)
            assert peaks.size >= 2
            np.testing.assert_allclose(peaks, cr_peaks(curve, e, x0, peaks.size), rtol=1e-9)


def test_peaks_of_a_hundred_random_cases():
    rng = np.random.default_rng(20250)
    for case in range(100):
        curve = random_curve(rng, case)
        x0 = float(curve.ultimate_displacement_ratio) * np.exp(
            rng.uniform(np.log(1e-3), np.log(0.98))
        )
        e = rng.choice([0.05, 0.3, 0.5, 0.7, 0.85, 0.95, 0.999])
        order = rng.choice([0, 0.5, 1, 2, 4, 8, 16, 32, 64, rng.uniform(0, 64)])
        turn = half_cycle(curve, of_restitution(e, order), x0)
        expected = float(curve.amplitude(e**2 * curve.energy(x0)))
        assert turn.displacement == pytest.approx(expected, rel=1e-10), (curve, x0, e, order)


def test_coefficient_follows_from_the_loss_at_each_phase():
    kappa, c, s = sp.symbols("kappa", positive=True), sp.cos(phi), sp.sin(phi)
    (solution,) = sp.solve(sp.Eq(D * c**2 / (1 + D * s * c), kappa * c ** (2 * m + 2)), D)
    assert sp.simplify(solution - kappa * c ** (2 * m) / (1 - kappa * c ** (2 * m + 1) * s)) == 0
    assert (
        sp.simplify(1 / (1 + solution * s * c) - (1 - kappa * c ** (2 * m + 1) * s)) == 0
    )  # ds/d phi


@pytest.mark.parametrize("order", [0.5, 1, 8, 64])
def test_half_cycles_end_below_the_critical_ratio(order):
    """The phase goes on while kappa cos^(2m+1) sin stays below 1; at its largest, the page's kappa_c is the inverse."""
    angle = np.linspace(0, np.pi / 2, 400001)
    largest = np.max(np.sin(angle) * np.cos(angle) ** (2 * order + 1))
    assert largest == pytest.approx(
        ((2 * order + 1) / (2 * order + 2)) ** (order + 0.5) / np.sqrt(2 * order + 2)
    )
    critical = float(critical_damping_ratio(order))
    assert 2 * critical * float(normalisation(order)) * largest == pytest.approx(1, rel=1e-9)
    if order >= 1:
        assert 2 / np.sqrt(3) <= critical < np.sqrt(2 * np.e / np.pi)


@pytest.mark.parametrize("order", [0.5, 4, 32])
@pytest.mark.parametrize("e", [0.05, 0.5, 0.95])
def test_duration_on_a_linear_spring(order, e):
    turn = half_cycle(PAPER, of_restitution(e, order), 0.03)
    assert turn.duration == pytest.approx(np.pi / float(PAPER.initial_frequency), rel=1e-10)
    assert turn.displacement == pytest.approx(0.03 * e, rel=1e-10)


def test_order_zero_differs_in_second_order():
    """C of delta = -ln e: with it xi is delta/pi; ECD, which has none, is nearer to it the less is lost."""
    phases = np.linspace(-1.5, 1.5, 301)
    away = []
    for delta in (0.1, 0.05):
        with_it = 2 * delta / np.pi / (1 - 2 * delta / np.pi * np.sin(phases) * np.cos(phases))
        away.append(np.abs(with_it - 2 * delta / np.hypot(np.pi, delta)).max())
    assert away[0] / away[1] == pytest.approx(4, rel=0.05)


def test_table_of_orders():
    orders, n, least, force = np.transpose(stated_rows(THEORY, "order m | N_m"))
    np.testing.assert_allclose(n, normalisation(orders), atol=5.1e-4)
    np.testing.assert_allclose(
        least[1:], np.exp(-CAP * np.pi * critical_damping_ratio(orders[1:])), atol=5.1e-4
    )
    for i, order in enumerate(orders):
        a = of_restitution(0.85, order).amplitude
        speed = half_cycle(PAPER, of_restitution(0.85, order), 0.5).crossing_speed
        assert a * float(PAPER.initial_frequency) * speed / 0.85 == pytest.approx(
            force[i], abs=5.1e-3
        )


# --- which dampers ---------------------------------------------------------------------------------------------------


def test_loss_by_phase_needs_a_coefficient_by_phase():
    g, c, s = sp.symbols("g"), sp.cos(phi), sp.sin(phi)
    (solution,) = sp.solve(sp.Eq(D * c**2 / (1 + D * s * c), g), D)
    assert sp.simplify(solution - g / (c**2 - g * s * c)) == 0


def test_order_chosen_at_each_turn_is_exact_too():
    e = 0.8
    peaks = [0.9]
    while peaks[-1] > 0.2:
        order = 8 if peaks[-1] > 0.5 else 1 + peaks[-1]
        peaks.append(half_cycle(PAPER, of_restitution(e, order), peaks[-1]).displacement)
    expected = PAPER.amplitude(e ** (2 * np.arange(len(peaks))) * PAPER.energy(0.9))
    np.testing.assert_allclose(peaks, expected, rtol=1e-9)
    # A part of the half cycle is another matter: the fraction left at the crossing depends on the order.
    left = [half_cycle(PAPER, of_restitution(e, order), 0.5).crossing_speed for order in (0, 8)]
    assert left[1] / left[0] - 1 > 9e-4


def test_more_damping_beyond_an_amplitude_loses_more():
    """C = w_E (2 xi + 0.1) for |x| > 0.1 and ECD within: releases up to there lose delta, and then more and more."""
    xi = float(Damping.from_restitution(0.85, "ECD").value)

    class Stepped(Damper):
        def coefficient(self, branch, z, v):
            return super().coefficient(branch, z, v) * (1 + 0.1 / self.amplitude * (branch.low > 0))

    curve = TrilinearCurve(0.1, 0.85)
    lost = [
        np.log(
            np.sqrt(
                curve.energy(x0)
                / curve.energy(half_cycle(curve, Stepped(2 * xi, 0), x0).displacement)
            )
        )
        for x0 in (0.05, 0.1, 0.1005, 0.101, 0.105)
    ]
    np.testing.assert_allclose(lost[:2], -np.log(0.85), rtol=1e-9)
    assert np.all(np.diff(lost[1:]) > 1e-5)


# --- limits of the damper --------------------------------------------------------------------------------------------


def test_table_of_first_peaks():
    peaks = []
    for strength, duration, *ratios in stated_rows(THEORY, "load over F0, duration in tau"):

        def load(tau, strength=strength, duration=duration):
            return strength * np.sin(np.pi * tau / duration) if tau < duration else 0.0

        free = forced_peak(PAPER, Damper(0.0, 0), load, duration)
        ordered = [
            forced_peak(PAPER, of_restitution(0.85, order), load, duration)
            for order in (0, 4, 16, 64)
        ]
        samples = [load(tau) for tau in np.linspace(0, duration, 257)]
        for model, width in (("BAND", 0.2), ("BAND", 0.1), ("CQD", 0.25)):
            damping = Damping.from_restitution(0.85, model, width=width)
            run = exact_history(PAPER, damping, [3.0], load=samples, sampling=duration / 256)
            ordered.append(run.turning_displacement[0])
        np.testing.assert_allclose(np.divide(ordered, free), ratios, atol=6e-4)
        peaks.append(free)
    np.testing.assert_allclose(np.sort(peaks), [0.06, 0.33, 0.40, 0.58], atol=0.005)


@pytest.mark.parametrize("order", [0, 4])
def test_two_different_sides_lose_the_same_fraction(order):
    other = TrilinearCurve(0.15, 0.4, 0.8)
    its = of_restitution(0.85, order)
    for x0 in (0.05, 0.3):
        end = half_cycle(PAPER, its, x0, beyond=(other, its)).displacement
        assert end == pytest.approx(float(other.amplitude(0.85**2 * PAPER.energy(x0))), rel=1e-9)
        back = half_cycle(other, its, end, beyond=(PAPER, its)).displacement
        assert back == pytest.approx(float(PAPER.amplitude(0.85**4 * PAPER.energy(x0))), rel=1e-9)


# --- restitution is the limit ----------------------------------------------------------------------------------------


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


@pytest.mark.parametrize(("e", "load"), [(0.95, 0.0), (0.85, 0.3), (0.7, 0.3), (0.7, -0.2)])
def test_limit_of_the_error_after_a_crossing(e, load):
    delta = -np.log(e)
    change = layer_integral(e)
    assert change == pytest.approx(
        -(5 / 4) * delta**2 / np.sqrt(2 * np.pi), rel=0.3 * delta**2
    )  # and even in delta
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


def test_error_after_a_crossing_at_the_orders_in_use():
    away = [np.linalg.norm(after_crossing(0.999, order, 0.3, 0.5)[0]) for order in (64, 256, 1024)]
    np.testing.assert_allclose(np.divide(away[:-1], away[1:]), 4, rtol=0.1)
    away = [np.linalg.norm(after_crossing(0.85, order, 0.3, 0.5)[0]) for order in (8, 16, 32)]
    np.testing.assert_allclose(
        np.divide(away[:-1], away[1:]), [1.7, 1.9], atol=0.06
    )  # at the orders in use


def test_limit_of_a_start_from_rest():
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

        run = solve_ivp(
            rates,
            (0, end),
            [0, 0],
            "DOP853",
            rtol=1e-12,
            atol=1e-15,
            max_step=0.05 / np.sqrt(order),
        )
        scaled.append((load - run.y[0, -1]) * np.sqrt(order))
    first = (
        2 * scaled[1] - scaled[0],
        2 * scaled[2] - scaled[1],
    )  # what is left is of the order of 1/m
    assert (4 * first[1] - first[0]) / 3 == pytest.approx(
        2 * -np.log(e) * load / np.sqrt(np.pi), rel=2e-3
    )
