"""Several runs in one posterior, and sizes of the wall that are uncertain."""

from dataclasses import replace

import numpy as np
import pytest
from experimental_style import WALL
from repository import ROOT

from rockdamp.errors import InputError
from rockdamp.laboratory import posterior as identify
from rockdamp.laboratory import problem
from rockdamp.laboratory.calibration import _by_sizes
from rockdamp.laboratory.candidates import Candidate, Prior
from rockdamp.laboratory.least_squares import RecordFit
from rockdamp.laboratory.posterior import posterior
from rockdamp.laboratory.problem import Problem
from rockdamp.mechanics.wall import Parapet
from rockdamp.motions.records import Record, read_record
from rockdamp.statistics.distribution import Distribution

MILLIMETRE = 1e-3


def record(name):
    """Every other sample, for speed."""
    whole = read_record(ROOT / f"data/test_series/cr-{name}.csv")
    return Record(*(column[::2] for column in (whole.elapsed, whole.ground_acceleration, whole.displacement)))


def solution(name):
    fit = RecordFit.from_record(
        record(name), WALL, Candidate("CR"), ultimate_displacement_ratio=1.0, softening="steeper", step=0.02
    )
    return fit.solution()


@pytest.fixture(scope="module")
def solutions():
    return solution("half"), solution("quarter")


@pytest.fixture
def coarse(monkeypatch):
    monkeypatch.setattr(problem, "LINEAR", 2.0)  # steps and samples here are coarse


def moments(about):
    made, draws = about.drawn(300, 1)
    values = made.values(draws.points)
    mean = draws.weights @ values
    return dict(zip(made.names, np.stack([mean, np.sqrt(draws.weights @ (values - mean) ** 2)], axis=1), strict=True))


def test_two_runs_together_know_what_the_precisions_of_each_add_up_to(solutions, coarse):
    """The law of independent normal measurements of the same parameters, of each along itself nearly."""
    alone = [moments(Problem.about(one, Prior())) for one in solutions]
    both, by_run = (moments(Problem.about(solutions, Prior(), loss_by_run=apart)) for apart in (False, True))
    for name in ("yield_displacement_ratio", "strength_ratio", "restitution"):
        (first, one), (second, other) = (moment[name] for moment in alone)
        added = one**-2 + other**-2
        assert both[name][1] == pytest.approx(added**-0.5, rel=0.15)
        assert both[name][0] == pytest.approx((first / one**2 + second / other**2) / added, abs=0.7 * added**-0.5)
    # With an e of its own each run knows its e less well than both know one, and no worse than alone.
    losses = [by_run[f"restitution {run}"] for run in (1, 2)]
    for (mean, deviation), moment in zip(losses, alone, strict=True):
        assert both["restitution"][1] < deviation < 1.15 * moment["restitution"][1]
        assert abs(mean - moment["restitution"][0]) < moment["restitution"][1]


def test_an_uncertain_thickness_widens_the_answer_by_what_the_least_squares_change_with_it(solutions, coarse):
    def about(deviation):
        reach = 6 * deviation
        thickness = Distribution("normal", WALL.thickness - reach, WALL.thickness + reach, WALL.thickness, deviation)
        return moments(Problem.about(solutions[0], replace(Prior(), thickness=thickness)))

    known, exact, wide = moments(Problem.about(solutions[0], Prior())), about(1e-7), about(MILLIMETRE)
    slopes = np.sqrt(np.diag(_by_sizes(solutions[0], {"thickness": MILLIMETRE}))) / MILLIMETRE
    left = wide["thickness"][1]
    assert left < MILLIMETRE  # the record tells of it too
    for slope, name in zip(slopes, ("yield_displacement_ratio", "strength_ratio", "restitution"), strict=True):
        assert exact[name] == pytest.approx(known[name], rel=0.1)
        assert wide[name][1] == pytest.approx(np.hypot(known[name][1], slope * left), rel=0.3)
        assert wide[name][1] > 1.02 * known[name][1]


def test_a_posterior_of_two_records_has_a_run_for_each_and_names_the_one_that_is_wrong(coarse, monkeypatch):
    monkeypatch.setattr(identify, "EFFECTIVE", 300.0)
    runs = [record("half"), record("quarter")]
    made = posterior(runs, WALL, loss_by_run=True, step=0.02)
    assert made.sizes["run"] == 2 and "restitution 2" in made["parameter"] and "predicted" not in made
    np.testing.assert_allclose(made["share_inside"], 0.9, atol=0.06)
    np.testing.assert_allclose(made["residual_over_noise"], 1.0, atol=0.3)
    wrong = replace(runs[1], displacement=1000 * runs[1].displacement)
    with pytest.raises(InputError, match="^record 2 of 2: the largest .* was it in millimetres?"):
        posterior([runs[0], wrong], WALL)


def test_a_parapet_has_no_hinge_that_is_uncertain():
    prior = replace(Prior(), hinge_ratio=Distribution("normal", 0.5, 0.7, 0.6, 0.01))
    with pytest.raises(InputError, match="hinge_ratio is 'uncertain'; it must be that of a wall"):
        posterior(record("half"), Parapet(0.23, 1.84), prior=prior)


def test_a_record_that_is_given_twice_is_refused():
    with pytest.raises(InputError, match="records 1 and 3 have the same displacements; each must be given once"):
        posterior([record("half"), record("quarter"), record("half")], WALL)
