"""Section 9 of docs/theory.md: dampers that act in a band about the crossing."""

import math
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
import pytest
from order_m_motion import Damper, branches, half_cycle
from pages import assert_stated, stated_rows
from scipy.integrate import quad, solve_ivp

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.half_cycle_loss import band_strength, half_cycle_loss, normalisation
from rockdamp.solvers.coefficient import damping_coefficient
from rockdamp.solvers.exact import exact_history
from rockdamp.solvers.newmark import simulate

PAPER = TrilinearCurve(0.04, 0.85)
W1 = float(PAPER.initial_frequency)
DELTA = -math.log(0.85)
EXACT = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-15}


def free_peaks(curve, damping, x0, half_cycles):
    """Return the release and the next peaks, by the event-driven solver."""
    end = (half_cycles + 1) * float(curve.period(x0))
    history = exact_history(curve, damping, [end], release_amplitude=x0)
    return np.abs([x0, *history.turning_displacement[:half_cycles]])


def shares(curve, damping, delta, x0, half_cycles=1):
    """Return the loss of each half cycle over delta."""
    energy = curve.energy(free_peaks(curve, damping, x0, half_cycles))
    return np.log(energy[:-1] / energy[1:]) / (2 * delta)


# --- a band of fixed length ----------------------------------------------------------------------


def crossing(curve, delta, w, kinetic):
    """Return E- and E+ of a crossing that enters at -w: dK/dx = -2 mu K - f."""
    a1 = float(curve.yield_displacement_ratio)
    corners = [x for x in (-a1, a1) if abs(x) < w]
    k = kinetic
    for low, high in pairwise(sorted({-w, 0.0, w, *corners})):
        side = np.sign(low + high)

        def rate(x, k, side=side):
            return -1.5 * delta / w * (1 - (x / w) ** 2) * k - side * curve.force(abs(x))

        k = solve_ivp(rate, (low, high), [k], **EXACT).y[0, -1]
    stored = float(curve.energy(w))
    return kinetic + stored, k + stored


def remainder(curve, delta, w):
    """Return A of E+ = e^2 E- + e A: 4 int_0^w V mu cosh(2 m) dx, m = int_0^x mu."""

    def integrand(r):
        growth = np.cosh(1.5 * delta * (r - r**3 / 3))
        return float(curve.energy(w * r)) * (1 - r * r) * growth

    corner = min(float(curve.yield_displacement_ratio) / w, 1.0)
    parts = [quad(integrand, *ends, epsrel=1e-13)[0] for ends in ((0, corner), (corner, 1))]
    return 3 * delta * sum(parts)


def test_energy_after_a_band_of_fixed_length():
    rng = np.random.default_rng(54)
    for _ in range(20):
        a1 = np.exp(rng.uniform(np.log(0.01), np.log(0.2)))
        curve = TrilinearCurve(a1, rng.uniform(0.5, 0.75))
        e = rng.uniform(0.5, 0.95)
        w = a1 * rng.uniform(0.1, 2)
        kinetic = 0.5 / e**2 * rng.uniform(1, 3) * float(curve.energy(3 * a1))
        before, after = crossing(curve, -np.log(e), w, kinetic)
        assert after > float(curve.energy(w))
        expected = e**2 * before + e * remainder(curve, -np.log(e), w)
        assert after == pytest.approx(expected, abs=1e-9 * before)


FIXED_LENGTH = Damping.from_restitution(0.85, "CQD")


def test_law_of_fixed_length_fails_inside_the_band():
    w = 0.01
    x0, x1 = free_peaks(PAPER, FIXED_LENGTH, w, 1)
    start, end = PAPER.energy(x0), PAPER.energy(x1)
    residual = end - 0.85**2 * start - 0.85 * remainder(PAPER, DELTA, w)
    assert x1 < w
    assert residual / start == pytest.approx(-2e-4, rel=0.3)


def test_remainder_of_fixed_length_to_first_order():
    """A = (2/5) delta V(w)."""
    expected = 0.4 * DELTA * float(PAPER.energy(0.01))
    assert remainder(PAPER, DELTA, 0.01) == pytest.approx(expected, rel=DELTA**2)


@pytest.mark.parametrize(("x0", "share"), [(0.02, 0.941), (0.05, 0.990), (0.5, 0.9993)])
def test_fixed_length_loses_less_of_small_motion(x0, share):
    assert shares(PAPER, FIXED_LENGTH, DELTA, x0) == pytest.approx(share, abs=6e-4)


@pytest.mark.parametrize("e", [0.85, 0.95])
def test_share_of_a_peak_inside_the_fixed_length(e):
    delta, damping = -np.log(e), Damping.from_restitution(e, "CQD")
    for r in (0.25, 0.5, 1.0):
        x0, x1 = free_peaks(PAPER, damping, 0.01 * r, 1)
        expected = delta * r * (1 - r * r / 5)
        assert np.log(x0 / x1) == pytest.approx(expected, abs=0.2 * delta**2), r


def test_peaks_inside_the_fixed_length_fall_slowly():
    last = free_peaks(PAPER, FIXED_LENGTH, 0.01, 200)[-1]
    assert last * (200 + 1 / DELTA) * DELTA / 0.01 == pytest.approx(1, rel=0.01)


# --- a band of fixed time ------------------------------------------------------------------------


def test_short_form_of_the_strength():
    width = np.array([0.05, 0.1, 0.2, 0.4])[:, None]
    delta = -np.log([0.5, 0.7, 0.85, 0.98])
    short = delta * (1 + 0.4 * width**2 - 0.097 * width**4 - 0.043 * delta**2)
    np.testing.assert_allclose(band_strength(delta, width), short, rtol=1e-3)


@pytest.mark.parametrize(("width", "share"), [(0.1, 0.9971471), (0.2, 0.9854858), (0.4, 0.9428526)])
def test_loss_with_an_uncorrected_strength(width, share):
    assert half_cycle_loss(DELTA, width) / DELTA == pytest.approx(share, abs=1e-7)


@pytest.mark.parametrize(("a1", "b1"), [(0.04, 0.85), (0.2, 0.5)])
@pytest.mark.parametrize("width", [0.1, 0.2, 0.4])
def test_band_of_fixed_time_is_exact_at_each_amplitude(a1, b1, width):
    """While it ends on the first branch: up to c v = a1 where |x| = a1."""
    curve = TrilinearCurve(a1, b1)
    fastest = float(curve.initial_stiffness) * a1**2 / (2 * width**2)
    energy = np.minimum(fastest + curve.energy(a1), curve.energy(0.9))
    largest = float(curve.amplitude(energy))
    damping = Damping.from_restitution(0.85, "BAND", width=width)
    for x0 in (0.001, 0.02, min(0.1, largest), largest):
        share = shares(curve, damping, DELTA, x0)
        np.testing.assert_allclose(share, 1, atol=1e-7, err_msg=f"release {x0}")


@pytest.mark.parametrize("curve", [PAPER, TrilinearCurve(0.2, 0.5)], ids=["paper", "severe"])
@pytest.mark.parametrize("x0", [0.02, 0.1, 0.5, 0.8])
def test_free_decays_under_the_default_band(curve, x0):
    share = shares(curve, Damping.from_restitution(0.85, "BAND"), DELTA, x0, 8)
    np.testing.assert_allclose(share, 1, atol=2e-4)


@pytest.mark.parametrize(("width", "share"), [(0.1, 1.0001), (0.2, 1.0043), (0.4, 1.033)])
def test_band_of_fixed_time_beyond_the_first_branch(width, share):
    damping = Damping.from_restitution(0.85, "BAND", width=width)
    loss = shares(TrilinearCurve(0.005, 0.85), damping, DELTA, 0.9)
    assert loss == pytest.approx(share, abs=6e-4)


@pytest.mark.parametrize(
    ("e", "expected"),
    [(e, forces) for e, *forces in stated_rows("docs/theory.md", "e | BAND 0.4")],
)
def test_table_of_forces_at_the_crossing(e, expected):
    """C v at the speed sqrt(v- v+) after a release from 0.5 on the paper's curve, over F0."""
    dampers = [Damping.from_restitution(e, "BAND", width=width) for width in (0.4, 0.2, 0.1)]
    dampers += [Damping.from_restitution(e, "ECD", order=order) for order in (16, 64)]
    dampers.append(Damping.from_restitution(e, "CQD"))
    speed = np.sqrt(2 * e * float(PAPER.energy(0.5)))
    forces = [speed * float(damping_coefficient(PAPER, damper, 0.0, speed)) for damper in dampers]
    np.testing.assert_allclose(forces[:-1], expected[:-1], atol=6e-3)
    assert forces[-1] == pytest.approx(expected[-1], abs=0.06)


# --- a band of energy ----------------------------------------------------------------------------


@dataclass
class EnergyBand:
    """C = (3 delta'/(4 t_c)) w_E max(0, 1 - 2V/(t_c v)^2), w_E = abs(f)/sqrt(2V)."""

    strength: float
    width: float

    def coefficient(self, branch, z, v):
        if branch.low == 0:
            frequency = math.sqrt(branch.stiffness)
            root = frequency * z
        else:
            # A step that overshoots the branch is cut off, and must not meet a negative energy.
            root = math.sqrt(max(branch.double_energy(z), branch.stored))
            frequency = branch.force(z) / root
        edge = self.width * abs(v)
        if root >= edge:
            return 0.0
        return 0.75 * self.strength / self.width * frequency * (1 - (root / edge) ** 2)


@dataclass
class TimeBand:
    """C of BAND with a half width c in tau that no first branch gives."""

    strength: float
    half_width: float

    def coefficient(self, branch, z, v):
        edge = self.half_width * abs(v)
        if z >= edge:
            return 0.0
        return 0.75 * self.strength / self.half_width * (1 - (z / edge) ** 2)


def share_of_loss(curve, damper, x0):
    """Return the loss of a half cycle from rest at x0 over delta."""
    turn = half_cycle(curve, damper, x0, tolerance=1e-10)
    return 0.5 * math.log(curve.energy(x0) / curve.energy(turn.displacement)) / DELTA


RIGID = TrilinearCurve(1e-4, 0.9998)


@pytest.mark.parametrize("width", [0.2, 0.4, 1.0])
@pytest.mark.parametrize(
    "curve",
    [PAPER, TrilinearCurve(0.005, 0.85), RIGID, TrilinearCurve(0.06, 0.72, 0.8, "translated")],
    ids=["paper", "stiff", "rigid", "translated"],
)
def test_band_of_energy_loses_delta_in_every_half_cycle(curve, width):
    damper = EnergyBand(float(band_strength(DELTA, width)), width)
    for x0 in (0.02, 0.1, 0.5, 0.75):
        assert share_of_loss(curve, damper, x0) == pytest.approx(1, abs=2e-7), x0


def test_band_of_energy_is_band_on_the_first_branch():
    width = 0.3
    damper = EnergyBand(float(band_strength(DELTA, width)), width)
    band = Damping.from_restitution(0.85, "BAND", width=width)
    first = branches(PAPER)[0]
    for x, v in ((0.01, 0.2), (0.01, -0.5), (0.03, 0.6), (0.03, 0.4)):
        expected = float(damping_coefficient(PAPER, band, x, v))
        assert damper.coefficient(first, x, v) == pytest.approx(expected, rel=1e-12), (x, v)


def test_band_of_fixed_time_fails_on_a_rigid_block():
    damper = TimeBand(DELTA, 0.1)
    expected = [share_of_loss(RIGID, damper, x0) for x0 in (0.5, 0.1, 0.01)]
    words = r"is ([\d.]+) from 0.5, ([\d.]+) from 0.1 and ([\d.]+) from 0.01. The disadvantage"
    assert_stated("docs/theory.md", words, *expected)


# --- under load ----------------------------------------------------------------------------------


def under_load(delta, load):
    """Return P = p c/sqrt(v- v+) and the error of ln v+ against an impact at x = 0.

    BAND has no restoring force here. In q = x/(c v), from -1 to 1; the unit of time is c.
    """
    strength = band_strength(delta, 1e-6)

    def rate(q, log_speed):
        g = 0.75 * strength * (1 - q * q)
        push = load / np.exp(log_speed)
        return (push - g) / (1 + q * g - q * push)

    end = np.exp(solve_ivp(rate, (-1, 1), [0.0], **EXACT).y[0, -1])
    before = np.sqrt(1 + 2 * load)
    after = np.sqrt(end**2 - 2 * load * end)
    return load / (before * np.exp(-delta / 2)), np.log(after / before) + delta


@pytest.mark.parametrize("e", [0.75, 0.85, 0.95])
def test_load_in_a_band_of_fixed_time(e):
    """By -(3/70) delta^2 P - (4/5) delta P^2."""
    delta = -np.log(e)
    size, helped = under_load(delta, 0.003)
    _, opposed = under_load(delta, -0.003)
    _, unloaded = under_load(delta, 0.0)
    linear = (helped - opposed) / (2 * size)
    quadratic = (helped + opposed - 2 * unloaded) / (2 * size**2)
    assert linear == pytest.approx(-3 / 70 * delta**2, rel=0.01)
    assert quadratic == pytest.approx(-0.8 * delta, rel=0.03)


def test_load_in_a_band_of_fixed_length():
    """By -(18/35) delta^2 p w/(v- v+): dK/dx = -2 mu K + p is linear."""
    load = 1e-3

    def mean_speed(p):
        def rate(x, k):
            return -1.5 * DELTA * (1 - x * x) * k + p

        k = solve_ivp(rate, (-1, 1), [0.5 - p], **EXACT).y[0, -1]
        return np.log(2 * (k - p)) / 2

    slope = (mean_speed(load) - mean_speed(-load)) / (2 * load / np.exp(-DELTA))
    assert slope == pytest.approx(-18 / 35 * DELTA**2, rel=0.01)


def push_through_band(delta, start, speed):
    """Follow v' = 1 - C v without restoring force for a time of 8; C is BAND with c = 1."""
    size = 0.75 * band_strength(delta, 1e-6)

    def rates(_, state):
        x, v = state
        r = min(abs(x) / max(abs(v), 1e-90), 1.0)
        return v, 1 - size * (1 - r * r) * v

    accuracy = EXACT | {"rtol": 1e-10, "max_step": 0.01}
    return solve_ivp(rates, (0, 8), [start, speed], **accuracy).y[:, -1]


@pytest.mark.parametrize("e", [0.85, 0.95])
def test_start_from_rest_loses_velocity_once(e):
    """(3/4) delta p c (1 - 0.4 delta)."""
    delta = -np.log(e)
    velocity_loss = 8 - push_through_band(delta, 0.0, 0.0)[1]
    assert velocity_loss == pytest.approx(0.75 * delta * (1 - 0.4 * delta), rel=0.01)


@pytest.mark.parametrize(("e", "energy"), [(0.85, 1.18), (0.95, 1.45)])
def test_turn_at_the_crossing_loses_energy(e, energy):
    """1.6 delta p^2 c^2 to first order, where restitution has no impact."""
    delta = -np.log(e)
    x, v = push_through_band(delta, 8.0, -4.0)
    assert (x - v * v / 2) / delta == pytest.approx(energy, abs=0.05)


# --- order m beside the band ---------------------------------------------------------------------


def test_large_order_is_a_gaussian_of_fixed_time():
    """C = w1 delta sqrt(m/pi) exp(-m t^2), t = w1 x/v."""
    m, delta, t = 10000, 0.1, np.linspace(-0.02, 0.02, 9)
    c = damping_coefficient(PAPER, Damping("ECD", delta / np.pi, order=m), t / W1, 1.0)
    gaussian = W1 * delta * np.sqrt(m / np.pi) * np.exp(-m * t * t)
    np.testing.assert_allclose(c, gaussian, rtol=0.03)


def test_band_with_the_deviation_of_the_gaussian():
    """m = 5/(2 t_c^2), and 0.84 of its force."""
    m = 10000
    width = np.sqrt(5 / (2 * m))

    def weighted_square(t):
        return t * t * 0.75 / width * (1 - (t / width) ** 2)

    variance = quad(weighted_square, -width, width)[0]
    assert np.sqrt(variance) == pytest.approx(1 / np.sqrt(2 * m))
    assert 0.75 / width / np.sqrt(m / np.pi) == pytest.approx(0.841, abs=5e-4)


class InitialStiffness(Damper):
    """Order m with V = k1 u^2/2 and f = k1 u at every u."""

    def coefficient(self, branch, z, v):
        share = v * v / max(v * v + (W1 * z) ** 2, 1e-300)
        q = self.amplitude * share**self.order
        side = 1 if v > 0 else -1
        return W1 * q / (1 - q * np.sqrt(share * (1 - share)) * side)


@pytest.mark.parametrize(("order", "tolerance"), [(16, 0.01), (64, 1e-4)])
def test_initial_stiffness_serves_at_high_orders(order, tolerance):
    amplitude = 2 * DELTA / np.pi * float(normalisation(order))
    x1 = half_cycle(PAPER, InitialStiffness(amplitude, order), 0.5).displacement
    share = np.log(float(PAPER.energy(0.5) / PAPER.energy(x1))) / (2 * DELTA)
    assert 1 < share < 1 + tolerance


# --- the step ------------------------------------------------------------------------------------


def march(form, delta, w, h, steps, x, v, force):
    """Take explicit Newmark's steps.

    C at the predicted velocity is *naive*, or the mean of mu |v| over the step.
    """

    def area(x):
        r = np.clip(x / w, -1, 1)
        return 0.75 * delta * (r - r**3 / 3)

    a = -force(x)
    for _ in range(steps):
        x = x + h * v + h * h / 2 * a
        predicted = v + h * a
        half = v + h / 2 * a
        if form == "naive":
            c = 0.75 * delta / w * np.maximum(1 - (x / w) ** 2, 0) * np.abs(predicted)
        else:
            c = np.abs(area(x + h * predicted / 2) - area(x - h * predicted / 2)) / h
        a = (-force(x) - c * half) / (1 + h * c / 2)
        v = half + h / 2 * a
    return x, v


def losses_of_a_crossing(form, n):
    """Return the loss over delta from 400 offsets of the steps, n = 2 w/(v h) in the band."""
    h = 2 / (n * np.sqrt(0.85))
    start = -1 - h * (1 + np.arange(400) / 400)
    steps = round(2 * n) + 6
    _, v = march(form, DELTA, 1.0, h, steps, start, np.ones(400), np.zeros_like)
    return -np.log(v) / DELTA


@pytest.mark.parametrize(
    ("form", "n", "least", "most"),
    [("naive", 0.5, 0, 3.4), ("naive", 1, 0, 1.65), ("naive", 5, 0.96, 1.03)]
    + [("mean", 0.5, 0.95, 1.1), ("mean", 5, 1.0, 1.005)],
)
def test_loss_of_a_fast_wall(form, n, least, most):
    losses = losses_of_a_crossing(form, n)
    assert losses.min() >= least - 1e-9
    assert losses.max() <= most


@pytest.mark.parametrize("n", [0.5, 1])
def test_fast_wall_jumps_over_a_naive_band(n):
    assert losses_of_a_crossing("naive", n).min() == 0


def test_kernel_takes_the_mean_over_the_step():
    def force(x):
        return np.sign(x) * PAPER.force(abs(x))

    history = simulate(
        PAPER, FIXED_LENGTH, step=0.01, steps=400, release_amplitude=0.5, store_every=400
    )
    x, v = march("mean", DELTA, 0.01, 0.01, 400, 0.5, 0.0, force)
    assert history.displacement[-1] == pytest.approx(float(x), abs=1e-12)
    assert history.velocity[-1] == pytest.approx(float(v), abs=1e-11)


GRID_X, GRID_V = np.linspace(-0.9, 0.9, 91)[:, None], np.linspace(-2, 2, 81)


@pytest.mark.parametrize("model", ["BAND", "CQD"])
def test_bands_never_feed_energy(model):
    damping = Damping.from_restitution(0.5, model)
    c = damping_coefficient(PAPER, damping, GRID_X, GRID_V)
    assert np.isfinite(c).all()
    assert (c >= 0).all()
    assert (np.diff(free_peaks(PAPER, damping, 0.9, 12)) < 0).all()


def test_largest_coefficient_of_a_band_of_fixed_time():
    """3 delta'/(4c), at x = 0 and also at rest there."""
    band = Damping.from_restitution(0.5, "BAND")
    size = 0.75 * band_strength(-np.log(0.5), 0.2) / (0.2 / W1)
    assert damping_coefficient(PAPER, band, GRID_X, GRID_V).max() <= size * (1 + 1e-14)
    c = damping_coefficient(PAPER, band, [0.0, 0.01, 0.0], [0.0, 0.0, 1.0])
    np.testing.assert_allclose(c, [size, 0, size], rtol=1e-14)


def test_band_is_stable_at_two_steps_in_it():
    curve = TrilinearCurve(np.array([0.005, 0.04])[:, None], 0.85)
    amplitudes = np.linspace(0.2, 0.9, 20) * curve.yield_displacement_ratio
    for e, width in product((0.3, 0.85), (0.05, 0.2)):
        damping = Damping.from_restitution(e, "BAND", width=width)
        step = width / curve.initial_frequency
        history = simulate(curve, damping, step=step, steps=600, release_amplitude=amplitudes)
        assert (history.peak <= amplitudes * (1 + 1e-9)).all(), (e, width)
