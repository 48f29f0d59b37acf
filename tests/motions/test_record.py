"""Records: uniform times, checked arrays, and copies of what they are given."""

import numpy as np
import pytest

from rockdamp.errors import InputError
from rockdamp.motions.record import Record, append_rest

ELAPSED = [0.0, 0.01, 0.02]
SAMPLE_NUMBERS = np.arange(2000)


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"elapsed": [0, 0.01, 0.0312]}, "elapsed"),
        ({"elapsed": [0]}, "elapsed"),
        ({"ground_acceleration": [0, 1]}, "ground_acceleration"),
        ({"ground_acceleration": [0, np.nan, 0]}, "ground_acceleration"),
        ({"displacement": [[0, 1, 0]]}, "displacement"),
        ({"header": {"synthetic": "no doubt"}}, "synthetic"),
    ],
)
def test_wrong_field_is_refused_by_name(changes, name):
    fields = {"elapsed": ELAPSED, "ground_acceleration": [0, 1, 0]} | changes
    with pytest.raises(InputError, match=name):
        Record(**fields)


def test_falling_times_are_refused_with_a_positive_step():
    with pytest.raises(InputError, match="must rise by equal steps, here 0.01"):
        Record(ELAPSED[::-1], [0, 1, 0])


def test_time_may_be_a_hundredth_of_a_step_off():
    assert Record([0, 0.10099, 0.2], [0, 1, 0]).step == pytest.approx(0.1)
    with pytest.raises(InputError, match="elapsed"):
        Record([0, 0.10105, 0.2], [0, 1, 0])


@pytest.mark.parametrize("step", [0.0001, 1 / 256, 0.1])
def test_step_of_a_logger_is_taken(step):
    record = Record(step * SAMPLE_NUMBERS, np.ones(2000))
    assert record.step == pytest.approx(step, rel=1e-12)


@pytest.mark.parametrize("step", [0.00005, 0.2, 1.0, 10.0])
def test_step_of_no_logger_is_refused(step):
    """An index, milliseconds or minutes in place of seconds."""
    with pytest.raises(InputError, match="step is .* from 0.0001 to 0.1 s"):
        Record(step * SAMPLE_NUMBERS, np.ones(2000))


def test_records_of_the_same_samples_and_header_are_equal():
    record = Record(ELAPSED, [0, 1, 0])
    assert record == Record(ELAPSED, [0, 1, 0])
    assert record != Record(ELAPSED, [0, 2, 0])
    assert record != Record(ELAPSED, [0, 1, 0], header={"specimen": "wall"})
    assert record != "record"


@pytest.mark.parametrize(("tail", "zeros"), [(0, 0), (0.02, 2), (0.021, 3)])
def test_rest_is_at_least_the_tail(tail, zeros):
    assert append_rest(np.array([1.0, -2.0]), 0.01, tail).tolist() == [1, -2] + [0] * zeros


def test_negative_tail_is_refused():
    with pytest.raises(InputError, match="tail"):
        append_rest(np.ones(2), 0.01, -1)
