"""The steps of docs/theory.md's section on ECD of order m, each by the name that it gives."""

import re

import numpy as np
import pytest
import sympy as sp
from exact_cases import cr_peaks
from order_m_motion import Damper, forced_peak, half_cycle, of_restitution
from repository import ROOT
from scipy.integrate import quad
from scipy.optimize import brentq

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import CAP, Damping, critical_damping_ratio, normalisation
from rockdamp.solvers.exact import exact_history

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


@pytest.mark.parametrize("order", [0, 1, 2.5, 8, 32])
def test_every_peak_of_the_free_decay_is_cr_s_from_any_amplitude(order):
    for curve in (PAPER, TrilinearCurve(0.20, 0.50), TrilinearCurve(0.06, 0.72, 0.9, "translated")):
        for e, share in ((0.7, 0.9), (0.9, 0.02)):
            x0, damping = (
                share * float(curve.ultimate_displacement_ratio),
                Damping.from_restitution(e, "ECD", order=order),
            )
            run = exact_history(curve, damping, [1.5 * float(curve.period(x0))], release_amplitude=x0)
            peaks = np.abs(run.turning_displacement)
            assert peaks.size >= 2
            np.testing.assert_allclose(peaks, cr_peaks(curve, e, x0, peaks.size), rtol=1e-9)


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


def test_the_coefficient_follows_from_the_loss_at_each_phase():
    kappa, c, s = sp.symbols("kappa", positive=True), sp.cos(phi), sp.sin(phi)
    (solution,) = sp.solve(sp.Eq(D * c**2 / (1 + D * s * c), kappa * c ** (2 * m + 2)), D)
    assert sp.simplify(solution - kappa * c ** (2 * m) / (1 - kappa * c ** (2 * m + 1) * s)) == 0
    assert sp.simplify(1 / (1 + solution * s * c) - (1 - kappa * c ** (2 * m + 1) * s)) == 0  # ds/d phi


@pytest.mark.parametrize("order", [0.5, 1, 8, 64])
def test_half_cycles_end_up_to_the_critical_ratio(order):
    """The phase goes on while kappa cos^(2m+1) sin stays below 1; at its largest, the page's kappa_c is the inverse."""
    angle = np.linspace(0, np.pi / 2, 400001)
    largest = np.max(np.sin(angle) * np.cos(angle) ** (2 * order + 1))
    assert largest == pytest.approx(((2 * order + 1) / (2 * order + 2)) ** (order + 0.5) / np.sqrt(2 * order + 2))
    critical = float(critical_damping_ratio(order))
    assert 2 * critical * float(normalisation(order)) * largest == pytest.approx(1, rel=1e-9)
    if order >= 1:
        assert 2 / np.sqrt(3) <= critical < np.sqrt(2 * np.e / np.pi)


@pytest.mark.parametrize("order", [0.5, 4, 32])
@pytest.mark.parametrize("e", [0.05, 0.5, 0.95])
def test_a_half_cycle_of_a_linear_spring_lasts_as_long_as_without_damping(order, e):
    turn = half_cycle(PAPER, of_restitution(e, order), 0.03)
    assert turn.duration == pytest.approx(np.pi / float(PAPER.initial_frequency), rel=1e-10)
    assert turn.displacement == pytest.approx(0.03 * e, rel=1e-10)


def test_order_zero_with_the_denominator_is_ecd_but_for_the_second_order():
    """C of delta = -ln e: with it xi is delta/pi; ECD, which has none, is nearer to it the less is lost."""
    phases = np.linspace(-1.5, 1.5, 301)
    away = []
    for delta in (0.1, 0.05):
        with_it = 2 * delta / np.pi / (1 - 2 * delta / np.pi * np.sin(phases) * np.cos(phases))
        away.append(np.abs(with_it - 2 * delta / np.hypot(np.pi, delta)).max())
    assert away[0] / away[1] == pytest.approx(4, rel=0.05)


def size_without_denominator(e, order):
    """Return A of D = A cos^2m, of which the integral of the loss over a half cycle is -ln e."""

    def loss(size):
        def rate(phase):
            d = size * np.cos(phase) ** (2 * order)
            return d * np.cos(phase) ** 2 / (1 - (d * np.sin(phase) * np.cos(phase)) ** 2)

        return quad(rate, -np.pi / 2, np.pi / 2, epsabs=1e-13, limit=200)[0]

    return brentq(lambda size: loss(size) + np.log(e), 0.0, 1.0, xtol=1e-14)


@pytest.mark.parametrize(("e", "order"), [(0.75, 1.0), (0.85, 16.0)])
def test_the_form_without_the_denominator_is_exact_with_the_inverse_of_an_integral(e, order):
    class Undivided(Damper):
        def coefficient(self, branch, z, v):
            double_v = branch.double_energy(z) if z else 0.0
            w = branch.force(z) / np.sqrt(double_v) if z else np.sqrt(branch.stiffness)
            return self.amplitude * w * (v * v / (v * v + double_v)) ** self.order if v else 0.0

    turn = half_cycle(PAPER, Undivided(size_without_denominator(e, order), order), 0.5)
    assert turn.displacement == pytest.approx(float(PAPER.amplitude(e**2 * PAPER.energy(0.5))), rel=1e-9)


def test_the_table_of_orders():
    orders, n, least, force = table("order m | N_m")
    np.testing.assert_allclose(n, normalisation(orders), atol=5.1e-4)
    np.testing.assert_allclose(least[1:], np.exp(-CAP * np.pi * critical_damping_ratio(orders[1:])), atol=5.1e-4)
    for i, order in enumerate(orders):
        a = of_restitution(0.85, order).amplitude
        speed = half_cycle(PAPER, of_restitution(0.85, order), 0.5).crossing_speed
        assert a * float(PAPER.initial_frequency) * speed / 0.85 == pytest.approx(force[i], abs=5.1e-3)


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
    xi = float(Damping.from_restitution(0.85, "ECD").value)

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
        for stated, order in zip(columns[2:9, i], (0, 1, 2, 4, 8, 16, 64), strict=True):
            assert forced_peak(PAPER, of_restitution(0.85, order), load, duration) / free == pytest.approx(
                stated, abs=6e-4
            )
        samples = [load(tau) for tau in np.linspace(0, duration, 257)]
        for stated, (model, width) in zip(columns[9:, i], (("BAND", 0.2), ("BAND", 0.1), ("CQD", 0.25)), strict=True):
            damping = Damping.from_restitution(0.85, model, width=width)
            run = exact_history(PAPER, damping, [3.0], load=samples, sampling=duration / 256)
            assert run.turning_displacement[0] / free == pytest.approx(stated, abs=6e-4)
        peaks.append(free)
    np.testing.assert_allclose(np.sort(peaks), [0.06, 0.33, 0.40, 0.58], atol=0.005)


@pytest.mark.parametrize("order", [0, 4])
def test_a_wall_with_another_curve_on_each_side_loses_the_same_fraction(order):
    other = TrilinearCurve(0.15, 0.4, 0.8)
    its = of_restitution(0.85, order)
    for x0 in (0.05, 0.3):
        end = half_cycle(PAPER, its, x0, beyond=(other, its)).displacement
        assert end == pytest.approx(float(other.amplitude(0.85**2 * PAPER.energy(x0))), rel=1e-9)
        back = half_cycle(other, its, end, beyond=(PAPER, its)).displacement
        assert back == pytest.approx(float(PAPER.amplitude(0.85**4 * PAPER.energy(x0))), rel=1e-9)


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
