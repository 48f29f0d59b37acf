"""Sections 1 to 6 of docs/theory.md: the closed form, the energy-consistent damper, and their errors."""

import mpmath
import numpy as np
import pytest
import sympy as sp
from exact_cases import cr_peaks
from pages import assert_stated

from rockdamp.equivalence import matching
from rockdamp.equivalence.closed_form import (
    damping_ratio_energy,
    equivalence_factor,
    giannini_masiani,
)
from rockdamp.equivalence.matching import Cases
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Wall
from rockdamp.solvers.coefficient import damping_coefficient
from rockdamp.solvers.exact import exact_history

CURVES = {
    "paper": TrilinearCurve(0.04, 0.85),
    "stiff": TrilinearCurve(0.02, 0.85),
    "severe": TrilinearCurve(0.20, 0.50),
    "steeper": TrilinearCurve(0.06, 0.72, 0.9, "steeper"),
    "translated": TrilinearCurve(0.04, 0.85, 0.9, "translated"),
}
SHARES = (0.03, 0.2, 0.5, 0.95)  # of u3: on the first branch, the plateau and the softening branch
THEORY = "docs/theory.md"
MODELS = ("CDC", "CDR", "SDR")
every_curve = pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)


# --- 1. what a half cycle loses --------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", [*MODELS, "ECD"])
def test_first_order_loss_is_the_work_on_the_undamped_motion(model):
    """The ratio of both, less one, is of the order of xi: halving xi halves it, to first order."""
    curve, x0 = CURVES["paper"], 0.6
    work = 2 * float(curve.energy(x0)) / float(equivalence_factor(curve, Damping(model, 1.0), x0))
    away = []
    for xi in (0.02, 0.01, 0.005):
        run = exact_history(
            curve, Damping(model, xi), [0.7 * float(curve.period(x0))], release_amplitude=x0
        )
        lost = float(curve.energy(x0) - curve.energy(run.turning_displacement[0]))
        away.append(lost / (xi * work) - 1)
    np.testing.assert_allclose(np.divide(away[:-1], away[1:]), 2.0, rtol=0.15)


def energy_of_rates(wall):
    """H, U and the rise c of the page, for both bodies and a mass on top."""
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
    np.testing.assert_allclose(
        wall.inertia_ratio, 1 + (3 - 2 * r) / (r**2 * (1 - r)) * q, rtol=1e-13
    )


# --- 2. the closed form ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", [*MODELS, "ECD"])
def test_factor_of_a_linear_spring(model):
    curve = CURVES["severe"]
    assert float(equivalence_factor(curve, Damping(model, 1.0), 0.19)) == pytest.approx(
        1 / np.pi, rel=1e-12
    )
    e = 1 - np.array([2e-3, 1e-3])
    away = (
        damping_ratio_energy(curve, "CDR", e, 0.19) / giannini_masiani(e) - 1
    )  # of second order in 1 - e
    assert away[0] / away[1] == pytest.approx(4.0, rel=0.01)


def test_factors_of_the_paper_s_curve():
    factors = [
        np.pi * float(equivalence_factor(CURVES["paper"], Damping(model, 1.0), 0.5))
        for model in MODELS
    ]
    words = r"it is ([\d.]+) for CDC, ([\d.]+) for CDR and ([\d.]+) for SDR"
    assert_stated(THEORY, words, *factors)
    curve = TrilinearCurve(np.array([0.02, 0.10]), 0.85)
    by_a1 = np.pi * equivalence_factor(curve, Damping("SDR", 1.0), 0.5)
    assert_stated(THEORY, r"from ([\d.]+) at \$a_1\$ = 0.02 to ([\d.]+) at 0.10", *by_a1)


def elementary(curve, model, x0, m=mpmath):
    """J of the page's table: half the integral of c_hat s, from the elementary forms of the branches reached."""
    k1, b1, ks, a1, a2, a3 = (m.mpf(float(p)) for p in curve.parameters())
    x0, w1 = m.mpf(x0), m.sqrt(m.mpf(float(curve.initial_stiffness)))
    x1, x2 = min(x0, a1), min(max(x0, a1), a2)

    def energy(x):
        y1, y2, y3 = min(x, a1), min(max(x, a1), a2), max(x, a2)
        return k1 * y1**2 / 2 + b1 * (y2 - a1) + ks * (y3 - a2) * (2 * a3 - a2 - y3) / 2

    speed = {x: m.sqrt(2 * max(energy(x0) - energy(x), 0)) for x in (m.mpf(0), x1, x2)}
    s0, s1, s2 = speed[m.mpf(0)], speed[x1], speed[x2]
    total = w1 / 2 * (x1 * s1 + s0**2 / w1 * m.atan2(w1 * x1, s1))
    if x0 > a1:
        if model == "CDC":
            total += w1 * (s1**3 - s2**3) / (3 * b1)
        else:
            q = m.sqrt(s1**2 + 2 * b1 * a1)
            total += 2 / w1 * b1 * (s2 - s1 + q * (m.atanh(s1 / q) - m.atanh(s2 / q)))
    if x0 > a2:
        z, z0 = a3 - a2, a3 - x0
        root, log = m.sqrt(z**2 - z0**2), m.acosh(z / z0)
        area = (z * root - z0**2 * log) / 2
        if model == "CDC":
            total += w1 * m.sqrt(ks) * area
        else:
            last = m.sqrt(a3**2 - z0**2) * m.atanh(
                m.sqrt((z - z0) * (a3 + z0) / (z + z0) / (a3 - z0))
            )
            total += ks ** m.mpf("1.5") / w1 * (-area - a3 * root - a3**2 * log + 2 * a3 * last)
    return energy(x0), total


@every_curve
@pytest.mark.parametrize("model", ["CDC", "SDR"])
def test_elementary_forms_equal_the_quadrature(curve, model):
    for share in (0.01, 0.08, 0.2, 0.5, 0.95):
        x0 = share * float(curve.ultimate_displacement_ratio)
        energy, total = elementary(curve, model, x0)
        factor = float(equivalence_factor(curve, Damping(model, 1.0), x0))
        assert float(energy / (2 * total)) == pytest.approx(factor, rel=1e-9)


def test_elementary_forms_are_antiderivatives():
    x, z = sp.symbols("x z", positive=True)
    w1, big, b1, a1, s1, a3, z0 = sp.symbols("omega_1 S b_1 a_1 s_1 a_3 z_0", positive=True)
    speed = sp.sqrt(big**2 - w1**2 * x**2)
    first = w1 / 2 * (x * speed + big**2 / w1 * sp.atan(w1 * x / speed))
    assert sp.simplify(sp.diff(first, x) - w1 * speed) == 0

    speed = sp.sqrt(s1**2 - 2 * b1 * (x - a1))
    assert sp.simplify(sp.diff(-w1 * speed**3 / (3 * b1), x) - w1 * speed) == 0  # CDC
    q = sp.sqrt(s1**2 + 2 * b1 * a1)
    plateau = 2 / w1 * b1 * (speed - q * sp.atanh(speed / q))
    assert sp.simplify(sp.diff(plateau, x) - b1 / x * speed / w1) == 0  # SDR

    root = sp.sqrt(z**2 - z0**2)  # in z = a3 - x, over sqrt(ks)
    area = (z * root - z0**2 * sp.acosh(z / z0)) / 2
    last = sp.sqrt(a3**2 - z0**2) * sp.atanh(sp.sqrt((z - z0) * (a3 + z0) / (z + z0) / (a3 - z0)))
    softening = -area - a3 * root - a3**2 * sp.acosh(z / z0) + 2 * a3 * last
    for form, integrand in ((area, root), (softening, z * root / (a3 - z))):
        away = sp.diff(form, z) - integrand
        for values in (
            {z: 0.7, z0: 0.3, a3: 1.0},
            {z: 0.41, z0: 0.4, a3: 0.9},
            {z: 0.85, z0: 0.05, a3: 1.0},
        ):
            assert abs(away.subs(values).evalf(30)) < 1e-12


# --- 3. the damper that does not depend on the amplitude -------------------------------------------------------------


@every_curve
def test_ecd_solves_abels_equation(curve):
    """integral_0^E0 (C/f) dE/sqrt(2 (E0 - E)) = delta for C = (2 delta/pi) f/sqrt(2V), at every E0."""
    delta = 0.2
    damper = Damping("ECD", delta / np.pi)
    for share in SHARES:
        x0 = share * float(curve.ultimate_displacement_ratio)
        top = float(curve.energy(x0))
        angle = (
            (np.arange(2000) + 0.5) / 2000 * np.pi / 2
        )  # E = E0 sin^2: the integrand has no singularity left
        x = curve.amplitude(top * np.sin(angle) ** 2)
        ratio = damping_coefficient(curve, damper, x) / curve.force(x)
        integral = np.mean(ratio * np.sqrt(2 * top) * np.sin(angle)) * np.pi / 2
        assert integral == pytest.approx(delta, rel=1e-6)


def test_abels_equation_has_one_solution():
    """h(E) = (1/pi) d/dE of integral_0^E sqrt(2) delta/sqrt(E - s) ds solves integral_0^E h/sqrt(2 (E - s)) = delta."""
    energy, s, delta = sp.symbols("E s delta", positive=True)
    kernel = sp.integrate(1 / sp.sqrt(energy - s) / sp.sqrt(s), (s, 0, energy))
    assert (
        sp.simplify(kernel - sp.pi) == 0
    )  # why applying the kernel twice is integration, which has one inverse
    inverted = (
        sp.diff(sp.integrate(sp.sqrt(2) * delta / sp.sqrt(energy - s), (s, 0, energy)), energy)
        / sp.pi
    )
    assert sp.simplify(inverted - 2 * delta / sp.pi / sp.sqrt(2 * energy)) == 0


# --- 4. the exact result ---------------------------------------------------------------------------------------------


def test_substitution_makes_the_motion_linear():
    x, xi = sp.symbols("x xi", positive=True)
    force, potential = sp.Function("f")(x), sp.Function("V")(x)
    y, v = sp.sqrt(2 * potential), sp.Function("v")(x)
    coefficient = 2 * xi * force / y
    dv_dx = -(coefficient * v + force) / v  # v dv/dx = -(C v + f)
    dy_dx = sp.diff(y, x).subs(sp.diff(potential, x), force)
    assert sp.simplify(v * dv_dx / dy_dx + 2 * xi * v + y) == 0


@every_curve
def test_trajectories_of_the_linear_oscillator(curve):
    """(y, v) lies on the spiral of y'' + 2 xi y' + y = 0 from (y0, 0): y^2 + 2 xi y v + v^2 falls as its phase says."""
    xi, x0 = 0.08, 0.9 * float(curve.ultimate_displacement_ratio)
    times = np.linspace(0, 3 * float(curve.period(x0)), 400)
    run = exact_history(curve, Damping("ECD", xi), times, release_amplitude=x0)
    x, v = run.displacement, run.velocity
    y = np.sign(x) * np.sqrt(2 * curve.energy(x))
    wd = np.sqrt(1 - xi**2)
    # From rest: y = y0 exp(-xi s) (cos wd s + xi/wd sin wd s), v = -y0 exp(-xi s)/wd sin wd s.
    phase = np.unwrap(np.arctan2(-wd * v, y + xi * v))
    amplitude = np.hypot(wd * v, y + xi * v)
    expected = wd * np.sqrt(2 * float(curve.energy(x0))) * np.exp(-xi * phase / wd) / wd
    np.testing.assert_allclose(amplitude, expected, rtol=1e-8)


def test_ecd_meets_chiellini_s_condition():
    """d/dx (f/C) = k C, with f = V' of any potential V; and no other power of V does."""
    x, xi = sp.symbols("x xi", positive=True)
    potential = sp.Function("V", positive=True)(x)
    force = sp.diff(potential, x)

    def k(power):
        coefficient = 2 * xi * force / (2 * potential) ** power
        return sp.simplify(sp.diff(force / coefficient, x) / coefficient)

    half = sp.Rational(1, 2)
    assert sp.simplify(k(half) - 1 / (4 * xi**2)) == 0  # a residual of zero, whatever V
    assert all(sp.simplify(sp.diff(k(half + change), x)) != 0 for change in (-half / 3, half / 4))


def test_ecd_of_a_power_law_contact():
    x, k, n = sp.symbols("x k n", positive=True)
    force = k * x**n
    potential = k * x ** (n + 1) / (n + 1)
    frequency = sp.simplify(force / sp.sqrt(2 * potential))
    assert sp.simplify(frequency / (sp.sqrt((n + 1) / 2) * sp.sqrt(k) * x ** ((n - 1) / 2))) == 1
    hertz = frequency.subs(n, sp.Rational(3, 2))
    assert sp.simplify(hertz / (sp.sqrt(5) / 2 * sp.sqrt(k) * x ** sp.Rational(1, 4))) == 1
    assert (
        sp.simplify(frequency / sp.sqrt(force / x) - sp.sqrt((n + 1) / 2)) == 0
    )  # CDR, times a factor


# --- 5. errors of time -----------------------------------------------------------------------------------------------


def test_half_cycles_are_longer_than_under_restitution():
    """By how much, in %, between the same two peaks."""
    ends = []
    for e in (0.7, 0.9):
        longer, damper = [], Damping.from_restitution(e, "ECD")
        for curve in CURVES.values():
            for share in (*SHARES, 0.75, 0.9):
                x0 = share * float(curve.ultimate_displacement_ratio)
                run = exact_history(
                    curve, damper, [0.65 * float(curve.period(x0))], release_amplitude=x0
                )
                x1 = cr_peaks(curve, e, x0, 1)[0]
                longer.append(
                    100
                    * (run.turning_tau[0] / float((curve.period(x0) + curve.period(x1)) / 4) - 1)
                )
        linear = 100 / np.sqrt(1 - float(damper.value) ** 2) - 100
        assert min(longer) == pytest.approx(linear, rel=1e-3)
        ends += [min(longer), max(longer)]
    assert_stated(
        THEORY,
        r"by ([\d.]+) to ([\d.]+) % at \$e\$ = 0.7 and by ([\d.]+) to ([\d.]+) % at 0.9",
        *ends,
    )


def test_ratio_of_least_err_differs_from_that_of_the_peaks():
    """The paper's curve from 0.5 u_ins at e = 0.85 and 0.7, over the default response length."""
    e, step, steps = np.array([0.7, 0.85]), 0.005, 1600
    curve = CURVES["paper"].map(lambda p: np.full(e.size, p))
    decays = Cases.release(curve, np.full(e.size, 0.5), e, step=step, steps=steps)
    ratio = matching.match_dampers(decays, ["ECD"], steps, refinement=4)["ECD"].damping_ratio
    larger = 100 * (ratio / Damping.from_restitution(e, "ECD").value - 1)
    assert_stated(
        THEORY, r"is ([\d.]+) % larger at \$e\$ = 0.85 and ([\d.]+) % larger at 0.7", *larger[::-1]
    )
