"""Sections 1 to 6 of docs/theory.md: the closed form, the energy-consistent damper, errors."""

import mpmath
import numpy as np
import pytest
import sympy as sp
from exact_cases import cr_peaks
from pages import assert_stated

from rockdamp.equivalence.closed_form import (
    damping_ratio_energy,
    equivalence_factor,
    giannini_masiani,
)
from rockdamp.equivalence.matching import Cases, match_dampers
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Wall
from rockdamp.solvers.coefficient import damping_coefficient
from rockdamp.solvers.exact import exact_history

PAPER = TrilinearCurve(0.04, 0.85)
SEVERE = TrilinearCurve(0.20, 0.50)
CURVES = {
    "paper": PAPER,
    "stiff": TrilinearCurve(0.02, 0.85),
    "severe": SEVERE,
    "steeper": TrilinearCurve(0.06, 0.72, 0.9, "steeper"),
    "translated": TrilinearCurve(0.04, 0.85, 0.9, "translated"),
}
SHARES = (0.03, 0.2, 0.5, 0.95)  # of u3: on the first branch, the plateau and the softening branch
THEORY = "docs/theory.md"
MODELS = ("CDC", "CDR", "SDR")
every_curve = pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
every_model = pytest.mark.parametrize("model", [*MODELS, "ECD"])


def factor(curve, model, x0):
    return equivalence_factor(curve, Damping(model, 1.0), x0)


def end_of(curve):
    return float(curve.ultimate_displacement_ratio)


def is_zero(expression):
    return sp.simplify(expression) == 0


# --- 1. what a half cycle loses ------------------------------------------------------------------


@every_model
def test_first_order_loss_is_the_undamped_work(model):
    """Their ratio less one is of the order of xi: half of xi halves it, to first order."""
    x0 = 0.6
    work = 2 * float(PAPER.energy(x0)) / float(factor(PAPER, model, x0))
    end = 0.7 * float(PAPER.period(x0))
    differences = []
    for xi in (0.02, 0.01, 0.005):
        history = exact_history(PAPER, Damping(model, xi), [end], release_amplitude=x0)
        loss = float(PAPER.energy(x0) - PAPER.energy(history.turning_displacement[0]))
        differences.append(loss / (xi * work) - 1)
    halves = np.divide(differences[:-1], differences[1:])
    np.testing.assert_allclose(halves, 2.0, rtol=0.15)


def energy_of_rates(wall):
    """Return H, U and the rise c of the page, for both bodies and a mass on top."""
    r, q = wall.hinge_ratio, 1 / wall.slenderness**2
    sideways = 1 / 3 + q / 12 * (1 / r + 1 / (1 - r))
    upwards = q / (4 * r) + (1 - r) * q * (1 / r + 1 / (2 * (1 - r))) ** 2
    rise = np.sqrt(q) * (1 / r + (1 / 2 + wall.eccentricity / wall.thickness) / (1 - r))
    return sideways, upwards, rise


def test_own_inertia_is_the_energy_of_all_rates():
    """The mass on top is counted once, beside the bodies and not on top of the slender limit."""
    wall = Wall(
        0.3,
        [2.4, 3.0, 4.5],
        hinge_ratio=[0.5, 0.6, 0.7],
        overburden_ratio=1.3,
        eccentricity=0.05,
        overburden_mass=0.7,
        own_inertia=True,
    )
    sideways, upwards, rise = energy_of_rates(wall)
    energy = sideways + upwards + 0.7 * 1.3 * rise**2
    np.testing.assert_allclose(wall.effective_mass, 2 * wall.mass * energy, rtol=1e-13)


def test_own_inertia_of_walls_without_overburden():
    wall = Wall(0.3, np.array([3.0, 9.0]), hinge_ratio=0.6, own_inertia=True)
    sideways, upwards, _ = energy_of_rates(wall)
    np.testing.assert_allclose(wall.inertia_ratio, 3 * (sideways + upwards), rtol=1e-13)
    r, q = 0.6, 1 / wall.slenderness**2
    expected = 1 + (3 - 2 * r) / (r**2 * (1 - r)) * q
    np.testing.assert_allclose(wall.inertia_ratio, expected, rtol=1e-13)


# --- 2. the closed form --------------------------------------------------------------------------


@every_model
def test_factor_of_a_linear_spring(model):
    assert float(factor(SEVERE, model, 0.19)) == pytest.approx(1 / np.pi, rel=1e-12)


def test_linear_spring_tends_to_giannini_masiani():
    """The difference is of second order in 1 - e."""
    e = 1 - np.array([2e-3, 1e-3])
    differences = damping_ratio_energy(SEVERE, "CDR", e, 0.19) / giannini_masiani(e) - 1
    assert differences[0] / differences[1] == pytest.approx(4.0, rel=0.01)


def test_stated_factors_of_the_paper_s_curve():
    factors = [np.pi * float(factor(PAPER, model, 0.5)) for model in MODELS]
    words = r"it is ([\d.]+) for CDC, ([\d.]+) for CDR and ([\d.]+) for SDR"
    assert_stated(THEORY, words, *factors)


def test_stated_factors_by_a1():
    curve = TrilinearCurve(np.array([0.02, 0.10]), 0.85)
    factors = np.pi * factor(curve, "SDR", 0.5)
    assert_stated(THEORY, r"from ([\d.]+) at \$a_1\$ = 0.02 to ([\d.]+) at 0.10", *factors)


def elementary_integral(curve, model, x0):
    """Return V(x0) and J of the page's table, half the integral of c_hat s."""
    m = mpmath
    k1, b1, ks, a1, a2, a3 = (m.mpf(float(p)) for p in curve.parameters())
    x0 = m.mpf(x0)
    w1 = m.sqrt(m.mpf(float(curve.initial_stiffness)))
    x1 = min(x0, a1)
    x2 = min(max(x0, a1), a2)

    def energy(x):
        y1, y2, y3 = min(x, a1), min(max(x, a1), a2), max(x, a2)
        return k1 * y1**2 / 2 + b1 * (y2 - a1) + ks * (y3 - a2) * (2 * a3 - a2 - y3) / 2

    s0, s1, s2 = (m.sqrt(2 * max(energy(x0) - energy(x), 0)) for x in (m.mpf(0), x1, x2))
    total = w1 / 2 * (x1 * s1 + s0**2 / w1 * m.atan2(w1 * x1, s1))
    z, z0 = a3 - a2, a3 - x0
    if x0 > a1 and model == "CDC":
        total += w1 * (s1**3 - s2**3) / (3 * b1)
    elif x0 > a1:
        q = m.sqrt(s1**2 + 2 * b1 * a1)
        total += 2 / w1 * b1 * (s2 - s1 + q * (m.atanh(s1 / q) - m.atanh(s2 / q)))
    if x0 > a2:
        root, log = m.sqrt(z**2 - z0**2), m.acosh(z / z0)
        area = (z * root - z0**2 * log) / 2
        ratio = (z - z0) * (a3 + z0) / (z + z0) / (a3 - z0)
        last = m.sqrt(a3**2 - z0**2) * m.atanh(m.sqrt(ratio))
        if model == "CDC":
            total += w1 * m.sqrt(ks) * area
        else:
            bracket = -area - a3 * root - a3**2 * log + 2 * a3 * last
            total += ks ** m.mpf("1.5") / w1 * bracket
    return energy(x0), total


@every_curve
@pytest.mark.parametrize("model", ["CDC", "SDR"])
def test_elementary_forms_equal_the_quadrature(curve, model):
    for share in (0.01, 0.08, 0.2, 0.5, 0.95):
        x0 = share * end_of(curve)
        energy, total = elementary_integral(curve, model, x0)
        expected = float(factor(curve, model, x0))
        assert float(energy / (2 * total)) == pytest.approx(expected, rel=1e-9)


X, Z, W1, B1, A1, S1, A3, Z0 = sp.symbols("x z omega_1 b_1 a_1 s_1 a_3 z_0", positive=True)


def test_elementary_form_of_the_first_branch():
    largest = sp.symbols("S", positive=True)
    speed = sp.sqrt(largest**2 - W1**2 * X**2)
    form = W1 / 2 * (X * speed + largest**2 / W1 * sp.atan(W1 * X / speed))
    assert is_zero(sp.diff(form, X) - W1 * speed)


def test_elementary_forms_of_the_plateau():
    speed = sp.sqrt(S1**2 - 2 * B1 * (X - A1))
    assert is_zero(sp.diff(-W1 * speed**3 / (3 * B1), X) - W1 * speed)  # CDC
    q = sp.sqrt(S1**2 + 2 * B1 * A1)
    form = 2 / W1 * B1 * (speed - q * sp.atanh(speed / q))
    assert is_zero(sp.diff(form, X) - B1 / X * speed / W1)  # SDR


ROOT = sp.sqrt(Z**2 - Z0**2)  # the speed in z = a3 - x, over sqrt(ks)
AREA = (Z * ROOT - Z0**2 * sp.acosh(Z / Z0)) / 2
RATIO = (Z - Z0) * (A3 + Z0) / (Z + Z0) / (A3 - Z0)
LAST = sp.sqrt(A3**2 - Z0**2) * sp.atanh(sp.sqrt(RATIO))
SOFTENING = -AREA - A3 * ROOT - A3**2 * sp.acosh(Z / Z0) + 2 * A3 * LAST


@pytest.mark.parametrize(
    ("form", "integrand"), [(AREA, ROOT), (SOFTENING, Z * ROOT / (A3 - Z))], ids=["CDC", "SDR"]
)
@pytest.mark.parametrize("values", [(0.7, 0.3, 1.0), (0.41, 0.4, 0.9), (0.85, 0.05, 1.0)])
def test_elementary_forms_of_the_softening_branch(form, integrand, values):
    residual = sp.diff(form, Z) - integrand
    place = dict(zip((Z, Z0, A3), values, strict=True))
    assert abs(residual.subs(place).evalf(30)) < 1e-12


# --- 3. the damper that does not depend on the amplitude -----------------------------------------


@every_curve
def test_ecd_solves_abel_s_equation(curve):
    """The integral of (C/f) dE/sqrt(2 (E0 - E)) from 0 to E0 is delta at every E0."""
    delta = 0.2
    damper = Damping("ECD", delta / np.pi)
    largest = curve.energy(np.array(SHARES) * end_of(curve))[:, None]
    # With E = E0 sin^2 the integrand has no singularity.
    angle = (np.arange(2000) + 0.5) / 2000 * np.pi / 2
    x = curve.amplitude(largest * np.sin(angle) ** 2)
    ratio = damping_coefficient(curve, damper, x) / curve.force(x)
    integral = np.mean(ratio * np.sqrt(2 * largest) * np.sin(angle), axis=1) * np.pi / 2
    np.testing.assert_allclose(integral, delta, rtol=1e-6)


def test_abel_s_equation_has_one_solution():
    """Applying the kernel twice is integration, which has one inverse."""
    energy, s, delta = sp.symbols("E s delta", positive=True)
    kernel = sp.integrate(1 / sp.sqrt(energy - s) / sp.sqrt(s), (s, 0, energy))
    assert is_zero(kernel - sp.pi)
    integral = sp.integrate(sp.sqrt(2) * delta / sp.sqrt(energy - s), (s, 0, energy))
    inverted = sp.diff(integral, energy) / sp.pi
    assert is_zero(inverted - 2 * delta / sp.pi / sp.sqrt(2 * energy))


# --- 4. the exact result -------------------------------------------------------------------------


def test_substitution_makes_the_motion_linear():
    x, xi = sp.symbols("x xi", positive=True)
    force, potential = sp.Function("f")(x), sp.Function("V")(x)
    y, v = sp.sqrt(2 * potential), sp.Function("v")(x)
    coefficient = 2 * xi * force / y
    dv_dx = -(coefficient * v + force) / v  # v dv/dx = -(C v + f)
    dy_dx = sp.diff(y, x).subs(sp.diff(potential, x), force)
    assert is_zero(v * dv_dx / dy_dx + 2 * xi * v + y)


@every_curve
def test_trajectories_of_the_linear_oscillator(curve):
    """(y, v) lies on the spiral of y'' + 2 xi y' + y = 0 from (y0, 0)."""
    xi, x0 = 0.08, 0.9 * end_of(curve)
    times = np.linspace(0, 3 * float(curve.period(x0)), 400)
    history = exact_history(curve, Damping("ECD", xi), times, release_amplitude=x0)
    x, v = history.displacement, history.velocity
    y = np.sign(x) * np.sqrt(2 * curve.energy(x))
    wd = np.sqrt(1 - xi**2)
    # From rest: y = y0 exp(-xi s) (cos wd s + xi/wd sin wd s), v = -y0 exp(-xi s)/wd sin wd s.
    phase = np.unwrap(np.arctan2(-wd * v, y + xi * v))
    amplitude = np.hypot(wd * v, y + xi * v)
    expected = np.sqrt(2 * float(curve.energy(x0))) * np.exp(-xi * phase / wd)
    np.testing.assert_allclose(amplitude, expected, rtol=1e-8)


def chiellini_constant(power):
    """Return k of d/dx (f/C) = k C for C = 2 xi f/(2V)^power, f = V' of any potential V."""
    x, xi = sp.symbols("x xi", positive=True)
    potential = sp.Function("V", positive=True)(x)
    force = sp.diff(potential, x)
    coefficient = 2 * xi * force / (2 * potential) ** power
    return sp.simplify(sp.diff(force / coefficient, x) / coefficient), x, xi


def test_ecd_meets_chiellini_s_condition():
    k, _, xi = chiellini_constant(sp.Rational(1, 2))
    assert is_zero(k - 1 / (4 * xi**2))


@pytest.mark.parametrize("power", [sp.Rational(1, 3), sp.Rational(5, 8)])
def test_no_other_power_meets_chiellini_s_condition(power):
    k, x, _ = chiellini_constant(power)
    assert not is_zero(sp.diff(k, x))


def power_law_frequency():
    """Return w_E, x, k, n and f of the contact f = k x^n."""
    x, k, n = sp.symbols("x k n", positive=True)
    force = k * x**n
    potential = k * x ** (n + 1) / (n + 1)
    return sp.simplify(force / sp.sqrt(2 * potential)), x, k, n, force


def test_ecd_of_a_power_law_contact():
    frequency, x, k, n, _ = power_law_frequency()
    expected = sp.sqrt((n + 1) / 2) * sp.sqrt(k) * x ** ((n - 1) / 2)
    assert sp.simplify(frequency / expected) == 1


def test_ecd_of_hertz_contact():
    frequency, x, k, n, _ = power_law_frequency()
    expected = sp.sqrt(5) / 2 * sp.sqrt(k) * x ** sp.Rational(1, 4)
    assert sp.simplify(frequency.subs(n, sp.Rational(3, 2)) / expected) == 1


def test_ecd_of_a_power_law_is_cdr_times_a_factor():
    frequency, x, _, n, force = power_law_frequency()
    assert is_zero(frequency / sp.sqrt(force / x) - sp.sqrt((n + 1) / 2))


# --- 5. errors of time ---------------------------------------------------------------------------


def lengthening(curve, e, x0):
    """Return by how much a half cycle of ECD lasts longer than under restitution. [%]"""
    damper = Damping.from_restitution(e, "ECD")
    period = float(curve.period(x0))
    history = exact_history(curve, damper, [0.65 * period], release_amplitude=x0)
    next_peak = cr_peaks(curve, e, x0, 1)[0]
    duration = (period + float(curve.period(next_peak))) / 4
    return 100 * (history.turning_tau[0] / duration - 1)


def test_half_cycles_are_longer_than_under_restitution():
    """The least lengthening is that of the linear oscillator."""
    expected = []
    for e in (0.7, 0.9):
        longer = [
            lengthening(curve, e, share * end_of(curve))
            for curve in CURVES.values()
            for share in (*SHARES, 0.75, 0.9)
        ]
        xi = float(Damping.from_restitution(e, "ECD").value)
        assert min(longer) == pytest.approx(100 / np.sqrt(1 - xi**2) - 100, rel=1e-3)
        expected += [min(longer), max(longer)]
    words = r"by ([\d.]+) to ([\d.]+) % at \$e\$ = 0.7 and by ([\d.]+) to ([\d.]+) % at 0.9"
    assert_stated(THEORY, words, *expected)


def test_ratio_of_least_err_differs_from_that_of_the_peaks():
    """The paper's curve from 0.5 u_ins at e = 0.85 and 0.7, over the default response length."""
    e, step, steps = np.array([0.7, 0.85]), 0.005, 1600
    curve = PAPER.map(lambda parameter: np.full(e.size, parameter))
    decays = Cases.release(curve, np.full(e.size, 0.5), e, step=step, steps=steps)
    ratio = match_dampers(decays, ["ECD"], steps, refinement=4)["ECD"].damping_ratio
    larger = 100 * (ratio / Damping.from_restitution(e, "ECD").value - 1)
    words = r"is ([\d.]+) % larger at \$e\$ = 0.85 and ([\d.]+) % larger at 0.7"
    assert_stated(THEORY, words, *larger[::-1])
