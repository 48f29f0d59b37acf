"""The compiled code of the event-driven solver as plain Python, and what it does at the edges."""

import ast
from pathlib import Path

import numpy as np
import pytest
from exact_cases import CURVES, DAMPERS, NAMES, smooth_load
from numba import config

from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.damping.secant import secant_law
from rockdamp.solvers import event_driven

pytestmark = pytest.mark.nojit


def runs(damper):
    """A short forced run over a corner and x = 0, and one to the collapse."""
    curve, times = CURVES[4], np.linspace(0, 1.2, 9)
    load = smooth_load(4, 5)
    yield event_driven.history(
        curve, damper, times, release_amplitude=0.105, release_velocity=-0.3, load=load, load_step=0.3
    )
    yield event_driven.history(curve, damper, times, release_amplitude=0.7, release_velocity=0.6)


@pytest.mark.parametrize("damper", DAMPERS, ids=NAMES)
def test_compiled_code_does_what_its_source_says(monkeypatch, damper):
    compiled = [] if config.DISABLE_JIT else [*runs(damper)]
    monkeypatch.setattr(event_driven, "compiled_run", lambda law: event_driven.plain(law)["run"])
    plain = [*runs(damper)]
    assert [run.outcome for run in plain] == ["completed", "collapsed"]
    assert plain[0].impacts.size == 1
    assert plain[0].turning_tau.size == 1
    for one, other in zip(compiled, plain, strict=False):
        assert one.outcome == other.outcome
        for name in ("displacement", "velocity", "impacts", "turning_tau", "turning_displacement", "outcome_tau"):
            np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-12, atol=1e-14)


def test_events_find_room(monkeypatch):
    run = {"curve": CURVES[0], "damping": Damping("CDC", 0.02), "times": [2.0], "release_amplitude": 0.03}
    much = event_driven.history(**run)
    monkeypatch.setattr(event_driven, "ROOM", 1)
    little = event_driven.history(**run)
    assert much.impacts.size > 2
    np.testing.assert_array_equal(little.impacts, much.impacts)
    np.testing.assert_array_equal(little.turning_displacement, much.turning_displacement)


@pytest.mark.parametrize("damper", [Damping("CDC", 0.05), Damping("CDR", 0.05)], ids=["closed form", "steps"])
@pytest.mark.parametrize(("share", "turns"), [(0.9, 2), (1.1, 0)])
def test_two_turns_close_to_each_other_are_both_found(damper, share, turns):
    """The load slows the wall and pushes it on again within a sample, and just turns it or does not."""
    curve, sample, least, most = CURVES[1], 0.09, -0.35, 0.55
    slowest = sample * least / (least - most)  # of a wall on the plateau, where the restoring force is constant
    start = {"release_amplitude": 0.1, "release_velocity": -share * least * slowest / 2}
    load = float(curve.force(0.1)) + np.array([least, most])
    few, many = (
        event_driven.history(curve, damper, times, **start, load=load, load_step=sample)
        for times in ([sample], np.linspace(0, sample, 2001))
    )
    assert few.turning_tau.size == turns
    changes = np.flatnonzero(np.diff(np.sign(many.velocity)))
    np.testing.assert_allclose(few.turning_tau, many.times[changes], atol=2 * sample / 2000)


@pytest.mark.parametrize("start_velocity", [0.0, 0.004, 0.006, 0.007, -0.004])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_step_turns_where_the_closed_form_does(start_velocity, way):
    """A load that grows from pushing against a slow wall to pushing it on: no turn, one, or two in a single step."""
    c, h, p, slope = 0.05, 0.09, -0.35, 10.0
    branch, given = np.zeros(event_driven.DESCRIPTION), (c, 1.0, 0.0)
    branch[event_driven.CONSTANT] = -1.0  # by the law, which is constant
    start = (0.1, way * start_velocity, way * p, way * slope)
    rates = np.zeros((2, event_driven.STAGES + 1))
    by_law = event_driven.plain(secant_law)
    end = by_law["advance"](branch, given, start, h, rates)
    a_end = by_law["acceleration"](branch, given, start[2] + start[3] * h, *end)
    rates[:, event_driven.STAGES] = end[1], a_end
    found, turns = by_law["turn"](branch, given, start, h, end, rates)
    branch[event_driven.CONSTANT] = c
    expected, turned, *_ = by_law["piece"](branch, given, start, h, 0.0, np.inf, rates)
    assert [turns, turned] == 2 * [start_velocity < 0.0061]
    assert found == pytest.approx(expected, abs=1e-12)


def test_no_power_of_a_whole_exponent_is_compiled_without_the_liberties_that_the_batched_solver_has():
    # Numba would share it with that solver, whose bits would then depend on which of the two is compiled first.
    tree = ast.parse(Path(event_driven.__file__).read_text(encoding="utf-8"))
    powers = [node.right for node in ast.walk(tree) if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow)]
    exponents = [getattr(power, "operand", power) for power in powers]  # without its sign
    assert exponents and not any(type(getattr(exponent, "value", None)) is int for exponent in exponents)
