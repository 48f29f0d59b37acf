"""Section 9 of docs/theory.md: dampers that act in a band about the crossing."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from order_m_motion import Damper, branches, half_cycle
from pages import assert_stated, stated_rows
from scipy.integrate import quad, solve_ivp

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.dampers import band_strength, half_cycle_loss, normalisation
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.coefficient import damping_coefficient
from rockdamp.solvers.exact import exact_history
from rockdamp.solvers.newmark import simulate

PAPER = TrilinearCurve(0.04, 0.85)
W1 = float(PAPER.initial_frequency)
EXACT = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-15}


def free_peaks(curve, damping, x0, half_cycles):
    """Return the release and the next peaks, by the event-driven solver."""
    end = (half_cycles + 1) * float(curve.period(x0))
    run = exact_history(curve, damping, [end], release_amplitude=x0)
    return np.abs([x0, *run.turning_displacement[:half_cycles]])


def shares(curve, damping, delta, x0, half_cycles=1):
    """Return the loss of each half cycle over delta."""
    energy = curve.energy(free_peaks(curve, damping, x0, half_cycles))
    return np.log(energy[:-1] / energy[1:]) / (2 * delta)


# --- a band of fixed length ------------------------------------------------------------------------------------------


def crossing(curve, delta, w, kinetic):
    """Return E- and E+ of a crossing that enters at -w with this kinetic energy: dK/dx = -2 mu K - f."""
    a1 = float(curve.yield_displacement_ratio)
    ends = sorted({-w, 0.0, w, *(x for x in (-a1, a1) if abs(x) < w)})
    k = kinetic
    for low, high in zip(ends, ends[1:], strict=False):
        side = np.sign(low + high)

        def rate(x, k, side=side):
            return -1.5 * delta / w * (1 - (x / w) ** 2) * k - side * curve.force(abs(x))

        k = solve_ivp(rate, (low, high), [k], **EXACT).y[0, -1]
    return kinetic + float(curve.energy(w)), k + float(curve.energy(w))


def remainder(curve, delta, w):
    """Return A of E+ = e^2 E- + e A: 4 int_0^w V mu cosh(2 m) dx, m = int_0^x mu."""

    def integrand(r):
        return float(curve.energy(w * r)) * (1 - r * r) * np.cosh(1.5 * delta * (r - r**3 / 3))

    corner = min(float(curve.yield_displacement_ratio) / w, 1.0)
    return (
        3
        * delta
        * sum(quad(integrand, *ends, epsrel=1e-13)[0] for ends in ((0, corner), (corner, 1)))
    )


def test_energy_after_a_band_of_fixed_length():
    rng = np.random.default_rng(54)
    for _ in range(20):
        curve = TrilinearCurve(
            np.exp(rng.uniform(np.log(0.01), np.log(0.2))), rng.uniform(0.5, 0.75)
        )
        a1, e = float(curve.yield_displacement_ratio), rng.uniform(0.5, 0.95)
        w = a1 * rng.uniform(0.1, 2)
        before, after = crossing(
            curve, -np.log(e), w, 0.5 / e**2 * rng.uniform(1, 3) * float(curve.energy(3 * a1))
        )
        assert after > float(curve.energy(w))
        assert after == pytest.approx(
            e**2 * before + e * remainder(curve, -np.log(e), w), abs=1e-9 * before
        )


def test_law_of_fixed_length_fails_inside_the_band():
    w, delta, energy = 0.01, -np.log(0.85), PAPER.energy
    x0, x1 = free_peaks(PAPER, Damping.from_restitution(0.85, "CQD"), w, 1)
    away = energy(x1) - 0.85**2 * energy(x0) - 0.85 * remainder(PAPER, delta, w)
    assert x1 < w and away / energy(x0) == pytest.approx(-2e-4, rel=0.3)


def test_band_of_fixed_length_loses_less_of_small_motion():
    """A = (2/5) delta V(w) to first order, and peaks within the band keep ever more."""
    delta = -np.log(0.85)
    assert remainder(PAPER, delta, 0.01) == pytest.approx(
        0.4 * delta * float(PAPER.energy(0.01)), rel=delta**2
    )
    for x0, share in ((0.02, 0.941), (0.05, 0.990), (0.5, 0.9993)):
        assert shares(PAPER, Damping.from_restitution(0.85, "CQD"), delta, x0) == pytest.approx(
            share, abs=6e-4
        )
    for e in (0.85, 0.95):
        delta, damping = -np.log(e), Damping.from_restitution(e, "CQD")
        for r in (0.25, 0.5, 1.0):
            x0, x1 = free_peaks(PAPER, damping, 0.01 * r, 1)
            assert np.log(x0 / x1) == pytest.approx(delta * r * (1 - r * r / 5), abs=0.2 * delta**2)
    last = free_peaks(PAPER, Damping.from_restitution(0.85, "CQD"), 0.01, 200)[-1]
    assert last * (200 - 1 / np.log(0.85)) * -np.log(0.85) / 0.01 == pytest.approx(1, rel=0.01)


# --- a band of fixed time --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("width", [0.05, 0.1, 0.2, 0.4])
def test_loss_of_a_band_of_fixed_time(width):
    """By `quad` over the phase of the polar form, D = G(tan phi); and the short form of delta' is its inverse."""

    def rate(phi, strength):
        d = 0.75 * strength / width * (1 - (np.tan(phi) / width) ** 2)
        return d * np.cos(phi) ** 2 / (1 + d * np.sin(phi) * np.cos(phi))

    for e in (0.5, 0.7, 0.85, 0.98):
        delta = -np.log(e)
        strength, edge = band_strength(delta, width), np.arctan(width)
        assert quad(rate, -edge, edge, args=(strength,), epsrel=1e-13)[0] == pytest.approx(
            delta, rel=1e-12
        )
        short = delta * (1 + 0.4 * width**2 - 0.097 * width**4 - 0.043 * delta**2)
        assert strength == pytest.approx(short, rel=1e-3)
    uncorrected = {0.1: 0.9971471, 0.2: 0.9854858, 0.4: 0.9428526}
    if width in uncorrected:
        loss = half_cycle_loss(-np.log(0.85), width)
        assert loss / -np.log(0.85) == pytest.approx(uncorrected[width], abs=1e-7)


@pytest.mark.parametrize("a1", [0.04, 0.2])
@pytest.mark.parametrize("width", [0.1, 0.2, 0.4])
def test_band_of_fixed_time_is_exact_at_each_amplitude(a1, width):
    """While it ends on the first branch: up to c v = a1 where |x| = a1."""
    curve = TrilinearCurve(a1, 0.5 if a1 == 0.2 else 0.85)
    most = np.minimum(
        float(curve.initial_stiffness) * a1**2 / (2 * width**2) + curve.energy(a1),
        curve.energy(0.9),
    )
    damping = Damping.from_restitution(0.85, "BAND", width=width)
    for x0 in (0.001, 0.02, min(0.1, float(curve.amplitude(most))), float(curve.amplitude(most))):
        np.testing.assert_allclose(shares(curve, damping, -np.log(0.85), x0), 1, atol=1e-7)


@pytest.mark.parametrize("curve", [PAPER, TrilinearCurve(0.2, 0.5)], ids=["paper", "severe"])
def test_free_decays_under_the_default_band(curve):
    for x0 in (0.02, 0.1, 0.5, 0.8):
        share = shares(curve, Damping.from_restitution(0.85, "BAND"), -np.log(0.85), x0, 8)
        np.testing.assert_allclose(share, 1, atol=2e-4)


def test_band_of_fixed_time_beyond_the_first_branch():
    for width, share in ((0.1, 1.0001), (0.2, 1.0043), (0.4, 1.033)):
        found = shares(
            TrilinearCurve(0.005, 0.85),
            Damping.from_restitution(0.85, "BAND", width=width),
            -np.log(0.85),
            0.9,
        )
        assert found == pytest.approx(share, abs=6e-4)


def test_table_of_forces_at_the_crossing():
    """C v at the speed sqrt(v- v+) after a release from 0.5 on the paper's curve, over F0."""
    dampers = [("BAND", {"width": width}) for width in (0.4, 0.2, 0.1)]
    dampers += [*(("ECD", {"order": order}) for order in (16, 64)), ("CQD", {})]
    for e, *forces in stated_rows("docs/theory.md", "e | BAND 0.4"):
        speed = np.sqrt(2 * e * float(PAPER.energy(0.5)))
        found = [
            speed
            * float(
                damping_coefficient(PAPER, Damping.from_restitution(e, model, **named), 0.0, speed)
            )
            for model, named in dampers
        ]
        np.testing.assert_allclose(found[:-1], forces[:-1], atol=6e-3)
        assert found[-1] == pytest.approx(forces[-1], abs=0.06)


# --- a band of energy ------------------------------------------------------------------------------------------------


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


def share_of_loss(curve, damper, delta, x0):
    """Return the loss of a half cycle from rest at x0 over delta."""
    turn = half_cycle(curve, damper, x0, tolerance=1e-10)
    return 0.5 * math.log(curve.energy(x0) / curve.energy(turn.displacement)) / delta


RIGID = TrilinearCurve(1e-4, 0.9998)


@pytest.mark.parametrize("x0", [0.02, 0.1, 0.5, 0.75])
@pytest.mark.parametrize("width", [0.2, 0.4, 1.0])
@pytest.mark.parametrize(
    "curve",
    [PAPER, TrilinearCurve(0.005, 0.85), RIGID, TrilinearCurve(0.06, 0.72, 0.8, "translated")],
    ids=["paper", "stiff", "rigid", "translated"],
)
def test_band_of_energy_loses_delta_in_every_half_cycle(curve, width, x0):
    delta = -math.log(0.85)
    damper = EnergyBand(float(band_strength(delta, width)), width)
    assert share_of_loss(curve, damper, delta, x0) == pytest.approx(1, abs=2e-7)


def test_band_of_energy_is_band_on_the_first_branch():
    delta, width = -math.log(0.85), 0.3
    damper = EnergyBand(float(band_strength(delta, width)), width)
    band = Damping.from_restitution(0.85, "BAND", width=width)
    first = branches(PAPER)[0]
    for x, v in ((0.01, 0.2), (0.01, -0.5), (0.03, 0.6), (0.03, 0.4)):
        expected = float(damping_coefficient(PAPER, band, x, v))
        assert damper.coefficient(first, x, v) == pytest.approx(expected, rel=1e-12)


def test_band_of_fixed_time_fails_on_a_rigid_block():
    delta = -math.log(0.85)
    damper = TimeBand(delta, 0.1)
    shares_of_delta = [share_of_loss(RIGID, damper, delta, x0) for x0 in (0.5, 0.1, 0.01)]
    words = r"is ([\d.]+) from 0.5, ([\d.]+) from 0.1 and ([\d.]+) from 0.01. The price"
    assert_stated("docs/theory.md", words, *shares_of_delta)


# --- under load ------------------------------------------------------------------------------------------------------


def under_load(delta, load):
    """Return P = p c/sqrt(v- v+) and the error of ln v+ against an impact at x = 0, of BAND without a restoring force.

    In q = x/(c v), from -1 to 1; the unit of time is c.
    """
    strength = band_strength(delta, 1e-6)

    def rate(q, log_speed):
        g, push = 0.75 * strength * (1 - q * q), load / np.exp(log_speed)
        return (push - g) / (1 + q * g - q * push)

    end = np.exp(solve_ivp(rate, (-1, 1), [0.0], **EXACT).y[0, -1])
    before, after = np.sqrt(1 + 2 * load), np.sqrt(end**2 - 2 * load * end)
    return load / (before * np.exp(-delta / 2)), np.log(after / before) + delta


@pytest.mark.parametrize("e", [0.75, 0.85, 0.95])
def test_load_in_a_band_of_fixed_time(e):
    """By -(3/70) delta^2 P - (4/5) delta P^2."""
    delta = -np.log(e)
    (size, helped), (_, opposed) = under_load(delta, 0.003), under_load(delta, -0.003)
    none = under_load(delta, 0.0)[1]
    assert (helped - opposed) / (2 * size) == pytest.approx(-3 / 70 * delta**2, rel=0.01)
    assert (helped + opposed - 2 * none) / (2 * size**2) == pytest.approx(-0.8 * delta, rel=0.03)


def test_load_in_a_band_of_fixed_length():
    """By -(18/35) delta^2 p w/(v- v+): dK/dx = -2 mu K + p is linear."""
    delta, load = -np.log(0.85), 1e-3

    def mean_speed(p):
        def rate(x, k):
            return -1.5 * delta * (1 - x * x) * k + p

        k = solve_ivp(rate, (-1, 1), [0.5 - p], **EXACT).y[0, -1]
        return np.log(2 * (k - p)) / 2

    slope = (mean_speed(load) - mean_speed(-load)) / (2 * load / np.exp(-delta))
    assert slope == pytest.approx(-18 / 35 * delta**2, rel=0.01)


def pushed(delta, start, speed):
    """Follow v' = 1 - C v of a wall without restoring force, C of BAND with c = 1, from `start` for a time of 8."""
    size = 0.75 * band_strength(delta, 1e-6)

    def rates(_, state):
        x, v = state
        r = min(abs(x) / max(abs(v), 1e-90), 1.0)
        return v, 1 - size * (1 - r * r) * v

    return solve_ivp(
        rates, (0, 8), [start, speed], **(EXACT | {"rtol": 1e-10, "max_step": 0.01})
    ).y[:, -1]


@pytest.mark.parametrize("e", [0.85, 0.95])
def test_start_from_rest_and_turn_at_the_crossing(e):
    """(3/4) delta p c (1 - 0.4 delta) of velocity; and 1.6 delta p^2 c^2 of energy, to first order."""
    delta = -np.log(e)
    assert 8 - pushed(delta, 0.0, 0.0)[1] == pytest.approx(
        0.75 * delta * (1 - 0.4 * delta), rel=0.01
    )
    x, v = pushed(delta, 8.0, -4.0)  # turns at x = 0 where nothing damps
    assert (x - v * v / 2) / delta == pytest.approx({0.85: 1.18, 0.95: 1.45}[e], abs=0.05)


# --- order m beside the band -----------------------------------------------------------------------------------------


def test_large_order_is_a_gaussian_of_fixed_time():
    """C = w1 delta sqrt(m/pi) exp(-m t^2), t = w1 x/v: the deviation of the band with m = 5/(2 t_c^2)."""
    m, delta, t = 10000, 0.1, np.linspace(-0.02, 0.02, 9)
    c = damping_coefficient(PAPER, Damping("ECD", delta / np.pi, order=m), t / W1, 1.0)
    np.testing.assert_allclose(c, W1 * delta * np.sqrt(m / np.pi) * np.exp(-m * t * t), rtol=0.03)
    width = np.sqrt(5 / (2 * m))
    deviation = np.sqrt(
        quad(lambda t: t * t * 0.75 / width * (1 - (t / width) ** 2), -width, width)[0]
    )
    assert deviation == pytest.approx(1 / np.sqrt(2 * m))
    assert 0.75 / width / np.sqrt(m / np.pi) == pytest.approx(0.841, abs=5e-4)


class OfInitialStiffness(Damper):
    """Order m with V = k1 u^2/2 and f = k1 u at every u."""

    def coefficient(self, branch, z, v):
        share = v * v / max(v * v + (W1 * z) ** 2, 1e-300)
        q = self.amplitude * share**self.order
        return W1 * q / (1 - q * np.sqrt(share * (1 - share)) * (1 if v > 0 else -1))


@pytest.mark.parametrize(("order", "within"), [(16, 0.01), (64, 1e-4)])
def test_initial_stiffness_serves_at_high_orders(order, within):
    damper = OfInitialStiffness(2 * -np.log(0.85) / np.pi * float(normalisation(order)), order)
    x1 = half_cycle(PAPER, damper, 0.5).displacement
    share = np.log(float(PAPER.energy(0.5) / PAPER.energy(x1))) / (-2 * np.log(0.85))
    assert 1 < share < 1 + within


# --- the step --------------------------------------------------------------------------------------------------------


def march(form, delta, w, h, steps, x, v, force):
    """Take explicit Newmark's steps; C at the predicted velocity is *naive*, or the mean of mu |v| over the step."""

    def area(x):
        r = np.clip(x / w, -1, 1)
        return 0.75 * delta * (r - r**3 / 3)

    a = -force(x)
    for _ in range(steps):
        x, ahead, half = x + h * v + h * h / 2 * a, v + h * a, v + h / 2 * a
        if form == "naive":
            c = 0.75 * delta / w * np.maximum(1 - (x / w) ** 2, 0) * np.abs(ahead)
        else:
            c = np.abs(area(x + h * ahead / 2) - area(x - h * ahead / 2)) / h
        a = (-force(x) - c * half) / (1 + h * c / 2)
        v = half + h / 2 * a
    return x, v


@pytest.mark.parametrize(
    ("form", "n", "least", "most"),
    [("naive", 0.5, 0, 3.4), ("naive", 1, 0, 1.65), ("naive", 5, 0.96, 1.03)]
    + [("mean", 0.5, 0.95, 1.1), ("mean", 5, 1.0, 1.005)],
)
def test_fast_wall_between_two_steps(form, n, least, most):
    """Loss of one crossing over delta, n = 2 w/(v h), from 400 offsets of the steps, without a restoring force."""
    delta = -np.log(0.85)
    h = 2 / (n * np.sqrt(0.85))
    start = -1 - h * (1 + np.arange(400) / 400)
    v = march(form, delta, 1.0, h, round(2 * n) + 6, start, np.ones(400), lambda x: 0 * x)[1]
    lost = -np.log(v) / delta
    assert least - 1e-9 <= lost.min() and lost.max() <= most
    if form == "naive" and n <= 1:
        assert lost.min() == 0


def test_kernel_takes_the_mean_over_the_step():
    def force(x):
        return np.sign(x) * PAPER.force(abs(x))

    damping = Damping.from_restitution(0.85, "CQD")
    run = simulate(PAPER, damping, step=0.01, steps=400, release_amplitude=0.5, store_every=400)
    x, v = march("mean", -np.log(0.85), 0.01, 0.01, 400, 0.5, 0.0, force)
    assert run.displacement[-1] == pytest.approx(float(x), abs=1e-12)
    assert run.velocity[-1] == pytest.approx(float(v), abs=1e-11)


def test_bands_never_feed_energy():
    x, v = np.linspace(-0.9, 0.9, 91)[:, None], np.linspace(-2, 2, 81)
    for damping in (Damping.from_restitution(0.5, "BAND"), Damping.from_restitution(0.5, "CQD")):
        c = damping_coefficient(PAPER, damping, x, v)
        assert np.isfinite(c).all() and (c >= 0).all()
        peaks = free_peaks(PAPER, damping, 0.9, 12)
        assert (np.diff(peaks) < 0).all()
    size = 0.75 * band_strength(-np.log(0.5), 0.2) / (0.2 / W1)
    band = Damping.from_restitution(0.5, "BAND")
    assert damping_coefficient(PAPER, band, x, v).max() <= size * (1 + 1e-14)
    np.testing.assert_allclose(
        damping_coefficient(PAPER, band, [0.0, 0.01, 0.0], [0.0, 0.0, 1.0]),
        [size, 0, size],
        rtol=1e-14,
    )


@pytest.mark.parametrize("width", [0.05, 0.2])
@pytest.mark.parametrize("e", [0.3, 0.85])
def test_band_is_stable_at_two_steps_in_it(width, e):
    for a1 in (0.005, 0.04):
        curve = TrilinearCurve(a1, 0.85)
        c = width / float(curve.initial_frequency)
        amplitude = np.linspace(0.2, 0.9, 20) * a1
        run = simulate(
            curve,
            Damping.from_restitution(e, "BAND", width=width),
            step=c,
            steps=600,
            release_amplitude=amplitude,
        )
        assert (run.peak <= amplitude * (1 + 1e-9)).all()
