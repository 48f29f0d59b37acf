"""Minima of Err, Eq. (17), and of the integral it tends to, and the protocol that publishes them."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from rockdamp.constants import VISCOUS_MODELS
from rockdamp.equivalence import matching
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.equivalence.matching import (
    RESOLUTION,
    Cases,
    global_minima,
    integral_minima,
    least_absolute,
    match_dampers,
)
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.exact import exact_history
from rockdamp.solvers.newmark import simulate

CURVE = TrilinearCurve(0.04, 0.85)


def release(restitution, amplitude=0.5, step=0.005, length=8.0, **scheme):
    """Decays of the reference curve, one for each e."""
    e = np.atleast_1d(restitution).astype(float)
    curve = TrilinearCurve(np.full(e.size, 0.04), np.full(e.size, 0.85))
    return Cases.release(
        curve, np.full(e.size, amplitude), e, step=step, steps=round(length / step), **scheme
    )


def history(damping, cases):
    """u of the reference curve at each step of the cases, under damping ratios in the place of restitution."""
    start = {
        "release_amplitude": float(cases.release_amplitude[0]),
        "step": cases.step,
        "steps": cases.steps,
    }
    return np.abs(simulate(CURVE, damping, **start).displacement)


# --- the global minimum of Err ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", VISCOUS_MODELS)
def test_a_viscous_decay_is_matched_by_its_own_damping_ratio(model):
    """The reference is the model itself, so Err is zero at its ratio and nowhere else."""
    cases = release(0.85)
    truth = 1.1 * damping_ratio_energy(CURVE, model, 0.85, 0.5).item()
    cases.displacement[:] = history(Damping(model, truth), cases)
    best = global_minima(cases, model, [1600])
    assert best.damping_ratio[0, 0] == pytest.approx(truth, rel=2e-5)
    assert best.error[0, 0] < 1e-6


@pytest.mark.parametrize("model", VISCOUS_MODELS)
def test_the_matched_ratio_is_that_of_an_independent_integration(model):
    """Event-driven decays sampled finely, and a bounded scalar minimiser: no code of the kernel or of the scan."""
    e, x0, times = 0.85, 0.5, np.arange(1, 1601) * 0.005
    reference = np.abs(
        exact_history(CURVE, Damping("CR", e), times, release_amplitude=x0).displacement
    )

    def err(xi):
        found = exact_history(CURVE, Damping(model, xi), times, release_amplitude=x0).displacement
        return np.sum((reference - np.abs(found)) ** 2)

    guess = damping_ratio_energy(CURVE, model, e, x0).item()
    independent = minimize_scalar(
        err, bounds=(0.6 * guess, 1.8 * guess), method="bounded", options={"xatol": 1e-5}
    )
    best = global_minima(release(e, step=0.00125), model, [6400])
    assert best.damping_ratio[0, 0] == pytest.approx(independent.x, rel=3e-3)


def test_the_global_minimum_is_found_among_many():
    """A long response near e = 1 has several local minima; a scan twenty times as fine knows which is lowest.

    Sampling |u| at the steps puts a ripple on Err, of first order in the step; at this step it is below 0.1 % of Err.
    """
    cases = release(0.97, length=60.0, step=0.0025)
    best = global_minima(cases, "CDC", [cases.steps])
    trial = damping_ratio_energy(CURVE, "CDC", 0.97, 0.5) * np.geomspace(0.3, 3.0, 4800)
    error = cases.errors("CDC", trial[None], np.array([[0]]), [cases.steps])[0, 0]
    assert best.local_minima[0, 0] > 1
    assert best.error[0, 0] <= error.min() * 1.001
    assert best.damping_ratio[0, 0] == pytest.approx(trial[error.argmin()], rel=2e-3)


def test_each_response_length_has_what_it_has_alone_and_without_loss_the_ratio_is_zero():
    cases, lengths = release([0.75, 0.9, 1.0], length=60.0), np.arange(1600, 12001, 800)
    together = global_minima(cases, "CDR", lengths)
    for index in (0, 5, 12):
        alone = global_minima(cases.take(slice(0, 2)), "CDR", lengths[[index]])
        for name in ("damping_ratio", "error", "local_minima"):
            assert getattr(together, name)[index, :2].tolist() == getattr(alone, name)[0].tolist()
    assert not together.damping_ratio[:, 2].any() and not together.error[:, 2].any()


def test_where_no_damping_ratio_is_defined_it_is_refused(monkeypatch):
    cases = release(0.85)
    first = float(CURVE.period(0.5)) / 4
    with pytest.raises(InputError, match="first impact"):
        global_minima(cases, "CDR", [int(0.99 * first / 0.005)])
    for smallest, largest in ((0.1, 0.5), (2.0, 3.0)):
        monkeypatch.setattr(matching, "SCAN", np.geomspace(smallest, largest, 50))
        with pytest.raises(InputError, match="edge of the scan"):
            global_minima(cases, "CDR", [1600])


@pytest.mark.parametrize(("deeper", "taken"), [(0.0, 0), (0.004, 1)])
def test_of_two_minima_the_lower_is_taken_though_the_scan_passes_it_and_of_equal_ones_the_smaller_ratio(
    deeper, taken
):
    """The first is at a point of the scan, the second between two points, where it seems to be the higher one."""
    guess = damping_ratio_energy(CURVE, "CDR", 0.85, 0.5).item()
    bottoms = np.log(matching.SCAN[60]), 0.5 * np.log(matching.SCAN[140] * matching.SCAN[141])

    class TwoBasins(Cases):
        def errors(self, damping_model, damping_ratio, case, marks, every=1):
            first, second = (np.abs(np.log(damping_ratio / guess) - bottom) for bottom in bottoms)
            return (
                np.minimum(np.maximum(first, 0.001), np.maximum(second, 0.001) - deeper)[None]
                + 0.01
            )

    one = release(0.85)
    cases = TwoBasins(one.curve, one.release_amplitude, one.restitution, one.displacement, one.step)
    best = global_minima(cases, "CDR", [1600])
    assert np.log(best.damping_ratio[0, 0] / guess) == pytest.approx(bottoms[taken], abs=0.002)
    assert best.local_minima[0, 0] == 2


# --- the minimum of the integral --------------------------------------------------------------------------------------


def exact_minimum(model, restitution, amplitude, near):
    """The least integral of (|u_CR| - |u|)^2 near a damping ratio, by the event-driven solver.

    |u| has a kink at each crossing of zero. The crossings are nodes, so the trapezoidal sum is smooth in the ratio.
    """
    even = np.linspace(0, 8.0, 16001)
    target = exact_history(CURVE, Damping("CR", restitution), even, release_amplitude=amplitude)
    nodes = np.union1d(even, target.impacts)
    wanted = np.abs(np.interp(nodes, target.times, target.displacement))
    wanted[np.isin(nodes, target.impacts)] = 0.0

    def distance(xi):
        found = exact_history(CURVE, Damping(model, xi), nodes, release_amplitude=amplitude)
        squared = (wanted - np.abs(found.displacement)) ** 2
        at_crossings = np.interp(found.impacts, nodes, wanted) ** 2
        place = np.searchsorted(nodes, found.impacts)
        return np.trapezoid(
            np.insert(squared, place, at_crossings), np.insert(nodes, place, found.impacts)
        )

    ends = 0.99 * near, 1.01 * near
    return minimize_scalar(
        distance, bounds=ends, method="bounded", options={"xatol": 1e-6 * near}
    ).x


@pytest.mark.parametrize("restitution", [0.72, 0.79, 0.85])
def test_the_exact_minimum_of_cdc_from_a_large_amplitude_is_within_the_uncertainty(restitution):
    """Where Err is largest, and its ripple with it: the two motions cross zero furthest apart."""
    matched = match_dampers(release(restitution, amplitude=0.9), ["CDC"], 1600)["CDC"]
    ratio, bound = matched.damping_ratio[0], matched.uncertainty[0]
    assert abs(ratio - exact_minimum("CDC", restitution, 0.9, ratio)) <= bound < 2e-3 * ratio


class KnownIntegral:
    """Cases whose integral is a known function of xi: the mean of the sums up to the last step but one and the last."""

    step = 0.005

    def __init__(self, function):
        self.function = function

    def errors(self, damping_model, damping_ratio, case, marks):
        assert marks == [99, 100]
        last = 0.1 * damping_ratio
        return np.stack([self.function(damping_ratio) - last, self.function(damping_ratio) + last])


@pytest.mark.parametrize("start", [0.045, 0.05, 0.06, 0.2])
def test_a_smooth_minimum_is_found_from_where_no_range_around_the_start_holds_it(start):
    known = KnownIntegral(lambda xi: 1 + (np.log(xi / 0.05)) ** 2)
    np.testing.assert_allclose(
        integral_minima(known, "CDC", 100, np.array([start])), 0.05, rtol=1e-4
    )


def test_of_a_ripple_little_is_left():
    """One with two periods per half range, at every phase; it moves the least value by 0.06 of the half range."""
    width, off = 8.0 * KnownIntegral.step, []
    for phase in np.linspace(0, 2 * np.pi, 17):

        def rippled(xi, phase=phase):
            return ((xi / 0.05 - 1) / width) ** 2 + 0.01 * np.sin((xi / 0.05) / width * 12 + phase)

        found = integral_minima(KnownIntegral(rippled), "CDC", 100, np.array([0.05]))[0, 0]
        off.append(np.abs(found / 0.05 - 1) / width)
    assert max(off) < 0.02


def test_an_integral_that_falls_for_ever_is_an_error():
    with pytest.raises(InputError, match="CDC"):
        integral_minima(KnownIntegral(lambda xi: 1 / xi), "CDC", 100, np.array([0.05]))


# --- what is published ------------------------------------------------------------------------------------------------


def test_the_integral_s_minimum_is_followed_from_the_global_one_to_the_finest_step():
    cases, steps = release([0.75, 0.9, 0.75], step=0.01), 800
    matched = match_dampers(cases, ["SDR", "CDC"], steps, refinement=4)
    assert list(matched) == ["SDR", "CDC"]
    for model, published in matched.items():
        best = global_minima(cases, model, [steps])
        ratio, found = integral_minima(cases, model, steps, best.damping_ratio[0])[0], []
        for refinement in (2, 2.5, 4):
            finer = cases.refine(steps, refinement)
            found.append(integral_minima(finer, model, finer.steps, ratio))
            ratio = found[-1][0]
        largest = np.abs(np.concatenate(found) - ratio).max(axis=0)
        np.testing.assert_array_equal(published.damping_ratio, ratio)
        np.testing.assert_array_equal(
            published.uncertainty, np.maximum(2 * largest, RESOLUTION * ratio)
        )
        np.testing.assert_array_equal(published.local_minima, best.local_minima[0])
        error = np.sum(
            (np.abs(finer.displacement[0]) - history(Damping(model, ratio[0]), finer)) ** 2
        )
        np.testing.assert_allclose(published.error[[0, 2]], error, rtol=1e-12)
        np.testing.assert_allclose(published.rms_error, np.sqrt(published.error / (4 * steps)))
        assert (published.step, published.steps) == (0.01 / 4, 4 * steps)


@pytest.mark.parametrize("off", [None, (1, 0), (1, 1), (2, 0), (2, 1), (3, 1)])
def test_any_of_the_minima_that_differs_widens_the_uncertainty(monkeypatch, off):
    """Six minima of three steps: five that can differ from the one that is published; the first call looks for it."""
    calls = []

    def minima(cases, model, steps, ratio):
        found = np.full((2, ratio.size), 0.05)
        if off is not None and len(calls) == off[0]:
            found[off[1]] *= 1.01
        calls.append(model)
        return found

    monkeypatch.setattr(matching, "integral_minima", minima)
    matched = match_dampers(release([0.75, 0.9], step=0.01), ["CDR"], 800, refinement=2)["CDR"]
    np.testing.assert_allclose(
        matched.uncertainty, RESOLUTION * 0.05 if off is None else 2 * 0.01 * 0.05
    )


def test_the_scheme_is_that_of_the_cases_and_the_scan_changes_nothing(monkeypatch):
    newmark, paper = (release(0.75, step=0.01, scheme=scheme) for scheme in ("newmark", "paper"))
    one, other = (
        match_dampers(cases, ["CDR"], 800, refinement=2)["CDR"].damping_ratio
        for cases in (newmark, paper)
    )
    assert 1e-3 < abs(other[0] / one[0] - 1) < 0.05
    monkeypatch.setattr(matching, "SCAN", np.geomspace(0.5, 2.0, 30))
    few = match_dampers(newmark, ["CDR"], 800, refinement=2)["CDR"].damping_ratio
    np.testing.assert_allclose(few, one, rtol=2 * RESOLUTION)


@pytest.mark.parametrize("start", [0.8, 1.0, 1.3])
def test_no_ratio_near_it_has_a_smaller_sum_of_absolute_differences(start):
    cases = release([0.75, 0.9], step=0.01)
    found = least_absolute(cases, "CDC", start * np.array([0.045, 0.018]), 800)
    for reference, best in zip(np.abs(cases.displacement), found, strict=True):
        ratios = best * np.linspace(0.9, 1.1, 201)
        sums = np.abs(history(Damping("CDC", ratios), cases) - reference).sum(axis=-1)
        assert best == pytest.approx(ratios[sums.argmin()], rel=2e-3)
