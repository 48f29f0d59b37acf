"""The event-driven solver under a load, and beside the kernel: energy balances and other integrators."""

import math

import numpy as np
import pytest
from exact_cases import CURVES, DAMPERS, NAMES, smooth_load
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.event_driven import history
from rockdamp.solvers.newmark import solve

# --- forced ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("damper", DAMPERS[1:], ids=NAMES[1:])
def test_energy_is_balanced_by_the_work_of_the_load_and_the_damper(damper):
    curve, step = CURVES[3], 0.05
    load = smooth_load(7, 161, 0.06)
    residuals = []
    for refined in (32, 128):
        times = np.arange(160 * refined + 1) * step / refined
        run = history(curve, damper, times, release_amplitude=0.3, load=load, load_step=step)
        x, v = run.displacement, run.velocity
        assert np.ptp(x) > 0.4  # all branches are visited
        power = (np.interp(times, np.arange(161) * step, load) - damper.coefficient(curve, x, v) * v) * v
        work = np.concatenate([[0], np.cumsum(power[1:] + power[:-1])]) * step / refined / 2
        residuals.append(np.abs(np.diff(curve.energy(x) + v**2 / 2 - work)).sum())
    # Trapezoids of a continuous integrand: second order, so the balance closes in the limit. Corners of C scatter it.
    assert np.log(residuals[0] / residuals[1]) / np.log(4) == pytest.approx(2.0, abs=0.15)
    assert residuals[-1] < 1e-4 * float(curve.energy(0.8))


@pytest.mark.filterwarnings("ignore:restitution:rockdamp.errors.InputWarning")  # e of 0 on purpose
def test_with_e_of_0_the_wall_stops_at_the_impact_and_starts_again_when_the_load_pushes():
    curve, step = CURVES[0], 0.25
    stopped = Damping.cr(0.0)
    times = np.linspace(0.0, 8.0, 81)
    free = history(curve, stopped, times, release_amplitude=0.5)
    after = times > free.impacts[0]
    assert free.impacts.size == 1 and after.sum() > 10
    assert not free.displacement[after].any() and not free.velocity[after].any()
    decay = solve(curve, stopped, release_amplitude=0.5, step=0.0025, steps=3200, store_every=40)
    np.testing.assert_allclose(decay.displacement, free.displacement, atol=1e-5)
    load = np.concatenate([np.zeros(17), 0.7 * np.sin(0.4 * np.arange(60))])
    times = np.arange(0, 76, 0.5) * step
    run = history(curve, stopped, times, release_amplitude=0.5, load=load, load_step=step)
    before = (times > run.impacts[0]) & (times < 16 * step)  # it rests until the load begins
    assert before.sum() > 5 and not run.displacement[before].any()
    assert run.outcome == "completed" and run.impacts.size > 3
    steps = {"step": step / 512, "substeps": 512, "steps": 75 * 512, "store_every": 256}
    marched = solve(curve, stopped, release_amplitude=0.5, load_factor=1.0, ground_acceleration=load, **steps)
    np.testing.assert_allclose(
        marched.displacement[: times.size], run.displacement[: marched.displacement.size], atol=1e-4
    )


@pytest.mark.parametrize("damper", [DAMPERS[0], DAMPERS[3]], ids=["CR", "SDR"])
def test_forced_history_agrees_with_an_implicit_integrator_that_knows_no_branches(damper):
    curve, step = CURVES[0], 0.25
    load = smooth_load(5, 21)
    times = np.arange(1, 200) * 0.025
    run = history(curve, damper, times, release_amplitude=0.2, load=load, load_step=step)
    samples = np.arange(21) * step

    def rates(t, y):
        c = float(damper.coefficient(curve, y[0], y[1]))
        return y[1], np.interp(t, samples, load) - float(curve.force(y[0])) - c * y[1]

    def crossing(_, y):
        return y[0]

    crossing.terminal = True
    e = float(damper.restitution) if damper.step_kind == "impact" else 1.0
    t, y, expected, impacts = 0.0, [0.2, 0.0], [], []
    while t < times[-1]:
        part = solve_ivp(rates, (t, times[-1]), y, "Radau", events=crossing, dense_output=True, rtol=1e-8, atol=1e-10)
        t_end = part.t[-1]
        inside = times[(times >= t) & (times < t_end) | (times == times[-1]) & (t_end == times[-1])]
        expected += part.sol(inside)[0].tolist() if inside.size else []
        v = part.y[1, -1]
        if part.status == 1:
            impacts.append(t_end)
            t, y = t_end + 1e-12, [math.copysign(1e-12, v), e * v]
        else:
            t = t_end
    assert len(impacts) > 3
    assert run.impacts == pytest.approx(impacts, abs=1e-6)
    # Radau holds 1e-8 of each step, and there are some hundreds.
    assert run.displacement == pytest.approx(expected, abs=1e-6)


def test_constant_load_on_the_plateau_accelerates_uniformly():
    curve = TrilinearCurve(0.04, 0.6)
    times = np.linspace(0, 0.5, 11)
    run = history(
        curve,
        Damping.cr(0.9),
        times,
        release_amplitude=0.1,
        release_velocity=0.1,
        load=[0.9, 0.9],
        load_step=1.0,
    )
    assert run.displacement == pytest.approx(0.1 + 0.1 * times + 0.15 * times**2, abs=1e-14)
    assert run.velocity == pytest.approx(0.1 + 0.3 * times, abs=1e-14)


def test_load_is_linear_between_its_samples_and_zero_afterwards():
    curve, times = CURVES[0], np.linspace(0, 4, 101)
    coarse = history(curve, DAMPERS[2], times, load=[0.0, 0.4, -0.2], load_step=0.5)
    fine = history(curve, DAMPERS[2], times, load=[0.0, 0.2, 0.4, 0.1, -0.2, 0, 0, 0], load_step=0.25)
    before = times <= 1.0
    assert coarse.displacement[before] == pytest.approx(fine.displacement[before], abs=1e-13)
    state = {"release_amplitude": coarse.displacement[25], "release_velocity": coarse.velocity[25]}
    rest = history(curve, DAMPERS[2], times[25:] - times[25], **state)
    assert coarse.displacement[25:] == pytest.approx(rest.displacement, abs=1e-12)


@pytest.mark.parametrize("damper", DAMPERS, ids=NAMES)
def test_a_wall_at_rest_stays_at_rest_until_the_load_comes(damper):
    run = history(CURVES[0], damper, [0.0, 1.0, 2.0, 2.2], load=[0.0, 0.0, -0.5], load_step=1.0)
    assert not run.displacement[:2].any()
    assert run.displacement[2] < 0
    assert run.impacts.size == 0


@settings(deadline=None, max_examples=25)
@given(
    x0=st.floats(-0.95, 0.95),
    v0=st.floats(-0.5, 0.5),
    seed=st.integers(0, 1000),
    damper=st.sampled_from(DAMPERS[:3]),
    curve=st.sampled_from(CURVES),
)
def test_the_mirrored_motion_is_the_mirror_image(x0, v0, seed, damper, curve):
    load, x0 = smooth_load(seed, 11), x0 * float(curve.ultimate_displacement_ratio)
    right, left = (
        history(
            curve,
            damper,
            np.linspace(0, 4, 9),
            release_amplitude=sign * x0,
            release_velocity=sign * v0,
            load=sign * load,
            load_step=0.3,
        )
        for sign in (1, -1)
    )
    assert left.outcome == right.outcome
    assert left.outcome_tau == pytest.approx(right.outcome_tau, abs=1e-9)
    assert left.displacement == pytest.approx(-right.displacement, abs=1e-9, nan_ok=True)


@pytest.mark.parametrize("v0", [-0.4, 0.4])
def test_a_launch_from_rest_position_is_not_an_impact(v0):
    damper = Damping.cr(0.6)
    run = history(CURVES[0], damper, [0.0, 0.01, 10.0], release_velocity=v0)
    kernel = solve(CURVES[0], damper, step=0.01, steps=1000, release_velocity=v0)
    assert run.velocity[0] == v0
    assert run.displacement[1] == pytest.approx(0.01 * v0, rel=1e-2)
    assert kernel.impacts == run.impacts.size


def test_every_time_asked_for_up_to_the_end_has_a_value():
    for end in np.random.default_rng(2).uniform(0, 9, 100):
        run = history(
            CURVES[0], DAMPERS[0], [0.0, 0.3 * end, end, end], release_amplitude=0.3, load=[0.1, 0, 0], load_step=1.1
        )
        assert np.isfinite(run.displacement).all() and np.isfinite(run.velocity).all()
        assert run.outcome_tau == end


def test_the_history_does_not_depend_on_the_times_asked_for():
    load = smooth_load(3, 41)
    for damper in DAMPERS:
        many, few = (
            history(CURVES[0], damper, times, release_amplitude=0.3, load=load, load_step=0.2)
            for times in (np.linspace(0, 4, 201), np.linspace(0, 4, 3))
        )
        assert np.array_equal(many.displacement[::100], few.displacement)
        assert np.array_equal(many.impacts, few.impacts)
