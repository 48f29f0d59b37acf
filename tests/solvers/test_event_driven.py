"""The event-driven solver against closed forms and at high precision; collapse."""

import math

import mpmath
import numpy as np
import pytest
from exact_cases import CURVES, DAMPERS, NAMES, cr_peaks

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.damping.secant import secant_law
from rockdamp.solvers import event_driven
from rockdamp.solvers.event_driven import history
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.oscillator import closed_state
from rockdamp.solvers.response import COLLAPSED

# --- free decays against closed forms --------------------------------------------------------------------------------


@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize("restitution", [0.7, 0.93, 1.0])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.97])
def test_cr_peaks_and_their_times_follow_the_energy_of_each_impact(curve, restitution, share):
    x0 = share * float(curve.ultimate_displacement_ratio)
    run = history(curve, Damping.cr(restitution), [60.0], release_amplitude=x0)
    peaks = cr_peaks(curve, restitution, x0, run.turning_tau.size)
    # At y = a3 - x0 = 0.03 an error of 1e-15 in energy is one of 1e-15/y^2 = 1e-12 in time, and it adds up.
    assert np.abs(run.turning_displacement) == pytest.approx(peaks, rel=1e-12)
    assert np.array_equal(np.sign(run.turning_displacement), -((-1.0) ** np.arange(peaks.size)))
    quarters = curve.period(np.concatenate([[x0], peaks])) / 4
    impacts = np.cumsum(np.concatenate([[quarters[0]], 2 * quarters[1:]]))
    assert run.impacts == pytest.approx(impacts[: run.impacts.size], abs=1e-10)
    assert run.turning_tau == pytest.approx(impacts[: peaks.size] + quarters[1:], abs=1e-10)


@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize("xi", [0.01, 0.1, 0.4])
def test_ecd_peaks_lose_the_energy_of_a_linear_oscillator_from_any_amplitude(curve, xi):
    x0 = 0.95 * float(curve.ultimate_displacement_ratio)
    run = history(curve, Damping("ECD", xi), [25.0], release_amplitude=x0)
    root = np.sqrt(curve.energy(np.abs(np.concatenate([[x0], run.turning_displacement]))))
    assert root[1:] / root[:-1] == pytest.approx(np.exp(-np.pi * xi / np.sqrt(1 - xi**2)), rel=1e-10)


@pytest.mark.parametrize("xi", [0.0, 0.05, 1.0, 2.5])
@pytest.mark.parametrize("model", ["CDC", "CDR", "SDR", "ECD"])
def test_inside_the_first_branch_every_damper_is_the_linear_oscillator(model, xi):
    curve, times = CURVES[0], np.linspace(0, 6, 200)
    w, x0, v0 = float(curve.initial_frequency), 0.02, 0.05
    run = history(curve, Damping(model, xi), times, release_amplitude=x0, release_velocity=v0)
    with mpmath.workdps(30):
        root = mpmath.sqrt(mpmath.mpf(xi) ** 2 - 1 + mpmath.mpf(10) ** -24)  # critical: two roots, nearly one
        rates = [w * (-xi + root), w * (-xi - root)]
        parts = [(v0 - rates[1] * x0) / (rates[0] - rates[1]), (v0 - rates[0] * x0) / (rates[1] - rates[0])]
        expected = [
            float(mpmath.re(sum(a * mpmath.exp(s * t) for a, s in zip(parts, rates, strict=True)))) for t in times
        ]
    assert run.displacement == pytest.approx(expected, abs=1e-11)


@pytest.mark.parametrize("amplitude", [0.04 * (1 - 1e-12), 0.04, 0.04 * (1 + 1e-12), 0.15, 0.15 + 1e-12])
@pytest.mark.parametrize("damper", [Damping.cr(1.0), Damping("CDR", 0.0), Damping("ECD", 0.0)])
def test_motion_that_only_just_touches_a_corner_keeps_its_amplitude_and_period(amplitude, damper):
    curve = TrilinearCurve(0.04, 0.85)
    run = history(curve, damper, [30.0], release_amplitude=amplitude)
    assert np.abs(run.turning_displacement) == pytest.approx(amplitude, abs=1e-13)
    assert np.diff(run.impacts) == pytest.approx(float(curve.period(amplitude)) / 2, abs=1e-9)


# --- the pieces at high precision ------------------------------------------------------------------------------------


@pytest.mark.parametrize("k", [16.0, 0.0, -1.0, -6.5])
@pytest.mark.parametrize("c", [0.0, 1e-9, 1e-3, 0.7, 8.0, 30.0])
def test_branch_solution_holds_every_digit_for_any_stiffness_and_damping(k, c):
    x, v, q, slope = 0.3, -0.7, 0.45, 1.9
    times = [1e-6, 0.01, 0.3, 1.7]
    with mpmath.workdps(40):
        rates = mpmath.matrix([[0, 1, 0, 0], [-mpmath.mpf(k), -mpmath.mpf(c), 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]])
        start = mpmath.matrix([mpmath.mpf(n) for n in (x, v, q, slope)])
        expected = [[float(n) for n in (mpmath.expm(rates * mpmath.mpf(t)) * start)[:2]] for t in times]
    for t, end in zip(times, expected, strict=True):
        # Rounding of the terms, which are up to |x''(0)| = 21, and their growth where k < 0.
        rounding = 21 * np.finfo(float).eps * math.exp(math.sqrt(max(-k, 0)) * t)
        assert closed_state(x, v, c, k, q, slope, t) == pytest.approx(end, rel=2e-14, abs=rounding)


@pytest.mark.parametrize("k", [16.0, 0.0, -1.0])
@pytest.mark.parametrize("c", [0.0, 0.7, 8.0, 30.0])
def test_a_piece_ends_where_the_velocity_first_changes_sign(k, c):
    rng = np.random.default_rng(1)
    piece = event_driven.plain(secant_law)["piece"]
    branch = np.zeros(event_driven.DESCRIPTION)
    branch[[event_driven.STIFFNESS, event_driven.CONSTANT]] = k, c
    turned = 0
    for _ in range(60):
        x, v, q, slope = rng.normal(size=4)
        stop, turns, *_ = piece(branch, (), (x, v, q, slope), 5.0, 0.0, np.inf, None)

        def velocity(t, x=x, v=v, q=q, slope=slope):
            return closed_state(x, v, c, k, q, slope, t)[1]

        within = np.array([velocity(t) for t in np.linspace(0, stop, 501)])
        assert (within[1:-1] * v > 0).all()
        if turns:
            assert abs(within[-1]) < 1e-11
            assert velocity(stop * (1 + 1e-6)) * v < 0
        else:
            assert stop == 5.0
        turned += turns
    assert turned > 10


@pytest.mark.parametrize("damper", DAMPERS, ids=NAMES)
def test_coefficients_on_the_branches_are_those_of_the_damper(damper):
    for curve in CURVES:
        given = damper.law_parameters(curve)
        coefficient = event_driven.plain(damper.law)["coefficient"]
        for branch in event_driven.branches(curve, damper):
            for x in np.linspace(branch[event_driven.LOW], branch[event_driven.HIGH], 9)[1:-1]:
                v = 0.3 * (x - 0.2)
                assert coefficient(branch, given, x, v) == pytest.approx(
                    float(damper.coefficient(curve, x, v)), rel=1e-12
                )
                force = branch[event_driven.STIFFNESS] * x + branch[event_driven.OFFSET]
                assert force == pytest.approx(float(curve.force(x)), abs=1e-14)


# --- collapse --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("damper", DAMPERS, ids=NAMES)
@pytest.mark.parametrize("curve", [CURVES[0], CURVES[3]], ids=["steeper", "translated"])
def test_collapse_ends_the_run_at_the_time_that_the_kernel_finds(curve, damper):
    load, load_step, substeps = 1.5 * np.sin(np.arange(41) * 0.2), 0.2, 100
    times = np.arange(81) * 0.1
    run = history(curve, damper, times, load=load, load_step=load_step)
    step = load_step / substeps
    kernel = solve(
        curve,
        damper,
        step=step,
        steps=40 * substeps,
        load_factor=1.0,
        ground_acceleration=load,
        substeps=substeps,
    )
    assert run.outcome == "collapsed"
    assert kernel.outcome == COLLAPSED
    # The kernel names the end of the step that goes beyond a3, and errs itself by a few h^2.
    assert -step < run.outcome_tau - kernel.outcome_tau < 10 * step**2
    gone = times > run.outcome_tau
    assert np.isnan(run.displacement[gone]).all() and np.isnan(run.velocity[gone]).all()
    assert np.abs(run.displacement[~gone]).max() <= curve.ultimate_displacement_ratio


def test_energy_decides_between_collapse_and_return():
    curve = CURVES[1]
    needed = float(np.sqrt(2 * (curve.energy(curve.ultimate_displacement_ratio) - curve.energy(0.5))))
    for factor, outcome in ((1 - 1e-9, "completed"), (1 + 1e-9, "collapsed")):
        start = {"release_amplitude": 0.5, "release_velocity": factor * needed}
        assert history(curve, Damping.cr(1.0), [40.0], **start).outcome == outcome
