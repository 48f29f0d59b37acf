"""The damping models that a record is explained with."""

import numpy as np
import pytest

from rockdamp.laboratory.candidates import GRID, RANGE, Candidate
from rockdamp.mechanics.damping import Damping
from rockdamp.vocabulary import ANY_ORDER, CANDIDATES


@pytest.mark.parametrize("name", CANDIDATES)
def test_every_candidate_has_a_damper_a_range_and_a_grid_inside_it(name):
    candidate = Candidate.from_name(name)
    for parameter in candidate.searched:
        low, high = RANGE[parameter]
        assert low <= GRID[parameter].min() and GRID[parameter].max() <= high
    loss = GRID[candidate.loss][:3]
    assert candidate.damping(loss).shape == (3,)


def test_a_model_that_e_describes_exactly_has_e_and_the_others_have_xi():
    assert [Candidate.from_name(name).loss for name in ("CR", "ECD", "ECD16", ANY_ORDER)] == ["restitution"] * 4
    assert [Candidate.from_name(name).loss for name in ("CDC", "CDR", "SDR")] == ["damping_ratio"] * 3


def test_the_order_is_a_parameter_of_one_candidate_and_reaches_its_damper():
    assert [name for name in CANDIDATES if "order" in Candidate.from_name(name).parameters] == [ANY_ORDER]
    orders = np.array([1.5, 8.0])
    assert Candidate.from_name(ANY_ORDER).damping(np.full(2, 0.85), orders) == Damping.of_restitution(
        0.85, order=orders
    )
