"""Both solvers on the same cases: closed forms, each other, independent integrations, and how a load is read."""

import mpmath as mp
import numpy as np
import pytest
from exact_cases import CURVES, DAMPERS, smooth_load
from scipy.integrate import solve_ivp

from rockdamp.constants import MODELS
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.solvers.exact import exact_history
from rockdamp.solvers.newmark import Load, simulate, stable_step

CURVE = CURVES[0]  # the wall of Fig. 5
W1, K1 = float(CURVE.initial_frequency), float(CURVE.initial_stiffness)


def solve(solver, curve, damping, step, steps, load=None, sampling=0.0, **start):
    """Displacement at each step."""
    if solver == "exact":
        times = step * np.arange(steps + 1)
        return exact_history(
            curve, damping, times, load=load, sampling=sampling, **start
        ).displacement
    run = (
        {"load": Load(load, 1.0, sampling, round(sampling / step))}
        if load is not None
        else {"step": step, "steps": steps}
    )
    return simulate(curve, damping, **run, **start).displacement


# --- closed forms -----------------------------------------------------------------------------------------------------

STEP, STEPS = 1e-3, 4000
TAU = STEP * np.arange(STEPS + 1)


def free(xi):
    """The linear oscillator from rest at 1."""
    root = np.sqrt(1 - xi**2)
    return np.exp(-xi * W1 * TAU) * (np.cos(W1 * root * TAU) + xi / root * np.sin(W1 * root * TAU))


PUSH, RAMP = (
    {"load": 0.01 * K1 * np.ones(2), "sampling": 4.0},
    {"load": np.array([0.0, 0.2]), "sampling": 4.0},
)
CLOSED = {  # on the curve's first branch, where these are the linear oscillator's damper
    f"{model} {xi}": (Damping(model, xi), {"release_amplitude": 0.03}, 0.03 * free(xi))
    for model in ("CDC", "CDR", "SDR", "ECD")
    for xi in (0.0, 0.02, 0.4)
} | {
    "push": (Damping("CDC", 0.0), PUSH, 0.01 * (1 - free(0.0))),  # to twice the static displacement
    "damped push": (Damping("CDC", 0.3), PUSH, 0.01 * (1 - free(0.3))),
    "ramp": (Damping("CDR", 0.0), RAMP, 0.05 * (TAU / W1**2 - np.sin(W1 * TAU) / W1**3)),
}


@pytest.mark.parametrize(("solver", "error"), [("newmark", 6e-5), ("exact", 1e-11)])
@pytest.mark.parametrize("case", CLOSED.values(), ids=CLOSED)
def test_on_the_first_branch_the_motion_is_the_linear_oscillator_s(case, solver, error):
    damping, run, expected = case
    # The scheme's period is off by the fraction (w1 step)^2/24: over 18 rad 1.6e-5; damping and load add as much.
    found = solve(solver, CURVE, damping, STEP, STEPS, **run)
    np.testing.assert_allclose(found, expected, atol=error * np.abs(expected).max())


@pytest.mark.parametrize("forced", [False, True], ids=["free", "forced"])
@pytest.mark.parametrize("damping", DAMPERS.values(), ids=DAMPERS)
def test_the_batched_solver_tends_to_the_exact_one_with_the_square_of_the_step(damping, forced):
    away, shares, sampling = [], np.linspace(0.08, 0.7, 6), 0.1
    load = smooth_load(2, 41, 0.12) if forced else np.zeros(41)
    for curve in (CURVES[0], CURVES[3]):
        release = shares * float(curve.ultimate_displacement_ratio)
        run = {"load": load, "sampling": sampling}
        exact = [
            solve("exact", curve, damping, sampling, 40, **run, release_amplitude=x0)
            for x0 in release
        ]
        for substeps in (20, 80):
            found = simulate(
                curve, damping, load=Load(load, 1.0, sampling, substeps), release_amplitude=release
            )
            away.append(np.sqrt(np.nanmean((found.displacement[:, ::substeps] - exact) ** 2)))
    # The corners of the curve scatter the fall by 16; steps of CR that hold an impact scatter it more.
    coarse, fine = np.sum(away[::2]), np.sum(away[1::2])
    assert fine < 1e-5 and coarse / fine > 5


def test_without_damping_the_period_is_the_curve_s_closed_form():
    step, release = 5e-4, np.array([0.015, 0.1, 0.3, 0.5, 0.75])
    for curve in CURVES:
        x = simulate(
            curve, Damping("CDR", 0.0), release_amplitude=release, step=step, steps=40000
        ).displacement
        for lane, period in zip(x, curve.period(release), strict=True):
            at = np.nonzero(lane[:-1] * lane[1:] < 0)[0]
            crossing = step * (at + lane[at] / (lane[at] - lane[at + 1]))
            # Energy is kept to about (w1 step)^2 = 1e-5, and far out the period changes by three times its fraction.
            assert 2 * np.diff(crossing).mean() == pytest.approx(period, rel=4e-5)


def test_impact_times_of_a_decay_are_those_rebuilt_with_thirty_digits(
    quarter_period, stored_energy
):
    # A decay of CR is known without integration: half periods of amplitudes that the energies give.
    with mp.workdps(30):
        e, x0 = mp.mpf("0.85"), mp.mpf("0.7")
        drawn = [
            [mp.mpf(value) for value in values.split()]
            for values in ("0 0.04 0.15 1", "0 0.85 0.85 0")
        ]
        tau, x, times = mp.mpf(0), x0, []
        for n in range(1, 8):
            tau += quarter_period(*drawn, x)
            times.append(float(tau))
            target = e ** (2 * n) * stored_energy(*drawn, x0)
            x = mp.findroot(
                lambda z, v=target: stored_energy(*drawn, z) - v,
                (mp.mpf("1e-9"), x),
                solver="anderson",
            )
            tau += quarter_period(*drawn, x)
    exact = exact_history(CURVE, Damping("CR", 0.85), [times[-1] + 0.1], release_amplitude=0.7)
    np.testing.assert_allclose(exact.impacts, times, rtol=1e-12)


def test_as_the_order_grows_the_response_under_a_load_tends_to_restitution():
    tau = np.arange(1601) * 0.005
    load = Load(np.where(tau < 1.5, 1.1 * np.sin(2 * np.pi * tau / 1.5), 0.0), 1.0, 0.005, 4)
    for curve in CURVES[:4]:
        dampings = [
            Damping("CR", 0.85),
            *(Damping.from_restitution(0.85, "ECD", order=m) for m in (8, 64, 512)),
        ]
        impact, *others = (
            simulate(curve, damping, load=load, store_every=4).displacement for damping in dampings
        )
        away = [np.sqrt(np.nanmean((x - impact) ** 2)) for x in others]
        assert away[0] > 2 * away[1] > 4 * away[2] > 0


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
        return v, -(c * v + np.copysign(force, u)) / mass - 1.5 * np.interp(t, elapsed, ground)

    accuracy = {"t_eval": elapsed, "rtol": 1e-9, "atol": 1e-12, "max_step": 0.03 / w1}
    return solve_ivp(rates, (0, elapsed[-1]), [release * u_ins, 0.0], "LSODA", **accuracy).y[0]


SPECIMEN = {
    "width": 1.438,
    "density": 1835.0,
    "hinge_ratio": 0.57,
    "overburden_ratio": 6.2,
    "eccentricity": 0.02,
}
WALLS = {
    "wall": Wall(0.102, 0.102 * 27, **SPECIMEN),
    "parapet": Parapet(0.25, 1.6, overburden_ratio=0.4, eccentricity=-0.05),
}


@pytest.mark.parametrize("release", [0.6, 0.0], ids=["free", "forced"])
@pytest.mark.parametrize(
    ("model", "exponent", "ratio"), [("CDC", 0, 0.03), ("CDR", 1, 0.05), ("SDR", 2, 0.15)]
)
@pytest.mark.parametrize("wall", WALLS.values(), ids=WALLS)
def test_a_dimensionless_run_is_the_si_run_of_the_same_wall(wall, model, exponent, ratio, release):
    law, elapsed = (0.05, 0.8), np.arange(161) / 64
    s = (np.pi * float(wall.frequency_parameter) / 20 * (elapsed - 1.0)) ** 2  # a Ricker wave
    ground = (
        (release == 0) * 0.9 * float(wall.rigid_strength / wall.mass) * (1 - 2 * s) * np.exp(-s)
    )
    expected = integrate_si(wall, law, ratio, exponent, release, elapsed, ground)
    load, damping = (
        Load(ground, wall.load_factor, wall.frequency_parameter / 64, 256),
        Damping(model, ratio),
    )
    response = simulate(
        TrilinearCurve(*law), damping, load=load, release_amplitude=release, store_every=256
    )
    assert 0.1 < response.peak < 1  # far from nothing and from collapse
    u_ins = wall.instability_displacement
    np.testing.assert_allclose(
        response.displacement * u_ins, expected, atol=2e-5 * u_ins
    )  # (w1 step)^2 is 1e-6


# --- load -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scheme", ["newmark", "paper"])
@pytest.mark.parametrize("model", MODELS)
def test_substeps_interpolate_the_record_and_one_of_zeros_is_a_free_decay_to_the_bit(model, scheme):
    damping, ground = (
        Damping(model, 0.85 if model == "CR" else 0.05),
        np.random.default_rng(11).normal(size=81),
    )
    start = {"release_amplitude": 0.2, "scheme": scheme}
    inside = simulate(CURVE, damping, load=Load(ground, 0.02, 0.05, 5), **start)
    resampled = np.interp(np.arange(401) / 5, np.arange(81), ground)
    outside = simulate(CURVE, damping, load=Load(resampled, 0.02, 0.01), **start)
    np.testing.assert_allclose(inside.displacement, outside.displacement, atol=1e-12)
    decay = simulate(CURVE, damping, step=0.01, steps=400, **start)
    still = simulate(CURVE, damping, load=Load(np.zeros(41), 0.5, 0.1, 10), **start)
    np.testing.assert_array_equal(
        [still.displacement, still.velocity], [decay.displacement, decay.velocity]
    )


@pytest.mark.parametrize("solver", ["newmark", "exact"])
def test_a_reference_amplitude_that_the_wall_does_not_reach_is_refused(solver):
    damping = Damping("CR", 0.8, loss_exponent=0.2, reference_amplitude=1.0)
    with pytest.raises(InputError, match="reference_amplitude"):
        solve(solver, CURVE, damping, 0.01, 2)


# --- stability --------------------------------------------------------------------------------------------------------


def test_just_below_the_stability_limit_a_linear_run_is_bounded_as_the_discrete_solution_says():
    # Explicit Newmark without damping: x_n = x0 cos(n theta), cos(theta) = 1 - (w1 step)^2/2, for w1 step < 2.
    step = 0.999 * float(stable_step(CURVE))
    response = simulate(CURVE, Damping("CDR", 0.0), release_amplitude=0.03, step=step, steps=1000)
    theta = np.arccos(1 - 2 * 0.999**2)
    np.testing.assert_allclose(
        response.displacement, 0.03 * np.cos(theta * np.arange(1001)), atol=1e-10
    )


def first_branch(order, e, step, steps):
    """Decays that never leave the first branch, from many amplitudes, so that crossings meet the step anywhere."""
    curve = TrilinearCurve(0.4, 0.5)
    w1, amplitude = float(curve.initial_frequency), np.linspace(0.2, 0.3, 40)
    damping = Damping.from_restitution(e, "ECD", order=order)
    return (
        amplitude,
        w1,
        simulate(curve, damping, step=step / w1, steps=steps, release_amplitude=amplitude),
    )


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
