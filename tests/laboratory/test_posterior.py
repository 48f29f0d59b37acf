"""The posterior: what made a record lies in it, and models that did not are told apart."""

from dataclasses import replace

import numpy as np
import pytest
from experimental_style import WALL
from repository import ROOT

from rockdamp.errors import InputError
from rockdamp.histories.labelled import respond
from rockdamp.laboratory import posterior as identify
from rockdamp.laboratory import problem
from rockdamp.laboratory.candidates import Candidate, Prior
from rockdamp.laboratory.least_squares import RecordFit
from rockdamp.laboratory.posterior import posterior
from rockdamp.laboratory.problem import Problem
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Wall
from rockdamp.motions.records import Record, read_record
from rockdamp.plausibility import as_meant
from rockdamp.vocabulary import ANY_ORDER


@pytest.fixture(scope="module")
def found():
    record = read_record(ROOT / "data/test_series/cr-half.csv")
    return posterior(record, WALL, "CR", compared=("CR", "CDR"), step=0.02, seed=7)


def test_what_made_a_record_lies_in_its_posterior(found):
    made = found.sel(parameter=["yield_displacement_ratio", "strength_ratio", "restitution"])
    assert np.isfinite(made["true_value"]).all()
    score = (made["mean"] - made["true_value"]) / made["standard_deviation"]
    assert np.abs(score).max() < 3
    assert made["standard_deviation"].max() < 2e-3  # and the interval tells something
    low, high = made["interval"].sel(level=0.9).transpose("bound", "parameter").values
    inside = (made["draws"] >= low) & (made["draws"] <= high)
    np.testing.assert_allclose(inside.mean("draw"), 0.9, atol=0.04)
    assert float(found["effective_draws"]) >= identify.EFFECTIVE


def test_the_sensor_is_found_with_the_wall_and_the_band_holds_the_record(found):
    assert float(found["sensor_deviation"].mean()) == pytest.approx(1.5e-4, rel=0.15)
    assert float(found["sensor_zero"]) == pytest.approx(1.3e-3, abs=1e-4)
    assert float(found["share_inside"]) == pytest.approx(0.9, abs=0.05)


def test_the_model_that_made_the_record_has_the_evidence(found):
    assert float(found["probability"].sel(damping_model="CDR")) < 1e-6
    assert float(found["probability"].sel(damping_model="CR")) == pytest.approx(1)
    # An evidence asks for fewer draws than the posterior, whose draws give that of the first model.
    first, other = found["log_evidence_error"].sel(damping_model=["CR", "CDR"]).values
    assert first <= identify.EFFECTIVE**-0.5 < 0.9 * other < other <= identify.OF_EVIDENCE**-0.5


def test_quantiles_of_weighted_values_are_those_of_the_values_repeated():
    random = np.random.RandomState(0)
    values, times = random.standard_normal(500), random.randint(1, 9, 500)
    levels = np.array([[0.05, 0.95], [0.25, 0.75]])
    weighted = identify._quantiles(values, times / times.sum(), levels)
    np.testing.assert_allclose(weighted, np.quantile(np.repeat(values, times), levels), atol=0.02)


def problem_of(name, model, step=0.03):
    record = read_record(ROOT / f"data/test_series/{name}.csv")
    fit = RecordFit.from_record(
        record, WALL, Candidate.from_name(model), ultimate_displacement_ratio=1.0, softening="steeper", step=step
    )
    return Problem.from_fit(fit, Prior())


def test_where_the_order_is_free_the_record_tells_that_it_is_no_small_one(monkeypatch):
    monkeypatch.setattr(problem, "LINEAR", 1.0)  # the step here is coarse
    made = problem_of("ecd16-half", ANY_ORDER)
    about, draws = made.drawn(300, 1)
    order = draws.weights @ made.values(draws.points)[:, made.names.index("order")]
    assert about is made and 4 < order < 20


@pytest.mark.parametrize("number", range(10))
def test_a_clean_record_is_answered(number):
    """Before a Ricker pulse without noise a wall passes zero at 1e-140 u_ins, by the spline through the record."""
    a1, b1, e = 0.03 + 0.005 * number, 0.65 + 0.02 * number, 0.92 - 0.008 * number
    thickness = 0.15 + 0.025 * number
    with as_meant():
        wall, curve = Wall(thickness, thickness * (10 + 0.8 * number), hinge_ratio=0.6), TrilinearCurve(a1, b1)
    elapsed = np.arange(601) / 100
    squared = (np.pi * (4.0 - 0.2 * number) * (elapsed - 3)) ** 2
    strength = 1.75 if number < 3 else 2.0  # of the pulse's peak over the acceleration at which rocking starts
    pulse = strength * float(wall.rocking_onset(b1)) * (1 - 2 * squared) * np.exp(-squared)
    shaken = respond(wall, curve, Damping.cr(e), Record(elapsed, pulse))
    assert 0.14 < float(shaken["peak"]) < 0.2
    noise = 5e-5 * np.random.RandomState(number).standard_normal(elapsed.size)
    record = Record(elapsed, pulse, shaken["control_displacement"].values + noise)
    settings = {"ultimate_displacement_ratio": 1.0, "softening": "steeper", "step": 0.01}
    made = Problem.from_fit(RecordFit.from_record(record, wall, Candidate.from_name("CR"), **settings), Prior())
    found = made.values(made.mode[None])[0]
    np.testing.assert_allclose(found[:3], [a1, b1, e], rtol=5e-3)
    if number == 0:
        draws = made.drawn(300, 1)[1]
        mean = draws.weights @ made.values(draws.points)
        np.testing.assert_allclose(mean[:3], [a1, b1, e], rtol=5e-3)


def test_a_response_too_sensitive_to_be_linearised_is_refused_with_that_reason(monkeypatch):
    def steep(self, parameters, directions):
        return np.zeros(directions.shape), np.full((3, self.measured.size), 2e6 * self.u_ins)

    monkeypatch.setattr(RecordFit, "tangent", steep)
    with pytest.raises(InputError, match="a change of a parameter by 1e-06 moves the wall by 2 u_ins"):
        problem_of("cr-half", "CR")


def test_draws_that_show_a_higher_mode_start_again_about_it():
    made = problem_of("cr-half", "CR")
    lower = made._neighbourhood().lower
    missed = replace(made, mode=made.mode + 4 * lower[:, 0])
    about, draws = missed.drawn(300, 1)
    assert np.all(np.abs(about.mode - made.mode)[:3] < np.diag(lower)[:3])
    assert draws.log_evidence == pytest.approx(made.drawn(300, 1)[1].log_evidence, abs=0.3)
