"""Minima of Err, Eq. (17), over the damping ratio."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from rockdamp.equivalence.closed_form import Scan, damping_ratio_energy
from rockdamp.equivalence.minima import SCAN, Cases, global_minima
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.exact import exact_history
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.response import Reference
from rockdamp.vocabulary import VISCOUS_MODELS

CURVE = TrilinearCurve(0.04, 0.85)


def cases_from(damping, restitution, release=0.5, step=0.005, length=8.0, curve=CURVE):
    e = np.atleast_1d(restitution).astype(float)
    batch = curve.map(lambda p: np.full(e.size, p))
    amplitude = np.full(e.size, release)
    response = solve(batch, damping, release_amplitude=amplitude, step=step, steps=round(length / step), store_every=1)
    return Cases(batch, amplitude, e, response.displacement, step)


@pytest.mark.parametrize("model", VISCOUS_MODELS)
def test_a_viscous_decay_is_matched_by_its_own_damping_ratio(model):
    """The reference is the model itself, so Err is zero at its ratio and nowhere else."""
    e = 0.85
    truth = float(damping_ratio_energy(CURVE, model, e, 0.5)) * 1.1
    cases = cases_from(Damping(model, np.array([truth])), e)
    best = global_minima(cases, model, [1600])
    assert best.damping_ratio[0, 0] == pytest.approx(truth, rel=2e-5)
    assert best.error[0, 0] < 1e-6


@pytest.mark.parametrize("model", VISCOUS_MODELS)
def test_the_matched_ratio_is_that_of_an_independent_integration(model):
    """Event-driven decays sampled finely, and a bounded scalar minimiser: no code of the kernel or of the scan."""
    e, x0, times = 0.85, 0.5, np.arange(1, 1601) * 0.005
    reference = np.abs(exact_history(CURVE, Damping.cr(e), times, release_amplitude=x0).displacement)

    def err(xi):
        found = exact_history(CURVE, Damping(model, xi), times, release_amplitude=x0).displacement
        return np.sum((reference - np.abs(found)) ** 2)

    guess = float(damping_ratio_energy(CURVE, model, e, x0))
    independent = minimize_scalar(err, bounds=(0.6 * guess, 1.8 * guess), method="bounded", options={"xatol": 1e-5})
    best = global_minima(cases_from(Damping.cr([e]), e, step=0.00125), model, [6400])
    assert best.damping_ratio[0, 0] == pytest.approx(independent.x, rel=3e-3)


def test_the_global_minimum_is_found_among_many():
    """A long response near e = 1 has several local minima; a scan twenty times as fine knows which is lowest.

    Sampling |u| at the steps puts a ripple on Err, of first order in the step; at this step it is below 0.1 % of Err.
    """
    e, steps, step = np.array([0.97]), 24000, 0.0025
    cases = cases_from(Damping.cr(e), e, length=60.0, step=step)
    best = global_minima(cases, "CDC", [steps])
    guess = float(damping_ratio_energy(CURVE, "CDC", 0.97, 0.5))
    trial = guess * np.geomspace(0.3, 3.0, 4800)
    error = solve(
        CURVE,
        Damping("CDC", trial),
        release_amplitude=0.5,
        step=step,
        steps=steps,
        reference=Reference(cases.displacement, 0, [steps]),
    ).error[0]
    assert best.local_minima[0, 0] > 1
    assert best.error[0, 0] <= error.min() * 1.001
    assert best.damping_ratio[0, 0] == pytest.approx(trial[error.argmin()], rel=2e-3)


def test_one_pass_over_the_response_lengths_gives_what_each_gives_alone():
    e = np.array([0.75, 0.9])
    cases = cases_from(Damping.cr(e), e, length=20.0)
    together = global_minima(cases, "CDR", [1600, 2800, 4000])
    for index, steps in enumerate((1600, 2800, 4000)):
        alone = global_minima(cases, "CDR", [steps])
        np.testing.assert_allclose(together.damping_ratio[index], alone.damping_ratio[0], rtol=1e-5)
        np.testing.assert_allclose(together.error[index], alone.error[0], rtol=1e-9)


def test_a_response_length_before_the_first_impact_has_no_damping_ratio():
    first = float(CURVE.period(0.5)) / 4
    cases = cases_from(Damping.cr([0.85]), 0.85)
    with pytest.raises(InputError, match="first impact"):
        global_minima(cases, "CDR", [int(0.99 * first / 0.005)])


@pytest.mark.parametrize("smallest, largest", [(0.1, 0.5), (2.0, 3.0)])
def test_a_minimum_at_the_edge_of_the_scan_is_an_error(smallest, largest):
    cases = cases_from(Damping.cr([0.85]), 0.85)
    with pytest.raises(InputError, match="edge of the scan"):
        global_minima(cases, "CDR", [1600], Scan(smallest, largest, points=50))


def test_without_loss_the_damping_ratio_is_zero_beside_cases_with_loss():
    e = np.array([0.9, 1.0])
    cases = cases_from(Damping.cr(e), e)
    best = global_minima(cases, "CDR", [1600])
    alone = global_minima(cases.take(slice(0, 1)), "CDR", [1600])
    assert best.damping_ratio.tolist() == [[alone.damping_ratio[0, 0], 0.0]]
    assert best.error[0, 1] == 0.0


def test_of_equal_minima_the_smaller_damping_ratio_is_taken(monkeypatch):
    from rockdamp.equivalence import minima

    def two_equal_basins(cases, model, response_lengths, response_length, case, around, scheme):
        return around[1], np.ones(response_length.size)

    def scan(cases, model, trial, response_lengths, scheme):
        error = np.full((1, 1, trial.shape[1]), 2.0)
        error[..., [10, 30]] = 1.0
        return error

    monkeypatch.setattr(minima, "_scan", scan)
    monkeypatch.setattr(minima, "_refine", two_equal_basins)
    cases = cases_from(Damping.cr([0.85]), 0.85)
    best = global_minima(cases, "CDR", [1600])
    guess = damping_ratio_energy(CURVE, "CDR", 0.85, 0.5)
    assert best.damping_ratio[0, 0] == pytest.approx(float(guess * np.geomspace(0.3, 3.0, SCAN.points)[10]))
    assert best.local_minima[0, 0] == 2
