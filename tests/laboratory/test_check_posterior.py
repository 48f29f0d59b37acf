"""The programs that see whether the posterior is right about itself, without the hours that they take."""

import check_posterior
import numpy as np
import pandas as pd
import pytest
from posterior_records import PRIOR, WALL, made, names_of, row_of, summary
from random_tests import LEAST, LEAST_OF_BRANCH, MOST, NAMES, drawn
from scipy.special import ndtr

from rockdamp.laboratory.candidates import Candidate
from rockdamp.plausibility import as_meant

PARAMETERS = names_of(Candidate.from_name("CR"))


def rows_of(z, refused=0):
    """Rows of normal posteriors of mean 0 and deviation 1, with the truth at z, shape (records, parameters)."""
    rows = [
        row_of(number, name, at, 0.0, 1.0, ndtr(at), ndtr(at) if index < 3 else np.nan)
        for number, record in enumerate(z)
        for index, (name, at) in enumerate(zip(PARAMETERS, record, strict=True))
    ]
    rows += [row_of(-1 - k, name, 0.0, *[np.nan] * 4) for k in range(refused) for name in PARAMETERS]
    return pd.DataFrame(rows)


CASES = [(1.0, 0.0, True), (1.25, 0.0, False), (0.85, 0.0, False), (1.0, 0.3, False)]


@pytest.mark.parametrize(("wider", "shift", "holds"), CASES)
def test_posteriors_that_are_too_narrow_too_wide_or_shifted_are_told(capsys, wider, shift, holds):
    z = shift + wider * np.random.RandomState(1).standard_normal((300, 5))
    assert check_posterior.report(rows_of(z, refused=1)) is holds
    printed = capsys.readouterr().out
    assert "300 of 301 records identified" in printed and "sensor_correlation: intervals hold" in printed


def test_an_interval_of_ninety_percent_holds_nine_of_ten_evenly_placed_truths_and_refused_records_do_not_count():
    """Ranks 0.005, 0.015 ... 0.995: an interval of 90 % holds those from 0.05 to 0.95, 90 of 100."""
    ranks = (np.arange(100) + 0.5) / 100
    rows = [row_of(number, "restitution", 0.0, 0.0, 1.0, rank, rank) for number, rank in enumerate(ranks)]
    rows.append(row_of(100, "restitution", *[np.nan] * 5))
    found = summary(pd.DataFrame(rows)).loc["restitution"]
    assert found[["records", "identified"]].tolist() == [101, 100]
    assert found["held_0.5"] == found["held_0.5_by_least_squares"] == pytest.approx(0.5)
    assert found["held_0.9"] == found["held_0.9_by_least_squares"] == pytest.approx(0.9)
    assert found["p"] > 0.99


def test_a_record_is_made_of_parameters_that_rock_and_stand():
    record, values = made(Candidate.from_name("CR"), np.random.RandomState([7, 0]))
    again, same = made(Candidate.from_name("CR"), np.random.RandomState([7, 0]))
    assert record == again and np.array_equal(values, same)
    inside = PRIOR.points(PARAMETERS, values[None])[0]
    assert np.all((0 < inside) & (inside < 1))
    u_ins = float(WALL.instability_displacement)
    assert values[0] * u_ins < np.ptp(record.displacement) < 2 * u_ins


def test_random_tests_are_judged_by_the_deviation_of_z():
    """Truths one deviation above and below the mean: z has the deviation 1, and every interval of 90 % holds them."""
    keys = ("true", "mean", "deviation", "rank")
    tests = [
        {f"{key}_{name}": value for name in NAMES for key, value in zip(keys, of, strict=True)}
        for of in ((0.5, 0.4, 0.1, 0.84), (0.3, 0.4, 0.1, 0.16))
    ]
    found = check_posterior.summary(pd.DataFrame([{"ended": "answered", "seconds": 1.0, **test} for test in tests]))
    assert [found[f"deviation_of_z_{name}"] for name in NAMES] == pytest.approx([1.0] * 3)
    assert [found[f"held_{name}"] for name in NAMES] == [1.0] * 3


@as_meant()
def test_a_random_test_is_the_same_each_time_and_one_that_a_laboratory_would_keep():
    made, again = drawn(3, 5), drawn(3, 5)
    assert made.record == again.record and made.truth == again.truth
    assert max(LEAST, LEAST_OF_BRANCH * made.truth[0]) < made.peak < MOST
    shown = made.record.displacement / float(made.wall.instability_displacement)
    assert np.ptp(shown) > made.peak / 2
