"""Minima of the integral that Err tends to, against exact solutions and on integrals that are known."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from rockdamp.equivalence import minima as module
from rockdamp.equivalence.matching import solve
from rockdamp.equivalence.minima import Cases, error_at, global_minima, integral_minima
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers import newmark
from rockdamp.solvers.exact import exact_history

STEP, STEPS = 0.005, 1600


def released(restitution, release=0.5):
    e = np.atleast_1d(restitution).astype(float)
    curve = TrilinearCurve(0.04, 0.85).map(lambda p: np.full(e.size, p))
    return Cases.released(curve, np.full(e.size, release), e, step=STEP, steps=STEPS)


def exact(model, restitution, release, near):
    """The least integral of (|u_CR| - |u|)^2 near a damping ratio, by the event-driven solver.

    |u| has a kink at each crossing of zero. The crossings are nodes, so the trapezoidal sum is smooth in the ratio.
    """
    curve, even = TrilinearCurve(0.04, 0.85), np.linspace(0, STEP * STEPS, 10 * STEPS + 1)
    target = exact_history(curve, Damping.cr(restitution), even, release_amplitude=release)
    nodes = np.union1d(even, target.impacts)
    wanted = np.abs(np.interp(nodes, target.times, target.displacement))
    wanted[np.isin(nodes, target.impacts)] = 0.0

    def distance(xi):
        found = exact_history(curve, Damping(model, xi), nodes, release_amplitude=release)
        squared = (wanted - np.abs(found.displacement)) ** 2
        at_crossings = np.interp(found.impacts, nodes, wanted) ** 2
        place = np.searchsorted(nodes, found.impacts)
        return np.trapezoid(np.insert(squared, place, at_crossings), np.insert(nodes, place, found.impacts))

    ends = 0.99 * near, 1.01 * near
    return minimize_scalar(distance, bounds=ends, method="bounded", options={"xatol": 1e-6 * near}).x


@pytest.mark.parametrize("restitution", [0.72, 0.75, 0.79, 0.85])
def test_the_exact_minimum_of_cdc_from_a_large_amplitude_is_within_the_uncertainty(restitution):
    """Where Err is largest, and its ripple with it: the two motions cross zero furthest apart."""
    of = solve(released(restitution, release=0.9), ["CDC"], STEPS)["CDC"]
    ratio, bound = of.damping_ratio[0], of.uncertainty[0]
    assert abs(ratio - exact("CDC", restitution, 0.9, ratio)) <= bound < 2e-3 * ratio


def test_the_error_falls_with_the_square_of_the_step():
    """Over many e, since that of a single one is erratic; the least sample falls with the step itself."""
    e = np.linspace(0.70, 0.98, 57)
    cases = released(e)
    ratio = global_minima(cases, "CDC", [STEPS]).damping_ratio[0]
    by_step = []
    for refinement in (1, 2, 4, 16):
        finer = cases.refined(STEPS, refinement)
        ratio = integral_minima(finer, "CDC", finer.steps, ratio)[0]
        by_step.append(ratio)
    error = [np.median(np.abs(coarse / by_step[-1] - 1)) for coarse in by_step[:-1]]
    assert np.log2(error[0] / error[2]) / 2 > 1.6


def test_the_error_at_a_damping_ratio_is_the_sum_of_eq_17():
    cases = released([0.8, 0.9])
    xi = np.array([0.06, 0.03])
    found = newmark.solve(
        cases.curve, Damping("SDR", xi), release_amplitude=0.5, step=STEP, steps=STEPS, store_every=1
    ).displacement
    expected = ((np.abs(cases.displacement) - np.abs(found)) ** 2)[:, : STEPS - 99].sum(axis=1)
    np.testing.assert_allclose(error_at(cases, "SDR", STEPS - 100, xi), expected, rtol=1e-12)


def test_the_integral_counts_its_last_sample_half():
    """The trapezoidal sum of the squared differences, in steps; Eq. (17) counts the last one whole."""
    cases, xi = released([0.8, 0.9]), np.array([0.06, 0.03])
    found = newmark.solve(cases.curve, Damping("SDR", xi), release_amplitude=0.5, step=STEP, steps=100, store_every=1)
    squared = (np.abs(cases.displacement[:, :101]) - np.abs(found.displacement)) ** 2
    integral = module._integral(cases, "SDR", 100, xi[:, None], np.arange(2), "newmark")
    np.testing.assert_allclose(integral[:, 0], np.trapezoid(squared), rtol=1e-12)


@pytest.fixture
def made_up(monkeypatch):
    """Put a known function of xi in place of the integral."""

    def put(function):
        monkeypatch.setattr(module, "_integral", lambda cases, model, steps, xi, case, scheme: function(xi))

    return put


@pytest.mark.parametrize("start", [0.045, 0.05, 0.06, 0.2])
def test_a_smooth_minimum_is_found_from_where_no_range_around_the_start_holds_it(made_up, start):
    made_up(lambda xi: 1 + (np.log(xi / 0.05)) ** 2)
    found = integral_minima(released(0.85), "CDC", STEPS, np.array([start]))
    np.testing.assert_allclose(found, 0.05, rtol=1e-4)


def test_of_a_ripple_little_is_left(made_up):
    """One with two periods per half range, at every phase; it moves the least value by 0.06 of the half range."""
    width = module.HALF_WIDTH * STEP
    phases = np.linspace(0, 2 * np.pi, 17)
    off = []
    for phase in phases:
        made_up(
            lambda xi, phase=phase: ((xi / 0.05 - 1) / width) ** 2 + 0.01 * np.sin((xi / 0.05) / width * 12 + phase)
        )
        off.append(np.abs(integral_minima(released(0.85), "CDC", STEPS, np.array([0.05]))[0, 0] / 0.05 - 1) / width)
    assert max(off) < 0.02


def test_an_integral_that_falls_for_ever_is_an_error(made_up):
    made_up(lambda xi: 1 / xi)
    with pytest.raises(InputError, match=r"the minimum of Err of CDC near xi = 0.05 could not be bracketed"):
        integral_minima(released(0.85), "CDC", STEPS, np.array([0.05]))
