"""Section 8 of docs/theory.md: a loss that depends on the amplitude, and its damper."""

import math

import numpy as np
import pytest
import sympy as sp
from exact_cases import random_curve
from pages import assert_stated, stated_rows
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from rockdamp.equivalence.closed_form import equivalence_factor
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.dampers import normalisation
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.coefficient import damping_coefficient
from rockdamp.solvers.exact import exact_history, restitution_factor
from rockdamp.solvers.kernel import cr_law
from rockdamp.solvers.newmark import simulate

PAPER = TrilinearCurve(0.04, 0.85)
THEORY = "docs/theory.md"


def lost(curve, e, g, at):
    """K, what E^g loses in each half cycle."""
    return float(curve.energy(at)) ** g * (1 - e ** (2 * g))


def turns(curve, damping, x0, count):
    """Peaks after the release, `count` of them at most."""
    end = (count + 1) * float(curve.period(x0)) / 2 + 1.0
    return np.abs(exact_history(curve, damping, [end], release_amplitude=x0).turning_displacement)[
        :count
    ]


def test_law_is_the_flow_over_whole_impacts():
    """dE/dn = -2 d_r E (E_r/E)^g from E_0: at n = 1 the law of one impact, after n impacts that of n times K."""
    n, g, e, start, energy_r = sp.symbols("n g e E_0 E_r", positive=True)
    k = energy_r**g * (1 - e ** (2 * g))
    energy = (start**g - n * k) ** (1 / g)
    flow = -2 * (1 - e ** (2 * g)) / (2 * g) * energy * (energy_r / energy) ** g
    numbers = {
        n: 3,
        g: sp.Rational(26, 100),
        e: sp.Rational(85, 100),
        start: 2,
        energy_r: sp.Rational(1, 3),
    }
    assert abs((sp.diff(energy, n) - flow).subs(numbers).evalf(30)) < 1e-25
    factor = sp.sqrt(energy / start).subs({n: 1, start: energy_r})  # of one impact from E_r
    assert abs(factor.subs(numbers).evalf(30) - numbers[e]) < 1e-25


def test_peaks_of_a_hundred_random_curves():
    rng = np.random.default_rng(42)
    compared = 0
    for case in range(100):
        curve = random_curve(rng, case, least=3e-3)
        a3 = float(curve.ultimate_displacement_ratio)
        e, g, at, x0 = (
            rng.uniform(0.5, 0.98),
            rng.uniform(0.02, 0.45),
            a3 * rng.uniform(0.05, 0.9),
            0.9 * a3,
        )
        k = lost(curve, e, g, at)
        energies = float(curve.energy(x0)) ** g - k * np.arange(1, 5)
        expected = curve.amplitude(np.maximum(energies, 0.0) ** (1 / g))
        found = turns(curve, Damping("CR", e, loss_exponent=g, reference_amplitude=at), x0, 4)
        assert found.size == (energies > 0).sum()
        np.testing.assert_allclose(found, expected[: found.size], rtol=1e-9)
        regular = (
            np.concatenate([[True], energies[:-1] > 2.2 * k])[: found.size].cumprod().astype(bool)
        )
        order = rng.choice([0.0, 0.5, 1.0, 4.0, 16.0])
        damping = Damping.from_restitution(
            e, "ECD", order=order, loss_exponent=g, reference_amplitude=at
        )
        damped = turns(curve, damping, x0, 4)[: found.size]
        both = regular[: damped.size] & (float(curve.energy(x0)) ** g > 2.2 * k)
        np.testing.assert_allclose(damped[both], expected[: damped.size][both], rtol=1e-8)
        compared += both.sum()
    assert compared > 150


def test_damper_on_two_different_sides():
    """Each side of x = 0 has a curve of its own; V at the turns falls by K in its power g."""
    e, g, order, energy_r = 0.85, 0.26, 4.0, 0.2
    kappa_r = 2 * (1 - e ** (2 * g)) / (2 * g * math.pi) * float(normalisation(order))

    def frequency(
        y,
    ):  # of f = x (1 - x^2/4) for x > 0 and a spring of stiffness 9 for x < 0, as a function of y
        if y < 0:
            return 3.0
        x2 = 2 * y * y / (1 + math.sqrt(max(1 - y * y / 2, 0.0)))
        return math.sqrt(x2) * (1 - x2 / 4) / y if y > 1e-8 else 1.0

    def rates(tau, state):
        y, v = state.tolist()
        energy = (y * y + v * v) / 2
        q = kappa_r * (energy_r / energy) ** g * (v * v / 2 / energy) ** order
        w = frequency(y)
        return w * v, -w * (y + q * v / (1 - q * y * v / 2 / energy))

    def at_rest(tau, state):
        return state[1]

    y, found = 1.3, []
    for _ in range(4):
        sign = -1 if y > 0 else 1
        at_rest.terminal, at_rest.direction = True, -sign
        start = [y, sign * 1e-12]
        run = solve_ivp(
            rates, (0, 20), start, "DOP853", events=at_rest, rtol=1e-12, atol=1e-14, max_step=0.02
        )
        y = run.y_events[0][0][0]
        found.append((y * y / 2) ** g)
    k = energy_r**g * (1 - e ** (2 * g))
    np.testing.assert_allclose(found, (1.3**2 / 2) ** g - k * np.arange(1, 5), rtol=1e-8)


@pytest.mark.parametrize(("e", "g"), [(0.85, 0.26), (0.7, 0.39), (0.95, 0.2), (0.85, 0.7)])
def test_wall_stops(e, g):
    for x0 in (0.3, 0.6):
        exact = (float(PAPER.energy(x0)) / float(PAPER.energy(0.3))) ** g / (1 - e ** (2 * g))
        run = exact_history(PAPER, Damping("CR", e, loss_exponent=g), [60.0], release_amplitude=x0)
        assert run.impacts.size == math.ceil(exact)
        assert run.displacement[0] == 0 and run.velocity[0] == 0
        batched = simulate(
            PAPER, Damping("CR", e, loss_exponent=g), release_amplitude=x0, step=0.001, steps=60000
        )
        assert (
            abs(int(batched.impacts) - math.ceil(exact)) <= 1
        )  # its last half cycles are a few steps long


def test_thirteenth_impact_is_the_last():
    last = math.ceil(1 / (1 - 0.85 ** (2 * 0.26)))
    assert_stated(THEORY, r"the (\d+)th from \$E_r\$ at \$e_r\$ = 0.85 and \$g\$ = 0.26", last)


def test_load_moves_a_wall_at_rest():
    """At rest from impact 5 on, until a half sine pushes: then as a wall that starts from rest."""
    damping, step = Damping("CR", 0.7, loss_exponent=0.39), 0.01
    load = 1.5 * np.sin(np.pi * np.arange(71) * step / 0.7)
    start = 20.0
    delayed = np.concatenate([np.zeros(round(start / step)), load])
    times = np.array([19.0, 20.3, 21.0, 22.0])
    run = exact_history(PAPER, damping, times, release_amplitude=0.3, load=delayed, sampling=step)
    fresh = exact_history(PAPER, damping, times[1:] - start, load=load, sampling=step)
    np.testing.assert_allclose(run.displacement, [0.0, *fresh.displacement], atol=1e-9)
    assert abs(run.displacement[1]) > 0.01


@pytest.mark.parametrize("law", [lambda v, *p: cr_law(v, p), restitution_factor])
def test_limit_of_a_constant_coefficient(law):
    for e in (0.3, 0.85, 0.99, 1.0):
        assert law(0.7, e, 0.0, 0.2) == e
        for speed in (1e-3, 0.1, 2.0):
            for g in (1e-14, 1e-12, 1e-10):
                away = (
                    -(math.log(e) ** 2) * g if e < 1 else 0.0
                )  # of ln e by first order in g, and more of it by the level
                level = g * math.log(e) * math.log(speed**2 / 0.2)
                assert law(speed, e, g, 0.2) == pytest.approx(e * (1 - away - level), abs=1e-10)
    plain = turns(PAPER, Damping("CR", 0.85), 0.5, 5)
    np.testing.assert_allclose(
        turns(PAPER, Damping("CR", 0.85, loss_exponent=1e-11), 0.5, 5), plain, rtol=1e-10
    )
    damped = turns(
        PAPER, Damping.from_restitution(0.85, "ECD", order=8, loss_exponent=1e-11), 0.5, 5
    )
    np.testing.assert_allclose(damped, plain, rtol=1e-10)


def test_both_forms_of_the_factor():
    for e in (0.1, 0.6, 0.9, 1.0):
        for g in (0.01, 0.3, 0.5, 1.5):
            for speed in (1e-9, 0.05, 0.4, 3.0):
                factor = restitution_factor(speed, e, g, 0.16)
                assert cr_law(speed, (e, g, 0.16)) == pytest.approx(factor, rel=1e-11, abs=1e-300)
                left = (speed**2) ** g - 0.16**g * (1 - e ** (2 * g))
                assert (factor * speed) ** (2 * g) == pytest.approx(
                    max(left, 0.0), rel=1e-9, abs=1e-14
                )
            assert restitution_factor(0.4, e, g, 0.16) == pytest.approx(
                e, rel=1e-13
            )  # at E_r it is e_r


def test_one_half_is_friction_on_a_linear_spring():
    curve = TrilinearCurve(0.5, 0.45)  # within its first branch
    run = turns(curve, Damping("CR", 0.8, loss_exponent=0.5, reference_amplitude=0.3), 0.45, 5)
    np.testing.assert_allclose(np.diff([0.45, *run]), -0.3 * (1 - 0.8), rtol=1e-10)
    damper = Damping.from_restitution(
        0.8, "ECD", order=4, loss_exponent=0.5 - 1e-9, reference_amplitude=0.3
    )  # its limit, which itself is refused
    np.testing.assert_allclose(
        np.diff([0.45, *turns(curve, damper, 0.45, 5)]), -0.3 * (1 - 0.8), rtol=1e-7
    )


def test_e_at_other_amplitudes():
    double_r = 2 * float(PAPER.energy(0.3))
    found = [
        restitution_factor(math.sqrt(2 * float(PAPER.energy(x))), 0.85, 0.26, double_r)
        for x in (0.05, 0.1, 0.2, 0.5)
    ]
    assert_stated(
        THEORY, r"\$e\$ is ([\d.]+), ([\d.]+), ([\d.]+) and ([\d.]+) from releases at", *found
    )


def test_table_of_regular_half_cycles():
    """The least (E_0/K)^g at which kappa cos^(2m+1) sin stays below 1 on the way, as E falls along the phase."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 20001)
    for g, *multiples in stated_rows(THEORY, "g | order 0"):
        for order, multiple in zip((0, 4, 16), multiples, strict=True):
            c, s = np.cos(angle), np.sin(angle)
            part = np.cumsum(c ** (2 * order + 2)) / np.sum(
                c ** (2 * order + 2)
            )  # of K, lost so far
            steepest = (
                float(normalisation(order)) / (np.pi * g) * c ** (2 * order + 1) * s
            )  # times K over E^g

            def worst(start, part=part, steepest=steepest):
                return np.max(steepest / (start - part)) - 1

            assert brentq(worst, 1.0001, 10) == pytest.approx(multiple, abs=0.006)


@pytest.mark.parametrize("order", [0.0, 4.0, 16.0])
@pytest.mark.parametrize("g", [0.13, 0.26, 0.45])
def test_damping_force_over_energy(g, order):
    """At one phase of the way in, on the first branch: x and v times a number multiply E by its square."""
    damping = Damping.from_restitution(0.85, "ECD", order=order, loss_exponent=g)
    x, v = -0.02 * np.array([1.0, 0.1, 1e-3]), 0.1 * np.array([1.0, 0.1, 1e-3])
    q = damping_coefficient(PAPER, damping, x, v) * v
    kappa_q = (
        damping_coefficient(PAPER, damping, 0.0, v) * v
    )  # at the crossing, where nothing is divided
    np.testing.assert_allclose(
        kappa_q / kappa_q[0], np.array([1.0, 0.1, 1e-3]) ** (1 - 2 * g), rtol=1e-9
    )
    assert np.all(np.diff(q) < 0) and np.all(q > 0)


@pytest.mark.parametrize("order", [0.0, 4.0, 16.0])
def test_coefficient_is_finite(order):
    damping = Damping.from_restitution(0.85, "ECD", order=order, loss_exponent=0.26)
    size = np.geomspace(1e-12, 1.0, 25)[:, None, None]
    x, v = np.linspace(-0.04, 0.04, 10)[:, None], np.linspace(-0.2, 0.2, 10)
    found = damping_coefficient(PAPER, damping, size * x, size * v)
    assert np.isfinite(found).all() and (found >= 0).all()
    double_t, double_v = (size * v) ** 2, 2 * PAPER.energy(np.abs(size * x))
    kappa = (2 * float(PAPER.energy(0.3)) / (double_t + double_v)) ** 0.26
    kappa *= 2 * float(damping.value) * float(normalisation(order))
    bound = (
        float(PAPER.initial_frequency) * kappa * (double_t / (double_t + double_v)) ** order / 0.05
    )
    assert (found <= bound * (1 + 1e-9)).all() and np.isclose(found, bound).any()  # the cap is met
    at_rest = damping_coefficient(PAPER, damping, [0.0, 0.0, 1e-3], [0.0, 1e-9, 0.0])
    assert np.isfinite(at_rest).all()


def test_exponent_of_sdr_on_a_nearly_rigid_block():
    """Its local g, by the loss of a half cycle at two amplitudes: each power of ten in a1 brings it nearer."""

    def local(a1, amplitudes):
        curve = TrilinearCurve(a1, 1 - 2 * a1)
        log_loss = -np.log(equivalence_factor(curve, Damping("SDR", 1.0), np.array(amplitudes)))
        return float(-np.diff(log_loss)[0] / np.diff(np.log(curve.energy(amplitudes)))[0])

    assert 0.2 < local(0.005, [0.05, 0.1]) < local(0.005, [0.2, 0.5]) < 0.3
    found = [local(a1, [0.05, 0.1]) for a1 in (0.05, 5e-3, 5e-4, 5e-5)]
    assert np.all(np.diff(found) > 0) and found[-1] < 0.5
    assert np.all(
        np.diff(0.5 - np.array(found)) / (0.5 - np.array(found[:-1])) > -0.7
    )  # not faster than this a decade
