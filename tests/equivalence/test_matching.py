"""Minima of Err, Eq. (17), and of its integral, and the protocol that publishes them."""

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
    """Return decays of the reference curve, one for each e."""
    e = np.atleast_1d(restitution).astype(float)
    curve = TrilinearCurve(np.full(e.size, 0.04), np.full(e.size, 0.85))
    amplitudes = np.full(e.size, amplitude)
    return Cases.release(curve, amplitudes, e, step=step, steps=round(length / step), **scheme)


def damped_decay(damping, cases):
    """Return abs(u) of the reference curve under a damper, at each step of the cases."""
    response = simulate(
        CURVE,
        damping,
        release_amplitude=float(cases.release_amplitude[0]),
        step=cases.step,
        steps=cases.steps,
    )
    return np.abs(response.displacement)


def match_cdr(cases):
    """Return the match of CDR over 800 steps of 0.01, with one refinement."""
    return match_dampers(cases, ["CDR"], 800, refinement=2)["CDR"]


# --- the global minimum of Err -------------------------------------------------------------------


@pytest.mark.parametrize("model", VISCOUS_MODELS)
def test_own_decay_gives_the_own_ratio(model):
    """The reference is the model itself: Err is zero at its ratio and nowhere else."""
    cases = release(0.85)
    truth = 1.1 * damping_ratio_energy(CURVE, model, 0.85, 0.5).item()
    cases.displacement[:] = damped_decay(Damping(model, truth), cases)
    best = global_minima(cases, model, [1600])
    assert best.damping_ratio[0, 0] == pytest.approx(truth, rel=2e-5)
    assert best.error[0, 0] < 1e-6


@pytest.mark.parametrize("model", VISCOUS_MODELS)
def test_ratio_against_an_independent_integration(model):
    """Event-driven decays and a bounded scalar minimiser: no code of the kernel or the scan."""
    e, x0 = 0.85, 0.5
    times = np.arange(1, 1601) * 0.005

    def decay(damping):
        return np.abs(exact_history(CURVE, damping, times, release_amplitude=x0).displacement)

    reference = decay(Damping("CR", e))

    def err(xi):
        return np.sum((reference - decay(Damping(model, xi))) ** 2)

    guess = damping_ratio_energy(CURVE, model, e, x0).item()
    bounds = (0.6 * guess, 1.8 * guess)
    independent = minimize_scalar(err, bounds=bounds, method="bounded", options={"xatol": 1e-5})
    best = global_minima(release(e, step=0.00125), model, [6400])
    assert best.damping_ratio[0, 0] == pytest.approx(independent.x, rel=3e-3)


def test_global_minimum_among_many():
    """A long response near e = 1 has several local minima; a finer scan knows the lowest.

    The samples of |u| put a ripple on Err, which at this step is below 0.1 % of Err.
    """
    cases = release(0.97, length=60.0, step=0.0025)
    best = global_minima(cases, "CDC", [cases.steps])
    trial = damping_ratio_energy(CURVE, "CDC", 0.97, 0.5) * np.geomspace(0.3, 3.0, 4800)
    error = cases.errors("CDC", trial[None], np.array([[0]]), [cases.steps])[0, 0]
    assert best.local_minima[0, 0] > 1
    assert best.error[0, 0] <= error.min() * 1.001
    assert best.damping_ratio[0, 0] == pytest.approx(trial[error.argmin()], rel=2e-3)


def test_response_lengths_together_as_alone():
    cases = release([0.75, 0.9], length=60.0)
    lengths = np.arange(1600, 12001, 800)
    batch = global_minima(cases, "CDR", lengths)
    for index in (0, 5, 12):
        single = global_minima(cases, "CDR", lengths[[index]])
        for name in ("damping_ratio", "error", "local_minima"):
            np.testing.assert_array_equal(getattr(batch, name)[index], getattr(single, name)[0])


def test_case_without_loss_has_no_damping():
    cases = release([0.75, 0.9, 1.0])
    batch = global_minima(cases, "CDR", [1600])
    single = global_minima(cases.take(slice(0, 2)), "CDR", [1600])
    np.testing.assert_array_equal(batch.damping_ratio[:, :2], single.damping_ratio)
    assert not batch.damping_ratio[:, 2].any()
    assert not batch.error[:, 2].any()


def test_response_before_the_first_impact_is_refused():
    first_impact = float(CURVE.period(0.5)) / 4
    with pytest.raises(InputError, match="first impact"):
        global_minima(release(0.85), "CDR", [int(0.99 * first_impact / 0.005)])


@pytest.mark.parametrize(("smallest", "largest"), [(0.1, 0.5), (2.0, 3.0)])
def test_minimum_at_the_edge_of_the_scan_is_refused(monkeypatch, smallest, largest):
    monkeypatch.setattr(matching, "SCAN", np.geomspace(smallest, largest, 50))
    with pytest.raises(InputError, match="edge of the scan"):
        global_minima(release(0.85), "CDR", [1600])


@pytest.mark.parametrize(
    ("depth", "basin"), [(0.0, 0), (0.004, 1)], ids=["equal", "second is deeper"]
)
def test_lower_basin_or_the_smaller_ratio_is_taken(depth, basin):
    """One basin is at a point of the scan. The other is between two, and seems to be higher."""
    guess = damping_ratio_energy(CURVE, "CDR", 0.85, 0.5).item()
    midpoint = 0.5 * np.log(matching.SCAN[140] * matching.SCAN[141])
    bottoms = np.log(matching.SCAN[60]), midpoint

    class TwoBasins(Cases):
        def errors(self, damping_model, damping_ratio, case, marks, stride=1):
            place = np.log(damping_ratio / guess)
            first = np.maximum(np.abs(place - bottoms[0]), 0.001)
            second = np.maximum(np.abs(place - bottoms[1]), 0.001) - depth
            return np.minimum(first, second)[None] + 0.01

    cases = release(0.85)
    basins = TwoBasins(
        cases.curve, cases.release_amplitude, cases.restitution, cases.displacement, cases.step
    )
    best = global_minima(basins, "CDR", [1600])
    place = np.log(best.damping_ratio[0, 0] / guess)
    assert place == pytest.approx(bottoms[basin], abs=0.002)
    assert best.local_minima[0, 0] == 2


# --- the minimum of the integral -----------------------------------------------------------------


def exact_minimum(model, restitution, amplitude, guess):
    """Return the least integral of (|u_CR| - |u|)^2 near a damping ratio, event by event.

    |u| has a kink at each crossing of zero. The crossings are nodes, so that the trapezoidal sum is
    smooth in the ratio.
    """
    even = np.linspace(0, 8.0, 16001)
    target = exact_history(CURVE, Damping("CR", restitution), even, release_amplitude=amplitude)
    nodes = np.union1d(even, target.impacts)
    reference = np.abs(np.interp(nodes, target.times, target.displacement))
    reference[np.isin(nodes, target.impacts)] = 0.0

    def distance(xi):
        decay = exact_history(CURVE, Damping(model, xi), nodes, release_amplitude=amplitude)
        squares = (reference - np.abs(decay.displacement)) ** 2
        at_crossings = np.interp(decay.impacts, nodes, reference) ** 2
        place = np.searchsorted(nodes, decay.impacts)
        values = np.insert(squares, place, at_crossings)
        return np.trapezoid(values, np.insert(nodes, place, decay.impacts))

    bounds = (0.99 * guess, 1.01 * guess)
    options = {"xatol": 1e-6 * guess}
    return minimize_scalar(distance, bounds=bounds, method="bounded", options=options).x


@pytest.mark.parametrize("restitution", [0.72, 0.79, 0.85])
def test_exact_minimum_is_within_the_uncertainty(restitution):
    """CDC from a large amplitude has the largest Err and ripple: the crossings differ most."""
    published = match_dampers(release(restitution, amplitude=0.9), ["CDC"], 1600)["CDC"]
    ratio, bound = published.damping_ratio[0], published.uncertainty[0]
    assert abs(ratio - exact_minimum("CDC", restitution, 0.9, ratio)) <= bound < 2e-3 * ratio


class KnownIntegral:
    """Cases whose integral, the mean of the last two sums, is a known function of xi."""

    step = 0.005

    def __init__(self, function):
        self.function = function

    def errors(self, damping_model, damping_ratio, case, marks):
        assert marks == [99, 100]
        mean = self.function(damping_ratio)
        last = 0.1 * damping_ratio
        return np.stack([mean - last, mean + last])

    def minima(self, start):
        return integral_minima(self, "CDC", 100, np.array([start]))


@pytest.mark.parametrize("start", [0.045, 0.05, 0.06, 0.2])
def test_smooth_minimum_is_found_from_afar(start):
    integral = KnownIntegral(lambda xi: 1 + np.log(xi / 0.05) ** 2)
    np.testing.assert_allclose(integral.minima(start), 0.05, rtol=1e-4)


@pytest.mark.parametrize("phase", np.linspace(0, 2 * np.pi, 17))
def test_ripple_hardly_moves_the_minimum(phase):
    """Two periods in half the range, which move the least value by 0.06 of the half range."""
    width = 8.0 * KnownIntegral.step

    def rippled(xi):
        ripple = 0.01 * np.sin((xi / 0.05) / width * 12 + phase)
        return ((xi / 0.05 - 1) / width) ** 2 + ripple

    minimum = KnownIntegral(rippled).minima(0.05)[0, 0]
    assert np.abs(minimum / 0.05 - 1) / width < 0.02


def test_monotone_cubic_is_least_at_the_end_downhill():
    x = np.linspace(-1, 1, 13)
    rising = x**3 + x - 0.5 * x**2
    falling = -(x**3) - x - 0.5 * x**2
    least = matching._least_of_cubic(x, np.stack([rising, falling]))
    assert least.tolist() == [-1.0, 1.0]


def test_integral_without_a_minimum_is_refused():
    with pytest.raises(InputError, match="CDC"):
        KnownIntegral(lambda xi: 1 / xi).minima(0.05)


# --- the published ratio -------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["SDR", "CDC"])
def test_minimum_is_followed_to_the_finest_step(model):
    cases, steps = release([0.75, 0.9, 0.75], step=0.01), 800
    published = match_dampers(cases, ["SDR", "CDC"], steps, refinement=4)
    assert list(published) == ["SDR", "CDC"]
    published = published[model]
    best = global_minima(cases, model, [steps])
    ratio = integral_minima(cases, model, steps, best.damping_ratio[0])[0]
    minima = []
    for refinement in (2, 2.5, 4):
        finer = cases.refine(steps, refinement)
        minima.append(integral_minima(finer, model, finer.steps, ratio))
        ratio = minima[-1][0]
    largest = np.abs(np.concatenate(minima) - ratio).max(axis=0)
    uncertainty = np.maximum(2 * largest, RESOLUTION * ratio)
    np.testing.assert_array_equal(published.damping_ratio, ratio)
    np.testing.assert_array_equal(published.uncertainty, uncertainty)
    np.testing.assert_array_equal(published.local_minima, best.local_minima[0])
    assert published.step == 0.01 / 4
    assert published.steps == 4 * steps


def test_published_error_is_err_at_the_finest_step():
    cases, steps = release([0.75, 0.9, 0.75], step=0.01), 800
    published = match_dampers(cases, ["CDC"], steps, refinement=4)["CDC"]
    finest = cases.refine(steps, 4)
    decay = damped_decay(Damping("CDC", published.damping_ratio[0]), finest)
    error = np.sum((np.abs(finest.displacement[0]) - decay) ** 2)
    np.testing.assert_allclose(published.error[[0, 2]], error, rtol=1e-12)
    np.testing.assert_allclose(published.rms_error, np.sqrt(published.error / (4 * steps)))


@pytest.mark.parametrize("place", [None, (1, 0), (1, 1), (2, 0), (2, 1), (3, 1)])
def test_deviating_minimum_widens_the_uncertainty(monkeypatch, place):
    """Of six minima at three steps, five can differ from the published one.

    The first call searches for it.
    """
    calls = []

    def minima(cases, model, steps, ratio):
        result = np.full((2, ratio.size), 0.05)
        if place is not None and len(calls) == place[0]:
            result[place[1]] *= 1.01
        calls.append(model)
        return result

    monkeypatch.setattr(matching, "integral_minima", minima)
    uncertainty = match_cdr(release([0.75, 0.9], step=0.01)).uncertainty
    expected = RESOLUTION * 0.05 if place is None else 2 * 0.01 * 0.05
    np.testing.assert_allclose(uncertainty, expected)


def test_scheme_of_the_cases_is_used():
    ratios = []
    for scheme in ("newmark", "paper"):
        cases = release(0.75, step=0.01, scheme=scheme)
        ratios.append(match_cdr(cases).damping_ratio[0])
    assert 1e-3 < abs(ratios[1] / ratios[0] - 1) < 0.05


def test_scan_does_not_change_the_ratio(monkeypatch):
    cases = release(0.75, step=0.01)
    ratio = match_cdr(cases).damping_ratio
    monkeypatch.setattr(matching, "SCAN", np.geomspace(0.5, 2.0, 30))
    np.testing.assert_allclose(match_cdr(cases).damping_ratio, ratio, rtol=2 * RESOLUTION)


@pytest.mark.parametrize("start", [0.8, 1.0, 1.3])
def test_least_sum_of_absolute_differences(start):
    cases = release([0.75, 0.9], step=0.01)
    ratios_of_least_sum = least_absolute(cases, "CDC", start * np.array([0.045, 0.018]), 800)
    for reference, ratio in zip(np.abs(cases.displacement), ratios_of_least_sum, strict=True):
        ratios = ratio * np.linspace(0.9, 1.1, 201)
        sums = np.abs(damped_decay(Damping("CDC", ratios), cases) - reference).sum(axis=-1)
        assert ratio == pytest.approx(ratios[sums.argmin()], rel=2e-3)
