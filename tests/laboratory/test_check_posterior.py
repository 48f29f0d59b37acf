"""The program that sees whether the walkers' posterior is right about itself, without the hours that it takes."""

import numpy as np
import pytest
from check_posterior import report
from random_tests import LEAST, LEAST_OF_BRANCH, MOST, drawn

from rockdamp.laboratory.simulated import Judged, gathered

NAMES = ("yield_displacement_ratio", "strength_ratio", "restitution", "sensor_deviation", "sensor_correlation")
NOTHING = np.full(5, np.nan)


@pytest.mark.parametrize(("narrower", "holds"), [(1.0, True), (3.0, False)])
def test_intervals_that_hold_the_truth_too_seldom_are_told(capsys, narrower, holds):
    random = np.random.RandomState(1)
    centred = random.uniform(-1, 1, (300, 5)) * narrower  # the truth's place in posteriors that are too narrow
    ranks = np.clip(0.5 + 0.5 * centred, 0, 1)
    records = [Judged(NOTHING, rank, NOTHING, NOTHING, random.uniform(0, 1, 3)) for rank in ranks]
    records.append(Judged(NOTHING, NOTHING, NOTHING, NOTHING, NOTHING[:3]))
    assert report(gathered(NAMES, records)) is holds
    printed = capsys.readouterr().out
    assert "300 of 301 records identified" in printed and "90% interval of sensor_correlation" in printed


def test_a_random_test_is_the_same_each_time_and_one_that_a_laboratory_would_keep():
    made, again = drawn(3, 5), drawn(3, 5)
    assert made.record == again.record and made.truth == again.truth
    assert max(LEAST, LEAST_OF_BRANCH * made.truth[0]) < made.peak < MOST
    shown = made.record.displacement / float(made.wall.instability_displacement)
    assert np.ptp(shown) > made.peak / 2
