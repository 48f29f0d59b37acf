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

every_damper = pytest.mark.parametrize("damper", DAMPERS.values(), ids=DAMPERS)

# --- free decays -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize("restitution", [0.7, 1.0])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.97])
def test_cr_peaks_and_their_times_follow_the_energy_of_each_impact(curve, restitution, share):
    x0 = share * float(curve.ultimate_displacement_ratio)
    run = exact_history(curve, Damping("CR", restitution), [60.0], release_amplitude=x0)
    peaks = cr_peaks(curve, restitution, x0, run.turning_tau.size)
    # At y = a3 - x0 = 0.03 an error of 1e-15 in energy is one of 1e-15/y^2 = 1e-12 in time, and it adds up.
    assert run.turning_displacement == pytest.approx(
        -peaks * (-1.0) ** np.arange(peaks.size), rel=1e-12
    )
    quarters = curve.period(np.concatenate([[x0], peaks])) / 4
    impacts = np.cumsum(np.concatenate([[quarters[0]], 2 * quarters[1:]]))
    assert run.impacts == pytest.approx(impacts[: run.impacts.size], abs=1e-10)
    assert run.turning_tau == pytest.approx(impacts[: peaks.size] + quarters[1:], abs=1e-10)
    assert (run.peak, run.peak_tau) == (x0, 0.0) or restitution == 1.0


@pytest.mark.parametrize(
    "amplitude", [0.04 * (1 - 1e-12), 0.04, 0.04 * (1 + 1e-12), 0.15, 0.15 + 1e-12]
)
@pytest.mark.parametrize("damper", [Damping("CR", 1.0), Damping("CDR", 0.0), Damping("ECD", 0.0)])
def test_motion_that_only_just_touches_a_corner_keeps_its_amplitude_and_period(amplitude, damper):
    curve = CURVES[0]
    run = exact_history(curve, damper, [30.0], release_amplitude=amplitude)
    assert np.abs(run.turning_displacement) == pytest.approx(amplitude, abs=1e-13)
    assert np.diff(run.impacts) == pytest.approx(float(curve.period(amplitude)) / 2, abs=1e-9)


def test_at_the_time_of_an_impact_the_velocity_is_that_after_it():
    curve, e, start = CURVES[0], 0.8, {"release_amplitude": 0.5}
    (first, *_) = exact_history(curve, Damping("CR", e), [9.0], **start).impacts
    run = exact_history(curve, Damping("CR", e), [first, 9.0], **start)
    assert run.velocity[0] == pytest.approx(-e * np.sqrt(2 * curve.energy(0.5)), rel=1e-12)


def test_energy_decides_between_collapse_and_return():
    curve = CURVES[1]
    needed = float(
        np.sqrt(2 * (curve.energy(curve.ultimate_displacement_ratio) - curve.energy(0.5)))
    )
    for factor, collapsed in ((1 - 1e-9, False), (1 + 1e-9, True)):
        start = {"release_amplitude": 0.5, "release_velocity": factor * needed}
        assert exact_history(curve, Damping("CR", 1.0), [40.0], **start).collapsed == collapsed


# --- pieces ----------------------------------------------------------------------------------------------------------

PIECES = [
    (c, k) for c in (0.0, 1e-9, 0.7, 8.0, 30.0) for k in (16.0, 0.0, -1.0)
]  # damping and stiffness, of all kinds


@pytest.mark.parametrize(("c", "k"), PIECES)
def test_branch_solution_holds_every_digit_for_any_stiffness_and_damping(c, k):
    x, v, q, slope = 0.3, -0.7, 0.45, 1.9
    times = [1e-6, 0.01, 0.3, 1.7]
    with mpmath.workdps(40):
        rates = mpmath.matrix(
            [[0, 1, 0, 0], [-mpmath.mpf(k), -mpmath.mpf(c), 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]]
        )
        start = mpmath.matrix([mpmath.mpf(n) for n in (x, v, q, slope)])
        expected = [
            [float(n) for n in (mpmath.expm(rates * mpmath.mpf(t)) * start)[:2]] for t in times
        ]
    for t, end in zip(times, expected, strict=True):
        # Rounding of the terms, which are up to |x''(0)| = 21, and their growth where k < 0.
        rounding = 21 * np.finfo(float).eps * math.exp(math.sqrt(max(-k, 0)) * t)
        assert exact.closed_state(x, v, c, k, q, slope, t) == pytest.approx(
            end, rel=2e-14, abs=rounding
        )


def piece_of(c, k):
    """A branch of one stiffness without an end, with a constant coefficient."""
    return exact.Branch(-np.inf, np.inf, k, 0.0, c, 0.0, 0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(("c", "k"), PIECES)
def test_a_piece_ends_where_the_velocity_first_changes_sign(c, k):
    turned, rng = 0, np.random.default_rng(1)
    for _ in range(60):
        x, v, q, slope = rng.normal(size=4)
        stop, turns, *_ = exact.piece(
            piece_of(c, k), None, (x, v, q, slope), 5.0, 0.0, np.inf, None
        )
        velocity = [
            exact.closed_state(x, v, c, k, q, slope, t)[1] for t in np.linspace(0, stop, 501)
        ]
        assert (np.array(velocity[1:-1]) * v > 0).all()
        if turns:
            assert abs(velocity[-1]) < 1e-11
            assert exact.closed_state(x, v, c, k, q, slope, stop * (1 + 1e-6))[1] * v < 0
        assert turns or stop == 5.0
        turned += turns
    assert turned > 10


@pytest.mark.parametrize(("c", "k"), [pair for pair in PIECES if pair[1]])
def test_the_acceleration_is_zero_first_where_it_is_said_and_then_at_equal_times(c, k):
    for x, v, q in np.random.default_rng(2).normal(size=(10, 3)):

        def acceleration(t, x=x, v=v, q=q):
            x_at, v_at = exact.closed_state(x, v, c, k, q, 0.7, t)
            return q + 0.7 * t - c * v_at - k * x_at

        first, spacing = exact.acceleration_zeros(x, v, c, k, q, 0.7)
        before = np.array(
            [acceleration(t) for t in np.linspace(1e-6, 0.999 * min(first, 6.0), 200)]
        )
        scale = np.abs(before).max()
        assert (before > -1e-12 * scale).all() or (before < 1e-12 * scale).all()
        zeros = [t for t in (first, first + spacing, first + 2 * spacing) if np.isfinite(t)]
        assert [acceleration(t) for t in zeros] == pytest.approx([0.0] * len(zeros), abs=1e-9)


@pytest.mark.parametrize("start_velocity", [0.0, 0.004, 0.006, 0.007, -0.004])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_step_of_the_integrator_turns_where_the_closed_form_does(start_velocity, way):
    """A load that grows from pushing against a slow wall to pushing it on: no turn, one, or two in a single step."""
    c, h = 0.05, 0.09
    start = (0.1, way * start_velocity, way * -0.35, way * 10.0)
    law, by_law, rates = (
        exact.Law(exact.SECANT, (c, 1.0, 0.0, 0.0)),
        piece_of(-1.0, 0.0),
        np.zeros((2, 13)),
    )
    end = exact.advance(by_law, law, start, h, rates)
    rates[:, 12] = end[1], exact.acceleration(by_law, law, start[2] + start[3] * h, *end)
    found, turns = exact.turn(by_law, law, start, h, end, rates)
    expected, turned, *_ = exact.piece(piece_of(c, 0.0), law, start, h, 0.0, np.inf, rates)
    assert [turns, turned] == 2 * [start_velocity < 0.0061]
    assert found == pytest.approx(expected, abs=1e-12)


@every_damper
def test_coefficients_on_the_branches_are_those_of_the_damper(damper):
    for curve in CURVES:
        law, constants = exact.LAWS[damper.model](curve, damper)
        for row in exact.curve_branches(curve, law, constants):
            branch = exact.Branch(*row)
            for x in np.linspace(branch.low, branch.high, 9)[1:-1]:
                v = 0.3 * (x - 0.2)
                expected = float(damping_coefficient(curve, damper, x, v))
                assert exact.coefficient(branch, law, x, v) == pytest.approx(expected, rel=1e-12)
                assert branch.stiffness * x + branch.offset == pytest.approx(
                    float(curve.force(x)), abs=1e-14
                )


# --- under a load ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["CR", "SDR"])
def test_forced_history_agrees_with_an_implicit_integrator_that_knows_no_branches(model):
    curve, damper, step = CURVES[0], DAMPERS[model], 0.25
    load, times = smooth_load(5, 21), np.arange(1, 200) * 0.025
    run = exact_history(curve, damper, times, release_amplitude=0.2, load=load, sampling=step)

    def rates(t, y):
        c = float(damping_coefficient(curve, damper, y[0], y[1]))
        return y[1], np.interp(t, np.arange(21) * step, load) - float(curve.force(y[0])) - c * y[1]

    def crossing(_, y):
        return y[0]

    crossing.terminal = True
    e = 0.85 if damper.model == "CR" else 1.0
    t, y, expected, impacts = 0.0, [0.2, 0.0], [], []
    while t < times[-1]:
        part = solve_ivp(
            rates,
            (t, times[-1]),
            y,
            "Radau",
            events=crossing,
            dense_output=True,
            rtol=1e-8,
            atol=1e-10,
        )
        inside = times[(times >= t) & ((times < part.t[-1]) | (part.status == 0))]
        expected += part.sol(inside)[0].tolist() if inside.size else []
        t, v = part.t[-1], part.y[1, -1]
        if part.status == 1:
            impacts.append(t)
            t, y = t + 1e-12, [math.copysign(1e-12, v), e * v]
    assert len(impacts) > 3
    assert run.impacts == pytest.approx(impacts, abs=1e-6)
    # Radau holds 1e-8 of each step, and there are some hundreds.
    assert run.displacement == pytest.approx(expected, abs=1e-6)


@every_damper
@pytest.mark.parametrize("curve", [CURVES[0], CURVES[3]], ids=["steeper", "translated"])
def test_collapse_ends_the_run_at_the_time_that_the_batched_solver_finds(curve, damper):
    load, sampling, substeps = 1.5 * np.sin(np.arange(41) * 0.2), 0.2, 100
    times, step = np.arange(81) * 0.1, sampling / substeps
    run = exact_history(curve, damper, times, load=load, sampling=sampling)
    kernel = simulate(curve, damper, load=Load(load, 1.0, sampling, substeps), store_every=4000)
    assert run.collapsed and kernel.collapsed
    # The other solver names the end of the step that goes beyond a3, and errs itself by a few h^2.
    assert -step < run.end_tau - kernel.end_tau < 10 * step**2
    gone = times > run.end_tau
    assert np.isnan(run.displacement[gone]).all() and np.isnan(run.velocity[gone]).all()
    assert np.abs(run.displacement[~gone]).max() <= run.peak == curve.ultimate_displacement_ratio
    assert run.peak_tau == run.end_tau


# By the law E^g falls by E_r^g (1 - e^2g) at each impact: from E_r the second leaves 2 e^2g - 1 < 0, nothing.
@pytest.mark.parametrize(("e", "g", "last"), [(0.0, 0.0, 0), (0.3, 0.45, 1)])
def test_a_wall_that_stops_at_an_impact_starts_again_when_the_load_pushes(e, g, last):
    load, times = (
        np.concatenate([np.zeros(17), 0.7 * np.sin(0.4 * np.arange(60))]),
        np.arange(150) / 8,
    )
    damping = Damping("CR", e, loss_exponent=g, reference_amplitude=0.5)
    run = exact_history(CURVES[0], damping, times, release_amplitude=0.5, load=load, sampling=0.25)
    before = (times > run.impacts[last]) & (times < 4)  # it rests until the load begins
    assert before.sum() > 5 and not run.displacement[before].any()
    assert not run.collapsed and run.impacts.size > 3


def test_the_load_is_linear_between_its_samples_and_zero_afterwards():
    times = np.linspace(0, 0.5, 11)
    plateau = TrilinearCurve(0.04, 0.6)  # a constant load accelerates the wall uniformly there
    start = {"release_amplitude": 0.1, "release_velocity": 0.1}
    run = exact_history(plateau, Damping("CR", 0.9), times, **start, load=[0.9, 0.9], sampling=1.0)
    assert run.displacement == pytest.approx(0.1 + 0.1 * times + 0.15 * times**2, abs=1e-14)
    curve, damper, times = CURVES[0], DAMPERS["CDR"], np.linspace(0, 4, 101)
    coarse = exact_history(curve, damper, times, load=[0.0, 0.4, -0.2], sampling=0.5)
    fine = exact_history(
        curve, damper, times, load=[0.0, 0.2, 0.4, 0.1, -0.2, 0, 0, 0], sampling=0.25
    )
    assert coarse.displacement[:26] == pytest.approx(fine.displacement[:26], abs=1e-13)
    state = {"release_amplitude": coarse.displacement[25], "release_velocity": coarse.velocity[25]}
    rest = exact_history(curve, damper, times[25:] - times[25], **state)
    assert coarse.displacement[25:] == pytest.approx(rest.displacement, abs=1e-12)


@every_damper
def test_the_mirrored_motion_is_the_mirror_image_and_does_not_depend_on_the_times_asked_for(damper):
    load, curve = smooth_load(3, 41), CURVES[0]
    right, left, few = (
        exact_history(
            curve, damper, times, release_amplitude=way * 0.3, load=way * load, sampling=0.2
        )
        for way, times in (
            (1, np.linspace(0, 4, 201)),
            (-1, np.linspace(0, 4, 201)),
            (1, np.linspace(0, 4, 3)),
        )
    )
    assert left.displacement == pytest.approx(-right.displacement, abs=1e-9)
    np.testing.assert_array_equal(right.displacement[::100], few.displacement)
    np.testing.assert_array_equal(right.impacts, few.impacts)


@pytest.mark.parametrize("v0", [-0.4, 0.4])
def test_a_launch_from_rest_position_is_not_an_impact_and_rest_is_kept(v0):
    run = exact_history(CURVES[0], Damping("CR", 0.6), [0.0, 0.01, 1.0], release_velocity=v0)
    assert run.velocity[0] == v0 and run.displacement[1] == pytest.approx(0.01 * v0, rel=1e-2)
    assert (
        exact_history(CURVES[0], Damping("CR", 0.6), [0.0], release_velocity=v0).velocity[0] == v0
    )
    rest = exact_history(
        CURVES[0], Damping("CR", 0.6), [0.0, 1.0, 2.2], load=[0.0, 0.0, v0], sampling=1.0
    )
    assert (
        not rest.displacement[:2].any() and rest.displacement[2] * v0 > 0 and not rest.impacts.size
    )


@pytest.mark.parametrize(
    "damper", [Damping("CDC", 0.05), Damping("CDR", 0.05)], ids=["closed form", "steps"]
)
@pytest.mark.parametrize(("share", "turns"), [(0.9, 2), (1.1, 0)])
def test_two_turns_close_to_each_other_are_both_found(damper, share, turns):
    """The load slows the wall and pushes it on again within a sample, and just turns it or does not."""
    curve, sample, least, most = CURVES[1], 0.09, -0.35, 0.55
    slowest = (
        sample * least / (least - most)
    )  # of a wall on the plateau, where the restoring force is constant
    start = {"release_amplitude": 0.1, "release_velocity": -share * least * slowest / 2}
    load = float(curve.force(0.1)) + np.array([least, most])
    run = exact_history(
        curve, damper, np.linspace(0, sample, 2001), **start, load=load, sampling=sample
    )
    assert run.turning_tau.size == turns
    changes = np.flatnonzero(np.diff(np.sign(run.velocity)))
    np.testing.assert_allclose(run.turning_tau, run.times[changes], atol=2 * sample / 2000)


# --- compiled code ---------------------------------------------------------------------------------------------------


@pytest.mark.nojit
@every_damper
def test_compiled_code_does_what_its_source_says(monkeypatch, damper):
    def run_both():
        for start in (
            {"release_amplitude": 0.105, "release_velocity": -0.3},
            {"release_amplitude": 0.7},
        ):
            load = smooth_load(4, 5) + 10 * (start["release_amplitude"] > 0.5)
            run = exact_history(
                CURVES[4], damper, np.linspace(0, 1.2, 9), **start, load=load, sampling=0.3
            )
            yield (
                run.displacement,
                run.velocity,
                run.impacts,
                run.turning_displacement,
                run.end_tau,
                run.collapsed,
            )

    compiled = [*run_both()]
    monkeypatch.setattr(exact, "run", inspect.unwrap(exact.run))
    plain = [*run_both()]
    assert [runs[-1] for runs in plain] == [False, True] and plain[0][2].size == plain[0][
        3
    ].size == 1
    for one, other in zip(compiled, plain, strict=True):
        for found, expected in zip(one, other, strict=True):
            np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-14)


def test_no_power_of_a_whole_exponent_is_compiled_without_the_liberties_that_the_batched_solver_has():
    # Numba would share it with that solver, whose bits would then depend on which of the two is compiled first.
    tree = ast.parse(Path(exact.__file__).read_text(encoding="utf-8"))
    powers = [
        node.right
        for node in ast.walk(tree)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow)
    ]
    exponents = [getattr(power, "operand", power) for power in powers]  # without its sign
    assert exponents and not any(
        type(getattr(exponent, "value", None)) is int for exponent in exponents
    )
