"""Local damping in both solvers: against an integrator that knows nothing of them, and in plain Python."""

import numpy as np
import pytest
from exact_cases import CURVES, smooth_load
from numba import config
from scipy.integrate import solve_ivp

from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers import event_driven
from rockdamp.solvers import newmark_kernel as kernel
from rockdamp.solvers.event_driven import history
from rockdamp.solvers.newmark import solve
from rockdamp.vocabulary import LOCAL

CURVE, STEP, SAMPLES = CURVES[0], 0.25, 21
LOAD = smooth_load(5, SAMPLES)
START = {"release_amplitude": 0.2, "release_velocity": -0.1}


def by_events(alpha, times):
    """Solve x'' = g - alpha |g| sgn(v), with a restart wherever v or g vanishes or the load has a corner."""
    samples = np.arange(SAMPLES) * STEP

    a1, b1, a3 = 0.04, 0.85, 1.0  # of the curve

    def net(t, y):
        z = abs(y[0])
        force = max(min(b1 / a1 * z, b1, a3 - z), 0.0)
        return np.interp(t, samples, LOAD) - np.copysign(force, y[0])

    def turn(_, y):
        return y[1]

    events = (turn, net)
    for event in events:
        event.terminal = True
    y, t, x, side = [START["release_amplitude"], START["release_velocity"]], 0.0, [], 0
    ends = np.union1d(samples, times[-1])
    while t < times[-1]:
        end = ends[ends > t][0]
        side = side or np.sign(net(t, y))
        share = 1 + alpha if y[1] * side < 0 else 1 - alpha
        part = solve_ivp(
            lambda t, y, share=share: (y[1], share * net(t, y)),
            (t, end), y, "DOP853", events=events, dense_output=True, rtol=1e-10, atol=1e-12, max_step=0.03,
        )  # fmt: skip
        inside = times[(times > t) & (times <= part.t[-1])]
        x += part.sol(inside)[0].tolist() if inside.size else []
        t, y = part.t[-1], part.y[:, -1]
        if part.status == 1:
            turned = part.t_events[0].size > 0
            side = side if turned else -side
            y, t = np.array([y[0], 0.0 if turned else y[1]]), t
            y = y + 1e-9 * np.array([y[1], share * net(t, y)])  # past the event, which has no time of its own
            t += 1e-9
    return np.array(x)


@pytest.mark.parametrize("alpha", [0.16, 0.5])
def test_forced_histories_are_those_of_an_integrator_that_stops_at_every_change_of_sign(alpha):
    times = np.arange(1, 21) * STEP
    expected = by_events(alpha, times)
    assert np.ptp(expected) > 0.1
    run = history(CURVE, Damping(LOCAL, alpha), times, **START, load=LOAD, load_step=STEP)
    assert run.impacts.size > 2 and run.turning_tau.size > 3
    np.testing.assert_allclose(run.displacement, expected, atol=1e-7)  # 1e-9 is lost of the time at each event


@pytest.mark.parametrize(("scheme", "order"), [("newmark", 2.0), ("paper", 1.0)])
def test_the_stepper_tends_to_the_event_driven_history_with_the_order_of_its_scheme(scheme, order):
    alpha, refined = np.linspace(0.05, 0.5, 12), 2 ** np.arange(5, 10)
    times = np.arange(1, SAMPLES) * STEP
    exact = [history(CURVE, Damping(LOCAL, a), times, **START, load=LOAD, load_step=STEP).displacement for a in alpha]
    errors = []
    for substeps in refined.tolist():
        run = solve(
            CURVE, Damping(LOCAL, alpha), step=STEP / substeps, steps=(SAMPLES - 1) * substeps, substeps=substeps,
            **START, load_factor=1.0, ground_acceleration=LOAD, store_every=substeps, scheme=scheme,
        )  # fmt: skip
        errors.append(np.sqrt(np.mean((run.displacement[:, 1:] - exact) ** 2)))
    assert -np.polyfit(np.log2(refined), np.log2(errors), 1)[0] == pytest.approx(order, abs=0.35)
    assert errors[-1] < (1e-5 if scheme == "newmark" else 3e-3)


def test_a_load_that_ends_on_the_force_of_the_plateau_leaves_the_wall_where_it_goes():
    """g = 0 for good: neither solver may stall, and the velocity stays."""
    curve = TrilinearCurve(0.04, 0.6)
    still = {"release_amplitude": 0.1, "release_velocity": 0.1, "load": [0.6, 0.6], "load_step": 1.0}
    run = history(curve, Damping(LOCAL, 0.3), [0.5, 1.0], **still)
    np.testing.assert_allclose(run.displacement, [0.15, 0.2], atol=1e-14)


@pytest.mark.nojit
@pytest.mark.parametrize("scheme", ["newmark", "paper"])
def test_compiled_steps_do_what_their_source_says(monkeypatch, scheme):
    run = {
        "step": 0.02, "steps": 120, "substeps": 10, "load_factor": [0.0, 0.3, 1.0], "scheme": scheme,
        "ground_acceleration": 5 * LOAD[:13], "release_amplitude": [0.5, 0.0, -0.02], "store_every": 1, "threads": 1,
    }  # fmt: skip
    compiled = None if config.DISABLE_JIT else solve(CURVE, Damping(LOCAL, 0.2), **run)
    monkeypatch.setattr(kernel, "compiled_march", kernel.plain_march)
    plain = solve(CURVE, Damping(LOCAL, 0.2), **run)
    assert (plain.peak > 0.02).all() and (plain.peak > 0.3).sum() == 2
    if compiled is not None:
        np.testing.assert_allclose(plain.displacement, compiled.displacement, atol=1e-12)


@pytest.mark.nojit
def test_compiled_pieces_do_what_their_source_says(monkeypatch):
    arguments = (CURVE, Damping(LOCAL, 0.2), np.linspace(0.1, 2.5, 9))
    compiled = None if config.DISABLE_JIT else history(*arguments, **START, load=LOAD, load_step=STEP)
    monkeypatch.setattr(event_driven, "compiled_run", lambda law: event_driven.plain(law)["run"])
    plain = history(*arguments, **START, load=LOAD, load_step=STEP)
    assert plain.impacts.size > 0
    if compiled is not None:
        np.testing.assert_allclose(plain.displacement, compiled.displacement, rtol=1e-12, atol=1e-14)


def test_its_coefficient_is_the_force_over_the_speed_and_its_range_is_stated():
    damper, x, v = Damping(LOCAL, 0.3), np.array([-0.5, 0.02, 0.1]), np.array([0.1, -0.3, 0.7])
    expected = 0.3 * np.abs(CURVE.force(x)) / np.abs(v)
    np.testing.assert_allclose(damper.coefficient(CURVE, x, v), expected, rtol=1e-14)
    np.testing.assert_allclose(
        [damper.law(abs(a), abs(CURVE.force(a)), 1.0, b, (0.3,)) for a, b in zip(x, v, strict=True)], expected
    )
    for alpha in (-0.1, 1.0):
        with pytest.raises(InputError, match=r"local_damping \(alpha\) is .*; it must be at least 0 and less than 1"):
            Damping(LOCAL, alpha)
