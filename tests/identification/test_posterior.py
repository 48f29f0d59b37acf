"""The posterior: what made a record lies in it, models that did not are told apart, and bad draws are refused."""

from concurrent.futures import ThreadPoolExecutor
from threading import BrokenBarrierError

import numpy as np
import pytest
from repository import ROOT

from rockdamp.errors import InputError
from rockdamp.identification import importance, problem
from rockdamp.identification import posterior as sampling
from rockdamp.identification.candidates import Candidate
from rockdamp.identification.identify import posterior, require_good
from rockdamp.identification.least_squares import Fit
from rockdamp.identification.posterior import Draws, Sampler, diagnosed
from rockdamp.identification.prior import Prior
from rockdamp.identification.problem import Problem
from rockdamp.motions.experimental_style import WALL
from rockdamp.motions.records import read_record
from rockdamp.vocabulary import ANY_ORDER

SHORT = Sampler(ensembles=4, walkers=32, burn_in=100, steps=100, rounds=3, effective=200, seed=7)


@pytest.fixture(scope="module")
def found():
    record = read_record(ROOT / "data/ladder/cr-half.csv")
    return posterior(record, WALL, "CR", compared=("CR", "CDR"), step=0.02, sampler=SHORT)


def test_what_made_a_record_lies_in_its_posterior(found):
    made = found.sel(parameter=["cracked_stiffness_ratio", "plateau_ratio", "restitution"])
    assert np.isfinite(made["true_value"]).all()
    score = (made["mean"] - made["true_value"]) / made["standard_deviation"]
    assert np.abs(score).max() < 3
    assert made["standard_deviation"].max() < 2e-3  # and the interval tells something
    low, high = made["interval"].sel(level=0.9).transpose("bound", "parameter").values
    inside = (made["draws"] >= low) & (made["draws"] <= high)
    np.testing.assert_allclose(inside.mean("draw"), 0.9, atol=0.04)


def test_the_sensor_is_found_with_the_wall_and_the_band_holds_the_record(found):
    assert float(found["sensor_deviation"].mean()) == pytest.approx(1.5e-4, rel=0.15)
    assert float(found["sensor_zero"]) == pytest.approx(1.3e-3, abs=1e-4)
    assert float(found["share_inside"]) == pytest.approx(0.9, abs=0.05)


def test_the_model_that_made_the_record_has_the_evidence(found):
    assert float(found["probability"].sel(damping_model="CDR")) < 1e-6
    assert float(found["probability"].sel(damping_model="CR")) == pytest.approx(1)


def test_r_hat_and_effective_size_suffice_where_a_posterior_is_returned(found):
    assert float(found["r_hat"].max()) <= 1.01 and float(found["effective_draws"].min()) >= 200


def test_walkers_that_do_not_agree_are_refused():
    random = np.random.RandomState(0)
    same = random.standard_normal((4, 50, 16, 2))
    assert diagnosed(same, 400).good
    apart = same + np.array([0.0, 0.0, 0.0, 1.0])[:, None, None, None] * [1.0, 0.0]
    bad = diagnosed(apart, 400)
    assert not bad.good and bad.r_hat[1] < 1.01
    with pytest.raises(InputError, match="r-hat of first is 1.*; it must be at most 1.01"):
        require_good(bad, ("first", "second"))
    stuck = np.repeat(same[:, ::25], 25, axis=1)
    with pytest.raises(InputError, match="effective sample size of .* is .*; it must be at least 4000"):
        require_good(Draws(stuck, np.ones(2), diagnosed(stuck, 400).effective, 4000), ("first", "second"))


def test_the_packages_that_a_posterior_needs_are_named_where_they_are_missing():
    with pytest.raises(InputError, match=r"needs the packages emcee and arviz-stats; pip install emcee arviz-stats"):
        importance.needed("emcee_that_is_not_there")


def test_ensembles_in_step_get_the_densities_they_ask_for():
    from concurrent.futures import ThreadPoolExecutor

    batches = []

    def density(points):
        batches.append(len(points))
        return points[:, 0]

    in_step = sampling._InStep(density, 3)
    with ThreadPoolExecutor(3) as pool:
        asked = [np.full((2 + number, 1), float(number)) for number in range(3)]
        answers = list(pool.map(lambda number: in_step.of(number)(asked[number]), range(3)))
    assert batches == [9]
    for number, answer in enumerate(answers):
        np.testing.assert_array_equal(answer, np.full(2 + number, float(number)))


def test_an_ensemble_that_fails_lets_the_others_end():
    """They wait for each other at every step: without its word they would for ever."""
    in_step = sampling._InStep(lambda coordinates: coordinates[:, 0], 2)
    with ThreadPoolExecutor(1) as pool:
        waiting = pool.submit(in_step.of(0), np.zeros((3, 1)))
        in_step.give_up()
        with pytest.raises(BrokenBarrierError):
            waiting.result(timeout=20)


def test_where_the_order_is_free_the_modes_follow_it(monkeypatch):
    monkeypatch.setattr(problem, "ORDERS", 3)
    record = read_record(ROOT / "data/ladder/ecd16-half.csv")
    fit = Fit.of(record, WALL, Candidate.of(ANY_ORDER), ultimate_ratio=1.0, softening="steeper", step=0.03)
    made = Problem.of(fit, Prior())
    orders = [made.values(mode.centre[None])[0, made.names.index("order")] for mode in made.modes]
    assert orders == pytest.approx([14.25], rel=1e-3)  # of 0.56, 2.8 and 14.3 that nearest to what made it
    assert made.modes[0].lower.shape == (6, 6)
