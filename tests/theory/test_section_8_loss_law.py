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
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.half_cycle_loss import normalisation
from rockdamp.solvers.coefficient import damping_coefficient
from rockdamp.solvers.exact import exact_history, restitution_factor
from rockdamp.solvers.kernel import cr_law
from rockdamp.solvers.newmark import simulate

PAPER = TrilinearCurve(0.04, 0.85)
THEORY = "docs/theory.md"
every_order = pytest.mark.parametrize("order", [0.0, 4.0, 16.0])


def loss_of_power(curve, e, g, reference):
    """Return K, the loss of E^g in each half cycle."""
    return float(curve.energy(reference)) ** g * (1 - e ** (2 * g))


def turns(curve, damping, x0, count):
    """Return the peaks after the release, at most `count` of them."""
    end = (count + 1) * float(curve.period(x0)) / 2 + 1.0
    history = exact_history(curve, damping, [end], release_amplitude=x0)
    return np.abs(history.turning_displacement)[:count]


# --- the law -------------------------------------------------------------------------------------

N, G, E, START, REFERENCE = sp.symbols("n g e E_0 E_r", positive=True)
K = REFERENCE**G * (1 - E ** (2 * G))
ENERGY = (START**G - N * K) ** (1 / G)
VALUES = {
    N: 3,
    G: sp.Rational(26, 100),
    E: sp.Rational(85, 100),
    START: 2,
    REFERENCE: sp.Rational(1, 3),
}


def test_law_is_a_flow_over_whole_impacts():
    """dE/dn = -2 d_r E (E_r/E)^g; after n impacts E^g has lost n times K."""
    flow = -2 * (1 - E ** (2 * G)) / (2 * G) * ENERGY * (REFERENCE / ENERGY) ** G
    residual = sp.diff(ENERGY, N) - flow
    assert abs(residual.subs(VALUES).evalf(30)) < 1e-25


def test_one_impact_from_the_reference_has_e():
    factor = sp.sqrt(ENERGY / START).subs({N: 1, START: REFERENCE})
    assert abs(factor.subs(VALUES).evalf(30) - VALUES[E]) < 1e-25


def random_cases(count):
    """Yield curves with e, g, the reference amplitude and the release."""
    rng = np.random.default_rng(42)
    for case in range(count):
        curve = random_curve(rng, case, smallest=3e-3)
        a3 = float(curve.ultimate_displacement_ratio)
        e, g = rng.uniform(0.5, 0.98), rng.uniform(0.02, 0.45)
        reference = a3 * rng.uniform(0.05, 0.9)
        order = rng.choice([0.0, 0.5, 1.0, 4.0, 16.0])
        yield curve, e, g, reference, order, 0.9 * a3


def remaining_powers(curve, e, g, reference, x0):
    """Return E^g after each of four half cycles, below 0 once the wall has stopped."""
    k = loss_of_power(curve, e, g, reference)
    return float(curve.energy(x0)) ** g - k * np.arange(1, 5)


def test_peaks_of_restitution_on_random_curves():
    for curve, e, g, reference, _, x0 in random_cases(100):
        powers = remaining_powers(curve, e, g, reference, x0)
        expected = curve.amplitude(np.maximum(powers, 0.0) ** (1 / g))
        damping = Damping("CR", e, loss_exponent=g, reference_amplitude=reference)
        peaks = turns(curve, damping, x0, 4)
        assert peaks.size == (powers > 0).sum()
        np.testing.assert_allclose(peaks, expected[: peaks.size], rtol=1e-9)


def test_peaks_of_the_damper_on_random_curves():
    """In half cycles that start with E^g above 2.2 K; smaller ones are not regular."""
    compared = 0
    for curve, e, g, reference, order, x0 in random_cases(100):
        k = loss_of_power(curve, e, g, reference)
        powers = remaining_powers(curve, e, g, reference, x0)
        starts = np.concatenate([[float(curve.energy(x0)) ** g], powers[:-1]])
        regular = int((starts > 2.2 * k).cumprod().sum())
        damping = Damping.from_restitution(
            e, "ECD", order=order, loss_exponent=g, reference_amplitude=reference
        )
        peaks = turns(curve, damping, x0, 4)[:regular]
        expected = curve.amplitude(np.maximum(powers, 0.0) ** (1 / g))
        np.testing.assert_allclose(peaks, expected[: peaks.size], rtol=1e-8)
        compared += peaks.size
    assert compared > 150


def test_damper_on_two_different_sides():
    """Each side of x = 0 has its curve; V at the turns falls by K in its power g."""
    e, g, order, reference = 0.85, 0.26, 4.0, 0.2
    k = reference**g * (1 - e ** (2 * g))
    kappa = 2 * (1 - e ** (2 * g)) / (2 * g * math.pi) * float(normalisation(order))

    def frequency(y):
        """f = x (1 - x^2/4) for x > 0 and a spring of stiffness 9 for x < 0, in y."""
        if y < 0:
            return 3.0
        if y < 1e-8:
            return 1.0
        square = 2 * y * y / (1 + math.sqrt(max(1 - y * y / 2, 0.0)))
        return math.sqrt(square) * (1 - square / 4) / y

    def rates(tau, state):
        y, v = state.tolist()
        energy = (y * y + v * v) / 2
        q = kappa * (reference / energy) ** g * (v * v / 2 / energy) ** order
        w = frequency(y)
        return w * v, -w * (y + q * v / (1 - q * y * v / 2 / energy))

    def turning(tau, state):
        return state[1]

    turning.terminal = True
    y, powers = 1.3, []
    for _ in range(4):
        direction = -1 if y > 0 else 1
        turning.direction = -direction
        start = [y, direction * 1e-12]
        accuracy = {"rtol": 1e-12, "atol": 1e-14, "max_step": 0.02}
        history = solve_ivp(rates, (0, 20), start, "DOP853", events=turning, **accuracy)
        y = history.y_events[0][0][0]
        powers.append((y * y / 2) ** g)
    np.testing.assert_allclose(powers, (1.3**2 / 2) ** g - k * np.arange(1, 5), rtol=1e-8)


# --- rest ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("e", "g"), [(0.85, 0.26), (0.7, 0.39), (0.95, 0.2), (0.85, 0.7)])
@pytest.mark.parametrize("x0", [0.3, 0.6])
def test_wall_stops_after_its_last_impact(e, g, x0):
    energy = float(PAPER.energy(x0)) / float(PAPER.energy(0.3))
    impacts = math.ceil(energy**g / (1 - e ** (2 * g)))
    damping = Damping("CR", e, loss_exponent=g)
    history = exact_history(PAPER, damping, [60.0], release_amplitude=x0)
    assert history.impacts.size == impacts
    assert history.displacement[0] == 0
    assert history.velocity[0] == 0
    batched = simulate(PAPER, damping, release_amplitude=x0, step=0.001, steps=60000)
    assert abs(int(batched.impacts) - impacts) <= 1  # the last half cycles are a few steps long


def test_thirteenth_impact_is_the_last():
    last = math.ceil(1 / (1 - 0.85 ** (2 * 0.26)))
    assert_stated(THEORY, r"the (\d+)th from \$E_r\$ at \$e_r\$ = 0.85 and \$g\$ = 0.26", last)


def test_load_moves_a_wall_at_rest():
    """At rest from impact 5 on, until a half sine pushes it as a wall that starts from rest."""
    damping, step, start = Damping("CR", 0.7, loss_exponent=0.39), 0.01, 20.0
    load = 1.5 * np.sin(np.pi * np.arange(71) * step / 0.7)
    delayed = np.concatenate([np.zeros(round(start / step)), load])
    times = np.array([19.0, 20.3, 21.0, 22.0])
    history = exact_history(
        PAPER, damping, times, release_amplitude=0.3, load=delayed, sampling=step
    )
    fresh = exact_history(PAPER, damping, times[1:] - start, load=load, sampling=step)
    np.testing.assert_allclose(history.displacement, [0.0, *fresh.displacement], atol=1e-9)
    assert abs(history.displacement[1]) > 0.01


# --- the factor of an impact ---------------------------------------------------------------------


def kernel_factor(speed, e, g, double_reference):
    return cr_law(speed, (e, g, double_reference))


@pytest.mark.parametrize("law", [kernel_factor, restitution_factor])
@pytest.mark.parametrize("e", [0.3, 0.85, 0.99, 1.0])
def test_factor_tends_to_a_constant_e(law, e):
    """To first order in g, ln e changes by its square and by the level of the energy."""
    assert law(0.7, e, 0.0, 0.2) == e
    log = math.log(e)
    for speed in (1e-3, 0.1, 2.0):
        level = log * math.log(speed**2 / 0.2)
        for g in (1e-14, 1e-12, 1e-10):
            expected = e * (1 + log**2 * g - level * g)
            assert law(speed, e, g, 0.2) == pytest.approx(expected, abs=1e-10), (speed, g)


def test_peaks_tend_to_those_of_a_constant_e():
    constant = turns(PAPER, Damping("CR", 0.85), 0.5, 5)
    small = turns(PAPER, Damping("CR", 0.85, loss_exponent=1e-11), 0.5, 5)
    np.testing.assert_allclose(small, constant, rtol=1e-10)
    damper = Damping.from_restitution(0.85, "ECD", order=8, loss_exponent=1e-11)
    np.testing.assert_allclose(turns(PAPER, damper, 0.5, 5), constant, rtol=1e-10)


@pytest.mark.parametrize("e", [0.1, 0.6, 0.9, 1.0])
@pytest.mark.parametrize("g", [0.01, 0.3, 0.5, 1.5])
def test_both_solvers_have_the_factor_of_the_law(e, g):
    for speed in (1e-9, 0.05, 0.4, 3.0):
        factor = restitution_factor(speed, e, g, 0.16)
        kernel = kernel_factor(speed, e, g, 0.16)
        assert kernel == pytest.approx(factor, rel=1e-11, abs=1e-300), speed
        power = (speed**2) ** g - 0.16**g * (1 - e ** (2 * g))
        remaining = (factor * speed) ** (2 * g)
        assert remaining == pytest.approx(max(power, 0.0), rel=1e-9, abs=1e-14), speed
    assert restitution_factor(0.4, e, g, 0.16) == pytest.approx(e, rel=1e-13)


SPRING = TrilinearCurve(0.5, 0.45)  # linear within its first branch


FRICTION = {"loss_exponent": 0.5, "reference_amplitude": 0.3}
# The package refuses the limit of the damper, an exponent of 1/2.
ALMOST_FRICTION = FRICTION | {"loss_exponent": 0.5 - 1e-9}


@pytest.mark.parametrize(
    ("damping", "tolerance"),
    [
        (Damping("CR", 0.8, **FRICTION), 1e-10),
        (Damping.from_restitution(0.8, "ECD", order=4, **ALMOST_FRICTION), 1e-7),
    ],
    ids=["restitution", "damper"],
)
def test_exponent_of_one_half_is_friction(damping, tolerance):
    """On a linear spring each half cycle loses the same length."""
    lengths = np.diff([0.45, *turns(SPRING, damping, 0.45, 5)])
    np.testing.assert_allclose(lengths, -0.3 * (1 - 0.8), rtol=tolerance)


def test_stated_e_at_other_amplitudes():
    double_reference = 2 * float(PAPER.energy(0.3))
    factors = []
    for x in (0.05, 0.1, 0.2, 0.5):
        speed = math.sqrt(2 * float(PAPER.energy(x)))
        factors.append(restitution_factor(speed, 0.85, 0.26, double_reference))
    words = r"\$e\$ is ([\d.]+), ([\d.]+), ([\d.]+) and ([\d.]+) from releases at"
    assert_stated(THEORY, words, *factors)


# --- the damper ----------------------------------------------------------------------------------

REGULAR = [
    (g, order, multiple)
    for g, *multiples in stated_rows(THEORY, "g | order 0")
    for order, multiple in zip((0, 4, 16), multiples, strict=True)
]


@pytest.mark.parametrize(("g", "order", "multiple"), REGULAR)
def test_table_of_regular_half_cycles(g, order, multiple):
    """The least (E_0/K)^g at which kappa cos^(2m+1) sin stays below 1 along the phase."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 20001)
    cosine = np.cos(angle)
    loss = cosine ** (2 * order + 2)
    lost_share = np.cumsum(loss) / np.sum(loss)
    scale = float(normalisation(order)) / (np.pi * g)  # times K over E^g
    steepness = scale * cosine ** (2 * order + 1) * np.sin(angle)

    def excess(start):
        return np.max(steepness / (start - lost_share)) - 1

    assert brentq(excess, 1.0001, 10) == pytest.approx(multiple, abs=0.006)


SIZES = np.array([1.0, 0.1, 1e-3])


@every_order
@pytest.mark.parametrize("g", [0.13, 0.26, 0.45])
def test_damping_force_falls_with_the_energy(g, order):
    """At one phase on the first branch, a factor on x and v multiplies E by its square."""
    damping = Damping.from_restitution(0.85, "ECD", order=order, loss_exponent=g)
    x, v = -0.02 * SIZES, 0.1 * SIZES
    forces = damping_coefficient(PAPER, damping, x, v) * v
    assert np.all(np.diff(forces) < 0)
    assert np.all(forces > 0)
    crossing = damping_coefficient(PAPER, damping, 0.0, v) * v  # without a denominator
    np.testing.assert_allclose(crossing / crossing[0], SIZES ** (1 - 2 * g), rtol=1e-9)


@every_order
def test_coefficient_is_finite_and_meets_the_cap(order):
    damping = Damping.from_restitution(0.85, "ECD", order=order, loss_exponent=0.26)
    size = np.geomspace(1e-12, 1.0, 25)[:, None, None]
    x = size * np.linspace(-0.04, 0.04, 10)[:, None]
    v = size * np.linspace(-0.2, 0.2, 10)
    coefficient = damping_coefficient(PAPER, damping, x, v)
    assert np.isfinite(coefficient).all()
    assert (coefficient >= 0).all()
    double_t, double_v = v**2, 2 * PAPER.energy(np.abs(x))
    total = double_t + double_v
    kappa = 2 * float(damping.value) * float(normalisation(order))
    kappa = kappa * (2 * float(PAPER.energy(0.3)) / total) ** 0.26
    largest = float(PAPER.initial_frequency) * kappa * (double_t / total) ** order / 0.05
    assert (coefficient <= largest * (1 + 1e-9)).all()
    assert np.isclose(coefficient, largest).any()


@every_order
def test_coefficient_at_rest_is_finite(order):
    damping = Damping.from_restitution(0.85, "ECD", order=order, loss_exponent=0.26)
    at_rest = damping_coefficient(PAPER, damping, [0.0, 0.0, 1e-3], [0.0, 1e-9, 0.0])
    assert np.isfinite(at_rest).all()


# --- SDR on a nearly rigid block -----------------------------------------------------------------


def local_exponent(a1, amplitudes):
    """Return g of SDR between two amplitudes, by the loss of a half cycle."""
    curve = TrilinearCurve(a1, 1 - 2 * a1)
    factors = equivalence_factor(curve, Damping("SDR", 1.0), np.array(amplitudes))
    loss = -np.log(factors)
    return float(-np.diff(loss)[0] / np.diff(np.log(curve.energy(amplitudes)))[0])


def test_exponent_of_sdr_is_0_2_to_0_3():
    small, large = local_exponent(0.005, [0.05, 0.1]), local_exponent(0.005, [0.2, 0.5])
    assert 0.2 < small < large < 0.3


def test_exponent_of_sdr_slowly_tends_to_one_half():
    """Each power of ten in a1 brings it nearer, by at most 70 % of the rest."""
    exponents = np.array([local_exponent(a1, [0.05, 0.1]) for a1 in (0.05, 5e-3, 5e-4, 5e-5)])
    distance = 0.5 - exponents
    assert np.all(np.diff(exponents) > 0)
    assert exponents[-1] < 0.5
    assert np.all(np.diff(distance) / distance[:-1] > -0.7)
