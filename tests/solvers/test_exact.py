"""The exact solver: its pieces, its events, and SciPy's Radau."""

import ast
import inspect
import math
from pathlib import Path

import mpmath
import numpy as np
import pytest
from exact_cases import CURVES, DAMPERS, cr_peaks, smooth_load
from scipy.integrate import solve_ivp

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers import exact
from rockdamp.solvers.coefficient import damping_coefficient
from rockdamp.solvers.exact import exact_history
from rockdamp.solvers.newmark import Load, simulate

CURVE = CURVES[0]
every_damper = pytest.mark.parametrize("damper", DAMPERS.values(), ids=DAMPERS)

# --- free decays ----------------------------------------------------------------------------------


@pytest.mark.parametrize("restitution", [0.7, 1.0])
@pytest.mark.parametrize("curve", CURVES)
def test_cr_decay_follows_energies_and_periods(curve, restitution):
    for share in (0.02, 0.3, 0.97):
        x0 = share * float(curve.ultimate_displacement_ratio)
        history = exact_history(curve, Damping("CR", restitution), [60.0], release_amplitude=x0)
        peaks = cr_peaks(curve, restitution, x0, history.turning_tau.size)
        signs = -((-1.0) ** np.arange(peaks.size))
        assert history.turning_displacement == pytest.approx(peaks * signs, rel=1e-12), share
        quarters = curve.period(np.concatenate([[x0], peaks])) / 4
        impacts = np.cumsum(np.concatenate([[quarters[0]], 2 * quarters[1:]]))
        # At y = a3 - x0 = 0.03 an error of 1e-15 in energy is one of 1e-15/y^2 = 1e-12 in time,
        # and it adds up.
        assert history.impacts == pytest.approx(impacts[: history.impacts.size], abs=1e-10), share
        assert history.turning_tau == pytest.approx(impacts[: peaks.size] + quarters[1:], abs=1e-10)
        if restitution < 1.0:
            assert history.peak == x0
            assert history.peak_tau == 0.0


@pytest.mark.parametrize(
    "amplitude", [0.04 * (1 - 1e-12), 0.04, 0.04 * (1 + 1e-12), 0.15, 0.15 + 1e-12]
)
@pytest.mark.parametrize("damper", [Damping("CR", 1.0), Damping("CDR", 0.0), Damping("ECD", 0.0)])
def test_motion_that_just_touches_a_corner_keeps_its_period(amplitude, damper):
    history = exact_history(CURVE, damper, [30.0], release_amplitude=amplitude)
    assert np.abs(history.turning_displacement) == pytest.approx(amplitude, abs=1e-13)
    half_period = float(CURVE.period(amplitude)) / 2
    assert np.diff(history.impacts) == pytest.approx(half_period, abs=1e-9)


def test_velocity_at_an_impact_is_that_after_it():
    damping = Damping("CR", 0.8)
    impacts = exact_history(CURVE, damping, [9.0], release_amplitude=0.5).impacts
    history = exact_history(CURVE, damping, [impacts[0], 9.0], release_amplitude=0.5)
    expected = -0.8 * np.sqrt(2 * CURVE.energy(0.5))
    assert history.velocity[0] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(("factor", "collapsed"), [(1 - 1e-9, False), (1 + 1e-9, True)])
def test_energy_decides_between_collapse_and_return(factor, collapsed):
    curve = CURVES[1]
    missing = curve.energy(curve.ultimate_displacement_ratio) - curve.energy(0.5)
    v0 = factor * float(np.sqrt(2 * missing))
    history = exact_history(
        curve, Damping("CR", 1.0), [40.0], release_amplitude=0.5, release_velocity=v0
    )
    assert history.collapsed == collapsed


# --- pieces ---------------------------------------------------------------------------------------

# Damping and stiffness of all kinds.
PIECES = [(c, k) for c in (0.0, 1e-9, 0.7, 8.0, 30.0) for k in (16.0, 0.0, -1.0)]
every_piece = pytest.mark.parametrize(("c", "k"), PIECES)


@every_piece
def test_branch_solution_holds_every_digit(c, k):
    x, v, q, slope = 0.3, -0.7, 0.45, 1.9
    for t in (1e-6, 0.01, 0.3, 1.7):
        with mpmath.workdps(40):
            rates = mpmath.matrix([[0, 1, 0, 0], [-k, -c, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]])
            end = mpmath.expm(rates * t) * mpmath.matrix([x, v, q, slope])
            expected = [float(end[0]), float(end[1])]
        # Rounding of the terms, which are up to |x''(0)| = 21, and their growth where k < 0.
        rounding = 21 * np.finfo(float).eps * math.exp(math.sqrt(max(-k, 0)) * t)
        state = exact.closed_state(x, v, c, k, q, slope, t)
        assert state == pytest.approx(expected, rel=2e-14, abs=rounding), t


def make_branch(c, k):
    """Return a branch of one stiffness without an end, with a constant coefficient."""
    return exact.Branch(-np.inf, np.inf, k, 0.0, c, 0.0, 0.0, 0.0, 0.0, 0.0)


@every_piece
def test_piece_ends_where_the_velocity_first_changes_sign(c, k):
    turn_count = 0
    for x, v, q, slope in np.random.default_rng(1).normal(size=(60, 4)):
        start = (x, v, q, slope)
        stop, turns, *_ = exact.piece(make_branch(c, k), None, start, 5.0, 0.0, np.inf, None)
        times = np.linspace(0, stop, 501)
        velocity = np.array([exact.closed_state(x, v, c, k, q, slope, t)[1] for t in times])
        assert (velocity[1:-1] * v > 0).all()
        if turns:
            turn_count += 1
            later = exact.closed_state(x, v, c, k, q, slope, stop * (1 + 1e-6))
            assert abs(velocity[-1]) < 1e-11
            assert later[1] * v < 0
        else:
            assert stop == 5.0
    assert turn_count > 10


@pytest.mark.parametrize(("c", "k"), [(c, k) for c, k in PIECES if k])
def test_acceleration_is_zero_at_equal_times(c, k):
    slope = 0.7
    for x, v, q in np.random.default_rng(2).normal(size=(10, 3)):

        def acceleration(t, x=x, v=v, q=q):
            x_t, v_t = exact.closed_state(x, v, c, k, q, slope, t)
            return q + slope * t - c * v_t - k * x_t

        first, spacing = exact.acceleration_zeros(x, v, c, k, q, slope)
        earlier_times = np.linspace(1e-6, 0.999 * min(first, 6.0), 200)
        earlier = np.array([acceleration(t) for t in earlier_times])
        rounding = 1e-12 * np.abs(earlier).max()
        assert (earlier > -rounding).all() or (earlier < rounding).all()
        for count in range(3):
            zero = first + count * spacing if count else first
            if np.isfinite(zero):
                assert acceleration(zero) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("start_velocity", [0.0, 0.004, 0.006, 0.007, -0.004])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_integrator_turns_where_the_closed_form_does(start_velocity, way):
    """A load that grows from pushing against a slow wall to pushing it on.

    A single step has no turn, one, or two.
    """
    c = 0.05
    h = 0.09
    start = (0.1, way * start_velocity, way * -0.35, way * 10.0)
    law = exact.Law(exact.SECANT, (c, 1.0, 0.0, 0.0))
    branch = make_branch(-1.0, 0.0)
    rates = np.zeros((2, 13))
    end = exact.advance(branch, law, start, h, rates)
    rates[:, 12] = end[1], exact.acceleration(branch, law, start[2] + start[3] * h, *end)
    time, turns = exact.turn(branch, law, start, h, end, rates)
    closed_branch = make_branch(c, 0.0)
    closed_time, closed_turns, *_ = exact.piece(closed_branch, law, start, h, 0.0, np.inf, rates)
    assert turns == closed_turns == (start_velocity < 0.0061)
    assert time == pytest.approx(closed_time, abs=1e-12)


def branches(curve, damper):
    law, constants = exact.LAWS[damper.model](curve, damper)
    return law, [exact.Branch(*row) for row in exact.curve_branches(curve, law, constants)]


@every_damper
def test_branches_have_the_coefficients_of_the_damper(damper):
    for curve in CURVES:
        law, parts = branches(curve, damper)
        for branch in parts:
            for x in np.linspace(branch.low, branch.high, 9)[1:-1]:
                v = 0.3 * (x - 0.2)
                expected = float(damping_coefficient(curve, damper, x, v))
                coefficient = exact.coefficient(branch, law, x, v)
                assert coefficient == pytest.approx(expected, rel=1e-12), (curve, x)


@every_damper
def test_branches_have_the_force_of_the_curve(damper):
    for curve in CURVES:
        for branch in branches(curve, damper)[1]:
            x = np.linspace(branch.low, branch.high, 9)[1:-1]
            force = branch.stiffness * x + branch.offset
            np.testing.assert_allclose(
                force, curve.force(x), rtol=0, atol=1e-14, err_msg=str(curve)
            )


# --- under a load ---------------------------------------------------------------------------------


def integrate_by_radau(damper, e, x0, times, load, step):
    """Return displacements and impacts by an implicit integrator that knows no branches."""

    def rates(t, y):
        x, v = y
        c = float(damping_coefficient(CURVE, damper, x, v))
        p = np.interp(t, np.arange(load.size) * step, load)
        return v, p - float(CURVE.force(x)) - c * v

    def crossing(_, y):
        return y[0]

    crossing.terminal = True
    options = {"events": crossing, "dense_output": True, "rtol": 1e-8, "atol": 1e-10}
    t = 0.0
    state = [x0, 0.0]
    displacement = []
    impacts = []
    while t < times[-1]:
        part = solve_ivp(rates, (t, times[-1]), state, "Radau", **options)
        has_impact = part.status == 1
        in_part = times[(times >= t) & ((times < part.t[-1]) | (not has_impact))]
        if in_part.size:
            displacement += part.sol(in_part)[0].tolist()
        t = part.t[-1]
        if has_impact:
            impacts.append(t)
            v = part.y[1, -1]
            state = [math.copysign(1e-12, v), e * v]
            t += 1e-12
    return displacement, impacts


@pytest.mark.parametrize(("model", "e"), [("CR", 0.85), ("SDR", 1.0)])
def test_forced_history_agrees_with_radau(model, e):
    damper = DAMPERS[model]
    step = 0.25
    load = smooth_load(5, 21)
    times = np.arange(1, 200) * 0.025
    history = exact_history(CURVE, damper, times, release_amplitude=0.2, load=load, sampling=step)
    displacement, impacts = integrate_by_radau(damper, e, 0.2, times, load, step)
    assert len(impacts) > 3
    assert history.impacts == pytest.approx(impacts, abs=1e-6)
    # Radau holds 1e-8 of each step, and there are some hundreds.
    assert history.displacement == pytest.approx(displacement, abs=1e-6)


@every_damper
@pytest.mark.parametrize("curve", [CURVES[0], CURVES[3]], ids=["steeper", "translated"])
def test_collapse_ends_the_run_when_the_batched_solver_does(curve, damper):
    load = 1.5 * np.sin(np.arange(41) * 0.2)
    sampling = 0.2
    substeps = 100
    step = sampling / substeps
    times = np.arange(81) * 0.1
    history = exact_history(curve, damper, times, load=load, sampling=sampling)
    batch = simulate(curve, damper, load=Load(load, 1.0, sampling, substeps), store_every=4000)
    assert history.collapsed
    assert batch.collapsed
    # The batched solver names the end of the step beyond a3, and errs itself by a few h^2.
    assert -step < history.end_tau - batch.end_tau < 10 * step**2
    is_after = times > history.end_tau
    assert np.isnan(history.displacement[is_after]).all()
    assert np.isnan(history.velocity[is_after]).all()
    assert np.abs(history.displacement[~is_after]).max() <= history.peak
    assert history.peak == curve.ultimate_displacement_ratio
    assert history.peak_tau == history.end_tau


# E^g falls by E_r^g (1 - e^2g) at each impact: from E_r the second leaves 2 e^2g - 1 < 0, nothing.
@pytest.mark.parametrize(("e", "g", "last_impact"), [(0.0, 0.0, 0), (0.3, 0.45, 1)])
def test_wall_that_stops_at_an_impact_starts_again_under_load(e, g, last_impact):
    load = np.concatenate([np.zeros(17), 0.7 * np.sin(0.4 * np.arange(60))])
    times = np.arange(150) / 8
    damping = Damping("CR", e, loss_exponent=g, reference_amplitude=0.5)
    history = exact_history(CURVE, damping, times, release_amplitude=0.5, load=load, sampling=0.25)
    is_resting = (times > history.impacts[last_impact]) & (times < 4)  # until the load begins
    assert is_resting.sum() > 5
    assert not history.displacement[is_resting].any()
    assert not history.collapsed
    assert history.impacts.size > 3


def test_plateau_under_a_constant_load_is_a_parabola():
    times = np.linspace(0, 0.5, 11)
    start = {"release_amplitude": 0.1, "release_velocity": 0.1}
    curve = TrilinearCurve(0.04, 0.6)
    history = exact_history(
        curve, Damping("CR", 0.9), times, **start, load=[0.9, 0.9], sampling=1.0
    )
    assert history.displacement == pytest.approx(0.1 + 0.1 * times + 0.15 * times**2, abs=1e-14)


def test_load_is_linear_between_its_samples():
    times = np.linspace(0, 1, 26)
    damper = DAMPERS["CDR"]
    coarse = exact_history(CURVE, damper, times, load=[0.0, 0.4, -0.2], sampling=0.5)
    fine = exact_history(CURVE, damper, times, load=[0.0, 0.2, 0.4, 0.1, -0.2], sampling=0.25)
    assert coarse.displacement == pytest.approx(fine.displacement, abs=1e-13)


def test_load_is_zero_after_its_last_sample():
    times = np.linspace(0, 4, 101)
    damper = DAMPERS["CDR"]
    history = exact_history(CURVE, damper, times, load=[0.0, 0.4, -0.2], sampling=0.5)
    end = {"release_amplitude": history.displacement[25], "release_velocity": history.velocity[25]}
    decay = exact_history(CURVE, damper, times[25:] - times[25], **end)
    assert history.displacement[25:] == pytest.approx(decay.displacement, abs=1e-12)


@every_damper
def test_mirrored_motion_is_the_mirror_image(damper):
    load = smooth_load(3, 41)
    times = np.linspace(0, 4, 201)
    right = exact_history(CURVE, damper, times, release_amplitude=0.3, load=load, sampling=0.2)
    left = exact_history(CURVE, damper, times, release_amplitude=-0.3, load=-load, sampling=0.2)
    assert left.displacement == pytest.approx(-right.displacement, abs=1e-9)


@every_damper
def test_motion_does_not_depend_on_the_times(damper):
    options = {"release_amplitude": 0.3, "load": smooth_load(3, 41), "sampling": 0.2}
    many_times = exact_history(CURVE, damper, np.linspace(0, 4, 201), **options)
    few_times = exact_history(CURVE, damper, np.linspace(0, 4, 3), **options)
    np.testing.assert_array_equal(many_times.displacement[::100], few_times.displacement)
    np.testing.assert_array_equal(many_times.impacts, few_times.impacts)


@pytest.mark.parametrize("v0", [-0.4, 0.4])
def test_launch_from_zero_is_no_impact(v0):
    damping = Damping("CR", 0.6)
    history = exact_history(CURVE, damping, [0.0, 0.01, 1.0], release_velocity=v0)
    assert history.velocity[0] == v0
    assert history.displacement[1] == pytest.approx(0.01 * v0, rel=1e-2)
    start = exact_history(CURVE, damping, [0.0], release_velocity=v0)
    assert start.velocity[0] == v0


@pytest.mark.parametrize("push", [-0.4, 0.4])
def test_rest_is_kept_until_the_load_pushes(push):
    load = [0.0, 0.0, push]
    history = exact_history(CURVE, Damping("CR", 0.6), [0.0, 1.0, 2.2], load=load, sampling=1.0)
    assert not history.displacement[:2].any()
    assert history.displacement[2] * push > 0
    assert not history.impacts.size


@pytest.mark.parametrize(
    "damper", [Damping("CDC", 0.05), Damping("CDR", 0.05)], ids=["closed form", "steps"]
)
@pytest.mark.parametrize(("share", "turns"), [(0.9, 2), (1.1, 0)])
def test_two_turns_close_to_each_other_are_found(damper, share, turns):
    """The load slows the wall and pushes it on again within a sample; it just turns it or not."""
    curve = CURVES[1]
    sample = 0.09
    lowest, highest = -0.35, 0.55
    # On the plateau, where the restoring force is constant.
    slowest_time = sample * lowest / (lowest - highest)
    v0 = -share * lowest * slowest_time / 2
    load = float(curve.force(0.1)) + np.array([lowest, highest])
    times = np.linspace(0, sample, 2001)
    history = exact_history(
        curve,
        damper,
        times,
        release_amplitude=0.1,
        release_velocity=v0,
        load=load,
        sampling=sample,
    )
    assert history.turning_tau.size == turns
    sign_changes = np.flatnonzero(np.diff(np.sign(history.velocity)))
    np.testing.assert_allclose(
        history.turning_tau, history.times[sign_changes], atol=2 * sample / 2000
    )


def test_reference_amplitude_beyond_the_curve_is_refused():
    damping = Damping("ECD", 0.05, loss_exponent=0.2, reference_amplitude=1.0)
    with pytest.raises(ValueError, match="reference_amplitude"):
        exact_history(CURVE, damping, [1.0], release_amplitude=0.5)


# --- compiled code --------------------------------------------------------------------------------


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("start", "push"),
    [({"release_amplitude": 0.105, "release_velocity": -0.3}, 0), ({"release_amplitude": 0.7}, 10)],
    ids=["turns", "collapses"],
)
@every_damper
def test_compiled_code_does_what_its_source_says(monkeypatch, damper, start, push):
    arguments = (CURVES[4], damper, np.linspace(0, 1.2, 9))
    options = {**start, "load": smooth_load(4, 5) + push, "sampling": 0.3}
    compiled = exact_history(*arguments, **options)
    monkeypatch.setattr(exact, "integrate", inspect.unwrap(exact.integrate))
    plain = exact_history(*arguments, **options)
    assert plain.collapsed == compiled.collapsed == bool(push)
    if not push:
        assert plain.impacts.size == plain.turning_tau.size == 1
    for name in ("displacement", "velocity", "impacts", "turning_displacement", "end_tau"):
        np.testing.assert_allclose(
            getattr(compiled, name), getattr(plain, name), rtol=1e-12, atol=1e-14
        )


def test_source_has_no_power_with_a_whole_exponent():
    """Numba would share it with the batched solver, whose compiler options are looser.

    The bits of each solver would then depend on which of the two is compiled first.
    """
    tree = ast.parse(Path(exact.__file__).read_text(encoding="utf-8"))
    exponents = []
    for node in ast.walk(tree):
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
            exponents.append(getattr(node.right, "operand", node.right))  # without its sign
    assert exponents
    assert not any(type(getattr(exponent, "value", None)) is int for exponent in exponents)
