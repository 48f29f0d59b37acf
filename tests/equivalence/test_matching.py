"""The protocol behind every published damping ratio of least Err."""

import numpy as np
import pytest

from rockdamp.equivalence import matching
from rockdamp.equivalence.minima import RESOLUTION, Cases, error_at, global_minima, integral_minima
from rockdamp.mechanics.curve import TrilinearCurve

STEP, STEPS = 0.01, 800


def released(restitution):
    e = np.asarray(restitution, dtype=float)
    curve = TrilinearCurve(0.04, 0.85).map(lambda p: np.full(e.size, p))
    return Cases.released(curve, np.full(e.size, 0.5), e, step=STEP, steps=STEPS)


@pytest.fixture(scope="module")
def cases():
    return released([0.75, 0.9, 0.75])


@pytest.fixture(scope="module")
def matched(cases):
    return matching.solve(cases, ["SDR", "CDC"], STEPS, refinement=4)


def test_the_integral_s_minimum_is_followed_from_the_global_one_to_the_finest_step(cases, matched):
    assert list(matched) == ["SDR", "CDC"]
    for model, of in matched.items():
        best = global_minima(cases, model, [STEPS])
        ratio, found = integral_minima(cases, model, STEPS, best.damping_ratio[0])[0], []
        for refinement in (2, 2.5, 4):
            finer = cases.refined(STEPS, refinement)
            found.append(integral_minima(finer, model, finer.steps, ratio))
            ratio = found[-1][0]
        largest = np.abs(np.concatenate(found) - ratio).max(axis=0)
        np.testing.assert_array_equal(of.damping_ratio, ratio)
        np.testing.assert_array_equal(of.uncertainty, np.maximum(2 * largest, RESOLUTION * ratio))
        np.testing.assert_array_equal(of.local_minima, best.local_minima[0])
        error = error_at(cases.refined(STEPS, 4), model, 4 * STEPS, ratio)
        np.testing.assert_array_equal(of.error, error)
        np.testing.assert_allclose(of.rms_error, np.sqrt(error / (4 * STEPS)))
        assert (of.step, of.steps) == (STEP / 4, 4 * STEPS)


def test_the_uncertainty_is_never_less_than_the_resolution_of_the_minimiser(cases, monkeypatch):
    monkeypatch.setattr(matching, "integral_minima", lambda cases, model, steps, ratio, scheme: np.stack([ratio] * 2))
    of = matching.solve(cases, ["CDR"], STEPS, refinement=2)["CDR"]
    np.testing.assert_array_equal(of.uncertainty, RESOLUTION * of.damping_ratio)


@pytest.mark.parametrize("off", range(5))
def test_any_of_the_minima_that_differs_widens_the_uncertainty(cases, monkeypatch, off):
    """Six minima of three steps: five that can differ from the one that is published."""
    calls = []

    def minima(cases, model, steps, ratio, scheme):
        found = np.full((2, ratio.size), 0.05)
        calls.append(model)
        step = len(calls) - 2  # the first call is at the solver's step and only looks for the place
        places = [(0, 0), (0, 1), (1, 0), (1, 1), (2, 1)]
        if step == places[off][0]:
            found[places[off][1]] *= 1.01
        return found

    monkeypatch.setattr(matching, "integral_minima", minima)
    of = matching.solve(cases, ["CDR"], STEPS, refinement=2)["CDR"]
    np.testing.assert_allclose(of.uncertainty, 2 * 0.01 * 0.05)


def test_equal_cases_are_matched_once(cases, matched, monkeypatch):
    for of in matched.values():
        for values in (of.damping_ratio, of.uncertainty, of.error, of.local_minima):
            assert values[0] == values[2] and values.shape == (3,)
    searched = []

    def search(cases, *arguments):
        searched.append(cases.restitution.tolist())
        return global_minima(cases, *arguments)

    monkeypatch.setattr(matching, "global_minima", search)
    matching.solve(cases, ["CDR"], STEPS, refinement=2)
    assert searched == [[0.75, 0.9]]


def test_the_scheme_and_the_scan_are_those_asked_for(cases):
    printed = Cases.released(
        cases.curve, cases.release_amplitude, cases.restitution, step=STEP, steps=STEPS, scheme="paper"
    )
    newmark = matching.solve(cases, ["CDR"], STEPS, refinement=2)["CDR"]
    paper = matching.solve(printed, ["CDR"], STEPS, refinement=2, scheme="paper")["CDR"]
    apart = np.abs(paper.damping_ratio / newmark.damping_ratio - 1)
    assert 1e-3 < apart[0] < 0.05
    coarser = matching.Scan(smallest=0.5, largest=2.0, points=30)
    few = matching.solve(cases, ["CDR"], STEPS, refinement=2, scan=coarser)["CDR"]
    np.testing.assert_allclose(few.damping_ratio, newmark.damping_ratio, rtol=2 * RESOLUTION)
