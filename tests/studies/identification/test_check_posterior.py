"""The program that sees whether the posterior is right about itself, without the hours that it takes."""

import check_posterior
import numpy as np
import pytest
from check_posterior import Judged, held_by_ranks, report, trial

from rockdamp.studies.candidates import Candidate

NAMES = ("a1", "b1", "e", "sigma", "phi")


def test_a_record_is_made_of_parameters_that_rock_and_stand():
    record, values = trial(Candidate.of("CR"), np.random.RandomState([7, 0]))
    again, same = trial(Candidate.of("CR"), np.random.RandomState([7, 0]))
    assert record == again and np.array_equal(values, same)
    low, high = check_posterior.PRIOR.bounds(("cracked_stiffness_ratio", "plateau_ratio", "restitution"))
    assert np.exp(low[0]) < values[0] < np.exp(high[0]) and np.all((low[1:] < values[1:3]) & (values[1:3] < high[1:]))
    u_ins = float(check_posterior.WALL.instability_displacement)
    assert values[0] * u_ins < np.ptp(record.displacement) < 2 * u_ins


def test_of_uniform_ranks_as_many_are_held_as_the_level_says():
    ranks = np.arange(check_posterior.RANKED + 1.0)
    assert [float(np.mean(held_by_ranks(ranks, level))) for level in (0.5, 0.9)] == [0.5, 0.9]


@pytest.mark.parametrize(("narrower", "holds"), [(1.0, True), (3.0, False)])
def test_intervals_that_hold_the_truth_too_seldom_are_told(capsys, narrower, holds):
    random = np.random.RandomState(1)
    centred = random.uniform(-1, 1, (300, 5)) * narrower  # the truth's place in posteriors that are too narrow
    ranks = np.clip(np.floor(50 + 50 * centred), 0, 99)
    scores = random.standard_normal((300, 3))
    records = [Judged(*row) for row in zip(ranks, scores, strict=True)]
    records.append(Judged(np.full(5, np.nan), np.full(3, np.nan)))
    assert report(NAMES, records) is holds
    printed = capsys.readouterr().out
    assert "300 of 301 records identified" in printed and "90% interval of phi" in printed
