"""The solver against closed forms, independent integrations in SI units, and its own rules for the load."""

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rockdamp.constants import MODELS, VISCOUS_MODELS
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.solvers.exact import exact_history
from rockdamp.solvers.newmark import Load, simulate, stable_step

CURVE = TrilinearCurve(0.04, 0.85)  # the wall of Fig. 5

# curves x amplitudes x restitutions, for statements that hold for any of them
A1 = np.array([0.02, 0.04, 0.06, 0.13, 0.20])[:, None, None]
B1 = np.array([0.80, 0.85, 0.72, 0.60, 0.50])[:, None, None]
CURVES = TrilinearCurve(A1, B1, np.array([1.0, 1.0, 0.9, 0.95, 1.0])[:, None, None])
RELEASES = np.array([0.015, 0.1, 0.3, 0.5, 0.8])[:, None]
RESTITUTIONS = np.array([0.70, 0.85, 0.95])


def matched_ratio(e):
    """xi of delta = pi xi/sqrt(1 - xi^2), delta = -ln e."""
    delta = -np.log(e)
    return delta / np.hypot(np.pi, delta)


def turning_energies(curve, response, count):
    """Energy V + v^2/2 where v changes sign: the stored energy at the first `count` peaks, per lane."""
    x, v = response.displacement, response.velocity
    energy = curve.map(lambda p: p[..., None]).energy(x) + v**2 / 2
    found = np.empty((*x.shape[:-1], count))
    for lane in np.ndindex(x.shape[:-1]):
        at = np.nonzero(v[lane][1:-1] * v[lane][2:] < 0)[0][:count] + 1
        found[lane] = energy[lane][at]
    return found


def crossings(x, step):
    """Times at which one history changes sign, linear between the steps."""
    at = np.nonzero(x[:-1] * x[1:] < 0)[0]
    return step * (at + x[at] / (x[at] - x[at + 1]))


# --- closed forms -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["CR", "ECD"])
def test_peaks_follow_the_energy_of_each_impact_for_cr_and_for_the_exact_ecd(model):
    # V(x_n) = e^(2n) V(x0), from any amplitude and for any curve, without a fit.
    damping = Damping("CR", RESTITUTIONS) if model == "CR" else Damping("ECD", matched_ratio(RESTITUTIONS))
    count = np.arange(1, 6)
    expected = RESTITUTIONS[:, None] ** (2 * count)
    worst, typical = [], []
    for step in (1e-3, 5e-4):
        response = simulate(CURVES, damping, release_amplitude=RELEASES, step=step, steps=round(20 / step))
        found = turning_energies(CURVES, response, count.size) / CURVES.energy(RELEASES)[..., None]
        worst.append(np.abs(found / expected - 1).max())
        typical.append(np.median(np.abs(found / expected - 1)))
    # A second-order scheme keeps energy to about (w1 step)^2 = 4e-5 at w1 = 6.3 (a1 = 0.02), and to a quarter of it at
    # half of the step: a third allows for the scatter of the corners.
    assert worst[0] < 4e-5
    assert typical[1] < typical[0] / 3


# On the curve's first branch these are the linear oscillator's damper.
LINEAR_INSIDE = ["CDC", "CDR", "SDR", "ECD"]


@pytest.mark.parametrize("model", LINEAR_INSIDE)
def test_inside_the_first_branch_every_damper_follows_the_linear_oscillator(model):
    xi, release, step = np.array([0.0, 0.02, 0.1, 0.4]), 0.03, 1e-3
    response = simulate(CURVE, Damping(model, xi), release_amplitude=release, step=step, steps=6000)
    w = CURVE.initial_frequency
    tau, root = step * np.arange(6001), np.sqrt(1 - xi**2)[:, None]
    phase = w * root * tau
    expected = release * np.exp(-xi[:, None] * w * tau) * (np.cos(phase) + xi[:, None] / root * np.sin(phase))
    # The scheme's period is off by the fraction (w step)^2/24: over 27.7 rad of phase 2.5e-5 of the release, and the
    # damping adds as much again.
    np.testing.assert_allclose(response.displacement, expected, atol=5e-5 * release)


@pytest.mark.parametrize("model", ["CR", *LINEAR_INSIDE])
def test_on_the_first_branch_one_impact_per_crossing_is_delta_pi_xi_over_the_root_of_1_minus_xi_squared(model):
    damping = Damping("CR", RESTITUTIONS) if model == "CR" else Damping(model, matched_ratio(RESTITUTIONS))
    response = simulate(CURVE, damping, release_amplitude=0.03, step=5e-4, steps=8000)
    energy = turning_energies(CURVE, response, 4)
    decrement = -np.diff(np.log(energy), axis=-1) / 2  # of the peaks: V goes with their square
    np.testing.assert_allclose(decrement, -np.log(RESTITUTIONS)[:, None] * np.ones(3), rtol=2e-5)


def test_without_damping_the_period_is_the_curve_s_closed_form():
    step, steps = 5e-4, 80000
    response = simulate(CURVES, Damping("CDR", 0.0), release_amplitude=RELEASES, step=step, steps=steps)
    for lane in np.ndindex(response.peak.shape):
        at = crossings(response.displacement[lane], step)
        measured = 2 * (at[-1] - at[0]) / (at.size - 1)
        expected = np.broadcast_to(CURVES.period(RELEASES), response.peak.shape)[lane]
        # Energy is kept to about (w1 step)^2 = 1e-5, and at 0.8 u_ins the period changes by three times its fraction.
        assert measured == pytest.approx(expected, rel=3e-5)


def test_impact_times_of_a_decay_are_those_rebuilt_with_thirty_digits(quarter_period, stored_energy):
    # A decay of CR is known without integration: half periods of amplitudes that the energies give.
    step, count = 2e-4, 7
    with mp.workdps(30):
        e, x0 = mp.mpf("0.85"), mp.mpf("0.7")
        drawn = [
            [mp.mpf(value) for value in values] for values in (("0", "0.04", "0.15", "1"), ("0", "0.85", "0.85", "0"))
        ]
        tau, x, times = mp.mpf(0), x0, []
        for n in range(1, count + 1):
            tau += quarter_period(*drawn, x)
            times.append(float(tau))
            target = e ** (2 * n) * stored_energy(*drawn, x0)
            x = mp.findroot(lambda z, v=target: stored_energy(*drawn, z) - v, (mp.mpf("1e-9"), x), solver="anderson")
            tau += quarter_period(*drawn, x)
    exact = exact_history(CURVE, Damping("CR", 0.85), [times[-1] + 0.1], release_amplitude=0.7)
    np.testing.assert_allclose(exact.impacts, times, rtol=1e-12)
    response = simulate(CURVE, Damping("CR", 0.85), release_amplitude=0.7, step=step, steps=60000)
    # The chord over a step with an impact in it misses the impact by at most (1 - sqrt(e))/(1 + sqrt(e)) = 0.04 steps.
    np.testing.assert_allclose(crossings(response.displacement, step)[:count], times, atol=0.05 * step)


@pytest.mark.parametrize("scheme", ["newmark", "paper"])
def test_a_step_of_constant_acceleration_settles_at_the_static_equilibrium_and_undamped_reaches_twice_it(scheme):
    static = 0.015
    ground = np.full(801, 2.0)
    response = simulate(
        CURVE,
        Damping("CDC", np.array([0.0, 0.3])),
        scheme=scheme,
        load=Load(ground, static * CURVE.initial_stiffness / 2.0, 0.01),
    )
    assert response.peak[0] == pytest.approx(2 * static, rel=1e-3)
    # exp(-0.3 w1 8) is 2e-5: what is left of the transient.
    assert response.displacement[1, -1] == pytest.approx(static, rel=1e-4)
    assert response.velocity[1, -1] == pytest.approx(0, abs=1e-4 * static)


def test_the_first_branch_under_a_ramp_follows_its_closed_form():
    w, rate, step = CURVE.initial_frequency, 0.05, 1e-3
    response = simulate(CURVE, Damping("CDR", 0.0), load=Load([0.0, rate * 4.0], 1.0, step * 4000, 4000))
    tau = step * np.arange(4001)
    expected = rate * (tau / w**2 - np.sin(w * tau) / w**3)
    np.testing.assert_allclose(response.displacement, expected, atol=5e-5 * rate * 4 / w**2)


# --- dimensions -------------------------------------------------------------------------------------------------------


def integrate_si(wall, law, damping_ratio, exponent, release, elapsed, ground):
    """m_eff u'' + C u' + F(u) = -lambda m_eff a_g in metres, newtons and seconds, Eq. (16), by LSODA."""
    strength, stiffness = float(wall.rigid_strength), float(wall.rigid_stiffness)
    u_ins, mass = strength / stiffness, float(wall.effective_mass)
    a1, b1 = law
    corner = np.array([0.0, a1 * u_ins, u_ins - b1 * strength / stiffness, u_ins])
    w1 = np.sqrt(b1 * strength / (a1 * u_ins) / mass)

    def rates(t, state):
        u, v = state
        force = np.interp(abs(u), corner, [0.0, b1 * strength, b1 * strength, 0.0])
        w = np.sqrt(force / abs(u) / mass) if abs(u) > 1e-9 * u_ins else w1
        c = 2 * mass * w1 * damping_ratio * (w / w1) ** exponent
        acceleration = np.interp(t, elapsed, ground) if ground is not None else 0.0
        return v, -(c * v + np.copysign(force, u)) / mass - 1.5 * acceleration

    step = 0.005 / w1 * 6
    return solve_ivp(
        rates, (0, elapsed[-1]), [release * u_ins, 0.0], "LSODA", elapsed, rtol=1e-9, atol=1e-12, max_step=step
    ).y[0]


@pytest.mark.parametrize("forced", [False, True], ids=["free", "forced"])
@pytest.mark.parametrize(("model", "exponent", "ratio"), [("CDC", 0, 0.03), ("CDR", 1, 0.05), ("SDR", 2, 0.15)])
@pytest.mark.parametrize(
    "wall",
    [
        Wall(0.102, 0.102 * 27, width=1.438, density=1835.0, hinge_ratio=0.57, overburden_ratio=6.2, eccentricity=0.02),
        Parapet(0.25, 1.6, overburden_ratio=0.4, eccentricity=-0.05),
    ],
    ids=["wall", "parapet"],
)
def test_a_dimensionless_run_is_the_si_run_of_the_same_wall(wall, model, exponent, ratio, forced):
    law, release = (0.05, 0.8), 0.0 if forced else 0.6
    elapsed = np.arange(161) / 64
    ground = None
    if forced:
        s = (np.pi * float(wall.frequency_parameter) / 20 * (elapsed - 1.0)) ** 2  # a Ricker wave
        ground = 0.9 * float(wall.rigid_strength / wall.mass) * (1 - 2 * s) * np.exp(-s)
    expected = integrate_si(wall, law, ratio, exponent, release, elapsed, ground)
    load = Load(np.zeros(161) if ground is None else ground, wall.load_factor, wall.frequency_parameter / 64, 256)
    damping = Damping(model, ratio)
    response = simulate(TrilinearCurve(*law), damping, load=load, release_amplitude=release, store_every=256)
    found = response.displacement * wall.instability_displacement
    assert 0.1 < response.peak < 1  # far from nothing and from collapse
    # (w1 step)^2 is at most 1e-6 here.
    np.testing.assert_allclose(found, expected, atol=2e-5 * wall.instability_displacement)


# --- load -------------------------------------------------------------------------------------------------------------

GROUND = np.random.default_rng(11).normal(size=81)


@pytest.mark.parametrize("scheme", ["newmark", "paper"])
@pytest.mark.parametrize("model", MODELS)
def test_substeps_are_linear_interpolation_of_the_record(model, scheme):
    damping = Damping(model, 0.85 if model == "CR" else 0.05)
    start = {"release_amplitude": 0.2, "scheme": scheme}
    inside = simulate(CURVE, damping, load=Load(GROUND, 0.02, 0.05, 5), **start)
    resampled = np.interp(np.arange(401) / 5, np.arange(81), GROUND)
    outside = simulate(CURVE, damping, load=Load(resampled, 0.02, 0.01), **start)
    np.testing.assert_allclose(inside.displacement, outside.displacement, atol=1e-12)


@pytest.mark.parametrize("model", MODELS)
def test_a_record_of_zeros_is_a_free_decay_bit_for_bit(model):
    damping = Damping(model, 0.85 if model == "CR" else 0.05)
    free = simulate(CURVE, damping, release_amplitude=0.4, step=0.01, steps=600)
    still = simulate(CURVE, damping, release_amplitude=0.4, load=Load(np.zeros(61), 0.5, 0.1, 10))
    np.testing.assert_array_equal(still.displacement, free.displacement)
    np.testing.assert_array_equal(still.velocity, free.velocity)


# --- energy -----------------------------------------------------------------------------------------------------------

SINE = 0.4 * np.sin(np.arange(31) * 0.2 * 1.7 + 0.4)  # every 0.2 in tau


def left_over(damping, substeps, forced):
    """Largest energy that is not accounted for, over the most that the wall was given."""
    step, steps = 0.2 / substeps, 30 * substeps
    load = np.interp(np.arange(steps + 1) / substeps, np.arange(31), SINE if forced else 0 * SINE)
    run = simulate(CURVE, damping, load=Load(SINE, float(forced), 0.2, substeps), release_amplitude=0.6 * (not forced))
    x, v = run.displacement, run.velocity
    energy, rate = v**2 / 2 + CURVE.energy(x), damping.coefficient(CURVE, x, v) * v**2
    lost = np.append(0, np.cumsum(step * (rate[1:] + rate[:-1]) / 2))
    work = np.append(0, np.cumsum((load[1:] + load[:-1]) / 2 * np.diff(x)))
    return np.abs(energy[0] + work - lost - energy).max() / (energy[0] + work).max()


@pytest.mark.parametrize("forced", [False, True], ids=["free", "forced"])
@pytest.mark.parametrize("model", VISCOUS_MODELS)
def test_a_damper_takes_what_leaves_the_wall_to_second_order(model, forced):
    """Eq. (14)."""
    coarse, fine = (left_over(Damping(model, 0.05), substeps, forced) for substeps in (10, 80))
    assert fine < 2e-4 and np.log(coarse / fine) / np.log(8) > 1.5
    assert left_over(Damping("CR", 1.0), 80, forced) < 2e-4


def test_as_the_order_grows_the_response_under_a_load_tends_to_restitution():
    tau = np.arange(1601) * 0.005
    load = Load(np.where(tau < 1.5, 1.1 * np.sin(2 * np.pi * tau / 1.5), 0.0), 1.0, 0.005, 4)
    for curve in (CURVE, TrilinearCurve(0.20, 0.50), TrilinearCurve(0.06, 0.72, 0.9)):
        dampings = [Damping("CR", 0.85), *(Damping.from_restitution(0.85, "ECD", order=m) for m in (8, 64, 512))]
        impact, *others = (simulate(curve, damping, load=load, store_every=4).displacement for damping in dampings)
        away = [np.sqrt(np.mean((x - impact) ** 2)) for x in others]
        assert away[0] > 2 * away[1] > 4 * away[2] > 0


# --- stability --------------------------------------------------------------------------------------------------------


def test_just_below_the_stability_limit_a_linear_run_is_bounded_as_the_discrete_solution_says():
    # Explicit Newmark without damping: x_n = x0 cos(n theta), cos(theta) = 1 - (w1 step)^2/2, for w1 step < 2.
    step = 0.999 * float(stable_step(CURVE))
    response = simulate(CURVE, Damping("CDR", 0.0), release_amplitude=0.03, step=step, steps=1000)
    theta = np.arccos(1 - 2 * 0.999**2)
    np.testing.assert_allclose(response.displacement, 0.03 * np.cos(theta * np.arange(1001)), atol=1e-10)


def first_branch(order, e, step, steps):
    """Decays that never leave the first branch, from many amplitudes, so that crossings meet the step anywhere."""
    curve = TrilinearCurve(0.4, 0.5)
    w1, amplitude = float(curve.initial_frequency), np.linspace(0.2, 0.3, 40)
    damping = Damping.from_restitution(e, "ECD", order=order)
    return amplitude, w1, simulate(curve, damping, step=step / w1, steps=steps, release_amplitude=amplitude)


@pytest.mark.parametrize("order", [0, 1, 16, 64])
@pytest.mark.parametrize("e", [0.5, 0.95])
def test_every_order_is_stable_up_to_the_limit_of_the_undamped_wall(order, e):
    for step in (0.3, 0.8, 1.2, 1.6, 1.98):  # w1 h
        amplitude, _, run = first_branch(order, e, step, 400)
        assert np.abs(run.displacement).max() < 0.4
        assert (np.abs(run.displacement[:, -60:]).max(axis=1) <= amplitude).all()


@pytest.mark.parametrize("e", [0.85, 0.95])
def test_the_step_that_an_order_needs(e):
    """The decrement of eight half cycles, by the energy at the eighth turning point, where the damper takes nothing."""
    worst = {}
    for order in (0, 1, 4, 16, 32):
        for step in (0.1, 0.05, 0.025):
            amplitude, w1, run = first_branch(order, e, step, int(8.9 * np.pi / step))
            away, size = np.abs(run.displacement), np.hypot(run.displacement, run.velocity / w1)
            for wall in range(amplitude.size):
                inner = away[wall, 1:-1]
                turns = 1 + np.flatnonzero((inner >= away[wall, :-2]) & (inner > away[wall, 2:]))
                lost = np.log(size[wall, turns[7]] / amplitude[wall]) / (8 * np.log(e))
                worst[order] = max(worst.get(order, 0.0), abs(lost - 1) / step**2)
    assert 0.25 < max(worst.values()) < 0.30 and worst[0] == pytest.approx(0.042, abs=0.003)
    assert worst[0] < worst[1] < worst[4] < worst[16]
