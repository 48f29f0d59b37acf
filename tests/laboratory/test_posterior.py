"""The posterior: what made a record lies in it, and models that did not are told apart."""

from dataclasses import replace

import numpy as np
import pytest
from experimental_style import WALL
from repository import ROOT

from rockdamp.errors import InputError
from rockdamp.laboratory import posterior as identify
from rockdamp.laboratory import problem
from rockdamp.laboratory.candidates import Candidate, Prior
from rockdamp.laboratory.least_squares import RecordFit
from rockdamp.laboratory.noise import Noise
from rockdamp.laboratory.posterior import posterior
from rockdamp.laboratory.problem import Problem
from rockdamp.motions.records import read_record
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


def test_quantiles_of_weighted_values_are_those_of_the_values_repeated():
    random = np.random.RandomState(0)
    values, times = random.standard_normal(500), random.randint(1, 9, 500)
    levels = np.array([[0.05, 0.95], [0.25, 0.75]])
    weighted = identify._quantiles(values, times / times.sum(), levels)
    np.testing.assert_allclose(weighted, np.quantile(np.repeat(values, times), levels), atol=0.02)


def problem_of(name, model, step=0.03):
    record = read_record(ROOT / f"data/test_series/{name}.csv")
    fit = RecordFit.of(
        record, WALL, Candidate.of(model), ultimate_displacement_ratio=1.0, softening="steeper", step=step
    )
    return Problem.of(fit, Prior())


def test_where_the_order_is_free_the_record_tells_that_it_is_no_small_one(monkeypatch):
    monkeypatch.setattr(problem, "LINEAR", 1.0)  # the step here is coarse
    made = problem_of("ecd16-half", ANY_ORDER)
    about, draws = made.drawn(300, 1)
    order = draws.weights @ made.values(draws.points)[:, made.names.index("order")]
    assert about is made and 4 < order < 20


def test_a_singular_matrix_near_to_collapse_is_refused_in_words(monkeypatch):
    def singular(*_):
        raise np.linalg.LinAlgError("Singular matrix")

    made = problem_of("cr-half", "CR")
    monkeypatch.setattr(Noise, "_conditional", singular)
    with pytest.raises(InputError, match="too near to collapse where the record is explained best"):
        made.drawn(300, 1)
    with pytest.raises(InputError, match="too near to collapse where the record is explained best"):
        problem_of("cr-half", "CR")


def test_draws_that_show_a_higher_mode_start_again_about_it():
    made = problem_of("cr-half", "CR")
    lower = made._neighbourhood().lower
    missed = replace(made, mode=made.mode + 4 * lower[:, 0])
    about, draws = missed.drawn(300, 1)
    assert np.all(np.abs(about.mode - made.mode)[:3] < np.diag(lower)[:3])
    assert draws.log_evidence == pytest.approx(made.drawn(300, 1)[1].log_evidence, abs=0.3)
