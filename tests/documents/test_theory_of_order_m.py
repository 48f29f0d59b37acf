"""The steps of docs/theory.md's section on ECD of order m, each by the name that it gives."""

import re

import mpmath
import numpy as np
import pytest
import sympy as sp
from order_m import Damper, forced_peak, half_cycle, of_restitution
from repository import ROOT
from scipy.integrate import quad, solve_ivp
from scipy.special import beta

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.half_cycle_loss import critical_damping_ratio, damping_ratio, log_decrement, normalisation

PAPER = TrilinearCurve(0.04, 0.85)
PAGE = (ROOT / "docs/theory.md").read_text(encoding="utf-8")
phi, D, r, m, A = sp.symbols("phi D r m A", positive=True)


def table(first_cell):
    """Rows of the page's table that begins with this cell, as numbers, column by column."""
    rows = PAGE.split(f"| {first_cell} |")[1].split("\n\n")[0].splitlines()[2:]
    return np.array([[float(number) for number in re.findall(r"-?\d+\.?\d*", row)] for row in rows]).T


# --- the polar form --------------------------------------------------------------------------------------------------


def test_the_polar_form_of_the_motion():
    y, v = r * sp.sin(phi), r * sp.cos(phi)
    dy, dv = v, -y - D * v
    assert sp.simplify((y * dy + v * dv) / r**2 + D * sp.cos(phi) ** 2) == 0  # (ln r)'
    assert sp.simplify((dy * v - y * dv) / r**2 - 1 - D * sp.sin(phi) * sp.cos(phi)) == 0  # phi'
    x = sp.symbols("x", positive=True)  # and y' = v in the time s: dy/dx = f/y = omega_E
    force, potential = sp.Function("f")(x), sp.Function("V")(x)
    slope = sp.diff(sp.sqrt(2 * potential), x).subs(sp.diff(potential, x), force)
    assert sp.simplify(slope - force / sp.sqrt(2 * potential)) == 0


def test_a_load_enters_the_polar_form_over_the_square_of_the_denominator():
    q, c, s = sp.symbols("q"), sp.cos(phi), sp.sin(phi)
    ln_r, phase = -D * c**2 + q * c / r, 1 + D * s * c - q * s / r
    first = sp.diff(ln_r / phase, q).subs(q, 0)
    assert sp.simplify(first - c / r / (1 + D * s * c) ** 2) == 0


def test_a_hundred_random_curves_amplitudes_restitutions_and_orders():
    rng = np.random.default_rng(20250)
    for case in range(100):
        softening = ("steeper", "translated")[case % 2]
        b1 = rng.uniform(0.2, 0.95)
        a3 = rng.uniform(1.02 * (1 - b1), 1.0) if softening == "steeper" else rng.uniform(b1 + 0.01, 1.0)
        a2 = 1 - b1 if softening == "steeper" else a3 - b1
        a1 = a2 * np.exp(rng.uniform(np.log(1e-3), np.log(0.95)))
        curve = TrilinearCurve(a1, b1, a3, softening)
        x0 = a3 * np.exp(rng.uniform(np.log(1e-3), np.log(0.98)))
        e = rng.choice([0.05, 0.3, 0.5, 0.7, 0.85, 0.95, 0.999])
        order = rng.choice([0, 0.5, 1, 2, 4, 8, 16, 32, 64, rng.uniform(0, 64)])
        turn = half_cycle(curve, of_restitution(e, order), x0)
        expected = float(curve.amplitude(e**2 * curve.energy(x0)))
        assert turn.displacement == pytest.approx(expected, rel=1e-10), (a1, b1, a3, softening, x0, e, order)


@pytest.mark.parametrize("order", [0, 1, 8])
def test_from_the_critical_ratio_on_the_motion_does_not_cross(order):
    """Just beyond it, phi' has a zero on the way, at which the phase comes to rest; just below it has none."""
    angle = np.linspace(-np.pi / 2, 0, 100001)
    slope = np.sin(angle) * np.cos(angle) ** (2 * order + 1)
    for factor, crosses in ((0.9999, True), (1.0001, False)):
        a = 2 * factor * float(critical_damping_ratio(order) * normalisation(order))
        assert np.all(1 + a * slope > 0) == crosses
        run = solve_ivp(
            lambda _, p, a=a: 1 + a * np.sin(p) * np.cos(p) ** (2 * order + 1), (0, 2e3), [-np.pi / 2 + 1e-9]
        )
        assert (run.y[0, -1] > 0) == crosses


@pytest.mark.parametrize("order", [0, 0.5, 1, 4, 16])
def test_the_series_of_the_decrement_and_of_its_inverse(order):
    with mpmath.workdps(25):
        n, xi = mpmath.mpf(float(normalisation(order))), mpmath.mpf("0.3")

        def term(k):
            return (2 * xi * n) ** (2 * k + 1) * mpmath.beta(k + 0.5, (2 * order + 1) * k + order + 1.5)

        k = mpmath.mpf(400)
        assert float(mpmath.fsum(term(k) for k in range(80))) == pytest.approx(
            float(log_decrement(0.3, order)), rel=1e-13
        )
        radius = float(xi / mpmath.sqrt(term(k + 1) / term(k)))  # of convergence, up to a term of order 1/k
        assert radius == pytest.approx(float(critical_damping_ratio(order)), rel=2e-3)
    third = (2 * normalisation(order)) ** 3 / np.pi * beta(1.5, 3 * order + 2.5)
    small = np.array([0.02, 0.01]) / np.pi  # delta/pi
    left = (small - damping_ratio(np.pi * small, order)) / small**3 - third
    assert abs(left[1]) < 2e-5 and left[0] / left[1] == pytest.approx(4, rel=0.05)  # the next term is two orders higher


def test_one_damping_ratio_serves_all_orders():
    for e, within in ((0.85, 0.0005), (0.7, 0.0025), (0.5, 0.009)):
        xi = damping_ratio(-np.log(e), np.array([0, 1, 2, 4, 8, 16, 32, 64]))
        assert xi[-1] / xi[0] - 1 == pytest.approx(within, rel=0.05)
        assert np.all(np.diff(xi) > 0)


def longer(a, order):
    """Mean of 1/phi' over a half cycle, less one."""

    def integrand(p):
        s = (a * np.sin(p) * np.cos(p) ** (2 * order + 1)) ** 2
        return s / (1 - s)

    return 2 * quad(integrand, 0, np.pi / 2, epsabs=1e-14, points=[np.arctan(1 / np.sqrt(2 * order + 1))])[0] / np.pi


def test_the_table_of_orders():
    orders, n, xi, xi_half, critical, late, force = table("order m | N_m")
    np.testing.assert_allclose(n, normalisation(orders), atol=5.1e-4)
    np.testing.assert_allclose(xi, damping_ratio(-np.log(0.85), orders), atol=5.1e-6)
    np.testing.assert_allclose(xi_half, damping_ratio(-np.log(0.5), orders), atol=5.1e-5)
    np.testing.assert_allclose(critical, critical_damping_ratio(orders), atol=5.1e-4)
    for i, order in enumerate(orders):
        a = of_restitution(0.85, order).amplitude
        assert 100 * longer(a, order) == pytest.approx(late[i], abs=5.1e-4)
        speed = half_cycle(PAPER, of_restitution(0.85, order), 0.5).crossing_speed
        assert a * float(PAPER.initial_frequency) * speed / 0.85 == pytest.approx(force[i], abs=5.1e-3)


@pytest.mark.parametrize("order", [0, 4, 32])
def test_half_cycles_of_a_linear_spring_are_longer_by_the_mean_of_the_inverse_phase_velocity(order):
    turn = half_cycle(PAPER, of_restitution(0.7, order), 0.03)
    expected = np.pi / float(PAPER.initial_frequency) * (1 + longer(of_restitution(0.7, order).amplitude, order))
    assert turn.duration == pytest.approx(expected, rel=1e-9)
    if order == 0:
        assert 1 + longer(of_restitution(0.7, 0).amplitude, 0) == pytest.approx(
            1 / np.sqrt(1 - damping_ratio(-np.log(0.7)) ** 2)
        )


# --- which dampers ---------------------------------------------------------------------------------------------------


def test_a_loss_that_depends_on_the_phases_alone_leaves_only_a_function_of_the_phase():
    g, c, s = sp.symbols("g"), sp.cos(phi), sp.sin(phi)
    (solution,) = sp.solve(sp.Eq(D * c**2 / (1 + D * s * c), g), D)
    assert sp.simplify(solution - g / (c**2 - g * s * c)) == 0


def test_an_order_that_depends_on_the_amplitude_loses_the_same_fraction_too():
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


def test_more_damping_beyond_some_amplitude_loses_more_just_beyond_it():
    """C = w_E (2 xi + 0.1) for |x| > 0.1 and ECD within: releases up to there lose delta, and then more and more."""
    xi = float(damping_ratio(-np.log(0.85)))

    class Stepped(Damper):
        def coefficient(self, branch, z, v):
            return super().coefficient(branch, z, v) * (1 + 0.1 / self.amplitude * (branch.low > 0))

    curve = TrilinearCurve(0.1, 0.85)
    lost = [
        np.log(np.sqrt(curve.energy(x0) / curve.energy(half_cycle(curve, Stepped(2 * xi, 0), x0).displacement)))
        for x0 in (0.05, 0.1, 0.1005, 0.101, 0.105)
    ]
    np.testing.assert_allclose(lost[:2], -np.log(0.85), rtol=1e-9)
    assert np.all(np.diff(lost[1:]) > 1e-5)


def test_a_damper_on_the_way_to_the_crossing_alone_is_exact_too_and_late_to_first_order():
    xi = 0.12
    delta = xi / np.sqrt(1 - xi**2) * (np.pi / 2 + np.arcsin(xi))
    none = Damper(0.0, 0)
    for x0 in (0.02, 0.3, 0.95):
        end = half_cycle(PAPER, Damper(2 * xi, 0), x0, beyond=(PAPER, none)).displacement
        assert end == pytest.approx(float(PAPER.amplitude(np.exp(-2 * delta) * PAPER.energy(x0))), rel=1e-9)
    late = []
    for xi in (0.01, 0.005):
        both = (
            half_cycle(PAPER, Damper(2 * xi, 0), 0.03),
            half_cycle(PAPER, Damper(4 * xi, 0), 0.03, beyond=(PAPER, none)),
        )
        late.append([turn.duration * float(PAPER.initial_frequency) / np.pi - 1 for turn in both])
    np.testing.assert_allclose(np.divide(*late), [4, 2], rtol=0.02)


# --- where it ends ---------------------------------------------------------------------------------------------------


def test_the_first_peak_before_any_impact():
    columns = table("load over F0, duration in tau")
    peaks = []
    for i, (strength, duration) in enumerate(columns[:2].T):

        def load(tau, strength=strength, duration=duration):
            return strength * np.sin(np.pi * tau / duration) if tau < duration else 0.0

        free = forced_peak(PAPER, Damper(0.0, 0), load, duration)
        for stated, order in zip(columns[2:, i], (0, 1, 2, 4, 8, 16, 64), strict=True):
            assert forced_peak(PAPER, of_restitution(0.85, order), load, duration) / free == pytest.approx(
                stated, abs=6e-4
            )
        peaks.append(free)
    np.testing.assert_allclose(np.sort(peaks), [0.06, 0.33, 0.40, 0.58], atol=0.005)


@pytest.mark.parametrize("order", [0, 1, 2, 5])
def test_at_resonance_every_order_has_the_work_of_the_linear_damper(order):
    """Over a cycle of y = r sin phi, v = r cos phi it takes 2 pi xi r^2, as 2 xi v does: the load's is pi q r."""
    n = sp.Rational(2 ** (2 * order + 1)) / sp.binomial(2 * order + 2, order + 1)
    xi = sp.symbols("xi")
    work = sp.integrate(2 * xi * n * sp.cos(phi) ** (2 * order + 2), (phi, 0, 2 * sp.pi)) * r**2
    assert sp.simplify(work - 2 * sp.pi * xi * r**2) == 0
    q = sp.symbols("q")
    assert sp.solve(sp.Eq(work, sp.pi * q * r), q) == [2 * xi * r]


def test_the_slopes_of_the_damping_force_are_bounded():
    y, v = sp.symbols("y v", positive=True)
    force = A * v * (v**2 / (y**2 + v**2)) ** m  # over omega_1
    at = {y: r * sp.sin(phi), v: r * sp.cos(phi)}
    by_y, by_v = (sp.diff(force, u).subs(at) for u in (y, v))
    c, s = sp.cos(phi), sp.sin(phi)
    values = {phi: sp.Rational(3, 10), r: 2, A: sp.Rational(1, 5)}
    for order in (0, sp.Rational(1, 2), 3, 8):
        for slope, expected in (
            (by_y, -2 * m * A * s * c ** (2 * m + 1)),
            (by_v, A * c ** (2 * m) * (1 + 2 * m * s**2)),
        ):
            assert abs(((slope - expected).subs(values | {m: order})).evalf(30)) < 1e-25
    angle = np.linspace(0, np.pi / 2, 20001)
    for order in (1, 8, 64):
        slopes = 2 * order * np.sin(angle) * np.cos(angle) ** (2 * order + 1)  # times A = 2 xi N
        bound = 2 * order / (2 * critical_damping_ratio(order) * normalisation(order))
        assert slopes.max() == pytest.approx(float(bound), rel=1e-6)
        assert (np.cos(angle) ** (2 * order) * (1 + 2 * order * np.sin(angle) ** 2)).max() < 1.22
    xi = damping_ratio(-np.log(0.85), np.array([8, 64]))
    np.testing.assert_allclose(2 * np.array([8, 64]) * xi / critical_damping_ratio([8, 64]), [0.65, 5.05], atol=0.01)


@pytest.mark.parametrize("order", [0, 4])
def test_a_wall_with_another_curve_on_each_side_loses_the_same_fraction(order):
    other = TrilinearCurve(0.15, 0.4, 0.8)
    its = of_restitution(0.85, order)
    for x0 in (0.05, 0.3):
        end = half_cycle(PAPER, its, x0, beyond=(other, its)).displacement
        assert end == pytest.approx(float(other.amplitude(0.85**2 * PAPER.energy(x0))), rel=1e-9)
        back = half_cycle(other, its, end, beyond=(PAPER, its)).displacement
        assert back == pytest.approx(float(PAPER.amplitude(0.85**4 * PAPER.energy(x0))), rel=1e-9)


@pytest.mark.parametrize("order", [0, 8])
def test_a_wall_that_turns_at_an_elastic_stop_loses_the_same_fraction_at_each_contact(order):
    """On f = x - x^3/4 for x > 0 alone: at x = 0 the velocity changes its sign."""
    a = of_restitution(0.8, order).amplitude

    def rates(_, s):
        x, v = s.tolist()
        double_v = x * x - x**4 / 8
        frequency = (1 - x * x / 4) / np.sqrt(1 - x * x / 8)
        return v, -x + x**3 / 4 - a * frequency * (v * v / (v * v + double_v)) ** order * v

    def at_the_stop(_, s):
        return s[0]

    def at_rest(_, s):
        return s[1]

    at_the_stop.terminal = at_rest.terminal = True
    accuracy = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14, "max_step": 0.02}
    contact = solve_ivp(rates, (0, 20), [1.5, 0], events=at_the_stop, **accuracy).y[:, -1]
    x = solve_ivp(rates, (0, 20), [0, -contact[1]], events=at_rest, **accuracy).y[0, -1]
    assert np.sqrt((x * x - x**4 / 8) / (1.5**2 - 1.5**4 / 8)) == pytest.approx(0.8, rel=1e-9)


def test_for_a_power_law_ecd_is_the_damper_of_granular_mechanics():
    x, k, n = sp.symbols("x k n", positive=True)
    force = k * x**n
    potential = k * x ** (n + 1) / (n + 1)
    frequency = sp.simplify(force / sp.sqrt(2 * potential))
    assert sp.simplify(frequency / (sp.sqrt((n + 1) / 2) * sp.sqrt(k) * x ** ((n - 1) / 2))) == 1
    hertz = frequency.subs(n, sp.Rational(3, 2))
    assert sp.simplify(hertz / (sp.sqrt(5) / 2 * sp.sqrt(k) * x ** sp.Rational(1, 4))) == 1
    assert sp.simplify(frequency / sp.sqrt(force / x) - sp.sqrt((n + 1) / 2)) == 0  # CDR, times a factor


def test_abels_inversion_leaves_no_other_solution():
    """h(E) = (1/pi) d/dE of integral_0^E sqrt(2) delta/sqrt(E - s) ds solves integral_0^E h/sqrt(2 (E - s)) = delta."""
    energy, s, delta = sp.symbols("E s delta", positive=True)
    kernel = sp.integrate(1 / sp.sqrt(energy - s) / sp.sqrt(s), (s, 0, energy))
    assert sp.simplify(kernel - sp.pi) == 0  # why applying the kernel twice is integration, which has one inverse
    inverted = sp.diff(sp.integrate(sp.sqrt(2) * delta / sp.sqrt(energy - s), (s, 0, energy)), energy) / sp.pi
    assert sp.simplify(inverted - 2 * delta / sp.pi / sp.sqrt(2 * energy)) == 0
